/* budget.h: what the targets of a configuration's budget make of cascades. */
#ifndef ABI_BUDGET_H
#define ABI_BUDGET_H

#include "abi/cascades.h"

/*
 * technique_set_make with the finest maps that budget_mib has room for, as the device has them. *made gets the configuration
 * that they were made for. Errors: those, and INVALID_VALUE (budget_mib has room for none).
 */
csm_result budget_make(csm_cascades *cascades, device *device, const csm_config *asked, csm_config *made);

/* Frames after which what was drawn has been measured, at the latest. */
static inline uint32_t budget_late(const device *device) {
  return device->slot_count + 1;
}

/* Chooses the next frame's step, which stays a choice until the frame is drawn. */
void budget_choose(const csm_cascades *cascades, plan_budget *next);

/* What csm_get_stats says of it. */
void budget_tell(const csm_cascades *cascades, csm_stats *stats);

#endif
