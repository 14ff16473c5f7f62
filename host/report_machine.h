/* report_machine.h: where figures were taken. */
#ifndef HOST_REPORT_MACHINE_H
#define HOST_REPORT_MACHINE_H

#include <jansson.h>

/* The processor, its cores, memory, the system and what else kept it busy. */
json_t *report_machine_to_json(void);

#endif
