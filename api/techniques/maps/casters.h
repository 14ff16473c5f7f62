/* casters.h: programs that draw casters, as a configuration has them drawn. */
#ifndef TECHNIQUES_CASTERS_H
#define TECHNIQUES_CASTERS_H

#include "device/device.h"

enum { CASTER_ROWS = 3 }; /* float4 rows for each instance's matrix */

/* How casters are drawn, but for their shape. */
typedef struct caster_look {
  gpu_format format;
  bool reversed, clip;
  gpu_cull cull;
  gpu_raster_bias bias;
} caster_look;

caster_look caster_look_of(const csm_config *config);

/* The programs for a look: by gpu_cull, as two-sided, watertight and mirrored meshes need them, then by shape. */
typedef struct caster_programs {
  caster_look look;
  uint32_t shapes; /* that there are programs for */
  gpu_program *programs[3][DEVICE_MAX_SHAPES];
} caster_programs;

/* Takes the programs for all shapes of the device that it has none for. After an error it has those that it had. */
csm_result caster_programs_extend(device *device, caster_programs *programs);
void caster_programs_give_back(device *device, caster_programs *programs);

#endif
