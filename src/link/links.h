/*
 * The transport operator between leaves. A link joins two patches and holds the dense blocks of all their
 * leaf pairs; blocks between patches that cannot see each other do not exist. K_ij = K_jiT, so each pair is
 * stored once.
 */
#ifndef HPR_LINK_LINKS_H
#define HPR_LINK_LINKS_H

#include "link/coverage.h"

typedef struct hpr_link {
    uint32_t recv, send; /* patches, recv < send */
    size_t offset;       /* first of its blocks in hpr_links.block */
} hpr_link;

typedef struct hpr_links {
    hpr_context *context;
    const hpr_elements *elements; /* borrowed */
    size_t count;
    hpr_link *link; /* [count] rising (recv, send) */
    /* One matrix per link, row-major [dofs of recv] x [dofs of send]: K_ij of leaves i, j is its submatrix at
     * row dof_i - first dof of recv, column dof_j - first dof of send. */
    double *block;
    size_t block_count;       /* doubles in block */
    size_t *row;              /* [patch_count + 1] into row_link */
    uint32_t *row_link;       /* links of each patch, rising by the other patch */
    bool occluded;            /* some pair of patches may be blocked */
    double tolerance;         /* of blocks that nothing obstructs */
    double blocked_tolerance; /* of the others; 0: they are sampled */
    size_t short_count;       /* blocks that stopped short of it */
    double block_error;       /* largest estimated error of an entry of those that are not sampled; */
    double sampled_error;     /* and of those that are */
} hpr_links;

/* First entry of the block of leaves i (of the link's receiver) and j (of its sender); rows are `*stride`
 * apart. */
size_t hpr_link_block(const hpr_links *links, const hpr_link *link, size_t leaf_i, size_t leaf_j,
                      size_t *stride);

/*
 * Integrates all blocks. tolerance 0: 1e-12 if no pair of patches may be blocked, 1e-5 else; pairs that see
 * each other partly are clipped to a tolerance chosen by their number, relative to the block or to the
 * sender's share of the area, and if there are too many they are sampled. Same bits for any thread count.
 * Errors: HPR_ERR_MEMORY (also when the blocks would exceed the machine's memory), HPR_ERR_DEVICE,
 * HPR_ERR_INTERRUPTED.
 */
hpr_status hpr_links_assemble(const hpr_coverage *coverage, const hpr_elements *elements, double tolerance,
                              hpr_links **links);
void hpr_links_destroy(hpr_links **links);

/*
 * Irradiance of the leaves [leaf, leaf_end) of one patch: H_i = sum_j K_ij B_j.
 * radiosity, irradiance: [channels][dofs]; only the rows of these leaves are written. Each value is summed in
 * a fixed order that does not depend on the range. Thread-safe for distinct ranges.
 */
void hpr_links_gather(const hpr_links *links, size_t patch, size_t leaf, size_t leaf_end,
                      size_t channel_count, const double *radiosity, double *irradiance);

#endif
