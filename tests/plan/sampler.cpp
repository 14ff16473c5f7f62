// The shaders' include in C++: vectors with the operators and the swizzles that it uses.
#include "sampler.h"

#include <cmath>

#define CSM_ENUMS_AS_MACROS
#include "csm_constants.h"
#include "csm_enums.h"

namespace shader {

typedef unsigned int uint;

struct csm_float2 {
  float x, y;
  csm_float2() : x(0), y(0) {
  }
  csm_float2(float x_, float y_) : x(x_), y(y_) {
  }
};

// The first components of a longer vector.
struct first_2 {
  float x, y;
  operator csm_float2() const {
    return csm_float2(x, y);
  }
};

struct csm_float3 {
  union {
    struct {
      float x, y, z;
    };
    first_2 xy;
  };
  csm_float3() : x(0), y(0), z(0) {
  }
  csm_float3(float x_, float y_, float z_) : x(x_), y(y_), z(z_) {
  }
};

struct first_3 {
  float x, y, z;
  operator csm_float3() const {
    return csm_float3(x, y, z);
  }
};

struct csm_float4 {
  union {
    struct {
      float x, y, z, w;
    };
    first_2 xy;
    first_3 xyz;
  };
  csm_float4() : x(0), y(0), z(0), w(0) {
  }
  csm_float4(float x_, float y_, float z_, float w_) : x(x_), y(y_), z(z_), w(w_) {
  }
};

csm_float2 operator+(csm_float2 a, csm_float2 b) {
  return csm_float2(a.x + b.x, a.y + b.y);
}
csm_float2 operator-(csm_float2 a, csm_float2 b) {
  return csm_float2(a.x - b.x, a.y - b.y);
}
csm_float2 operator+(csm_float2 a, float b) {
  return csm_float2(a.x + b, a.y + b);
}
csm_float2 operator-(csm_float2 a, float b) {
  return csm_float2(a.x - b, a.y - b);
}
csm_float2 operator*(csm_float2 a, float b) {
  return csm_float2(a.x * b, a.y * b);
}
csm_float2 operator*(float a, csm_float2 b) {
  return b * a;
}
csm_float4 operator+(csm_float4 a, csm_float4 b) {
  return csm_float4(a.x + b.x, a.y + b.y, a.z + b.z, a.w + b.w);
}

int min(int a, int b) {
  return a < b ? a : b;
}

/* Literals are floats there. */
template <typename A, typename B> float min(A a, B b) {
  return float(a) < float(b) ? float(a) : float(b);
}
float max(float a, float b) {
  return a > b ? a : b;
}
int abs(int a) {
  return a < 0 ? -a : a;
}
float abs(float a) {
  return std::fabs(a);
}
float abs(double a) {
  return float(std::fabs(a));
}
float sqrt(float a) {
  return std::sqrt(a);
}
float floor(float a) {
  return std::floor(a);
}
float ceil(float a) {
  return std::ceil(a);
}
float exp(float a) {
  return std::exp(a);
}
float log2(float a) {
  return std::log2(a);
}
float pow(float a, float b) {
  return std::pow(a, b);
}
float cos(float a) {
  return std::cos(a);
}
float sin(float a) {
  return std::sin(a);
}
csm_float2 floor(csm_float2 a) {
  return csm_float2(floor(a.x), floor(a.y));
}
float clamp(float a, float low, float high) {
  return min(max(a, low), high);
}
csm_float2 clamp(csm_float2 a, float low, float high) {
  return csm_float2(clamp(a.x, low, high), clamp(a.y, low, high));
}
csm_float4 clamp(csm_float4 a, float low, float high) {
  return csm_float4(clamp(a.x, low, high), clamp(a.y, low, high), clamp(a.z, low, high), clamp(a.w, low, high));
}
float csm_mad(float a, float b, float c) {
  return std::fma(a, b, c);
}
csm_float4 csm_mad(csm_float4 a, csm_float4 b, csm_float4 c) {
  return csm_float4(csm_mad(a.x, b.x, c.x), csm_mad(a.y, b.y, c.y), csm_mad(a.z, b.z, c.z), csm_mad(a.w, b.w, c.w));
}

struct bound {
  const csm_float4 *constants;
  const float *depths;
  float width, height, layers;
  bool outside;
};
bound bound;

float depth_of(float x, float y, float layer) {
  if (!(x >= 0 && y >= 0 && layer >= 0 && x < bound.width && y < bound.height && layer < bound.layers)) {
    bound.outside = true;
    return 0;
  }
  return bound.depths[(long(layer) * long(bound.height) + long(y)) * long(bound.width) + long(x)];
}

csm_float4 depths_of(csm_float2 texel, float layer) {
  return csm_float4(depth_of(texel.x, texel.y, layer), depth_of(texel.x + 1, texel.y, layer),
                    depth_of(texel.x, texel.y + 1, layer), depth_of(texel.x + 1, texel.y + 1, layer));
}

// One level of the moments' image, bilinear and clamped, at a place in texels of the map.
struct moments_bound {
  const float *texels; // levels from the largest on, each with its layers
  int side, layers, levels;
  bool outside; // whether a texel of the clamped border would have been read
};
moments_bound moments;

csm_float4 moments_texel(int x, int y, int layer, int level) {
  const float *from = moments.texels;
  for (int i = 0; i < level; ++i)
    from += 4L * (moments.side >> i) * (moments.side >> i) * moments.layers;
  const int side = moments.side >> level;
  from += 4L * ((long(layer) * side + y) * side + x);
  return csm_float4(from[0], from[1], from[2], from[3]);
}

float mixed(float share, float a, float b) {
  return csm_mad(share, b - a, a);
}

csm_float4 mixed(float share, csm_float4 a, csm_float4 b) {
  return csm_float4(mixed(share, a.x, b.x), mixed(share, a.y, b.y), mixed(share, a.z, b.z), mixed(share, a.w, b.w));
}

csm_float4 moments_at(csm_float2 uv, float layer, float level) {
  if (!(layer >= 0 && layer < moments.layers && level >= 0 && level < moments.levels)) {
    moments.outside = true;
    return csm_float4();
  }
  const int side = moments.side >> int(level);
  const csm_float2 place = csm_float2(uv.x * side - 0.5f, uv.y * side - 0.5f), first = floor(place);
  int at[4];
  for (int i = 0; i < 4; ++i) {
    const float from = i < 2 ? first.x : first.y, share = (i < 2 ? place.x : place.y) - from;
    const int index = int(from) + (i & 1), inside = index < 0 ? 0 : index >= side ? side - 1 : index;
    moments.outside = moments.outside || (index != inside && (i & 1 ? share : 1 - share) > 1e-4f);
    at[i] = inside;
  }
  const int l = int(layer), k = int(level);
  const csm_float2 share = place - first;
  const csm_float4 top = mixed(share.x, moments_texel(at[0], at[2], l, k), moments_texel(at[1], at[2], l, k));
  const csm_float4 bottom = mixed(share.x, moments_texel(at[0], at[3], l, k), moments_texel(at[1], at[3], l, k));
  return mixed(share.y, top, bottom);
}

#define CSM_MOMENTS_AT(uv, layer, level) moments_at(uv, layer, level)
#define CSM_CONSTANT(i) bound.constants[i]
#define CSM_DEPTHS_4(texel, layer) depths_of(texel, layer)
#define CSM_TEXEL_LIT(texel, layer, reference)                                                                         \
  float(reference * CSM_SIDE <= depth_of((texel).x, (texel).y, layer) * CSM_SIDE)
#define CSM_SOFT 1
#define CSM_UNROLL
#define CSM_LOOP
#define CSM_STATIC static const
#define CSM_GLOBAL static

#include "csm_sample.inc"

csm_float3 vector(const float v[3]) {
  return csm_float3(v[0], v[1], v[2]);
}

} // namespace shader

using namespace shader;

void sampler_bind(const float *constants, const float *depths, uint32_t width, uint32_t height, uint32_t layers) {
  // One more than there are: with 31 taps csm_tap_weight looks there for a tap that is none, and must not use it.
  static csm_float4 block[CSM_C_COUNT + 1];
  block[CSM_C_COUNT] = csm_float4(NAN, NAN, NAN, NAN);
  for (int i = 0; i < CSM_C_COUNT; ++i)
    block[i] = csm_float4(constants[i * 4], constants[i * 4 + 1], constants[i * 4 + 2], constants[i * 4 + 3]);
  shader::bound = {block, depths, float(width), float(height), float(layers), false};
}

int sampler_read_outside(void) {
  return shader::bound.outside;
}

int sampler_select(float view_depth) {
  return csm_select(view_depth);
}

int sampler_cascade(const float position[3], const float normal[3], float view_depth) {
  return csm_cascade(vector(position), vector(normal), view_depth);
}

// A position in a cascade's map, whether or not it holds it.
static csm_found found_at(int cascade, const csm_receiver &receiver) {
  const csm_float4 scale = shader::bound.constants[CSM_C_SCALES + cascade];
  const csm_float4 offset = shader::bound.constants[CSM_C_OFFSETS + cascade];
  csm_found found;
  found.at = csm_float3(csm_mad(receiver.at.x, scale.x, offset.x), csm_mad(receiver.at.y, scale.y, offset.y),
                        csm_mad(receiver.at.z, scale.z, offset.z));
  found.scale = scale.xyz;
  found.cascade = cascade;
  return found;
}

static csm_receiver receiver_at(const float position[3], const float normal[3], float view_depth) {
  return csm_receiver_of(csm_to_light(vector(position)), csm_to_light(vector(normal)), view_depth);
}

float sampler_bias(int cascade, const float normal[3]) {
  const float origin[3] = {0, 0, 0};
  const csm_receiver receiver = receiver_at(origin, normal, 0);
  const csm_found found = found_at(cascade, receiver);
  return csm_bias(found, csm_texel(found, csm_rect(found).z * 0.5f), csm_tilt_of(receiver.normal, CSM_BIAS_ROW.z));
}

void sampler_plane(float out[2], int cascade, const float normal[3]) {
  const float origin[3] = {0, 0, 0};
  const csm_receiver receiver = receiver_at(origin, normal, 0);
  const csm_found found = found_at(cascade, receiver);
  const csm_float2 texel = csm_texel(found, csm_rect(found).z * 0.5f);
  const csm_tilt tilt = csm_tilt_of(receiver.normal, CSM_BIAS_ROW.z);
  out[0] = tilt.slope.x * texel.x;
  out[1] = tilt.slope.y * texel.y;
}

float sampler_blend(int cascade, const float position[3], const float normal[3], float view_depth) {
  return csm_blend(found_at(cascade, receiver_at(position, normal, view_depth)), view_depth);
}

float sampler_visibility_point(const float position[3], float view_depth) {
  return csm_visibility_point(vector(position), view_depth);
}

float sampler_visibility(const float position[3], const float normal[3], float view_depth) {
  return csm_visibility(vector(position), vector(normal), view_depth);
}

float sampler_filter(float x, float y, float depth) {
  csm_spot spot;
  spot.place = csm_float2(x, y);
  spot.depth = depth;
  spot.last = 1;
  spot.rect = shader::bound.constants[CSM_C_RECTS];
  spot.pattern = csm_float2(1, 0);
  spot.soft = 0;
  return csm_filter(spot);
}

void sampler_bind_moments(const float *texels, uint32_t side, uint32_t layers, uint32_t levels) {
  shader::moments = {texels, int(side), int(layers), int(levels), false};
}

int sampler_moments_read_outside(void) {
  return shader::moments.outside;
}

void sampler_moments_of(float out[4], float depth, float slice) {
  const csm_float4 m = csm_moments_of(depth, slice);
  const float all[] = {m.x, m.y, m.z, m.w};
  for (int i = 0; i < 4; ++i)
    out[i] = all[i];
}

float sampler_filter_spot(const sampler_spot *at) {
  csm_spot spot;
  spot.place = csm_float2(at->place[0], at->place[1]);
  spot.depth = at->depth;
  spot.last = CSM_LAST;
  spot.rect = shader::bound.constants[CSM_C_RECTS];
  spot.pattern = csm_float2(1, 0);
  spot.across = csm_float2(at->across[0], at->across[1]);
  spot.down = csm_float2(at->down[0], at->down[1]);
  spot.slope = spot.steep = at->slope;
  spot.texel = at->texel;
  spot.metre = at->metre;
  spot.room = at->room;
  spot.soft = 0;
  spot.cascade = 0;
  return csm_filter(spot);
}

void sampler_in_texels(float out[2], int cascade, const float step[3]) {
  csm_found found;
  found.scale = shader::bound.constants[CSM_C_SCALES + cascade].xyz;
  found.cascade = cascade;
  const csm_float2 texels = csm_in_texels(found, vector(step), csm_rect(found).z * 0.5f);
  out[0] = texels.x;
  out[1] = texels.y;
}

float sampler_less_bleeding(float lit) {
  return csm_less_bleeding(lit);
}

void sampler_poisson(float out[16][2]) {
  for (int i = 0; i < 16; ++i) {
    out[i][0] = csm_poisson[i].x;
    out[i][1] = csm_poisson[i].y;
  }
}
