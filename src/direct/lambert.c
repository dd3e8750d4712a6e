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
