#include "patch/carve.h"

#include <assert.h>

/* A side of the hole: points with direction . (x - origin) > 0 are on the hole's side of it. */
typedef struct side {
    hpr_vec3 origin, direction;
} side;

void hpr_carving_release(hpr_carving *list)
{
    hpr_release(list->context, list->piece);
    list->piece = NULL;
    list->count = list->capacity = 0;
}

hpr_status hpr_carving_add(hpr_carving *list, const hpr_carved *piece)
{
    hpr_status status =
        hpr_grow(list->context, &list->piece, &list->capacity, list->count + 1, sizeof *list->piece);
    if (status == HPR_OK)
        list->piece[list->count++] = *piece;
    return status;
}

static double distance(const side *s, hpr_vec3 x)
{
    return hpr_dot(s->direction, hpr_sub(x, s->origin));
}

/* The part of a piece on one side (sign 1: the hole's, -1: the other); count 0 if it is nowhere farther than
 * slack. */
static hpr_carved clip(const hpr_carved *piece, const side *s, double sign, double slack)
{
    hpr_carved out = {0};
    double height[HPR_CARVED_ROOM], farthest = 0;
    for (int i = 0; i < piece->count; i++) {
        height[i] = sign * distance(s, piece->corner[i]);
        if (fabs(height[i]) <= slack)
            height[i] = 0;
        farthest = fmax(farthest, height[i]);
    }
    for (int i = 0; farthest > 0 && i < piece->count; i++) {
        int next = (i + 1) % piece->count;
        double here = height[i], there = height[next];
        assert(out.count + 2 <= HPR_CARVED_ROOM);
        if (here >= 0)
            out.corner[out.count++] = piece->corner[i];
        if ((here > 0 && there < 0) || (here < 0 && there > 0)) {
            hpr_vec3 step = hpr_sub(piece->corner[next], piece->corner[i]);
            out.corner[out.count++] = hpr_madd(piece->corner[i], here / (here - there), step);
        }
    }
    return out;
}

/* Adds a piece, halved first if it has got too many corners to be cut again. */
static hpr_status add_part(hpr_carving *list, const hpr_carved *piece)
{
    if (piece->count <= HPR_CARVED_CORNERS)
        return hpr_carving_add(list, piece);
    int half = piece->count / 2;
    hpr_carved part[2] = {{0}, {0}};
    for (int i = 0; i <= half; i++)
        part[0].corner[part[0].count++] = piece->corner[i];
    for (int i = half; i <= piece->count; i++)
        part[1].corner[part[1].count++] = piece->corner[i % piece->count];
    hpr_status status = hpr_carving_add(list, &part[0]);
    return status == HPR_OK ? hpr_carving_add(list, &part[1]) : status;
}

static bool reaches(const hpr_carved *piece, const side *sides, int side_count, double slack)
{
    hpr_carved rest = *piece;
    for (int k = 0; k < side_count; k++)
        rest = clip(&rest, &sides[k], 1, slack);
    return rest.count > 0;
}

static hpr_status cut_piece(hpr_carving *parts, const hpr_carved *piece, const side *sides, int side_count,
                            double slack)
{
    if (!reaches(piece, sides, side_count, slack))
        return hpr_carving_add(parts, piece);
    hpr_status status = HPR_OK;
    hpr_carved rest = *piece;
    for (int k = 0; status == HPR_OK && k < side_count; k++) {
        hpr_carved outside = clip(&rest, &sides[k], -1, slack);
        if (outside.count)
            status = add_part(parts, &outside);
        rest = clip(&rest, &sides[k], 1, slack);
    }
    return status;
}

/* The sides of the hole; those without length are left out. */
static int find_sides(hpr_vec3 normal, const hpr_vec3 *hole, int hole_count, double slack, side *sides)
{
    hpr_vec3 across = {0, 0, 0};
    for (int i = 1; i + 1 < hole_count; i++)
        across = hpr_add(across, hpr_cross(hpr_sub(hole[i], hole[0]), hpr_sub(hole[i + 1], hole[0])));
    double turn = hpr_dot(across, normal) < 0 ? -1 : 1;
    int count = 0;
    for (int i = 0; i < hole_count; i++) {
        hpr_vec3 edge = hpr_sub(hole[(i + 1) % hole_count], hole[i]);
        double length = hpr_length(edge);
        if (length > slack)
            sides[count++] = (side){hole[i], hpr_scale(hpr_cross(normal, edge), turn / length)};
    }
    return count;
}

hpr_status hpr_carve(hpr_carving *list, hpr_vec3 normal, const hpr_vec3 *hole, int hole_count, double slack)
{
    side sides[4];
    assert(hole_count >= 3 && hole_count <= 4);
    int side_count = find_sides(normal, hole, hole_count, slack, sides);
    if (side_count < 3)
        return HPR_OK; /* no area */
    hpr_carving parts = {.context = list->context};
    hpr_status status = HPR_OK;
    for (size_t i = 0; status == HPR_OK && i < list->count; i++)
        status = cut_piece(&parts, &list->piece[i], sides, side_count, slack);
    if (status == HPR_OK) {
        hpr_carving old = *list;
        *list = parts;
        parts = old;
    }
    hpr_carving_release(&parts);
    return status;
}
