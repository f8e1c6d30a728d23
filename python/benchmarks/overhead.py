#!/usr/bin/env python3
"""Measures the cost of Python: seconds of the same work by the program and by the module, in turns. It prints the ratio
of the smallest times of all rounds, which other load disturbs least, and the median and the range of the ratios of the
rounds.

usage: PYTHONPATH=build/release/python python3 python/benchmarks/overhead.py PROGRAM SEQUENCE [CUSTOM_CULLING]

PROGRAM         build/release/volccd
SEQUENCE        e.g. volccd scene generate deform --mesh octopus2-14k.vtkhdf --motion twist:40,collide:2 --copies 2 \\
                --frames 25 -o SEQUENCE
CUSTOM_CULLING  the program of examples/custom_culling; then its stage `spheres` is compared with `python-spheres` of
                docs/python.md, on the same pairs in the same batches

All runs use one thread. These are compared:
  steps    seconds in Pipeline::run, summed over the steps: Sequence.detect against the program
  arrays   wall clock of Detector.step from arrays, against the seconds in Pipeline::run of the same steps: all that
           the module adds, and the time to make the motion from the arrays, which every caller needs
  run      seconds of the culling stage's run(), Python against C++
  stage    the same with prepare()
"""

import json
import re
import statistics
import subprocess
import sys
import tempfile
import time
from pathlib import Path

import numpy as np

import volccd

ROUNDS = 15
ROOT = Path(__file__).resolve().parents[2]


def program(command, sequence, *settings):
    """The steps of stats.json."""
    with tempfile.TemporaryDirectory() as folder:
        stats = Path(folder) / "stats.json"
        more = [word for setting in settings for word in ("--set", setting)]
        words = [command, "detect", sequence, "--pipeline", "VolCCD+", "--threads", "1", "--stats", stats, *more]
        subprocess.run(words, check=True, stdout=subprocess.DEVNULL)
        return json.loads(stats.read_text())["steps"]


def from_file(path):
    steps = volccd.Sequence(path).detect(threads=1)
    return sum(result.statistics["seconds"] for _, result in steps)


def from_arrays(points, cells):
    """Wall clock of all steps, and what of it Pipeline::run took."""
    detector = volccd.Detector(cells, len(points[0]), threads=1)
    detector.step(points[0], points[1])
    start, within = time.perf_counter(), 0.0
    for x0, x1 in zip(points, points[1:]):
        result = detector.step(x0, x1)
        result.contacts
        within += result.statistics["seconds"]
    return time.perf_counter() - start, within


def stage_seconds(rows):
    return np.array([(row["seconds"], row["prepare_seconds"], row["in"]) for row in rows]).sum(axis=0)


def culling(command, path):
    """Seconds of run(), and of prepare() and run(): each in Python and in C++. The pairs of both are the same."""
    steps = program(command, path, "element-culling=spheres")
    cpp = stage_seconds(row for step in steps for row in step["stages"] if row["name"] == "spheres")
    results = volccd.Sequence(path).detect(threads=1, settings="element-culling=python-spheres")
    tables = [result.statistics["stages"] for _, result in results]
    python = stage_seconds(table[table["name"] == "python-spheres"][0] for table in tables)
    assert cpp[2] == python[2], f"pairs: {cpp[2]:.0f} in C++, {python[2]:.0f} in Python"
    return (python[0], cpp[0]), (python[0] + python[1], cpp[0] + cpp[1])


def register_spheres():
    source = "\n".join(re.findall(r"```python\n(.*?)```", (ROOT / "docs/python.md").read_text(), re.DOTALL))
    exec(re.search(r"^@volccd\.register\nclass Spheres.*?(?=\n\n\S)", source, re.DOTALL | re.MULTILINE).group(),
         {"np": np, "volccd": volccd})


def show(name, rounds):
    """rounds: pairs of seconds, with Python and without."""
    ratios = [python / without for python, without in rounds]
    smallest = min(python for python, _ in rounds) / min(without for _, without in rounds)
    print(f"{name:8} {smallest:7.3f}   median {statistics.median(ratios):.3f}, {min(ratios):.3f} .. {max(ratios):.3f}")


def main():
    if len(sys.argv) < 3:
        sys.exit(__doc__)
    command, path = sys.argv[1:3]
    sequence = volccd.Sequence(path)
    points = [sequence.points(frame) for frame in range(sequence.frame_count)]
    steps, arrays, stage = [], [], []
    for _ in range(ROUNDS):
        steps.append((from_file(path), sum(step["seconds"] for step in program(command, path))))
        arrays.append(from_arrays(points, sequence.cells(1)))
    show("steps", steps), show("arrays", arrays)
    if len(sys.argv) > 3:
        register_spheres()
        stage = [culling(sys.argv[3], path) for _ in range(ROUNDS)]
        show("run", [run for run, _ in stage]), show("stage", [both for _, both in stage])


if __name__ == "__main__":
    main()
