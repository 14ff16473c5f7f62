#include "draw_list.h"

enum { row_bytes = 4 * sizeof(float), position_bytes = 3 * sizeof(float) };

void draw_list(pass_gpu gpu, const plan_list *list, const pass_mesh *meshes, gpu_buffer *matrices, uint64_t offset,
               uint32_t rows) {
  for (uint32_t i = 0; i < list->draw_count; ++i) {
    const plan_draw *draw = &list->draws[i];
    const pass_mesh *mesh = &meshes[draw->mesh];
    gpu.api->pass_draw(gpu.device,
                       &(gpu_draw){
                           .streams = {mesh->buffer, matrices},
                           .stream_offsets = {mesh->vertices, offset + (uint64_t)draw->first * rows * row_bytes},
                           .indices = mesh->buffer,
                           .index_offset = mesh->indices,
                           .index_size = mesh->index_size,
                           .count = mesh->index_count,
                           .instance_count = draw->count,
                       });
  }
}

csm_result draw_list_program(pass_gpu gpu, const char *name, gpu_code vertex, uint32_t rows, gpu_compare compare,
                             bool clip, gpu_program **out) {
  gpu_program_info info = {
      .name = name,
      .vertex = vertex,
      .stream_count = 2,
      .streams = {{.stride = position_bytes}, {.stride = rows * row_bytes, .per_instance = true}},
      .attribute_count = 1 + rows,
      .attributes = {{.format = GPU_FORMAT_RGB32_FLOAT}},
      .depth_format = GPU_FORMAT_D32_FLOAT,
      .depth_compare = compare,
      .depth_clip = clip,
      .cull = GPU_CULL_NONE,
  };
  for (uint32_t row = 0; row < rows; ++row)
    info.attributes[1 + row] =
        (gpu_attribute){.format = GPU_FORMAT_RGBA32_FLOAT, .stream = 1, .offset = row * row_bytes};
  return gpu.api->program_create(gpu.device, &info, out);
}
