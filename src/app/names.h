/* File names that a job makes: defaults, neighbours, and the placeholders of a picture's name. */
#ifndef HPR_APP_NAMES_H
#define HPR_APP_NAMES_H

#include "base/context.h"

/* The file name without folders and without its last extension, plus `tail`; caller releases. NULL: no
 * memory. "a/room.v2.gltf" + ".exr" -> "room.v2.exr" */
char *hpr_name_default(hpr_context *ctx, const char *path, const char *tail);

/* The path with its last extension replaced by `extension`; caller releases. NULL: no memory. */
char *hpr_name_beside(hpr_context *ctx, const char *path, const char *extension);

/* The path with `text`, such as "_{camera}", put before its last extension; caller releases. NULL: no memory.
 */
char *hpr_name_insert(hpr_context *ctx, const char *path, const char *text);

/* True if the pattern contains a placeholder, so that it can give several pictures several names. */
bool hpr_name_varies(const char *pattern);

/* Errors: HPR_ERR_ARG if something between braces is no placeholder, or a brace is not closed. */
hpr_status hpr_name_check(hpr_context *ctx, const char *pattern);

/* Replaces the placeholders of a checked pattern. The caller releases *path. Errors: HPR_ERR_MEMORY. */
hpr_status hpr_name_expand(hpr_context *ctx, const char *pattern, const char *camera, size_t frame,
                           char **path);

/*
 * The names that stand for cameras in file names. name: [count], entries may be "" or NULL.
 * *label: [count] texts that differ from each other; released by hpr_camera_labels_release.
 * Errors: HPR_ERR_MEMORY.
 */
hpr_status hpr_camera_labels(hpr_context *ctx, size_t count, const char *const *name, char ***label);
void hpr_camera_labels_release(hpr_context *ctx, size_t count, char ***label);

/* Finds the camera called `wanted`: by label, then by name, then by index. Errors: HPR_ERR_ARG; the message
 * lists the labels. */
hpr_status hpr_camera_find(hpr_context *ctx, size_t count, const char *const *name, char *const *label,
                           const char *wanted, size_t *camera);

#endif
