/* passes.h: the programs that make moments, and the dispatches of a frame: converted, blurred, and brought down to levels. */
#ifndef TECHNIQUES_MOMENTS_PASSES_H
#define TECHNIQUES_MOMENTS_PASSES_H

#include "techniques/inputs.h"
#include "techniques/moments/image.h"

/* Rows, or what is converted without a blur; columns; then each level but the first. */
enum { MOMENT_ROWS, MOMENT_COLUMNS, MOMENT_LEVEL, MOMENT_STEPS = MOMENT_LEVEL + MOMENT_LEVELS_MOST - 1 };

typedef struct moment_programs {
  gpu_program *rows, *columns, *level; /* columns: NULL without a blur */
  uint32_t radius;
} moment_programs;

csm_result moment_programs_find(device *device, const csm_config *config, moment_programs *out);

/* A piece of the list of tiles. */
typedef struct moment_list {
  uint32_t first, count;
} moment_list;

/* The dispatches of one recording. */
typedef struct moment_work {
  ring_range ring;
  uint64_t tiles; /* where their list begins in the ring's buffer */
  uint32_t tile_bytes;
  input *inputs[MOMENT_STEPS];
  moment_list all;                        /* to be made, of all cascades */
  moment_list due[CSM_MAX_CASCADES];      /* of one */
  moment_list spread[CSM_MAX_CASCADES];   /* the same, with those above and below, which a blur reads */
  moment_list levels[MOMENT_LEVELS_MOST]; /* groups of 8 x 8 texels of a level beyond the third */
} moment_work;

/* Bytes of the ring. */
uint64_t moment_work_size(const moment_image *image);
/* Bindings for the recording that was prepared. */
csm_result moment_work_reserve(moment_work *work, inputs inputs[MOMENT_STEPS], device *device,
                               const moment_image *image, const moment_programs *programs, gpu_image *maps);
/* Fills in the ring with image->due, and what blurs and levels need. */
void moment_work_write(moment_work *work, const moment_image *image, const csm_config *config, const void *constants,
                       uint32_t constants_size);
void moment_work_record(const moment_work *work, const moment_image *image, const moment_programs *programs,
                        const device *device);

#endif
