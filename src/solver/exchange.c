#include "solver/exchange.h"

#include "math/dense.h"

double hpr_exchange_bytes(size_t row_count)
{
    return 2 * (double)row_count * (double)row_count * sizeof(double);
}

hpr_status hpr_exchange_factors(const hpr_form_factors *factors, const double *emissivity, double *exchange)
{
    hpr_context *ctx = factors->context;
    size_t n = factors->count;
    double *system = NULL;
    hpr_status status = hpr_allocate_into(ctx, &system, n * n, sizeof *system, "exchange factors");
    if (status != HPR_OK)
        return status;
    for (size_t i = 0; i < n; i++) {
        double *row = exchange + i * n;
        hpr_form_factors_row(factors, i, row);
        for (size_t j = 0; j < n; j++)
            system[i * n + j] = (i == j) - row[j] * (1 - emissivity[j]);
    }
    if (!hpr_dense_solve(n, system, n, exchange, hpr_context_threads(ctx)))
        status =
            hpr_fail(ctx, HPR_ERR_NUMERIC,
                     "script-F does not exist: nothing absorbs in this closed model (emittances are zero)");
    for (size_t i = 0; status == HPR_OK && i < n; i++) {
        for (size_t j = 0; j < n; j++)
            exchange[i * n + j] *= emissivity[i] * emissivity[j];
    }
    hpr_release(ctx, system);
    return status;
}
