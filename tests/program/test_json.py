"""--json: the output of every command follows its schema in docs/output.schema.json."""

import json
import os
import re
import shlex
import unittest

from json_schema import problems
from program_support import SOURCE, Interruption, ProgramTest, run

with open(os.path.join(SOURCE, "docs/output.schema.json"), encoding="utf-8") as file:
    SCHEMA = json.load(file)
DEFINITIONS = SCHEMA["$defs"]
COMMANDS = [one["$ref"].removeprefix("#/$defs/").replace("-", " ") for one in SCHEMA["anyOf"]]


def examples():
    with open(os.path.join(SOURCE, "docs/json_output.md"), encoding="utf-8") as page:
        return re.findall(r"^    (volccd .*)$", page.read(), re.MULTILINE)


def commands_with_json(*path):
    """All commands whose --help contains --json."""
    text = run(*path, "--help").stdout
    block = re.search(r"^Subcommands:\n((?:  .*\n)+)", text, re.MULTILINE)
    if block:
        for name in re.findall(r"^  (\w+) ", block[1], re.MULTILINE):
            yield from commands_with_json(*path, name)
    elif re.search(r"^  --json ", text, re.MULTILINE):
        yield " ".join(path)


class Json(ProgramTest):
    @classmethod
    def setUpClass(cls):
        super().setUpClass()
        cls.no_data = {"VOLCCD_DATA": cls.path("absent")}
        done = run("experiment", "run", "projectile", "--quick", "-o", cls.path("results"), "--quiet", env=cls.no_data)
        assert (done.returncode, done.stdout) == (0, ""), done.stdout + done.stderr

    def valid(self, text, name):
        document = json.loads(text)
        self.assertEqual(list(problems(document, DEFINITIONS[name.replace(" ", "-")], DEFINITIONS)), [], name)
        return document

    def test_the_validator_finds_what_is_wrong(self):
        schema = {"type": "object", "properties": {"a": {"type": "integer", "minimum": 0}, "b": {"enum": ["x"]}},
                  "required": ["a"], "additionalProperties": False}
        wrong = lambda value: len(list(problems(value, schema, {})))
        self.assertEqual(wrong({"a": 1, "b": "x"}), 0)
        for value in ({}, {"a": True}, {"a": 1.5}, {"a": -1}, {"a": 1, "b": "y"}, {"a": 1, "c": 0}, []):
            self.assertEqual(wrong(value), 1, value)
        self.assertEqual(len(list(problems([1, "x"], {"type": "array", "items": {"type": "string"}}, {}))), 1)
        with self.assertRaises(ValueError):
            list(problems(1, {"maximum": 0}, {}))

    def test_every_command_with_json_has_a_schema(self):
        self.assertEqual(sorted(COMMANDS), sorted(commands_with_json()))

    def test_examples_follow_their_schemas(self):
        seen = []
        for example in examples():
            words = shlex.split(example.replace("run.vtkhdf", self.sequence).replace("RESULTS", self.path("results")))[1:]
            text = self.good(*words, env=self.no_data)
            seen.append(json.loads(text)["command"])
            self.valid(text, seen[-1])
        self.assertEqual(sorted(set(seen)), sorted(COMMANDS))

    def test_other_forms_follow_them_too(self):
        for arguments in (["--first"], ["--overlaps", os.devnull], ["--pipeline", "NavCCD", "--steps", "0"],
                          ["--pairs", "intra"]):
            document = self.valid(self.good("detect", self.sequence, "--json", *arguments), "detect")
            self.assertEqual(document["initial_overlaps"], "--overlaps" in arguments)
        self.valid(self.good("verify", self.sequence, "--json", "--no-fcl", "--approximate"), "verify")
        for name in ("scenes", "feature-sets", "plus", "peers"):
            shown = self.good("experiment", "table", name, "--results", os.path.join(SOURCE, "results"), "--json")
            self.valid(shown, "experiment table")

    def test_values(self):
        rows = self.contacts()[1:]
        document = json.loads(self.good("detect", self.sequence, "--json"))
        self.assertEqual(document["total"]["contacts"], len(rows))
        self.assertEqual(sum(pair["vf_contacts"] + pair["ee_contacts"] for pair in document["object_pairs"]), len(rows))
        first = min((int(row[0]), float(row[6])) for row in rows)
        self.assertEqual(document["earliest_step"], first[0])
        self.assertEqual(document["object_pairs"][0]["first_toi"], first[1])
        header = self.contacts()[0]
        objects = {tuple(sorted(int(row[header.index(name)]) for name in ("object_1", "object_2"))) for row in rows}
        self.assertEqual({tuple(pair["objects"]) for pair in document["object_pairs"]}, objects)
        self.assertTrue(json.loads(self.good("verify", self.sequence, "--json"))["clean"])
        info = json.loads(self.good("info", self.sequence, "--json"))
        self.assertEqual(sum(one["elements"] for one in info["frame_0"]["objects"]),
                         sum(info["frame_0"]["elements"].values()))

    def test_an_interrupted_run_follows_it_too(self):
        long = self.path("long.vtkhdf")
        self.good("scene", "generate", "builtin", "--elements", "2000", "--frames", "100", "-o", long)
        cut = Interruption("detect", long, "--json", "--pipeline", "NavCCD", done=2)
        self.assertEqual(cut.code, 130, cut.screen)
        document = self.valid(cut.out, "detect")
        self.assertEqual((document["complete"], document["stopped_by"]), (False, "interrupted"))

    def test_json_has_the_standard_output_for_itself(self):
        self.bad("detect", self.sequence, "--json", "--stats", "-", says="--json")
        done = run("detect", self.sequence, "--json", "--contacts", self.path("c.csv"))
        self.assertEqual((done.stdout[0], done.stderr), ("{", ""))


if __name__ == "__main__":
    unittest.main()
