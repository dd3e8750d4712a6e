/*
 * Pairs in planes that nearly agree. A height that is a millionth of the size has lost six digits if it is
 * formed with a normal of double precision, and heights of either side that lost them independently belong to
 * no pair of planes: fluxes err by as much. So both are seen in coordinates in which one plane is z = 0: the
 * other side's z are triple products in twice the digits, and all else follows from them.
 */
#include "quadrature/flat.h"

#include "math/twofold.h"

#include <float.h>
#include <math.h>

/* (edge1 x edge2) . v */
static double triple(const hpr_element_frame *f, hpr_vec3 v)
{
    hpr_vec3 a = f->edge1, b = f->edge2;
    hpr_twofold x = hpr_twofold_times(hpr_twofold_minor(a.y, b.z, a.z, b.y), v.x),
                y = hpr_twofold_times(hpr_twofold_minor(a.z, b.x, a.x, b.z), v.y),
                z = hpr_twofold_times(hpr_twofold_minor(a.x, b.y, a.y, b.x), v.z);
    return hpr_twofold_sum(hpr_twofold_sum(x, y), z).high;
}

typedef struct axes {
    hpr_vec3 x, y;
    const hpr_element_frame *base;
    double twice; /* |edge1 x edge2| */
} axes;

static hpr_vec3 turned(const axes *a, hpr_vec3 v)
{
    return (hpr_vec3){hpr_dot(a->x, v), hpr_dot(a->y, v), triple(a->base, v) / a->twice};
}

static double longest_edge(const hpr_pair *pair)
{
    return fmax(fmax(hpr_length(pair->recv.edge1), hpr_length(pair->recv.edge2)),
                fmax(hpr_length(pair->send.edge1), hpr_length(pair->send.edge2)));
}

/* Not what counts as one plane anyway. */
static bool is_flat(const hpr_pair *pair, double contact)
{
    static const double flat = 0.02;
    double over = hpr_frame_largest(&pair->send, &pair->send_height);
    double below = -hpr_frame_least(&pair->send, &pair->send_height);
    return fmax(over, below) < flat * longest_edge(pair) && over > contact &&
           hpr_frame_largest(&pair->recv, &pair->recv_height) > contact;
}

/* Points nearer to the plane than that lie in it but for rounding. */
static double snapped(double z, double nearest)
{
    return fabs(z) <= nearest ? 0 : z;
}

void hpr_pair_flatten(hpr_pair *pair, double contact)
{
    static const double rounding = 16 * DBL_EPSILON;
    if (!is_flat(pair, contact))
        return;
    double nearest = fmin(contact, rounding * (longest_edge(pair) + hpr_length(pair->send.origin)));
    hpr_element_frame recv = pair->recv, send = pair->send;
    axes a = {.base = &pair->recv};
    a.x = hpr_scale(recv.edge1, 1 / hpr_length(recv.edge1));
    a.y = hpr_cross(recv.normal, a.x);
    a.twice = hpr_frame_jacobian(&recv);
    recv.edge1 = (hpr_vec3){hpr_length(recv.edge1), 0, 0};
    recv.edge2 = (hpr_vec3){hpr_dot(a.x, recv.edge2), a.twice / recv.edge1.x, 0};
    recv.normal = (hpr_vec3){0, 0, 1};
    hpr_vec3 origin = turned(&a, send.origin), edge1 = turned(&a, send.edge1), edge2 = turned(&a, send.edge2);
    double z0 = snapped(origin.z, nearest), z1 = snapped(origin.z + edge1.z, nearest),
           z2 = snapped(origin.z + edge2.z, nearest);
    origin.z = z0;
    edge1.z = z1 - z0;
    edge2.z = z2 - z0;
    hpr_vec3 across = hpr_cross(edge1, edge2);
    send.origin = origin;
    send.edge1 = edge1;
    send.edge2 = edge2;
    send.normal = hpr_scale(across, 1 / hpr_length(across));
    hpr_pair_init(pair, &recv, &send);
}
