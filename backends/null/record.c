/* record.c: recordings, and what they hold outside passes. */
#include "null.h"

#include <string.h>

enum { MAX_GROUPS = 65535 };

static bool outside(gpu_device *device, const char *rule) {
  return null_require(device, device->recording && !device->in_pass, rule);
}

void null_touch(gpu_device *device, gpu_image *image) {
  null_use_now(device, &image->used);
  if (image->touched)
    return;
  image->touched = true;
  image->next_touched = device->touched;
  device->touched = image;
}

static void use_buffers(const gpu_device *device, const gpu_buffer_part *parts, uint32_t count) {
  for (uint32_t i = 0; i < count; i++)
    null_use_now(device, &parts[i].buffer->used);
}

void null_use_bindings(const gpu_device *device, gpu_bindings *bindings) {
  const gpu_bindings_info *info = &bindings->info;
  const gpu_program_info *program = &info->program->info;
  null_use_now(device, &bindings->used);
  for (uint32_t i = 0; i < program->constants_count; i++)
    null_use_now(device, &info->constants[i]->used);
  for (uint32_t i = 0; i < program->texture_count; i++) {
    null_use_now(device, &null_texture(bindings, i).image->used);
    if (info->texture_views[i])
      null_use_now(device, &info->texture_views[i]->used);
  }
  for (uint32_t i = 0; i < program->store_image_count; i++)
    null_use_now(device, &info->store_images[i]->used);
  use_buffers(device, info->buffers, program->buffer_count);
  for (uint32_t i = 0; i < program->texel_buffer_count; i++)
    null_use_now(device, &info->texel_buffers[i]->used);
  use_buffers(device, info->store_buffers, program->store_buffer_count);
}

/* Takes a range into a use. `write`: it holds something from now on; else a breach is told if it does not. */
static void use_range(gpu_device *device, gpu_image *image, const gpu_range *range, null_use use, bool write,
                      const char *rule) {
  bool defined = true;
  null_touch(device, image);
  for (uint32_t layer = range->first_layer; layer < range->first_layer + range->layer_count; layer++)
    for (uint32_t level = range->first_level; level < range->first_level + range->level_count; level++) {
      null_piece *piece = null_piece_at(image, layer, level);
      piece->defined |= write;
      piece->use = use;
      defined &= piece->defined;
    }
  null_require(device, defined, rule);
}

/* ---- a recording ---- */

csm_result null_begin(gpu_device *device, const gpu_record_info *info) {
  null_require(device, !device->recording && !info->native,
               "begin: already recording, or into an engine's command buffer");
  null_record(device, "begin %u%s", info->slot, info->first ? "" : ", again");
  device->recording = true;
  device->slot = null_require(device, info->slot < device->slot_count, "begin: no such slot") ? info->slot : 0;
  device->serial++;
  null_slot *slot = &device->slots[device->slot];
  slot->in_flight = 0;
  if (info->first)
    slot->taken = 0;
  return CSM_SUCCESS;
}

csm_result null_end(gpu_device *device) {
  null_record(device, "end");
  outside(device, "end: not recording, or a pass is open");
  null_require(device, !device->open_markers, "end: a marker is open");
  device->open_markers = 0;
  device->recording = false;
  device->slots[device->slot].in_flight = device->serial;
  for (gpu_image *image = device->touched; image; image = image->next_touched) {
    image->touched = false;
    for (uint32_t i = 0; i < image->info.layers * null_levels(image); i++)
      image->pieces[i].use = image->info.usage & GPU_IMAGE_SAMPLED ? NULL_READABLE : image->pieces[i].use;
  }
  device->touched = NULL;
  return CSM_SUCCESS;
}

csm_result null_wait(gpu_device *device, uint32_t slot) {
  null_record(device, "wait %u", slot);
  if (null_require(device, slot < device->slot_count, "wait: no such slot"))
    device->slots[slot].in_flight = 0;
  return CSM_SUCCESS;
}

/* ---- timestamps and markers ---- */

/* A millisecond from each to the next. */
csm_result null_timestamps(gpu_device *device, uint32_t slot, uint32_t first, uint32_t count, uint64_t *nanoseconds) {
  null_require(device, slot < device->slot_count, "timestamps: no such slot");
  for (uint32_t i = 0; i < count; i++) {
    const bool taken =
        slot < device->slot_count && first + i < GPU_MAX_TIMESTAMPS && (device->slots[slot].taken >> (first + i) & 1);
    null_require(device, taken, "timestamps: one was not taken");
    nanoseconds[i] = (first + i) * 1000000ull;
  }
  return CSM_SUCCESS;
}

void null_marker_begin(gpu_device *device, const char *name) {
  null_record(device, "marker_begin %s", name);
  outside(device, "marker_begin: not between begin and end, or in a pass");
  device->open_markers++;
}

void null_marker_end(gpu_device *device) {
  null_record(device, "marker_end");
  outside(device, "marker_end: not between begin and end, or in a pass");
  if (null_require(device, device->open_markers, "marker_end: no marker is open"))
    device->open_markers--;
}

void null_timestamp(gpu_device *device, uint32_t index) {
  null_record(device, "timestamp %u", index);
  outside(device, "timestamp: not between begin and end, or in a pass");
  if (!null_require(device, index < GPU_MAX_TIMESTAMPS, "timestamp: no such index"))
    return;
  uint64_t *taken = &device->slots[device->slot].taken;
  null_require(device, !(*taken >> index & 1), "timestamp: taken before in this frame");
  *taken |= 1ull << index;
}

/* ---- copies and clears ---- */

void null_copy_buffer(gpu_device *device, gpu_buffer *to, uint64_t to_offset, gpu_buffer *from, uint64_t from_offset,
                      uint64_t size) {
  null_record(device, "copy_buffer %s %llu %s %llu %llu", to->name, (unsigned long long)to_offset, from->name,
              (unsigned long long)from_offset, (unsigned long long)size);
  outside(device, "copy_buffer: not between begin and end, or in a pass");
  null_use_now(device, &to->used);
  null_use_now(device, &from->used);
  null_require(device, to != from, "copy_buffer: from a buffer to itself");
  null_require(device, to->info.kind != GPU_BUFFER_UPLOAD && from->info.kind != GPU_BUFFER_READBACK,
               "copy_buffer: to an upload buffer, or from a readback buffer");
  const bool fits = size > 0 && null_holds(to, to_offset, size) && null_holds(from, from_offset, size);
  null_require(device, fits, "copy_buffer: beyond a buffer's end, or empty");
  if (fits)
    memmove(to->memory + to_offset, from->memory + from_offset, size);
}

/* A copy between a buffer and a region of an image. */
typedef struct image_copy {
  gpu_image *image;
  const gpu_region *region;
  gpu_buffer *buffer;
  uint64_t offset;
  uint32_t row_bytes;
  bool out; /* of the image */
} image_copy;

/* Of a depth image a whole {layer, level}, of any other a piece of one. */
static bool check_region(gpu_device *device, const image_copy *copy) {
  const gpu_image_info *info = &copy->image->info;
  const gpu_region *region = copy->region;
  const bool out = copy->out, there = region->layer < info->layers && region->level < null_levels(copy->image);
  if (!null_require(device, there,
                    out ? "copy_image: no such layer or level" : "copy_to_image: no such layer or level"))
    return false;
  const uint32_t width = gpu_level_size(info->width, region->level),
                 height = gpu_level_size(info->height, region->level);
  null_require(device, null_spans(width, region->x, region->width) && null_spans(height, region->y, region->height),
               out ? "copy_image: beyond the image, or empty" : "copy_to_image: beyond the image, or empty");
  null_require(device, !gpu_format_is_depth(info->format) || (region->width == width && region->height == height),
               "copy_image: a part of a layer of depths");
  null_require(device, info->usage & (out ? GPU_IMAGE_COPY_SOURCE : GPU_IMAGE_COPY_TARGET),
               out ? "copy_image: the image is not made to be copied"
                   : "copy_to_image: the image is not made to be copied to");
  return true;
}

/* The bytes that the rows take. */
static uint64_t check_rows(gpu_device *device, const image_copy *copy) {
  const gpu_region *region = copy->region;
  const bool out = copy->out;
  null_require(device, copy->offset % NULL_PLACEMENT_ALIGNMENT == 0,
               out ? "copy_image: offset is not a multiple of 512" : "copy_to_image: offset is not a multiple of 512");
  null_require(device, copy->row_bytes % NULL_OFFSET_ALIGNMENT == 0,
               out ? "copy_image: row_bytes is not a multiple of 256"
                   : "copy_to_image: row_bytes is not a multiple of 256");
  const uint64_t used = (uint64_t)region->width * gpu_format_bytes(copy->image->info.format);
  const uint64_t size = region->height ? (uint64_t)copy->row_bytes * (region->height - 1) + used : 0;
  const bool fits = used <= copy->row_bytes && null_holds(copy->buffer, copy->offset, size);
  null_require(device, fits,
               out ? "copy_image: beyond a row's or the buffer's end"
                   : "copy_to_image: beyond a row's or the buffer's end");
  return fits ? size : 0;
}

static gpu_range range_of(const gpu_region *region) {
  return (gpu_range){.first_layer = region->layer, .layer_count = 1, .first_level = region->level, .level_count = 1};
}

void null_copy_image(gpu_device *device, gpu_buffer *to, uint64_t offset, uint32_t row_bytes, gpu_image *image,
                     const gpu_region *from) {
  const image_copy copy = {image, from, to, offset, row_bytes, true};
  null_record(device, "copy_image %s %llu %u %s %u %u %u %u %u %u", to->name, (unsigned long long)offset, row_bytes,
              image->name, from->layer, from->level, from->x, from->y, from->width, from->height);
  outside(device, "copy_image: not between begin and end, or in a pass");
  null_use_now(device, &to->used);
  null_require(device, to->info.kind == GPU_BUFFER_READBACK, "copy_image: to no readback buffer");
  const bool there = check_region(device, &copy);
  memset(to->memory + (there ? offset : 0), 0, there ? check_rows(device, &copy) : 0);
  const gpu_range range = range_of(from);
  if (there)
    use_range(device, image, &range, NULL_COPIED, false, "copy_image: what was never written, or was discarded");
}

void null_copy_to_image(gpu_device *device, gpu_image *image, const gpu_region *to, gpu_buffer *from, uint64_t offset,
                        uint32_t row_bytes) {
  const image_copy copy = {image, to, from, offset, row_bytes, false};
  null_record(device, "copy_to_image %s %u %u %u %u %u %u %s %llu %u", image->name, to->layer, to->level, to->x, to->y,
              to->width, to->height, from->name, (unsigned long long)offset, row_bytes);
  outside(device, "copy_to_image: not between begin and end, or in a pass");
  null_use_now(device, &from->used);
  null_require(device, from->info.kind == GPU_BUFFER_UPLOAD, "copy_to_image: from no upload buffer");
  if (!check_region(device, &copy))
    return;
  check_rows(device, &copy);
  const gpu_range range = range_of(to);
  use_range(device, image, &range, NULL_COPIED, true, "");
}

void null_clear_depth(gpu_device *device, gpu_image *image, float depth) {
  null_record(device, "clear_depth %s %g", image->name, (double)depth);
  outside(device, "clear_depth: not between begin and end, or in a pass");
  null_require(device, gpu_format_is_depth(image->info.format), "clear_depth: the image has no depths");
  null_require(device, image->info.usage & GPU_IMAGE_TARGET, "clear_depth: the image is no target");
  const gpu_range all = null_range(image, NULL);
  use_range(device, image, &all, NULL_TARGET, true, "");
}

void null_make_readable(gpu_device *device, gpu_image *image, const gpu_range *range) {
  const gpu_range all = null_range(image, range);
  null_record(device, "make_readable %s", image->name);
  outside(device, "make_readable: not between begin and end, or in a pass");
  null_require(device, image->info.usage & GPU_IMAGE_SAMPLED, "make_readable: the image is not made to be sampled");
  const bool there = null_spans(image->info.layers, all.first_layer, all.layer_count) &&
                     null_spans(null_levels(image), all.first_level, all.level_count);
  if (!null_require(device, there, "make_readable: no such layers or levels"))
    return;
  null_touch(device, image);
  for (uint32_t layer = all.first_layer; layer < all.first_layer + all.layer_count; layer++)
    for (uint32_t level = all.first_level; level < all.first_level + all.level_count; level++)
      null_piece_at(image, layer, level)->use = NULL_READABLE;
}

/* ---- dispatches ---- */

void null_check_arguments(gpu_device *device, const gpu_buffer *buffer, uint64_t offset, uint32_t words,
                          const char *rule) {
  null_require(device,
               (buffer->info.usage & GPU_BUFFER_INDIRECT) && offset % 4 == 0 &&
                   null_holds(buffer, offset, words * sizeof(uint32_t)),
               rule);
}

void null_check_offsets(gpu_device *device, const gpu_bindings *bindings, const uint32_t *offsets) {
  const gpu_program_info *program = &bindings->info.program->info;
  for (uint32_t i = 0; i < program->constants_count; i++) {
    null_require(device, offsets[i] % NULL_OFFSET_ALIGNMENT == 0, "constants: an offset is not a multiple of 256");
    null_require(device, null_holds(bindings->info.constants[i], offsets[i], program->constants_sizes[i]),
                 "constants: beyond the buffer's end");
  }
}

static void check_groups(gpu_device *device, const gpu_dispatch_info *info) {
  if (info->arguments) {
    null_check_arguments(device, info->arguments, info->arguments_offset,
                         sizeof(gpu_indirect_dispatch) / sizeof(uint32_t),
                         "dispatch: no arguments, or beyond their end");
    return;
  }
  for (uint32_t i = 0; i < 3; i++)
    null_require(device, info->groups[i] > 0 && info->groups[i] <= MAX_GROUPS, "dispatch: no groups, or over 65535");
}

static void use_bindings(gpu_device *device, const gpu_bindings *bindings, const gpu_buffer *arguments) {
  const gpu_program_info *program = &bindings->info.program->info;
  for (uint32_t i = 0; i < program->texture_count; i++) {
    const gpu_view view = null_texture(bindings, i);
    use_range(device, view.image, &view.range, NULL_READABLE, false,
              "dispatch: a texture was never written, or was discarded");
  }
  for (uint32_t i = 0; i < program->store_image_count; i++) {
    const gpu_view *view = bindings->info.store_images[i];
    use_range(device, view->image, &view->range, NULL_STORED, true, "");
  }
  for (uint32_t i = 0; i < program->store_buffer_count; i++)
    null_require(device, bindings->info.store_buffers[i].buffer != arguments, "dispatch: it writes its own arguments");
}

void null_dispatch(gpu_device *device, const gpu_dispatch_info *info) {
  const gpu_program_info *program = &info->program->info;
  if (info->arguments)
    null_record(device, "dispatch %s indirect %s", info->program->name, info->arguments->name);
  else
    null_record(device, "dispatch %s %u %u %u", info->program->name, info->groups[0], info->groups[1], info->groups[2]);
  outside(device, "dispatch: not between begin and end, or in a pass");
  null_use_now(device, &info->program->used);
  if (info->arguments)
    null_use_now(device, &info->arguments->used);
  null_require(device, program->compute.spirv_size, "dispatch: the program draws");
  check_groups(device, info);
  const bool needs = program->constants_count + program->texture_count + program->buffer_count +
                     program->texel_buffer_count + program->store_image_count + program->store_buffer_count;
  if (!info->bindings) {
    null_require(device, !needs, "dispatch: nothing is bound");
    return;
  }
  if (!null_require(device, null_same_shape(info->bindings->info.program, info->program),
                    "dispatch: bindings of a program of another shape"))
    return;
  null_use_bindings(device, info->bindings);
  null_check_offsets(device, info->bindings, info->offsets);
  use_bindings(device, info->bindings, info->arguments);
}
