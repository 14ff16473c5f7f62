#define INITGUID
#include "rig_d3d12.h"

#include "rig_d3d12_faults.h"

#include <stdio.h>
#include <stdlib.h>

void rig_d3d12_must(HRESULT hr, const char *what) {
  if (SUCCEEDED(hr))
    return;
  fprintf(stderr, "engine: %s: HRESULT 0x%08x\n", what, (unsigned)hr);
  abort();
}

static void expect(bool holds, const char *what) {
  if (holds)
    return;
  fprintf(stderr, "engine: %s\n", what);
  abort();
}

uint32_t rig_d3d12_references(void *object) {
  IUnknown *unknown = object;
  IUnknown_AddRef(unknown);
  return IUnknown_Release(unknown);
}

/* ---- the device ---- */

static PFN_vkVoidFunction instance_function(const rig *rig, const char *name) {
  return vkGetInstanceProcAddr(vkd3d_instance_get_vk_instance(rig->instance), name);
}

/* May come from vkd3d's own threads. */
static VKAPI_ATTR VkBool32 VKAPI_CALL count_message(VkDebugUtilsMessageSeverityFlagBitsEXT severity,
                                                    VkDebugUtilsMessageTypeFlagsEXT types,
                                                    const VkDebugUtilsMessengerCallbackDataEXT *data, void *user) {
  rig *rig = user;
  (void)severity, (void)types;
  __atomic_fetch_add(&rig->messages, 1, __ATOMIC_RELAXED);
  fprintf(stderr, "engine: %s\n", data->pMessage);
  return VK_FALSE;
}

/* vkd3d turns no layers on; the environment that tests run in does. */
static void open_instance(rig *rig) {
  const char *const extensions[] = {VK_EXT_DEBUG_UTILS_EXTENSION_NAME};
  const struct vkd3d_instance_create_info create = {
      .type = VKD3D_STRUCTURE_TYPE_INSTANCE_CREATE_INFO,
      .pfn_signal_event = vkd3d_signal_event,
      .wchar_size = sizeof(WCHAR),
      .instance_extensions = extensions,
      .instance_extension_count = 1,
  };
  const VkDebugUtilsMessengerCreateInfoEXT listen = {
      .sType = VK_STRUCTURE_TYPE_DEBUG_UTILS_MESSENGER_CREATE_INFO_EXT,
      .messageSeverity =
          VK_DEBUG_UTILS_MESSAGE_SEVERITY_WARNING_BIT_EXT | VK_DEBUG_UTILS_MESSAGE_SEVERITY_ERROR_BIT_EXT,
      .messageType = VK_DEBUG_UTILS_MESSAGE_TYPE_VALIDATION_BIT_EXT,
      .pfnUserCallback = count_message,
      .pUserData = rig,
  };
  rig_d3d12_must(vkd3d_create_instance(&create, &rig->instance), "vkd3d_create_instance");
  const PFN_vkCreateDebugUtilsMessengerEXT create_messenger =
      (PFN_vkCreateDebugUtilsMessengerEXT)instance_function(rig, "vkCreateDebugUtilsMessengerEXT");
  expect(create_messenger(vkd3d_instance_get_vk_instance(rig->instance), &listen, NULL, &rig->messenger) == VK_SUCCESS,
         "vkCreateDebugUtilsMessengerEXT");
}

static void open_device(rig *rig) {
  VkPhysicalDevice physical;
  uint32_t count = 1;
  vkEnumeratePhysicalDevices(vkd3d_instance_get_vk_instance(rig->instance), &count, &physical);
  expect(count == 1, "no Vulkan device");
  const struct vkd3d_device_create_info create = {
      .type = VKD3D_STRUCTURE_TYPE_DEVICE_CREATE_INFO,
      .minimum_feature_level = D3D_FEATURE_LEVEL_11_0,
      .instance = rig->instance,
      .vk_physical_device = physical,
  };
  const D3D12_COMMAND_QUEUE_DESC queue = {.Type = D3D12_COMMAND_LIST_TYPE_DIRECT};
  rig_d3d12_must(vkd3d_create_device(&create, &IID_ID3D12Device, (void **)&rig->device), "vkd3d_create_device");
  rig_d3d12_must(ID3D12Device_CreateCommandQueue(rig->device, &queue, &IID_ID3D12CommandQueue, (void **)&rig->queue),
                 "a queue");
  rig_d3d12_must(
      ID3D12Device_CreateFence(rig->device, 0, D3D12_FENCE_FLAG_NONE, &IID_ID3D12Fence, (void **)&rig->fence),
      "a fence");
  rig->event = vkd3d_create_event();
}

static void make_list(rig *rig, ID3D12CommandAllocator **allocator, ID3D12GraphicsCommandList **list) {
  rig_d3d12_must(ID3D12Device_CreateCommandAllocator(rig->device, D3D12_COMMAND_LIST_TYPE_DIRECT,
                                                     &IID_ID3D12CommandAllocator, (void **)allocator),
                 "an allocator");
  rig_d3d12_must(ID3D12Device_CreateCommandList(rig->device, 0, D3D12_COMMAND_LIST_TYPE_DIRECT, *allocator, NULL,
                                                &IID_ID3D12GraphicsCommandList, (void **)list),
                 "a list");
  rig_d3d12_must(ID3D12GraphicsCommandList_Close(*list), "closing a list");
}

rig *rig_open(rig_kind kind) {
  rig *rig = calloc(1, sizeof *rig);
  if (!rig)
    abort();
  open_instance(rig);
  open_device(rig);
  rig->native = (csm_d3d12_device){
      .struct_size = sizeof rig->native,
      .device = kind == RIG_FAILING ? d3d12_faults_open(rig->device) : rig->device,
      .serialize_root_signature = (void *)D3D12SerializeRootSignature,
  };
  if (kind == RIG_MODERN)
    rig_d3d12_lend(rig);
  for (uint32_t f = 0; f < RIG_FRAMES; ++f)
    for (uint32_t i = 0; i < RIG_LISTS; ++i)
      make_list(rig, &rig->frames[f].allocators[i], &rig->frames[f].lists[i]);
  return rig;
}

void rig_close(rig *rig) {
  rig_run(rig, rig->frame);
  for (uint32_t f = 0; f < RIG_FRAMES; ++f)
    for (uint32_t i = 0; i < RIG_LISTS; ++i) {
      ID3D12GraphicsCommandList_Release(rig->frames[f].lists[i]);
      ID3D12CommandAllocator_Release(rig->frames[f].allocators[i]);
    }
  ID3D12Fence_Release(rig->fence);
  ID3D12CommandQueue_Release(rig->queue);
  vkd3d_destroy_event(rig->event);
  const uint32_t references = ID3D12Device_Release(rig->device);
  const PFN_vkDestroyDebugUtilsMessengerEXT destroy =
      (PFN_vkDestroyDebugUtilsMessengerEXT)instance_function(rig, "vkDestroyDebugUtilsMessengerEXT");
  destroy(vkd3d_instance_get_vk_instance(rig->instance), rig->messenger, NULL);
  vkd3d_instance_decref(rig->instance);
  const uint32_t messages = rig->messages, pieces = rig->lent.pieces;
  free(rig);
  assert_int_equal(messages, 0);
  assert_int_equal(references, 0);
  assert_int_equal(pieces, 0);
}

void rig_give(const rig *rig, csm_create_info *info) {
  info->d3d12 = &rig->native;
  info->flags &= ~(uint32_t)CSM_CREATE_VALIDATE;
}

rig_lent *rig_lent_memory(rig *rig) {
  return &rig->lent;
}

uint32_t rig_messages(const rig *rig) {
  return rig->messages;
}

/* ---- frames ---- */

uint64_t rig_frame(const rig *rig) {
  return rig->frame;
}

uint64_t rig_done(const rig *rig) {
  return rig->done;
}

static ID3D12GraphicsCommandList *next_list(rig *rig) {
  const uint32_t slot = rig->frame % RIG_FRAMES, i = rig->frames[slot].count++;
  expect(i < RIG_LISTS, "a frame has too many lists");
  rig_d3d12_must(ID3D12CommandAllocator_Reset(rig->frames[slot].allocators[i]), "resetting an allocator");
  rig_d3d12_must(ID3D12GraphicsCommandList_Reset(rig->frames[slot].lists[i], rig->frames[slot].allocators[i], NULL),
                 "resetting a list");
  return rig->frames[slot].lists[i];
}

void *rig_begin(rig *rig) {
  ++rig->frame;
  expect(rig->done + RIG_FRAMES >= rig->frame, "too many frames in flight");
  rig->frames[rig->frame % RIG_FRAMES].count = 0;
  return next_list(rig);
}

void *rig_commands(const rig *rig) {
  const uint32_t slot = rig->frame % RIG_FRAMES;
  return rig->frames[slot].count ? rig->frames[slot].lists[rig->frames[slot].count - 1] : NULL;
}

void rig_end(rig *rig) {
  rig_d3d12_must(ID3D12GraphicsCommandList_Close((ID3D12GraphicsCommandList *)rig_commands(rig)), "closing a list");
}

void *rig_split(rig *rig) {
  rig_end(rig);
  return next_list(rig);
}

void rig_run(rig *rig, uint64_t frame) {
  if (frame <= rig->done)
    return;
  for (uint64_t f = rig->done + 1; f <= frame; ++f) {
    const uint32_t slot = f % RIG_FRAMES;
    for (uint32_t i = 0; i < rig->frames[slot].count; ++i)
      ID3D12CommandQueue_ExecuteCommandLists(rig->queue, 1, (ID3D12CommandList **)&rig->frames[slot].lists[i]);
  }
  rig_d3d12_must(ID3D12CommandQueue_Signal(rig->queue, rig->fence, frame), "signalling");
  rig_d3d12_must(ID3D12Fence_SetEventOnCompletion(rig->fence, frame, rig->event), "waiting");
  expect(vkd3d_wait_event(rig->event, VKD3D_INFINITE) == VKD3D_WAIT_OBJECT_0, "vkd3d_wait_event");
  rig->done = frame;
}

void rig_drop(rig *rig) {
  rig->frames[rig->frame % RIG_FRAMES].count = 0;
}
