"""Ranks as processes: the exchange, and volccd-mpi against volccd. Usage: test_mpi.py MPIRUN TEST_MPI [VOLCCD VOLCCD_MPI].

Skipped where mpirun cannot start two processes."""

import json
import os
import re
import signal
import subprocess
import sys
import tempfile
import time
import unittest

MPIRUN, TEST_MPI, VOLCCD, VOLCCD_MPI = (sys.argv[1:5] + [None, None])[:4]
del sys.argv[1:]
DATA = os.path.join(os.path.dirname(os.path.dirname(os.path.dirname(os.path.dirname(os.path.abspath(__file__))))),
                    "shared", "data")
ENVIRONMENT = {**os.environ, "OMPI_ALLOW_RUN_AS_ROOT": "1", "OMPI_ALLOW_RUN_AS_ROOT_CONFIRM": "1",
               "OMPI_MCA_rmaps_base_oversubscribe": "1", "OMPI_MCA_btl_vader_single_copy_mechanism": "none"}
EXACT = ("--set", "inclusion.undecided=exact")


def run(*command):
    return subprocess.run(command, capture_output=True, text=True, env=ENVIRONMENT, check=False, timeout=240)


def ranks(count, *command):
    return run(MPIRUN, "-n", str(count), *command)


class Exchange(unittest.TestCase):
    def test_exchange(self):
        for count in (1, 2, 3, 4):
            result = ranks(count, TEST_MPI)
            self.assertEqual(result.returncode, 0, result.stdout + result.stderr)

    def test_an_exception_on_one_rank_ends_all_with_one_message(self):
        for count, rank in ((2, 0), (3, 1)):
            result = ranks(count, TEST_MPI, "fail", str(rank))
            self.assertEqual(result.returncode, 2)
            self.assertEqual(result.stderr.count(f"test_mpi: rank {rank} of {count}: no more paper\n"), 1, result.stderr)
            self.assertEqual(result.stderr.count("no more paper"), 1, result.stderr)

    def test_an_error_that_all_ranks_know_is_printed_once(self):
        result = ranks(3, TEST_MPI, "refuse", "2")
        self.assertEqual(result.returncode, 2)
        self.assertEqual(result.stderr.count("test_mpi: rank 2 of 3: printing: no more paper\n"), 1, result.stderr)
        self.assertEqual(result.stderr.count("no more paper"), 1, result.stderr)


@unittest.skipUnless(VOLCCD, "built without the program")
class Program(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.folder = tempfile.TemporaryDirectory()
        cls.sequence = cls.path("run.vtkhdf")
        made = run(VOLCCD, "scene", "generate", "builtin", "--elements", "300", "--frames", "5", "-o", cls.sequence)
        assert made.returncode == 0, made.stderr

    @classmethod
    def tearDownClass(cls):
        cls.folder.cleanup()

    @classmethod
    def path(cls, name):
        return os.path.join(cls.folder.name, name)

    def files(self, command):
        """Contacts and overlaps that a command writes."""
        names = [self.path("contacts.csv"), self.path("overlaps.csv")]
        result = run(*command, "--contacts", names[0], "--overlaps", names[1])
        self.assertEqual(result.returncode, 0, result.stderr)
        texts = []
        for name in names:
            with open(name, encoding="ascii") as file:
                texts.append(file.read())
            os.remove(name)
        self.assertEqual(os.listdir(self.folder.name), ["run.vtkhdf"])
        return texts

    def same(self, sequence, *options, counts=(1, 2, 3, 4)):
        serial = self.files([VOLCCD, "detect", sequence, *options])
        for count in counts:
            found = self.files([MPIRUN, "-n", str(count), VOLCCD_MPI, "detect", sequence, *options])
            for text, expected in zip(found, serial):
                self.assertTrue(text == expected, (sequence, options, count))
        return serial[0].count("\n") - 1

    def test_files_are_those_of_volccd(self):
        self.assertGreater(self.same(self.sequence, *EXACT), 20)
        for options in (("--first", *EXACT), ("--separation", "0.05"), ("--pipeline", "NavCCD", *EXACT, "--pairs", "inter"),
                        ("--motion", "quadratic", *EXACT), ("--objects", "components", "--pairs", "inter", *EXACT),
                        ("--steps", "1:3", "--edges", "polytope", *EXACT, "--threads", "2"),
                        ("--steps", "2:4", "--substeps", "5", "--lists", "0.02:5", *EXACT)):
            self.assertGreater(self.same(self.sequence, *options, counts=(3,)), 0)

    @unittest.skipUnless(os.path.isdir(DATA), f"there is no {DATA}")
    def test_files_of_shared_data_are_those_of_volccd(self):
        for name, options in (("ls-dyna-projectile", ("--steps", "4:6")), ("openradioss-crash", ("--steps", "60:62")),
                              ("openradioss-crash", ("--steps", "60", "--shells", "solid")),
                              ("openradioss-bullet", ("--steps", "40:42", "--motion", "quadratic"))):
            with self.subTest(name=name, options=options):
                sequence = os.path.join(DATA, name + ".vtkhdf")
                self.assertGreater(self.same(sequence, *options, *EXACT, counts=(2, 4)), 0)

    def refused(self, *command):
        result = run(MPIRUN, *command)
        self.assertEqual(result.returncode, 2, result.stderr)
        self.assertEqual(os.listdir(self.folder.name), ["run.vtkhdf"], "a file is left behind")
        return [line for line in result.stderr.splitlines() if line.startswith("volccd-mpi: ")]

    def test_errors_are_one_message_and_leave_no_file(self):
        contacts = ("--contacts", self.path("contacts.csv"))
        detect = (VOLCCD_MPI, "detect", self.sequence, *contacts)
        lines = self.refused("-n", "3", VOLCCD_MPI, "detect", self.path("none.vtkhdf"), *contacts)
        self.assertEqual(len(lines), 1, lines)
        self.assertIn("rank 0 of 3: options: " + self.path("none.vtkhdf"), lines[0])
        for options, part in ((("--steps", "7:9"), "rank 0 of 3: options: --steps: 7:9 is not within"),
                              (("--pipeline", "none"), "rank 0 of 3: options: "),
                              (("--separation", "1e9"), "is greater than the diagonal"),
                              (("--lists", "often"), "rank 0 of 3: options: --lists: 'often' is not off, auto")):
            lines = self.refused("-n", "3", *detect, *options)
            self.assertEqual(len(lines), 1, lines)
            self.assertIn(part, lines[0])

    def test_an_output_that_cannot_be_opened(self):
        lines = self.refused("-n", "3", VOLCCD_MPI, "detect", self.sequence, "--contacts", self.path("contacts.csv"),
                             "--overlaps", self.path("none/overlaps.csv"))
        self.assertEqual(len(lines), 1, lines)
        self.assertIn("none/overlaps.csv", lines[0])

    def test_ranks_with_other_options_do_not_hang(self):
        detect = (VOLCCD_MPI, "detect", self.sequence)
        for options, part in ((("--separation", "0.1"), "request of a step must be the same on all ranks"),
                              (("--pipeline", "NavCCD"), "options must be the same on all ranks"),
                              (("--steps", "9"), "rank 1 of 2: options: --steps: 9 is not within"),
                              (("--nonsense",), "--nonsense")):
            lines = self.refused("-n", "1", *detect, ":", "-n", "1", *detect, *options)
            self.assertEqual(len(lines), 1, lines)
            self.assertIn(part, lines[0])

    def test_statistics(self):
        names = [self.path("serial.json"), self.path("ranks.json")]
        for command in ((VOLCCD, "detect", self.sequence, "--stats", names[0]),
                        (MPIRUN, "-n", "3", VOLCCD_MPI, "detect", self.sequence, "--stats", names[1])):
            result = run(*command)
            self.assertEqual(result.returncode, 0, result.stderr)
        serial, ranks_of_it = [], []
        for name, kept in zip(names, (serial, ranks_of_it)):
            with open(name, encoding="utf-8") as file:
                kept.append(json.load(file))
            os.remove(name)
        one, three = serial[0], ranks_of_it[0]
        self.assertEqual(len(three["ranks"]), 3)
        self.assertEqual([(s["step"], s["contacts"], s["earliest_toi"]) for s in three["steps"]],
                         [(s["step"], s["contacts"], s["earliest_toi"]) for s in one["steps"]])
        for key in ("contacts", "tests"):
            self.assertEqual(sum(rank[key] for rank in three["ranks"]), sum(step[key] for step in three["steps"]), key)
        self.assertEqual((three["pipeline"]["name"], three["sequence"]), (one["pipeline"]["name"], one["sequence"]))
        self.assertLessEqual(max(step["slowest_seconds"] for step in three["steps"]),
                             max(rank["seconds"] for rank in three["ranks"]) + 1e-6)

    def test_candidate_lists_of_substeps_are_used(self):
        result = ranks(2, VOLCCD_MPI, "detect", self.sequence, "--steps", "2:4", "--substeps", "20", "--lists", "0.02:20",
                       "--stats", self.path("stats.json"))
        self.assertEqual(result.returncode, 0, result.stderr)
        made, used = (int(n) for n in re.search(r": (\d+) made one, \d+ refreshed one, (\d+) used one",
                                                result.stdout).groups())
        self.assertGreater(made, 0)
        self.assertGreater(used, made)
        self.assertLessEqual(made + used, 2 * 2 * 20)
        with open(self.path("stats.json"), encoding="utf-8") as file:
            stats = json.load(file)
        os.remove(self.path("stats.json"))
        self.assertEqual((stats["substeps"], [s["step"] for s in stats["steps"]]), (20, [2, 3]))

    def test_ctrl_c_ends_all_ranks_and_leaves_no_file(self):
        long = self.path("long.vtkhdf")
        made = run(VOLCCD, "scene", "generate", "builtin", "--elements", "6000", "--frames", "60", "-o", long)
        self.assertEqual(made.returncode, 0, made.stderr)
        self.addCleanup(os.remove, long)
        contacts = self.path("contacts.csv")
        with subprocess.Popen([MPIRUN, "-n", "2", VOLCCD_MPI, "detect", long, "--pipeline", "NavCCD", "--contacts", contacts],
                              env=ENVIRONMENT, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True) as running:
            end = time.monotonic() + 60
            while not any("contacts.csv" in name for name in os.listdir(self.folder.name)):
                self.assertLess(time.monotonic(), end, "no output was begun")
                self.assertIsNone(running.poll(), "ended too early")
                time.sleep(0.05)
            running.send_signal(signal.SIGINT)
            _, problem = running.communicate(timeout=60)
        self.assertNotEqual(running.returncode, 0, problem)
        self.assertEqual(sorted(os.listdir(self.folder.name)), ["long.vtkhdf", "run.vtkhdf"], problem)

    def test_help_and_version_are_printed_once(self):
        for option, text in (("--help", "volccd-mpi"), ("--version", "volccd-mpi ")):
            result = ranks(3, VOLCCD_MPI, option)
            self.assertEqual(result.returncode, 0, result.stderr)
            self.assertIn(text, result.stdout)
        self.assertEqual(ranks(3, VOLCCD_MPI, "--version").stdout.count("\n"), 1)


if __name__ == "__main__":
    if ranks(2, "true").returncode != 0:
        print(f"skipped: {MPIRUN} cannot start two processes")
        sys.exit(77)
    unittest.main()
