/* Arrays of a solution file: how one is written and found (io/solution_format.h). */
#ifndef HPR_IO_SOLUTION_COLUMN_H
#define HPR_IO_SOLUTION_COLUMN_H

#include "io/glb.h"
#include "io/solution_format.h"

/* Writes column->array as a member of `group`, an object; the data must stay until the file is written.
 * Errors: HPR_ERR_MEMORY. */
hpr_status hpr_column_write(hpr_glb_builder *glb, cJSON *group, const hpr_column *column);

/*
 * The data of a column in `group`, which may be NULL; *bytes receives their number. *data is NULL for an
 * empty array, and for one that files of this version need not have. Errors: HPR_ERR_FORMAT.
 */
hpr_status hpr_column_find(const hpr_glb *glb, const cJSON *group, size_t version, const hpr_column *column,
                           const unsigned char **data, size_t *bytes);

#endif
