#include "hard/engine.h"
#include "base/host.h"
#include "csm/csm_vulkan.h"
#include "native/vulkan_commands.h"
#include <stdlib.h>
#include <string.h>

/* An image that the engine hands over, and the buffer that it is filled from. */
typedef struct input {
  vulkan_image image;
  vulkan_buffer staging;
  csm_vulkan_image lent;
  VkFormat format;
  uint32_t texel_bytes;
} input;

/* A mesh in the engine's own buffers. */
typedef struct own_mesh {
  vulkan_buffer vertices, indices;
  csm_mesh handle;
} own_mesh;

struct hard_engine {
  const host_setup *setup;
  vulkan_device vulkan;
  vulkan_commands commands;
  stage stage; /* its context is on the engine's device */
  input depth, normals;
  vulkan_buffer mask;
  own_mesh *meshes; /* by the scene's; NULL: they are copied */
  uint64_t frame;
};

static int refuse(VkResult result) {
  return result ? host_fail(HOST_NO_DEVICE, "the engine's device: %s", vulkan_reason(result)) : 0;
}

bool hard_engine_there(const host_options *options) {
  return options->backends[0]; /* host_backend_names begins with it */
}

/* ---- opening ---- */

static int open_context(hard_engine *e) {
  const csm_vulkan_device lent = vulkan_device_lend(&e->vulkan);
  const csm_create_info info = {.struct_size = sizeof info,
                                .version = CSM_VERSION,
                                .flags = CSM_CREATE_RAYS,
                                .backend = host_backend_names[0],
                                .vulkan = &lent,
                                .log = stage_log,
                                .user = &e->stage};
  e->stage.backend = host_backend_names[0];
  return csm_create(&info, &e->stage.context) ? HOST_NO_DEVICE : 0;
}

static VkResult input_open(hard_engine *e, input *out, VkFormat format, uint32_t texel_bytes) {
  const uint32_t width = e->setup->width, height = e->setup->height;
  const vulkan_image_info info = {.format = format,
                                  .width = width,
                                  .height = height,
                                  .usage = VK_IMAGE_USAGE_TRANSFER_DST_BIT | VK_IMAGE_USAGE_SAMPLED_BIT};
  out->format = format;
  out->texel_bytes = texel_bytes;
  VkResult result = vulkan_image_open(&out->image, &e->vulkan, &info);
  if (!result)
    result = vulkan_buffer_open(&out->staging, &e->vulkan, (VkDeviceSize)width * height * texel_bytes,
                                VK_BUFFER_USAGE_TRANSFER_SRC_BIT);
  out->lent = (csm_vulkan_image){.struct_size = sizeof out->lent,
                                 .layout = VK_IMAGE_LAYOUT_SHADER_READ_ONLY_OPTIMAL,
                                 .view = out->image.view,
                                 .format = format,
                                 .width = width,
                                 .height = height};
  return result;
}

static VkResult open_device(hard_engine *e, const char *name) {
  const VkDeviceSize pixels = (VkDeviceSize)e->setup->width * e->setup->height;
  VkResult result = vulkan_device_open(&e->vulkan, name);
  if (!result)
    result = vulkan_commands_open(&e->commands, &e->vulkan);
  if (!result)
    result = vulkan_buffer_open(&e->mask, &e->vulkan, pixels, VK_BUFFER_USAGE_TRANSFER_DST_BIT);
  if (!result)
    result = input_open(e, &e->depth, VK_FORMAT_R32_SFLOAT, 4);
  return result ? result : input_open(e, &e->normals, VK_FORMAT_R32G32B32A32_SFLOAT, 16);
}

/* ---- meshes in the engine's buffers ---- */

static VkResult fill_buffer(vulkan_buffer *out, const vulkan_device *vulkan, const void *data, size_t size,
                            VkBufferUsageFlags usage) {
  const VkResult result = vulkan_buffer_open(out, vulkan, size, usage);
  if (!result)
    memcpy(out->mapped, data, size);
  return result;
}

static int make_own_mesh(hard_engine *e, size_t index) {
  const scene_mesh *mesh = &e->setup->scene.meshes[index];
  own_mesh *own = &e->meshes[index];
  csm_mesh_info info = assets_mesh_info(&e->stage.assets, index);
  double minimum[3], maximum[3];
  VkResult result = fill_buffer(&own->vertices, &e->vulkan, mesh->positions,
                                3 * sizeof(float) * (size_t)mesh->vertex_count, VK_BUFFER_USAGE_VERTEX_BUFFER_BIT);
  if (!result)
    result = fill_buffer(&own->indices, &e->vulkan, mesh->indices, (size_t)mesh->index_size * mesh->index_count,
                         VK_BUFFER_USAGE_INDEX_BUFFER_BIT);
  if (result)
    return refuse(result);
  const csm_vulkan_mesh lent = {.struct_size = sizeof lent,
                                .vertex_stride = 12,
                                .vertices = own->vertices.buffer,
                                .indices = own->indices.buffer};
  info.positions = info.indices = NULL;
  info.vulkan = &lent;
  scene_mesh_bounds(mesh, minimum, maximum);
  for (int axis = 0; axis < 3; axis++) {
    info.bounds_min[axis] = (float)minimum[axis];
    info.bounds_max[axis] = (float)maximum[axis];
  }
  return csm_mesh_create(e->stage.context, &info, &own->handle) ? HOST_BAD_INPUT : 0;
}

/* The instances draw them in place of the copied ones. */
static int use_own_meshes(hard_engine *e) {
  const scene *from = &e->setup->scene;
  int code = 0;
  e->meshes = host_allocate(from->mesh_count, sizeof *e->meshes);
  for (size_t m = 0; code == 0 && m < from->mesh_count; m++)
    code = make_own_mesh(e, m);
  if (code)
    return code;
  csm_instance *instances = host_allocate(from->instance_count, sizeof *instances);
  for (size_t i = 0; i < from->instance_count; i++) {
    instances[i] = (csm_instance){.struct_size = sizeof *instances, .mesh = e->meshes[from->instances[i].mesh].handle};
    memcpy(instances[i].transform, from->instances[i].transform, sizeof instances[i].transform);
  }
  const csm_scene_batch batch = {.struct_size = sizeof batch,
                                 .count = (uint32_t)from->instance_count,
                                 .ids = e->stage.instances,
                                 .instances = instances};
  code = csm_scene_change(e->stage.scene, &batch) ? HOST_BAD_INPUT : 0;
  free(instances);
  return code;
}

int hard_engine_open(hard_engine **out, const host_setup *setup, const host_options *options, bool engine_buffers) {
  hard_engine *e = *out = host_allocate(1, sizeof *e);
  e->setup = setup;
  int code = refuse(open_device(e, options->device));
  if (code == 0)
    code = open_context(e);
  if (code == 0)
    code = stage_load(&e->stage, setup);
  if (code == 0 && engine_buffers)
    code = use_own_meshes(e);
  return code;
}

static void input_close(const input *image, const vulkan_device *vulkan) {
  vulkan_image_close(&image->image, vulkan);
  vulkan_buffer_close(&image->staging, vulkan);
}

void hard_engine_close(hard_engine *e) {
  if (!e)
    return;
  stage_close(&e->stage);
  if (e->vulkan.device) {
    for (size_t m = 0; e->meshes && m < e->setup->scene.mesh_count; m++) {
      vulkan_buffer_close(&e->meshes[m].vertices, &e->vulkan);
      vulkan_buffer_close(&e->meshes[m].indices, &e->vulkan);
    }
    input_close(&e->depth, &e->vulkan);
    input_close(&e->normals, &e->vulkan);
    vulkan_buffer_close(&e->mask, &e->vulkan);
    vulkan_commands_close(&e->commands);
  }
  vulkan_device_close(&e->vulkan);
  free(e->meshes);
  free(e);
}

stage *hard_engine_stage(hard_engine *engine) {
  return &engine->stage;
}

/* ---- frames ---- */

static const vulkan_use undefined = {VK_IMAGE_LAYOUT_UNDEFINED, VK_PIPELINE_STAGE_TOP_OF_PIPE_BIT, 0};
static const vulkan_use written = {VK_IMAGE_LAYOUT_TRANSFER_DST_OPTIMAL, VK_PIPELINE_STAGE_TRANSFER_BIT,
                                   VK_ACCESS_TRANSFER_WRITE_BIT};
static const vulkan_use copied = {VK_IMAGE_LAYOUT_TRANSFER_SRC_OPTIMAL, VK_PIPELINE_STAGE_TRANSFER_BIT,
                                  VK_ACCESS_TRANSFER_READ_BIT};
static const vulkan_use sampled = {VK_IMAGE_LAYOUT_SHADER_READ_ONLY_OPTIMAL,
                                   VK_PIPELINE_STAGE_FRAGMENT_SHADER_BIT | VK_PIPELINE_STAGE_COMPUTE_SHADER_BIT,
                                   VK_ACCESS_SHADER_READ_BIT};

static VkBufferImageCopy whole_picture(const hard_engine *e) {
  return (VkBufferImageCopy){
      .imageSubresource = {.aspectMask = VK_IMAGE_ASPECT_COLOR_BIT, .layerCount = 1},
      .imageExtent = {e->setup->width, e->setup->height, 1},
  };
}

static void upload(hard_engine *e, const input *to, const void *texels) {
  const VkBufferImageCopy region = whole_picture(e);
  memcpy(to->staging.mapped, texels, (size_t)e->setup->width * e->setup->height * to->texel_bytes);
  vulkan_transition(e->commands.buffer, to->image.image, VK_IMAGE_ASPECT_COLOR_BIT, undefined, written);
  vkCmdCopyBufferToImage(e->commands.buffer, to->staging.buffer, to->image.image, written.layout, 1, &region);
  vulkan_transition(e->commands.buffer, to->image.image, VK_IMAGE_ASPECT_COLOR_BIT, written, sampled);
}

static csm_result record(hard_engine *e, const hard_inputs *inputs) {
  stage *s = &e->stage;
  const csm_mask_info info = {.struct_size = sizeof info,
                              .frame = &s->frame,
                              .width = e->setup->width,
                              .height = e->setup->height,
                              .camera_depth = inputs->camera_depth ? &e->depth.lent : NULL,
                              .normals = inputs->normals ? &e->normals.lent : NULL};
  csm_binding binding = {.struct_size = sizeof binding, .view = s->view};
  s->frame.frame = ++e->frame;
  s->frame.command_buffer = e->commands.buffer;
  csm_result result = csm_render_cascades(s->cascades, &s->frame);
  if (result == CSM_SUCCESS)
    result = csm_resolve_mask(s->view, s->cascades, &info);
  if (result == CSM_SUCCESS)
    result = csm_bind(s->cascades, &binding);
  if (result)
    return result;
  const VkBufferImageCopy region = whole_picture(e);
  const VkImage image = (VkImage)binding.native_mask;
  vulkan_transition(e->commands.buffer, image, VK_IMAGE_ASPECT_COLOR_BIT, sampled, copied);
  vkCmdCopyImageToBuffer(e->commands.buffer, image, copied.layout, e->mask.buffer, 1, &region);
  vulkan_transition(e->commands.buffer, image, VK_IMAGE_ASPECT_COLOR_BIT, copied, sampled);
  return CSM_SUCCESS;
}

int hard_engine_draw(hard_engine *e, const hard_inputs *inputs, const camera *from, const scene_light *light,
                     float *mask) {
  const size_t pixels = (size_t)e->setup->width * e->setup->height;
  int code = refuse(vulkan_commands_begin(&e->commands));
  if (code)
    return code;
  if (inputs->camera_depth)
    upload(e, &e->depth, inputs->camera_depth);
  if (inputs->normals)
    upload(e, &e->normals, inputs->normals);
  stage_look(&e->stage, from);
  e->stage.light = stage_light(light);
  const csm_result result = record(e, inputs);
  code = refuse(vulkan_commands_finish(&e->commands));
  if (result)
    return HOST_BAD_INPUT;
  csm_retire(e->stage.context, e->frame);
  for (size_t i = 0; code == 0 && i < pixels; i++)
    mask[i] = ((const uint8_t *)e->mask.mapped)[i] / 255.0f;
  return code;
}

int hard_engine_map(hard_engine *e, uint32_t index, csm_cascade_info *cascade, float **out) {
  csm_binding binding = {.struct_size = sizeof binding};
  vulkan_buffer texels = {0};
  if (csm_bind(e->stage.cascades, &binding))
    return HOST_BAD_INPUT;
  const uint32_t side = binding.resolutions[index];
  const size_t size = (size_t)side * side * sizeof(float);
  *cascade = binding.cascades[index];
  const VkImage image = (VkImage)binding.native_maps;
  const VkBufferImageCopy region = {
      .imageSubresource = {.aspectMask = VK_IMAGE_ASPECT_DEPTH_BIT, .baseArrayLayer = index, .layerCount = 1},
      .imageExtent = {side, side, 1},
  };
  VkResult result = vulkan_buffer_open(&texels, &e->vulkan, size, VK_BUFFER_USAGE_TRANSFER_DST_BIT);
  if (!result)
    result = vulkan_commands_begin(&e->commands);
  if (!result) {
    vulkan_transition(e->commands.buffer, image, VK_IMAGE_ASPECT_DEPTH_BIT, sampled, copied);
    vkCmdCopyImageToBuffer(e->commands.buffer, image, copied.layout, texels.buffer, 1, &region);
    vulkan_transition(e->commands.buffer, image, VK_IMAGE_ASPECT_DEPTH_BIT, copied, sampled);
    result = vulkan_commands_finish(&e->commands);
  }
  if (!result) {
    *out = host_allocate(size, 1);
    memcpy(*out, texels.mapped, size);
  }
  vulkan_buffer_close(&texels, &e->vulkan);
  return refuse(result);
}
