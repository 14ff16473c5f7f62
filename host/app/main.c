/* main.c: csm-host: scenes, both backends side by side, measurements and pictures. */
#include "app/run.h"
#include "bench/bench.h"
#include "hard/hard.h"
#include "measure/measure.h"
#include "report/preset_table.h"
#include "report/report.h"
#include "setup/config_json.h"
#include "setup/options.h"
#include "setup/output.h"
#include "setup/presets.h"
#include "view/view.h"
#include <math.h>

/* The shadow distance is left out where the scene decides it, so that a file made of this leaves it open, too. */
static int config_command(const host_options *options) {
  csm_config config;
  if (!options->preset && !options->config_file)
    return output_json_to_stdout(config_describe_json());
  int code = config_load(&config, options->preset, options->config_file, NAN);
  csm_config checked = config;
  checked.shadow_distance = isnan(config.shadow_distance) ? 100.0 : config.shadow_distance;
  if (code == 0)
    code = config_check(&checked, options->config_file ? "--config" : "--preset");
  if (code)
    return code;
  json_t *object = config_to_json(&config);
  if (isnan(config.shadow_distance))
    json_object_del(object, "shadow_distance");
  return output_json_to_stdout(object);
}

int main(int count, char **arguments) {
  host_options options;
  setvbuf(stdout, NULL, _IOLBF, BUFSIZ); /* whoever interrupts it keeps every line that was told */
  const int code = options_parse(&options, count, arguments);
  if (code)
    return code;
  switch (options.command) {
  case COMMAND_HELP:
    options_print_help(stdout);
    return 0;
  case COMMAND_CONFIG:
    return config_command(&options);
  case COMMAND_PRESETS:
    return output_json_to_stdout(presets_to_json());
  case COMMAND_RUN:
    return run_command(&options);
  case COMMAND_MEASURE:
    return options.presets.count ? preset_table_command(&options) : measure_command(&options);
  case COMMAND_BENCH:
    return bench_command(&options);
  case COMMAND_REPORT:
    return report_command(&options);
  case COMMAND_HARD:
    return hard_command(&options);
  case COMMAND_VIEW:
    return view_command(&options);
  }
  return 0;
}
