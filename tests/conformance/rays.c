/*
 * rays.c: filter exact against rays in doubles: every pixel whose ray does not pass a hair's breadth from an edge is as
 * that ray says, whatever a scene is made of, and whatever has happened to it.
 */
#include "rays_model.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

static const double suns[][3] = {{0.4, -1, 0.25}, {-0.8, -0.7, 0.4}, {0.1, -1, -0.7}, {1, -0.35, 0.2}};
enum { SUNS = sizeof suns / sizeof suns[0] };

static void set_sun(rays_model *m, uint32_t sun) {
  memcpy(m->shot.light.direction, suns[sun % SUNS], sizeof suns[0]);
}

static void look(rays_model *m, double x, double y, double z) {
  support_look_at(m->shot.camera.view, (const double[]){x, y, z}, (const double[]){0, 0.5, -2});
}

static void succeed(const rays_model *m, csm_result result) {
  if (result)
    fail_msg("%s: %s", csm_result_name(result), csm_last_error(m->context));
}

/* That what was compared tells something. */
static void expect_told(rays_model *m, uint32_t pixels) {
  assert_true(!rays_draw() || (m->sure > pixels / 2 && m->dark > pixels / 40));
  m->sure = m->dark = 0;
}

/* ---- pictures ---- */

static void all_suns_and_cameras(void **state) {
  (void)state;
  static const double eyes[][3] = {{-4, 7, 13}, {12, 3, 6}, {-2, 18, -2}};
  rays_model m = {0};
  rays_open(&m, 0, NULL);
  const csm_config config = rays_config();
  csm_cascades *cascades = rays_cascades(&m, &config);
  for (uint32_t i = 0; i < SUNS * 3; ++i) {
    const rays_picture picture = {.cascades = cascades, .list = i % 2};
    set_sun(&m, i);
    look(&m, eyes[i % 3][0], eyes[i % 3][1], eyes[i % 3][2]);
    rays_check(&m, &picture, "a sun and a camera");
    expect_told(&m, RAYS_WIDTH * RAYS_HEIGHT);
  }
  rays_close(&m);
}

/* As it is configured by default maps decide most pixels, and are wrong where something thin lies between texels. */
static void maps_decide_where_they_can(void **state) {
  (void)state;
  rays_model m = {0};
  rays_open(&m, 0, NULL);
  for (uint32_t i = 0; i < 6; ++i) {
    csm_config config = rays_config(), defaults = {.struct_size = sizeof defaults};
    assert_int_equal(csm_config_default(&defaults), CSM_SUCCESS);
    config.ray_unsure_cosine = defaults.ray_unsure_cosine;
    config.ray_grazing_cosine = defaults.ray_grazing_cosine;
    config.resolution = 512;
    config.map_format = i & 1;
    config.map_reversed = i >> 1 & 1;
    config.map_layout = i == 4;
    const rays_picture picture = {.cascades = rays_cascades(&m, &config), .list = i % 2, .most_wrong_percent = 0.3};
    set_sun(&m, i);
    rays_check(&m, &picture, "the defaults");
    expect_told(&m, RAYS_WIDTH * RAYS_HEIGHT);
    succeed(&m, csm_cascades_destroy(picture.cascades));
  }
  rays_close(&m);
}

static void masks_of_any_size(void **state) {
  (void)state;
  static const uint32_t sizes[][2] = {{1, 1}, {7, 1}, {1, 9}, {8, 8}, {65, 63}, {129, 3}, {200, 133}, {16, 16}};
  rays_model m = {0};
  rays_open(&m, 0, NULL);
  const csm_config config = rays_config();
  csm_cascades *cascades = rays_cascades(&m, &config);
  for (size_t i = 0; i < sizeof sizes / sizeof *sizes; ++i) {
    const rays_picture picture = {.cascades = cascades, .width = sizes[i][0], .height = sizes[i][1]};
    rays_check(&m, &picture, "a size");
  }
  expect_told(&m, 200 * 133);
  rays_close(&m);
}

/* A thousand kilometres from the origin, and a mesh whose vertices are as far from their own. */
static void far_from_every_origin(void **state) {
  (void)state;
  static const double places[][3] = {{1e6, 20, -1e6}, {-3e5, 1e5, 7}};
  rays_model m = {0};
  rays_open(&m, 0, NULL);
  const csm_config config = rays_config();
  csm_cascades *cascades = rays_cascades(&m, &config);
  for (int k = 0; k < 2; ++k) {
    const double *to = places[k], *from = k ? places[0] : (const double[]){0, 0, 0};
    double away[3];
    for (int axis = 0; axis < 3; ++axis)
      away[axis] = to[axis] - from[axis];
    for (uint32_t i = 0; i < m.count; ++i) {
      for (int axis = 0; axis < 3; ++axis)
        m.instances[i].transform[12 + axis] += away[axis];
      rays_move(&m, i);
    }
    double *view = m.shot.camera.view;
    for (int axis = 0; axis < 3; ++axis)
      view[12 + axis] -= view[axis] * away[0] + view[4 + axis] * away[1] + view[8 + axis] * away[2];
    for (uint32_t list = 0; list < 2; ++list) {
      const rays_picture picture = {.cascades = cascades, .list = list};
      rays_check(&m, &picture, "far away");
    }
  }
  rays_move_cloth(&m.shapes[SHAPE_CLOTH], 0, 1 << 17);
  rays_update(&m, SHAPE_CLOTH);
  m.instances[8].transform[12] -= m.instances[8].transform[0] * (1 << 17);
  rays_move(&m, 8);
  rays_expect(&m, cascades, "a mesh far from its origin");
  expect_told(&m, 4 * RAYS_WIDTH * RAYS_HEIGHT);
  rays_close(&m);
}

/* ---- what changes ---- */

static void a_scene_changes(void **state) {
  (void)state;
  rays_model m = {0};
  rays_open(&m, 0, NULL);
  const csm_config config = rays_config();
  csm_cascades *cascades = rays_cascades(&m, &config);
  rays_expect(&m, cascades, "at first");
  for (int i = 1; i < 4; ++i) {
    m.instances[i].transform[12] += 1.25 * i;
    m.instances[i].transform[13] += 0.5;
    rays_move(&m, (uint32_t)i);
  }
  rays_expect(&m, cascades, "moved");
  rays_expect(&m, cascades, "as it was");
  m.instances[4].mesh = m.shapes[SHAPE_BOX].mesh;
  m.instances[8].mesh = m.shapes[SHAPE_LEAF].mesh;
  rays_change(&m, 4);
  rays_change(&m, 8);
  rays_expect(&m, cascades, "other meshes");
  rays_remove(&m, 2);
  rays_remove(&m, 1);
  rays_expect(&m, cascades, "removed");
  for (int i = 0; i < 25; ++i) { /* beyond the room that there is */
    const csm_instance one = support_instance(m.shapes[i % 3 ? SHAPE_BOX : SHAPE_WEDGE].mesh, i % 5 * 3 - 7, 0.6,
                                              i / 5 * 3 - 9, 0.4, 0.6, i % 2 ? 0.4 : -0.4);
    rays_add(&m, &one);
  }
  rays_expect(&m, cascades, "added");
  while (m.count > 3)
    rays_remove(&m, m.count / 2);
  rays_expect(&m, cascades, "all but three removed");
  m.instances[1].transform[13] += 40; /* what was fitted becomes another tree */
  m.instances[2].transform[12] -= 30;
  rays_move(&m, 1);
  rays_move(&m, 2);
  rays_expect(&m, cascades, "scattered");
  expect_told(&m, RAYS_WIDTH * RAYS_HEIGHT);
  rays_close(&m);
}

static uint32_t chance(uint64_t *state, uint32_t limit) {
  *state = *state * 6364136223846793005ull + 1442695040888963407ull;
  return (uint32_t)((*state >> 33) % limit);
}

/* Any nine numbers that are neither too flat nor too large; mirrored as often as not. */
static void bend(csm_instance *instance, uint64_t *numbers) {
  double *t = instance->transform;
  for (int column = 0; column < 3; ++column)
    for (int row = 0; row < 3; ++row)
      t[column * 4 + row] = (chance(numbers, 200) / 100.0 - 1) * 0.5 + (row == column ? 1.2 : 0);
  if (chance(numbers, 2))
    for (int row = 0; row < 3; ++row)
      t[row] = -t[row];
}

static void transforms_of_every_kind(void **state) {
  (void)state;
  rays_model m = {0};
  uint64_t numbers = 3;
  rays_open(&m, 0, NULL);
  const csm_config config = rays_config();
  csm_cascades *cascades = rays_cascades(&m, &config);
  for (int step = 0; step < 12; ++step) {
    for (uint32_t i = 1; i < m.count; ++i)
      if (chance(&numbers, 2)) {
        bend(&m.instances[i], &numbers);
        m.instances[i].transform[12] = chance(&numbers, 18) - 9.0;
        m.instances[i].transform[13] = 1.5 + chance(&numbers, 4);
        m.instances[i].transform[14] = chance(&numbers, 20) - 14.0;
        rays_move(&m, i);
      }
    for (int k = 0; k < 3 && step % 3 == 2; ++k) /* one becomes flat, along each of its axes in turn */
      m.instances[4].transform[step / 3 % 3 * 4 + k] = 0;
    rays_move(&m, 4);
    const rays_picture picture = {.cascades = cascades, .list = step % 4 == 3};
    set_sun(&m, (uint32_t)step);
    rays_check(&m, &picture, "bent");
    expect_told(&m, RAYS_WIDTH * RAYS_HEIGHT / 4);
  }
  rays_close(&m);
}

static void flags_and_layers_say_who_casts(void **state) {
  (void)state;
  static const uint32_t flags[] = {CSM_INSTANCE_CAST_ONLY, CSM_INSTANCE_RECEIVE_ONLY, CSM_INSTANCE_HIDDEN, 0};
  static const uint32_t layers[] = {0, 1, 2, 4, 6};
  rays_model m = {0};
  rays_open(&m, 0, NULL);
  const csm_config config = rays_config();
  csm_cascades *cascades = rays_cascades(&m, &config);
  for (uint32_t step = 0; step < 10; ++step) {
    for (uint32_t i = 1; i < m.count; ++i) {
      m.instances[i].flags = flags[(i + step) % 4];
      m.instances[i].layers = layers[(i + step / 2) % 5];
      rays_change(&m, i);
    }
    for (uint32_t light = 0; light < 4; ++light) { /* the scene rests, and the light does not */
      m.shot.light.layers = (const uint32_t[]){0, 1, 2, 5}[light];
      const rays_picture picture = {.cascades = cascades, .list = step == 3};
      if (step % 3 == 0 || light == step % 4)
        rays_check(&m, &picture, "flags and layers");
    }
  }
  expect_told(&m, RAYS_WIDTH * RAYS_HEIGHT);
  rays_close(&m);
}

static void nothing_casts(void **state) {
  (void)state;
  rays_model m = {0};
  rays_open(&m, 0, NULL);
  const csm_config config = rays_config();
  csm_cascades *cascades = rays_cascades(&m, &config);
  rays_model full = m;
  while (m.count)
    rays_remove(&m, 0);
  rays_expect(&m, cascades, "an empty scene");
  full.instances[0].flags = CSM_INSTANCE_RECEIVE_ONLY;
  rays_add(&m, &full.instances[0]);
  rays_expect(&m, cascades, "a receiver alone");
  rays_add(&m, &full.instances[1]);
  rays_expect(&m, cascades, "one caster");
  m.shot.light.layers = 4;
  m.instances[1].layers = 2;
  rays_change(&m, 1);
  rays_expect(&m, cascades, "a caster for another light");
  m.shot.light.layers = 2;
  rays_expect(&m, cascades, "and for this one");
  const rays_picture list = {.cascades = cascades, .list = true};
  m.count = 0;
  rays_check(&m, &list, "an empty list");
  rays_close(&m);
}

/* ---- meshes ---- */

static void meshes_are_updated(void **state) {
  (void)state;
  rays_model m = {0};
  rays_open(&m, 0, NULL);
  const csm_config config = rays_config();
  csm_cascades *cascades = rays_cascades(&m, &config);
  const csm_instance second = support_instance(m.shapes[SHAPE_CLOTH].mesh, 6, 3, 2, 1.5, -1, 1);
  rays_add(&m, &second);
  rays_move_cloth(&m.shapes[SHAPE_CLOTH], 0.3, 0);
  rays_update(&m, SHAPE_CLOTH);
  rays_expect(&m, cascades, "updated before it was ever drawn");
  for (int step = 1; step < 6; ++step) {
    rays_move_cloth(&m.shapes[SHAPE_CLOTH], 0.8 * step, step == 3 ? 2 : 0);
    rays_update(&m, SHAPE_CLOTH);
    if (step % 2) /* twice before a frame: the last counts */
      rays_update(&m, SHAPE_CLOTH);
    const rays_picture picture = {.cascades = cascades, .list = step == 4};
    rays_check(&m, &picture, "updated");
  }
  /* Nothing but a vertex in the middle, so that the bounds stay; then everything turned inside out */
  m.shapes[SHAPE_CLOTH].positions[RAYS_VERTICES / 2][0] += 0.15f;
  rays_update(&m, SHAPE_CLOTH);
  rays_expect(&m, cascades, "a vertex");
  for (int i = 0; i < 8; ++i)
    for (int axis = 0; axis < 3; ++axis)
      m.shapes[SHAPE_BOX].positions[i][axis] *= axis == 1 ? 2.0f : i % 2 ? -1.5f : -0.5f;
  rays_update(&m, SHAPE_BOX);
  rays_expect(&m, cascades, "a box deformed");
  for (int i = 0; i < 4; ++i)
    m.shapes[SHAPE_LEAF].positions[i][1] += i % 2 ? 0.5f : -0.5f;
  rays_update(&m, SHAPE_LEAF);
  rays_expect(&m, cascades, "a leaf bent");
  expect_told(&m, RAYS_WIDTH * RAYS_HEIGHT);
  rays_close(&m);
}

/* Of 2 * side * side triangles, to lie where no ray goes. */
static csm_mesh make_large(rays_model *m, uint32_t side) {
  const uint32_t vertices = (side + 1) * (side + 1), count = side * side * 6;
  float(*positions)[3] = calloc(vertices, sizeof *positions);
  uint32_t *indices = calloc(count, sizeof *indices), *to = indices;
  csm_mesh mesh;
  assert_true(positions && indices);
  for (uint32_t i = 0; i < vertices; ++i) {
    positions[i][0] = (float)(i % (side + 1)) / (float)side;
    positions[i][1] = (float)(i * 7919 % 101) / 500;
    positions[i][2] = (float)(i / (side + 1)) / (float)side;
  }
  for (uint32_t i = 0; i < side * side; ++i, to += 6) {
    const uint32_t a = i / side * (side + 1) + i % side, b = a + side + 1;
    memcpy(to, (const uint32_t[]){a, b, a + 1, a + 1, b, b + 1}, 6 * sizeof *to);
  }
  const csm_mesh_info info = {.struct_size = sizeof info,
                              .positions = positions,
                              .vertex_count = vertices,
                              .indices = indices,
                              .index_count = count,
                              .index_size = 4};
  succeed(m, csm_mesh_create(m->context, &info, &mesh));
  free(positions);
  free(indices);
  return mesh;
}

/* Trees need more room than there is, again and again, before the first frame, between two, and several times at once. */
static void trees_need_more_and_more_room(void **state) {
  (void)state;
  enum { LARGE = 9 };
  rays_model m = {0};
  rays_open(&m, 0, NULL);
  csm_mesh large[LARGE] = {make_large(&m, 110)};
  const csm_config config = rays_config();
  csm_cascades *cascades = rays_cascades(&m, &config);
  rays_expect(&m, cascades, "before the first frame");
  for (uint32_t i = 1; i < LARGE; ++i) {
    large[i] = make_large(&m, 60 + 25 * i);
    if (i == 4) /* what is on its way goes along */
      rays_update(&m, SHAPE_CLOTH);
    const csm_instance deep = support_instance(large[i], i, -3, -5, 1, 1, 1);
    rays_add(&m, &deep);
    if (i != 4 && i != 5)
      rays_expect(&m, cascades, "more room");
  }
  for (uint32_t i = 0; i < LARGE; i += 2) {
    if (i)
      rays_remove(&m, m.count - LARGE + i);
    succeed(&m, csm_mesh_destroy(m.context, large[i]));
    rays_expect(&m, cascades, "less room");
  }
  large[0] = make_large(&m, 120); /* where one was */
  rays_expect(&m, cascades, "more room again");
  expect_told(&m, RAYS_WIDTH * RAYS_HEIGHT);
  rays_close(&m);
}

/* Meshes go, and others come to where their trees were, while frames are on their way. */
static void meshes_come_and_go(void **state) {
  (void)state;
  rays_model m = {0};
  rays_open(&m, 0, NULL);
  const csm_config config = rays_config();
  csm_cascades *cascades = rays_cascades(&m, &config);
  for (int step = 0; step < 8; ++step) {
    const uint32_t place = SHAPES + (uint32_t)step % 4, kind = (uint32_t)step % 2 ? SHAPE_CLOTH : SHAPE_LEAF;
    rays_shape *shape = &m.shapes[place];
    if (shape->mesh) {
      rays_remove(&m, m.count - 4);
      succeed(&m, csm_mesh_destroy(m.context, shape->mesh));
    }
    *shape = m.shapes[kind];
    for (uint32_t i = 0; i < shape->vertex_count; ++i)
      shape->positions[i][1] += (float)(0.2 * step * shape->positions[i][0]);
    rays_make_mesh(&m, place);
    const csm_instance one = support_instance(shape->mesh, step % 4 * 4 - 6, 3.5, step / 4 * 3, 1.5, 1, 1);
    rays_add(&m, &one);
    rays_expect(&m, cascades, "another mesh");
  }
  expect_told(&m, RAYS_WIDTH * RAYS_HEIGHT);
  rays_close(&m);
}

static void casters_are_cut_out(void **state) {
  (void)state;
  for (uint32_t mode = 0; mode < 9; ++mode) {
    rays_model m = {.wrap_u = mode % 3, .wrap_v = mode / 3};
    rays_open(&m, 0, NULL);
    const csm_config config = rays_config();
    csm_cascades *cascades = rays_cascades(&m, &config);
    m.shapes[SHAPES] = m.shapes[SHAPE_LEAF];
    m.shapes[SHAPES].cutoff = mode % 2 ? 0.65f : 1.0f / 255;
    rays_make_mesh(&m, SHAPES);
    const csm_instance other = support_instance(m.shapes[SHAPES].mesh, -6, 5, -4, 2.5, -1, 2.5);
    rays_add(&m, &other);
    look(&m, 1, 9, 9);
    rays_expect(&m, cascades, "leaves");
    expect_told(&m, RAYS_WIDTH * RAYS_HEIGHT);
    rays_close(&m);
  }
}

/* Layers over each other, each cut out at other places, so that a ray passes many holes before it meets something. */
static void make_crown(rays_shape *crown) {
  enum { layers = RAYS_VERTICES / 4 };
  const rays_shape leaf = *crown;
  crown->vertex_count = crown->index_count = 0;
  for (uint16_t layer = 0; layer < layers; ++layer) {
    for (uint16_t i = 0; i < leaf.index_count; ++i)
      crown->indices[crown->index_count++] = (uint16_t)(leaf.indices[i] + 4 * layer);
    for (int i = 0; i < 4; ++i, ++crown->vertex_count) {
      float *at = crown->positions[crown->vertex_count], *uv = crown->uvs[crown->vertex_count];
      memcpy(at, leaf.positions[i], sizeof leaf.positions[i]);
      at[1] += 0.15f * layer;
      uv[0] = leaf.uvs[i][0] + 0.21f * layer;
      uv[1] = leaf.uvs[i][1] + 0.13f * layer;
    }
  }
  crown->cutoff = 0.85f;
}

static void rays_pass_holes(void **state) {
  (void)state;
  rays_model m = {.wrap_u = 0};
  rays_open(&m, 0, NULL);
  const csm_config config = rays_config();
  csm_cascades *cascades = rays_cascades(&m, &config);
  m.shapes[SHAPES] = m.shapes[SHAPE_LEAF];
  make_crown(&m.shapes[SHAPES]);
  rays_make_mesh(&m, SHAPES);
  const csm_instance crowns[] = {support_instance(m.shapes[SHAPES].mesh, -5, 3, 2, 4, 1, 4),
                                 support_instance(m.shapes[SHAPES].mesh, -3, 7, 1, 3, -1, 4)};
  for (size_t i = 0; i < sizeof crowns / sizeof *crowns; ++i)
    rays_add(&m, &crowns[i]);
  for (uint32_t sun = 0; sun < 3; ++sun) {
    set_sun(&m, sun);
    rays_expect(&m, cascades, "a crown");
    expect_told(&m, RAYS_WIDTH * RAYS_HEIGHT);
  }
  rays_close(&m);
}

/* ---- settings, views and devices ---- */

static void configurations_come_and_go(void **state) {
  (void)state;
  rays_model m = {0};
  rays_open(&m, 0, NULL);
  const csm_config config = rays_config();
  csm_config other = config;
  csm_cascades *cascades = rays_cascades(&m, &config);
  rays_expect(&m, cascades, "exact");
  for (int step = 0; step < 4; ++step) {
    const rays_picture picture = {.cascades = cascades};
    other.filter = step == 1 ? CSM_FILTER_EXACT_SOFT : CSM_FILTER_PCF_3X3;
    other.history = step == 2 ? CSM_HISTORY_ON : CSM_HISTORY_OFF;
    other.soft_radius_max_texels = 8;
    succeed(&m, csm_cascades_configure(cascades, &other));
    if (step != 3)
      free(rays_mask(&m, &picture));
    m.instances[2].transform[12] -= 1;
    rays_move(&m, 2);
    if (step != 0)
      free(rays_mask(&m, &picture));
    succeed(&m, csm_cascades_configure(cascades, &config));
    rays_expect(&m, cascades, "exact again");
  }
  expect_told(&m, RAYS_WIDTH * RAYS_HEIGHT);
  rays_close(&m);
}

/* Two suns, each with layers of its own, and two views, in turn. */
static void cascades_share_a_scene(void **state) {
  (void)state;
  rays_model m = {0};
  rays_open(&m, 0, NULL);
  const csm_config config = rays_config();
  csm_cascades *cascades[2] = {rays_cascades(&m, &config), rays_cascades(&m, &config)};
  csm_view *views[2] = {m.view, support_view(m.context)};
  for (uint32_t i = 1; i < m.count; ++i) {
    m.instances[i].layers = 1 + i % 3;
    rays_change(&m, i);
  }
  for (uint32_t step = 0; step < 8; ++step) {
    const rays_picture picture = {.cascades = cascades[step % 2],
                                  .view = views[step / 2 % 2],
                                  .width = step / 2 % 2 ? 50 : 0,
                                  .height = step / 2 % 2 ? 33 : 0};
    set_sun(&m, step % 2);
    m.shot.light.layers = 1 + step % 2;
    if (step % 3 == 2) {
      m.instances[2].transform[14] += 0.75;
      rays_move(&m, 2);
    }
    rays_check(&m, &picture, "two suns");
  }
  expect_told(&m, RAYS_WIDTH * RAYS_HEIGHT);
  rays_close(&m);
}

static const char *other_backend(void) {
  const char *mine = support_backend();
  return !strcmp(mine, "vulkan") ? "d3d12" : !strcmp(mine, "d3d12") ? "vulkan" : mine;
}

static void switch_to(rays_model *m, const char *backend) {
  csm_create_info info = support_create_info(&m->record);
  info.backend = backend;
  succeed(m, csm_switch_backend(m->context, &info));
}

static void a_switch_takes_trees_along(void **state) {
  (void)state;
  rays_model m = {0};
  rays_open(&m, CSM_CREATE_KEEP_GEOMETRY, NULL);
  const csm_config config = rays_config();
  csm_cascades *cascades = rays_cascades(&m, &config);
  for (int step = 0; step < 4; ++step) {
    rays_move_cloth(&m.shapes[SHAPE_CLOTH], 0.7 * step, 0);
    rays_update(&m, SHAPE_CLOTH);
    rays_expect(&m, cascades, "before a switch");
    if (step % 2) { /* changed, and not drawn */
      m.instances[1].transform[12] += 1;
      rays_move(&m, 1);
    }
    switch_to(&m, step % 2 ? support_backend() : other_backend());
    rays_expect(&m, cascades, "after a switch");
  }
  expect_told(&m, RAYS_WIDTH * RAYS_HEIGHT);
  rays_close(&m);
}

static csm_result CSM_CALL supply(void *user, csm_mesh mesh, csm_mesh_info *info) {
  const rays_model *m = user;
  for (uint32_t i = 0; i < SHAPES; ++i)
    if (m->shapes[i].mesh == mesh)
      *info = rays_mesh_info(m, i);
  return CSM_SUCCESS;
}

/* What is supplied may lie elsewhere than it did, and its tree is another. */
static void a_switch_makes_trees_of_what_is_supplied(void **state) {
  (void)state;
  rays_model m = {0};
  rays_open(&m, 0, supply);
  const csm_config config = rays_config();
  csm_cascades *cascades = rays_cascades(&m, &config);
  rays_expect(&m, cascades, "before a switch");
  for (int step = 0; step < 2; ++step) {
    rays_move_cloth(&m.shapes[SHAPE_CLOTH], 1.1 + step, step);
    for (int i = 0; i < 8; ++i)
      m.shapes[SHAPE_BOX].positions[i][1] *= 1.5f;
    switch_to(&m, step % 2 ? support_backend() : other_backend());
    rays_expect(&m, cascades, "supplied");
  }
  expect_told(&m, RAYS_WIDTH * RAYS_HEIGHT);
  rays_close(&m);
}

/* ---- soft ---- */

/* Rays to the disc: what all of them see, or none, is so; between, their share is near that of many more. */
static void soft_shadows_are_shares_of_the_disc(void **state) {
  (void)state;
  enum { PIXELS = RAYS_WIDTH * RAYS_HEIGHT };
  static float seen[PIXELS];
  rays_model m = {0};
  rays_open(&m, 0, NULL);
  m.shot.light.angular_diameter = 0.08;
  csm_config config = rays_config();
  config.filter = CSM_FILTER_EXACT_SOFT;
  config.resolution = 512;
  config.ray_taps = 64;
  config.soft_radius_max_texels = 64;
  const rays_picture picture = {.cascades = rays_cascades(&m, &config)};
  float *mask = rays_mask(&m, &picture);
  float *depth = support_image(m.context, m.view, CSM_READ_CAMERA_DEPTH, RAYS_WIDTH, RAYS_HEIGHT);
  uint32_t between = 0, wrong = 0;
  double sum = 0;
  if (rays_draw())
    rays_seen(&m, depth, 256, seen);
  for (int i = 0; i < PIXELS && rays_draw(); ++i) {
    if (seen[i] < 0)
      continue;
    const bool inside = seen[i] > 0.01f && seen[i] < 0.99f;
    between += inside;
    sum += inside ? (double)fabsf(mask[i] - seen[i]) : 0;
    wrong += fabsf(mask[i] - seen[i]) > 0.12f;
  }
  if (rays_draw()) {
    print_message("%u pixels in penumbrae, off by %.4f in the mean; %u are far off\n", between, sum / between, wrong);
    assert_true(between > PIXELS / 50);
    assert_true(sum / between < 0.02 && wrong < PIXELS / 200);
  }
  free(mask);
  free(depth);
  rays_close(&m);
}

/* How a pixel's depth goes on along an axis, `step` pixels apart in the picture; false: not told for sure. */
static bool slope_at(const float *depth, int at, int step, double *out) {
  const double back = (double)depth[at] - depth[at - step], on = (double)depth[at + step] - depth[at];
  const double bend_back = fabs(back - ((double)depth[at - step] - depth[at - 2 * step]));
  const double bend_on = fabs(((double)depth[at + 2 * step] - depth[at + step]) - on);
  *out = bend_back < bend_on ? back : on;
  return fmin(bend_back, bend_on) < 0.5 * fmax(bend_back, bend_on) || fabs(back - on) < 1e-6;
}

/* What a pixel becomes of what masks without sharing have, in 255ths; -1: it is too close to call. */
static int shared_level(const int *own, const float *depth, int at, uint32_t rays) {
  int64_t count = 0, sum = 0, squares = 0;
  double right, down;
  if (!slope_at(depth, at, 1, &right) || !slope_at(depth, at, RAYS_WIDTH, &down))
    return -1;
  const double room = 0.25 * (fabs(right) + fabs(down));
  for (int y = -1; y <= 1; ++y)
    for (int x = -1; x <= 1; ++x) {
      const int beside = at + y * RAYS_WIDTH + x;
      const double off = fabs(depth[beside] - (depth[at] + x * right + y * down));
      if (off > 0.7 * room - 2e-6 && off < 1.3 * room + 2e-6 && beside != at)
        return -1;
      if (off > room && beside != at)
        continue;
      ++count;
      sum += own[beside];
      squares += own[beside] * own[beside];
    }
  const bool chance = rays * (count * squares - sum * sum) <= sum * (255 * count - sum);
  return chance ? (int)((2 * sum + count) / (2 * count)) : own[at];
}

static int *levels_of(rays_model *m, csm_cascades *cascades, uint32_t show) {
  const csm_mask_info info = {.struct_size = sizeof info,
                              .frame = shot_frame(&m->shot),
                              .width = RAYS_WIDTH,
                              .height = RAYS_HEIGHT,
                              .show = show};
  succeed(m, csm_resolve_mask(m->view, cascades, &info));
  float *mask = support_image(m->context, m->view, CSM_READ_MASK, RAYS_WIDTH, RAYS_HEIGHT);
  int *levels = malloc(RAYS_WIDTH * RAYS_HEIGHT * sizeof *levels);
  assert_non_null(levels);
  for (int i = 0; i < RAYS_WIDTH * RAYS_HEIGHT; ++i)
    levels[i] = (int)lroundf(mask[i] * 255);
  free(mask);
  return levels;
}

static csm_config few_rays(void) {
  csm_config config = rays_config();
  config.filter = CSM_FILTER_EXACT_SOFT;
  config.resolution = 512;
  config.ray_taps = 4;
  config.ray_grazing_cosine = 0;
  config.soft_radius_max_texels = 64;
  return config;
}

/* Every pixel is what the rule makes of it, and noise falls by a quarter at least. */
static void pixels_share_what_rays_found(void **state) {
  (void)state;
  enum { PIXELS = RAYS_WIDTH * RAYS_HEIGHT };
  static float seen[PIXELS];
  rays_model m = {0};
  rays_open(&m, 0, NULL);
  m.shot.light.angular_diameter = 0.4;
  m.shot.frame.scene = m.scene;
  csm_config config = few_rays();
  csm_cascades *cascades = rays_cascades(&m, &config);
  succeed(&m, csm_render_cascades(cascades, shot_frame(&m.shot)));
  int *own = levels_of(&m, cascades, CSM_SHOW_VISIBILITY), *asked = levels_of(&m, cascades, CSM_SHOW_RAYS);
  float *depth = support_image(m.context, m.view, CSM_READ_CAMERA_DEPTH, RAYS_WIDTH, RAYS_HEIGHT);
  config.ray_share = 1;
  succeed(&m, csm_cascades_configure(cascades, &config));
  succeed(&m, csm_render_cascades(cascades, shot_frame(&m.shot)));
  int *shared = levels_of(&m, cascades, CSM_SHOW_VISIBILITY), *viewed = levels_of(&m, cascades, CSM_SHOW_RAYS);
  if (rays_draw()) {
    uint32_t sure = 0, mixed = 0, all = 0;
    double before = 0, after = 0;
    rays_seen(&m, depth, 256, seen);
    assert_memory_equal(asked, viewed, PIXELS * sizeof *asked);
    for (int at = 0; at < PIXELS; ++at) {
      const int x = at % RAYS_WIDTH, y = at / RAYS_WIDTH;
      if (!asked[at])
        assert_int_equal(shared[at], own[at]);
      if (!asked[at] || seen[at] < 0)
        continue;
      before += pow(own[at] / 255.0 - (double)seen[at], 2);
      after += pow(shared[at] / 255.0 - (double)seen[at], 2);
      ++all;
      if (x < 2 || y < 2 || x > RAYS_WIDTH - 3 || y > RAYS_HEIGHT - 3)
        continue;
      const int expected = shared_level(own, depth, at, config.ray_taps);
      if (expected < 0)
        continue;
      if (shared[at] != expected)
        fail_msg("pixel %d, %d: %d, not %d; %d by itself", x, y, shared[at], expected, own[at]);
      ++sure;
      mixed += expected != own[at];
    }
    print_message("%u pixels asked, %u sure, %u of them mixed; off by %.4f, shared by %.4f\n", all, sure, mixed,
                  sqrt(before / all), sqrt(after / all));
    assert_true(sure > all / 2 && mixed > sure / 4);
    assert_true(sqrt(after) < 0.75 * sqrt(before));
  }
  free(viewed);
  free(shared);
  free(depth);
  free(asked);
  free(own);
  rays_close(&m);
}

/* Frames share by themselves. */
static void a_history_shares_no_rays(void **state) {
  (void)state;
  rays_model m = {0};
  rays_open(&m, 0, NULL);
  m.shot.light.angular_diameter = 0.08;
  float *masks[2];
  for (uint32_t share = 0; share < 2; ++share) {
    csm_config config = few_rays();
    config.history = CSM_HISTORY_ON;
    config.ray_share = share;
    const rays_picture picture = {.cascades = rays_cascades(&m, &config), .view = support_view(m.context)};
    masks[share] = rays_mask(&m, &picture);
  }
  assert_memory_equal(masks[0], masks[1], RAYS_WIDTH * RAYS_HEIGHT * sizeof **masks);
  free(masks[0]);
  free(masks[1]);
  rays_close(&m);
}

int main(int argc, char **argv) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(all_suns_and_cameras),
      cmocka_unit_test(maps_decide_where_they_can),
      cmocka_unit_test(masks_of_any_size),
      cmocka_unit_test(far_from_every_origin),
      cmocka_unit_test(a_scene_changes),
      cmocka_unit_test(transforms_of_every_kind),
      cmocka_unit_test(flags_and_layers_say_who_casts),
      cmocka_unit_test(nothing_casts),
      cmocka_unit_test(meshes_are_updated),
      cmocka_unit_test(trees_need_more_and_more_room),
      cmocka_unit_test(meshes_come_and_go),
      cmocka_unit_test(casters_are_cut_out),
      cmocka_unit_test(rays_pass_holes),
      cmocka_unit_test(configurations_come_and_go),
      cmocka_unit_test(cascades_share_a_scene),
      cmocka_unit_test(a_switch_takes_trees_along),
      cmocka_unit_test(a_switch_makes_trees_of_what_is_supplied),
      cmocka_unit_test(soft_shadows_are_shares_of_the_disc),
      cmocka_unit_test(pixels_share_what_rays_found),
      cmocka_unit_test(a_history_shares_no_rays),
  };
  return support_main(argc, argv, tests, sizeof tests / sizeof tests[0]);
}
