#include "techniques/moments/image.h"

gpu_format moment_format(const plan_moments *shape, const csm_config *config) {
  static const gpu_format formats[2][3] = {
      {GPU_FORMAT_R32_FLOAT, GPU_FORMAT_RG32_FLOAT, GPU_FORMAT_RGBA32_FLOAT},
      {GPU_FORMAT_R16_FLOAT, GPU_FORMAT_RG16_FLOAT, GPU_FORMAT_RGBA16_FLOAT},
  };
  return formats[config->moment_format == CSM_MOMENTS_FLOAT16][shape->channels / 2];
}

void moment_image_free(device *device, retired *self) {
  moment_image *image = (moment_image *)self;
  for (uint32_t i = 0; i < image->target_count; ++i)
    gpu_target_destroy(device->gpu, image->targets[i]);
  for (uint32_t i = 0; i < image->shape.levels; ++i)
    gpu_view_destroy(device->gpu, image->levels[i]);
  gpu_view_destroy(device->gpu, image->between_view);
  device_image_free(device, image->image);
  device_image_free(device, image->between);
  host_release(device->host, image->targets);
  host_release(device->host, image->memory);
  host_release(device->host, image);
}

/* ---- what it is made of ---- */

static csm_result check_device(const device *device, gpu_format format) {
  const uint32_t needed = GPU_CAN_SAMPLE | GPU_CAN_FILTER | GPU_CAN_STORE | GPU_CAN_DRAW;
  if (!device->info.can.compute)
    return host_fail(device->host, CSM_ERROR_UNSUPPORTED, "filter: the device cannot compute, which moments need");
  if ((device->info.can.formats[format] & needed) != needed)
    return host_fail(device->host, CSM_ERROR_UNSUPPORTED,
                     "filter, moment_format: the device cannot store and filter images of such floats");
  return CSM_SUCCESS;
}

static csm_result make_views(device *device, moment_image *image) {
  csm_result result = CSM_SUCCESS;
  for (uint32_t i = 0; i < image->shape.levels && !result; ++i) {
    const gpu_view_info view = {
        .name = "moments' level", .image = image->image, .range = {.first_level = i, .level_count = 1}};
    result = device_check(device, gpu_view_create(device->gpu, &view, &image->levels[i]), "moments");
  }
  if (image->between && !result)
    result = device_check(device,
                          gpu_view_create(device->gpu,
                                          &(gpu_view_info){.name = "half blurred moments",
                                                           .image = image->between,
                                                           .range = {.layer_count = 1, .level_count = 1}},
                                          &image->between_view),
                          "moments");
  return result;
}

static csm_result make_targets(device *device, moment_image *image) {
  const uint32_t count = image->layers * image->shape.levels;
  csm_result result = CSM_SUCCESS;
  image->targets = host_allocate(device->host, count * sizeof(gpu_target *));
  if (!image->targets)
    return CSM_ERROR_OUT_OF_MEMORY;
  for (uint32_t i = 0; i < count && !result; ++i) {
    const gpu_target_info target = {
        .name = "moments", .color = image->image, .color_layer = i % image->layers, .color_level = i / image->layers};
    result = device_check(device, gpu_target_create(device->gpu, &target, &image->targets[i]), "moments");
    image->target_count += !result;
  }
  return result;
}

static csm_result make_images(device *device, moment_image *image, bool blurs) {
  const gpu_image_info info = {
      .name = "moments",
      .format = image->format,
      .usage = GPU_IMAGE_TARGET | GPU_IMAGE_SAMPLED | GPU_IMAGE_STORED | GPU_IMAGE_COPY_SOURCE,
      .width = image->shape.side,
      .height = image->shape.side,
      .layers = image->layers,
      .levels = image->shape.levels,
      .array = true,
  };
  gpu_image_info between = info;
  between.name = "half blurred moments";
  between.usage = GPU_IMAGE_SAMPLED | GPU_IMAGE_STORED;
  between.layers = between.levels = 1;
  csm_result result = device_image(device, &info, &image->image);
  if (blurs && !result)
    result = device_image(device, &between, &image->between);
  return result;
}

/* Every tile is invalid. */
static csm_result make_tiles(device *device, moment_image *image) {
  uint32_t most = 0;
  for (uint32_t i = 0; i < image->cascades; ++i) {
    image->across[i] = plan_tiles_across(image->shape.sides[i]);
    const uint32_t count = image->across[i] * image->across[i];
    image->tile_count += count;
    most = count > most ? count : most;
  }
  uint8_t *at = image->memory = host_allocate(device->host, 2 * (size_t)image->tile_count + most);
  if (!at)
    return CSM_ERROR_OUT_OF_MEMORY;
  image->spread = at;
  at += most;
  for (uint32_t i = 0; i < image->cascades; ++i) {
    const size_t count = (size_t)image->across[i] * image->across[i];
    image->valid[i] = at;
    image->due[i] = at + count;
    at += 2 * count;
  }
  return CSM_SUCCESS;
}

csm_result moment_image_create(device *device, const csm_config *config, moment_image **out) {
  plan_moments shape;
  plan_moments_make(&shape, config);
  csm_result result = check_device(device, moment_format(&shape, config));
  if (result)
    return result;
  moment_image *image = host_allocate(device->host, sizeof *image);
  if (!image)
    return CSM_ERROR_OUT_OF_MEMORY;
  image->shape = shape;
  image->format = moment_format(&shape, config);
  image->cascades = config->cascade_count;
  image->layers = config->cascade_count * shape.depth_layers;
  result = make_images(device, image, config->moment_blur_texels > 0);
  if (!result)
    result = make_views(device, image);
  if (!result)
    result = make_targets(device, image);
  if (!result)
    result = make_tiles(device, image);
  if (result) {
    moment_image_free(device, &image->retired);
    return result;
  }
  *out = image;
  return CSM_SUCCESS;
}

uint64_t moment_image_bytes(const device *device, const moment_image *image) {
  return gpu_image_bytes(device->gpu, image->image) +
         (image->between ? gpu_image_bytes(device->gpu, image->between) : 0);
}

void moment_image_clear(gpu gpu, const moment_image *image) {
  for (uint32_t i = 0; i < image->target_count; ++i) {
    gpu_pass_begin(gpu, &(gpu_pass_info){.target = image->targets[i], .color_load = GPU_LOAD_CLEAR});
    gpu_pass_end(gpu);
  }
}
