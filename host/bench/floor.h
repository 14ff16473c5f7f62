/*
 * bench/floor.h: a bare Vulkan loop that clears the cascades' maps and draws the same lists into them, without the
 * faces that csm leaves out. `csm-host bench` measures the library against it. It may write moments on the way.
 */
#ifndef HOST_FLOOR_H
#define HOST_FLOOR_H

#include "plan.h"
#include "scene/scene.h"

typedef struct floor_loop floor_loop;

/* What is drawn: a texel has so many floats of moments beside its depth. */
typedef enum floor_moments { FLOOR_DEPTH = 0, FLOOR_VSM = 2, FLOOR_EVSM4 = 4 } floor_moments;

typedef struct floor_info {
  const scene *scene;
  const plan_frame *frame;      /* its lists name the scene's meshes by index */
  const plan_scene *plan_scene; /* what the frame was planned from, for plan_write_window_matrices */
  uint32_t resolution;          /* of each map, in texels a side; D32 */
  floor_moments moments;        /* of one layer of depth, with the exponents of drawn_moments.h */
  const char *device;           /* part of a device's name, or NULL for the first discrete, integrated, virtual, CPU */
} floor_info;

/*
 * Opens a device and uploads everything that the frames draw. 0, HOST_NO_DEVICE or HOST_BAD_INPUT; `error` gets a
 * text then, and *out is NULL.
 */
int floor_open(floor_loop **out, const floor_info *info, char *error, size_t error_size);

/* Records, submits and waits for one frame. Wall-clock milliseconds of it all, or a negative number if the device
 * fails. */
double floor_frame(floor_loop *loop);

/* Milliseconds that the last frame took on the GPU; negative where the device has no timestamps. */
double floor_gpu_ms(const floor_loop *loop);

/* Reads a map of the last frame: resolution * resolution depths, top row first. False if the device fails. */
bool floor_read(floor_loop *loop, uint32_t cascade, float *out);
/* The same of its moments. */
bool floor_read_moments(floor_loop *loop, uint32_t cascade, float *out);

/* NULL is allowed. */
void floor_close(floor_loop *loop);

#endif
