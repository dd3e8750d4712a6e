/* View factors between the rows of a model: whole in memory, or tile by tile. */
#ifndef HPR_LINK_FORM_FACTORS_H
#define HPR_LINK_FORM_FACTORS_H

#include "link/pairs.h"

/* A part of the matrix: A_i F_ij of rows i = row, row + 1 ... and columns j = column, column + 1 ..., row <=
 * column. Where row == column it is square and whole. */
typedef struct hpr_factor_tile {
    size_t row, column, row_count, column_count;
    const double *exchange; /* [row_count][column_count] */
} hpr_factor_tile;

/* No tile has more rows or columns: of so many numbers a line is a page. */
enum { HPR_FACTOR_TILE_MOST = 512 };

/* Takes a tile; called by several threads at once, in any order. What it returns but HPR_OK ends everything.
 */
typedef struct hpr_factor_sink {
    hpr_status (*put)(void *user, const hpr_factor_tile *tile);
    void *user;
} hpr_factor_sink;

/* Rows and columns of a tile, those of the last may be fewer. */
size_t hpr_factor_tile_side(size_t row_count);

/*
 * A_i F_ij = sum over patches p of row i, q of row j of ∫_p ∫_q G V dA dA, each pair integrated once, to the
 * relative tolerance; plus the masks. Every tile of the upper half of the matrix goes to the sink once. The
 * same bits for any number of threads. Pairs that nothing obstructs go through quadrature/constants.h, near
 * and obstructed ones one by one. Blocks that stop short are counted. Errors: HPR_ERR_MEMORY, HPR_ERR_DEVICE,
 * HPR_ERR_INTERRUPTED, those of the sink.
 */
hpr_status hpr_form_factors_stream(const hpr_rows *rows, double tolerance, const hpr_factor_sink *sink,
                                   hpr_pairs_done *done);

typedef struct hpr_form_factors {
    hpr_context *context;
    size_t count;
    double *area_m2;  /* [count] */
    double *exchange; /* A_i F_ij for j >= i, row after row: see hpr_form_factors_at */
    hpr_pairs_done done;
} hpr_form_factors;

/* Memory that create takes for this many rows, bytes. */
double hpr_form_factors_bytes(size_t row_count);

/* The same, kept. Errors: as above. */
hpr_status hpr_form_factors_create(const hpr_rows *rows, double tolerance, hpr_form_factors **factors);
void hpr_form_factors_destroy(hpr_form_factors **factors);

/* A_i F_ij, in any order of i and j. */
double hpr_form_factors_at(const hpr_form_factors *factors, size_t i, size_t j);

/* row[count] = F_ij for all j; zero where A_i is. */
void hpr_form_factors_row(const hpr_form_factors *factors, size_t i, double *row);

#endif
