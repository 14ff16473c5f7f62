#include "picture/picture.h"
#include "base/host.h"
#include "base/linear.h"
#include "scene/mesh_builder.h"
#include <math.h>
#include <stdlib.h>
#include <string.h>

#define MAP_TILE 512u

static const float sun_color[3] = {3.2f, 2.85f, 2.35f};
static const float sky_color[3] = {0.42f, 0.56f, 0.82f};
static const float bounce_color[3] = {0.2f, 0.18f, 0.14f};
static const float horizon_color[3] = {0.62f, 0.71f, 0.82f};
static const float zenith_color[3] = {0.13f, 0.29f, 0.6f};

static float dot3(const float a[3], const float b[3]) {
  return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}

/* Brings light of any brightness to 0 to 1: Narkowicz's fit of the ACES curve. */
static void tone_map(float out[3], const float light[3]) {
  for (int i = 0; i < 3; i++) {
    const float x = 0.62f * light[i];
    out[i] = x * (2.51f * x + 0.03f) / (x * (2.43f * x + 0.59f) + 0.14f);
  }
}

static void toward_sun(float out[3], const picture_view *view) {
  double direction[3];
  memcpy(direction, view->light->direction, sizeof direction);
  vec_normalize(direction);
  for (int i = 0; i < 3; i++)
    out[i] = (float)-direction[i];
}

static void sky_light(float out[3], const float ray[3], const float sun[3]) {
  const float height = powf(fmaxf(ray[1], 0.0f), 0.55f);
  const float glow = powf(fmaxf(dot3(ray, sun), 0.0f), 24.0f);
  for (int i = 0; i < 3; i++)
    out[i] = horizon_color[i] + (zenith_color[i] - horizon_color[i]) * height + 0.35f * glow * sun_color[i] / 3.0f;
}

/*
 * Fine grain on large plain surfaces: noise on the axis plane that the surface faces most. It fades where a pixel
 * covers many grains.
 */
static float grain(const picture_view *view, const trace_surface *surface) {
  int axis = 0;
  for (int i = 1; i < 3; i++)
    if (fabsf(surface->normal[i]) > fabsf(surface->normal[axis]))
      axis = i;
  const int first = (axis + 1) % 3, second = (axis + 2) % 3;
  const double x = surface->position[first] + view->camera->position[first];
  const double y = surface->position[second] + view->camera->position[second];
  const double fade = 1.0 / (1.0 + surface->distance / 60.0);
  return (float)(1.0 + fade * (0.14 * noise_value(1.3 * x, 1.3 * y, 5) + 0.16 * noise_value(6.7 * x, 6.7 * y, 6)));
}

/* Linear light that reaches the camera from a pixel. */
static void shade(float out[3], const picture_view *view, const trace_surface *surface, const float sun[3],
                  float visibility) {
  float sky[3];
  sky_light(sky, surface->ray, sun);
  if (surface->view_depth < 0.0) {
    memcpy(out, sky, sizeof sky);
    return;
  }
  const float cosine = fmaxf(dot3(surface->normal, sun), 0.0f);
  const float up = 0.5f + 0.5f * surface->normal[1];
  const float texture = isfinite(view->scene->haze_distance) ? grain(view, surface) : 1.0f;
  const float haze = (float)-expm1(-surface->distance / view->scene->haze_distance);
  for (int i = 0; i < 3; i++) {
    const float ambient = bounce_color[i] + (sky_color[i] - bounce_color[i]) * up;
    const float reflected = surface->color[i] * texture * (ambient + visibility * cosine * sun_color[i]);
    out[i] = reflected + (horizon_color[i] - reflected) * haze;
  }
}

/* Changes the colour of pixel `at`. */
typedef void (*tint_function)(float color[3], size_t at, const void *data);

static void lit_with_tint(image *out, const picture_view *view, const float *mask, tint_function tint,
                          const void *data) {
  float sun[3];
  toward_sun(sun, view);
  image_create(out, view->width, view->height);
  for (uint32_t y = 0; y < view->height; y++)
    for (uint32_t x = 0; x < view->width; x++) {
      const size_t at = (size_t)y * view->width + x;
      float light[3], color[3];
      shade(light, view, &view->surfaces[at], sun, mask[at]);
      tone_map(color, light);
      if (tint)
        tint(color, at, data);
      image_set(out, x, y, color);
    }
}

void picture_lit(image *out, const picture_view *view, const float *mask) {
  lit_with_tint(out, view, mask, NULL, NULL);
}

const float picture_cascade_colors[CSM_MAX_CASCADES][3] = {
    {1.0f, 0.12f, 0.1f}, {0.12f, 0.8f, 0.15f}, {0.15f, 0.35f, 1.0f}, {1.0f, 0.75f, 0.05f},
    {0.9f, 0.2f, 0.9f},  {0.1f, 0.85f, 0.9f},  {1.0f, 0.42f, 0.08f}, {0.55f, 0.9f, 0.6f}};

static float luminance(const float color[3]) {
  return 0.25f * color[0] + 0.6f * color[1] + 0.15f * color[2];
}

/* Below 0, or beyond the last one: none. */
static void tint_as(float color[3], long cascade, float light) {
  const float grey = luminance(color);
  for (int i = 0; i < 3; i++)
    color[i] = cascade >= 0 && cascade < CSM_MAX_CASCADES
                   ? light * (0.15f * color[i] + (0.06f + 1.15f * grey) * picture_cascade_colors[cascade][i])
                   : 0.8f * grey;
}

static void tint_cascade(float color[3], size_t at, const void *data) {
  const float *cascades = data;
  tint_as(color, lroundf(cascades[at] * 255.0f) - 1, 1.0f);
}

static void tint_page(float color[3], size_t at, const void *data) {
  const float *pages = data;
  const long value = lroundf(pages[at] * 255.0f) - 1;
  tint_as(color, value < 0 ? -1 : value / 16, (value / 4 + value) % 2 ? 0.55f : 1.0f);
}

/* White, or more blue the less it is, or more red the more, up to three doublings. */
static void tint_doublings(float color[3], float doublings) {
  static const float one[3] = {1.0f, 1.0f, 1.0f}, few[3] = {0.02f, 0.12f, 1.0f}, many[3] = {1.0f, 0.04f, 0.02f};
  const float share = fminf(fabsf(doublings) / 3.0f, 1.0f);
  const float *end = doublings < 0.0f ? few : many;
  const float light = 0.45f + 0.55f * fminf(2.0f * luminance(color), 1.0f);
  for (int i = 0; i < 3; i++)
    color[i] = light * (one[i] + (end[i] - one[i]) * share);
}

/* Of what a view of doublings from one on holds. */
static float doublings_of(float value) {
  return (value * 255.0f - 128.0f) / 16.0f;
}

static void tint_density(float color[3], size_t at, const void *data) {
  static const float none[3] = {0.03f, 0.03f, 0.035f};
  const float *density = data;
  if (density[at] > 0.0f)
    tint_doublings(color, doublings_of(density[at]));
  else
    memcpy(color, none, sizeof none);
}

static void tint_penumbra(float color[3], size_t at, const void *data) {
  const float *penumbra = data, grey = luminance(color);
  if (penumbra[at] > 0.0f)
    tint_doublings(color, doublings_of(penumbra[at]) - 3.0f);
  else
    color[0] = color[1] = color[2] = 0.5f * grey;
}

static void tint_rays(float color[3], size_t at, const void *data) {
  const float *rays = data, grey = luminance(color), doublings = (rays[at] * 255.0f - 1.0f) / 16.0f;
  if (rays[at] > 0.0f)
    tint_doublings(color, doublings - 7.0f);
  else
    color[0] = color[1] = color[2] = 0.5f * grey;
}

/* Without shadows, which would be taken for another colour. */
static void all_lit_with_tint(image *out, const picture_view *view, tint_function tint, const void *data) {
  const size_t pixels = (size_t)view->width * view->height;
  float *lit = host_allocate(pixels, sizeof *lit);
  for (size_t i = 0; i < pixels; i++)
    lit[i] = 1.0f;
  lit_with_tint(out, view, lit, tint, data);
  free(lit);
}

void picture_shown(image *out, const picture_view *view, const float *mask, uint32_t show, const float *values) {
  if (show == CSM_SHOW_CASCADE)
    lit_with_tint(out, view, mask, tint_cascade, values);
  else if (show == CSM_SHOW_PAGES)
    lit_with_tint(out, view, mask, tint_page, values);
  else
    all_lit_with_tint(out, view,
                      show == CSM_SHOW_DENSITY    ? tint_density
                      : show == CSM_SHOW_PENUMBRA ? tint_penumbra
                                                  : tint_rays,
                      values);
}

void picture_mask(image *out, const picture_view *view, const float *mask) {
  static const float blue[3] = {0.12f, 0.25f, 0.5f};
  image_create(out, view->width, view->height);
  for (uint32_t y = 0; y < view->height; y++)
    for (uint32_t x = 0; x < view->width; x++) {
      const size_t at = (size_t)y * view->width + x;
      const float grey[3] = {mask[at], mask[at], mask[at]};
      image_set(out, x, y, view->surfaces[at].view_depth < 0.0 ? blue : grey);
    }
}

/* ---- depth maps ---- */

/* A map as it is shown: depth from the light, 1 where nothing was drawn. */
typedef struct shown_map {
  const float *depths;
  uint32_t resolution;
  bool reversed;
  float nearest, scale;
} shown_map;

static float shown_depth(const shown_map *map, size_t texel) {
  return map->reversed ? 1.0f - map->depths[texel] : map->depths[texel];
}

static void find_range(shown_map *map) {
  float nearest = 1.0f, farthest = 0.0f;
  for (size_t i = 0; i < (size_t)map->resolution * map->resolution; i++)
    if (shown_depth(map, i) < 1.0f) {
      nearest = fminf(nearest, shown_depth(map, i));
      farthest = fmaxf(farthest, shown_depth(map, i));
    }
  map->nearest = nearest;
  map->scale = farthest > nearest ? 1.0f / (farthest - nearest) : 0.0f;
}

/* The mean colour of the texels that fall on one pixel. */
static void map_pixel(float color[3], const shown_map *map, uint32_t tile, uint32_t x, uint32_t y) {
  static const float empty[3] = {0.03f, 0.05f, 0.16f};
  const uint32_t resolution = map->resolution;
  const uint32_t left = x * resolution / tile, right = (x + 1) * resolution / tile;
  const uint32_t top = y * resolution / tile, bottom = (y + 1) * resolution / tile;
  float sum[3] = {0};
  uint32_t count = 0;
  for (uint32_t row = top; row < bottom || row == top; row++)
    for (uint32_t column = left; column < right || column == left; column++) {
      const float depth = shown_depth(map, (size_t)row * resolution + column);
      const float closeness = 0.04f + 0.9f * (1.0f - (depth - map->nearest) * map->scale);
      for (int i = 0; i < 3; i++)
        sum[i] += depth < 1.0f ? closeness * closeness : empty[i];
      count++;
    }
  for (int i = 0; i < 3; i++)
    color[i] = sum[i] / (float)count;
}

void picture_maps(image *out, const float *const *maps, uint32_t count, const uint32_t *resolutions, bool reversed) {
  uint32_t tile = 0;
  for (uint32_t k = 0; k < count; k++)
    tile = resolutions[k] > tile ? resolutions[k] : tile;
  tile = tile < MAP_TILE ? tile : MAP_TILE;
  const uint32_t gap = 6, columns = count < 4 ? count : 4, rows = (count + columns - 1) / columns;
  image_create(out, columns * (tile + gap) - gap, rows * (tile + gap) - gap);
  memset(out->pixels, 255, (size_t)out->width * out->height * 3);
  for (uint32_t k = 0; k < count; k++) {
    shown_map map = {.depths = maps[k], .resolution = resolutions[k], .reversed = reversed};
    find_range(&map);
    for (uint32_t y = 0; y < tile; y++)
      for (uint32_t x = 0; x < tile; x++) {
        float color[3];
        map_pixel(color, &map, tile, x, y);
        image_set(out, k % columns * (tile + gap) + x, k / columns * (tile + gap) + y, color);
      }
  }
}

/* ---- differences ---- */

static void draw_frame(image *picture, uint32_t thickness, const float color[3]) {
  for (uint32_t y = 0; y < picture->height; y++)
    for (uint32_t x = 0; x < picture->width; x++)
      if (x < thickness || y < thickness || x + thickness >= picture->width || y + thickness >= picture->height)
        image_set(picture, x, y, color);
}

static void draw_cross(image *picture, uint32_t x, uint32_t y, const float color[3]) {
  for (int step = -2; step <= 2; step++) {
    if ((int64_t)x + step >= 0 && (int64_t)x + step < picture->width)
      image_set(picture, (uint32_t)((int64_t)x + step), y, color);
    if ((int64_t)y + step >= 0 && (int64_t)y + step < picture->height)
      image_set(picture, x, (uint32_t)((int64_t)y + step), color);
  }
}

static void tint_grey(float color[3], size_t at, const void *data) {
  (void)at;
  (void)data;
  const float grey = 0.12f + 0.5f * luminance(color);
  color[0] = color[1] = color[2] = grey;
}

void picture_difference(image *out, const picture_view *view, const float *mask_a, const float *mask_b,
                        float tolerance) {
  static const float red[3] = {1.0f, 0.02f, 0.02f}, green[3] = {0.05f, 0.5f, 0.1f};
  lit_with_tint(out, view, mask_a, tint_grey, NULL);
  bool differs = false;
  for (uint32_t y = 0; y < view->height; y++)
    for (uint32_t x = 0; x < view->width; x++) {
      const size_t at = (size_t)y * view->width + x;
      if (!(fabsf(mask_a[at] - mask_b[at]) <= tolerance)) {
        draw_cross(out, x, y, red);
        differs = true;
      }
    }
  draw_frame(out, 6, differs ? red : green);
}
