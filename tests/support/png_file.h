/* A PNG of 8-bit RGB or 16-bit grey pixels, stored without compression. */
#ifndef HPR_TEST_PNG_FILE_H
#define HPR_TEST_PNG_FILE_H

#include <stddef.h>
#include <stdint.h>
#include <string.h>

static inline uint32_t png_crc(const unsigned char *data, size_t size)
{
    uint32_t crc = 0xffffffff;
    for (size_t i = 0; i < size; i++) {
        crc ^= data[i];
        for (int bit = 0; bit < 8; bit++)
            crc = crc >> 1 ^ (crc & 1 ? 0xedb88320 : 0);
    }
    return ~crc;
}

static inline void png_u32(unsigned char *at, uint32_t value)
{
    for (int i = 0; i < 4; i++)
        at[i] = (unsigned char)(value >> (24 - 8 * i));
}

/* A chunk whose `size` bytes stand at out + 8 already; returns its whole length. */
static inline size_t png_chunk(unsigned char *out, const char *kind, size_t size)
{
    png_u32(out, (uint32_t)size);
    memcpy(out + 4, kind, 4);
    png_u32(out + 8 + size, png_crc(out + 4, size + 4));
    return size + 12;
}

/* pixels: [height][width][row bytes / width]. At most 65535 bytes with one byte more per row. */
static inline size_t make_png(unsigned char *out, unsigned width, unsigned height, int bits, int colour_type,
                              const unsigned char *pixels)
{
    size_t row = (size_t)width * (unsigned)bits / 8 * (colour_type == 2 ? 3 : 1), raw = height * (row + 1);
    memcpy(out, "\x89PNG\r\n\x1a\n", 8);
    unsigned char *at = out + 8;
    png_u32(at + 8, width);
    png_u32(at + 12, height);
    const unsigned char header[] = {(unsigned char)bits, (unsigned char)colour_type, 0, 0, 0};
    memcpy(at + 16, header, 5);
    at += png_chunk(at, "IHDR", 13);
    const unsigned char stored[] = {0x78,
                                    0x01,
                                    1,
                                    (unsigned char)raw,
                                    (unsigned char)(raw >> 8),
                                    (unsigned char)~raw,
                                    (unsigned char)(~raw >> 8)};
    memcpy(at + 8, stored, 7);
    uint32_t a = 1, b = 0;
    for (size_t i = 0; i < raw; i++) {
        size_t y = i / (row + 1), x = i % (row + 1);
        unsigned char byte = x ? pixels[y * row + x - 1] : 0;
        at[15 + i] = byte;
        a = (a + byte) % 65521;
        b = (b + a) % 65521;
    }
    png_u32(at + 15 + raw, b << 16 | a);
    at += png_chunk(at, "IDAT", raw + 11);
    at += png_chunk(at, "IEND", 0);
    return (size_t)(at - out);
}

#endif
