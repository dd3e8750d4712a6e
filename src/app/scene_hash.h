/* The content of a scene's files. */
#ifndef HPR_APP_SCENE_HASH_H
#define HPR_APP_SCENE_HASH_H

#include "io/sha256.h"

/* Adds a glTF file (.gltf or .glb) and every file that its buffers and images name, in their order. Errors:
 * HPR_ERR_IO, HPR_ERR_FORMAT (no JSON), HPR_ERR_MEMORY. */
hpr_status hpr_scene_hash_add(hpr_context *ctx, hpr_sha256 *hash, const char *path);

/* All that a file holds; *data, NULL before, is the caller's to release, also after a failure. Errors:
 * HPR_ERR_IO, HPR_ERR_MEMORY. */
hpr_status hpr_scene_file_read(hpr_context *ctx, const char *path, char **data, size_t *bytes);

#endif
