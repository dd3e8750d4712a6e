#include "app/factor_stream.h"

hpr_status hpr_factor_stream_open(const hpr_rows *rows, const char *path, double rounding,
                                  hpr_factor_stream *stream)
{
    hpr_context *ctx = rows->context;
    size_t side = hpr_factor_tile_side(rows->count);
    *stream = (hpr_factor_stream){
        .rows = rows, .rounding = rounding, .side = side, .tiles = (rows->count + side - 1) / side};
    hpr_status status =
        hpr_allocate_into(ctx, &stream->area_m2, rows->count, sizeof *stream->area_m2, "view factors");
    if (status == HPR_OK)
        status = hpr_allocate_into(ctx, &stream->sum, stream->tiles * rows->count, sizeof *stream->sum,
                                   "row sums");
    for (size_t i = 0; status == HPR_OK && i < rows->count; i++)
        stream->area_m2[i] = rows->row[i].area_m2;
    if (status == HPR_OK)
        status = hpr_factor_file_open(ctx, path, rows->count, stream->area_m2, &stream->file);
    return status;
}

/* Adds an entry of line i that is in a column of tiles. */
static void account(hpr_factor_stream *stream, size_t i, size_t column, double exchange, size_t *outside)
{
    double area = stream->area_m2[i], factor = area > 0 ? exchange / area : 0;
    stream->sum[column / stream->side * stream->rows->count + i] += factor;
    *outside += !(factor >= -stream->rounding && factor <= 1 + stream->rounding);
}

static hpr_status put(void *user, const hpr_factor_tile *tile)
{
    hpr_factor_stream *stream = user;
    size_t outside = 0;
    for (size_t r = 0; r < tile->row_count; r++) {
        for (size_t c = 0; c < tile->column_count; c++) {
            double exchange = tile->exchange[r * tile->column_count + c];
            account(stream, tile->row + r, tile->column, exchange, &outside);
            if (tile->row != tile->column)
                account(stream, tile->column + c, tile->row, exchange, &outside);
        }
    }
    stream->outside += outside;
    return hpr_factor_file_put(&stream->file, tile);
}

hpr_status hpr_factor_stream_run(hpr_factor_stream *stream, double tolerance, double *row_sum,
                                 hpr_pairs_done *done)
{
    const hpr_factor_sink sink = {put, stream};
    hpr_status status = hpr_form_factors_stream(stream->rows, tolerance, &sink, done);
    for (size_t i = 0; i < stream->rows->count; i++) {
        row_sum[i] = 0;
        for (size_t t = 0; t < stream->tiles; t++)
            row_sum[i] += stream->sum[t * stream->rows->count + i];
    }
    return status;
}

hpr_status hpr_factor_stream_close(hpr_factor_stream *stream, hpr_status status)
{
    if (!stream->rows)
        return status;
    hpr_context *ctx = stream->rows->context;
    if (stream->file.file.stream)
        status = hpr_factor_file_close(&stream->file, status);
    hpr_release(ctx, stream->area_m2);
    hpr_release(ctx, stream->sum);
    stream->rows = NULL;
    return status;
}
