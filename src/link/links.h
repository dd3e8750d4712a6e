/*
 * The transport operator. A link joins two nodes of the elements' trees, of any level, with the block of
 * kernel inner products between them; every pair of points of two patches that can see each other is in
 * exactly one link. K_ij = K_jiT, so each pair is stored once.
 */
#ifndef HPR_LINK_LINKS_H
#define HPR_LINK_LINKS_H

#include "link/tree.h"

#include <hprad/solve.h>

typedef struct hpr_link {
    uint32_t recv, send;              /* nodes; the receiver's patch is before the sender's */
    size_t offset;                    /* its block in hpr_links.block, row-major [n_recv x n_send] */
    uint8_t recv_degree, send_degree; /* of the block: no more than the nodes'; or HPR_TREE_LEAVES */
    bool partly;                      /* something may come between; then see hpr_tree_stretch, too */
} hpr_link;

/* What integrating the blocks of a link told; kept, so that who takes a block over knows it too. */
typedef struct hpr_link_note {
    double error;         /* largest estimated error of an entry that is not sampled */
    double sampled_error; /* of one that is */
    double sampled2;      /* what rays add to the square of the error, see link/blocked.h */
    uint32_t short_count; /* blocks that stopped short of their tolerance */
} hpr_link_note;

typedef struct hpr_links {
    hpr_context *context;
    hpr_tree *tree;
    size_t count, partly_count;
    hpr_link *link;
    hpr_link_note *note; /* [count] */
    double *block;
    size_t block_count;       /* doubles in block */
    size_t row_count;         /* of nodes */
    size_t *row;              /* [row_count + 1] into row_link */
    uint32_t *row_link;       /* links of each node, rising */
    bool occluded;            /* some pair of patches may be blocked */
    double area_m2;           /* of all patches */
    double link_tolerance;    /* of what the degrees of inner nodes leave out */
    double link_error;        /* what that leaves out of H, of ‖B‖ if all is equally bright, measured */
    double tolerance;         /* of blocks that nothing obstructs */
    double blocked_tolerance; /* of the others; 0: they are sampled */
    double
        sampling_error; /* of the irradiance, relative, from the rays of sampled blocks, see link/blocked.h */
    size_t short_count; /* blocks that stopped short of it */
    double block_error; /* largest estimated error of an entry of those that are not sampled; */
    double sampled_error; /* and of those that are */
} hpr_links;

/* What the operator has to satisfy. */
typedef struct hpr_links_demand {
    double link_tolerance;    /* 0: chosen */
    double block_tolerance;   /* relative, per block; 0: chosen */
    double blocked_tolerance; /* of those that something obstructs; 0: like the others */
    const hpr_links *known;   /* the links of these trees before some leaves were refined, with the same
                                 tolerances; their blocks are taken over where they still serve. NULL: none */
    /* gets the blocks that no product Gauss gives, and is asked for them; NULL: none */
    const hpr_block_keeper *keeper;
    bool constant;     /* links carry constants only, on all levels */
    bool counted;      /* find the links, integrate nothing: block and note stay NULL */
    double most_bytes; /* of blocks; beyond it is refused. 0: chosen (link/afford.h) */
    const bool *sends; /* [patches] does it reflect or emit? Pairs of which none does have no link. */
    /* [patches] radiosity of what links carry from a patch, of the mean, where that is more; else 1. NULL: 1
     */
    const double *brightness;
} hpr_links_demand;

/*
 * Finds the links and integrates their blocks. A link stands where it is, if what the degrees of its nodes
 * leave out of the kernel is small enough (refine.c): where nothing comes between the operator errs by at
 * most ‖δK‖ <= link_tolerance, else the irradiance by that, relative. Links between leaves are exact.
 * block_tolerance 0: 1e-13 if no pair of patches may be blocked, else what hpr_blocked_plan chooses; pairs
 * that see each other partly are clipped or sampled (hpr_blocked_decide). Same bits for any thread count.
 * Errors: HPR_ERR_MEMORY (also when the blocks would exceed most_bytes), HPR_ERR_DEVICE, HPR_ERR_INTERRUPTED.
 */
hpr_status hpr_links_assemble(const hpr_coverage *coverage, const hpr_elements *elements,
                              const hpr_links_demand *demand, hpr_links **links);
void hpr_links_destroy(hpr_links **links);

/* Entries of a link's block. */
size_t hpr_link_size(const hpr_links *links, const hpr_link *link);

/*
 * Irradiance that a node receives through its own links: H = sum_j K_ij B_j.
 * radiosity, irradiance: [channels][tree's dofs]; only the node's coefficients are written. Each value is
 * summed in a fixed order. Thread-safe for distinct nodes.
 */
void hpr_links_gather(const hpr_links *links, size_t node, size_t channel_count, const double *radiosity,
                      double *irradiance);

/*
 * What a node sends, added to all that it is linked with: irradiance_j += K_ji B. reached [patches]: set for
 * the patches of these. Same layouts.
 */
void hpr_links_scatter(const hpr_links *links, size_t node, size_t channel_count, const double *radiosity,
                       double *irradiance, bool *reached);

#endif
