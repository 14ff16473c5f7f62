#include "base/interrupt.h"
#include <stdbool.h>

static const int signals[INTERRUPT_SIGNALS] = {SIGINT, SIGTERM, SIGHUP};

/* A handler is told nothing but the signal, so what came lies here. */
static volatile sig_atomic_t came[INTERRUPT_SIGNALS];

static void note(int number) {
  for (int i = 0; i < INTERRUPT_SIGNALS; i++)
    if (signals[i] == number)
      came[i] = 1;
}

void interrupt_hold_begin(interrupt_hold *out) {
  struct sigaction action = {.sa_handler = note, .sa_flags = SA_RESTART};
  sigemptyset(&action.sa_mask);
  for (int i = 0; i < INTERRUPT_SIGNALS; i++) {
    sigaction(signals[i], NULL, &out->before[i]);
    if (out->before[i].sa_handler != SIG_IGN)
      sigaction(signals[i], &action, NULL);
  }
}

void interrupt_hold_end(const interrupt_hold *hold) {
  for (int i = 0; i < INTERRUPT_SIGNALS; i++) {
    sigaction(signals[i], &hold->before[i], NULL);
    const bool raised = came[i];
    came[i] = 0;
    if (raised)
      raise(signals[i]);
  }
}
