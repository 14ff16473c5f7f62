#include "metrics/ghosts.h"
#include <math.h>

void ghosts_add(ghosts *sum, const metrics_frame *frame, const uint8_t *kinds, const float *alone) {
  const size_t count = (size_t)frame->view->width * frame->view->height;
  for (size_t i = 0; i < count; i++) {
    if (kinds[i] < METRICS_RIGHT)
      continue;
    const double truly = frame->visibility[i], wrong = fabs(frame->mask[i] - truly),
                 wrong_alone = fabs(alone[i] - truly);
    sum->pixels++;
    sum->wrong += wrong > 0.5 && wrong_alone <= 0.5;
    sum->squares += wrong_alone * wrong_alone;
  }
}

static double share(const ghosts *g) {
  return g->pixels ? (double)g->wrong / (double)g->pixels : 0.0;
}

static double rmse_alone(const ghosts *g) {
  return g->pixels ? sqrt(g->squares / (double)g->pixels) : 0.0;
}

void ghosts_print(FILE *to, const ghosts *all, uint32_t count) {
  fprintf(to, "  %-20s  %-34s", "ghosts", "wrong by the history alone");
  for (uint32_t i = 0; i < count; i++)
    fprintf(to, " %12.4f %%", 100.0 * share(&all[i]));
  fprintf(to, "\n  %-20s  %-34s", "rmse_alone", "of each frame without a history");
  for (uint32_t i = 0; i < count; i++)
    fprintf(to, " %12.5f  ", rmse_alone(&all[i]));
  fputc('\n', to);
}

void ghosts_to_json(json_t *object, const ghosts *g) {
  json_object_set_new(object, "ghosts", json_real(share(g)));
  json_object_set_new(object, "rmse_alone", json_real(rmse_alone(g)));
}
