#include "direct/lambert.h"

enum { MAX_CORNERS = 24 };

/* Sutherland & Hodgman 1974 against height over the horizon >= 0; corners relative to the point. */
static size_t cut_at_horizon(hpr_vec3 normal, const hpr_vec3 *in, size_t count, hpr_vec3 *out)
{
    size_t kept = 0;
    for (size_t i = 0; i < count; i++) {
        hpr_vec3 p = in[i], q = in[(i + 1) % count];
        double hp = hpr_dot(normal, p), hq = hpr_dot(normal, q);
        if (hp >= 0)
            out[kept++] = p;
        if (hp * hq < 0)
            out[kept++] = hpr_madd(p, hp / (hp - hq), hpr_sub(q, p));
    }
    return kept;
}

hpr_lambert hpr_lambert_above(hpr_vec3 normal, const hpr_vec3 *corner, size_t count)
{
    double sum = 0, size = 0, error = 0;
    for (size_t i = 0; i < count; i++) {
        hpr_vec3 a = corner[i], b = corner[(i + 1) % count];
        hpr_vec3 cross = hpr_cross(a, b);
        double sine = hpr_length(cross), cosine = hpr_dot(a, b);
        if (!(sine > 0))
            continue;
        double angle = atan2(sine, cosine), term = angle * hpr_dot(normal, cross) / sine;
        sum += term;
        size += fabs(term);
        /* the cross product errs by |a||b| roundoffs, so the unit vector by their ratio to the sine, and the
         * term by that times the angle; beside an edge it is more, but there the point itself counts */
        error += 1;
    }
    sum = fabs(sum);
    return (hpr_lambert){sum / (2 * 3.14159265358979323846), size / sum, error / sum};
}

/* One edge from u to v, seen from the foot: twice the area of the triangle with the sign of its side, and the
 * edge's term over the cosine of the planes, less the angle that the foot sees, with that sign. */
static double beside_edge(hpr_vec3 plane, double height, hpr_vec3 u, hpr_vec3 v, double *area, double *weight)
{
    hpr_vec3 edge = hpr_sub(v, u);
    double s = hpr_dot(plane, hpr_cross(u, v)), side = s < 0 ? -1 : 1, z2 = height * height;
    double raised = z2 * hpr_dot(edge, edge), flat = fabs(s), sine = sqrt(s * s + raised);
    double cosine = hpr_dot(u, v), angle = atan2(sine, cosine + z2), lift = raised / (sine + flat);
    double more = atan2(lift * cosine - flat * z2, (cosine + z2) * cosine + sine * flat);
    *area = s;
    *weight = angle / sine;
    return side * (more - *weight * lift);
}

hpr_lambert hpr_lambert_beside(hpr_vec3 normal, hpr_vec3 plane, double height, const hpr_vec3 *corner,
                               size_t count)
{
    static const double turn = 2 * 3.14159265358979323846;
    double facing = hpr_dot(normal, plane), sum = 0, size = 0;
    size_t left = 0, edges = 0;
    for (size_t i = 0; i < count; i++) {
        hpr_vec3 u = hpr_madd(corner[i], height, plane), v = hpr_madd(corner[(i + 1) % count], height, plane);
        hpr_vec3 edge = hpr_sub(v, u);
        double area, weight;
        if (!(hpr_dot(edge, edge) > 0))
            continue;
        double term = facing * beside_edge(plane, height, u, v, &area, &weight);
        double tilt = -height * weight * hpr_dot(normal, hpr_cross(plane, edge));
        sum += term + tilt;
        size += fabs(term) + fabs(tilt);
        edges++;
        left += area >= 0;
    }
    if (left == 0 || left == edges) {
        sum += left ? facing * turn : -facing * turn;
        size += fabs(facing) * turn;
    }
    return (hpr_lambert){fabs(sum) / turn, size / fabs(sum), 4 * size / fabs(sum)};
}

double hpr_lambert_fraction(const double point[3], const double normal[3], const double (*corner)[3],
                            size_t count)
{
    hpr_vec3 x = hpr_vec3_load(point), n = hpr_vec3_load(normal);
    hpr_vec3 whole[MAX_CORNERS], above[2 * MAX_CORNERS];
    for (size_t i = 0; i < count && i < MAX_CORNERS; i++)
        whole[i] = hpr_sub(hpr_vec3_load(corner[i]), x);
    size_t kept = cut_at_horizon(n, whole, count, above);
    return kept ? hpr_lambert_above(n, above, kept).fraction : 0;
}
