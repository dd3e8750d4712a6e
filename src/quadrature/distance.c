#include "quadrature/pair.h"

static double clamp01(double x)
{
    return x < 0 ? 0 : x > 1 ? 1 : x;
}

/* Squared distance of the segments p + s d, q + t e, s and t in [0,1]. */
static double segment_distance2(hpr_vec3 p, hpr_vec3 d, hpr_vec3 q, hpr_vec3 e)
{
    hpr_vec3 r = hpr_sub(p, q);
    double a = hpr_dot(d, d), b = hpr_dot(d, e), c = hpr_dot(d, r), f = hpr_dot(e, e), g = hpr_dot(e, r);
    double determinant = a * f - b * b;
    double s = determinant > 0 ? clamp01((b * g - c * f) / determinant) : 0;
    double t = f > 0 ? clamp01((b * s + g) / f) : 0;
    s = a > 0 ? clamp01((b * t - c) / a) : 0;
    hpr_vec3 gap = hpr_sub(hpr_madd(r, s, d), hpr_scale(e, t));
    return hpr_dot(gap, gap);
}

/* Squared distance of a point to the plane of a polygon if its foot is inside, else infinity; a point or a
 * segment has no plane. */
static double face_distance2(hpr_vec3 p, const hpr_vec3 *polygon, int count)
{
    if (count < 3)
        return INFINITY;
    hpr_vec3 normal = hpr_cross(hpr_sub(polygon[1], polygon[0]), hpr_sub(polygon[count - 1], polygon[0]));
    for (int i = 0; i < count; i++) {
        hpr_vec3 edge = hpr_sub(polygon[(i + 1) % count], polygon[i]);
        if (hpr_dot(hpr_cross(edge, hpr_sub(p, polygon[i])), normal) < 0)
            return INFINITY;
    }
    double height = hpr_dot(hpr_sub(p, polygon[0]), normal);
    return height * height / hpr_dot(normal, normal);
}

double hpr_outline_distance(const hpr_vec3 *a, int a_count, const hpr_vec3 *b, int b_count)
{
    double best = INFINITY;
    for (int i = 0; i < a_count; i++) {
        hpr_vec3 d = hpr_sub(a[(i + 1) % a_count], a[i]);
        for (int j = 0; j < b_count; j++)
            best = fmin(best, segment_distance2(a[i], d, b[j], hpr_sub(b[(j + 1) % b_count], b[j])));
    }
    return sqrt(best);
}

double hpr_polygon_distance(const hpr_vec3 *a, int a_count, const hpr_vec3 *b, int b_count)
{
    double best = hpr_outline_distance(a, a_count, b, b_count);
    best *= best;
    for (int i = 0; i < a_count; i++)
        best = fmin(best, face_distance2(a[i], b, b_count));
    for (int j = 0; j < b_count; j++)
        best = fmin(best, face_distance2(b[j], a, a_count));
    return sqrt(best);
}
