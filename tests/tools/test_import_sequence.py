"""tools/import_sequence.py on files that other programs wrote (data/README.md), read back by `volccd` and by h5py."""

import os
import resource
import shutil
import signal
import subprocess
import sys
import unittest
import unittest.mock

from import_support import Importer, TOOL, VOLCCD, data, import_sequence

import numpy as np


class Files(Importer):
    def check_boxes(self, grid, parts, ids_kept=True):
        self.assertEqual(grid["NumberOfPoints"][:].tolist(), [22])
        self.assertEqual(grid["Types"][:].tolist(), [10] * 24 + [12])
        first = 25 if ids_kept else 0
        self.assertEqual(grid["CellData/GlobalCellIds"][:].tolist(), list(range(first, first + 25)))
        self.assertEqual(grid["PointData/GlobalPointIds"][:].tolist(), list(range(int(ids_kept), 22 + int(ids_kept))))
        self.assertEqual(grid["CellData/PartId"][:].tolist(), [parts[0]] * 24 + [parts[1]])
        points, cells = grid["Points"][:], grid["Connectivity"][:96].reshape(-1, 4)
        corners = points[cells]
        volumes = np.linalg.det(corners[:, 1:] - corners[:, :1]) / 6
        self.assertAlmostEqual(np.abs(volumes).sum(), 1, places=5)
        self.assertAlmostEqual(np.ptp(points[grid["Connectivity"][96:]], axis=0).prod(), 1, places=5)
        self.assertIn("24 triangles and quads that are faces", self.said)

    def test_gmsh(self):
        for name, kept in (("boxes_22.msh", True), ("boxes_41.msh", True), ("boxes_41b.msh", False)):
            with self.subTest(name):
                self.check_boxes(self.good(*data(name)), (7, 9), ids_kept=kept)
                self.assertRegex(self.info, r"object 7 +24  soft body\n +object 9 +1  plate")

    def test_faces_are_kept_on_request(self):
        grid = self.good(*data("boxes_41.msh"), "--keep-faces")
        self.assertEqual(grid["Types"][:].tolist(), [5] * 24 + [10] * 24 + [12])
        self.assertRegex(self.info, r"object 20 +24  skin")

    def test_abaqus(self):
        self.check_boxes(self.good(*data("boxes.inp")), (1, 2))
        self.assertRegex(self.info, r"object 1 +24  soft_body\n +object 2 +1  plate")
        self.check_boxes(self.good(*data("boxes.inp"), "--sets", "plate,soft_body"), (2, 1))
        self.bad(*data("boxes.inp"), "--sets", "wheel", says="no set 'wheel'; there is: Surface1")

    def test_abaqus_sets_of_mixed_cells_and_overlapping_sets(self):
        nodes = "".join(f"{10 + i}, {i & 1}, {i >> 1 & 1}, {i >> 2}\n" for i in range(8))
        cells = "*ELEMENT, TYPE=C3D4, ELSET=body\n3, 10, 11, 12, 14\n1, 17, 16, 15, 13\n" \
                "*ELEMENT, TYPE=C3D8, ELSET=body\n7, 10, 11, 13, 12,\n14, 15, 17, 16\n"
        grid = self.good(self.path("a.inp", f"*NODE\n{nodes}{cells}"))
        self.assertEqual(grid["CellData/GlobalCellIds"][:].tolist(), [3, 1, 7])
        self.assertEqual(grid["CellData/PartId"][:].tolist(), [1, 1, 1])
        self.bad(self.path("b.inp", f"*NODE\n{nodes}{cells}*ELSET, ELSET=some, GENERATE\n1, 3, 2\n"),
                 says="element 3 is in 'body' and in 'some'")

    TETRAHEDRON = "1, 0, 0, 0\n2, 1, 0, 0\n** a comment\n3, 0, 1, 0\n", "4, 0, 0, 1\n", "*ELEMENT, TYPE=C3D4\n7, 1, 2, 3, 4\n"

    def test_abaqus_nodes_in_several_blocks_and_files(self):
        nodes, more, element = self.TETRAHEDRON
        self.path("more.inc", f"*Node, nset=More\n{more}")
        for text in (f"*NODE\n{nodes}*NODE, NSET=more\n{more}{element}", f"*NODE\n{nodes}{element}*Node\n{more}",
                     f"*NODE\n{nodes}*INCLUDE, INPUT=more.inc\n{element}",
                     f"*Part, name=A\n*Node\n{nodes}*Node\n{more}{element}*End Part\n*Assembly, name=All\n"
                     "*Instance, name=A-1, part=A\n*End Instance\n*End Assembly\n"):
            grid = self.good(self.path("a.inp", text))
            self.assertEqual(grid["Points"][:].tolist(), [[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1]], text)
            self.assertEqual(grid["PointData/GlobalPointIds"][:].tolist(), [1, 2, 3, 4])
            self.assertEqual(grid["CellData/GlobalCellIds"][:].tolist(), [7])
            self.assertEqual(grid["Connectivity"][:].tolist(), [0, 1, 2, 3])

    def test_abaqus_decks_that_mean_another_mesh(self):
        nodes, more, element = self.TETRAHEDRON
        part = f"*Part, name=A\n*Node\n{nodes}{more}{element}*End Part\n"
        for text, says in (
                (part + part.replace("=A", "=B"), "*Part: 2 parts, and no *Instance says where they are"),
                (part + "*Instance, name=A-1, part=B\n*End Instance\n", "*Instance: A-1: no part 'B'; there is: A"),
                (part + "*Instance, library=old, instance=A-1\n*End Instance\n", "instances of earlier analyses are not read"),
                (part + "*Instance, name=A-1, part=A\n0., 0., 2.\n0, 0, 0, 0, 0, 0, 90\n*End Instance\n",
                 "*Instance: the two points of the axis of rotation are one"),
                (part + "*Instance, name=A-1, part=A\n0., 0.\n*End Instance\n", "*Instance: its data are 3 numbers"),
                (f"*NODE\n{nodes}{more}*ELEMENT, TYPE=AC3D4\n7, 1, 2, 3, 4\n", "*Element: type 'AC3D4' is not supported"),
                (f"*NODE\n{nodes}{more}*ELEMENT, TYPE=C3D4\n7, 1, 2, 3\n", "element 7 has 3 nodes, its type has 4"),
                (f"*NODE\n{nodes}{more}*ELEMENT, TYPE=C3D4\n7, 1, 2, 3, 5\n", "element 7 has node 5, which is not there"),
                (f"*NODE\n{nodes}*NODE\n{nodes}{more}{element}", "*Node: node 1 is there twice"),
                (f"*NODE, SYSTEM=C\n{nodes}{more}{element}", "'*NODE, SYSTEM=C' is not supported"),
                (f"*NODE\n{nodes}{more}{element}*ELCOPY, OLD SET=a\n", "'*ELCOPY, OLD SET=a' is not supported"),
                ("*INCLUDE, INPUT=none.inc\n", "*Include: no such file"), ("*INCLUDE, INPUT=a.inp\n", "includes itself")):
            self.bad(self.path("a.inp", text), says=says)

    def test_displacements(self):
        def file(*names):
            vectors = "".join(f"VECTORS {name} double\n0 0 0\n0 0 0.5\n0 0 0\n" for name in names)
            return self.path("a.vtk", "# vtk DataFile Version 3.0\n\nASCII\nDATASET UNSTRUCTURED_GRID\nPOINTS 3 double\n"
                             "0 0 0\n1 0 0\n0 1 0\nCELLS 1 4\n3 0 1 2\nCELL_TYPES 1\n5\nPOINT_DATA 3\n" + vectors)

        for name in ("disp", "Displacement", "U", "NodeDisplacements", "u_x"):
            self.bad(file(name), says=f"displacement: the points have '{name}': give --displacement {name} to add it to the "
                     "points, or --displacement none")
            self.assertEqual(self.good(file(name), "--displacement", name)["Points"][:, 2].tolist(), [0, 0.5, 0])
            self.assertIn(f"{name} is added to the points", self.said)
            self.assertEqual(self.good(file(name), "--displacement", "none")["Points"][:, 2].tolist(), [0, 0, 0])
        self.bad(file("disp", "U"), says="'disp', 'U': give --displacement NAME")
        self.good(file("U"), "--velocity", "U")
        self.good(file("dispersion", "Normals"))
        self.bad(file("disp"), "--displacement", "d", says="displacement: no array 'd'; there is: disp")
        self.bad(file("Displacement"), "--displacement", "displacements", says="did you mean 'Displacement'?")

    def test_nastran(self):
        self.check_boxes(self.good(*data("boxes.bdf")), (1, 2))

    def test_steps_with_ids_in_another_order_and_cells_that_go(self):
        files = data("cells_1.vtu", "cells_10.vtu", "cells_2.vtu")
        grid = self.good(*files, "--sort", "natural", "--dt", "0.5", "--units", "m", "--time-unit", "second")
        self.assertEqual(grid["Steps/Values"][:].tolist(), [0, 0.5, 1])
        self.assertEqual(grid["Steps/PartOffsets"][:].tolist(), [0, 0, 1])
        self.assertEqual(grid["NumberOfCells"][:].tolist(), [4, 3])
        self.assertEqual(grid["CellData/GlobalCellIds"][:].tolist(), [100, 101, 102, 103, 100, 102, 103])
        self.assertEqual(grid["CellData/PartId"][:].tolist(), [1, 2, 1, 2, 1, 1, 2])
        self.assertEqual(grid["PointData/GlobalPointIds"][:].tolist(), list(range(10, 33)))
        points = grid["Points"][:].reshape(3, 23, 3)
        for step in (1, 2):
            self.assertTrue((points[step] == points[0] + [0.5 * step, 0, 0]).all())
        velocity = grid["PointData/Velocity"][:].reshape(3, 23, 3)
        self.assertTrue((velocity == np.column_stack([np.full(23, 0.25), np.zeros(23), np.arange(23)])).all())
        self.assertIn("second", self.info)
        self.assertRegex(self.info, r"hexahedron +1\n +wedge +1\n +pyramid +1")
        detected = subprocess.run([VOLCCD, "detect", self.target], capture_output=True, text=True, check=False)
        self.assertEqual(detected.returncode, 0, detected.stderr)

    def test_order_of_files(self):
        files = data("cells_1.vtu", "cells_10.vtu", "cells_2.vtu")
        self.bad(*files, says="give --sort natural, or --sort given")
        self.assertEqual(self.good(*files, "--sort", "given")["Steps/PartOffsets"][:].tolist(), [0, 1, 2])

    def test_legacy_vtk(self):
        grid = self.good(*data("legacy_42.vtk", "legacy_51.vtk"), "--times", "0,0.25")
        self.assertEqual(grid["Types"][:].tolist(), [10, 12, 13, 14])
        self.assertEqual(grid["CellData/GlobalCellIds"][:].tolist(), [100, 101, 102, 103])
        self.assertEqual(grid["PointData/GlobalPointIds"][:].tolist(), list(range(10, 33)))
        points = grid["Points"][:].reshape(2, 23, 3)
        self.assertTrue((points[1] == points[0] + [1, 0, 0]).all())
        self.assertTrue((grid["PointData/Velocity"][:, 2] == np.tile(np.arange(23), 2)).all())

    def test_surfaces(self):
        grid = self.good(*data("cube.ply", "cube_moved.ply"), "--thickness", "0.01")
        self.assertEqual(grid["Types"][:].tolist(), [5] * 12)
        points = grid["Points"][:].reshape(2, 8, 3)
        self.assertTrue((points[1] == points[0] + [0.25, 0, 0]).all())
        self.assertTrue((grid["CellData/Thickness"][:] == 0.01).all())
        self.assertEqual(self.good(*data("cube.obj"))["NumberOfCells"][:].tolist(), [12])

    def test_points_that_come_and_go(self):
        def file(name, nodes, triangle):
            lines = "".join(f"{i}, {x}, 0, {y}\n" for i, x, y in nodes)
            return self.path(name, f"*NODE\n{lines}*ELEMENT, TYPE=S3\n{triangle}\n")

        grid = self.good(file("0.inp", [(1, 0, 0), (2, 1, 0), (3, 0, 1)], "5, 1, 2, 3"),
                         file("1.inp", [(4, 9, 9), (2, 2, 0), (1, 1, 0)], "6, 4, 2, 1"))
        self.assertEqual(grid["PointData/GlobalPointIds"][:].tolist(), [1, 2, 3, 4])
        self.assertEqual(grid["Points"][:].tolist(), [[0, 0, 0], [1, 0, 0], [0, 0, 1], [9, 0, 9],
                                                      [1, 0, 0], [2, 0, 0], [0, 0, 1], [9, 0, 9]])
        self.assertEqual(grid["Connectivity"][:].tolist(), [0, 1, 2, 3, 1, 0])

    def test_wedges_as_hexahedra(self):
        """Two bodies of wedges, of which the second falls onto the first; as C3D6, and as C3D8 with repeated nodes."""
        def deck(name, drop, as_hexahedra):
            nodes, elements = [], []
            for body in range(2):
                first = len(nodes) + 1
                for z, y, x in ((z, y, x) for z in range(2) for y in range(3) for x in range(3)):
                    nodes.append((x + 0.3 * body, y + 0.2 * body, z + body * (1.5 - drop)))
                for y, x in ((y, x) for y in range(2) for x in range(2)):
                    a = first + 3 * y + x
                    base = [a, a + 1, a + 4, a + 3]
                    for i, j, k in ((0, 2, 1), (0, 3, 2)):
                        low = [base[i], base[j], base[k]]
                        low += low[2:] if as_hexahedra else []
                        elements.append(low + [node + 9 for node in low])
            lines = ["*NODE", *(f"{i + 1}, {x}, {y}, {z}" for i, (x, y, z) in enumerate(nodes)),
                     f"*ELEMENT, TYPE={'C3D8' if as_hexahedra else 'C3D6'}",
                     *(f"{100 + i}, {', '.join(map(str, element))}" for i, element in enumerate(elements))]
            return self.path(name, "\n".join(lines) + "\n")

        contacts = {}
        for as_hexahedra in (False, True):
            grid = self.good(deck("0.inp", 0, as_hexahedra), deck("1.inp", 1, as_hexahedra))
            self.assertEqual(set(grid["Types"][:].tolist()), {12 if as_hexahedra else 13})
            self.assertRegex(self.info, r"wedge +16\n")
            self.assertEqual("nodes repeat, read as: 16 hexahedra as wedges" in self.info, as_hexahedra)
            for extra in ((), ("--edges", "polytope"), ("--pairs", "inter", "--objects", "components")):
                target = self.path("contacts.csv")
                done = subprocess.run([VOLCCD, "detect", self.target, "--contacts", target, *extra], capture_output=True,
                                      text=True, check=False)
                self.assertEqual((done.returncode, done.stderr), (0, ""))
                with open(target, encoding="ascii") as file:
                    contacts[as_hexahedra, extra] = file.read()
                self.assertGreater(contacts[as_hexahedra, extra].count("\n"), 20)
        for as_hexahedra, extra in contacts:
            self.assertEqual(contacts[as_hexahedra, extra], contacts[False, extra])
        made = subprocess.run([VOLCCD, "scene", "generate", "deform", "--mesh", self.target, "--motion", "twist", "-o",
                               self.path("twist.vtkhdf")], capture_output=True, text=True, check=False)
        self.assertEqual(made.returncode, 0, made.stderr)

    def test_as_a_program(self):
        for arguments, code in ((data("cube.obj"), 0), (data("polyhedron.vtu"), 2), (["--help"], 0), (["--nonsense"], 2)):
            done = subprocess.run([sys.executable, TOOL, *arguments, "-o", self.target], capture_output=True, check=False)
            self.assertEqual(done.returncode, code, done.stderr)

    def test_what_is_refused(self):
        self.bad(*data("polyhedron.vtu"), says="1 polyhedron4: not supported")
        self.bad(self.path("none.vtu"), says="none.vtu: no such file")
        self.bad(self.path("a.xyz", "solid\n"), says="unknown extension '.xyz'")
        self.bad(self.path("junk.vtk", "junk\n"), says="junk.vtk: meshio cannot read it as vtk")
        self.bad(*data("cells_1.vtu", "cells_2.vtu"), "--times", "1", says="1 times for 2 frames")
        self.bad(*data("cells_1.vtu", "cells_2.vtu"), "--times", "1,1", says="time[1]: 1.0 is not finite or not after")
        self.bad(*data("cells_1.vtu"), "--part", "Colour", says="no array 'Colour'; there is: ElementId, PartId")
        self.bad(*data("cells_1.vtu", "cells_10.vtu"), "--cell-ids", "none", says="there are no cell ids")
        self.bad(*data("cells_1.vtu", "cube.ply"), says="cube.ply: point ids: not given here but in the first file")
        self.bad(self.path("a.obj", "v 0 0 0\nv 1 0 0\nv 0 nan 0\nf 1 2 3\n"), says="points[2]: not a finite number")
        self.bad(self.path("b.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\nf 1 2 4\n"), says="cells[1]: uses point 3 of 3")
        self.bad(self.path("c.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 2\n"), says="cells[0]: has 2 distinct vertices")
        self.bad(self.path("d.inp", "*NODE\n1, 0, 0, 0\n2, 1, 0, 0\n3, 0, 1, 0\n*ELEMENT, TYPE=S3\n7, 1, 2, 3\n7, 3, 2, 1\n"),
                 says="cell ids[1]: 7 is there twice")

    def read(self, file):
        with open(file, "rb") as stream:
            return stream.read()

    def test_the_output_is_no_input_and_links_stay(self):
        source = self.path("in.vtu")
        shutil.copy(*data("cells_1.vtu"), source)
        os.link(source, self.path("hard.vtu"))
        os.symlink("in.vtu", self.path("soft.vtu"))
        for name in ("in.vtu", "hard.vtu", "soft.vtu"):
            self.target = self.path(name)
            self.bad(source, says="is the input")
        self.assertEqual(self.read(source), self.read(*data("cells_1.vtu")))
        os.mkfifo(self.path("fifo"))
        for name, says in (("-", "not a regular file"), ("/dev/fd/1", "not a regular file"),
                           (self.path("fifo"), "not a regular file"), (self.folder, "folder"),
                           (self.path("no/such"), "no/such: cannot be written: No such file or directory")):
            self.target = name
            self.bad(source, says=says)
        with open(self.path("report"), "w", encoding="ascii") as report:
            done = subprocess.run([sys.executable, TOOL, source, "-o", "/dev/fd/1"], stdout=report, stderr=subprocess.PIPE,
                                  text=True, check=False)
        self.assertEqual(done.returncode, 2, done.stderr)
        os.symlink("there.vtkhdf", self.path("link.vtkhdf"))
        self.target = self.path("link.vtkhdf")
        for _ in range(2):
            self.good(source)
            self.assertTrue(os.path.islink(self.target))
            self.assertTrue(os.path.isfile(self.path("there.vtkhdf")))

    def test_full_disk_and_ctrl_c_leave_what_was_there(self):
        self.path("out.vtkhdf", "old")

        def limit(size):
            signal.signal(signal.SIGXFSZ, signal.SIG_IGN)
            resource.setrlimit(resource.RLIMIT_FSIZE, (size, size))
        for size in (0, 1000, 4000):
            done = subprocess.run([sys.executable, TOOL, *data("cells_1.vtu"), "-o", self.target], capture_output=True,
                                  text=True, check=False, preexec_fn=lambda size=size: limit(size))
            self.assertEqual((done.returncode, done.stderr),
                             (2, f"volccd-import: {self.target}: cannot be written: File too large\n"))
        with unittest.mock.patch.object(import_sequence, "read_frame", side_effect=KeyboardInterrupt):
            done = self.run_tool(*data("cells_1.vtu"))
        self.assertEqual((done.returncode, "interrupted" in done.stderr), (130, True))
        self.assertEqual(os.listdir(self.folder), ["out.vtkhdf"])
        self.assertEqual(self.read(self.target), b"old")


if __name__ == "__main__":
    unittest.main()
