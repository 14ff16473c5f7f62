#include "misuse_support.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

void setup(fixture *f) {
  memset(f, 0, sizeof *f);
  f->context = support_open(&f->record);
  f->record.quiet = true;
  f->config = support_config();
  f->config.resolution = RESOLUTION;
  f->view = support_view(f->context);
  support_scene_make(&f->scene, f->context);
  assert_int_equal(csm_cascades_create(f->context, &f->config, &f->cascades), CSM_SUCCESS);
  assert_int_equal(csm_render_cascades(f->cascades, shot_frame(&f->scene.shot)), CSM_SUCCESS);
}

void teardown(fixture *f) {
  assert_int_equal(csm_view_destroy(f->view), CSM_SUCCESS);
  assert_int_equal(csm_cascades_destroy(f->cascades), CSM_SUCCESS);
  support_close(f->context, &f->record);
}

void take(const fixture *f, snapshot *out) {
  memset(out, 0, sizeof *out);
  out->binding.struct_size = sizeof out->binding;
  out->stats.struct_size = sizeof out->stats;
  assert_int_equal(csm_bind(f->cascades, &out->binding), CSM_SUCCESS);
  assert_in_range(out->binding.cascade_constants_size, 1, sizeof out->constants);
  memcpy(out->constants, out->binding.cascade_constants, out->binding.cascade_constants_size);
  assert_int_equal(csm_get_stats(f->cascades, &out->stats), CSM_SUCCESS);
  float *map = support_map(f->context, f->cascades, 0, RESOLUTION);
  memcpy(out->map, map, sizeof out->map);
  free(map);
}

void unchanged(const fixture *f, const snapshot *before) {
  snapshot now;
  take(f, &now);
  assert_memory_equal(&now, before, sizeof now);
}

void expect(const fixture *f, csm_result result, csm_result expected, const char *what) {
  if (result != expected)
    fail_msg("%s: %s (%s), not %s", what, csm_result_name(result), csm_last_error(f->context),
             csm_result_name(expected));
  if (!csm_last_error(f->context)[0])
    fail_msg("%s: no text", what);
}

void check_rows(fixture *f, const row_table *table, attempt attempt) {
  for (size_t i = 0; i < table->count; ++i) {
    _Alignas(16) unsigned char wrong[1024];
    assert_in_range(table->size, 1, sizeof wrong);
    memcpy(wrong, table->good, table->size);
    misuse_apply(&table->rows[i], wrong);
    const csm_result result = attempt(f, wrong);
    misuse_expect(&table->rows[i], result, csm_last_error(f->context));
  }
}

#define INSTANCE(field) FIELD(csm_instance, field)

void check_instances(fixture *f, const csm_instance *good, attempt attempt) {
  static const misuse rows[] = {
      {"no size", INSTANCE(struct_size), {0}, CSM_ERROR_STRUCT_SIZE, "instance"},
      {"another size", INSTANCE(struct_size), {sizeof(csm_instance) - 8}, CSM_ERROR_STRUCT_SIZE, "instance"},
      {"no mesh", INSTANCE(mesh), {0}, CSM_ERROR_INVALID_HANDLE, "mesh"},
      {"a mesh from nowhere", INSTANCE(mesh), {1ull << 40}, CSM_ERROR_INVALID_HANDLE, "mesh"},
      {"unknown flags", INSTANCE(flags), {8}, CSM_ERROR_INVALID_VALUE, "flags"},
      {"casts alone and receives alone",
       INSTANCE(flags),
       {CSM_INSTANCE_CAST_ONLY | CSM_INSTANCE_RECEIVE_ONLY},
       CSM_ERROR_INVALID_VALUE,
       "flags"},
      {"reserved", INSTANCE(reserved), {1}, CSM_ERROR_INVALID_VALUE, "reserved"},
      {"NaN", INSTANCE(transform[5]), {.real = NAN}, CSM_ERROR_NOT_FINITE, "transform"},
      {"infinity", INSTANCE(transform[12]), {.real = INFINITY}, CSM_ERROR_NOT_FINITE, "transform"},
      {"a projective one", INSTANCE(transform[3]), {.real = 1}, CSM_ERROR_INVALID_MATRIX, "transform"},
      {"w of 2", INSTANCE(transform[15]), {.real = 2}, CSM_ERROR_INVALID_MATRIX, "transform"},
  };
  check_rows(f, &(row_table){rows, COUNT(rows), good, sizeof *good}, attempt);
}
