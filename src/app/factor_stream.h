/* View factors from the integration straight into their file; their sums are kept. */
#ifndef HPR_APP_FACTOR_STREAM_H
#define HPR_APP_FACTOR_STREAM_H

#include "io/factors_write.h"

#include <stdatomic.h>

typedef struct hpr_factor_stream {
    const hpr_rows *rows; /* NULL: closed */
    hpr_factor_file file;
    double rounding; /* a factor outside [0, 1] by more is counted */
    double *area_m2; /* [rows->count] */
    double *sum;     /* [tiles][rows->count] of the entries of a line in a column of tiles */
    size_t side, tiles;
    atomic_size_t outside;
} hpr_factor_stream;

/* Whether it fails or not, the stream can be closed. Errors: HPR_ERR_IO, HPR_ERR_MEMORY, HPR_ERR_INTERRUPTED.
 */
hpr_status hpr_factor_stream_open(const hpr_rows *rows, const char *path, double rounding,
                                  hpr_factor_stream *stream);

/* Integrates and writes; row_sum [rows->count]. Errors: those of hpr_form_factors_stream and of the file. */
hpr_status hpr_factor_stream_run(hpr_factor_stream *stream, double tolerance, double *row_sum,
                                 hpr_pairs_done *done);

/* Keeps the file if the status is HPR_OK, else removes it; returns the status or what went wrong. Of a stream
 * that is zero or closed: the status. */
hpr_status hpr_factor_stream_close(hpr_factor_stream *stream, hpr_status status);

#endif
