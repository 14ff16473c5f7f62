/* scene_gltf.c: glTF files, through Assimp. */
#include "base/host.h"
#include "base/image.h"
#include "base/linear.h"
#include "scene/gltf_document.h"
#include "scene/scene.h"
#include <assimp/GltfMaterial.h>
#include <assimp/cimport.h>
#include <assimp/material.h>
#include <assimp/postprocess.h>
#include <assimp/scene.h>
#include <inttypes.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

typedef struct loader {
  scene *scene;
  const struct aiScene *file;
  const char *path;
  uint32_t first_material;
  uint32_t *meshes; /* ours for each of the file's; UINT32_MAX: it has no triangles */
} loader;

/* Assimp calls an embedded texture "*" and its number. */
static const struct aiTexture *embedded_texture(const struct aiScene *file, const char *name) {
  if (name[0] != '*')
    return NULL;
  const unsigned long index = strtoul(name + 1, NULL, 10);
  return index < file->mNumTextures ? file->mTextures[index] : NULL;
}

/* A texture's file: embedded (*owned is NULL), or read from beside the scene. NULL: it cannot be read. */
static const void *texture_file(const loader *l, const char *name, size_t *size, uint8_t **owned) {
  const struct aiTexture *texture = embedded_texture(l->file, name);
  char path[4096];
  const char *slash = strrchr(l->path, '/');
  const int folder = slash ? (int)(slash - l->path + 1) : 0;
  *owned = NULL;
  *size = texture ? texture->mWidth : 0;
  if (texture)
    return texture->mHeight == 0 ? texture->pcData : NULL;
  if ((size_t)snprintf(path, sizeof path, "%.*s%s", folder, l->path, name) < sizeof path)
    *owned = (uint8_t *)host_read_file(path, size);
  return *owned;
}

static scene_wrap wrap_mode(enum aiTextureMapMode mode) {
  if (mode == aiTextureMapMode_Mirror)
    return SCENE_WRAP_MIRROR;
  return mode == aiTextureMapMode_Clamp ? SCENE_WRAP_CLAMP : SCENE_WRAP_REPEAT;
}

static double alpha_factor(const struct aiMaterial *from) {
  struct aiColor4D factor;
  return aiGetMaterialColor(from, AI_MATKEY_BASE_COLOR, &factor) == aiReturn_SUCCESS ? factor.a : 1.0;
}

/* glTF's cutoff is 0.5 where the file has none; what it would blend is cut there too. */
static double alpha_cutoff(const struct aiMaterial *from) {
  ai_real cutoff = 0.5f;
  unsigned count = 1;
  if (aiGetMaterialFloatArray(from, AI_MATKEY_GLTF_ALPHACUTOFF, &cutoff, &count) != aiReturn_SUCCESS)
    return 0.5;
  return cutoff;
}

/* Where no texel can make up for the factor, nothing is left of the surface. */
static void set_cutoff(scene_alpha_mask *alpha_mask, double cutoff, double factor) {
  const bool empty = cutoff > factor;
  if (empty && alpha_mask->alpha)
    memset(alpha_mask->alpha, 0, (size_t)alpha_mask->width * alpha_mask->height);
  alpha_mask->cutoff = empty ? 1.0 : cutoff > 0.0 ? cutoff / factor : 0.0;
}

/* The base colour's texture: its mean colour tints the material, its alpha cuts out what is alpha-tested. */
static void read_texture(const loader *l, scene_material *material, const struct aiMaterial *from) {
  struct aiString name;
  enum aiTextureMapMode modes[2] = {aiTextureMapMode_Wrap, aiTextureMapMode_Wrap};
  if (aiGetMaterialTexture(from, aiTextureType_DIFFUSE, 0, &name, NULL, NULL, NULL, NULL, modes, NULL) !=
      aiReturn_SUCCESS)
    return;
  size_t size;
  uint8_t *owned;
  float mean[3];
  const void *data = texture_file(l, name.data, &size, &owned);
  if (data && image_mean_of_png(data, size, mean) == 0)
    for (int i = 0; i < 3; i++)
      material->color[i] *= mean[i];
  scene_alpha_mask *alpha_mask = &material->alpha_mask;
  if (data && material->alpha_tested)
    alpha_mask->alpha = image_alpha_of_png(data, size, &alpha_mask->width, &alpha_mask->height);
  alpha_mask->wrap[0] = wrap_mode(modes[0]);
  alpha_mask->wrap[1] = wrap_mode(modes[1]);
  set_cutoff(alpha_mask, alpha_cutoff(from), alpha_factor(from));
  free(owned);
}

/* A file without materials would be white, and what reflects all light drowns shadows in pictures. */
static const float brightest = 0.6f;

static void add_material(const loader *l, const struct aiMaterial *from) {
  scene_material material = {.color = {1, 1, 1}};
  struct aiString text;
  struct aiColor4D factor;
  int two_sided = 0;
  if (aiGetMaterialString(from, AI_MATKEY_NAME, &text) == aiReturn_SUCCESS)
    snprintf(material.name, sizeof material.name, "%.63s", text.data);
  if (aiGetMaterialColor(from, AI_MATKEY_COLOR_DIFFUSE, &factor) == aiReturn_SUCCESS) {
    material.color[0] = factor.r;
    material.color[1] = factor.g;
    material.color[2] = factor.b;
  }
  if (aiGetMaterialIntegerArray(from, AI_MATKEY_TWOSIDED, &two_sided, NULL) == aiReturn_SUCCESS)
    material.two_sided = two_sided != 0;
  if (aiGetMaterialString(from, AI_MATKEY_GLTF_ALPHAMODE, &text) == aiReturn_SUCCESS)
    material.alpha_tested = strcmp(text.data, "OPAQUE") != 0;
  read_texture(l, &material, from);
  for (int i = 0; i < 3; i++)
    material.color[i] = fminf(material.color[i], brightest);
  scene_add_material(l->scene, &material);
}

static void copy_triangles(scene_mesh *to, const struct aiMesh *from) {
  uint32_t *indices = host_allocate((size_t)from->mNumFaces * 3, sizeof *indices);
  for (uint32_t f = 0; f < from->mNumFaces; f++)
    if (from->mFaces[f].mNumIndices == 3) {
      memcpy(indices + to->index_count, from->mFaces[f].mIndices, 3 * sizeof *indices);
      to->index_count += 3;
    }
  to->index_size = to->vertex_count <= 65535 ? 2 : 4;
  to->indices = indices;
  if (to->index_size == 2) {
    uint16_t *narrow = host_allocate(to->index_count, sizeof *narrow);
    for (uint32_t i = 0; i < to->index_count; i++)
      narrow[i] = (uint16_t)indices[i];
    to->indices = narrow;
    free(indices);
  }
}

static float *copy_vectors(const struct aiVector3D *from, uint32_t count) {
  float *to = host_allocate((size_t)count * 3, sizeof *to);
  for (uint32_t v = 0; v < count; v++) {
    to[3 * (size_t)v] = from[v].x;
    to[3 * (size_t)v + 1] = from[v].y;
    to[3 * (size_t)v + 2] = from[v].z;
  }
  return to;
}

/* Assimp counts v from the bottom row. */
static float *copy_uvs(const struct aiVector3D *from, uint32_t count) {
  float *to = host_allocate((size_t)count * 2, sizeof *to);
  for (uint32_t v = 0; v < count; v++) {
    to[2 * (size_t)v] = from[v].x;
    to[2 * (size_t)v + 1] = 1.0f - from[v].y;
  }
  return to;
}

static int check_mesh(const loader *l, const struct aiMesh *mesh) {
  if (mesh->mMaterialIndex >= l->file->mNumMaterials)
    return host_fail(HOST_BAD_INPUT, "'%s': mesh '%s' has a material out of range", l->path, mesh->mName.data);
  for (uint32_t v = 0; v < mesh->mNumVertices; v++)
    if (!isfinite(mesh->mVertices[v].x) || !isfinite(mesh->mVertices[v].y) || !isfinite(mesh->mVertices[v].z))
      return host_fail(HOST_BAD_INPUT, "'%s': mesh '%s' has a position that is not finite", l->path, mesh->mName.data);
  for (uint32_t f = 0; f < mesh->mNumFaces; f++)
    for (uint32_t i = 0; i < mesh->mFaces[f].mNumIndices; i++)
      if (mesh->mFaces[f].mIndices[i] >= mesh->mNumVertices)
        return host_fail(HOST_BAD_INPUT, "'%s': mesh '%s' has an index out of range", l->path, mesh->mName.data);
  return 0;
}

static int add_mesh(loader *l, uint32_t index) {
  const struct aiMesh *from = l->file->mMeshes[index];
  l->meshes[index] = UINT32_MAX;
  if (!(from->mPrimitiveTypes & aiPrimitiveType_TRIANGLE) || !from->mVertices || from->mNumFaces == 0)
    return 0;
  const int code = check_mesh(l, from);
  if (code)
    return code;
  scene_mesh mesh = {.material = l->first_material + from->mMaterialIndex, .vertex_count = from->mNumVertices};
  snprintf(mesh.name, sizeof mesh.name, "%.63s", from->mName.data);
  mesh.positions = copy_vectors(from->mVertices, from->mNumVertices);
  if (from->mNormals)
    mesh.normals = copy_vectors(from->mNormals, from->mNumVertices);
  if (from->mTextureCoords[0])
    mesh.uvs = copy_uvs(from->mTextureCoords[0], from->mNumVertices);
  copy_triangles(&mesh, from);
  l->meshes[index] = scene_add_mesh(l->scene, &mesh);
  return 0;
}

/* Assimp's matrices are row-major. */
static void node_transform(double out[16], const struct aiMatrix4x4 *m) {
  const double columns[16] = {m->a1, m->b1, m->c1, m->d1, m->a2, m->b2, m->c2, m->d2,
                              m->a3, m->b3, m->c3, m->d3, m->a4, m->b4, m->c4, m->d4};
  memcpy(out, columns, sizeof columns);
}

/* A node that is scaled to nothing along an axis shows nothing, and is left out. */
static bool is_flat(const double transform[16]) {
  double scale = 1.0;
  for (int column = 0; column < 3; column++)
    scale *= vec_length(transform + 4 * column);
  return !(fabs(mat_determinant3(transform)) > 1e-12 * scale) || scale == 0.0;
}

static void add_node(const loader *l, const struct aiNode *node, const double parent[16]) {
  double local[16], world[16];
  node_transform(local, &node->mTransformation);
  mat_multiply(world, parent, local);
  for (uint32_t i = 0; i < node->mNumMeshes; i++) {
    const uint32_t mesh = l->meshes[node->mMeshes[i]];
    if (mesh != UINT32_MAX && !is_flat(world))
      scene_add_instance(l->scene, mesh, world);
  }
  for (uint32_t i = 0; i < node->mNumChildren; i++)
    add_node(l, node->mChildren[i], world);
}

static int add_contents(loader *l, const double root[16]) {
  const size_t instances = l->scene->instance_count;
  l->first_material = (uint32_t)l->scene->material_count;
  for (uint32_t i = 0; i < l->file->mNumMaterials; i++)
    add_material(l, l->file->mMaterials[i]);
  for (uint32_t i = 0; i < l->file->mNumMeshes; i++) {
    const int code = add_mesh(l, i);
    if (code)
      return code;
  }
  add_node(l, l->file->mRootNode, root);
  if (l->scene->instance_count == instances)
    return host_fail(HOST_BAD_INPUT, "'%s' draws no triangles", l->path);
  return 0;
}

static uint64_t file_triangles(const struct aiScene *file) {
  uint64_t count = 0;
  for (uint32_t m = 0; m < file->mNumMeshes; m++)
    for (uint32_t f = 0; f < file->mMeshes[m]->mNumFaces; f++)
      count += file->mMeshes[m]->mFaces[f].mNumIndices == 3;
  return count;
}

/* Assimp leaves out triangles whose indices are out of range. */
static int check_triangles(const struct aiScene *file, const json_t *document, const char *path) {
  const uint64_t wanted = gltf_document_triangles(document), found = file_triangles(file);
  return found >= wanted
             ? 0
             : host_fail(HOST_BAD_INPUT, "'%s': %" PRIu64 " of %" PRIu64 " triangles have an index out of range", path,
                         wanted - found, wanted);
}

int scene_add_gltf(scene *s, const char *path, const double root[16]) {
  json_t *document = gltf_document_load(path);
  if (!document)
    return HOST_BAD_INPUT;
  int code = 0;
  const struct aiScene *file = aiImportFile(path, aiProcess_Triangulate | aiProcess_JoinIdenticalVertices |
                                                      aiProcess_SortByPType | aiProcess_ValidateDataStructure);
  if (file && file->mNumMeshes == 0) {
    code = host_fail(HOST_BAD_INPUT, "the scene '%s' is empty: it draws no triangles", path);
  } else if (!file || !file->mRootNode || (file->mFlags & AI_SCENE_FLAGS_INCOMPLETE)) {
    const char *reason = aiGetErrorString();
    code = host_fail(HOST_BAD_INPUT, "cannot read the scene '%s': %s", path,
                     reason && *reason ? reason : "it is truncated or broken");
  } else {
    loader l = {.scene = s, .file = file, .path = path, .meshes = host_allocate(file->mNumMeshes, sizeof(uint32_t))};
    code = check_triangles(file, document, path);
    if (code == 0)
      code = add_contents(&l, root);
    free(l.meshes);
  }
  json_decref(document);
  if (file)
    aiReleaseImport(file);
  return code;
}
