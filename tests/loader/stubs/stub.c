/* A backend that does nothing, and says of itself what the build tells it to: see meson.build. */
#include "gpu.h"

#include <string.h>

enum { TABLE_NONE, TABLE_COMPLETE, TABLE_LACKS_LAST, TABLE_LACKS_NAME };

static void nothing(void) {
}

static const gpu_backend *make_table(void) {
  static gpu_backend table;
  void (*const function)(void) = nothing;
  size_t end = sizeof table;
  if (STUB_TABLE == TABLE_NONE)
    return NULL;
  if (STUB_TABLE == TABLE_LACKS_LAST)
    end -= sizeof function;
  for (size_t offset = offsetof(gpu_backend, query); offset < end; offset += sizeof function)
    memcpy((char *)&table + offset, &function, sizeof function);
  table.name = STUB_TABLE == TABLE_LACKS_NAME ? NULL : STUB_NAME;
  return &table;
}

__attribute__((visibility("default"))) void STUB_ENTRY(gpu_handshake *handshake);
void STUB_ENTRY(gpu_handshake *handshake) {
  if (STUB_NEWEST < 0)
    return;
  handshake->front_oldest = 0; /* not its to write: the loader must not believe it */
  handshake->front_newest = 1000;
  handshake->backend_oldest = STUB_OLDEST;
  handshake->backend_newest = (uint32_t)STUB_NEWEST;
  handshake->backend = make_table();
}
