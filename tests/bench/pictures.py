"""Pictures of a stored solution: 512 x 512, one sample per pixel, direct light exact."""
from measure import Row

SIZE = ("--size", "512x512")
VIEWS = 10


def picture(bench, name, solution, *options, views=1, aim=None):
    """Seconds per view; the error is the difference from the same view of a finer solution, relative to its RMS."""
    seconds, memory, _ = bench.run("render", bench.path(solution), "-o", "{frame:04}.exr" if views > 1 else "p.exr",
                                   "--report", "p.json", *SIZE, *options)
    report = bench.report("p.json")
    counters = {"camera rays": report["counters"]["camera_rays"], "clips": report["counters"]["clips"]}
    return Row(name, seconds / views, None, memory, counters, aim)


def rows(bench):
    bench.once("solve", bench.scene("cornell_box"), "-o", "box.glb", "--order", "3", "--subdivide", "2")
    yield picture(bench, "cornell_box, 1 sample", "box.glb", "--samples", "1", aim=0.35)
    yield picture(bench, "cornell_box, 4 samples", "box.glb", "--samples", "4")
    yield picture(bench, f"cornell_box, 1 sample, each of {VIEWS} of 100 orbit views", "box.glb", "--samples", "1",
                  "--orbit", "100", "--frames", f"0-{VIEWS - 1}", views=VIEWS, aim=0.35)
