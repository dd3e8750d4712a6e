#include "quadrature/pair.h"

#include "basis/basis.h"
#include "direct/lambert.h"
#include "math/planar_basis.h"

#include <string.h>

hpr_element_frame hpr_leaf_frame(const hpr_patches *patches, const hpr_elements *elements, size_t leaf)
{
    return hpr_node_frame(patches, elements, elements->leaf[leaf]);
}

double hpr_frame_longest(const hpr_element_frame *frame)
{
    return fmax(hpr_length(frame->edge1), hpr_length(frame->edge2));
}

/* Divided first: the square of a small size could vanish. */
double hpr_frame_slenderness(const hpr_element_frame *frame)
{
    double longest = hpr_frame_longest(frame);
    return longest / (frame->area_m2 / longest);
}

/* The recurrence of a node that is a leaf and a quadrilateral; a tree has those of inner nodes. */
static const double *leaf_basis(const hpr_elements *elements, size_t node)
{
    uint32_t leaf = elements->leaf_of_node[node];
    return leaf == HPR_NONE || !elements->recurrence ? NULL
                                                     : elements->recurrence + elements->recurrence_at[leaf];
}

hpr_element_frame hpr_node_frame(const hpr_patches *patches, const hpr_elements *elements, size_t node)
{
    uint32_t patch = elements->patch[node];
    return (hpr_element_frame){.shape = (hpr_shape)patches->shape[patch],
                               .degree = elements->degree[node],
                               .origin = hpr_vec3_load(elements->origin + 3 * node),
                               .edge1 = hpr_vec3_load(elements->edge1 + 3 * node),
                               .edge2 = hpr_vec3_load(elements->edge2 + 3 * node),
                               .normal = hpr_vec3_load(patches->normal + 3 * (size_t)patch),
                               .area_m2 = elements->area_m2[node],
                               .opposite = {elements->opposite[2 * node], elements->opposite[2 * node + 1]},
                               .recurrence = leaf_basis(elements, node)};
}

double hpr_frame_measure(const hpr_element_frame *frame)
{
    return hpr_shape_measure(frame->shape, frame->opposite);
}

double hpr_frame_jacobian(const hpr_element_frame *frame)
{
    return frame->area_m2 / hpr_frame_measure(frame);
}

void hpr_frame_basis(const hpr_element_frame *frame, double s, double t, double *values)
{
    if (frame->shape != HPR_SHAPE_QUADRILATERAL)
        hpr_basis_eval(frame->shape, frame->degree, s, t, values);
    else if (frame->degree > 0)
        hpr_planar_eval(frame->recurrence, frame->degree, s, t, values);
    else
        values[0] = 1 / sqrt(hpr_frame_measure(frame));
}

void hpr_frame_basis_many(hpr_isa isa, const hpr_element_frame *frame, size_t count, const double *s,
                          const double *t, size_t stride, double *values, double *scratch)
{
    if (frame->shape != HPR_SHAPE_QUADRILATERAL) {
        hpr_basis_many(isa, frame->shape, frame->degree, count, s, t, stride, values, scratch);
    } else if (frame->degree > 0) {
        hpr_planar_many(isa, frame->recurrence, frame->degree, count, s, t, stride, values);
    } else {
        for (size_t k = 0; k < count; k++)
            values[k] = 1 / sqrt(hpr_frame_measure(frame));
    }
}

double hpr_frame_scale(const hpr_element_frame *frame)
{
    return frame->shape == HPR_SHAPE_QUADRILATERAL ? 1 / sqrt(hpr_frame_jacobian(frame))
                                                   : hpr_basis_scale(frame->shape, frame->area_m2);
}

void hpr_pair_init(hpr_pair *pair, const hpr_element_frame *recv, const hpr_element_frame *send)
{
    pair->blocker = NULL;
    pair->chosen = NULL;
    pair->blocker_count = 0;
    pair->recv_part = pair->send_part = NULL;
    pair->recv_part_count = pair->send_part_count = 0;
    pair->recv = *recv;
    pair->send = *send;
    hpr_vec3 offset = hpr_sub(send->origin, recv->origin);
    pair->recv.origin = (hpr_vec3){0, 0, 0};
    pair->send.origin = offset;
    pair->recv_height = (hpr_affine){-hpr_dot(send->normal, offset), hpr_dot(send->normal, recv->edge1),
                                     hpr_dot(send->normal, recv->edge2)};
    pair->send_height = (hpr_affine){hpr_dot(recv->normal, offset), hpr_dot(recv->normal, send->edge1),
                                     hpr_dot(recv->normal, send->edge2)};
}

hpr_element_frame hpr_frame_rescaled(const hpr_element_frame *frame, double scale)
{
    hpr_element_frame f = *frame;
    f.origin = hpr_scale(f.origin, scale);
    f.edge1 = hpr_scale(f.edge1, scale);
    f.edge2 = hpr_scale(f.edge2, scale);
    f.area_m2 = f.area_m2 * scale * scale;
    return f;
}

hpr_cell hpr_cell_whole(const hpr_element_frame *frame)
{
    return (hpr_cell){.shape = frame->shape,
                      .edge1 = {1, 0},
                      .edge2 = {0, 1},
                      .opposite = {frame->opposite[0], frame->opposite[1]}};
}

hpr_polygon hpr_frame_outline(const hpr_element_frame *frame)
{
    double corner[4][2];
    hpr_polygon outline = {.count = (int)hpr_shape_corners(frame->shape, frame->opposite, corner)};
    memcpy(outline.corner, corner, sizeof corner);
    return outline;
}

double hpr_frame_largest(const hpr_element_frame *frame, const hpr_affine *f)
{
    double a = f->at_origin, b = a + f->along1, c = a + f->along2, last = a;
    if (frame->shape == HPR_SHAPE_PARALLELOGRAM)
        last = b + f->along2;
    else if (frame->shape == HPR_SHAPE_QUADRILATERAL)
        last = hpr_affine_at(f, frame->opposite[0], frame->opposite[1]);
    return fmax(fmax(a, b), fmax(c, last));
}

double hpr_frame_least(const hpr_element_frame *frame, const hpr_affine *f)
{
    const hpr_affine turned = {-f->at_origin, -f->along1, -f->along2};
    return -hpr_frame_largest(frame, &turned);
}

hpr_cell hpr_cell_triangle(const double p0[2], const double p1[2], const double p2[2])
{
    return (hpr_cell){.shape = HPR_SHAPE_TRIANGLE,
                      .origin = {p0[0], p0[1]},
                      .edge1 = {p1[0] - p0[0], p1[1] - p0[1]},
                      .edge2 = {p2[0] - p0[0], p2[1] - p0[1]}};
}

void hpr_frame_chord(const hpr_element_frame *frame, const double from[2], const double to[2],
                     double chord[2])
{
    /* side >= 0 inside: s, t, and 1 - s - t or 1 - s, 1 - t or those of a quadrilateral */
    double ds = to[0] - from[0], dt = to[1] - from[1];
    bool triangle = frame->shape == HPR_SHAPE_TRIANGLE;
    double side[4] = {from[0], from[1], 1 - from[0] - (triangle ? from[1] : 0), 1 - from[1]};
    double slope[4] = {ds, dt, -ds - (triangle ? dt : 0), -dt};
    if (frame->shape == HPR_SHAPE_QUADRILATERAL) {
        double a = frame->opposite[0], b = frame->opposite[1];
        side[2] = (a - 1) * from[1] - b * (from[0] - 1);
        slope[2] = (a - 1) * dt - b * ds;
        side[3] = (b - 1) * from[0] - a * (from[1] - 1);
        slope[3] = (b - 1) * ds - a * dt;
    }
    chord[0] = -INFINITY;
    chord[1] = INFINITY;
    for (int i = 0; i < (triangle ? 3 : 4); i++) {
        if (slope[i] > 0)
            chord[0] = fmax(chord[0], -side[i] / slope[i]);
        else if (slope[i] < 0)
            chord[1] = fmin(chord[1], -side[i] / slope[i]);
    }
    chord[0] = fmin(chord[0], 0);
    chord[1] = fmax(chord[1], 1);
}

int hpr_cell_corners(const hpr_element_frame *frame, const hpr_cell *cell, hpr_vec3 corner[4])
{
    hpr_vec3 o = hpr_frame_point(frame, cell->origin[0], cell->origin[1]);
    hpr_vec3 e1 = hpr_frame_vector(frame, cell->edge1), e2 = hpr_frame_vector(frame, cell->edge2);
    corner[0] = o;
    corner[1] = hpr_add(o, e1);
    if (cell->shape == HPR_SHAPE_TRIANGLE) {
        corner[2] = hpr_add(o, e2);
        return 3;
    }
    corner[2] = cell->shape == HPR_SHAPE_PARALLELOGRAM
                    ? hpr_add(corner[1], e2)
                    : hpr_frame_point(frame, cell->opposite[0], cell->opposite[1]);
    corner[3] = hpr_add(o, e2);
    return 4;
}

double hpr_inner_fraction(const hpr_pair *pair, const hpr_element_frame *outer,
                          const hpr_element_frame *inner, const hpr_convex *polygon, hpr_vec3 point,
                          bool *complete)
{
    if (pair->blocker_count) {
        hpr_visible visible;
        visible.hidden = NULL;
        *complete &= hpr_visible_part(point, polygon, inner->normal, pair->blocker, pair->chosen,
                                      pair->blocker_count, &visible);
        return hpr_visible_fraction(outer->normal, &visible);
    }
    double x[3], normal[3], corner[HPR_VISIBLE_CORNERS][3];
    hpr_vec3_store(x, point);
    hpr_vec3_store(normal, outer->normal);
    for (int i = 0; i < polygon->count; i++)
        hpr_vec3_store(corner[i], polygon->corner[i]);
    return hpr_lambert_fraction(x, normal, (const double(*)[3])corner, (size_t)polygon->count);
}
