#include "quadrature/cuts.h"

#include <string.h>

double hpr_polygon_area(const hpr_polygon *p)
{
    double area = 0;
    for (int i = 1; i + 1 < p->count; i++)
        area += (p->corner[i][0] - p->corner[0][0]) * (p->corner[i + 1][1] - p->corner[0][1]) -
                (p->corner[i][1] - p->corner[0][1]) * (p->corner[i + 1][0] - p->corner[0][0]);
    return fabs(area) / 2;
}

hpr_polygon hpr_polygon_half(const hpr_polygon *polygon, const hpr_affine *f, double sign)
{
    hpr_polygon half = {0};
    for (int i = 0; i < polygon->count; i++) {
        const double *a = polygon->corner[i], *b = polygon->corner[(i + 1) % polygon->count];
        double fa = sign * hpr_affine_at(f, a[0], a[1]), fb = sign * hpr_affine_at(f, b[0], b[1]);
        if (fa >= 0 && half.count < HPR_POLYGON_MAX)
            memcpy(half.corner[half.count++], a, sizeof half.corner[0]);
        if (fa * fb < 0 && half.count < HPR_POLYGON_MAX) {
            double part = fa / (fa - fb);
            half.corner[half.count][0] = a[0] + part * (b[0] - a[0]);
            half.corner[half.count][1] = a[1] + part * (b[1] - a[1]);
            half.count++;
        }
    }
    return half;
}

void hpr_cuts_init(hpr_cuts *pieces, const hpr_polygon *polygon)
{
    static const double sliver = 1e-14;
    pieces->count = 1;
    pieces->least = sliver * hpr_polygon_area(polygon);
    pieces->piece[0] = *polygon;
}

void hpr_cuts_along(hpr_cuts *p, const hpr_affine *f)
{
    if (!(fabs(f->along1) + fabs(f->along2) > 0))
        return;
    for (int k = p->count - 1; k >= 0 && p->count < HPR_MAX_CUTS; k--) {
        hpr_polygon left = hpr_polygon_half(&p->piece[k], f, 1),
                    right = hpr_polygon_half(&p->piece[k], f, -1);
        if (left.count < 3 || right.count < 3 || p->piece[k].count >= HPR_POLYGON_MAX - 1 ||
            hpr_polygon_area(&left) <= p->least || hpr_polygon_area(&right) <= p->least)
            continue;
        p->piece[k] = left;
        p->piece[p->count++] = right;
    }
}

int hpr_cuts_fan(const hpr_polygon *piece, hpr_cell *cells)
{
    double middle[2] = {0, 0};
    for (int i = 0; i < piece->count; i++) {
        middle[0] += piece->corner[i][0] / piece->count;
        middle[1] += piece->corner[i][1] / piece->count;
    }
    for (int i = 0; i < piece->count; i++)
        cells[i] = hpr_cell_triangle(piece->corner[i], piece->corner[(i + 1) % piece->count], middle);
    return piece->count;
}

int hpr_cuts_cells(hpr_shape shape, const hpr_polygon *piece, hpr_cell *cells)
{
    static const double rounding = 1e-14;
    if (shape == HPR_SHAPE_PARALLELOGRAM && fabs(hpr_polygon_area(piece) - 1) < rounding) {
        cells[0] = hpr_cell_whole(HPR_SHAPE_PARALLELOGRAM);
        return 1;
    }
    return hpr_cuts_fan(piece, cells);
}
