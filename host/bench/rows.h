/* bench/rows.h: configurations timed in turn with one that they are compared with, on each backend. */
#ifndef HOST_BENCH_ROWS_H
#define HOST_BENCH_ROWS_H

#include "base/statistics.h"
#include "stage/stage.h"

enum { bench_most_rows = 40 };

typedef struct bench_row {
  const char *name;
  csm_config config;
  double most_floors; /* at most so many times the floor; 0: nothing is asked */
  double most_bases;  /* at most so many times the base; likewise */
  bool depth; /* maps are drawn for what this frame's depth shows; reducing it counts, and drawing it does not */
} bench_row;

typedef enum bench_timed {
  BENCH_MASK,    /* the mask's passes alone, with its rays and its history if it has them */
  BENCH_MAPS,    /* the maps' passes */
  BENCH_PLANNED, /* the same, and planning them */
  BENCH_FRAME,   /* the maps, what is made of them, and the mask */
  BENCH_MOMENTS, /* what makes moments, but of the base, whose maps' passes are; the light turns with each frame */
} bench_timed;

/* What is to be timed. */
typedef struct bench_table {
  const char *name, *about;
  bench_timed timed;
  bench_row base;
  bench_row rows[bench_most_rows];
  uint32_t count;
} bench_table;

/* What single taps and the default cost, against the least that a mask may take. */
void bench_table_floors(bench_table *out, const csm_config *config);
/* Every filter, against one tap. */
void bench_table_filters(bench_table *out, const csm_config *config);
/* Selecting, blending, looking at what the camera sees, keeping a history, against the configuration without. */
void bench_table_modes(bench_table *out, const csm_config *config);
/* Every way to lay out, fit and draw maps, against the configuration without. */
void bench_table_maps(bench_table *out, const csm_config *config);
/* The maps of what casts on what is seen, against those of all that casts; what they may take is known for some scenes. */
void bench_table_casters(bench_table *out, const csm_config *config, const char *scene);
/* Making and blurring moments, against the maps' passes of the configuration. */
void bench_table_moments(bench_table *out, const csm_config *config);
/* What preset `exact` says, over a configuration. */
void bench_exact(csm_config *config);
/* How many times pcf_3x3's mask may the exact one take with an engine's normals; 0: that is not known of the scene. */
double bench_most_with_normals(const char *scene);
/* The mask with rays, and the maps with it, against those of pcf_3x3; what they may take is known for some scenes. */
void bench_table_ray_masks(bench_table *out, const csm_config *config, const char *scene);
void bench_table_ray_frames(bench_table *out, const csm_config *config, const char *scene);
/* Makes a configuration that of bench_table_moments' rows: a filter's moments of four maps of 1024 texels a side, blurred. */
void bench_moments_config(csm_config *config, uint32_t filter, uint32_t radius);

/*
 * The least that such a pass may take. It is drawn once, and gives its milliseconds on the GPU, or a negative number.
 */
typedef struct bench_floor {
  double (*draw)(void *user); /* NULL: there is none */
  void *user;
} bench_floor;

typedef struct bench_result {
  const char *row, *backend;
  estimate ms, to_base, to_floor;
  estimate to_first; /* the first stage's of the same row */
  double most_floors, most_bases;
} bench_result;

typedef struct bench_rows {
  bench_table table;
  uint32_t pairs;
  bool has_floor;
  bench_result results[(bench_most_rows + 10) * HOST_BACKENDS]; /* the base's of each group of rows first */
  uint32_t count;
} bench_rows;

/*
 * Times a table's rows on each stage, in groups. Every round of a group draws the floor, the base and each row once, in
 * turn. A ratio is of two times from one round. 0, or a code after a message.
 */
int bench_rows_run(bench_rows *out, const bench_table *table, stage *stages, uint32_t stage_count, bench_floor floor,
                   uint32_t pairs);
/* One figure with the interval that it lies in. */
void bench_print_line(FILE *to, const char *name, const estimate *value);
void bench_rows_print(FILE *to, const bench_rows *rows);
json_t *bench_rows_to_json(const bench_rows *rows);

#endif
