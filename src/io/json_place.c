#include "io/json_place.h"

#include <stdbool.h>
#include <string.h>

size_t hpr_json_line_at(const char *text, size_t offset)
{
    size_t line = 1;
    for (size_t i = 0; i < offset && text[i]; i++)
        line += text[i] == '\n';
    return line;
}

/* The next character that is none of blanks, commas and colons: where a value, a key or an end stands. */
static const char *skip_between(const char *at)
{
    return at + strspn(at, " \t\r\n,:");
}

static const char *skip_string(const char *at)
{
    for (at++; *at && *at != '"'; at++) {
        if (*at == '\\' && at[1])
            at++;
    }
    return *at ? at + 1 : at;
}

/* Walks text and tree together: the text is the one that the tree came from, so it is valid. Returns what
 * follows the value; *found becomes where `wanted` begins. */
static const char *walk(const char *at, const cJSON *value, const cJSON *wanted, const char **found)
{
    at = skip_between(at);
    if (value == wanted)
        *found = at;
    if (*found)
        return at;
    if (cJSON_IsObject(value) || cJSON_IsArray(value)) {
        at++;
        for (const cJSON *child = value->child; child && !*found; child = child->next) {
            at = skip_between(at);
            if (cJSON_IsObject(value))
                at = skip_string(at);
            at = walk(at, child, wanted, found);
        }
        at = skip_between(at);
        return *at ? at + 1 : at;
    }
    return *at == '"' ? skip_string(at) : at + strcspn(at, " \t\r\n,:]}");
}

size_t hpr_json_line(const char *text, const cJSON *root, const cJSON *item)
{
    const char *found = NULL;
    walk(text, root, item, &found);
    return found ? hpr_json_line_at(text, (size_t)(found - text)) : 0;
}
