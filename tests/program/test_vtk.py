"""VTK reads the files that are written: contacts (.vtp), single steps, and sequences. Skipped if Python has no VTK
(python3-vtk9)."""

import json
import math
import subprocess
import sys
import unittest

from program_support import ProgramTest

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
        time = {motion["motion"]: motion["time"] for motion in info["motions"]}
        time[info["steps"] - 1] = info["end_time"]
        for i, row in enumerate(rows):
            row = dict(zip(header, row))
            number = lambda *names: [float(row[name]) for name in names]
            self.assertEqual(read["points"][i], number("px", "py", "pz"))
            self.assertEqual(data["Normal"][i], number("nx", "ny", "nz"))
            self.assertEqual(data["VertexIds"][i], number("a", "b", "c", "d"))
            for array, name in (("Step", "step"), ("TimeOfImpact", "toi"), ("AtStart", "at_start"), ("Part1", "part_1"),
                                ("Part2", "part_2"), ("Element1", "element_1"), ("Element2", "element_2")):
                self.assertEqual(data[array][i], number(name), array)
            self.assertEqual(data["Kind"][i], [["VF", "EE"].index(row["kind"])])
            step = int(row["step"])
            at = time[step] + float(row["toi"]) * (time[step + 1] - time[step])
            self.assertTrue(math.isclose(data["Time"][i][0], at, rel_tol=1e-12))

    def test_no_contacts(self):
        target = self.path("none.vtp")
        self.good("detect", self.sequence, "--pairs", "intra", "--vtk", target)
        _, (read,) = self.by_vtk(target)
        self.assertEqual((read["messages"], read["points"], read["cells"]), ([], [], 0))

    def test_single_steps(self):
        """The files can also be read with VTK 9.1, the version in Debian 12."""
        shown = self.good("scene", "export", self.sequence, "--steps", "1:4", "-o", self.path("step.vtkhdf"))
        self.assertIn("3 frame(s)", shown)
        files = [self.path(f"step_{k:04}.vtkhdf") for k in (1, 2, 3)]
        _, read = self.by_vtk(*files)
        info = json.loads(self.good("info", self.sequence, "--json"))
        for step, name, one in zip((1, 2, 3), files, read):
            self.assertEqual(one["messages"], [])
            self.assertEqual(one["field_data"]["TimeValue"], [[info["motions"][step]["time"]]])
            same = json.loads(self.good("info", name, "--json"))
            self.assertEqual((len(one["points"]), one["cells"]),
                             (same["points"], sum(same["step_0"]["elements"].values())))
            self.assertEqual(set(one["types"]), {12})
            self.assertEqual([ids[0] for ids in one["point_data"]["GlobalPointIds"]], list(range(same["points"])))
            parts = [part for (part,) in one["cell_data"]["PartId"]]
            self.assertEqual({part: parts.count(part) for part in set(parts)},
                             {part["part"]: part["elements"] for part in same["step_0"]["parts"]})
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
        self.assertEqual((read["messages"], read["steps"]), ([], info["steps"]))
        self.assertEqual(read["cells"], sum(info["step_0"]["elements"].values()))

    def test_what_is_refused(self):
        self.bad("scene", "export", self.sequence, "--steps", "9", "-o", self.path("x.vtkhdf"), says="--steps")
        self.bad("scene", "export", self.sequence, "-o", self.path("no/x.vtkhdf"), says="no/x_0000.vtkhdf")


if __name__ == "__main__":
    unittest.main()
