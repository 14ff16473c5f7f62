/* report/machine.h: where figures were taken. */
#ifndef HOST_REPORT_MACHINE_H
#define HOST_REPORT_MACHINE_H

#include <jansson.h>

/* The processor, its cores, memory and the system. */
json_t *report_machine_to_json(void);
/* How many programs wanted to run, on average over the last minute; null where the system does not tell. */
json_t *report_machine_load(void);

#endif
