"""The `volccd` program and the custom-culling example, as a user runs them."""

import csv
import json
import os
import shutil
import struct
import subprocess
import sys
import tempfile
import unittest

VOLCCD, EXAMPLE = sys.argv[1:3]
SOURCE = os.path.dirname(os.path.dirname(os.path.dirname(os.path.abspath(__file__))))
del sys.argv[1:3]


def run(*arguments, program=VOLCCD, env=None):
    return subprocess.run([program, *arguments], capture_output=True, text=True, env={**os.environ, **(env or {})},
                          check=False)


class Program(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.folder = tempfile.TemporaryDirectory()
        cls.sequence = cls.path("run.vtkhdf")
        made = run("scene", "generate", "builtin", "--elements", "300", "--steps", "5", "-o", cls.sequence)
        assert made.returncode == 0, made.stderr

    @classmethod
    def tearDownClass(cls):
        cls.folder.cleanup()

    @classmethod
    def path(cls, name):
        return os.path.join(cls.folder.name, name)

    def good(self, *arguments, program=VOLCCD, env=None):
        done = run(*arguments, program=program, env=env)
        self.assertEqual(done.returncode, 0, done.stdout + done.stderr)
        return done.stdout

    def bad(self, *arguments, says):
        done = run(*arguments)
        self.assertEqual(done.returncode, 2, done.stdout + done.stderr)
        self.assertIn(says, done.stderr)

    def contacts(self, *arguments):
        target = self.path("contacts.csv")
        self.good("detect", self.sequence, "--contacts", target, *arguments)
        with open(target, encoding="ascii", newline="") as file:
            return list(csv.reader(file))

    def test_all_pipelines_write_the_same_contacts(self):
        expected = self.contacts("--pipeline", "BruteForce")
        self.assertEqual(expected[0], "step,kind,a,b,c,d,toi,nx,ny,nz,px,py,pz".split(","))
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
        self.good("detect", self.sequence, "--stats", target, "--set", "csat.axis=centroid")
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
        for settings in (["broad-phase=spatial-hash"], ["element-culling=none"], ["feature-culling=all-pairs"],
                         ["feature-filters=feature-kdop,coplanarity"], ["kdop-bvh.k=24", "csat.axis=optimal"],
                         ["feature-culling=static-assignment", "feature-filters=none"]):
            arguments = [word for setting in settings for word in ("--set", setting)]
            self.assertEqual(self.contacts(*arguments), expected, settings)

    def test_initial_overlaps(self):
        target = self.path("overlaps.csv")
        texts = set()
        for arguments in (["--pipeline", "VolCCD"], ["--pipeline", "VolCCD+", "--threads", "2"], ["--pipeline", "HashCCD"],
                          ["--first"]):
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
        self.assertIn("clean", self.good("verify", self.sequence))

    def test_picture(self):
        target = self.path("picture.png")
        self.good("scene", "picture", self.sequence, "--step", "2", "--size", "160x120", "-o", target)
        with open(target, "rb") as file:
            png = file.read()
        self.assertEqual(png[:8], b"\x89PNG\r\n\x1a\n")
        self.assertEqual(struct.unpack(">II", png[16:24]), (160, 120))
        self.good("scene", "picture", self.sequence, self.sequence, "--step", "0,4", "--size", "200", "--cut", "y=50%",
                  "--edges", "--no-contacts", "-o", self.path("panels.png"))
        self.bad("scene", "picture", self.sequence, "--step", "5", "-o", target, says="0:5")
        self.bad("scene", "picture", self.sequence, "--size", "0x7", "-o", target, says="--size")
        self.bad("scene", "picture", self.sequence, "--view", "up", "-o", target, says="view")
        self.bad("scene", "picture", self.sequence, "--parts", "nobody", "-o", target, says="nobody")
        self.bad("scene", "picture", self.sequence, "-o", self.path("no/such/picture.png"), says="picture.png")
        with open(target, "rb") as file:
            self.assertEqual(file.read(), png)

    def queries(self, *arguments):
        return json.loads(self.good("queries", *arguments, "--json", "--rounds", "1"))

    def test_queries_on_candidates_find_what_detect_finds(self):
        found = self.queries(self.sequence, "--steps", "0", "--candidates", "--narrowphase",
                             "cubic,cubic:axis_test=false")
        self.assertEqual([n["name"] for n in found["narrow_phases"]], ["cubic", "cubic:axis_test=false"])
        expected = self.contacts("--steps", "0", "--set", "narrow-phase=cubic")[1:]
        for group in found["groups"]:
            self.assertEqual(group["scene"], "candidates, motion 0")
            self.assertIsNone(group["colliding"])
            for score in group["scores"]:
                self.assertEqual(score["contacts"], sum(row[1] == group["kind"] for row in expected))
                self.assertGreater(score["nanoseconds"], 0)
        filtered = self.queries(self.sequence, "--steps", "0", "--candidates", "--narrowphase", "cubic", "--filters",
                                "feature-kdop,coplanarity", "--set", "cubic.axis_test=false")
        for group, fewer in zip(found["groups"], filtered["groups"]):
            self.assertEqual(fewer["scores"][0]["contacts"], group["scores"][0]["contacts"])
            self.assertLess(fewer["scores"][0]["tests"], group["queries"])
        sample = self.queries(self.sequence, "--steps", "0:2", "--candidates", "--narrowphase", "cubic", "--sample", "10")
        self.assertEqual([group["queries"] for group in sample["groups"]], [10, 10, 10, 10])

    def test_queries_judged_by_a_narrow_phase(self):
        judged = self.queries(self.sequence, "--steps", "1:3", "--candidates", "--sample", "2000", "--judge", "exact",
                              "--narrowphase", "inclusion,exact")
        self.assertGreater(sum(group["colliding"] for group in judged["groups"]), 0)
        for group in judged["groups"]:
            for score in group["scores"]:
                self.assertEqual((score["missed"], score["extra"]), (0, score["undecided"]))
                self.assertLessEqual(score["latest"], 0)
        self.bad("queries", self.sequence, "--steps", "1", says="GroundTruth")

    def test_queries_with_known_answers(self):
        data = os.environ.get("VOLCCD_DATA", os.path.join(SOURCE, "..", "shared", "data"))
        queries = os.path.join(data, "ccd-queries.h5")
        if not os.path.exists(queries):
            self.skipTest("ccd-queries.h5 is not there")
        found = self.queries(queries, "--narrowphase", "cubic")
        self.assertEqual(sum(group["queries"] for group in found["total"]), 4779)
        self.assertEqual([group["scores"][0]["missed"] for group in found["total"]], [0, 0])
        listed = self.good("queries", queries, "--narrowphase", "cubic:tolerance=1e-3", "--rounds", "0", "--list")
        self.assertTrue("extra by cubic:tolerance=1e-3: erleben-spike-hole VF 500 (data_0_0.csv)" in listed)
        self.bad("queries", queries, "--candidates", says="--candidates")

    def test_quadratic_motion(self):
        self.assertIn("motions", self.good("info", self.sequence, "--motion", "quadratic"))
        self.bad("detect", self.sequence, "--motion", "quadratic", "--set", "narrow-phase=cubic", says="exact")

    def test_info_stages_and_lists(self):
        info = self.good("info", self.sequence)
        self.assertIn("hexahedron", info)
        stages = self.good("stages")
        for name in ("kdop-bvh", "spatial-hash", "csat", "dynamic-assignment", "cubic", "VolCCD+"):
            self.assertIn(name, stages)
        self.assertIn("deform", self.good("scene", "list"))
        self.assertIn("projectile", self.good("experiment", "list"))
        for command in ([], ["info"], ["detect"], ["verify"], ["queries"], ["scene", "generate"], ["scene", "picture"],
                        ["experiment", "run"]):
            self.assertIn("Example", self.good(*command, "--help"))

    def test_deform_takes_any_mesh(self):
        target = self.path("twist.vtkhdf")
        self.good("scene", "generate", "deform", "--mesh", self.sequence, "--motion", "twist", "--amount", "20",
                  "--copies", "2", "-o", target)
        self.assertIn("clean", self.good("verify", target, "--no-fcl"))

    def test_scenes_by_name(self):
        data, cache = self.path("data"), self.path("cache")
        os.makedirs(data, exist_ok=True)
        shutil.copy(self.sequence, os.path.join(data, "openradioss-bullet.vtkhdf"))
        env = {"VOLCCD_DATA": data, "VOLCCD_CACHE": cache}
        listed = self.good("scene", "list", env=env)
        for name in ("octopi", "bullet", "airbag", "crash", "liver", "builtin", "openradioss-bullet"):
            self.assertIn(f"  {name} ", listed)
        self.assertNotIn("openradioss-crash", listed)
        self.assertEqual(self.good("detect", "openradioss-bullet", env=env).split("\n")[3:4],
                         self.good("detect", self.sequence).split("\n")[3:4])
        self.assertIn("builtin", self.good("info", "builtin", env=env))
        self.assertIn("candidates", self.good("queries", "builtin", "--candidates", "--sample", "20", "--judge", "exact",
                                              "--steps", "0", "--rounds", "0", env=env))
        target, stats = self.path("copy.vtkhdf"), self.path("scene-stats.json")
        self.good("scene", "generate", "openradioss-bullet", "-o", target, "--stats", stats, env=env)
        with open(target, "rb") as copy, open(self.sequence, "rb") as original:
            self.assertEqual(copy.read(), original.read())
        with open(stats, encoding="ascii") as file:
            motions = json.load(file)["motions"]
        self.assertEqual(len(motions), 4)
        counted = sum(sum(motion["contacts"].values()) for motion in motions)
        self.assertEqual(counted, len(self.contacts()) - 1)
        self.bad("scene", "generate", "octopus", "-o", target, says="there are: octopi, bullet, airbag, crash, liver,")
        self.bad("scene", "generate", "crash", "--copies", "2", "-o", target, says="scene crash has no option --copies")
        self.bad("scene", "generate", "builtin", "--quick", "-o", target, says="no quick size")
        self.bad("scene", "generate", "crash", "--elements", "0", "-o", target, says="--elements: '0' is not a positive number")

    def test_experiment_falls_back_to_the_builtin_sequence(self):
        text = self.good("experiment", "run", "projectile", "--quick", "-o", self.path("results"),
                         env={"VOLCCD_DATA": self.folder.name})
        self.assertIn("built-in sequence", text)
        self.assertIn("0.69 %", text)
        with open(self.path("results/projectile.json"), encoding="utf-8") as file:
            self.assertEqual(len(json.load(file)["pipelines"]), 4)

    def test_bad_input_exits_with_2_and_says_why(self):
        empty = self.path("empty.vtkhdf")
        with open(empty, "wb"):
            pass
        self.bad("info", empty, says="empty.vtkhdf")
        self.bad("detect", self.path("absent.vtkhdf"), says="absent.vtkhdf")
        self.bad("detect", self.sequence, "--pipeline", "Nothing", says="VolCCD+")
        self.bad("detect", self.sequence, "--set", "csat.axis=sideways", says="centroid")
        self.bad("detect", self.sequence, "--set", "nothing.x=1", says="kdop-bvh")
        self.bad("detect", self.sequence, "--set", "feature-culling=static-assignment", "--set",
                 "static-assignment.oset=minimal", says="O-Set")
        for steps in ("4", "2:2", "3:1", "x", "-1:2", "0:9"):
            self.bad("detect", self.sequence, "--steps=" + steps, says="--steps")
        self.bad("detect", self.sequence, "--separation", "0.1", "--set", "narrow-phase=cubic", says="separation")
        self.bad("detect", self.sequence, "--contacts", self.path("no/such/folder.csv"), says="folder.csv")
        self.bad("queries", self.path("absent.h5"), says="absent.h5")
        self.bad("queries", self.sequence, says="GroundTruth")
        self.bad("queries", self.sequence, "--candidates", "--narrowphase", "nothing", says="cubic")
        self.bad("queries", self.sequence, "--candidates", "--narrowphase", "cubic:tolerance", says="option=value")
        self.bad("queries", self.sequence, "--candidates", "--set", "csat.axis=face", says="csat")
        self.bad("frobnicate", says="frobnicate")
        self.bad("experiment", "run", "nothing", says="projectile")
        self.assertEqual([name for name in os.listdir(self.folder.name) if "tmp" in name], [])

    def test_a_stage_from_outside_the_library(self):
        self.assertIn("spheres", self.good("stages", program=EXAMPLE))
        self.assertIn("none of 5", self.good("verify", self.sequence, program=EXAMPLE))
        self.assertIn("spheres", self.good("detect", self.sequence, "--pipeline", "Spheres", program=EXAMPLE))
        self.good("detect", self.sequence, "--pipeline", "VolCCD+", "--set", "element-culling=spheres,csat", "--set",
                  "spheres.padding=0.1", program=EXAMPLE)

    def test_separation_beyond_the_scene_is_refused(self):
        for command in ("detect", "verify"):
            self.bad(command, self.sequence, "--steps", "0", "--separation", "1e308", says="diagonal")
            for value in ("inf", "nan", "-1"):
                self.bad(command, self.sequence, "--steps", "0", "--separation", value, says="--separation")
        self.assertIn("diagonal", self.good("detect", "--help"))

    def test_pairs_between_parts_of_a_file_without_parts(self):
        """The two bodies of the built-in scene with their parts taken away: one part, of two components."""
        source, plain = self.path("parts.vtkhdf"), self.path("no-parts.vtkhdf")
        self.good("scene", "generate", "deform", "--mesh", self.sequence, "--motion", "twist", "--steps", "3", "-o", source)
        with open(source, "rb") as file:
            data = file.read()
        self.assertEqual(data.count(b"PartId\0"), 2)  # the array and its table
        with open(plain, "wb") as file:
            file.write(data.replace(b"PartId\0", b"PartXX\0"))

        def contacts(file, *arguments, warns):
            target = self.path("parts.csv")
            done = run("detect", file, "--contacts", target, *arguments)
            self.assertEqual(done.returncode, 0, done.stderr)
            self.assertEqual("--parts components" in done.stderr, warns, done.stderr)
            with open(target, encoding="ascii") as rows:
                return rows.read()

        expected = contacts(source, "--pairs", "inter", warns=False)
        self.assertEqual(contacts(plain, "--pairs", "inter", warns=True).count("\n"), 1)
        self.assertEqual(contacts(plain, "--pairs", "inter", "--parts", "components", warns=False), expected)
        self.assertIn("component 1", self.good("info", plain, "--parts", "components"))
        self.assertNotIn("component 1", self.good("info", plain))
        self.assertIn("clean", self.good("verify", plain, "--pairs", "inter", "--parts", "components", "--steps", "0"))

    def test_damaged_files_leave_no_messages_of_hdf5(self):
        """Where the address in a continuation message of an object header is wrong, HDF5 loses memory of its own."""
        with open(self.sequence, "rb") as file:
            data = file.read()
        message = b"\x10\x00\x10\x00\x00\x00\x00\x00"
        damaged, at, refused = self.path("damaged.vtkhdf"), data.find(message), 0
        while at >= 0:
            with open(damaged, "wb") as file:
                file.write(data[:at + 12] + b"\x56" + data[at + 13:])
            done = run("info", damaged)
            self.assertNotIn("infinite loop", done.stderr)
            refused += done.returncode == 2
            at = data.find(message, at + 1)
        self.assertGreater(refused, 2)


if __name__ == "__main__":
    unittest.main()
