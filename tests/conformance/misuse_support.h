/* misuse_support.h: what may be misused, what a caller can see of it, and rows that misuse it. */
#ifndef MISUSE_SUPPORT_H
#define MISUSE_SUPPORT_H

#include "rows.h"
#include "support.h"

enum { RESOLUTION = 64, SIDE = 16 };

#define COUNT(rows) (sizeof(rows) / sizeof(rows)[0])

/* A context that is quiet about errors, whose maps are drawn, and whose view has no mask yet. */
typedef struct fixture {
  record record;
  csm_context *context;
  csm_cascades *cascades;
  csm_view *view;
  csm_config config;
  support_scene scene;
} fixture;

void setup(fixture *f);
void teardown(fixture *f);

/* Everything that a caller can see of the cascades. */
typedef struct snapshot {
  csm_binding binding;
  unsigned char constants[2048]; /* those that the binding points to, then */
  csm_stats stats;
  float map[RESOLUTION * RESOLUTION];
} snapshot;

void take(const fixture *f, snapshot *out);
/* Asserts that a caller sees what was there. */
void unchanged(const fixture *f, const snapshot *before);

/* Asserts a result, which has a text. */
void expect(const fixture *f, csm_result result, csm_result expected, const char *what);

/* Tries what a struct asks for, of which a row has made one field wrong. */
typedef csm_result (*attempt)(fixture *f, const void *wrong);

typedef struct row_table {
  const misuse *rows;
  size_t count;
  const void *good;
  size_t size; /* of the struct */
} row_table;

void check_rows(fixture *f, const row_table *table, attempt attempt);
/* Every way in which an instance can be wrong. */
void check_instances(fixture *f, const csm_instance *good, attempt attempt);

#endif
