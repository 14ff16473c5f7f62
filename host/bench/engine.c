#include "bench/engine.h"
#include "base/host.h"
#include "bench/vulkan_device.h"
#include "csm/csm_vulkan.h"
#include <stdlib.h>
#include <string.h>

enum { frame_slots = 3, warm_up = 2 * frame_slots };

typedef struct engine {
  vulkan_device vulkan;
  VkCommandPool pool;
  VkCommandBuffer commands[frame_slots];
  VkFence fences[frame_slots];
  csm_context *context;
  csm_cascades *cascades;
  csm_mesh *meshes;
  csm_instance *instances;
  uint32_t allocations;
} engine;

static void *CSM_CALL count_allocate(void *user, size_t size, size_t alignment) {
  ++((engine *)user)->allocations;
  return aligned_alloc(alignment, (size + alignment - 1) / alignment * alignment);
}

static void CSM_CALL count_release(void *user, void *memory) {
  (void)user;
  free(memory);
}

static VkResult open_frames(engine *e) {
  const VkCommandPoolCreateInfo pool = {.sType = VK_STRUCTURE_TYPE_COMMAND_POOL_CREATE_INFO,
                                        .flags = VK_COMMAND_POOL_CREATE_RESET_COMMAND_BUFFER_BIT,
                                        .queueFamilyIndex = e->vulkan.family};
  VkResult result = vkCreateCommandPool(e->vulkan.device, &pool, NULL, &e->pool);
  const VkCommandBufferAllocateInfo commands = {.sType = VK_STRUCTURE_TYPE_COMMAND_BUFFER_ALLOCATE_INFO,
                                                .commandPool = e->pool,
                                                .level = VK_COMMAND_BUFFER_LEVEL_PRIMARY,
                                                .commandBufferCount = frame_slots};
  if (!result)
    result = vkAllocateCommandBuffers(e->vulkan.device, &commands, e->commands);
  const VkFenceCreateInfo fence = {.sType = VK_STRUCTURE_TYPE_FENCE_CREATE_INFO, .flags = VK_FENCE_CREATE_SIGNALED_BIT};
  for (int i = 0; i < frame_slots && !result; ++i)
    result = vkCreateFence(e->vulkan.device, &fence, NULL, &e->fences[i]);
  return result;
}

static csm_result open_context(engine *e, char *error, size_t error_size) {
  const csm_vulkan_device lent = {.struct_size = sizeof lent,
                                  .api_version = VK_API_VERSION_1_1,
                                  .instance = e->vulkan.instance,
                                  .physical_device = e->vulkan.physical,
                                  .device = e->vulkan.device,
                                  .queue_family = e->vulkan.family,
                                  .get_instance_proc_addr = vkGetInstanceProcAddr,
                                  .features = &e->vulkan.features};
  const csm_create_info info = {.struct_size = sizeof info,
                                .version = CSM_VERSION,
                                .frame_slots = frame_slots,
                                .backend = "vulkan",
                                .vulkan = &lent,
                                .allocate = count_allocate,
                                .release = count_release,
                                .user = e,
                                .error = error,
                                .error_size = error_size};
  return csm_create(&info, &e->context);
}

static csm_result load_scene(engine *e, const host_setup *setup, const bench_plan *many) {
  const scene *s = &setup->scene;
  csm_result result = csm_cascades_create(e->context, &setup->config, &e->cascades);
  for (size_t i = 0; i < s->mesh_count && !result; ++i) {
    const scene_mesh *mesh = &s->meshes[i];
    const csm_mesh_info info = {.struct_size = sizeof info,
                                .positions = mesh->positions,
                                .vertex_count = mesh->vertex_count,
                                .indices = mesh->indices,
                                .index_count = mesh->index_count,
                                .index_size = mesh->index_size};
    result = csm_mesh_create(e->context, &info, &e->meshes[i]);
  }
  for (uint32_t i = 0; i < many->scene.instance_count && !result; ++i) {
    const plan_instance *from = &many->instances[i];
    csm_instance *to = &e->instances[i];
    *to = (csm_instance){.struct_size = sizeof *to, .mesh = e->meshes[from->mesh], .transform = {[15] = 1}};
    for (int row = 0; row < 3; ++row)
      for (int column = 0; column < 4; ++column)
        to->transform[column * 4 + row] = from->transform[row * 4 + column];
  }
  return result;
}

/* One frame as an engine makes it; *call_ms gets csm's share of the CPU's time. */
static int draw_frame(engine *e, const host_setup *setup, uint32_t instance_count, uint64_t number, double *call_ms) {
  const int slot = (int)(number % frame_slots);
  const VkDevice device = e->vulkan.device;
  vkWaitForFences(device, 1, &e->fences[slot], VK_TRUE, UINT64_MAX);
  vkResetFences(device, 1, &e->fences[slot]);
  if (number > frame_slots && csm_retire(e->context, number - frame_slots))
    return host_fail(HOST_NO_DEVICE, "an engine's frame: %s", csm_last_error(e->context));
  const VkCommandBufferBeginInfo begin = {.sType = VK_STRUCTURE_TYPE_COMMAND_BUFFER_BEGIN_INFO,
                                          .flags = VK_COMMAND_BUFFER_USAGE_ONE_TIME_SUBMIT_BIT};
  vkBeginCommandBuffer(e->commands[slot], &begin);
  csm_frame frame = {.struct_size = sizeof frame,
                     .frame = number,
                     .instances = e->instances,
                     .instance_count = instance_count,
                     .command_buffer = e->commands[slot]};
  memcpy(frame.view, setup->camera.view, sizeof frame.view);
  memcpy(frame.projection, setup->camera.projection, sizeof frame.projection);
  memcpy(frame.light_direction, setup->light.direction, sizeof frame.light_direction);
  const double start_ms = host_now_ms();
  const csm_result result = csm_render_cascades(e->cascades, &frame);
  *call_ms = host_now_ms() - start_ms;
  if (result)
    return host_fail(HOST_NO_DEVICE, "an engine's frame: %s", csm_last_error(e->context));
  vkEndCommandBuffer(e->commands[slot]);
  const VkSubmitInfo submit = {
      .sType = VK_STRUCTURE_TYPE_SUBMIT_INFO, .commandBufferCount = 1, .pCommandBuffers = &e->commands[slot]};
  return vkQueueSubmit(e->vulkan.queue, 1, &submit, e->fences[slot])
             ? host_fail(HOST_NO_DEVICE, "an engine's frame could not be submitted")
             : 0;
}

static int draw_frames(engine *e, bench_engine *out, const host_setup *setup, uint32_t instance_count) {
  double *samples = host_allocate(out->frames, sizeof *samples), ms = 0.0;
  int code = 0;
  for (uint32_t i = 0; i < warm_up + out->frames && !code; ++i) {
    if (i == warm_up)
      e->allocations = 0;
    code = draw_frame(e, setup, instance_count, i + 1, &ms);
    if (i >= warm_up)
      samples[i - warm_up] = ms;
  }
  out->allocations = e->allocations;
  if (!code)
    out->call_ms = estimate_median(samples, out->frames);
  free(samples);
  return code;
}

static void close_engine(engine *e) {
  if (e->vulkan.device)
    vkDeviceWaitIdle(e->vulkan.device);
  csm_destroy(e->context);
  for (int i = 0; i < frame_slots && e->vulkan.device; ++i)
    vkDestroyFence(e->vulkan.device, e->fences[i], NULL);
  if (e->vulkan.device)
    vkDestroyCommandPool(e->vulkan.device, e->pool, NULL);
  vulkan_device_close(&e->vulkan);
  free(e->meshes);
  free(e->instances);
}

int bench_engine_run(bench_engine *out, const host_setup *setup, const bench_plan *many, const char *device,
                     uint32_t frames) {
  const uint32_t instance_count = many->scene.instance_count;
  engine e = {.meshes = host_allocate(setup->scene.mesh_count, sizeof *e.meshes),
              .instances = host_allocate(instance_count, sizeof *e.instances)};
  char error[512] = "";
  *out = (bench_engine){.frames = frames};
  int code = 0;
  if (vulkan_device_open(&e.vulkan, device) || open_frames(&e))
    code = host_fail(HOST_NO_DEVICE, "an engine's Vulkan device could not be opened");
  if (!code && open_context(&e, error, sizeof error))
    code = host_fail(HOST_NO_DEVICE, "csm on an engine's device: %s", error);
  if (!code && load_scene(&e, setup, many))
    code = host_fail(HOST_NO_DEVICE, "csm on an engine's device: %s", csm_last_error(e.context));
  if (!code)
    code = draw_frames(&e, out, setup, instance_count);
  close_engine(&e);
  return code;
}
