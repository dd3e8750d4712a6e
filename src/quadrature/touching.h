/*
 * What the vertex and the edge rule share: triangles in the reference coordinates of Sauter & Schwab 2011,
 * sec. 5.2: x = P0 + x1 (P1 - P0) + x2 (P2 - P1), 0 <= x2 <= x1 <= 1. The kernel is homogeneous of degree -2
 * in x - y, so that the coordinates that only scale x - y leave it but for a power; that power cancels part
 * of the Jacobian, and along them only the polynomials have to be integrated.
 */
#ifndef HPR_QUADRATURE_TOUCHING_H
#define HPR_QUADRATURE_TOUCHING_H

#include "quadrature/rule.h"

/* A triangle seen from the contact. */
typedef struct hpr_wing {
    const hpr_cell *cell;
    hpr_vec3 first, second;             /* P1 - P0, P2 - P1 in space */
    double first_height, second_height; /* the same over the other's plane */
    double jacobian;                    /* of the parameters by (x1, x2) */
} hpr_wing;

hpr_wing hpr_wing_make(const hpr_element_frame *frame, const hpr_affine *height, const hpr_cell *cell);

/* Appends the point with parameters at (x1, x2), relative position and height-weighted weight as given. */
void hpr_wing_append(const hpr_wing *wing, hpr_points *points, double x1, double x2, hpr_vec3 position,
                     double weight);

#endif
