#include "io/sha256.h"

#include <errno.h>
#include <stdio.h>
#include <string.h>

static const uint32_t constants[64] = {
    0x428a2f98, 0x71374491, 0xb5c0fbcf, 0xe9b5dba5, 0x3956c25b, 0x59f111f1, 0x923f82a4, 0xab1c5ed5,
    0xd807aa98, 0x12835b01, 0x243185be, 0x550c7dc3, 0x72be5d74, 0x80deb1fe, 0x9bdc06a7, 0xc19bf174,
    0xe49b69c1, 0xefbe4786, 0x0fc19dc6, 0x240ca1cc, 0x2de92c6f, 0x4a7484aa, 0x5cb0a9dc, 0x76f988da,
    0x983e5152, 0xa831c66d, 0xb00327c8, 0xbf597fc7, 0xc6e00bf3, 0xd5a79147, 0x06ca6351, 0x14292967,
    0x27b70a85, 0x2e1b2138, 0x4d2c6dfc, 0x53380d13, 0x650a7354, 0x766a0abb, 0x81c2c92e, 0x92722c85,
    0xa2bfe8a1, 0xa81a664b, 0xc24b8b70, 0xc76c51a3, 0xd192e819, 0xd6990624, 0xf40e3585, 0x106aa070,
    0x19a4c116, 0x1e376c08, 0x2748774c, 0x34b0bcb5, 0x391c0cb3, 0x4ed8aa4a, 0x5b9cca4f, 0x682e6ff3,
    0x748f82ee, 0x78a5636f, 0x84c87814, 0x8cc70208, 0x90befffa, 0xa4506ceb, 0xbef9a3f7, 0xc67178f2};

void hpr_sha256_init(hpr_sha256 *hash)
{
    *hash = (hpr_sha256){.state = {0x6a09e667, 0xbb67ae85, 0x3c6ef372, 0xa54ff53a, 0x510e527f, 0x9b05688c,
                                   0x1f83d9ab, 0x5be0cd19}};
}

static uint32_t rotate(uint32_t x, int n)
{
    return x >> n | x << (32 - n);
}

static void take_block(hpr_sha256 *hash)
{
    uint32_t w[64], s[8];
    for (int i = 0; i < 16; i++) {
        const unsigned char *b = hash->block + 4 * i;
        w[i] = (uint32_t)b[0] << 24 | (uint32_t)b[1] << 16 | (uint32_t)b[2] << 8 | b[3];
    }
    for (int i = 16; i < 64; i++) {
        uint32_t a = w[i - 15], b = w[i - 2];
        w[i] = w[i - 16] + (rotate(a, 7) ^ rotate(a, 18) ^ a >> 3) + w[i - 7] +
               (rotate(b, 17) ^ rotate(b, 19) ^ b >> 10);
    }
    memcpy(s, hash->state, sizeof s);
    for (int i = 0; i < 64; i++) {
        uint32_t choice = (s[4] & s[5]) ^ (~s[4] & s[6]);
        uint32_t majority = (s[0] & s[1]) ^ (s[0] & s[2]) ^ (s[1] & s[2]);
        uint32_t first =
            s[7] + (rotate(s[4], 6) ^ rotate(s[4], 11) ^ rotate(s[4], 25)) + choice + constants[i] + w[i];
        uint32_t second = (rotate(s[0], 2) ^ rotate(s[0], 13) ^ rotate(s[0], 22)) + majority;
        memmove(s + 1, s, 7 * sizeof *s);
        s[4] += first;
        s[0] = first + second;
    }
    for (int i = 0; i < 8; i++)
        hash->state[i] += s[i];
}

void hpr_sha256_add(hpr_sha256 *hash, const void *data, size_t bytes)
{
    const unsigned char *from = data;
    while (bytes) {
        size_t filled = hash->bytes % sizeof hash->block, room = sizeof hash->block - filled;
        size_t taken = bytes < room ? bytes : room;
        memcpy(hash->block + filled, from, taken);
        hash->bytes += taken;
        from += taken;
        bytes -= taken;
        if (taken == room)
            take_block(hash);
    }
}

void hpr_sha256_add_text(hpr_sha256 *hash, const char *text)
{
    text = text ? text : "";
    hpr_sha256_add(hash, text, strlen(text) + 1);
}

void hpr_sha256_finish(hpr_sha256 *hash, char text[HPR_SHA256_TEXT])
{
    static const unsigned char end = 0x80, zero = 0;
    uint64_t bits = 8 * hash->bytes;
    unsigned char length[8];
    hpr_sha256_add(hash, &end, 1);
    while (hash->bytes % sizeof hash->block != sizeof hash->block - sizeof length)
        hpr_sha256_add(hash, &zero, 1);
    for (int i = 0; i < 8; i++)
        length[i] = (unsigned char)(bits >> (56 - 8 * i));
    hpr_sha256_add(hash, length, sizeof length);
    for (int i = 0; i < 8; i++)
        snprintf(text + 8 * i, 9, "%08x", (unsigned)hash->state[i]);
}

hpr_status hpr_sha256_add_file(hpr_context *ctx, hpr_sha256 *hash, const char *path, uint64_t *bytes)
{
    unsigned char piece[16384];
    uint64_t count = 0;
    FILE *file = fopen(path, "rb");
    if (!file)
        return hpr_fail(ctx, HPR_ERR_IO, "cannot read '%s': %s", path, strerror(errno));
    for (size_t got; (got = fread(piece, 1, sizeof piece, file)) > 0; count += got)
        hpr_sha256_add(hash, piece, got);
    hpr_status status = HPR_OK;
    if (ferror(file))
        status = hpr_fail(ctx, HPR_ERR_IO, "cannot read '%s': %s", path, strerror(errno));
    fclose(file);
    if (bytes)
        *bytes = count;
    return status;
}
