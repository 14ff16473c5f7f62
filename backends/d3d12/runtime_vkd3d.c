/*
 * runtime_vkd3d.c: Direct3D 12 from vkd3d, over Vulkan. vkd3d and the Vulkan loader beneath it are opened when a device
 * is. COM methods use the Microsoft calling convention, which vkd3d's headers declare.
 */
#include "runtime.h"

#define VKD3D_NO_PROTOTYPES
#include <vkd3d.h>

#include "../choose.h"
#include "../physical.h"
#include "internal.h"

#include <dlfcn.h>
#include <pthread.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>

#define VALIDATION_LAYER "VK_LAYER_KHRONOS_validation"

enum { WAIT_SECONDS = 2 };

/* What a fence signals, from vkd3d's own thread. */
typedef struct fence_event {
  pthread_mutex_t mutex;
  pthread_cond_t changed;
  bool signaled;
} fence_event;

struct d3d12_runtime {
  void *vulkan_library, *vkd3d_library;
  PFN_vkGetInstanceProcAddr get_instance_proc;
  PFN_vkd3d_create_instance create_instance;
  PFN_vkd3d_instance_decref release_instance;
  PFN_vkd3d_instance_get_vk_instance get_vk_instance;
  PFN_vkd3d_create_device create_device;
  PFN_vkd3d_serialize_root_signature serialize_root_signature;
  struct vkd3d_instance *instance;
  VkInstance vk_instance;
  VkDebugUtilsMessengerEXT messenger;
  VkPhysicalDevice physical;
  bool memory_budget; /* VK_EXT_memory_budget */
  bool has_event;
  fence_event event;
};

/* vkd3d's markers and discards do nothing but print a line for every call. Its signals answer E_FAIL where the device is
   lost, and fail for no other reason. */
const d3d12_traits *d3d12_runtime_traits(void) {
  static const char *const run_time[] = {"an ID3D12Device of the process's libvkd3d.so.1",
                                         "its D3D12SerializeRootSignature", NULL};
  static const d3d12_traits traits = {
      .required = {.others = run_time, .feature_level = D3D_FEATURE_LEVEL_11_0},
      .self_barriers = true,
      .partial_depth_copies = true,
      .markers = false,
      .discards = false,
      .nameless_loss = true,
  };
  return &traits;
}

/* ---- libraries ---- */

static csm_result open_library(const gpu_device *device, const char *name, const char *package, void **out) {
  *out = dlopen(name, RTLD_NOW | RTLD_LOCAL);
  if (*out)
    return CSM_SUCCESS;
  const char *reason = dlerror();
  return lent_fail(&device->lent, CSM_ERROR_NO_DEVICE, "%s (Debian's package %s) cannot be opened: %s", name, package,
                   reason ? reason : "no reason given");
}

static csm_result open_libraries(const gpu_device *device, d3d12_runtime *runtime) {
  csm_result result = open_library(device, "libvulkan.so.1", "libvulkan1", &runtime->vulkan_library);
  if (result == CSM_SUCCESS)
    result = open_library(device, "libvkd3d.so.1", "libvkd3d1", &runtime->vkd3d_library);
  if (result != CSM_SUCCESS)
    return result;

  const struct {
    void *library;
    const char *name;
    void **out;
  } entries[] = {
      {runtime->vulkan_library, "vkGetInstanceProcAddr", (void **)&runtime->get_instance_proc},
      {runtime->vkd3d_library, "vkd3d_create_instance", (void **)&runtime->create_instance},
      {runtime->vkd3d_library, "vkd3d_instance_decref", (void **)&runtime->release_instance},
      {runtime->vkd3d_library, "vkd3d_instance_get_vk_instance", (void **)&runtime->get_vk_instance},
      {runtime->vkd3d_library, "vkd3d_create_device", (void **)&runtime->create_device},
      {runtime->vkd3d_library, "vkd3d_serialize_root_signature", (void **)&runtime->serialize_root_signature},
  };
  for (size_t i = 0; i < sizeof entries / sizeof *entries; i++) {
    *entries[i].out = dlsym(entries[i].library, entries[i].name);
    if (!*entries[i].out)
      return lent_fail(&device->lent, CSM_ERROR_NO_DEVICE, "%s has no %s", i ? "libvkd3d.so.1" : "libvulkan.so.1",
                       entries[i].name);
  }
  return CSM_SUCCESS;
}

/* A function of the instance's. Before there is one: a function that serves to make it. */
static PFN_vkVoidFunction instance_function(const d3d12_runtime *runtime, const char *name) {
  return runtime->get_instance_proc(runtime->vk_instance, name);
}

/* ---- validation ---- */

/*
 * vkd3d enables layers only by environment variables. But it takes a vkGetInstanceProcAddr, and this one hands out a
 * vkCreateInstance that adds the layer, so the process's environment stays as it is. These functions get no user
 * pointer, so they look the loader up by name; the run time keeps it open.
 */
static PFN_vkVoidFunction loader_function(VkInstance instance, const char *name) {
  void *library = dlopen("libvulkan.so.1", RTLD_NOW | RTLD_LOCAL | RTLD_NOLOAD);
  if (!library)
    return NULL;
  PFN_vkGetInstanceProcAddr get;
  *(void **)&get = dlsym(library, "vkGetInstanceProcAddr");
  const PFN_vkVoidFunction function = get ? get(instance, name) : NULL;
  dlclose(library);
  return function;
}

static bool lists(const char *const *names, uint32_t count, const char *name) {
  for (uint32_t i = 0; i < count; i++)
    if (strcmp(names[i], name) == 0)
      return true;
  return false;
}

/* Whether the layer can be told what to validate. */
static bool has_validation_features(PFN_vkEnumerateInstanceExtensionProperties enumerate) {
  VkExtensionProperties extensions[64];
  uint32_t count = sizeof extensions / sizeof *extensions;
  if (!enumerate || enumerate(VALIDATION_LAYER, &count, extensions) < 0)
    return false;
  for (uint32_t i = 0; i < count; i++)
    if (strcmp(extensions[i].extensionName, VK_EXT_VALIDATION_FEATURES_EXTENSION_NAME) == 0)
      return true;
  return false;
}

static VKAPI_ATTR VkResult VKAPI_CALL create_validated_instance(const VkInstanceCreateInfo *asked,
                                                                const VkAllocationCallbacks *allocator,
                                                                VkInstance *out) {
  static const char *const added[] = {VK_EXT_DEBUG_UTILS_EXTENSION_NAME, VK_EXT_VALIDATION_FEATURES_EXTENSION_NAME};
  static const VkValidationFeatureEnableEXT enabled = VK_VALIDATION_FEATURE_ENABLE_SYNCHRONIZATION_VALIDATION_EXT;
  const bool has_features = has_validation_features(
      (PFN_vkEnumerateInstanceExtensionProperties)loader_function(NULL, "vkEnumerateInstanceExtensionProperties"));
  const uint32_t added_count = has_features ? 2 : 1;
  const PFN_vkCreateInstance create = (PFN_vkCreateInstance)loader_function(NULL, "vkCreateInstance");
  const char **extensions = malloc((asked->enabledExtensionCount + added_count) * sizeof *extensions);
  if (!create || !extensions) {
    free(extensions);
    return create ? VK_ERROR_OUT_OF_HOST_MEMORY : VK_ERROR_INITIALIZATION_FAILED;
  }
  uint32_t count = 0;
  for (uint32_t i = 0; i < asked->enabledExtensionCount; i++)
    extensions[count++] = asked->ppEnabledExtensionNames[i];
  for (uint32_t i = 0; i < added_count; i++)
    if (!lists(extensions, count, added[i]))
      extensions[count++] = added[i];

  const char *const layers[] = {VALIDATION_LAYER};
  const VkValidationFeaturesEXT features = {
      .sType = VK_STRUCTURE_TYPE_VALIDATION_FEATURES_EXT,
      .pNext = asked->pNext,
      .enabledValidationFeatureCount = 1,
      .pEnabledValidationFeatures = &enabled,
  };
  VkInstanceCreateInfo info = *asked;
  info.pNext = has_features ? &features : asked->pNext;
  info.enabledLayerCount = 1;
  info.ppEnabledLayerNames = layers;
  info.enabledExtensionCount = count;
  info.ppEnabledExtensionNames = extensions;
  const VkResult result = create(&info, allocator, out);
  free(extensions);
  return result;
}

static PFN_vkVoidFunction VKAPI_CALL validated_function(VkInstance instance, const char *name) {
  if (strcmp(name, "vkCreateInstance") == 0)
    return (PFN_vkVoidFunction)create_validated_instance;
  return loader_function(instance, name);
}

static bool has_validation_layer(const d3d12_runtime *runtime) {
  const PFN_vkEnumerateInstanceLayerProperties enumerate =
      (PFN_vkEnumerateInstanceLayerProperties)instance_function(runtime, "vkEnumerateInstanceLayerProperties");
  VkLayerProperties layers[64];
  uint32_t count = sizeof layers / sizeof *layers;
  if (!enumerate || enumerate(&count, layers) < 0)
    return false;
  for (uint32_t i = 0; i < count; i++)
    if (strcmp(layers[i].layerName, VALIDATION_LAYER) == 0)
      return true;
  return false;
}

/* A message may come from the thread on which vkd3d waits for its fences. */
static VKAPI_ATTR VkBool32 VKAPI_CALL log_message(VkDebugUtilsMessageSeverityFlagBitsEXT severity,
                                                  VkDebugUtilsMessageTypeFlagsEXT types,
                                                  const VkDebugUtilsMessengerCallbackDataEXT *data, void *user) {
  (void)types;
  const gpu_device *device = user;
  physical_log(&device->lent.host, severity, data->pMessage);
  return VK_FALSE;
}

static csm_result create_messenger(gpu_device *device, d3d12_runtime *runtime) {
  const PFN_vkCreateDebugUtilsMessengerEXT create =
      (PFN_vkCreateDebugUtilsMessengerEXT)instance_function(runtime, "vkCreateDebugUtilsMessengerEXT");
  const VkDebugUtilsMessengerCreateInfoEXT info = {
      .sType = VK_STRUCTURE_TYPE_DEBUG_UTILS_MESSENGER_CREATE_INFO_EXT,
      .messageSeverity =
          VK_DEBUG_UTILS_MESSAGE_SEVERITY_WARNING_BIT_EXT | VK_DEBUG_UTILS_MESSAGE_SEVERITY_ERROR_BIT_EXT,
      .messageType = VK_DEBUG_UTILS_MESSAGE_TYPE_VALIDATION_BIT_EXT,
      .pfnUserCallback = log_message,
      .pUserData = device,
  };
  if (create && create(runtime->vk_instance, &info, NULL, &runtime->messenger) == VK_SUCCESS)
    return CSM_SUCCESS;
  runtime->messenger = VK_NULL_HANDLE;
  return lent_fail(&device->lent, CSM_ERROR_DEVICE, "the validation layer's messages cannot be received");
}

static void destroy_messenger(d3d12_runtime *runtime) {
  const PFN_vkDestroyDebugUtilsMessengerEXT destroy =
      (PFN_vkDestroyDebugUtilsMessengerEXT)instance_function(runtime, "vkDestroyDebugUtilsMessengerEXT");
  destroy(runtime->vk_instance, runtime->messenger, NULL);
}

/* ---- waiting ---- */

static csm_result event_create(gpu_device *device, d3d12_runtime *runtime) {
  pthread_condattr_t attributes;
  if (pthread_condattr_init(&attributes))
    return lent_fail(&device->lent, CSM_ERROR_OUT_OF_MEMORY, "out of memory");
  pthread_condattr_setclock(&attributes, CLOCK_MONOTONIC);
  const int failed = pthread_cond_init(&runtime->event.changed, &attributes);
  pthread_condattr_destroy(&attributes);
  if (failed)
    return lent_fail(&device->lent, CSM_ERROR_OUT_OF_MEMORY, "out of memory");
  pthread_mutex_init(&runtime->event.mutex, NULL);
  runtime->has_event = true;
  return CSM_SUCCESS;
}

static HRESULT event_signal(HANDLE handle) {
  fence_event *event = handle;
  pthread_mutex_lock(&event->mutex);
  event->signaled = true;
  pthread_cond_broadcast(&event->changed);
  pthread_mutex_unlock(&event->mutex);
  return S_OK;
}

HRESULT d3d12_runtime_wait(d3d12_runtime *runtime, ID3D12Fence *fence, uint64_t value) {
  fence_event *event = &runtime->event;
  const HRESULT hr = ID3D12Fence_SetEventOnCompletion(fence, value, event);
  if (FAILED(hr))
    return hr;
  struct timespec end;
  clock_gettime(CLOCK_MONOTONIC, &end);
  end.tv_sec += WAIT_SECONDS;
  pthread_mutex_lock(&event->mutex);
  for (int failed = 0; !event->signaled && !failed;)
    failed = pthread_cond_timedwait(&event->changed, &event->mutex, &end);
  event->signaled = false;
  pthread_mutex_unlock(&event->mutex);
  return S_OK;
}

/* ---- the instance ---- */

static csm_result create_instance(gpu_device *device, d3d12_runtime *runtime, bool asked) {
  const bool validate = asked && has_validation_layer(runtime);
  if (asked && !validate)
    device->lent.host.log(device->lent.host.user, CSM_LOG_WARNING,
                          VALIDATION_LAYER " is not installed: nothing is validated");
  if (validate && !has_validation_features((PFN_vkEnumerateInstanceExtensionProperties)instance_function(
                      runtime, "vkEnumerateInstanceExtensionProperties")))
    device->lent.host.log(device->lent.host.user, CSM_LOG_WARNING,
                          VALIDATION_LAYER " is too old to validate synchronization");

  const struct vkd3d_application_info application = {
      .type = VKD3D_STRUCTURE_TYPE_APPLICATION_INFO,
      .application_name = "csm",
      .application_version = CSM_VERSION,
      .api_version = VKD3D_API_VERSION_1_2,
  };
  const struct vkd3d_instance_create_info info = {
      .type = VKD3D_STRUCTURE_TYPE_INSTANCE_CREATE_INFO,
      .next = &application,
      .pfn_signal_event = event_signal,
      .wchar_size = sizeof(WCHAR),
      .pfn_vkGetInstanceProcAddr = validate ? validated_function : runtime->get_instance_proc,
  };
  const HRESULT hr = runtime->create_instance(&info, &runtime->instance);
  if (FAILED(hr)) {
    runtime->instance = NULL;
    return lent_fail(&device->lent, CSM_ERROR_NO_DEVICE, "vkd3d found no usable Vulkan driver (HRESULT 0x%08x)",
                     (uint32_t)hr);
  }
  runtime->vk_instance = runtime->get_vk_instance(runtime->instance);
  return validate ? create_messenger(device, runtime) : CSM_SUCCESS;
}

/* ---- the adapter ---- */

/* What a device lacks that csm cannot do without; NULL if nothing. */
static const char *missing(const d3d12_runtime *runtime, VkPhysicalDevice physical,
                           const VkPhysicalDeviceProperties *properties) {
  const PFN_vkGetPhysicalDeviceFeatures get_features =
      (PFN_vkGetPhysicalDeviceFeatures)instance_function(runtime, "vkGetPhysicalDeviceFeatures");
  const PFN_vkGetPhysicalDeviceFormatProperties get_format =
      (PFN_vkGetPhysicalDeviceFormatProperties)instance_function(runtime, "vkGetPhysicalDeviceFormatProperties");
  VkPhysicalDeviceFeatures features;
  VkFormatProperties depth;
  get_features(physical, &features);
  get_format(physical, VK_FORMAT_D32_SFLOAT, &depth);
  return physical_lacks(properties, &features, &depth);
}

static csm_result select_physical(gpu_device *device, d3d12_runtime *runtime, const char *name) {
  const PFN_vkEnumeratePhysicalDevices enumerate =
      (PFN_vkEnumeratePhysicalDevices)instance_function(runtime, "vkEnumeratePhysicalDevices");
  const PFN_vkGetPhysicalDeviceProperties get_properties =
      (PFN_vkGetPhysicalDeviceProperties)instance_function(runtime, "vkGetPhysicalDeviceProperties");
  VkPhysicalDevice list[32];
  uint32_t count = sizeof list / sizeof *list;
  choose_choice choice = {.part = name};
  char refusal[512];
  if (enumerate(runtime->vk_instance, &count, list) < 0 || count == 0)
    return lent_fail(&device->lent, CSM_ERROR_NO_DEVICE, "no Vulkan device for vkd3d was found");
  for (uint32_t i = 0; i < count; i++) {
    VkPhysicalDeviceProperties properties;
    get_properties(list[i], &properties);
    const choose_candidate candidate = {.name = properties.deviceName,
                                        .type = physical_type(properties.deviceType),
                                        .lacks = missing(runtime, list[i], &properties)};
    if (choose_offer(&choice, &candidate))
      runtime->physical = list[i];
  }
  if (runtime->physical)
    return CSM_SUCCESS;
  choose_refusal(&choice, refusal, sizeof refusal);
  return lent_fail(&device->lent, CSM_ERROR_NO_DEVICE, "%s", refusal);
}

/* ---- description ---- */

/* vkd3d tells its version through the shader library that it depends on, which is of the same release. */
static const char *vkd3d_version(const d3d12_runtime *runtime) {
  const char *(*get_version)(unsigned int *major, unsigned int *minor);
  *(void **)&get_version = dlsym(runtime->vkd3d_library, "vkd3d_shader_get_version");
  return get_version ? get_version(NULL, NULL) : "vkd3d";
}

static uint32_t minimum(uint32_t a, uint32_t b) {
  return a < b ? a : b;
}

static uint64_t minimum64(uint64_t a, uint64_t b) {
  return a < b ? a : b;
}

/* The largest images and memory: limits of the device, of its depth format, and of D3D12. */
static csm_result describe_sizes(gpu_device *device, const d3d12_runtime *runtime, const VkPhysicalDeviceLimits *limits,
                                 uint64_t max_allocation) {
  const PFN_vkGetPhysicalDeviceImageFormatProperties get =
      (PFN_vkGetPhysicalDeviceImageFormatProperties)instance_function(runtime,
                                                                      "vkGetPhysicalDeviceImageFormatProperties");
  const PFN_vkGetPhysicalDeviceMemoryProperties get_memory =
      (PFN_vkGetPhysicalDeviceMemoryProperties)instance_function(runtime, "vkGetPhysicalDeviceMemoryProperties");
  gpu_device_info *info = &device->info;
  VkImageFormatProperties depth;
  VkPhysicalDeviceMemoryProperties memory;
  if (get(runtime->physical, VK_FORMAT_D32_SFLOAT, VK_IMAGE_TYPE_2D, VK_IMAGE_TILING_OPTIMAL, physical_depth_usage, 0,
          &depth) != VK_SUCCESS)
    return lent_fail(&device->lent, CSM_ERROR_NO_DEVICE, "%s has no D32_FLOAT images", info->name);
  get_memory(runtime->physical, &memory);
  const physical_limits all = {.device = limits, .depth = &depth, .memory = &memory, .max_allocation = max_allocation};
  physical_sizes(&all, info);
  info->max_image_size = minimum(info->max_image_size, D3D12_REQ_TEXTURE2D_U_OR_V_DIMENSION);
  info->max_image_layers = minimum(info->max_image_layers, D3D12_REQ_TEXTURE2D_ARRAY_AXIS_DIMENSION);
  return CSM_SUCCESS;
}

static uint32_t format_can(const VkFormatProperties *properties, gpu_format format, bool loads) {
  const VkFormatFeatureFlags features = properties->optimalTilingFeatures;
  uint32_t can = 0;
  if (features & VK_FORMAT_FEATURE_SAMPLED_IMAGE_BIT)
    can |= GPU_CAN_SAMPLE;
  if (features & VK_FORMAT_FEATURE_SAMPLED_IMAGE_FILTER_LINEAR_BIT)
    can |= GPU_CAN_FILTER;
  if (features & (VK_FORMAT_FEATURE_COLOR_ATTACHMENT_BIT | VK_FORMAT_FEATURE_DEPTH_STENCIL_ATTACHMENT_BIT))
    can |= GPU_CAN_DRAW;
  if (features & VK_FORMAT_FEATURE_STORAGE_IMAGE_BIT)
    can |= GPU_CAN_STORE;
  if ((can & GPU_CAN_STORE) && (loads || format == GPU_FORMAT_R32_FLOAT || format == GPU_FORMAT_R32_UINT))
    can |= GPU_CAN_LOAD;
  if (features & VK_FORMAT_FEATURE_STORAGE_IMAGE_ATOMIC_BIT)
    can |= GPU_CAN_ATOMIC;
  return can;
}

static void describe_capabilities(const d3d12_runtime *runtime, const VkPhysicalDeviceLimits *limits,
                                  gpu_capabilities *out) {
  static const VkFormat formats[GPU_FORMAT_COUNT] = {
      [GPU_FORMAT_D32_FLOAT] = VK_FORMAT_D32_SFLOAT,
      [GPU_FORMAT_D16_UNORM] = VK_FORMAT_D16_UNORM,
      [GPU_FORMAT_R8_UNORM] = VK_FORMAT_R8_UNORM,
      [GPU_FORMAT_R16_UNORM] = VK_FORMAT_R16_UNORM,
      [GPU_FORMAT_RG16_UNORM] = VK_FORMAT_R16G16_UNORM,
      [GPU_FORMAT_R16_FLOAT] = VK_FORMAT_R16_SFLOAT,
      [GPU_FORMAT_RG16_FLOAT] = VK_FORMAT_R16G16_SFLOAT,
      [GPU_FORMAT_RGBA16_FLOAT] = VK_FORMAT_R16G16B16A16_SFLOAT,
      [GPU_FORMAT_R32_FLOAT] = VK_FORMAT_R32_SFLOAT,
      [GPU_FORMAT_RG32_FLOAT] = VK_FORMAT_R32G32_SFLOAT,
      [GPU_FORMAT_RGBA32_FLOAT] = VK_FORMAT_R32G32B32A32_SFLOAT,
      [GPU_FORMAT_R32_UINT] = VK_FORMAT_R32_UINT,
  };
  const PFN_vkGetPhysicalDeviceFormatProperties get_format =
      (PFN_vkGetPhysicalDeviceFormatProperties)instance_function(runtime, "vkGetPhysicalDeviceFormatProperties");
  const PFN_vkGetPhysicalDeviceFeatures get_features =
      (PFN_vkGetPhysicalDeviceFeatures)instance_function(runtime, "vkGetPhysicalDeviceFeatures");
  VkPhysicalDeviceFeatures features;
  get_features(runtime->physical, &features);
  d3d12_describe_level(out);
  out->max_anisotropy =
      features.samplerAnisotropy ? minimum((uint32_t)limits->maxSamplerAnisotropy, GPU_MAX_ANISOTROPY) : 1;
  out->max_texels_size = minimum64(out->max_texels_size, (uint64_t)limits->maxTexelBufferElements * GPU_TEXEL_SIZE);
  for (gpu_format format = GPU_FORMAT_NONE + 1; format < GPU_FORMAT_COUNT; format++) {
    VkFormatProperties properties;
    if (formats[format] == VK_FORMAT_UNDEFINED)
      continue; /* attributes alone */
    get_format(runtime->physical, formats[format], &properties);
    out->formats[format] = format_can(&properties, format, features.shaderStorageImageReadWithoutFormat);
  }
}

static csm_result describe_physical(gpu_device *device, const d3d12_runtime *runtime) {
  const PFN_vkGetPhysicalDeviceProperties2 get =
      (PFN_vkGetPhysicalDeviceProperties2)instance_function(runtime, "vkGetPhysicalDeviceProperties2KHR");
  if (!get)
    return lent_fail(&device->lent, CSM_ERROR_NO_DEVICE, "the Vulkan driver has no vkGetPhysicalDeviceProperties2KHR");
  /* A driver that does not know the driver's properties leaves them empty. */
  VkPhysicalDeviceDriverProperties driver = {.sType = VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_DRIVER_PROPERTIES};
  VkPhysicalDeviceMaintenance3Properties sizes = {.sType = VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_MAINTENANCE_3_PROPERTIES,
                                                  .pNext = &driver};
  VkPhysicalDeviceProperties2 all = {.sType = VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_PROPERTIES_2, .pNext = &sizes};
  get(runtime->physical, &all);

  gpu_device_info *info = &device->info;
  info->type = physical_type(all.properties.deviceType);
  lent_text(info->name, sizeof info->name, "%s", all.properties.deviceName);
  lent_text(info->driver, sizeof info->driver, "%s on %.96s %.96s", vkd3d_version(runtime), driver.driverName,
            driver.driverInfo);
  describe_capabilities(runtime, &all.properties.limits, &info->can);
  return describe_sizes(device, runtime, &all.properties.limits, sizes.maxMemoryAllocationSize);
}

/* ---- the budget ---- */

/* VK_EXT_memory_budget needs no enabling. */
static csm_result find_memory_budget(gpu_device *device, d3d12_runtime *runtime) {
  const PFN_vkEnumerateDeviceExtensionProperties enumerate =
      (PFN_vkEnumerateDeviceExtensionProperties)instance_function(runtime, "vkEnumerateDeviceExtensionProperties");
  uint32_t count = 0;
  if (enumerate(runtime->physical, NULL, &count, NULL) != VK_SUCCESS || count == 0)
    return CSM_SUCCESS;
  VkExtensionProperties *extensions = lent_allocate(&device->lent, count * sizeof *extensions);
  if (!extensions)
    return lent_fail(&device->lent, CSM_ERROR_OUT_OF_MEMORY, "out of memory");
  if (enumerate(runtime->physical, NULL, &count, extensions) >= 0)
    for (uint32_t i = 0; i < count; i++)
      runtime->memory_budget |= strcmp(extensions[i].extensionName, VK_EXT_MEMORY_BUDGET_EXTENSION_NAME) == 0;
  lent_release(&device->lent, extensions);
  return CSM_SUCCESS;
}

uint64_t d3d12_runtime_memory_available(const d3d12_runtime *runtime) {
  const PFN_vkGetPhysicalDeviceMemoryProperties2 get =
      (PFN_vkGetPhysicalDeviceMemoryProperties2)instance_function(runtime, "vkGetPhysicalDeviceMemoryProperties2KHR");
  if (!runtime->memory_budget || !get)
    return UINT64_MAX;
  VkPhysicalDeviceMemoryBudgetPropertiesEXT budget = {
      .sType = VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_MEMORY_BUDGET_PROPERTIES_EXT};
  VkPhysicalDeviceMemoryProperties2 memory = {.sType = VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_MEMORY_PROPERTIES_2,
                                              .pNext = &budget};
  get(runtime->physical, &memory);
  const uint32_t heap = physical_image_heap(&memory.memoryProperties);
  return budget.heapBudget[heap] > budget.heapUsage[heap] ? budget.heapBudget[heap] - budget.heapUsage[heap] : 0;
}

/* ---- opening and closing ---- */

csm_result d3d12_runtime_open(gpu_device *device, const gpu_open_info *info) {
  d3d12_runtime *runtime = lent_allocate(&device->lent, sizeof *runtime);
  if (!runtime)
    return lent_fail(&device->lent, CSM_ERROR_OUT_OF_MEMORY, "out of memory");
  device->runtime = runtime;
  csm_result result = event_create(device, runtime);
  if (result == CSM_SUCCESS)
    result = open_libraries(device, runtime);
  if (result == CSM_SUCCESS)
    result = create_instance(device, runtime, info->validate);
  if (result == CSM_SUCCESS)
    result = select_physical(device, runtime, info->device_name);
  if (result == CSM_SUCCESS)
    result = describe_physical(device, runtime);
  if (result == CSM_SUCCESS)
    result = find_memory_budget(device, runtime);
  return result;
}

csm_result d3d12_runtime_create_device(gpu_device *device) {
  const d3d12_runtime *runtime = device->runtime;
  const struct vkd3d_device_create_info info = {
      .type = VKD3D_STRUCTURE_TYPE_DEVICE_CREATE_INFO,
      .minimum_feature_level = D3D_FEATURE_LEVEL_11_0,
      .instance = runtime->instance,
      .vk_physical_device = runtime->physical,
  };
  const HRESULT hr = runtime->create_device(&info, &IID_ID3D12Device, (void **)&device->handle);
  if (SUCCEEDED(hr))
    return CSM_SUCCESS;
  device->handle = NULL;
  return lent_fail(&device->lent, CSM_ERROR_NO_DEVICE, "vkd3d cannot open %s at feature level 11_0 (HRESULT 0x%08x)",
                   device->info.name, (uint32_t)hr);
}

HRESULT d3d12_runtime_serialize(const d3d12_runtime *runtime, const D3D12_ROOT_SIGNATURE_DESC *signature,
                                ID3DBlob **out) {
  return runtime->serialize_root_signature(signature, D3D_ROOT_SIGNATURE_VERSION_1_0, out, NULL);
}

void d3d12_runtime_close(gpu_device *device) {
  d3d12_runtime *runtime = device->runtime;
  if (!runtime)
    return;
  if (runtime->messenger)
    destroy_messenger(runtime);
  if (runtime->instance)
    runtime->release_instance(runtime->instance);
  if (runtime->vkd3d_library)
    dlclose(runtime->vkd3d_library);
  if (runtime->vulkan_library)
    dlclose(runtime->vulkan_library);
  if (runtime->has_event) {
    pthread_mutex_destroy(&runtime->event.mutex);
    pthread_cond_destroy(&runtime->event.changed);
  }
  lent_release(&device->lent, runtime);
  device->runtime = NULL;
}
