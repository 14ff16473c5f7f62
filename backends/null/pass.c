/* pass.c: what a recording holds in passes. */
#include "null.h"

#include <stdio.h>

/* ---- the target ---- */

static gpu_range one(uint32_t layer, uint32_t level) {
  return (gpu_range){.first_layer = layer, .layer_count = 1, .first_level = level, .level_count = 1};
}

static bool is_target(const gpu_device *device, const gpu_image *image, const gpu_range *range) {
  const gpu_target_info *target = &device->pass.target->info;
  const gpu_range depth = one(target->depth_layer, target->depth_level);
  const gpu_range color = one(target->color_layer, target->color_level);
  return (image == target->depth && null_overlap(range, &depth)) ||
         (image == target->color && null_overlap(range, &color));
}

static bool lies_in(const gpu_rect *area, const gpu_rect *part) {
  return part->width && part->height && part->x >= area->x && part->y >= area->y &&
         null_spans(area->width, part->x - area->x, part->width) &&
         null_spans(area->height, part->y - area->y, part->height);
}

static void load(gpu_device *device, gpu_image *image, null_piece *piece, gpu_load op, bool whole) {
  null_require(device, op != GPU_LOAD_KEEP || piece->defined,
               "pass_begin: it keeps what was never written, or was discarded");
  null_touch(device, image);
  piece->use = NULL_TARGET;
  if (op == GPU_LOAD_CLEAR)
    piece->defined = true;
  else if (op == GPU_LOAD_DISCARD && whole)
    piece->defined = false;
}

/* What draws, and what an engine draws itself, leave in the target. */
static void drawn(gpu_device *device) {
  const gpu_target_info *target = &device->pass.target->info;
  if (target->depth)
    null_piece_at(target->depth, target->depth_layer, target->depth_level)->defined = true;
  if (target->color)
    null_piece_at(target->color, target->color_layer, target->color_level)->defined = true;
}

/* ---- what draws store ---- */

static void begin_stores(gpu_device *device, const gpu_bindings *stores) {
  for (uint32_t i = 0; i < stores->info.program->info.store_image_count; i++) {
    const gpu_view *view = stores->info.store_images[i];
    null_require(device, !is_target(device, view->image, &view->range), "pass_begin: it stores to its target");
    null_touch(device, view->image);
    for (uint32_t layer = 0; layer < view->range.layer_count; layer++) {
      null_piece *piece = null_piece_at(view->image, view->range.first_layer + layer, view->range.first_level);
      *piece = (null_piece){.use = NULL_STORED, .defined = true};
    }
  }
}

static bool stores_image(const gpu_bindings *stores, const gpu_view *view) {
  for (uint32_t i = 0; stores && i < stores->info.program->info.store_image_count; i++)
    if (stores->info.store_images[i]->image == view->image &&
        null_overlap(&stores->info.store_images[i]->range, &view->range))
      return true;
  return false;
}

static bool stores_buffer(const gpu_bindings *stores, const gpu_buffer *buffer) {
  for (uint32_t i = 0; stores && buffer && i < stores->info.program->info.store_buffer_count; i++)
    if (stores->info.store_buffers[i].buffer == buffer)
      return true;
  return false;
}

/* ---- beginning and ending ---- */

static void record_begin(gpu_device *device, const gpu_pass_info *info) {
  static const char *const loads[] = {[GPU_LOAD_KEEP] = "keep", [GPU_LOAD_DISCARD] = "discard"};
  char depth[32] = "", color[128] = "", area[64] = "", space[64] = "";
  if (info->target->info.depth && info->depth_load == GPU_LOAD_CLEAR)
    snprintf(depth, sizeof depth, " depth %g", (double)info->clear_depth);
  else if (info->target->info.depth)
    snprintf(depth, sizeof depth, " depth %s", loads[info->depth_load]);
  const float *c = info->clear_color;
  if (info->target->info.color && info->color_load == GPU_LOAD_CLEAR)
    snprintf(color, sizeof color, " colour %g %g %g %g", (double)c[0], (double)c[1], (double)c[2], (double)c[3]);
  else if (info->target->info.color)
    snprintf(color, sizeof color, " colour %s", loads[info->color_load]);
  if (info->area.width)
    snprintf(area, sizeof area, " area %u %u %u %u", info->area.x, info->area.y, info->area.width, info->area.height);
  const gpu_rect *of = &info->clip_space;
  if (of->width)
    snprintf(space, sizeof space, " clip %u %u %u %u", of->x, of->y, of->width, of->height);
  null_record(device, "pass_begin %s%s%s%s%s", info->target->name, depth, color, area, space);
}

void null_pass_begin(gpu_device *device, const gpu_pass_info *info) {
  const gpu_target *target = info->target;
  const gpu_target_info *on = &target->info;
  const gpu_rect all = {.width = target->width, .height = target->height};
  const bool given = info->area.x || info->area.y || info->area.width || info->area.height;
  record_begin(device, info);
  null_require(device, device->recording && !device->in_pass, "pass_begin: not between begin and end, or in a pass");
  null_use_now(device, &info->target->used);
  device->in_pass = true;
  device->pass = *info;
  device->area = given ? info->area : all;
  device->program = NULL;
  device->bound = false;
  null_require(device, lies_in(&all, &device->area), "pass_begin: beyond the target, or empty");
  if (info->clip_space.width)
    null_require(device, lies_in(&all, &info->clip_space) && lies_in(&info->clip_space, &device->area),
                 "pass_begin: clip space leaves out a part of the area, or lies beyond the target");
  const bool whole = device->area.width == all.width && device->area.height == all.height;
  if (on->depth)
    load(device, on->depth, null_piece_at(on->depth, on->depth_layer, on->depth_level), info->depth_load, whole);
  if (on->color)
    load(device, on->color, null_piece_at(on->color, on->color_layer, on->color_level), info->color_load, whole);
  if (info->stores)
    begin_stores(device, info->stores);
}

void null_pass_area(gpu_device *device, const gpu_rect *area) {
  null_record(device, "area %u %u %u %u", area->x, area->y, area->width, area->height);
  if (null_require(device, device->in_pass, "pass_area: no pass is open"))
    null_require(device, lies_in(&device->area, area), "pass_area: beyond the pass's area, or empty");
}

void null_pass_end(gpu_device *device) {
  null_record(device, "pass_end");
  null_require(device, device->in_pass, "pass_end: no pass is open");
  device->in_pass = false;
}

/* ---- programs and bindings ---- */

void null_pass_program(gpu_device *device, gpu_program *program) {
  null_record(device, "program %s", program->name);
  null_use_now(device, &program->used);
  device->program = program;
  device->bound = false;
  if (!null_require(device, device->in_pass, "pass_program: no pass is open"))
    return;
  const gpu_target_info *on = &device->pass.target->info;
  const gpu_format depth = on->depth ? on->depth->info.format : GPU_FORMAT_NONE;
  const gpu_format color = on->color ? on->color->info.format : GPU_FORMAT_NONE;
  null_require(device, !program->info.compute.spirv_size, "pass_program: the program computes");
  null_require(device, program->info.depth_format == depth && program->info.color_format == color,
               "pass_program: made for targets of other formats");
}

static void check_texture(gpu_device *device, const gpu_view *view) {
  bool defined = true, readable = true;
  const gpu_range *range = &view->range;
  for (uint32_t layer = range->first_layer; layer < range->first_layer + range->layer_count; layer++)
    for (uint32_t level = range->first_level; level < range->first_level + range->level_count; level++) {
      const null_piece *piece = null_piece_at(view->image, layer, level);
      defined &= piece->defined;
      readable &= piece->use == NULL_READABLE;
    }
  if (!null_require(device, !is_target(device, view->image, range), "pass_bind: a texture is the pass's target"))
    return;
  if (null_require(device, defined, "pass_bind: a texture was never written, or was discarded"))
    null_require(device, readable, "pass_bind: a texture is not readable: make_readable goes before the pass");
}

static void check_stores(gpu_device *device, const gpu_bindings *bindings) {
  const gpu_bindings_info *info = &bindings->info;
  const gpu_program_info *program = &info->program->info;
  for (uint32_t i = 0; i < program->store_image_count; i++)
    null_require(device, stores_image(device->pass.stores, info->store_images[i]),
                 "pass_bind: it stores to what pass_begin was not told of");
  for (uint32_t i = 0; i < program->store_buffer_count; i++)
    null_require(device, stores_buffer(device->pass.stores, info->store_buffers[i].buffer),
                 "pass_bind: it stores to what pass_begin was not told of");
  for (uint32_t i = 0; i < program->buffer_count; i++)
    null_require(device, !stores_buffer(device->pass.stores, info->buffers[i].buffer),
                 "pass_bind: it reads a buffer that the pass stores to");
  for (uint32_t i = 0; i < program->texel_buffer_count; i++)
    null_require(device, !stores_buffer(device->pass.stores, info->texel_buffers[i]),
                 "pass_bind: it reads a buffer that the pass stores to");
}

void null_pass_bind(gpu_device *device, gpu_bindings *bindings, const uint32_t *offsets) {
  null_record(device, "bind %s", bindings->name);
  device->bound = true;
  if (!null_require(device,
                    device->in_pass && device->program && null_same_shape(bindings->info.program, device->program),
                    "pass_bind: no pass is open, or bindings of a program of another shape"))
    return;
  null_use_bindings(device, bindings);
  null_check_offsets(device, bindings, offsets);
  for (uint32_t i = 0; i < device->program->info.texture_count; i++) {
    const gpu_view view = null_texture(bindings, i);
    check_texture(device, &view);
  }
  check_stores(device, bindings);
}

/* ---- draws ---- */

static void use_source(gpu_device *device, gpu_buffer *buffer) {
  null_use_now(device, &buffer->used);
  null_require(device, buffer->info.kind != GPU_BUFFER_READBACK, "pass_draw: from a readback buffer");
  null_require(device, !stores_buffer(device->pass.stores, buffer),
               "pass_draw: it reads a buffer that the pass stores to");
}

static void check_indices(gpu_device *device, const gpu_draw *draw) {
  use_source(device, draw->indices);
  if (!null_require(device, draw->index_size == 2 || draw->index_size == 4, "pass_draw: index_size is not 2 or 4"))
    return;
  null_require(device, draw->index_offset % draw->index_size == 0,
               "pass_draw: index_offset is not a multiple of index_size");
  null_require(device, null_holds(draw->indices, draw->index_offset, (uint64_t)draw->count * draw->index_size),
               "pass_draw: indices beyond the buffer's end");
}

static void check_counts(gpu_device *device, const gpu_draw *draw) {
  if (!draw->arguments) {
    null_require(device, draw->count > 0 && draw->instance_count > 0, "pass_draw: draws nothing");
    return;
  }
  const size_t bytes = draw->indices ? sizeof(gpu_indirect_indexed) : sizeof(gpu_indirect_draw);
  use_source(device, draw->arguments);
  null_require(device, !draw->index_offset, "pass_draw: arguments beside an index_offset");
  null_check_arguments(device, draw->arguments, draw->arguments_offset, (uint32_t)(bytes / sizeof(uint32_t)),
                       "pass_draw: no arguments, or beyond their end");
}

static void check_draw(gpu_device *device, const gpu_draw *draw) {
  const gpu_program_info *program = &device->program->info;
  const bool needs = program->constants_count + program->texture_count + program->buffer_count +
                     program->texel_buffer_count + program->store_image_count + program->store_buffer_count;
  null_require(device, device->bound || !needs, "pass_draw: nothing is bound");
  check_counts(device, draw);
  if (draw->indices)
    check_indices(device, draw);
  for (uint32_t i = 0; i < program->stream_count; i++) {
    const uint32_t elements = program->streams[i].per_instance && !draw->arguments ? draw->instance_count : 1;
    if (null_require(
            device,
            null_holds(draw->streams[i], draw->stream_offsets[i], (uint64_t)elements * program->streams[i].stride) &&
                draw->stream_offsets[i] % 4 == 0,
            "pass_draw: a stream is missing, ends too early, or begins at no multiple of 4"))
      use_source(device, draw->streams[i]);
  }
}

void null_pass_draw(gpu_device *device, const gpu_draw *draw) {
  if (draw->arguments)
    null_record(device, "draw indirect %s", draw->arguments->name);
  else
    null_record(device, "draw count=%u instances=%u", draw->count, draw->instance_count);
  if (!null_require(device, device->in_pass && device->program, "pass_draw: no pass is open, or no program is set"))
    return;
  check_draw(device, draw);
  drawn(device);
}

void null_pass_native(gpu_device *device, gpu_native_pass *out) {
  *out = (gpu_native_pass){0};
  if (null_require(device, device->in_pass, "pass_native: no pass is open"))
    drawn(device);
}
