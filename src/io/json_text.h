/*
 * Writing JSON with cJSON: numbers that read back bit for bit in any locale, text that is always valid UTF-8,
 * and one flag for "out of memory" instead of a check at every line. A NULL parent only clears the flag; a
 * NULL key appends to an array.
 */
#ifndef HPR_IO_JSON_TEXT_H
#define HPR_IO_JSON_TEXT_H

#include <cjson/cJSON.h>
#include <stdbool.h>

enum { HPR_NUMBER_BYTES = 32 };

/* %.17g with a point, whatever the locale; "nan", "inf" and "-inf". Returns `text`. */
const char *hpr_number_text(double value, char text[HPR_NUMBER_BYTES]);

cJSON *hpr_json_object(cJSON *parent, const char *key, bool *ok);
cJSON *hpr_json_array(cJSON *parent, const char *key, bool *ok);

/* A value that is not finite becomes null. */
void hpr_json_number(cJSON *parent, const char *key, double value, bool *ok);
/* The same, but "NaN", "Infinity" and "-Infinity" (as text) survive. */
void hpr_json_exact(cJSON *parent, const char *key, double value, bool *ok);
void hpr_json_bool(cJSON *parent, const char *key, bool value, bool *ok);
void hpr_json_null(cJSON *parent, const char *key, bool *ok);

/* Bytes that are not UTF-8 become U+FFFD. NULL counts as "". */
void hpr_json_text(cJSON *parent, const char *key, const char *text, bool *ok);

/* What hpr_json_exact wrote; false if `item` is NULL or neither a number nor one of the three texts. */
bool hpr_json_read_exact(const cJSON *item, double *value);

/* A whole number from 0 to `most` (at most 2^53); false otherwise. */
bool hpr_json_read_size(const cJSON *item, double most, size_t *value);

#endif
