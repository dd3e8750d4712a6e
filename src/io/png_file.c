#include "io/png_file.h"

#include <png.h>

/* Into memory first: libpng would swallow what the disk has to say. */
hpr_status hpr_png_encode(hpr_atomic_file *file, int width, int height, unsigned format,
                          const unsigned char *bytes)
{
    png_image png = {.version = PNG_IMAGE_VERSION};
    png.width = (png_uint_32)width;
    png.height = (png_uint_32)height;
    png.format = (format & HPR_PNG_COLOUR ? PNG_FORMAT_FLAG_COLOR : 0u) |
                 (format & HPR_PNG_ALPHA ? PNG_FORMAT_FLAG_ALPHA : 0u);
    png_alloc_size_t size = PNG_IMAGE_PNG_SIZE_MAX(png);
    void *memory = NULL;
    hpr_status status = hpr_allocate_into(file->context, &memory, size, 1, "a compressed picture");
    if (status != HPR_OK)
        return status;
    if (png_image_write_to_memory(&png, memory, &size, 0, bytes, 0, NULL))
        status = hpr_atomic_write(file, memory, size);
    else
        status =
            hpr_fail(file->context, HPR_ERR_IO, "cannot write '%s': libpng: %s", file->path, png.message);
    hpr_release(file->context, memory);
    return status;
}
