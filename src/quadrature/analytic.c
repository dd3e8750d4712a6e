#include "quadrature/analytic.h"

double hpr_ellipse(double re, double im)
{
    double x = 2 * re - 1, y = 2 * im;
    double half = (hypot(x - 1, y) + hypot(x + 1, y)) / 2;
    return half + sqrt(fmax(half * half - 1, 0));
}

static double at_corner(hpr_vec3 from, hpr_vec3 along, double square, hpr_vec3 corner)
{
    hpr_vec3 offset = hpr_sub(corner, from);
    return hpr_ellipse(hpr_dot(offset, along) / square, hpr_length(hpr_cross(offset, along)) / square);
}

/* Where the segment's line comes nearest to the line of an edge. Beyond the edge's ends nothing is singular
 * on the sheet that counts: there the two arcs of the integral along the edge cancel. */
static double at_line(hpr_vec3 from, hpr_vec3 along, hpr_vec3 a, hpr_vec3 b)
{
    static const double parallel = 1e-24;
    hpr_vec3 edge = hpr_sub(b, a), offset = hpr_sub(from, a);
    double square = hpr_dot(edge, edge), step = hpr_dot(along, edge) / square;
    hpr_vec3 across = hpr_madd(along, -step, edge);
    hpr_vec3 gap = hpr_madd(offset, -hpr_dot(offset, edge) / square, edge);
    double speed = hpr_dot(across, across);
    if (!(speed > parallel * hpr_dot(along, along)))
        return INFINITY;
    double re = -hpr_dot(gap, across) / speed, im = hpr_length(hpr_cross(gap, across)) / speed;
    double place = hpr_dot(offset, edge) / square + re * step;
    return place >= 0 && place <= 1 ? hpr_ellipse(re, im) : INFINITY;
}

double hpr_bernstein(hpr_vec3 from, hpr_vec3 to, const hpr_vec3 *outline, int count)
{
    hpr_vec3 along = hpr_sub(to, from);
    double square = hpr_dot(along, along), least = INFINITY;
    if (!(square > 0))
        return INFINITY;
    for (int i = 0; i < count; i++) {
        least = fmin(least, at_corner(from, along, square, outline[i]));
        if (i > 0 || count > 2)
            least = fmin(least, at_line(from, along, outline[i], outline[i + 1 < count ? i + 1 : 0]));
    }
    return least;
}

/* Beyond this, nodes are as few as they get. */
static const double largest = 1e4;

static double factor(const hpr_convergence *c, double nodes)
{
    double pole = 1 + 1.5 * nodes * nodes * nodes * (fmin(c->ellipse, largest) - 1);
    return fmin(c->strength, pole) * fmin(c->lift, largest);
}

double hpr_polygon_strength(double cancellation)
{
    return 4 * cancellation;
}

int hpr_convergence_nodes(const hpr_convergence *c, double tolerance)
{
    enum { NEVER = 1000 };
    if (!(c->ellipse > 1))
        return NEVER;
    double rate = 2 * log(fmin(c->ellipse, largest)), n = 4;
    for (int i = 0; i < 3 && n < NEVER; i++)
        n = fmax((log(factor(c, n) / tolerance) + c->degree * log(c->growth)) / rate, 1);
    return n < NEVER ? (int)ceil(n) : NEVER;
}

double hpr_convergence_error(const hpr_convergence *c, int nodes)
{
    return factor(c, nodes) * pow(c->growth, c->degree) * pow(fmin(c->ellipse, largest), -2.0 * nodes);
}

double hpr_chord_growth(double bernstein, double low, double high)
{
    double rho = fmin(bernstein, largest), wide = (rho + 1 / rho) / 4, tall = (rho - 1 / rho) / 4;
    double left = (0.5 - wide - low) / (high - low), right = (0.5 + wide - low) / (high - low);
    double middle = (0.5 - low) / (high - low);
    double most = fmax(left < 0 ? hpr_ellipse(left, 0) : 1, right > 1 ? hpr_ellipse(right, 0) : 1);
    return fmax(most, hpr_ellipse(middle, tall / (high - low)));
}
