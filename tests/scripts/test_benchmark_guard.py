#!/usr/bin/env python3
"""benchmark-guard: what counts as slower, and a complete run with two programs made for the test."""

import contextlib
import importlib.machinery
import importlib.util
import io
import os
import tempfile
import unittest
from pathlib import Path

SCRIPT = Path(__file__).resolve().parents[2] / "scripts/benchmark-guard"
LOADER = importlib.machinery.SourceFileLoader("benchmark_guard", str(SCRIPT))
guard = importlib.util.module_from_spec(importlib.util.spec_from_loader("benchmark_guard", LOADER))
LOADER.exec_module(guard)

# A program that makes empty scenes, and writes statistics with a chosen time of culling.
PROGRAM = """#!/bin/sh
for word; do last=$word; done
[ "$1" = scene ] && { : >"$last"; exit; }
cat >"$last" <<JSON
{"total": {"seconds": %(step)s, "vf_tests": %(tests)s, "ee_tests": 1, "contacts": 1, "stages": [
  {"role": "element-culling", "name": "csat", "prepare_seconds": 0.1, "seconds": %(culling)s},
  {"role": "assignment", "name": "all-pairs", "prepare_seconds": 0.0, "seconds": %(small)s}]}}
JSON
"""


class Judge(unittest.TestCase):
    def test_a_rise_within_the_spread_is_none(self):
        self.assertEqual(guard.judge([1.0, 1.0, 1.0], [1.04, 1.04, 1.04])[2], "slower")
        self.assertEqual(guard.judge([1.0, 1.0, 1.0], [1.02, 1.02, 1.02])[2], "")
        self.assertEqual(guard.judge([0.9, 1.0, 1.1], [1.15, 1.15, 1.15])[2], "")
        self.assertEqual(guard.judge([1.0, 1.0, 1.0], [1.0, 1.15, 1.3])[2], "")
        self.assertEqual(guard.judge([1.0, 1.0, 1.0], [0.9, 0.9, 0.9])[2], "faster")
        self.assertEqual(guard.judge([1000], [1011], guard.LEAST_INSTRUCTIONS)[2], "slower")
        self.assertEqual(guard.judge([0.0, 0.0], [0.0, 0.0])[2], "")
        self.assertEqual(guard.judge([0.0, 0.0], [1.0, 1.0])[2], "slower")
        self.assertEqual(guard.judge([1.0, 1.0], [0.0, 0.0])[2], "faster")


class Runs(unittest.TestCase):
    def setUp(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.folder = Path(folder.name)
        data = os.environ.get("VOLCCD_DATA")
        os.environ["VOLCCD_DATA"] = folder.name  # only scenes that are computed
        self.addCleanup(lambda: os.environ.update(VOLCCD_DATA=data) if data else os.environ.pop("VOLCCD_DATA"))

    def program(self, name, culling, tests=1):
        file = self.folder / name
        numbers = {"culling": culling, "step": 1 + culling, "small": culling / 1000, "tests": tests}
        file.write_text(PROGRAM % numbers, encoding="utf-8")
        file.chmod(0o755)
        return str(file)

    def guard(self, *arguments):
        out, err = io.StringIO(), io.StringIO()
        with contextlib.redirect_stdout(out), contextlib.redirect_stderr(err):
            code = guard.main([*arguments, "--rounds", "2", "--only", "hexahedra VolCCD+", "--folder",
                               str(self.folder / "scratch")])
        return code, out.getvalue(), err.getvalue()

    def test_exit_code_tells_whether_a_stage_got_slower(self):
        one, same, slow = (self.program(name, seconds) for name, seconds in (("one", 1), ("same", 1), ("slow", 1.5)))
        code, out, _ = self.guard(one, same)
        self.assertEqual(code, 0, out)
        self.assertIn("0 slower", out)
        code, out, _ = self.guard(one, slow)
        self.assertEqual(code, 1)
        self.assertRegex(out, r"element-culling csat +1100\.000 +1600\.000 +1\.455 +3\.0 % +slower\n")
        # the times are too small to be compared
        self.assertRegex(out, r"assignment all-pairs +1\.000 +1\.500 +1\.500 +3\.0 %\n")
        code, out, _ = self.guard(slow, one)
        self.assertEqual(code, 0)
        self.assertIn("faster", out)

    def test_other_counts_are_said(self):
        code, out, _ = self.guard(self.program("one", 1), self.program("other", 1, tests=2))
        self.assertEqual(code, 0)
        self.assertIn("hexahedra VolCCD+: other counts", out)

    def test_what_cannot_be_run_is_refused(self):
        code, _, err = self.guard("no-such-commit", "HEAD")
        self.assertEqual(code, 2)
        self.assertIn("no-such-commit: is no commit of this repository, and no program", err)


if __name__ == "__main__":
    unittest.main()
