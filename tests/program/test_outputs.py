"""Outputs do not destroy inputs, devices, links and older files."""

import json
import os
import shutil
import stat
import subprocess
import unittest

from program_support import VOLCCD, run, ProgramTest


class Outputs(ProgramTest):
    def test_an_output_is_never_an_input_or_another_output(self):
        source = self.path("in.vtkhdf")
        shutil.copy(self.sequence, source)
        os.link(source, self.path("hard.vtkhdf"))
        os.symlink("in.vtkhdf", self.path("soft.vtkhdf"))
        rows = self.write("rows.csv", "step,kind,a,b,c,d,toi\n")
        for name in ("in.vtkhdf", "hard.vtkhdf", "soft.vtkhdf",
                     "../" + os.path.basename(self.folder.name) + "/in.vtkhdf"):
            same = self.path(name)
            for option in ("--contacts", "--overlaps", "--stats"):
                self.bad("detect", source, option, same, says=option)
            self.bad("scene", "picture", source, "-o", same, says="-o")
            self.bad("scene", "generate", "deform", "--mesh", source, "-o", same, says="--mesh")
            self.bad("scene", "generate", "builtin", "-o", source, "--stats", same, says="--stats")
        self.bad("scene", "picture", source, "--contacts-from", rows, "-o", rows, says="--contacts-from")
        self.bad("detect", source, "--contacts", self.path("x"), "--overlaps", self.path("./x"), says="--overlaps")
        self.bad("detect", source, "--contacts", "-", "--stats", "/dev/fd/1", says="--stats")
        self.bad("scene", "generate", "openradioss-bullet", "-o", self.path("openradioss-bullet.vtkhdf"),
                 says="openradioss-bullet", env=self.data(source))
        with open(self.path("report.txt"), "w", encoding="ascii") as report:
            done = subprocess.run([VOLCCD, "detect", source, "--contacts", report.name], stdout=report,
                                  stderr=subprocess.PIPE, text=True, check=False)
        self.assertEqual((done.returncode, "standard output" in done.stderr), (2, True), done.stderr)
        self.assertEqual(self.read("in.vtkhdf"), self.read("run.vtkhdf"))
        self.assertEqual(self.read("rows.csv"), b"step,kind,a,b,c,d,toi\n")
        self.assertFalse(os.path.exists(self.path("x")))
        self.no_leftovers()

    def data(self, sequence):
        """An environment in which the scene openradioss-bullet is a copy of `sequence`."""
        if not os.path.exists(self.path("openradioss-bullet.vtkhdf")):
            shutil.copy(sequence, self.path("openradioss-bullet.vtkhdf"))
        return {"VOLCCD_DATA": self.folder.name}

    def test_standard_output_carries_the_result_alone(self):
        whole = [",".join(row) for row in self.contacts()]
        os.symlink("/proc/self/fd/1", self.path("stdout"))
        for name in ("-", "/dev/fd/1", "/proc/self/fd/1", self.path("stdout"), *self.device("/dev/stdout")):
            done = run("detect", self.sequence, "--contacts", name)
            self.assertEqual((done.returncode, done.stdout.splitlines()), (0, whole), name)
            self.assertIn("after culling", done.stderr)
        stats = json.loads(self.good("detect", self.sequence, "--stats", "-"))
        self.assertEqual(stats["total"]["contacts"], len(whole) - 1)
        self.assertTrue(self.good("detect", self.sequence, "--overlaps", "-").startswith("step,a,b\n"))
        with subprocess.Popen([VOLCCD, "scene", "picture", self.sequence, "--size", "160x120", "-o", "-"],
                              stdout=subprocess.PIPE, stderr=subprocess.PIPE) as process:
            self.assertEqual(process.communicate()[0][:8], b"\x89PNG\r\n\x1a\n")
        os.mkfifo(self.path("for-hdf5"))
        for name in ("-", "/dev/fd/1", self.path("for-hdf5"), *self.device("/dev/null")):
            self.bad("scene", "generate", "builtin", "-o", name, says="not a regular file")
        with open(self.path("out.txt"), "wb") as file:  # stdout is the file, as with the shell's >
            subprocess.run([VOLCCD, "detect", self.sequence, "--contacts", self.path("stdout")], stdout=file,
                           stderr=subprocess.DEVNULL, check=True)
        self.assertEqual(self.read("out.txt").decode().splitlines(), whole)

    def test_links_fifos_and_devices_stay(self):
        self.good("detect", self.sequence, "--contacts", self.path("contacts.csv"))
        whole = self.read("contacts.csv")
        os.symlink("target.csv", self.path("link.csv"))
        for _ in range(2):  # at first the target does not exist, then it does
            self.good("detect", self.sequence, "--contacts", self.path("link.csv"))
            self.assertTrue(os.path.islink(self.path("link.csv")))
            self.assertEqual(self.read("target.csv"), whole)
        for null in self.device("/dev/null"):
            self.good("detect", self.sequence, "--contacts", null, "--stats", null, "--overlaps", null)
            self.assertTrue(stat.S_ISCHR(os.stat(null).st_mode))
        os.mkfifo(self.path("fifo"))
        reader = os.open(self.path("fifo"), os.O_RDONLY | os.O_NONBLOCK)  # the output fits into the FIFO's buffer
        self.good("detect", self.sequence, "--first", "--contacts", self.path("fifo"))
        self.good("detect", self.sequence, "--first", "--contacts", self.path("first.csv"))
        self.assertEqual(os.read(reader, 1 << 16), self.read("first.csv"))
        os.close(reader)
        self.assertTrue(stat.S_ISFIFO(os.stat(self.path("fifo")).st_mode))
        os.symlink("picture.png", self.path("link.png"))
        self.good("scene", "picture", self.sequence, "--size", "160x120", "-o", self.path("link.png"))
        self.assertTrue(os.path.islink(self.path("link.png")) and os.path.isfile(self.path("picture.png")))
        os.symlink("made.vtkhdf", self.path("link.vtkhdf"))
        self.good("scene", "generate", "builtin", "--elements", "300", "-o", self.path("link.vtkhdf"))
        self.assertTrue(os.path.islink(self.path("link.vtkhdf")) and os.path.isfile(self.path("made.vtkhdf")))

    def test_outputs_that_cannot_be_written_are_refused_at_once_with_the_reason(self):
        reason = "No such file or directory"
        for arguments in (["detect", self.sequence, "--contacts"], ["detect", self.sequence, "--overlaps"],
                          ["detect", self.sequence, "--stats"], ["scene", "picture", self.sequence, "-o"],
                          ["scene", "generate", "builtin", "-o"]):
            self.bad(*arguments, self.path("no/such"), says=reason)
            self.bad(*arguments, self.folder.name, says="folder")
        self.bad("experiment", "run", "projectile", "-o", self.path("run.vtkhdf") + "/results", says="Not a directory")
        self.bad("experiment", "run", "projectile", "-o", "/proc/results", says="/proc/results")
        os.mkdir(self.path("records"))
        os.mkdir(self.path("records/projectile.txt"))
        self.bad("experiment", "run", "projectile", "-o", self.path("records"), says="projectile.txt",
                 env={"VOLCCD_DATA": self.folder.name})
        with open("/dev/full", "w", encoding="ascii") as full:
            done = subprocess.run([VOLCCD, "detect", self.sequence], stdout=full, stderr=subprocess.PIPE, text=True,
                                  check=False)
        self.assertEqual(done.returncode, 2)
        self.assertIn("standard output: cannot be written: No space left on device", done.stderr)
        with open("/dev/full", "w", encoding="ascii") as full:
            done = subprocess.run([VOLCCD, "detect", self.sequence, "--contacts", "-"], stdout=full,
                                  stderr=subprocess.PIPE, text=True, check=False)
        self.assertEqual(done.returncode, 2)
        self.assertIn("-: cannot be written: No space left on device", done.stderr)
        self.no_leftovers()

    @staticmethod
    def device(name):
        """The device, or nothing if this user could replace it by mistake."""
        return [] if os.access(os.path.dirname(name), os.W_OK) else [name]


if __name__ == "__main__":
    unittest.main()
