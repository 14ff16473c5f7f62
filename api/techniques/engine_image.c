#include "techniques/engine_image.h"

typedef struct imported_image {
  retired retired;
  gpu_image *image;
} imported_image;

static void imported_free(device *device, retired *self) {
  gpu_image_destroy(device->gpu, ((imported_image *)self)->image);
  host_release(device->host, self);
}

/* A float is off by half of its significand's last place, of which its leading place is 2^(bits - 1) at least. */
static plan_grain rounding_of(const gpu_imported *about) {
  const double places = (double)(1u << about->bits);
  if (about->numbers == GPU_NUMBERS_FLOAT)
    return (plan_grain){.share = 1.0 / places};
  return (plan_grain){.step = about->numbers == GPU_NUMBERS_SNORM ? 1.0 / (places - 2.0) : 0.5 / (places - 1.0)};
}

csm_result engine_image_import(device *device, const engine_image *from, engine_imported *out) {
  *out = (engine_imported){0};
  if (!from->native)
    return CSM_SUCCESS;
  imported_image *imported = host_allocate(device->host, sizeof *imported);
  if (!imported)
    return CSM_ERROR_OUT_OF_MEMORY;
  gpu_imported about = {0};
  const csm_result result = device_check(
      device, gpu_image_import(device->gpu, from->native, from->texels, &imported->image, &about), from->name);
  if (result) {
    host_release(device->host, imported);
    return result;
  }
  retire(device, &imported->retired, imported_free);
  imported->retired.serial = device->prepared.serial;
  if (about.width != from->width || about.height != from->height)
    return host_fail(device->host, CSM_ERROR_INVALID_VALUE, "%s is %u x %u, and the mask %u x %u", from->name,
                     about.width, about.height, from->width, from->height);
  *out = (engine_imported){
      .image = imported->image, .unorm = about.numbers == GPU_NUMBERS_UNORM, .rounding = rounding_of(&about)};
  return CSM_SUCCESS;
}
