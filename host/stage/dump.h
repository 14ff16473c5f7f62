/* stage/dump.h: everything that a frame was made of, as files that other programs can check. */
#ifndef HOST_DUMP_H
#define HOST_DUMP_H

#include "stage/stage.h"
#include <jansson.h>

/*
 * Writes frame.json (with the metrics, where they are not NULL), scene.ply, depth_K.pfm, camera_depth.pfm and mask.pfm
 * into FOLDER/BACKEND. 0, or HOST_BAD_INPUT after a message.
 */
int dump_frame(const char *folder, const stage *s, const stage_frame *frame, json_t *metrics);

/* World-space triangles of the scene. 0, or HOST_BAD_INPUT after a message. */
int dump_ply(const scene *s, const char *path);
/* `values` have the top row first. 0, or HOST_BAD_INPUT after a message. */
int dump_pfm(const float *values, uint32_t width, uint32_t height, const char *path);

#endif
