/*
 * technique.h: what every technique is to those that run it. A technique is a room: a folder of its own with its
 * settings' meaning, images, programs, commands and statistics, behind one table of functions.
 *
 * How to add one: a folder here with a table `technique_NAME`, its line in techniques.c (in the order of recording), a
 * line in meson.build. Its settings are a theme of csm_config, its shaders rows of the variants' table. What another
 * room needs of it, it tells in NAME.h. Nothing else changes: frames, pictures, switching, statistics and reading are
 * loops over techniques.c.
 *
 * A technique belongs to the cascades (it is drawn once for a light: maps, moments of them, pages), or to a view (once
 * for a picture: camera depth, mask, its history). It keeps a state for each owner. A state holds what lies on its
 * device now, and `fresh`, which is what `make` or `reserve` made beside it: then comes `adopt`, which cannot fail, or
 * `forget`. So nothing changes before all has been reserved.
 */
#ifndef TECHNIQUE_H
#define TECHNIQUE_H

#include "device/device.h"
#include "plan/plan.h"
#include "techniques/engine_image.h"

enum { TECHNIQUE_MAX = 8 };

typedef struct technique technique;

/* The states of one owner's techniques. */
typedef struct technique_set {
  const technique *const *techniques;
  uint32_t count;
  host *host;
  void *states[TECHNIQUE_MAX];
} technique_set;

/* A picture: what a view's techniques draw. */
typedef struct technique_picture {
  uint32_t width, height, show; /* show: CSM_SHOW_* */
  const plan_camera *camera;
  const plan_camera *depth_camera; /* that the depth is of: the same, or csm's own, if the depth is */
  const plan_scene *scene;
  const plan_list *seen;     /* of the scene, by the camera; empty if the engine brings its depth */
  bool reduces;              /* its depth is reduced, before maps are drawn, and no mask is */
  bool depth_kept;           /* csm's own depth was drawn by a reduction already */
  const void *engines_depth; /* csm_vulkan_image, csm_d3d12_image, or NULL; as in csm_mask_info */
  const void *engines_normals, *engines_motion;
  gpu_image *depth; /* out, of technique_camera_depth: readable once that is recorded */
  plan_grain depth_rounding;
  engine_imported normals; /* out, of technique_mask, as the next: the engine's, if the picture needs them */
  gpu_image *mask;
  gpu_view *mask_stores;     /* NULL: no shader writes it */
  ring_range mask_constants; /* the two blocks that the mask's programs see */
} technique_picture;

/* One recording on its way through the techniques. */
typedef struct technique_run {
  device *device;
  const csm_config *config; /* NULL for a reduction, as `plan` and `constants` are */
  uint64_t settings;        /* another number for each configuration of each cascades */
  uint64_t changes;         /* of a picture: how often the cascades' shadows had changed */
  const plan_frame *plan;   /* of the cascades */
  const void *constants;    /* csm_constants of csm_constants.h */
  uint32_t constants_size;  /* in bytes */
  const csm_frame *frame;   /* frame, command_buffer, draw */
  bool timestamps;
  technique_set *cascades;
  uint32_t same;              /* bit i: cascade i's map comes out as that of the frame before did; 0 for a picture */
  uint32_t light_layers;      /* instances of other layers cast nothing; 0: all */
  const plan_scene *scene;    /* what the plan's lists are of; NULL for a picture */
  technique_set *view;        /* NULL: the cascades' techniques run */
  technique_picture *picture; /* likewise */
} technique_run;

/* What a recording took on the CPU, waiting for the device left out. */
typedef struct technique_times {
  double write_ms, record_ms;
} technique_times;

/* Of an image that is made of pages, as plan_cascade has it. */
typedef struct technique_pages {
  uint32_t across, begin[2]; /* across: 0: it is not */
  uint64_t valid[PLAN_CELLS];
} technique_pages;

/* An image that csm_read may read a part of. */
typedef struct technique_image {
  gpu_image *image;
  gpu_format format;
  uint32_t width, height, layer;
  uint32_t layers;               /* that are read, one after the other, from `layer` on; 0: that one */
  uint32_t levels;               /* that can be read; 0: one */
  gpu_rect part;                 /* of the first level; its x and y are 0 where there are more */
  const technique_pages *pages;  /* NULL: it is not made of them */
  float cleared;                 /* what pages hold that nothing reads */
  const plan_camera *drawn_with; /* of camera depths: they are converted from its; NULL: read as they are */
  const plan_camera *read_as;    /* to this one's, or, if NULL, to view depths */
} technique_image;

/* Which recordings of its owner a technique runs in. */
typedef enum technique_when { TECHNIQUE_SHADOWS, TECHNIQUE_REDUCTION, TECHNIQUE_BOTH } technique_when;

struct technique {
  const char *name;
  technique_when when;
  size_t state_size; /* of zeroed memory, for each owner */
  /* Whether a configuration asks for it. */
  bool (*wanted)(const csm_config *config);

  /* ---- settings and devices; a view's technique makes all in `reserve` and leaves the first one NULL ---- */

  /* Makes what a configuration needs on a device. What the state has there and fits is used on. */
  csm_result (*make)(void *state, device *device, const csm_config *config);
  /* Puts what is fresh in the place of what was there, which is retired on `from`. */
  void (*adopt)(void *state, device *from);
  /* Lets what is fresh go, if anything is. */
  void (*forget)(void *state, device *device);
  /* Device memory of what `make` made, or found, while it is fresh; NULL: it is not of a budget. */
  uint64_t (*bytes)(const void *state, const device *device);
  /* Retires all that lies on the device, and forgets what was measured there. What another device can use stays. */
  void (*drop)(void *state, device *device);
  /* Frees host memory that the state keeps; may be NULL. */
  void (*end)(void *state, host *host);

  /* ---- a recording: size, reserve, write, adopt, record ---- */

  /* Bytes that it wants of the ring. */
  uint64_t (*size)(const void *state, const technique_run *run);
  /* All that can fail. `ring` is its piece, which stays as it is until the recording is done. */
  csm_result (*reserve)(void *state, technique_run *run, const ring_range *ring);
  /* Fills its piece of the ring in; may be NULL. */
  void (*write)(void *state, const technique_run *run);
  void (*record)(void *state, const technique_run *run);

  /* ---- what came of it; each may be NULL ---- */

  /* Its images in the binding. The binding's descriptors are in. */
  void (*bind)(const void *state, device *device, csm_binding *binding);
  void (*tell)(const void *state, const device *device, csm_stats *stats);
  void (*tell_view)(const void *state, const device *device, csm_view_stats *stats);
  /* Where a CSM_READ_* lies. Errors: UNSUPPORTED (it is not the technique's), INVALID_STATE (not drawn yet). */
  csm_result (*find)(const void *state, uint32_t source, uint32_t cascade, technique_image *out);
};

/* ---- the techniques, in the order of recording: techniques.c ---- */

/* An owner's states, all empty. Errors: OUT_OF_MEMORY. */
csm_result technique_set_begin_cascades(technique_set *set, host *host);
csm_result technique_set_begin_view(technique_set *set, host *host);
/* Everything on the device must have been dropped. */
void technique_set_end(technique_set *set);
/* The state of one of the set's techniques. */
void *technique_state(const technique_set *set, const technique *technique);

/* make, for all that the configuration asks for, or nothing. */
csm_result technique_set_make(technique_set *set, device *device, const csm_config *config);
/* adopt after that; what the configuration does not ask for is dropped. */
void technique_set_adopt(technique_set *set, device *from, const csm_config *config);
void technique_set_forget(technique_set *set, device *device);
/* Device memory of the maps and moments that technique_set_make made, before they are adopted. */
uint64_t technique_set_bytes(const technique_set *set, const device *device, const csm_config *config);
void technique_set_drop(technique_set *set, device *device);
/* Drops what the configuration does not ask for. */
void technique_set_drop_unwanted(technique_set *set, device *device, const csm_config *config);

/* Reserves, writes and records what the configuration asks for, of the view's techniques if there is a view, else of
   the cascades'. After an error everything is as it was, or the device is lost. */
csm_result technique_run_record(technique_run *run, technique_times *times);

void technique_set_bind(const technique_set *set, device *device, csm_binding *binding);
void technique_set_tell(const technique_set *set, const device *device, csm_stats *stats);
void technique_set_tell_view(const technique_set *set, const device *device, csm_view_stats *stats);
/* The image of a CSM_READ_*. Errors: as technique.find. */
csm_result technique_set_find(const technique_set *set, uint32_t source, uint32_t cascade, technique_image *out);

#endif
