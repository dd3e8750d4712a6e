/* Where in its text a JSON value stands, for messages; cJSON does not keep that. */
#ifndef HPR_IO_JSON_PLACE_H
#define HPR_IO_JSON_PLACE_H

#include <cjson/cJSON.h>
#include <stddef.h>

/* The line (from 1) of the character `offset` of a text. */
size_t hpr_json_line_at(const char *text, size_t offset);

/* The line where `item` begins, one of the values of the tree `root` that was parsed from `text`; 0 if it is
 * none. */
size_t hpr_json_line(const char *text, const cJSON *root, const cJSON *item);

#endif
