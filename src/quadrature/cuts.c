#include "quadrature/cuts.h"

#include <math.h>
#include <string.h>

double hpr_polygon_area(const hpr_polygon *p)
{
    double area = 0;
    for (int i = 1; i + 1 < p->count; i++)
        area += (p->corner[i][0] - p->corner[0][0]) * (p->corner[i + 1][1] - p->corner[0][1]) -
                (p->corner[i][1] - p->corner[0][1]) * (p->corner[i + 1][0] - p->corner[0][0]);
    return fabs(area) / 2;
}

/* A corner on the line but for rounding counts as on it: else the cut would leave two corners in one place,
 * and the edge between them any direction. */
static double side_of(const hpr_affine *f, const double corner[2], double most)
{
    static const double rounding = 1e-12;
    double value = hpr_affine_at(f, corner[0], corner[1]);
    return fabs(value) > rounding * most ? value : 0;
}

hpr_polygon hpr_polygon_half(const hpr_polygon *polygon, const hpr_affine *f, double sign)
{
    hpr_polygon half = {0};
    double most = 0;
    for (int i = 0; i < polygon->count; i++)
        most = fmax(most, fabs(hpr_affine_at(f, polygon->corner[i][0], polygon->corner[i][1])));
    for (int i = 0; i < polygon->count; i++) {
        const double *a = polygon->corner[i], *b = polygon->corner[(i + 1) % polygon->count];
        double fa = sign * side_of(f, a, most), fb = sign * side_of(f, b, most);
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

bool hpr_polygon_holds(const hpr_polygon *polygon, double s, double t)
{
    static const double rounding = 1e-12;
    int left = 0, right = 0;
    for (int i = 0; i < polygon->count; i++) {
        const double *a = polygon->corner[i], *b = polygon->corner[(i + 1) % polygon->count];
        double turn = (b[0] - a[0]) * (t - a[1]) - (b[1] - a[1]) * (s - a[0]);
        left += turn > rounding;
        right += turn < -rounding;
    }
    return !left || !right;
}

void hpr_cuts_init(hpr_cuts *pieces, const hpr_polygon *polygon)
{
    static const double sliver = 1e-14;
    pieces->count = 1;
    pieces->least = sliver * hpr_polygon_area(polygon);
    pieces->piece[0] = *polygon;
}

/* Cuts one piece, if both parts are worth it. */
static void cut_piece(hpr_cuts *p, int k, const hpr_affine *f)
{
    hpr_polygon left = hpr_polygon_half(&p->piece[k], f, 1), right = hpr_polygon_half(&p->piece[k], f, -1);
    if (left.count < 3 || right.count < 3 || p->piece[k].count >= HPR_POLYGON_MAX - 1 ||
        hpr_polygon_area(&left) <= p->least || hpr_polygon_area(&right) <= p->least)
        return;
    p->piece[k] = left;
    p->piece[p->count++] = right;
}

void hpr_cuts_along(hpr_cuts *p, const hpr_affine *f)
{
    if (!(fabs(f->along1) + fabs(f->along2) > 0))
        return;
    for (int k = p->count - 1; k >= 0 && p->count < HPR_MAX_CUTS; k--)
        cut_piece(p, k, f);
}

/* The part of a segment, from 0 to 1, that lies in a convex polygon; empty if low >= high. */
static void clip_segment(const hpr_polygon *polygon, const double from[2], const double to[2], double *low,
                         double *high)
{
    double turn = 0;
    for (int i = 1; i + 1 < polygon->count; i++)
        turn += (polygon->corner[i][0] - polygon->corner[0][0]) *
                    (polygon->corner[i + 1][1] - polygon->corner[0][1]) -
                (polygon->corner[i][1] - polygon->corner[0][1]) *
                    (polygon->corner[i + 1][0] - polygon->corner[0][0]);
    *low = 0;
    *high = 1;
    for (int i = 0; i < polygon->count; i++) {
        const double *a = polygon->corner[i], *b = polygon->corner[(i + 1) % polygon->count];
        double n[2] = {a[1] - b[1], b[0] - a[0]}, sign = turn < 0 ? -1 : 1; /* inward */
        double at = sign * (n[0] * (from[0] - a[0]) + n[1] * (from[1] - a[1]));
        double along = sign * (n[0] * (to[0] - from[0]) + n[1] * (to[1] - from[1]));
        if (along > 0)
            *low = fmax(*low, -at / along);
        else if (along < 0)
            *high = fmin(*high, -at / along);
        else if (at <= 0)
            *high = *low;
    }
}

void hpr_cuts_segment(hpr_cuts *p, const double from[2], const double to[2], double slack)
{
    double d[2] = {to[0] - from[0], to[1] - from[1]}, length = hypot(d[0], d[1]), low, high;
    const hpr_affine line = {d[1] * from[0] - d[0] * from[1], -d[1], d[0]};
    for (int k = p->count - 1; k >= 0 && p->count < HPR_MAX_CUTS && length > 0; k--) {
        clip_segment(&p->piece[k], from, to, &low, &high);
        if ((high - low) * length > slack)
            cut_piece(p, k, &line);
    }
}

static bool same_point(const double a[2], const double b[2], double slack)
{
    return fabs(a[0] - b[0]) <= slack && fabs(a[1] - b[1]) <= slack;
}

/* Height of b over the line from a to c, times its length. */
static double turn_at(const double a[2], const double b[2], const double c[2])
{
    return (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0]);
}

/* The union of two polygons along edge i of a and edge j of b, without corners that have become straight;
 * false if it is not convex. */
static bool join(const hpr_polygon *a, int i, const hpr_polygon *b, int j, double slack, hpr_polygon *joined)
{
    double corner[2 * HPR_POLYGON_MAX][2], area = 0;
    int count = 0;
    for (int k = 1; k <= a->count; k++) /* from the end of edge i around to its beginning */
        memcpy(corner[count++], a->corner[(i + k) % a->count], sizeof corner[0]);
    for (int k = 2; k < b->count; k++)
        memcpy(corner[count++], b->corner[(j + k) % b->count], sizeof corner[0]);
    for (int k = 1; k + 1 < count; k++)
        area += -turn_at(corner[0], corner[k], corner[k + 1]);
    double sign = area < 0 ? -1 : 1;
    joined->count = 0;
    for (int k = 0; k < count; k++) {
        const double *before = corner[(k + count - 1) % count], *after = corner[(k + 1) % count];
        double turn = -sign * turn_at(before, corner[k], after);
        double reach = slack * hypot(after[0] - before[0], after[1] - before[1]);
        if (turn < -reach || (turn > reach && joined->count == HPR_POLYGON_MAX))
            return false;
        if (turn > reach)
            memcpy(joined->corner[joined->count++], corner[k], sizeof corner[0]);
    }
    return joined->count >= 3;
}

static bool join_pair(hpr_polygon *a, const hpr_polygon *b, double slack)
{
    hpr_polygon joined;
    for (int i = 0; i < a->count; i++) {
        for (int j = 0; j < b->count; j++) {
            if (same_point(a->corner[i], b->corner[(j + 1) % b->count], slack) &&
                same_point(a->corner[(i + 1) % a->count], b->corner[j], slack) &&
                join(a, i, b, j, slack, &joined)) {
                *a = joined;
                return true;
            }
        }
    }
    return false;
}

int hpr_cuts_merge(hpr_polygon *piece, int count, double slack)
{
    for (int i = 0; i < count; i++) {
        for (int j = i + 1; j < count; j++) {
            if (!join_pair(&piece[i], &piece[j], slack))
                continue;
            piece[j] = piece[--count];
            i = -1; /* what has grown may fit to any other */
            break;
        }
    }
    return count;
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

/* Corners in order around: one cell if opposite sides are equal. */
static bool parallelogram_cell(const hpr_polygon *piece, hpr_cell *cell)
{
    static const double rounding = 1e-12;
    const double(*p)[2] = piece->corner;
    if (piece->count != 4 || fabs(p[0][0] + p[2][0] - p[1][0] - p[3][0]) > rounding ||
        fabs(p[0][1] + p[2][1] - p[1][1] - p[3][1]) > rounding)
        return false;
    *cell = (hpr_cell){.shape = HPR_SHAPE_PARALLELOGRAM};
    for (int k = 0; k < 2; k++) {
        cell->origin[k] = p[0][k];
        cell->edge1[k] = p[1][k] - p[0][k];
        cell->edge2[k] = p[3][k] - p[0][k];
    }
    return true;
}

int hpr_cuts_tiles(const hpr_polygon *piece, hpr_cell *cells)
{
    return parallelogram_cell(piece, cells) ? 1 : hpr_cuts_fan(piece, cells);
}

int hpr_cuts_cells(hpr_shape shape, const hpr_polygon *piece, hpr_cell *cells)
{
    static const double rounding = 1e-14;
    if (shape == HPR_SHAPE_PARALLELOGRAM && fabs(hpr_polygon_area(piece) - 1) < rounding) {
        cells[0] = hpr_cell_whole(&(hpr_element_frame){.shape = HPR_SHAPE_PARALLELOGRAM});
        return 1;
    }
    return hpr_cuts_fan(piece, cells);
}
