#include "link/blocked.h"

#include <math.h>

/* What stands in for the tolerance of blocks that go by rays. */
static const double by_rays = 0.03;

hpr_blocked hpr_blocked_plan(const hpr_blocked_load *load)
{
    static const struct {
        double tolerance, points, seconds;
    } level[] = {{1e-6, 4000, 4}, {1e-3, 500, 6}, {1e-2, 300, 25}, {3e-2, 250, 40}};
    static const double part_if_open = 0.1, tightest_if_open = 1e-5;
    enum { LEVELS = sizeof level / sizeof *level };
    hpr_blocked blocked = {.tolerance = load->asked, .area_m2 = load->area_m2};
    double point_s = 0.5e-6 + 0.07e-6 * load->blocker_count;
    for (int k = 0; k < LEVELS && blocked.tolerance == 0; k++) {
        if ((double)load->pair_count * level[k].points * point_s <= level[k].seconds)
            blocked.tolerance = level[k].tolerance;
    }
    double clipped = blocked.tolerance > 0 ? blocked.tolerance : by_rays;
    if (load->asked > 0)
        blocked.rays = load->spread / (load->asked * load->asked);
    blocked.open_tolerance = load->asked > 0 ? load->asked : fmax(part_if_open * clipped, tightest_if_open);
    return blocked;
}

static double longest_side(const hpr_element_frame *frame)
{
    double length = fmax(hpr_length(frame->edge1), hpr_length(frame->edge2));
    if (frame->shape == HPR_SHAPE_PARALLELOGRAM)
        return length;
    if (frame->shape == HPR_SHAPE_TRIANGLE)
        return fmax(length, hpr_length(hpr_sub(frame->edge2, frame->edge1)));
    hpr_vec3 across = hpr_sub(hpr_frame_point(frame, frame->opposite[0], frame->opposite[1]), frame->origin);
    return fmax(length,
                fmax(hpr_length(hpr_sub(across, frame->edge1)), hpr_length(hpr_sub(across, frame->edge2))));
}

static double distance_between(const hpr_element_frame *a, const hpr_element_frame *b)
{
    const hpr_cell cell[2] = {hpr_cell_whole(a), hpr_cell_whole(b)};
    hpr_vec3 p[4], q[4];
    int p_count = hpr_cell_corners(a, &cell[0], p), q_count = hpr_cell_corners(b, &cell[1], q);
    return hpr_polygon_distance(p, p_count, q, q_count);
}

/* Near pairs need so many cells for the kernel that the rays between all their points cost more than
 * clipping. */
static bool is_near(const hpr_element_frame *a, const hpr_element_frame *b)
{
    static const double near = 0.5; /* of the longest side of the smaller one */
    return distance_between(a, b) < near * fmin(longest_side(a), longest_side(b));
}

double hpr_blocked_spread(const hpr_element_frame *recv, const hpr_element_frame *send, double area_m2)
{
    static const double pi = 3.14159265358979323846;
    double distance = distance_between(recv, send), r = recv->area_m2, s = send->area_m2;
    double far = sqrt(r * s) / (pi * distance * distance), near = sqrt(fmin(r, s) / fmax(r, s));
    return fmin(far, near) / 2 * sqrt((r + s) / area_m2);
}

void hpr_blocked_decide(const hpr_blocked *blocked, double recv_m2, double send_m2, hpr_block_task *task)
{
    static const double few = 16, roughly = 0.3; /* rays; the kernel, where few rays meet it */
    bool parts = task->recv_part_count || task->send_part_count;
    if (!task->blocker_count && !parts)
        return;
    bool near = is_near(&task->recv, &task->send);
    double rays = blocked->rays * hpr_blocked_spread(&task->recv, &task->send, blocked->area_m2);
    bool drowns = blocked->rays > 0 && rays <= few && !near && !parts;
    bool clip = task->blocker_count <= HPR_CLIP_BLOCKERS && (blocked->tolerance > 0 || near) && !drowns;
    double tolerance = clip && blocked->tolerance > 0 ? blocked->tolerance : by_rays;
    task->clip = clip || !task->blocker_count;
    if (task->clip)
        task->tolerance = tolerance;
    else if (blocked->rays > 0) {
        task->ray_nodes = 2;
        task->tolerance = fmin(fmax(task->tolerance, 0.5 / sqrt(rays)), roughly);
    }
    task->negligible = fmax(task->negligible, tolerance * sqrt(recv_m2 * send_m2) / blocked->area_m2);
}

double hpr_blocked_error2(const hpr_blocked *blocked, const hpr_block_task *task,
                          const hpr_block_result *result)
{
    return result->sampling_error * result->sampling_error * (task->recv.area_m2 + task->send.area_m2) /
           blocked->area_m2;
}
