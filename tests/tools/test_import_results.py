"""tools/import_sequence.py on results with several frames, assemblies and elements of higher order. The files are written here
by the programs concerned where Debian has them: CalculiX, VTK, meshio."""

import os
import shutil
import subprocess
import sys
import unittest

from import_support import HERE, TOOL, VOLCCD, Importer, data

import meshio
import netCDF4
import numpy as np
import vtk

from d3plot_file import write_d3plot

CUBE = np.array([(0, 0, 0), (1, 0, 0), (1, 1, 0), (0, 1, 0), (0, 0, 1), (1, 0, 1), (1, 1, 1), (0, 1, 1)], float)
FALL = [0.0, 0.75, 1.5]  # how far the upper cube has fallen in each frame; its bottom is at z = 2


def grid(cells, arrays=None, points=CUBE, cell_arrays=None):
    """A grid of VTK from (type, corners) and arrays."""
    result, places = vtk.vtkUnstructuredGrid(), vtk.vtkPoints()
    places.SetDataTypeToDouble()
    for point in points:
        places.InsertNextPoint(point)
    result.SetPoints(places)
    for kind, corners in cells:
        result.InsertNextCell(kind, len(corners), corners)
    for data_of, given in ((result.GetPointData(), arrays or {}), (result.GetCellData(), cell_arrays or {})):
        for name, values in given.items():
            values = np.asarray(values)
            array = vtk.vtkDoubleArray() if values.dtype.kind == "f" else vtk.vtkIdTypeArray()
            array.SetName(name)
            array.SetNumberOfComponents(values.shape[1] if values.ndim == 2 else 1)
            for row in values.reshape(len(values), -1):
                array.InsertNextTuple(row)
            data_of.AddArray(array)
    return result


def write_vtu(path, data_set):
    writer = vtk.vtkXMLUnstructuredGridWriter()
    writer.SetFileName(path)
    writer.SetInputData(data_set)
    writer.SetDataModeToAscii()
    writer.Write()


def two_cubes(fall=0.0):
    return np.concatenate([CUBE, CUBE + [0.25, 0.25, 2 - fall]])


HEXAHEDRA = [list(range(8)), list(range(8, 16))]


class Results(Importer):
    def check_fall(self, target_points=16, times=(0, 0.5, 1.0), objects=(1, 2)):
        """The upper cube touches the lower one in step 1, and not before."""
        file = self.opened["VTKHDF"]
        self.assertEqual(file["Steps/Values"][:].tolist(), list(times))
        self.assertEqual(file["Types"][:].tolist(), [12, 12])
        self.assertEqual(file["CellData/PartId"][:].tolist(), list(objects))
        points = file["Points"][:].reshape(3, target_points, 3)
        for k, fall in enumerate(FALL):
            np.testing.assert_allclose(points[k], two_cubes(fall), atol=1e-6)
        for step, contacts in ((0, 0), (1, 1)):
            done = subprocess.run([VOLCCD, "detect", self.target, "--steps", str(step), "--pairs", "inter", "--contacts", "-",
                                   "--quiet"], capture_output=True, text=True, check=False)
            self.assertEqual(done.returncode, 0, done.stderr)
            self.assertEqual(min(done.stdout.count("\n") - 1, 1), contacts)

    def good(self, *arguments):
        result = super().good(*arguments)
        self.opened = result.file
        return result

    # ---- Abaqus

    def deck(self, instances, sets=""):
        nodes = "".join(f"{10 * (i + 1)}, {x}, {y}, {z}\n" for i, (x, y, z) in enumerate(CUBE))
        part = f"*Part, name=Cube\n*Node\n{nodes}*Element, type=C3D8R, elset=All\n5, " \
               f"{', '.join(str(10 * (i + 1)) for i in range(8))}\n*Element, type=MASS\n6, 10\n*End Part\n"
        text = "".join(f"*Instance, name={name}, part=CUBE\n{place}*End Instance\n" for name, place in instances)
        return self.path("job.inp", f"{part}*Assembly, name=A\n{text}*Node\n1, 0, 0, 0\n{sets}*End Assembly\n")

    def test_an_assembly(self):
        deck = self.deck([("low", ""), ("high", "0., 0., 2.\n"), ("turned", "3., 0., 0.\n3., 0., 0., 3., 0., 1., 90.\n")],
                         sets="*Elset, elset=Chosen, instance=high\n5,\n")
        grid_read = self.good(deck)
        self.assertEqual(grid_read["Types"][:].tolist(), [12] * 3)
        self.assertEqual(grid_read["PointData/GlobalPointIds"][:].tolist(), [k * 80 + 10 * i for k in range(3) for i in range(1, 9)])
        self.assertEqual(grid_read["CellData/GlobalCellIds"][:].tolist(), [5, 10, 15])
        self.assertEqual(grid_read["CellData/PartId"][:].tolist(), [1, 2, 3])
        self.assertRegex(self.info, r"object 1 +1  low\n +object 2 +1  high\n +object 3 +1  turned")
        self.assertIn("instance high: node numbers + 80, element numbers + 5", self.said)
        self.assertIn("1 elements without a surface (springs, beams, ..) are left out", self.said)
        points = grid_read["Points"][:].reshape(3, 8, 3)
        np.testing.assert_allclose(points[0], CUBE)
        np.testing.assert_allclose(points[1], CUBE + [0, 0, 2])
        # x becomes y, and y becomes -x, about the z axis through (3, 0, 0).
        np.testing.assert_allclose(points[2], np.column_stack([3 - CUBE[:, 1], CUBE[:, 0], CUBE[:, 2]]), atol=1e-15)
        self.assertEqual(self.good(deck, "--sets", "turned.All,Chosen")["CellData/PartId"][:].tolist(), [0, 2, 1])
        self.bad(deck, "--sets", "turned.Al", says="did you mean 'turned.All'?")

    def test_instances_with_nodes_of_their_own_and_sets_of_sets(self):
        nodes = "".join(f"{i + 1}, {x}, {y}, {z}\n" for i, (x, y, z) in enumerate(CUBE))
        element = "*Element, type=C3D8\n1, 1, 2, 3, 4, 5,\n 6, 7, 8\n*Elset, elset=One\n1,\n*Elset, elset=Both\none\n"
        text = "*Part, name=Empty\n*End Part\n*Assembly, name=A\n" + "".join(
            f"*Instance, name=I{k}, part=Empty\n0., 0., {2 * k}.\n*Node\n{nodes}{element}*End Instance\n" for k in (0, 1))
        read = self.good(self.path("a.inp", text + "*End Assembly\n"), "--sets", "I1.Both")
        self.assertEqual(read["CellData/PartId"][:].tolist(), [0, 1])
        np.testing.assert_allclose(read["Points"][8:], CUBE + [0, 0, 2])

    # ---- elements of higher order

    def test_elements_of_higher_order_by_their_corners(self):
        read = self.good(*data("boxes_order2.msh"))
        self.assertEqual((read["Types"][:].tolist(), read["NumberOfPoints"][:].tolist()), ([10] * 24 + [12], [22]))
        self.assertEqual(read["CellData/PartId"][:].tolist(), [7] * 24 + [9])
        self.assertRegex(self.said, r"24 triangle6, 24 tetra10, 1 hexahedron27: taken as straight, by their corners; \d+ middle nodes")
        corners = read["Points"][:][read["Connectivity"][:96].reshape(-1, 4)]
        self.assertAlmostEqual(np.abs(np.linalg.det(corners[:, 1:] - corners[:, :1])).sum() / 6, 1, places=5)
        self.assertLess(read["PointData/GlobalPointIds"][:].max(), 91)  # numbers of the corners stay
        middle = [(CUBE[a] + CUBE[b]) / 2 for a, b in ((0, 1), (1, 3), (0, 3), (0, 4), (1, 4), (3, 4))]
        path = self.path("tetra.vtu")
        write_vtu(path, grid([(vtk.VTK_QUADRATIC_TETRA, [0, 1, 3, 4, *range(8, 14)])], points=[*CUBE, *middle]))
        read = self.good(path)
        self.assertEqual((read["Types"][:].tolist(), len(read["Points"])), ([10], 8))
        self.assertIn("1 tetra10: taken as straight, by their corners; 6 middle nodes are left out", self.said)

    # ---- ParaView

    def pvd(self, entries):
        lines = "".join(f'<DataSet timestep="{time}" part="{part}" file="{name}"/>\n' for time, part, name in entries)
        return self.path("run.pvd", f'<?xml version="1.0"?>\n<VTKFile type="Collection"><Collection>\n{lines}'
                         "</Collection></VTKFile>\n")

    def test_pvd_with_displacements(self):
        for k, fall in enumerate(FALL):
            moved = np.zeros((16, 3))
            moved[8:, 2] = -fall
            write_vtu(self.path(f"f{k}.vtu"), grid([(12, row) for row in HEXAHEDRA], {"Displacement": moved}, two_cubes(),
                                                   {"PartId": np.array([1, 2])}))
        run = self.pvd([(0.5 * k, 0, f"f{k}.vtu") for k in range(3)])
        self.bad(run, says="give --displacement Displacement to add it to the points, or --displacement none")
        self.good(run, "--displacement", "Displacement")
        self.assertIn("f0.vtu: Displacement is added to the points", self.said)
        self.check_fall()
        self.good(run, "--displacement", "none")
        self.assertIn("no point moves in 3 frames", self.said)
        self.good(*(self.path(f"f{k}.vtu") for k in range(3)), "--dt", "0.5", "--displacement", "Displacement")
        self.check_fall()
        os.remove(self.path("f1.vtu"))
        self.bad(run, says="f1.vtu: no such file")
        self.bad(self.path("a.pvd", "<VTKFile"), says="a.pvd: is not XML")

    def test_pvd_with_a_file_for_each_body(self):
        for k, fall in enumerate(FALL):
            for part in range(2):
                write_vtu(self.path(f"f{k}-{part}.vtu"), grid([(12, list(range(8)))], points=two_cubes(fall)[8 * part:][:8]))
        self.good(self.pvd([(0.5 * k, part, f"f{k}-{part}.vtu") for k in range(3) for part in range(2)]))
        self.check_fall(objects=(0, 1))

    def pieces(self, with_ids):
        """Two cubes side by side with four points in common, each a piece."""
        names = []
        for part in range(2):
            ids = {"GlobalPointIds": np.array([[0, 1, 2, 3, 4, 5, 6, 7], [1, 8, 9, 2, 5, 10, 11, 6]][part])}
            names.append(f"p{part}.vtu")
            write_vtu(self.path(names[-1]), grid([(12, list(range(8)))], ids if with_ids else None, CUBE + [part, 0, 0],
                                                 {"PartId": np.array([3])}))
        return names

    def test_pieces_of_one_body_are_joined(self):
        for with_ids in (True, False):
            names = self.pieces(with_ids)
            arrays = '<PPointData><PDataArray type="Int64" Name="GlobalPointIds"/></PPointData>' if with_ids else ""
            sources = "".join(f'<Piece Source="{name}"/>' for name in names)
            parallel = self.path("p.pvtu", '<VTKFile type="PUnstructuredGrid" version="0.1" byte_order="LittleEndian">'
                                 f'<PUnstructuredGrid GhostLevel="0">{arrays}<PPoints><PDataArray type="Float64" Name="Points" '
                                 f'NumberOfComponents="3"/></PPoints>{sources}</PUnstructuredGrid></VTKFile>')
            run = self.pvd([(0, part, name) for part, name in enumerate(names)])
            for file in (parallel, run):
                if not with_ids:
                    self.bad(file, says="4 are at the place of another, and there are no point ids: give --pieces join")
                    self.assertEqual(len(self.good(file, "--pieces", "apart")["Points"]), 16)
                read = self.good(file, *([] if with_ids else ["--pieces", "join"]))
                self.assertEqual(read["NumberOfPoints"][:].tolist(), [12])
                self.assertEqual(read["Connectivity"][:].tolist(), [0, 1, 2, 3, 4, 5, 6, 7, 1, 8, 9, 2, 5, 10, 11, 6])
        self.pieces(True)
        write_vtu(self.path("p1.vtu"), grid([(12, list(range(8)))], {"GlobalPointIds": np.arange(8)}, CUBE + [5, 0, 0]))
        self.bad(self.pvd([(0, 0, "p0.vtu"), (0, 1, "p1.vtu")]), says="the id 0 is there twice, at two places")

    def test_a_file_in_pieces(self):
        texts = []
        for name in self.pieces(True):
            with open(self.path(name), encoding="ascii") as file:
                texts.append(file.read())
        piece = texts[1][texts[1].index("<Piece"):texts[1].index("</UnstructuredGrid>")]
        read = self.good(self.path("a.vtu", texts[0].replace("</UnstructuredGrid>", piece + "</UnstructuredGrid>")))
        self.assertEqual((read["Types"][:].tolist(), len(read["Points"])), ([12] * 2, 12))

    def test_ghost_cells_are_those_of_another_piece(self):
        """Two pieces of a row of three cubes: the second has the middle one as a ghost, too."""
        points = np.array([(x, y, z) for z in (0, 1) for y in (0, 1) for x in range(4)], float)
        cubes = [[x, x + 1, x + 5, x + 4, x + 8, x + 9, x + 13, x + 12] for x in range(3)]
        for part, (here, ghosts) in enumerate((((0, 1), (0, 0)), ((1, 2), (1, 0)))):
            write_vtu(self.path(f"g{part}.vtu"), grid([(12, cubes[k]) for k in here], {"GlobalPointIds": np.arange(16)}, points,
                                                      {"vtkGhostType": np.array(ghosts), "ElementId": np.array(here) + 5}))
        read = self.good(self.pvd([(0, part, f"g{part}.vtu") for part in range(2)]))
        self.assertEqual(read["CellData/GlobalCellIds"][:].tolist(), [5, 6, 7])
        self.assertEqual(read["Connectivity"][:].reshape(3, 8).tolist(), cubes)
        with open(self.path("g0.vtu"), encoding="ascii") as first, open(self.path("g1.vtu"), encoding="ascii") as second:
            text = second.read()
            piece = text[text.index("<Piece"):text.index("</UnstructuredGrid>")]
            both = first.read().replace("</UnstructuredGrid>", piece + "</UnstructuredGrid>")
        self.assertEqual(len(self.good(self.path("both.vtu", both))["Types"]), 3)

    def test_a_middle_node_that_is_a_corner_in_another_piece_stays(self):
        corners = np.array([(0, 0, 0), (1, 0, 0), (0, 1, 0), (0, 0, 1)], float)
        middle = [(corners[a] + corners[b]) / 2 for a, b in ((0, 1), (1, 2), (0, 2), (0, 3), (1, 3), (2, 3))]
        write_vtu(self.path("m0.vtu"), grid([(vtk.VTK_QUADRATIC_TETRA, list(range(10)))], {"GlobalPointIds": np.arange(10)},
                                            [*corners, *middle]))
        other = np.array([middle[0], (1, 0, 0), (1, -1, 0), (1, 0, -1)])
        write_vtu(self.path("m1.vtu"), grid([(10, [0, 1, 2, 3])], {"GlobalPointIds": np.array([4, 1, 20, 21])}, other))
        read = self.good(self.pvd([(0, 0, "m0.vtu"), (0, 1, "m1.vtu")]))
        self.assertEqual(read["PointData/GlobalPointIds"][:].tolist(), [0, 1, 2, 3, 4, 20, 21])
        self.assertEqual(read["Connectivity"][:].tolist(), [0, 1, 2, 3, 4, 1, 5, 6])

    # ---- XDMF

    def test_xdmf_of_meshio(self):
        here = os.getcwd()
        os.chdir(self.folder)  # meshio puts the arrays into the working folder
        self.addCleanup(os.chdir, here)
        for form in ("XML", "HDF", "Binary"):
            with meshio.xdmf.TimeSeriesWriter(self.path("run.xdmf"), data_format=form) as writer:
                writer.write_points_cells(two_cubes(), [("hexahedron", np.array(HEXAHEDRA))])
                for k, fall in enumerate(FALL):
                    moved = np.zeros((16, 3))
                    moved[8:, 2] = -fall
                    writer.write_data(0.5 * k, point_data={"u": moved}, cell_data={"PartId": [np.array([1, 2])]})
            self.bad(self.path("run.xdmf"), says="frame 0: displacement: the points have 'u': give --displacement u")
            self.good(self.path("run.xdmf"), "--displacement", "u")
            self.check_fall()

    def test_xdmf_of_paraview(self):
        """Frames with a mesh of their own, and references to that of an earlier frame."""
        frames = ""
        for k, fall in enumerate(FALL):
            places = " ".join(map(str, two_cubes(fall).ravel()))
            cells = "9 " + " 9 ".join(" ".join(map(str, row)) for row in HEXAHEDRA)
            topology = f'<Topology TopologyType="Mixed" NumberOfElements="2"><DataItem Dimensions="18" NumberType="Int" ' \
                       f'Format="XML">{cells}</DataItem></Topology>' if k == 0 else \
                       '<Topology Reference="/Xdmf/Domain/Grid/Grid[1]/Topology[1]"/>'
            frames += f'<Grid Name="f{k}"><Time Value="{k / 2}"/>{topology}<Geometry Type="XYZ"><DataItem Dimensions="16 3" ' \
                      f'Format="XML">{places}</DataItem></Geometry><Attribute Name="PartId" Center="Cell"><DataItem ' \
                      'Dimensions="2" NumberType="Int" Format="XML">1 2</DataItem></Attribute></Grid>'
        text = '<Xdmf Version="2.0"><Domain><Grid GridType="Collection" CollectionType="Temporal">{}</Grid></Domain></Xdmf>'
        self.good(self.path("a.xdmf", text.format(frames)))
        self.check_fall()
        include = '<xi:include xmlns:xi="http://www.w3.org/2001/XInclude" xpointer="xpointer(//Grid[@Name=&quot;all&quot;]/' \
                  'Grid[1]/*[self::Topology])"/>'  # as FEniCS refers to the mesh of the first frame
        fenics = text.replace("<Grid ", '<Grid Name="all" ').format(
            frames.replace('<Topology Reference="/Xdmf/Domain/Grid/Grid[1]/Topology[1]"/>', include))
        self.assertEqual(fenics.count("xi:include "), 2)
        self.good(self.path("c.xdmf", fenics))
        self.check_fall()
        self.bad(self.path("b.xdmf", text.format(frames.replace("Grid[1]/Top", "Grid[9]/Top"))), says="nothing is at 'Domain/Grid/Grid[9]")
        self.bad(self.path("b.xdmf", text.format(frames).replace("Temporal", "Spatial")), says="the collection is of pieces")
        self.bad(self.path("b.xdmf", text.format(frames).replace('"16 3"', '"17 3"')), says="48 values instead of 17 x 3")
        self.bad(self.path("b.xdmf", text.format(frames).replace("Mixed", "Polygon")), says="Topology: of type polygon: not supported")
        self.bad(self.path("b.xdmf", text.format(frames).replace(">9 0", ">3 0")), says="Topology[0]: number 3 is no type")

    # ---- Exodus

    def test_exodus_of_vtk(self):
        writer = vtk.vtkExodusIIWriter()
        writer.SetFileName(self.path("a.e"))
        writer.SetInputData(grid([(12, row) for row in HEXAHEDRA], points=two_cubes()))
        writer.Write()
        read = self.good(self.path("a.e"))
        self.assertEqual(read["Types"][:].tolist(), [12, 12])
        np.testing.assert_allclose(read["Points"][:], two_cubes())
        self.assertEqual(read["Connectivity"][:].tolist(), list(range(16)))

    def test_exodus_with_steps(self):
        """As Sierra and MOOSE write it: two blocks, displacements in three scalars, numbers that have gaps."""
        path = self.path("run.exo")
        with netCDF4.Dataset(path, "w", format="NETCDF3_64BIT_OFFSET") as file:
            for name, size in (("len_string", 33), ("num_dim", 3), ("num_nodes", 16), ("num_elem", 2), ("num_el_blk", 2),
                               ("num_nod_var", 3), ("time_step", None), ("one", 1), ("eight", 8)):
                file.createDimension(name, size)
            for k, name in enumerate(("coordx", "coordy", "coordz")):
                file.createVariable(name, "f8", ("num_nodes",))[:] = two_cubes()[:, k]
            for k, row in enumerate(HEXAHEDRA):
                block = file.createVariable(f"connect{k + 1}", "i4", ("one", "eight"))
                block.elem_type = "HEX8"
                block[:] = np.array([row]) + 1
            file.createVariable("eb_prop1", "i4", ("num_el_blk",))[:] = [4, 9]
            names = file.createVariable("eb_names", "S1", ("num_el_blk", "len_string"))
            values = file.createVariable("name_nod_var", "S1", ("num_nod_var", "len_string"))
            for k, text in enumerate(("lower", "upper")):
                names[k] = netCDF4.stringtochar(np.array(text.ljust(33, "\0"), "S33"))
            for k in range(3):
                values[k] = netCDF4.stringtochar(np.array(f"disp_{'xyz'[k]}".ljust(33, "\0"), "S33"))
                moved = file.createVariable(f"vals_nod_var{k + 1}", "f8", ("time_step", "num_nodes"))
                for step, fall in enumerate(FALL):
                    moved[step] = [0] * 8 + [-fall if k == 2 else 0] * 8
            file.createVariable("time_whole", "f8", ("time_step",))[:] = [0, 0.5, 1]
            file.createVariable("node_num_map", "i4", ("num_nodes",))[:] = np.arange(16) + 100
            file.createVariable("elem_num_map", "i4", ("num_elem",))[:] = [7, 70]
        read = self.good(path)
        self.assertIn("disp is added to the points", self.said)
        self.check_fall(objects=(4, 9))
        self.assertEqual(read["CellData/GlobalCellIds"][:].tolist(), [7, 70])
        self.assertEqual(read["PointData/GlobalPointIds"][:].tolist(), list(range(100, 116)))
        self.assertRegex(self.info, r"object 4 +1  lower\n +object 9 +1  upper")
        with open(path, "r+b") as file:
            file.truncate(100)
        self.bad(path, says="run.exo: is not an Exodus file")

    # ---- CalculiX

    @unittest.skipUnless(shutil.which("ccx"), "install calculix-ccx")
    def test_results_of_calculix(self):
        """A bar whose free end is pulled: C3D20, dynamics, displacements and velocities."""
        corners = [(x, y, z) for z in (0, 1) for y in (0, 1) for x in (0, 1)]
        order = [0, 1, 3, 2, 4, 5, 7, 6]
        edges = [(0, 1), (1, 2), (2, 3), (3, 0), (4, 5), (5, 6), (6, 7), (7, 4), (0, 4), (1, 5), (2, 6), (3, 7)]
        places = np.array([corners[k] for k in order], float)
        places = np.concatenate([places, [(places[a] + places[b]) / 2 for a, b in edges]])
        nodes = "".join(f"{5 * k + 1},{x},{y},{z}\n" for k, (x, y, z) in enumerate(places))
        numbers = [5 * k + 1 for k in range(20)]
        element = f"9,{','.join(map(str, numbers[:10]))},\n{','.join(map(str, numbers[10:]))}\n"
        fixed = "".join(f"{5 * k + 1},1,3\n" for k in range(20) if places[k][2] == 0)
        deck = self.path("bar.inp", f"*NODE, NSET=ALL\n{nodes}*ELEMENT, TYPE=C3D20, ELSET=E\n{element}*MATERIAL, NAME=S\n*ELASTIC\n"
                         f"1000,0.3\n*DENSITY\n1.\n*SOLID SECTION, ELSET=E, MATERIAL=S\n*BOUNDARY\n{fixed}*STEP, INC=20\n"
                         "*DYNAMIC, DIRECT\n0.01,0.05\n*CLOAD\n21,3,10.\n*NODE FILE, FREQUENCY=1\nU, V\n*END STEP\n")
        done = subprocess.run(["ccx", "bar"], cwd=self.folder, capture_output=True, text=True, check=False)
        self.assertTrue(os.path.exists(self.path("bar.frd")), done.stdout[-2000:])
        read = self.good(self.path("bar.frd"))
        self.assertIn("1 hexahedron20: taken as straight, by their corners; 12 middle nodes are left out", self.said)
        self.assertIn("DISP is added to the points", self.said)
        np.testing.assert_allclose(read["Steps/Values"][:], [0.01, 0.02, 0.03, 0.04, 0.05])
        self.assertEqual(read["PointData/GlobalPointIds"][:].tolist(), numbers[:8])
        self.assertEqual(read["CellData/GlobalCellIds"][:].tolist(), [9])
        points, velocity = read["Points"][:].reshape(5, 8, 3), read["PointData/Velocity"][:].reshape(5, 8, 3)
        self.assertTrue((points[:, :4] == places[:4]).all())
        self.assertTrue((points[:, 4, 2] > 1).all() and (np.diff(points[:3, 4, 2]) > 0).all())
        self.assertTrue((velocity[0, 4:] != 0).any() and not velocity[:, :4].any())
        read = self.good(deck)  # the deck itself
        np.testing.assert_allclose(read["Points"][:], places[:8])
        with open(self.path("bar.frd"), encoding="ascii") as file:
            text = file.read()
        self.bad(self.path("b.frd", text.replace(" -1        96", " -1        9x")), says="b.frd: is not the text form of .frd")

    # ---- LS-DYNA

    def write_states(self, same_numbers=False):
        points = np.concatenate([two_cubes(), [(0, 0, 9), (1, 0, 9), (1, 1, 9), (0, 1, 9)]])
        nodes = {10 + 2 * k: place for k, place in enumerate(points)}
        numbers = list(nodes)
        solids = {100: (7, numbers[:8]), 105: (8, numbers[8:16])}
        shells = {100 if same_numbers else 200: (23, numbers[16:])}
        states = []
        for k, fall in enumerate(FALL):
            moved, velocity = points.copy(), np.zeros_like(points)
            moved[8:16, 2] -= fall
            velocity[8:16, 2] = -1.5
            states.append((0.5 * k, moved, velocity, () if k < 2 else (list(shells)[0],)))
        write_d3plot(self.path("d3plot"), nodes, solids, shells, states)

    def test_d3plot(self):
        self.write_states()
        read = self.good(self.path("d3plot"))
        self.assertEqual(read["Steps/Values"][:].tolist(), [0, 0.5, 1])
        self.assertEqual(read["CellData/GlobalCellIds"][:].tolist(), [100, 105, 200, 100, 105])
        self.assertEqual(read["CellData/PartId"][:].tolist(), [7, 8, 23, 7, 8])
        self.assertEqual(read["Types"][:].tolist(), [12, 12, 9, 12, 12])
        self.assertEqual(read["PointData/GlobalPointIds"][:].tolist(), list(range(10, 50, 2)))
        points = read["Points"][:].reshape(3, 20, 3)
        for k, fall in enumerate(FALL):
            np.testing.assert_allclose(points[k, :16], two_cubes(fall), atol=1e-6)
        self.assertEqual(read["PointData/Velocity"][8].tolist(), [0, 0, -1.5])
        self.bad(self.path("d3plot01"), says="d3plot01: is a further file of the family: give d3plot")
        self.bad(self.path("x.d3plot", "junk"), says="x.d3plot: is no d3plot of LS-DYNA")
        with open(self.path("d3plot"), "r+b") as file:
            file.truncate(400)
        self.bad(self.path("d3plot"), says="d3plot: ends before its mesh is complete")

    def test_d3plot_with_parts_that_share_nodes_and_numbers(self):
        self.write_states(same_numbers=True)
        deleted_too = self.good(self.path("d3plot"))
        self.assertIn("numbers of shells + 105, because solids have the same", self.said)
        self.assertEqual(deleted_too["CellData/GlobalCellIds"][:].tolist(), [100, 105, 205, 105])
        numbers = list(range(1, 13))
        points = np.concatenate([CUBE, CUBE[4:] + [0, 0, 1]])
        write_d3plot(self.path("d3plot"), dict(zip(numbers, points)),
                     {1: (1, numbers[:8]), 2: (2, numbers[4:])}, {}, [(0, points, 0 * points, ())])
        read = self.good(self.path("d3plot"))
        self.assertEqual(read["Connectivity"][:].tolist(), [*range(8), *range(4, 12)])

    # ---- what is not read, and needs

    def test_advice(self):
        for name, says in (("a.k", "a deck of LS-DYNA, without results: give its d3plot"), ("a.odb", "export the frames"),
                           ("a.stl", "no common vertices"), ("a.vtkhdf", "volccd reads it"), ("a.h5", "give the .xdmf file"),
                           ("a.xyz", "unknown extension '.xyz'; known: .vtu .vtk")):
            self.bad(self.path(name, "x"), says=says)

    def test_a_missing_package_is_named(self):
        self.path("a.exo", "x")
        self.path("netCDF4.py", "raise ImportError('not here')\n")
        done = subprocess.run([sys.executable, TOOL, self.path("a.exo"), "-o", self.target], capture_output=True, text=True,
                              env={**os.environ, "PYTHONPATH": self.folder}, check=False)
        self.assertEqual(done.returncode, 2)
        self.assertIn("a.exo: needs netCDF4: install python3-netcdf4 (not here)", done.stderr)

    def test_version(self):
        with open(os.path.join(HERE, "..", "..", "core", "version.hpp"), encoding="ascii") as file:
            version = file.read().split('VERSION_STRING "')[1].split('"')[0]
        done = subprocess.run([sys.executable, TOOL, "--version"], capture_output=True, text=True, check=False)
        self.assertEqual((done.returncode, done.stdout), (0, f"volccd-import {version}\n"))


if __name__ == "__main__":
    unittest.main()
