#include "bench/engine.h"
#include "base/host.h"
#include "bench/moving.h"
#include "native/vulkan_device.h"
#include "csm/csm_vulkan.h"
#include "stage/stage.h"
#include <stdlib.h>

enum { frame_slots = 3, warm_up = 2 * frame_slots };

typedef struct engine {
  vulkan_device vulkan;
  VkCommandPool pool;
  VkCommandBuffer commands[frame_slots];
  csm_context *context;
  assets assets;
  bench_moving moving;
  csm_scene *scenes[ENGINE_WAYS];
  csm_cascades *cascades[ENGINE_WAYS];
  csm_camera camera;
  csm_light light;
  uint64_t frame;
  uint32_t allocations;
} engine;

typedef struct engine_samples {
  double *call_ms[ENGINE_WAYS], *move_ms;
} engine_samples;

static void *CSM_CALL count_allocate(void *user, size_t size, size_t alignment) {
  ++((engine *)user)->allocations;
  return aligned_alloc(alignment, (size + alignment - 1) / alignment * alignment);
}

static void CSM_CALL count_release(void *user, void *memory) {
  (void)user;
  free(memory);
}

/* ---- opening ---- */

static VkResult open_commands(engine *e) {
  const VkCommandPoolCreateInfo pool = {.sType = VK_STRUCTURE_TYPE_COMMAND_POOL_CREATE_INFO,
                                        .flags = VK_COMMAND_POOL_CREATE_RESET_COMMAND_BUFFER_BIT,
                                        .queueFamilyIndex = e->vulkan.family};
  const VkResult result = vkCreateCommandPool(e->vulkan.device, &pool, NULL, &e->pool);
  const VkCommandBufferAllocateInfo commands = {.sType = VK_STRUCTURE_TYPE_COMMAND_BUFFER_ALLOCATE_INFO,
                                                .commandPool = e->pool,
                                                .level = VK_COMMAND_BUFFER_LEVEL_PRIMARY,
                                                .commandBufferCount = frame_slots};
  return result ? result : vkAllocateCommandBuffers(e->vulkan.device, &commands, e->commands);
}

static csm_result open_context(engine *e, char *error, size_t error_size) {
  const csm_vulkan_device lent = vulkan_device_lend(&e->vulkan);
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

/* Each way has cascades of its own, which remember what they drew. */
static csm_result open_way(engine *e, engine_way way, const csm_config *config) {
  const csm_result result = csm_cascades_create(e->context, config, &e->cascades[way]);
  if (way == ENGINE_LIST || result)
    return result;
  return bench_moving_scene(&e->moving, e->context, &e->scenes[way]);
}

static csm_result load_scene(engine *e, const host_setup *setup, const bench_plan *many) {
  e->camera = stage_camera(&setup->camera);
  e->light = stage_light(&setup->light);
  csm_result result = assets_upload(&e->assets, e->context, &setup->scene);
  if (!result)
    bench_moving_make(&e->moving, many, &e->assets);
  for (int way = 0; way < ENGINE_WAYS && !result; ++way)
    result = open_way(e, (engine_way)way, &setup->config);
  return result;
}

static void close_engine(engine *e) {
  csm_destroy(e->context);
  if (e->vulkan.device)
    vkDestroyCommandPool(e->vulkan.device, e->pool, NULL);
  vulkan_device_close(&e->vulkan);
  assets_free(&e->assets);
  bench_moving_free(&e->moving);
}

/* ---- frames ---- */

static csm_result move_some(engine *e, double *ms) {
  const csm_scene_batch batch = bench_moving_next(&e->moving, e->frame);
  const double start_ms = host_cpu_ms();
  const csm_result result = csm_scene_move(e->scenes[ENGINE_MOVED], &batch);
  *ms = host_cpu_ms() - start_ms;
  return result;
}

/* A frame as an engine records it; *call_ms gets csm's share of the CPU's time. */
static csm_result record_frame(engine *e, engine_way way, double *call_ms) {
  const uint64_t number = ++e->frame;
  const VkCommandBuffer commands = e->commands[number % frame_slots];
  const VkCommandBufferBeginInfo begin = {.sType = VK_STRUCTURE_TYPE_COMMAND_BUFFER_BEGIN_INFO,
                                          .flags = VK_COMMAND_BUFFER_USAGE_ONE_TIME_SUBMIT_BIT};
  csm_result result = number > frame_slots ? csm_retire(e->context, number - frame_slots) : CSM_SUCCESS;
  if (result)
    return result;
  vkBeginCommandBuffer(commands, &begin);
  csm_frame frame = {.struct_size = sizeof frame,
                     .frame = number,
                     .command_buffer = commands,
                     .camera = &e->camera,
                     .light = &e->light,
                     .scene = e->scenes[way]};
  if (way == ENGINE_LIST) {
    frame.instances = e->moving.instances;
    frame.instance_count = e->moving.count;
  }
  const double start_ms = host_cpu_ms();
  result = csm_render_cascades(e->cascades[way], &frame);
  *call_ms = host_cpu_ms() - start_ms;
  vkEndCommandBuffer(commands);
  return result;
}

static csm_result record_round(engine *e, double call_ms[ENGINE_WAYS], double *move_ms) {
  csm_result result = move_some(e, move_ms);
  for (int way = 0; way < ENGINE_WAYS && !result; ++way)
    result = record_frame(e, (engine_way)way, &call_ms[way]);
  return result;
}

static csm_result record_rounds(engine *e, const engine_samples *samples, uint32_t rounds) {
  csm_result result = CSM_SUCCESS;
  for (uint32_t i = 0; i < warm_up + rounds && !result; ++i) {
    double call_ms[ENGINE_WAYS], move_ms;
    if (i == warm_up)
      e->allocations = 0;
    result = record_round(e, call_ms, &move_ms);
    if (i < warm_up)
      continue;
    for (int way = 0; way < ENGINE_WAYS; ++way)
      samples->call_ms[way][i - warm_up] = call_ms[way];
    samples->move_ms[i - warm_up] = move_ms;
  }
  return result;
}

static void take_results(bench_engine *out, const engine_samples *samples, uint32_t rounds) {
  out->rounds = rounds;
  for (int way = 0; way < ENGINE_WAYS; ++way)
    out->to_list[way] = estimate_ratio(samples->call_ms[way], samples->call_ms[ENGINE_LIST], rounds);
  for (int way = 0; way < ENGINE_WAYS; ++way)
    out->call_ms[way] = estimate_median(samples->call_ms[way], rounds);
  out->move_ms = estimate_median(samples->move_ms, rounds);
}

static int measure(bench_engine *out, engine *e, uint32_t rounds) {
  engine_samples samples = {.move_ms = host_allocate(rounds, sizeof(double))};
  for (int way = 0; way < ENGINE_WAYS; ++way)
    samples.call_ms[way] = host_allocate(rounds, sizeof(double));
  const csm_result result = record_rounds(e, &samples, rounds);
  *out = (bench_engine){.instances = e->moving.count, .moved = e->moving.moved, .allocations = e->allocations};
  if (!result)
    take_results(out, &samples, rounds);
  for (int way = 0; way < ENGINE_WAYS; ++way)
    free(samples.call_ms[way]);
  free(samples.move_ms);
  return result ? host_fail(HOST_NO_DEVICE, "an engine's frame: %s", csm_last_error(e->context)) : 0;
}

int bench_engine_run(bench_engine *out, const host_setup *setup, const bench_plan *many, const char *device,
                     uint32_t rounds) {
  engine e = {0};
  char error[512] = "";
  int code = 0;
  if (vulkan_device_open(&e.vulkan, device) || open_commands(&e))
    code = host_fail(HOST_NO_DEVICE, "an engine's Vulkan device could not be opened");
  if (!code && open_context(&e, error, sizeof error))
    code = host_fail(HOST_NO_DEVICE, "csm on an engine's device: %s", error);
  if (!code && load_scene(&e, setup, many))
    code = host_fail(HOST_NO_DEVICE, "csm on an engine's device: %s", csm_last_error(e.context));
  if (!code)
    code = measure(out, &e, rounds);
  close_engine(&e);
  return code;
}
