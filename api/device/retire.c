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

void retire_collect(device *device) {
  retired **link = &device->retired;
  while (*link) {
    retired *thing = *link;
    if (thing->serial <= device->done) {
      *link = thing->next;
      thing->destroy(device, thing);
    } else {
      device->retired_last = thing;
      link = &thing->next;
    }
  }
}
