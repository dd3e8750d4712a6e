/*
 * Elements: the nodes of one binary tree per patch. A parallelogram splits in halves along one of its axes:
 * child 0 is the half with the smaller parameter. A triangle (v0, v1, v2) is split by the line from v0 to the
 * middle m of v1-v2 (newest vertex bisection, Mitchell 1991): child 0 is (m, v0, v1), child 1 is (m, v2, v0),
 * so that a child point (s', t') is the parent point (s, t) = ((1 - s' + t')/2, (1 - s' - t')/2) in child 0
 * and ((1 - s' - t')/2, (1 + s' - t')/2) in child 1, and orientation is kept. A quadrilateral is split like a
 * parallelogram by the line between the middles of two opposite sides, into two quadrilaterals
 * (hpr_quad_half). Leaves carry the solution, each with a degree of its own. A node has the frame of its own:
 * x = origin + s edge1 + t edge2.
 */
#ifndef HPR_PATCH_ELEMENTS_H
#define HPR_PATCH_ELEMENTS_H

#include "patch/patches.h"

typedef struct hpr_elements {
    hpr_context *context;
    size_t node_count;
    uint32_t *patch;                /* [node_count] */
    uint32_t *child;                /* [node_count] first of two consecutive children, HPR_NONE: leaf */
    uint8_t *axis;                  /* [node_count] no triangle: axis that the children halve (0: s, 1: t) */
    uint8_t *degree;                /* [node_count] */
    double *origin, *edge1, *edge2; /* [node_count][3] */
    double *opposite;               /* [node_count][2] of a quadrilateral (patch/shape.h) */
    double *area_m2;                /* [node_count] */
    size_t leaf_count;
    uint32_t *leaf;         /* [leaf_count] node of each leaf; leaves of a patch are consecutive */
    uint32_t *leaf_of_node; /* [node_count] the other way round, HPR_NONE for inner nodes */
    uint32_t
        *patch_leaf; /* [patch_count + 1] first leaf of each patch; roots are nodes 0 .. patch_count - 1 */
    size_t *dof;     /* [leaf_count + 1] first coefficient of each leaf */
    size_t patch_count;
    /* The basis of leaves that are quadrilaterals (math/planar_basis.h), of their degree; without any, both
     * are NULL. */
    double *recurrence;
    size_t *recurrence_at; /* [leaf_count] */
} hpr_elements;

/* 4^subdivide leaves of degree `order` on each patch; parallelograms are halved along s, t, s, t, ...
 * Errors: HPR_ERR_ARG (order, subdivide), HPR_ERR_MEMORY (too many for memory or indices). */
hpr_status hpr_elements_uniform(const hpr_patches *patches, int order, int subdivide,
                                hpr_elements **elements);
/* A leaf, or a piece of it that a refinement would make, in the parameters of its patch: (s,t) = origin +
 * a edge1 + b edge2; of a quadrilateral in those of the bilinear map from the unit square. */
typedef struct hpr_piece_of_leaf {
    uint32_t patch, leaf;
    int level; /* halvings since the patch */
    int depth; /* halvings since the leaf */
    double origin[2], edge1[2], edge2[2];
} hpr_piece_of_leaf;

/* The axis along which a piece is to be halved (of a triangle: any), -1: not at all. Asked twice for each,
 * with the same answer expected. */
typedef int hpr_split_choice(void *user, const hpr_piece_of_leaf *piece);

/* Halves leaves, and the halves again, as `choose` says; they keep their degree. Leaves are numbered anew.
 * Errors: HPR_ERR_MEMORY. */
hpr_status hpr_elements_refine(const hpr_patches *patches, hpr_elements *elements, hpr_split_choice *choose,
                               void *user);
/* Splits the leaves that are marked, marked [leaf_count], each into four of the same degree: a parallelogram
 * along both axes, a triangle twice. Leaves are numbered anew. Errors: HPR_ERR_MEMORY. */
hpr_status hpr_elements_split(const hpr_patches *patches, hpr_elements *elements, const bool *marked);

void hpr_elements_destroy(hpr_elements **elements);

/* Fills leaf, leaf_of_node, patch_leaf, dof and recurrence from the tree; called by whoever has built one.
 * Errors: HPR_ERR_MEMORY. */
hpr_status hpr_elements_index(const hpr_patches *patches, hpr_elements *elements);

/* The leaf that holds the point (s,t) of a patch, and the point's parameters in that leaf. A point on a
 * border between leaves belongs to one of them, always the same; one outside the patch to a leaf on its rim,
 * with parameters outside too. Concurrent calls allowed. */
size_t hpr_elements_locate(const hpr_patches *patches, const hpr_elements *elements, size_t patch, double s,
                           double t, double *leaf_s, double *leaf_t);

#endif
