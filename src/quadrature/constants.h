/*
 * Constants on many elements of one plane against constants on many of another, all at once: product Gauss
 * with as many nodes as each pair needs, eight senders side by side.
 */
#ifndef HPR_QUADRATURE_CONSTANTS_H
#define HPR_QUADRATURE_CONSTANTS_H

#include "quadrature/far.h"

/* Parallelograms or triangles, of one shape, in one plane. Borrowed. */
typedef struct hpr_panel {
    size_t count;
    const hpr_element_frame *frame; /* [count] */
} hpr_panel;

/* Doubles that hpr_constants_block needs as scratch. */
size_t hpr_constants_scratch(size_t recv_count, size_t send_count);

/*
 * block[i * send->count + j] = K_ij^00 = 1 / sqrt(A_i A_j) ∫_i ∫_j G dA dA for wholly visible pairs, each to
 * the relative tolerance. near[the same]: pairs that are too near for that; their entries are left at 0.
 * Neither panel may cross the other's plane or lie behind it. Nodes per axis are those of hpr_kernel_error
 * with the distance of the spheres around the two elements, HPR_FAR_NODES at most, and the most that one of
 * eight neighbours needs. Returns the number of kernel evaluations. Concurrent calls allowed with distinct
 * block, near and scratch.
 */
uint64_t hpr_constants_block(const hpr_far *tables, const hpr_panel *recv, const hpr_panel *send,
                             double tolerance, double *block, bool *near, double *scratch);

#endif
