#include "link/form_factors.h"

#include "quadrature/constants.h"

#include <math.h>
#include <omp.h>
#include <stdatomic.h>
#include <string.h>

/* What a thread needs for a tile beside its pairs one by one. */
typedef struct tile_worker {
    hpr_pairs_worker *one;
    hpr_element_frame *frame; /* [2 panel] of patches of its rows, then of its columns */
    double *part;             /* [panel][panel] A_p F_pq of these */
    uint8_t *kind;            /* [panel][panel] hpr_pair_kind */
    double *scratch;
    double *exchange; /* [side][side] */
} tile_worker;

typedef struct assembly {
    hpr_pairs pairs;
    const hpr_rows *rows;
    double tolerance;
    size_t side, panel; /* rows of a tile; patches that are gone through at once */
    hpr_far *far;
    tile_worker *worker; /* [threads] */
} assembly;

/* Patches of a tile's rows and of its columns, as places in rows->member. */
typedef struct tile_patches {
    size_t recv, recv_count, send, send_count;
    bool square; /* both are the same */
} tile_patches;

static const uint32_t *patch_at(const assembly *a, size_t place)
{
    return a->rows->member + place;
}

/* A_p F_pq of the block that the worker has. */
static double exchange_of(const assembly *a, const hpr_pairs_worker *w, size_t p, size_t q)
{
    const double *area = a->rows->patches->area_m2;
    return sqrt(area[p]) * sqrt(area[q]) * w->block[0];
}

/* A_p F_pq to a relative tolerance. */
static double integrate_exchange(const assembly *a, hpr_pairs_worker *w, size_t p, size_t q, double tolerance)
{
    return hpr_pairs_integrate(&a->pairs, w, p, q, tolerance) ? exchange_of(a, w, p, q) : 0;
}

/* How a pair of patches is to be integrated: in bulk, by itself, or not at all because it is zero. What may
 * be blocked is integrated here and now, for the blockers are at hand. */
static hpr_pair_kind begin_pair(const assembly *a, hpr_pairs_worker *w, uint32_t p, uint32_t q, double *part)
{
    const uint8_t *shape = a->rows->patches->shape;
    if (!hpr_pairs_counts(&a->pairs, p, q))
        return HPR_PAIR_UNASKED;
    hpr_verdict verdict = hpr_views_between(a->pairs.views, p, q);
    if (verdict == HPR_SEES_PARTLY)
        verdict = hpr_pairs_look(&a->pairs, w, p, q);
    if (verdict == HPR_SEES_PARTLY && hpr_pairs_integrate_past(&a->pairs, w, p, q, a->tolerance))
        *part = exchange_of(a, w, p, q);
    if (verdict != HPR_SEES_WHOLLY)
        return HPR_PAIR_UNASKED;
    bool bulk = shape[p] != HPR_SHAPE_QUADRILATERAL && shape[q] != HPR_SHAPE_QUADRILATERAL;
    return bulk ? HPR_PAIR_WANTED : HPR_PAIR_LEFT;
}

/* Of square tiles only pairs of a patch and a later one. */
static void begin_pairs(const assembly *a, tile_worker *w, const tile_patches *t)
{
    memset(w->part, 0, t->recv_count * t->send_count * sizeof *w->part);
    memset(w->kind, HPR_PAIR_UNASKED, t->recv_count * t->send_count);
    for (size_t m = 0; m < t->recv_count; m++) {
        for (size_t n = t->square ? m + 1 : 0; n < t->send_count && !hpr_cancelled(a->pairs.context); n++) {
            size_t at = m * t->send_count + n;
            w->kind[at] = (uint8_t)begin_pair(a, w->one, *patch_at(a, t->recv + m), *patch_at(a, t->send + n),
                                              &w->part[at]);
        }
    }
}

/* A_p F_pq of all pairs that can be had so. */
static void integrate_bulk(const assembly *a, tile_worker *w, const tile_patches *t)
{
    const hpr_constants_task task = {.tables = a->far,
                                     .recv = {t->recv_count, w->frame},
                                     .send = {t->send_count, w->frame + t->recv_count},
                                     .tolerance = a->tolerance,
                                     .slack_m = hpr_visibility_slack_m(a->pairs.visibility)};
    for (size_t m = 0; m < t->recv_count; m++)
        w->frame[m] = hpr_pairs_frame(&a->pairs, *patch_at(a, t->recv + m));
    for (size_t n = 0; n < t->send_count; n++)
        w->frame[t->recv_count + n] = hpr_pairs_frame(&a->pairs, *patch_at(a, t->send + n));
    hpr_constants_result result = hpr_constants_block(&task, w->part, w->kind, w->scratch);
    for (size_t m = 0; m < t->recv_count; m++) {
        for (size_t n = 0; n < t->send_count; n++) {
            size_t at = m * t->send_count + n;
            if (w->kind[at] == HPR_PAIR_WANTED)
                w->part[at] *= sqrt(w->frame[m].area_m2) * sqrt(w->frame[t->recv_count + n].area_m2);
        }
    }
    w->one->kernel_count += result.kernel_count;
    w->one->done.pair_count += result.pair_count;
    w->one->done.relative_error = fmax(w->one->done.relative_error, result.error);
}

static void integrate_parts(const assembly *a, tile_worker *w, const tile_patches *t)
{
    begin_pairs(a, w, t);
    integrate_bulk(a, w, t);
    for (size_t m = 0; m < t->recv_count; m++) {
        for (size_t n = 0; n < t->send_count && !hpr_cancelled(a->pairs.context); n++) {
            size_t at = m * t->send_count + n;
            if (w->kind[at] == HPR_PAIR_LEFT)
                w->part[at] = integrate_exchange(a, w->one, *patch_at(a, t->recv + m),
                                                 *patch_at(a, t->send + n), a->tolerance);
        }
    }
}

/* Adds the parts of a panel to the entries that they are of. */
static void add_parts(const assembly *a, const tile_worker *w, const tile_patches *t,
                      const hpr_factor_tile *tile)
{
    const uint32_t *row = a->rows->patch_row;
    for (size_t m = 0; m < t->recv_count; m++) {
        double *entry = w->exchange + (row[*patch_at(a, t->recv + m)] - tile->row) * tile->column_count;
        for (size_t n = 0; n < t->send_count; n++)
            entry[row[*patch_at(a, t->send + n)] - tile->column] += w->part[m * t->send_count + n];
    }
}

/* A_i F_ij anew, each part to an absolute error as well. Pairs within one row count in both directions. */
static double sum_exactly(const assembly *a, tile_worker *w, size_t i, size_t j, double allowed_m2)
{
    static const double tight = 1e-14;
    const hpr_rows *rows = a->rows;
    double sum = 0;
    for (size_t m = rows->first[i]; m < rows->first[i + 1]; m++) {
        for (size_t n = i == j ? m + 1 : rows->first[j]; n < rows->first[j + 1]; n++) {
            uint32_t p = *patch_at(a, m), q = *patch_at(a, n);
            double part = integrate_exchange(a, w->one, p, q, a->tolerance);
            if (part * a->tolerance > allowed_m2)
                part = integrate_exchange(a, w->one, p, q, fmax(tight, allowed_m2 / part));
            sum += part;
        }
    }
    return i == j ? 2 * sum : sum;
}

/* Where one sees hardly anything but the other, an error within the tolerance might make that more than all:
 * then the errors of all pairs of patches together must be rounding. */
static double finish_entry(const assembly *a, tile_worker *w, size_t i, size_t j, double sum)
{
    static const double rounding = 1e-14;
    const hpr_rows *rows = a->rows;
    double smaller = fmin(rows->row[i].area_m2, rows->row[j].area_m2);
    sum *= i == j ? 2 : 1;
    if (sum > (1 - a->tolerance) * smaller) {
        const hpr_pairs_done done = w->one->done;
        size_t pairs = (rows->first[i + 1] - rows->first[i]) * (rows->first[j + 1] - rows->first[j]);
        sum = sum_exactly(a, w, i, j, rounding * smaller / (double)pairs);
        w->one->done = done;
    }
    return sum;
}

static size_t smaller_of(size_t a, size_t b)
{
    return a < b ? a : b;
}

/* What masks and their bases see of each other goes into the tile that they are in. */
static void add_masks(const hpr_rows *rows, const hpr_factor_tile *tile, double *exchange)
{
    for (size_t k = 0; k < rows->mask_count; k++) {
        const hpr_mask *mask = &rows->mask[k];
        const size_t both[2] = {mask->mask_row, mask->base_row};
        for (int turn = 0; turn < 2; turn++) {
            size_t i = both[turn] - tile->row, j = both[1 - turn] - tile->column; /* before it: huge */
            if (i < tile->row_count && j < tile->column_count)
                exchange[i * tile->column_count + j] += mask->area_m2;
        }
    }
}

/* All pairs of patches of the tile, panel by panel: a row may have any number of patches. */
static void integrate_panels(const assembly *a, tile_worker *w, const hpr_factor_tile *tile)
{
    const size_t *first = a->rows->first;
    size_t recv_end = first[tile->row + tile->row_count], send_end = first[tile->column + tile->column_count];
    bool square = tile->row == tile->column;
    for (size_t recv = first[tile->row]; recv < recv_end; recv += a->panel) {
        for (size_t send = square ? recv : first[tile->column]; send < send_end; send += a->panel) {
            const tile_patches patches = {recv, smaller_of(a->panel, recv_end - recv), send,
                                          smaller_of(a->panel, send_end - send), recv == send};
            integrate_parts(a, w, &patches);
            add_parts(a, w, &patches, tile);
        }
    }
}

static hpr_factor_tile integrate_tile(const assembly *a, tile_worker *w, size_t row, size_t column)
{
    const hpr_rows *rows = a->rows;
    const hpr_factor_tile tile = {row, column, smaller_of(a->side, rows->count - row),
                                  smaller_of(a->side, rows->count - column), w->exchange};
    size_t width = tile.column_count;
    memset(w->exchange, 0, tile.row_count * width * sizeof *w->exchange);
    integrate_panels(a, w, &tile);
    for (size_t i = 0; i < tile.row_count; i++) {
        for (size_t j = row == column ? i : 0; j < width; j++) {
            double *entry = &w->exchange[i * width + j];
            *entry = finish_entry(a, w, row + i, column + j, *entry);
            if (row == column)
                w->exchange[j * width + i] = *entry;
        }
    }
    add_masks(rows, &tile, w->exchange);
    return tile;
}

/* A tile's place among those of the upper half, row after row. */
static void place_of(size_t index, size_t tiles, size_t *row, size_t *column)
{
    for (*row = 0; index >= tiles - *row; (*row)++)
        index -= tiles - *row;
    *column = *row + index;
}

size_t hpr_factor_tile_side(size_t row_count)
{
    enum { FEW = 16 }; /* enough tiles to be shared out */
    return smaller_of(1 + row_count / FEW, HPR_FACTOR_TILE_MOST);
}

static hpr_status integrate_all(assembly *a, const hpr_factor_sink *sink)
{
    hpr_context *ctx = a->pairs.context;
    size_t tiles = (a->rows->count + a->side - 1) / a->side, tile_count = tiles * (tiles + 1) / 2;
    atomic_int failure = HPR_OK;
    atomic_size_t finished = 0;
#pragma omp parallel for schedule(dynamic, 1) num_threads(hpr_context_threads(ctx))
    for (size_t index = 0; index < tile_count; index++) {
        size_t row, column;
        if (failure != HPR_OK || hpr_cancelled(ctx))
            continue;
        place_of(index, tiles, &row, &column);
        const hpr_factor_tile tile =
            integrate_tile(a, &a->worker[omp_get_thread_num()], row * a->side, column * a->side);
        hpr_status status = hpr_cancelled(ctx) ? HPR_OK : sink->put(sink->user, &tile);
        if (status != HPR_OK)
            failure = (int)status;
        finished++;
        if (omp_get_thread_num() == 0)
            hpr_stage_progress(ctx, (double)finished / (double)tile_count);
    }
    if (failure == HPR_OK && hpr_cancelled(ctx))
        return hpr_fail(ctx, HPR_ERR_INTERRUPTED, "interrupted");
    return (hpr_status)failure;
}

/* The most patches that the rows of a tile have, but no more than are gone through at once. */
static size_t panel_of(const hpr_rows *rows, size_t side)
{
    size_t most = 1;
    for (size_t row = 0; row < rows->count; row += side) {
        size_t count = rows->first[smaller_of(row + side, rows->count)] - rows->first[row];
        most = count > most ? count : most;
    }
    return smaller_of(most, HPR_FACTOR_TILE_MOST);
}

static hpr_status open_workers(assembly *a)
{
    static const char what[] = "quadrature scratch";
    hpr_context *ctx = a->pairs.context;
    int threads = hpr_context_threads(ctx);
    size_t panel = a->panel;
    hpr_status status = hpr_allocate_into(ctx, &a->worker, (size_t)threads, sizeof *a->worker, what);
    for (int t = 0; status == HPR_OK && t < threads; t++) {
        tile_worker *w = &a->worker[t];
        w->one = &a->pairs.worker[t];
        status = hpr_allocate_into(ctx, &w->frame, 2 * panel, sizeof *w->frame, what);
        if (status == HPR_OK)
            status = hpr_allocate_into(ctx, &w->part, panel * panel, sizeof *w->part, what);
        if (status == HPR_OK)
            status = hpr_allocate_into(ctx, &w->kind, panel * panel, sizeof *w->kind, what);
        if (status == HPR_OK)
            status = hpr_allocate_into(ctx, &w->scratch, hpr_constants_scratch(panel, panel), sizeof(double),
                                       what);
        if (status == HPR_OK)
            status = hpr_allocate_into(ctx, &w->exchange, a->side * a->side, sizeof(double), what);
    }
    return status;
}

static void close_workers(assembly *a)
{
    hpr_context *ctx = a->rows->context;
    for (int t = 0; a->worker && t < hpr_context_threads(ctx); t++) {
        tile_worker *w = &a->worker[t];
        void *arrays[] = {w->frame, w->part, w->kind, w->scratch, w->exchange};
        for (size_t i = 0; i < sizeof arrays / sizeof *arrays; i++)
            hpr_release(ctx, arrays[i]);
    }
    hpr_release(ctx, a->worker);
}

hpr_status hpr_form_factors_stream(const hpr_rows *rows, double tolerance, const hpr_factor_sink *sink,
                                   hpr_pairs_done *done)
{
    assembly a = {.rows = rows, .tolerance = tolerance, .side = hpr_factor_tile_side(rows->count)};
    a.panel = panel_of(rows, a.side);
    hpr_status status = hpr_pairs_open(rows, 0, &a.pairs);
    if (status == HPR_OK)
        status = hpr_far_create(rows->context, 0, &a.far);
    if (status == HPR_OK)
        status = open_workers(&a);
    if (status == HPR_OK)
        status = integrate_all(&a, sink);
    close_workers(&a);
    hpr_far_destroy(&a.far);
    hpr_pairs_close(&a.pairs, done);
    return status;
}

double hpr_form_factors_bytes(size_t row_count)
{
    return (0.5 * ((double)row_count + 1) + 1) * (double)row_count * sizeof(double);
}

/* First of row i among the entries j >= i of all rows. */
static size_t packed_row(size_t count, size_t i)
{
    return i * count - i * (i - 1) / 2;
}

static hpr_status keep_tile(void *user, const hpr_factor_tile *tile)
{
    hpr_form_factors *factors = user;
    for (size_t r = 0; r < tile->row_count; r++) {
        size_t i = tile->row + r, skip = tile->row == tile->column ? r : 0;
        memcpy(factors->exchange + packed_row(factors->count, i) + (tile->column + skip - i),
               tile->exchange + r * tile->column_count + skip, (tile->column_count - skip) * sizeof(double));
    }
    return HPR_OK;
}

hpr_status hpr_form_factors_create(const hpr_rows *rows, double tolerance, hpr_form_factors **out)
{
    hpr_context *ctx = rows->context;
    hpr_form_factors *factors = NULL;
    size_t count = rows->count;
    *out = NULL;
    hpr_status status = hpr_allocate_into(ctx, &factors, 1, sizeof *factors, "view factors");
    if (status != HPR_OK)
        return status;
    factors->context = ctx;
    factors->count = count;
    status = hpr_allocate_into(ctx, &factors->area_m2, count, sizeof(double), "view factors");
    if (status == HPR_OK)
        status = hpr_allocate_into(ctx, &factors->exchange, packed_row(count, count), sizeof(double),
                                   "view factors");
    if (status == HPR_OK) {
        const hpr_factor_sink sink = {keep_tile, factors};
        for (size_t i = 0; i < count; i++)
            factors->area_m2[i] = rows->row[i].area_m2;
        status = hpr_form_factors_stream(rows, tolerance, &sink, &factors->done);
    }
    if (status != HPR_OK)
        hpr_form_factors_destroy(&factors);
    *out = factors;
    return status;
}

void hpr_form_factors_destroy(hpr_form_factors **out)
{
    hpr_form_factors *factors = *out;
    if (!factors)
        return;
    hpr_context *ctx = factors->context;
    hpr_release(ctx, factors->area_m2);
    hpr_release(ctx, factors->exchange);
    hpr_release(ctx, factors);
    *out = NULL;
}

double hpr_form_factors_at(const hpr_form_factors *factors, size_t i, size_t j)
{
    size_t low = i < j ? i : j, high = i < j ? j : i;
    return factors->exchange[packed_row(factors->count, low) + (high - low)];
}

void hpr_form_factors_row(const hpr_form_factors *factors, size_t i, double *row)
{
    double area = factors->area_m2[i];
    for (size_t j = 0; j < factors->count; j++)
        row[j] = area > 0 ? hpr_form_factors_at(factors, i, j) / area : 0;
}
