"""docs/how_to.md: its commands work, in order, in one folder. docs/troubleshooting.md: its commands give the messages
above them. The commands of the other pages work as well, except those that take minutes or need other data.
docs/json_output.md has a test of its own (test_json.py), and so has docs/python.md (python/)."""

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

    # Parts of commands that take minutes: experiments, simulations, and scenes that must be simulated first.
    LONG = re.compile(r"experiment run|scene generate (?!builtin)|scene picture (octopi|bullet|airbag|crash|liver)(-quick)? ")
    # Files that the tests do not have: of simulated shells, of the shared data, with velocities, and with queries.
    ABSENT = re.compile(r"--motion (tentative|query)|crash\.vtkhdf|liver\.vtkhdf|bullet\.vtkhdf|all\.vtkhdf|\.\./shared/|build/tables|build/results/")

    def test_quick_commands_of_the_other_pages_work(self):
        folder = self.path("pages")
        os.makedirs(os.path.join(folder, "build"))
        shutil.copytree(os.path.join(SOURCE, "results"), os.path.join(folder, "results"))
        self.good("scene", "generate", "builtin", "--elements", "300", "--steps", "61", "-o",
                  os.path.join(folder, "run.vtkhdf"))
        ran = []
        for name in ("../README.md", "pictures.md", "report.md", "reproducing.md", "sequence_files.md", "simulation.md"):
            for command in re.findall(r"^    (?:build/release/)?(volccd \S.*)$", page(name), re.MULTILINE):
                if self.LONG.search(command) or self.ABSENT.search(command):
                    continue
                done = self.run_in_folder(folder, command)
                if "the page of the report is not built" in done.stderr:
                    continue
                self.assertEqual(done.returncode, 0, f"{name}: {command}\n{done.stdout}{done.stderr}")
                ran.append(name)
        self.assertEqual(set(ran) | {"report.md"}, {"../README.md", "pictures.md", "report.md", "reproducing.md",
                                                    "sequence_files.md", "simulation.md"})
        self.assertGreater(len(ran), 20)

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
