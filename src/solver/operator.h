/* The transport operator applied: what leaves send is pulled up their trees, carried by the links, and pushed
 * down to the leaves. */
#ifndef HPR_SOLVER_OPERATOR_H
#define HPR_SOLVER_OPERATOR_H

#include "link/links.h"

typedef struct hpr_operator {
    const hpr_links *links; /* borrowed */
    size_t channel_count;
    size_t leaf_dofs, node_dofs;
    double *sent, *received; /* [channels][node_dofs] */
    size_t *work;            /* [patches] multiplications of a gather, one channel */
} hpr_operator;

/* Errors: HPR_ERR_MEMORY. */
hpr_status hpr_operator_create(const hpr_links *links, size_t channel_count, hpr_operator **op);
void hpr_operator_destroy(hpr_operator **op);

/* Takes over what a patch sends, radiosity [channels][leaf_dofs]. Thread-safe for distinct patches. */
void hpr_operator_send(hpr_operator *op, size_t patch, const double *radiosity);

/*
 * irradiance [channels][leaf_dofs]: of the patch's leaves, sum_j K_ij B_j over what was sent; other leaves'
 * are left alone. Large patches are shared between threads; the bits do not depend on it.
 */
void hpr_operator_receive(hpr_operator *op, size_t patch, double *irradiance);

/* Both for all patches. */
void hpr_operator_apply(hpr_operator *op, const double *radiosity, double *irradiance);

#endif
