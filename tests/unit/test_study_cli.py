#!/usr/bin/env python3
"""hprad study from outside: test_study_cli.py HPRAD SCENES. The rates that theory foretells on plates with a smooth
solution, files, resuming, exit codes."""
import csv
import json
import math
import os
import sys
import tempfile

sys.path.insert(0, os.path.join(os.path.dirname(os.path.abspath(__file__)), "..", "support"))
from cli_support import Command, SIGNALS, interrupt, problems, write_scene  # noqa: E402
from tap import check, done  # noqa: E402

BAD_VALUES = {
    "--orders": ["", "17", "-1", "2:1", "1:x", "2,1", "1,1", "0:17", "1,"],
    "--subdivide": ["", "11", "1:0", "x"],
    "--refine": ["", "hpp", "h,,p"],
    "--method": ["", "jacobi", "hemicube,"],
    "--direct": ["", "both"],
    "--truth": ["", "17,0", "3,11", "1", "0"],
    "--tol": ["", "1", "0.1,", "x"],
    "--repeats": ["0", "x"],
    "--hemicube": ["3"],
}


def path_of(command, *parts):
    return os.path.join(command.folder, *parts)


def rows_of(command, name):
    with open(path_of(command, name), encoding="utf-8", newline="") as file:
        return list(csv.DictReader(file))


def study(command, *arguments, name="s.csv"):
    result = command("study", *arguments, "-o", name, "--quiet")
    check(f"hprad study {' '.join(arguments)}", problems(result, 0, (), ""))
    return rows_of(command, name)


def check_rates(command, plates):
    """The plates' solution is smooth: h converges like h^(p+1), p exponentially."""
    rows = study(command, plates, "--orders", "0:5", "--subdivide", "1:3", "--direct", "galerkin", "--truth", "16,1")
    check("a row for every order and subdivision", len(rows) == 18)
    orders = {(int(r["p"]), int(r["subdivide"])): float(r["order_l2"]) for r in rows if r["order_l2"]}
    check("the first subdivision has no order", sorted(orders) == [(p, n) for p in range(6) for n in (2, 3)])
    wrong = [f"p = {p}: {orders[p, 3]:.3f}" for p in range(6) if abs(orders[p, 3] - (p + 1)) > .1]
    check("h: the error falls like h^(p+1), exponent within 0.1", wrong)
    for key, most in (("error_l1", 1.1), ("error_linf", 12), ("error_face_means", 1.1)):
        wrong = [f"{key} {r[key]}, L2 {r['error_l2']}" for r in rows
                 if not 0 < float(r[key]) < most * float(r["error_l2"])]
        check(f"{key} is of the size of the L2 error", wrong)
    rows = study(command, plates, "--orders", "0:12", "--subdivide", "0,1", "--refine", "p", "--truth", "16,1")
    check("p alone: one row per order", [int(r["p"]) for r in rows] == list(range(13)))
    errors = {int(r["p"]): float(r["error_l2"]) for r in rows}
    wrong = [f"p = {p}: {errors[p]:.2e}, before {errors[p - 2]:.2e}" for p in range(2, 13, 2)
             if errors[p] > .2 * errors[p - 2]]  # observed .03 to .14
    check("p: two more degrees, a fifth of the error at most", wrong)
    check("p: exponential, a tenth on the average", errors[12] < 1e-5 * errors[2])
    check("p: nine digits at degree 12", errors[12] < 2e-9)  # by symmetry each even degree gains; observed 4e-10


def cheapest(rows, error, cost):
    """The least cost at which rows come below an error; infinite if none does."""
    return min((float(r[cost]) for r in rows if float(r["error_l2"]) <= error), default=math.inf)


def check_strategies(command, plates):
    """On a smooth solution the degree pays; hp is never dearer than p or h."""
    rows = study(command, plates, "--orders", "0:8", "--subdivide", "0:2", "--refine", "h,hp", "--truth", "16,1", name="w.csv")
    graded = [r for r in rows if r["refine"] == "graded"]
    uniform = [r for r in rows if r["refine"] == "uniform" and r["subdivide"] != "0"]
    lone = [r for r in rows if r["refine"] == "uniform" and r["subdivide"] == "0"]
    least = min(float(r["error_l2"]) for r in graded)
    errors = [error for error in (float(r["error_l2"]) for r in rows) if least <= error < 1e-4]
    check("hp goes below 1e-6", least < 1e-6 and len(errors) > 10)
    for cost in ("dofs", "kernel_evaluations"):
        wrong = []
        for error in errors:
            hp, h, p = (cheapest(some, error, cost) for some in (graded, uniform, lone))
            wrong += [] if hp <= p < math.inf and hp < h else [f"{error:.1e}: hp {hp}, h {h}, p {p}"]
        check(f"hp is best at every error below 1e-4: {cost}", wrong)


def check_curves(command, corner, truth):
    """The two curves of one table. With e = C exp(-c N^(1/4)) the slope of ln e over N^(1/4) stays the same, a faster
    fall makes it steeper; the best that uniform elements do, a power of N, flattens it: to 0.56 of its first half, were
    all of hp's six errors on the power that fits them best."""
    rows = study(command, corner, "--orders", "1", "--subdivide", "0:4", "--tol", "1e-1,3e-2,1e-2,3e-3,1e-3,4e-4",
                 *truth, name="curves.csv")
    hp = [(float(r["dofs"]) ** .25, math.log(float(r["error_l2"]))) for r in rows if r["refine"] == "adaptive hp"]
    first, second = ((b[1] - a[1]) / (b[0] - a[0]) for a, b in ((hp[0], hp[3]), (hp[3], hp[5])))
    check("curves: hp falls exponentially in the fourth root of its coefficients, or faster",  # observed 1.28
          [] if first < -.9 and second < .9 * first else [f"slopes {first:.3f} and {second:.3f}"])
    uniform = {float(r["h_m"]): float(r["error_l2"]) for r in rows if r["refine"] == "uniform"}
    rate = math.log2(uniform[.125] / uniform[.0625])
    check("curves: uniform elements fall like h to h^(lambda + 1/2)",  # lambda = 0.63, each within 0.1; observed 0.98
          [] if len(uniform) == 5 and .9 <= rate <= .63 + .6 else [f"{rate:.3f}"])
    check("curves: their best error takes hp a tenth of their 2048 coefficients",
          cheapest([r for r in rows if r["tolerance"]], min(uniform.values()), "dofs") <= 205)


def check_edges(command, corner):
    """Two squares at a right angle: what limits uniform elements is the edge, whatever their degree, until they are
    graded toward it. The solution compared with errs by 7e-5 (README)."""
    result = command("solve", corner, "--order", "4", "--subdivide", "0", "--grade", "7", "-o", "corner.glb", "--quiet")
    check("a corner to compare with", problems(result, 0))
    truth = ("--truth", "corner.glb")
    for direct in ("exact", "galerkin"):
        rows = study(command, corner, "--orders", "1:4", "--subdivide", "1:3", "--direct", direct, *truth, name="e.csv")
        orders = [(r["p"], float(r["order_l2"])) for r in rows if r["subdivide"] == "3"]
        wrong = [f"p = {p}: {order:.3f}" for p, order in orders if not .9 <= order <= .63 + .6]  # lambda = 0.63; observed 0.96 to 1.0
        check(f"edges: whatever the degree the error falls like h to h^(lambda + 1/2), direct light {direct}",
              wrong + ([] if len(orders) == 4 else ["other rows"]))
    rows = study(command, corner, "--orders", "1:4", "--subdivide", "0:3", "--refine", "h,hp", "--direct", "galerkin", *truth, name="e.csv")
    graded, uniform = ([r for r in rows if r["refine"] == kind] for kind in ("graded", "uniform"))
    best = min(float(r["error_l2"]) for r in uniform)
    check("edges: no uniform elements reach what hp does", [] if cheapest(graded, best / 2, "dofs") < math.inf else [f"uniform {best}"])
    wrong = []
    for r in graded:
        error = float(r["error_l2"])
        if error < 1e-2 and not cheapest(graded, error, "dofs") < cheapest(uniform, error, "dofs"):
            wrong.append(f"{error:.1e}: {cheapest(graded, error, 'dofs')}, uniform {cheapest(uniform, error, 'dofs')}")
    check("edges: hp needs the fewest coefficients for every error below 1e-2", wrong)
    check_curves(command, corner, truth)


def write_known(command, name, value):
    with open(path_of(command, name), "w", encoding="utf-8") as file:
        file.write("x,y,z,nx,ny,nz,irradiance_r,irradiance_g,irradiance_b\n")
        file.writelines(f"{x},0,{z},0,1,0,{value},{value},{value}\n" for x, z in ((.25, .5), (1, 1.5)))


def check_known(command, furnace):
    """Values of a closed form: H = 2 pi everywhere in the furnace."""
    options = (furnace, "--orders", "1", "--subdivide", "0", "--truth", "2,0", "--points")
    write_known(command, "known.csv", 2 * math.pi)
    row, = study(command, *options, "known.csv", name="k.csv")
    check("known values: the furnace has them", float(row["error_points"]) < 1e-6)  # blocks to 1e-6 or better
    write_known(command, "known.csv", 2.02 * math.pi)
    row, = study(command, *options, "known.csv", name="k.csv")
    check("known values: one percent more is one percent off, at the worst and on the average",
          all(abs(float(row[key]) - .02 / 2.02) < 1e-6 for key in ("error_points", "error_points_l2")))
    with open(path_of(command, "known.csv"), "w", encoding="utf-8") as file:
        file.write("x,y,z,nx,ny,nz,irradiance_r\n1,0,1,0,1,0,6\n")
    check("known values of one channel of three are refused",
          problems(command("study", *options, "known.csv", "-o", "x.csv"), 3, ["known.csv", "3 channels"], ""))


def check_methods(command, plates):
    rows = study(command, plates, "--method", "galerkin,hierarchical,hemicube,raycast,exact", "--orders", "0,1",
                 "--subdivide", "1,2", "--direct", "exact,galerkin", "--truth", "9,1", "--repeats", "2", "--hemicube", "64",
                 "--block-tol", "1e-8", "--link-tol", "1e-2")
    kinds = [(r["method"], r["p"], r["direct"]) for r in rows if r["subdivide"] == "1"]
    check("orders and direct light vary for galerkin alone",
          kinds == [("galerkin", "0", "exact"), ("galerkin", "1", "exact"), ("galerkin", "0", "galerkin"),
                    ("galerkin", "1", "galerkin"), ("hierarchical", "0", "galerkin"), ("hemicube", "0", "galerkin"),
                    ("raycast", "0", "galerkin"), ("exact", "0", "galerkin")])
    by = {(r["method"], r["p"], r["direct"], r["subdivide"]): r for r in rows}
    check("the hemicube evaluates no kernel and casts no ray",
          all(float(r["rays"]) == float(r["kernel_evaluations"]) == 0 for r in rows if r["method"] == "hemicube"))
    exact, own = (float(by[key]["error_l2"]) for key in (("exact", "0", "galerkin", "2"), ("galerkin", "0", "galerkin", "2")))
    check("exact form factors err like degree 0", abs(exact - own) < 1e-4 * own)
    for row in rows:
        least, middle, most = (float(row[k]) for k in ("cpu_seconds_least", "cpu_seconds", "cpu_seconds_most"))
        stages = sum(float(row[k]) for k in row if k.endswith("_cpu_seconds"))
        if not (0 < least <= middle <= most and stages <= 1.1 * most + .01 and float(row["peak_memory_bytes"]) > 1e6):
            check(f"times and memory of {row['method']} make sense", [str(row)])
    few, many = (float(study(command, plates, "--method", "hemicube", "--subdivide", "1", "--truth", "4,1", "--solver", "shooting",
                             "--hemicube", "64", "--shots", shots, name="n.csv")[0]["error_l2"]) for shots in ("1", "100"))
    check("--shots: what has not been shot yet is missing", few > 1.5 * many)
    fine = [float(by["galerkin", p, d, "2"]["error_l2"]) for p, d in (("0", "exact"), ("0", "galerkin"))]
    check("direct light evaluated at points is more exact", fine[0] < fine[1])


def check_files(command, plates):
    options = (plates, "--subdivide", "0,1", "--truth", "8,1", "--points", "points.csv")
    whole = study(command, *options, "--orders", "0:2", "--json", "s.json")
    with open(path_of(command, "s.json"), encoding="utf-8") as file:
        told = json.load(file)
    check("JSON says what ran and with what it was compared",
          told["scene"] == "parallel_plates.gltf" and told["truth"] == "order 8 subdivide 1 feet 2 grade 0"
          and "version" in told["hprad"])
    wrong = [f"{key}: {item[key]} and {row[key]}" for item, row in zip(told["rows"], whole) for key in item
             if str(item[key]) != row[key] and (item[key] is not None or row[key]) and float(row[key] or "nan") != item[key]]
    check("JSON and CSV say the same", wrong + ([] if len(told["rows"]) == len(whole) == 6 else ["other rows"]))
    check("errors at points are of the size of the others",
          all(0 < float(r["error_points"]) <= 20 * float(r["error_l2"]) for r in whole))
    result = command("solve", plates, "--order", "8", "--subdivide", "1", "--feet", "2", "-o", "truth.glb", "--quiet")
    check("a solution to compare with", problems(result, 0))
    stored = study(command, plates, "--subdivide", "0,1", "--orders", "0:2", "--truth", "truth.glb", name="t.csv")
    wrong = [f"{a['error_l2']} {b['error_l2']}" for a, b in zip(whole, stored)
             if not math.isclose(float(a["error_l2"]), float(b["error_l2"]), rel_tol=1e-9)]
    check("compared with a stored solution: the same errors", wrong)
    check("which was it", {r["truth"] for r in stored} == {"truth.glb"} and not stored[0]["error_points"])
    graded = study(command, plates, "--refine", "h,hp", "--orders", "1", "--subdivide", "0", "--truth", "8,1", name="g.csv")
    check("hp: order 1 with one level of grading", [(r["refine"], r["grade"]) for r in graded] == [("uniform", "0"), ("graded", "1")])


def check_adaptive(command, plates):
    options = (plates, "--orders", "1", "--subdivide", "0", "--method", "galerkin,hemicube", "--hemicube", "16")
    rows = study(command, *options, "--tol", "1e-1,1e-3", "--refine", "p,hp", "--truth", "12,1", "--json", "a.json", name="a.csv")
    found = [(r["method"], r["refine"], r["tolerance"] and float(r["tolerance"]), r["p"], r["subdivide"]) for r in rows]
    check("adaptive rows of galerkin alone, of each way",
          found == [("galerkin", "uniform", "", "1", "0"), ("galerkin", "graded", "", "1", "0"),
                    ("galerkin", "adaptive p", .1, "", ""), ("galerkin", "adaptive p", .001, "", ""),
                    ("galerkin", "adaptive hp", .1, "", ""), ("galerkin", "adaptive hp", .001, "", ""),
                    ("hemicube", "uniform", "", "0", "0")])
    wrong = [f"{r['refine']} {r['tolerance']}: {r['error_l2']}, estimated {r['error_estimate']}" for r in rows if r["tolerance"]
             and not float(r["error_l2"]) <= float(r["error_estimate"]) <= float(r["tolerance"])]
    check("their errors are below the estimates, and those below the tolerances", wrong)
    check("the hemicube has no estimate", not any(r["error_estimate"] for r in rows if r["method"] == "hemicube"))
    check("adaptive: which tolerance and no order, as JSON too",
          [(r["tolerance"], r["p"]) for r in json.load(open(path_of(command, "a.json"), encoding="utf-8"))["rows"]][1:4]
          == [(None, 1), (.1, None), (.001, None)])
    again = study(command, *options, "--tol", "1e-1,1e-2,1e-3", "--refine", "p,hp", "--truth", "12,1", "--resume", name="a.csv")
    check("--resume takes adaptive rows over", [r for r in again if r["tolerance"] and float(r["tolerance"]) != .01] == rows[2:6])
    check("and solves the others", len(again) == 9)
    late = study(command, *options, "--tol", "1e-6", "--max-time", "1e-9", "--truth", "12,1", name="b.csv")[1]
    check("--max-time: the first step stands, and its estimate says that the tolerance was missed",
          float(late["error_estimate"]) > 1e-6 and late["elements"] == "2")
    told = study(command, plates, "--orders", "0", "--subdivide", "0", "--method", "hierarchical", "--tol", "1e-1,5e-2", "--truth", "12,1",
                 name="c.csv")
    wrong = [f"{r['tolerance']}: {r['error_l2']}, estimated {r['error_estimate']}" for r in told[1:]
             if not float(r["error_l2"]) <= float(r["error_estimate"]) <= float(r["tolerance"]) or r["dofs"] != r["elements"]]
    check("adaptive constants: halved until the tolerance is met", wrong + ([] if [r["refine"] for r in told] ==
          ["uniform", "adaptive h", "adaptive h"] else ["other rows"]))
    # observed: 5e-4 of the run to 1e-2, below the 1.1e-3 that are estimated of what it is compared with
    late = command("study", *options, "--tol", "1e-1,1e-2", "-o", "b.csv", "--quiet")
    check("errors below that of the solution compared with are told", problems(late, 0, ["1 of 4 errors are below", "tolerance 0.002"]))
    told = rows_of(command, "b.csv")
    check("compared with a fifth of the least tolerance", {r["truth"] for r in told} == {"tolerance 0.002"})
    told = study(command, *options, "--tol", "1e-1", "--truth", "1e-4", name="b.csv")
    check("or with the one that is given", {r["truth"] for r in told} == {"tolerance 0.0001"})


def check_resume(command, plates):
    options = (plates, "--subdivide", "0,1", "--truth", "6,1")
    first = study(command, *options, "--orders", "0:1", name="r.csv")
    again = study(command, *options, "--orders", "0:2", "--resume", name="r.csv")
    check("--resume takes over what is there, bit for bit, and adds the rest", again[:4] == first and len(again) == 6)
    other = study(command, *options, "--orders", "0:1", "--resume", "--block-tol", "1e-3", name="r.csv")
    check("but not what was made with other settings", all(a["options"] != b["options"] for a, b in zip(other, first)))
    with open(path_of(command, "r.csv"), "w", encoding="utf-8") as file:
        file.write("a,b\n1,2\n")
    check("nor what it does not know", len(study(command, *options, "--orders", "0", "--resume", name="r.csv")) == 2)
    before = command.listing()
    number, code = SIGNALS["SIGINT"]
    got, text = interrupt(command, number, ("study", "long.gltf", "--orders", "4", "--subdivide", "2", "-o", "i.csv"), "assembly")
    check("interrupted: exit code 130, nothing half-written",
          [*([] if got == code else [f"exit code {got}: {text}"]), *(f for f in command.listing() if f not in before)])


def check_usage(command):
    before = command.listing()
    for option, values in BAD_VALUES.items():
        wrong = []
        for value in values:
            wrong += problems(command("study", "one.gltf", option, value), 2, [option], "")
        check(f"{option} refuses {len(values)} bad values", wrong)
    for arguments, code, texts in (((), 2, ["one scene"]),
                                   (("one.gltf", "--order", "1"), 2, ["--order", "unknown option"]),
                                   (("none.gltf",), 3, ["none.gltf"]),
                                   (("one.gltf", "--method", "hemicube", "--tol", "1e-1"), 2, ["galerkin"]),
                                   (("one.gltf", "--max-time", "3"), 2, ["--max-time", "--tol"]),
                                   (("one.gltf", "-o", "one.gltf"), 2, ["input"]),
                                   (("one.gltf", "-o", "no/x.csv"), 1, ["'no/x.csv'"]),
                                   (("one.gltf", "--truth", "one.gltf"), 3, ["one.gltf"]),
                                   (("one.gltf", "--truth", "truth.glb", "--orders", "0", "-o", "x.csv"), 3, ["not of this scene"])):
        check(f"hprad study {' '.join(arguments)}", problems(command("study", *arguments), code, texts, ""))
    check("what is refused writes nothing", command.listing() == before)


def main():
    with tempfile.TemporaryDirectory() as folder:
        command = Command(sys.argv[1], folder)
        plates, corner, furnace = (os.path.join(os.path.abspath(sys.argv[2]), name + ".gltf")
                                   for name in ("parallel_plates", "l_corner", "furnace_box"))
        write_scene(path_of(command, "one.gltf"))
        write_scene(path_of(command, "long.gltf"), plates=160)
        with open(path_of(command, "points.csv"), "w", encoding="utf-8") as file:
            file.write("x,y,z,nx,ny,nz\n0.5,0.5,0,0,0,1\n0.25,0.25,1,0,0,-1\n9,9,9,0,0,1\n")
        check_rates(command, plates)
        check_strategies(command, plates)
        check_edges(command, corner)
        check_known(command, furnace)
        check_methods(command, plates)
        check_files(command, plates)
        check_adaptive(command, plates)
        check_resume(command, plates)
        check_usage(command)
    return done()


sys.exit(main())
