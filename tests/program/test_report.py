"""`report` and `view`: their output, their errors, and their messages about missing scenes. The page itself is
tested in a browser by tests/report/test_page.py."""

import json
import os
import re
import shutil
import unittest

from program_support import Interruption, copy_results, run, ProgramTest


class Report(ProgramTest):
    @classmethod
    def setUpClass(cls):
        super().setUpClass()
        cls.page = cls.path("page")
        os.mkdir(cls.page)
        for name in ("index.html", "volccd.css", "volccd.js"):
            with open(os.path.join(cls.page, name), "w", encoding="ascii") as file:
                file.write(name)
        cls.results = cls.path("results")
        os.mkdir(cls.results)
        copy_results(cls.path("all-results"))
        for name in ("plus.json", "scenes.json"):
            shutil.copy(os.path.join(cls.path("all-results"), name), cls.results)

    def environment(self, **more):
        return {"VOLCCD_PAGE": self.page, "VOLCCD_CACHE": self.path("cache"), "VOLCCD_DATA": self.path("none"), **more}

    def data(self, folder):
        text = self.read(os.path.join(folder, "data", "report.js")).decode()
        self.assertTrue(text.startswith("volccd_report = ") and text.endswith(";\n"))
        return json.loads(text[len("volccd_report = "):-2])

    def test_report_lists_records_and_how_to_get_missing_scenes(self):
        out = self.good("report", self.results, "-o", self.path("a"), env=self.environment())
        self.assertIn("a/index.html", out)
        data = self.data("a")
        self.assertEqual([r["name"] for r in data["records"]], ["plus", "scenes"])
        missing = {s["name"]: s["missing"] for s in data["scenes"]}
        (octopi,) = [name for name in missing if name.startswith("octopi-")]
        # The second, if the scene has changed since the records of results/ were made.
        self.assertRegex(missing[octopi], r"^volccd (scene generate octopi( --quick)? -o octopi(-quick)?\.vtkhdf|"
                                          r"experiment run plus \(the record is of another version of the scene\))$")
        self.assertIn("VOLCCD_DATA", missing["cloth-ball"])
        self.assertEqual(missing["octopus2-105k-deformed"], "volccd experiment run plus")
        self.assertIn("octopi: not shown", out)
        self.assertFalse(os.path.exists(self.path("cache")))  # nothing was simulated
        self.assertEqual(self.read("a/index.html"), b"index.html")

    def test_record_of_another_version_of_a_scene(self):
        results = self.path("old")
        os.mkdir(results)
        with open(os.path.join(self.results, "plus.json"), encoding="utf-8") as file:
            text = re.sub(r"(octopi-\S*-version-)[0-9.]+(?=\.vtkhdf)", r"\g<1>0.1", file.read())
        with open(os.path.join(results, "plus.json"), "w", encoding="utf-8") as file:
            file.write(text)
        out = self.good("report", results, "-o", self.path("of-old"), env=self.environment())
        self.assertIn("experiment run plus (the record is of another version of the scene)", out)

    def test_report_without_scenes(self):
        self.good("report", self.results, "--scenes", "none", "-o", self.path("b"), env=self.environment())
        self.assertEqual(self.data("b")["scenes"], [])
        self.assertLess(os.path.getsize(self.path("b/data/report.js")), 1_000_000)

    def test_report_shows_scenes_that_are_there_and_says_when_they_differ(self):
        os.makedirs(self.path("data"), exist_ok=True)
        shutil.copy(self.sequence, self.path("data/cloth-ball.vtkhdf"))
        self.good("report", self.results, "--scenes", "cloth-ball", "-o", self.path("c"),
                  env=self.environment(VOLCCD_DATA=self.path("data")))
        (scene,) = self.data("c")["scenes"]
        self.assertEqual(scene["data"], "data/scene-cloth-ball.js")
        self.assertIn("differs", " ".join(scene["notes"]))
        self.assertTrue(self.read("c/data/scene-cloth-ball.js").startswith(b'volccd_scene("cloth-ball", "'))
        # With a picture beside the records; nothing else there is copied.
        os.makedirs(os.path.join(self.results, "pictures"))
        self.addCleanup(shutil.rmtree, os.path.join(self.results, "pictures"))
        for name in ("cloth-ball", "unknown"):
            with open(os.path.join(self.results, "pictures", name + ".png"), "wb") as file:
                file.write(b"picture of " + name.encode())
        self.good("report", self.results, "--scenes", "cloth-ball", "-o", self.path("c"),
                  env=self.environment(VOLCCD_DATA=self.path("data")))
        (scene,) = self.data("c")["scenes"]
        self.assertEqual(self.read("c/" + scene["picture"]), b"picture of cloth-ball")
        self.assertEqual(sorted(os.listdir(self.path("c/data"))),
                         ["report.js", "scene-cloth-ball.js", "scene-cloth-ball.png"])
        # Another report in the same folder leaves no scene and no picture of the old one.
        self.good("report", self.results, "--scenes", "none", "-o", self.path("c"), env=self.environment())
        self.assertEqual(os.listdir(self.path("c/data")), ["report.js"])
        self.no_leftovers()

    def test_view(self):
        self.good("view", self.sequence, "-o", self.path("v"), env=self.environment())
        data = self.data("v")
        self.assertEqual((data["records"], len(data["scenes"])), ([], 1))
        whole = os.path.getsize(self.path("v/data/scene-run.js"))
        out = self.good("view", self.sequence, "--no-contacts", "-o", self.path("v"), env=self.environment())
        self.assertLess(os.path.getsize(self.path("v/data/scene-run.js")), whole)
        self.assertRegex(out, r"index\.html \(\S+ KB\) written")

    def test_ctrl_c_leaves_the_earlier_report(self):
        long = self.path("long.vtkhdf")
        self.good("scene", "generate", "builtin", "--elements", "3000", "--frames", "150", "-o", long)
        os.makedirs(self.path("interrupted"), exist_ok=True)
        for command, source, name in (("report", self.results, "cloth-ball"), ("view", long, "long")):
            with self.subTest(command):
                environment = self.environment(VOLCCD_DATA=self.path("interrupted"))
                target = self.path("whole-" + command)
                if command == "report":
                    shutil.copy(self.sequence, self.path("interrupted/cloth-ball.vtkhdf"))
                    arguments = [command, source, "--scenes", name, "-o", target]
                else:
                    arguments = [command, source, "-o", target]
                self.good(*arguments, env=environment)
                before = self.texts(target)
                self.assertIn(f"data/scene-{name}.js", before)
                shutil.copy(long, self.path("interrupted/cloth-ball.vtkhdf"))
                cut = Interruption(*arguments, env=environment, done=3)
                self.assertEqual(cut.code, 130, cut.screen)
                self.assertIn("interrupted", cut.screen)
                self.assertEqual(self.texts(target), before)
                new = self.path("new-" + command)
                cut = Interruption(*arguments[:-1], new, env=environment, done=3)
                self.assertEqual((cut.code, os.path.exists(new)), (130, False), cut.screen)
                self.good(*arguments, env=environment)  # the same command again
        self.no_leftovers()

    @staticmethod
    def texts(folder):
        """The bytes of all files in a folder, by their paths."""
        paths = (os.path.join(place, name) for place, _, names in os.walk(folder) for name in names)
        texts = {}
        for path in paths:
            with open(path, "rb") as file:
                texts[os.path.relpath(path, folder)] = file.read()
        return texts

    def test_the_page_is_not_overwritten(self):
        self.bad("report", self.results, "-o", self.page, says="the page from which all reports are made",
                 env=self.environment())
        self.assertEqual(sorted(os.listdir(self.page)), ["index.html", "volccd.css", "volccd.js"])

    def test_refusals(self):
        empty = self.path("empty")
        os.makedirs(empty, exist_ok=True)
        self.bad("view", self.sequence, "-o", self.path("x"), says="scripts/build-report",
                env=self.environment(VOLCCD_PAGE=empty))
        self.bad("view", self.sequence, "-o", os.path.dirname(self.sequence), says="no report of volccd",
                env=self.environment())
        self.bad("view", self.path("no.vtkhdf"), "-o", self.path("x"), says="no.vtkhdf", env=self.environment())
        self.bad("view", self.sequence, "--pipeline", "Vol", "-o", self.path("x"), says="VolCCD+",
                env=self.environment())
        self.bad("report", empty, "-o", self.path("x"), says="volccd experiment run", env=self.environment())
        self.bad("report", self.results, says="--output", env=self.environment())
        self.write("results/culling.json", "{")
        self.bad("report", self.results, "-o", self.path("x"), says="culling.json", env=self.environment())
        os.remove(self.path("results/culling.json"))
        self.assertFalse(os.path.exists(self.path("x")))

    def test_help_has_examples(self):
        for command in ("report", "view"):
            text = run(command, "--help").stdout
            self.assertGreaterEqual(len(re.findall(rf"^  volccd {command} ", text, re.MULTILINE)), 3)


if __name__ == "__main__":
    unittest.main()
