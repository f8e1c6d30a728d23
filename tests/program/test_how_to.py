"""docs/how_to.md: its commands work, in order, in one folder. docs/troubleshooting.md: its commands give the messages
above them."""

import os
import re
import shlex
import shutil
import subprocess
import unittest

from program_support import SOURCE, VOLCCD, ProgramTest


def page(name):
    with open(os.path.join(SOURCE, "docs", name), encoding="utf-8") as file:
        return file.read()


class HowTo(ProgramTest):
    def run_in_folder(self, folder, command):
        words = shlex.split(command)
        self.assertEqual(words[0], "volccd", command)
        env = {**os.environ, "VOLCCD_CACHE": self.path("empty-cache"), "VOLCCD_DATA": self.path("absent")}
        return subprocess.run([os.path.abspath(VOLCCD), *words[1:]], cwd=folder, env=env, capture_output=True,
                              text=True, check=False)

    def test_commands_work_in_order(self):
        folder = self.path("how-to")
        os.mkdir(folder)
        commands = re.findall(r"^    (\S.*)$", page("how_to.md"), re.MULTILINE)
        self.assertGreater(len(commands), 20)
        for command in commands:
            done = self.run_in_folder(folder, command)
            self.assertEqual(done.returncode, 0, f"{command}\n{done.stdout}{done.stderr}")
        for name in ("run.vtkhdf", "contacts.csv", "between.csv", "overlaps.csv", "contacts.vtp", "steps_0004.vtkhdf",
                     "run-3.png", "inside.png"):
            self.assertTrue(os.path.getsize(os.path.join(folder, name)), name)
        self.assertFalse(os.path.exists(self.path("empty-cache")))

    def test_messages_are_those_of_the_program(self):
        folder = self.path("trouble")
        os.mkdir(folder)
        shutil.copy(self.sequence, os.path.join(folder, "run.vtkhdf"))
        with open(self.sequence, "rb") as file, open(os.path.join(folder, "queries.h5"), "wb") as other:
            other.write(file.read().replace(b"VTKHDF\0", b"VTKXXX\0"))
        self.good("scene", "export", self.sequence, "--steps", "0", "-o", os.path.join(folder, "single.vtkhdf"))
        entries = re.findall(r'^### "(.*)"\n\n    (volccd .*)\n', page("troubleshooting.md"), re.MULTILINE)
        self.assertEqual(len(entries), page("troubleshooting.md").count("\n### "))
        self.assertGreater(len(entries), 8)
        for message, command in entries:
            done = self.run_in_folder(folder, command)
            self.assertEqual(done.returncode, 2, f"{command}\n{done.stdout}{done.stderr}")
            self.assertIn(message, done.stderr, command)


if __name__ == "__main__":
    unittest.main()
