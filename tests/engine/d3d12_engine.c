#define INITGUID
#include "d3d12_engine.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

void d3d12_engine_must(HRESULT hr, const char *what) {
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

uint32_t d3d12_engine_references(void *object) {
  IUnknown *unknown = object;
  IUnknown_AddRef(unknown);
  return IUnknown_Release(unknown);
}

/* ---- the device ---- */

static PFN_vkVoidFunction instance_function(const d3d12_engine *engine, const char *name) {
  return vkGetInstanceProcAddr(vkd3d_instance_get_vk_instance(engine->instance), name);
}

/* May come from vkd3d's own threads. */
static VKAPI_ATTR VkBool32 VKAPI_CALL count_message(VkDebugUtilsMessageSeverityFlagBitsEXT severity,
                                                    VkDebugUtilsMessageTypeFlagsEXT types,
                                                    const VkDebugUtilsMessengerCallbackDataEXT *data, void *user) {
  d3d12_engine *engine = user;
  (void)severity, (void)types;
  __atomic_fetch_add(&engine->messages, 1, __ATOMIC_RELAXED);
  fprintf(stderr, "engine: %s\n", data->pMessage);
  return VK_FALSE;
}

/* vkd3d turns no layers on; the environment that tests run in does. */
static void open_instance(d3d12_engine *engine) {
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
      .pUserData = engine,
  };
  d3d12_engine_must(vkd3d_create_instance(&create, &engine->instance), "vkd3d_create_instance");
  const PFN_vkCreateDebugUtilsMessengerEXT create_messenger =
      (PFN_vkCreateDebugUtilsMessengerEXT)instance_function(engine, "vkCreateDebugUtilsMessengerEXT");
  expect(create_messenger(vkd3d_instance_get_vk_instance(engine->instance), &listen, NULL, &engine->messenger) ==
             VK_SUCCESS,
         "vkCreateDebugUtilsMessengerEXT");
}

static void open_device(d3d12_engine *engine) {
  VkPhysicalDevice physical;
  uint32_t count = 1;
  vkEnumeratePhysicalDevices(vkd3d_instance_get_vk_instance(engine->instance), &count, &physical);
  expect(count == 1, "no Vulkan device");
  const struct vkd3d_device_create_info create = {
      .type = VKD3D_STRUCTURE_TYPE_DEVICE_CREATE_INFO,
      .minimum_feature_level = D3D_FEATURE_LEVEL_11_0,
      .instance = engine->instance,
      .vk_physical_device = physical,
  };
  const D3D12_COMMAND_QUEUE_DESC queue = {.Type = D3D12_COMMAND_LIST_TYPE_DIRECT};
  d3d12_engine_must(vkd3d_create_device(&create, &IID_ID3D12Device, (void **)&engine->device), "vkd3d_create_device");
  d3d12_engine_must(
      ID3D12Device_CreateCommandQueue(engine->device, &queue, &IID_ID3D12CommandQueue, (void **)&engine->queue),
      "a queue");
  d3d12_engine_must(
      ID3D12Device_CreateFence(engine->device, 0, D3D12_FENCE_FLAG_NONE, &IID_ID3D12Fence, (void **)&engine->fence),
      "a fence");
  engine->event = vkd3d_create_event();
  engine->native = (csm_d3d12_device){
      .struct_size = sizeof engine->native,
      .device = engine->device,
      .serialize_root_signature = (void *)D3D12SerializeRootSignature,
  };
}

static void make_list(d3d12_engine *engine, ID3D12CommandAllocator **allocator, ID3D12GraphicsCommandList **list) {
  d3d12_engine_must(ID3D12Device_CreateCommandAllocator(engine->device, D3D12_COMMAND_LIST_TYPE_DIRECT,
                                                        &IID_ID3D12CommandAllocator, (void **)allocator),
                    "an allocator");
  d3d12_engine_must(ID3D12Device_CreateCommandList(engine->device, 0, D3D12_COMMAND_LIST_TYPE_DIRECT, *allocator, NULL,
                                                   &IID_ID3D12GraphicsCommandList, (void **)list),
                    "a list");
  d3d12_engine_must(ID3D12GraphicsCommandList_Close(*list), "closing a list");
}

void d3d12_engine_open(d3d12_engine *engine) {
  *engine = (d3d12_engine){0};
  open_instance(engine);
  open_device(engine);
  for (uint32_t f = 0; f < D3D12_ENGINE_FRAMES; ++f)
    for (uint32_t i = 0; i < D3D12_ENGINE_LISTS; ++i)
      make_list(engine, &engine->frames[f].allocators[i], &engine->frames[f].lists[i]);
}

void d3d12_engine_close(d3d12_engine *engine) {
  d3d12_engine_run(engine, engine->frame);
  for (uint32_t f = 0; f < D3D12_ENGINE_FRAMES; ++f)
    for (uint32_t i = 0; i < D3D12_ENGINE_LISTS; ++i) {
      ID3D12GraphicsCommandList_Release(engine->frames[f].lists[i]);
      ID3D12CommandAllocator_Release(engine->frames[f].allocators[i]);
    }
  ID3D12Fence_Release(engine->fence);
  ID3D12CommandQueue_Release(engine->queue);
  vkd3d_destroy_event(engine->event);
  expect(ID3D12Device_Release(engine->device) == 0, "the device is still held when the engine closes it");
  const PFN_vkDestroyDebugUtilsMessengerEXT destroy =
      (PFN_vkDestroyDebugUtilsMessengerEXT)instance_function(engine, "vkDestroyDebugUtilsMessengerEXT");
  destroy(vkd3d_instance_get_vk_instance(engine->instance), engine->messenger, NULL);
  vkd3d_instance_decref(engine->instance);
}

/* ---- frames ---- */

static ID3D12GraphicsCommandList *next_list(d3d12_engine *engine) {
  const uint32_t slot = engine->frame % D3D12_ENGINE_FRAMES, i = engine->frames[slot].list_count++;
  expect(i < D3D12_ENGINE_LISTS, "a frame has too many lists");
  d3d12_engine_must(ID3D12CommandAllocator_Reset(engine->frames[slot].allocators[i]), "resetting an allocator");
  d3d12_engine_must(
      ID3D12GraphicsCommandList_Reset(engine->frames[slot].lists[i], engine->frames[slot].allocators[i], NULL),
      "resetting a list");
  return engine->frames[slot].lists[i];
}

ID3D12GraphicsCommandList *d3d12_engine_begin(d3d12_engine *engine) {
  ++engine->frame;
  expect(engine->done + D3D12_ENGINE_FRAMES >= engine->frame, "too many frames in flight");
  engine->frames[engine->frame % D3D12_ENGINE_FRAMES].list_count = 0;
  return next_list(engine);
}

void d3d12_engine_end(d3d12_engine *engine) {
  const uint32_t slot = engine->frame % D3D12_ENGINE_FRAMES;
  d3d12_engine_must(ID3D12GraphicsCommandList_Close(engine->frames[slot].lists[engine->frames[slot].list_count - 1]),
                    "closing a list");
}

ID3D12GraphicsCommandList *d3d12_engine_split(d3d12_engine *engine) {
  d3d12_engine_end(engine);
  return next_list(engine);
}

void d3d12_engine_run(d3d12_engine *engine, uint64_t frame) {
  if (frame <= engine->done)
    return;
  for (uint64_t f = engine->done + 1; f <= frame; ++f) {
    const uint32_t slot = f % D3D12_ENGINE_FRAMES;
    for (uint32_t i = 0; i < engine->frames[slot].list_count; ++i)
      ID3D12CommandQueue_ExecuteCommandLists(engine->queue, 1, (ID3D12CommandList **)&engine->frames[slot].lists[i]);
  }
  d3d12_engine_must(ID3D12CommandQueue_Signal(engine->queue, engine->fence, frame), "signalling");
  d3d12_engine_must(ID3D12Fence_SetEventOnCompletion(engine->fence, frame, engine->event), "waiting");
  expect(vkd3d_wait_event(engine->event, VKD3D_INFINITE) == VKD3D_WAIT_OBJECT_0, "vkd3d_wait_event");
  engine->done = frame;
}

/* ---- buffers and images ---- */

ID3D12Resource *d3d12_engine_buffer(d3d12_engine *engine, D3D12_HEAP_TYPE heap, uint64_t size, const void *data) {
  const D3D12_HEAP_PROPERTIES properties = {.Type = heap};
  const D3D12_RESOURCE_DESC description = {
      .Dimension = D3D12_RESOURCE_DIMENSION_BUFFER,
      .Width = size,
      .Height = 1,
      .DepthOrArraySize = 1,
      .MipLevels = 1,
      .SampleDesc = {.Count = 1},
      .Layout = D3D12_TEXTURE_LAYOUT_ROW_MAJOR,
  };
  const D3D12_RESOURCE_STATES state =
      heap == D3D12_HEAP_TYPE_READBACK ? D3D12_RESOURCE_STATE_COPY_DEST : D3D12_RESOURCE_STATE_GENERIC_READ;
  ID3D12Resource *buffer;
  d3d12_engine_must(ID3D12Device_CreateCommittedResource(engine->device, &properties, D3D12_HEAP_FLAG_NONE,
                                                         &description, state, NULL, &IID_ID3D12Resource,
                                                         (void **)&buffer),
                    "a buffer");
  if (data)
    memcpy(d3d12_engine_map(buffer), data, size);
  return buffer;
}

void *d3d12_engine_map(ID3D12Resource *buffer) {
  void *memory;
  d3d12_engine_must(ID3D12Resource_Map(buffer, 0, NULL, &memory), "mapping a buffer");
  return memory;
}

void d3d12_engine_barrier(ID3D12GraphicsCommandList *list, ID3D12Resource *resource, D3D12_RESOURCE_STATES before,
                          D3D12_RESOURCE_STATES after) {
  const D3D12_RESOURCE_BARRIER barrier = {
      .Type = D3D12_RESOURCE_BARRIER_TYPE_TRANSITION,
      .Transition = {.pResource = resource,
                     .Subresource = D3D12_RESOURCE_BARRIER_ALL_SUBRESOURCES,
                     .StateBefore = before,
                     .StateAfter = after},
  };
  ID3D12GraphicsCommandList_ResourceBarrier(list, 1, &barrier);
}

uint32_t d3d12_engine_pitch(uint32_t width, uint32_t texel_bytes) {
  return (width * texel_bytes + D3D12_ENGINE_ROW - 1) / D3D12_ENGINE_ROW * D3D12_ENGINE_ROW;
}

/* How an image's texels lie in a buffer. */
static D3D12_TEXTURE_COPY_LOCATION in_buffer(ID3D12Resource *buffer, uint64_t offset, ID3D12Resource *image,
                                             uint32_t texel_bytes) {
  const D3D12_RESOURCE_DESC description = ID3D12Resource_GetDesc(image);
  return (D3D12_TEXTURE_COPY_LOCATION){
      .pResource = buffer,
      .Type = D3D12_TEXTURE_COPY_TYPE_PLACED_FOOTPRINT,
      .PlacedFootprint = {.Offset = offset,
                          .Footprint = {.Format = description.Format,
                                        .Width = (UINT)description.Width,
                                        .Height = description.Height,
                                        .Depth = 1,
                                        .RowPitch = d3d12_engine_pitch((uint32_t)description.Width, texel_bytes)}},
  };
}

static void upload(d3d12_engine *engine, ID3D12Resource *image, uint32_t width, uint32_t height, uint32_t texel_bytes,
                   const void *texels) {
  const uint32_t pitch = d3d12_engine_pitch(width, texel_bytes);
  ID3D12Resource *buffer = d3d12_engine_buffer(engine, D3D12_HEAP_TYPE_UPLOAD, (uint64_t)pitch * height, NULL);
  char *memory = d3d12_engine_map(buffer);
  for (uint32_t y = 0; y < height; ++y)
    memcpy(memory + (size_t)y * pitch, (const char *)texels + (size_t)y * width * texel_bytes, width * texel_bytes);
  d3d12_engine_run(engine, engine->frame);
  ID3D12GraphicsCommandList *list = d3d12_engine_begin(engine);
  const D3D12_TEXTURE_COPY_LOCATION to = {.pResource = image, .Type = D3D12_TEXTURE_COPY_TYPE_SUBRESOURCE_INDEX};
  const D3D12_TEXTURE_COPY_LOCATION from = in_buffer(buffer, 0, image, texel_bytes);
  ID3D12GraphicsCommandList_CopyTextureRegion(list, &to, 0, 0, 0, &from, NULL);
  d3d12_engine_barrier(list, image, D3D12_RESOURCE_STATE_COPY_DEST, D3D12_RESOURCE_STATE_PIXEL_SHADER_RESOURCE);
  d3d12_engine_end(engine);
  d3d12_engine_run(engine, engine->frame);
  ID3D12Resource_Release(buffer);
}

ID3D12Resource *d3d12_engine_image(d3d12_engine *engine, DXGI_FORMAT format, D3D12_RESOURCE_FLAGS flags, uint32_t width,
                                   uint32_t height, uint32_t texel_bytes, const void *texels) {
  const D3D12_HEAP_PROPERTIES properties = {.Type = D3D12_HEAP_TYPE_DEFAULT};
  const D3D12_RESOURCE_DESC description = {
      .Dimension = D3D12_RESOURCE_DIMENSION_TEXTURE2D,
      .Width = width,
      .Height = height,
      .DepthOrArraySize = 1,
      .MipLevels = 1,
      .Format = format,
      .SampleDesc = {.Count = 1},
      .Flags = flags,
  };
  ID3D12Resource *image;
  d3d12_engine_must(ID3D12Device_CreateCommittedResource(engine->device, &properties, D3D12_HEAP_FLAG_NONE,
                                                         &description, D3D12_RESOURCE_STATE_COPY_DEST, NULL,
                                                         &IID_ID3D12Resource, (void **)&image),
                    "an image");
  upload(engine, image, width, height, texel_bytes, texels);
  return image;
}

void d3d12_engine_copy(ID3D12GraphicsCommandList *list, ID3D12Resource *from, uint32_t layer, uint32_t texel_bytes,
                       ID3D12Resource *to, uint64_t offset) {
  const D3D12_TEXTURE_COPY_LOCATION source = {
      .pResource = from, .Type = D3D12_TEXTURE_COPY_TYPE_SUBRESOURCE_INDEX, .SubresourceIndex = layer};
  const D3D12_TEXTURE_COPY_LOCATION destination = in_buffer(to, offset, from, texel_bytes);
  const D3D12_RESOURCE_STATES readable =
      D3D12_RESOURCE_STATE_PIXEL_SHADER_RESOURCE | D3D12_RESOURCE_STATE_NON_PIXEL_SHADER_RESOURCE;
  d3d12_engine_barrier(list, from, readable, D3D12_RESOURCE_STATE_COPY_SOURCE);
  ID3D12GraphicsCommandList_CopyTextureRegion(list, &destination, 0, 0, 0, &source, NULL);
  d3d12_engine_barrier(list, from, D3D12_RESOURCE_STATE_COPY_SOURCE, readable);
}
