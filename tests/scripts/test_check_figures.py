"""scripts/check_figures: the figures of this tree are those of its records, and it finds those that are not."""

import json
import os
import subprocess
import sys
import tempfile
import unittest

ROOT = os.path.dirname(os.path.dirname(os.path.dirname(os.path.abspath(__file__))))

PAGE = """# Speed

VolCCD takes 2.5 ms a step, and 1,234 tests
are left. The limit is 3 %.

    volccd detect --separation 0.25

| scene | ms |
|---|---|
| octopi | 2.50 |
"""
LIST = """# a comment
ms(scene) = mean(steps(rows("plus", scene=scene), "seconds")) * 1000
[README.md]
VolCCD takes {} ms a step, and {} tests are left :: ms("octopi");
    summary("plus", scene="octopi")["tests"]
for scene: octopi
| $scene | {} | :: ms(scene)
limit is 3 % !! a limit
"""


class CheckFigures(unittest.TestCase):
    def setUp(self):
        self.folder = tempfile.TemporaryDirectory()
        self.addCleanup(self.folder.cleanup)

    def write(self, name, text):
        path = os.path.join(self.folder.name, name)
        os.makedirs(os.path.dirname(path), exist_ok=True)
        with open(path, "w", encoding="utf-8") as file:
            file.write(text)

    def check(self, code, root=None, says=(), page=PAGE, entries=LIST, seconds=0.0025):
        if root is None:
            root = self.folder.name
            self.write("README.md", page)
            self.write("results/README.md", "# Results\n")
            self.write("scripts/figures.list", entries)
            rows = [{"scene": "octopi", "step": 0, "seconds": value} for value in (seconds, seconds, 1.0)]
            self.write("results/plus.json", json.dumps({"rows": rows, "summary": [{"scene": "octopi", "tests": 1234}]}))
        done = subprocess.run([sys.executable, "-B", os.path.join(ROOT, "scripts/check_figures"), "--root", root],
                              capture_output=True, text=True, check=False)
        self.assertEqual(done.returncode, code, done.stdout + done.stderr)
        for text in says:
            self.assertIn(text, done.stdout + done.stderr)

    def test_the_figures_of_this_tree(self):
        self.check(0, root=ROOT)

    def test_figures_of_records_pass(self):
        self.check(0, says=["3 figures are those of records, 1 exceptions, 0 findings"])

    def test_figures_of_other_records_are_found(self):
        self.check(1, seconds=0.0026, says=["README.md:3: 2.5 is 2.6 in the records", "README.md:10: 2.50 is 2.60"])

    def test_figures_of_new_records_are_written(self):
        page = PAGE.replace("2.5 ms", "2.5\nms")
        self.check(1, page=page, seconds=1.2345)
        command = [sys.executable, "-B", os.path.join(ROOT, "scripts/check_figures"), "--root", self.folder.name]
        written = subprocess.run([*command, "--write"], capture_output=True, text=True, check=False)
        self.assertEqual(written.returncode, 0, written.stdout + written.stderr)
        with open(os.path.join(self.folder.name, "README.md"), encoding="utf-8") as file:
            self.assertEqual(file.read(), page.replace("2.50", "1,234.50").replace("2.5\nms", "1,234.5\nms"))
        self.assertEqual(subprocess.run(command, capture_output=True, check=False).returncode, 0)

    def test_drawings_of_other_records_are_found(self):
        self.write("results/figures/new.svg", "<text>Commit</text><text>abc1234.</text>")
        self.write("results/figures/old.svg", "<text>Commit 0123456.</text>")
        self.write("results/other.json", json.dumps({"rows": [], "summary": [], "provenance": {"commit": "abc1234ff"}}))
        self.check(1, says=["1 findings", "results/figures/old.svg:1: is of commit 0123456"])

    def test_figures_without_an_entry_are_found(self):
        for text, says in (("It is 12x faster.", "12 is bound to no record"), ("5 ms more.", "5 is bound"),
                           ("4,321 pairs", "4,321 is bound"), ("a factor of 1.07", "1.07 is bound"),
                           ("| a | 17 |", "17 is bound")):
            self.check(1, page=PAGE + "\n" + text + "\n", says=["README.md:12: " + says, "1 findings"])

    def test_text_that_has_changed_is_found(self):
        self.check(1, page=PAGE.replace("are left", "remain"),
                   says=["is 0 times in the page, see scripts/figures.list:4", "2.5 is bound to no record"])

    def test_a_list_that_cannot_be_read(self):
        for broken in ('VolCCD takes {} ms :: 1 / 0', 'VolCCD takes {} ms :: rows("absent")',
                       'VolCCD takes {} ms :: rows("plus", scene="none")', 'VolCCD takes {} ms :: unknown',
                       'VolCCD takes {} ms :: 1; 2', 'limit is 3 % !! '):
            self.check(2, entries=LIST + broken + "\n", says=["scripts/figures.list:9: "])
        self.check(2, entries="[ABSENT.md]\n", says=["scripts/figures.list:1: "])


if __name__ == "__main__":
    unittest.main()
