/* support.h: what tests of the host's parts share. */
#ifndef TEST_HOST_SUPPORT_H
#define TEST_HOST_SUPPORT_H

#include <stddef.h>
#include <stdint.h>

/* A new file in the current folder; unlink it. */
void make_path(char path[64], const char *ending);
void write_text(const char *path, const char *text);
/* All of it, and a 0 after it, for the caller to free. */
uint8_t *read_bytes(const char *path, size_t *size);

/* A document with one triangle. */
extern const char triangle_gltf[];

/* Fails unless a is b, within a share of b or of 1. */
void close_to(double a, double b, double tolerance);

#endif
