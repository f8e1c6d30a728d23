"""VTK reads the files that are written: contacts (.vtp), single steps, and sequences. Skipped if Python has no VTK
(python3-vtk9)."""

import json
import math
import os
import re
import subprocess
import sys
import unittest
import xml.etree.ElementTree as ET

from program_support import run, with_bad_last_step, ProgramTest

# Run by the Python that has VTK: prints the data that VTK's readers return.
READER = r"""
import json, sys
from vtkmodules.vtkCommonCore import vtkOutputWindow, vtkVersion
from vtkmodules.vtkIOHDF import vtkHDFReader
from vtkmodules.vtkIOXML import vtkXMLPolyDataReader

class Messages:
    def __init__(self):
        self.texts = []
    def __call__(self, caller, event, *rest):
        self.texts.append(event)

def arrays_of(data):
    arrays = {}
    for i in range(data.GetNumberOfArrays()):
        array = data.GetArray(i)
        arrays[data.GetArrayName(i)] = [list(array.GetTuple(k)) for k in range(array.GetNumberOfTuples())]
    return arrays

version = vtkVersion()
result = {"version": [version.GetVTKMajorVersion(), version.GetVTKMinorVersion()], "files": []}
for name in sys.argv[1:]:
    reader = vtkXMLPolyDataReader() if name.endswith(".vtp") else vtkHDFReader()
    messages = Messages()
    for event in ("ErrorEvent", "WarningEvent"):
        reader.AddObserver(event, messages)
    reader.SetFileName(name)
    reader.Update()
    out = reader.GetOutput()
    result["files"].append({
        "messages": messages.texts, "points": [list(out.GetPoint(i)) for i in range(out.GetNumberOfPoints())],
        "corners": [[out.GetCell(i).GetPointId(k) for k in range(out.GetCell(i).GetNumberOfPoints())]
                    for i in range(out.GetNumberOfCells())],
        "cells": out.GetNumberOfCells(), "types": [out.GetCellType(i) for i in range(out.GetNumberOfCells())],
        "point_data": arrays_of(out.GetPointData()), "cell_data": arrays_of(out.GetCellData()),
        "field_data": arrays_of(out.GetFieldData()),
        "steps": reader.GetNumberOfSteps() if hasattr(reader, "GetNumberOfSteps") else None})
print(json.dumps(result))
"""


def python_with_vtk():
    for python in (sys.executable, "/usr/bin/python3"):
        try:
            probe = subprocess.run([python, "-c", "import vtkmodules.vtkIOHDF, vtkmodules.vtkIOXML"],
                                   capture_output=True, check=False)
        except OSError:
            continue
        if probe.returncode == 0:
            return python
    return None


PYTHON = python_with_vtk()


@unittest.skipUnless(PYTHON, "VTK's Python modules are not there (Debian: python3-vtk9)")
class Vtk(ProgramTest):
    def by_vtk(self, *files):
        done = subprocess.run([PYTHON, "-c", READER, *files], capture_output=True, text=True, check=False)
        self.assertEqual(done.returncode, 0, done.stderr)
        result = json.loads(done.stdout.splitlines()[-1])
        return result["version"], result["files"]

    def test_contacts(self):
        target = self.path("contacts.vtp")
        header, *rows = self.contacts("--vtk", target)
        _, (read,) = self.by_vtk(target)
        self.assertEqual(read["messages"], [])
        self.assertEqual((len(read["points"]), read["cells"], set(read["types"])), (len(rows), len(rows), {1}))
        data = read["point_data"]
        info = json.loads(self.good("info", self.sequence, "--json"))
        time = {step["step"]: step["time"] for step in info["steps"]}
        time[info["frames"] - 1] = info["end_time"]
        for i, row in enumerate(rows):
            row = dict(zip(header, row))
            number = lambda *names: [float(row[name]) for name in names]
            self.assertEqual(read["points"][i], number("px", "py", "pz"))
            self.assertEqual(data["Normal"][i], number("nx", "ny", "nz"))
            self.assertEqual(data["VertexIds"][i], number("a", "b", "c", "d"))
            for array, name in (("Step", "step"), ("TimeOfImpact", "toi"), ("AtStart", "at_start"), ("Object1", "object_1"),
                                ("Object2", "object_2"), ("Element1", "element_1"), ("Element2", "element_2")):
                self.assertEqual(data[array][i], number(name), array)
            self.assertEqual(data["Kind"][i], [["VF", "EE"].index(row["kind"])])
            step = int(row["step"])
            at = time[step] + float(row["toi"]) * (time[step + 1] - time[step])
            self.assertTrue(math.isclose(data["Time"][i][0], at, rel_tol=1e-12))

    def expected_features(self, rows):
        """By step: each feature in contact with its number of contacts, first time, parts."""
        steps = {}
        for row in rows:
            ids = [int(row[name]) for name in "abcd"]
            split = 1 if row["kind"] == "VF" else 2
            for feature, side in ((ids[:split], "1"), (ids[split:], "2")):
                of = steps.setdefault(int(row["step"]), {}).setdefault(tuple(feature), [0, 2.0, row["object_" + side]])
                of[0], of[1] = of[0] + 1, min(of[1], float(row["toi"]))
        return steps

    def check_series(self, series, rows, times, points, number=1):
        """Compares the files of a series with the rows of contacts.csv. `points`: those of each frame."""
        entries = [(float(entry.get("timestep")), entry.get("file")) for entry in ET.parse(series).getroot().iter("DataSet")]
        self.assertEqual([time for time, _ in entries], times)
        stem = os.path.basename(series)[:-4]
        self.assertEqual([name for _, name in entries], [f"{stem}_{k:04}.vtp" for k in range(number - 1, number - 1 + len(times))])
        _, read = self.by_vtk(*(self.path(name) for _, name in entries))
        self.assertEqual((read[0]["points"], read[0]["cells"]), ([], 0))
        expected = self.expected_features(rows)
        for k, one in enumerate(read[1:], number):
            self.assertEqual(one["messages"], [])
            ids, data = [int(v) for (v,) in one["point_data"]["VertexIds"]], one["cell_data"]
            self.assertEqual(one["points"], [points[k][v] for v in ids])
            found = {}
            for i, corners in enumerate(one["corners"]):
                self.assertEqual((one["types"][i], data["Feature"][i]), ({1: 1, 2: 3, 3: 5}[len(corners)], [len(corners) - 1]))
                found[tuple(ids[v] for v in corners)] = [data["Contacts"][i][0], data["TimeOfImpact"][i][0],
                                                         str(int(data["Object"][i][0]))]
                at = times[k - number] + data["TimeOfImpact"][i][0] * (times[k - number + 1] - times[k - number])
                self.assertTrue(math.isclose(data["Time"][i][0], at, rel_tol=1e-12, abs_tol=1e-12))
            self.assertEqual(found, expected.get(k - 1, {}))

    def test_features_over_time(self):
        series = self.path("touching.pvd")
        header, *rows = self.contacts("--vtk", series)
        rows = [dict(zip(header, row)) for row in rows]
        info = json.loads(self.good("info", self.sequence, "--json"))
        times = [step["time"] for step in info["steps"]] + [info["end_time"]]
        self.good("scene", "export", self.sequence, "-o", self.path("frame.vtkhdf"))
        _, frames = self.by_vtk(*(self.path(f"frame_{k:04}.vtkhdf") for k in range(len(times))))
        points = [frame["points"] for frame in frames]
        self.check_series(series, rows, times, points)
        header, *some = self.contacts("--vtk", series, "--steps", "2:4")
        self.check_series(series, [dict(zip(header, row)) for row in some], times[2:5], points, number=3)
        os.mkfifo(self.path("pipe.pvd"))
        self.bad("detect", self.sequence, "--vtk", self.path("pipe.pvd"), says="a series has a file for each step beside it")

    def test_a_series_that_ends_early(self):
        damaged = self.path("damaged.vtkhdf")
        with open(self.sequence, "rb") as file:
            data = file.read()
        with open(damaged, "wb") as file:
            file.write(with_bad_last_step(data))
        for substeps in (1, 2):
            done = run("detect", damaged, "--vtk", self.path("early.pvd"), "--substeps", str(substeps), "--contacts",
                       self.path("early.csv"))
            self.assertEqual(done.returncode, 2, done.stderr)
            with open(self.path("early.pvd"), encoding="ascii") as file:
                text = file.read()
            last = int(re.search(r"<!-- incomplete: steps 0 to (\d+) of", text)[1])
            self.assertEqual(last % substeps, substeps - 1)
            self.assertEqual(text.count("<DataSet"), last + 2)
            with open(self.path("early.csv"), encoding="ascii") as file:
                *rows, mark = file.read().splitlines()[1:]
            self.assertIn(f"# incomplete: steps 0 to {last} of", mark)
            self.assertEqual(rows, [",".join(row) for row in self.contacts("--substeps", str(substeps))[1:]
                                    if int(row[0]) <= last])

    def test_no_contacts(self):
        target = self.path("none.vtp")
        self.good("detect", self.sequence, "--pairs", "intra", "--vtk", target)
        _, (read,) = self.by_vtk(target)
        self.assertEqual((read["messages"], read["points"], read["cells"]), ([], [], 0))

    def test_single_steps(self):
        """The files can also be read with VTK 9.1, the version in Debian 12."""
        shown = self.good("scene", "export", self.sequence, "--frames", "1:4", "-o", self.path("step.vtkhdf"))
        self.assertIn("3 frames written", shown)
        self.assertIn("1 frame written", self.good("scene", "export", self.sequence, "--frames", "0", "-o", self.path("one.vtkhdf")))
        files = [self.path(f"step_{k:04}.vtkhdf") for k in (1, 2, 3)]
        _, read = self.by_vtk(*files)
        info = json.loads(self.good("info", self.sequence, "--json"))
        for step, name, one in zip((1, 2, 3), files, read):
            self.assertEqual(one["messages"], [])
            self.assertEqual(one["field_data"]["TimeValue"], [[info["steps"][step]["time"]]])
            same = json.loads(self.good("info", name, "--json"))
            self.assertEqual((len(one["points"]), one["cells"]),
                             (same["points"], sum(same["frame_0"]["elements"].values())))
            self.assertEqual(set(one["types"]), {12})
            self.assertEqual([ids[0] for ids in one["point_data"]["GlobalPointIds"]], list(range(same["points"])))
            parts = [part for (part,) in one["cell_data"]["PartId"]]
            self.assertEqual({part: parts.count(part) for part in set(parts)},
                             {one["object"]: one["elements"] for one in same["frame_0"]["objects"]})
        # The contacts of motion 1 lie within the boxes of its two ends.
        rows = [row for row in self.contacts("--steps", "1")[1:]]
        both = read[0]["points"] + read[1]["points"]
        for axis in range(3):
            low, high = (extreme(point[axis] for point in both) for extreme in (min, max))
            self.assertTrue(all(low - 1e-9 <= float(row[10 + axis]) <= high + 1e-9 for row in rows))

    def test_sequences(self):
        version, (read,) = self.by_vtk(self.sequence)
        if version < [9, 3]:
            self.skipTest(f"VTK {version[0]}.{version[1]} does not know temporal VTKHDF (9.3 does): see `scene export`")
        info = json.loads(self.good("info", self.sequence, "--json"))
        self.assertEqual((read["messages"], read["steps"]), ([], info["frames"]))
        self.assertEqual(read["cells"], sum(info["frame_0"]["elements"].values()))

    def test_what_is_refused(self):
        self.bad("scene", "export", self.sequence, "--frames", "9", "-o", self.path("x.vtkhdf"), says="--frames")
        self.bad("scene", "export", self.sequence, "-o", self.path("no/x.vtkhdf"), says="no/x_0000.vtkhdf")


if __name__ == "__main__":
    unittest.main()
