#include "techniques/maps/map_image.h"

#include "shader_code.h"
#include "techniques/maps/pages.h"

static void free_layers(device *device, gpu_image *image, gpu_target *targets[CSM_MAX_CASCADES], uint32_t layers) {
  for (uint32_t i = 0; i < layers; ++i) {
    gpu_target_destroy(device->gpu, targets[i]);
    targets[i] = NULL;
  }
  device_image_free(device, image);
}

/* An image, and a target of each of its layers. After an error there may be some of them. */
static csm_result make_layers(device *device, const map_image *like, const char *name, gpu_image **image,
                              gpu_target *targets[CSM_MAX_CASCADES]) {
  const gpu_image_info info = {
      .name = name,
      .format = like->format,
      .usage = GPU_IMAGE_TARGET | GPU_IMAGE_SAMPLED | GPU_IMAGE_COPY_SOURCE,
      .width = like->layout.width,
      .height = like->layout.height,
      .layers = like->layout.layers,
      .array = true,
  };
  csm_result result = device_image(device, &info, image);
  for (uint32_t i = 0; i < like->layout.layers && !result; ++i) {
    const gpu_target_info target = {.name = name, .depth = *image, .depth_layer = i};
    result = device_check(device, gpu_target_create(device->gpu, &target, &targets[i]), "a cascade's target");
  }
  return result;
}

static void free_second(device *device, map_image *image) {
  map_second *second = &image->second;
  gpu_bindings_destroy(device->gpu, second->from_maps);
  gpu_bindings_destroy(device->gpu, second->from_here);
  free_layers(device, second->image, second->targets, image->layout.layers);
  *second = (map_second){0};
}

void map_image_free(device *device, retired *self) {
  map_image *image = (map_image *)self;
  free_second(device, image);
  free_layers(device, image->image, image->targets, image->layout.layers);
  host_release(device->host, image);
}

csm_result map_image_create(device *device, const plan_layout *layout, gpu_format format, map_image **out) {
  map_image *image = host_allocate(device->host, sizeof *image);
  if (!image)
    return CSM_ERROR_OUT_OF_MEMORY;
  image->layout = *layout;
  image->format = format;
  const csm_result result = make_layers(device, image, "cascade maps", &image->image, image->targets);
  if (result) {
    map_image_free(device, &image->retired);
    return result;
  }
  *out = image;
  return CSM_SUCCESS;
}

static csm_result make_program(gpu gpu, const void *about, gpu_program **out) {
  const uint32_t *format = about;
  const gpu_program_info info = {
      .name = "pages, copied",
      .vertex = shader_copy_pages_vs,
      .pixel = shader_copy_pages_ps,
      .stream_count = 1,
      .streams = {{.stride = sizeof(page_rect), .per_instance = true}},
      .attribute_count = 2,
      .attributes = {{.format = GPU_FORMAT_RGBA32_FLOAT, .offset = offsetof(page_rect, corners)},
                     {.format = GPU_FORMAT_R32_FLOAT, .offset = offsetof(page_rect, layer)}},
      .texture_count = 1,
      .depth_format = (gpu_format)*format,
      .depth_compare = GPU_COMPARE_ALWAYS,
      .cull = GPU_CULL_NONE,
  };
  return gpu_program_create(gpu, &info, out);
}

static csm_result make_bindings(device *device, const map_image *image, gpu_image *from, gpu_bindings **out) {
  const gpu_bindings_info info = {.name = "pages, copied", .program = image->second.copy, .textures = {from}};
  return device_check(device, gpu_bindings_create(device->gpu, &info, out), "what pages are copied from");
}

csm_result map_image_extend(device *device, map_image *image) {
  map_second *second = &image->second;
  const uint32_t format = image->format;
  const program_key key = {.make = make_program, .name = "a program of pages", .about = &format, .size = sizeof format};
  if (second->image)
    return CSM_SUCCESS;
  csm_result result = programs_find(device, &key, &second->copy);
  if (!result)
    result = make_layers(device, image, "cascade maps of what stands still", &second->image, second->targets);
  if (!result)
    result = make_bindings(device, image, image->image, &second->from_maps);
  if (!result)
    result = make_bindings(device, image, second->image, &second->from_here);
  if (result)
    free_second(device, image);
  return result;
}

uint64_t map_image_bytes(const device *device, const map_image *image) {
  const uint64_t bytes = gpu_image_bytes(device->gpu, image->image);
  return image->second.image ? bytes + gpu_image_bytes(device->gpu, image->second.image) : bytes;
}
