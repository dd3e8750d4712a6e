#!/usr/bin/env python3
"""The picture of the Cornell box's default solution against path tracing: test_cornell_picture.py HPRAD SCENES.

cornell_blocks.csv has means and standard errors of blocks of 16 x 16 pixels (tests/support/z_test.py --table) of
    hprad reference scenes/cornell_box.gltf -o truth.exr --size 256x256 --samples 2048
134 million paths, four CPU minutes. Its blocks are known to 0.22, 0.24 and 0.27 % of the mean, that to 0.015 %.
"""
import os
import sys
import tempfile

HERE = os.path.dirname(os.path.abspath(__file__))
sys.path.insert(0, os.path.join(HERE, "..", "support"))
import exr  # noqa: E402
import z_test  # noqa: E402
from cli_support import Command, problems  # noqa: E402
from tap import check, done  # noqa: E402

BLOCKS = os.path.join(HERE, "cornell_blocks.csv")
BLOCK_ERROR = .005  # relative standard error that a block may have
MEAN_BOUND = .001  # observed 4e-4


def main():
    scene = os.path.join(sys.argv[2], "cornell_box.gltf")
    with tempfile.TemporaryDirectory() as folder:
        command = Command(sys.argv[1], folder)
        check("the default solution", problems(command("solve", scene, "-o", "box.glb", "--quiet"), 0))
        # 64 samples: at an edge along the pixels' rows or columns a pixel is off by at most 1/128 of the step there.
        run = command("render", "box.glb", "-o", "box.exr", "--size", "256x256", "--samples", "64", "--quiet")
        check("its picture", problems(run, 0))
        picture = exr.read(os.path.join(folder, "box.exr"))
    verdict = z_test.judge(list(z_test.blocks_of_table(BLOCKS, picture)), BLOCK_ERROR)
    worst, ratios = abs(verdict.worst.z), ", ".join(f"{r:.5f}" for r in verdict.mean_ratio)
    check(f"{verdict.blocks} blocks: |z| <= {worst:.2f}, limit {verdict.limit:.2f}", verdict.problems)
    check(f"means over those of path tracing: {ratios}, within {MEAN_BOUND}",
          all(abs(r - 1) <= MEAN_BOUND for r in verdict.mean_ratio))
    sys.exit(done())


main()
