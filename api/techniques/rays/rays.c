#include "techniques/rays/rays.h"

#include "device/tree_pool.h"
#include "private/rays.h"
#include "shader_code.h"
#include "techniques/history/history.h"
#include "techniques/inputs.h"
#include "techniques/mask/mask_programs.h"
#include "techniques/pass_timer.h"
#include "techniques/rays/instances.h"

#include <string.h>

/* The passes: pixels are listed, groups of threads counted, rays sent; then pixels share what these found. */
enum { LIST, GROUPS, RAYS, SHARE, STORE, steps };
enum { list_header = RAYS_FIRST * sizeof(uint32_t), arguments_size = 3 * sizeof(uint32_t) };

/* The pixels that rays are to decide: private/rays.h. */
typedef struct pixel_list {
  retired retired;
  gpu_buffer *buffer;
  gpu_buffer *arguments; /* the list's groups: what a dispatch writes cannot be its arguments */
  uint64_t size;         /* of the list */
} pixel_list;

/* The list's header on its way back. */
typedef struct count_read {
  retired retired;
  struct count_read *next;
  gpu_buffer *buffer;
  uint64_t serial; /* the frame that copies it */
  bool view;       /* nodes were counted, too */
} count_read;

/* What the GPU has counted. */
typedef struct ray_counts {
  uint32_t pixels, by_map;
  uint64_t nodes, triangles;
} ray_counts;

typedef struct rays_state {
  pixel_list *now, *fresh;
  count_read *reads_back; /* of recordings that may be on their way, newest first */
  ray_counts counts;
  inputs inputs[steps];
  pass_timer timer;
  /* of the recording on its way */
  uint32_t runs; /* how many of the passes */
  ring_range ring;
  gpu_program *programs[steps];
  input *reads[steps];
  count_read *counting;
} rays_state;

static bool wanted(const csm_config *config) {
  return plan_has_rays(config);
}

/* ---- programs ---- */

static const char *const names[steps] = {"rays' pixels", "rays' groups", "rays", "rays' sharing", "rays' means"};

/* What a program is made for; without gaps, for its bytes are compared. */
typedef struct rays_key {
  uint64_t step;
  uint64_t variant; /* of rays.cs.hlsl, where rays are sent */
} rays_key;

static csm_result make_program(gpu gpu, const void *about, gpu_program **out) {
  static const uint32_t textures[steps] = {[LIST] = 1, [RAYS] = 2, [SHARE] = 2};
  const rays_key *key = about;
  const gpu_code codes[steps] = {[LIST] = shader_rays_list_cs,
                                 [GROUPS] = shader_rays_groups_cs,
                                 [SHARE] = shader_rays_share_cs,
                                 [STORE] = shader_rays_store_cs};
  const gpu_program_info info = {.name = names[key->step],
                                 .compute = key->step == RAYS ? *shader_find(key->variant) : codes[key->step],
                                 .constants_count = 2,
                                 .constants_sizes = {MASK_CASCADES_BLOCK, MASK_CAMERA_BLOCK},
                                 .texture_count = textures[key->step],
                                 .texel_buffer_count = key->step == RAYS ? 2 : 0,
                                 .store_image_count = key->step == RAYS || key->step == STORE,
                                 .store_buffer_count = 1,
                                 .sampler_count = textures[key->step] > 0,
                                 .samplers = {GPU_SAMPLER_POINT_CLAMP}};
  return gpu_program_create(gpu, &info, out);
}

static csm_result find_programs(rays_state *state, technique_run *run) {
  const csm_config *config = run->config;
  const bool view = run->picture->show == CSM_SHOW_RAYS;
  const uint64_t variant =
      shader_key_rays(config->filter == CSM_FILTER_EXACT_SOFT, config->history == CSM_HISTORY_ON && !view, view);
  csm_result result = CSM_SUCCESS;
  for (uint32_t i = 0; i < state->runs && !result; ++i) {
    const rays_key about = {.step = i, .variant = i == RAYS ? variant : 0};
    const program_key key = {.make = make_program, .name = "a program of rays", .about = &about, .size = sizeof about};
    result = programs_find(run->device, &key, &state->programs[i]);
  }
  return result;
}

/* ---- devices ---- */

static void list_free(device *device, retired *self) {
  pixel_list *list = (pixel_list *)self;
  device_buffer_free(device, list->arguments, arguments_size);
  device_buffer_free(device, list->buffer, list->size);
  host_release(device->host, list);
}

static void count_read_free(device *device, retired *self) {
  count_read *read = (count_read *)self;
  device_buffer_free(device, read->buffer, list_header);
  host_release(device->host, read);
}

static void drop(void *self, device *device) {
  rays_state *state = self;
  pass_timer_drop(&state->timer, device);
  while (state->reads_back) {
    count_read *read = state->reads_back;
    state->reads_back = read->next;
    retire(device, &read->retired, count_read_free);
  }
  state->counts = (ray_counts){0};
  for (uint32_t i = 0; i < steps; ++i)
    inputs_drop(&state->inputs[i], device);
  if (state->now)
    retire(device, &state->now->retired, list_free);
  state->now = NULL;
}

static void adopt(void *self, device *from) {
  rays_state *state = self;
  if (!state->fresh)
    return;
  if (state->now)
    retire(from, &state->now->retired, list_free);
  state->now = state->fresh;
  state->fresh = NULL;
}

static void forget(void *self, device *device) {
  rays_state *state = self;
  if (state->fresh)
    list_free(device, &state->fresh->retired);
  state->fresh = NULL;
}

/* ---- a picture ---- */

/* An empty list's header. */
static uint64_t size(const void *self, const technique_run *run) {
  (void)self;
  (void)run;
  return RING_ALIGNMENT;
}

static csm_result reserve_list(rays_state *state, const technique_run *run) {
  device *device = run->device;
  const uint64_t pixels_most = (uint64_t)run->picture->width * run->picture->height;
  const uint64_t words = plan_shares_rays(run->config) ? 2 * pixels_most : pixels_most;
  const uint64_t wanted = list_header + words * sizeof(uint32_t);
  if (state->now && state->now->size == wanted)
    return CSM_SUCCESS;
  pixel_list *list = host_allocate(device->host, sizeof *list);
  if (!list)
    return CSM_ERROR_OUT_OF_MEMORY;
  list->size = wanted;
  const gpu_buffer_info pixels = {
      .name = "rays' pixels", .kind = GPU_BUFFER_DEVICE, .size = wanted, .usage = GPU_BUFFER_READ | GPU_BUFFER_WRITE};
  const gpu_buffer_info arguments = {
      .name = "rays' groups", .kind = GPU_BUFFER_DEVICE, .size = arguments_size, .usage = GPU_BUFFER_INDIRECT};
  csm_result result = device_buffer(device, &pixels, &list->buffer);
  if (!result)
    result = device_buffer(device, &arguments, &list->arguments);
  if (result)
    list_free(device, &list->retired);
  else
    state->fresh = list;
  return result;
}

static csm_result reserve_reads(rays_state *state, technique_run *run) {
  const technique_picture *picture = run->picture;
  gpu_buffer *constants = picture->mask_constants.buffer;
  gpu_buffer *instances = ray_instances_buffer(run->cascades);
  gpu_buffer *meshes = tree_pool_buffer(run->device); /* NULL: no mesh has a tree, and no row is read */
  const gpu_buffer_part list = {.buffer = (state->fresh ? state->fresh : state->now)->buffer,
                                .stride = sizeof(uint32_t)};
  gpu_bindings_info reads[steps] = {[LIST] = {.textures = {picture->mask}},
                                    [RAYS] = {.textures = {picture->depth, picture->depth},
                                              .texel_buffers = {meshes ? meshes : instances, instances},
                                              .store_images = {picture->mask_stores}},
                                    [SHARE] = {.textures = {picture->mask, picture->depth}},
                                    [STORE] = {.store_images = {picture->mask_stores}}};
  csm_result result = CSM_SUCCESS;
  for (uint32_t i = 0; i < state->runs && !result; ++i) {
    reads[i].name = names[i];
    reads[i].program = state->programs[i];
    reads[i].constants[0] = reads[i].constants[1] = constants;
    reads[i].store_buffers[0] = list;
    result = inputs_find(&state->inputs[i], run->device, &reads[i], &state->reads[i]);
  }
  return result;
}

/* What the GPU has counted up to now. */
static ray_counts counts_of(const rays_state *state, const device *device) {
  ray_counts counts = state->counts;
  uint64_t newest = 0, newest_view = 0;
  for (const count_read *read = state->reads_back; read; read = read->next) {
    if (!read->serial || read->serial > device->done)
      continue;
    const uint32_t *list = gpu_buffer_memory(device->gpu, read->buffer);
    if (read->serial > newest) {
      newest = read->serial;
      counts.pixels = list[RAYS_COUNT];
      counts.by_map = list[RAYS_BY_MAP];
    }
    if (read->view && read->serial > newest_view) {
      newest_view = read->serial;
      counts.nodes = list[RAYS_NODES] * (uint64_t)16;
      counts.triangles = list[RAYS_TRIANGLES] * (uint64_t)16;
    }
  }
  return counts;
}

/* A read that is done serves again. */
static csm_result reserve_counting(rays_state *state, device *device) {
  count_read *read = state->reads_back;
  state->counts = counts_of(state, device);
  while (read && read->serial > device->done)
    read = read->next;
  state->counting = read;
  if (read)
    return CSM_SUCCESS;
  read = host_allocate(device->host, sizeof *read);
  if (!read)
    return CSM_ERROR_OUT_OF_MEMORY;
  const csm_result result = device_buffer(
      device, &(gpu_buffer_info){.name = "rays' counts", .kind = GPU_BUFFER_READBACK, .size = list_header},
      &read->buffer);
  if (result) {
    host_release(device->host, read);
    return result;
  }
  read->next = state->reads_back;
  state->reads_back = state->counting = read;
  return CSM_SUCCESS;
}

/* Views of other things send none. */
static bool sends(const technique_run *run) {
  const uint32_t show = run->picture->show;
  return (show == CSM_SHOW_RAYS || show == CSM_SHOW_VISIBILITY || history_takes(run->config, run->picture)) &&
         ray_instances_buffer(run->cascades);
}

static csm_result reserve(void *self, technique_run *run, const ring_range *ring) {
  rays_state *state = self;
  const bool shares = plan_shares_rays(run->config) && run->picture->show == CSM_SHOW_VISIBILITY;
  state->runs = !sends(run) ? 0 : shares ? steps : SHARE;
  state->ring = *ring;
  if (!state->runs)
    return CSM_SUCCESS;
  csm_result result = find_programs(state, run);
  if (!result)
    result = reserve_list(state, run);
  if (!result)
    result = reserve_counting(state, run->device);
  return result ? result : reserve_reads(state, run);
}

static void write(void *self, const technique_run *run) {
  (void)run;
  memset(((const rays_state *)self)->ring.memory, 0, list_header);
}

static void dispatch(rays_state *state, const technique_run *run, uint32_t step, gpu_dispatch_info info) {
  const uint32_t offset = (uint32_t)run->picture->mask_constants.offset;
  const uint32_t offsets[] = {offset, offset + MASK_CASCADES_BLOCK};
  info.program = state->programs[step];
  info.bindings = inputs_use(state->reads[step], run->device);
  info.offsets = offsets;
  gpu_dispatch(run->device->gpu, &info);
}

static void record(void *self, const technique_run *run) {
  rays_state *state = self;
  const technique_picture *picture = run->picture;
  const gpu gpu = run->device->gpu;
  const uint32_t across = (picture->width + RAYS_TILE - 1) / RAYS_TILE;
  const uint32_t down = (picture->height + RAYS_TILE - 1) / RAYS_TILE;
  if (!state->runs) {
    pass_timer_skip(&state->timer, run);
    return;
  }
  pass_timer_begin(&state->timer, run, 1);
  gpu_marker_begin(gpu, "rays");
  gpu_copy_buffer(gpu, state->now->buffer, 0, state->ring.buffer, state->ring.offset, list_header);
  dispatch(state, run, LIST, (gpu_dispatch_info){.groups = {across, down, 1}});
  dispatch(state, run, GROUPS, (gpu_dispatch_info){.groups = {1, 1, 1}});
  gpu_copy_buffer(gpu, state->now->arguments, 0, state->now->buffer, RAYS_GROUPS * sizeof(uint32_t), arguments_size);
  for (uint32_t step = RAYS; step < state->runs; ++step)
    dispatch(state, run, step, (gpu_dispatch_info){.arguments = state->now->arguments});
  gpu_make_readable(gpu, picture->mask, NULL);
  gpu_copy_buffer(gpu, state->counting->buffer, 0, state->now->buffer, 0, list_header);
  gpu_marker_end(gpu);
  pass_timer_step(&state->timer, run);
  state->counting->serial = run->device->serial;
  state->counting->view = picture->show == CSM_SHOW_RAYS;
}

/* ---- what came of it ---- */

static void tell_view(const void *self, const device *device, csm_view_stats *stats) {
  const rays_state *state = self;
  const ray_counts counts = counts_of(state, device);
  stats->rays_gpu_ms = pass_timer_ms(&state->timer, 0);
  stats->ray_pixels = counts.pixels;
  stats->ray_map_pixels = counts.by_map;
  stats->ray_nodes = counts.nodes;
  stats->ray_triangles = counts.triangles;
  stats->bytes += state->now ? state->now->size + arguments_size : 0;
}

const technique technique_rays = {
    .name = "rays",
    .state_size = sizeof(rays_state),
    .wanted = wanted,
    .adopt = adopt,
    .forget = forget,
    .drop = drop,
    .size = size,
    .reserve = reserve,
    .write = write,
    .record = record,
    .tell_view = tell_view,
};
