#include "math/hull.h"

#include "math/vec3.h"

#include <stdbool.h>

/* The plane through edge `i`. (a, h): the way of a corner of the other polygon inward from the edge, and its
 * height. */
static bool edge_plane(const hpr_hull_end *own, const hpr_hull_end *other, size_t i, double slack,
                       double plane[4])
{
    const double *p = own->corner[i], *q = own->corner[(i + 1) % own->count];
    double edge[3], inward[3], third[3], best_a = 1, best_h = 0;
    hpr_subtract3(q, p, edge);
    hpr_cross3(own->normal, edge, inward);
    double length = hpr_length3(inward);
    if (!(length > slack))
        return false;
    hpr_subtract3(own->corner[(i + 2) % own->count], p, third);
    if (hpr_dot3(inward, third) < 0) /* the corners go round the other way */
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
