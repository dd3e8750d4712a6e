#include "patch/shape.h"

#include <math.h>

size_t hpr_shape_corners(hpr_shape shape, const double opposite[2], double corner[4][2])
{
    static const double fixed[4][2] = {{0, 0}, {1, 0}, {1, 1}, {0, 1}};
    for (int i = 0; i < 4; i++) {
        for (int k = 0; k < 2; k++)
            corner[i][k] = i == 2 && shape == HPR_SHAPE_QUADRILATERAL ? opposite[k] : fixed[i][k];
    }
    if (shape != HPR_SHAPE_TRIANGLE)
        return 4;
    corner[2][0] = 0;
    return 3;
}

double hpr_shape_measure(hpr_shape shape, const double opposite[2])
{
    if (shape == HPR_SHAPE_QUADRILATERAL)
        return (opposite[0] + opposite[1]) / 2;
    return shape == HPR_SHAPE_PARALLELOGRAM ? 1 : 0.5;
}

void hpr_shape_middle(hpr_shape shape, const double opposite[2], double middle[2])
{
    for (int k = 0; k < 2; k++) {
        middle[k] = shape == HPR_SHAPE_PARALLELOGRAM ? 0.5
                    : shape == HPR_SHAPE_TRIANGLE    ? 1.0 / 3
                                                     : (1 + opposite[k]) / 4;
    }
}

/* Of a quadrilateral: positive inside of the side from (1,0) to (a,b) and of the one from (a,b) to (0,1). */
static void far_sides(const double opposite[2], double s, double t, double inside[2])
{
    double a = opposite[0], b = opposite[1];
    inside[0] = (a - 1) * t - b * (s - 1);
    inside[1] = (b - 1) * s - a * (t - 1);
}

bool hpr_shape_holds(hpr_shape shape, const double opposite[2], double s, double t)
{
    if (!(s > 0 && t > 0))
        return false;
    if (shape == HPR_SHAPE_TRIANGLE)
        return s + t < 1;
    if (shape == HPR_SHAPE_PARALLELOGRAM)
        return s < 1 && t < 1;
    double inside[2];
    far_sides(opposite, s, t, inside);
    return inside[0] > 0 && inside[1] > 0;
}

void hpr_shape_uniform(hpr_shape shape, const double opposite[2], double u, double v, double point[2])
{
    double first[2] = {1, 0}, second[2] = {0, 1};
    if (shape == HPR_SHAPE_QUADRILATERAL) {
        /* One of the triangles beside the diagonal from the origin; their areas are as b to a. */
        double share = opposite[1] / (opposite[0] + opposite[1]);
        bool upper = u >= share;
        u = upper ? (u - share) / (1 - share) : u / share;
        for (int k = 0; k < 2; k++)
            *(upper ? &first[k] : &second[k]) = opposite[k];
    }
    if (shape != HPR_SHAPE_PARALLELOGRAM && u + v > 1) {
        u = 1 - u;
        v = 1 - v;
    }
    for (int k = 0; k < 2; k++)
        point[k] = u * first[k] + v * second[k];
}

hpr_quad_piece hpr_quad_box(const double opposite[2], const double low[2], const double width[2],
                            double *measure)
{
    double a = opposite[0] - 1, b = opposite[1] - 1, u = low[0], v = low[1], du = width[0], dv = width[1];
    double jacobian = 1 + v * a + u * b; /* at the box's origin */
    *measure = du * dv * (1 + (v + dv / 2) * a + (u + du / 2) * b);
    return (hpr_quad_piece){{u + u * v * a, v + u * v * b},
                            {du * (1 + v * a), du * v * b},
                            {dv * u * a, dv * (1 + u * b)},
                            {1 + dv * a / jacobian, 1 + du * b / jacobian}};
}

hpr_quad_piece hpr_quad_half(const double opposite[2], int axis, int which)
{
    double low[2] = {0, 0}, width[2] = {1, 1}, measure;
    width[axis] = 0.5;
    low[axis] = which ? 0.5 : 0;
    return hpr_quad_box(opposite, low, width, &measure);
}

void hpr_quad_bring_inside(const double opposite[2], double *s, double *t)
{
    double middle[2], here[4] = {*s, *t}, there[4], keep = 1;
    hpr_shape_middle(HPR_SHAPE_QUADRILATERAL, opposite, middle);
    there[0] = middle[0];
    there[1] = middle[1];
    far_sides(opposite, *s, *t, here + 2);
    far_sides(opposite, middle[0], middle[1], there + 2);
    for (int i = 0; i < 4; i++) {
        if (here[i] < 0)
            keep = fmin(keep, there[i] / (there[i] - here[i]));
    }
    *s = middle[0] + keep * (*s - middle[0]);
    *t = middle[1] + keep * (*t - middle[1]);
}
