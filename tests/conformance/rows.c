#include "rows.h"

#include "support.h"

#include <string.h>

void misuse_apply(const misuse *row, void *target) {
  memcpy((char *)target + row->offset, &row->value, row->size);
}

void misuse_expect(const misuse *row, csm_result result, const char *text) {
  if (result != row->expected)
    fail_msg("%s: %s (%s), not %s", row->what, csm_result_name(result), text, csm_result_name(row->expected));
  if (result && (!row->words || !strstr(text, row->words)))
    fail_msg("%s: \"%s\" does not say \"%s\"", row->what, text, row->words ? row->words : "");
}
