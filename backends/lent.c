#include "lent.h"

#include <stdarg.h>
#include <stdio.h>
#include <string.h>

gpu_lent lent_begin(const gpu_open_info *info) {
  const gpu_lent lent = {.host = *info->host,
                         .error = info->error && info->error_size ? info->error : NULL,
                         .error_size = info->error_size};
  if (lent.error)
    lent.error[0] = 0;
  return lent;
}

void *lent_allocate(const gpu_lent *lent, size_t size) {
  void *memory = lent->host.allocate(lent->host.user, size, _Alignof(max_align_t));
  return memory ? memset(memory, 0, size) : NULL;
}

void lent_release(const gpu_lent *lent, void *memory) {
  if (memory)
    lent->host.release(lent->host.user, memory);
}

void lent_text(char *out, size_t size, const char *format, ...) {
  va_list arguments;
  va_start(arguments, format);
  vsnprintf(out, size, format, arguments);
  va_end(arguments);
}

csm_result lent_fail(const gpu_lent *lent, csm_result result, const char *format, ...) {
  char text[512];
  va_list arguments;
  va_start(arguments, format);
  vsnprintf(text, sizeof text, format, arguments);
  va_end(arguments);
  if (lent->error)
    lent_text(lent->error, lent->error_size, "%s", text);
  else
    lent->host.log(lent->host.user, CSM_LOG_ERROR, text);
  return result;
}
