#!/usr/bin/env python3
"""View factors and moments of pairs that are hard, through the command: test_view_factors.py HPRAD.

Against numbers of 40-digit arithmetic that share nothing with hprad: view factors by contour integrals
(tests/support/contour_digits.py), moments K_k0 by tanh-sinh over the receiver of Lambert's closed form in 30 digits.
All within 1e-12 at --tol 1e-13.
"""
import math
import os
import struct
import sys
import tempfile

sys.path.insert(0, os.path.join(os.path.dirname(os.path.abspath(__file__)), "..", "support"))
from cli_support import Command  # noqa: E402
from tap import check, done  # noqa: E402

BOUND = 1e-12  # worst seen: 4e-15

SQUARE = ((0, 0, 0), (1, 0, 0), (1, 1, 0), (0, 1, 0))
# Four billion times longer than wide, its short side near SQUARE.
NEEDLE = ((.5, 3e9, 4e9), (-.25, 1.5, .25), (1.25, 1.5, .25))
SCALENE = ((0, 0, 0), (1.25, 0, 0), (.75, .5, 0))


def turned(degrees, length):
    """y and z of a point at this distance from the x axis, turned up from the y axis."""
    return length * math.cos(math.radians(degrees)), length * math.sin(math.radians(degrees))


def hinged(degrees, width):
    """A rectangle on the first edge of SQUARE that looks at it."""
    y, z = turned(degrees, width)
    return (1, 0, 0), (0, 0, 0), (0, y, z), (1, y, z)


# name, two polygons, F_12
FACTORS = [
    ("squares, 3 degrees", SQUARE, hinged(3, 1), 0.95076679854742656376),
    ("squares, 33 degrees", SQUARE, hinged(33, 1), 0.58975086319835327168),
    ("squares, 177 degrees", SQUARE, hinged(177, 1), 0.00021248760682235547817),
    ("a strip 1 : 1e4, 60 degrees", SQUARE, hinged(60, 1e-4), 7.4985248277627260331e-05),
    ("scalene triangles on an edge, 5 degrees", SCALENE, ((1.25, 0, 0), (0, 0, 0), (.25, *turned(5, 1.5))),
     0.9937839402804685996),
    ("a needle 1 : 1e4 along an edge, 60 degrees", SQUARE, ((1, 0, 0), (0, 0, 0), (.25, *turned(60, 1e-4))),
     3.7498785827185738369e-05),
    ("needles 1 : 1e4, gap of half a width", ((0, 0, 0), (1, 0, 0), (.5, 1e-4, 0)),
     ((0, 0, 5e-5), (.25, 1e-4, 5e-5), (1, 0, 5e-5)), 0.42844892142781360056),
    ("triangles sharing a vertex", ((0, 0, 0), (1, .125, 0), (.25, 1, 0)), ((0, 0, 0), (.5, .75, .5), (1, .25, 1.25)),
     0.200787772558840017),
    ("a leaning triangle on the middle of a floor", SQUARE,
     ((.75, .5, 0), (.25, .5, 0), (.5, .5 + turned(45, .75)[0], turned(45, .75)[1])), 0.11211257316665484141),
    ("squares shifted, gap 1e-3", SQUARE, ((.375, .25, 1e-3), (.375, 1.25, 1e-3), (1.375, 1.25, 1e-3),
                                           (1.375, .25, 1e-3)), 0.46874871729672384641),
    ("triangles shifted, gap 2^-36", SCALENE, ((.125, 0, 2 ** -36), (.875, .5, 2 ** -36), (1.375, 0, 2 ** -36)),
     0.8099999999738065526),
    ("a slit of 2^-30 rad", SQUARE, ((1, 0, 0), (0, 0, 0), (.25, .75, .75 * 2 ** -30), (.75, .75, .75 * 2 ** -30)),
     0.56249999999999999959),
    ("a slit of 2^-20 rad on a part of the edge", SQUARE, ((1.25, 0, 0), (.25, 0, 0), (.75, 1.25, 1.25 * 2 ** -20)),
     0.52187499998921656214),
    ("2^-30 rad short of flat", SQUARE, ((1, 0, 0), (0, 0, 0), (0, -1, 2 ** -30), (1, -1, 2 ** -30)),
     6.7222853101927396652e-20),
    ("parallelograms in general position, gap 1e-12, corners rounded",
     ((-0.23761418318220065, -0.065774330808380743, 0.61546882615682774),
      (-0.29168414133240694, -0.033306581450736152, 0.66588306368509009),
      (-0.27392158809381673, -0.011311804528094722, 0.64289958467891584),
      (-0.21985162994361043, -0.043779553885739314, 0.59248534715065349)),
     ((-0.27392158809387052, -0.011311804528104794, 0.64289958467886466),
      (-0.29168414133246073, -0.033306581450746227, 0.66588306368503891),
      (-0.23761418318225447, -0.065774330808390818, 0.61546882615677656),
      (-0.21985162994366425, -0.043779553885749389, 0.5924853471506023)), .99999999999660251653),
    ("squares so small that their area is no normal number, 33 degrees",
     *(tuple(tuple(x * 2 ** -513 for x in c) for c in p) for p in (SQUARE, hinged(33, 1))), 0.58975086319835327168),
    ("a needle 1 : 4e9 from its tip", SQUARE, NEEDLE, 0.063547325499358770449),
    ("the same from the side", SQUARE, NEEDLE[1:] + NEEDLE[:1], 0.063547325499358770449),
]

# Two plates 1e-11 apart and a sheet through both: most of what one sees of the other is in pieces.
PLATES = (
    ((0.61266098493952748, -1.2890351980166259, 0.24194085845777757),
     (-0.14765115862483458, -0.27456033206687058, 0.83106994999913075),
     (-0.15464491704167238, -0.40831285562682429, 0.51860220396396572),
     (0.60566722652268967, -1.4227877215765796, -0.070526887577387454)),
    ((-0.15464491705055811, -0.40831285563584058, 0.51860220396802403),
     (-0.1476511586337203, -0.27456033207588687, 0.83106995000318906),
     (0.61266098493064181, -1.2890351980256423, 0.24194085846183591),
     (0.605667226513804, -1.422787721585596, -0.070526887573329131)),
    ((-0.12974085428158841, -0.43233789943490614, 0.51975385738066548),
     (1.4430875190286605, 0.8159636973501978, 1.2654392418857194),
     (-2.0020802330927867, -1.9675662098582376, -0.50965370400275711),
     (-2.4254770336571712, -2.3036021761384382, -0.71038813338145779)))
# The same without the sheet, which is so thin a part of the view that it does not count.
OPEN_PLATES = .9999999999351491
ROUNDING = 1e-13  # seen: 2e-14

# Two facets on one line in planes that agree to 2e-5, the line known to 1e-8 of their size: tolerance, F_12 by
# Gauss over the first of Lambert's formula in 50 digits, which converges to 1e-8.
VAGUE = (
    ((0.001075639758560984, 0.001074496730340037, 0.0010758111790399277),
     (0.0010751209490722636, 0.0010751811391404868, 0.0010757273200031655),
     (0.0010756507863748817, 0.0010745758077578681, 0.0010750456571429843)),
    ((0.0010749418568576368, 0.0010754173959755058, 0.0010756983719963599),
     (0.0010758622441514234, 0.0010742032293548376, 0.0010758471410408422),
     (0.0010756376915721645, 0.0010744819222787009, 0.0010759545147035188),
     (0.0010752165321493887, 0.0010750375119924728, 0.001075886439573273)))
VAGUE_FACTOR, VAGUE_BOUND = 2.0942e-11, 1e-6

# name, two polygons, degree, K_k0
MOMENTS = [
    ("squares, 33 degrees, degree 2", SQUARE, hinged(33, 1), 2,
     [0.589750863198353582, -0.193994527980285952, -0.0100928335517956285, 0, 0, 0, -0.0741083063351733976,
      0.00937940949310182881, 0.0195793126354314614]),
    ("scalene triangles, 60 degrees, degree 2", SCALENE, ((1.25, 0, 0), (0, 0, 0), (.25, *turned(60, 1.5))), 2,
     [0.339040295275426328, -0.017434160540197036, -0.057597269066725499, -0.0165197380123466316,
      -0.0111057815058950737, 0.00231504860857748896]),
    # These by product Gauss and, the vertex, by Sauter & Schwab's rule in 80-bit arithmetic, 18 and 16 digits.
    ("parallelograms in general position, degree 2", SQUARE,
     ((.25, .5, .75), (.5, 1.5, 1), (1.5, 1.625, 1.25), (1.25, .625, 1)), 2,
     [.12713673172858727462, .044184668794711570415, -.003691568343408252155, .028170222564969004039,
      .011183734084036590885, -.00018166992029988107995, -.0088384119496738929275, -.0034533783232503176303,
      .00059746343228753439603]),
    ("triangles sharing a vertex, degree 2", ((0, 0, 0), (1, 0, 0), (.25, 1, 0)),
     ((0, 0, 0), (-.25, 1, 1), (1, -.25, 1)), 2,
     [.20310792170504003036, -.044772218962702843306, -.017966118787818753962, -.00025516479262537524759,
      .0097882947405543737477, -.018102916081038379692]),
]


def write_model(path, *polygons):
    lines, surfaces, count = ["F 3"], [], 0
    for number, polygon in enumerate(polygons, 1):
        corners = [*range(count + 1, count + len(polygon) + 1), 0][:4]
        for corner in polygon:
            count += 1
            lines.append(f"V {count} " + " ".join(repr(float(x)) for x in corner))
        surfaces.append(f"S {number} {' '.join(map(str, corners))} 0 0 .5 s{number}")
    with open(path, "w", encoding="utf-8") as file:
        file.write("\n".join(lines + surfaces) + "\n")


def matrix(command, *options, tol="1e-13"):
    """The numbers of the matrix that formfactors writes of pair.vs3."""
    result = command("formfactors", "pair.vs3", "-o", "pair.npy", "--tol", tol, *options)
    if result.returncode not in (0, 4):
        raise RuntimeError(result.stderr)
    with open(os.path.join(command.folder, "pair.npy"), "rb") as file:
        data = file.read()
    return [x for x, in struct.iter_unpack("<d", data[10 + struct.unpack("<H", data[8:10])[0]:])]


def say(name, got, wanted, scale):
    """Each within the bound, relative to the scale."""
    error = max(abs(g - w) for g, w in zip(got, wanted)) / scale
    check(f"{name}: off by {error:.1e}", [] if error <= BOUND else [f"off by {error:.2e}, bound {BOUND:g}"])


def main():
    with tempfile.TemporaryDirectory() as folder:
        command, path = Command(sys.argv[1], folder), os.path.join(folder, "pair.vs3")
        for name, first, second, factor in FACTORS:
            write_model(path, first, second)
            say(name, [matrix(command)[1]], [factor], factor)
        for name, first, second, degree, column in MOMENTS:
            write_model(path, first, second)
            block = matrix(command, "--order", str(degree))
            count = len(column)
            forth, back = block[count * count:2 * count * count], block[2 * count * count:3 * count * count]
            say(name, forth[::count], column, column[0])
            say(f"{name}, the other way round", back[:count], column, column[0])
        write_model(path, *PLATES)
        factors = matrix(command, tol="1e-4")
        off = factors[1] - OPEN_PLATES
        wrong = [f"F = {f!r}" for f in factors if not 0 <= f <= 1]
        check(f"plates 1e-11 apart, a sheet through both: off by {off:.1e}",
              wrong + ([f"off by {off:.1e}"] if abs(off) > ROUNDING else []))
        write_model(path, *VAGUE)
        off = matrix(command, tol="1e-4")[1] / VAGUE_FACTOR - 1
        check(f"nearly one plane, hardly touching: off by {off:.1e}", [] if abs(off) < VAGUE_BOUND else [off])
    return done()


if __name__ == "__main__":
    sys.exit(main())
