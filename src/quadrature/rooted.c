#include "quadrature/rooted.h"

#include "math/twofold.h"

typedef struct corners {
    int count;
    hpr_vec3 at[4];
} corners;

static corners corners_of(const hpr_element_frame *frame)
{
    corners c;
    hpr_cell whole = hpr_cell_whole(frame);
    c.count = hpr_cell_corners(frame, &whole, c.at);
    return c;
}

static bool may_be_turned(const hpr_element_frame *frame)
{
    static const double slender = 1e4; /* beside it even a plane of double precision loses digits */
    return frame->degree == 0 && frame->shape != HPR_SHAPE_QUADRILATERAL &&
           hpr_frame_slenderness(frame) > slender;
}

/* Index of the corner nearest to one of the others'. */
static int nearest_corner(const corners *own, const corners *other)
{
    int nearest = 0;
    double least = INFINITY;
    for (int i = 0; i < own->count; i++) {
        for (int j = 0; j < other->count; j++) {
            double distance = hpr_length(hpr_sub(own->at[i], other->at[j]));
            if (distance < least) {
                least = distance;
                nearest = i;
            }
        }
    }
    return nearest;
}

/* From this corner on, counter-clockwise as before. */
static void turn(hpr_element_frame *frame, int corner)
{
    const hpr_vec3 a = frame->edge1, b = frame->edge2, back_a = hpr_scale(a, -1), back_b = hpr_scale(b, -1);
    bool triangle = frame->shape == HPR_SHAPE_TRIANGLE;
    const hpr_vec3 edges[4][2] = {{a, b},
                                  {triangle ? hpr_sub(b, a) : b, back_a},
                                  {triangle ? back_b : back_a, triangle ? hpr_sub(a, b) : back_b},
                                  {back_b, a}};
    frame->origin = corners_of(frame).at[corner];
    frame->edge1 = edges[corner][0];
    frame->edge2 = edges[corner][1];
    hpr_cross_exactly(frame->edge1, frame->edge2, &frame->normal);
}

void hpr_frames_root(hpr_element_frame *recv, hpr_element_frame *send)
{
    bool turn_recv = may_be_turned(recv), turn_send = may_be_turned(send);
    if (!turn_recv && !turn_send)
        return;
    const corners a = corners_of(recv), b = corners_of(send);
    if (turn_recv)
        turn(recv, nearest_corner(&a, &b));
    if (turn_send)
        turn(send, nearest_corner(&b, &a));
}
