/*
 * How blocks are integrated between elements that see each other partly: clipped exactly to a tolerance, or
 * by rays; and what rays add to the error.
 */
#ifndef HPR_LINK_BLOCKED_H
#define HPR_LINK_BLOCKED_H

#include "quadrature/block.h"

/* What is to be done in all. */
typedef struct hpr_blocked_load {
    size_t pair_count;    /* pairs of elements that may see each other partly */
    double spread;        /* sum over pairs of patches that may of hpr_blocked_spread */
    double blocker_count; /* of such a pair, on the average */
    double area_m2;       /* of all patches */
    double asked;         /* tolerance that the user wants, 0: none */
} hpr_blocked_load;

typedef struct hpr_blocked {
    double tolerance;      /* of clipped blocks, relative to themselves or to the sender's share of the area;
                              0: by rays */
    double open_tolerance; /* of blocks that nothing obstructs */
    double area_m2;
    double rays; /* of a sampled block, over its hpr_blocked_spread; 0: as its rules have points */
} hpr_blocked;

/*
 * What sampling a pair by one ray adds to the error at most, as hpr_blocked_error2 counts it:
 *   s = K^00 / 2 sqrt((A_r + A_s) / A),   K^00 <= sqrt(A_r A_s) / (pi r^2) and sqrt(smaller / larger area)
 */
double hpr_blocked_spread(const hpr_element_frame *recv, const hpr_element_frame *send, double area_m2);

/*
 * Clipping for a point takes about 0.5 + 0.07 b microseconds, b the blockers, and at a tolerance of 1e-6,
 * 1e-3, 1e-2 or 3e-2 there are 4000, 500, 300 or 250 points to a pair (observed, counting pairs that turn out
 * hidden). The tightest of these tolerances is taken with which all pairs take at most 4, 6, 25 or 40 s; if
 * there is none, they go by rays. Blocks that nothing obstructs get a tenth of that tolerance, for more would
 * be lost among the errors of the others, and 1e-5 at least.
 */
hpr_blocked hpr_blocked_plan(const hpr_blocked_load *load);

/*
 * Sets clip, tolerance, ray_nodes and negligible of a task whose blockers and parts are known; recv_m2,
 * send_m2: the open area of the two elements. Without blockers or parts the task is left as it is. A block's
 * error of t sqrt(A_r A_s) / A is one of t A_s / A in the form factor: of one sign in all senders, a relative
 * error of t in the irradiance; in truth they have either sign. So that much is negligible, and for rays 0.03
 * of it.
 *
 * Rays err in either sign for certain, and are shared out among all blocks so that few do most: with n_i rays
 * of block i the square of the error is sum_i s_i^2 / n_i, s_i its spread, and for a given sum of n_i least
 * if n_i is proportional to s_i. So, where a tolerance t is asked for, n_i = s_i sum_j s_j / t^2, the sum
 * over pairs of patches: halving an element of each leaves it as it is. Where that is at most 16, a few rays
 * it is, also instead of clipping; and no sampled block takes a finer rule for the kernel than its rays
 * deserve.
 */
void hpr_blocked_decide(const hpr_blocked *blocked, double recv_m2, double send_m2, hpr_block_task *task);

/*
 * What a block adds to the square of
 *   e = sqrt(∫ dH^2 dA / ∫ H^2 dA)
 * by its sampling, were all surfaces equally bright and H as bright as they are: dH_r = d_rs sqrt(A_s / A_r)
 * of T_0, d_rs the standard error of K_rs^00; both ways, as receiver and as sender: d_rs^2 (A_r + A_s) / A.
 * The blocks err independently, so these add up; the sum's root is the error of one reflection.
 */
double hpr_blocked_error2(const hpr_blocked *blocked, const hpr_block_task *task,
                          const hpr_block_result *result);

#endif
