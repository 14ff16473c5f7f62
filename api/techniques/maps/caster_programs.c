/* caster_programs.c: programs that draw casters, by how a configuration has them drawn and by their vertices. */
#include "device/device.h"

#include "abi/context.h"
#include <string.h>

static bool same_casters(const pass_casters *a, const pass_casters *b) {
  return a->format == b->format && a->reversed == b->reversed && a->clip == b->clip && a->cull == b->cull &&
         a->bias.constant == b->bias.constant && a->bias.slope == b->bias.slope && a->bias.clamp == b->bias.clamp;
}

void caster_programs_remove_shape(device *device, caster_programs *programs, uint32_t shape) {
  for (gpu_cull cull = GPU_CULL_NONE; cull <= GPU_CULL_FRONT; ++cull) {
    device->gpu.api->program_destroy(device->gpu.device, programs->programs[cull][shape]);
    programs->programs[cull][shape] = NULL;
  }
}

csm_result caster_programs_add_shape(device *device, caster_programs *programs, uint32_t shape) {
  csm_result result = CSM_SUCCESS;
  for (gpu_cull cull = GPU_CULL_NONE; cull <= GPU_CULL_FRONT && !result; ++cull)
    result = device_check(device,
                          cascade_depth_program(device->gpu, &programs->casters, cull, device->programs.vertices[shape],
                                                &programs->programs[cull][shape]),
                          "a cascade depth program");
  if (result)
    caster_programs_remove_shape(device, programs, shape);
  return result;
}

static void caster_programs_free(device *device, retired *self) {
  caster_programs *programs = (caster_programs *)self;
  for (uint32_t shape = 0; shape < device->programs.count; ++shape)
    caster_programs_remove_shape(device, programs, shape);
  context_release(device->context, programs);
}

static csm_result make(device *device, const pass_casters *casters, caster_programs **out) {
  caster_programs *programs = context_allocate(device->context, sizeof *programs);
  if (!programs)
    return CSM_ERROR_OUT_OF_MEMORY;
  programs->casters = *casters;
  csm_result result = CSM_SUCCESS;
  for (uint32_t shape = 0; shape < device->programs.count && !result; ++shape)
    result = caster_programs_add_shape(device, programs, shape);
  if (result) {
    caster_programs_free(device, &programs->retired);
    return result;
  }
  programs->next = device->casters;
  device->casters = programs;
  *out = programs;
  return CSM_SUCCESS;
}

csm_result caster_programs_take(device *device, const csm_config *config, caster_programs **out) {
  const pass_casters casters = cascade_depth_casters(config);
  *out = device->casters;
  while (*out && !same_casters(&(*out)->casters, &casters))
    *out = (*out)->next;
  const csm_result result = *out ? CSM_SUCCESS : make(device, &casters, out);
  if (!result)
    ++(*out)->users;
  return result;
}

static void unlink_programs(device *device, const caster_programs *programs) {
  caster_programs **link = &device->casters;
  while (*link != programs)
    link = &(*link)->next;
  *link = programs->next;
}

void caster_programs_give_back(device *device, caster_programs *programs) {
  if (!programs || --programs->users)
    return;
  unlink_programs(device, programs);
  retire(device, &programs->retired, caster_programs_free);
}

void caster_programs_destroy(device *device) {
  while (device->casters) {
    caster_programs *programs = device->casters;
    device->casters = programs->next;
    caster_programs_free(device, &programs->retired);
  }
}
