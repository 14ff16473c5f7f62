/* uploads.h: geometry on its way to the device. It waits in staging buffers until the next recording copies it. */
#ifndef DEVICE_UPLOADS_H
#define DEVICE_UPLOADS_H

#include "device/pages.h"

/*
 * Memory that is copied to the beginning of a piece by the next recording: what waits for the piece already, or `size`
 * new bytes of staging. Errors: those of device_buffer, OUT_OF_MEMORY; what waited waits on.
 */
csm_result uploads_write(device *device, page_piece *to, uint64_t size, void **memory);
/* What waits for the piece is not copied. */
void uploads_drop(device *device, page_piece *to);
/* Records all copies. */
void uploads_record(device *device);
void uploads_destroy(device *device);

#endif
