#include "device/device.h"

void retire(device *device, retired *thing, void (*destroy)(struct device *, retired *)) {
  thing->serial = device->serial;
  thing->destroy = destroy;
  thing->next = device->retired;
  device->retired = thing;
}

void retire_collect(device *device) {
  retired **link = &device->retired;
  while (*link) {
    retired *thing = *link;
    if (thing->serial <= device->done) {
      *link = thing->next;
      thing->destroy(device, thing);
    } else {
      link = &thing->next;
    }
  }
}
