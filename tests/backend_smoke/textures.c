/* textures.c: samplers, as many textures and bindings as there may be, and vertices in narrow formats. */
#include "smoke.h"

#include <math.h>
#include <string.h>

/* ---- samplers ---- */

enum { SAMPLED_SIDE = 64, SAMPLED_LEVELS = 4, COLUMNS = 8, WAYS = 3, RESULT_SIDE = WAYS * COLUMNS };

typedef struct sampling {
  gpu_image *image, *result;
  gpu_target *target;
} sampling;

/* Level n holds n everywhere in x, and -n in y. */
static void make_sampling(smoke *s, sampling *out) {
  const uint32_t usage = GPU_IMAGE_SAMPLED | GPU_IMAGE_TARGET | GPU_IMAGE_COPY_SOURCE;
  out->image = scrap_image(s, (gpu_image_info){"levels", GPU_FORMAT_RG16_FLOAT, usage, SAMPLED_SIDE, SAMPLED_SIDE, 1,
                                               false, SAMPLED_LEVELS});
  out->result =
      scrap_image(s, (gpu_image_info){"result", GPU_FORMAT_RG32_FLOAT, usage, RESULT_SIDE, RESULT_SIDE, 1, false, 1});
  out->target = scrap_target(s, (gpu_target_info){.name = "result", .color = out->result});
  begin(s, 0);
  for (uint32_t level = 0; level < SAMPLED_LEVELS; level++) {
    gpu_target *target = scrap_target(s, (gpu_target_info){.name = "level", .color = out->image, .color_level = level});
    gpu_pass_begin(
        s->g,
        &(gpu_pass_info){.target = target, .color_load = GPU_LOAD_CLEAR, .clear_color = {(float)level, -(float)level}});
    gpu_pass_end(s->g);
  }
  end_and_wait(s, 0);
}

/* What a sampler gives by a level, and by gradients in texels, which are told or the quad's own. */
static void sample(smoke *s, const sampling *on, gpu_sampler sampler, const float level_and_gradients[3],
                   float out[WAYS]) {
  gpu_program_info info = screen_program("sample", shader_sample_ps, GPU_FORMAT_RG32_FLOAT);
  info.constants_count = 1;
  info.constants_sizes[0] = 32;
  info.sampler_count = 1;
  info.samplers[0] = sampler;
  gpu_program *program = scrap_program(s, info);
  gpu_bindings *bindings = scrap_bindings(
      s, (gpu_bindings_info){
             .name = "sample", .program = program, .constants = {s->slots[0].upload}, .textures = {on->image}});
  begin(s, 0);
  const float texel = 1.0f / SAMPLED_SIDE;
  const uint32_t offset = put_constants(s, 0, (const float[4]){0.5f, 0.5f, level_and_gradients[0]});
  const float gradients[4] = {level_and_gradients[1] * texel, 0, 0, level_and_gradients[2] * texel};
  memcpy((char *)gpu_buffer_memory(s->g, s->slots[0].upload) + offset + 16, gradients, sizeof gradients);
  draw_screen(s, &(gpu_pass_info){.target = on->target, .color_load = GPU_LOAD_DISCARD}, program, bindings, offset);
  end_and_wait(s, 0);
  uint32_t row_bytes;
  const gpu_region all = {.width = RESULT_SIDE, .height = RESULT_SIDE};
  const float *row = (const float *)read_level(s, on->result, GPU_FORMAT_RG32_FLOAT, all, &row_bytes);
  for (uint32_t way = 0; way < WAYS; way++) {
    const float *texel = row + (way * COLUMNS + COLUMNS / 2) * 2;
    out[way] = texel[0];
    CHECK(s, texel[1] == -texel[0], "%g, not %g", (double)texel[1], -(double)texel[0]);
  }
}

/* Whether what was drawn by gradients is what the sampler's definition gives. lavapipe 22.3 takes the quad's own
   gradients for those told, and for a level, where the sampler is anisotropic: so these alone are held there. */
static void check_sampler(smoke *s, const sampling *on, gpu_sampler sampler, const float asked[3],
                          const float expected[2]) {
  const bool anisotropic = sampler == GPU_SAMPLER_ANISOTROPIC_CLAMP;
  const float slack = sampler < GPU_SAMPLER_TRILINEAR_CLAMP ? 0 : 0.01f;
  float drawn[WAYS];
  sample(s, on, sampler, asked, drawn);
  for (uint32_t way = anisotropic ? WAYS - 1 : 0; way < WAYS; way++)
    CHECK(s, fabsf(drawn[way] - expected[way > 0]) <= slack, "sampler %d, level %g, steps %g, %g: %g by way %u",
          (int)sampler, (double)asked[0], (double)asked[1], (double)asked[2], (double)drawn[way], way);
}

/* A row: a sampler, what is asked, and what must come out by the definition of each. */
void test_samplers(smoke *s) {
  const struct {
    gpu_sampler sampler;
    float asked[3];    /* a level; steps in x and y, in texels */
    float expected[2]; /* by the level, by the steps */
  } rows[] = {
      {GPU_SAMPLER_POINT_CLAMP, {1.25f, 4, 1}, {1, 2}},   {GPU_SAMPLER_POINT_CLAMP, {1.75f, 1, 1}, {2, 0}},
      {GPU_SAMPLER_LINEAR_CLAMP, {2.25f, 2, 2}, {2, 1}},  {GPU_SAMPLER_TRILINEAR_CLAMP, {1.5f, 8, 1}, {1.5f, 3}},
      {GPU_SAMPLER_TRILINEAR_CLAMP, {9, 2, 4}, {3, 2}},   {GPU_SAMPLER_TRILINEAR_CLAMP, {0.25f, 1, 1}, {0.25f, 0}},
      {GPU_SAMPLER_ANISOTROPIC_CLAMP, {0, 8, 1}, {0, 0}}, {GPU_SAMPLER_ANISOTROPIC_CLAMP, {0, 8, 4}, {0, 2}},
      {GPU_SAMPLER_ANISOTROPIC_CLAMP, {0, 4, 4}, {0, 2}},
  };
  if (!(s->can.formats[GPU_FORMAT_RG16_FLOAT] & GPU_CAN_FILTER))
    return;
  for (uint32_t i = 0; i < sizeof rows / sizeof *rows; i++) {
    sampling on;
    if (rows[i].sampler == GPU_SAMPLER_ANISOTROPIC_CLAMP && s->can.max_anisotropy < 8)
      continue;
    make_sampling(s, &on);
    check_sampler(s, &on, rows[i].sampler, rows[i].asked, rows[i].expected);
    scrap_free(s);
  }
}

/* ---- textures ---- */

enum { SIDE = 64, ROWS = 47, MANY = SIDE * ROWS }; /* MANY: over 3000 */

/* A program that reads eight textures, and textures of which number k holds k + 1. */
typedef struct eight {
  gpu_program *program;
  gpu_image *textures[GPU_MAX_TEXTURES], *result;
  gpu_target *target;
} eight;

static void make_eight(smoke *s, eight *out) {
  const uint32_t usage = GPU_IMAGE_TARGET | GPU_IMAGE_SAMPLED | GPU_IMAGE_COPY_SOURCE;
  gpu_program_info info = screen_program("eight", shader_eight_ps, GPU_FORMAT_RG32_FLOAT);
  info.constants_count = 0;
  info.texture_count = GPU_MAX_TEXTURES;
  out->program = scrap_program(s, info);
  out->result = scrap_image(s, (gpu_image_info){"result", GPU_FORMAT_RG32_FLOAT, usage, SIDE, SIDE, 1, false, 1});
  out->target = scrap_target(s, (gpu_target_info){.name = "result", .color = out->result});
  begin(s, 0);
  for (uint32_t i = 0; i < GPU_MAX_TEXTURES; i++) {
    const gpu_format format = i % 2 ? GPU_FORMAT_R16_FLOAT : GPU_FORMAT_R32_FLOAT;
    gpu_image *image = scrap_image(s, (gpu_image_info){"one of eight", format, usage, SIDE, SIDE, 1, false, 1});
    gpu_target *into = scrap_target(s, (gpu_target_info){.name = "one of eight", .color = image});
    gpu_pass_begin(s->g,
                   &(gpu_pass_info){.target = into, .color_load = GPU_LOAD_CLEAR, .clear_color = {(float)(i + 1)}});
    gpu_pass_end(s->g);
    gpu_make_readable(s->g, image, NULL);
    out->textures[i] = image;
  }
  end_and_wait(s, 0);
}

/* Bindings whose texture k is number k + turn, counted round. */
static gpu_bindings *bind_eight(smoke *s, const eight *on, uint32_t turn) {
  gpu_bindings_info info = {.name = "eight", .program = on->program};
  for (uint32_t k = 0; k < GPU_MAX_TEXTURES; k++)
    info.textures[k] = on->textures[(k + turn) % GPU_MAX_TEXTURES];
  gpu_bindings *bindings = NULL;
  const csm_result result = gpu_bindings_create(s->g, &info, &bindings);
  CHECK(s, result == CSM_SUCCESS && bindings, "%d", result);
  return bindings;
}

/* In one pass, a texel with each of the bindings; each texture is seen at its own place. */
static void check_eight(smoke *s, const eight *on, gpu_bindings *const *bindings, const uint32_t *turns) {
  begin(s, 0);
  gpu_pass_begin(s->g, &(gpu_pass_info){.target = on->target, .color_load = GPU_LOAD_DISCARD});
  gpu_pass_program(s->g, on->program);
  for (uint32_t i = 0; i < MANY; i++) {
    gpu_pass_area(s->g, &(gpu_rect){i % SIDE, i / SIDE, 1, 1});
    gpu_pass_bind(s->g, bindings[i], NULL);
    gpu_pass_draw(s->g, &(gpu_draw){.count = 3, .instance_count = 1});
  }
  gpu_pass_end(s->g);
  end_and_wait(s, 0);
  uint32_t row_bytes, wrong = 0;
  const gpu_region all = {.width = SIDE, .height = ROWS};
  const uint8_t *rows = read_level(s, on->result, GPU_FORMAT_RG32_FLOAT, all, &row_bytes);
  for (uint32_t i = 0; i < MANY; i++) {
    const float *sums = (const float *)(rows + i / SIDE * row_bytes) + i % SIDE * 2;
    uint32_t expected[2] = {0, 0};
    for (uint32_t k = GPU_MAX_TEXTURES; k-- > 0;)
      expected[k / 4] = expected[k / 4] * 10 + (k + turns[i]) % GPU_MAX_TEXTURES + 1;
    wrong += sums[0] != (float)expected[0] || sums[1] != (float)expected[1];
  }
  CHECK(s, wrong == 0, "%u of %u texels", wrong, (uint32_t)MANY);
}

/* More bindings than a heap of descriptors begins with; then every second one is made anew, for other textures. */
void test_many_bindings(smoke *s) {
  eight on;
  gpu_bindings *bindings[MANY];
  uint32_t turns[MANY];
  make_eight(s, &on);
  for (uint32_t i = 0; i < MANY; i++) {
    turns[i] = i;
    bindings[i] = bind_eight(s, &on, turns[i]);
  }
  check_eight(s, &on, bindings, turns);
  for (uint32_t i = 0; i < MANY; i += 2)
    gpu_bindings_destroy(s->g, bindings[i]);
  for (uint32_t i = 0; i < MANY; i += 2) {
    turns[i] = i / 2 + 3;
    bindings[i] = bind_eight(s, &on, turns[i]);
  }
  check_eight(s, &on, bindings, turns);
  for (uint32_t i = 0; i < MANY; i++)
    gpu_bindings_destroy(s->g, bindings[i]);
  scrap_free(s);
}

/* ---- attributes ---- */

/* One corner of a triangle over everything, with a sum of 2^-1 and a bit at each lower place but one. */
typedef struct narrow_vertex {
  float position[3];
  uint16_t normalised[2]; /* 0 and 65535: 1 */
  uint16_t pair[2];       /* halves: -1 and 2^-2 */
  uint16_t four[4];       /* halves: 2^-3, 2^-4, 0, 2^-6 */
  float single;           /* 2^-7 */
  uint32_t whole;         /* of 256: 3 */
} narrow_vertex;

void test_attributes(smoke *s) {
  const float expected = 0.25f + 0.125f + 0.0625f + 0.015625f + 0.0078125f + 3.0f / 256;
  const narrow_vertex vertex = {.normalised = {0, 65535},
                                .pair = {0xbc00, 0x3400},
                                .four = {0x3000, 0x2c00, 0, 0x2400},
                                .single = 0.0078125f,
                                .whole = 3};
  const float corners[3][2] = {{-1, -1}, {3, -1}, {-1, 3}};
  gpu_program *program = scrap_program(
      s, (gpu_program_info){.name = "attributes",
                            .vertex = shader_attributes_vs,
                            .stream_count = 1,
                            .streams = {{.stride = sizeof(narrow_vertex)}},
                            .attribute_count = 6,
                            .attributes = {{GPU_FORMAT_RGB32_FLOAT, 0, offsetof(narrow_vertex, position)},
                                           {GPU_FORMAT_RG16_UNORM, 0, offsetof(narrow_vertex, normalised)},
                                           {GPU_FORMAT_RG16_FLOAT, 0, offsetof(narrow_vertex, pair)},
                                           {GPU_FORMAT_RGBA16_FLOAT, 0, offsetof(narrow_vertex, four)},
                                           {GPU_FORMAT_R32_FLOAT, 0, offsetof(narrow_vertex, single)},
                                           {GPU_FORMAT_R32_UINT, 0, offsetof(narrow_vertex, whole)}},
                            .depth_format = GPU_FORMAT_D32_FLOAT,
                            .depth_compare = GPU_COMPARE_LESS});
  const smoke_slot *slot = &s->slots[0];
  begin(s, 0);
  narrow_vertex *vertices = gpu_buffer_memory(s->g, slot->upload);
  for (uint32_t i = 0; i < 3; i++) {
    vertices[i] = vertex;
    memcpy(vertices[i].position, corners[i], sizeof corners[i]);
  }
  gpu_pass_begin(s->g, &(gpu_pass_info){.target = s->plain.target, .depth_load = GPU_LOAD_CLEAR, .clear_depth = 1});
  gpu_pass_program(s->g, program);
  gpu_pass_draw(s->g, &(gpu_draw){.streams = {slot->upload}, .count = 3, .instance_count = 1});
  gpu_pass_end(s->g);
  copy_layer(s, slot->readback, 0, s->plain.image, GPU_FORMAT_D32_FLOAT, 0);
  end_and_wait(s, 0);
  const float *depth = gpu_buffer_memory(s->g, slot->readback);
  CHECK(s, count_texels(depth, expected) == SIZE * SIZE, "%.9g, not %.9g", (double)depth[0], (double)expected);
  scrap_free(s);
}
