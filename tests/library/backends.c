/*
 * backends.c: what csm_query_backends tells. Its lists and its texts say the same; a Vulkan device with what is
 * required, and nothing else, is enough, and without any of it csm_create says what is missing.
 */
#include "csm/csm.h"

#include <setjmp.h>
#include <stdarg.h>
#include <stdbool.h>
#include <string.h>

#include <cmocka.h>

#ifdef WITH_VULKAN
#include "csm/csm_vulkan.h"
#include <vulkan/vulkan.h>
#endif

enum { MOST = 8 };

static uint32_t query(csm_backend_info infos[MOST]) {
  uint32_t count = MOST;
  memset(infos, 0, MOST * sizeof *infos);
  infos[0].struct_size = sizeof *infos;
  assert_int_equal(csm_query_backends(&count, infos), CSM_SUCCESS);
  return count;
}

static uint32_t check_list(const char *const *names, const char *text) {
  uint32_t count = 0;
  assert_non_null(names);
  for (; names[count]; ++count)
    if (!names[count][0] || !strstr(text, names[count]))
      fail_msg("'%s' is not in: %s", names[count], text);
  return count;
}

static void lists_and_texts_agree(void **state) {
  (void)state;
  csm_backend_info infos[MOST];
  const uint32_t count = query(infos);
  for (uint32_t i = 0; i < count; ++i) {
    const csm_backend_info *info = &infos[i];
    const uint32_t required = check_list(info->required_instance_extensions, info->required) +
                              check_list(info->required_device_extensions, info->required) +
                              check_list(info->required_features, info->required);
    const uint32_t optional = check_list(info->optional_instance_extensions, info->optional) +
                              check_list(info->optional_device_extensions, info->optional) +
                              check_list(info->optional_features, info->optional);
    if (info->result != CSM_SUCCESS) {
      assert_true(required + optional == 0 && !info->required[0] && !info->optional[0]);
      continue;
    }
    /* A text that was cut ends at its room. */
    assert_true(strlen(info->required) + 1 < sizeof info->required);
    assert_true(strlen(info->optional) + 1 < sizeof info->optional);
    const bool vulkan = strcmp(info->name, "vulkan") == 0;
    assert_int_equal(info->required_api_version, vulkan ? 1u << 22 | 1u << 12 : 0);
    assert_int_equal(info->required_feature_level, vulkan ? 0 : 0xb000);
    assert_non_null(strstr(info->required, vulkan ? "Vulkan 1.1" : "feature level 11_0"));
    assert_true(vulkan ? required > 0 && optional > 0 : required + optional == 0);
  }
}

/* Elements are as large as the caller says, and get no more. */
static void an_older_struct_has_no_lists(void **state) {
  (void)state;
  enum { OLDER = offsetof(csm_backend_info, required_instance_extensions) };
  union {
    csm_backend_info align;
    unsigned char bytes[2 * OLDER + 64];
  } room;
  memset(&room, 0xa5, sizeof room);
  memcpy(room.bytes, &(uint32_t){OLDER}, sizeof(uint32_t));
  uint32_t count = 2;
  assert_int_equal(csm_query_backends(&count, (csm_backend_info *)(void *)room.bytes), CSM_SUCCESS);
  assert_string_equal((char *)room.bytes + offsetof(csm_backend_info, name), "vulkan");
  assert_string_equal((char *)room.bytes + OLDER + offsetof(csm_backend_info, name), "d3d12");
  for (size_t i = 2 * OLDER; i < sizeof room.bytes; ++i)
    assert_int_equal(room.bytes[i], 0xa5);
}

#ifdef WITH_VULKAN

/* The library keeps no backend open: lists of one query are read after others. */
static const csm_backend_info *query_vulkan(csm_backend_info infos[MOST]) {
  csm_backend_info again[MOST];
  const uint32_t count = query(infos);
  query(again);
  for (uint32_t i = 0; i < count; ++i)
    if (strcmp(infos[i].name, "vulkan") == 0 && infos[i].result == CSM_SUCCESS)
      return &infos[i];
  fail_msg("there is no Vulkan device");
  return NULL;
}

static uint32_t length(const char *const *names) {
  uint32_t count = 0;
  while (names[count])
    ++count;
  return count;
}

typedef struct features {
  VkPhysicalDeviceFeatures core;
  VkPhysicalDeviceDynamicRenderingFeatures dynamic;
} features;

static void enable(features *features, const char *name) {
  const struct {
    const char *name;
    VkBool32 *value;
  } known[] = {
      {"depthClamp", &features->core.depthClamp},
      {"depthBiasClamp", &features->core.depthBiasClamp},
      {"samplerAnisotropy", &features->core.samplerAnisotropy},
      {"fragmentStoresAndAtomics", &features->core.fragmentStoresAndAtomics},
      {"shaderStorageImageExtendedFormats", &features->core.shaderStorageImageExtendedFormats},
      {"dynamicRendering", &features->dynamic.dynamicRendering},
  };
  for (size_t i = 0; i < sizeof known / sizeof *known; ++i)
    if (strcmp(known[i].name, name) == 0) {
      *known[i].value = VK_TRUE;
      return;
    }
  fail_msg("%s is no feature that this test knows", name);
}

typedef struct device {
  VkInstance instance;
  VkPhysicalDevice physical;
  VkDevice handle;
  features features;
} device;

/* With all that is required but one feature (NULL: all). */
static void open_device(device *out, const csm_backend_info *info, const char *left_out) {
  memset(out, 0, sizeof *out);
  const VkApplicationInfo application = {.sType = VK_STRUCTURE_TYPE_APPLICATION_INFO,
                                         .apiVersion = info->required_api_version};
  const VkInstanceCreateInfo instance = {.sType = VK_STRUCTURE_TYPE_INSTANCE_CREATE_INFO,
                                         .pApplicationInfo = &application,
                                         .enabledExtensionCount = length(info->required_instance_extensions),
                                         .ppEnabledExtensionNames = info->required_instance_extensions};
  assert_int_equal(vkCreateInstance(&instance, NULL, &out->instance), VK_SUCCESS);
  uint32_t count = 1;
  assert_true(vkEnumeratePhysicalDevices(out->instance, &count, &out->physical) >= 0 && count == 1);
  for (const char *const *name = info->required_features; *name; ++name)
    if (*name != left_out)
      enable(&out->features, *name);
  const VkDeviceQueueCreateInfo queue = {
      .sType = VK_STRUCTURE_TYPE_DEVICE_QUEUE_CREATE_INFO, .queueCount = 1, .pQueuePriorities = (float[]){1}};
  const VkDeviceCreateInfo create = {.sType = VK_STRUCTURE_TYPE_DEVICE_CREATE_INFO,
                                     .queueCreateInfoCount = 1,
                                     .pQueueCreateInfos = &queue,
                                     .enabledExtensionCount = length(info->required_device_extensions),
                                     .ppEnabledExtensionNames = info->required_device_extensions,
                                     .pEnabledFeatures = &out->features.core};
  assert_int_equal(vkCreateDevice(out->physical, &create, NULL, &out->handle), VK_SUCCESS);
}

static csm_result create_on(const device *with, const csm_backend_info *info, char error[256]) {
  const csm_vulkan_device vulkan = {.struct_size = sizeof vulkan,
                                    .api_version = info->required_api_version,
                                    .instance = with->instance,
                                    .physical_device = with->physical,
                                    .device = with->handle,
                                    .get_instance_proc_addr = vkGetInstanceProcAddr,
                                    .extensions = info->required_device_extensions,
                                    .extension_count = length(info->required_device_extensions),
                                    .features = &with->features.core};
  const csm_create_info create = {.struct_size = sizeof create,
                                  .version = CSM_VERSION,
                                  .backend = "vulkan",
                                  .vulkan = &vulkan,
                                  .error = error,
                                  .error_size = 256};
  csm_context *context = NULL;
  const csm_result result = csm_create(&create, &context);
  csm_destroy(context);
  return result;
}

static void what_is_required_is_enough_and_needed(void **state) {
  (void)state;
  csm_backend_info infos[MOST];
  const csm_backend_info *info = query_vulkan(infos);
  const uint32_t count = length(info->required_features);
  for (uint32_t i = 0; i <= count; ++i) { /* the last round leaves nothing out */
    device with;
    char error[256] = "";
    open_device(&with, info, info->required_features[i]);
    const csm_result result = create_on(&with, info, error);
    if (i == count)
      assert_int_equal(result, CSM_SUCCESS);
    else if (result != CSM_ERROR_UNSUPPORTED || !strstr(error, info->required_features[i]))
      fail_msg("without %s: %s, %s", info->required_features[i], csm_result_name(result), error);
    vkDestroyDevice(with.handle, NULL);
    vkDestroyInstance(with.instance, NULL);
  }
}

static bool has_extension(const VkExtensionProperties *extensions, uint32_t count, const char *name) {
  for (uint32_t i = 0; i < count; ++i)
    if (strcmp(extensions[i].extensionName, name) == 0)
      return true;
  return false;
}

/* An instance's extension in a device's list, or the other way about, would never be found. */
static void extensions_are_of_the_kind_that_they_are_listed_as(void **state) {
  (void)state;
  static VkExtensionProperties of_instance[512], of_device[1024];
  csm_backend_info infos[MOST];
  const csm_backend_info *info = query_vulkan(infos);
  uint32_t instance_count = 512, device_count = 1024;
  device with;
  open_device(&with, info, NULL);
  assert_int_equal(vkEnumerateInstanceExtensionProperties(NULL, &instance_count, of_instance), VK_SUCCESS);
  assert_int_equal(vkEnumerateDeviceExtensionProperties(with.physical, NULL, &device_count, of_device), VK_SUCCESS);
  for (const char *const *name = info->optional_instance_extensions; *name; ++name)
    assert_false(has_extension(of_device, device_count, *name));
  for (const char *const *name = info->optional_device_extensions; *name; ++name)
    assert_false(has_extension(of_instance, instance_count, *name));
  for (const char *const *name = info->optional_features; *name; ++name)
    enable(&(features){0}, *name);
  vkDestroyDevice(with.handle, NULL);
  vkDestroyInstance(with.instance, NULL);
}

#endif

int main(void) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(lists_and_texts_agree),
      cmocka_unit_test(an_older_struct_has_no_lists),
#ifdef WITH_VULKAN
      cmocka_unit_test(what_is_required_is_enough_and_needed),
      cmocka_unit_test(extensions_are_of_the_kind_that_they_are_listed_as),
#endif
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}
