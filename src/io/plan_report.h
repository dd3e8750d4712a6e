/* The report of a plan; the README lists its keys. */
#ifndef HPR_IO_PLAN_REPORT_H
#define HPR_IO_PLAN_REPORT_H

#include "base/context.h"

#include <hprad/plan.h>

/* Errors: HPR_ERR_MEMORY, HPR_ERR_IO, HPR_ERR_INTERRUPTED. */
hpr_status hpr_plan_report_write(hpr_context *ctx, const hpr_plan *plan, const char *scene_path,
                                 const char *path);

#endif
