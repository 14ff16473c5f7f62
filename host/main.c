/* main.c: csm-host: scenes, both backends side by side, measurements and pictures. */
#include "bench.h"
#include "config_json.h"
#include "measure.h"
#include "options.h"
#include "output.h"
#include "report.h"
#include "run.h"
#include "view.h"

int main(int count, char **arguments) {
  host_options options;
  const int code = options_parse(&options, count, arguments);
  if (code)
    return code;
  switch (options.command) {
  case COMMAND_HELP:
    options_print_help(stdout);
    return 0;
  case COMMAND_CONFIG:
    return output_json_to_stdout(config_describe_json());
  case COMMAND_RUN:
    return run_command(&options);
  case COMMAND_MEASURE:
    return measure_command(&options);
  case COMMAND_BENCH:
    return bench_command(&options);
  case COMMAND_REPORT:
    return report_command(&options);
  case COMMAND_VIEW:
    return view_command(&options);
  }
  return 0;
}
