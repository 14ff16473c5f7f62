/* report/page.h: writing a report's files. */
#ifndef HOST_REPORT_PAGE_H
#define HOST_REPORT_PAGE_H

#include <jansson.h>

/* Writes FOLDER/report.html around `data`, or FOLDER/report.json. Both replace what was there only once they are
 * whole. 0, or HOST_BAD_INPUT after a message. */
int report_page_write(const char *folder, const json_t *data);
int report_json_write(const char *folder, const json_t *data);

#endif
