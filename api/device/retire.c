#include "device/device.h"

void retire(device *device, retired *thing, void (*destroy)(struct device *, retired *)) {
  thing->serial = device->serial;
  thing->destroy = destroy;
  thing->next = NULL;
  if (device->retired)
    device->retired_last->next = thing;
  else
    device->retired = thing;
  device->retired_last = thing;
}

/* Serials never fall, so the first that is not done ends it. */
void retire_collect(device *device) {
  while (device->retired && device->retired->serial <= device->done) {
    retired *thing = device->retired;
    device->retired = thing->next;
    thing->destroy(device, thing);
  }
}
