/* base/parallel.h: work on all cores. */
#ifndef HOST_PARALLEL_H
#define HOST_PARALLEL_H

#include <stdint.h>

/*
 * Calls work(context, row) once for each row below `rows`, from as many threads as there are cores, in any order.
 * `progress`, if not NULL, is shown on a terminal with the share that is done.
 */
void parallel_rows(uint32_t rows, void (*work)(void *context, uint32_t row), void *context, const char *progress);

#endif
