#include "techniques/maps/maps.h"

#include "techniques/draw_list.h"
#include "techniques/maps/casters.h"
#include "techniques/pass_timer.h"

#include <stdio.h>
#include <string.h>

/* The image that a configuration's maps lie in. */
typedef struct map_image {
  retired retired;
  gpu_image *image;
  gpu_target *targets[CSM_MAX_CASCADES]; /* by layer */
  plan_layout layout;
  gpu_format format;
  bool written; /* something has been recorded into it */
} map_image;

/* What lies on a device for a configuration. */
typedef struct map_objects {
  device *device; /* NULL: nothing */
  map_image *image;
  caster_programs casters;
} map_objects;

typedef struct maps_state {
  map_objects now, fresh;
  bool drawn; /* with the present configuration */
  /* of the recording on its way */
  ring_range ring;
  uint64_t offsets[PLAN_WINDOWS_MOST]; /* in the ring's buffer, where each window's matrices begin */
  /* of the last frame */
  csm_cascade_stats cascades[CSM_MAX_CASCADES];
  pass_timer timer; /* of the clear, of each cascade */
  technique_pages pages[CSM_MAX_CASCADES];
  uint32_t pages_drawn, pages_valid;
} maps_state;

/* ---- images ---- */

static void image_free(device *device, retired *self) {
  map_image *image = (map_image *)self;
  for (uint32_t i = 0; i < image->layout.layers; ++i)
    gpu_target_destroy(device->gpu, image->targets[i]);
  device_image_free(device, image->image);
  host_release(device->host, image);
}

static csm_result image_create(device *device, const plan_layout *layout, gpu_format format, map_image **out) {
  map_image *image = host_allocate(device->host, sizeof *image);
  if (!image)
    return CSM_ERROR_OUT_OF_MEMORY;
  image->layout = *layout;
  image->format = format;
  const gpu_image_info info = {
      .name = "cascade maps",
      .format = format,
      .usage = GPU_IMAGE_TARGET | GPU_IMAGE_SAMPLED | GPU_IMAGE_COPY_SOURCE,
      .width = layout->width,
      .height = layout->height,
      .layers = layout->layers,
      .array = true,
  };
  csm_result result = device_image(device, &info, &image->image);
  for (uint32_t i = 0; i < layout->layers && !result; ++i) {
    const gpu_target_info target = {.name = "cascade map", .depth = image->image, .depth_layer = i};
    result = device_check(device, gpu_target_create(device->gpu, &target, &image->targets[i]), "a cascade's target");
  }
  if (result) {
    image_free(device, &image->retired);
    return result;
  }
  *out = image;
  return CSM_SUCCESS;
}

static bool image_fits(const map_image *image, const plan_layout *layout, gpu_format format) {
  return image->format == format && memcmp(&image->layout, layout, sizeof *layout) == 0;
}

/* ---- settings and devices ---- */

static bool wanted(const csm_config *config) {
  (void)config;
  return true;
}

static csm_result make(void *self, device *device, const csm_config *config) {
  maps_state *state = self;
  map_objects made = {.device = device, .casters.look = caster_look_of(config)};
  const gpu_format format = made.casters.look.format;
  plan_layout layout = {0};
  plan_layout_make(&layout, config);
  csm_result result = caster_programs_extend(device, &made.casters);
  if (!result && state->now.device == device && image_fits(state->now.image, &layout, format))
    made.image = state->now.image;
  else if (!result)
    result = image_create(device, &layout, format, &made.image);
  if (result) {
    caster_programs_give_back(device, &made.casters);
    return result;
  }
  state->fresh = made;
  return CSM_SUCCESS;
}

static void forget_measured(maps_state *state, device *device) {
  pass_timer_drop(&state->timer, device);
  memset(state->cascades, 0, sizeof state->cascades);
  state->drawn = false;
}

static void drop(void *self, device *device) {
  maps_state *state = self;
  forget_measured(state, device);
  if (!state->now.device)
    return;
  if (state->now.image != state->fresh.image)
    retire(device, &state->now.image->retired, image_free);
  caster_programs_give_back(device, &state->now.casters);
  state->now = (map_objects){0};
}

static void adopt(void *self, device *from) {
  maps_state *state = self;
  if (!state->fresh.device)
    return;
  drop(state, from);
  state->now = state->fresh;
  state->fresh = (map_objects){0};
}

static void forget(void *self, device *device) {
  maps_state *state = self;
  if (!state->fresh.device)
    return;
  if (state->fresh.image != state->now.image)
    image_free(device, &state->fresh.image->retired);
  caster_programs_give_back(device, &state->fresh.casters);
  state->fresh = (map_objects){0};
}

/* ---- a frame ---- */

/* Bytes of a window's matrices, up to where the next one's begin. */
static uint64_t matrices_bytes(const plan_frame *plan, uint32_t window) {
  const uint64_t bytes = draw_list_bytes(&plan->windows[window].list, CASTER_ROWS);
  return (bytes + RING_ALIGNMENT - 1) / RING_ALIGNMENT * RING_ALIGNMENT;
}

static uint64_t size(const void *self, const technique_run *run) {
  (void)self;
  uint64_t bytes = 0;
  for (uint32_t i = 0; i < run->plan->window_count && !run->plan->unshadowed; ++i)
    bytes += matrices_bytes(run->plan, i);
  return bytes;
}

static csm_result reserve(void *self, technique_run *run, const ring_range *ring) {
  maps_state *state = self;
  state->ring = *ring;
  return caster_programs_extend(run->device, &state->now.casters);
}

static void write(void *self, const technique_run *run) {
  maps_state *state = self;
  uint64_t offset = 0;
  for (uint32_t i = 0; i < run->plan->window_count && !run->plan->unshadowed; ++i) {
    if (run->plan->windows[i].list.instance_count)
      plan_write_window_matrices((float *)((char *)state->ring.memory + offset), run->plan, i, run->scene);
    state->offsets[i] = state->ring.offset + offset;
    offset += matrices_bytes(run->plan, i);
  }
}

/* ---- recording ---- */

static void call_engine(const maps_state *state, const technique_run *run, uint32_t cascade) {
  const plan_rect *rect = &state->now.image->layout.rects[cascade];
  gpu_native_pass native;
  gpu_pass_native(run->device->gpu, &native);
  csm_draw_info info = {
      .struct_size = sizeof info,
      .cascade = cascade,
      .resolution = rect->side,
      .x = rect->x,
      .y = rect->y,
      .depth_format = native.target.depth_format,
      .render_pass = native.target.render_pass,
      .dynamic_rendering = native.target.dynamic_rendering,
      .reversed = state->now.casters.look.reversed,
      .command_buffer = native.command_buffer,
      .depth_view = native.depth_view,
  };
  plan_cascade_volume(run->plan, cascade, info.world_to_clip, info.planes);
  run->frame->draw(run->frame->draw_user, &info);
}

/* Into the pass that is open. */
static void draw_casters(const maps_state *state, const technique_run *run, uint32_t window) {
  const caster_programs *casters = &state->now.casters;
  draw_list(run->device->gpu,
            &(draw_list_info){.programs = {casters->programs[GPU_CULL_NONE], casters->programs[GPU_CULL_BACK],
                                           casters->programs[GPU_CULL_FRONT]},
                              .cull = casters->look.cull,
                              .skip_hidden = true,
                              .list = &run->plan->windows[window].list,
                              .meshes = run->device->geometry.meshes,
                              .matrices = state->ring.buffer,
                              .offset = state->offsets[window],
                              .rows = CASTER_ROWS});
}

/* A whole map, which is one window. */
static void draw_map(const maps_state *state, const technique_run *run, uint32_t cascade) {
  const gpu gpu = run->device->gpu;
  if (!run->plan->windows[cascade].list.draw_count && !run->frame->draw)
    return;
  const plan_rect *rect = &state->now.image->layout.rects[cascade];
  gpu_pass_begin(gpu, &(gpu_pass_info){.target = state->now.image->targets[rect->layer],
                                       .area = {rect->x, rect->y, rect->side, rect->side}});
  draw_casters(state, run, cascade);
  if (run->frame->draw)
    call_engine(state, run, cascade);
  gpu_pass_end(gpu);
}

/* Slots of a layer, in texels. */
static gpu_rect texels_of(const map_image *image, const uint32_t slots[4]) {
  const uint32_t page = image->layout.width / PLAN_CELLS;
  return (gpu_rect){slots[0] * page, slots[1] * page, slots[2] * page, slots[3] * page};
}

/*
 * The pages that are due. What else lies in their rectangle is drawn over by some of what it holds, at the same depths, so
 * it stays as it is.
 */
static void draw_pages(const maps_state *state, const technique_run *run, uint32_t cascade) {
  const gpu gpu = run->device->gpu;
  const map_image *image = state->now.image;
  for (uint32_t i = 0; i < run->plan->window_count; ++i) {
    const plan_window *window = &run->plan->windows[i];
    if (window->cascade != cascade || !window->list.draw_count)
      continue;
    gpu_pass_begin(gpu, &(gpu_pass_info){.target = image->targets[cascade],
                                         .area = texels_of(image, window->slots),
                                         .clip_space = {0, 0, image->layout.width, image->layout.height}});
    draw_casters(state, run, i);
    gpu_pass_end(gpu);
  }
}

static void count_casters(maps_state *state, const technique_run *run) {
  for (uint32_t i = 0; i < run->plan->cascade_count; ++i) {
    const plan_cascade *of = &run->plan->cascades[i];
    state->cascades[i] =
        (csm_cascade_stats){.casters_drawn = of->casters, .casters_culled = run->scene->caster_count - of->casters};
  }
  for (uint32_t i = 0; i < run->plan->window_count; ++i) {
    const plan_list *list = &run->plan->windows[i].list;
    csm_cascade_stats *stats = &state->cascades[run->plan->windows[i].cascade];
    for (uint32_t d = 0; d < list->draw_count; ++d) {
      const plan_draw *draw = &list->draws[d];
      const mesh_place *mesh = &run->device->geometry.meshes[draw->mesh];
      stats->triangles_drawn += (uint64_t)draw_list_indices(draw, mesh) / 3 * draw->count;
    }
  }
}

static uint32_t count_bits(const uint64_t rows[PLAN_CELLS]) {
  uint32_t bits = 0;
  for (uint32_t i = 0; i < PLAN_CELLS; ++i)
    bits += (uint32_t)__builtin_popcountll(rows[i]);
  return bits;
}

static void count_pages(maps_state *state, const technique_run *run) {
  state->pages_drawn = state->pages_valid = 0;
  for (uint32_t i = 0; i < run->plan->cascade_count; ++i) {
    const plan_cascade *of = &run->plan->cascades[i];
    state->pages[i] = (technique_pages){.across = run->plan->pages ? PLAN_CELLS : 0,
                                        .begin = {of->begin_texels[0], of->begin_texels[1]}};
    memcpy(state->pages[i].valid, of->valid, sizeof of->valid);
    state->pages_drawn += count_bits(of->due);
    state->pages_valid += count_bits(of->valid);
  }
}

static float clear_depth(const maps_state *state) {
  return state->now.casters.look.reversed ? 0.0f : 1.0f;
}

static void clear(const maps_state *state, const technique_run *run) {
  gpu_clear_depth(run->device->gpu, state->now.image->image, clear_depth(state));
}

/* Those that are due, a rectangle after the other. */
static void clear_pages(const maps_state *state, const technique_run *run) {
  const map_image *image = state->now.image;
  for (uint32_t i = 0; i < run->plan->cascade_count; ++i) {
    uint64_t due[PLAN_CELLS];
    uint32_t slots[4];
    memcpy(due, run->plan->cascades[i].due, sizeof due);
    while (plan_next_slots(slots, due)) {
      gpu_pass_begin(run->device->gpu, &(gpu_pass_info){.target = image->targets[i],
                                                        .area = texels_of(image, slots),
                                                        .depth_load = GPU_LOAD_CLEAR,
                                                        .clear_depth = clear_depth(state)});
      gpu_pass_end(run->device->gpu);
    }
  }
}

static void draw_all(maps_state *state, const technique_run *run) {
  const gpu gpu = run->device->gpu;
  const uint32_t count = run->plan->cascade_count;
  pass_timer_begin(&state->timer, run, 1 + count);
  if (run->plan->pages && state->now.image->written)
    clear_pages(state, run);
  else
    clear(state, run);
  pass_timer_step(&state->timer, run);
  for (uint32_t cascade = 0; cascade < count; ++cascade) {
    char name[32];
    snprintf(name, sizeof name, "cascade %u depth", (unsigned)cascade);
    gpu_marker_begin(gpu, name);
    if (run->plan->pages)
      draw_pages(state, run, cascade);
    else
      draw_map(state, run, cascade);
    gpu_marker_end(gpu);
    pass_timer_step(&state->timer, run);
  }
}

static void record(void *self, const technique_run *run) {
  maps_state *state = self;
  map_image *image = state->now.image;
  if (!run->plan->unshadowed)
    draw_all(state, run);
  else if (!image->written) /* shaders that look at it must find something */
    clear(state, run);
  gpu_make_readable(run->device->gpu, image->image, NULL);
  image->written = true;
  state->drawn = true;
  count_casters(state, run);
  if (!run->plan->unshadowed)
    count_pages(state, run);
}

/* ---- what came of it ---- */

static void bind(const void *self, device *device, csm_binding *binding) {
  const maps_state *state = self;
  gpu_native_image native;
  gpu_image_native(device->gpu, state->now.image->image, &native);
  binding->native_maps = native.image;
  binding->native_maps_view = native.view;
  const bool reversed = state->now.casters.look.reversed;
  binding->native_sampler = !state->pages[0].across ? (reversed ? native.sampler_reversed : native.sampler)
                            : reversed              ? native.sampler_repeat_reversed
                                                    : native.sampler_repeat;
  if (binding->maps_descriptor)
    gpu_image_describe(device->gpu, state->now.image->image, binding->maps_descriptor);
}

static void tell(const void *self, const device *device, csm_stats *stats) {
  const maps_state *state = self;
  memcpy(stats->cascades, state->cascades, sizeof state->cascades);
  for (uint32_t i = 0; i < CSM_MAX_CASCADES; ++i)
    stats->cascades[i].gpu_ms = pass_timer_ms(&state->timer, 1 + i);
  stats->clear_gpu_ms = pass_timer_ms(&state->timer, 0);
  stats->pages_drawn = state->pages_drawn;
  stats->pages_valid = state->pages_valid;
  stats->map_bytes += gpu_image_bytes(device->gpu, state->now.image->image);
}

static csm_result find(const void *self, uint32_t source, uint32_t cascade, technique_image *out) {
  const maps_state *state = self;
  if (source != CSM_READ_MAP)
    return CSM_ERROR_UNSUPPORTED;
  if (!state->drawn)
    return CSM_ERROR_INVALID_STATE;
  const map_image *image = state->now.image;
  const plan_rect *rect = &image->layout.rects[cascade];
  *out = (technique_image){.image = image->image,
                           .format = image->format,
                           .width = image->layout.width,
                           .height = image->layout.height,
                           .layer = rect->layer,
                           .pages = state->pages[cascade].across ? &state->pages[cascade] : NULL,
                           .cleared = clear_depth(state),
                           .part = {.x = rect->x, .y = rect->y, .width = rect->side, .height = rect->side}};
  return CSM_SUCCESS;
}

gpu_image *maps_image(const technique_set *cascades) {
  const maps_state *state = technique_state(cascades, &technique_maps);
  return state->now.image->image;
}

csm_result maps_draw_target(const technique_set *cascades, device *device, csm_draw_target *out) {
  const maps_state *state = technique_state(cascades, &technique_maps);
  const caster_look *look = &state->now.casters.look;
  gpu_native_target native = {0};
  const csm_result result =
      device_check(device, gpu_target_native(device->gpu, look->format, GPU_FORMAT_NONE, &native), "the maps' target");
  if (result)
    return result;
  out->depth_format = native.depth_format;
  out->render_pass = native.render_pass;
  out->dynamic_rendering = native.dynamic_rendering;
  out->reversed = look->reversed;
  return CSM_SUCCESS;
}

const technique technique_maps = {
    .name = "maps",
    .state_size = sizeof(maps_state),
    .wanted = wanted,
    .make = make,
    .adopt = adopt,
    .forget = forget,
    .drop = drop,
    .size = size,
    .reserve = reserve,
    .write = write,
    .record = record,
    .bind = bind,
    .tell = tell,
    .find = find,
};
