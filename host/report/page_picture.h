/* report/page_picture.h: pictures that are small enough to lie in a page. */
#ifndef HOST_REPORT_PICTURE_H
#define HOST_REPORT_PICTURE_H

#include "base/image.h"

/*
 * Makes a picture at most `width` pixels wide: a whole number of pixels becomes one. With `rank`, one for each pixel,
 * that is the pixel of the highest rank, so that nothing rare is lost. Without, it is the mean in 32 steps of grey, or
 * the first pixel's colour where colours are in the majority.
 */
void report_picture_shrink(image *out, const image *picture, const uint8_t *rank, uint32_t width);

/* A PNG as a data URI, for the caller to free; NULL after a message. With up to 256 colours it gets a palette. */
char *report_picture_uri(const image *picture);

#endif
