/* bench/floor_casters.h: what the bare loop draws: a scene's meshes on a device, and the pipelines for them. */
#ifndef HOST_FLOOR_CASTERS_H
#define HOST_FLOOR_CASTERS_H

#include "native/vulkan_commands.h"
#include "plan.h"
#include "scene/scene.h"

/* Where a mesh lies in the one buffer that holds them all, and how it is drawn. */
typedef struct floor_mesh {
  VkDeviceSize vertices, uvs, indices;
  VkIndexType index_type;
  uint32_t index_count;
  bool watertight;
  VkDescriptorSet cut_out; /* VK_NULL_HANDLE: opaque */
} floor_mesh;

typedef struct floor_casters {
  const vulkan_device *vulkan;
  floor_mesh *meshes;   /* as many as the scene's */
  vulkan_image *images; /* of its materials; empty where they cut nothing out */
  size_t image_count;
  vulkan_buffer geometry, constants;
  VkDescriptorSetLayout set_layout;
  VkDescriptorPool descriptors;
  VkPipelineLayout layout;
  VkPipeline pipelines[2][3]; /* by cut out or not, and by VkCullModeFlags */
} floor_casters;

/* Uploads the meshes, whose bounds are given, and waits. floor_casters_close is allowed after an error, too. */
VkResult floor_casters_open(floor_casters *out, vulkan_commands *commands, const scene *s, const plan_bounds *bounds);

/* What pipelines draw into. */
typedef struct floor_target {
  VkRenderPass pass; /* VK_NULL_HANDLE: dynamic rendering */
  uint32_t side;     /* in texels, of a D32 attachment */
  VkFormat moments;  /* of a colour attachment beside it: of two floats VSM's, of four EVSM4's. VK_FORMAT_UNDEFINED:
                        there is none */
} floor_target;
VkResult floor_casters_make_pipelines(floor_casters *c, const floor_target *target);
void floor_casters_close(floor_casters *c);

/* What an instance's matrix takes in a vertex buffer. */
enum { floor_matrix_bytes = 12 * sizeof(float) };

/* Faces that csm leaves out of a draw without a face_culling: those of a watertight mesh that look away. */
VkCullModeFlags floor_cull(const floor_mesh *mesh, bool mirrored);

#endif
