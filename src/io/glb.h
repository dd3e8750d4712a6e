/*
 * The GLB container of glTF 2.0 (section 4.4): a JSON chunk and one binary chunk cut into buffer views. The
 * builder borrows its data until it is written; the parser trusts nothing.
 */
#ifndef HPR_IO_GLB_H
#define HPR_IO_GLB_H

#include "base/context.h"

#include <cjson/cJSON.h>

enum { HPR_GLB_NO_TARGET = 0, HPR_GLB_VERTICES = 34962, HPR_GLB_INDICES = 34963 };

typedef struct hpr_glb_segment {
    const void *data;
    size_t offset, bytes; /* in the binary chunk; offset is a multiple of 8 */
} hpr_glb_segment;

typedef struct hpr_glb_builder {
    hpr_context *context;
    cJSON *root;  /* the glTF; the caller adds what it needs, but not "buffers" */
    cJSON *views; /* root.bufferViews */
    bool ok;      /* false once cJSON ran out of memory: hpr_glb_write reports it */
    size_t bin_bytes;
    size_t segment_count, segment_capacity;
    hpr_glb_segment *segment;
} hpr_glb_builder;

void hpr_glb_builder_init(hpr_context *ctx, hpr_glb_builder *builder);
void hpr_glb_builder_fini(hpr_glb_builder *builder);

/* Adds a buffer view of `bytes` > 0 bytes, which must stay until the file is written. Errors:
 * HPR_ERR_MEMORY. */
hpr_status hpr_glb_add_view(hpr_glb_builder *builder, const void *data, size_t bytes, int target,
                            size_t *index);

/* Writes the file, through a temporary one. The same builder gives the same bytes. Errors: HPR_ERR_IO,
 * HPR_ERR_MEMORY, HPR_ERR_INTERRUPTED, HPR_ERR_UNSUPPORTED (more than the 4 GB that a .glb can hold). */
hpr_status hpr_glb_write(hpr_glb_builder *builder, const char *path);

typedef struct hpr_glb {
    hpr_context *context;
    char *path;
    unsigned char *data; /* the whole file */
    size_t bytes, capacity;
    cJSON *root;
    const unsigned char *bin; /* within data, NULL if there is no binary chunk */
    size_t bin_bytes;
} hpr_glb;

/* Reads a file and takes it apart. Fini it whether this fails or not. Errors: HPR_ERR_IO, HPR_ERR_FORMAT,
 * HPR_ERR_MEMORY. */
hpr_status hpr_glb_read(hpr_context *ctx, const char *path, hpr_glb *glb);
void hpr_glb_fini(hpr_glb *glb);

/* Bytes of a buffer view; valid as long as the file. Errors: HPR_ERR_FORMAT. */
hpr_status hpr_glb_view(const hpr_glb *glb, size_t index, const unsigned char **data, size_t *bytes);

#endif
