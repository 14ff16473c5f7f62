/* setup/output.h: where a command's table and JSON go. */
#ifndef HOST_OUTPUT_H
#define HOST_OUTPUT_H

#include "setup/options.h"
#include <jansson.h>

/* The table's stream: stdout, or stderr where stdout is for JSON. */
FILE *output_table(const host_options *options);
/* Writes `value` where --json says, if it is given, and releases it. 0, or HOST_BAD_INPUT after a message. */
int output_json(const host_options *options, json_t *value);
/* Writes to stdout, and releases it. */
int output_json_to_stdout(json_t *value);

/* Peak memory of this process, in bytes. */
uint64_t output_peak_memory(void);

#endif
