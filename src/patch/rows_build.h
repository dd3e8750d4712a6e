/* What the two makers of rows share. */
#ifndef HPR_PATCH_ROWS_BUILD_H
#define HPR_PATCH_ROWS_BUILD_H

#include "patch/rows.h"

/* Rows without names and patches. Errors: HPR_ERR_MEMORY. */
hpr_status hpr_rows_create(hpr_context *ctx, size_t count, hpr_rows **rows);

/* Copies the name. Errors: HPR_ERR_MEMORY. */
hpr_status hpr_rows_name(hpr_rows *rows, size_t row, const char *name);

/* Makes `first` and `member` from patch_row. Errors: HPR_ERR_MEMORY. */
hpr_status hpr_rows_index(hpr_rows *rows);

#endif
