#include "stage.h"

#include <math.h>
#include <string.h>

csm_create_info stage_create_info(rig *rig, record *record) {
  csm_create_info info = support_create_info(record);
  info.frame_slots = RIG_FRAMES;
  if (rig)
    rig_give(rig, &info);
  return info;
}

void stage_open(stage *stage, rig *rig) {
  stage_open_with(stage, rig, 0);
}

void stage_open_with(stage *stage, rig *rig, uint32_t flags) {
  char text[512] = "";
  *stage = (struct stage){.rig = rig};
  csm_create_info info = stage_create_info(rig, &stage->record);
  info.flags |= flags;
  info.error = text;
  info.error_size = sizeof text;
  const csm_result result = csm_create(&info, &stage->context);
  if (result)
    fail_msg("%s: %s", csm_result_name(result), text);
  stage->config = support_config();
  stage->config.selection = CSM_SELECT_INTERVAL; /* the larger texels: normals of the depth decide fewer pixels */
  assert_int_equal(csm_cascades_create(stage->context, &stage->config, &stage->cascades), CSM_SUCCESS);
  stage->view = support_view(stage->context);
  support_scene_make(&stage->scene, stage->context);
}

void stage_close(stage *stage) {
  if (stage->rig)
    rig_run(stage->rig, rig_frame(stage->rig));
  support_close(stage->context, &stage->record);
  if (stage->rig)
    assert_int_equal(rig_messages(stage->rig), 0);
}

shot stage_shot(const stage *stage, double time) {
  shot shot = stage->scene.shot;
  const double eye[3] = {-4 + 0.7 * time, 6, 12 - time}, target[3] = {0.3 * time, 0, -4};
  support_look_at(shot.camera.view, eye, target);
  shot.light.direction[0] = 0.4 - 0.05 * time;
  shot.frame.instances = stage->scene.instances;
  if (stage->rig) {
    shot.frame.frame = rig_frame(stage->rig);
    shot.frame.command_buffer = rig_commands(stage->rig);
  }
  return shot;
}

static void succeed(const stage *stage, csm_result result) {
  if (result)
    fail_msg("%s: %s", csm_result_name(result), csm_last_error(stage->context));
}

void stage_configure(stage *stage) {
  succeed(stage, csm_cascades_configure(stage->cascades, &stage->config));
}

void stage_render(stage *stage, shot *shot) {
  succeed(stage, csm_render_cascades(stage->cascades, shot_frame(shot)));
}

void stage_resolve(stage *stage, shot *shot, picture_size mask) {
  succeed(stage, shot_resolve(shot, stage->view, stage->cascades, mask.width, mask.height));
}

picture_copy stage_record(stage *stage, picture_size mask) {
  return picture_record(stage->rig, stage->cascades, stage->view, mask,
                        stage->config.map_format == CSM_MAP_D16 ? 2 : 4);
}

void stage_retire(stage *stage) {
  succeed(stage, csm_retire(stage->context, rig_done(stage->rig)));
}

void stage_finish(stage *stage) {
  rig_end(stage->rig);
  rig_run(stage->rig, rig_frame(stage->rig));
  stage_retire(stage);
}

picture stage_draw(stage *stage, shot *shot, picture_size mask) {
  stage_render(stage, shot);
  if (mask.width)
    stage_resolve(stage, shot, mask);
  if (!stage->rig)
    return picture_read(stage->context, stage->cascades, stage->view, mask);
  picture_copy copy = stage_record(stage, mask);
  stage_finish(stage);
  return picture_take(stage->rig, &copy);
}

picture stage_draw_at(stage *stage, double time, picture_size mask) {
  if (stage->rig)
    rig_begin(stage->rig);
  shot shot = stage_shot(stage, time);
  return stage_draw(stage, &shot, mask);
}

/* ---- the hill ---- */

void hill_make(hill *hill) {
  for (uint32_t i = 0; i < HILL_VERTICES; ++i) {
    const float x = (float)(i % HILL_SIDE) / (HILL_SIDE - 1) * 2 - 1,
                z = (float)(i / HILL_SIDE) / (HILL_SIDE - 1) * 2 - 1;
    const float p[3] = {x, cosf(x * 2.1f + 0.3f) * cosf(z * 1.7f), z};
    memcpy(hill->positions[i], p, sizeof p);
  }
  uint16_t *out = hill->indices;
  for (uint16_t row = 0; row + 1 < HILL_SIDE; ++row)
    for (uint16_t column = 0; column + 1 < HILL_SIDE; ++column) {
      const uint16_t a = (uint16_t)(row * HILL_SIDE + column), b = (uint16_t)(a + HILL_SIDE);
      const uint16_t corners[6] = {a, b, (uint16_t)(a + 1), (uint16_t)(a + 1), b, (uint16_t)(b + 1)};
      memcpy(out, corners, sizeof corners);
      out += 6;
    }
  for (uint32_t i = 0; i < HILL_INDICES; ++i)
    hill->wide_indices[i] = hill->indices[i];
}

csm_mesh_info hill_info(const hill *hill, uint32_t index_size) {
  return (csm_mesh_info){
      .struct_size = sizeof(csm_mesh_info),
      .positions = hill->positions,
      .vertex_count = HILL_VERTICES,
      .indices = index_size == 2 ? (const void *)hill->indices : hill->wide_indices,
      .index_count = HILL_INDICES,
      .index_size = index_size,
      .name = "hill",
  };
}

csm_mesh hill_mesh(csm_context *context, const hill *hill, uint32_t index_size) {
  const csm_mesh_info info = hill_info(hill, index_size);
  csm_mesh mesh;
  assert_int_equal(csm_mesh_create(context, &info, &mesh), CSM_SUCCESS);
  return mesh;
}
