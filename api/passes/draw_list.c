#include "draw_list.h"

#include "shader_code.h"

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
    if (mesh->opacity)
      gpu.api->pass_bind(gpu.device, mesh->opacity, &(uint32_t){0});
    gpu.api->pass_draw(
        gpu.device,
        &(gpu_draw){
            .streams = {mesh->vertices, matrices, mesh->opacity ? mesh->vertices : NULL},
            .stream_offsets = {mesh->vertex_offset, offset + (uint64_t)draw->first * rows * row_bytes, mesh->uv_offset},
            .indices = mesh->indices,
            .index_offset = mesh->index_offset,
            .index_size = mesh->index_size,
            .count = mesh->index_count,
            .instance_count = draw->count,
        });
  }
}

/* What an opacity adds to a program: coordinates, a pixel shader that discards, and what that reads. */
static void add_opacity(gpu_program_info *info, const draw_list_kind *kind, uint32_t uv_stride) {
  info->vertex = kind->cut_out_vertex;
  info->pixel = shader_opacity_ps;
  info->streams[info->stream_count] = (gpu_stream){.stride = uv_stride};
  info->attributes[info->attribute_count++] =
      (gpu_attribute){.format = GPU_FORMAT_RG32_FLOAT, .stream = info->stream_count++};
  info->constants_count = 1;
  info->constants_sizes[0] = OPACITY_BLOCK;
  info->texture_count = 1;
}

csm_result draw_list_program(pass_gpu gpu, const draw_list_kind *kind, pass_vertices vertices, gpu_program **out) {
  gpu_program_info info = {
      .name = kind->name,
      .vertex = kind->vertex,
      .stream_count = 2,
      .streams = {{.stride = vertices.stride}, {.stride = kind->rows * row_bytes, .per_instance = true}},
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
  if (vertices.uv_stride)
    add_opacity(&info, kind, vertices.uv_stride);
  return gpu.api->program_create(gpu.device, &info, out);
}
