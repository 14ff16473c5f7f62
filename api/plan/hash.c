/* hash.c: a number that tells plans apart. */
#include "plan/internal.h"

#include "csm_constants.h"
#include <string.h>

/* FNV-1a by 64-bit words, for speed, folded after each one: a multiplication carries bits upwards only. */
static uint64_t add_word(uint64_t hash, uint64_t word) {
  const uint64_t mixed = (hash ^ word) * 0x100000001b3u;
  return mixed ^ mixed >> 32;
}

/* Bytes past the last whole word are taken as one word with zeros. */
static uint64_t add(uint64_t hash, const void *data, size_t size) {
  const char *bytes = data;
  uint64_t word;
  for (; size >= sizeof word; size -= sizeof word, bytes += sizeof word) {
    memcpy(&word, bytes, sizeof word);
    hash = add_word(hash, word);
  }
  if (size == 0)
    return hash;
  word = 0;
  memcpy(&word, bytes, size);
  return add_word(hash, word);
}

static uint64_t add_list(uint64_t hash, const plan_list *list) {
  hash = add(hash, &list->culled, sizeof list->culled);
  hash = add(hash, &list->draw_count, sizeof list->draw_count);
  hash = add(hash, &list->instance_count, sizeof list->instance_count);
  if (list->instance_count == 0)
    return hash;
  hash = add(hash, list->draws, list->draw_count * sizeof *list->draws);
  return add(hash, list->instances, list->instance_count * sizeof *list->instances);
}

/* The instances are looked at again, for the cache may have gone on to another plan. */
static uint64_t add_matrices(uint64_t hash, const plan_frame *frame, uint32_t window, const plan_scene *scene) {
  const plan_list *list = &frame->windows[window].list;
  for (uint32_t i = 0; i < list->instance_count; ++i) {
    const plan_instance *instance = &scene->instances[list->instances[i]];
    double to_light[12];
    float matrix[12];
    plan_light_transform(to_light, frame->basis, instance, &scene->meshes[instance->mesh]);
    plan_light_to_clip(matrix, frame->windows[window].to_clip, to_light);
    hash = add(hash, matrix, sizeof matrix);
  }
  return hash;
}

uint64_t plan_hash(const plan_frame *frame, const csm_config *config, const plan_scene *scene) {
  float constants[CSM_C_COUNT * 4];
  uint64_t hash = 0xcbf29ce484222325u;
  hash = add(hash, config, sizeof *config);
  hash = add(hash, constants, plan_write_constants(constants, frame, config));
  hash = add(hash, frame->camera.position, sizeof frame->camera.position);
  hash = add(hash, frame->origin, sizeof frame->origin);
  for (uint32_t i = 0; i < frame->cascade_count; ++i) {
    hash = add(hash, &frame->cascades[i].info, sizeof frame->cascades[i].info);
    hash = add(hash, frame->cascades[i].due, sizeof frame->cascades[i].due);
    hash = add(hash, frame->cascades[i].copied, sizeof frame->cascades[i].copied);
    hash = add(hash, frame->cascades[i].saved, sizeof frame->cascades[i].saved);
  }
  for (uint32_t i = 0; i < frame->window_count; ++i) {
    hash = add(hash, frame->windows[i].slots, sizeof frame->windows[i].slots);
    hash = add_list(hash, &frame->windows[i].list);
    hash = add_matrices(hash, frame, i, scene);
  }
  return hash;
}
