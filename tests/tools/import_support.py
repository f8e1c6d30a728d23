"""What the tests of tools/import_sequence.py share."""

import contextlib
import io
import os
import subprocess
import sys
import tempfile
import types
import unittest

SKIPPED = 77  # the exit code that means "skipped" to CTest
try:
    import h5py
    import meshio  # noqa: F401  # pylint: disable=unused-import
    import netCDF4  # noqa: F401  # pylint: disable=unused-import
    import vtk  # noqa: F401  # pylint: disable=unused-import
except ImportError as missing:
    # Debian's packages are for Debian's interpreter, which need not be the first one in the path.
    SYSTEM = "/usr/bin/python3"
    if os.path.realpath(sys.executable) != os.path.realpath(SYSTEM) and os.path.exists(SYSTEM):
        os.execv(SYSTEM, [SYSTEM, *sys.argv])
    print(f"skipped: {missing}; install python3-meshio, python3-h5py, python3-netcdf4, python3-vtk9")
    sys.exit(SKIPPED)

VOLCCD = os.path.abspath(sys.argv.pop(1))
HERE = os.path.dirname(os.path.abspath(__file__))
TOOL = os.path.join(os.path.dirname(os.path.dirname(HERE)), "tools", "import_sequence.py")
sys.dont_write_bytecode = True
sys.path.insert(0, os.path.dirname(TOOL))
import import_sequence  # noqa: E402  # pylint: disable=wrong-import-position


def data(*names):
    return [os.path.join(HERE, "data", name) for name in names]


class Importer(unittest.TestCase):
    def setUp(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.folder = folder.name
        self.target = self.path("out.vtkhdf")

    def path(self, name, text=None):
        result = os.path.join(self.folder, name)
        if text is not None:
            with open(result, "w", encoding="ascii") as file:
                file.write(text)
        return result

    def run_tool(self, *arguments):
        """Imports in this process, because starting Python and meshio takes longer than the work."""
        out, err = io.StringIO(), io.StringIO()
        with contextlib.redirect_stdout(out), contextlib.redirect_stderr(err):
            try:
                code = import_sequence.main([*arguments, "-o", self.target])
            except SystemExit as end:
                code = end.code
        return types.SimpleNamespace(returncode=code, stdout=out.getvalue(), stderr=err.getvalue())

    def good(self, *arguments):
        """Opens the file that was written; `volccd` must accept it."""
        done = self.run_tool(*arguments)
        self.assertEqual(done.returncode, 0, done.stderr)
        self.said = done.stderr
        read = subprocess.run([VOLCCD, "info", self.target], capture_output=True, text=True, check=False)
        self.assertEqual(read.returncode, 0, read.stderr)
        self.info = read.stdout
        file = h5py.File(self.target, "r")
        self.addCleanup(file.close)
        return file["VTKHDF"]

    def bad(self, *arguments, says):
        before = sorted(os.listdir(self.folder))
        done = self.run_tool(*arguments)
        self.assertEqual(done.returncode, 2, done.stdout + done.stderr)
        self.assertIn(says, done.stderr)
        self.assertNotIn("Traceback", done.stderr)
        self.assertEqual(sorted(os.listdir(self.folder)), before)
