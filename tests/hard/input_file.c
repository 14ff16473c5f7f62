#include "input.h"

#include <dirent.h>
#include <stdio.h>
#include <stdlib.h>
#include <sys/stat.h>
#include <unistd.h>

static char folder[64];

static void remove_folder(void) {
  DIR *open = opendir(folder);
  char path[400];
  for (struct dirent *entry; open && (entry = readdir(open));) {
    snprintf(path, sizeof path, "%s/%s", folder, entry->d_name);
    unlink(path);
  }
  if (open)
    closedir(open);
  rmdir(folder);
}

const char *input_folder(void) {
  static pid_t owner;
  if (owner == getpid())
    return folder;
  snprintf(folder, sizeof folder, "/tmp/csm-input-XXXXXX");
  if (!mkdtemp(folder))
    abort();
  owner = getpid();
  atexit(remove_folder);
  return folder;
}

const char *input_file(const uint8_t *data, size_t size, const char *ending) {
  static char path[128];
  snprintf(path, sizeof path, "%s/input%s", input_folder(), ending);
  FILE *file = fopen(path, "wb");
  if (!file || (size && fwrite(data, size, 1, file) != 1) || fclose(file) != 0)
    abort();
  return path;
}

void input_quiet(void) {
  static FILE *nowhere;
  if (!nowhere) {
    nowhere = fopen("/dev/null", "w");
    stderr = nowhere; /* a sanitizer writes to the descriptor */
  }
}
