/*
 * What a tree over quadrilaterals keeps per node, for no two of them are alike: the basis of inner nodes
 * (that of leaves is the elements'), and the two-scale matrix of each child. For degree p with n = (p + 1)(p
 * + 2)/2 functions that is about n^2 doubles per node, as much as the block of one link.
 */
#ifndef HPR_LINK_QUAD_TABLES_H
#define HPR_LINK_QUAD_TABLES_H

#include "patch/elements.h"

typedef struct hpr_quad_tables hpr_quad_tables;

/* degree [node_count]: of each node. Borrowed, like patches and elements. *tables is NULL if there are
 * no quadrilaterals.
 * Errors: HPR_ERR_MEMORY. */
hpr_status hpr_quad_tables_create(const hpr_patches *patches, const hpr_elements *elements,
                                  const uint8_t *degree, hpr_quad_tables **tables);
void hpr_quad_tables_destroy(hpr_quad_tables **tables);

/* The recurrence (math/planar_basis.h) of an inner node that is a quadrilateral. */
const double *hpr_quad_tables_basis(const hpr_quad_tables *tables, size_t node);

/* M of a child [functions of the parent][functions of the child] (basis/two_scale.h). */
const double *hpr_quad_tables_matrix(const hpr_quad_tables *tables, size_t child);

#endif
