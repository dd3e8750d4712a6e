#ifndef HPRAD_REPORT_H
#define HPRAD_REPORT_H

#include <hprad/solve.h>

#ifdef __cplusplus
extern "C" {
#endif

/**
 * Writes what a run did and cost as JSON: version, settings, counts, counters, seconds per stage, memory,
 * convergence, energy terms and warnings of `context` and `solution`. The README lists the keys. Numbers
 * round-trip; those that are not finite become null. `scene_path` may be NULL. Written to a temporary file
 * and renamed. Errors: HPR_ERR_IO, HPR_ERR_MEMORY, HPR_ERR_INTERRUPTED.
 */
HPR_API hpr_status hpr_report_write(hpr_context *context, const hpr_solution *solution,
                                    const char *scene_path, const char *path);

#ifdef __cplusplus
}
#endif

#endif
