#include "techniques/rays/rays.h"

#include "device/tree_pool.h"
#include "private/rays.h"
#include "shader_code.h"
#include "techniques/inputs.h"
#include "techniques/mask/mask_programs.h"
#include "techniques/pass_timer.h"
#include "techniques/rays/instances.h"

#include <string.h>

enum { steps = 3, list_header = RAYS_FIRST * sizeof(uint32_t) };

/* The pixels that rays are to decide: private/rays.h. */
typedef struct pixel_list {
  retired retired;
  gpu_buffer *buffer;
  uint64_t size;
} pixel_list;

typedef struct rays_state {
  pixel_list *now, *fresh;
  inputs inputs[steps];
  pass_timer timer;
  /* of the recording on its way */
  bool runs;
  ring_range ring;
  gpu_program *programs[steps];
  input *reads[steps];
} rays_state;

static bool wanted(const csm_config *config) {
  return plan_has_rays(config);
}

/* ---- programs ---- */

/* What a program is made for: list, groups, or rays, which are RAYS_SOFT and RAYS_MIXED. */
enum { LIST = 0, GROUPS = 1, RAYS = 2, SOFT = 1, MIXED = 2 };

static gpu_code code_of(uint32_t kind) {
  static const gpu_code *const codes[] = {&shader_rays_list_cs, &shader_rays_groups_cs,
                                          &shader_rays_cs,      &shader_rays_soft_cs,
                                          &shader_rays_mixed_cs, &shader_rays_soft_mixed_cs};
  return *codes[kind];
}

static csm_result make_program(gpu gpu, const void *about, gpu_program **out) {
  const uint32_t kind = *(const uint32_t *)about;
  const bool rays = kind >= RAYS;
  const gpu_program_info info = {.name = rays ? "rays" : kind == LIST ? "rays' pixels" : "rays' groups",
                                 .compute = code_of(kind),
                                 .constants_count = 2,
                                 .constants_sizes = {MASK_CASCADES_BLOCK, MASK_CAMERA_BLOCK},
                                 .texture_count = kind == GROUPS ? 0 : rays ? 2 : 1,
                                 .buffer_count = rays ? 3 : 0,
                                 .store_image_count = rays,
                                 .store_buffer_count = !rays,
                                 .sampler_count = rays,
                                 .samplers = {GPU_SAMPLER_POINT_CLAMP}};
  return gpu_program_create(gpu, &info, out);
}

static csm_result find_programs(rays_state *state, device *device, const csm_config *config) {
  const uint32_t soft = config->filter == CSM_FILTER_EXACT_SOFT ? SOFT : 0;
  const uint32_t mixed = config->history == CSM_HISTORY_ON ? MIXED : 0;
  const uint32_t kinds[steps] = {LIST, GROUPS, RAYS + soft + mixed};
  csm_result result = CSM_SUCCESS;
  for (uint32_t i = 0; i < steps && !result; ++i) {
    const program_key key = {
        .make = make_program, .name = "a program of rays", .about = &kinds[i], .size = sizeof kinds[i]};
    result = programs_find(device, &key, &state->programs[i]);
  }
  return result;
}

/* ---- devices ---- */

static void list_free(device *device, retired *self) {
  pixel_list *list = (pixel_list *)self;
  device_buffer_free(device, list->buffer, list->size);
  host_release(device->host, list);
}

static void drop(void *self, device *device) {
  rays_state *state = self;
  pass_timer_drop(&state->timer, device);
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

static csm_result reserve_list(rays_state *state, device *device, const technique_picture *picture) {
  const uint64_t wanted = list_header + (uint64_t)picture->width * picture->height * sizeof(uint32_t);
  if (state->now && state->now->size == wanted)
    return CSM_SUCCESS;
  pixel_list *list = host_allocate(device->host, sizeof *list);
  if (!list)
    return CSM_ERROR_OUT_OF_MEMORY;
  list->size = wanted;
  const gpu_buffer_info info = {.name = "rays' pixels",
                                .kind = GPU_BUFFER_DEVICE,
                                .size = wanted,
                                .usage = GPU_BUFFER_READ | GPU_BUFFER_WRITE | GPU_BUFFER_INDIRECT};
  const csm_result result = device_buffer(device, &info, &list->buffer);
  if (result)
    host_release(device->host, list);
  else
    state->fresh = list;
  return result;
}

static csm_result reserve_reads(rays_state *state, technique_run *run) {
  const technique_picture *picture = run->picture;
  gpu_buffer *constants = picture->mask_constants.buffer;
  const gpu_buffer_part list = {.buffer = (state->fresh ? state->fresh : state->now)->buffer,
                                .stride = sizeof(uint32_t)};
  const gpu_bindings_info reads[steps] = {
      {.name = "rays' pixels",
       .program = state->programs[0],
       .constants = {constants, constants},
       .textures = {picture->mask},
       .store_buffers = {list}},
      {.name = "rays' groups",
       .program = state->programs[1],
       .constants = {constants, constants},
       .store_buffers = {list}},
      {.name = "rays",
       .program = state->programs[2],
       .constants = {constants, constants},
       .textures = {picture->depth, picture->depth},
       .buffers = {{.buffer = tree_pool_buffer(run->device), .stride = TREE_POOL_ROW},
                   {.buffer = ray_instances_buffer(run->cascades), .stride = TREE_POOL_ROW},
                   list},
       .store_images = {picture->mask_stores}}};
  csm_result result = CSM_SUCCESS;
  for (uint32_t i = 0; i < steps && !result; ++i)
    result = inputs_find(&state->inputs[i], run->device, &reads[i], &state->reads[i]);
  return result;
}

static csm_result reserve(void *self, technique_run *run, const ring_range *ring) {
  rays_state *state = self;
  /* Without a mesh there is nothing that casts, and maps are empty */
  state->runs = run->picture->show == CSM_SHOW_VISIBILITY && tree_pool_buffer(run->device);
  state->ring = *ring;
  if (!state->runs)
    return CSM_SUCCESS;
  csm_result result = find_programs(state, run->device, run->config);
  if (!result)
    result = reserve_list(state, run->device, run->picture);
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
  if (!state->runs)
    return;
  pass_timer_begin(&state->timer, run, 1);
  gpu_marker_begin(gpu, "rays");
  gpu_copy_buffer(gpu, state->now->buffer, 0, state->ring.buffer, state->ring.offset, list_header);
  dispatch(state, run, 0, (gpu_dispatch_info){.groups = {across, down, 1}});
  dispatch(state, run, 1, (gpu_dispatch_info){.groups = {1, 1, 1}});
  dispatch(state, run, 2,
           (gpu_dispatch_info){.arguments = state->now->buffer, .arguments_offset = RAYS_GROUPS * sizeof(uint32_t)});
  gpu_make_readable(gpu, picture->mask, NULL);
  gpu_marker_end(gpu);
  pass_timer_step(&state->timer, run);
}

/* ---- what came of it ---- */

static void tell_view(const void *self, const device *device, csm_view_stats *stats) {
  const rays_state *state = self;
  (void)device;
  stats->rays_gpu_ms = pass_timer_ms(&state->timer, 0);
  stats->bytes += state->now ? state->now->size : 0;
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
