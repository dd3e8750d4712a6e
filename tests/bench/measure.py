"""What the areas of the benchmark share: a row, a command measured, the median."""
import dataclasses
import json
import os
import statistics
import subprocess
import time

# A run that took longer than this is not repeated.
LONG_S = 4


@dataclasses.dataclass
class Row:
    """One line of a table. Seconds are CPU seconds; error is relative; what is not known is None."""
    case: str
    cpu_seconds: float
    error: float = None
    memory_bytes: int = None
    counters: dict = dataclasses.field(default_factory=dict)
    target_seconds: float = None
    note: str = ""


class Bench:
    """Where things are, how often a run is repeated, and one measured run of the command."""

    def __init__(self, root, build, folder, repeats, large):
        self.root, self.build, self.folder, self.repeats, self.large = root, build, folder, repeats, large
        self.hprad = os.path.join(build, "hprad")

    def scene(self, name):
        return os.path.join(self.root, "scenes", name + ".gltf")

    def path(self, name):
        return os.path.join(self.folder, name)

    def once(self, *arguments, allowed=(0,)):
        """(CPU seconds, exit code) of one run with one thread. Memory is in the reports; a process starts with the peak of
        the one that it was forked from, hence the shell between."""
        line = [self.hprad, *arguments, "--threads", "1", "--quiet"]
        process = subprocess.Popen(["sh", "-c", '"$@"; exit $?', "sh", *line], cwd=self.folder, stdout=subprocess.DEVNULL)
        _, status, usage = os.wait4(process.pid, 0)
        code = os.waitstatus_to_exitcode(status)
        process.returncode = code
        if code not in allowed:
            raise RuntimeError(f"{' '.join(line)}: exit code {code}")
        return usage.ru_utime + usage.ru_stime, code

    def run(self, *arguments, allowed=(0,)):
        """The same, the median of several."""
        runs, start = [], time.monotonic()
        while len(runs) < self.repeats and (not runs or time.monotonic() - start < LONG_S):
            runs.append(self.once(*arguments, allowed=allowed))
        return statistics.median(run[0] for run in runs), runs[-1][1]

    def commit(self):
        result = subprocess.run([self.hprad, "--version"], stdout=subprocess.PIPE, check=True, universal_newlines=True)
        return result.stdout.strip()

    def report(self, name):
        with open(self.path(name), encoding="utf-8") as file:
            return json.load(file)
