#include "app/scene_hash.h"

#include <cjson/cJSON.h>
#include <ctype.h>
#include <errno.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

hpr_status hpr_scene_file_read(hpr_context *ctx, const char *path, char **data, size_t *bytes)
{
    size_t capacity = 0, got = 1;
    FILE *file = fopen(path, "rb");
    *bytes = 0;
    if (!file)
        return hpr_fail(ctx, HPR_ERR_IO, "cannot read '%s': %s", path, strerror(errno));
    hpr_status status = HPR_OK;
    while (status == HPR_OK && got) {
        status = hpr_grow(ctx, data, &capacity, *bytes + 65537, 1);
        got = status == HPR_OK ? fread(*data + *bytes, 1, 65536, file) : 0;
        *bytes += got;
    }
    if (status == HPR_OK && ferror(file))
        status = hpr_fail(ctx, HPR_ERR_IO, "cannot read '%s': %s", path, strerror(errno));
    fclose(file);
    return status;
}

/* The JSON within the file: all of a .gltf, the first chunk of a .glb. */
static cJSON *parse(const char *data, size_t bytes)
{
    const unsigned char *head = (const unsigned char *)data;
    if (bytes < 20 || memcmp(data, "glTF", 4) != 0)
        return cJSON_ParseWithLength(data, bytes);
    size_t length =
        (size_t)head[12] | (size_t)head[13] << 8 | (size_t)head[14] << 16 | (size_t)head[15] << 24;
    return length <= bytes - 20 ? cJSON_ParseWithLength(data + 20, length) : NULL;
}

/* Undoes %20 and the like in place. */
static void decode(char *uri)
{
    char *out = uri;
    for (const char *in = uri; *in;) {
        if (in[0] == '%' && isxdigit((unsigned char)in[1]) && isxdigit((unsigned char)in[2])) {
            const char digits[] = {in[1], in[2], '\0'};
            *out++ = (char)strtol(digits, NULL, 16);
            in += 3;
        } else {
            *out++ = *in++;
        }
    }
    *out = '\0';
}

/* The file that a URI names, beside the scene. What cannot be read is left to who reads the scene. */
static hpr_status add_uri(hpr_context *ctx, hpr_sha256 *hash, const char *path, const char *uri)
{
    const char *slash = strrchr(path, '/');
    size_t folder = slash ? (size_t)(slash - path) + 1 : 0, length = strlen(uri);
    char *file = NULL;
    hpr_status status = hpr_allocate_into(ctx, &file, folder + length + 1, 1, "a file name");
    if (status != HPR_OK)
        return status;
    memcpy(file, path, folder);
    memcpy(file + folder, uri, length + 1);
    decode(file + folder);
    status = hpr_sha256_add_file(ctx, hash, file, NULL);
    hpr_release(ctx, file);
    return status;
}

hpr_status hpr_scene_hash_add(hpr_context *ctx, hpr_sha256 *hash, const char *path)
{
    static const char *const lists[] = {"buffers", "images"};
    char *data = NULL;
    size_t bytes;
    cJSON *root = NULL;
    hpr_status status = hpr_scene_file_read(ctx, path, &data, &bytes);
    if (status == HPR_OK) {
        hpr_sha256_add(hash, data, bytes);
        root = parse(data, bytes);
        if (!root)
            status = hpr_fail(ctx, HPR_ERR_FORMAT, "%s: this is no glTF", path);
    }
    for (int i = 0; i < 2; i++) {
        const cJSON *item;
        cJSON_ArrayForEach(item, cJSON_GetObjectItemCaseSensitive(root, lists[i]))
        {
            const char *uri = cJSON_GetStringValue(cJSON_GetObjectItemCaseSensitive(item, "uri"));
            if (status == HPR_OK && uri && strncmp(uri, "data:", 5) != 0)
                status = add_uri(ctx, hash, path, uri);
        }
    }
    cJSON_Delete(root);
    hpr_release(ctx, data);
    return status;
}
