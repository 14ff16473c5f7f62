/* vulkan_case.h: what the tests on a Vulkan engine share: a context on its device, and what an own device draws. */
#ifndef VULKAN_CASE_H
#define VULKAN_CASE_H

#include "../conformance/support.h"
#include "vulkan_engine.h"

enum { CASE_MAX_CASCADES = 4, CASE_MAX_RESOLUTION = 256, CASE_MAX_PIXELS = 160 * 128 };

/* One frame: when, and with which settings. */
typedef struct case_step {
  double time; /* moves the camera and the sun */
  uint32_t cascades, resolution, width, height;
} case_step;

/* What a frame drew. */
typedef struct case_image {
  float maps[CASE_MAX_CASCADES][CASE_MAX_RESOLUTION * CASE_MAX_RESOLUTION]; /* each without gaps */
  uint8_t mask[CASE_MAX_PIXELS];
} case_image;

/* A context with its cascades and the scene that all tests know. */
typedef struct vulkan_case {
  vulkan_engine *engine; /* NULL: an own device */
  record record;
  csm_context *context;
  csm_cascades *cascades;
  csm_config config;
  support_scene scene;
  engine_buffer readback; /* of the size of VULKAN_ENGINE_FRAMES images */
} vulkan_case;

void case_open(vulkan_case *c, vulkan_engine *engine);
/* Runs and retires what was recorded, and destroys the context; asserts that nothing is left and nothing was said. */
void case_close(vulkan_case *c);

/* The frame of a step, for the engine's current frame. */
csm_frame case_frame(const vulkan_case *c, double time);
/* Takes a step's settings over; does nothing where they are in force. */
void case_configure(vulkan_case *c, const case_step *step);
/* Records what the last resolve and render made to be read with the engine's frame. */
void case_copy(const vulkan_case *c, const case_step *step);
/* What was copied in a frame that is done, or what an own device drew last. */
void case_read(const vulkan_case *c, uint64_t frame, const case_step *step, case_image *out);
/* What an own device draws for each of the steps, one after another. */
void case_reference(const case_step *steps, uint32_t count, case_image *out);
/* Asserts that every bit is the same. */
void case_compare(const case_image *drawn, const case_image *expected, const case_step *step);

#endif
