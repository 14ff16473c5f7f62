/* input_gltf.c: a scene's file, read, looked at and given to csm. */
#include "csm/csm.h"
#include "input.h"
#include "scene/scene.h"
#include "stage/assets.h"
#include "truth/truth.h"

#include <stdlib.h>
#include <string.h>

/* A triangle that a texture cuts out, in a node below another one; and a skin. */
static const char document[] =
    "{\"asset\": {\"version\": \"2.0\"}, \"scene\": 0, \"scenes\": [{\"nodes\": [0]}],\n"
    "\"nodes\": [{\"children\": [1], \"scale\": [2, 3, 1]}, {\"mesh\": 0, \"translation\": [1, 1, 4], \"skin\": 0}],\n"
    "\"skins\": [{\"joints\": [0], \"inverseBindMatrices\": 4}],\n"
    "\"meshes\": [{\"primitives\": [{\"attributes\": {\"POSITION\": 1, \"TEXCOORD_0\": 2}, \"indices\": 0,\n"
    " \"material\": 0, \"mode\": 4}]}],\n"
    "\"materials\": [{\"alphaMode\": \"MASK\", \"alphaCutoff\": 0.4, \"doubleSided\": true,\n"
    " \"pbrMetallicRoughness\": {\"baseColorFactor\": [1, 0.25, 1, 0.9], \"baseColorTexture\": {\"index\": 0}}}],\n"
    "\"textures\": [{\"source\": 0, \"sampler\": 0}], \"samplers\": [{\"wrapS\": 33071, \"wrapT\": 33648}],\n"
    "\"images\": [{\"uri\": \"data:image/png;base64,"
    "iVBORw0KGgoAAAANSUhEUgAAAAIAAAACCAYAAABytg0kAAAAF0lEQVR42mP4DwRcInIMDP8ZGBqAhA0ATkEG81R0O9YAAAAASUVORK5CYII="
    "\"}],\n"
    "\"accessors\": [{\"bufferView\": 0, \"componentType\": 5123, \"count\": 3, \"type\": \"SCALAR\"},\n"
    " {\"bufferView\": 1, \"componentType\": 5126, \"count\": 3, \"type\": \"VEC3\", \"min\": [0, 0, 0], \"max\": [1, "
    "1, 0]},\n"
    " {\"bufferView\": 1, \"componentType\": 5126, \"count\": 3, \"type\": \"VEC2\"},\n"
    " {\"bufferView\": 0, \"componentType\": 5121, \"count\": 3, \"type\": \"SCALAR\"},\n"
    " {\"bufferView\": 1, \"componentType\": 5126, \"count\": 1, \"type\": \"MAT4\"}],\n"
    "\"bufferViews\": [{\"buffer\": 0, \"byteOffset\": 0, \"byteLength\": 8},\n"
    " {\"buffer\": 0, \"byteOffset\": 8, \"byteLength\": 64}],\n"
    "\"buffers\": [{\"byteLength\": 72, \"uri\": \"data:application/octet-stream;base64,"
    "AAABAAIAAAAAAAAAAAAAAAAAAAAAAIA/AAAAAAAAAAAAAAAAAACAPwAAAAAAAIA/AAAAAAAAAAAAAAAAAAAAAAAAgD8AAAAA\"}]}";

/* The first byte says how the rest is stored. */
enum { TEXT = 't', BINARY = 'b' };

/* What the text's buffer holds in base64, as a binary file's own: indices, then positions, then what else is read. */
typedef struct buffer {
  uint16_t indices[4];
  float positions[9], uvs[7];
} buffer;

static uint8_t *put(uint8_t *to, const void *from, size_t size) {
  memcpy(to, from, size);
  return to + size;
}

/* The document without its buffer's data, and that in a chunk of its own. */
static size_t make_binary(uint8_t *out) {
  static const buffer data = {{0, 1, 2, 0}, {0, 0, 0, 1, 0, 0, 0, 1, 0}, {1, 0, 0, 0, 0, 1, 0}};
  static const char end[] = "}]}    ";
  const char *uri = strstr(document, ", \"uri\": \"data:application");
  const uint32_t kept = (uint32_t)(uri - document), text = (kept + 3 + 3) / 4 * 4;
  const uint32_t header[5] = {0x46546c67, 2, 28 + text + sizeof data, text, 0x4e4f534a},
                 chunk[2] = {sizeof data, 0x004e4942};
  uint8_t *at = out;
  *at++ = BINARY;
  at = put(at, header, sizeof header);
  at = put(at, document, kept);
  at = put(at, end, text - kept);
  at = put(at, chunk, sizeof chunk);
  at = put(at, &data, sizeof data);
  return (size_t)(at - out);
}

uint32_t input_seeds(input_seed out[INPUT_SEEDS]) {
  static uint8_t text[sizeof document], binary[sizeof document + 256];
  text[0] = TEXT;
  memcpy(text + 1, document, sizeof document - 1);
  out[0] = (input_seed){text, sizeof document};
  out[1] = (input_seed){binary, make_binary(binary)};
  return 2;
}

static void give_to_csm(const scene *s) {
  const csm_create_info info = {.struct_size = sizeof info, .version = CSM_VERSION, .backend = "null"};
  csm_context *context;
  assets assets = {0};
  if (csm_create(&info, &context))
    abort();
  assets_upload(&assets, context, s);
  assets_free(&assets);
  csm_destroy(context);
}

/* Rays through the scene's own camera. */
static void cast_rays(scene *s) {
  enum { SIDE = 8 };
  camera from;
  truth_surface surfaces[SIDE * SIDE];
  uint32_t triangles[SIDE * SIDE];
  truth *caster = truth_create(s, true);
  const truth_view view = {.camera = &from, .width = SIDE, .height = SIDE, .surfaces = surfaces};
  camera_from_pose(&from, &s->camera, 1.0);
  if (truth_find(caster, &from, SIDE, SIDE, triangles) == 0)
    truth_view_fill(caster, &view, triangles);
  truth_destroy(caster);
}

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size) {
  scene s;
  double minimum[3], maximum[3];
  if (size == 0)
    return 0;
  input_quiet();
  const char *path = input_file(data + 1, size - 1, data[0] == BINARY ? ".glb" : ".gltf");
  if (scene_load(&s, path) == 0) {
    scene_bounds(&s, minimum, maximum);
    if (camera_pose_check(&s.camera) == NULL && scene_triangles(&s) < 100000)
      cast_rays(&s);
    give_to_csm(&s);
  }
  scene_free(&s);
  return 0;
}
