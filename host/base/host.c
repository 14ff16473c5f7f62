#include "base/host.h"
#include <errno.h>
#include <stdarg.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <time.h>
#include <unistd.h>

int host_fail(int code, const char *format, ...) {
  va_list arguments;
  va_start(arguments, format);
  fputs("csm-host: ", stderr);
  vfprintf(stderr, format, arguments);
  fputc('\n', stderr);
  va_end(arguments);
  return code;
}

void *host_allocate(size_t count, size_t size) {
  void *memory = calloc(count ? count : 1, size);
  if (!memory)
    exit(host_fail(HOST_BAD_INPUT, "out of memory: %zu elements of %zu bytes", count, size));
  return memory;
}

void *host_grow(void *array, size_t *capacity, size_t needed, size_t size) {
  if (needed <= *capacity)
    return array;
  size_t count = *capacity ? *capacity : 16;
  while (count < needed)
    count *= 2;
  void *grown = count <= SIZE_MAX / size ? realloc(array, count * size) : NULL;
  if (!grown)
    exit(host_fail(HOST_BAD_INPUT, "out of memory: %zu elements of %zu bytes", count, size));
  *capacity = count;
  return grown;
}

static double read_clock(clockid_t clock) {
  struct timespec now;
  clock_gettime(clock, &now);
  return (double)now.tv_sec * 1e3 + (double)now.tv_nsec * 1e-6;
}

double host_now_ms(void) {
  return read_clock(CLOCK_MONOTONIC);
}

double host_cpu_ms(void) {
  return read_clock(CLOCK_THREAD_CPUTIME_ID);
}

void host_progress(const char *text) {
  if (!isatty(STDERR_FILENO))
    return;
  fprintf(stderr, "\r\033[K%s", text);
  fflush(stderr);
}

int host_make_folder(const char *path) {
  char partial[4096];
  const int length = snprintf(partial, sizeof partial, "%s", path);
  if (length <= 0 || (size_t)length >= sizeof partial)
    return host_fail(HOST_BAD_INPUT, "not a usable folder: '%s'", path);
  for (char *at = partial + 1;; at++)
    if (*at == '/' || *at == '\0') {
      const char kept = *at;
      *at = '\0';
      if (mkdir(partial, 0777) != 0 && errno != EEXIST)
        return host_fail(HOST_BAD_INPUT, "cannot make the folder '%s': %s", partial, strerror(errno));
      if (kept == '\0')
        break;
      *at = kept;
    }
  struct stat status;
  if (stat(path, &status) != 0 || !S_ISDIR(status.st_mode))
    return host_fail(HOST_BAD_INPUT, "not a folder: '%s'", path);
  return 0;
}

char *host_read_file(const char *path, size_t *size) {
  FILE *file = fopen(path, "rb");
  if (!file)
    return NULL;
  size_t capacity = 0, count = 0, read;
  char *bytes = NULL;
  do {
    bytes = host_grow(bytes, &capacity, count + 65536, 1);
    read = fread(bytes + count, 1, 65535, file);
    count += read;
  } while (read > 0);
  bytes[count] = '\0';
  fclose(file);
  if (size)
    *size = count;
  return bytes;
}
