/*
 * exact_moving.c: trees that are kept and refitted while instances move, hide and come, and meshes change: what is drawn
 * then is what a new context draws of the same scene, in every bit.
 */
#include "base/host.h"
#include "hard/exact.h"
#include <math.h>
#include <stdlib.h>
#include <string.h>

enum { SIDE = 100, INSTANCES = SIDE * SIDE, BALLS = 8 };

/* A hundred times a hundred boxes over a ground, and a few balls, which come last. */
static void make_crowd(host_setup *out) {
  mesh_builder b = {0};
  const double size = 0.2;
  hard_setup_begin(out, 192, 108);
  hard_ground(&b, (const double[3]){0.0, 0.0, -40.0}, 64.0, 2);
  hard_add(out, &b, "ground", NULL);
  builder_box(&b, (const double[3]){-size, -size, -size}, (const double[3]){size, size, size});
  hard_add(out, &b, "box", (const double[3]){-40.0, 1.0, 5.0});
  const scene_instance first = out->scene.instances[1];
  for (uint32_t i = 1; i < INSTANCES; i++) {
    double transform[16];
    memcpy(transform, first.transform, sizeof transform);
    transform[12] += 0.8 * (i % SIDE);
    transform[13] += 2.0 * noise_hash(i, 0, 3);
    transform[14] -= 0.8 * (i / SIDE);
    scene_add_instance(&out->scene, first.mesh, transform);
  }
  for (uint32_t i = 0; i < BALLS; i++) {
    builder_ball(&b, (const double[3]){0.0, 0.0, 0.0}, (const double[3]){1.0, 1.0, 1.0}, 3, 0.2, i);
    hard_add(out, &b, "skin", (const double[3]){-7.0 + 2.0 * i, 4.0, -8.0});
  }
  hard_look(out, (const double[3]){0.0, 6.0, 10.0}, (const double[3]){0.0, 0.5, -8.0}, 60.0);
  hard_reach(out, 60.0);
  out->config.resolution = 512;
  out->config.depth_mode = CSM_DEPTH_SLICE; /* ranges that do not follow casters */
}

/* ---- what happens to the scene: in the host, and in what is loaded ---- */

/* From one instance on, every so-manieth. */
typedef struct choice {
  uint32_t first, step, count;
} choice;

static int move(hard_run *run, host_setup *setup, const choice *which, double far) {
  csm_instance_id *ids = host_allocate(which->count, sizeof *ids);
  double *matrices = host_allocate(which->count, 16 * sizeof *matrices);
  csm_result result = CSM_SUCCESS;
  for (uint32_t i = 0; i < which->count; i++) {
    double *transform = setup->scene.instances[which->first + i * which->step].transform;
    for (uint32_t axis = 0; axis < 3; axis++)
      transform[12 + axis] += far * (axis == 1 ? noise_hash(i, axis, 5) : 2.0 * noise_hash(i, axis, 5) - 1.0);
    memcpy(matrices + 16 * (size_t)i, transform, 16 * sizeof *matrices);
  }
  for (uint32_t s = 0; !result && s < run->stage_count; s++) {
    for (uint32_t i = 0; i < which->count; i++)
      ids[i] = run->stages[s].instances[which->first + i * which->step];
    const csm_scene_batch batch = {
        .struct_size = sizeof batch, .count = which->count, .ids = ids, .matrices = matrices};
    result = csm_scene_move(run->stages[s].scene, &batch);
  }
  free(matrices);
  free(ids);
  return hard_called(result, "moving");
}

static int move_some(hard_run *run, host_setup *setup) {
  return move(run, setup, &(choice){1, SIDE + 1, 100}, 1.0);
}

/* Far enough that the tree does not pay any more, and is built anew. */
static int move_all(hard_run *run, host_setup *setup) {
  return move(run, setup, &(choice){1, 1, INSTANCES}, 20.0);
}

static int change_meshes(hard_run *run, host_setup *setup) {
  csm_result result = CSM_SUCCESS;
  for (uint32_t i = 0; !result && i < BALLS; i++) {
    const uint32_t index = setup->scene.instances[1 + INSTANCES + i].mesh;
    scene_mesh *mesh = &setup->scene.meshes[index];
    for (uint32_t v = 0; v < mesh->vertex_count; v++) {
      float *p = mesh->positions + 3 * (size_t)v;
      p[0] *= 1.0f + 0.5f * p[1];
      p[1] -= 0.3f * p[0] * p[2];
    }
    const csm_mesh_update_info info = {.struct_size = sizeof info, .positions = mesh->positions};
    for (uint32_t s = 0; !result && s < run->stage_count; s++)
      result = csm_mesh_update(run->stages[s].context, run->stages[s].assets.meshes[index], &info);
  }
  return hard_called(result, "changing meshes");
}

typedef struct change {
  const char *what;
  int (*apply)(hard_run *run, host_setup *setup);
} change;

static const change changes[] = {{"100 of 10000 moved", move_some},
                                 {"all moved", move_all},
                                 {"meshes changed", change_meshes},
                                 {"100 moved again", move_some}};

/* ---- the same picture ---- */

static int draw(hard_run *run, hard_picture out[EXACT_WAYS]) {
  int code = 0;
  for (int way = 0; code == 0 && way < EXACT_WAYS; way++) {
    csm_config config = run->setup->config;
    exact_set(&config, way);
    code = hard_configure(run, &config);
    if (code == 0)
      code = hard_draw(run, &run->setup->camera, &run->setup->light, 0, &out[way]);
  }
  return code;
}

/* New contexts, with the scene as it is now. */
static int open_anew(hard_run *run, const host_setup *setup) {
  hard_unload(run);
  for (uint32_t i = 0; i < run->stage_count; i++)
    stage_close(&run->stages[i]);
  run->stage_count = 0;
  return hard_load(run, setup);
}

static void compare(hard_run *run, const char *what, const hard_picture *expected, const hard_picture *drawn,
                    const hard_picture *before) {
  for (int way = 0; way < EXACT_WAYS; way++) {
    hard_figure_add(run, (double)hard_compare(run, &expected[way], &drawn[way], 0.0).pixels, 0.0, "px",
                    "other than a new context's, %s: %s", exact_ways[way], what);
    uint64_t changed = 0;
    for (size_t i = 0; i < (size_t)drawn->width * drawn->height; i++)
      changed += before[way].mask[i] != drawn[way].mask[i];
    hard_figure_add(run, changed ? 0.0 : 1.0, 0.0, "1", "changes that do not show");
  }
}

static int draw_changes(hard_run *run, host_setup *setup) {
  hard_picture before[EXACT_WAYS] = {{0}}, drawn[EXACT_WAYS] = {{0}}, expected[EXACT_WAYS] = {{0}};
  int code = hard_load(run, setup);
  for (size_t i = 0; code == 0 && i < sizeof changes / sizeof changes[0]; i++) {
    code = draw(run, before);
    if (code == 0)
      code = changes[i].apply(run, setup);
    if (code == 0)
      code = draw(run, drawn);
    if (code == 0)
      code = open_anew(run, setup);
    if (code == 0)
      code = draw(run, expected);
    if (code == 0)
      compare(run, changes[i].what, expected, drawn, before);
  }
  for (int way = 0; way < EXACT_WAYS; way++) {
    hard_picture_free(&before[way]);
    hard_picture_free(&drawn[way]);
    hard_picture_free(&expected[way]);
  }
  return code;
}

static int run_case(hard_run *run) {
  host_setup setup;
  make_crowd(&setup);
  const int code = draw_changes(run, &setup);
  hard_unload(run);
  setup_free(&setup);
  return code;
}

const hard_case hard_exact_moving = {
    .name = "exact_moving",
    .about = "exact: 100 and all of 10000 instances moved, and meshes changed, against new contexts",
    .run = run_case};
