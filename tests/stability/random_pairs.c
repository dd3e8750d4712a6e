/*
 * Random facets through hpr_job_form_factors: random_pairs COUNT [SEED]. Touching, crossing, coplanar,
 * degenerate, huge, tiny, hardly apart, non-finite. Whatever is finite gives 0 <= F <= 1 without clamping,
 * what is not is refused, nothing crashes. Many pairs are to be run under sanitizers: ./dev fuzz.
 */
#include "convex_room.h"

#include <hprad/hprad.h>
#include <stdio.h>
#include <stdlib.h>
#include <unistd.h>

enum { FACETS_MAX = 5, TEXT_MAX = 8192, RELATIONS = 13, FAILURES_TOLD = 5 };

/* An entry outside [0, 1] by more is no rounding. */
static const double rounding = 1e-14;

typedef struct facet {
    int count;
    double corner[4][3];
} facet;

typedef struct run {
    uint64_t seed;
    char model[600], matrix[600], table[600], text[TEXT_MAX];
    long pairs, models, refused, short_of, nonfinite;
    int failures;
} run;

static double uniform(run *r, double low, double high)
{
    return low + (high - low) * convex_random(&r->seed);
}

static int any(run *r, int count)
{
    return (int)(count * convex_random(&r->seed));
}

static double power(run *r, double low, double high)
{
    return pow(10, uniform(r, low, high));
}

static void point(run *r, double size, double x[3])
{
    for (int k = 0; k < 3; k++)
        x[k] = uniform(r, -size, size);
}

static void between(const double a[3], const double b[3], double f, double x[3])
{
    for (int k = 0; k < 3; k++)
        x[k] = a[k] + f * (b[k] - a[k]);
}

/* Corners after the second from these: a triangle, a parallelogram or a trapezium. */
static void finish(run *r, facet *f)
{
    double *c3 = f->corner[3];
    f->count = any(r, 2) ? 3 : 4;
    double share = any(r, 2) ? 1 : uniform(r, 0.1, 1);
    for (int k = 0; k < 3; k++)
        c3[k] = f->corner[2][k] + share * (f->corner[0][k] - f->corner[1][k]);
}

static void random_facet(run *r, double size, facet *f)
{
    double middle[3];
    point(r, 1, middle);
    for (int i = 0; i < 3; i++) {
        point(r, size, f->corner[i]);
        for (int k = 0; k < 3; k++)
            f->corner[i][k] += middle[k];
    }
    finish(r, f);
}

static void normal_of(const facet *f, double n[3])
{
    double u[3], v[3], length = 0;
    for (int k = 0; k < 3; k++) {
        u[k] = f->corner[1][k] - f->corner[0][k];
        v[k] = f->corner[2][k] - f->corner[0][k];
    }
    for (int k = 0; k < 3; k++) {
        n[k] = u[(k + 1) % 3] * v[(k + 2) % 3] - u[(k + 2) % 3] * v[(k + 1) % 3];
        length += n[k] * n[k];
    }
    for (int k = 0; k < 3; k++)
        n[k] = length > 0 ? n[k] / sqrt(length) : k == 0;
}

static void turn_over(facet *f)
{
    double keep[3];
    memcpy(keep, f->corner[0], sizeof keep);
    memcpy(f->corner[0], f->corner[2], sizeof keep);
    memcpy(f->corner[2], keep, sizeof keep);
}

/* A copy of `a`, moved along its normal by `gap` and in its plane. */
static void shift(run *r, const facet *a, double gap, double aside, facet *b)
{
    double n[3], f = uniform(r, -aside, aside);
    normal_of(a, n);
    *b = *a;
    for (int i = 0; i < b->count; i++) {
        for (int k = 0; k < 3; k++)
            b->corner[i][k] += gap * n[k] + f * (a->corner[1][k] - a->corner[0][k]);
    }
    if (any(r, 4))
        turn_over(b);
}

/* A facet on the edge from corner 1 to corner 0 of `a`, all of it or a part, or past it. */
static void on_edge(run *r, const facet *a, bool part, facet *b)
{
    double n[3], lift = any(r, 2) ? power(r, -17, 0) : uniform(r, -1, 1);
    normal_of(a, n);
    between(a->corner[0], a->corner[1], part ? uniform(r, 0.5, 1.5) : 1, b->corner[0]);
    between(a->corner[0], a->corner[1], part ? uniform(r, -0.5, 0.5) : 0, b->corner[1]);
    /* over the facet or beside it, from flat to upright */
    between(a->corner[0], a->corner[2], uniform(r, -1, 1), b->corner[2]);
    for (int k = 0; k < 3; k++)
        b->corner[2][k] += lift * n[k];
    finish(r, b);
}

static void related_facet(run *r, const facet *a, facet *b)
{
    random_facet(r, 1, b);
    switch (any(r, RELATIONS)) {
    case 0:
        break;
    case 1:
        memcpy(b->corner[0], a->corner[any(r, a->count)], sizeof b->corner[0]);
        finish(r, b);
        break;
    case 2:
        on_edge(r, a, false, b);
        break;
    case 3:
        on_edge(r, a, true, b);
        break;
    case 4: /* through its middle */
        between(a->corner[1], a->corner[2], 0.5, b->corner[0]);
        between(a->corner[0], b->corner[0], uniform(r, 0, 2), b->corner[0]);
        for (int k = 0; k < 3; k++)
            b->corner[2][k] = 2 * b->corner[0][k] - b->corner[1][k] + uniform(r, -0.5, 0.5);
        finish(r, b);
        break;
    case 5:
        shift(r, a, power(r, -17, 1), any(r, 2), b);
        break;
    case 6: /* in its plane */
        shift(r, a, 0, 2, b);
        break;
    case 7:
        shift(r, a, 0, 0, b);
        break;
    case 8: /* tiny, somewhere near */
        random_facet(r, power(r, -9, 0), b);
        break;
    case 9: /* slender or without area */
        between(b->corner[0], b->corner[1], uniform(r, -1, 2), b->corner[2]);
        b->corner[2][any(r, 3)] += any(r, 3) ? power(r, -17, -1) : 0;
        finish(r, b);
        break;
    case 10:
        memcpy(b->corner[2], b->corner[any(r, 2)], sizeof b->corner[2]);
        finish(r, b);
        break;
    case 11: /* far */
        shift(r, b, power(r, 0, 12), 0, b);
        break;
    default: /* on a grid, where much coincides */
        for (int i = 0; i < 3; i++) {
            for (int k = 0; k < 3; k++)
                b->corner[i][k] = 0.5 * any(r, 3);
        }
        finish(r, b);
    }
}

static double any_scale(run *r)
{
    static const double extreme[] = {1e-310, 1e-300, 1e-150, 1e-80, 1e80, 1e150, 1e300};
    switch (any(r, 4)) {
    case 0:
        return power(r, -8, 8);
    case 1:
        return any(r, 4) ? 1 : extreme[any(r, 7)];
    default:
        return 1;
    }
}

/* The model's text; true if all its numbers are finite. */
static bool make_model(run *r, int count)
{
    static const char *const other[] = {"nan", "inf", "-inf", "1e999"};
    facet f[FACETS_MAX];
    double scale = any_scale(r), offset = any(r, 8) ? 0 : power(r, 0, 9);
    int broken = any(r, 200) ? -1 : any(r, 3 * count), corners = 0;
    random_facet(r, any(r, 2) ? 1 : power(r, -3, 3), &f[0]);
    for (int i = 1; i < count; i++)
        related_facet(r, &f[any(r, i)], &f[i]);
    char *at = r->text, *end = r->text + TEXT_MAX;
    bool finite = true;
    at += snprintf(at, (size_t)(end - at), "F 3\n");
    for (int i = 0; i < count; i++) {
        int first = corners + 1;
        for (int c = 0; c < f[i].count; c++) {
            at += snprintf(at, (size_t)(end - at), "V %d", ++corners);
            for (int k = 0; k < 3; k++) {
                double x = scale * (f[i].corner[c][k] + offset);
                bool whole = isfinite(x) && !(corners == broken + 1 && k == 1);
                finite &= whole;
                if (whole)
                    at += snprintf(at, (size_t)(end - at), " %.17g", x);
                else
                    at += snprintf(at, (size_t)(end - at), " %s", other[any(r, 4)]);
            }
            at += snprintf(at, (size_t)(end - at), "\n");
        }
        at += snprintf(at, (size_t)(end - at), "S %d %d %d %d %d 0 0 0.5 s%d\n", i + 1, first, first + 1,
                       first + 2, f[i].count == 4 ? first + 3 : 0, i + 1);
    }
    return finite;
}

static void complain(run *r, const char *what, const char *text)
{
    if (r->failures++ < FAILURES_TOLD)
        fprintf(stderr, "%s: %s\n%s\n", what, text, r->text);
}

/* The matrix as it was written; false if that is not what it should be. */
static bool read_matrix(const run *r, int count, double *matrix)
{
    unsigned char head[10];
    FILE *file = fopen(r->matrix, "rb");
    size_t wanted = (size_t)(count * count);
    bool good = file && fread(head, 1, sizeof head, file) == sizeof head &&
                fseek(file, 10 + head[8] + 256 * head[9], SEEK_SET) == 0 &&
                fread(matrix, sizeof *matrix, wanted, file) == wanted && fgetc(file) == EOF;
    if (file)
        fclose(file);
    return good;
}

static void check_matrix(run *r, int count)
{
    double matrix[FACETS_MAX * FACETS_MAX];
    if (!read_matrix(r, count, matrix)) {
        complain(r, "matrix", "not readable");
        return;
    }
    for (int i = 0; i < count * count; i++) {
        char text[96];
        snprintf(text, sizeof text, "F[%d][%d] = %.17g", i / count, i % count, matrix[i]);
        if (!(matrix[i] >= 0 && matrix[i] <= 1 + rounding)) {
            complain(r, "outside [0, 1]", text);
            return;
        }
    }
}

static void one_model(run *r, hpr_context *context)
{
    static const double tolerances[] = {1e-4, 1e-6, 1e-9};
    int count = any(r, 16) ? 2 : 3 + any(r, FACETS_MAX - 2);
    bool finite = make_model(r, count);
    hpr_job_form_factors_options options;
    hpr_job_form_factors_options_init(&options);
    options.output_path = r->matrix;
    options.tolerance = tolerances[count > 2 ? 0 : any(r, 3)];
    FILE *file = fopen(r->model, "w");
    if (!file || fputs(r->text, file) < 0 || fclose(file)) {
        complain(r, "model", "not written");
        return;
    }
    hpr_status status = hpr_job_form_factors(context, r->model, &options, NULL);
    r->models++;
    r->nonfinite += !finite;
    if (!finite && status != HPR_ERR_FORMAT)
        complain(r, "not finite, and taken", hpr_status_string(status));
    if (!finite)
        return;
    if (status != HPR_OK && status != HPR_ERR_TOLERANCE) {
        r->refused++;
        if (status != HPR_ERR_FORMAT && status != HPR_ERR_UNSUPPORTED)
            complain(r, hpr_status_string(status), hpr_context_error(context));
        return;
    }
    r->short_of += status == HPR_ERR_TOLERANCE;
    r->pairs += count * (count - 1) / 2;
    check_matrix(r, count);
}

static hpr_context *make_context(void)
{
    hpr_context_options options;
    hpr_context *context = NULL;
    hpr_context_options_init(&options);
    options.threads = 1;
    return hpr_context_create(&options, &context) == HPR_OK ? context : NULL;
}

int main(int argc, char **argv)
{
    enum { MODELS_PER_CONTEXT = 500 };
    static run r;
    char folder[512];
    const char *parent = access("/dev/shm", W_OK) == 0 ? "/dev/shm" : "/tmp"; /* no waiting for a disk */
    long wanted = argc > 1 ? atol(argv[1]) : 0;
    r.seed = argc > 2 ? strtoull(argv[2], NULL, 10) : 1;
    snprintf(folder, sizeof folder, "%s/random_pairs_XXXXXX", parent);
    if (wanted < 1 || !mkdtemp(folder)) {
        fprintf(stderr, "random_pairs COUNT [SEED], and a writable %s\n", parent);
        return 2;
    }
    snprintf(r.model, sizeof r.model, "%s/pair.vs3", folder);
    snprintf(r.matrix, sizeof r.matrix, "%s/pair.npy", folder);
    snprintf(r.table, sizeof r.table, "%s/pair.surfaces.csv", folder);
    hpr_context *context = NULL;
    while (r.pairs < wanted) {
        if (r.models % MODELS_PER_CONTEXT == 0) {
            hpr_context_destroy(&context);
            context = make_context();
        }
        if (!context)
            return 2;
        one_model(&r, context);
    }
    hpr_context_destroy(&context);
    unlink(r.model);
    unlink(r.matrix);
    unlink(r.table);
    rmdir(folder);
    printf("%ld pairs in %ld models: %ld not finite, %ld refused, %ld short of the tolerance; %d failures\n",
           r.pairs, r.models, r.nonfinite, r.refused, r.short_of, r.failures);
    return r.failures != 0;
}
