/* Kernel blocks of element pairs. */
#ifndef HPR_QUADRATURE_BLOCK_H
#define HPR_QUADRATURE_BLOCK_H

#include "basis/basis.h"
#include "math/gauss.h"
#include "quadrature/pair.h"
#include "visibility/visibility.h"

/* Tables shared by all blocks; read-only once made. */
typedef struct hpr_quadrature hpr_quadrature;

hpr_status hpr_quadrature_create(hpr_context *ctx, hpr_quadrature **quadrature);
void hpr_quadrature_destroy(hpr_quadrature **quadrature);

/* Working memory of one thread. */
typedef struct hpr_block_scratch hpr_block_scratch;

hpr_status hpr_block_scratch_create(hpr_context *ctx, hpr_block_scratch **scratch);
/* The same for blocks of elements of no more than this degree: constants need a tenth of the memory. */
hpr_status hpr_block_scratch_create_for(hpr_context *ctx, int degree, hpr_block_scratch **scratch);
void hpr_block_scratch_destroy(hpr_block_scratch **scratch);

enum {
    /* Evaluations of the kernel that one block may take, at most so many and a few for each rule that is left
     * then: some ten seconds for constants. Beyond it the block is completed roughly and is HPR_BLOCK_SHORT.
     */
    HPR_BLOCK_KERNELS = 1000000000
};

typedef struct hpr_block_task {
    hpr_element_frame recv, send;
    double tolerance;  /* relative to the block's largest entry, > 0 */
    double negligible; /* an absolute error that does not matter either, >= 0: far pairs get fewer nodes */
    double contact_m;  /* points nearer than this count as touching, >= 0; a view through a slit as narrow is
                          none */
    uint64_t kernel_limit; /* in place of HPR_BLOCK_KERNELS; 0: that */
    /* Occluders that may come between; count 0: wholly visible, V = 1. Else V is sampled by a ray per pair of
     * quadrature points, and the tolerance does not cover the error of that, see sampling_error; or, with
     * `clip` and for at most HPR_CLIP_BLOCKERS of them, the visible part is clipped exactly and the tolerance
     * holds. */
    const hpr_visibility *visibility;
    const uint32_t *blockers;
    size_t blocker_count;
    bool clip;
    uint64_t seed; /* of rays: blocks with different seeds err independently */
    int ray_nodes; /* along an axis, at least, where rays sample; 0: enough for some three digits */
    /* Convex parts of the elements, in their parameters, that are integrated over instead of all of them, for
     * what else is covered; 0: all. */
    const hpr_polygon *recv_part, *send_part;
    int recv_part_count, send_part_count;
} hpr_block_task;

/* Gives the pair the task's blockers, moved as it is (the receiver's origin to 0) and in its unit of length,
 * `scale` of them to a metre; outline [blocker_count] is filled and borrowed. */
void hpr_block_set_blockers(const hpr_block_task *task, double scale, hpr_pair *pair, hpr_convex *outline);

typedef enum hpr_block_status {
    HPR_BLOCK_WITHIN,  /* the estimated error is within the tolerance */
    HPR_BLOCK_ROUNDED, /* only with what rounding may do to the coordinates, most of the error, it is not */
    HPR_BLOCK_SHORT,   /* that of the quadrature is not */
    HPR_BLOCK_SAMPLED  /* visibility was sampled: the error is a guess */
} hpr_block_status;

typedef struct hpr_block_result {
    bool seen; /* false: the block is zero because neither sees the other */
    hpr_block_status status;
    /* Estimated, absolute, of the entries of the (dimensionless) block, rounding of the coordinates included.
     * Of random pairs, less than one in a hundred errs by more; most err by a hundredth or a thousandth of
     * it.
     */
    double error;
    double sampling_error; /* standard error of block[0] from rays, see hpr_sampled_error; 0 if clipped */
    uint64_t kernel_count, ray_count, clip_count;
} hpr_block_result;

/*
 * Transport block of one element pair, row-major [n_recv x n_send]:
 *   block[k*n_send + l] = ∫_r ∫_s T_k(x) cosθ_x cosθ_y / (π |x-y|²) V(x,y) T_l(y) dA_y dA_x
 * T orthonormal in area (unit 1/m), so the block is dimensionless; no reflectance in it.
 * Concurrent calls allowed with distinct block and scratch. Never fails: what falls short is in the result.
 * Source: Zatz 1993 (eq. 7); touching pairs: homothety.h.
 */
hpr_block_result hpr_block(const hpr_quadrature *quadrature, const hpr_block_task *task, double *block,
                           hpr_block_scratch *scratch);

/* The same by plain loops over the same points, many times slower: what hpr_block is compared with. */
hpr_block_result hpr_block_ref(const hpr_quadrature *quadrature, const hpr_block_task *task, double *block,
                               hpr_block_scratch *scratch);

#endif
