/*
 * Constants on many elements against constants on many others, all at once: product Gauss with as many nodes
 * as each pair needs, eight senders side by side.
 */
#ifndef HPR_QUADRATURE_CONSTANTS_H
#define HPR_QUADRATURE_CONSTANTS_H

#include "quadrature/far.h"

/* Parallelograms and triangles, wherever they lie. Borrowed. */
typedef struct hpr_panel {
    size_t count;
    const hpr_element_frame *frame; /* [count] */
} hpr_panel;

typedef struct hpr_constants_task {
    const hpr_far *tables;
    hpr_panel recv, send;
    double tolerance; /* relative, of each pair */
    double slack_m;   /* a height over the other's plane of at most that is none */
} hpr_constants_task;

/* What is to be done with a pair, and what was. */
typedef enum hpr_pair_kind {
    HPR_PAIR_WANTED,  /* to be integrated; after that: it was, or neither sees the other */
    HPR_PAIR_UNASKED, /* not to be touched */
    HPR_PAIR_LEFT     /* too near for so few nodes, or across the other's plane: for other rules */
} hpr_pair_kind;

typedef struct hpr_constants_result {
    uint64_t kernel_count;
    size_t pair_count; /* integrated */
    double error;      /* the largest estimate of one of them, relative */
} hpr_constants_result;

/* Doubles that hpr_constants_block needs as scratch. */
size_t hpr_constants_scratch(size_t recv_count, size_t send_count);

/*
 * block[i * send.count + j] = K_ij^00 = 1 / sqrt(A_i A_j) ∫_i ∫_j G dA dA of pairs that see each other wholly
 * unless they are behind each other's planes, where kind[the same] is HPR_PAIR_WANTED; other entries are not
 * written. Those for which it then is HPR_PAIR_LEFT are at 0. Nodes per axis are those of which the error of
 * 1/r^4, hpr_kernel_error with the distance of the spheres around the two elements, grown by what the heights
 * over each other's plane vary, is within the tolerance, HPR_FAR_NODES at most, and the most that one of
 * eight neighbours needs. So are pairs left whose heights are so small that rounding of the coordinates would
 * be seen. The same bits for one instruction set of the tables' context. Concurrent calls allowed with
 * distinct block, kind and scratch.
 */
hpr_constants_result hpr_constants_block(const hpr_constants_task *task, double *block, uint8_t *kind,
                                         double *scratch);

#endif
