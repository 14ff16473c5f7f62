#include "base/output_file.h"
#include "base/host.h"
#include <errno.h>
#include <fcntl.h>
#include <limits.h>
#include <stdarg.h>
#include <stdbool.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

int output_path(char path[OUTPUT_PATH_SIZE], const char *folder, const char *format, ...) {
  const size_t room = OUTPUT_PATH_SIZE;
  va_list arguments;
  size_t used = (size_t)snprintf(path, room, "%s/", folder);
  if (used < room) {
    va_start(arguments, format);
    used += (size_t)vsnprintf(path + used, room - used, format, arguments);
    va_end(arguments);
  }
  return used < room ? 0 : host_fail(HOST_BAD_INPUT, "the folder's name is too long: '%s'", folder);
}

/* Another program may write the same file, so what is not whole yet has the process's number in its name. */
static const char *place(output_file *out, const char *path, mode_t *mode) {
  struct stat status;
  char resolved[PATH_MAX];
  const bool there = stat(path, &status) == 0;
  if (there && access(path, W_OK) != 0)
    return strerror(errno);
  const bool in_place = there && !S_ISREG(status.st_mode);
  const char *target = there && !in_place ? realpath(path, resolved) : path;
  if (!target)
    return strerror(errno);
  if ((size_t)snprintf(out->path, sizeof out->path, "%s", target) >= sizeof out->path)
    return strerror(ENAMETOOLONG);
  if (!in_place)
    snprintf(out->partial, sizeof out->partial, "%s.%ld", out->path, (long)getpid());
  *mode = there ? status.st_mode & 0777 : 0;
  return NULL;
}

/* A file that is made here: what a link of that name leads to is not written to. */
static FILE *make_partial(const char *path) {
  remove(path);
  const int file = open(path, O_WRONLY | O_CREAT | O_EXCL | O_CLOEXEC, 0666);
  FILE *stream = file >= 0 ? fdopen(file, "wb") : NULL;
  if (file >= 0 && !stream)
    close(file);
  return stream;
}

const char *output_file_open(output_file *out, const char *path) {
  mode_t mode = 0;
  *out = (output_file){0};
  const char *problem = place(out, path, &mode);
  if (problem)
    return problem;
  interrupt_hold_begin(&out->hold);
  out->stream = out->partial[0] ? make_partial(out->partial) : fopen(out->path, "wb");
  if (!out->stream) {
    problem = strerror(errno);
    interrupt_hold_end(&out->hold);
  } else if (mode && out->partial[0]) {
    fchmod(fileno(out->stream), mode);
  }
  return problem;
}

const char *output_file_close(output_file *file, const char *problem) {
  if (!problem && (fflush(file->stream) != 0 || ferror(file->stream)))
    problem = strerror(errno);
  if (fclose(file->stream) != 0 && !problem)
    problem = strerror(errno);
  if (file->partial[0]) {
    if (!problem && rename(file->partial, file->path) != 0)
      problem = strerror(errno);
    if (problem)
      remove(file->partial);
  }
  interrupt_hold_end(&file->hold);
  return problem;
}
