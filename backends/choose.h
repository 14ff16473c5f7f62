/* choose.h: which of several devices a backend takes: the same one in all. */
#ifndef CHOOSE_H
#define CHOOSE_H

#include "gpu.h"

/* Whether a device's name contains the part asked for, in letters of either case. A part of NULL fits every name. */
bool choose_fits(const char *name, const char *part);

/* How good a gpu_device_type is: discrete, integrated, virtual, CPU, others. Higher is better, and 0 is none. */
uint32_t choose_rank(gpu_device_type type);

#endif
