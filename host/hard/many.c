/*
 * many.c: very many instances, spread and all in one place: work and memory grow with their number and no faster. Short:
 * 4095 against 32760, counted. Long: 125000 against 1000000, timed, too.
 */
#include "base/host.h"
#include "hard/hard.h"
#include <math.h>
#include <stdlib.h>
#include <string.h>

enum { WIDTH = 96, HEIGHT = 54 };

/* What the context holds, in bytes, each block behind its size. */
typedef struct heap {
  size_t bytes;
  uint64_t allocations;
} heap;

typedef struct crowd {
  heap heap;
  csm_context *context;
  csm_mesh mesh;
  csm_scene *scene;
  csm_cascades *cascades;
  csm_view *view;
  csm_camera camera;
  csm_light light;
  uint32_t count, frames; /* frames: that are timed */
  float *rows;            /* three of four for each instance */
  csm_instance_id *ids;
  csm_stats stats;
} crowd;

/* What grows with the number of instances. */
typedef struct growth {
  double count;
  double host_bytes, device_bytes, allocations;
  double add_ms, move_ms, moved_frame_ms, still_frame_ms;
  uint64_t plan_hash;
  float mask[WIDTH * HEIGHT];
} growth;

/* ---- memory ---- */

static void *CSM_CALL allocate(void *user, size_t size, size_t alignment) {
  heap *heap = user;
  const size_t told[2] = {alignment > sizeof told ? alignment : sizeof told, size};
  char *block = aligned_alloc(told[0], (size + 2 * told[0] - 1) / told[0] * told[0]);
  if (!block)
    return NULL;
  heap->bytes += size;
  heap->allocations++;
  memcpy(block + told[0] - sizeof told, told, sizeof told);
  return block + told[0];
}

static void CSM_CALL give_back(void *user, void *memory) {
  heap *heap = user;
  size_t told[2];
  if (!memory)
    return;
  memcpy(told, (char *)memory - sizeof told, sizeof told);
  heap->bytes -= told[1];
  free((char *)memory - told[0]);
}

static void CSM_CALL log_message(void *user, int32_t level, const char *message) {
  (void)user;
  if (level <= CSM_LOG_WARNING)
    fprintf(stderr, "csm-host: many: %s\n", message);
}

/* ---- the crowd ---- */

/* Leaves over 200 m square, up to 10 m above the ground; or all of them in one place before the camera. */
static void scatter(crowd *c, bool spread, uint32_t step) {
  for (uint32_t i = 0; i < c->count; i++) {
    float *row = c->rows + 12 * (size_t)i;
    memset(row, 0, 12 * sizeof *row);
    row[0] = row[5] = row[10] = spread ? 1.0f : 8.0f;
    row[3] = spread ? (float)(200.0 * noise_hash(i, 0, 1) - 100.0) : 0.0f;
    row[7] = spread ? (float)(10.0 * noise_hash(i, 1, 1)) : 1.0f;
    row[11] = (spread ? (float)(-200.0 * noise_hash(i, 2, 1)) : -10.0f) + 0.01f * (float)step;
  }
}

/* What they stand on comes first, and is no leaf. */
static csm_result make_assets(crowd *c) {
  static const float leaf[9] = {-0.3f, 0, -0.3f, 0.3f, 0, -0.3f, 0, 0, 0.4f};
  static const float ground[12] = {-200, -1, -300, 200, -1, -300, 200, -1, 100, -200, -1, 100};
  static const uint16_t indices[6] = {0, 2, 1, 0, 3, 2};
  csm_mesh_info info = {.struct_size = sizeof info,
                        .flags = CSM_MESH_TWO_SIDED,
                        .positions = leaf,
                        .vertex_count = 3,
                        .indices = indices,
                        .index_count = 3,
                        .index_size = 2};
  csm_mesh floor;
  csm_instance_id id;
  csm_result result = csm_mesh_create(c->context, &info, &c->mesh);
  info.positions = ground;
  info.vertex_count = 4;
  info.index_count = 6;
  if (!result)
    result = csm_mesh_create(c->context, &info, &floor);
  if (!result)
    result = csm_scene_create(c->context, &c->scene);
  const csm_instance instance = {.struct_size = sizeof instance,
                                 .flags = CSM_INSTANCE_RECEIVE_ONLY,
                                 .mesh = floor,
                                 .transform = {1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1}};
  const csm_scene_batch batch = {.struct_size = sizeof batch, .count = 1, .ids = &id, .instances = &instance};
  return result ? result : csm_scene_add(c->scene, &batch);
}

static csm_result add_instances(crowd *c) {
  csm_instance *instances = host_allocate(c->count, sizeof *instances);
  for (uint32_t i = 0; i < c->count; i++)
    instances[i] = (csm_instance){.struct_size = sizeof *instances, .mesh = c->mesh};
  const csm_scene_batch batch = {
      .struct_size = sizeof batch, .count = c->count, .ids = c->ids, .instances = instances, .rows = c->rows};
  const csm_result result = csm_scene_add(c->scene, &batch);
  free(instances);
  return result;
}

static csm_result move(crowd *c) {
  const csm_scene_batch batch = {.struct_size = sizeof batch, .count = c->count, .ids = c->ids, .rows = c->rows};
  return csm_scene_move(c->scene, &batch);
}

static csm_result open_crowd(crowd *c, const host_options *options, const char *backend) {
  host_setup setup;
  const csm_create_info info = {.struct_size = sizeof info,
                                .version = CSM_VERSION,
                                .backend = backend,
                                .device = options->device,
                                .allocate = allocate,
                                .release = give_back,
                                .log = log_message,
                                .user = &c->heap};
  hard_setup_begin(&setup, WIDTH, HEIGHT);
  hard_look(&setup, (const double[3]){0.0, 30.0, 20.0}, (const double[3]){0.0, 0.0, -60.0}, 60.0);
  hard_reach(&setup, 250.0);
  setup.config.cascade_count = 2;
  setup.config.resolution = 512;
  c->camera = stage_camera(&setup.camera);
  c->light = stage_light(&setup.light);
  csm_result result = csm_create(&info, &c->context);
  if (!result)
    result = make_assets(c);
  if (!result)
    result = csm_cascades_create(c->context, &setup.config, &c->cascades);
  if (!result)
    result = csm_view_create(c->context, &c->view);
  setup_free(&setup);
  return result;
}

/* *ms gets what planning and recording took of a processor; the least of all frames stays. */
static csm_result draw(crowd *c, double *ms) {
  const csm_frame frame = {.struct_size = sizeof frame, .camera = &c->camera, .light = &c->light, .scene = c->scene};
  const double begun_ms = host_cpu_ms();
  csm_result result = csm_render_cascades(c->cascades, &frame);
  *ms = fmin(*ms, host_cpu_ms() - begun_ms);
  c->stats = (csm_stats){.struct_size = sizeof c->stats};
  return result ? result : csm_get_stats(c->cascades, &c->stats);
}

static csm_result read_mask(crowd *c, float *mask) {
  const csm_frame frame = {.struct_size = sizeof frame, .camera = &c->camera, .light = &c->light, .scene = c->scene};
  const csm_mask_info info = {.struct_size = sizeof info, .frame = &frame, .width = WIDTH, .height = HEIGHT};
  const csm_read_info read = {.struct_size = sizeof read,
                              .source = CSM_READ_MASK,
                              .view = c->view,
                              .data = mask,
                              .size = (uint64_t)WIDTH * HEIGHT * sizeof *mask};
  const csm_result result = csm_resolve_mask(c->view, c->cascades, &info);
  return result ? result : csm_read(c->context, &read);
}

/* ---- measuring ---- */

static csm_result add_and_draw(crowd *c, growth *out) {
  const double begun_ms = host_cpu_ms();
  csm_result result = add_instances(c);
  out->add_ms = host_cpu_ms() - begun_ms;
  return result ? result : draw(c, &out->moved_frame_ms);
}

/* The first frames take what they need; the last one takes nothing. */
static csm_result move_and_draw(crowd *c, bool spread, growth *out) {
  csm_result result = CSM_SUCCESS;
  for (uint32_t step = 1; !result && step <= c->frames; step++) {
    if (step == c->frames)
      out->allocations = -(double)c->heap.allocations;
    scatter(c, spread, step % 2);
    const double begun_ms = host_cpu_ms();
    result = move(c);
    out->move_ms = fmin(out->move_ms, host_cpu_ms() - begun_ms);
    if (!result)
      result = draw(c, &out->moved_frame_ms);
  }
  out->allocations += (double)c->heap.allocations;
  for (uint32_t i = 0; !result && i < c->frames; i++)
    result = draw(c, &out->still_frame_ms);
  return result;
}

static csm_result fill_growth(crowd *c, bool spread, growth *out) {
  *out = (growth){.count = c->count, .move_ms = INFINITY, .moved_frame_ms = INFINITY, .still_frame_ms = INFINITY};
  scatter(c, spread, 0);
  csm_result result = add_and_draw(c, out);
  out->moved_frame_ms = INFINITY;
  if (!result)
    result = move_and_draw(c, spread, out);
  if (!result)
    result = read_mask(c, out->mask);
  out->host_bytes = (double)c->heap.bytes;
  out->device_bytes = (double)(c->stats.frame_bytes + c->stats.geometry_bytes);
  out->plan_hash = c->stats.plan_hash;
  return result;
}

/* Every instance is drawn or culled, in each cascade. */
static void count_casters(hard_run *run, const crowd *c) {
  for (uint32_t k = 0; k < c->stats.cascade_count; k++) {
    const csm_cascade_stats *of = &c->stats.cascades[k];
    hard_figure_add(run, fabs((double)of->casters_drawn + of->casters_culled - c->count), 0.0, "1",
                    "instances that are neither drawn nor culled");
  }
}

static int measure(hard_run *run, const char *backend, uint32_t count, bool spread, growth *out) {
  crowd c = {.count = count, .frames = run->sweep ? 5 : 3};
  c.rows = host_allocate(count, 12 * sizeof *c.rows);
  c.ids = host_allocate(count, sizeof *c.ids);
  csm_result result = open_crowd(&c, run->options, backend);
  if (!result)
    result = fill_growth(&c, spread, out);
  if (!result)
    count_casters(run, &c);
  csm_destroy(c.context);
  free(c.rows);
  free(c.ids);
  return result ? host_fail(HOST_NO_DEVICE, "many: %u instances: %s", count, csm_result_name(result)) : 0;
}

/* ---- figures ---- */

/*
 * Eight times as many take eight times the memory, and what does not depend on their number comes on top of both. Times
 * may grow half as much again, for caches hold less of it.
 */
static void compare(hard_run *run, const growth *few, const growth *many, const char *where) {
  const double times = 8.0, most = 12.0;
  hard_figure_add(run, many->host_bytes / few->host_bytes, times, "1", "memory of 8 times as many, %s", where);
  hard_figure_add(run, many->device_bytes / few->device_bytes, times, "1", "device memory of 8 times as many, %s",
                  where);
  hard_figure_add(run, many->host_bytes / many->count, INFINITY, "bytes", "memory of an instance, %s", where);
  hard_figure_add(run, many->device_bytes / many->count, INFINITY, "bytes", "device memory of an instance, %s", where);
  hard_figure_add(run, many->allocations, 0.0, "1", "allocations while all move, %s", where);
  if (!run->sweep)
    return;
  hard_figure_add(run, many->moved_frame_ms / few->moved_frame_ms, most, "1", "time of 8 times as many that move, %s",
                  where);
  hard_figure_add(run, many->still_frame_ms / few->still_frame_ms, most, "1",
                  "time of 8 times as many that stand still, %s", where);
  hard_figure_add(run, many->add_ms / few->add_ms, most, "1", "adding 8 times as many, %s", where);
  hard_figure_add(run, many->move_ms / few->move_ms, most, "1", "moving 8 times as many, %s", where);
  hard_figure_add(run, many->moved_frame_ms, INFINITY, "ms", "planning and recording, all moved, %s", where);
  hard_figure_add(run, many->still_frame_ms, INFINITY, "ms", "planning and recording, none moved, %s", where);
}

/* In one place a crowd looks like one of it. */
static void compare_masks(hard_run *run, const growth *few, const growth *many) {
  uint64_t changed = 0, shadowed = 0;
  for (size_t i = 0; i < (size_t)WIDTH * HEIGHT; i++) {
    changed += few->mask[i] != many->mask[i];
    shadowed += few->mask[i] < 1.0f;
  }
  hard_figure_add(run, (double)changed, 0.0, "px", "changed by more in one place");
  hard_figure_add(run, shadowed ? 0.0 : 1.0, 0.0, "1", "pictures that show no shadow");
}

static int draw_places(hard_run *run, const char *backend, uint64_t hashes[2]) {
  growth *grown = host_allocate(2, sizeof *grown);
  int code = 0;
  for (int spread = 0; code == 0 && spread < 2; spread++) {
    const uint32_t few = run->sweep ? 125000 : (1u << 12) - 1; /* a power of two, with the ground */
    code = measure(run, backend, few, spread, &grown[0]);
    if (code == 0)
      code = measure(run, backend, 8 * few, spread, &grown[1]);
    if (code == 0)
      compare(run, &grown[0], &grown[1], spread ? "spread" : "in one place");
    if (code == 0 && !spread)
      compare_masks(run, &grown[0], &grown[1]);
    if (code == 0 && hashes[spread])
      hard_figure_add(run, hashes[spread] != grown[1].plan_hash, 0.0, "1", "plans that backends differ in");
    hashes[spread] = grown[1].plan_hash;
  }
  free(grown);
  return code;
}

static int run_case(hard_run *run) {
  uint64_t hashes[2] = {0, 0};
  int code = 0;
  for (int i = 0; code == 0 && i < HOST_BACKENDS; i++)
    if (run->options->backends[i])
      code = draw_places(run, host_backend_names[i], hashes);
  return code;
}

const hard_case hard_many = {.name = "many", .about = "a million instances, spread and in one place", .run = run_case};
