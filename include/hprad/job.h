#ifndef HPRAD_JOB_H
#define HPRAD_JOB_H

#include <hprad/baseline.h>
#include <hprad/compare.h>
#include <hprad/reference.h>
#include <hprad/render.h>
#include <hprad/solve.h>

#ifdef __cplusplus
extern "C" {
#endif

/*
 * What the verbs of the command do, from files to files. Every job
 *   - finds out before its long work whether its outputs can be written, and refuses what cannot: a folder
 *     that is missing or not writable, a name that is a folder, an output that is the job's own input, two
 *     outputs of one name;
 *   - writes each file under a temporary name and renames it, so that a failure or an interruption leaves
 *     nothing half-written under the final name; files finished before that stay;
 *   - says through `result` in which step it ended, because an I/O error while reading is the input's fault
 *     and one while writing is not.
 * Errors common to all jobs: HPR_ERR_ARG (an option, or an output refused as input or as duplicate),
 * HPR_ERR_IO (input not readable: step READ; output not writable: step CHECK or WRITE), HPR_ERR_FORMAT,
 * HPR_ERR_UNSUPPORTED, HPR_ERR_MEMORY, HPR_ERR_NUMERIC, HPR_ERR_DEVICE, HPR_ERR_INTERRUPTED.
 * A job is one call on its context: no concurrent calls on the same context. All texts in options are
 * borrowed until the job returns. `result` may be NULL.
 */

/** What a job does one after the other; CHECK comes again when the names of the cameras are known. */
typedef enum hpr_job_step {
    HPR_JOB_CHECK, /**< options and outputs */
    HPR_JOB_READ,
    HPR_JOB_SOLVE,
    HPR_JOB_RENDER,
    HPR_JOB_WRITE
} hpr_job_step;

typedef enum hpr_job_kind {
    HPR_JOB_FILE_SOLUTION,
    HPR_JOB_FILE_REPORT,
    HPR_JOB_FILE_EXR,
    HPR_JOB_FILE_PNG,
    HPR_JOB_FILE_FALSE_COLOUR,
    HPR_JOB_FILE_DIFFERENCE,
    HPR_JOB_FILE_TABLE,
    HPR_JOB_FILE_FACTORS
} hpr_job_kind;

/** A file that a job has just finished. Valid during the call that hands it over. */
typedef struct hpr_job_file {
    hpr_job_kind kind;
    const char *path;
    const char *camera; /**< of a picture: the camera as `{camera}` names it; else NULL */
    int width, height;  /**< of a picture, pixels; else 0 */
    double exposure;    /**< of a preview: the factor on radiance; else 0 */
    double top;         /**< of a false-colour picture: the irradiance at the legend's top, W/m²; else 0 */
    const char *reference;            /**< of a difference: what the picture was compared with; else NULL */
    const hpr_difference *difference; /**< of a difference: how large it is; else NULL */
} hpr_job_file;

/** Called after each file, by the thread that runs the job; NULL: not wanted. */
typedef struct hpr_job_events {
    void (*wrote)(void *user, const hpr_job_file *file);
    void *user;
} hpr_job_events;

typedef struct hpr_job_result {
    hpr_job_step step;         /**< the last step begun: where the job failed, if it failed */
    hpr_solve_summary summary; /**< of the solution; zero if there was none */
    double seconds;            /**< wall clock of the whole job */
    double solve_seconds;      /**< wall clock of the solve alone, 0 if nothing was solved */
    size_t picture_count;      /**< EXR files written */
    size_t point_count;        /**< points probed */
    size_t matched_count;      /**< points that lie on a patch */
    size_t row_count;          /**< surfaces in a matrix of view factors */
    size_t pair_count;         /**< pairs of patches that were integrated for it */
    size_t short_count;        /**< of these: how many stopped short of the tolerance */
    size_t outside_count;      /**< view factors outside [0, 1] by more than 1e-14 */
    double closure_defect;     /**< largest |sum_j sqrt(A_j) K_ij^{k0} / sqrt(A_i) - delta_k0| over the rows i
                                    and functions k; of view factors largest |1 - row sum|: rounding and
                                    errors if the model is closed, else what is open */
    uint64_t ray_count;        /**< rays of path tracing, those of the camera included */
    double noise;              /**< of path tracing: RMS standard error of a pixel over RMS radiance, all
                                    channels together; of the worst picture, 0 if it is black */
} hpr_job_result;

/** Scene file -> solution .glb, and its report if asked. */
typedef struct hpr_job_solve_options {
    const char *solution_path; /**< NULL: base name of the scene + ".glb", in the working folder */
    const char *report_path;   /**< NULL: none */
    /** With a tolerance: where the series of solves stands is written to the first between any two of them,
     * and it goes on from what the second holds. They may be the same file. NULL: not wanted. */
    const char *checkpoint_path, *resume_path;
    hpr_read_options read;
    hpr_solve_options solve;
    hpr_baseline_options baseline; /**< of classical methods. Its `shot` is the job's own: after `every` shots
                                        the solution so far, with "_SHOTS", 6 digits, before its extension */
    size_t environment_count;      /**< 0: none; else as hpr_scene_set_environment takes it */
    const double *environment;
    hpr_job_events events;
} hpr_job_solve_options;

HPR_API void hpr_job_solve_options_init(hpr_job_solve_options *options);

/** `options` may be NULL. Errors: as above; HPR_ERR_FORMAT also if the file is itself a solution, and, naming
 * what differs, if resume_path is of another scene, other options or another program. What was resumed gives
 * the same solution file, bit for bit, as what was never stopped. */
HPR_API hpr_status hpr_job_solve(hpr_context *context, const char *scene_path,
                                 const hpr_job_solve_options *options, hpr_job_result *result);

/**
 * Which pictures, of what, and under which names. Every camera that is chosen gives a picture, or one camera
 * gives `orbit` of them: the k-th from 0 is seen by the camera turned by 2 pi k / orbit about the vertical
 * (+y) through the centre, counter-clockwise as seen from above. A picture depends on its own camera and
 * settings only: alone it has the same bits as among all. In `pattern` these are replaced:
 *   {camera}     the camera's name, "/" as "_", "camera0" if it has none; a name that came before gets _1, _2
 *   {frame}      the number of the picture from 0;  {frame:04} the same, padded with zeros to 4 digits
 * Anything else between braces is refused. The names of the cameras are made before one is chosen, so a
 * camera has the same name alone as among all.
 */
typedef struct hpr_job_render_options {
    const char *pattern; /**< NULL: base name of the input + ".exr" in the working folder, with "_{camera}",
                              or of an orbit "_{frame:04}", before the extension if there are several */
    const char *camera_file; /**< glTF whose cameras take the place of the input's; NULL: none */
    const char *camera; /**< NULL or "all"; else a name as {camera} has it or as the file has it, or an index;
                             unknown: HPR_ERR_ARG, and the message lists the names */
    int orbit;          /**< pictures around the scene; 0: none. One camera must be chosen */
    int orbit_centred;  /**< 1: about orbit_centre; 0: about the centre of the box around all surfaces */
    double orbit_centre[3];       /**< metres */
    int first_frame, frame_count; /**< only these pictures, by their numbers from 0; count 0: all of them */
    int preview;                  /**< 1: an 8-bit .png beside each EXR, with the same base name */
    double exposure;              /**< of previews, factor on radiance; 0: each chooses its own */
    int false_colour;             /**< 1: the irradiance in colours, with a legend, beside each EXR as
                                       "_irradiance.png" */
    double false_colour_top;      /**< W/m² at the legend's top; 0: each chooses its own */
    const char
        *compare;    /**< pattern of EXR files to compare with: the difference is written beside each EXR as
                          "_difference.exr". Without a size the picture takes that of the file. NULL: none */
    int half, tiled; /**< of EXR, see hpr_image_labels */
    const char *report_path; /**< NULL: none; it includes the rendering */
    hpr_render_options render;
    hpr_view_options view;
    size_t environment_count; /**< of a scene, as hpr_scene_set_environment takes it; 0: none. With a
                                   solution, which has its own: HPR_ERR_ARG */
    const double *environment;
    hpr_job_events events;
} hpr_job_render_options;

HPR_API void hpr_job_render_options_init(hpr_job_render_options *options);

/**
 * Solution .glb -> one EXR per camera. A scene file is solved first, with default options. `options` may be
 * NULL. Errors: as above; HPR_ERR_ARG also if there are several pictures and the pattern gives them one name.
 * A report of a solution that was read has no stage of solving.
 */
HPR_API hpr_status hpr_job_render(hpr_context *context, const char *input_path,
                                  const hpr_job_render_options *options, hpr_job_result *result);

/** Scene file -> pictures in one go, and the report if asked. */
typedef struct hpr_job_picture_options {
    hpr_read_options read;
    hpr_solve_options solve;
    hpr_job_render_options pictures;
} hpr_job_picture_options;

HPR_API void hpr_job_picture_options_init(hpr_job_picture_options *options);

/**
 * As hpr_job_render, but a pattern that gives several pictures one name gets "_{camera}" before its
 * extension. `options` may be NULL. Errors: as above; HPR_ERR_FORMAT also if the file is itself a solution.
 */
HPR_API hpr_status hpr_job_picture(hpr_context *context, const char *scene_path,
                                   const hpr_job_picture_options *options, hpr_job_result *result);

/** Scene file -> pictures by path tracing, and the report if asked. */
typedef struct hpr_job_reference_options {
    hpr_read_options read;
    hpr_reference_options reference;
    hpr_job_render_options pictures; /**< of these: pattern, camera, preview, exposure, half, tiled, report,
                                          size, environment, events; HPR_DEFAULT_PATHS samples, 2 to
                                          HPR_MAX_PATHS; default name: base name of the scene +
                                          "_reference.exr". Whatever else is set is refused */
} hpr_job_reference_options;

HPR_API void hpr_job_reference_options_init(hpr_job_reference_options *options);

/**
 * Scene file -> one EXR per camera, with the layer `variance`, by hpr_reference_render. `options` may be
 * NULL. Errors: as hpr_job_render; HPR_ERR_FORMAT also if the file is itself a solution; HPR_ERR_NUMERIC if a
 * path does not end. The report has the keys that the README lists for it.
 */
HPR_API hpr_status hpr_job_reference(hpr_context *context, const char *scene_path,
                                     const hpr_job_reference_options *options, hpr_job_result *result);

/** Solution .glb and a table of points -> a table of irradiance and radiosity. */
typedef struct hpr_job_probe_options {
    const char *output_path; /**< NULL or "-": standard output */
    int gather;              /**< 1: by hpr_solution_gather */
    hpr_job_events events;
} hpr_job_probe_options;

HPR_API void hpr_job_probe_options_init(hpr_job_probe_options *options);

/** `options` may be NULL. Points that match no patch are no error; they are counted in the result. */
HPR_API hpr_status hpr_job_probe(hpr_context *context, const char *solution_path, const char *points_path,
                                 const hpr_job_probe_options *options, hpr_job_result *result);

/** Model file -> view factors, or kernel blocks, and a table of the surfaces beside them. */
typedef struct hpr_job_form_factors_options {
    const char
        *output_path; /**< its extension decides the format: .npy, .csv or .txt; NULL: base name of the model
                           + ".npy", in the working folder. The table has the same name with
                           ".surfaces.csv" for the extension */
    const char *report_path; /**< NULL: none */
    double tolerance;        /**< relative, of each entry, 0 < tolerance < 1 (default 1e-9) */
    int order;               /**< -1: view factors; 0 ... 16: kernel blocks of this degree, .npy only */
    int use_eps;             /**< 1: where a .vs3 file has eps, that is the tolerance */
    hpr_read_options read;   /**< of glTF models */
    /** Called once before the long work; NULL: not wanted. `user` is that of the events. */
    void (*planned)(void *user, size_t row_count, double bytes);
    hpr_job_events events;
} hpr_job_form_factors_options;

HPR_API void hpr_job_form_factors_options_init(hpr_job_form_factors_options *options);

/**
 * F[i][j], row-major: the part of what leaves surface i that reaches surface j without reflection. The model
 * is View3D's .vs3 (formats 3 and 3a) if that is its extension, else glTF. Rows are numbered as View3D does
 * it (no rows for obstructions and null surfaces, nor for those combined into others), or by node, primitive
 * and patch, front before back; a surface without area keeps a row of zeros. If a .vs3 file asks for it
 * (emit=1), the matrix is script-F; if it says that it is closed (encl=1), rows that do not sum to 1 are
 * warned about and left alone. With `order` >= 0 the file is [N][N][n][n]: block K_ij^kl of receiver i and
 * sender j, zero-padded to the largest n; every row must then be one parallelogram or triangle (else
 * HPR_ERR_UNSUPPORTED). Errors: as above; HPR_ERR_MEMORY also before the work if the machine has too little;
 * HPR_ERR_TOLERANCE if some pair stopped short of the tolerance: everything is written then. The report has
 * the keys that the README lists for it. `options` may be NULL.
 */
HPR_API hpr_status hpr_job_form_factors(hpr_context *context, const char *model_path,
                                        const hpr_job_form_factors_options *options, hpr_job_result *result);

#ifdef __cplusplus
}
#endif

#endif
