/* Files of view factors. All are written whole or not at all. */
#ifndef HPR_IO_FACTORS_WRITE_H
#define HPR_IO_FACTORS_WRITE_H

#include "io/atomic_file.h"
#include "link/form_factors.h"
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

/* The same file from A_i F_ij, tile by tile in any order (link/form_factors.h), so that the matrix need not
 * be in memory. */
typedef struct hpr_factor_file {
    hpr_atomic_file file;
    size_t count, start;   /* start: of the numbers, in bytes */
    const double *area_m2; /* [count] borrowed; rows of zero area are zero */
} hpr_factor_file;

/* Whether it fails or not, the file can be closed. The path must not be one that is written directly
 * (hpr_atomic_is_direct). Errors: as above. */
hpr_status hpr_factor_file_open(hpr_context *ctx, const char *path, size_t count, const double *area_m2,
                                hpr_factor_file *file);

/* Both the tile and its transpose. Concurrent calls allowed with different tiles. Errors: as above. */
hpr_status hpr_factor_file_put(hpr_factor_file *file, const hpr_factor_tile *tile);

/* Keeps the file if the status is HPR_OK, else removes it; returns the status or what went wrong. */
hpr_status hpr_factor_file_close(hpr_factor_file *file, hpr_status status);

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
