/* The convex hull of two planar polygons. */
#ifndef HPR_MATH_HULL_H
#define HPR_MATH_HULL_H

#include <stdbool.h>
#include <stddef.h>

enum { HPR_HULL_CORNERS = 24, HPR_HULL_PLANES = 2 + 2 * HPR_HULL_CORNERS };

/* A convex planar polygon: corner [count][3] in order around it, either way; normal of length 1. */
typedef struct hpr_hull_end {
    const double (*corner)[3];
    size_t count;
    const double *normal;
} hpr_hull_end;

/*
 * Planes of the convex hull of two polygons, each in front of the other's plane: plane[i][0..2] . x <=
 * plane[i][3] for all of it, normals of length 1. The first two are those of the polygons; then comes one for
 * each edge, through that corner of the other polygon that is seen at the largest angle around the edge.
 * Points nearer than `slack` count as one. plane: room for 2 + both numbers of corners. Returns how many
 * there are. Thread-safe.
 */
size_t hpr_hull_planes(const hpr_hull_end end[2], double slack, double (*plane)[4]);

enum { HPR_HULL_POLYGON = 24 };

/* Has the convex polygon (corner [count][3], count <= HPR_HULL_POLYGON) anything inside all the planes, at
 * most HPR_HULL_PLANES, by more than the slack? Thread-safe. */
bool hpr_hull_meets(const double (*plane)[4], size_t plane_count, const double (*corner)[3], size_t count,
                    double slack);

#endif
