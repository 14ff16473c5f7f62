#include "context.h"

void retire(csm_context *context, retired *thing, void (*destroy)(csm_context *, retired *)) {
  thing->serial = context->serial;
  thing->destroy = destroy;
  thing->next = context->retired;
  context->retired = thing;
}

void retire_collect(csm_context *context, uint64_t serial) {
  retired **link = &context->retired;
  while (*link) {
    retired *thing = *link;
    if (thing->serial <= serial) {
      *link = thing->next;
      thing->destroy(context, thing);
    } else {
      link = &thing->next;
    }
  }
}
