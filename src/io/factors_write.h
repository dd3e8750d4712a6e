/* Files of view factors. All are written whole or not at all. */
#ifndef HPR_IO_FACTORS_WRITE_H
#define HPR_IO_FACTORS_WRITE_H

#include "patch/rows.h"

/* Where the numbers come from: fetch fills line[count] with line i. */
typedef struct hpr_factor_source {
    size_t count;
    void (*fetch)(const void *data, size_t i, double *line);
    const void *data;
} hpr_factor_source;

/* Square, float64, C order: NumPy's format 1.0, little-endian. Errors: HPR_ERR_IO, HPR_ERR_MEMORY,
 * HPR_ERR_INTERRUPTED; those of the others too. */
hpr_status hpr_factors_write_npy(hpr_context *ctx, const char *path, const hpr_factor_source *source);

/* array [shape[0]] ... [shape[dimensions - 1]], 2 to 4 dimensions. */
hpr_status hpr_array_write_npy(hpr_context *ctx, const char *path, int dimensions, const size_t *shape,
                               const double *array);

/* Square, without header, numbers that read back bit for bit. */
hpr_status hpr_factors_write_csv(hpr_context *ctx, const char *path, const hpr_factor_source *source);

/* View3D's text layout (that of its version 4.0.0) with all digits: a line "View3D 4.0.0 0 encl emit N",
 * areas, the matrix line by line, emittances. */
hpr_status hpr_factors_write_text(hpr_context *ctx, const char *path, const hpr_factor_source *source,
                                  const hpr_rows *rows, bool closed, bool exchange);

/*
 * index,name,node,primitive,side,area_m2,emissivity,row_sum,surroundings: index from 0 as in the matrix; node
 * and primitive are empty if the model has none; side is "front" or "back"; surroundings = 1 - row_sum.
 * row_sum: [rows->count].
 */
hpr_status hpr_surfaces_write(hpr_context *ctx, const char *path, const hpr_rows *rows,
                              const double *row_sum);

#endif
