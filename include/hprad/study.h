#ifndef HPRAD_STUDY_H
#define HPRAD_STUDY_H

#include <hprad/job.h>

#ifdef __cplusplus
extern "C" {
#endif

/** Along which way accuracy is bought; a bit each. */
typedef enum hpr_study_way {
    HPR_STUDY_H = 1, /**< every order on every subdivision; adaptive: HPR_REFINE_H */
    HPR_STUDY_P = 2, /**< every order on the first subdivision; adaptive: HPR_REFINE_P */
    HPR_STUDY_HP = 4 /**< order p with p levels of grading, on the first subdivision; adaptive:
                          HPR_REFINE_HP */
} hpr_study_way;

/** One solve of a study. */
typedef struct hpr_study_run {
    hpr_method method;
    hpr_direct_mode direct;
    int order, subdivide, grade; /**< order and subdivide: HPR_CHOOSE if adaptive */
    double tolerance;            /**< adaptive: what elements are refined for; else 0 */
    hpr_refine_mode adapt;       /**< if adaptive: how */
} hpr_study_run;

/** What it cost and how far it is off. NaN: not known. */
typedef struct hpr_study_row {
    hpr_study_run run;
    double h_m; /**< the largest element's sqrt(area) */
    double dofs, elements, links, kernel_evaluations, rays, clips;
    /** CPU seconds of the stages, medians of the repeats. */
    double mesh_cpu_s, assembly_cpu_s, direct_cpu_s, environment_cpu_s, solver_cpu_s, energy_cpu_s,
        estimate_cpu_s;
    double cpu_s, least_cpu_s, most_cpu_s; /**< of the whole solve: median, least, most */
    double wall_s;                         /**< median */
    double peak_memory_bytes; /**< of the process during the solve, the solution to compare with included */
    /**
     * Errors of the irradiance, of the worst channel: ∫|H - H*| / ∫|H*|, the root of ∫(H - H*)^2 / ∫H*^2,
     * max|H - H*| / max|H*| over the points of the integrals, the same over the points given (H* as known
     * there, if it is), the root of sum (H - H*)^2 / sum H*^2 over these, and the largest error of a patch's
     * mean over the largest mean.
     */
    double error_l1, error_l2, error_linf, error_points, error_points_l2, error_face_means;
    double error_estimate; /**< of an adaptive run: the solve's own, of error_l2 */
    double order_l2;       /**< log2 of the error_l2 of the row with one subdivision less over this one's */
} hpr_study_row;

typedef struct hpr_job_study_options {
    const char *table_path;  /**< CSV; NULL: base name of the scene + "_study.csv", in the working folder */
    const char *json_path;   /**< NULL: none */
    const char *points_path; /**< a table as hpr_job_probe takes it; NULL: none. If it has columns of
                                irradiance as hpr_job_probe writes them, these are compared with, instead of
                                the better solution's: the values of a closed form, or of another program */
    const char *truth_path;  /**< a solution of the scene to compare with; NULL: one is made */
    double truth_tolerance;  /**< of that, adaptive; 0: with tolerances and neither order nor subdivision of
                                  it given, a fifth of the least; else it is uniform or graded */
    int truth_order, truth_subdivide; /**< of that; HPR_CHOOSE: 4 more than the highest order, and one
                                           subdivision more than the highest, or less until there are at most
                                           12,000 coefficients; with HPR_STUDY_HP 2 orders more, 2 levels of
                                           grading more, and the first subdivision */
    int refine;                       /**< hpr_study_way, bits, of the runs of given order */
    size_t tolerance_count;           /**< adaptive runs of HPR_METHOD_GALERKIN beside them, and of
                                           HPR_METHOD_HIERARCHICAL, which only halves; 0: none */
    const double *tolerance;          /**< each in (0, 1) */
    int adapt;                        /**< hpr_study_way, bits, of the adaptive runs of HPR_METHOD_GALERKIN */
    size_t order_count, subdivide_count, method_count, direct_count; /**< none may be 0 */
    const int *order, *subdivide;                                    /**< rising */
    const hpr_method *method;      /**< of a method with constants only, order 0 stands for all orders */
    const hpr_direct_mode *direct; /**< of a classical method the first stands for all */
    int repeats; /**< solves per row, from 1; if more, one more comes first, to warm up, and does not count */
    int resume;  /**< 1: rows that the table has for the same settings and version are taken over */
    hpr_read_options read;
    hpr_solve_options solve; /**< what all runs share; feet HPR_CHOOSE: 0, but of adaptive runs; limits are
                                  of these alone */
    hpr_baseline_options baseline;
    size_t environment_count;
    const double *environment;
    /** After each row, `row` valid during the call; left_s: seconds that the rest may take, NaN at first;
     * NULL: not wanted. `user` is that of the events. */
    void (*ran)(void *user, const hpr_study_row *row, size_t done, size_t total, double left_s);
    hpr_job_events events;
} hpr_job_study_options;

/** Order 0 to 4, subdivision 0 to 2, Galerkin with exact direct light, HPR_STUDY_H, one repeat; no
 * tolerances, but were there any: HPR_STUDY_HP. */
HPR_API void hpr_job_study_options_init(hpr_job_study_options *options);

/**
 * Solves the scene in every way that the options span and measures each against a better solution; a row per
 * run in a table of CSV, written anew after each run, so that what was interrupted can be resumed. The same
 * points and weights for all runs: Gauss points on the better solution's elements, cut to the finest
 * subdivision where they are coarser. A
 * run for which there is not enough memory is left out, with a warning; one that does not reach its tolerance
 * has a row, whose error_estimate says so. Errors: as in job.h; HPR_ERR_FORMAT
 * also if the solution to compare with is not of this scene. `options` may be NULL.
 */
HPR_API hpr_status hpr_job_study(hpr_context *context, const char *scene_path,
                                 const hpr_job_study_options *options, hpr_job_result *result);

#ifdef __cplusplus
}
#endif

#endif
