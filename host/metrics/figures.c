/* metrics_output.c: metrics as a table, and as JSON. */
#include "metrics/metrics.h"
#include <inttypes.h>

typedef enum unit { SHARE, VISIBILITY, PIXELS, COUNT } unit;

/* One number of the metrics, by its member's offset: a double, or an integer where the unit is COUNT. */
typedef struct row {
  const char *key, *about;
  unit unit;
  size_t offset;
} row;

static const row rows[] = {
    {"pixels", "pixels measured (S)", COUNT, offsetof(metrics, pixels)},
    {"lit", "truly lit", SHARE, offsetof(metrics, lit)},
    {"false_lit", "lit, though in shadow", SHARE, offsetof(metrics, false_lit)},
    {"false_shadow", "shadowed, though lit", SHARE, offsetof(metrics, false_shadow)},
    {"leak", "lit far from every true edge", SHARE, offsetof(metrics, leak)},
    {"acne", "shadowed far from every true edge", SHARE, offsetof(metrics, acne)},
    {"rmse", "error of visibility", VISIBILITY, offsetof(metrics, rmse)},
    {"mean", "drawn less true", VISIBILITY, offsetof(metrics, mean)},
    {"mean_absolute", "of its absolute value", VISIBILITY, offsetof(metrics, mean_absolute)},
    {"edge", "distance between edges", PIXELS, offsetof(metrics, edge_px)},
    {"edge_true_px", "length of the true edges", COUNT, offsetof(metrics, edge_true_px)},
    {"edge_drawn_px", "length of the drawn edges", COUNT, offsetof(metrics, edge_drawn_px)},
    {"edge_true_alone_px", "true edges without a drawn one", COUNT, offsetof(metrics, edge_true_alone_px)},
    {"edge_drawn_alone_px", "drawn edges without a true one", COUNT, offsetof(metrics, edge_drawn_alone_px)},
    {"grazing_pixels", "pixels that the light grazes", COUNT, offsetof(metrics, grazing_pixels)},
    {"grazing_false_lit", "of them: lit, though in shadow", SHARE, offsetof(metrics, grazing_false_lit)},
    {"grazing_false_shadow", "of them: shadowed, though lit", SHARE, offsetof(metrics, grazing_false_shadow)},
    {"depth_pixels", "left out: the depth differs", COUNT, offsetof(metrics, depth_pixels)},
};

static void print_value(FILE *to, const metrics *m, const row *r) {
  const void *at = (const char *)m + r->offset;
  const double value = r->unit == COUNT ? 0.0 : *(const double *)at;
  if (r->unit == COUNT)
    fprintf(to, " %12" PRIu64 "  ", *(const uint64_t *)at);
  else if (r->unit == SHARE)
    fprintf(to, " %12.4f %%", 100.0 * value);
  else if (value < 0.0 && r->unit == PIXELS)
    fprintf(to, " %15s", "no edges");
  else
    fprintf(to, " %12.5f%s", value, r->unit == PIXELS ? "px" : "  ");
}

void metrics_print(FILE *to, const metrics *all, const char *const *names, uint32_t count) {
  fprintf(to, "  %-20s  %-34s", "", "");
  for (uint32_t i = 0; i < count; i++)
    fprintf(to, " %14s", names[i]);
  fputc('\n', to);
  for (size_t r = 0; r < sizeof rows / sizeof rows[0]; r++) {
    fprintf(to, "  %-20s  %-34s", rows[r].key, rows[r].about);
    for (uint32_t i = 0; i < count; i++)
      print_value(to, &all[i], &rows[r]);
    fputc('\n', to);
  }
}

json_t *metrics_to_json(const metrics *m) {
  json_t *object = json_object();
  for (size_t r = 0; r < sizeof rows / sizeof rows[0]; r++) {
    const void *at = (const char *)m + rows[r].offset;
    json_t *value = rows[r].unit == COUNT ? json_integer((json_int_t) * (const uint64_t *)at)
                    : rows[r].unit == PIXELS && *(const double *)at < 0.0 ? json_null()
                                                                          : json_real(*(const double *)at);
    json_object_set_new(object, rows[r].key, value);
  }
  return object;
}
