/* Model file -> view factors or kernel blocks, and the table of surfaces. */
#include "app/factor_stream.h"
#include "app/job.h"
#include "app/names.h"
#include "basis/basis.h"
#include "io/factors_report.h"
#include "io/vs3_read.h"
#include "solver/exchange.h"

#include <math.h>
#include <string.h>
#include <strings.h>

static const double default_tolerance = 1e-9;

/* An entry outside [0, 1] by more is no rounding. */
static const double rounding = 1e-14;

typedef enum format { FORMAT_NPY, FORMAT_CSV, FORMAT_TEXT } format;

/* One run of the job, from the names to the numbers. */
typedef struct work {
    hpr_job job;
    const hpr_job_form_factors_options *options;
    const char *model_path;
    char *output_path, *table_path;
    format output_format;
    double tolerance;
    bool closed, wants_exchange;
    hpr_rows *rows;
    bool streamed; /* view factors go to their file at once, or */
    hpr_factor_stream stream;
    hpr_form_factors *factors; /* are kept; or */
    double *block;             /* kernel blocks, or */
    double *exchange;          /* script-F beside the factors */
    double *row_sum;           /* [rows->count] of F */
    size_t outside_count;      /* factors outside [0, 1] */
    hpr_pairs_done done;
} work;

void hpr_job_form_factors_options_init(hpr_job_form_factors_options *options)
{
    *options = (hpr_job_form_factors_options){.tolerance = default_tolerance, .order = -1};
    hpr_read_options_init(&options->read);
}

static bool has_extension(const char *path, const char *extension)
{
    size_t length = strlen(path), tail = strlen(extension);
    return length >= tail && !strcasecmp(path + length - tail, extension);
}

static hpr_status check_options(work *w)
{
    hpr_context *ctx = w->job.context;
    const hpr_job_form_factors_options *options = w->options;
    if (!(options->tolerance > 0 && options->tolerance < 1))
        return hpr_fail(ctx, HPR_ERR_ARG, "tolerance %g: expected above 0 and below 1", options->tolerance);
    if (options->order < -1 || options->order > HPR_MAX_DEGREE)
        return hpr_fail(ctx, HPR_ERR_ARG, "order %d: expected 0 to %d, or -1 for view factors",
                        options->order, HPR_MAX_DEGREE);
    const char *path = w->output_path;
    if (has_extension(path, ".npy"))
        w->output_format = FORMAT_NPY;
    else if (has_extension(path, ".csv"))
        w->output_format = FORMAT_CSV;
    else if (has_extension(path, ".txt"))
        w->output_format = FORMAT_TEXT;
    else
        return hpr_fail(ctx, HPR_ERR_ARG, "output '%s': expected a name that ends in .npy, .csv or .txt",
                        path);
    if (options->order >= 0 && w->output_format != FORMAT_NPY)
        return hpr_fail(ctx, HPR_ERR_ARG, "output '%s': kernel blocks (an order) go to .npy only", path);
    return HPR_OK;
}

static hpr_status claim_outputs(work *w)
{
    hpr_context *ctx = w->job.context;
    const char *path = w->options->output_path;
    w->output_path = path ? hpr_duplicate_text(ctx, path) : hpr_name_default(ctx, w->model_path, ".npy");
    if (!w->output_path)
        return hpr_fail(ctx, HPR_ERR_MEMORY, "out of memory for a file name");
    hpr_status status = check_options(w);
    if (status != HPR_OK)
        return status;
    w->table_path = hpr_name_beside(ctx, w->output_path, ".surfaces.csv");
    if (!w->table_path)
        return hpr_fail(ctx, HPR_ERR_MEMORY, "out of memory for a file name");
    hpr_outputs_input(&w->job.outputs, w->model_path);
    status = hpr_outputs_claim(&w->job.outputs, w->output_path);
    if (status == HPR_OK)
        status = hpr_outputs_claim(&w->job.outputs, w->table_path);
    if (status == HPR_OK && w->options->report_path)
        status = hpr_outputs_claim(&w->job.outputs, w->options->report_path);
    return status;
}

static hpr_status read_vs3(work *w)
{
    hpr_model *model = NULL;
    hpr_status status = hpr_job_enter(&w->job, HPR_JOB_READ);
    if (status != HPR_OK)
        return status;
    hpr_stage_begin(w->job.context, "read");
    status = hpr_vs3_read(w->job.context, w->model_path, &model);
    hpr_stage_end(w->job.context);
    if (status == HPR_OK)
        status = hpr_rows_of_model(model, &w->rows);
    if (status == HPR_OK) {
        w->closed = model->closed;
        w->wants_exchange = model->exchange;
        if (w->options->use_eps && model->tolerance > 0)
            w->tolerance = model->tolerance;
        if (w->options->order >= 0 && model->exchange)
            hpr_warn(w->job.context, "%s: emit=1 has no effect on kernel blocks", w->model_path);
    }
    hpr_model_destroy(&model);
    return status;
}

static hpr_status read_gltf(work *w)
{
    hpr_scene *scene = NULL;
    hpr_status status = hpr_job_read_scene(&w->job, w->model_path, &w->options->read, &scene);
    if (status == HPR_OK)
        status = hpr_rows_of_scene(scene, &w->rows);
    hpr_scene_destroy(&scene);
    return status;
}

static hpr_status read_model(work *w)
{
    hpr_status status = has_extension(w->model_path, ".vs3") ? read_vs3(w) : read_gltf(w);
    if (status != HPR_OK)
        return status;
    w->job.result->row_count = w->rows->count;
    if (!w->rows->count)
        return hpr_fail(w->job.context, HPR_ERR_FORMAT, "%s: no surface that could have a view factor",
                        w->model_path);
    uint32_t composite = w->options->order >= 0 ? hpr_rows_composite(w->rows) : HPR_NONE;
    if (composite != HPR_NONE)
        return hpr_fail(w->job.context, HPR_ERR_UNSUPPORTED,
                        "%s: row %u '%.60s' is not one parallelogram or triangle, so it has no kernel blocks",
                        w->model_path, composite, w->rows->row[composite].name);
    return HPR_OK;
}

static double block_count(const work *w)
{
    double functions = (double)hpr_form_blocks_size(w->rows, w->options->order);
    double rows = (double)w->rows->count;
    return rows * rows * functions * functions;
}

/* Tiles need a file in which one may jump, script-F and lines of text the whole matrix. */
static bool may_stream(const work *w)
{
    return w->options->order < 0 && w->output_format == FORMAT_NPY && !w->wants_exchange &&
           !hpr_atomic_is_direct(w->output_path);
}

static hpr_status check_memory(work *w)
{
    size_t n = w->rows->count;
    double machine = hpr_machine_bytes();
    double needed = 0;
    w->streamed = may_stream(w);
    if (w->options->order >= 0)
        needed = block_count(w) * sizeof(double);
    else
        needed =
            (w->streamed ? 0 : hpr_form_factors_bytes(n)) + (w->wants_exchange ? hpr_exchange_bytes(n) : 0);
    if (needed > 0.9 * machine)
        return hpr_fail(w->job.context, HPR_ERR_MEMORY,
                        "%zu surfaces need %.3g GB for their %s, this machine has %.3g GB", n, 1e-9 * needed,
                        w->options->order >= 0 ? "kernel blocks" : "view factors", 1e-9 * machine);
    if (w->options->planned)
        w->options->planned(w->options->events.user, n, needed);
    return HPR_OK;
}

/* F_ij out of block K_ij: K^00 = sqrt(A_i / A_j) F_ij. */
static void fetch_block_factors(const work *w, size_t i, double *line)
{
    size_t n = hpr_form_blocks_size(w->rows, w->options->order), count = w->rows->count;
    for (size_t j = 0; j < count; j++) {
        double head = w->block[(i * count + j) * n * n];
        line[j] = head != 0 ? sqrt(w->rows->row[j].area_m2 / w->rows->row[i].area_m2) * head : 0;
    }
}

static void warn_unclosed(const work *w)
{
    size_t worst = 0, n = w->rows->count;
    for (size_t i = 0; i < n; i++) {
        bool counts = w->rows->row[i].area_m2 > 0;
        if (counts && !(fabs(w->row_sum[i] - 1) <= fabs(w->row_sum[worst] - 1)))
            worst = i;
    }
    double slack = 2 * w->tolerance + 1e-12;
    if (w->rows->row[worst].area_m2 > 0 && !(fabs(w->row_sum[worst] - 1) <= slack))
        hpr_warn(w->job.context,
                 "%s: not closed as it says (encl=1): row %zu '%.60s' sums to %.12g; nothing was adjusted",
                 w->model_path, worst, w->rows->row[worst].name, w->row_sum[worst]);
}

/* Largest |sum_j sqrt(A_j) K_ij^{k0} / sqrt(A_i) - delta_k0| of the rows with area. */
static double closure_defect(const work *w)
{
    size_t count = w->rows->count, n = w->block ? hpr_form_blocks_size(w->rows, w->options->order) : 1;
    double worst = 0;
    for (size_t i = 0; i < count; i++) {
        double area = w->rows->row[i].area_m2;
        for (size_t k = 0; k < n && area > 0; k++) {
            double sum = k ? 0 : w->row_sum[i];
            for (size_t j = 0; j < count && k; j++)
                sum += sqrt(w->rows->row[j].area_m2 / area) * w->block[((i * count + j) * n + k) * n];
            worst = fmax(worst, fabs(sum - (k == 0)));
        }
    }
    return worst;
}

/* Sums the rows of F; how many factors are impossible. */
static hpr_status sum_rows(work *w)
{
    hpr_context *ctx = w->job.context;
    size_t n = w->rows->count;
    double *line = NULL;
    hpr_status status = hpr_allocate_into(ctx, &line, n, sizeof *line, "row sums");
    for (size_t i = 0; status == HPR_OK && i < n; i++) {
        if (w->factors)
            hpr_form_factors_row(w->factors, i, line);
        else
            fetch_block_factors(w, i, line);
        for (size_t j = 0; j < n; j++) {
            w->row_sum[i] += line[j];
            w->outside_count += !(line[j] >= -rounding && line[j] <= 1 + rounding);
        }
    }
    hpr_release(ctx, line);
    return status;
}

/* Checks that nothing is impossible. */
static void judge(work *w)
{
    hpr_job_result *result = w->job.result;
    if (w->outside_count)
        hpr_warn(w->job.context, "%s: %zu view factors are outside [0, 1] by more than %g", w->model_path,
                 w->outside_count, rounding);
    result->pair_count = w->done.pair_count;
    result->short_count = w->done.short_count;
    result->outside_count = w->outside_count;
    result->closure_defect = closure_defect(w);
    if (w->closed)
        warn_unclosed(w);
}

static hpr_status make_exchange(work *w)
{
    hpr_context *ctx = w->job.context;
    size_t n = w->rows->count;
    double *emissivity = NULL;
    hpr_stage_begin(ctx, "script-F");
    hpr_status status = hpr_allocate_into(ctx, &w->exchange, n * n, sizeof *w->exchange, "exchange factors");
    if (status == HPR_OK)
        status = hpr_allocate_into(ctx, &emissivity, n, sizeof *emissivity, "exchange factors");
    for (size_t i = 0; status == HPR_OK && i < n; i++)
        emissivity[i] = w->rows->row[i].emissivity;
    if (status == HPR_OK)
        status = hpr_exchange_factors(w->factors, emissivity, w->exchange);
    hpr_release(ctx, emissivity);
    hpr_stage_end(ctx);
    return status;
}

static hpr_status stream_factors(work *w)
{
    hpr_status status = hpr_factor_stream_open(w->rows, w->output_path, rounding, &w->stream);
    if (status == HPR_OK)
        status = hpr_factor_stream_run(&w->stream, w->tolerance, w->row_sum, &w->done);
    w->outside_count = w->stream.outside;
    return status;
}

static hpr_status keep_factors(work *w)
{
    hpr_status status = hpr_form_factors_create(w->rows, w->tolerance, &w->factors);
    if (status != HPR_OK)
        return status;
    w->done = w->factors->done;
    return sum_rows(w);
}

static hpr_status keep_blocks(work *w)
{
    hpr_status status = hpr_allocate_into(w->job.context, &w->block, (size_t)block_count(w), sizeof *w->block,
                                          "kernel blocks");
    if (status == HPR_OK)
        status = hpr_form_blocks(w->rows, w->options->order, w->tolerance, w->block, &w->done);
    return status == HPR_OK ? sum_rows(w) : status;
}

static hpr_status integrate(work *w)
{
    hpr_context *ctx = w->job.context;
    hpr_status status = hpr_job_enter(&w->job, HPR_JOB_SOLVE);
    if (status == HPR_OK)
        status = hpr_allocate_into(ctx, &w->row_sum, w->rows->count, sizeof *w->row_sum, "row sums");
    if (status != HPR_OK)
        return status;
    bool blocks = w->options->order >= 0;
    hpr_stage_begin(ctx, blocks ? "kernel blocks" : "view factors");
    status = blocks ? keep_blocks(w) : w->streamed ? stream_factors(w) : keep_factors(w);
    hpr_stage_end(ctx);
    if (status == HPR_OK)
        judge(w);
    if (status == HPR_OK && w->factors && w->wants_exchange)
        status = make_exchange(w);
    return status;
}

static void fetch_factors(const void *data, size_t i, double *line)
{
    hpr_form_factors_row(((const work *)data)->factors, i, line);
}

static void fetch_exchange(const void *data, size_t i, double *line)
{
    const work *w = data;
    memcpy(line, w->exchange + i * w->rows->count, w->rows->count * sizeof *line);
}

static hpr_status write_matrix(work *w)
{
    hpr_context *ctx = w->job.context;
    size_t count = w->rows->count;
    const hpr_factor_source source = {
        .count = count, .fetch = w->exchange ? fetch_exchange : fetch_factors, .data = w};
    if (w->streamed)
        return hpr_factor_stream_close(&w->stream, HPR_OK);
    if (w->block) {
        size_t n = hpr_form_blocks_size(w->rows, w->options->order);
        return hpr_array_write_npy(ctx, w->output_path, 4, (const size_t[]){count, count, n, n}, w->block);
    }
    switch (w->output_format) {
    case FORMAT_CSV:
        return hpr_factors_write_csv(ctx, w->output_path, &source);
    case FORMAT_TEXT:
        return hpr_factors_write_text(ctx, w->output_path, &source, w->rows, w->closed, w->exchange != NULL);
    default:
        return hpr_factors_write_npy(ctx, w->output_path, &source);
    }
}

static hpr_status write_report(work *w)
{
    const char *path = w->options->report_path;
    const hpr_factors_report report = {.model_path = w->model_path,
                                       .tolerance = w->tolerance,
                                       .order = w->options->order,
                                       .row_count = w->rows->count,
                                       .pair_count = w->done.pair_count,
                                       .blocked_count = w->done.blocked_count,
                                       .rounded_count = w->done.rounded_count,
                                       .short_count = w->done.short_count,
                                       .outside_count = w->job.result->outside_count,
                                       .relative_error = w->done.relative_error,
                                       .sampled_error = w->done.sampled_error,
                                       .closed = w->closed,
                                       .closure_defect = w->job.result->closure_defect};
    if (!path)
        return HPR_OK;
    hpr_status status = hpr_factors_report_write(w->job.context, &report, path);
    if (status == HPR_OK)
        hpr_job_wrote(&w->job, &(hpr_job_file){.kind = HPR_JOB_FILE_REPORT, .path = path});
    return status;
}

static hpr_status write_outputs(work *w)
{
    hpr_context *ctx = w->job.context;
    hpr_status status = hpr_job_enter(&w->job, HPR_JOB_WRITE);
    if (status != HPR_OK)
        return status;
    hpr_stage_begin(ctx, "write");
    status = write_matrix(w);
    if (status == HPR_OK) {
        hpr_job_wrote(&w->job, &(hpr_job_file){.kind = HPR_JOB_FILE_FACTORS, .path = w->output_path});
        status = hpr_surfaces_write(ctx, w->table_path, w->rows, w->row_sum);
    }
    hpr_stage_end(ctx);
    if (status != HPR_OK)
        return status;
    hpr_job_wrote(&w->job, &(hpr_job_file){.kind = HPR_JOB_FILE_TABLE, .path = w->table_path});
    status = write_report(w);
    if (status == HPR_OK && w->done.short_count)
        return hpr_fail(
            ctx, HPR_ERR_TOLERANCE,
            "%s: %zu of %zu pairs of patches stopped short of the tolerance %g; the result is written",
            w->model_path, w->done.short_count, w->done.pair_count, w->tolerance);
    return status;
}

hpr_status hpr_job_form_factors(hpr_context *ctx, const char *model_path,
                                const hpr_job_form_factors_options *options, hpr_job_result *result)
{
    hpr_job_form_factors_options defaults;
    hpr_job_form_factors_options_init(&defaults);
    if (!options)
        options = &defaults;
    work w = {.options = options, .model_path = model_path, .tolerance = options->tolerance};
    hpr_job_begin(&w.job, ctx, &options->events, result);
    hpr_status status = claim_outputs(&w);
    if (status == HPR_OK)
        status = read_model(&w);
    if (status == HPR_OK)
        status = check_memory(&w);
    if (status == HPR_OK)
        status = integrate(&w);
    if (status == HPR_OK)
        status = write_outputs(&w);
    if (w.streamed)
        status = hpr_factor_stream_close(&w.stream, status);
    hpr_form_factors_destroy(&w.factors);
    hpr_rows_destroy(&w.rows);
    void *arrays[] = {w.output_path, w.table_path, w.block, w.exchange, w.row_sum};
    for (size_t i = 0; i < sizeof arrays / sizeof *arrays; i++)
        hpr_release(ctx, arrays[i]);
    return hpr_job_end(&w.job, status);
}
