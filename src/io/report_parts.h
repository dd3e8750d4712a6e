/* What every report has, whatever was run. */
#ifndef HPR_IO_REPORT_PARTS_H
#define HPR_IO_REPORT_PARTS_H

#include "base/context.h"
#include "io/json_text.h"

#include <hprad/plan.h>

/* hprad, isa, threads: what ran. */
void hpr_report_add_program(cJSON *root, const hpr_context *ctx, bool *ok);

/* stages, cpu_seconds, peak_memory_bytes. */
void hpr_report_add_cost(cJSON *root, const hpr_context *ctx, bool *ok);

/* plan: what a scene calls for [HPR_PLAN_EFFECTS]. */
void hpr_report_add_effects(cJSON *root, const hpr_plan_effect *effect, bool *ok);

/* warnings: every one said so far on the context. */
void hpr_report_add_warnings(cJSON *root, const hpr_context *ctx, bool *ok);

/* Prints and deletes `root` and writes it through a temporary file. Errors: HPR_ERR_MEMORY, also if `ok` is
 * false; HPR_ERR_IO, HPR_ERR_INTERRUPTED. */
hpr_status hpr_report_save(hpr_context *ctx, cJSON *root, bool ok, const char *path);

#endif
