"""The `volccd` program and the custom-culling example, as a user runs them."""

import csv
import json
import os
import pty
import re
import resource
import shutil
import signal
import stat
import struct
import subprocess
import sys
import tempfile
import threading
import time
import unittest
import zlib

VOLCCD, EXAMPLE = sys.argv[1:3]
SOURCE = os.path.dirname(os.path.dirname(os.path.dirname(os.path.abspath(__file__))))
del sys.argv[1:3]


def run(*arguments, program=VOLCCD, env=None, disk=None):
    """`disk`: no file can grow beyond so many bytes, as on a full disk."""
    def limit():
        resource.setrlimit(resource.RLIMIT_FSIZE, (disk, disk))
    return subprocess.run([program, *arguments], capture_output=True, text=True, env={**os.environ, **(env or {})},
                          check=False, preexec_fn=limit if disk is not None else None)


def with_bad_last_step(sequence):
    """The bytes of a sequence whose steps have one chunk of points each, with the last of these chunks destroyed."""
    chunks = {}
    for match in re.finditer(rb"\x78[\x01\x5e\x9c\xda]", sequence):
        try:
            chunks.setdefault(len(zlib.decompressobj().decompress(sequence[match.start():])), []).append(match.start())
        except zlib.error:
            pass
    begin = max(chunks[max(chunks)])  # the points are what is largest
    return sequence[:begin + 100] + bytes(64) + sequence[begin + 164:]


class Interruption:
    """A run that gets Ctrl-C once its progress, on a terminal of its own, shows `done` steps; `seconds` it took to end
    after that."""

    def __init__(self, *arguments, done=1, env=None, delay=0.0):
        terminal, tty = pty.openpty()
        with subprocess.Popen([VOLCCD, *arguments], stdout=subprocess.PIPE, stderr=tty, text=True,
                              env={**os.environ, **(env or {})}) as process:
            os.close(tty)
            self.screen = b""
            out = []
            reader = threading.Thread(target=lambda: out.append(process.stdout.read()))
            reader.start()
            sent = None
            limit = threading.Timer(120, process.kill)
            limit.start()
            while True:
                try:
                    data = os.read(terminal, 4096)
                except OSError:  # the program has closed it
                    break
                if not data:
                    break
                self.screen += data
                shown = re.findall(rb" (\d+)/\d+", self.screen)
                if sent is None and shown and int(shown[-1]) >= done:
                    time.sleep(delay)
                    sent = time.monotonic()
                    process.send_signal(signal.SIGINT)
            self.code = process.wait()
            limit.cancel()
            reader.join()
        os.close(terminal)
        self.seconds = time.monotonic() - sent if sent is not None else None
        self.out = out[0]
        self.screen = self.screen.decode()


class ProgramTest(unittest.TestCase):
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

    def bad(self, *arguments, says, program=VOLCCD, env=None):
        done = run(*arguments, program=program, env=env)
        self.assertEqual(done.returncode, 2, done.stdout + done.stderr)
        self.assertIn(says, done.stderr)

    def contacts(self, *arguments):
        target = self.path("contacts.csv")
        self.good("detect", self.sequence, "--contacts", target, *arguments)
        with open(target, encoding="ascii", newline="") as file:
            return list(csv.reader(file))


class Program(ProgramTest):
    def test_all_pipelines_write_the_same_contacts(self):
        expected = self.contacts("--pipeline", "BruteForce")
        self.assertEqual(expected[0], "step,kind,a,b,c,d,toi,nx,ny,nz,px,py,pz,at_start".split(","))
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
        for settings in (["broad-phase=spatial-hash"], ["element-culling=none"], ["assignment=all-pairs"], ["orphans=none", "assignment=all-pairs"],
                         ["feature-filter=feature-kdop,coplanarity"], ["kdop-bvh.k=24", "csat.axis=optimal"],
                         ["assignment=static-assignment", "orphans=none", "feature-filter=none"]):
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
        plain = self.good("verify", self.sequence)
        self.assertIn("clean", plain)
        compared = int(re.search(r"none of (\d+)", plain)[1])
        more = self.good("verify", self.sequence, "--set", "broad-phase=spatial-hash", "--set", "spatial-hash.k=6")
        self.assertIn(f"none of {compared + 1}", more)
        self.bad("verify", self.sequence, "--set", "broad-phase=nothing", says="kdop-bvh")

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

    def test_tentative_motion(self):
        for command in ("detect", "verify", "info"):
            self.bad(command, self.sequence, "--motion", "tentative", says="Velocity: is missing: tentative motion needs")
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
        self.assertGreater(without["left_out"], 0)
        self.assertIn(f"left out: {without['left_out']:,} contacts", text)
        self.assertIn(f"contacts at t = 0: {without['contacts_at_start']:,} of {without['contacts']:,}", text)
        text, rule, every = total("--shell-neighbours", "keep")
        self.assertEqual((rule, every["left_out"]), ("keep", 0))
        self.assertNotIn("left out", text)
        self.assertEqual(every["contacts"], without["contacts"] + without["left_out"])
        text, _, first = total("--first")
        self.assertIn("not counted with --first", text)
        self.assertEqual(first["earliest_toi"], without["earliest_toi"])
        self.assertLessEqual(every["earliest_toi"], first["earliest_toi"])

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
            record = json.load(file)
        self.assertEqual({row["pipeline"] for row in record["rows"]}, {"NavCCD", "HashCCD", "VolCCD", "VolCCD+"})
        self.assertEqual({row["motion"] for row in record["rows"]}, set(range(8)))
        self.assertEqual({row["scene"] for row in record["rows"]}, {"builtin"})
        names = [option for stage in record["provenance"]["plan"]["runs"][0]["entrants"][0]["stages"].values()
                 if isinstance(stage, dict) for option in stage["options"]]
        self.assertIn("leaf_size", names)  # options are recorded whether or not they were set
        for fact in ("commit", "compiler", "flags", "cpu", "load", "inputs"):
            self.assertIn(fact, record["provenance"])
        self.assertNotIn(self.folder.name, json.dumps(record))  # no path of this machine
        for form, sign in (("text", "0.69 %"), ("markdown", "|---|"), ("csv", "NavCCD,"), ("latex", "\\toprule")):
            self.assertIn(sign, self.good("experiment", "table", "projectile", "--results", self.path("results"), "--format", form))
        text = self.good("experiment", "table", "projectile", "--results", self.path("results"))
        with open(self.path("results/projectile.txt"), encoding="utf-8") as file:
            self.assertEqual(text, file.read())
        same = self.good("experiment", "compare", self.path("results"), self.path("results"))
        self.assertIn("4 compared: 0 slower, 0 faster beyond the spread, 0 with other counts", same)
        record["rows"][0]["contacts_hash"] = "0"
        os.mkdir(self.path("other"))
        with open(self.path("other/projectile.json"), "w", encoding="utf-8") as file:
            json.dump(record, file)
        other_rows = {"experiment": "operations", "schema": 1, "rows": [{"operation": "csat", "ns": 1.0}]}
        for folder in ("results", "other"):
            with open(self.path(folder + "/operations.json"), "w", encoding="utf-8") as file:
                json.dump(other_rows, file)
        changed = run("experiment", "compare", self.path("results"), self.path("other"))
        self.assertEqual(changed.returncode, 1)
        self.assertIn("OTHER", changed.stdout)
        self.bad("experiment", "table", "projectile", "--results", self.path("absent"), says="projectile.json")
        self.bad("experiment", "compare", self.path("results"), self.path("absent"), says="absent")

    def test_bad_input_exits_with_2_and_says_why(self):
        empty = self.path("empty.vtkhdf")
        with open(empty, "wb"):
            pass
        self.bad("info", empty, says="empty.vtkhdf")
        self.bad("detect", self.path("absent.vtkhdf"), says="absent.vtkhdf")
        self.bad("detect", self.sequence, "--pipeline", "Nothing", says="VolCCD+")
        self.bad("detect", self.sequence, "--set", "csat.axis=sideways", says="centroid")
        self.bad("detect", self.sequence, "--set", "nothing.x=1", says="kdop-bvh")
        self.bad("detect", self.sequence, "--set", "assignment=static-assignment", says="O-Set")
        for steps in ("4", "2:2", "3:1", "x", "-1:2", "0:9"):
            self.bad("detect", self.sequence, "--steps=" + steps, says="--steps")
        self.bad("detect", self.sequence, "--separation", "0.1", "--set", "narrow-phase=cubic", says="separation")
        self.bad("detect", self.sequence, "--contacts", self.path("no/such/folder.csv"), says="folder.csv")
        self.bad("queries", self.path("absent.h5"), says="absent.h5")
        self.bad("queries", self.sequence, says="GroundTruth")
        self.bad("queries", self.sequence, "--candidates", "--narrowphase", "nothing", says="cubic")
        self.bad("queries", self.sequence, "--candidates", "--narrowphase", "cubic:tolerance", says="option=value")
        self.bad("queries", self.sequence, "--candidates", "--set", "csat.axis=face", says="csat")
        for command in (["detect", self.sequence], ["verify", self.sequence], ["experiment", "run", "projectile"],
                        ["scene", "generate", "builtin", "-o", self.path("threads.vtkhdf")],
                        ["scene", "picture", self.sequence, "-o", self.path("threads.png")]):
            self.bad(*command, "--threads", "100000", says="1024")
        self.bad("frobnicate", says="frobnicate")
        self.bad("experiment", "run", "nothing", says="projectile")
        self.assertEqual([name for name in os.listdir(self.folder.name) if "tmp" in name], [])

    def test_a_stage_from_outside_the_library(self):
        self.assertIn("spheres", self.good("stages", program=EXAMPLE))
        self.assertIn("none of 6", self.good("verify", self.sequence, program=EXAMPLE))
        for pipeline in ("Spheres", "Spheres+CSAT"):
            self.assertIn("spheres", self.good("detect", self.sequence, "--pipeline", pipeline, program=EXAMPLE))
        self.good("detect", self.sequence, "--pipeline", "VolCCD+", "--set", "element-culling=spheres,csat", "--set",
                  "spheres.padding=0.1", program=EXAMPLE)

    def test_a_stage_from_outside_the_library_in_a_table(self):
        env = {"VOLCCD_DATA": self.path("absent")}
        arguments = ["experiment", "run", "projectile", "--pipelines", "Spheres,Spheres+CSAT", "-o", self.path("own")]
        done = run(*arguments, program=EXAMPLE, env=env)
        self.assertEqual(done.returncode, 0, done.stderr)
        self.assertRegex(done.stdout, r"\nSpheres +\S+ ms +")
        with open(os.path.join(self.path("own"), "projectile.json")) as file:
            record = json.load(file)
        self.assertEqual({row["pipeline"] for row in record["rows"]} - {"NavCCD", "HashCCD", "VolCCD"},
                         {"VolCCD+", "Spheres", "Spheres+CSAT"})
        self.bad(*arguments[:3], "--pipelines", "Nothing", "-o", self.path("own"), says="Spheres+CSAT", program=EXAMPLE)

    def test_check_of_a_stage(self):
        shown = self.good("check", "spheres", self.sequence, "--trials", "300", program=EXAMPLE)
        self.assertIn("spheres (element-culling), declared conservative", shown)
        self.assertRegex(shown, r"allocates nothing in steady state +[1-9]")
        self.assertTrue(shown.endswith("all promises kept\n"))
        self.good("check", "csat", "--set", "csat.axis=optimal", "--trials", "10", "--seed", "7")
        self.bad("check", "nothing", says="kdop-bvh")
        self.bad("check", "csat", "--set", "kdop-bvh.k=6", says="csat.option=value")
        self.bad("check", "csat", "--set", "csat.axis=sideways", says="centroid")
        self.bad("check", "csat", self.path("absent.vtkhdf"), says="absent.vtkhdf")

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


class Outputs(ProgramTest):
    """Nothing is lost: inputs, devices, links, older records, and what was complete before a run ended."""

    @classmethod
    def setUpClass(cls):
        super().setUpClass()
        cls.long = cls.path("long.vtkhdf")
        made = run("scene", "generate", "builtin", "--elements", "3000", "--steps", "150", "-o", cls.long)
        assert made.returncode == 0, made.stderr
        cls.large = cls.path("large.vtkhdf")
        made = run("scene", "generate", "builtin", "--elements", "60000", "--steps", "4", "-o", cls.large)
        assert made.returncode == 0, made.stderr
        begin = time.monotonic()
        run("info", cls.large, "--steps", "0")
        # A second, but for sanitizers and a busy machine: there, what it takes to read a step.
        cls.patience = max(1.0, 2 * (time.monotonic() - begin))

    def read(self, name):
        with open(self.path(name), "rb") as file:
            return file.read()

    def write(self, name, text):
        with open(self.path(name), "w", encoding="ascii") as file:
            file.write(text)
        return self.path(name)

    def no_leftovers(self):
        self.assertEqual([name for _, _, names in os.walk(self.folder.name) for name in names if name.endswith("tmp")], [])

    @staticmethod
    def device(name):
        """Nothing for a user whose mistakes could replace it."""
        return [] if os.access(os.path.dirname(name), os.W_OK) else [name]

    def whole_contacts(self, sequence):
        return self.good("detect", sequence, "--contacts", "-").splitlines()

    def check_incomplete(self, lines, whole, first=1):
        """The mark says how many steps there are, and these have all their rows. Returns their number."""
        mark = re.fullmatch(r"# incomplete: steps 0 to (\d+) of 0 to (\d+) are complete; (.*)", lines[-1])
        self.assertTrue(mark, lines[-1])
        last = int(mark[1])
        self.assertEqual(lines[:-1], whole[:1] + [row for row in whole[1:] if int(row.split(",")[0]) <= last])
        self.assertGreaterEqual(last + 1, first)
        self.assertLess(last, int(mark[2]))
        return last + 1

    def test_an_output_is_never_an_input_or_another_output(self):
        source = self.path("in.vtkhdf")
        shutil.copy(self.sequence, source)
        os.link(source, self.path("hard.vtkhdf"))
        os.symlink("in.vtkhdf", self.path("soft.vtkhdf"))
        rows = self.write("rows.csv", "step,kind,a,b,c,d,toi\n")
        for name in ("in.vtkhdf", "hard.vtkhdf", "soft.vtkhdf", "../" + os.path.basename(self.folder.name) + "/in.vtkhdf"):
            same = self.path(name)
            for option in ("--contacts", "--overlaps", "--stats"):
                self.bad("detect", source, option, same, says=option)
            self.bad("scene", "picture", source, "-o", same, says="-o")
            self.bad("scene", "generate", "deform", "--mesh", source, "-o", same, says="--mesh")
            self.bad("scene", "generate", "builtin", "-o", source, "--stats", same, says="--stats")
        self.bad("scene", "picture", source, "--contacts-from", rows, "-o", rows, says="--contacts-from")
        self.bad("detect", source, "--contacts", self.path("x"), "--overlaps", self.path("./x"), says="--overlaps")
        self.bad("detect", source, "--contacts", "-", "--stats", "/dev/fd/1", says="--stats")
        self.bad("scene", "generate", "openradioss-bullet", "-o", self.path("openradioss-bullet.vtkhdf"),
                 says="openradioss-bullet", env=self.data(source))
        with open(self.path("report.txt"), "w", encoding="ascii") as report:
            done = subprocess.run([VOLCCD, "detect", source, "--contacts", report.name], stdout=report,
                                  stderr=subprocess.PIPE, text=True, check=False)
        self.assertEqual((done.returncode, "standard output" in done.stderr), (2, True), done.stderr)
        self.assertEqual(self.read("in.vtkhdf"), self.read("run.vtkhdf"))
        self.assertEqual(self.read("rows.csv"), b"step,kind,a,b,c,d,toi\n")
        self.assertFalse(os.path.exists(self.path("x")))
        self.no_leftovers()

    def data(self, sequence):
        """Environment in which the scene openradioss-bullet is a copy of `sequence`."""
        if not os.path.exists(self.path("openradioss-bullet.vtkhdf")):
            shutil.copy(sequence, self.path("openradioss-bullet.vtkhdf"))
        return {"VOLCCD_DATA": self.folder.name}

    def test_standard_output_carries_the_result_alone(self):
        whole = [",".join(row) for row in self.contacts()]
        os.symlink("/proc/self/fd/1", self.path("stdout"))
        for name in ("-", "/dev/fd/1", "/proc/self/fd/1", self.path("stdout"), *self.device("/dev/stdout")):
            done = run("detect", self.sequence, "--contacts", name)
            self.assertEqual((done.returncode, done.stdout.splitlines()), (0, whole), name)
            self.assertIn("after culling", done.stderr)
        stats = json.loads(self.good("detect", self.sequence, "--stats", "-"))
        self.assertEqual(stats["total"]["contacts"], len(whole) - 1)
        self.assertTrue(self.good("detect", self.sequence, "--overlaps", "-").startswith("step,a,b\n"))
        with subprocess.Popen([VOLCCD, "scene", "picture", self.sequence, "--size", "160x120", "-o", "-"],
                              stdout=subprocess.PIPE, stderr=subprocess.PIPE) as process:
            self.assertEqual(process.communicate()[0][:8], b"\x89PNG\r\n\x1a\n")
        os.mkfifo(self.path("for-hdf5"))
        for name in ("-", "/dev/fd/1", self.path("for-hdf5"), *self.device("/dev/null")):
            self.bad("scene", "generate", "builtin", "-o", name, says="not a regular file")
        with open(self.path("out.txt"), "wb") as file:  # where a shell's > goes
            subprocess.run([VOLCCD, "detect", self.sequence, "--contacts", self.path("stdout")], stdout=file,
                           stderr=subprocess.DEVNULL, check=True)
        self.assertEqual(self.read("out.txt").decode().splitlines(), whole)

    def test_links_fifos_and_devices_stay(self):
        self.good("detect", self.sequence, "--contacts", self.path("contacts.csv"))
        whole = self.read("contacts.csv")
        os.symlink("target.csv", self.path("link.csv"))
        for _ in range(2):  # the target is not there, then is
            self.good("detect", self.sequence, "--contacts", self.path("link.csv"))
            self.assertTrue(os.path.islink(self.path("link.csv")))
            self.assertEqual(self.read("target.csv"), whole)
        for null in self.device("/dev/null"):
            self.good("detect", self.sequence, "--contacts", null, "--stats", null, "--overlaps", null)
            self.assertTrue(stat.S_ISCHR(os.stat(null).st_mode))
        os.mkfifo(self.path("fifo"))
        reader = os.open(self.path("fifo"), os.O_RDONLY | os.O_NONBLOCK)  # what it gets fits its buffer
        self.good("detect", self.sequence, "--first", "--contacts", self.path("fifo"))
        self.good("detect", self.sequence, "--first", "--contacts", self.path("first.csv"))
        self.assertEqual(os.read(reader, 1 << 16), self.read("first.csv"))
        os.close(reader)
        self.assertTrue(stat.S_ISFIFO(os.stat(self.path("fifo")).st_mode))
        os.symlink("picture.png", self.path("link.png"))
        self.good("scene", "picture", self.sequence, "--size", "160x120", "-o", self.path("link.png"))
        self.assertTrue(os.path.islink(self.path("link.png")) and os.path.isfile(self.path("picture.png")))
        os.symlink("made.vtkhdf", self.path("link.vtkhdf"))
        self.good("scene", "generate", "builtin", "--elements", "300", "-o", self.path("link.vtkhdf"))
        self.assertTrue(os.path.islink(self.path("link.vtkhdf")) and os.path.isfile(self.path("made.vtkhdf")))

    def test_outputs_that_cannot_be_written_are_refused_at_once_with_the_reason(self):
        reason = "No such file or directory"
        for arguments in (["detect", self.sequence, "--contacts"], ["detect", self.sequence, "--overlaps"],
                          ["detect", self.sequence, "--stats"], ["scene", "picture", self.sequence, "-o"],
                          ["scene", "generate", "builtin", "-o"]):
            self.bad(*arguments, self.path("no/such"), says=reason)
            self.bad(*arguments, self.folder.name, says="folder")
        self.bad("experiment", "run", "projectile", "-o", self.path("run.vtkhdf") + "/results", says="Not a directory")
        self.bad("experiment", "run", "projectile", "-o", "/proc/results", says="/proc/results")
        os.mkdir(self.path("records"))
        os.mkdir(self.path("records/projectile.txt"))
        self.bad("experiment", "run", "projectile", "-o", self.path("records"), says="projectile.txt",
                 env={"VOLCCD_DATA": self.folder.name})
        with open("/dev/full", "w", encoding="ascii") as full:
            done = subprocess.run([VOLCCD, "detect", self.sequence], stdout=full, stderr=subprocess.PIPE, text=True,
                                  check=False)
        self.assertEqual(done.returncode, 2)
        self.assertIn("standard output: cannot be written: No space left on device", done.stderr)
        with open("/dev/full", "w", encoding="ascii") as full:
            done = subprocess.run([VOLCCD, "detect", self.sequence, "--contacts", "-"], stdout=full, stderr=subprocess.PIPE,
                                  text=True, check=False)
        self.assertEqual(done.returncode, 2)
        self.assertIn("-: cannot be written: No space left on device", done.stderr)
        self.no_leftovers()

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
        done = run("detect", source, "--contacts", contacts, "--stats", stats, "--overlaps", self.path("bad-overlaps.csv"))
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
        self.assertEqual((done.returncode, self.read("bad.csv").decode().splitlines()), (2, lines), "no step: nothing new")

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
        self.assertEqual((record["complete"], record["steps_done"], record["stopped_by"]), (False, steps, "interrupted"))
        self.good("detect", self.sequence, "--stats", stats)
        record = json.loads(self.read("cut.json"))
        self.assertEqual((record["complete"], record["steps_done"], record["stopped_by"]), (True, 4, None))
        cut = Interruption("info", self.long, done=40)
        self.assertEqual(cut.code, 130)
        self.assertIn("incomplete: steps 0 to ", cut.out)
        self.no_leftovers()

    def test_ctrl_c_within_a_step(self):
        """Steps that take many seconds: none is complete, older results stay."""
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
        self.assertRegex(cut.out, r"no difference in these steps\n\nincomplete: steps 0 to \d+ of 0 to 148 are complete; inter")
        self.assertIn("incomplete: steps 0 to ", cut.screen)
        for json_wanted in (False, True):
            cut = Interruption("queries", self.long, "--candidates", "--steps", ":50", "--sample", "5000",
                               *(["--json"] if json_wanted else []), done=700)
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
        cut = Interruption("scene", "generate", "builtin", "--elements", "3000", "--steps", "5000", "-o", target, done=5)
        self.assertEqual(cut.code, 130, cut.screen)
        self.assertIn("are complete; interrupted", cut.screen)
        info = self.good("info", target)
        done = run("detect", target, "--steps", "0")
        self.assertEqual(done.returncode, 0)
        self.assertRegex(done.stderr, r"cut.vtkhdf is incomplete: steps 0 to \d+ of 0 to 4999 are complete; interrupted")
        self.assertRegex(info, r"INCOMPLETE steps 0 to \d+ of 0 to 4999 are complete; interrupted")

    def test_an_interrupted_experiment_leaves_the_whole_record(self):
        data = self.path("projectile")
        os.makedirs(os.path.join(data, "records"))
        self.good("scene", "generate", "builtin", "--elements", "300", "--steps", "61", "-o",
                  os.path.join(data, "ls-dyna-projectile.vtkhdf"))
        env, results = {"VOLCCD_DATA": data}, os.path.join(data, "records")
        for name in ("projectile.json", "projectile.txt"):
            self.write("projectile/records/" + name, "whole")
        cut = Interruption("experiment", "run", "projectile", "-o", results, done=1, env=env)
        self.assertEqual(cut.code, 130, cut.screen)
        self.assertIn("stopped; the same command goes on", cut.screen)
        kept = ["projectile.incomplete.jsonl", "projectile.json", "projectile.txt"]
        self.assertEqual(sorted(os.listdir(results)), kept)
        cut = Interruption("experiment", "run", "projectile", "-o", results, done=60, env=env)
        self.assertEqual(cut.code, 130, cut.screen)
        self.assertEqual(sorted(os.listdir(results)), kept)
        for name in ("projectile.json", "projectile.txt"):
            self.assertEqual(self.read("projectile/records/" + name), b"whole")
        windows = self.read("projectile/records/projectile.incomplete.jsonl").decode().splitlines()[1:]
        self.assertGreaterEqual(len(windows), 2)
        first = json.loads(windows[0])["rows"]
        self.assertEqual(len(first), 4 * len({row["motion"] for row in first}))
        text = self.good("experiment", "run", "projectile", "-o", results, env=env)
        self.assertRegex(text, r"going on, [1-9]\d* window")
        rows = json.loads(self.read("projectile/records/projectile.json"))["rows"]
        self.assertEqual(len(rows), 4 * 60)
        self.assertEqual(rows[:len(first)], first)
        self.no_leftovers()


if __name__ == "__main__":
    unittest.main()
