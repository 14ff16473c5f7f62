#include "report/machine.h"
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/utsname.h>
#include <unistd.h>

/* The text after the colon of a file's first line that begins with `key`; "unknown" if there is none. */
static void find_line(char *out, size_t size, const char *path, const char *key) {
  char line[512];
  FILE *file = fopen(path, "r");
  snprintf(out, size, "unknown");
  while (file && fgets(line, sizeof line, file)) {
    const char *colon = strchr(line, ':');
    if (strncmp(line, key, strlen(key)) != 0 || !colon)
      continue;
    line[strcspn(line, "\n")] = '\0';
    snprintf(out, size, "%s", colon + 1 + strspn(colon + 1, " \t"));
    break;
  }
  if (file)
    fclose(file);
}

json_t *report_machine_to_json(void) {
  char processor[256], memory[64];
  struct utsname system = {0};
  json_t *object = json_object();
  find_line(processor, sizeof processor, "/proc/cpuinfo", "model name");
  find_line(memory, sizeof memory, "/proc/meminfo", "MemTotal");
  json_object_set_new(object, "processor", json_string(processor));
  json_object_set_new(object, "cores", json_integer(sysconf(_SC_NPROCESSORS_ONLN)));
  json_object_set_new(object, "memory_gib", json_real(strtod(memory, NULL) / (1024.0 * 1024.0)));
  if (uname(&system) == 0)
    json_object_set_new(object, "system", json_sprintf("%s %s %s", system.sysname, system.release, system.machine));
  return object;
}

json_t *report_machine_load(void) {
  double load;
  return getloadavg(&load, 1) == 1 ? json_real(load) : json_null();
}
