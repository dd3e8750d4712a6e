/* An element's polynomial along the two axes of the element, which tells where it is smooth. */
#ifndef HPR_SOLVER_ALONG_H
#define HPR_SOLVER_ALONG_H

#include "quadrature/pair.h"

/*
 * value [(p+1)^2]: coefficients of orthonormal tensor Legendre polynomials, k = (p+1) a + b, of the function
 * of a leaf, coefficient [hpr_basis_count][stride]. A parallelogram has them. Of a quadrilateral they are of
 * the function of (u,v) in the unit square from which the bilinear map comes, times the root of the area:
 * exact, for that is of degree p at most in u and in v; in norm, of a quadrilateral that is nearly a
 * parallelogram, what the function's own are, and then next to nothing has a + b > p. Triangles have no axes.
 */
void hpr_along_axes(const hpr_element_frame *frame, const double *coefficient, size_t stride, double *value);

#endif
