/* Light that is lost: on the black backs of patches, and into the open. */
#ifndef HPR_SOLVER_LOSSES_H
#define HPR_SOLVER_LOSSES_H

#include "link/tree.h"
#include "quadrature/cuts.h"
#include "solver/mass.h"
#include "solver/solution.h"
#include "visibility/visibility.h"

typedef struct hpr_losses {
    /* borrowed */
    const hpr_solution *solution;
    const hpr_coverage *coverage;
    const hpr_mass *mass;
    const hpr_tree *tree;
    const double *reflected; /* [dofs][channels] coefficients of rho H where rho varies; NULL: nowhere */
    double tolerance;        /* absolute, W in all */
    /* its own */
    hpr_visibility *visibility;
    size_t rays;  /* per leaf */
    bool *shaded; /* [patches] something may come between it and what it sees */
    bool *done;   /* [leaves] lost already with a node above */
    double *lost; /* [leaves][2][channels] on backs, escaped; summed in leaf order */
} hpr_losses;

/*
 * Adds to lost_on_backs and escaped of energy [channels] the integrals over all patches of B f_back and B
 * f_out, f_back(y) the part of the light leaving y that meets the back of a single-sided patch, f_out that
 * which meets nothing. Of patches that nothing can shade the fractions are Lambert's, carried by polynomials
 * on nodes of the trees as large as the tolerance allows, so that the work does not grow with the elements
 * but near what makes the fractions bend; of the others they are sampled by about a million rays in all, of
 * many leaves by a few each. Same bits for any thread count. Errors: HPR_ERR_MEMORY, HPR_ERR_DEVICE,
 * HPR_ERR_INTERRUPTED.
 */
hpr_status hpr_losses_add(hpr_losses *losses, hpr_energy *energy);

/* f_back and f_out at one point of a patch. */
typedef struct hpr_fractions {
    double back, out;
} hpr_fractions;

/* Exact, where nothing shades: every other patch is seen from its front or from its back. */
hpr_fractions hpr_losses_at(const hpr_losses *losses, size_t patch, const double point[3]);

/* Coefficient k of B on a leaf. */
double hpr_losses_radiosity(const hpr_losses *losses, size_t leaf, size_t channel, size_t k);

/* A node cut where it crosses the planes of other patches: on one side they show their fronts, on the other
 * their backs, so that the fractions have a kink there. */
void hpr_losses_cut(const hpr_losses *losses, uint32_t node, const hpr_element_frame *frame,
                    hpr_cuts *pieces);

/* What can be had on nodes: sets done, and lost of these leaves. Errors: HPR_ERR_MEMORY. */
hpr_status hpr_losses_on_nodes(hpr_losses *losses);

#endif
