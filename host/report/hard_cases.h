/* report/hard_cases.h: a report's section of hard cases. */
#ifndef HOST_REPORT_HARD_H
#define HOST_REPORT_HARD_H

#include "setup/options.h"
#include <jansson.h>

/* Whether there are such cases as the options name. 0, or HOST_BAD_INPUT after a message. */
int report_hard_check(const host_options *options);

/*
 * Runs the hard cases that the options name, and adds each one's figures to two arrays; to `page` with a picture of
 * what is around its worst pixel. *broken gets whether a figure does not hold. 0, or a code after a message.
 */
int report_hard_run(json_t *full, json_t *page, bool *broken, const host_options *options);

#endif
