#ifndef HPRAD_SOLVE_H
#define HPRAD_SOLVE_H

#include <hprad/scene.h>
#include <stdbool.h>

#ifdef __cplusplus
extern "C" {
#endif

/** A solved scene: geometry, elements, coefficients, cameras. Needs nothing else to be shown or probed. */
typedef struct hpr_solution hpr_solution;

enum {
    HPR_MAX_ORDER = 16,
    HPR_MAX_SUBDIVIDE = 10,
    HPR_MAX_FEET = 6,
    HPR_MAX_GRADE = 20,
    HPR_DEFAULT_ORDER = 4,
    HPR_DEFAULT_SUBDIVIDE = 2,
    HPR_DEFAULT_FEET = 3,
    HPR_CHOOSE = -1 /**< order, subdivide, feet or element_size: see hpr_solve_options_init */
};

/** What becomes of direct light. */
typedef enum hpr_direct_mode {
    HPR_DIRECT_EXACT, /**< evaluated at every point by Lambert's formula; the basis carries the indirect part
                       */
    HPR_DIRECT_GALERKIN /**< projected onto the basis like everything else */
} hpr_direct_mode;

/** What is solved: by which elements and by which transport between them. */
typedef enum hpr_method {
    HPR_METHOD_GALERKIN,     /**< hprad's own */
    HPR_METHOD_HIERARCHICAL, /**< its degree 0 with constants on all levels: hierarchical radiosity (Hanrahan,
                                Salzman & Aupperle 1991); link_tolerance 0 is then 0.3 (with a tolerance: a
                                tenth of it), direct light goes through the basis; a tolerance is met by
                                halving */
    HPR_METHOD_HEMICUBE,     /**< the others: see baseline.h */
    HPR_METHOD_RAYCAST,
    HPR_METHOD_EXACT
} hpr_method;

/** "galerkin", "hierarchical", "hemicube", "raycast", "exact"; static text. */
HPR_API const char *hpr_method_name(hpr_method method);

/** How the linear system is solved. All give the same solution. */
typedef enum hpr_solver_method {
    HPR_SOLVER_AUTO,         /**< Gauss-Seidel, and GMRES where that takes long */
    HPR_SOLVER_GAUSS_SEIDEL, /**< patch after patch */
    HPR_SOLVER_GMRES,        /**< preconditioned by a Gauss-Seidel sweep */
    HPR_SOLVER_GATHERING,    /**< Jacobi: all patches at once */
    HPR_SOLVER_SHOOTING,     /**< Southwell: the brightest patch first, progressive refinement */
    HPR_SOLVER_DIRECT        /**< elimination: of the full matrix of a classical method only */
} hpr_solver_method;

/** How elements are refined until a tolerance is met. */
typedef enum hpr_refine_mode {
    HPR_REFINE_HP, /**< the degree is raised where the coefficients fall fast, else elements are halved */
    HPR_REFINE_H,  /**< halved, all of one degree */
    HPR_REFINE_P   /**< the degree is raised */
} hpr_refine_mode;

/** "hp", "h", "p"; static text. */
HPR_API const char *hpr_refine_name(hpr_refine_mode mode);

/** "auto", "gauss-seidel", "gmres", "gathering", "shooting", "direct"; static text. */
HPR_API const char *hpr_solver_name(hpr_solver_method method);

/** How a scene is solved. */
typedef struct hpr_solve_options {
    int order;     /**< polynomial degree p of every element, 0 .. HPR_MAX_ORDER, or HPR_CHOOSE */
    int subdivide; /**< N: 4^N elements per patch, 0 .. HPR_MAX_SUBDIVIDE, or HPR_CHOOSE */
    int feet;      /**< so often are elements quartered that the foot of an object cuts, each time one degree
                        lower, down to 1; 0 .. HPR_MAX_FEET, or HPR_CHOOSE */
    double element_size; /**< then elements are halved until none is longer, metres; 0: they are not; or
                              HPR_CHOOSE */
    int grade; /**< so often are elements halved toward edges at which patches meet, 0 .. HPR_MAX_GRADE */
    double
        tolerance; /**< relative error of H in L2 that elements are refined for; 0: they stay as they are */
    hpr_refine_mode refine;
    double max_seconds, max_bytes; /**< with a tolerance: of time, and of blocks; no step is begun that would
                                        probably exceed them. 0: no limit. Without one: beyond max_bytes for
                                        blocks a solve is refused; 0: half of the machine's memory */
    double link_tolerance;         /**< of the operator's norm, for what links leave out; 0: chosen */
    double block_tolerance;        /**< relative, per block; 0: chosen, see hpr_solve_summary */
    hpr_solver_method solver;
    double solver_tolerance; /**< relative error of the linear system's solution */
    int max_sweeps;          /**< limit of sweeps, iterations or shots */
    hpr_direct_mode direct;  /**< what becomes of direct light */
    hpr_method method;
} hpr_solve_options;

/**
 * Order, subdivide, feet and element_size are HPR_CHOOSE: HPR_DEFAULT_ORDER, HPR_DEFAULT_SUBDIVIDE and
 * HPR_DEFAULT_FEET where the scene then has at most 12,000 coefficients; else a lower order, and instead of
 * the same number of elements on each patch elements of the same size everywhere, as many as that allows,
 * with a warning that says which. What was chosen is in hpr_solve_summary.
 */
HPR_API void hpr_solve_options_init(hpr_solve_options *options);

/** What becomes of light from outside. */
typedef enum hpr_environment_mode {
    HPR_ENVIRONMENT_NONE,    /**< there is none */
    HPR_ENVIRONMENT_EXACT,   /**< evaluated at every point: what is open of its view is clipped */
    HPR_ENVIRONMENT_GALERKIN /**< projected onto the basis like everything else */
} hpr_environment_mode;

/**
 * Energy terms per channel in W; each is computed by itself, so that
 * emitted + environment = absorbed + lost_on_backs + escaped is a check. Light from outside that meets a
 * black back at once is in none of them.
 */
typedef struct hpr_energy {
    double emitted;       /**< ∫ M dA */
    double environment;   /**< ∫ pi L V dA: what comes from outside, V the open part of the view */
    double absorbed;      /**< ∫ (1 - rho) H dA */
    double lost_on_backs; /**< light that reaches black backs of single-sided surfaces */
    double escaped;       /**< light that leaves the scene */
} hpr_energy;

/** Parts of the estimated error, relative. */
typedef struct hpr_error_parts {
    double discretisation; /**< what the elements leave out, errors of the blocks between them included */
    double links;          /**< what links between groups of elements leave out */
    double visibility;     /**< statistical, where visibility is sampled */
    double solver;         /**< of the linear system */
} hpr_error_parts;

/** Figures of one solve. */
typedef struct hpr_solve_summary {
    hpr_solve_options options; /**< as they were given, or chosen */
    size_t patch_count, element_count, dof_count, link_count, block_bytes;
    int direct;      /**< hpr_direct_mode in force: numerous emitters go through the basis */
    int environment; /**< hpr_environment_mode in force: with many patches through the basis */
    /** Elements on which V was integrated in closed form, adaptively over clipped points, by rays. */
    size_t environment_closed, environment_clipped, environment_sampled;
    double environment_error; /**< estimated, of the mean of V on an element: root of its mean square */
    /** Estimated relative error of H in L2, the worst channel's, and its parts, of which it is the sum; NaN:
     * not estimated, as without a tolerance. */
    double error_estimate;
    hpr_error_parts error_parts;
    int steps;              /**< solves until the tolerance was met, or given up */
    int reached;            /**< 1 if error_estimate is within the tolerance */
    size_t channels_solved; /**< 1 if all channels agree, else their number */
    size_t degenerate_count, duplicate_count;
    double link_tolerance, link_error; /**< in force, and what links leave out of the irradiance */
    double block_tolerance;   /**< of blocks that nothing obstructs: 1e-13 in an unobstructed scene, else 1e-5
                                 to 3e-3 */
    double blocked_tolerance; /**< of the others, relative to themselves or to the sender's share of the area:
                                 by what they cost, 1e-6 to 0.03; 0 if they are sampled */
    double visibility_error;  /**< estimated statistical error of the irradiance, relative, RMS over the area,
                                 from  blocks that are sampled: of one reflection, were all surfaces equally
                                 bright */
    size_t short_count;       /**< blocks that stopped short of theirs */
    /** Largest estimated error of an entry of the (dimensionless) blocks between elements, rounding of the
     *  coordinates included: of those that are not sampled, and a guess for those that are. */
    double block_error, sampled_error;
    int solver;      /**< hpr_solver_method that was used last */
    int sweeps;      /**< applications of the operator; of shooting: shots */
    double residual; /**< |D + K rho H - H| / |H|, computed afresh at the end */
    int occluded;    /**< 1 if some pair of patches may be blocked */
} hpr_solve_summary;

/**
 * Solves H = ∫ G V (M + rho H) dA + pi L V_outside on uniform elements, L the scene's environment.
 * Errors: HPR_ERR_ARG (options out of range, or a method of baseline.h), HPR_ERR_MEMORY (also when the
 * predicted size exceeds the machine's memory), HPR_ERR_NUMERIC (no convergence; the message names the
 * remedy), HPR_ERR_INTERRUPTED. A scene without patches, or without light (lamps or environment), gives the
 * zero solution and a warning.
 */
HPR_API hpr_status hpr_solve(hpr_context *context, const hpr_scene *scene, const hpr_solve_options *options,
                             hpr_solution **solution);

/** What a step of a solve with a tolerance puts in the place of an element. */
typedef struct hpr_refinement {
    uint32_t step; /**< after which of the solves, from 1 */
    uint32_t leaf; /**< the element's number in that solve */
    uint8_t
        halve[2]; /**< 1: halved along s, along t; a triangle or quadrilateral once, whatever stands here */
    uint8_t degree[4]; /**< of what takes its place, in the order of the new numbers: itself, or its parts */
} hpr_refinement;

/** A kernel block between two nodes of the elements' trees, as it was integrated. */
typedef struct hpr_kept_block {
    uint32_t recv,
        send; /**< nodes; with the degrees they name the block among those of a scene and options */
    uint8_t recv_degree, send_degree;
    uint32_t count;       /**< entries */
    uint32_t short_count; /**< what its integration told, as all that follows */
    double error, sampled_error, sampled2;
    const double *block; /**< [count] valid during the call, or, of `find`, as long as the keeper is in use */
} hpr_kept_block;

/** Who keeps the blocks that took time, so that a solve which is taken up need not integrate them again. Both
 * functions are called by several threads at once; either may be NULL. */
typedef struct hpr_block_keeper {
    void (*keep)(void *user, const hpr_kept_block *block); /**< has been integrated */
    /** Completes a block of these nodes, degrees and count; false: not known. */
    bool (*find)(void *user, hpr_kept_block *block);
    void *user;
} hpr_block_keeper;

/**
 * How a solve with a tolerance can be taken up where another one stopped: the elements of each step follow
 * from the refinements before it, and the solution from the elements alone.
 */
typedef struct hpr_solve_series {
    const hpr_refinement *done; /**< [done_count] in order of their steps; the series begins after them */
    size_t done_count;
    /** Called between two steps with all refinements from the beginning, by the thread that solves; another
     * status than HPR_OK ends the solve with it. NULL: not wanted. */
    hpr_status (*stepped)(void *user, const hpr_refinement *refinement, size_t count);
    void *user;
    const hpr_block_keeper *blocks; /**< NULL: none are kept */
} hpr_solve_series;

/**
 * hpr_solve with a tolerance, which begins at a later step and tells of each; bit for bit what hpr_solve
 * gives, but for what max_seconds, counted afresh, may change. Errors: also HPR_ERR_ARG if there is no
 * tolerance, or if the refinements do not fit the scene.
 */
HPR_API hpr_status hpr_solve_resume(hpr_context *context, const hpr_scene *scene,
                                    const hpr_solve_options *options, const hpr_solve_series *series,
                                    hpr_solution **solution);

HPR_API void hpr_solution_destroy(hpr_solution **solution);

HPR_API size_t hpr_solution_channel_count(const hpr_solution *solution);
/** Name of a channel; valid as long as the solution. */
HPR_API const char *hpr_solution_channel_name(const hpr_solution *solution, size_t channel);
HPR_API const hpr_solve_summary *hpr_solution_summary(const hpr_solution *solution);
/** [channels]; valid as long as the solution. */
HPR_API const hpr_energy *hpr_solution_energy(const hpr_solution *solution);

HPR_API size_t hpr_solution_camera_count(const hpr_solution *solution);
HPR_API const char *hpr_solution_camera_name(const hpr_solution *solution, size_t camera);

/**
 * Writes the solution as a .glb that any glTF viewer shows and that hpr_solution_read reads back bit for bit
 * (extension HPRAD_radiosity). Written to a temporary file and renamed. Errors: HPR_ERR_IO, HPR_ERR_MEMORY.
 */
HPR_API hpr_status hpr_solution_write(hpr_context *context, const hpr_solution *solution, const char *path);

/** Errors: HPR_ERR_IO, HPR_ERR_FORMAT (not a solution, or one of a newer version), HPR_ERR_MEMORY. */
HPR_API hpr_status hpr_solution_read(hpr_context *context, const char *path, hpr_solution **solution);

/**
 * Irradiance and radiosity at points. point, normal: [count][3]; irradiance, radiosity: [count][channels],
 * NaN where no patch matches; patch: [count] index or HPR_NONE. A point matches the side within 1e-6 of the
 * scene's size whose normal agrees best, ties to the lowest index.
 */
HPR_API hpr_status hpr_solution_probe(hpr_context *context, const hpr_solution *solution, size_t count,
                                      const double *point, const double *normal, double *irradiance,
                                      double *radiosity, uint32_t *patch);

/**
 * The same by final gathering: at each point what the solution's radiosity sends there is integrated anew,
 * past the true obstacles, and not read from the polynomial of the element. Closer to the truth where
 * elements are coarse for what happens on them, as near edges; it takes some milliseconds a point, and the
 * moments of direct light once more beforehand. Same bits for any number of threads. Errors: HPR_ERR_MEMORY,
 * HPR_ERR_DEVICE, HPR_ERR_UNSUPPORTED, HPR_ERR_INTERRUPTED.
 */
HPR_API hpr_status hpr_solution_gather(hpr_context *context, const hpr_solution *solution, size_t count,
                                       const double *point, const double *normal, double *irradiance,
                                       double *radiosity, uint32_t *patch);

#ifdef __cplusplus
}
#endif

#endif
