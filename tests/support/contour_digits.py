#!/usr/bin/env python3
"""The view factor of two polygons that face each other wholly, to 20 digits: contour_digits.py MODEL.vs3 I J.

Independent of hprad: Stokes' theorem twice, A_1 F_12 = 1/(2 pi) sum over pairs of edges of the integral of
ln|x - y| dx . dy (Sparrow 1963), along one edge in closed form, along the other by tanh-sinh between the places
where edges are nearest to each other; in 40 digits, because the sum cancels. Surfaces I and J count from 1. Needs
mpmath, takes a second or so. The numbers of test_view_factors.py are from here.
"""
import sys

from mpmath import atan2, log, mp, mpf, nstr, pi, quad, sqrt

mp.dps = 40


def subtract(a, b):
    return [x - y for x, y in zip(a, b)]


def dot(a, b):
    return sum(x * y for x, y in zip(a, b))


def cross(a, b):
    return [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]


def area(polygon):
    """By the sum of its fan's cross products."""
    total = [mpf(0)] * 3
    for p, q in zip(polygon[1:], polygon[2:]):
        total = [t + c for t, c in zip(total, cross(subtract(p, polygon[0]), subtract(q, polygon[0])))]
    return sqrt(dot(total, total)) / 2


def edges(polygon):
    """(corner, direction of length 1, length) of each edge."""
    for a, b in zip(polygon, polygon[1:] + polygon[:1]):
        along = subtract(b, a)
        length = sqrt(dot(along, along))
        yield a, [c / length for c in along], length


def along_edge(x, a, direction, length):
    """The integral of ln|x - a - t direction| over 0 <= t <= length."""
    offset = subtract(x, a)
    foot = dot(offset, direction)
    distance = sqrt(max(dot(offset, offset) - foot * foot, mpf(0)))

    def primitive(t):
        square = t * t + distance * distance
        return t * log(square) / 2 - t + distance * atan2(t, distance) if square else mpf(0)
    return primitive(length - foot) - primitive(-foot)


def breaks(a, direction, length, others):
    """Places on an edge where corners or lines of the others are nearest."""
    places = {mpf(0), length}
    for b, other, _ in others:
        offset, cosine = subtract(b, a), dot(direction, other)
        places.add(dot(offset, direction))
        if 1 - cosine * cosine > mpf(10) ** -30:
            places.add((dot(offset, direction) - cosine * dot(offset, other)) / (1 - cosine * cosine))
    kept = []
    for place in sorted(p for p in places if 0 <= p <= length):
        if not kept or place - kept[-1] > length * mpf(10) ** -32:
            kept.append(place)
    return kept


def exchange(first, second):
    """A F of two polygons, lists of corners."""
    others, total = list(edges(second)), mpf(0)
    for a, direction, length in edges(first):
        def inner(t, a=a, direction=direction):
            x = [p + t * d for p, d in zip(a, direction)]
            return sum(dot(direction, other) * along_edge(x, b, other, width) for b, other, width in others)
        total += quad(inner, breaks(a, direction, length, others), maxdegree=9)
    return abs(total) / (2 * pi)


def read(path):
    """Polygons of the surfaces of a .vs3 file, scaled to about 1."""
    vertices, surfaces = [], []
    with open(path, encoding="utf-8") as file:
        for words in map(str.split, file):
            if words and words[0] == "V":
                vertices.append([mpf(float(x)) for x in words[2:5]])
            elif words and words[0] == "S":
                surfaces.append([int(index) - 1 for index in words[2:6] if int(index)])
    scale = max(abs(x) for vertex in vertices for x in vertex)
    return [[[x / scale for x in vertices[index]] for index in surface] for surface in surfaces]


def main():
    polygons = read(sys.argv[1])
    first, second = (polygons[int(index) - 1] for index in sys.argv[2:4])
    print(nstr(exchange(first, second) / area(first), 20))


if __name__ == "__main__":
    main()
