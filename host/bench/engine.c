#include "bench/engine.h"
#include "base/host.h"
#include "native/vulkan_device.h"
#include "csm/csm_vulkan.h"
#include "stage/assets.h"
#include "stage/stage.h"
#include <stdlib.h>
#include <string.h>

enum { frame_slots = 3, warm_up = 2 * frame_slots, moved_instances = 100 };

typedef struct engine {
  vulkan_device vulkan;
  VkCommandPool pool;
  VkCommandBuffer commands[frame_slots];
  csm_context *context;
  assets assets;
  csm_instance *instances;
  uint32_t instance_count;
  csm_instance_id *ids; /* in the scene of those that move */
  double (*places)[16]; /* where they go, moved_instances of them */
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

static void fill_instances(engine *e, const bench_plan *many) {
  for (uint32_t i = 0; i < e->instance_count; ++i) {
    const plan_instance *from = &many->instances[i];
    csm_instance *to = &e->instances[i];
    *to = (csm_instance){.struct_size = sizeof *to, .mesh = e->assets.meshes[from->mesh], .transform = {[15] = 1}};
    for (int row = 0; row < 3; ++row)
      for (int column = 0; column < 4; ++column)
        to->transform[column * 4 + row] = from->transform[row * 4 + column];
  }
}

/* Each way has cascades of its own, which remember what they drew. */
static csm_result open_way(engine *e, engine_way way, const csm_config *config) {
  csm_result result = csm_cascades_create(e->context, config, &e->cascades[way]);
  if (way == ENGINE_LIST || result)
    return result;
  const csm_scene_batch batch = {
      .struct_size = sizeof batch, .count = e->instance_count, .ids = e->ids, .instances = e->instances};
  result = csm_scene_create(e->context, &e->scenes[way]);
  return result ? result : csm_scene_add(e->scenes[way], &batch);
}

static csm_result load_scene(engine *e, const host_setup *setup, const bench_plan *many) {
  e->camera = stage_camera(&setup->camera);
  e->light = stage_light(&setup->light);
  csm_result result = assets_upload(&e->assets, e->context, &setup->scene);
  if (!result)
    fill_instances(e, many);
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
  free(e->instances);
  free(e->ids);
  free(e->places);
}

/* ---- frames ---- */

/* Some of the instances, spread over all, go up and down a metre. */
static csm_result move_some(engine *e, double *ms) {
  const uint32_t count = e->instance_count < moved_instances ? e->instance_count : moved_instances;
  csm_instance_id ids[moved_instances];
  for (uint32_t i = 0; i < count; ++i) {
    const uint32_t from = (uint32_t)((uint64_t)i * e->instance_count / count);
    ids[i] = e->ids[from];
    memcpy(e->places[i], e->instances[from].transform, sizeof e->places[i]);
    e->places[i][13] += (double)(e->frame % 2);
  }
  const csm_scene_batch batch = {.struct_size = sizeof batch, .count = count, .ids = ids, .matrices = e->places[0]};
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
    frame.instances = e->instances;
    frame.instance_count = e->instance_count;
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
  out->allocations = e->allocations;
  if (!result)
    take_results(out, &samples, rounds);
  for (int way = 0; way < ENGINE_WAYS; ++way)
    free(samples.call_ms[way]);
  free(samples.move_ms);
  return result ? host_fail(HOST_NO_DEVICE, "an engine's frame: %s", csm_last_error(e->context)) : 0;
}

int bench_engine_run(bench_engine *out, const host_setup *setup, const bench_plan *many, const char *device,
                     uint32_t rounds) {
  const uint32_t count = many->scene.slot_count;
  engine e = {.instance_count = count,
              .instances = host_allocate(count, sizeof *e.instances),
              .ids = host_allocate(count, sizeof *e.ids),
              .places = host_allocate(moved_instances, sizeof *e.places)};
  char error[512] = "";
  *out = (bench_engine){.instances = count, .moved = count < moved_instances ? count : moved_instances};
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
