/*
 * rig_vulkan_faults.h: a Vulkan in which any call that may fail can be made to (rig_fail), which counts what is made
 * and destroyed, and which may tell of a memory budget. A rig of kind RIG_FAILING hands csm its vkGetInstanceProcAddr;
 * for an own device it stands in for the library, see fake_vulkan.c. There is one in a program.
 */
#ifndef RIG_VULKAN_FAULTS_H
#define RIG_VULKAN_FAULTS_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>
#include <vulkan/vulkan.h>

typedef struct rig_vulkan_faults {
  uint32_t calls;     /* made so far of those that may fail */
  uint32_t fail_at;   /* which of them fails, from 1; 0 is none */
  VkResult result;    /* and with what */
  const char *failed; /* the function that did; NULL: none yet */
  bool lost;          /* VK_ERROR_DEVICE_LOST was answered: whatever may answer it again does */

  bool tells_budget;        /* VK_EXT_memory_budget is there */
  uint64_t budget, used;    /* bytes: of every heap; used by others */
  uint64_t allocated, most; /* bytes: now; at most so far */
} rig_vulkan_faults;

extern rig_vulkan_faults faults;

PFN_vkVoidFunction VKAPI_CALL faults_get_instance_proc_addr(VkInstance instance, const char *name);

#endif
