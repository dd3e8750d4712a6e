#include "direct/visible.h"

#include "direct/lambert.h"

#include <string.h>

/* Corners whose height over a plane is known. */
static void cut_at(const hpr_convex *in, const double *height, double sign, hpr_convex *out)
{
    bool strictly = false;
    out->count = 0;
    for (int i = 0; i < in->count; i++) {
        int j = (i + 1) % in->count;
        hpr_vec3 p = in->corner[i], q = in->corner[j];
        double hp = sign * height[i], hq = sign * height[j];
        strictly |= hp > 0;
        if (hp >= 0 && out->count < HPR_VISIBLE_CORNERS)
            out->corner[out->count++] = p;
        if (hp * hq < 0 && out->count < HPR_VISIBLE_CORNERS)
            out->corner[out->count++] = hpr_madd(p, hp / (hp - hq), hpr_sub(q, p));
    }
    if (out->count < 3 || !strictly)
        out->count = 0;
}

/* The part of `in` where sign * (plane . x) >= offset. */
static void cut(const hpr_convex *in, hpr_vec3 plane, double sign, double offset, hpr_convex *out)
{
    double height[HPR_VISIBLE_CORNERS];
    for (int i = 0; i < in->count; i++)
        height[i] = hpr_dot(plane, in->corner[i]) - sign * offset;
    cut_at(in, height, sign, out);
}

/* Without the unused corners. */
static void copy(hpr_convex *to, const hpr_convex *from)
{
    to->count = from->count;
    memcpy(to->corner, from->corner, (size_t)from->count * sizeof *to->corner);
}

/* The part of it between the point's parallel plane and the sender's: 0 < normal . x / height < 1. */
static void cut_between(hpr_vec3 normal, double height, hpr_convex *blocker)
{
    static const double in_plane =
        1e-13; /* of the distance: a blocker lying on the sender's plane hides nothing */
    double sign = height > 0 ? 1 : -1, high = fabs(height) * (1 - in_plane), low = fabs(height) * in_plane;
    double least = INFINITY, most = -INFINITY;
    for (int i = 0; i < blocker->count; i++) {
        double h = sign * hpr_dot(normal, blocker->corner[i]);
        least = h < least ? h : least;
        most = h > most ? h : most;
    }
    if (most <= low || least >= high)
        blocker->count = 0;
    hpr_convex below;
    if (most > high && blocker->count) {
        cut(blocker, normal, -sign, -high, &below);
        copy(blocker, &below);
    }
    if (least < low && blocker->count) {
        cut(blocker, normal, sign, low, &below);
        copy(blocker, &below);
    }
}

/* How often a line with these heights meets the outline of a polygon. */
static int meetings(const double *height, int count)
{
    int met = 0;
    for (int i = 0; i < count; i++)
        met += height[i] == 0 || height[i] * height[i + 1 < count ? i + 1 : 0] < 0;
    return met;
}

/* A line meets a convex outline twice at most. Heights that tell of more are noise, of a plane that goes
 * through two corners which are all but one: such a plane cuts nothing. */
static void side_heights(const hpr_convex *piece, const hpr_side *s, double *height)
{
    int most = 0;
    bool on_line = false;
    for (int i = 0; i < piece->count; i++) {
        height[i] = hpr_dot(s->normal, piece->corner[i]);
        most = fabs(height[i]) > fabs(height[most]) ? i : most;
        hpr_vec3 x = piece->corner[i];
        if (fabs(height[i]) <= s->rounding * (fabs(x.x) + fabs(x.y) + fabs(x.z))) {
            height[i] = 0;
            on_line = true;
        }
    }
    if (on_line && meetings(height, piece->count) > 2) {
        for (int i = 0; i < piece->count; i++)
            height[i] = height[most];
    }
}

int hpr_visible_pyramid(const hpr_convex *blocker, hpr_side *sides)
{
    static const double edge_on = 1e-14, rounding = 2e-15;
    hpr_vec3 middle = {0, 0, 0};
    double length[HPR_VISIBLE_CORNERS];
    for (int i = 0; i < blocker->count; i++) {
        middle = hpr_add(middle, blocker->corner[i]);
        length[i] = hpr_length(blocker->corner[i]);
    }
    const double least = edge_on * edge_on * hpr_dot(middle, middle);
    int count = 0;
    for (int i = 0; i < blocker->count; i++) {
        int j = i + 1 < blocker->count ? i + 1 : 0;
        hpr_vec3 a = blocker->corner[i], b = blocker->corner[j], along = hpr_sub(b, a);
        hpr_vec3 normal = hpr_cross(a, b);
        double inward = hpr_dot(normal, middle);
        if (hpr_dot(along, along) == 0)
            continue;
        if (!(inward * inward > least * hpr_dot(normal, normal)))
            return 0;
        sides[count++] = (hpr_side){hpr_scale(normal, inward > 0 ? 1 : -1), rounding * length[i] * length[j]};
    }
    return count;
}

static bool inside(hpr_vec3 corner, const hpr_side *s)
{
    return hpr_dot(s->normal, corner) > s->rounding * (fabs(corner.x) + fabs(corner.y) + fabs(corner.z));
}

/* No corner is inside some plane: the pyramid leaves the piece alone. */
static bool apart(const hpr_convex *piece, const hpr_side *sides, int side_count)
{
    for (int k = 0; k < side_count; k++) {
        int i = 0;
        while (i < piece->count && !inside(piece->corner[i], &sides[k]))
            i++;
        if (i == piece->count)
            return true;
    }
    return side_count == 0;
}

static void append(hpr_convex *to, hpr_vec3 corner)
{
    if (to->count < HPR_VISIBLE_CORNERS)
        to->corner[to->count++] = corner;
}

/* The parts of `in` where the height is >= 0 and <= 0; none if it is nowhere more, or less. */
static void split(const hpr_convex *in, const double *height, hpr_convex *above, hpr_convex *below)
{
    bool up = false, down = false;
    above->count = below->count = 0;
    for (int i = 0; i < in->count; i++) {
        int j = i + 1 < in->count ? i + 1 : 0;
        double hp = height[i], hq = height[j];
        up |= hp > 0;
        down |= hp < 0;
        if (hp >= 0)
            append(above, in->corner[i]);
        if (hp <= 0)
            append(below, in->corner[i]);
        if (hp * hq < 0) {
            hpr_vec3 at = hpr_madd(in->corner[i], hp / (hp - hq), hpr_sub(in->corner[j], in->corner[i]));
            append(above, at);
            append(below, at);
        }
    }
    if (!up || above->count < 3)
        above->count = 0;
    if (!down || below->count < 3)
        below->count = 0;
}

/* Of every piece, what is outside side k and inside the sides before it stays. */
bool hpr_visible_subtract(hpr_visible *visible, const hpr_side *sides, int side_count)
{
    int before = visible->count;
    bool complete = true;
    for (int i = before - 1; i >= 0; i--) {
        if (apart(&visible->piece[i], sides, side_count))
            continue;
        hpr_convex inside[2], outside[HPR_VISIBLE_CORNERS];
        const hpr_convex *rest = &visible->piece[i];
        int outside_count = 0;
        for (int k = 0; k < side_count && rest->count; k++) {
            double height[HPR_VISIBLE_CORNERS];
            side_heights(rest, &sides[k], height);
            split(rest, height, &inside[k % 2], &outside[outside_count]);
            outside_count += outside[outside_count].count > 0;
            rest = &inside[k % 2];
        }
        if (rest->count == 0)
            continue; /* untouched */
        if (visible->count - 1 + outside_count > HPR_VISIBLE_PIECES) {
            complete = false;
            continue;
        }
        visible->whole = false;
        if (visible->hidden && visible->hidden->count < HPR_VISIBLE_PIECES)
            copy(&visible->hidden->piece[visible->hidden->count++], rest);
        else
            complete &= !visible->hidden;
        if (i != --visible->count)
            copy(&visible->piece[i], &visible->piece[visible->count]);
        for (int k = 0; k < outside_count; k++)
            copy(&visible->piece[visible->count++], &outside[k]);
    }
    return complete;
}

bool hpr_visible_part(hpr_vec3 point, const hpr_convex *sender, hpr_vec3 normal, const hpr_convex *outline,
                      const uint32_t *blocker, int blocker_count, hpr_visible *visible)
{
    visible->count = 1;
    visible->whole = true;
    if (visible->hidden)
        visible->hidden->count = 0;
    visible->piece[0].count = sender->count;
    for (int i = 0; i < sender->count; i++)
        visible->piece[0].corner[i] = hpr_sub(sender->corner[i], point);
    double height = hpr_dot(normal, visible->piece[0].corner[0]); /* of the sender's plane over the point */
    bool complete = true;
    hpr_side view[HPR_VISIBLE_CORNERS], sides[HPR_VISIBLE_CORNERS];
    int view_count = blocker_count > 0 ? hpr_visible_pyramid(&visible->piece[0], view) : 0;
    for (int b = 0; b < blocker_count && visible->count > 0; b++) {
        const hpr_convex *other = &outline[blocker ? blocker[b] : (uint32_t)b];
        hpr_convex relative;
        relative.count = other->count;
        for (int i = 0; i < relative.count; i++)
            relative.corner[i] = hpr_sub(other->corner[i], point);
        if (view_count > 0 && apart(&relative, view, view_count))
            continue;
        cut_between(normal, height, &relative);
        if (relative.count)
            complete &= hpr_visible_subtract(visible, sides, hpr_visible_pyramid(&relative, sides));
    }
    return complete;
}

double hpr_visible_fraction(hpr_vec3 receiver_normal, const hpr_visible *visible)
{
    static const double origin[3] = {0, 0, 0};
    double normal[3], corner[HPR_VISIBLE_CORNERS][3], sum = 0;

    hpr_vec3_store(normal, receiver_normal);
    for (int i = 0; i < visible->count; i++) {
        const hpr_convex *piece = &visible->piece[i];
        for (int k = 0; k < piece->count; k++)
            hpr_vec3_store(corner[k], piece->corner[k]);
        sum += hpr_lambert_fraction(origin, normal, (const double(*)[3])corner, (size_t)piece->count);
    }
    return sum;
}
