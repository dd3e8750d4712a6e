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
    return fmax(hpr_frame_longest(&pair->recv), hpr_frame_longest(&pair->send));
}

/* Not what counts as one plane anyway. base, other: their heights over the other's plane. */
static bool is_flat(const hpr_pair *pair, double contact, bool by_send)
{
    static const double flat = 0.02;
    const hpr_element_frame *base = by_send ? &pair->send : &pair->recv;
    const hpr_element_frame *other = by_send ? &pair->recv : &pair->send;
    const hpr_affine *height = by_send ? &pair->recv_height : &pair->send_height;
    double over = hpr_frame_largest(other, height), below = -hpr_frame_least(other, height);
    return fmax(over, below) < flat * longest_edge(pair) && over > contact &&
           hpr_frame_largest(base, by_send ? &pair->send_height : &pair->recv_height) > contact;
}

/* Points nearer to the plane than that lie in it but for rounding. */
static double snapped(double z, double nearest)
{
    return fabs(z) <= nearest ? 0 : z;
}

/* In the axes of the base, whose origin is where the other's is measured from. */
static void turn(const axes *a, double nearest, hpr_element_frame *other)
{
    hpr_vec3 origin = turned(a, other->origin), edge1 = turned(a, other->edge1),
             edge2 = turned(a, other->edge2);
    double z0 = snapped(origin.z, nearest), z1 = snapped(origin.z + edge1.z, nearest),
           z2 = snapped(origin.z + edge2.z, nearest);
    origin.z = z0;
    edge1.z = z1 - z0;
    edge2.z = z2 - z0;
    hpr_vec3 across = hpr_cross(edge1, edge2);
    other->origin = origin;
    other->edge1 = edge1;
    other->edge2 = edge2;
    other->normal = hpr_scale(across, 1 / hpr_length(across));
}

static void lay_down(const axes *a, hpr_element_frame *base)
{
    base->origin = (hpr_vec3){0, 0, 0};
    base->edge2 = (hpr_vec3){hpr_dot(a->x, base->edge2), 0, 0};
    base->edge1 = (hpr_vec3){hpr_length(base->edge1), 0, 0};
    base->edge2.y = a->twice / base->edge1.x;
    base->normal = (hpr_vec3){0, 0, 1};
}

/* A slender one loses its width when it is turned, but not when it is laid down. */
static bool sender_is_base(const hpr_pair *pair)
{
    static const double slender = 100;
    double width = hpr_frame_slenderness(&pair->send);
    return width > slender && width > hpr_frame_slenderness(&pair->recv);
}

void hpr_pair_flatten(hpr_pair *pair, double contact)
{
    static const double rounding = 1e-12;
    bool by_send = sender_is_base(pair);
    if (!is_flat(pair, contact, by_send))
        return;
    double nearest = fmin(contact, rounding * (longest_edge(pair) + hpr_length(pair->send.origin)));
    hpr_element_frame base = by_send ? pair->send : pair->recv, other = by_send ? pair->recv : pair->send;
    axes a = {.base = by_send ? &pair->send : &pair->recv, .twice = hpr_frame_jacobian(&base)};
    a.x = hpr_scale(base.edge1, 1 / hpr_length(base.edge1));
    a.y = hpr_cross(base.normal, a.x);
    other.origin = hpr_sub(other.origin, base.origin);
    lay_down(&a, &base);
    turn(&a, nearest, &other);
    hpr_pair_init(pair, by_send ? &other : &base, by_send ? &base : &other);
}
