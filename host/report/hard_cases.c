#include "report/hard_cases.h"
#include "base/host.h"
#include "hard/cases.h"
#include "report/page_picture.h"
#include "setup/output.h"
#include <stdlib.h>

int report_hard_check(const host_options *options) {
  const hard_case *chosen[OPTIONS_MAX_CASES];
  uint32_t count;
  return hard_cases_choose(chosen, &count, options);
}

static int add_picture(json_t *object, const hard_worst *worst) {
  image picture;
  if (!worst->expected)
    return 0;
  hard_worst_picture(&picture, worst);
  char *uri = report_picture_uri(&picture);
  image_free(&picture);
  if (!uri)
    return HOST_BAD_INPUT;
  json_object_set_new(object, "picture", json_string(uri));
  json_object_set_new(object, "pictured", json_string(worst->what));
  free(uri);
  return 0;
}

static int add_case(json_t *full, json_t *page, bool *broken, const hard_case *which, const host_options *options) {
  hard_run run;
  int code = hard_run_case(&run, which, options);
  if (code == 0) {
    json_t *object = hard_run_to_json(&run), *pictured = json_copy(object);
    code = add_picture(pictured, &run.worst);
    json_array_append_new(full, object);
    json_array_append_new(page, pictured);
    *broken = *broken || !hard_run_holds(&run);
    fprintf(output_table(options), "hard case %s: %s\n", which->name, hard_run_holds(&run) ? "holds" : "BROKEN");
  }
  hard_run_close(&run);
  return code;
}

int report_hard_run(json_t *full, json_t *page, bool *broken, const host_options *options) {
  const hard_case *chosen[OPTIONS_MAX_CASES];
  uint32_t count;
  int code = hard_cases_choose(chosen, &count, options);
  *broken = false;
  for (uint32_t i = 0; code == 0 && i < count; i++)
    code = add_case(full, page, broken, chosen[i], options);
  return code;
}
