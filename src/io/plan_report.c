#include "io/plan_report.h"

#include "io/report_parts.h"

#include <math.h>

static void add_cost(cJSON *item, const char *key, const hpr_plan_cost *cost, bool *ok)
{
    if (!cost) {
        hpr_json_null(item, key, ok);
        return;
    }
    cJSON *object = hpr_json_object(item, key, ok);
    hpr_json_number(object, "elements", cost->elements, ok);
    hpr_json_number(object, "dofs", cost->dofs, ok);
    hpr_json_number(object, "links", cost->links, ok);
    hpr_json_number(object, "memory_bytes", cost->memory_bytes, ok);
    hpr_json_number(object, "cpu_seconds", cost->cpu_s, ok);
}

static void add_pairs(cJSON *root, const hpr_plan *plan, bool *ok)
{
    cJSON *pairs = hpr_json_object(root, "pairs", ok);
    hpr_json_number(pairs, "all", plan->pairs, ok);
    hpr_json_number(pairs, "drawn", plan->pairs_drawn, ok);
    hpr_json_number(pairs, "hidden", plan->pairs_hidden, ok);
    hpr_json_number(pairs, "visible", plan->pairs_visible, ok);
    hpr_json_number(pairs, "partial", plan->pairs_partial, ok);
    hpr_json_number(pairs, "blockers", plan->blocker_count, ok);
}

hpr_status hpr_plan_report_write(hpr_context *ctx, const hpr_plan *plan, const char *scene_path,
                                 const char *path)
{
    bool ok = true;
    hpr_context_clear_error(ctx);
    cJSON *root = cJSON_CreateObject();
    hpr_report_add_program(root, ctx, &ok);
    hpr_json_text(root, "scene", scene_path, &ok);
    hpr_report_add_effects(root, plan->effect, &ok);
    hpr_json_number(root, "patches", (double)plan->patch_count, &ok);
    hpr_json_number(root, "occluders", (double)plan->occluder_count, &ok);
    add_pairs(root, plan, &ok);
    cJSON *solves = hpr_json_array(root, "solves", &ok);
    for (size_t i = 0; i < plan->solve_count; i++) {
        const hpr_plan_solve *solve = &plan->solve[i];
        cJSON *item = hpr_json_object(solves, NULL, &ok);
        hpr_json_number(item, "tolerance", solve->tolerance > 0 ? solve->tolerance : NAN, &ok);
        hpr_json_bool(item, "too_large", solve->too_large, &ok);
        add_cost(item, "predicted", &solve->predicted, &ok);
        add_cost(item, "measured", solve->measured ? &solve->cost : NULL, &ok);
        hpr_json_number(item, "error_estimate", solve->error, &ok);
    }
    hpr_report_add_cost(root, ctx, &ok);
    hpr_report_add_warnings(root, ctx, &ok);
    return hpr_report_save(ctx, root, ok, path);
}
