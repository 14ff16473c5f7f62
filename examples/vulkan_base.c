#include "vulkan_base.h"
#include "app.h"
#include <stdio.h>
#include <string.h>

static const char layer_name[] = "VK_LAYER_KHRONOS_validation";

void vulkan_check(VkResult result, const char *what) {
  if (result != VK_SUCCESS)
    app_fail(result == VK_ERROR_INCOMPATIBLE_DRIVER ? APP_NO_DEVICE : APP_FAILED, "%s: VkResult %d", what, result);
}

/* ---- device ---- */

static VKAPI_ATTR VkBool32 VKAPI_CALL count_message(VkDebugUtilsMessageSeverityFlagBitsEXT severity,
                                                    VkDebugUtilsMessageTypeFlagsEXT types,
                                                    const VkDebugUtilsMessengerCallbackDataEXT *data, void *user) {
  (void)severity;
  (void)types;
  vulkan_base *base = user;
  base->messages++;
  fprintf(stderr, "validation: %s\n", data->pMessage);
  return VK_FALSE;
}

static void create_instance(vulkan_base *base, bool validate) {
  static const char *const extensions[] = {VK_EXT_DEBUG_UTILS_EXTENSION_NAME};
  static const char *const layers[] = {layer_name};
  static const VkValidationFeatureEnableEXT synchronization =
      VK_VALIDATION_FEATURE_ENABLE_SYNCHRONIZATION_VALIDATION_EXT;
  const VkDebugUtilsMessengerCreateInfoEXT messenger = {
      .sType = VK_STRUCTURE_TYPE_DEBUG_UTILS_MESSENGER_CREATE_INFO_EXT,
      .messageSeverity =
          VK_DEBUG_UTILS_MESSAGE_SEVERITY_WARNING_BIT_EXT | VK_DEBUG_UTILS_MESSAGE_SEVERITY_ERROR_BIT_EXT,
      .messageType = VK_DEBUG_UTILS_MESSAGE_TYPE_VALIDATION_BIT_EXT,
      .pfnUserCallback = count_message,
      .pUserData = base};
  const VkValidationFeaturesEXT features = {.sType = VK_STRUCTURE_TYPE_VALIDATION_FEATURES_EXT,
                                            .pNext = &messenger,
                                            .enabledValidationFeatureCount = 1,
                                            .pEnabledValidationFeatures = &synchronization};
  const VkApplicationInfo application = {
      .sType = VK_STRUCTURE_TYPE_APPLICATION_INFO, .pApplicationName = "mini_vulkan", .apiVersion = VK_API_VERSION_1_1};
  const VkInstanceCreateInfo info = {.sType = VK_STRUCTURE_TYPE_INSTANCE_CREATE_INFO,
                                     .pNext = validate ? &features : NULL,
                                     .pApplicationInfo = &application,
                                     .enabledLayerCount = validate,
                                     .ppEnabledLayerNames = layers,
                                     .enabledExtensionCount = validate,
                                     .ppEnabledExtensionNames = extensions};
  vulkan_check(vkCreateInstance(&info, NULL, &base->instance), "vkCreateInstance");
  if (!validate)
    return;
  const PFN_vkCreateDebugUtilsMessengerEXT create_messenger =
      (PFN_vkCreateDebugUtilsMessengerEXT)vkGetInstanceProcAddr(base->instance, "vkCreateDebugUtilsMessengerEXT");
  vulkan_check(create_messenger(base->instance, &messenger, NULL, &base->messenger), "vkCreateDebugUtilsMessengerEXT");
}

/* The first device that draws; a larger engine would rank them. */
static void choose_device(vulkan_base *base) {
  uint32_t count = 1;
  if (vkEnumeratePhysicalDevices(base->instance, &count, &base->physical_device) < 0 || count == 0)
    app_fail(APP_NO_DEVICE, "there is no Vulkan device");
  vkGetPhysicalDeviceProperties(base->physical_device, &base->properties);
  vkGetPhysicalDeviceMemoryProperties(base->physical_device, &base->memory);

  VkQueueFamilyProperties families[16];
  count = 16;
  vkGetPhysicalDeviceQueueFamilyProperties(base->physical_device, &count, families);
  while (base->queue_family < count && !(families[base->queue_family].queueFlags & VK_QUEUE_GRAPHICS_BIT))
    base->queue_family++;
  if (base->queue_family == count)
    app_fail(APP_NO_DEVICE, "%s has no graphics queue", base->properties.deviceName);
}

static void create_device(vulkan_base *base) {
  /* What csm needs beyond Vulkan 1.1; csm_backend_info.required lists it. csm_create says so where it is not on. */
  VkPhysicalDeviceFeatures available;
  vkGetPhysicalDeviceFeatures(base->physical_device, &available);
  base->features.depthClamp = available.depthClamp;

  const float priority = 1.0f;
  const VkDeviceQueueCreateInfo queue = {.sType = VK_STRUCTURE_TYPE_DEVICE_QUEUE_CREATE_INFO,
                                         .queueFamilyIndex = base->queue_family,
                                         .queueCount = 1,
                                         .pQueuePriorities = &priority};
  const VkDeviceCreateInfo info = {.sType = VK_STRUCTURE_TYPE_DEVICE_CREATE_INFO,
                                   .queueCreateInfoCount = 1,
                                   .pQueueCreateInfos = &queue,
                                   .pEnabledFeatures = &base->features};
  vulkan_check(vkCreateDevice(base->physical_device, &info, NULL, &base->device), "vkCreateDevice");
  vkGetDeviceQueue(base->device, base->queue_family, 0, &base->queue);
}

void vulkan_open(vulkan_base *out, bool validate) {
  memset(out, 0, sizeof *out);
  create_instance(out, validate);
  choose_device(out);
  create_device(out);
}

void vulkan_close(vulkan_base *base) {
  vkDestroyDevice(base->device, NULL);
  if (base->messenger) {
    const PFN_vkDestroyDebugUtilsMessengerEXT destroy_messenger =
        (PFN_vkDestroyDebugUtilsMessengerEXT)vkGetInstanceProcAddr(base->instance, "vkDestroyDebugUtilsMessengerEXT");
    destroy_messenger(base->instance, base->messenger, NULL);
  }
  vkDestroyInstance(base->instance, NULL);
}

/* ---- memory ---- */

static VkDeviceMemory allocate(const vulkan_base *base, const VkMemoryRequirements *needs,
                               VkMemoryPropertyFlags flags) {
  uint32_t type = 0;
  while (type < base->memory.memoryTypeCount &&
         !(needs->memoryTypeBits & (1u << type) && (base->memory.memoryTypes[type].propertyFlags & flags) == flags))
    type++;
  const VkMemoryAllocateInfo info = {
      .sType = VK_STRUCTURE_TYPE_MEMORY_ALLOCATE_INFO, .allocationSize = needs->size, .memoryTypeIndex = type};
  VkDeviceMemory memory;
  if (type == base->memory.memoryTypeCount)
    app_fail(APP_FAILED, "%s has no memory of a kind that is needed", base->properties.deviceName);
  vulkan_check(vkAllocateMemory(base->device, &info, NULL, &memory), "vkAllocateMemory");
  return memory;
}

vulkan_buffer vulkan_buffer_create(const vulkan_base *base, VkDeviceSize size, VkBufferUsageFlags usage) {
  const VkBufferCreateInfo info = {.sType = VK_STRUCTURE_TYPE_BUFFER_CREATE_INFO, .size = size, .usage = usage};
  vulkan_buffer out;
  VkMemoryRequirements needs;
  vulkan_check(vkCreateBuffer(base->device, &info, NULL, &out.buffer), "vkCreateBuffer");
  vkGetBufferMemoryRequirements(base->device, out.buffer, &needs);
  out.memory = allocate(base, &needs, VK_MEMORY_PROPERTY_HOST_VISIBLE_BIT | VK_MEMORY_PROPERTY_HOST_COHERENT_BIT);
  vulkan_check(vkBindBufferMemory(base->device, out.buffer, out.memory, 0), "vkBindBufferMemory");
  vulkan_check(vkMapMemory(base->device, out.memory, 0, VK_WHOLE_SIZE, 0, &out.mapped), "vkMapMemory");
  return out;
}

void vulkan_buffer_destroy(const vulkan_base *base, vulkan_buffer *buffer) {
  vkDestroyBuffer(base->device, buffer->buffer, NULL);
  vkFreeMemory(base->device, buffer->memory, NULL);
}

vulkan_image vulkan_image_create(const vulkan_base *base, VkFormat format, uint32_t width, uint32_t height,
                                 VkImageUsageFlags usage, VkImageAspectFlags aspect) {
  const VkImageCreateInfo info = {.sType = VK_STRUCTURE_TYPE_IMAGE_CREATE_INFO,
                                  .imageType = VK_IMAGE_TYPE_2D,
                                  .format = format,
                                  .extent = {width, height, 1},
                                  .mipLevels = 1,
                                  .arrayLayers = 1,
                                  .samples = VK_SAMPLE_COUNT_1_BIT,
                                  .usage = usage};
  vulkan_image out;
  VkMemoryRequirements needs;
  vulkan_check(vkCreateImage(base->device, &info, NULL, &out.image), "vkCreateImage");
  vkGetImageMemoryRequirements(base->device, out.image, &needs);
  out.memory = allocate(base, &needs, VK_MEMORY_PROPERTY_DEVICE_LOCAL_BIT);
  vulkan_check(vkBindImageMemory(base->device, out.image, out.memory, 0), "vkBindImageMemory");
  const VkImageViewCreateInfo view = {.sType = VK_STRUCTURE_TYPE_IMAGE_VIEW_CREATE_INFO,
                                      .image = out.image,
                                      .viewType = VK_IMAGE_VIEW_TYPE_2D,
                                      .format = format,
                                      .subresourceRange = {aspect, 0, 1, 0, 1}};
  vulkan_check(vkCreateImageView(base->device, &view, NULL, &out.view), "vkCreateImageView");
  return out;
}

void vulkan_image_destroy(const vulkan_base *base, vulkan_image *image) {
  vkDestroyImageView(base->device, image->view, NULL);
  vkDestroyImage(base->device, image->image, NULL);
  vkFreeMemory(base->device, image->memory, NULL);
}

/* ---- pipelines ---- */

static VkShaderModule create_module(const vulkan_base *base, const uint32_t *code, size_t size) {
  const VkShaderModuleCreateInfo info = {
      .sType = VK_STRUCTURE_TYPE_SHADER_MODULE_CREATE_INFO, .codeSize = size, .pCode = code};
  VkShaderModule module = VK_NULL_HANDLE;
  if (code)
    vulkan_check(vkCreateShaderModule(base->device, &info, NULL, &module), "vkCreateShaderModule");
  return module;
}

VkPipeline vulkan_pipeline_create(const vulkan_base *base, const vulkan_pipeline_info *info) {
  const VkPipelineShaderStageCreateInfo stages[2] = {
      {.sType = VK_STRUCTURE_TYPE_PIPELINE_SHADER_STAGE_CREATE_INFO,
       .stage = VK_SHADER_STAGE_VERTEX_BIT,
       .module = create_module(base, info->vertex_code, info->vertex_size),
       .pName = "main"},
      {.sType = VK_STRUCTURE_TYPE_PIPELINE_SHADER_STAGE_CREATE_INFO,
       .stage = VK_SHADER_STAGE_FRAGMENT_BIT,
       .module = create_module(base, info->fragment_code, info->fragment_size),
       .pName = "main"}};
  const VkPipelineInputAssemblyStateCreateInfo assembly = {
      .sType = VK_STRUCTURE_TYPE_PIPELINE_INPUT_ASSEMBLY_STATE_CREATE_INFO,
      .topology = VK_PRIMITIVE_TOPOLOGY_TRIANGLE_LIST};
  const VkPipelineViewportStateCreateInfo viewport = {
      .sType = VK_STRUCTURE_TYPE_PIPELINE_VIEWPORT_STATE_CREATE_INFO, .viewportCount = 1, .scissorCount = 1};
  const VkPipelineRasterizationStateCreateInfo rasterization = {
      .sType = VK_STRUCTURE_TYPE_PIPELINE_RASTERIZATION_STATE_CREATE_INFO,
      .depthClampEnable = info->depth_clamp,
      .cullMode = info->cull,
      .frontFace = VK_FRONT_FACE_COUNTER_CLOCKWISE,
      .lineWidth = 1.0f};
  const VkPipelineMultisampleStateCreateInfo samples = {
      .sType = VK_STRUCTURE_TYPE_PIPELINE_MULTISAMPLE_STATE_CREATE_INFO, .rasterizationSamples = VK_SAMPLE_COUNT_1_BIT};
  const VkPipelineDepthStencilStateCreateInfo depth = {.sType =
                                                           VK_STRUCTURE_TYPE_PIPELINE_DEPTH_STENCIL_STATE_CREATE_INFO,
                                                       .depthTestEnable = VK_TRUE,
                                                       .depthWriteEnable = VK_TRUE,
                                                       .depthCompareOp = info->depth_compare};
  const VkPipelineColorBlendAttachmentState opaque = {.colorWriteMask =
                                                          VK_COLOR_COMPONENT_R_BIT | VK_COLOR_COMPONENT_G_BIT |
                                                          VK_COLOR_COMPONENT_B_BIT | VK_COLOR_COMPONENT_A_BIT};
  const VkPipelineColorBlendStateCreateInfo blend = {.sType = VK_STRUCTURE_TYPE_PIPELINE_COLOR_BLEND_STATE_CREATE_INFO,
                                                     .attachmentCount = info->fragment_code ? 1 : 0,
                                                     .pAttachments = &opaque};
  const VkDynamicState states[] = {VK_DYNAMIC_STATE_VIEWPORT, VK_DYNAMIC_STATE_SCISSOR};
  const VkPipelineDynamicStateCreateInfo dynamic = {
      .sType = VK_STRUCTURE_TYPE_PIPELINE_DYNAMIC_STATE_CREATE_INFO, .dynamicStateCount = 2, .pDynamicStates = states};
  const VkGraphicsPipelineCreateInfo pipeline = {.sType = VK_STRUCTURE_TYPE_GRAPHICS_PIPELINE_CREATE_INFO,
                                                 .stageCount = info->fragment_code ? 2 : 1,
                                                 .pStages = stages,
                                                 .pVertexInputState = &info->input,
                                                 .pInputAssemblyState = &assembly,
                                                 .pViewportState = &viewport,
                                                 .pRasterizationState = &rasterization,
                                                 .pMultisampleState = &samples,
                                                 .pDepthStencilState = &depth,
                                                 .pColorBlendState = &blend,
                                                 .pDynamicState = &dynamic,
                                                 .layout = info->layout,
                                                 .renderPass = info->render_pass};
  VkPipeline out;
  vulkan_check(vkCreateGraphicsPipelines(base->device, VK_NULL_HANDLE, 1, &pipeline, NULL, &out),
               "vkCreateGraphicsPipelines");
  for (int i = 0; i < 2; i++)
    vkDestroyShaderModule(base->device, stages[i].module, NULL);
  return out;
}
