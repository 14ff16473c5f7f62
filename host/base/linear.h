/* base/linear.h: vectors and matrices in doubles. Matrices are column-major: element [column * 4 + row]. */
#ifndef HOST_LINEAR_H
#define HOST_LINEAR_H

#include <stdbool.h>
#include <stdint.h>

void vec_subtract(double out[3], const double a[3], const double b[3]);
void vec_cross(double out[3], const double a[3], const double b[3]); /* out may not alias */
double vec_dot(const double a[3], const double b[3]);
double vec_length(const double a[3]);
/* False, and left as it is, if the length is zero or not finite. */
bool vec_normalize(double v[3]);

void mat_identity(double out[16]);
void mat_multiply(double out[16], const double a[16], const double b[16]); /* out may not alias */
bool mat_invert(double out[16], const double m[16]);                       /* false: singular; out may not alias */
/* m times (v, w), all four components */
void mat_transform(double out[4], const double m[16], const double v[3], double w);
/* Translation times a turn about the y axis (radians) times a scale along each axis. */
void mat_place(double out[16], const double position[3], double turn, const double scale[3]);
/* Of the upper left 3x3. */
double mat_determinant3(const double m[16]);

bool all_finite(const double *values, uint32_t count);

#endif
