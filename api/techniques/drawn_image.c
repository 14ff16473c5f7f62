#include "techniques/drawn_image.h"

static void drawn_image_free(device *device, retired *self) {
  drawn_image *image = (drawn_image *)self;
  gpu_view_destroy(device->gpu, image->stores);
  gpu_target_destroy(device->gpu, image->target);
  device_image_free(device, image->image);
  host_release(device->host, image);
}

static bool fits(const drawn_image *image, const gpu_image_info *wanted) {
  return image && image->width == wanted->width && image->height == wanted->height && image->format == wanted->format &&
         (image->stores || !(wanted->usage & GPU_IMAGE_STORED));
}

static csm_result make_stores(device *device, const gpu_image_info *wanted, drawn_image *image) {
  const gpu_view_info view = {
      .name = wanted->name, .image = image->image, .range = {.layer_count = 1, .level_count = 1}};
  return wanted->usage & GPU_IMAGE_STORED
             ? device_check(device, gpu_view_create(device->gpu, &view, &image->stores), wanted->name)
             : CSM_SUCCESS;
}

csm_result drawn_image_reserve(drawn_images *images, device *device, const gpu_image_info *wanted) {
  if (fits(images->now, wanted))
    return CSM_SUCCESS;
  drawn_image *fresh = host_allocate(device->host, sizeof *fresh);
  if (!fresh)
    return CSM_ERROR_OUT_OF_MEMORY;
  *fresh = (drawn_image){.format = wanted->format, .width = wanted->width, .height = wanted->height};
  csm_result result = device_drawn_image(device, wanted, &fresh->image, &fresh->target);
  if (!result)
    result = make_stores(device, wanted, fresh);
  if (result) {
    drawn_image_free(device, &fresh->retired);
    return result;
  }
  images->fresh = fresh;
  return CSM_SUCCESS;
}

drawn_image *drawn_image_next(const drawn_images *images) {
  return images->fresh ? images->fresh : images->now;
}

void drawn_image_drop(drawn_images *images, device *device) {
  if (images->now)
    retire(device, &images->now->retired, drawn_image_free);
  images->now = NULL;
}

void drawn_image_adopt(drawn_images *images, device *device) {
  if (!images->fresh)
    return;
  drawn_image_drop(images, device);
  images->now = images->fresh;
  images->fresh = NULL;
}

void drawn_image_forget(drawn_images *images, device *device) {
  if (images->fresh)
    drawn_image_free(device, &images->fresh->retired);
  images->fresh = NULL;
}

uint64_t drawn_image_bytes(const drawn_images *images, const device *device) {
  return images->now ? gpu_image_bytes(device->gpu, images->now->image) : 0;
}

void drawn_image_bind(const drawn_images *images, device *device, csm_binding *binding) {
  const drawn_image *mask = images->now;
  gpu_native_image native;
  if (!mask || !mask->drawn)
    return;
  gpu_image_native(device->gpu, mask->image, &native);
  binding->native_mask = native.image;
  binding->native_mask_view = native.view;
  if (binding->mask_descriptor)
    gpu_image_describe(device->gpu, mask->image, binding->mask_descriptor);
}

csm_result drawn_image_find(const drawn_images *images, technique_image *out) {
  const drawn_image *image = images->now;
  if (!image || !image->drawn)
    return CSM_ERROR_INVALID_STATE;
  *out = (technique_image){.image = image->image,
                           .format = image->format,
                           .width = image->width,
                           .height = image->height,
                           .part = {.width = image->width, .height = image->height}};
  return CSM_SUCCESS;
}
