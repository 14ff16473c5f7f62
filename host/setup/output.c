#include "setup/output.h"
#include "base/host.h"
#include <errno.h>
#include <string.h>
#include <sys/resource.h>

FILE *output_table(const host_options *options) {
  return options->json && strcmp(options->json, "-") == 0 ? stderr : stdout;
}

static int write_json(FILE *file, const char *name, json_t *value) {
  const bool failed = json_dumpf(value, file, JSON_INDENT(2) | JSON_REAL_PRECISION(17)) != 0;
  json_decref(value);
  fputc('\n', file);
  if (fflush(file) != 0 || ferror(file) || failed)
    return host_fail(HOST_BAD_INPUT, "cannot write '%s': %s", name, strerror(errno));
  return 0;
}

int output_json_to_stdout(json_t *value) {
  return write_json(stdout, "stdout", value);
}

int output_json(const host_options *options, json_t *value) {
  if (options->json && strcmp(options->json, "-") == 0)
    return output_json_to_stdout(value);
  FILE *file = options->json ? fopen(options->json, "wb") : NULL;
  if (!file) {
    json_decref(value);
    return options->json ? host_fail(HOST_BAD_INPUT, "--json: cannot write '%s': %s", options->json, strerror(errno))
                         : 0;
  }
  const int code = write_json(file, options->json, value);
  fclose(file);
  return code;
}

uint64_t output_peak_memory(void) {
  struct rusage usage;
  return getrusage(RUSAGE_SELF, &usage) == 0 ? (uint64_t)usage.ru_maxrss * 1024u : 0;
}
