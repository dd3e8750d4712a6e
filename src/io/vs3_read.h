/* View3D's .vs3 files, formats 3 and 3a. */
#ifndef HPR_IO_VS3_READ_H
#define HPR_IO_VS3_READ_H

#include "scene/model.h"

/*
 * Reads a file into a checked model. Control words other than eps, encl and emit are named in one warning.
 * Errors: HPR_ERR_IO, HPR_ERR_FORMAT (with file, line and value), HPR_ERR_UNSUPPORTED (X, other formats),
 * HPR_ERR_MEMORY, HPR_ERR_INTERRUPTED.
 */
hpr_status hpr_vs3_read(hpr_context *ctx, const char *path, hpr_model **model);

#endif
