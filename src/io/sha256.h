/* SHA-256 (FIPS 180-4), by which files and settings are told apart. */
#ifndef HPR_IO_SHA256_H
#define HPR_IO_SHA256_H

#include "base/context.h"

enum { HPR_SHA256_TEXT = 65 };

typedef struct hpr_sha256 {
    uint32_t state[8];
    uint64_t bytes;
    unsigned char block[64];
} hpr_sha256;

void hpr_sha256_init(hpr_sha256 *hash);
void hpr_sha256_add(hpr_sha256 *hash, const void *data, size_t bytes);
/* Adds a text and its end, so that "ab" "c" is not "a" "bc". NULL counts as "". */
void hpr_sha256_add_text(hpr_sha256 *hash, const char *text);
/* 64 lower-case hexadecimal digits. The hash must be initialised again to be used again. */
void hpr_sha256_finish(hpr_sha256 *hash, char text[HPR_SHA256_TEXT]);

/* Adds what a file holds; *bytes (may be NULL) receives how much. Errors: HPR_ERR_IO. */
hpr_status hpr_sha256_add_file(hpr_context *ctx, hpr_sha256 *hash, const char *path, uint64_t *bytes);

#endif
