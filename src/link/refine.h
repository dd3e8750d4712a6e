/* Which nodes are joined by links. */
#ifndef HPR_LINK_REFINE_H
#define HPR_LINK_REFINE_H

#include "link/links.h"
#include "visibility/views.h"

/* The piece of a patch that a node is: the whole node, or the only open part of a leaf. */
hpr_facet hpr_node_facet(const hpr_coverage *coverage, const hpr_tree *tree, size_t node);

/* Square of a sender's part of ‖B‖, the mean of both directions. brightness: as in hpr_links_demand. */
double hpr_link_part2(const hpr_links *links, const double *brightness, uint32_t recv, uint32_t send);

/* Square of what a link leaves out of H, of ‖B‖, because something comes between; from its block. */
double hpr_link_jump2(const hpr_links *links, const double *brightness, const hpr_link *link);

typedef struct hpr_link_refinement {
    const hpr_coverage *coverage;
    const hpr_visibility *visibility;
    const hpr_views *views;
    const uint8_t *verdict;   /* [patches][patches] hpr_verdict, upper triangle */
    const double *brightness; /* as in hpr_links_demand */
    hpr_links *links; /* tree, area_m2 and link_tolerance are set; count, partly_count and link are filled */
} hpr_link_refinement;

/*
 * Goes down from every pair of patches that see each other until the link may stand. Runs in parallel, same
 * links in the same order for any thread count. Errors: HPR_ERR_MEMORY, HPR_ERR_INTERRUPTED.
 */
hpr_status hpr_links_refine(const hpr_link_refinement *refinement);

#endif
