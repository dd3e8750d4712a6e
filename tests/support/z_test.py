#!/usr/bin/env python3
"""Does a picture agree with one by path tracing? z_test.py REFERENCE.exr PICTURE.exr --error E
[--alpha A] [--table BLOCKS.csv]
With --blocks, REFERENCE is what --table has written.

REFERENCE is from `hprad reference` and has the layer `variance`; PICTURE is without noise. The pictures are compared
in blocks of 16 x 16 pixels, channel by channel: the difference of the block's means over the standard error of the
reference's must be within what chance explains with probability 1 - A for all blocks and channels together
(Bonferroni). So that a noisy reference does not agree with everything, E is fixed beforehand: the standard error of a
block, relative to the channel's mean over the picture, must be at most that (in the RMS over blocks). Pixels that no
path covers wholly and blocks where nothing shines are compared as they are: with a standard error of zero, equal or
not. Exits 1 if they differ. --table writes the means and standard errors of all blocks.
"""
import argparse
import csv
import math
import statistics
import sys
from collections import namedtuple

from exr import read

BLOCK = 16
# A mean over 256 float32 numbers that are equal but for their last bit.
ROUNDING = 2.0 ** -23

Block = namedtuple("Block", "channel column row mean other error z")
Verdict = namedtuple("Verdict", "table blocks limit mean_ratio error worst problems")


def _means(picture, name, columns, rows):
    values, width = picture.channels[name], picture.width
    return math.fsum(values[y * width + x] for y in rows for x in columns) / (len(rows) * len(columns))


def _z(mean, shown, error):
    off = max(abs(shown - mean) - ROUNDING * abs(mean), 0)
    return math.copysign(off / error if error > 0 else (math.inf if off else 0), shown - mean)


def blocks_of(reference, other, channels):
    """Every block of every channel; the blocks at the right and lower border may be smaller."""
    for name in channels:
        for y in range(0, reference.height, BLOCK):
            rows = range(y, min(y + BLOCK, reference.height))
            for x in range(0, reference.width, BLOCK):
                columns = range(x, min(x + BLOCK, reference.width))
                count = len(rows) * len(columns)
                mean, shown = (_means(picture, name, columns, rows) for picture in (reference, other))
                error = math.sqrt(_means(reference, "variance." + name, columns, rows) / count)
                yield Block(name, x // BLOCK, y // BLOCK, mean, shown, error, _z(mean, shown, error))


def blocks_of_table(path, other):
    """The same from means and standard errors that --table has written of another picture of this size."""
    with open(path, encoding="utf-8", newline="") as file:
        for line in csv.DictReader(file):
            name, x, y = line["channel"], int(line["column"]), int(line["row"])
            columns = range(BLOCK * x, min(BLOCK * (x + 1), other.width))
            rows = range(BLOCK * y, min(BLOCK * (y + 1), other.height))
            mean, error = float(line["reference_w_m2_sr"]), float(line["standard_error_w_m2_sr"])
            shown = _means(other, name, columns, rows)
            yield Block(name, x, y, mean, shown, error, _z(mean, shown, error))


def compare(reference, other, error, alpha=1e-3, channels=("R", "G", "B")):
    """Verdict on two pictures (paths, or what exr.read gives); its `problems` are texts, none if they agree."""
    reference, other = (read(p) if isinstance(p, str) else p for p in (reference, other))
    if (reference.width, reference.height) != (other.width, other.height):
        raise ValueError(f"{reference.width} x {reference.height} and {other.width} x {other.height} pixels")
    return judge(list(blocks_of(reference, other, channels)), error, alpha, channels)


def judge(blocks, error, alpha=1e-3, channels=("R", "G", "B")):
    limit = statistics.NormalDist().inv_cdf(1 - alpha / (2 * len(blocks)))
    problems, ratios, errors = [], [], []
    for name in channels:
        own = [block for block in blocks if block.channel == name]
        mean = math.fsum(block.mean for block in own) / len(own)
        if not mean > 0:
            problems.append(f"{name}: the reference is black")
            continue
        ratios.append(math.fsum(block.other for block in own) / len(own) / mean)
        errors.append(math.sqrt(math.fsum(block.error ** 2 for block in own) / len(own)) / mean)
        if not errors[-1] <= error:
            problems.append(f"{name}: the standard error of a block is {errors[-1]:.3%}, more than {error:.3%}")
    worst = max(blocks, key=lambda block: abs(block.z))
    for block in blocks:
        if not abs(block.z) <= limit:
            problems.append(f"{block.channel} in block ({block.column}, {block.row}): {block.other:.6g}, reference "
                            f"{block.mean:.6g} +- {block.error:.2g}: z = {block.z:.2f}, limit {limit:.2f}")
    return Verdict(blocks, len(blocks), limit, ratios, errors, worst, problems)


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("reference")
    parser.add_argument("picture")
    parser.add_argument("--error", type=float, required=True)
    parser.add_argument("--alpha", type=float, default=1e-3)
    parser.add_argument("--table")
    parser.add_argument("--blocks", action="store_true")
    arguments = parser.parse_args()
    if arguments.blocks:
        blocks = list(blocks_of_table(arguments.reference, read(arguments.picture)))
        verdict = judge(blocks, arguments.error, arguments.alpha)
    else:
        verdict = compare(arguments.reference, arguments.picture, arguments.error, arguments.alpha)
    if arguments.table:
        with open(arguments.table, "w", encoding="utf-8") as file:
            file.write("channel,column,row,reference_w_m2_sr,standard_error_w_m2_sr,picture_w_m2_sr,z\n")
            for block in verdict.table:
                numbers = (block.mean, block.error, block.other, block.z)
                file.write(f"{block.channel},{block.column},{block.row},{','.join(f'{x:.9g}' for x in numbers)}\n")
    print(f"{verdict.blocks} blocks, |z| <= {abs(verdict.worst.z):.2f} (limit {verdict.limit:.2f}), standard error of a "
          f"block {', '.join(f'{e:.3%}' for e in verdict.error)}, picture / reference "
          f"{', '.join(f'{r:.5f}' for r in verdict.mean_ratio)}")
    for problem in verdict.problems:
        print(problem, file=sys.stderr)
    return 1 if verdict.problems else 0


if __name__ == "__main__":
    sys.exit(main())
