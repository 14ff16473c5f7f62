/*
 * check.c: check FRAME PICTURE.png [PICTURE.png]: the mini-engines' pictures against the world that they drew. Rays
 * find what a pixel sees and whether the sun reaches it; where neither is in doubt, the pixel's colour follows. Two
 * pictures must also be the same, but for 1/255 on 0.01 % of their pixels. Exit status 0 if all of that holds.
 */
#include "world.h"
#include <math.h>
#include <spng.h>
#include <stdbool.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

enum {
  STEP = 4, /* every how many pixels a ray is cast */
  MAX_TRIANGLES = 4096,
  TOLERANCE = 2,     /* levels of 255: rounding, and the shader's floats */
  WANTED_LIT = 2000, /* pixels that the test must have been able to judge */
  WANTED_SHADED = 400,
  WANTED_BY_TREE = 20 /* shaded by the skinned caster */
};

/* How far from a shadow's edge a pixel must lie to be judged, in metres: beyond the filter's reach in any cascade. */
static const double clearance = 0.2;
static const double pi = 3.14159265358979323846;

typedef struct triangle {
  double corners[3][3];
  double normals[3][3];
  uint32_t thing;
} triangle;

static triangle triangles[MAX_TRIANGLES];
static uint32_t triangle_count;

static double dot(const double a[3], const double b[3]) {
  return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}

static void subtract(double out[3], const double a[3], const double b[3]) {
  for (int i = 0; i < 3; i++)
    out[i] = a[i] - b[i];
}

static void cross(double out[3], const double a[3], const double b[3]) {
  for (int i = 0; i < 3; i++)
    out[i] = a[(i + 1) % 3] * b[(i + 2) % 3] - a[(i + 2) % 3] * b[(i + 1) % 3];
}

static void normalize(double v[3]) {
  const double length = sqrt(dot(v, v));
  for (int i = 0; i < 3; i++)
    v[i] /= length;
}

/* ---- the world's triangles ---- */

/* Of a point (w 1) or a direction (w 0), as the shaders bend it. */
static void bend(double out[3], const thing *t, const float v[3], double w, double height) {
  const double weight = fmin(fmax(height * t->bend, 0.0), 1.0);
  for (int i = 0; i < 3; i++) {
    double by_bone[2];
    for (int b = 0; b < 2; b++)
      by_bone[b] =
          t->bones[b][i] * v[0] + t->bones[b][4 + i] * v[1] + t->bones[b][8 + i] * v[2] + t->bones[b][12 + i] * w;
    out[i] = by_bone[0] + weight * (by_bone[1] - by_bone[0]);
  }
}

static void collect(const world *w) {
  for (uint32_t i = 0; i < w->thing_count; i++) {
    const thing *t = &w->things[i];
    const mesh *m = &w->meshes[t->mesh];
    for (uint32_t first = 0; first < m->index_count && triangle_count < MAX_TRIANGLES; first += 3) {
      triangle *out = &triangles[triangle_count++];
      out->thing = i;
      for (int corner = 0; corner < 3; corner++) {
        const vertex *v = &m->vertices[m->indices[first + corner]];
        bend(out->corners[corner], t, v->position, 1.0, v->position[1]);
        bend(out->normals[corner], t, v->normal, 0.0, v->position[1]);
      }
    }
  }
}

/* ---- rays ---- */

typedef struct hit {
  double distance; /* INFINITY: nothing */
  double u, v;     /* weights of corners 1 and 2 */
  uint32_t index;  /* of the triangle */
} hit;

static bool intersect(const triangle *t, const double from[3], const double direction[3], hit *out) {
  double edge1[3], edge2[3], to[3], p[3], q[3];
  subtract(edge1, t->corners[1], t->corners[0]);
  subtract(edge2, t->corners[2], t->corners[0]);
  cross(p, direction, edge2);
  const double determinant = dot(edge1, p);
  if (fabs(determinant) < 1e-12)
    return false;
  subtract(to, from, t->corners[0]);
  cross(q, to, edge1);
  out->u = dot(to, p) / determinant;
  out->v = dot(direction, q) / determinant;
  out->distance = dot(edge2, q) / determinant;
  return out->u >= 0.0 && out->v >= 0.0 && out->u + out->v <= 1.0 && out->distance > 0.0;
}

/* The first triangle along a ray, but for those of the surface that it leaves. */
static hit cast(const double from[3], const double direction[3], uint32_t except) {
  hit first = {.distance = INFINITY};
  for (uint32_t i = 0; i < triangle_count; i++) {
    hit here;
    if (i != except && intersect(&triangles[i], from, direction, &here) && here.distance < first.distance) {
      first = here;
      first.index = i;
    }
  }
  return first;
}

static void camera_ray(double out[3], const world *w, double x, double y) {
  const double right = (2.0 * x / WORLD_WIDTH - 1.0) / w->projection[0];
  const double up = (1.0 - 2.0 * y / WORLD_HEIGHT) / w->projection[5];
  for (int i = 0; i < 3; i++)
    out[i] = right * w->view[i * 4] + up * w->view[i * 4 + 1] - w->view[i * 4 + 2];
  normalize(out);
}

/* What a pixel sees, if all about it see the same thing: an edge would leave in doubt which of them was drawn. */
static bool see(const world *w, uint32_t x, uint32_t y, hit *out, double position[3]) {
  static const double offsets[4][2] = {{-1, -1}, {1, -1}, {-1, 1}, {1, 1}};
  double ray[3];
  camera_ray(ray, w, x + 0.5, y + 0.5);
  *out = cast(w->camera, ray, UINT32_MAX);
  if (isinf(out->distance))
    return false;
  for (int i = 0; i < 3; i++)
    position[i] = w->camera[i] + out->distance * ray[i];
  for (int i = 0; i < 4; i++) {
    camera_ray(ray, w, x + 0.5 + offsets[i][0], y + 0.5 + offsets[i][1]);
    const hit beside = cast(w->camera, ray, UINT32_MAX);
    if (isinf(beside.distance) || triangles[beside.index].thing != triangles[out->index].thing ||
        fabs(beside.distance - out->distance) > 0.05 * out->distance)
      return false;
  }
  return true;
}

enum { SUN_IN_DOUBT, SUN_REACHES, SUN_BLOCKED, SUN_BLOCKED_BY_TREE };

/* Whether the sun reaches a point, and all points about it. What blocks it from very near may be lost in the bias. */
static int sun_at(const world *w, const double position[3], uint32_t index) {
  double to_sun[3], right[3], up[3];
  for (int i = 0; i < 3; i++)
    to_sun[i] = -w->sun_direction[i];
  cross(right, to_sun, (const double[3]){0, 1, 0});
  normalize(right);
  cross(up, right, to_sun);
  uint32_t blocked = 0, by_tree = 0, count = 0;
  for (int ring = 0; ring <= 2; ring++)
    for (int k = 0; k < (ring ? 12 : 1); k++, count++) {
      const double radius = 0.5 * ring * clearance, a = radius * cos(k * pi / 6.0), b = radius * sin(k * pi / 6.0);
      double from[3];
      for (int i = 0; i < 3; i++)
        from[i] = position[i] + a * right[i] + b * up[i] + 1e-6 * to_sun[i];
      const hit blocker = cast(from, to_sun, index);
      if (blocker.distance < clearance)
        return SUN_IN_DOUBT;
      blocked += !isinf(blocker.distance);
      by_tree += !isinf(blocker.distance) && triangles[blocker.index].thing == w->thing_count - 1;
    }
  if (blocked == 0)
    return SUN_REACHES;
  return blocked < count ? SUN_IN_DOUBT : by_tree == count ? SUN_BLOCKED_BY_TREE : SUN_BLOCKED;
}

/* ---- pictures ---- */

static uint8_t *read_png(const char *path) {
  const size_t size = (size_t)WORLD_WIDTH * WORLD_HEIGHT * 3;
  FILE *file = fopen(path, "rb");
  spng_ctx *png = spng_ctx_new(0);
  uint8_t *pixels = malloc(size);
  struct spng_ihdr header;
  const bool read = file && png && pixels && spng_set_png_file(png, file) == 0 && spng_get_ihdr(png, &header) == 0 &&
                    header.width == WORLD_WIDTH && header.height == WORLD_HEIGHT &&
                    spng_decode_image(png, pixels, size, SPNG_FMT_RGB8, 0) == 0;
  spng_ctx_free(png);
  if (file)
    fclose(file);
  if (read)
    return pixels;
  fprintf(stderr, "%s: not a picture of %dx%d\n", path, WORLD_WIDTH, WORLD_HEIGHT);
  free(pixels);
  return NULL;
}

static int to_srgb(double linear) {
  const double x = fmin(fmax(linear, 0.0), 1.0);
  return (int)lround(255.0 * (x <= 0.0031308 ? 12.92 * x : 1.055 * pow(x, 1.0 / 2.4) - 0.055));
}

/* ---- what must hold ---- */

static void surface_normal(double out[3], const hit *at) {
  const triangle *t = &triangles[at->index];
  for (int i = 0; i < 3; i++)
    out[i] = (1.0 - at->u - at->v) * t->normals[0][i] + at->u * t->normals[1][i] + at->v * t->normals[2][i];
  normalize(out);
}

/* 0 if the picture is right wherever that can be said for sure, and that is in enough places. */
static int judge(const world *w, const char *path, const uint8_t *pixels) {
  uint32_t seen[4] = {0}, wrong = 0;
  for (uint32_t y = STEP; y + STEP < WORLD_HEIGHT; y += STEP)
    for (uint32_t x = STEP; x + STEP < WORLD_WIDTH; x += STEP) {
      hit at;
      double position[3], normal[3];
      if (!see(w, x, y, &at, position))
        continue;
      surface_normal(normal, &at);
      const double cosine = -dot(normal, w->sun_direction);
      const int sun = cosine < 0.2 ? SUN_IN_DOUBT : sun_at(w, position, at.index);
      if (sun == SUN_IN_DOUBT)
        continue;
      seen[sun]++;
      const uint8_t *pixel = pixels + ((size_t)y * WORLD_WIDTH + x) * 3;
      for (int i = 0; i < 3; i++) {
        const double light =
            w->sky_light[i] * (0.75 + 0.25 * normal[1]) + (sun == SUN_REACHES) * w->sun_light[i] * cosine;
        const int expected = to_srgb(light * w->things[triangles[at.index].thing].color[i]);
        if (abs(pixel[i] - expected) <= TOLERANCE)
          continue;
        if (wrong++ < 10)
          fprintf(stderr, "%s: pixel %u, %u, channel %d is %d, but the sun %s it: %d\n", path, x, y, i, pixel[i],
                  sun == SUN_REACHES ? "reaches" : "does not reach", expected);
      }
    }
  const uint32_t shaded = seen[SUN_BLOCKED] + seen[SUN_BLOCKED_BY_TREE];
  printf("%s: %u pixels lit, %u in shadow, %u of them the tree's; %u values wrong\n", path, seen[SUN_REACHES], shaded,
         seen[SUN_BLOCKED_BY_TREE], wrong);
  return wrong > 0 || seen[SUN_REACHES] < WANTED_LIT || shaded < WANTED_SHADED ||
         seen[SUN_BLOCKED_BY_TREE] < WANTED_BY_TREE;
}

static int compare(const uint8_t *a, const uint8_t *b) {
  uint32_t beyond = 0;
  for (size_t i = 0; i < (size_t)WORLD_WIDTH * WORLD_HEIGHT; i++) {
    bool differs = false;
    for (int channel = 0; channel < 3; channel++)
      differs = differs || abs(a[3 * i + channel] - b[3 * i + channel]) > 1;
    beyond += differs;
  }
  printf("the two differ by more than 1/255 in %u pixels\n", beyond);
  return beyond > WORLD_WIDTH * WORLD_HEIGHT / 10000;
}

int main(int count, char **arguments) {
  uint8_t *pixels[2] = {NULL};
  world w;
  int failed = count < 3 || count > 4;
  world_create(&w);
  world_animate(&w, count > 1 ? (uint32_t)atoi(arguments[1]) : 0);
  collect(&w);
  for (int i = 0; i + 2 < count && !failed; i++) {
    pixels[i] = read_png(arguments[i + 2]);
    failed = !pixels[i] || judge(&w, arguments[i + 2], pixels[i]);
  }
  if (!failed && pixels[1])
    failed = compare(pixels[0], pixels[1]);
  free(pixels[0]);
  free(pixels[1]);
  world_destroy(&w);
  return failed;
}
