"""experiment: records, tables, comparisons, and what remains after an interruption."""

import json
import os
import shutil
import subprocess
import unittest

from json_schema import problems
from program_support import EXAMPLE, SOURCE, run, Interruption, ProgramTest

with open(os.path.join(SOURCE, "docs/record.schema.json"), encoding="utf-8") as schema_file:
    SCHEMA = json.load(schema_file)["$defs"]


class Experiments(ProgramTest):
    def follows_schema(self, path):
        """Returns the record."""
        with open(path, encoding="utf-8") as file:
            record = json.load(file)
        some = dict(record, rows=record["rows"][:100] + record["rows"][-100:])
        self.assertEqual(list(problems(some, SCHEMA[record["experiment"]], SCHEMA)), [], path)
        return record

    def test_experiment_falls_back_to_the_builtin_sequence(self):
        text = self.good("experiment", "run", "projectile", "--quick", "-o", self.path("results"),
                         env={"VOLCCD_DATA": self.folder.name})
        self.assertIn("built-in sequence", text)
        self.assertIn("0.69 %", text)
        record = self.follows_schema(self.path("results/projectile.json"))
        self.assertEqual({row["pipeline"] for row in record["rows"]}, {"NavCCD", "HashCCD", "VolCCD", "VolCCD+"})
        self.assertEqual({row["step"] for row in record["rows"]}, set(range(8)))
        self.assertEqual({row["scene"] for row in record["rows"]}, {"builtin"})
        names = [option for stage in record["provenance"]["plan"]["runs"][0]["entrants"][0]["stages"].values()
                 if isinstance(stage, dict) for option in stage["options"]]
        self.assertIn("leaf_size", names)  # options are recorded even if they were not set
        for fact in ("commit", "compiler", "flags", "cpu", "load", "inputs"):
            self.assertIn(fact, record["provenance"])
        self.assertNotIn(self.folder.name, json.dumps(record))  # the record has no path of this machine
        for form, sign in (("text", "0.69 %"), ("markdown", "|---|"), ("csv", "NavCCD,"), ("latex", "\\toprule")):
            table = self.good("experiment", "table", "projectile", "--results", self.path("results"), "--format", form)
            self.assertIn(sign, table)
        text = self.good("experiment", "table", "projectile", "--results", self.path("results"))
        with open(self.path("results/projectile.txt"), encoding="utf-8") as file:
            self.assertEqual(text, file.read())
        same = self.good("experiment", "compare", self.path("results"), self.path("results"))
        self.assertIn("4 compared: 0 slower, 0 faster beyond the tolerance, 0 with other counts", same)
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
        self.assertIn("no runs of pipelines, not compared: operations\n", changed.stdout)
        self.good("experiment", "compare", self.path("results"), self.path("results"))
        os.remove(self.path("other/operations.json"))
        for sides, letter in ((("results", "other"), "A"), (("other", "results"), "B")):
            missing = run("experiment", "compare", *map(self.path, sides))
            self.assertEqual(missing.returncode, 1)
            self.assertIn(f"not compared: record operations: only in {letter}\n", missing.stdout)
        self.bad("experiment", "table", "projectile", "--results", self.path("absent"), says="projectile.json")
        self.bad("experiment", "compare", self.path("results"), self.path("absent"), says="absent")

    def test_own_scenes_steps_and_rounds(self):
        folder, other = self.path("mine"), self.path("other.vtkhdf")
        self.good("scene", "generate", "builtin", "--elements", "200", "--frames", "5", "-o", other)
        scenes = ["--scenes", f"{self.sequence},{other}", "-o", folder]
        self.good("experiment", "run", "projectile", *scenes, "--steps", "1:3", "--rounds", "2")
        with open(self.path("mine/projectile.json"), encoding="utf-8") as file:
            record = json.load(file)
        name = os.path.basename(self.sequence)
        self.assertEqual({(row["scene"], row["step"], row["round"]) for row in record["rows"]},
                         {(scene, motion, of) for scene in (name.split(".")[0], "other") for motion in (1, 2) for of in (0, 1)})
        self.assertEqual(record["provenance"]["options"], f"--scenes {name},other.vtkhdf --steps 1:3 --rounds 2")
        self.assertNotIn(self.folder.name, json.dumps(record))  # the record has no path of this machine
        table = self.good("experiment", "table", "projectile", "--results", folder)
        self.assertIn("other", table)
        for kind in ("table1", "baselines", "plus", "ablation", "boundary"):  # ablation: two pipelines, which takes less time
            extra = {"ablation": ["--pipelines", "VolCCD,VolCCD+"], "table1": ["--rounds", "2"]}.get(kind, [])
            self.good("experiment", "run", kind, "--scenes", other, "--steps", "2", "-o", folder, *extra)
            with open(self.path(f"mine/{kind}.json"), encoding="utf-8") as file:
                rows = json.load(file)["rows"]
            self.assertEqual({(row["scene"], row["step"]) for row in rows}, {("other", 2)}, kind)
            if kind == "table1":
                self.assertEqual({(row["table"], row["round"]) for row in rows}, {(table, of) for table in "abc" for of in (0, 1)})
        os.mkdir(self.path("sub"))
        shutil.copy(other, self.path("sub/other.vtkhdf"))
        self.good("experiment", "run", "projectile", "--scenes", f"{other},{self.path('sub/other.vtkhdf')}", "--steps", "2",
                  "-o", folder)
        with open(self.path("mine/projectile.json"), encoding="utf-8") as file:
            self.assertEqual({row["scene"] for row in json.load(file)["rows"]}, {other, self.path("sub/other.vtkhdf")})
        for names, options, says in (
                (["projectile"], ["--quick", "-o", folder], "is the record of a run with --scenes; give another folder"),
                (["culling"], scenes, "culling takes no --scenes: its scenes are fixed; projectile, table1"),
                (["all"], scenes, "all takes no --scenes"), (["scenes"], ["--rounds", "2"], "scenes takes no --rounds"),
                (["peers"], ["--steps", "1"], "peers takes no --steps"), (["projectile"], ["--rounds", "0"], "--rounds"),
                (["projectile"], ["--scenes", f"{other},{other}"], "is there twice"),
                (["projectile"], [*scenes, "--steps", "4:9"], "--steps: 4:9 is not within the steps 0:"),
                (["projectile"], ["--scenes", self.path("absent.vtkhdf")], "absent.vtkhdf")):
            self.bad("experiment", "run", *names, *options, says=says)

    def test_full_ratios_are_of_two_processes(self):
        for output in ([], ["--json"]):
            folder = self.path("two" + "".join(output))
            done = self.good("experiment", "run", "baselines", "--full", "--scenes", self.sequence, "--steps", "2:4",
                             "--rounds", "3", "-o", folder, *output)
            with open(os.path.join(folder, "baselines.json"), encoding="utf-8") as file:
                record = json.load(file)
            self.assertEqual({(row["process"], row["round"]) for row in record["rows"]}, {(0, 0), (1, 1), (1, 2)})
            self.assertFalse(os.path.exists(os.path.join(folder, "baselines.incomplete.jsonl")))
            if output:
                self.assertEqual([one["complete"] for one in json.loads(done)["experiments"]], [True])
            else:
                self.assertIn("the other rounds follow in another process", done)
                self.assertIn("Speed-up over the strongest baseline", done)

    def test_an_interruption_reaches_the_other_process(self):
        folder, sequence = self.path("cut"), self.path("long.vtkhdf")
        self.good("scene", "generate", "builtin", "--elements", "300", "--frames", "61", "-o", sequence)
        command = ["experiment", "run", "baselines", "--full", "--scenes", sequence, "--rounds", "2", "-o", folder]
        cut = Interruption(*command, done=150)  # of 192 to 240
        self.assertEqual(cut.code, 130, cut.screen)
        self.assertIn("another process", cut.out)
        self.assertIn("stopped; the same command continues", cut.screen)
        self.assertIn("continued", self.good(*command))

    def test_a_quick_run_keeps_the_record_of_a_full_one(self):
        env = {"VOLCCD_DATA": self.path("absent"), "VOLCCD_CACHE": self.path("cache")}
        folder = self.path("full")
        shutil.copytree(os.path.join(SOURCE, "results"), folder, ignore=lambda _, names: [
            name for name in names if not name.endswith((".json", ".txt"))])
        before = {name: os.stat(os.path.join(folder, name)).st_mtime_ns for name in os.listdir(folder)}
        for names in (["projectile"], ["projectile", "--quick"], ["culling", "projectile"], ["feature-sets"],
                      ["scenes", "--quick"], ["all"]):
            first = names[0] if names[0] != "all" else "projectile"
            self.bad("experiment", "run", *names, "-o", folder, env=env, says=f"-o {folder}: {folder}/{first}.json is the "
                     "record of a full run, which a quick run does not replace; give another folder, or remove the file")
        self.assertEqual({name: os.stat(os.path.join(folder, name)).st_mtime_ns for name in os.listdir(folder)}, before)
        self.assertFalse(os.path.exists(self.path("cache")))  # nothing was simulated either
        os.remove(os.path.join(folder, "projectile.json"))
        for _ in range(2):  # a quick record may be replaced
            self.good("experiment", "run", "projectile", "--quick", "-o", folder, env=env)

    def test_the_default_folder_is_not_that_of_the_repository(self):
        for command in ("run", "table"):
            self.assertIn("=build/results", self.good("experiment", command, "--help"))
        ignored = subprocess.run(["git", "check-ignore", "-q", "build/results"], cwd=SOURCE, check=False).returncode
        self.assertIn(ignored, (0, 128))  # 128: not a clone

    def test_a_stage_from_outside_the_library_in_a_table(self):
        env = {"VOLCCD_DATA": self.path("absent")}
        arguments = ["experiment", "run", "projectile", "--pipelines", "Spheres,Spheres+CSAT", "-o", self.path("own")]
        done = run(*arguments, program=EXAMPLE, env=env)
        self.assertEqual(done.returncode, 0, done.stderr)
        self.assertRegex(done.stdout, r"\nSpheres +\S+ ms +")
        record = self.follows_schema(os.path.join(self.path("own"), "projectile.json"))
        self.assertEqual({row["pipeline"] for row in record["rows"]} - {"NavCCD", "HashCCD", "VolCCD"},
                         {"VolCCD+", "Spheres", "Spheres+CSAT"})
        self.bad(*arguments[:3], "--pipelines", "Nothing", "-o", self.path("own"), says="Spheres+CSAT", program=EXAMPLE)

    def test_committed_tables_are_those_of_their_records(self):
        results, compared = os.path.join(SOURCE, "results"), 0
        for name in ("table1", "baselines", "culling", "ablation", "scaling", "operations", "projectile", "plus", "boundary",
                     "inversion", "feature-sets", "peers", "substeps", "first-steps", "ranks"):
            if os.path.exists(os.path.join(results, name + ".json")):
                with open(os.path.join(results, name + ".txt"), encoding="utf-8") as file:
                    expected = file.read()
                self.assertEqual(self.good("experiment", "table", name, "--results", results), expected, name)
                self.follows_schema(os.path.join(results, name + ".json"))
                compared += 1
        self.assertGreater(compared, 0)

    def test_options_that_an_experiment_would_ignore_are_refused(self):
        env, folder = {"VOLCCD_DATA": self.path("absent"), "VOLCCD_CACHE": self.path("no-cache")}, self.path("refused")
        for name in ("culling", "operations", "scenes", "feature-sets"):
            self.bad("experiment", "run", name, "--quick", "--pipelines", "NavCCD", "-o", folder, env=env,
                     says=f"{name} takes no --pipelines")
        for name in ("projectile", "table1", "culling", "scaling", "plus", "operations", "scenes", "feature-sets"):
            self.bad("experiment", "run", name, "--quick", "--set", "csat.axis=face", "-o", folder, env=env,
                     says=f"{name} takes no --set")
        # One of several experiments does not take the option; then none is run.
        self.bad("experiment", "run", "projectile", "culling", "--quick", "--pipelines", "NavCCD", "-o", folder,
                 env=env, says="culling takes no --pipelines")
        self.assertFalse(os.path.exists(folder))
        self.assertFalse(os.path.exists(self.path("no-cache")))

    def test_an_interrupted_experiment_leaves_the_whole_record(self):
        data = self.path("projectile")
        os.makedirs(os.path.join(data, "records"))
        self.good("scene", "generate", "builtin", "--elements", "300", "--frames", "61", "-o",
                  os.path.join(data, "ls-dyna-projectile.vtkhdf"))
        env, results = {"VOLCCD_DATA": data}, os.path.join(data, "records")
        for name in ("projectile.json", "projectile.txt"):
            self.write("projectile/records/" + name, "whole")
        cut = Interruption("experiment", "run", "projectile", "-o", results, done=1, env=env)
        self.assertEqual(cut.code, 130, cut.screen)
        self.assertIn("stopped; the same command continues", cut.screen)
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
        self.assertEqual(len(first), 4 * len({row["step"] for row in first}))
        text = self.good("experiment", "run", "projectile", "-o", results, env=env)
        self.assertRegex(text, r"continued; [1-9]\d* part")
        whole = self.read("projectile/records/projectile.json")
        rows = json.loads(whole)["rows"]
        self.assertEqual(len(rows), 4 * 60)
        self.assertEqual(rows[:len(first)], first)
        text = self.good("experiment", "run", "projectile", "--skip-complete", "-o", results, env=env)
        self.assertIn("it is kept", text)
        self.assertEqual(self.read("projectile/records/projectile.json"), whole)
        # Another plan, and another input.
        text = self.good("experiment", "run", "projectile", "--skip-complete", "--pipelines", "BruteForce", "-o",
                         results, env=env)
        self.assertNotIn("it is kept", text)
        self.assertEqual(len(json.loads(self.read("projectile/records/projectile.json"))["rows"]), 5 * 60)
        self.no_leftovers()


if __name__ == "__main__":
    unittest.main()
