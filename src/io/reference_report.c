#include "io/reference_report.h"

#include "io/report_parts.h"

static void add_numbers(cJSON *parent, const char *key, const double *value, size_t count, bool *ok)
{
    cJSON *array = hpr_json_array(parent, key, ok);
    for (size_t i = 0; i < count; i++)
        hpr_json_number(array, NULL, value[i], ok);
}

static void add_run(cJSON *root, const hpr_reference_report *report, bool *ok)
{
    const hpr_reference *reference = report->reference;
    const hpr_patches *patches = reference->patches;
    size_t n = patches->channel_count;
    cJSON *settings = hpr_json_object(root, "settings", ok);
    hpr_json_number(settings, "samples", report->samples, ok);
    hpr_json_number(settings, "seed", (double)reference->seed, ok);
    add_numbers(settings, "environment", reference->tracer.environment, n, ok);
    cJSON *counts = hpr_json_object(root, "counts", ok);
    hpr_json_number(counts, "patches", (double)patches->count, ok);
    hpr_json_number(counts, "lamps", (double)reference->tracer.lights.count, ok);
    hpr_json_number(counts, "channels", (double)n, ok);
    hpr_json_number(counts, "degenerate", (double)patches->degenerate_count, ok);
    hpr_json_number(counts, "duplicate", (double)patches->duplicate_count, ok);
    cJSON *counters = hpr_json_object(root, "counters", ok);
    const hpr_context *ctx = reference->context;
    hpr_json_number(counters, "rays", (double)hpr_counter_value(ctx, HPR_COUNT_RAYS), ok);
    hpr_json_number(counters, "camera_rays", (double)hpr_counter_value(ctx, HPR_COUNT_CAMERA_RAYS), ok);
}

static void add_pictures(cJSON *root, const hpr_reference_report *report, bool *ok)
{
    size_t n = report->reference->patches->channel_count;
    cJSON *pictures = hpr_json_array(root, "pictures", ok);
    for (size_t i = 0; i < report->picture_count; i++) {
        const hpr_reference_picture *picture = &report->picture[i];
        cJSON *item = hpr_json_object(pictures, NULL, ok);
        hpr_json_text(item, "camera", picture->camera, ok);
        hpr_json_number(item, "width", picture->width, ok);
        hpr_json_number(item, "height", picture->height, ok);
        hpr_json_number(item, "noise", picture->noise, ok);
        add_numbers(item, "mean_radiance", picture->mean_radiance, n, ok);
        add_numbers(item, "standard_error", picture->standard_error, n, ok);
    }
}

hpr_status hpr_reference_report_write(hpr_context *ctx, const hpr_reference_report *report, const char *path)
{
    bool ok = true;
    hpr_context_clear_error(ctx);
    cJSON *root = cJSON_CreateObject();
    hpr_report_add_program(root, ctx, &ok);
    hpr_json_text(root, "scene", report->scene_path, &ok);
    add_run(root, report, &ok);
    hpr_report_add_cost(root, ctx, &ok);
    add_pictures(root, report, &ok);
    hpr_report_add_warnings(root, ctx, &ok);
    return hpr_report_save(ctx, root, ok, path);
}
