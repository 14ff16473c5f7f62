#include "rays_model.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

enum { MOST_TRIANGLES = 3000, FOGS = 8, texels_u = 7, texels_v = 5 };

static const double shadow_distance = 60;

bool rays_draw(void) {
  return strcmp(support_backend(), "null") != 0;
}

static void succeed(const rays_model *m, csm_result result) {
  if (result)
    fail_msg("%s: %s", csm_result_name(result), csm_last_error(m->context));
}

/* ---- shapes ---- */

static const float ground_positions[4][3] = {{-1, 0, -1}, {1, 0, -1}, {1, 0, 1}, {-1, 0, 1}};
static const uint16_t ground_indices[6] = {0, 2, 1, 0, 3, 2};
static const float box_positions[8][3] = {{-1, -1, -1}, {1, -1, -1}, {1, 1, -1}, {-1, 1, -1},
                                          {-1, -1, 1},  {1, -1, 1},  {1, 1, 1},  {-1, 1, 1}};
static const uint16_t box_indices[36] = {0, 2, 1, 0, 3, 2, 4, 5, 6, 4, 6, 7, 0, 1, 5, 0, 5, 4,
                                         3, 7, 6, 3, 6, 2, 0, 4, 7, 0, 7, 3, 1, 2, 6, 1, 6, 5};
static const float wedge_positions[4][3] = {{-1, 0, -1}, {1, 0, -1}, {-1, 0, 1}, {-1, 3, -1}};
static const uint16_t wedge_indices[12] = {0, 1, 2, 0, 3, 1, 0, 2, 3, 1, 3, 2};
/* Its texture goes beyond the mask on every side, so that wrapping shows. */
static const float leaf_uvs[4][2] = {{-1.25f, -0.5f}, {2.5f, -0.5f}, {2.5f, 1.75f}, {-1.25f, 1.75f}};

static void put_shape(rays_shape *shape, const float (*positions)[3], uint32_t vertices, const uint16_t *indices,
                      uint32_t count) {
  shape->vertex_count = vertices;
  shape->index_count = count;
  memcpy(shape->positions, positions, vertices * sizeof *positions);
  memcpy(shape->indices, indices, count * sizeof *indices);
}

void rays_move_cloth(rays_shape *cloth, double time, double away) {
  for (int i = 0; i < RAYS_VERTICES; ++i) {
    const double x = (double)(i % RAYS_SIDE) / (RAYS_SIDE - 1) * 2 - 1,
                 z = (double)(i / RAYS_SIDE) / (RAYS_SIDE - 1) * 2 - 1;
    cloth->positions[i][0] = (float)(x + away);
    cloth->positions[i][1] = (float)(0.5 * cos(2 * x + time) * cos(1.7 * z - 0.5 * time));
    cloth->positions[i][2] = (float)(z * (1 + 0.1 * time));
  }
}

static void make_cloth(rays_shape *cloth) {
  uint16_t *out = cloth->indices;
  cloth->vertex_count = RAYS_VERTICES;
  cloth->index_count = RAYS_INDICES;
  for (uint16_t row = 0; row + 1 < RAYS_SIDE; ++row)
    for (uint16_t column = 0; column + 1 < RAYS_SIDE; ++column, out += 6) {
      const uint16_t a = (uint16_t)(row * RAYS_SIDE + column), b = (uint16_t)(a + RAYS_SIDE);
      memcpy(out, (const uint16_t[]){a, b, (uint16_t)(a + 1), (uint16_t)(a + 1), b, (uint16_t)(b + 1)}, 12);
    }
  rays_move_cloth(cloth, 0, 0);
}

csm_mesh_info rays_mesh_info(const rays_model *m, uint32_t shape) {
  const rays_shape *s = &m->shapes[shape];
  csm_mesh_info info = {.struct_size = sizeof info,
                        .flags = CSM_MESH_TWO_SIDED,
                        .positions = s->positions,
                        .vertex_count = s->vertex_count,
                        .indices = s->indices,
                        .index_count = s->index_count,
                        .index_size = 2};
  if (s->cut_out) {
    info.alpha_mask = m->alpha_mask;
    info.uvs = s->uvs;
    info.alpha_cutoff = s->cutoff;
  }
  return info;
}

void rays_make_mesh(rays_model *m, uint32_t shape) {
  const csm_mesh_info info = rays_mesh_info(m, shape);
  succeed(m, csm_mesh_create(m->context, &info, &m->shapes[shape].mesh));
}

void rays_update(rays_model *m, uint32_t shape) {
  const csm_mesh_update_info info = {.struct_size = sizeof info, .positions = m->shapes[shape].positions};
  succeed(m, csm_mesh_update(m->context, m->shapes[shape].mesh, &info));
}

static void make_shapes(rays_model *m) {
  rays_shape *s = m->shapes;
  for (int i = 0; i < RAYS_TEXELS; ++i)
    m->texels[i] = (uint8_t)((i % texels_u * 89 + i / texels_u * 151 + i % texels_u * (i / texels_u) * 37) % 256);
  const csm_alpha_mask_info mask = {.struct_size = sizeof mask,
                                    .width = texels_u,
                                    .height = texels_v,
                                    .wrap_u = m->wrap_u,
                                    .wrap_v = m->wrap_v,
                                    .texels = m->texels};
  succeed(m, csm_alpha_mask_create(m->context, &mask, &m->alpha_mask));
  put_shape(&s[SHAPE_GROUND], ground_positions, 4, ground_indices, 6);
  put_shape(&s[SHAPE_BOX], box_positions, 8, box_indices, 36);
  put_shape(&s[SHAPE_WEDGE], wedge_positions, 4, wedge_indices, 12);
  put_shape(&s[SHAPE_LEAF], ground_positions, 4, ground_indices, 6);
  memcpy(s[SHAPE_LEAF].uvs, leaf_uvs, sizeof leaf_uvs);
  s[SHAPE_LEAF].cut_out = true;
  s[SHAPE_LEAF].cutoff = 0.4f;
  make_cloth(&s[SHAPE_CLOTH]);
  for (uint32_t i = 0; i < SHAPES; ++i)
    rays_make_mesh(m, i);
}

/* ---- the model ---- */

void rays_add(rays_model *m, const csm_instance *instance) {
  assert_true(m->count < RAYS_INSTANCES);
  m->instances[m->count] = *instance;
  const csm_scene_batch batch = {
      .struct_size = sizeof batch, .count = 1, .ids = &m->ids[m->count], .instances = instance};
  succeed(m, csm_scene_add(m->scene, &batch));
  ++m->count;
}

void rays_remove(rays_model *m, uint32_t place) {
  succeed(m, csm_scene_remove(m->scene, 1, &m->ids[place]));
  --m->count;
  memmove(m->instances + place, m->instances + place + 1, (m->count - place) * sizeof *m->instances);
  memmove(m->ids + place, m->ids + place + 1, (m->count - place) * sizeof *m->ids);
}

void rays_move(rays_model *m, uint32_t place) {
  const csm_scene_batch batch = {
      .struct_size = sizeof batch, .count = 1, .ids = &m->ids[place], .matrices = m->instances[place].transform};
  succeed(m, csm_scene_move(m->scene, &batch));
}

void rays_change(rays_model *m, uint32_t place) {
  const csm_scene_batch batch = {
      .struct_size = sizeof batch, .count = 1, .ids = &m->ids[place], .instances = &m->instances[place]};
  succeed(m, csm_scene_change(m->scene, &batch));
}

static void fill_scene(rays_model *m) {
  const rays_shape *s = m->shapes;
  const csm_mesh box = s[SHAPE_BOX].mesh, wedge = s[SHAPE_WEDGE].mesh;
  csm_instance sheared = support_instance(box, -6, 1.5, -8, 2, 1, 1);
  sheared.transform[4] = 0.7;
  sheared.transform[2] = 0.5;
  const csm_instance all[] = {
      support_instance(s[SHAPE_GROUND].mesh, 0, 0, 0, 40, 1, 40),
      support_instance(box, 0, 1, 0, 1, 1, 1),
      support_instance(box, 4, 2, -6, -1.5, 2, 1),
      sheared,
      support_instance(wedge, -3, 0, 3, 1, 1, 1),
      support_instance(wedge, 3, 0, 4, -1, 0.7, 1),
      support_instance(wedge, 8, 0, -14, 2, 1.5, -2),
      support_instance(s[SHAPE_LEAF].mesh, 1, 6, -3, 3, 1, 3),
      support_instance(s[SHAPE_CLOTH].mesh, -5, 4, 0, 2, 1, 2),
      support_instance(box, 1, 25, -12, 4, 0.6, 4),
  };
  for (size_t i = 0; i < sizeof all / sizeof *all; ++i)
    rays_add(m, &all[i]);
}

void rays_open(rays_model *m, uint32_t flags, csm_supply_function supply) {
  csm_create_info info = support_create_info(&m->record);
  info.flags |= flags | CSM_CREATE_RAYS;
  info.supply = supply;
  assert_int_equal(csm_create(&info, &m->context), CSM_SUCCESS);
  m->view = support_view(m->context);
  m->shot = shot_make(NULL, 0);
  memcpy(m->shot.light.direction, (const double[]){0.4, -1, 0.25}, sizeof m->shot.light.direction);
  support_look_at(m->shot.camera.view, (const double[]){-4, 7, 13}, (const double[]){0, 0, -3});
  support_perspective(m->shot.camera.projection, 55, 1.5, 0.25, 0);
  succeed(m, csm_scene_create(m->context, &m->scene));
  make_shapes(m);
  fill_scene(m);
}

void rays_close(rays_model *m) {
  support_close(m->context, &m->record);
}

csm_config rays_config(void) {
  csm_config config = support_config();
  config.shadow_distance = shadow_distance;
  config.filter = CSM_FILTER_EXACT;
  config.ray_unsure_cosine = 1;
  config.ray_grazing_cosine = 1;
  return config;
}

csm_cascades *rays_cascades(rays_model *m, const csm_config *config) {
  csm_cascades *cascades;
  succeed(m, csm_cascades_create(m->context, config, &cascades));
  return cascades;
}

/* ---- triangles ---- */

typedef struct triangle {
  double corners[3][3], uvs[3][2], normal[3];
  double low[2], high[2]; /* of its corners, as the light sees them */
  const rays_shape *shape;
} triangle;

/* A box; of an instance so flat that rays cannot look into it, where maps decide. */
typedef struct fog {
  double low[3], high[3];
} fog;

typedef struct world {
  const rays_model *model;
  uint32_t count, fogs;
  triangle triangles[MOST_TRIANGLES];
  fog fog[FOGS];
  double to_light[3], right[3], up[3];
} world;

static double dot(const double a[3], const double b[3]) {
  return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}

static void cross(double out[3], const double a[3], const double b[3]) {
  for (int i = 0; i < 3; ++i)
    out[i] = a[(i + 1) % 3] * b[(i + 2) % 3] - a[(i + 2) % 3] * b[(i + 1) % 3];
}

static double normalise(double v[3]) {
  const double length = sqrt(dot(v, v));
  for (int i = 0; i < 3 && length > 0; ++i)
    v[i] /= length;
  return length;
}

static void difference(double out[3], const double a[3], const double b[3]) {
  for (int i = 0; i < 3; ++i)
    out[i] = a[i] - b[i];
}

static const rays_shape *shape_of(const rays_model *m, csm_mesh mesh) {
  for (uint32_t i = 0; i < RAYS_SHAPES; ++i)
    if (m->shapes[i].mesh == mesh)
      return &m->shapes[i];
  return NULL; /* a mesh that lies where no ray goes */
}

static bool is_flat(const double t[16]) {
  double across[3];
  cross(across, &t[0], &t[4]);
  return fabs(dot(across, &t[8])) < 1e-9;
}

static void add_fog(world *w, const csm_instance *instance, const rays_shape *shape) {
  assert_true(w->fogs < FOGS);
  fog *fog = &w->fog[w->fogs++];
  for (int axis = 0; axis < 3; ++axis) {
    fog->low[axis] = INFINITY;
    fog->high[axis] = -INFINITY;
  }
  for (uint32_t i = 0; i < shape->vertex_count; ++i) {
    const float *p = shape->positions[i];
    double at[3];
    support_apply(instance->transform, (const double[]){(double)p[0], (double)p[1], (double)p[2]}, at);
    for (int axis = 0; axis < 3; ++axis) {
      fog->low[axis] = fmin(fog->low[axis], at[axis] - 0.5);
      fog->high[axis] = fmax(fog->high[axis], at[axis] + 0.5);
    }
  }
}

static void add_triangles(world *w, const csm_instance *instance, const rays_shape *shape) {
  for (uint32_t i = 0; i < shape->index_count; i += 3) {
    assert_true(w->count < MOST_TRIANGLES);
    triangle *t = &w->triangles[w->count++];
    double first[3], second[3];
    t->shape = shape;
    for (int k = 0; k < 3; ++k) {
      const uint16_t vertex = shape->indices[i + (uint32_t)k];
      const float *p = shape->positions[vertex];
      support_apply(instance->transform, (const double[]){(double)p[0], (double)p[1], (double)p[2]}, t->corners[k]);
      t->uvs[k][0] = (double)shape->uvs[vertex][0];
      t->uvs[k][1] = (double)shape->uvs[vertex][1];
    }
    difference(first, t->corners[1], t->corners[0]);
    difference(second, t->corners[2], t->corners[0]);
    cross(t->normal, first, second);
    normalise(t->normal);
  }
}

/* A ray's direction to the light, and two across it. */
static void turn_to(world *w, const double to_light[3]) {
  memcpy(w->to_light, to_light, sizeof w->to_light);
  normalise(w->to_light);
  cross(w->right, w->to_light, fabs(w->to_light[1]) < 0.9 ? (const double[]){0, 1, 0} : (const double[]){1, 0, 0});
  normalise(w->right);
  cross(w->up, w->to_light, w->right);
}

/* Where triangles lie in the light's eyes. */
static void flatten(world *w) {
  for (uint32_t i = 0; i < w->count; ++i) {
    triangle *t = &w->triangles[i];
    for (int axis = 0; axis < 2; ++axis) {
      const double *along = axis ? w->up : w->right;
      const double a = dot(t->corners[0], along), b = dot(t->corners[1], along), c = dot(t->corners[2], along);
      t->low[axis] = fmin(fmin(a, b), c);
      t->high[axis] = fmax(fmax(a, b), c);
    }
  }
}

static world *make_world(const rays_model *m) {
  world *w = calloc(1, sizeof *w);
  const csm_light *light = &m->shot.light;
  assert_non_null(w);
  w->model = m;
  turn_to(w, (const double[]){-light->direction[0], -light->direction[1], -light->direction[2]});
  for (uint32_t i = 0; i < m->count; ++i) {
    const csm_instance *instance = &m->instances[i];
    const rays_shape *shape = shape_of(m, instance->mesh);
    const bool meets = !light->layers || !instance->layers || light->layers & instance->layers;
    if (!shape || !meets || instance->flags & (CSM_INSTANCE_RECEIVE_ONLY | CSM_INSTANCE_HIDDEN))
      continue;
    (is_flat(instance->transform) ? add_fog : add_triangles)(w, instance, shape);
  }
  flatten(w);
  return w;
}

/* ---- rays ---- */

typedef enum answer { LIT, DARK, UNSURE } answer;

/* Whether a cut-out triangle is there where a ray meets it. */
static answer is_there(const world *w, const triangle *t, const double shares[3]) {
  const rays_model *m = w->model;
  double uv[2] = {0, 0};
  for (int i = 0; i < 2; ++i)
    for (int k = 0; k < 3; ++k)
      uv[i] += t->uvs[k][i] * shares[k];
  const support_texture texture = {m->texels, texels_u, texels_v, texels_u, m->wrap_u, m->wrap_v};
  const double alpha = support_alpha(&texture, uv[0], uv[1]), over = alpha - (double)t->shape->cutoff;
  return fabs(over) < 0.01 ? UNSURE : over > 0 ? DARK : LIT;
}

/*
 * Of one triangle. Seen along the ray, the point lies within it by so many metres, or not, and from its plane by so many:
 * where either is less than a hair's breadth, nobody can tell. What a pixel lies on is nearer than that by far.
 */
static answer meet(const world *w, const triangle *t, const double at[3], double view_depth) {
  const double breadth = 2e-5 * view_depth + 2e-6;
  double flat[3][2], shares[3], within = INFINITY, to[3];
  difference(to, t->corners[0], at);
  const double height = dot(to, t->normal), towards = dot(w->to_light, t->normal);
  if (fabs(height) < 1e-5 * view_depth || height * towards <= 0)
    return LIT;
  for (int k = 0; k < 3; ++k) {
    difference(to, t->corners[k], at);
    flat[k][0] = dot(to, w->right);
    flat[k][1] = dot(to, w->up);
  }
  for (int k = 0; k < 3; ++k) {
    const double *a = flat[(k + 1) % 3], *b = flat[(k + 2) % 3];
    shares[k] = a[0] * b[1] - a[1] * b[0];
  }
  const double all = shares[0] + shares[1] + shares[2];
  for (int k = 0; k < 3; ++k) {
    const double *a = flat[(k + 1) % 3], *b = flat[(k + 2) % 3];
    within = fmin(within, shares[k] * (all < 0 ? -1 : 1) / hypot(b[0] - a[0], b[1] - a[1]));
    shares[k] /= all;
  }
  if (!(within > -breadth))
    return LIT;
  if (within < breadth || fabs(height) < 3e-4 * view_depth)
    return UNSURE;
  return t->shape->cut_out ? is_there(w, t, shares) : DARK;
}

static bool passes(const world *w, const fog *fog, const double at[3]) {
  double enters = 0, leaves = INFINITY;
  for (int axis = 0; axis < 3; ++axis) {
    const double a = (fog->low[axis] - at[axis]) / w->to_light[axis];
    const double b = (fog->high[axis] - at[axis]) / w->to_light[axis];
    enters = fmax(enters, fmin(a, b));
    leaves = fmin(leaves, fmax(a, b));
  }
  return enters <= leaves;
}

static answer trace(const world *w, const double at[3], double view_depth) {
  answer all = LIT;
  const double x = dot(at, w->right), y = dot(at, w->up), near = 1e-3 * view_depth + 1e-3; /* many a hair's breadth */
  for (uint32_t i = 0; i < w->fogs; ++i)
    if (passes(w, &w->fog[i], at))
      return UNSURE;
  for (uint32_t i = 0; i < w->count && all != DARK; ++i) {
    const triangle *t = &w->triangles[i];
    if (x < t->low[0] - near || x > t->high[0] + near || y < t->low[1] - near || y > t->high[1] + near)
      continue;
    const answer one = meet(w, &w->triangles[i], at, view_depth);
    all = one == LIT ? all : one;
  }
  return all;
}

/* The pixel's view depth; 0 where nothing is, or no map reaches. */
static double depth_of(const rays_model *m, float depth) {
  const double *p = m->shot.camera.projection, z = p[14] / (p[10] + (double)depth);
  return depth > 0 && z < 0.9 * shadow_distance ? z : 0;
}

/* ---- pictures ---- */

static uint32_t width_of(const rays_picture *p) {
  return p->width ? p->width : RAYS_WIDTH;
}

static uint32_t height_of(const rays_picture *p) {
  return p->height ? p->height : RAYS_HEIGHT;
}

float *rays_mask(rays_model *m, const rays_picture *p) {
  csm_view *view = p->view ? p->view : m->view;
  shot shot = m->shot;
  if (p->list) {
    shot.frame.instances = m->count ? m->instances : NULL;
    shot.frame.instance_count = m->count;
  } else {
    shot.frame.scene = m->scene;
  }
  succeed(m, csm_render_cascades(p->cascades, shot_frame(&shot)));
  succeed(m, shot_resolve(&shot, view, p->cascades, width_of(p), height_of(p)));
  return support_image(m->context, view, CSM_READ_MASK, width_of(p), height_of(p));
}

/* How many pixels are not as rays say. */
static uint32_t compare(rays_model *m, const rays_picture *p, const float *mask, const float *depth, char *first,
                        size_t size) {
  world *w = make_world(m);
  uint32_t wrong = 0;
  for (uint32_t y = 0; y < height_of(p); ++y)
    for (uint32_t x = 0; x < width_of(p); ++x) {
      const uint32_t pixel = y * width_of(p) + x;
      const double view_depth = depth_of(m, depth[pixel]);
      double at[3];
      if (view_depth <= 0)
        continue;
      support_seen(&m->shot.camera, depth[pixel], (x + 0.5) / width_of(p), (y + 0.5) / height_of(p), at);
      const answer expected = trace(w, at, view_depth);
      m->sure += expected != UNSURE;
      m->dark += expected == DARK;
      if (expected == UNSURE || mask[pixel] == (expected == DARK ? 0 : 1))
        continue;
      if (!wrong++)
        snprintf(first, size, "pixel %u, %u at %.9g, %.9g, %.9g: %g, and a ray says %d", x, y, at[0], at[1], at[2],
                 (double)mask[pixel], expected == LIT);
    }
  free(w);
  return wrong;
}

void rays_check(rays_model *m, const rays_picture *p, const char *what) {
  float *mask = rays_mask(m, p);
  if (rays_draw()) {
    char first[256] = "";
    csm_view *view = p->view ? p->view : m->view;
    float *depth = support_image(m->context, view, CSM_READ_CAMERA_DEPTH, width_of(p), height_of(p));
    const uint32_t wrong = compare(m, p, mask, depth, first, sizeof first);
    if (wrong > width_of(p) * height_of(p) * p->most_wrong_percent / 100)
      fail_msg("%s, %s of %u instances: %u pixels are wrong; %s", what, p->list ? "a list" : "a scene", m->count, wrong,
               first);
    free(depth);
  }
  free(mask);
}

void rays_expect(rays_model *m, csm_cascades *cascades, const char *what) {
  const rays_picture picture = {.cascades = cascades};
  rays_check(m, &picture, what);
}

void rays_seen(const rays_model *m, const float *depth, uint32_t rays, float *out) {
  world *w = make_world(m);
  double to_light[3], right[3], up[3];
  memcpy(to_light, w->to_light, sizeof to_light);
  memcpy(right, w->right, sizeof right);
  memcpy(up, w->up, sizeof up);
  memset(out, 0, RAYS_WIDTH * RAYS_HEIGHT * sizeof *out);
  for (uint32_t i = 0; i < rays; ++i) { /* a sunflower's seeds */
    const double radius = tan(0.5 * m->shot.light.angular_diameter) * sqrt((i + 0.5) / rays), angle = 2.39996323 * i;
    double way[3];
    for (int axis = 0; axis < 3; ++axis)
      way[axis] = to_light[axis] + radius * (cos(angle) * right[axis] + sin(angle) * up[axis]);
    turn_to(w, way);
    flatten(w);
    for (uint32_t pixel = 0; pixel < RAYS_WIDTH * RAYS_HEIGHT; ++pixel) {
      const double view_depth = depth_of(m, depth[pixel]);
      double at[3];
      support_seen(&m->shot.camera, depth[pixel], (pixel % RAYS_WIDTH + 0.5) / RAYS_WIDTH,
                   ((double)(pixel / RAYS_WIDTH) + 0.5) / RAYS_HEIGHT, at);
      out[pixel] += view_depth <= 0 ? -1.0f : trace(w, at, view_depth) == LIT ? 1.0f / (float)rays : 0.0f;
    }
  }
  free(w);
}
