#include "base/parallel.h"
#include "base/host.h"
#include <pthread.h>
#include <stdatomic.h>
#include <stdio.h>
#include <unistd.h>

#define MAX_THREADS 256

typedef struct job {
  uint32_t rows;
  void (*work)(void *context, uint32_t row);
  void *context;
  atomic_uint next;
} job;

static void *work_off(void *argument) {
  job *j = argument;
  for (uint32_t row = atomic_fetch_add(&j->next, 1); row < j->rows; row = atomic_fetch_add(&j->next, 1))
    j->work(j->context, row);
  return NULL;
}

/* As work_off, telling how far all threads are, every tenth of a second at most. */
static void work_off_and_tell(job *j, const char *progress) {
  double told = host_now_ms();
  for (uint32_t row = atomic_fetch_add(&j->next, 1); row < j->rows; row = atomic_fetch_add(&j->next, 1)) {
    if (progress && host_now_ms() - told > 100.0) {
      char text[128];
      snprintf(text, sizeof text, "%s: %.0f %%", progress, 100.0 * row / j->rows);
      host_progress(text);
      told = host_now_ms();
    }
    j->work(j->context, row);
  }
  if (progress)
    host_progress("");
}

/* The calling thread works too, so a machine that gives no more threads still finishes. */
void parallel_rows(uint32_t rows, void (*work)(void *context, uint32_t row), void *context, const char *progress) {
  job j = {.rows = rows, .work = work, .context = context};
  pthread_t threads[MAX_THREADS];
  const long cores = sysconf(_SC_NPROCESSORS_ONLN);
  long started = 0;
  while (started < cores - 1 && started < MAX_THREADS && pthread_create(&threads[started], NULL, work_off, &j) == 0)
    started++;
  work_off_and_tell(&j, progress);
  for (long i = 0; i < started; i++)
    pthread_join(threads[i], NULL);
}
