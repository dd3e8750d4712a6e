#include "app/names.h"

#include <ctype.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

enum { LIST_BYTES = 512 }; /* of a message, for the names of cameras */

/* Where the last extension begins: at its dot, else at the end. A leading dot is part of the name. */
static size_t stem_length(const char *path)
{
    const char *slash = strrchr(path, '/');
    const char *name = slash ? slash + 1 : path;
    const char *dot = strrchr(name, '.');
    return dot && dot != name ? (size_t)(dot - path) : strlen(path);
}

static char *join(hpr_context *ctx, const char *head, size_t head_length, const char *middle,
                  const char *tail)
{
    size_t middle_length = strlen(middle), tail_length = strlen(tail);
    char *text = hpr_allocate(ctx, head_length + middle_length + tail_length + 1, 1);
    if (!text)
        return NULL;
    memcpy(text, head, head_length);
    memcpy(text + head_length, middle, middle_length);
    memcpy(text + head_length + middle_length, tail, tail_length + 1);
    return text;
}

char *hpr_name_default(hpr_context *ctx, const char *path, const char *tail)
{
    const char *slash = strrchr(path, '/');
    const char *name = slash ? slash + 1 : path;
    return join(ctx, name, stem_length(name), tail, "");
}

char *hpr_name_beside(hpr_context *ctx, const char *path, const char *extension)
{
    return join(ctx, path, stem_length(path), extension, "");
}

char *hpr_name_insert(hpr_context *ctx, const char *path, const char *text)
{
    size_t stem = stem_length(path);
    return join(ctx, path, stem, text, path + stem);
}

typedef struct placeholder {
    bool camera;   /* else frame */
    int width;     /* of frame: least number of digits */
    size_t length; /* characters in the pattern, braces included; 0: none here */
} placeholder;

/* The placeholder that begins at `text`, which points at a brace. A width has one digit: no file name has
 * room for much more. */
static placeholder read_placeholder(const char *text)
{
    const char camera[] = "{camera}", frame[] = "{frame}", padded[] = "{frame:0";
    if (!strncmp(text, camera, strlen(camera)))
        return (placeholder){.camera = true, .length = strlen(camera)};
    if (!strncmp(text, frame, strlen(frame)))
        return (placeholder){.width = 1, .length = strlen(frame)};
    size_t n = strlen(padded);
    if (!strncmp(text, padded, n) && text[n] >= '1' && text[n] <= '9' && text[n + 1] == '}')
        return (placeholder){.width = text[n] - '0', .length = n + 2};
    return (placeholder){0};
}

bool hpr_name_varies(const char *pattern)
{
    for (const char *brace = strchr(pattern, '{'); brace; brace = strchr(brace + 1, '{')) {
        if (read_placeholder(brace).length)
            return true;
    }
    return false;
}

hpr_status hpr_name_check(hpr_context *ctx, const char *pattern)
{
    for (const char *brace = strchr(pattern, '{'); brace; brace = strchr(brace + 1, '{')) {
        if (read_placeholder(brace).length)
            continue;
        size_t length = strcspn(brace, "}");
        if (brace[length] == '}')
            length++;
        return hpr_fail(ctx, HPR_ERR_ARG,
                        "output name '%s': unknown '%.*s'; known are {camera}, {frame} and {frame:04}",
                        pattern, (int)length, brace);
    }
    return HPR_OK;
}

/* Appends to text[*length], or only counts when text is NULL. */
static void append(char *text, size_t *length, const char *piece, size_t piece_length)
{
    if (text)
        memcpy(text + *length, piece, piece_length);
    *length += piece_length;
}

static size_t expand_into(const char *pattern, const char *camera, size_t frame, char *text)
{
    size_t length = 0;
    for (const char *at = pattern; *at;) {
        placeholder found = *at == '{' ? read_placeholder(at) : (placeholder){0};
        if (!found.length) {
            append(text, &length, at++, 1);
            continue;
        }
        if (found.camera) {
            append(text, &length, camera, strlen(camera));
        } else {
            char digits[32];
            int n = snprintf(digits, sizeof digits, "%0*zu", found.width, frame);
            append(text, &length, digits, (size_t)n);
        }
        at += found.length;
    }
    return length;
}

hpr_status hpr_name_expand(hpr_context *ctx, const char *pattern, const char *camera, size_t frame,
                           char **path)
{
    size_t length = expand_into(pattern, camera, frame, NULL);
    hpr_status status = hpr_allocate_into(ctx, path, length + 1, 1, "a file name");
    if (status == HPR_OK)
        expand_into(pattern, camera, frame, *path);
    return status;
}

static bool label_taken(char *const *label, size_t count, const char *text)
{
    for (size_t i = 0; i < count; i++) {
        if (!strcmp(label[i], text))
            return true;
    }
    return false;
}

hpr_status hpr_camera_labels(hpr_context *ctx, size_t count, const char *const *name, char ***label)
{
    hpr_status status = hpr_allocate_into(ctx, label, count, sizeof **label, "camera names");
    for (size_t i = 0; i < count && status == HPR_OK; i++) {
        const char *text = name[i] && name[i][0] ? name[i] : "camera0";
        size_t room = strlen(text) + 24; /* the longest "_%zu" and the end */
        status = hpr_allocate_into(ctx, &(*label)[i], room, 1, "a camera name");
        if (status != HPR_OK)
            break;
        snprintf((*label)[i], room, "%s", text);
        for (char *at = (*label)[i]; *at; at++) {
            if (*at == '/')
                *at = '_';
        }
        size_t stem = strlen(text);
        for (size_t k = 1; label_taken(*label, i, (*label)[i]); k++)
            snprintf((*label)[i] + stem, room - stem, "_%zu", k);
    }
    if (status != HPR_OK)
        hpr_camera_labels_release(ctx, count, label);
    return status;
}

void hpr_camera_labels_release(hpr_context *ctx, size_t count, char ***label)
{
    for (size_t i = 0; *label && i < count; i++)
        hpr_release(ctx, (*label)[i]);
    hpr_release(ctx, *label);
    *label = NULL;
}

hpr_status hpr_camera_find(hpr_context *ctx, size_t count, const char *const *name, char *const *label,
                           const char *wanted, size_t *camera)
{
    for (size_t i = 0; i < count; i++) {
        if (!strcmp(label[i], wanted)) {
            *camera = i;
            return HPR_OK;
        }
    }
    for (size_t i = 0; i < count; i++) {
        if (name[i] && name[i][0] && !strcmp(name[i], wanted)) {
            *camera = i;
            return HPR_OK;
        }
    }
    char *end = NULL;
    unsigned long index = isdigit((unsigned char)wanted[0]) ? strtoul(wanted, &end, 10) : 0;
    if (end && !*end && index < count) {
        *camera = index;
        return HPR_OK;
    }
    char list[LIST_BYTES] = "";
    size_t used = 0;
    for (size_t i = 0; i < count && used < sizeof list; i++) {
        int n = snprintf(list + used, sizeof list - used, "%s%s", i ? ", " : "", label[i]);
        used += (size_t)n;
    }
    return hpr_fail(ctx, HPR_ERR_ARG, "camera '%s' is not in the scene; it has: %s%s (or an index from 0)",
                    wanted, list, used >= sizeof list ? " ..." : "");
}
