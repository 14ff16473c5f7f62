#include "setup/output.h"
#include "base/host.h"
#include "base/output_file.h"
#include <errno.h>
#include <string.h>
#include <sys/resource.h>

FILE *output_table(const host_options *options) {
  return options->json && strcmp(options->json, "-") == 0 ? stderr : stdout;
}

/* NULL, or what went wrong. */
static const char *write_json(FILE *file, const json_t *value) {
  const bool failed = json_dumpf(value, file, JSON_INDENT(2) | JSON_REAL_PRECISION(17)) != 0;
  return failed || fputc('\n', file) == EOF || fflush(file) != 0 ? strerror(errno) : NULL;
}

int output_json_to_stdout(json_t *value) {
  interrupt_hold hold;
  interrupt_hold_begin(&hold);
  const char *problem = write_json(stdout, value);
  interrupt_hold_end(&hold);
  json_decref(value);
  return problem ? host_fail(HOST_BAD_INPUT, "cannot write 'stdout': %s", problem) : 0;
}

int output_json(const host_options *options, json_t *value) {
  if (options->json && strcmp(options->json, "-") == 0)
    return output_json_to_stdout(value);
  const char *problem = NULL;
  if (options->json) {
    output_file file;
    problem = output_file_open(&file, options->json);
    if (!problem)
      problem = output_file_close(&file, write_json(file.stream, value));
  }
  json_decref(value);
  return problem ? host_fail(HOST_BAD_INPUT, "--json: cannot write '%s': %s", options->json, problem) : 0;
}

uint64_t output_peak_memory(void) {
  struct rusage usage;
  return getrusage(RUSAGE_SELF, &usage) == 0 ? (uint64_t)usage.ru_maxrss * 1024u : 0;
}
