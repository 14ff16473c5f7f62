/* base/json_file.h: reading a JSON object that an option names. */
#ifndef HOST_JSON_FILE_H
#define HOST_JSON_FILE_H

#include <jansson.h>

/* The object in a file, or NULL after a message that names the option. Keys that appear twice are an error. */
json_t *json_file_load(const char *option, const char *path);

#endif
