/* base/interrupt.h: a while in which the program is not ended by a signal, so that what it begins is done or not done. */
#ifndef HOST_INTERRUPT_H
#define HOST_INTERRUPT_H

#include <signal.h>

enum { INTERRUPT_SIGNALS = 3 };

typedef struct interrupt_hold {
  struct sigaction before[INTERRUPT_SIGNALS];
} interrupt_hold;

/* SIGINT, SIGTERM and SIGHUP wait until the end, and then do what they would have done. Holds may lie within others. */
void interrupt_hold_begin(interrupt_hold *out);
void interrupt_hold_end(const interrupt_hold *hold);

#endif
