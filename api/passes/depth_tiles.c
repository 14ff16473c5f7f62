#include "passes.h"
#include "shader_code.h"

#include <string.h>

csm_result depth_tiles_program(pass_gpu gpu, bool coarse, gpu_program **out) {
  const gpu_program_info info = {
      .name = coarse ? "depth tiles, large" : "depth tiles",
      .vertex = shader_screen_vs,
      .pixel = coarse ? shader_depth_tiles_large_ps : shader_depth_tiles_ps,
      .constants_count = 1,
      .constants_sizes = {DEPTH_TILES_BLOCK},
      .texture_count = 1,
      .color_format = GPU_FORMAT_RG32_FLOAT,
      .cull = GPU_CULL_NONE,
  };
  return gpu.api->program_create(gpu.device, &info, out);
}

void depth_tiles_write(void *out, uint32_t width, uint32_t height, float clear) {
  float blocks[DEPTH_TILES_BLOCKS / sizeof(float)] = {0};
  float *large = &blocks[DEPTH_TILES_BLOCK / sizeof(float)];
  blocks[0] = (float)width;
  blocks[1] = (float)height;
  blocks[2] = clear;
  large[0] = (float)((width + DEPTH_TILES_FINE_PX - 1) / DEPTH_TILES_FINE_PX);
  large[1] = (float)((height + DEPTH_TILES_FINE_PX - 1) / DEPTH_TILES_FINE_PX);
  memcpy(out, blocks, sizeof blocks);
}

gpu_bindings_info depth_tiles_inputs(const gpu_program *program, gpu_buffer *constants, gpu_image *from) {
  return (gpu_bindings_info){.name = "depth tiles", .program = program, .constants = {constants}, .textures = {from}};
}

void depth_tiles_record(pass_gpu gpu, const depth_tiles_pass *pass) {
  gpu.api->marker_begin(gpu.device, "depth tiles");
  for (uint32_t size = 0; size < 2; ++size) {
    const uint32_t offset = pass->constants_offset + size * DEPTH_TILES_BLOCK;
    gpu.api->pass_begin(gpu.device, &(gpu_pass_info){.target = pass->targets[size], .color_load = GPU_LOAD_DISCARD});
    gpu.api->pass_program(gpu.device, pass->programs[size]);
    gpu.api->pass_bind(gpu.device, pass->bindings[size], &offset);
    gpu.api->pass_draw(gpu.device, &(gpu_draw){.count = 3, .instance_count = 1});
    gpu.api->pass_end(gpu.device);
    gpu.api->make_readable(gpu.device, pass->images[size], NULL);
  }
  const gpu_region all = {.width = pass->columns, .height = pass->rows};
  gpu.api->copy_image(gpu.device, pass->out, 0, pass->row_bytes, pass->images[1], &all);
  gpu.api->marker_end(gpu.device);
}
