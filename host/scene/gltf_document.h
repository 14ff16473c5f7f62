/*
 * scene/gltf_document.h: the JSON of a glTF file, read beside Assimp. Assimp drops without a word what it does not
 * understand, misleads where a file ends early, and trusts what a file names.
 */
#ifndef HOST_GLTF_DOCUMENT_H
#define HOST_GLTF_DOCUMENT_H

#include <jansson.h>
#include <stdint.h>

/*
 * The document of a .gltf or .glb file that is whole, whose nodes are a tree, that names files beside it and below it
 * alone, and needs nothing that is not read here; NULL after a message.
 */
json_t *gltf_document_load(const char *path);

/* Triangles that the meshes of its scene are made of, each mesh once. The document's references must be sound. */
uint64_t gltf_document_triangles(const json_t *document);

#endif
