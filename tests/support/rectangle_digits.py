"""View factors of rectangles along the axes in closed form, in 60 digits: the alternating sums cancel.

A rectangle is ((x0, y0, z0), (x1, y1, z1)), flat along one axis; two of them see each other wholly. Numbers are taken as
they are in binary. Source: Ehlert & Smith 1993.
"""
from decimal import Decimal, getcontext
from itertools import product

getcontext().prec = 60
ATAN_HALVINGS = 12


def arctangent(x):
    """By halving the angle until its series takes few terms."""
    for _ in range(ATAN_HALVINGS):
        x = x / (1 + (1 + x * x).sqrt())
    square, power, total, n = x * x, x, Decimal(0), 1
    while True:
        before = total
        total += power / n
        if total == before:
            return total * 2 ** ATAN_HALVINGS
        power, n = -power * square, n + 2


PI = 4 * arctangent(Decimal(1))


def angle_term(a, c):
    """a c atan(a / c)"""
    return a * c * arctangent(a / c) if c else Decimal(0)


def log_term(factor, square):
    return factor * square.ln() if square else Decimal(0)


def parallel_corner(dx, dy, h):
    x2, y2, h2 = dx * dx, dy * dy, h * h
    return (angle_term(dy, (x2 + h2).sqrt()) + angle_term(dx, (y2 + h2).sqrt()) - log_term(h2 / 2, x2 + y2 + h2)) / (2 * PI)


def perpendicular_corner(a, b, d):
    square = a * a + b * b
    return (angle_term(d, square.sqrt()) - log_term((square - d * d) / 4, square + d * d)) / (2 * PI)


def alternating(function, *ranges):
    """Sum over the ends of all ranges, minus for each first end, plus for each second."""
    total = Decimal(0)
    for ends in product((0, 1), repeat=len(ranges)):
        total += (-1) ** (len(ranges) - sum(ends)) * function(*(r[e] for r, e in zip(ranges, ends)))
    return total


def exchange(first, second):
    """A_1 F_12."""
    a, b = ([[Decimal(c) for c in point] for point in rectangle] for rectangle in (first, second))
    flat, other = (next(k for k in range(3) if r[0][k] == r[1][k]) for r in (a, b))
    spans = [[(r[0][k], r[1][k]) for k in range(3)] for r in (a, b)]
    if flat == other:
        u, v = (k for k in range(3) if k != flat)
        height = abs(a[0][flat] - b[0][flat])
        return abs(alternating(lambda x, p, y, q: parallel_corner(x - p, y - q, height), spans[0][u], spans[1][u],
                               spans[0][v], spans[1][v]))
    along = 3 - flat - other
    heights = [[abs(c - b[0][other]) for c in spans[0][other]], [abs(c - a[0][flat]) for c in spans[1][flat]]]
    return abs(alternating(lambda s, t, p, q: perpendicular_corner(s, t, p - q), *heights, spans[0][along],
                           spans[1][along]))


def area(rectangle):
    sizes = [abs(Decimal(p) - Decimal(q)) for p, q in zip(*rectangle)]
    return sum(a * b for a, b in zip(sizes, sizes[1:] + sizes[:1]))


def view_factor(first, second):
    return exchange(first, second) / area(first)
