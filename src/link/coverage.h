/*
 * What of an element lies open. A block that stands on a floor covers a part of it; there no light arrives,
 * and at its foot the irradiance jumps. A polynomial that had to follow the jump would ring; so the
 * projection is taken over the open part alone:
 *   H = sum_k c_k T_k on the open part O with ∫_O T_k (H - sum_l c_l T_l) dA = 0, that is G c = m,
 *   G_kl = ∫_O T_k T_l dA, m_k = ∫ T_k H dA, which kernel blocks give: what is covered receives nothing.
 * On the covered part H is 0.
 */
#ifndef HPR_LINK_COVERAGE_H
#define HPR_LINK_COVERAGE_H

#include "visibility/visibility.h"

#include "quadrature/pair.h"

/* Convex parts that the open part of an element may have; if there would be more, all of it counts as open.
 */
enum { HPR_COVERAGE_PIECES = 64 };

typedef struct hpr_coverage hpr_coverage;

/*
 * Finds the covered parts: each patch is cut along the lines in which other patches meet its plane; a piece
 * is covered if it lies against a patch that faces it, but not if the two are the sides of a thin wall, or if
 * no light can come there, as under a closed block (link/shut.h). In a scene of more than 20,000 patches all
 * counts as open. Errors: HPR_ERR_MEMORY, HPR_ERR_DEVICE.
 */
hpr_status hpr_coverage_create(const hpr_patches *patches, const hpr_elements *elements,
                               hpr_coverage **coverage);
void hpr_coverage_destroy(hpr_coverage **coverage);

/* The patches that it was made from. */
const hpr_patches *hpr_coverage_patches(const hpr_coverage *coverage);

/* Leaves of which some part is covered, and those of which all is. */
void hpr_coverage_count(const hpr_coverage *coverage, size_t *partly, size_t *wholly);

/* Does something stand on a leaf that is not covered wholly? There H jumps, from one side of a sheet to the
 * other if nothing is covered. */
bool hpr_coverage_cut(const hpr_coverage *coverage, size_t leaf);

/*
 * The open part of a leaf of which some part is covered: convex polygons in its parameters, *count of them, 0
 * if all is covered. NULL for an open leaf. Borrowed.
 */
const hpr_polygon *hpr_coverage_parts(const hpr_coverage *coverage, size_t leaf, int *count);

/* The open part of a leaf's area, 0 .. 1. */
double hpr_coverage_open_share(const hpr_coverage *coverage, size_t leaf);

/*
 * The same of any node. Of an inner node of which some part is covered *count is 0, too, if it would have
 * more than HPR_COVERAGE_PIECES: then nothing is known of it but what its children tell.
 */
const hpr_polygon *hpr_coverage_node_parts(const hpr_coverage *coverage, size_t node, int *count);
double hpr_coverage_node_share(const hpr_coverage *coverage, size_t node);

/* False if the point (s,t) of a leaf is covered. Thread-safe. */
bool hpr_coverage_open(const hpr_coverage *coverage, size_t leaf, double s, double t);

/*
 * Turns moments m [n] of a leaf into coefficients c = G+ m in place, n the leaf's functions; nothing to do
 * for an open leaf. G+ leaves out directions in which the open part determines nothing (eigenvalues below
 * 1e-3 of the largest). Never allocates; thread-safe.
 */
void hpr_coverage_project(const hpr_coverage *coverage, size_t leaf, double *moment);

/* The other way round, m = G c in place: the moments of Σ c_k T_k over the open part. Thread-safe. */
void hpr_coverage_weigh(const hpr_coverage *coverage, size_t leaf, double *coefficient);

/* ∫_O T_0 H dA from coefficients, the first apart by `stride`. Thread-safe. */
double hpr_coverage_mean(const hpr_coverage *coverage, size_t leaf, const double *coefficient, size_t stride);

#endif
