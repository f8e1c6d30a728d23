"""docs/how_to.md: its commands work, in order, in one folder. docs/troubleshooting.md: its commands give the messages
above them. The commands of the other pages work as well, except those that take minutes or need other data. Other tests
run docs/json_output.md (test_json.py), docs/python.md (python/tests/), and the builds of docs/installing.md,
docs/adding_a_stage.md and docs/into_a_solver.md (package.*); CI runs the scripts."""

import os
import re
import shlex
import shutil
import subprocess
import unittest

from program_support import EXAMPLE, SOURCE, VOLCCD, ProgramTest, copy_results


def page(name):
    with open(os.path.join(SOURCE, "docs", name), encoding="utf-8") as file:
        return file.read()


class HowTo(ProgramTest):
    PROGRAMS = {"volccd": [VOLCCD], "build/custom_culling": [EXAMPLE],
                "tools/plot_results.py": ["/usr/bin/python3", "-B", os.path.join(SOURCE, "tools/plot_results.py")]}

    def run_in_folder(self, folder, command):
        words = shlex.split(command)
        program, *first = self.PROGRAMS[words[0]]
        env = {**os.environ, "VOLCCD_CACHE": self.path("empty-cache"), "VOLCCD_DATA": self.path("absent")}
        return subprocess.run([os.path.abspath(program), *first, *words[1:]], cwd=folder, env=env, capture_output=True,
                              text=True, check=False)

    def check(self, folder, command, code=0):
        """Runs the command, which must end with the exit code, and returns its result."""
        done = self.run_in_folder(folder, command)
        self.assertEqual(done.returncode, code, f"{command}\n{done.stdout}{done.stderr}")
        return done

    def commands_of(self, name, begin, more_than):
        """The commands of a page that begin so."""
        commands = re.findall(rf"^    ({begin}.*)$", page(name), re.MULTILINE)
        self.assertGreater(len(commands), more_than)
        return commands

    def new_folder(self, name):
        folder = self.path(name)
        os.mkdir(folder)
        return folder

    def test_commands_work_in_order(self):
        folder = self.new_folder("how-to")
        for command in self.commands_of("how_to.md", r"\S", more_than=20):
            self.check(folder, command)
        for name in ("run.vtkhdf", "contacts.csv", "between.csv", "overlaps.csv", "contacts.vtp", "frames_0004.vtkhdf",
                     "run-3.png", "inside.png"):
            self.assertTrue(os.path.getsize(os.path.join(folder, name)), name)
        self.assertFalse(os.path.exists(self.path("empty-cache")))

    # Parts of commands that take minutes: experiments, simulations, and scenes that must be simulated first.
    LONG = re.compile(r"experiment run|scene generate (?!builtin)|scene picture (octopi|bullet|airbag|crash|liver)(-quick)? ")
    # Files that the tests do not have: of simulated scenes, and of the shared data.
    ABSENT = re.compile(r"detect liver-quick|crash\.vtkhdf|liver\.vtkhdf|bullet\.vtkhdf|all\.vtkhdf|\.\./shared/")

    def test_quick_commands_of_the_other_pages_work(self):
        folder = self.path("pages")
        os.makedirs(os.path.join(folder, "build"))
        for results in ("results", "build/results", "build/tables"):
            copy_results(os.path.join(folder, results))
        self.good("scene", "generate", "builtin", "--elements", "300", "--frames", "61", "-o",
                  os.path.join(folder, "run.vtkhdf"))
        with_queries = self.new_folder("with-queries")  # and with velocities
        self.good("scene", "generate", "weld", "--elements", "300", "--frames", "3", "-o",
                  os.path.join(with_queries, "run.vtkhdf"))
        ran = []
        for name in ("../README.md", "pictures.md", "report.md", "reproducing.md", "sequence_files.md", "simulation.md"):
            for command in re.findall(r"^    (?:build/release/)?(volccd \S.*)$", page(name), re.MULTILINE):
                if self.LONG.search(command) or self.ABSENT.search(command):
                    continue
                place = with_queries if re.search("--motion (tentative|query)", command) else folder
                done = self.run_in_folder(place, command)
                if "the page of the report is not built" in done.stderr:
                    continue
                self.assertEqual(done.returncode, 0, f"{name}: {command}\n{done.stdout}{done.stderr}")
                ran.append(name)
        self.assertEqual(set(ran) | {"report.md"}, {"../README.md", "pictures.md", "report.md", "reproducing.md",
                                                    "sequence_files.md", "simulation.md"})
        self.assertGreater(len(ran), 25)

    def test_commands_of_adding_a_stage_work_in_order(self):
        folder = self.new_folder("stage")
        for command in self.commands_of("adding_a_stage.md", r"build/custom_culling \S", more_than=7):
            if not self.LONG.search(command) and "--trials" not in command:
                self.check(folder, command)

    def test_figures(self):
        folder = self.new_folder("figures")
        shutil.copytree(os.path.join(SOURCE, "results"), os.path.join(folder, "results"))
        commands = self.commands_of("reproducing.md", r"tools/plot_results\.py \S", more_than=1)
        if subprocess.run(["/usr/bin/python3", "-c", "import matplotlib"], capture_output=True, check=False).returncode:
            self.skipTest("python3-matplotlib is not installed")
        # All figures take half a minute; the second command is the same for two of them.
        self.assertTrue(commands[1].startswith(commands[0] + " --only"), commands)
        self.check(folder, commands[1])
        self.assertTrue(os.path.exists(os.path.join(folder, "build/figures/culling.svg")))

    def test_messages_are_those_of_the_program(self):
        folder = self.new_folder("trouble")
        shutil.copy(self.sequence, os.path.join(folder, "run.vtkhdf"))
        with open(self.sequence, "rb") as file, open(os.path.join(folder, "queries.h5"), "wb") as other:
            other.write(file.read().replace(b"VTKHDF\0", b"VTKXXX\0"))
        self.good("scene", "export", self.sequence, "--frames", "0", "-o", os.path.join(folder, "single.vtkhdf"))
        entries = re.findall(r'^### "(.*)"\n\n    (volccd .*)\n', page("troubleshooting.md"), re.MULTILINE)
        self.assertEqual(len(entries), page("troubleshooting.md").count("\n### "))
        self.assertGreater(len(entries), 8)
        for message, command in entries:
            done = self.check(folder, command, code=2)
            self.assertIn(message, done.stderr, command)


if __name__ == "__main__":
    unittest.main()
