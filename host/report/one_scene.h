/* report/one_scene.h: one scene of a report: its sweep, what to make of it, and pictures. */
#ifndef HOST_REPORT_SCENE_H
#define HOST_REPORT_SCENE_H

#include "report/judge.h"
#include "report/sweep.h"
#include "report/technique_picture.h"
#include <jansson.h>

#define REPORT_PICTURES 3

/* What a chosen configuration looks like, as data URIs. */
typedef struct report_picture {
  uint32_t point;
  char *drawn, *errors;
} report_picture;

/* What the best setting of a filter makes of a soft sun: a data URI of a report_technique_picture. */
typedef struct report_technique {
  uint32_t point;
  char *picture;
} report_technique;

/* One scene under one sun. */
typedef struct report_scene {
  host_setup setup;
  truth_store store;
  truth_frame truth;
  stage stages[HOST_BACKENDS], references[HOST_BACKENDS];
  uint32_t stage_count;
  report_sweep sweep;
  report_score *scores[HOST_BACKENDS]; /* of every point */
  report_verdict verdicts[HOST_BACKENDS];
  char *truth_picture; /* data URI */
  report_picture pictures[REPORT_PICTURES];
  uint32_t picture_count;
  report_crop crop; /* of a soft sun's pictures, one for each filter */
  report_technique *techniques;
  uint32_t technique_count;
  double begun_ms, seconds; /* when it began, and what it all took */
} report_scene;

/* Loads options->scene, casts its truth, and opens devices. As report_scene_run. */
int report_scene_open(report_scene *out, const host_options *options);
/* Runs the sweep that has been made for it, until deadline_ms at the latest. 0, or a code after a message. */
int report_scene_sweep(report_scene *s, const host_options *options, double deadline_ms);
/*
 * Loads options->scene, casts its truth, sweeps until deadline_ms (host_now_ms) at the latest, and judges. 0, or a code
 * after a message; report_scene_free is allowed in both cases.
 */
int report_scene_run(report_scene *out, const host_options *options, double deadline_ms);
/* Gives devices, geometry and truth back; what was found stays. */
void report_scene_close(report_scene *s);
void report_scene_free(report_scene *s);

/*
 * The measure of error: the root mean square for a soft sun, for a hard one the share of wrong pixels. The measure of
 * time: of a soft sun, whose techniques differ by what the GPU does, that alone; of a hard one the whole frame's.
 */
bool report_scene_is_soft(const report_scene *s);
double report_error(const report_scene *s, const metrics *m);
/*
 * How much of the root mean square at most is the truth's own, for its rays are few: 0 for a hard sun. It adds to what
 * is drawn wrong as squares do.
 */
double report_noise(const report_scene *s);
/* Whether any configuration's masks differ between the backends by more than they may. */
bool report_scene_differs(const report_scene *s);

/* All that was found, but for the pictures. */
json_t *report_scene_to_json(const report_scene *s);
/* The same as the page wants it: short, a row for each configuration, with the pictures. */
json_t *report_scene_to_page(const report_scene *s);
json_t *report_verdict_to_json(const report_verdict *v);

#endif
