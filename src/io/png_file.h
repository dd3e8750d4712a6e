/* 8-bit PNG files, through libpng's simplified interface. */
#ifndef HPR_IO_PNG_FILE_H
#define HPR_IO_PNG_FILE_H

#include "io/atomic_file.h"

enum { HPR_PNG_COLOUR = 1, HPR_PNG_ALPHA = 2 };

/* Encodes bytes [height][width][components]: grey or RGB, then alpha (not premultiplied), all sRGB, into an
 * open file. Errors: HPR_ERR_IO, HPR_ERR_MEMORY. */
hpr_status hpr_png_encode(hpr_atomic_file *file, int width, int height, unsigned format,
                          const unsigned char *bytes);

#endif
