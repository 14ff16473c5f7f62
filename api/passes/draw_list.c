#include "draw_list.h"

enum { row_bytes = 4 * sizeof(float) };

void draw_list(pass_gpu gpu, gpu_program *const *programs, const plan_list *list, const pass_mesh *meshes,
               gpu_buffer *matrices, uint64_t offset, uint32_t rows) {
  uint32_t current = UINT32_MAX;
  for (uint32_t i = 0; i < list->draw_count; ++i) {
    const plan_draw *draw = &list->draws[i];
    const pass_mesh *mesh = &meshes[draw->mesh];
    if (mesh->programs != current) {
      current = mesh->programs;
      gpu.api->pass_program(gpu.device, programs[current]);
    }
    gpu.api->pass_draw(gpu.device,
                       &(gpu_draw){
                           .streams = {mesh->vertices, matrices},
                           .stream_offsets = {mesh->vertex_offset, offset + (uint64_t)draw->first * rows * row_bytes},
                           .indices = mesh->indices,
                           .index_offset = mesh->index_offset,
                           .index_size = mesh->index_size,
                           .count = mesh->index_count,
                           .instance_count = draw->count,
                       });
  }
}

csm_result draw_list_program(pass_gpu gpu, const draw_list_kind *kind, uint32_t vertex_stride, gpu_program **out) {
  gpu_program_info info = {
      .name = kind->name,
      .vertex = kind->vertex,
      .stream_count = 2,
      .streams = {{.stride = vertex_stride}, {.stride = kind->rows * row_bytes, .per_instance = true}},
      .attribute_count = 1 + kind->rows,
      .attributes = {{.format = GPU_FORMAT_RGB32_FLOAT}},
      .depth_format = GPU_FORMAT_D32_FLOAT,
      .depth_compare = kind->compare,
      .depth_clip = kind->clip,
      .cull = GPU_CULL_NONE,
  };
  for (uint32_t row = 0; row < kind->rows; ++row)
    info.attributes[1 + row] =
        (gpu_attribute){.format = GPU_FORMAT_RGBA32_FLOAT, .stream = 1, .offset = row * row_bytes};
  return gpu.api->program_create(gpu.device, &info, out);
}
