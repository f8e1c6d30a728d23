"""detect and verify: contacts, the options that select them, and their output."""

import re
import json
import os
import unittest

from program_support import SOURCE, run, ProgramTest


class Detect(ProgramTest):
    def test_all_pipelines_write_the_same_contacts(self):
        expected = self.contacts("--pipeline", "BruteForce")
        self.assertEqual(expected[0], ("step,kind,a,b,c,d,toi,nx,ny,nz,px,py,pz,at_start,object_1,object_2,"
                                       "element_1,element_2").split(","))
        self.assertGreater(len(expected), 20)
        for pipeline in ("NavCCD", "HashCCD", "VolCCD", "VolCCD+"):
            for threads in ("1", "3"):
                self.assertEqual(self.contacts("--pipeline", pipeline, "--threads", threads), expected, pipeline)

    def test_first_is_the_earliest_row_of_each_step(self):
        earliest = {}
        for row in self.contacts()[1:]:
            earliest[row[0]] = min(earliest.get(row[0], 2.0), float(row[6]))
        first = self.contacts("--first")[1:]
        self.assertEqual({row[0]: float(row[6]) for row in first}, earliest)

    def test_substeps_have_the_same_contacts_with_lists(self):
        substeps = ("--substeps", "6", "--separation", "0.05")
        fresh = self.contacts(*substeps, "--lists", "off")
        self.assertGreater(len(fresh), 20)
        self.assertEqual({int(row[0]) // 6 for row in fresh[1:]}, {int(row[0]) for row in self.contacts()[1:]})
        for lists in ("auto", "0.05:4", "0:0"):
            self.assertEqual(self.contacts(*substeps, "--lists", lists), fresh, lists)
        for bad in ("on", "1", "1:2x", "-1:2", "nan:1"):
            self.assertEqual(run("detect", self.sequence, "--lists", bad).returncode, 2, bad)

    def test_ranks_have_the_same_contacts(self):
        substeps = ("--substeps", "6", "--separation", "0.05", "--lists")
        for options in ((), ("--first",), ("--separation", "0.05"), ("--pipeline", "NavCCD"), ("--pairs", "inter"),
                        (*substeps, "auto"), (*substeps, "0.05:4")):
            whole = self.contacts(*options)
            self.assertGreater(len(whole), 0)
            for ranks in ("1", "3", "16"):
                self.assertEqual(self.contacts(*options, "--ranks", ranks), whole, (options, ranks))
        self.assertIn("slowest rank / mean", self.good("detect", self.sequence, "--ranks", "3"))

    def test_steps_select(self):
        everything = self.contacts()[1:]
        for text, steps in (("1:3", "12"), (":2", "01"), ("2:", "23"), ("3", "3")):
            self.assertEqual(self.contacts("--steps", text)[1:], [row for row in everything if row[0] in steps], text)

    def test_pair_scopes_partition(self):
        inter, intra = self.contacts("--pairs", "inter")[1:], self.contacts("--pairs", "intra")[1:]
        self.assertTrue(inter)
        self.assertEqual(sorted(inter + intra), sorted(self.contacts()[1:]))

    def test_stats(self):
        target = self.path("stats.json")
        self.good("detect", self.sequence, "--stats", target, "--set", "csat.axis=centroid", "--pipeline", "VolCCD")
        with open(target, encoding="utf-8") as file:
            stats = json.load(file)
        self.assertEqual(stats["pipeline"]["name"], "VolCCD")
        self.assertEqual(stats["pipeline"]["element_culling"][0]["options"]["axis"], "centroid")
        self.assertEqual(len(stats["steps"]), 4)
        self.assertEqual(sum(step["contacts"] for step in stats["steps"]), stats["total"]["contacts"])
        self.assertEqual(stats["total"]["contacts"], len(self.contacts()) - 1)
        self.assertIn("cpu", stats["machine"])
        self.assertTrue(all(stage["seconds"] >= 0 for stage in stats["total"]["stages"]))

    def test_settings_change_stages_and_not_contacts(self):
        expected = self.contacts()
        for settings in (["broad-phase=spatial-hash"], ["element-culling=none"], ["assignment=all-pairs"],
                         ["orphans=none", "assignment=all-pairs"],
                         ["feature-filter=feature-kdop,coplanarity"], ["kdop-bvh.k=24", "csat.axis=optimal"],
                         ["assignment=static-assignment", "orphans=none", "feature-filter=none"]):
            arguments = [word for setting in settings for word in ("--set", setting)]
            self.assertEqual(self.contacts("--pipeline", "VolCCD", *arguments), expected, settings)

    def test_initial_overlaps(self):
        target = self.path("overlaps.csv")
        texts = set()
        for arguments in (["--pipeline", "VolCCD"], ["--pipeline", "VolCCD+", "--threads", "2"],
                          ["--pipeline", "HashCCD"], ["--first"]):
            self.good("detect", self.sequence, "--overlaps", target, "--stats", self.path("stats.json"), *arguments)
            with open(target, encoding="ascii") as file:
                texts.add(file.read())
        self.assertEqual(len(texts), 1)
        rows = texts.pop().splitlines()
        self.assertEqual(rows[0], "step,a,b")
        with open(self.path("stats.json"), encoding="utf-8") as file:
            self.assertEqual(json.load(file)["total"]["initial_overlaps"], len(rows) - 1)
        self.bad("detect", self.sequence, "--overlaps", self.path("no/such/folder.csv"), says="folder.csv")

    def test_verify_is_clean(self):
        plain = self.good("verify", self.sequence)
        self.assertIn("clean", plain)
        compared = int(re.search(r"none of (\d+)", plain)[1])
        more = self.good("verify", self.sequence, "--set", "broad-phase=spatial-hash", "--set", "spatial-hash.k=6")
        self.assertIn(f"none of {compared + 1}", more)
        self.bad("verify", self.sequence, "--set", "broad-phase=nothing", says="kdop-bvh")

    def test_quadratic_motion(self):
        self.assertIn("steps: distances", self.good("info", self.sequence, "--motion", "quadratic"))
        self.bad("detect", self.sequence, "--motion", "quadratic", "--set", "narrow-phase=cubic", says="exact")

    def test_tentative_motion(self):
        for command in ("detect", "verify", "info"):
            self.bad(command, self.sequence, "--motion", "tentative",
                     says="Velocity: is missing: tentative motion needs")
        data = os.environ.get("VOLCCD_DATA", os.path.join(SOURCE, "..", "shared", "data"))
        projectile = os.path.join(data, "ls-dyna-projectile.vtkhdf")
        if not os.path.exists(projectile):
            self.skipTest("ls-dyna-projectile.vtkhdf is not there")
        stats = self.path("tentative.json")
        self.good("detect", projectile, "--steps", "1", "--motion", "tentative", "--stats", stats)
        with open(stats, encoding="utf-8") as file:
            record = json.load(file)
        self.assertEqual(record["motion"], "tentative")
        self.good("detect", projectile, "--steps", "1", "--stats", stats)
        with open(stats, encoding="utf-8") as file:
            self.assertNotEqual(json.load(file)["total"]["contacts"], record["total"]["contacts"])

    def test_contacts_of_shell_neighbours(self):
        self.bad("detect", self.sequence, "--shell-neighbours", "leave-out", says="--shells solid")
        self.bad("verify", self.sequence, "--shell-neighbours", "leave-out", says="--shells solid")
        data = os.environ.get("VOLCCD_DATA", os.path.join(SOURCE, "..", "shared", "data"))
        crash = os.path.join(data, "openradioss-crash.vtkhdf")
        if not os.path.exists(crash):
            self.skipTest("openradioss-crash.vtkhdf is not there")
        solid = ["detect", crash, "--shells", "solid", "--steps", "20", "--stats", self.path("shells.json")]

        def total(*arguments):
            text = self.good(*solid, *arguments)
            with open(self.path("shells.json"), encoding="utf-8") as file:
                record = json.load(file)
            return text, record["shell_neighbours"], record["total"]

        text, rule, without = total()
        self.assertEqual(rule, "leave-out")
        self.assertIn("left out: contacts of features that stem from one shell vertex", text)
        self.assertIn(f"contacts at t = 0: {without['contacts_at_start']:,} of {without['contacts']:,}", text)
        text, rule, every = total("--shell-neighbours", "keep")
        self.assertEqual(rule, "keep")
        self.assertNotIn("left out", text)
        self.assertGreater(every["contacts"], without["contacts"])
        _, _, first = total("--first")
        self.assertEqual(first["earliest_toi"], without["earliest_toi"])
        self.assertLessEqual(every["earliest_toi"], first["earliest_toi"])

    def test_separation_beyond_the_scene_is_refused(self):
        for command in ("detect", "verify"):
            self.bad(command, self.sequence, "--steps", "0", "--separation", "1e308", says="diagonal")
            for value in ("inf", "nan", "-1"):
                self.bad(command, self.sequence, "--steps", "0", "--separation", value, says="--separation")
        self.assertIn("diagonal", self.good("detect", "--help"))

    def test_pairs_between_parts_of_a_file_without_parts(self):
        """The two bodies of the built-in scene without their parts: one part with two components."""
        source, plain = self.path("parts.vtkhdf"), self.path("no-parts.vtkhdf")
        self.good("scene", "generate", "deform", "--mesh", self.sequence, "--motion", "twist", "--frames", "3",
                  "-o", source)
        with open(source, "rb") as file:
            data = file.read()
        self.assertEqual(data.count(b"PartId\0"), 2)  # the array and its table
        with open(plain, "wb") as file:
            file.write(data.replace(b"PartId\0", b"PartXX\0"))

        def contacts(file, *arguments, warns):
            target = self.path("parts.csv")
            done = run("detect", file, "--contacts", target, *arguments)
            self.assertEqual(done.returncode, 0, done.stderr)
            self.assertEqual("--objects components" in done.stderr, warns, done.stderr)
            with open(target, encoding="ascii") as rows:
                return rows.read()

        expected = contacts(source, "--pairs", "inter", warns=False)
        self.assertEqual(contacts(plain, "--pairs", "inter", warns=True).count("\n"), 1)
        self.assertEqual(contacts(plain, "--pairs", "inter", "--objects", "components", warns=False), expected)
        self.assertIn("component 1", self.good("info", plain, "--objects", "components"))
        self.assertNotIn("component 1", self.good("info", plain))
        self.assertIn("clean", self.good("verify", plain, "--pairs", "inter", "--objects", "components", "--steps", "0"))


if __name__ == "__main__":
    unittest.main()
