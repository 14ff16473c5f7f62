#define INITGUID /* the identifiers of D3D12 interfaces live here */
#include "d3d12_base.h"
#include "app.h"
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

void d3d12_check(HRESULT result, const char *what) {
  if (FAILED(result))
    app_fail(APP_FAILED, "%s: HRESULT 0x%08x", what, (unsigned)result);
}

/* ---- device ---- */

static VKAPI_ATTR VkBool32 VKAPI_CALL count_message(VkDebugUtilsMessageSeverityFlagBitsEXT severity,
                                                    VkDebugUtilsMessageTypeFlagsEXT types,
                                                    const VkDebugUtilsMessengerCallbackDataEXT *data, void *user) {
  (void)severity;
  (void)types;
  d3d12_base *base = user;
  base->messages++;
  fprintf(stderr, "validation: %s\n", data->pMessage);
  return VK_FALSE;
}

/* vkd3d turns no layer on itself, but the Vulkan loader takes them from the environment. */
static void request_validation(void) {
  setenv("VK_INSTANCE_LAYERS", "VK_LAYER_KHRONOS_validation", 1);
  setenv("VK_LAYER_ENABLES", "VK_VALIDATION_FEATURE_ENABLE_SYNCHRONIZATION_VALIDATION_EXT", 1);
}

static void listen(d3d12_base *base) {
  const VkInstance instance = vkd3d_instance_get_vk_instance(base->instance);
  const PFN_vkCreateDebugUtilsMessengerEXT create =
      (PFN_vkCreateDebugUtilsMessengerEXT)vkGetInstanceProcAddr(instance, "vkCreateDebugUtilsMessengerEXT");
  const VkDebugUtilsMessengerCreateInfoEXT info = {.sType = VK_STRUCTURE_TYPE_DEBUG_UTILS_MESSENGER_CREATE_INFO_EXT,
                                                   .messageSeverity = VK_DEBUG_UTILS_MESSAGE_SEVERITY_WARNING_BIT_EXT |
                                                                      VK_DEBUG_UTILS_MESSAGE_SEVERITY_ERROR_BIT_EXT,
                                                   .messageType = VK_DEBUG_UTILS_MESSAGE_TYPE_VALIDATION_BIT_EXT,
                                                   .pfnUserCallback = count_message,
                                                   .pUserData = base};
  if (!create || create(instance, &info, NULL, &base->messenger) != VK_SUCCESS)
    app_fail(APP_FAILED, "the validation layer's messages cannot be received");
}

static void create_instance(d3d12_base *base, bool validate) {
  static const char *const extensions[] = {VK_EXT_DEBUG_UTILS_EXTENSION_NAME};
  const struct vkd3d_application_info application = {.type = VKD3D_STRUCTURE_TYPE_APPLICATION_INFO,
                                                     .application_name = "mini_d3d12",
                                                     .api_version = VKD3D_API_VERSION_1_2};
  const struct vkd3d_instance_create_info info = {.type = VKD3D_STRUCTURE_TYPE_INSTANCE_CREATE_INFO,
                                                  .next = &application,
                                                  .pfn_signal_event = vkd3d_signal_event,
                                                  .wchar_size = sizeof(WCHAR),
                                                  .instance_extensions = extensions,
                                                  .instance_extension_count = validate};
  if (validate)
    request_validation();
  if (FAILED(vkd3d_create_instance(&info, &base->instance)))
    app_fail(APP_NO_DEVICE, "vkd3d found no Vulkan driver");
  if (validate)
    listen(base);
}

void d3d12_open(d3d12_base *out, bool validate) {
  memset(out, 0, sizeof *out);
  create_instance(out, validate);
  const struct vkd3d_device_create_info device = {.type = VKD3D_STRUCTURE_TYPE_DEVICE_CREATE_INFO,
                                                  .minimum_feature_level = D3D_FEATURE_LEVEL_11_0,
                                                  .instance = out->instance};
  if (FAILED(vkd3d_create_device(&device, &IID_ID3D12Device, (void **)&out->device)))
    app_fail(APP_NO_DEVICE, "vkd3d found no device of feature level 11_0");
  VkPhysicalDeviceProperties properties;
  vkGetPhysicalDeviceProperties(vkd3d_get_vk_physical_device(out->device), &properties);
  snprintf(out->name, sizeof out->name, "%s", properties.deviceName);

  const D3D12_COMMAND_QUEUE_DESC queue = {.Type = D3D12_COMMAND_LIST_TYPE_DIRECT};
  d3d12_check(ID3D12Device_CreateCommandQueue(out->device, &queue, &IID_ID3D12CommandQueue, (void **)&out->queue),
              "CreateCommandQueue");
  d3d12_check(ID3D12Device_CreateFence(out->device, 0, D3D12_FENCE_FLAG_NONE, &IID_ID3D12Fence, (void **)&out->fence),
              "CreateFence");
  out->event = vkd3d_create_event();
}

void d3d12_close(d3d12_base *base) {
  vkd3d_destroy_event(base->event);
  ID3D12Fence_Release(base->fence);
  ID3D12CommandQueue_Release(base->queue);
  ID3D12Device_Release(base->device);
  if (base->messenger) {
    const VkInstance instance = vkd3d_instance_get_vk_instance(base->instance);
    const PFN_vkDestroyDebugUtilsMessengerEXT destroy =
        (PFN_vkDestroyDebugUtilsMessengerEXT)vkGetInstanceProcAddr(instance, "vkDestroyDebugUtilsMessengerEXT");
    destroy(instance, base->messenger, NULL);
  }
  vkd3d_instance_decref(base->instance);
}

void d3d12_wait(const d3d12_base *base, uint64_t frame) {
  if (ID3D12Fence_GetCompletedValue(base->fence) >= frame)
    return;
  d3d12_check(ID3D12Fence_SetEventOnCompletion(base->fence, frame, base->event), "SetEventOnCompletion");
  vkd3d_wait_event(base->event, VKD3D_INFINITE);
}

/* ---- memory ---- */

ID3D12Resource *d3d12_buffer_create(const d3d12_base *base, D3D12_HEAP_TYPE heap, uint64_t size) {
  const D3D12_HEAP_PROPERTIES properties = {.Type = heap};
  const D3D12_RESOURCE_DESC buffer = {.Dimension = D3D12_RESOURCE_DIMENSION_BUFFER,
                                      .Width = size,
                                      .Height = 1,
                                      .DepthOrArraySize = 1,
                                      .MipLevels = 1,
                                      .SampleDesc = {.Count = 1},
                                      .Layout = D3D12_TEXTURE_LAYOUT_ROW_MAJOR};
  const D3D12_RESOURCE_STATES state =
      heap == D3D12_HEAP_TYPE_READBACK ? D3D12_RESOURCE_STATE_COPY_DEST : D3D12_RESOURCE_STATE_GENERIC_READ;
  ID3D12Resource *out;
  d3d12_check(ID3D12Device_CreateCommittedResource(base->device, &properties, D3D12_HEAP_FLAG_NONE, &buffer, state,
                                                   NULL, &IID_ID3D12Resource, (void **)&out),
              "CreateCommittedResource of a buffer");
  return out;
}

void *d3d12_buffer_map(ID3D12Resource *buffer) {
  void *memory;
  d3d12_check(ID3D12Resource_Map(buffer, 0, NULL, &memory), "Map");
  return memory;
}

ID3D12Resource *d3d12_image_create(const d3d12_base *base, DXGI_FORMAT format, uint32_t width, uint32_t height,
                                   D3D12_RESOURCE_FLAGS flags, D3D12_RESOURCE_STATES state,
                                   const D3D12_CLEAR_VALUE *clear) {
  const D3D12_HEAP_PROPERTIES properties = {.Type = D3D12_HEAP_TYPE_DEFAULT};
  const D3D12_RESOURCE_DESC image = {.Dimension = D3D12_RESOURCE_DIMENSION_TEXTURE2D,
                                     .Width = width,
                                     .Height = height,
                                     .DepthOrArraySize = 1,
                                     .MipLevels = 1,
                                     .Format = format,
                                     .SampleDesc = {.Count = 1},
                                     .Flags = flags};
  ID3D12Resource *out;
  d3d12_check(ID3D12Device_CreateCommittedResource(base->device, &properties, D3D12_HEAP_FLAG_NONE, &image, state,
                                                   clear, &IID_ID3D12Resource, (void **)&out),
              "CreateCommittedResource of an image");
  return out;
}

ID3D12DescriptorHeap *d3d12_heap_create(const d3d12_base *base, D3D12_DESCRIPTOR_HEAP_TYPE type, uint32_t count,
                                        bool shader_visible) {
  const D3D12_DESCRIPTOR_HEAP_DESC heap = {.Type = type,
                                           .NumDescriptors = count,
                                           .Flags = shader_visible ? D3D12_DESCRIPTOR_HEAP_FLAG_SHADER_VISIBLE
                                                                   : D3D12_DESCRIPTOR_HEAP_FLAG_NONE};
  ID3D12DescriptorHeap *out;
  d3d12_check(ID3D12Device_CreateDescriptorHeap(base->device, &heap, &IID_ID3D12DescriptorHeap, (void **)&out),
              "CreateDescriptorHeap");
  return out;
}

/* ---- pipelines ---- */

ID3D12PipelineState *d3d12_pipeline_create(const d3d12_base *base, const d3d12_pipeline_info *info) {
  const D3D12_DEPTH_STENCILOP_DESC keep = {.StencilFailOp = D3D12_STENCIL_OP_KEEP,
                                           .StencilDepthFailOp = D3D12_STENCIL_OP_KEEP,
                                           .StencilPassOp = D3D12_STENCIL_OP_KEEP,
                                           .StencilFunc = D3D12_COMPARISON_FUNC_ALWAYS};
  const D3D12_RENDER_TARGET_BLEND_DESC opaque = {.SrcBlend = D3D12_BLEND_ONE,
                                                 .DestBlend = D3D12_BLEND_ZERO,
                                                 .BlendOp = D3D12_BLEND_OP_ADD,
                                                 .SrcBlendAlpha = D3D12_BLEND_ONE,
                                                 .DestBlendAlpha = D3D12_BLEND_ZERO,
                                                 .BlendOpAlpha = D3D12_BLEND_OP_ADD,
                                                 .LogicOp = D3D12_LOGIC_OP_NOOP,
                                                 .RenderTargetWriteMask = D3D12_COLOR_WRITE_ENABLE_ALL};
  const D3D12_GRAPHICS_PIPELINE_STATE_DESC pipeline = {
      .pRootSignature = info->signature,
      .VS = {info->vertex_code, info->vertex_size},
      .PS = {info->pixel_code, info->pixel_size},
      .BlendState = {.RenderTarget = {opaque}},
      .SampleMask = ~0u,
      .RasterizerState = {.FillMode = D3D12_FILL_MODE_SOLID,
                          .CullMode = info->cull,
                          .FrontCounterClockwise = TRUE,
                          .DepthClipEnable = info->depth_clip},
      .DepthStencilState = {.DepthEnable = TRUE,
                            .DepthWriteMask = D3D12_DEPTH_WRITE_MASK_ALL,
                            .DepthFunc = info->depth_compare,
                            .FrontFace = keep,
                            .BackFace = keep},
      .InputLayout = {info->elements, info->element_count},
      .PrimitiveTopologyType = D3D12_PRIMITIVE_TOPOLOGY_TYPE_TRIANGLE,
      .NumRenderTargets = info->color_format != DXGI_FORMAT_UNKNOWN,
      .RTVFormats = {info->color_format},
      .DSVFormat = info->depth_format,
      .SampleDesc = {.Count = 1}};
  ID3D12PipelineState *out;
  d3d12_check(
      ID3D12Device_CreateGraphicsPipelineState(base->device, &pipeline, &IID_ID3D12PipelineState, (void **)&out),
      "CreateGraphicsPipelineState");
  return out;
}

void d3d12_transition(ID3D12GraphicsCommandList *list, ID3D12Resource *resource, D3D12_RESOURCE_STATES before,
                      D3D12_RESOURCE_STATES after) {
  const D3D12_RESOURCE_BARRIER barrier = {.Type = D3D12_RESOURCE_BARRIER_TYPE_TRANSITION,
                                          .Transition = {.pResource = resource,
                                                         .Subresource = D3D12_RESOURCE_BARRIER_ALL_SUBRESOURCES,
                                                         .StateBefore = before,
                                                         .StateAfter = after}};
  ID3D12GraphicsCommandList_ResourceBarrier(list, 1, &barrier);
}
