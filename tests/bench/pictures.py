"""Pictures of a stored solution: 512 x 512, direct light exact; the error is the solution's own estimate."""
from measure import Row

SIZE = ("--size", "512x512")
VIEWS = 10


def picture(bench, name, error, *options, views=1, aim=None):
    """Seconds are per view, those of the whole command with reading and writing."""
    seconds, _ = bench.run("render", "box.glb", "-o", "{frame:04}.exr" if views > 1 else "p.exr", "--report", "p.json",
                           *SIZE, *options)
    report = bench.report("p.json")
    counters = {"camera rays": report["counters"]["camera_rays"]}
    return Row(name, seconds / views, error, report["peak_memory_bytes"], counters, aim)


def rows(bench):
    bench.once("solve", bench.scene("cornell_box"), "-o", "box.glb", "--report", "box.json")
    error = bench.report("box.json")["error_estimate"]
    yield picture(bench, "cornell_box, 1 sample", error, "--samples", "1", aim=0.35)
    yield picture(bench, "cornell_box, 4 samples", error, "--samples", "4")
    yield picture(bench, f"cornell_box, 1 sample, each of {VIEWS} of 100 orbit views", error, "--samples", "1", "--orbit",
                  "100", "--frames", f"0-{VIEWS - 1}", views=VIEWS, aim=0.35)
