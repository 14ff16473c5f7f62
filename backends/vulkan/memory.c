/*
 * memory.c: device memory, from the engine's allocator where it has one. Else small buffers share blocks, because
 * devices allow few allocations. Large buffers and images have one each, which is a block with a single piece.
 */
#include "internal.h"

enum {
  BLOCK_SIZE = 16 << 20,
  SHARED_SIZE = 4 << 20, /* the largest piece that shares a block */
  GRAIN = 256            /* such pieces are multiples of it; a stricter alignment gets a block of its own */
};

struct vulkan_span {
  uint64_t offset, size;
  bool taken;
  vulkan_span *next; /* by offset, without gaps */
};

struct vulkan_block {
  VkDeviceMemory handle;
  uint32_t type;
  bool shared;
  char *mapped;
  vulkan_span *spans;
  vulkan_block *next;
};

static uint32_t find_type(const gpu_device *device, uint32_t allowed, VkMemoryPropertyFlags flags) {
  for (uint32_t i = 0; i < device->memory.memoryTypeCount; i++)
    if ((allowed >> i & 1) && (device->memory.memoryTypes[i].propertyFlags & flags) == flags)
      return i;
  return UINT32_MAX;
}

/* The properties that memory of a kind must have, and those that it should. */
typedef struct memory_wish {
  VkMemoryPropertyFlags required, preferred;
} memory_wish;

static memory_wish wish_of(gpu_buffer_kind kind) {
  const VkMemoryPropertyFlags host = VK_MEMORY_PROPERTY_HOST_VISIBLE_BIT | VK_MEMORY_PROPERTY_HOST_COHERENT_BIT;
  if (kind == GPU_BUFFER_DEVICE)
    return (memory_wish){.preferred = VK_MEMORY_PROPERTY_DEVICE_LOCAL_BIT};
  return (memory_wish){.required = host,
                       .preferred = kind == GPU_BUFFER_READBACK ? VK_MEMORY_PROPERTY_HOST_CACHED_BIT : 0};
}

uint32_t vulkan_memory_type(const gpu_device *device, uint32_t allowed_types, gpu_buffer_kind kind) {
  const memory_wish wish = wish_of(kind);
  const uint32_t type = find_type(device, allowed_types, wish.required | wish.preferred);
  return type != UINT32_MAX ? type : find_type(device, allowed_types, wish.required);
}

static void block_destroy(gpu_device *device, vulkan_block *block) {
  for (vulkan_span *span = block->spans, *next; span; span = next) {
    next = span->next;
    lent_release(&device->lent, span);
  }
  device->vk.FreeMemory(device->handle, block->handle, NULL);
  lent_release(&device->lent, block);
}

static csm_result block_create(gpu_device *device, uint64_t size, uint32_t type, bool map, vulkan_block **out) {
  csm_result result = CSM_ERROR_OUT_OF_MEMORY;
  vulkan_block *block = lent_allocate(&device->lent, sizeof *block);
  if (!block)
    return result;
  block->type = type;
  block->spans = lent_allocate(&device->lent, sizeof *block->spans);
  if (!block->spans)
    goto failed;
  block->spans->size = size;

  const VkMemoryAllocateInfo info = {
      .sType = VK_STRUCTURE_TYPE_MEMORY_ALLOCATE_INFO, .allocationSize = size, .memoryTypeIndex = type};
  result = vulkan_made(device, device->vk.AllocateMemory(device->handle, &info, NULL, &block->handle), &block->handle,
                       "vkAllocateMemory");
  if (result != CSM_SUCCESS)
    goto failed;
  if (map) {
    void *mapped = NULL;
    result = vulkan_check(device, device->vk.MapMemory(device->handle, block->handle, 0, VK_WHOLE_SIZE, 0, &mapped),
                          "vkMapMemory");
    if (result != CSM_SUCCESS)
      goto failed;
    block->mapped = mapped;
  }
  *out = block;
  return CSM_SUCCESS;

failed:
  block_destroy(device, block);
  return result;
}

static vulkan_span *find_span(const vulkan_block *block, uint64_t size) {
  for (vulkan_span *span = block->spans; span; span = span->next)
    if (!span->taken && span->size >= size)
      return span;
  return NULL;
}

/* Takes the first `size` bytes of a free span; the rest becomes a span of its own. False when out of memory. */
static bool take_span(gpu_device *device, vulkan_span *span, uint64_t size) {
  if (span->size > size) {
    vulkan_span *rest = lent_allocate(&device->lent, sizeof *rest);
    if (!rest)
      return false;
    *rest = (vulkan_span){.offset = span->offset + size, .size = span->size - size, .next = span->next};
    span->size = size;
    span->next = rest;
  }
  span->taken = true;
  return true;
}

static void merge_free_spans(gpu_device *device, vulkan_block *block) {
  for (vulkan_span *span = block->spans; span->next;) {
    vulkan_span *next = span->next;
    if (span->taken || next->taken) {
      span = next;
      continue;
    }
    span->size += next->size;
    span->next = next->next;
    lent_release(&device->lent, next);
  }
}

static void destroy_if_free(gpu_device *device, vulkan_block *block) {
  if (block->spans->next || block->spans->taken)
    return;
  vulkan_block **link = &device->blocks;
  while (*link != block)
    link = &(*link)->next;
  *link = block->next;
  block_destroy(device, block);
}

static csm_result block_take(gpu_device *device, const vulkan_memory_request *request, uint32_t type,
                             vulkan_memory *out) {
  const VkMemoryRequirements *needs = &request->needs;
  const bool shared = !request->image && needs->size <= SHARED_SIZE && needs->alignment <= GRAIN;
  const bool visible = device->memory.memoryTypes[type].propertyFlags & VK_MEMORY_PROPERTY_HOST_VISIBLE_BIT;
  const uint64_t size = shared ? (needs->size + GRAIN - 1) / GRAIN * GRAIN : needs->size;

  vulkan_block *block = NULL;
  vulkan_span *span = NULL;
  for (vulkan_block *b = device->blocks; shared && b && !span; b = b->next)
    if (b->shared && b->type == type && (span = find_span(b, size)))
      block = b;
  if (!block) {
    const csm_result result =
        block_create(device, shared ? BLOCK_SIZE : size, type, visible && !request->image, &block);
    if (result != CSM_SUCCESS)
      return result;
    vulkan_name(device, VK_OBJECT_TYPE_DEVICE_MEMORY, (uint64_t)block->handle, shared ? "csm buffers" : request->name);
    block->shared = shared;
    block->next = device->blocks;
    device->blocks = block;
    span = block->spans;
  }
  if (!take_span(device, span, size)) {
    destroy_if_free(device, block);
    return CSM_ERROR_OUT_OF_MEMORY;
  }
  *out = (vulkan_memory){.handle = block->handle,
                         .offset = span->offset,
                         .size = size,
                         .mapped = block->mapped ? block->mapped + span->offset : NULL,
                         .block = block,
                         .span = span};
  return CSM_SUCCESS;
}

/* ---- the engine's allocator ---- */

static csm_result engine_allocate(gpu_device *device, const vulkan_memory_request *request, vulkan_memory *out) {
  const memory_wish wish = wish_of(request->kind);
  const csm_vulkan_memory_request asked = {.struct_size = sizeof asked,
                                           .memory_type_bits = request->needs.memoryTypeBits,
                                           .size = request->needs.size,
                                           .alignment = request->needs.alignment,
                                           .image = request->image,
                                           .buffer = request->buffer,
                                           .required = wish.required,
                                           .preferred = wish.preferred,
                                           .name = request->name};
  csm_vulkan_memory given = {0};
  const csm_result result = vulkan_check(device, device->allocate_memory(device->memory_user, &asked, &given),
                                         "the engine's allocate_memory");
  if (result != CSM_SUCCESS)
    return result;
  if (!given.memory)
    return lent_fail(&device->lent, CSM_ERROR_OUT_OF_DEVICE_MEMORY, "the engine's allocate_memory: memory is NULL");
  const bool visible = wish.required & VK_MEMORY_PROPERTY_HOST_VISIBLE_BIT;
  const char *fault = given.offset % request->needs.alignment ? "offset is no multiple of the alignment"
                      : visible && !given.mapped              ? "mapped is NULL"
                                                              : NULL;
  if (fault) {
    device->free_memory(device->memory_user, &given);
    return lent_fail(&device->lent, CSM_ERROR_DEVICE, "the engine's allocate_memory: %s", fault);
  }
  *out = (vulkan_memory){.handle = given.memory,
                         .offset = given.offset,
                         .size = request->needs.size,
                         .mapped = given.mapped,
                         .engine = true,
                         .engine_handle = given.handle};
  return CSM_SUCCESS;
}

static void engine_free(gpu_device *device, const vulkan_memory *memory) {
  const csm_vulkan_memory given = {
      .memory = memory->handle, .offset = memory->offset, .mapped = memory->mapped, .handle = memory->engine_handle};
  device->free_memory(device->memory_user, &given);
}

/* ---- both ---- */

csm_result vulkan_memory_allocate(gpu_device *device, const vulkan_memory_request *request, vulkan_memory *out) {
  const uint32_t type = vulkan_memory_type(device, request->needs.memoryTypeBits, request->kind);
  if (type == UINT32_MAX)
    return lent_fail(&device->lent, CSM_ERROR_DEVICE, "no memory type of the device fits");
  if (request->needs.size > (request->image ? device->info.max_allocation_size : device->info.max_buffer_size))
    return lent_fail(&device->lent, CSM_ERROR_OUT_OF_DEVICE_MEMORY, "the device allows no allocation of %llu bytes",
                     (unsigned long long)request->needs.size);
  return device->allocate_memory ? engine_allocate(device, request, out) : block_take(device, request, type, out);
}

void vulkan_memory_release(gpu_device *device, vulkan_memory *memory) {
  vulkan_block *block = memory->block;
  if (memory->engine) {
    engine_free(device, memory);
  } else if (block) {
    memory->span->taken = false;
    merge_free_spans(device, block);
    destroy_if_free(device, block);
  }
  *memory = (vulkan_memory){0};
}
