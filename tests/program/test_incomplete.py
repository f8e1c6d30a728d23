"""Results that were complete before an error, a full disk or Ctrl-C are kept, and the output is marked as incomplete."""

import json
import os
import re
import time
import unittest

from program_support import run, with_bad_last_step, Interruption, ProgramTest


class Incomplete(ProgramTest):
    @classmethod
    def setUpClass(cls):
        super().setUpClass()
        cls.long = cls.path("long.vtkhdf")
        made = run("scene", "generate", "builtin", "--elements", "3000", "--frames", "150", "-o", cls.long)
        assert made.returncode == 0, made.stderr
        cls.large = cls.path("large.vtkhdf")
        made = run("scene", "generate", "builtin", "--elements", "60000", "--frames", "4", "-o", cls.large)
        assert made.returncode == 0, made.stderr
        begin = time.monotonic()
        run("info", cls.large, "--steps", "0")
        # Far less than the steps that are interrupted take; more where a step takes long to read (with sanitizers, or on
        # a busy machine).
        cls.patience = max(3.0, 5 * (time.monotonic() - begin))

    def whole_contacts(self, sequence):
        return self.good("detect", sequence, "--contacts", "-").splitlines()

    def check_incomplete(self, lines, whole, first=1):
        """Checks that the mark gives the number of complete steps, and that these have all their rows. Returns
        their number."""
        mark = re.fullmatch(r"# incomplete: steps 0 to (\d+) of 0 to (\d+) are complete; (.*)", lines[-1])
        self.assertTrue(mark, lines[-1])
        last = int(mark[1])
        self.assertEqual(lines[:-1], whole[:1] + [row for row in whole[1:] if int(row.split(",")[0]) <= last])
        self.assertGreaterEqual(last + 1, first)
        self.assertLess(last, int(mark[2]))
        return last + 1

    def test_full_disk(self):
        target = self.path("full.vtkhdf")
        for disk in (0, 100, 2000, 20000, 100000):
            done = run("scene", "generate", "builtin", "-o", target, disk=disk)
            self.assertEqual(done.returncode, 2, (disk, done.stderr))
            self.assertIn("full.vtkhdf: ", done.stderr)
            self.assertIn("File too large", done.stderr)
            self.assertFalse(os.path.exists(target))
        target = self.write("full.png", "old")
        done = run("scene", "picture", self.sequence, "-o", target, disk=500)
        self.assertEqual(done.returncode, 2)
        self.assertIn("full.png: cannot be written: File too large", done.stderr)
        self.assertEqual(self.read("full.png"), b"old")
        target, whole = self.path("full.csv"), self.whole_contacts(self.long)
        done = run("detect", self.long, "--contacts", target, disk=sum(len(row) + 1 for row in whole) // 2)
        self.assertEqual(done.returncode, 2, done.stderr)
        self.assertIn("full.csv: cannot be written: File too large", done.stderr)
        self.check_incomplete(self.read("full.csv").decode().splitlines(), whole, first=10)
        self.no_leftovers()

    def test_a_bad_step_leaves_those_before(self):
        source, contacts, stats = self.path("bad.vtkhdf"), self.path("bad.csv"), self.path("bad.json")
        with open(source, "wb") as file:
            file.write(with_bad_last_step(self.read("run.vtkhdf")))
        done = run("detect", source, "--contacts", contacts, "--stats", stats,
                   "--overlaps", self.path("bad-overlaps.csv"))
        self.assertEqual(done.returncode, 2)
        self.assertIn("incomplete: steps 0 to 2 of 0 to 3 are complete; " + source, done.stderr)
        self.assertIn("incomplete: steps 0 to 2 of 0 to 3", done.stdout)
        lines = self.read("bad.csv").decode().splitlines()
        self.assertEqual(self.check_incomplete(lines, self.whole_contacts(self.sequence)), 3)
        self.assertIn(b"\n# incomplete: steps 0 to 2 of 0 to 3", self.read("bad-overlaps.csv"))
        record = json.loads(self.read("bad.json"))
        self.assertEqual((record["complete"], record["steps_done"], record["steps_asked"], len(record["steps"])),
                         (False, 3, [0, 4], 3))
        self.assertIn("bad.vtkhdf", record["stopped_by"])
        self.bad("scene", "picture", source, "--contacts-from", contacts, "-o", self.path("bad.png"), says="incomplete")
        done = run("verify", source, "--no-fcl")
        self.assertEqual(done.returncode, 2)
        self.assertIn("no difference in these steps\n\nincomplete: steps 0 to 2 of 0 to 3", done.stdout)
        done = run("detect", source, "--steps", "3", "--contacts", contacts)
        self.assertEqual((done.returncode, self.read("bad.csv").decode().splitlines()), (2, lines),
                         "no step: nothing new")

    def test_ctrl_c_keeps_complete_steps(self):
        contacts, stats = self.path("cut.csv"), self.path("cut.json")
        whole = self.whole_contacts(self.long)
        cut = Interruption("detect", self.long, "--contacts", contacts, "--stats", stats, done=40)
        self.assertEqual(cut.code, 130, cut.screen)
        lines = self.read("cut.csv").decode().splitlines()
        steps = self.check_incomplete(lines, whole, first=40)
        self.assertTrue(lines[-1].endswith("; interrupted"))
        for text in (cut.out, cut.screen):
            self.assertIn(f"incomplete: steps 0 to {steps - 1} of 0 to 148 are complete; interrupted", text)
        record = json.loads(self.read("cut.json"))
        self.assertEqual((record["complete"], record["steps_done"], record["stopped_by"]),
                         (False, steps, "interrupted"))
        self.good("detect", self.sequence, "--stats", stats)
        record = json.loads(self.read("cut.json"))
        self.assertEqual((record["complete"], record["steps_done"], record["stopped_by"]), (True, 4, None))
        cut = Interruption("info", self.long, done=40)
        self.assertEqual(cut.code, 130)
        self.assertIn("incomplete: steps 0 to ", cut.out)
        self.no_leftovers()

    def test_ctrl_c_within_a_step(self):
        """If steps take many seconds, none is complete, and earlier results are kept."""
        contacts = self.write("old.csv", "old")
        for arguments in (["detect", self.large, "--pipeline", "BruteForce", "--contacts", contacts],
                          ["verify", self.large], ["verify", self.large, "--threads", "2"]):
            for delay in (0.5, 2):
                cut = Interruption(*arguments, done=0, delay=delay)
                self.assertEqual(cut.code, 130, cut.screen)
                self.assertLess(cut.seconds, self.patience)
                self.assertIn("interrupted before the first step was complete", cut.screen)
        self.assertEqual(self.read("old.csv"), b"old")
        cut = Interruption("queries", self.large, "--candidates", "--judge", "exact", done=0, delay=0.5)
        self.assertEqual(cut.code, 130, cut.screen)
        self.assertLess(cut.seconds, self.patience)
        self.assertIn("interrupted before the first group", cut.screen)
        self.no_leftovers()

    def test_verify_and_queries_say_that_they_were_cut(self):
        cut = Interruption("verify", self.long, "--no-fcl", done=2)
        self.assertEqual(cut.code, 130, cut.screen)
        self.assertLess(cut.seconds, self.patience)
        self.assertRegex(cut.out, r"no difference in these steps\n\n"
                                  r"incomplete: steps 0 to \d+ of 0 to 148 are complete; inter")
        self.assertIn("incomplete: steps 0 to ", cut.screen)
        for json_wanted in (False, True):
            cut = Interruption("queries", self.long, "--candidates", "--steps", ":50", "--sample", "5000",
                               *(["--json"] if json_wanted else []), done=7)
            self.assertEqual(cut.code, 130, cut.screen)
            self.assertIn("group(s) of queries are complete; interrupted", cut.screen)
            if json_wanted:
                record = json.loads(cut.out)
                self.assertEqual((record["complete"], record["stopped_by"]), (False, "interrupted"))
                self.assertGreater(len(record["groups"]), 10)
            else:
                self.assertIn("group(s) of queries are complete; interrupted", cut.out)

    def test_a_sequence_cut_short_says_so(self):
        target = self.path("cut.vtkhdf")
        cut = Interruption("scene", "generate", "builtin", "--elements", "3000", "--frames", "500", "-o", target,
                           done=5)
        self.assertEqual(cut.code, 130, cut.screen)
        self.assertIn("are complete; interrupted", cut.screen)
        info = self.good("info", target)
        done = run("detect", target, "--steps", "0")
        self.assertEqual(done.returncode, 0)
        self.assertRegex(done.stderr,
                         r"cut.vtkhdf is incomplete: frames 0 to \d+ of 0 to 499 are complete; interrupted")
        self.assertRegex(info, r"INCOMPLETE frames 0 to \d+ of 0 to 499 are complete; interrupted")


if __name__ == "__main__":
    unittest.main()
