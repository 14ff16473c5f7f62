#include "techniques/draw_list.h"

#include "device/alpha_images.h"
#include "shader_code.h"

enum { row_bytes = 4 * sizeof(float) };

uint64_t draw_list_bytes(const plan_list *list, uint32_t rows) {
  return (uint64_t)list->instance_count * rows * row_bytes;
}

uint32_t draw_list_indices(const plan_draw *draw, const mesh_place *mesh) {
  return draw->index_count ? draw->index_count : mesh->index_count;
}

/* Faces that are left out of a draw: a mirrored instance shows its front faces as back ones. */
static gpu_cull draw_cull(const draw_list_info *info, const plan_draw *draw) {
  const mesh_place *mesh = &info->meshes[draw->mesh];
  const bool hides_back = info->cull == GPU_CULL_NONE && mesh->watertight && info->skip_hidden;
  const gpu_cull cull = hides_back ? GPU_CULL_BACK : info->cull;
  if (cull == GPU_CULL_NONE || mesh->two_sided)
    return GPU_CULL_NONE;
  const bool front = (cull == GPU_CULL_FRONT) != (draw->mirrored != 0);
  return front ? GPU_CULL_FRONT : GPU_CULL_BACK;
}

void draw_list(gpu gpu, const draw_list_info *info) {
  const gpu_program *current = NULL;
  for (uint32_t i = 0; i < info->list->draw_count; ++i) {
    const plan_draw *draw = &info->list->draws[i];
    const mesh_place *mesh = &info->meshes[draw->mesh];
    if (!mesh->index_count)
      continue;
    gpu_program *program = info->programs[draw_cull(info, draw)][mesh->shape];
    if (program != current) {
      current = program;
      gpu_pass_program(gpu, program);
    }
    if (mesh->alpha_mask)
      gpu_pass_bind(gpu, mesh->alpha_mask, &(uint32_t){0});
    gpu_pass_draw(
        gpu, &(gpu_draw){
                 .streams = {mesh->vertices, info->matrices, mesh->alpha_mask ? mesh->vertices : NULL},
                 .stream_offsets = {mesh->vertex_offset, info->offset + (uint64_t)draw->first * info->rows * row_bytes,
                                    mesh->uv_offset},
                 .indices = mesh->indices,
                 .index_offset = mesh->index_offset + (uint64_t)draw->first_index * mesh->index_size,
                 .index_size = mesh->index_size,
                 .count = draw_list_indices(draw, mesh),
                 .instance_count = draw->count,
             });
  }
}

/* What an alpha mask adds to a program: coordinates, a pixel shader that discards, and what that reads. */
static void add_alpha_mask(gpu_program_info *info, const draw_list_kind *kind, uint32_t uv_stride) {
  info->vertex = kind->cut_out_vertex;
  info->pixel = shader_alpha_mask_ps;
  info->streams[info->stream_count] = (gpu_stream){.stride = uv_stride};
  info->attributes[info->attribute_count++] =
      (gpu_attribute){.format = GPU_FORMAT_RG32_FLOAT, .stream = info->stream_count++};
  info->constants_count = 1;
  info->constants_sizes[0] = ALPHA_MASK_BLOCK;
  info->texture_count = 1;
}

csm_result draw_list_program(gpu gpu, const draw_list_kind *kind, mesh_vertices vertices, gpu_program **out) {
  gpu_program_info info = {
      .name = kind->name,
      .vertex = kind->vertex,
      .stream_count = 2,
      .streams = {{.stride = vertices.stride}, {.stride = kind->rows * row_bytes, .per_instance = true}},
      .attribute_count = 1 + kind->rows,
      .attributes = {{.format = GPU_FORMAT_RGB32_FLOAT}},
      .depth_format = kind->format,
      .depth_compare = kind->compare,
      .depth_clip = kind->clip,
      .cull = kind->cull,
      .raster_bias = kind->bias,
  };
  for (uint32_t row = 0; row < kind->rows; ++row)
    info.attributes[1 + row] =
        (gpu_attribute){.format = GPU_FORMAT_RGBA32_FLOAT, .stream = 1, .offset = row * row_bytes};
  if (vertices.uv_stride)
    add_alpha_mask(&info, kind, vertices.uv_stride);
  return gpu_program_create(gpu, &info, out);
}
