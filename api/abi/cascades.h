/* cascades.h: one light seen from one camera: settings, the states of its techniques, and what was planned last. */
#ifndef ABI_CASCADES_H
#define ABI_CASCADES_H

#include "abi/context.h"
#include "csm_constants.h"
#include "plan/budget.h"
#include "techniques/technique.h"

/* What a depth was of that a plan was made for. */
typedef struct planned_depth {
  uint32_t width, height; /* 0: there was none */
  bool own;               /* csm drew it */
} planned_depth;

/* A plan, with the memory that its lists lie in, and what it was made of. */
typedef struct planned {
  plan_memory memory;
  size_t size; /* bytes of it */
  plan_frame frame;
  instances list;         /* the frame's own, if it had one */
  const csm_scene *scene; /* NULL: the list */
  bool scene_gone;        /* it was destroyed since */
  bool others_cast;       /* the engine's callback drew into the maps */
  csm_camera camera;      /* as the frame gave it, and so the next ones */
  csm_light light;
  uint32_t flags;
  uint64_t revision; /* of the scene */
  uint64_t meshes_revision;
  uint32_t instances, changed;
  plan_budget budget; /* that it was planned by */
  csm_constants constants;
  planned_depth seen; /* by csm_frame.depth_view */
} planned;

struct csm_cascades {
  csm_context *context;
  csm_cascades *next, **link;
  csm_config asked;   /* as the caller gave it */
  csm_config config;  /* with what maps budget_mib has room for */
  csm_config fresh;   /* that techniques are made for on another device, before that is taken */
  plan_budget budget; /* of config */
  uint64_t settings;  /* which of all configurations of the context's cascades it is */
  technique_set techniques;
  plan_history history; /* what the last drawn frame handed on */
  plan_cache cache;
  plan_depth_samples *samples; /* of the views, gathered for a plan */
  size_t samples_size;
  planned plans[2]; /* the last one that was drawn, and room for the next */
  uint32_t current;
  uint64_t renders;
  uint64_t changes; /* of all renders, how many drew other shadows than the one before, but for the maps' jitter */
  bool drawn;       /* maps hold plans[current], planned with config */
  double plan_ms, record_ms;
};

/* NULL_POINTER, or DEVICE_LOST. */
csm_result cascades_usable(csm_cascades *cascades);
/* INVALID_STATE before the first frame with the present configuration. */
csm_result cascades_drawn(csm_cascades *cascades);
/* Whether they are a context's. The pointer is compared, not followed. */
bool cascades_known(const csm_context *context, const csm_cascades *cascades);
/* A scene goes: no plan looks into it any more. */
void cascades_forget_scene(csm_context *context, const csm_scene *scene);

static inline const planned *cascades_planned(const csm_cascades *cascades) {
  return &cascades->plans[cascades->current];
}

/* Whether what the last plan was made of is as it was then. */
bool planned_current(const csm_cascades *cascades);

#endif
