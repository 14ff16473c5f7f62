#include "report/page.h"
#include "base/host.h"
#include "base/output_file.h"
#include "report/report_template.h"
#include <errno.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

/*
 * Nothing inside a script element may look like its end, so "<", which JSON has in texts alone, is written as an
 * escape.
 */
static int write_escaped(const char *data, size_t size, void *file) {
  for (size_t begun = 0; begun < size;) {
    const char *found = memchr(data + begun, '<', size - begun);
    const size_t end = found ? (size_t)(found - data) : size;
    if (fwrite(data + begun, 1, end - begun, file) != end - begun || (found && fputs("\\u003c", file) < 0))
      return -1;
    begun = end + (found != NULL);
  }
  return 0;
}

/* The template, with the data where it says so. */
static int write_page(FILE *file, const json_t *data) {
  static const char mark[] = "@DATA@";
  const char *at = strstr(report_template, mark);
  const size_t before = (size_t)(at - report_template);
  if (fwrite(report_template, 1, before, file) != before ||
      json_dump_callback(data, write_escaped, file, JSON_COMPACT | JSON_REAL_PRECISION(5)) != 0)
    return -1;
  return fputs(at + sizeof mark - 1, file) < 0 ? -1 : 0;
}

static int write_json(FILE *file, const json_t *data) {
  return json_dumpf(data, file, JSON_INDENT(1) | JSON_REAL_PRECISION(17)) != 0 || fputc('\n', file) == EOF ? -1 : 0;
}

static int write_file(const char *folder, const char *name, int (*write)(FILE *, const json_t *), const json_t *data) {
  char path[OUTPUT_PATH_SIZE];
  output_file file;
  const int code = output_path(path, folder, "%s", name);
  if (code)
    return code;
  const char *problem = output_file_open(&file, path);
  if (!problem) {
    const int failed = write(file.stream, data);
    problem = output_file_close(&file, failed ? strerror(errno) : NULL);
  }
  return problem ? host_fail(HOST_BAD_INPUT, "--out: cannot write '%s': %s", path, problem) : 0;
}

int report_page_write(const char *folder, const json_t *data) {
  return write_file(folder, "report.html", write_page, data);
}

int report_json_write(const char *folder, const json_t *data) {
  return write_file(folder, "report.json", write_json, data);
}
