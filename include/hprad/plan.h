#ifndef HPRAD_PLAN_H
#define HPRAD_PLAN_H

#include <hprad/job.h>

#ifdef __cplusplus
extern "C" {
#endif

enum {
    HPR_PLAN_EFFECTS = 8, /**< channels, lamps, environment, visibility, interreflection, two_sided, textures,
                               openings: in this order */
    HPR_PLAN_TEXT = 160,  /**< bytes of a reason */
    HPR_PLAN_TOLERANCES = 3 /**< of the table: 1e-1, 1e-2, 1e-3 */
};

/** Something that a scene may call for. What it does not call for is left out and costs nothing. */
typedef struct hpr_plan_effect {
    const char *name; /**< static text */
    int called_for;   /**< 0: left out */
    char why[HPR_PLAN_TEXT];
} hpr_plan_effect;

/** What a solve takes. */
typedef struct hpr_plan_cost {
    double elements, dofs, links;
    double memory_bytes; /**< of the process, at its peak */
    double cpu_s;        /**< of all threads together */
} hpr_plan_cost;

/** One solve: the scene's default, or one to a tolerance. */
typedef struct hpr_plan_solve {
    double tolerance; /**< 0: elements as the options say, or the default */
    hpr_plan_cost predicted;
    int too_large;      /**< 1: this machine has too little memory */
    int measured;       /**< 1: it was solved; 0: not asked for, or too large */
    hpr_plan_cost cost; /**< measured */
    double error;       /**< estimated relative error that was reached; NaN: not estimated */
} hpr_plan_solve;

typedef struct hpr_plan {
    hpr_plan_effect effect[HPR_PLAN_EFFECTS];
    size_t patch_count;
    /** Pairs of patches, by what they see of each other; where pairs_drawn is less than their number,
     * estimated from so many drawn at random. */
    double pairs, pairs_hidden, pairs_visible, pairs_partial;
    double pairs_drawn;
    size_t occluder_count; /**< convex things that may be in the way */
    double blocker_count;  /**< of a pair that is partly visible, on the average */
    double least_bytes;    /**< > 0: the first solve is refused, for its operator takes so much at least */
    size_t solve_count;
    hpr_plan_solve solve[HPR_PLAN_TOLERANCES + 1];
} hpr_plan;

typedef struct hpr_job_plan_options {
    const char *report_path; /**< the plan as JSON; NULL: none */
    hpr_read_options read;
    /** Of all rows; with a tolerance the table has this one alone. max_seconds (0: 60) and max_bytes (0: half
     * of the machine's) limit what is measured: what is predicted to take more CPU seconds or memory is not
     * solved, and a solve ends after four times the seconds of wall clock. */
    hpr_solve_options solve;
    size_t environment_count; /**< as for hpr_job_solve */
    const double *environment;
    int measure; /**< 1: what the limits allow is solved, too */
    hpr_job_events events;
} hpr_job_plan_options;

HPR_API void hpr_job_plan_options_init(hpr_job_plan_options *options);

/**
 * Reads a scene and says what it calls for and what that will cost: pairs of patches are classified, nothing
 * is integrated or solved unless options->measure. A scene that is too large to be solved is no error.
 * `options` and `result` may be NULL. Errors: as every job (job.h).
 */
HPR_API hpr_status hpr_job_plan(hpr_context *context, const char *scene_path,
                                const hpr_job_plan_options *options, hpr_plan *plan, hpr_job_result *result);

#ifdef __cplusplus
}
#endif

#endif
