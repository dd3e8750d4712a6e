#include "baseline/matrix.h"

#include "math/dense.h"

#include <float.h>
#include <math.h>
#include <string.h>

static size_t value_count(const hpr_matrix_problem *p)
{
    return p->count * p->channel_count;
}

/* sum_j F_ij (M_j + rho_j H_j), in the order of j. */
static double gather(const hpr_matrix_problem *p, size_t i, size_t channel)
{
    size_t first = channel * p->count;
    const double *row = p->factor + i * p->count, *rho = p->reflectance + first, *m = p->exitance + first,
                 *h = p->irradiance + first;
    double sum = 0;
    for (size_t j = 0; j < p->count; j++)
        sum += row[j] * (m[j] + rho[j] * h[j]);
    return sum;
}

static void gather_all(const hpr_matrix_problem *p, double *fresh)
{
    size_t values = value_count(p);
#pragma omp parallel for schedule(static) num_threads(hpr_context_threads(p->context))
    for (size_t k = 0; k < values; k++)
        fresh[k] = gather(p, k % p->count, k / p->count);
}

/* |fresh - H| / |fresh|, area-weighted, the worst channel's. */
static double difference(const hpr_matrix_problem *p, const double *fresh)
{
    double worst = 0;
    for (size_t c = 0; c < p->channel_count; c++) {
        double change2 = 0, norm2 = 0;
        for (size_t i = 0; i < p->count; i++) {
            double now = fresh[c * p->count + i], change = now - p->irradiance[c * p->count + i];
            change2 += p->area_m2[i] * change * change;
            norm2 += p->area_m2[i] * now * now;
        }
        if (change2 > 0)
            worst = fmax(worst, sqrt(change2 / norm2));
    }
    return worst;
}

/* One pass; room [channel_count][count]. Returns the relative change. */
static double sweep(const hpr_matrix_problem *p, double *room)
{
    size_t bytes = value_count(p) * sizeof *room;
    double change;
    if (p->used == HPR_SOLVER_GATHERING) {
        gather_all(p, room);
        change = difference(p, room);
        memcpy(p->irradiance, room, bytes);
        return change;
    }
    memcpy(room, p->irradiance, bytes);
#pragma omp parallel for schedule(static) num_threads(hpr_context_threads(p->context))
    for (size_t c = 0; c < p->channel_count; c++) {
        for (size_t i = 0; i < p->count; i++)
            p->irradiance[c * p->count + i] = gather(p, i, c);
    }
    return difference(p, room); /* relative to the old values, which is the same near the end */
}

static hpr_status no_convergence(const hpr_matrix_problem *p, double change)
{
    return hpr_fail(
        p->context, HPR_ERR_NUMERIC,
        "no convergence after %d %s (relative change %.3g): where nothing is absorbed and nothing "
        "escapes there is no finite solution; --max-reflectance 0.99 scales such materials down",
        p->sweeps, p->used == HPR_SOLVER_SHOOTING ? "shots" : "sweeps", change);
}

static hpr_status interrupted(const hpr_matrix_problem *p)
{
    return hpr_fail(p->context, HPR_ERR_INTERRUPTED, "interrupted while solving");
}

/* Until the error foreseen from the last two changes, |change| q / (1 - q), q their ratio, is within the
 * tolerance, or a change is rounding. Source: Golub & Van Loan 2013, 11.2. */
static hpr_status iterate(hpr_matrix_problem *p)
{
    static const double rounding = 4 * DBL_EPSILON;
    double *room = NULL, change = 0, before = 0;
    hpr_status status = hpr_allocate_into(p->context, &room, value_count(p), sizeof *room, "the solver");
    bool done = false;
    while (status == HPR_OK && !done && p->sweeps < p->max_sweeps) {
        change = sweep(p, room);
        p->sweeps++;
        double ratio = before > 0 ? change / before : 0;
        done = change <= rounding ||
               (p->sweeps > 2 && ratio < 1 && change * ratio / (1 - ratio) <= p->tolerance);
        before = change;
        hpr_stage_progress(p->context, fmin(0.99, log(fmin(change, 1)) / log(p->tolerance)));
        if (hpr_cancelled(p->context))
            status = interrupted(p);
    }
    if (status == HPR_OK && !done)
        status = no_convergence(p, change);
    hpr_release(p->context, room);
    return status;
}

typedef struct shooter {
    hpr_matrix_problem *p;
    double *unshot; /* [channel_count][count] dB, W/m2 */
    double *power;  /* [count] sum over the channels of A dB */
} shooter;

static double power_of(const shooter *s, size_t i)
{
    double sum = 0;
    for (size_t c = 0; c < s->p->channel_count; c++)
        sum += s->unshot[c * s->p->count + i];
    return sum * s->p->area_m2[i];
}

static void shoot_from(shooter *s, size_t i)
{
    const hpr_matrix_problem *p = s->p;
    for (size_t c = 0; c < p->channel_count; c++) {
        size_t first = c * p->count;
        double unshot = s->unshot[first + i];
        s->unshot[first + i] = 0;
        for (size_t j = 0; j < p->count; j++) {
            double received = p->factor[j * p->count + i] * unshot;
            p->irradiance[first + j] += received;
            s->unshot[first + j] += p->reflectance[first + j] * received;
        }
    }
    for (size_t j = 0; j < p->count; j++)
        s->power[j] = power_of(s, j);
}

/* The element with the most unshot power, the first of equals; *total of all. */
static size_t brightest(const shooter *s, double *total)
{
    size_t best = 0;
    *total = 0;
    for (size_t i = 0; i < s->p->count; i++) {
        *total += s->power[i];
        best = s->power[i] > s->power[best] ? i : best;
    }
    return best;
}

/* Power received so far, of all channels. */
static double received_power(const hpr_matrix_problem *p)
{
    double sum = 0;
    for (size_t k = 0; k < value_count(p); k++)
        sum += p->area_m2[k % p->count] * p->irradiance[k];
    return sum;
}

static double least_absorption(const hpr_matrix_problem *p)
{
    double most = 0;
    for (size_t k = 0; k < value_count(p); k++)
        most = fmax(most, p->reflectance[k]);
    return fmax(1 - most, 1e-3);
}

static hpr_status after_shot(const hpr_matrix_problem *p)
{
    if (hpr_cancelled(p->context))
        return interrupted(p);
    if (p->every > 0 && p->sweeps % p->every == 0)
        return p->shot(p->user, p->sweeps);
    return HPR_OK;
}

/* What is unshot adds at most its power / (1 - rho) to what is received. */
static hpr_status shoot(shooter *s)
{
    hpr_matrix_problem *p = s->p;
    double most = (double)p->max_sweeps * (double)p->count, absorption = least_absorption(p), first, rest;
    hpr_status status = HPR_OK;
    size_t next = brightest(s, &first);
    bool done = first == 0;
    for (rest = first; status == HPR_OK && !done && p->sweeps < most;) {
        shoot_from(s, next);
        p->sweeps++;
        status = after_shot(p);
        next = brightest(s, &rest);
        double left = rest / (absorption * received_power(p));
        done = p->shots ? p->sweeps >= p->shots || rest == 0 : left <= p->tolerance || rest == 0;
        double far = p->shots ? (double)p->sweeps / p->shots : log(fmin(left, 1)) / log(p->tolerance);
        hpr_stage_progress(p->context, fmin(0.99, far));
    }
    if (status == HPR_OK && !done)
        status = no_convergence(p, rest / first);
    return status;
}

static hpr_status solve_by_shooting(hpr_matrix_problem *p)
{
    shooter s = {.p = p};
    hpr_status status =
        hpr_allocate_into(p->context, &s.unshot, value_count(p), sizeof *s.unshot, "the solver");
    if (status == HPR_OK)
        status = hpr_allocate_into(p->context, &s.power, p->count, sizeof *s.power, "the solver");
    if (status == HPR_OK) {
        memcpy(s.unshot, p->exitance, value_count(p) * sizeof *s.unshot);
        for (size_t i = 0; i < p->count; i++)
            s.power[i] = power_of(&s, i);
        status = shoot(&s);
    }
    hpr_release(p->context, s.unshot);
    hpr_release(p->context, s.power);
    return status;
}

/* (I - F rho) H = F M, channel by channel: gather is F M while H is 0. */
static hpr_status eliminate(hpr_matrix_problem *p)
{
    size_t n = p->count;
    double *system = NULL;
    hpr_status status = hpr_allocate_into(p->context, &system, n * n, sizeof *system, "the matrix");
    if (status == HPR_OK)
        status = hpr_cancelled(p->context) ? interrupted(p) : HPR_OK;
    for (size_t c = 0; status == HPR_OK && c < p->channel_count; c++) {
        double *h = p->irradiance + c * n;
        for (size_t i = 0; i < n; i++) {
            for (size_t j = 0; j < n; j++)
                system[i * n + j] = (i == j) - p->factor[i * n + j] * p->reflectance[c * n + j];
        }
        double *right = NULL;
        status = hpr_allocate_into(p->context, &right, n, sizeof *right, "the matrix");
        for (size_t i = 0; status == HPR_OK && i < n; i++)
            right[i] = gather(p, i, c);
        if (status == HPR_OK) {
            if (!hpr_dense_solve(n, system, 1, right, hpr_context_threads(p->context)))
                status = hpr_fail(p->context, HPR_ERR_NUMERIC,
                                  "the matrix is singular: where nothing is absorbed and nothing escapes "
                                  "there is no finite solution; --max-reflectance 0.99 scales such materials "
                                  "down");
            memcpy(h, right, n * sizeof *h);
        }
        hpr_release(p->context, right);
        hpr_stage_progress(p->context, (double)(c + 1) / (double)p->channel_count);
    }
    hpr_release(p->context, system);
    return status;
}

hpr_status hpr_matrix_solve(hpr_matrix_problem *p)
{
    hpr_status status;
    p->sweeps = 0;
    p->used = p->method == HPR_SOLVER_AUTO ? HPR_SOLVER_GAUSS_SEIDEL : p->method;
    memset(p->irradiance, 0, value_count(p) * sizeof *p->irradiance);
    if (p->used == HPR_SOLVER_DIRECT)
        status = eliminate(p);
    else if (p->used == HPR_SOLVER_SHOOTING)
        status = solve_by_shooting(p);
    else
        status = iterate(p);
    double *fresh = NULL;
    if (status == HPR_OK)
        status = hpr_allocate_into(p->context, &fresh, value_count(p), sizeof *fresh, "the solver");
    if (status == HPR_OK) {
        gather_all(p, fresh);
        p->residual = difference(p, fresh);
    }
    hpr_release(p->context, fresh);
    return status;
}
