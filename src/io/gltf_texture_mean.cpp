/* The mean of texture times colour over a triangle (see gltf.hpp). */
#include "io/gltf_texture.hpp"

#include <algorithm>
#include <cmath>

namespace gltf
{

namespace
{

const double max_pieces = 65536;
const double far_away = 1e12; /* texels; beyond it their fractions are lost to rounding */

/* A corner of a piece: where it lies in the reference triangle and in the texture, in texels. */
struct corner {
    double xi, eta, x, y;
};

/* Pieces are convex: a triangle cut by four lines has at most seven corners. */
struct piece {
    corner at[8];
    int count = 0;
};

double axis_value(const corner &p, int axis)
{
    return axis == 0 ? p.x : p.y;
}

/* What is left where sign * (coordinate - line) >= 0. */
piece clip(const piece &from, int axis, double line, double sign)
{
    piece to;
    for (int i = 0; i < from.count; i++) {
        const corner &a = from.at[i], &b = from.at[(i + 1) % from.count];
        double da = sign * (axis_value(a, axis) - line), db = sign * (axis_value(b, axis) - line);
        if (da >= 0 && to.count < 8)
            to.at[to.count++] = a;
        if ((da >= 0) != (db >= 0) && to.count < 8) {
            double t = da / (da - db);
            to.at[to.count++] = {a.xi + t * (b.xi - a.xi), a.eta + t * (b.eta - a.eta), a.x + t * (b.x - a.x),
                                 a.y + t * (b.y - a.y)};
        }
    }
    return to;
}

/* The cells along one axis. Cell i lies between i and i + 1; where the texture is clamped, the first and the
 * last one reach to infinity. */
struct axis_cells {
    hpr_wrap mode;
    int size;     /* texels */
    bool nearest; /* else between texel centres */

    double first() const
    {
        return mode != HPR_WRAP_CLAMP ? -HUGE_VAL : nearest ? 0 : -1;
    }
    double last() const
    {
        return mode != HPR_WRAP_CLAMP ? HUGE_VAL : size - 1;
    }
    double cell(double x) const
    {
        return std::clamp(std::floor(x), first(), last());
    }
    int texel(double i) const
    {
        if (mode == HPR_WRAP_CLAMP)
            return static_cast<int>(std::clamp(i, 0.0, size - 1.0));
        int64_t period = mode == HPR_WRAP_MIRROR ? 2 * static_cast<int64_t>(size) : size;
        int64_t m = static_cast<int64_t>(i) % period;
        m += m < 0 ? period : 0;
        return static_cast<int>(m < size ? m : period - 1 - m);
    }
};

struct integrand {
    const level *picture;
    axis_cells s, t;
    const rgb *colour; /* [3], at the corners of the reference triangle */
};

struct sum {
    rgb value = {0, 0, 0};
    double area = 0;
};

/* The texels that a cell interpolates, row-major; nearest: one. */
struct cell {
    double x, y;
    rgb texel[4];
};

cell open_cell(const integrand &f, double x, double y)
{
    cell c = {x, y, {}};
    for (int k = 0; k < (f.s.nearest ? 1 : 4); k++)
        c.texel[k] = f.picture->at(f.s.texel(x + k % 2), f.t.texel(y + k / 2));
    return c;
}

void add_point(const integrand &f, const cell &c, const corner &p, double weight, sum &total)
{
    /* Beyond a clamped edge the texels agree; extrapolated weights would only cancel. */
    double a = std::clamp(p.x - c.x, 0.0, 1.0), b = std::clamp(p.y - c.y, 0.0, 1.0);
    double corner_weight[4] = {(1 - a) * (1 - b), a * (1 - b), (1 - a) * b, a * b};
    for (size_t k = 0; k < 3; k++) {
        double colour = f.colour[0][k] + p.xi * (f.colour[1][k] - f.colour[0][k]) +
                        p.eta * (f.colour[2][k] - f.colour[0][k]);
        double value = f.s.nearest ? c.texel[0][k] : 0;
        for (size_t i = 0; !f.s.nearest && i < 4; i++)
            value += corner_weight[i] * c.texel[i][k];
        total.value[k] += weight * colour * value;
    }
}

/* Within a cell the texture is bilinear and the colour linear: the four-point rule of degree 3 (Strang & Fix
 * 1973) is exact. */
void add_piece(const integrand &f, const cell &c, const piece &p, sum &total)
{
    for (int i = 1; i + 1 < p.count; i++) {
        const corner &a = p.at[0], &b = p.at[i], &d = p.at[i + 1];
        double area = 0.5 * ((b.xi - a.xi) * (d.eta - a.eta) - (d.xi - a.xi) * (b.eta - a.eta));
        for (int k = 0; k < 4; k++) {
            double wa = k == 3 ? 1.0 / 3 : k == 0 ? 0.6 : 0.2, wb = k == 3 ? 1.0 / 3 : k == 1 ? 0.6 : 0.2;
            double wd = 1 - wa - wb;
            corner q = {wa * a.xi + wb * b.xi + wd * d.xi, wa * a.eta + wb * b.eta + wd * d.eta,
                        wa * a.x + wb * b.x + wd * d.x, wa * a.y + wb * b.y + wd * d.y};
            add_point(f, c, q, area * (k == 3 ? -27.0 / 48 : 25.0 / 48), total);
        }
        total.area += area;
    }
}

struct range {
    double low, high;
};

range extent(const piece &p, int axis)
{
    range r = {HUGE_VAL, -HUGE_VAL};
    for (int i = 0; i < p.count; i++) {
        r.low = std::min(r.low, axis_value(p.at[i], axis));
        r.high = std::max(r.high, axis_value(p.at[i], axis));
    }
    return r;
}

/* The part of a piece within cell i of an axis; the open ends of a clamped axis are not cut. */
piece cut(const piece &from, int axis, const axis_cells &cells, double i, const range &r)
{
    piece to = from;
    if (i > cells.first() && i > r.low)
        to = clip(to, axis, i, 1);
    if (i < cells.last() && i + 1 < r.high)
        to = clip(to, axis, i + 1, -1);
    return to;
}

sum integrate(const integrand &f, const piece &triangle)
{
    sum total;
    range rows = extent(triangle, 1);
    for (double y = f.t.cell(rows.low); y <= f.t.cell(rows.high); y++) {
        piece row = cut(triangle, 1, f.t, y, rows);
        if (row.count < 3)
            continue;
        range columns = extent(row, 0);
        for (double x = f.s.cell(columns.low); x <= f.s.cell(columns.high); x++)
            add_piece(f, open_cell(f, x, y), cut(row, 0, f.s, x, columns), total);
    }
    return total;
}

/* Cells that a triangle meets, at most: those inside it and those along its bounding box's sides. */
double count_pieces(const piece &p, const axis_cells &s, const axis_cells &t)
{
    range columns = extent(p, 0), rows = extent(p, 1);
    double wide = s.cell(columns.high) - s.cell(columns.low) + 1;
    double high = t.cell(rows.high) - t.cell(rows.low) + 1;
    double area = 0.5 * std::fabs((p.at[1].x - p.at[0].x) * (p.at[2].y - p.at[0].y) -
                                  (p.at[2].x - p.at[0].x) * (p.at[1].y - p.at[0].y));
    return std::min(wide * high, area + 2 * (wide + high));
}

rgb mean_colour(const rgb colour[3], const rgb &factor)
{
    rgb out;
    for (size_t c = 0; c < 3; c++)
        out[c] = (colour[0][c] + colour[1][c] + colour[2][c]) / 3 * factor[c];
    return out;
}

} // namespace

rgb texture_triangle_mean(texture &tex, const double uv[3][2], const rgb colour[3])
{
    for (size_t i = 0;; i++) {
        const level &picture = tex.at_level(i);
        if (tex.uniform || (picture.width == 1 && picture.height == 1))
            return mean_colour(colour, picture.at(0, 0));
        double shift = tex.nearest ? 0 : 0.5;
        piece triangle;
        triangle.count = 3;
        double reach = 0;
        for (int k = 0; k < 3; k++) {
            triangle.at[k] = {k == 1 ? 1.0 : 0.0, k == 2 ? 1.0 : 0.0, uv[k][0] * picture.width - shift,
                              uv[k][1] * picture.height - shift};
            reach = std::max({reach, std::fabs(triangle.at[k].x), std::fabs(triangle.at[k].y)});
        }
        integrand f = {&picture,
                       {tex.wrap_s, picture.width, tex.nearest},
                       {tex.wrap_t, picture.height, tex.nearest},
                       colour};
        if (reach > far_away || count_pieces(triangle, f.s, f.t) > max_pieces)
            continue;
        sum total = integrate(f, triangle);
        rgb out;
        for (size_t c = 0; c < 3; c++)
            out[c] = total.value[c] / total.area;
        return out;
    }
}

} // namespace gltf
