#include "render/footprint.h"

#include "math/vec3.h"
#include "patch/paint.h"
#include "patch/shape.h"

#include <math.h>
#include <string.h>

enum { MOST_POINTS = 256, POINTS_PER_TEXEL = 4 };

/* Parameters of where a ray meets the plane of a patch; false if it does not. */
static bool meet(const hpr_sample_view *view, double x, double y, size_t patch, double at[2])
{
    const hpr_patches *patches = view->patches;
    const double *normal = patches->normal + 3 * patch;
    hpr_camera_ray ray;
    double offset[3], point[3];
    hpr_camera_ray_through(view->camera, view->aspect, x, y, &ray);
    hpr_subtract3(patches->origin + 3 * patch, ray.origin, offset);
    double distance = hpr_dot3(normal, offset) / hpr_dot3(normal, ray.direction);
    if (!(distance > 0 && isfinite(distance)))
        return false;
    for (int k = 0; k < 3; k++)
        point[k] = ray.origin[k] + distance * ray.direction[k];
    hpr_patch_parameters(patches, patch, point, &at[0], &at[1]);
    return true;
}

/* From one border of the sample to the other; where the plane ends between them, twice the half that is left.
 */
static void find_edge(const hpr_sample_view *view, double x, double y, double dx, double dy,
                      const hpr_footprint *f, double edge[2])
{
    double low[2] = {f->s, f->t}, high[2] = {f->s, f->t};
    bool before = meet(view, x - dx / 2, y - dy / 2, f->patch, low),
         after = meet(view, x + dx / 2, y + dy / 2, f->patch, high);
    double factor = before && after ? 1 : 2;
    for (int a = 0; a < 2; a++)
        edge[a] = factor * (high[a] - low[a]);
}

hpr_footprint hpr_footprint_of(const hpr_sample_view *view, double x, double y, size_t patch, double s,
                               double t)
{
    hpr_footprint f = {.patch = patch, .s = s, .t = t};
    find_edge(view, x, y, view->across, 0, &f, f.across);
    find_edge(view, x, y, 0, view->down, &f, f.down);
    return f;
}

/* Texels along an edge of the footprint. */
static double texels(const hpr_texture *texture, const double map[6], const double edge[2])
{
    double u = edge[0] * map[2] + edge[1] * map[4], v = edge[0] * map[3] + edge[1] * map[5];
    return hypot(u * texture->width, v * texture->height);
}

/* Points that show a texture; 1 if the footprint is no longer than a texel. */
static int count_points(const hpr_texture *texture, const double map[6], const hpr_footprint *f)
{
    if (!texture)
        return 1;
    double a = texels(texture, map, f->across), b = texels(texture, map, f->down);
    if (!(a > 1 || b > 1))
        return 1;
    double count = POINTS_PER_TEXEL * fmax(a, 1) * fmax(b, 1);
    return count < MOST_POINTS ? (int)ceil(count) : MOST_POINTS;
}

void hpr_footprint_shade(const hpr_patches *patches, const hpr_footprint *f, double *reflectance,
                         double *exitance, double *room)
{
    static const double step[2] = {0.75487766624669276, 0.56984029099805327};
    const hpr_texture *texture = hpr_patch_texture(patches, f->patch),
                      *glow = hpr_patch_glow(patches, f->patch);
    size_t n = patches->channel_count;
    int points = 1, inside = 0;
    if (texture)
        points = count_points(texture, patches->paint->map + 6 * f->patch, f);
    if (glow) {
        int more = count_points(glow, patches->paint->glow_map + 6 * f->patch, f);
        points = more > points ? more : points;
    }
    memset(reflectance, 0, n * sizeof *reflectance);
    memset(exitance, 0, n * sizeof *exitance);
    for (int i = 0; i < points; i++) { /* the first is the middle */
        double u = i * step[0], v = i * step[1];
        u -= floor(u + 0.5);
        v -= floor(v + 0.5);
        double s = f->s + u * f->across[0] + v * f->down[0], t = f->t + u * f->across[1] + v * f->down[1];
        if (i > 0 &&
            !hpr_shape_holds((hpr_shape)patches->shape[f->patch], patches->opposite + 2 * f->patch, s, t))
            continue;
        inside++;
        hpr_patch_reflectance(patches, f->patch, s, t, room);
        for (size_t c = 0; c < n; c++) {
            reflectance[c] += (room[c] - reflectance[c]) / inside;
            exitance[c] += (hpr_patch_exitance(patches, f->patch, s, t, c) - exitance[c]) / inside;
        }
    }
}
