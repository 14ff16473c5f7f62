#include "abi/loader.h"

#include <dlfcn.h>
#include <fcntl.h>
#include <link.h>
#include <stdarg.h>
#include <stdio.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

static csm_result fail(csm_result result, char *error, size_t error_size, const char *format, ...) {
  va_list arguments;
  va_start(arguments, format);
  vsnprintf(error, error_size, format, arguments);
  va_end(arguments);
  return result;
}

csm_result loader_negotiate(const gpu_handshake *answer, uint32_t *version) {
  *version = 0;
  if (answer->backend_oldest > answer->backend_newest)
    return CSM_ERROR_BACKEND_BROKEN;
  if (answer->backend_newest < answer->front_oldest)
    return CSM_ERROR_BACKEND_TOO_OLD;
  if (answer->backend_oldest > answer->front_newest)
    return CSM_ERROR_BACKEND_TOO_NEW;
  if (!answer->backend)
    return CSM_ERROR_BACKEND_BROKEN;
  *version = answer->backend_newest < answer->front_newest ? answer->backend_newest : answer->front_newest;
  return CSM_SUCCESS;
}

/* The folder of the program. The linker keeps no absolute path for it. */
static bool program_folder(char folder[PATH_MAX]) {
  const ssize_t length = readlink("/proc/self/exe", folder, PATH_MAX - 1);
  if (length <= 0 || folder[0] != '/')
    return false;
  folder[length] = '\0';
  *strrchr(folder, '/') = '\0';
  return true;
}

/* The folder that this library was loaded from, or that of the program which it is linked into. The dynamic linker made
   it absolute when it loaded the library, so it holds after a chdir too. */
static bool own_folder(char folder[PATH_MAX]) {
  Dl_info info;
  struct link_map *map = NULL;
  if (!dladdr1((const void *)&own_folder, &info, (void **)&map, RTLD_DL_LINKMAP) || !map)
    return false;
  if (!map->l_name[0])
    return program_folder(folder);
  void *library = dlopen(map->l_name, RTLD_LAZY | RTLD_NOLOAD);
  if (!library)
    return false;
  const bool found = dlinfo(library, RTLD_DI_ORIGIN, folder) == 0 && folder[0] == '/';
  dlclose(library);
  return found;
}

static bool find_in(char path[PATH_MAX], const char *folder, const char *name) {
  const int length = snprintf(path, PATH_MAX, "%s/libcsm-%s.so", folder, name);
  return length < PATH_MAX && access(path, F_OK) == 0;
}

static csm_result find(char path[PATH_MAX], const char *name, char *error, size_t error_size) {
  if (strchr(name, '/')) {
    const int length = snprintf(path, PATH_MAX, "%s", name);
    if (length < PATH_MAX && access(path, F_OK) == 0)
      return CSM_SUCCESS;
    return fail(CSM_ERROR_BACKEND_NOT_FOUND, error, error_size, "there is no backend at %s", name);
  }
  if (!name[0] || name[strspn(name, "abcdefghijklmnopqrstuvwxyz0123456789_-")])
    return fail(CSM_ERROR_INVALID_VALUE, error, error_size, "\"%s\" is neither a backend's name nor a path", name);
  char folder[PATH_MAX];
  const bool known = own_folder(folder);
  if ((known && find_in(path, folder, name)) || find_in(path, CSM_BACKEND_DIR, name))
    return CSM_SUCCESS;
  return fail(CSM_ERROR_BACKEND_NOT_FOUND, error, error_size, "there is no libcsm-%s.so in %s%s%s", name,
              known ? folder : "", known ? " or " : "", CSM_BACKEND_DIR);
}

static bool segments_fit(int file, uint64_t size) {
  ElfW(Ehdr) header;
  if (pread(file, &header, sizeof header, 0) != (ssize_t)sizeof header ||
      memcmp(header.e_ident, ELFMAG, SELFMAG) != 0 || header.e_phentsize != sizeof(ElfW(Phdr)))
    return true;
  for (unsigned i = 0; i < header.e_phnum; ++i) {
    ElfW(Phdr) segment;
    if (pread(file, &segment, sizeof segment, (off_t)(header.e_phoff + i * sizeof segment)) != (ssize_t)sizeof segment)
      return false;
    if (segment.p_type == PT_LOAD && (segment.p_offset > size || segment.p_filesz > size - segment.p_offset))
      return false;
  }
  return true;
}

/*
 * What the dynamic linker would not survive: a pipe, which it would wait for, and a library whose file ends before what
 * its header promises (SIGBUS). Whatever else is wrong with a file it finds out itself. NULL: nothing.
 */
static const char *unfit(const char *path) {
  const int file = open(path, O_RDONLY | O_CLOEXEC | O_NONBLOCK);
  struct stat status;
  if (file < 0)
    return NULL;
  const char *const wrong = fstat(file, &status) != 0                       ? NULL
                            : !S_ISREG(status.st_mode)                      ? "it is not a regular file"
                            : !segments_fit(file, (uint64_t)status.st_size) ? "the file is cut short"
                                                                            : NULL;
  close(file);
  return wrong;
}

/* Every member after the name is a function that the front calls without looking. */
static bool complete(const gpu_backend *table) {
  if (!table->name)
    return false;
  for (size_t offset = offsetof(gpu_backend, query); offset < sizeof *table; offset += sizeof(void (*)(void))) {
    void (*function)(void);
    memcpy(&function, (const char *)table + offset, sizeof function);
    if (!function)
      return false;
  }
  return true;
}

static csm_result shake_hands(void *library, const char *path, const gpu_backend **table, char *error,
                              size_t error_size) {
  const void *symbol = dlsym(library, GPU_HANDSHAKE_SYMBOL);
  if (!symbol)
    return fail(CSM_ERROR_BACKEND_BROKEN, error, error_size, "%s is no backend: it has no %s", path,
                GPU_HANDSHAKE_SYMBOL);
  gpu_handshake_function handshake;
  memcpy(&handshake, &symbol, sizeof handshake);

  /* A range that nobody wrote is not sound, so that a backend which writes nothing is found out. */
  gpu_handshake answer = {.backend_oldest = 1, .backend_newest = 0};
  answer.front_oldest = LOADER_OLDEST;
  answer.front_newest = LOADER_NEWEST;
  handshake(&answer);
  answer.front_oldest = LOADER_OLDEST;
  answer.front_newest = LOADER_NEWEST;

  uint32_t version;
  csm_result result = loader_negotiate(&answer, &version);
  if (result == CSM_SUCCESS && !complete(answer.backend))
    result = CSM_ERROR_BACKEND_BROKEN;
  if (result == CSM_SUCCESS) {
    *table = answer.backend;
    return CSM_SUCCESS;
  }
  const char *what = result == CSM_ERROR_BACKEND_TOO_OLD ? "is too old" : "is too new";
  if (result == CSM_ERROR_BACKEND_BROKEN)
    what = "is broken: its range is no range, or its table is missing or not complete";
  return fail(result, error, error_size, "%s %s: it speaks versions %u to %u, this csm speaks %u to %u", path, what,
              answer.backend_oldest, answer.backend_newest, (unsigned)LOADER_OLDEST, (unsigned)LOADER_NEWEST);
}

csm_result loader_open(loader_library *out, const char *name, char *error, size_t error_size) {
  *out = (loader_library){0};
  csm_result result = find(out->path, name, error, error_size);
  if (result != CSM_SUCCESS) {
    out->path[0] = '\0';
    return result;
  }
  const char *const wrong = unfit(out->path);
  if (wrong)
    return fail(CSM_ERROR_BACKEND_BROKEN, error, error_size, "%s does not load: %s", out->path, wrong);
  out->handle = dlopen(out->path, RTLD_NOW | RTLD_LOCAL);
  if (!out->handle)
    return fail(CSM_ERROR_BACKEND_BROKEN, error, error_size, "%s does not load: %s", out->path, dlerror());
  result = shake_hands(out->handle, out->path, &out->backend, error, error_size);
  if (result != CSM_SUCCESS)
    loader_close(out);
  return result;
}

void loader_keep(const loader_library *library) {
  void *const again = dlopen(library->path, RTLD_NOW | RTLD_NOLOAD | RTLD_NODELETE);
  if (again)
    dlclose(again);
}

void loader_close(loader_library *library) {
  if (library->handle)
    dlclose(library->handle);
  library->handle = NULL;
  library->backend = NULL;
}
