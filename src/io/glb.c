#include "io/glb.h"

#include "io/atomic_file.h"
#include "io/json_text.h"

#include <errno.h>
#include <limits.h>
#include <string.h>
#include <sys/stat.h>

/* "glTF", "JSON" and "BIN" with a zero, as little-endian numbers */
enum { GLB_MAGIC = 0x46546c67, CHUNK_JSON = 0x4e4f534a, CHUNK_BIN = 0x004e4942 };
enum { HEADER_BYTES = 12, CHUNK_HEADER_BYTES = 8 };

static size_t padding(size_t bytes, size_t alignment)
{
    return (alignment - bytes % alignment) % alignment;
}

void hpr_glb_builder_init(hpr_context *ctx, hpr_glb_builder *builder)
{
    *builder = (hpr_glb_builder){.context = ctx, .ok = true, .root = cJSON_CreateObject()};
    builder->ok = builder->root != NULL;
}

void hpr_glb_builder_fini(hpr_glb_builder *builder)
{
    cJSON_Delete(builder->root);
    hpr_release(builder->context, builder->segment);
    *builder = (hpr_glb_builder){0};
}

hpr_status hpr_glb_add_view(hpr_glb_builder *builder, const void *data, size_t bytes, int target,
                            size_t *index)
{
    hpr_status status = hpr_grow(builder->context, &builder->segment, &builder->segment_capacity,
                                 builder->segment_count + 1, sizeof *builder->segment);
    if (status != HPR_OK)
        return status;
    size_t offset = builder->bin_bytes + padding(builder->bin_bytes, 8);
    builder->segment[builder->segment_count] = (hpr_glb_segment){data, offset, bytes};
    *index = builder->segment_count++;
    builder->bin_bytes = offset + bytes;
    bool *ok = &builder->ok;
    if (!builder->views)
        builder->views = hpr_json_array(builder->root, "bufferViews", ok);
    cJSON *view = hpr_json_object(builder->views, NULL, ok);
    hpr_json_number(view, "buffer", 0, ok);
    hpr_json_number(view, "byteOffset", (double)offset, ok);
    hpr_json_number(view, "byteLength", (double)bytes, ok);
    if (target != HPR_GLB_NO_TARGET)
        hpr_json_number(view, "target", target, ok);
    return HPR_OK;
}

static hpr_status write_word(hpr_atomic_file *file, size_t value)
{
    unsigned char word[4];
    for (int i = 0; i < 4; i++)
        word[i] = (unsigned char)(value >> (8 * i));
    return hpr_atomic_write(file, word, sizeof word);
}

static hpr_status write_padding(hpr_atomic_file *file, char what, size_t bytes)
{
    char filler[8];
    memset(filler, what, sizeof filler);
    return hpr_atomic_write(file, filler, bytes);
}

static hpr_status write_binary(const hpr_glb_builder *builder, hpr_atomic_file *file)
{
    size_t written = 0;
    hpr_status status = HPR_OK;
    for (size_t i = 0; status == HPR_OK && i < builder->segment_count; i++) {
        const hpr_glb_segment *segment = builder->segment + i;
        status = write_padding(file, 0, segment->offset - written);
        if (status == HPR_OK)
            status = hpr_atomic_write(file, segment->data, segment->bytes);
        written = segment->offset + segment->bytes;
    }
    return status == HPR_OK ? write_padding(file, 0, padding(written, 4)) : status;
}

static hpr_status write_chunks(const hpr_glb_builder *builder, hpr_atomic_file *file, const char *json)
{
    size_t json_bytes = strlen(json), bin_bytes = builder->bin_bytes + padding(builder->bin_bytes, 4);
    /* so many spaces that float64 data lie on multiples of 8 in the file, too */
    size_t spaces = padding(HEADER_BYTES + 2 * CHUNK_HEADER_BYTES + json_bytes, 8);
    size_t total = HEADER_BYTES + CHUNK_HEADER_BYTES + json_bytes + spaces;
    if (builder->bin_bytes)
        total += CHUNK_HEADER_BYTES + bin_bytes;
    if (total > UINT32_MAX)
        return hpr_fail(builder->context, HPR_ERR_UNSUPPORTED,
                        "cannot write '%s': %zu bytes are more than the 4 GB that a .glb can hold",
                        file->path, total);
    hpr_status status = HPR_OK;
    const size_t head[] = {GLB_MAGIC, 2, total, json_bytes + spaces, CHUNK_JSON};
    for (size_t i = 0; status == HPR_OK && i < sizeof head / sizeof *head; i++)
        status = write_word(file, head[i]);
    if (status == HPR_OK)
        status = hpr_atomic_write(file, json, json_bytes);
    if (status == HPR_OK)
        status = write_padding(file, ' ', spaces);
    if (status != HPR_OK || !builder->bin_bytes)
        return status;
    status = write_word(file, bin_bytes);
    if (status == HPR_OK)
        status = write_word(file, CHUNK_BIN);
    return status == HPR_OK ? write_binary(builder, file) : status;
}

hpr_status hpr_glb_write(hpr_glb_builder *builder, const char *path)
{
    if (builder->bin_bytes) {
        cJSON *buffers = hpr_json_array(builder->root, "buffers", &builder->ok);
        cJSON *buffer = hpr_json_object(buffers, NULL, &builder->ok);
        hpr_json_number(buffer, "byteLength", (double)builder->bin_bytes, &builder->ok);
    }
    char *json = builder->ok ? cJSON_PrintUnformatted(builder->root) : NULL;
    if (!json)
        return hpr_fail(builder->context, HPR_ERR_MEMORY, "out of memory: the JSON of '%s'", path);
    hpr_atomic_file file;
    hpr_status status = hpr_atomic_open(builder->context, path, &file);
    if (status == HPR_OK)
        status = write_chunks(builder, &file, json);
    if (status == HPR_OK)
        status = hpr_atomic_commit(&file);
    hpr_atomic_abort(&file);
    cJSON_free(json);
    return status;
}

static hpr_status broken(const hpr_glb *glb, const char *what)
{
    return hpr_fail(glb->context, HPR_ERR_FORMAT, "%s: %s", glb->path, what);
}

static hpr_status read_whole(hpr_glb *glb)
{
    FILE *stream = fopen(glb->path, "rbe");
    hpr_status status = HPR_OK;
    struct stat info;
    size_t wanted = 1 << 16, got = 0;
    if (!stream || fstat(fileno(stream), &info) != 0)
        goto fail;
    if (S_ISREG(info.st_mode) && info.st_size > 0)
        wanted = (size_t)info.st_size + 1; /* one more, so that the end is seen at once */
    do {
        if (glb->bytes == glb->capacity) /* a pipe has no size */
            status = hpr_grow(glb->context, &glb->data, &glb->capacity,
                              glb->capacity ? 2 * glb->capacity : wanted, 1);
        if (status == HPR_OK)
            got = fread(glb->data + glb->bytes, 1, glb->capacity - glb->bytes, stream);
        glb->bytes += got;
    } while (status == HPR_OK && got && glb->bytes <= UINT32_MAX);
    if (status == HPR_OK && !ferror(stream)) {
        fclose(stream);
        return HPR_OK;
    }
fail:
    if (status == HPR_OK)
        status = hpr_fail(glb->context, HPR_ERR_IO, "cannot read '%s': %s", glb->path, strerror(errno));
    if (stream)
        fclose(stream);
    return status;
}

static size_t word_at(const hpr_glb *glb, size_t offset)
{
    const unsigned char *b = glb->data + offset;
    return (size_t)b[0] | (size_t)b[1] << 8 | (size_t)b[2] << 16 | (size_t)b[3] << 24;
}

static hpr_status parse_json(hpr_glb *glb, size_t offset, size_t bytes)
{
    /* a copy of its own, closed by zeros, so that no fault of the JSON can lead the parser out of it */
    char *text = NULL;
    hpr_status status = hpr_allocate_into(glb->context, &text, bytes + 16, 1, "a JSON chunk");
    if (status != HPR_OK)
        return status;
    memcpy(text, glb->data + offset, bytes);
    const char *end = NULL;
    glb->root = strlen(text) == bytes ? cJSON_ParseWithOpts(text, &end, 1) : NULL;
    if (!cJSON_IsObject(glb->root))
        status = hpr_fail(glb->context, HPR_ERR_FORMAT, "%s: the JSON chunk is broken at byte %zu", glb->path,
                          end ? (size_t)(end - text) : strlen(text));
    hpr_release(glb->context, text);
    return status;
}

static hpr_status parse_chunks(hpr_glb *glb)
{
    if (glb->bytes < HEADER_BYTES + CHUNK_HEADER_BYTES || word_at(glb, 0) != GLB_MAGIC)
        return broken(glb, "this is no .glb file");
    if (word_at(glb, 4) != 2)
        return hpr_fail(glb->context, HPR_ERR_FORMAT, "%s: version %zu of GLB, not 2", glb->path,
                        word_at(glb, 4));
    if (word_at(glb, 8) != glb->bytes)
        return hpr_fail(glb->context, HPR_ERR_FORMAT, "%s: %zu bytes long, but the header says %zu",
                        glb->path, glb->bytes, word_at(glb, 8));
    size_t offset = HEADER_BYTES;
    for (int chunk = 0; offset < glb->bytes; chunk++) {
        if (glb->bytes - offset < CHUNK_HEADER_BYTES)
            return broken(glb, "a chunk's header is cut off");
        size_t bytes = word_at(glb, offset), type = word_at(glb, offset + 4);
        offset += CHUNK_HEADER_BYTES;
        if (bytes > glb->bytes - offset || bytes % 4)
            return hpr_fail(glb->context, HPR_ERR_FORMAT, "%s: chunk %d has the length %zu", glb->path, chunk,
                            bytes);
        if ((chunk == 0) != (type == CHUNK_JSON) || (chunk != 1 && type == CHUNK_BIN))
            return hpr_fail(glb->context, HPR_ERR_FORMAT, "%s: chunk %d is of type 0x%08zx", glb->path, chunk,
                            type);
        if (type == CHUNK_BIN) {
            glb->bin = glb->data + offset;
            glb->bin_bytes = bytes;
        }
        hpr_status status = type == CHUNK_JSON ? parse_json(glb, offset, bytes) : HPR_OK;
        if (status != HPR_OK)
            return status;
        offset += bytes;
    }
    return HPR_OK;
}

hpr_status hpr_glb_read(hpr_context *ctx, const char *path, hpr_glb *glb)
{
    *glb = (hpr_glb){.context = ctx, .path = hpr_duplicate_text(ctx, path)};
    if (!glb->path)
        return hpr_fail(ctx, HPR_ERR_MEMORY, "out of memory: a file name");
    hpr_status status = read_whole(glb);
    return status == HPR_OK ? parse_chunks(glb) : status;
}

void hpr_glb_fini(hpr_glb *glb)
{
    cJSON_Delete(glb->root);
    hpr_release(glb->context, glb->data);
    hpr_release(glb->context, glb->path);
    *glb = (hpr_glb){0};
}

hpr_status hpr_glb_view(const hpr_glb *glb, size_t index, const unsigned char **data, size_t *bytes)
{
    const cJSON *views = cJSON_GetObjectItemCaseSensitive(glb->root, "bufferViews");
    const cJSON *view = index < INT_MAX ? cJSON_GetArrayItem(views, (int)index) : NULL;
    const cJSON *at = cJSON_GetObjectItemCaseSensitive(view, "byteOffset");
    size_t buffer, offset = 0, length;
    if (!cJSON_IsArray(views) || !cJSON_IsObject(view) ||
        !hpr_json_read_size(cJSON_GetObjectItemCaseSensitive(view, "buffer"), 0, &buffer) ||
        (at && !hpr_json_read_size(at, UINT32_MAX, &offset)) ||
        !hpr_json_read_size(cJSON_GetObjectItemCaseSensitive(view, "byteLength"), UINT32_MAX, &length))
        return hpr_fail(glb->context, HPR_ERR_FORMAT, "%s: buffer view %zu is missing or broken", glb->path,
                        index);
    if (!glb->bin || offset > glb->bin_bytes || length > glb->bin_bytes - offset)
        return hpr_fail(glb->context, HPR_ERR_FORMAT,
                        "%s: buffer view %zu (%zu bytes at %zu) leaves the binary chunk of %zu bytes",
                        glb->path, index, length, offset, glb->bin_bytes);
    *data = glb->bin + offset;
    *bytes = length;
    return HPR_OK;
}
