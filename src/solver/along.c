#include "solver/along.h"

#include "basis/basis.h"
#include "math/planar_basis.h"

#include <assert.h>
#include <math.h>
#include <string.h>

/* Gauss of p + 1 nodes along u and v integrates the products with Legendre polynomials exactly. */
static void project_bilinear(const hpr_element_frame *frame, const double *coefficient, size_t stride,
                             double *value)
{
    int degree = frame->degree, n = degree + 1;
    const hpr_gauss_rule *rule = &hpr_gauss.legendre[n];
    size_t functions = hpr_basis_count(HPR_SHAPE_QUADRILATERAL, degree), products = (size_t)(n * n);
    double root = hpr_frame_scale(frame) * sqrt(frame->area_m2), own[HPR_MAX_BASIS], tensor[HPR_MAX_BASIS];
    memset(value, 0, products * sizeof *value);
    for (int q = 0; q < n * n; q++) {
        hpr_planar_node x = hpr_planar_gauss(frame->opposite, rule, n, q);
        double f = 0, weight = root * rule->weight[q % n] * rule->weight[q / n];
        hpr_frame_basis(frame, x.s, x.t, own);
        hpr_basis_eval(HPR_SHAPE_PARALLELOGRAM, degree, rule->node[q % n], rule->node[q / n], tensor);
        for (size_t k = 0; k < functions; k++)
            f += coefficient[k * stride] * own[k];
        for (size_t k = 0; k < products; k++)
            value[k] += weight * f * tensor[k];
    }
}

void hpr_along_axes(const hpr_element_frame *frame, const double *coefficient, size_t stride, double *value)
{
    assert(frame->shape != HPR_SHAPE_TRIANGLE);
    if (frame->shape == HPR_SHAPE_QUADRILATERAL) {
        project_bilinear(frame, coefficient, stride, value);
        return;
    }
    for (size_t k = 0; k < hpr_basis_count(frame->shape, frame->degree); k++)
        value[k] = coefficient[k * stride];
}
