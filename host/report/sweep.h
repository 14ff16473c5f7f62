/* report/sweep.h: many configurations of one scene, each drawn on every backend, timed in turn and measured. */
#ifndef HOST_REPORT_SWEEP_H
#define HOST_REPORT_SWEEP_H

#include "base/statistics.h"
#include "measure/truth_frame.h"

#define REPORT_MAX_ROUNDS 31u /* as many as a comparison takes by its definition in docs/accuracy.md */
#define REPORT_QUICK_ROUNDS 5u

/* The last two are sums: what shadows take of the GPU (the four before them), and of a frame (all before them). */
typedef enum report_time {
  REPORT_PLAN_MS,
  REPORT_RECORD_MS,
  REPORT_MAPS_MS,
  REPORT_MOMENTS_MS,
  REPORT_MASK_MS,
  REPORT_HISTORY_MS,
  REPORT_GPU_MS,
  REPORT_SHADOW_MS,
  REPORT_TIMES
} report_time;

/* One configuration, and what each backend made of it. */
typedef struct report_point {
  csm_config config;
  const char
      *name; /* of a preset, or of one of the settings that a soft sun is measured with; NULL: its shape says it */
  bool is_preset;
  uint64_t map_bytes, moment_bytes, view_bytes; /* on the first backend */
  uint64_t differing;                           /* pixels whose masks differ between backends by more than they may */
  metrics metrics[HOST_BACKENDS];
  double samples[HOST_BACKENDS][REPORT_TIMES][REPORT_MAX_ROUNDS]; /* ms */
  double reference_ms[REPORT_MAX_ROUNDS]; /* first of a shape: the base on all backends, drawn before it and after it */
} report_point;

/* Configurations of one shape stand together, so that maps are made anew as seldom as can be. */
typedef struct report_sweep {
  report_point *points;
  uint32_t count, per_shape;
  uint32_t base;   /* index of the configuration that everything else is compared with: the options' own */
  uint32_t rounds; /* that were timed: one drawing of every point on every backend, in turn */
} report_sweep;

/* How many filters there are. */
uint32_t report_filter_count(void);

/*
 * Every combination of the options' cascade counts and resolutions with every filter and bias mode that go together;
 * the rest, and one more shape if it is not among them, is `base`'s.
 */
void report_sweep_make(report_sweep *out, const host_options *options, const csm_config *base);
/*
 * The setup's own configuration, which is the base, and then the options' presets and those that they are held against,
 * each a shape of its own. A preset that leaves the shadow distance open takes the scene's. 0, or HOST_BAD_INPUT after a
 * message.
 */
int report_sweep_make_presets(report_sweep *out, const host_options *options, const host_setup *setup);
/*
 * What a soft sun is measured with: the setup's own configuration, which is the base; the same with every filter, and
 * with the settings that a technique is known by; then the options' presets, or all there are. Each is a shape of its
 * own. 0, or HOST_BAD_INPUT after a message.
 */
int report_sweep_make_soft(report_sweep *out, const host_options *options, const host_setup *setup);
void report_sweep_free(report_sweep *sweep);

/* What draws a scene, and what it is measured against. */
typedef struct report_studio {
  const host_setup *setup;
  const truth_frame *truth;
  stage *stages, *references; /* loaded with the setup; those that draw the points, and those that draw the base */
  uint32_t stage_count;       /* of each */
} report_studio;

/*
 * A machine is now faster, now slower. So the base is drawn beside every shape, and times are brought to the base's
 * median over the whole run: what is compared is each point's ratio to a base drawn at the same time.
 *
 * Draws and measures every point, then again for times: up to `rounds`, as many as end before `deadline_ms`
 * (host_now_ms), but at least one. Points that a device cannot hold are taken out, after a message. 0, or a code after
 * a message.
 */
int report_sweep_run(report_sweep *sweep, const report_studio *studio, uint32_t rounds, double deadline_ms);

/* Draws one point on one backend. 0, or a code after a message; stage_frame_free is allowed in both cases. */
int report_draw(const report_studio *studio, uint32_t backend, const csm_config *config, stage_frame *out);

/* Over the rounds. */
estimate report_time_of(const report_sweep *sweep, uint32_t point, uint32_t backend, report_time time);
/* Of REPORT_SHADOW_MS in the same round: the second backend's divided by the first's. */
estimate report_ratio_of(const report_sweep *sweep, uint32_t point);
/* The same over all points and rounds, a pair each. */
estimate report_ratio_of_all(const report_sweep *sweep);

#endif
