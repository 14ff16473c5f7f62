/* inputs.c: what an engine hands in: its camera's depth, normals and motion, and its own vertices and indices. */
#include "stage.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

enum { WIDTH = 192, HEIGHT = 128, PIXELS = WIDTH * HEIGHT };

static const picture_size size = {WIDTH, HEIGHT};

/* Settings that tell normals apart. */
static void open_telling(stage *stage, rig *rig) {
  stage_open(stage, rig);
  stage->config.bias_normal_texels = 2;
  stage_configure(stage);
}

/* What a context with a device of its own draws, and the depth that its camera sees. */
static picture draw_own(float depth[PIXELS]) {
  stage own;
  open_telling(&own, NULL);
  const picture out = stage_draw_at(&own, 0, size);
  float *read = support_image(own.context, own.view, CSM_READ_CAMERA_DEPTH, WIDTH, HEIGHT);
  memcpy(depth, read, PIXELS * sizeof *depth);
  free(read);
  stage_close(&own);
  return out;
}

/* What a mask is resolved from. */
typedef struct seen {
  const rig_image *depth, *normals;
  uint32_t show; /* CSM_SHOW_* */
  const rig_image *motion;
} seen;

/* The maps, and the mask of the engine's images; with its depth, the camera needs no instances. */
static picture draw_seen(stage *stage, seen seen) {
  rig_begin(stage->rig);
  shot shot = stage_shot(stage, 0);
  stage_render(stage, &shot);
  shot.frame.instances = NULL;
  shot.frame.instance_count = 0;
  const csm_mask_info mask = {.struct_size = sizeof mask,
                              .frame = shot_frame(&shot),
                              .width = WIDTH,
                              .height = HEIGHT,
                              .camera_depth = rig_image_native(seen.depth),
                              .normals = seen.normals ? rig_image_native(seen.normals) : NULL,
                              .show = seen.show,
                              .motion = seen.motion ? rig_image_native(seen.motion) : NULL};
  const csm_result result = csm_resolve_mask(stage->view, stage->cascades, &mask);
  if (result)
    fail_msg("%s: %s", csm_result_name(result), csm_last_error(stage->context));
  picture_copy copy = stage_record(stage, size);
  stage_finish(stage);
  return picture_take(stage->rig, &copy);
}

static rig_image *make_image(rig *rig, rig_format format, uint32_t way, const void *texels) {
  return rig_image_make(
      rig, &(rig_image_info){.format = format, .way = way, .width = WIDTH, .height = HEIGHT, .texels = texels});
}

/* ---- depth ---- */

static void own_depth_gives_the_same_mask(void **state) {
  (void)state;
  static float depth[PIXELS];
  picture expected = draw_own(depth);
  assert_true(rig_depth_ways > 1);
  for (uint32_t way = 0; way < rig_depth_ways; ++way) {
    stage stage;
    rig *rig = rig_open(RIG_TYPICAL);
    open_telling(&stage, rig);
    rig_image *image = make_image(rig, RIG_DEPTH_32, way, depth);
    picture drawn = draw_seen(&stage, (seen){.depth = image});
    picture_expect_equal(&expected, &drawn);
    rig_image_free(rig, image);
    stage_close(&stage);
    rig_close(rig);
  }
  picture_free(&expected);
}

/* ---- depth, before the maps are drawn ---- */

/* A scene of what a stage's shots list. */
static csm_scene *scene_of_stage(const stage *stage) {
  csm_scene *scene;
  csm_instance_id ids[SUPPORT_INSTANCES];
  const csm_scene_batch batch = {
      .struct_size = sizeof batch, .count = SUPPORT_INSTANCES, .ids = ids, .instances = stage->scene.instances};
  assert_int_equal(csm_scene_create(stage->context, &scene), CSM_SUCCESS);
  assert_int_equal(csm_scene_add(scene, &batch), CSM_SUCCESS);
  return scene;
}

static shot shot_of_scene(const stage *stage, csm_scene *scene) {
  shot shot = stage_shot(stage, 0);
  shot.frame.instances = NULL;
  shot.frame.instance_count = 0;
  shot.frame.scene = scene;
  return shot;
}

static csm_mask_info mask_of(shot *shot, const rig_image *depth) {
  return (csm_mask_info){.struct_size = sizeof(csm_mask_info),
                         .frame = shot_frame(shot),
                         .width = WIDTH,
                         .height = HEIGHT,
                         .camera_depth = depth ? rig_image_native(depth) : NULL};
}

/* The depth in a frame of its own, which is not done before it is retired; then maps and mask. */
static picture draw_by_depth(stage *stage, csm_scene *scene, const rig_image *depth) {
  rig_begin(stage->rig);
  shot shot = shot_of_scene(stage, scene);
  csm_mask_info info = mask_of(&shot, depth);
  assert_int_equal(csm_reduce_depth(stage->view, &info), CSM_SUCCESS);
  shot.frame.depth_view = stage->view;
  stage->record.quiet = true;
  assert_int_equal(csm_render_cascades(stage->cascades, shot_frame(&shot)), CSM_ERROR_INVALID_STATE);
  assert_non_null(strstr(csm_last_error(stage->context), "not retired"));
  stage_finish(stage);
  rig_begin(stage->rig);
  shot = shot_of_scene(stage, scene);
  shot.frame.depth_view = stage->view;
  stage_render(stage, &shot);
  info = mask_of(&shot, depth);
  assert_int_equal(csm_resolve_mask(stage->view, stage->cascades, &info), CSM_SUCCESS);
  picture_copy copy = stage_record(stage, size);
  stage_finish(stage);
  csm_stats stats = {.struct_size = sizeof stats};
  assert_int_equal(csm_get_stats(stage->cascades, &stats), CSM_SUCCESS);
  assert_int_equal(stats.cells_by, CSM_CELLS_DEPTH);
  assert_true(stats.cells_read > 0 && stats.cells_read < stats.cascade_count * 64 * 64);
  return picture_take(stage->rig, &copy);
}

/* The engine's depth in every way that it may be made, and csm's own. */
static void maps_for_a_depth_give_the_same_mask(void **state) {
  (void)state;
  static float depth[PIXELS];
  picture expected = draw_own(depth);
  for (uint32_t way = 0; way <= rig_depth_ways; ++way) {
    stage stage;
    rig *rig = rig_open(RIG_TYPICAL);
    open_telling(&stage, rig);
    stage.config.caster_set = CSM_CASTER_SET_VIEW;
    stage_configure(&stage);
    csm_scene *scene = scene_of_stage(&stage);
    rig_image *image = way < rig_depth_ways ? make_image(rig, RIG_DEPTH_32, way, depth) : NULL;
    picture drawn = draw_by_depth(&stage, scene, image);
    assert_true(picture_mask_difference(&expected, &drawn, 1) == 0);
    picture_free(&drawn);
    if (image)
      rig_image_free(rig, image);
    stage_close(&stage);
    rig_close(rig);
  }
  picture_free(&expected);
}

/* ---- normals ---- */

/* The scene's normal at every pixel, turned to the camera: all faces lie along axes. Up where nothing is. */
static void trace_normals(const stage *stage, double normals[PIXELS][3]) {
  static double corners[SUPPORT_TRIANGLES][3][3];
  shot shot = stage_shot(stage, 0);
  const double *view = shot.camera.view, *projection = shot.camera.projection;
  double eye[3];
  support_triangles(&stage->scene, corners);
  for (int axis = 0; axis < 3; ++axis)
    eye[axis] = -(view[axis * 4] * view[12] + view[axis * 4 + 1] * view[13] + view[axis * 4 + 2] * view[14]);
  for (uint32_t pixel = 0; pixel < PIXELS; ++pixel) {
    const double x = ((pixel % WIDTH + 0.5) / WIDTH * 2 - 1) / projection[0];
    const double y = (1 - (pixel / WIDTH + 0.5) / HEIGHT * 2) / projection[5];
    double direction[3], nearest = INFINITY, *normal = normals[pixel];
    for (int axis = 0; axis < 3; ++axis)
      direction[axis] = view[axis * 4] * x + view[axis * 4 + 1] * y - view[axis * 4 + 2];
    memcpy(normal, (const double[]){0, 1, 0}, 3 * sizeof *normal);
    for (uint32_t i = 0; i < SUPPORT_TRIANGLES; ++i) {
      double edge;
      const double distance = support_trace(&corners[i], 1, eye, direction, &edge);
      if (distance < 0 || distance >= nearest)
        continue;
      nearest = distance;
      for (int axis = 0; axis < 3; ++axis) {
        const bool flat = corners[i][0][axis] == corners[i][1][axis] && corners[i][0][axis] == corners[i][2][axis];
        normal[axis] = flat ? (direction[axis] > 0 ? -1 : 1) : 0;
      }
    }
  }
}

static void encode(const double n[3], rig_format format, unsigned char *out) {
  for (int i = 0; i < 4; ++i) {
    const double value = i < 3 ? n[i] : 0, unorm = value * 0.5 + 0.5;
    const float whole = (float)value;
    const int16_t snorm = (int16_t)lrint(value * 32767);
    const uint16_t wide = (uint16_t)lrint(unorm * 65535);
    if (format == RIG_RGBA_FLOAT_32)
      memcpy(out + i * 4, &whole, 4);
    else if (format == RIG_RGBA_SNORM_16)
      memcpy(out + i * 2, &snorm, 2);
    else if (format == RIG_RGBA_UNORM_16)
      memcpy(out + i * 2, &wide, 2);
    else
      out[i] = (unsigned char)lrint(unorm * 255);
  }
}

/* An image of the normals, coded for one format and taken for another or the same. */
static rig_image *make_normals(rig *rig, double normals[PIXELS][3], rig_format coded, rig_format taken) {
  const uint32_t texel_bytes = rig_texel_bytes(coded);
  unsigned char *texels = malloc((size_t)PIXELS * texel_bytes);
  assert_non_null(texels);
  for (uint32_t i = 0; i < PIXELS; ++i)
    encode(normals[i], coded, texels + (size_t)i * texel_bytes);
  rig_image *image = make_image(rig, taken, 0, texels);
  free(texels);
  return image;
}

/* Draws with normals, and checks how far the mask is from another. */
static picture draw_normals(stage *stage, const rig_image *depth, rig_image *normals) {
  const picture drawn = draw_seen(stage, (seen){.depth = depth, .normals = normals});
  rig_image_free(stage->rig, normals);
  return drawn;
}

static void normals_of_every_coding_agree(void **state) {
  (void)state;
  static const struct {
    rig_format format;
    double tolerance; /* share of pixels that may differ from those of float normals */
  } codings[] = {{RIG_RGBA_SNORM_16, 0}, {RIG_RGBA_UNORM_16, 1e-3}, {RIG_RGBA_UNORM_8, 1e-2}};
  static double normals[PIXELS][3];
  static float depth[PIXELS];
  stage stage;
  picture own = draw_own(depth);
  rig *rig = rig_open(RIG_TYPICAL);
  open_telling(&stage, rig);
  trace_normals(&stage, normals);
  rig_image *seen_depth = make_image(rig, RIG_DEPTH_32, 0, depth);
  picture floats = draw_normals(&stage, seen_depth, make_normals(rig, normals, RIG_RGBA_FLOAT_32, RIG_RGBA_FLOAT_32));
  /* Normals from depth are those of the faces, but for silhouettes. */
  assert_true(picture_mask_difference(&own, &floats, 1) < 0.01);
  assert_true(picture_mask_difference(&own, &floats, 32) < 8.0 / (96 * 64));
  for (size_t i = 0; i < sizeof codings / sizeof codings[0]; ++i) {
    picture drawn = draw_normals(&stage, seen_depth, make_normals(rig, normals, codings[i].format, codings[i].format));
    assert_true(picture_mask_difference(&floats, &drawn, 1) <= codings[i].tolerance);
    assert_true(picture_mask_difference(&own, &drawn, 1) < 0.01);
    picture_free(&drawn);
  }
  /* Taken for floats as they are, coded normals are others. */
  picture wrong = draw_normals(&stage, seen_depth, make_normals(rig, normals, RIG_RGBA_UNORM_16, RIG_RGBA_FLOAT_16));
  assert_true(picture_mask_difference(&floats, &wrong, 2) > 24.0 / (96 * 64));
  picture_free(&wrong);
  for (uint32_t i = 0; i < PIXELS; ++i) /* false ones: each along the next axis */
    memcpy(normals[i], (const double[]){normals[i][2], normals[i][0], normals[i][1]}, sizeof normals[i]);
  wrong = draw_normals(&stage, seen_depth, make_normals(rig, normals, RIG_RGBA_FLOAT_32, RIG_RGBA_FLOAT_32));
  assert_true(picture_mask_difference(&floats, &wrong, 1) > 0.02);
  picture_free(&wrong);
  picture_free(&floats);
  picture_free(&own);
  rig_image_free(rig, seen_depth);
  stage_close(&stage);
  rig_close(rig);
}

/* It takes its normals from the depth; and the mask is the same after it. */
static void what_is_shown_instead_needs_no_normals(void **state) {
  (void)state;
  static double normals[PIXELS][3];
  static float depth[PIXELS];
  stage stage;
  picture own = draw_own(depth);
  picture_free(&own);
  rig *rig = rig_open(RIG_TYPICAL);
  open_telling(&stage, rig);
  trace_normals(&stage, normals);
  rig_image *images[] = {make_image(rig, RIG_DEPTH_32, 0, depth),
                         make_normals(rig, normals, RIG_RGBA_FLOAT_32, RIG_RGBA_FLOAT_32)};
  picture shadow = draw_seen(&stage, (seen){.depth = images[0], .normals = images[1]});
  for (uint32_t show = CSM_SHOW_CASCADE; show <= CSM_SHOW_DENSITY; ++show) {
    picture without = draw_seen(&stage, (seen){.depth = images[0], .show = show});
    picture with = draw_seen(&stage, (seen){.depth = images[0], .normals = images[1], .show = show});
    assert_true(picture_mask_difference(&without, &shadow, 2) > 1.0 / 8);
    picture_expect_equal(&without, &with);
    picture_free(&without);
  }
  picture again = draw_seen(&stage, (seen){.depth = images[0], .normals = images[1]});
  picture_expect_equal(&shadow, &again);
  picture_free(&shadow);
  for (int i = 0; i < 2; ++i)
    rig_image_free(rig, images[i]);
  stage_close(&stage);
  rig_close(rig);
}

/* ---- motion ---- */

/* The whole picture's motion, in two halves or floats, or in four of which csm reads two. */
static rig_image *make_motion(rig *rig, rig_format format, const float motion[2], const uint16_t halves[2]) {
  const bool floats = format == RIG_RGBA_FLOAT_32 || format == RIG_RG_FLOAT_32;
  const uint32_t bytes = rig_texel_bytes(format);
  unsigned char *texels = calloc(PIXELS, bytes);
  assert_non_null(texels);
  for (uint32_t i = 0; i < PIXELS; ++i)
    memcpy(texels + (size_t)i * bytes, floats ? (const void *)motion : halves, floats ? 8 : 4);
  rig_image *image = make_image(rig, format, 0, texels);
  free(texels);
  return image;
}

/* The share of pixels with a surface whose history has so many frames. */
static double share_of(const picture *shown, uint32_t frames) {
  uint32_t surfaces = 0, as_many = 0;
  const float *mask = shown->layers[shown->count - 1].texels;
  for (uint32_t i = 0; i < PIXELS; ++i) {
    const uint32_t has = (uint32_t)(mask[i] * 255.0f + 0.5f);
    surfaces += has > 0;
    as_many += has == frames;
  }
  return surfaces ? (double)as_many / surfaces : 0.0;
}

/* Without motion, with none that is told, and with one to the left: from outside of the picture, or from the pixel beside,
   where the ground and most faces go on. */
static void motion_says_where_a_surface_was(void **state) {
  (void)state;
  static float depth[PIXELS];
  static const struct {
    float motion[2];
    uint16_t halves[2];
    double least, most; /* share of the pixels that go on */
  } ways[] = {{{0, 0}, {0, 0}, 1, 1},
              {{-2, 0}, {0xc000, 0}, 0, 0},
              {{0, 1.5f}, {0, 0x3e00}, 0, 0},
              {{-1.0f / 64, 0}, {0xa400, 0}, 0.5, 0.99}};
  picture own = draw_own(depth);
  picture_free(&own);
  static const rig_format formats[] = {RIG_RGBA_FLOAT_32, RIG_RGBA_FLOAT_16, RIG_RG_FLOAT_32, RIG_RG_FLOAT_16};
  for (size_t format = 0; format < sizeof formats / sizeof formats[0]; ++format)
    for (size_t i = 0; i < sizeof ways / sizeof ways[0]; ++i) {
      stage stage;
      rig *rig = rig_open(RIG_TYPICAL);
      stage_open(&stage, rig);
      stage.config.history = CSM_HISTORY_ON;
      stage_configure(&stage);
      rig_image *images[] = {make_image(rig, RIG_DEPTH_32, 0, depth),
                             make_motion(rig, formats[format], ways[i].motion, ways[i].halves)};
      const seen seen = {.depth = images[0], .show = CSM_SHOW_HISTORY, .motion = images[1]};
      picture first = draw_seen(&stage, seen), second = draw_seen(&stage, seen);
      assert_true(share_of(&first, 1) == 1.0);
      const double goes_on = share_of(&second, 2);
      assert_true(goes_on >= ways[i].least && goes_on <= ways[i].most);
      assert_true(goes_on + share_of(&second, 1) >= 1.0 - 1e-9);
      picture_free(&first);
      picture_free(&second);
      for (int k = 0; k < 2; ++k)
        rig_image_free(rig, images[k]);
      stage_close(&stage);
      rig_close(rig);
    }
}

/* ---- vertices and indices ---- */

/* How an engine lays a mesh out: positions among other attributes, indices behind them or in another buffer. */
typedef struct mesh_layout {
  uint32_t stride, index_size;
  uint32_t vertex_offset, index_offset; /* of the first position; of the first index, from its buffer's or own begin */
  bool one_buffer;
  int filler; /* of what lies between: NaN or 3e38 */
} mesh_layout;

static const mesh_layout layouts[] = {
    {12, 2, 0, 0, false, 0xff},  {12, 4, 12, 0, true, 0xff}, {16, 4, 8, 64, true, 0x7f},  {20, 2, 4, 0, true, 0xff},
    {32, 2, 64, 8, false, 0xff}, {32, 2, 12, 4, true, 0x7f}, {32, 4, 8, 0, true, 0xff},   {52, 4, 20, 8, false, 0xff},
    {60, 4, 4, 0, false, 0x7f},  {16, 4, 0, 8, false, 0xff}, {2048, 4, 0, 0, true, 0xff},
};

typedef struct engine_mesh {
  rig_buffer vertices, indices;
  csm_mesh mesh;
} engine_mesh;

static engine_mesh make_engine_mesh(stage *stage, const hill *hill, const mesh_layout *layout) {
  const uint32_t vertex_bytes = layout->vertex_offset + HILL_VERTICES * layout->stride;
  const uint32_t index_bytes = HILL_INDICES * layout->index_size;
  const uint32_t begin = layout->index_offset + (layout->one_buffer ? (vertex_bytes + 3) / 4 * 4 : 0);
  const void *indices = layout->index_size == 2 ? (const void *)hill->indices : hill->wide_indices;
  engine_mesh out = {.vertices = rig_buffer_make(stage->rig, RIG_GEOMETRY, vertex_bytes + 4 + begin + index_bytes)};
  char *memory = out.vertices.mapped;
  memset(memory, layout->filler, vertex_bytes);
  for (uint32_t i = 0; i < HILL_VERTICES; ++i)
    memcpy(memory + layout->vertex_offset + (size_t)i * layout->stride, hill->positions[i], sizeof hill->positions[i]);
  if (!layout->one_buffer)
    out.indices = rig_buffer_make(stage->rig, RIG_GEOMETRY, begin + index_bytes);
  const rig_buffer *of_indices = layout->one_buffer ? &out.vertices : &out.indices;
  memcpy((char *)of_indices->mapped + begin, indices, index_bytes);
  rig_native native;
  csm_mesh_info info = {.struct_size = sizeof info,
                        .vertex_count = HILL_VERTICES,
                        .index_count = HILL_INDICES,
                        .index_size = layout->index_size,
                        .bounds_min = {-1, -1, -1},
                        .bounds_max = {1, 1, 1}};
  rig_mesh_give(&(rig_mesh){&out.vertices, of_indices, layout->vertex_offset, layout->stride, begin}, &native, &info);
  const csm_result result = csm_mesh_create(stage->context, &info, &out.mesh);
  if (result)
    fail_msg("%s: %s", csm_result_name(result), csm_last_error(stage->context));
  return out;
}

static void free_engine_mesh(rig *rig, engine_mesh *mesh) {
  rig_buffer_free(rig, &mesh->vertices);
  if (mesh->indices.object)
    rig_buffer_free(rig, &mesh->indices);
}

/* The scene with an instance of each mesh in it; the meshes are destroyed before the frame runs if `brief`. */
static picture draw_meshes(stage *stage, const csm_mesh meshes[2], bool brief) {
  stage->scene.instances[1] = support_instance(meshes[0], -1, 2, 1, 3, 2, 3);
  stage->scene.instances[3] = support_instance(meshes[1], -6, 5, -9, 2, 1, 2);
  rig_begin(stage->rig);
  shot shot = stage_shot(stage, 0);
  stage_render(stage, &shot);
  stage_resolve(stage, &shot, size);
  picture_copy copy = stage_record(stage, size);
  for (int i = 0; brief && i < 2; ++i)
    assert_int_equal(csm_mesh_destroy(stage->context, meshes[i]), CSM_SUCCESS);
  stage_finish(stage);
  return picture_take(stage->rig, &copy);
}

/* Two layouts in each frame. */
static void own_buffers_draw_as_copies(rig_kind kind) {
  enum { LAYOUTS = sizeof layouts / sizeof *layouts };
  engine_mesh meshes[LAYOUTS];
  stage stage;
  hill hill;
  rig *rig = rig_open(kind);
  stage_open(&stage, rig);
  hill_make(&hill);
  picture before = stage_draw_at(&stage, 0, size);
  const csm_mesh copies[2] = {hill_mesh(stage.context, &hill, 4), hill_mesh(stage.context, &hill, 2)};
  picture expected = draw_meshes(&stage, copies, false);
  assert_true(picture_mask_difference(&before, &expected, 1) > 0.01);
  meshes[0] = make_engine_mesh(&stage, &hill, &layouts[0]);
  for (size_t i = 0; i < LAYOUTS; ++i) {
    const bool last = i + 1 == LAYOUTS;
    if (!last)
      meshes[i + 1] = make_engine_mesh(&stage, &hill, &layouts[i + 1]);
    picture drawn =
        draw_meshes(&stage, (const csm_mesh[]){meshes[i].mesh, last ? copies[0] : meshes[i + 1].mesh}, last);
    picture_expect_equal(&expected, &drawn);
    if (!last)
      assert_int_equal(csm_mesh_destroy(stage.context, meshes[i].mesh), CSM_SUCCESS);
  }
  for (size_t i = 0; i < LAYOUTS; ++i)
    free_engine_mesh(rig, &meshes[i]);
  picture_free(&before);
  picture_free(&expected);
  stage_close(&stage);
  rig_close(rig);
}

static void own_buffers_draw_as_copies_on_a_typical_device(void **state) {
  (void)state;
  own_buffers_draw_as_copies(RIG_TYPICAL);
}

static void own_buffers_draw_as_copies_on_a_bare_device(void **state) {
  (void)state;
  own_buffers_draw_as_copies(RIG_BARE);
}

int main(int argc, char **argv) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(own_depth_gives_the_same_mask),
      cmocka_unit_test(maps_for_a_depth_give_the_same_mask),
      cmocka_unit_test(normals_of_every_coding_agree),
      cmocka_unit_test(what_is_shown_instead_needs_no_normals),
      cmocka_unit_test(motion_says_where_a_surface_was),
      cmocka_unit_test(own_buffers_draw_as_copies_on_a_typical_device),
      cmocka_unit_test(own_buffers_draw_as_copies_on_a_bare_device),
  };
  return support_main(argc, argv, tests, sizeof tests / sizeof tests[0]);
}
