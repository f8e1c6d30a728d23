"""Bad input is an error that states the reason."""

import os
import unittest

from program_support import run, ProgramTest


class BadInput(ProgramTest):
    def test_bad_input_exits_with_2_and_says_why(self):
        empty = self.path("empty.vtkhdf")
        with open(empty, "wb"):
            pass
        self.bad("info", empty, says="empty.vtkhdf")
        self.bad("detect", self.path("absent.vtkhdf"), says="absent.vtkhdf")
        self.bad("detect", self.sequence, "--pipeline", "Nothing", says="VolCCD+")
        self.bad("detect", self.sequence, "--set", "csat.axis=sideways", says="centroid")
        self.bad("detect", self.sequence, "--set", "nothing.x=1", says="kdop-bvh")
        self.bad("detect", self.sequence, "--set", "assignment=static-assignment", says="O-Set")
        for steps in ("4", "2:2", "3:1", "x", "-1:2", "0:9"):
            self.bad("detect", self.sequence, "--steps=" + steps, says="--steps")
        self.bad("detect", self.sequence, "--separation", "0.1", "--set", "narrow-phase=cubic", says="separation")
        self.bad("detect", self.sequence, "--contacts", self.path("no/such/folder.csv"), says="folder.csv")
        self.bad("queries", self.path("absent.h5"), says="absent.h5")
        self.bad("queries", self.sequence, says="GroundTruth")
        self.bad("queries", self.sequence, "--candidates", "--narrowphase", "nothing", says="cubic")
        self.bad("queries", self.sequence, "--candidates", "--narrowphase", "cubic:tolerance", says="option=value")
        self.bad("queries", self.sequence, "--candidates", "--set", "csat.axis=face", says="csat")
        for command in (["detect", self.sequence], ["verify", self.sequence], ["experiment", "run", "projectile"],
                        ["scene", "generate", "builtin", "-o", self.path("threads.vtkhdf")],
                        ["scene", "picture", self.sequence, "-o", self.path("threads.png")]):
            self.bad(*command, "--threads", "100000", says="1024")
        self.bad("frobnicate", says="frobnicate")
        self.bad("experiment", "run", "nothing", says="projectile")
        self.assertEqual([name for name in os.listdir(self.folder.name) if "tmp" in name], [])

    def test_files_of_other_programs_are_for_the_importer(self):
        for name, source, output in (
                ("x.vtu", "x.vtu", "x"), ("x.MSH", "x.MSH", "x"), ("x.inp", "x.inp", "x"), ("x.pvd", "x.pvd", "x"),
                ("x.xdmf", "x.xdmf", "x"), ("x.e", "x.e", "x"), ("x.exo", "x.exo", "x"), ("x.k", "d3plot", "x"),
                ("d3plot", "d3plot", "d3plot"), ("x y.vtu", "'x y.vtu'", "'x y")):
            file = self.path(name)
            with open(file, "w", encoding="ascii") as target:
                target.write("something")
            source = source.replace("'", "")
            words = f"'{self.path(source)}' -o 'x y.vtkhdf'" if " " in source else f"{self.path(source)} -o {output}.vtkhdf"
            for command in (["detect"], ["info"], ["verify"], ["queries"]):
                self.bad(*command, file, says="is no sequence (VTKHDF); this makes one of it: volccd-import " + words)
        os.rename(self.sequence, self.path("named.vtu"))
        self.assertEqual(run("info", self.path("named.vtu")).returncode, 0)
        self.bad("info", self.path("absent.vtu"), says="No such file")

    def test_damaged_files_leave_no_messages_of_hdf5(self):
        """If the address in a continuation message of an object header is wrong, HDF5 leaks memory of its own."""
        with open(self.sequence, "rb") as file:
            data = file.read()
        message = b"\x10\x00\x10\x00\x00\x00\x00\x00"
        damaged, at, refused = self.path("damaged.vtkhdf"), data.find(message), 0
        while at >= 0:
            with open(damaged, "wb") as file:
                file.write(data[:at + 12] + b"\x56" + data[at + 13:])
            done = run("info", damaged)
            self.assertNotIn("infinite loop", done.stderr)
            refused += done.returncode == 2
            at = data.find(message, at + 1)
        self.assertGreater(refused, 2)


if __name__ == "__main__":
    unittest.main()
