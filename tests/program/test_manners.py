"""Output for users: lines of 100 columns, suggestions of names, --quiet, help, progress, and no simulation that was
not asked for."""

import fcntl
import json
import os
import pty
import re
import shutil
import struct
import subprocess
import termios
import unittest

from program_support import SOURCE, VOLCCD, ProgramTest, copy_results, run

WIDTH = 100


def commands(*path):
    """Every command, including the commands below others, with the program itself first."""
    yield path
    block = re.search(r"^Subcommands:\n((?:  .*\n)+)", run(*path, "--help").stdout, re.MULTILINE)
    if block:
        for name in re.findall(r"^  (\w+) ", block[1], re.MULTILINE):
            yield from commands(*path, name)


def on_a_terminal(*arguments):
    """The output on stderr if it is a terminal."""
    terminal, tty = pty.openpty()
    with subprocess.Popen([VOLCCD, *arguments], stdout=subprocess.DEVNULL, stderr=tty) as process:
        os.close(tty)
        screen = b""
        while True:
            try:
                data = os.read(terminal, 4096)
            except OSError:
                break
            if not data:
                break
            screen += data
        code = process.wait()
    os.close(terminal)
    return code, screen.decode()


def output_of_a_terminal(columns, *arguments):
    """The lines on stdout if it is a terminal of that many columns."""
    terminal, tty = pty.openpty()
    fcntl.ioctl(tty, termios.TIOCSWINSZ, struct.pack("HHHH", 50, columns, 0, 0))
    with subprocess.Popen([VOLCCD, *arguments], stdout=tty, stderr=subprocess.DEVNULL) as process:
        os.close(tty)
        screen = b""
        while True:
            try:
                data = os.read(terminal, 4096)
            except OSError:
                break
            if not data:
                break
            screen += data
        process.wait()
    os.close(terminal)
    return screen.decode().replace("\r", "").splitlines()


class Manners(ProgramTest):
    def fits(self, text, what):
        self.assertTrue(text, what)
        for line in text.splitlines():
            self.assertLessEqual(len(line), WIDTH, f"{what}: {line}")

    def test_help_fits(self):
        every = list(commands())
        self.assertGreater(len(every), 14)
        for path in every:
            shown = self.good(*path, "--help")
            self.fits(shown, f"{path} --help")
            if path != ("help",):
                self.assertEqual(self.good("help", *path), shown)
        self.bad("help", "scene", "genrate", says="did you mean 'generate'?")

    def test_tables_fit(self):
        for arguments in (["info", self.sequence], ["detect", self.sequence], ["verify", self.sequence],
                          ["detect", self.sequence, "--overlaps", os.devnull, "--pipeline", "NavCCD"],
                          ["verify", self.sequence, "--approximate"], ["stages"], ["scene", "list"],
                          ["experiment", "list"], ["check", "csat", "--trials", "10"],
                          ["queries", self.sequence, "--candidates", "--sample", "100", "--judge", "exact",
                           "--narrowphase", "cubic,inclusion,exact", "--filters", "feature-kdop,coplanarity"]):
            self.fits(self.good(*arguments), arguments)
        for name in ("octopus2-105k-deformed.vtkhdf", "a" * 60 + ".vtkhdf"):
            os.symlink(self.sequence, self.path(name))
            self.fits(self.good("detect", self.path(name)).split("\n", 1)[1], name)

    def test_tables_take_the_width_of_the_terminal(self):
        shown = {columns: output_of_a_terminal(columns, "detect", self.sequence, "--overlaps", os.devnull)
                 for columns in (60, 100, 180)}
        headers = {columns: [line for line in lines if line.startswith("step ")] for columns, lines in shown.items()}
        self.assertEqual([len(headers[columns]) for columns in (60, 180)], [2, 1])  # 60 columns take two tables
        self.assertGreater(len(headers[180][0]), 100)
        self.assertLessEqual(max(len(line) for line in shown[60] if line.startswith("---")), 60)
        table = output_of_a_terminal(180, "experiment", "table", "table1", "--results", os.path.join(SOURCE, "results"))
        self.assertGreater(max(map(len, table)), 105)
        target = self.path("table1.txt")
        self.good("experiment", "table", "table1", "--results", os.path.join(SOURCE, "results"), "-o", target)
        with open(target, encoding="utf-8") as file:  # a file is the same whatever terminal there is
            self.fits(file.read(), target)

    def test_columns_have_names_of_their_own_and_numbers_no_exponents(self):
        for name in ("table1", "culling", "ablation", "scaling", "operations", "peers", "plus", "projectile", "boundary",
                     "inversion", "feature-sets"):
            shown = self.good("experiment", "table", name, "--results", os.path.join(SOURCE, "results"), "--json")
            for table in json.loads(shown)["tables"]:
                self.assertEqual(len(set(table["columns"])), len(table["columns"]), (name, table["columns"]))
                for row in table["rows"]:
                    for cell in row:
                        if cell not in ("8.24E+09", "1.6E+10", "2.43E+10", "9.8E+07", "3.8E+08", "4.76E+08", "2.3E+07", "1.2E+08",
                                        "1.41E+08"):  # as the paper prints them
                            self.assertNotRegex(cell, r"[eE]\+|^-0(\.0+)?( |$)", (name, row))

    def test_without_arguments_the_commands_are_listed(self):
        done = run()
        self.assertEqual((done.returncode, done.stderr), (2, ""))
        self.assertIn("Usage: volccd COMMAND", done.stdout)
        self.assertRegex(done.stdout, r"\n  detect +contacts of the steps")
        self.assertLess(done.stdout.count("\n"), 25)
        self.fits(done.stdout, "volccd")

    def test_numbers_that_are_too_small(self):
        for command in ("detect", "verify"):
            for value, says in (("-1", "--separation: must be at least 0, and is -1\n"), ("nan", "at least 0, and is nan\n"),
                                ("inf", "must be at least 0 and finite, and is inf\n"), ("x", "'x' is not a number")):
                self.bad(command, self.sequence, f"--separation={value}", says=says)
        self.bad("detect", says="volccd: FILE is required")

    def test_a_cache_that_cannot_be_written_to(self):
        with open(self.path("no-folder"), "w", encoding="ascii"):
            pass
        for scene in ("builtin", "liver-quick"):
            self.bad("detect", scene, env={"VOLCCD_CACHE": self.path("no-folder/cache")}, says="scenes are kept in the folder that "
                     "VOLCCD_CACHE names: let it name another")

    def test_tables_of_experiments_fit(self):
        folder = os.path.join(SOURCE, "results")
        for name in sorted(os.listdir(folder)):
            if name.endswith(".txt"):
                with open(os.path.join(folder, name), encoding="utf-8") as file:
                    self.fits(file.read(), name)

    def test_what_experiments_and_reports_print_fits(self):
        none = {"VOLCCD_DATA": "none", "VOLCCD_CACHE": self.path("no-cache")}
        results, records = self.path("results"), self.path("records")
        copy_results(records)
        for arguments in (["experiment", "run", "projectile", "--quick", "-o", results],
                          *(["experiment", "table", name, "--results", records]
                            for name in ("table1", "culling", "ablation", "scaling", "operations", "peers", "plus",
                                         "projectile", "scenes", "feature-sets")),
                          ["experiment", "compare", results, results], ["report", records, "-o", self.path("report")],
                          ["view", self.sequence, "-o", self.path("view")],
                          ["scene", "generate", "builtin", "--elements", "200", "-o", self.path("g.vtkhdf")],
                          ["scene", "export", self.sequence, "-o", self.path("e.vtkhdf")],
                          ["scene", "picture", self.sequence, "--size", "160x120", "-o", self.path("p.png")]):
            done = run(*arguments, env=none)
            self.assertEqual(done.returncode, 0, done.stderr)
            # The folder of the test has a long name. It is replaced by a name of usual length.
            self.fits((done.stdout + done.stderr).replace(self.folder.name, "out"), arguments)

    def test_near_names(self):
        data = {"VOLCCD_CACHE": self.path("no-cache")}
        for arguments, near in (
                (["detcet"], "'detect'"), (["scene", "lst"], "'list'"), (["experiment", "rnu"], "'run'"),
                (["detect", self.sequence, "--treads", "2"], "'--threads'"),
                (["scene", "generate", "builtin", "-o", self.path("x"), "--elemnts", "4"], "'--elements'"),
                (["detect", self.sequence, "--pipeline", "VolCD"], "'VolCCD'"),
                (["detect", self.sequence, "--pairs", "intre"], "'inter'"),
                (["detect", self.sequence, "--set", "brod-phase=kdop-bvh"], "'broad-phase'"),
                (["detect", self.sequence, "--set", "broad-phase=kdop-bhv"], "'kdop-bvh'"),
                (["detect", self.sequence, "--set", "csta.axis=face"], "'csat'"),
                (["detect", self.sequence, "--set", "csat.axes=face"], "'axis'"),
                (["detect", self.sequence, "--set", "csat.axis=centriod"], "'centroid'"),
                (["check", "csta"], "'csat'"),
                (["queries", self.sequence, "--candidates", "--narrowphase", "incluson"], "'inclusion'"),
                (["detect", "octopii"], "'octopi'"), (["info", "livre-quick"], "'liver-quick'"),
                (["scene", "generate", "octopy", "-o", self.path("x")], "'octopi'"),
                (["scene", "picture", self.sequence, "--objects", "Plat", "-o", self.path("x")], "'Plate'"),
                (["experiment", "run", "culing"], "'culling'"), (["experiment", "table", "table2"], "'table1'")):
            self.bad(*arguments, says=f"did you mean {near}", env=data)
        self.bad("detect", self.sequence, "--parts", "components", says="option '--parts' is called '--objects' now")
        self.bad("scene", "picture", self.sequence, "--step", "1", "-o", self.path("x"), says="called '--frames' now")
        done = run("detect", self.sequence, "--nothing-like-it")
        self.assertEqual((done.returncode, "did you mean" in done.stderr), (2, False), done.stderr)

    def test_the_manual_page_has_every_option(self):
        page = self.path("volccd.1")
        with open(page, "w", encoding="utf-8") as file:
            file.write(self.good("help", "--manual-page"))
        done = subprocess.run(["groff", "-man", "-Tutf8", "-ww", "-P-cbou", page], capture_output=True, text=True,
                              check=False) if shutil.which("groff") else self.skipTest("groff is not there")
        self.assertEqual((done.returncode, done.stderr), (0, ""))
        every = list(commands())
        for path in every:
            if any(other[:len(path)] == path and other != path for other in every):
                continue
            section = re.search(rf"^ +volccd {' '.join(path)}\b.*?\[options\]\n(.*?)(?=^ +volccd .*\[options\]$|\Z)",
                                done.stdout, re.MULTILINE | re.DOTALL)
            self.assertIsNotNone(section, path)
            for option in re.findall(r"^  (?:-\w,)?(--[a-z-]+)", self.good(*path, "--help"), re.MULTILINE):
                self.assertTrue(option in section[1] or option == "--help", f"{path}: {option}")

    def test_completion_in_bash(self):
        script = self.path("volccd.bash")
        with open(script, "w", encoding="utf-8") as file:
            file.write(self.good("help", "--completion", "bash"))

        def completed(*words):
            listed = " ".join(f"'{word}'" for word in ("volccd", *words))
            done = subprocess.run(["bash", "--norc", "-c", f"source '{script}'; COMP_WORDS=({listed}); "
                                   f"COMP_CWORD={len(words)}; _volccd; printf '%s\\n' \"${{COMPREPLY[@]}}\""],
                                  capture_output=True, text=True, check=False, cwd=self.folder.name)
            self.assertEqual((done.returncode, done.stderr), (0, ""), words)
            return done.stdout.split()

        self.assertEqual(completed("det"), ["detect"])
        self.assertEqual(completed("scene", ""), ["list", "generate", "picture", "export", "--help"])
        self.assertEqual(completed("detect", "--thr"), ["--threads"])
        self.assertEqual(completed("detect", "x.vtkhdf", "--pairs", "in"), ["inter", "intra"])
        self.assertEqual(completed("detect", "--pipeline", "VolCCD"), ["VolCCD", "VolCCD+", "VolCCD-2011"])
        self.assertEqual(completed("scene", "generate", "oct"), ["octopi"])
        self.assertEqual(completed("check", "csat-"), ["csat-2011"])
        self.assertEqual(completed("experiment", "run", "cul"), ["culling"])
        self.assertEqual(completed("info", "run"), ["run.vtkhdf"])
        self.assertEqual(completed("detect", "--json", "run"), ["run.vtkhdf"])
        self.assertEqual(completed("help", "ver"), ["verify"])

    def test_quiet(self):
        for arguments in (["info", self.sequence], ["detect", self.sequence, "--contacts", self.path("quiet.csv")],
                          ["verify", self.sequence], ["stages"], ["scene", "list"], ["check", "csat", "--trials", "5"],
                          ["scene", "generate", "builtin", "--elements", "200", "-o", self.path("quiet.vtkhdf")],
                          ["scene", "picture", self.sequence, "--size", "160x120", "-o", self.path("quiet.png")]):
            done = run(*arguments, "--quiet")
            self.assertEqual((done.returncode, done.stdout, done.stderr), (0, "", ""), arguments)
        for name in ("quiet.csv", "quiet.vtkhdf", "quiet.png"):
            self.assertTrue(os.path.getsize(self.path(name)))
        self.assertEqual(on_a_terminal("detect", self.sequence, "--quiet"), (0, ""))
        self.assertTrue(self.good("detect", self.sequence, "--contacts", "-", "--quiet").startswith("step,kind,"))
        self.bad("detect", self.path("absent"), "--quiet", says="absent")

    def test_progress_has_one_style(self):
        for arguments, what in ((["detect", self.sequence], "detecting: 1 of 4 steps"),
                                (["verify", self.sequence, "--no-fcl"], "verifying: 1 of 4 steps"),
                                (["info", self.sequence], "reading: 1 of 4 steps"),
                                (["check", "csat", "--trials", "20"], "checking csat: 1 of 20 trials"),
                                (["queries", self.sequence, "--candidates", "--steps", ":3", "--sample", "10"],
                                 "testing queries: 1 of 3 steps"),
                                (["scene", "picture", self.sequence, "--frames", "0,1,2", "--size", "300", "-o",
                                  os.devnull],
                                 "drawing: 1 of 3 panels"),
                                (["scene", "generate", "builtin", "--elements", "200", "--frames", "5", "-o",
                                  self.path("x.vtkhdf")], "computing builtin: 1 of 5 frames")):
            code, screen = on_a_terminal(*arguments)
            self.assertEqual(code, 0, screen)
            self.assertIn(what, screen)

    def test_info_simulates_nothing(self):
        cache = {"VOLCCD_CACHE": self.path("empty-cache")}
        self.bad("info", "liver-quick", env=cache, says="volccd scene generate liver --quick -o liver-quick.vtkhdf")
        self.bad("info", "octopi", env=cache, says="volccd scene generate octopi -o octopi.vtkhdf")
        self.assertFalse(os.path.exists(self.path("empty-cache")))

    def test_all_cores_are_the_default(self):
        cores = len(os.sched_getaffinity(0))
        self.assertIn(f" {cores} thread{'' if cores == 1 else 's'}\n", self.good("detect", self.sequence))
        self.assertIn(" 1 thread\n", self.good("detect", self.sequence, "--threads", "1"))
        for path in commands():
            shown = self.good(*path, "--help")
            if path != ("experiment", "run") and (threads := re.search(r"--threads N:.*", shown)):
                self.assertTrue(threads[0].endswith("=0"), f"{path}: {threads[0]}")

    def test_the_report_of_detect(self):
        shown = self.good("detect", self.sequence)
        self.assertIn(": VolCCD+, conservative", shown)
        self.assertIn("element pairs: without adjacent ones", shown)
        self.assertNotIn("initial overlaps", shown)
        step, toi = re.search(r"earliest contact: step (\d), t = (\S+) of the step", shown).groups()
        rows = self.contacts()[1:]
        first = min((int(row[0]), float(row[6])) for row in rows)
        self.assertEqual((int(step), toi), (first[0], f"{first[1]:.6f}"))
        self.assertRegex(shown, r"1 Projectile +2 Plate +\d+ +\d+ ")
        with_adjacent = self.good("detect", self.sequence, "--pipeline", "NavCCD")
        self.assertRegex(with_adjacent, r"element pairs: with [\d,]+ adjacent ones")
        header = re.search(r"^step .*time \[ms\]$", shown, re.MULTILINE)
        self.assertIsNotNone(header)
        overlaps = self.good("detect", self.sequence, "--overlaps", self.path("o.csv"))
        self.assertRegex(overlaps, r"initial\b")


if __name__ == "__main__":
    unittest.main()
