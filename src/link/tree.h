/*
 * Coefficients on all nodes of the elements' trees. A link joins two nodes of any level; what a node sends
 * is pulled up from the leaves below it, and what it receives is pushed down to them. Inner nodes have a
 * degree of their own, which may be higher than that of the leaves. A small node can also be linked by the
 * coefficients of all its leaves at once, so that near elements need not go one by one; for that it keeps a
 * copy of them behind its own coefficients. Every patch has a tree of its own, so all pairs of patches are
 * looked at; a hierarchy above patches, for scenes of many small ones, would put nodes over these roots.
 * Source: Hanrahan, Salzman & Aupperle 1991; Gortler, Schroeder, Cohen & Hanrahan 1993.
 */
#ifndef HPR_LINK_TREE_H
#define HPR_LINK_TREE_H

#include "basis/two_scale.h"
#include "link/coverage.h"
#include "link/quad_tables.h"

/* What lies below a node. */
typedef enum hpr_node_kind {
    HPR_NODE_OPEN,   /* leaves of which nothing is covered */
    HPR_NODE_MIXED,  /* some of it is covered */
    HPR_NODE_COVERED /* nothing but covered leaves: no links */
} hpr_node_kind;

/* In the place of a degree: the coefficients of all leaves below a node, leaf after leaf. */
enum { HPR_TREE_LEAVES = 255 };

typedef struct hpr_tree {
    hpr_context *context;
    const hpr_coverage *coverage; /* borrowed, and needed to pull and push only */
    const hpr_patches *patches;   /* borrowed */
    const hpr_elements *elements; /* borrowed */
    hpr_two_scale *two_scale;
    hpr_quad_tables *quads; /* NULL: no quadrilaterals */
    uint8_t *degree;        /* [node_count] of leaves the element's */
    uint8_t *worth;         /* [node_count] highest degree that a link may have there */
    uint8_t *kind;          /* [node_count] hpr_node_kind */
    uint32_t *leaf;         /* [node_count][2] the leaves below a node: from, up to */
    uint32_t *node;         /* [node_count] the nodes of patch after patch, each before its children */
    uint32_t *first;        /* [patch_count + 1] into node */
    size_t *dof; /* [node_count] first coefficient of each node; those of a patch are consecutive */
    size_t dof_count;
    int highest_degree;  /* of any node */
    size_t most_at_once; /* coefficients of leaves that a node may be linked by */
} hpr_tree;

/*
 * Inner nodes get inner_degree, or the highest degree of the leaves if that is more. Nodes whose leaves have
 * no more coefficients than a parallelogram of that degree may be linked by these. Errors: HPR_ERR_MEMORY.
 */
hpr_status hpr_tree_create(const hpr_coverage *coverage, const hpr_elements *elements, int inner_degree,
                           hpr_tree **tree);
void hpr_tree_destroy(hpr_tree **tree);

/* Number of functions of some degree on a node, or HPR_TREE_LEAVES of them. */
size_t hpr_tree_count(const hpr_tree *tree, size_t node, int degree);

/* May the node be linked by its leaves' coefficients? Leaves may, for these are their own. */
bool hpr_tree_at_once(const hpr_tree *tree, size_t node);

/* Coefficients that a node has in the tree's arrays, from dof[node] on: its own and the copy. */
size_t hpr_tree_room(const hpr_tree *tree, size_t node);

/* The frame of a node, with some degree. */
hpr_element_frame hpr_tree_frame(const hpr_tree *tree, size_t node, int degree);

/*
 * Is it an inner node of which some part is covered? What such a node has in the tree's arrays are, as of any
 * node, moments of what its leaves send, ∫_O T_k B dA over the open part O, and a polynomial of what they
 * receive, which counts on O alone. So a link that sees wholly may have the kernel's moments over the whole
 * node, as if nothing lay there. One that sees partly has degree 0 there and the moment over O; then
 * hpr_tree_stretch, one over the share of O, makes the mean over O of it.
 */
bool hpr_tree_is_mixed(const hpr_tree *tree, size_t node);
double hpr_tree_stretch(const hpr_tree *tree, size_t node);

/*
 * The coefficients of a node up to some degree, in the order of that degree's basis, or those of its leaves:
 * a pointer into node [dof_count], or `room` [HPR_MAX_BASIS] filled if the order differs.
 */
const double *hpr_tree_take(const hpr_tree *tree, size_t node, int degree, const double *value, double *room);

/* The other way round: value += part. */
void hpr_tree_add(const hpr_tree *tree, size_t node, int degree, const double *part, double *value);

/* node [dof_count]: of a patch's leaves taken from leaf [leaf dofs], of the others pulled up; to do so makes
 * moments over the open part of a leaf's coefficients, and hpr_tree_push does the same to what leaves get
 * from above, for moments are what they get from their own links. Thread-safe for distinct patches. */
void hpr_tree_pull(const hpr_tree *tree, size_t patch, const double *leaf, double *node);

/* leaf: what all nodes of a patch have, pushed down. node is used up. Thread-safe for distinct patches. */
void hpr_tree_push(const hpr_tree *tree, size_t patch, double *node, double *leaf);

#endif
