#include "io/json_text.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

const char *hpr_number_text(double value, char text[HPR_NUMBER_BYTES])
{
    if (isnan(value))
        return strcpy(text, "nan");
    if (isinf(value))
        return strcpy(text, value > 0 ? "inf" : "-inf");
    char raw[HPR_NUMBER_BYTES];
    snprintf(raw, sizeof raw, "%.17g", value);
    char *out = text;
    for (const char *c = raw; *c; c++) {
        if (strchr("+-0123456789e", *c))
            *out++ = *c;
        else if (out == text || out[-1] != '.') /* the locale's decimal point may take several bytes */
            *out++ = '.';
    }
    *out = '\0';
    return text;
}

/* Takes ownership of `item`. */
static cJSON *put(cJSON *parent, const char *key, cJSON *item, bool *ok)
{
    bool added = parent && item &&
                 (key ? cJSON_AddItemToObject(parent, key, item) : cJSON_AddItemToArray(parent, item));
    if (added)
        return item;
    cJSON_Delete(item);
    *ok = false;
    return NULL;
}

cJSON *hpr_json_object(cJSON *parent, const char *key, bool *ok)
{
    return put(parent, key, cJSON_CreateObject(), ok);
}

cJSON *hpr_json_array(cJSON *parent, const char *key, bool *ok)
{
    return put(parent, key, cJSON_CreateArray(), ok);
}

/* cJSON's own printing rounds to 15 digits where that is "close enough", hence raw text. */
void hpr_json_number(cJSON *parent, const char *key, double value, bool *ok)
{
    char text[HPR_NUMBER_BYTES];
    put(parent, key, isfinite(value) ? cJSON_CreateRaw(hpr_number_text(value, text)) : cJSON_CreateNull(),
        ok);
}

void hpr_json_exact(cJSON *parent, const char *key, double value, bool *ok)
{
    if (isfinite(value))
        hpr_json_number(parent, key, value, ok);
    else
        put(parent, key, cJSON_CreateString(isnan(value) ? "NaN" : value > 0 ? "Infinity" : "-Infinity"), ok);
}

void hpr_json_bool(cJSON *parent, const char *key, bool value, bool *ok)
{
    put(parent, key, cJSON_CreateBool(value), ok);
}

void hpr_json_null(cJSON *parent, const char *key, bool *ok)
{
    put(parent, key, cJSON_CreateNull(), ok);
}

/* Length of the UTF-8 character at `text` (RFC 3629, section 4), 0 if there is none. */
static size_t utf8_length(const unsigned char *text)
{
    unsigned char a = text[0];
    size_t length = a < 0x80 ? 1 : a >= 0xc2 && a < 0xe0 ? 2 : a >= 0xe0 && a < 0xf0 ? 3 : 4;
    if (a >= 0x80 && (a < 0xc2 || a > 0xf4))
        return 0;
    for (size_t i = 1; i < length; i++) {
        if ((text[i] & 0xc0) != 0x80) /* also stops at the end of the text */
            return 0;
    }
    bool overlong = (a == 0xe0 && text[1] < 0xa0) || (a == 0xf0 && text[1] < 0x90);
    bool surrogate = a == 0xed && text[1] > 0x9f, too_high = a == 0xf4 && text[1] > 0x8f;
    return overlong || surrogate || too_high ? 0 : length;
}

void hpr_json_text(cJSON *parent, const char *key, const char *text, bool *ok)
{
    if (!text)
        text = "";
    char *valid = malloc(3 * strlen(text) + 1);
    char *out = valid;
    for (const char *c = text; valid && *c;) {
        size_t length = utf8_length((const unsigned char *)c);
        memcpy(out, length ? c : "\xef\xbf\xbd", length ? length : 3);
        out += length ? length : 3;
        c += length ? length : 1;
    }
    if (valid)
        *out = '\0';
    put(parent, key, valid ? cJSON_CreateString(valid) : NULL, ok);
    free(valid);
}

bool hpr_json_read_exact(const cJSON *item, double *value)
{
    if (cJSON_IsNumber(item) && isfinite(item->valuedouble)) {
        *value = item->valuedouble;
        return true;
    }
    const char *text = cJSON_GetStringValue(item);
    if (!text)
        return false;
    if (!strcmp(text, "NaN"))
        *value = NAN;
    else if (!strcmp(text, "Infinity"))
        *value = INFINITY;
    else if (!strcmp(text, "-Infinity"))
        *value = -INFINITY;
    else
        return false;
    return true;
}

bool hpr_json_read_size(const cJSON *item, double most, size_t *value)
{
    if (!cJSON_IsNumber(item))
        return false;
    double number = item->valuedouble;
    if (!(number >= 0 && number <= fmin(most, 0x1p53)) || number != floor(number))
        return false;
    *value = (size_t)number;
    return true;
}
