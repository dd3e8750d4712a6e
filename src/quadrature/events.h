/* Where, on one polygon, the view of another past blockers changes its kind. */
#ifndef HPR_QUADRATURE_EVENTS_H
#define HPR_QUADRATURE_EVENTS_H

#include "quadrature/pair.h"

enum { HPR_EVENTS_MAX = 256 };

typedef struct hpr_events {
    int count;
    bool complete; /* false: there are more */
    hpr_affine line[HPR_EVENTS_MAX];
} hpr_events;

/*
 * Lines f = 0 in the parameters of the outer element between which the part of the inner polygon that a point
 * of the outer one sees, if its blockers were one at a time, changes smoothly (EV events, Gigus & Malik
 * 1990): a corner of the inner polygon seen on an edge of a blocker, a corner of a blocker seen on an edge of
 * the inner polygon, a blocker seen edge-on. Only what lies between the polygons and concerns points of the
 * outer one makes a line; an edge that two blockers share makes none unless some point of the outer polygon
 * sees it as an outline. Where the inner polygon is near, its own edges' projections are lines as well. Each
 * line is listed once.
 */
void hpr_events_find(const hpr_pair *pair, const hpr_element_frame *outer, const hpr_polygon *outer_polygon,
                     const hpr_convex *inner, hpr_vec3 inner_normal, hpr_events *events);

#endif
