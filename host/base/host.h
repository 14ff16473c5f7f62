/* base/host.h: what every part of csm-host shares: exit codes, messages, memory and time. */
#ifndef HOST_H
#define HOST_H

#include <stddef.h>

enum { HOST_AGREE = 0, HOST_DIFFER = 1, HOST_BAD_INPUT = 2, HOST_NO_DEVICE = 3 };

/* Prints "csm-host: " and the message as one line on stderr; returns the code. */
__attribute__((format(printf, 2, 3))) int host_fail(int code, const char *format, ...);

/* Zeroed memory for count elements; never NULL: it ends the program when there is no more. */
void *host_allocate(size_t count, size_t size);
/* Grows an array to hold at least `needed` elements, doubling *capacity. */
void *host_grow(void *array, size_t *capacity, size_t needed, size_t size);

/* A steady clock. */
double host_now_ms(void);
/* What the calling thread has had of a processor: other programs do not show in it. */
double host_cpu_ms(void);

/* A line of progress on a terminal, overwritten by the next; "" clears it. Silent elsewhere. */
void host_progress(const char *text);

/*
 * A file's bytes with a 0 after them, for the caller to free. NULL, and errno, if it cannot be opened. size may be
 * NULL.
 */
char *host_read_file(const char *path, size_t *size);

/* Makes a folder and those above it. 0, or HOST_BAD_INPUT after a message. */
int host_make_folder(const char *path);

#endif
