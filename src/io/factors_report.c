#include "io/factors_report.h"

#include "io/report_parts.h"

static void add_counts(cJSON *root, const hpr_context *ctx, const hpr_factors_report *report, bool *ok)
{
    cJSON *counts = hpr_json_object(root, "counts", ok);
    hpr_json_number(counts, "surfaces", (double)report->row_count, ok);
    hpr_json_number(counts, "pairs", (double)report->pair_count, ok);
    hpr_json_number(counts, "pairs_blocked", (double)report->blocked_count, ok);
    cJSON *counters = hpr_json_object(root, "counters", ok);
    hpr_json_number(counters, "kernel_evaluations", (double)hpr_counter_value(ctx, HPR_COUNT_KERNEL), ok);
    hpr_json_number(counters, "rays", (double)hpr_counter_value(ctx, HPR_COUNT_RAYS), ok);
    hpr_json_number(counters, "clips", (double)hpr_counter_value(ctx, HPR_COUNT_CLIPS), ok);
}

static void add_accuracy(cJSON *root, const hpr_factors_report *report, bool *ok)
{
    cJSON *quadrature = hpr_json_object(root, "quadrature", ok);
    hpr_json_number(quadrature, "relative_error", report->relative_error, ok);
    hpr_json_number(quadrature, "sampled_error", report->sampled_error, ok);
    hpr_json_number(quadrature, "pairs_rounded", (double)report->rounded_count, ok);
    hpr_json_number(quadrature, "pairs_short", (double)report->short_count, ok);
    hpr_json_number(quadrature, "outside", (double)report->outside_count, ok);
    cJSON *closure = hpr_json_object(root, "closure", ok);
    hpr_json_bool(closure, "closed", report->closed, ok);
    hpr_json_number(closure, "defect", report->closure_defect, ok);
}

hpr_status hpr_factors_report_write(hpr_context *ctx, const hpr_factors_report *report, const char *path)
{
    bool ok = true;
    hpr_context_clear_error(ctx);
    cJSON *root = cJSON_CreateObject();
    hpr_report_add_program(root, ctx, &ok);
    hpr_json_text(root, "model", report->model_path, &ok);
    cJSON *settings = hpr_json_object(root, "settings", &ok);
    hpr_json_number(settings, "tolerance", report->tolerance, &ok);
    if (report->order < 0)
        hpr_json_null(settings, "order", &ok);
    else
        hpr_json_number(settings, "order", report->order, &ok);
    add_counts(root, ctx, report, &ok);
    hpr_report_add_cost(root, ctx, &ok);
    add_accuracy(root, report, &ok);
    hpr_report_add_warnings(root, ctx, &ok);
    return hpr_report_save(ctx, root, ok, path);
}
