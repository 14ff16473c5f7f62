#include "techniques/maps/maps.h"

#include "techniques/draw_list.h"
#include "techniques/maps/pages.h"
#include "techniques/pass_timer.h"

#include <stdio.h>
#include <string.h>

/* What lies on a device for a configuration. */
typedef struct map_objects {
  device *device; /* NULL: nothing */
  map_image *image;
  bool pages;
  caster_programs casters;
} map_objects;

typedef struct maps_state {
  map_objects now, fresh;
  bool drawn; /* with the present configuration */
  /* of the recording on its way */
  ring_range ring;
  map_windows windows;
  page_copies copies;
  /* of the last frame */
  csm_cascade_stats cascades[CSM_MAX_CASCADES];
  uint32_t sides[CSM_MAX_CASCADES]; /* of maps, in their rectangles' top left corners */
  pass_timer timer;                 /* of the clear, of each cascade */
  technique_pages pages[CSM_MAX_CASCADES];
  uint32_t pages_drawn, pages_copied, pages_valid;
} maps_state;

/* ---- settings and devices ---- */

/* Whether an image serves a configuration. Second layers go with the last pages. */
static bool image_fits(const map_image *image, const plan_layout *layout, gpu_format format, const csm_config *config) {
  return image->format == format && memcmp(&image->layout, layout, sizeof *layout) == 0 &&
         (!image->second.image || plan_has_pages(config));
}
static bool wanted(const csm_config *config) {
  (void)config;
  return true;
}

static csm_result make(void *self, device *device, const csm_config *config) {
  maps_state *state = self;
  map_objects made = {.device = device, .pages = plan_has_pages(config), .casters.look = caster_look_of(config)};
  const gpu_format format = made.casters.look.format;
  plan_layout layout = {0};
  plan_layout_make(&layout, config);
  csm_result result = caster_programs_extend(device, &made.casters);
  if (!result && state->now.device == device && image_fits(state->now.image, &layout, format, config))
    made.image = state->now.image;
  else if (!result)
    result = map_image_create(device, &layout, format, &made.image);
  if (result) {
    caster_programs_give_back(device, &made.casters);
    return result;
  }
  state->fresh = made;
  return CSM_SUCCESS;
}

/* Pages may get second layers later. */
static uint64_t bytes(const void *self, const device *device) {
  const map_objects *made = &((const maps_state *)self)->fresh;
  return gpu_image_bytes(device->gpu, made->image->image) * (made->pages ? 2 : 1);
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
    retire(device, &state->now.image->retired, map_image_free);
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
    map_image_free(device, &state->fresh.image->retired);
  caster_programs_give_back(device, &state->fresh.casters);
  state->fresh = (map_objects){0};
}

/* ---- a frame ---- */

static uint64_t size(const void *self, const technique_run *run) {
  (void)self;
  return map_windows_bytes(run->plan) + page_copies_bytes(run->plan);
}

static csm_result reserve(void *self, technique_run *run, const ring_range *ring) {
  maps_state *state = self;
  state->ring = *ring;
  const csm_result result = caster_programs_extend(run->device, &state->now.casters);
  return !result && page_copies_any(run->plan) ? map_image_extend(run->device, state->now.image) : result;
}

static void write(void *self, const technique_run *run) {
  maps_state *state = self;
  const uint64_t matrices = map_windows_bytes(run->plan);
  map_windows_write(&state->windows, run, &state->ring);
  page_copies_write(&state->copies, run->plan,
                    &(ring_range){.buffer = state->ring.buffer,
                                  .offset = state->ring.offset + matrices,
                                  .memory = (char *)state->ring.memory + matrices});
}

/* ---- recording ---- */

static void call_engine(const maps_state *state, const technique_run *run, uint32_t cascade) {
  const plan_rect *rect = &state->now.image->layout.rects[cascade];
  gpu_native_pass native;
  gpu_pass_native(run->device->gpu, &native);
  csm_draw_info info = {
      .struct_size = sizeof info,
      .cascade = cascade,
      .resolution = run->plan->cascades[cascade].resolution,
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

/* A whole map, which is one window. */
static void draw_map(const maps_state *state, const technique_run *run, uint32_t cascade) {
  const gpu gpu = run->device->gpu;
  if (!run->plan->windows[cascade].list.draw_count && !run->frame->draw)
    return;
  const plan_rect *rect = &state->now.image->layout.rects[cascade];
  const uint32_t side = run->plan->cascades[cascade].resolution;
  gpu_pass_begin(
      gpu, &(gpu_pass_info){.target = state->now.image->targets[rect->layer], .area = {rect->x, rect->y, side, side}});
  map_windows_draw(&state->windows, run, &state->now.casters, cascade);
  if (run->frame->draw)
    call_engine(state, run, cascade);
  gpu_pass_end(gpu);
}

static void count_casters(maps_state *state, const technique_run *run) {
  for (uint32_t i = 0; i < run->plan->cascade_count; ++i) {
    const plan_cascade *of = &run->plan->cascades[i];
    state->sides[i] = of->resolution;
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
  state->pages_drawn = state->pages_copied = state->pages_valid = 0;
  for (uint32_t i = 0; i < run->plan->cascade_count; ++i) {
    const plan_cascade *of = &run->plan->cascades[i];
    state->pages[i] = (technique_pages){.across = run->plan->pages ? PLAN_CELLS : 0,
                                        .begin = {of->begin_texels[0], of->begin_texels[1]}};
    memcpy(state->pages[i].valid, of->valid, sizeof of->valid);
    state->pages_drawn += count_bits(of->due);
    state->pages_copied += count_bits(of->copied);
    state->pages_valid += count_bits(of->valid);
  }
}

static float clear_depth(const maps_state *state) {
  return state->now.casters.look.reversed ? 0.0f : 1.0f;
}

static void clear(const maps_state *state, const technique_run *run) {
  gpu_clear_depth(run->device->gpu, state->now.image->image, clear_depth(state));
}

static void draw_all(maps_state *state, const technique_run *run) {
  const gpu gpu = run->device->gpu;
  const uint32_t count = run->plan->cascade_count;
  const page_drawing pages = {.run = run,
                              .image = state->now.image,
                              .casters = &state->now.casters,
                              .windows = &state->windows,
                              .copies = &state->copies,
                              .clear_depth = clear_depth(state)};
  pass_timer_begin(&state->timer, run, 1 + count);
  if (run->plan->pages)
    pages_begin(&pages);
  else
    clear(state, run);
  pass_timer_step(&state->timer, run);
  for (uint32_t cascade = 0; cascade < count; ++cascade) {
    char name[32];
    snprintf(name, sizeof name, "cascade %u depth", (unsigned)cascade);
    gpu_marker_begin(gpu, name);
    if (run->plan->pages)
      pages_draw(&pages, cascade);
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
  stats->pages_copied = state->pages_copied;
  stats->map_bytes += map_image_bytes(device, state->now.image);
}

static csm_result find(const void *self, uint32_t source, uint32_t cascade, technique_image *out) {
  const maps_state *state = self;
  if (source != CSM_READ_MAP)
    return CSM_ERROR_UNSUPPORTED;
  if (!state->drawn)
    return CSM_ERROR_INVALID_STATE;
  const map_image *image = state->now.image;
  const plan_rect *rect = &image->layout.rects[cascade];
  *out = (technique_image){
      .image = image->image,
      .format = image->format,
      .width = image->layout.width,
      .height = image->layout.height,
      .layer = rect->layer,
      .pages = state->pages[cascade].across ? &state->pages[cascade] : NULL,
      .cleared = clear_depth(state),
      .part = {.x = rect->x, .y = rect->y, .width = state->sides[cascade], .height = state->sides[cascade]}};
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
    .bytes = bytes,
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
