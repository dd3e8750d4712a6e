#include "quadrature/strips.h"

bool hpr_strips_apply(const hpr_pair *pair)
{
    static const double small_angle = 1e-3;
    return hpr_dot(pair->recv.normal, pair->send.normal) < 0 &&
           hpr_length(hpr_cross(pair->recv.normal, pair->send.normal)) < small_angle;
}

void hpr_strips_init(hpr_strips *strips, const hpr_element_frame *outer, const hpr_affine *height,
                     const hpr_vec3 *outline, int count)
{
    hpr_vec3 middle = {0, 0, 0};
    strips->count = count;
    strips->height = *height;
    for (int i = 0; i < count; i++)
        middle = hpr_madd(middle, 1.0 / count, outline[i]);
    for (int i = 0; i < count; i++) {
        hpr_vec3 from = outline[i], edge = hpr_sub(outline[(i + 1) % count], from);
        hpr_vec3 normal = hpr_cross(edge, outer->normal);
        double sign = hpr_dot(normal, hpr_sub(middle, from)) < 0 ? -1 : 1, length = hpr_length(normal);
        normal = hpr_scale(normal, length > 0 ? sign / length : 0);
        strips->inside[i] = (hpr_affine){hpr_dot(normal, hpr_sub(outer->origin, from)),
                                         hpr_dot(normal, outer->edge1), hpr_dot(normal, outer->edge2)};
    }
}

/* How far a half plane that is `height` away can be from filling the view, or from filling nothing of it, at
 * `distance` from the projection of its edge; on average over a strip from there on of this width. */
static double half_plane(double distance, double height, double width)
{
    double r = hypot(distance, height), end = r > 0 ? height * height / (2 * r * (r + distance)) : 0;
    return fmin(end, height / width);
}

double hpr_strips_left(const hpr_strips *strips, const double corner[4][2])
{
    static const double crossing = 1e-9;
    double height = 0, inside = 0, outside = 1;
    for (int k = 0; k < 4; k++)
        height = fmax(height, hpr_affine_at(&strips->height, corner[k][0], corner[k][1]));
    for (int i = 0; i < strips->count; i++) {
        double low = INFINITY, high = -INFINITY;
        for (int k = 0; k < 4; k++) {
            double at = hpr_affine_at(&strips->inside[i], corner[k][0], corner[k][1]);
            low = fmin(low, at);
            high = fmax(high, at);
        }
        if (fmin(-low, high) > crossing * (high - low))
            return 1;
        if (low + high > 0)
            inside += half_plane(fmax(low, 0), height, high - low);
        else
            outside = fmin(outside, half_plane(fmax(-high, 0), height, high - low));
    }
    return outside < 1 ? outside : inside;
}
