#include "math/hull.h"

#include "math/vec3.h"

#include <stdint.h>
#include <string.h>

/* The plane through edge `i`. (a, h): the way of a corner of the other polygon inward from the edge, and its
 * height. */
static bool edge_plane(const hpr_hull_end *own, const hpr_hull_end *other, size_t i, double slack,
                       double plane[4])
{
    const double *p = own->corner[i], *q = own->corner[(i + 1) % own->count];
    double edge[3], inward[3], depth = 0, best_a = 1, best_h = 0;
    hpr_subtract3(q, p, edge);
    hpr_cross3(own->normal, edge, inward);
    double length = hpr_length3(inward);
    if (!(length > slack))
        return false;
    for (size_t k = 0; k < own->count; k++) {
        double offset[3];
        hpr_subtract3(own->corner[k], p, offset);
        double a = hpr_dot3(inward, offset);
        depth = fabs(a) > fabs(depth) ? a : depth;
    }
    if (depth < 0) /* the corners go round the other way */
        length = -length;
    bool found = false;
    for (size_t j = 0; j < other->count; j++) {
        double offset[3];
        hpr_subtract3(other->corner[j], p, offset);
        double a = hpr_dot3(inward, offset) / length, h = hpr_max(hpr_dot3(own->normal, offset), 0);
        if (a * a + h * h <= slack * slack)
            continue; /* on the edge: every plane through it will do */
        double turn = best_a * h - a * best_h;
        if (!found || turn > 0 || (turn == 0 && a < best_a)) {
            best_a = a;
            best_h = h;
            found = true;
        }
    }
    if (!found)
        return false;
    double size = sqrt(best_a * best_a + best_h * best_h);
    for (int k = 0; k < 3; k++)
        plane[k] = (best_a * own->normal[k] - best_h * inward[k] / length) / size;
    plane[3] = hpr_dot3(plane, p);
    return true;
}

size_t hpr_hull_planes(const hpr_hull_end end[2], double slack, double (*plane)[4])
{
    size_t count = 0;
    for (int e = 0; e < 2; e++, count++) {
        for (int k = 0; k < 3; k++)
            plane[count][k] = -end[e].normal[k];
        plane[count][3] = hpr_dot3(plane[count], end[e].corner[0]);
    }
    for (int e = 0; e < 2; e++) {
        for (size_t i = 0; i < end[e].count; i++)
            count += edge_plane(&end[e], &end[1 - e], i, slack, plane[count]);
    }
    return count;
}

/* The part of a polygon where plane . x < limit (Sutherland & Hodgman 1974); returns its corners. */
static size_t cut(const double (*in)[3], size_t count, const double plane[4], double limit, double (*out)[3])
{
    size_t kept = 0;
    double first = limit - hpr_dot3(plane, in[0]), here = first;
    for (size_t i = 0; i < count; i++) {
        const double *q = in[i + 1 < count ? i + 1 : 0];
        double next = i + 1 < count ? limit - hpr_dot3(plane, q) : first, step[3];
        if (here > 0)
            memcpy(out[kept++], in[i], sizeof *out);
        if ((here > 0) != (next > 0)) {
            hpr_subtract3(q, in[i], step);
            hpr_add_scaled3(in[i], here / (here - next), step, out[kept++]);
        }
        here = next;
    }
    return kept;
}

bool hpr_hull_meets(const double (*plane)[4], size_t plane_count, const double (*corner)[3], size_t count,
                    double slack)
{
    double part[2][HPR_HULL_POLYGON + HPR_HULL_PLANES][3];
    uint32_t all = ((uint32_t)1 << count) - 1, inside = all; /* corners inside all planes so far */
    bool cuts[HPR_HULL_PLANES];
    for (size_t k = 0; k < plane_count; k++) {
        uint32_t here = 0;
        for (size_t c = 0; c < count; c++)
            here |= (uint32_t)(hpr_dot3(plane[k], corner[c]) < plane[k][3] - slack) << c;
        if (!here)
            return false;
        cuts[k] = here != all;
        inside &= here;
    }
    if (inside)
        return true;
    int turn = 0;
    for (size_t k = 0; k < plane_count; k++) {
        if (!cuts[k])
            continue;
        count = cut(corner, count, plane[k], plane[k][3] - slack, part[turn]);
        if (!count)
            return false;
        corner = (const double(*)[3])part[turn];
        turn = 1 - turn;
    }
    return true;
}
