#include "dispatches.h"

#include <stdlib.h>
#include <string.h>

static void CSM_CALL take_line(void *user, int32_t level, const char *message) {
  commands *log = user;
  log->dispatches += strncmp(message, "dispatch ", 9) == 0;
  log->drawn_after |= log->dispatches && strncmp(message, "pass_begin", 10) == 0;
  log->breaches += level == CSM_LOG_ERROR;
}

int fixture_begin(void **state, uint32_t flags, const csm_config *config) {
  fixture *f = calloc(1, sizeof *f);
  const csm_create_info info = {.struct_size = sizeof info,
                                .version = CSM_VERSION,
                                .flags = flags,
                                .backend = "null",
                                .log = take_line,
                                .user = &f->commands};
  *state = f;
  f->config = *config;
  if (csm_create(&info, &f->context) || csm_cascades_create(f->context, &f->config, &f->cascades) ||
      csm_scene_create(f->context, &f->scene))
    return -1;
  support_scene_make(&f->instances, f->context);
  const csm_scene_batch batch = {
      .struct_size = sizeof batch, .count = SUPPORT_INSTANCES, .ids = f->ids, .instances = f->instances.instances};
  return csm_scene_add(f->scene, &batch);
}

int fixture_end(void **state) {
  fixture *f = *state;
  csm_destroy(f->context);
  free(f);
  return 0;
}

uint32_t fixture_render(fixture *f) {
  csm_frame frame = *shot_frame(&f->instances.shot);
  frame.scene = f->scene;
  frame.instances = NULL;
  frame.instance_count = 0;
  f->commands = (commands){0};
  assert_int_equal(csm_render_cascades(f->cascades, &frame), CSM_SUCCESS);
  assert_int_equal(f->commands.breaches, 0);
  return f->commands.dispatches;
}

void fixture_move(fixture *f, uint32_t instance, double x) {
  double matrix[16] = {1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, x, 1, 0, 1};
  const csm_scene_batch batch = {.struct_size = sizeof batch, .count = 1, .ids = &f->ids[instance], .matrices = matrix};
  assert_int_equal(csm_scene_move(f->scene, &batch), CSM_SUCCESS);
}
