/*
 * csm_loader.h: csm's functions as a table, for an engine that opens libcsm at run time instead of linking it.
 *
 *   csm_functions csm;
 *   void *library = dlopen("libcsm.so.1", RTLD_NOW | RTLD_LOCAL);
 *   const char *missing = csm_functions_load(library, &csm);   (NULL: all are there)
 *   csm.create(&info, &context);
 *
 * Header only. The library stays open for as long as the table or anything made with it is used.
 */
#ifndef CSM_LOADER_H
#define CSM_LOADER_H

#include "csm.h"
#include <string.h>
#if defined(_WIN32)
#include <windows.h>
#else
#include <dlfcn.h>
#endif

/* Every function of csm.h: what it returns, its name without "csm_", its arguments. */
#define CSM_FUNCTIONS(F)                                                                                               \
  F(uint32_t, version, (void))                                                                                         \
  F(const char *, result_name, (csm_result result))                                                                    \
  F(const char *, last_error, (const csm_context *context))                                                            \
  F(csm_result, query_backends, (uint32_t * count, csm_backend_info * infos))                                          \
  F(csm_result, create, (const csm_create_info *info, csm_context **context))                                          \
  F(void, destroy, (csm_context * context))                                                                            \
  F(csm_result, switch_backend, (csm_context * context, const csm_create_info *info))                                  \
  F(csm_result, retire, (csm_context * context, uint64_t frame))                                                       \
  F(csm_result, alpha_mask_create,                                                                                     \
    (csm_context * context, const csm_alpha_mask_info *info, csm_alpha_mask *alpha_mask))                              \
  F(csm_result, alpha_mask_destroy, (csm_context * context, csm_alpha_mask alpha_mask))                                \
  F(csm_result, mesh_create, (csm_context * context, const csm_mesh_info *info, csm_mesh *mesh))                       \
  F(csm_result, mesh_update, (csm_context * context, csm_mesh mesh, const csm_mesh_update_info *info))                 \
  F(csm_result, mesh_destroy, (csm_context * context, csm_mesh mesh))                                                  \
  F(csm_result, scene_create, (csm_context * context, csm_scene * *scene))                                             \
  F(csm_result, scene_destroy, (csm_scene * scene))                                                                    \
  F(csm_result, scene_add, (csm_scene * scene, const csm_scene_batch *batch))                                          \
  F(csm_result, scene_move, (csm_scene * scene, const csm_scene_batch *batch))                                         \
  F(csm_result, scene_change, (csm_scene * scene, const csm_scene_batch *batch))                                       \
  F(csm_result, scene_remove, (csm_scene * scene, uint32_t count, const csm_instance_id *ids))                         \
  F(csm_result, config_describe, (uint32_t index, csm_config_field * field))                                           \
  F(csm_result, config_default, (csm_config * config))                                                                 \
  F(csm_result, config_preset_describe, (uint32_t index, csm_preset_info * info))                                      \
  F(csm_result, config_preset, (const char *name, csm_config *config))                                                 \
  F(csm_result, shader_defines, (const csm_config *config, char *text, uint64_t *size))                                \
  F(csm_result, cascades_create, (csm_context * context, const csm_config *config, csm_cascades **cascades))           \
  F(csm_result, cascades_configure, (csm_cascades * cascades, const csm_config *config))                               \
  F(csm_result, cascades_destroy, (csm_cascades * cascades))                                                           \
  F(csm_result, view_create, (csm_context * context, csm_view * *view))                                                \
  F(csm_result, view_destroy, (csm_view * view))                                                                       \
  F(csm_result, get_draw_target, (csm_cascades * cascades, csm_draw_target * target))                                  \
  F(csm_result, reduce_depth, (csm_view * view, const csm_mask_info *info))                                            \
  F(csm_result, render_cascades, (csm_cascades * cascades, const csm_frame *frame))                                    \
  F(csm_result, resolve_mask, (csm_view * view, csm_cascades * cascades, const csm_mask_info *info))                   \
  F(csm_result, bind, (csm_cascades * cascades, csm_binding * binding))                                                \
  F(csm_result, read, (csm_context * context, const csm_read_info *info))                                              \
  F(csm_result, get_stats, (csm_cascades * cascades, csm_stats * stats))                                               \
  F(csm_result, get_view_stats, (csm_view * view, csm_view_stats * stats))                                             \
  F(csm_result, get_casters, (csm_cascades * cascades, uint32_t count, const csm_instance_id *ids, uint8_t *drawn))

typedef struct csm_functions {
#define CSM_FIELD(type, name, arguments) type(CSM_CALL *name) arguments;
  CSM_FUNCTIONS(CSM_FIELD)
#undef CSM_FIELD
} csm_functions;

/*
 * Fills the table from an open library: a handle of dlopen, on Windows an HMODULE. Gives NULL, or the name of the first
 * function that the library lacks; the table is zero then.
 */
static inline const char *csm_functions_load(void *library, csm_functions *out) {
  const char *missing = NULL;
  memset(out, 0, sizeof *out);
#if defined(_WIN32)
#define CSM_FIND(name) (void *)GetProcAddress((HMODULE)library, name)
#else
#define CSM_FIND(name) dlsym(library, name)
#endif
/* Standard C has no conversion from an object's pointer to a function's. */
#define CSM_LOAD(type, name, arguments)                                                                                \
  if (!missing) {                                                                                                      \
    void *const symbol = CSM_FIND("csm_" #name);                                                                       \
    memcpy(&out->name, &symbol, sizeof symbol);                                                                        \
    missing = symbol ? NULL : "csm_" #name;                                                                            \
  }
  CSM_FUNCTIONS(CSM_LOAD)
#undef CSM_LOAD
#undef CSM_FIND
  if (missing)
    memset(out, 0, sizeof *out);
  return missing;
}

#endif
