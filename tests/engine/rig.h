/*
 * rig.h: as much of an engine as tests need, on whichever API: a device of its own with validation, frames in flight,
 * images, buffers, and casters that it draws itself. A program has one of rig_vulkan.c and rig_d3d12.c. What must not
 * fail ends the program with a text.
 */
#ifndef RIG_H
#define RIG_H

#include "../conformance/rows.h"
#include "../conformance/support.h"
#include "csm/csm_d3d12.h"
#include "csm/csm_vulkan.h"

#include <stdbool.h>

enum { RIG_FRAMES = 3 /* in flight */, RIG_LISTS = 2 /* command buffers of one frame */ };

typedef struct rig rig;

typedef enum rig_kind {
  RIG_TYPICAL, /* as engines open their devices */
  RIG_BARE,    /* with no more than csm requires; the same as the typical one where there is nothing to leave out */
  RIG_MODERN,  /* with all that an engine may lend: its allocator, its pipeline cache, dynamic rendering */
  RIG_FAILING  /* bare but for what rays need, and any call of csm's can be made to fail; one in a program */
} rig_kind;

rig *rig_open(rig_kind kind);
/* Runs all frames; asserts that validation said nothing, and that nothing but the engine holds its device. */
void rig_close(rig *rig);
/* Hands the device to a context that is about to be made. */
void rig_give(const rig *rig, csm_create_info *info);
/* Errors and warnings of validation so far; they are printed. */
uint32_t rig_messages(const rig *rig);

/* ---- frames ---- */

/* The last frame that was begun, from 1; and the last that the GPU is done with. */
uint64_t rig_frame(const rig *rig);
uint64_t rig_done(const rig *rig);
/* Begins a frame's command buffer; goes on in another one, which is submitted on its own; ends the frame. Nothing is
   submitted yet, so csm cannot count on its being done. */
void *rig_begin(rig *rig);
void *rig_split(rig *rig);
void rig_end(rig *rig);
/* The command buffer or list that was opened last; NULL before the first. */
void *rig_commands(const rig *rig);
/* Submits the frames up to and with `frame`, in their order, and waits for them. */
void rig_run(rig *rig, uint64_t frame);
/* What was recorded for the last frame, which has ended, is never run. */
void rig_drop(rig *rig);

/* ---- memory that a rig of kind RIG_MODERN lends ---- */

/* How a request goes wrong. */
typedef enum rig_lapse {
  RIG_REFUSAL,    /* an error, and nothing given */
  RIG_NOTHING,    /* no error, and nothing given */
  RIG_ODD_OFFSET, /* a piece at an offset that is not aligned */
  RIG_UNMAPPED    /* a piece that is not mapped, where it must be: not on Direct3D 12 */
} rig_lapse;

typedef struct rig_lent {
  uint32_t requests, pieces, most; /* made so far; pieces that csm has now, and had at most */
  uint32_t refuse_at;              /* the request that goes wrong, from 1; 0: none */
  rig_lapse lapse;
  uint32_t lapses; /* that came to pass */
} rig_lent;

rig_lent *rig_lent_memory(rig *rig);

/* ---- buffers ---- */

typedef struct rig_buffer {
  void *mapped;
  uint64_t size;
  void *object; /* VkBuffer or ID3D12Resource* */
  void *memory; /* VkDeviceMemory; Direct3D 12: NULL */
} rig_buffer;

typedef enum rig_buffer_use { RIG_GEOMETRY, RIG_READBACK, RIG_CONSTANTS } rig_buffer_use;

/* Mapped and coherent. */
rig_buffer rig_buffer_make(rig *rig, rig_buffer_use use, uint64_t size);
/* Asserts that csm holds it no more. */
void rig_buffer_free(rig *rig, rig_buffer *buffer);

/* Where an engine's mesh lies in its buffers. */
typedef struct rig_mesh {
  const rig_buffer *vertices, *indices;
  uint32_t vertex_offset, vertex_stride, index_offset;
} rig_mesh;

typedef union rig_native {
  csm_vulkan_device vulkan_device;
  csm_vulkan_image vulkan_image;
  csm_vulkan_mesh vulkan_mesh;
  csm_d3d12_device d3d12_device;
  csm_d3d12_image d3d12_image;
  csm_d3d12_mesh d3d12_mesh;
  unsigned char bytes[256];
} rig_native;

/* The API's struct of a mesh, into `native`, to which `info` points then. */
void rig_mesh_give(const rig_mesh *mesh, rig_native *native, csm_mesh_info *info);

/* ---- images ---- */

typedef enum rig_format {
  RIG_DEPTH_32,
  RIG_RGBA_FLOAT_32,
  RIG_RGBA_FLOAT_16,
  RIG_RGBA_SNORM_16,
  RIG_RGBA_UNORM_16,
  RIG_RGBA_UNORM_8,
  RIG_RG_FLOAT_32,
  RIG_RG_FLOAT_16
} rig_format;

typedef struct rig_image rig_image;

/* How a depth image may be made or rest: 0 to rig_depth_ways - 1. */
extern const uint32_t rig_depth_ways;

typedef struct rig_image_info {
  rig_format format;
  uint32_t way; /* of depth */
  uint32_t width, height;
  const void *texels; /* without gaps */
} rig_image_info;

/* A 2D image, readable by shaders. Runs all frames that were recorded. */
rig_image *rig_image_make(rig *rig, const rig_image_info *info);
/* Asserts that csm holds it no more. */
void rig_image_free(rig *rig, rig_image *image);
/* The csm_vulkan_image or csm_d3d12_image. */
const void *rig_image_native(const rig_image *image);
uint32_t rig_texel_bytes(rig_format format);

/* ---- reading what csm drew ---- */

typedef struct rig_layer {
  uint64_t image; /* of csm_binding; at rest, before and after */
  uint32_t layer, width, height;
  uint32_t texel_bytes; /* 4 or 2: depth, 1: a mask, 16: colour */
} rig_layer;

/* Records a copy, as an engine does that samples the image in compute shaders. */
void rig_copy(rig *rig, const rig_layer *from, const rig_buffer *to, uint64_t offset);
/* Bytes from one copied row to the next. */
uint32_t rig_pitch(uint32_t width, uint32_t texel_bytes);

/* ---- casters that the engine draws ---- */

/* A mesh, drawn by the engine's own pipeline with csm's arithmetic: the instance's rows times the position. */
typedef struct rig_caster rig_caster;

enum { RIG_CASTER_INSTANCES = 8, RIG_ROWS = 12 };

/* What a caster is made of. */
typedef struct rig_caster_info {
  const float (*positions)[3];
  const uint16_t *indices;
  uint32_t vertex_count, index_count;
  csm_draw_target target; /* that its pipeline is built for */
} rig_caster_info;

rig_caster *rig_caster_make(rig *rig, const rig_caster_info *info);
void rig_caster_free(rig_caster *caster);
/* Draws `count` instances in a callback of csm's, at most RIG_CASTER_INSTANCES in each cascade; changes every state
   that it may. */
void rig_caster_draw(rig_caster *caster, const csm_draw_info *info, const float (*rows)[RIG_ROWS], uint32_t count);
/* Asserts what the API promises of a target, of maps in 32 or 16 bits; and of a callback's. */
void rig_check_target(const rig *rig, const csm_draw_target *target, uint32_t map_format);
void rig_check_draw(const rig *rig, const csm_draw_info *info);

/* ---- misuse: an API's own structs, of which one field is wrong in each row ---- */

typedef enum rig_struct {
  RIG_DEVICE,
  RIG_IMAGE,
  RIG_MESH,
  RIG_TESTED_MESH /* a mesh with an alpha mask */
} rig_struct;

/* Fills in a good struct, and the rows that spoil it, at most MISUSE_ROWS; returns their number. The image and the
   buffers are what the good struct speaks of, and what a row may take in a wrong place. */
uint32_t rig_misuses(rig *rig, rig_struct which, const rig_image *image, const rig_buffer *buffer, rig_native *good,
                     misuse *rows);
uint32_t rig_struct_size(rig_struct which);
/* Makes `info` and `mask` speak of the struct. */
void rig_give_device(const rig_native *device, csm_create_info *info);
void rig_give_mesh(const rig_native *mesh, csm_mesh_info *info);
/* Structs of the other API. */
void rig_give_foreign_device(csm_create_info *info);
void rig_give_foreign_mesh(csm_mesh_info *info);

/* ---- faults, on a rig of kind RIG_FAILING ---- */

typedef struct rig_fault {
  const char *what;
  int32_t code;        /* the API's; 0: the host's allocator fails */
  csm_result expected; /* of csm */
} rig_fault;

extern const rig_fault rig_faults[];
extern const uint32_t rig_fault_count;

/* Lets the nth call from now on that can fail do so; 0: none does, and which one did is remembered. */
void rig_fail(const rig_fault *fault, uint32_t nth);
/* The function that failed since a call was last told to, or NULL. */
const char *rig_failed(void);
/* Whether an error of that function loses what was recorded, and the device with it. */
bool rig_loses_recording(const char *function);
/* A device that was lost is there again. */
void rig_find(void);
/* From now on the device is lost, as if by itself, where the API can tell between frames; false where it cannot. */
bool rig_lose(void);
/* The name of something that csm holds still of a device that it was given; NULL: nothing. */
const char *rig_leak(void);

#endif
