/* functions.h: the Vulkan functions that a device uses, in a table of its own: no global vk* name is linked or defined.
 */
#ifndef VULKAN_FUNCTIONS_H
#define VULKAN_FUNCTIONS_H

#define VK_NO_PROTOTYPES
#include <vulkan/vulkan_core.h>
#include <stdbool.h>

#define VULKAN_LOADER_FUNCTIONS(X)                                                                                     \
  X(EnumerateInstanceVersion)                                                                                          \
  X(EnumerateInstanceLayerProperties)                                                                                  \
  X(EnumerateInstanceExtensionProperties)                                                                              \
  X(CreateInstance)

/* On any device. */
#define VULKAN_INSTANCE_FUNCTIONS(X)                                                                                   \
  X(GetPhysicalDeviceProperties)                                                                                       \
  X(GetPhysicalDeviceProperties2)                                                                                      \
  X(GetPhysicalDeviceFormatProperties)                                                                                 \
  X(GetPhysicalDeviceImageFormatProperties)                                                                            \
  X(GetPhysicalDeviceMemoryProperties)                                                                                 \
  X(GetPhysicalDeviceMemoryProperties2)                                                                                \
  X(GetPhysicalDeviceQueueFamilyProperties)                                                                            \
  X(GetDeviceProcAddr)

/* On an own device alone: an engine's is never asked for them. */
#define VULKAN_OWN_INSTANCE_FUNCTIONS(X)                                                                               \
  X(DestroyInstance)                                                                                                   \
  X(EnumeratePhysicalDevices)                                                                                          \
  X(EnumerateDeviceExtensionProperties)                                                                                \
  X(GetPhysicalDeviceFeatures)                                                                                         \
  X(GetPhysicalDeviceFeatures2)                                                                                        \
  X(CreateDevice)

/* Of VK_EXT_debug_utils, which is optional; the messenger's on an own device alone. */
#define VULKAN_DEBUG_FUNCTIONS(X)                                                                                      \
  X(SetDebugUtilsObjectNameEXT)                                                                                        \
  X(CmdBeginDebugUtilsLabelEXT)                                                                                        \
  X(CmdEndDebugUtilsLabelEXT)

#define VULKAN_MESSENGER_FUNCTIONS(X)                                                                                  \
  X(CreateDebugUtilsMessengerEXT)                                                                                      \
  X(DestroyDebugUtilsMessengerEXT)

#define VULKAN_DEVICE_FUNCTIONS(X)                                                                                     \
  X(AllocateMemory)                                                                                                    \
  X(FreeMemory)                                                                                                        \
  X(MapMemory)                                                                                                         \
  X(CreateBuffer)                                                                                                      \
  X(DestroyBuffer)                                                                                                     \
  X(GetBufferMemoryRequirements)                                                                                       \
  X(BindBufferMemory)                                                                                                  \
  X(CreateImage)                                                                                                       \
  X(DestroyImage)                                                                                                      \
  X(GetImageMemoryRequirements)                                                                                        \
  X(BindImageMemory)                                                                                                   \
  X(CreateImageView)                                                                                                   \
  X(CreateBufferView)                                                                                                  \
  X(DestroyBufferView)                                                                                                 \
  X(DestroyImageView)                                                                                                  \
  X(CreateSampler)                                                                                                     \
  X(DestroySampler)                                                                                                    \
  X(CreateRenderPass)                                                                                                  \
  X(DestroyRenderPass)                                                                                                 \
  X(CreateFramebuffer)                                                                                                 \
  X(DestroyFramebuffer)                                                                                                \
  X(CreateShaderModule)                                                                                                \
  X(DestroyShaderModule)                                                                                               \
  X(CreateDescriptorSetLayout)                                                                                         \
  X(DestroyDescriptorSetLayout)                                                                                        \
  X(CreatePipelineLayout)                                                                                              \
  X(DestroyPipelineLayout)                                                                                             \
  X(CreateGraphicsPipelines)                                                                                           \
  X(CreateComputePipelines)                                                                                            \
  X(DestroyPipeline)                                                                                                   \
  X(CreateDescriptorPool)                                                                                              \
  X(DestroyDescriptorPool)                                                                                             \
  X(AllocateDescriptorSets)                                                                                            \
  X(UpdateDescriptorSets)                                                                                              \
  X(CreateQueryPool)                                                                                                   \
  X(DestroyQueryPool)                                                                                                  \
  X(GetQueryPoolResults)                                                                                               \
  X(CmdResetQueryPool)                                                                                                 \
  X(CmdWriteTimestamp)                                                                                                 \
  X(CmdPipelineBarrier)                                                                                                \
  X(CmdCopyBuffer)                                                                                                     \
  X(CmdCopyBufferToImage)                                                                                              \
  X(CmdCopyImageToBuffer)                                                                                              \
  X(CmdClearDepthStencilImage)                                                                                         \
  X(CmdBeginRenderPass)                                                                                                \
  X(CmdEndRenderPass)                                                                                                  \
  X(CmdSetViewport)                                                                                                    \
  X(CmdSetScissor)                                                                                                     \
  X(CmdBindPipeline)                                                                                                   \
  X(CmdBindDescriptorSets)                                                                                             \
  X(CmdBindVertexBuffers)                                                                                              \
  X(CmdBindIndexBuffer)                                                                                                \
  X(CmdDraw)                                                                                                           \
  X(CmdDrawIndexed)                                                                                                    \
  X(CmdDrawIndirect)                                                                                                   \
  X(CmdDrawIndexedIndirect)                                                                                            \
  X(CmdDispatch)                                                                                                       \
  X(CmdDispatchIndirect)

#define VULKAN_OWN_DEVICE_FUNCTIONS(X)                                                                                 \
  X(DestroyDevice)                                                                                                     \
  X(DeviceWaitIdle)                                                                                                    \
  X(GetDeviceQueue)                                                                                                    \
  X(QueueSubmit)                                                                                                       \
  X(CreateCommandPool)                                                                                                 \
  X(DestroyCommandPool)                                                                                                \
  X(ResetCommandPool)                                                                                                  \
  X(AllocateCommandBuffers)                                                                                            \
  X(BeginCommandBuffer)                                                                                                \
  X(EndCommandBuffer)                                                                                                  \
  X(CreateFence)                                                                                                       \
  X(DestroyFence)                                                                                                      \
  X(ResetFences)                                                                                                       \
  X(WaitForFences)

#define VULKAN_DECLARE(name) PFN_vk##name name;

/* Members are the functions' names without "vk". */
typedef struct vulkan_functions {
  PFN_vkGetInstanceProcAddr GetInstanceProcAddr; /* set by the owner; what the others are loaded through */
  VULKAN_LOADER_FUNCTIONS(VULKAN_DECLARE)
  VULKAN_INSTANCE_FUNCTIONS(VULKAN_DECLARE)
  VULKAN_OWN_INSTANCE_FUNCTIONS(VULKAN_DECLARE)
  VULKAN_DEBUG_FUNCTIONS(VULKAN_DECLARE)
  VULKAN_MESSENGER_FUNCTIONS(VULKAN_DECLARE)
  VULKAN_DEVICE_FUNCTIONS(VULKAN_DECLARE)
  VULKAN_OWN_DEVICE_FUNCTIONS(VULKAN_DECLARE)
  PFN_vkCmdBeginRendering CmdBeginRendering; /* where dynamic rendering is on: of the extension, or of Vulkan 1.3 */
  PFN_vkCmdEndRendering CmdEndRendering;
} vulkan_functions;

/* Each is false if a function is missing: what was asked is older than Vulkan 1.1, or has not the extension. `own`:
   with the functions of an own device. */
bool vulkan_load_loader(vulkan_functions *vk);
bool vulkan_load_instance(vulkan_functions *vk, VkInstance instance, bool own);
bool vulkan_load_debug(vulkan_functions *vk, VkInstance instance, bool own);
bool vulkan_load_device(vulkan_functions *vk, VkDevice device, bool own);
bool vulkan_load_rendering(vulkan_functions *vk, VkDevice device);

#endif
