"""The documents agree with the program: presets, stages, options and their defaults,
commands, exit codes, columns and keys of files. A document that names something that is not there fails."""

import json
import os
import re
import shlex
import subprocess
import sys
import tempfile
import unittest
from pathlib import Path

VOLCCD, EXAMPLE = (os.path.abspath(path) for path in sys.argv[1:3])
del sys.argv[1:3]
ROOT = Path(__file__).resolve().parents[2]
DOCUMENTS = [*sorted(ROOT.glob("*.md")), *sorted(ROOT.glob("docs/*.md"))]
ROLE_OF_OPTION = {"--narrowphase": "narrow-phase", "--judge": "narrow-phase", "--filters": "feature-filter"}


def run(*arguments, program=VOLCCD):
    return subprocess.run([program, *arguments], capture_output=True, text=True, check=False)


def text_of(name):
    return (ROOT / name).read_text(encoding="utf-8")


class Stages:
    """`stages --json`: stages by role, their guarantees, options (what is allowed, default); of each pipeline the
    cells of docs/pipelines.md's table."""

    def __init__(self, program):
        shown = json.loads(run("stages", "--json", program=program).stdout)
        self.roles, self.options, self.guarantees = {}, {}, {}
        for stage in shown["stages"]:
            self.roles.setdefault(stage["role"], []).append(stage["name"])
            self.guarantees[stage["name"]] = stage["guarantee"]
            self.options[stage["name"]] = {option["name"]: (option["allowed"], option["default"])
                                           for option in stage["options"]}
        roles = ("broad_phase", "element_culling", "assignment", "orphans", "flood", "feature_filters", "narrow_phase")
        self.pipelines = {spec["name"]: [self.cell(spec[role]) for role in roles] for spec in shown["pipelines"]}

    @staticmethod
    def cell(choices):
        choices = choices if isinstance(choices, list) else [choices] if choices else []
        return ", ".join(choice["name"] + (f"({', '.join('='.join(o) for o in choice['options'].items())})"
                                           if choice["options"] else "") for choice in choices) or "none"

    def check_option(self, stage, option, value=None):
        """Describes the problem, or returns None."""
        if option not in self.options.get(stage, {}):
            return f"no option {stage}.{option}"
        allowed, _ = self.options[stage][option]
        bounds = re.fullmatch(r"(\S+) \.\. (\S+)", allowed)
        if value is None or re.fullmatch(r"[A-Z]", value):
            return None
        inside = float(bounds[1]) <= float(value) <= float(bounds[2]) if bounds else value in allowed.split("|")
        return None if inside else f"{stage}.{option} is {allowed}, not {value}"

    def check_choice(self, role, text):
        """Checks a list name[:option=value...][,name...] or "none", the form of `--narrowphase` and `--set role=`."""
        for choice in [] if text == "none" else text.split(","):
            name, *options = choice.split(":")
            if name not in self.roles[role]:
                return f"no {role} {name}"
            for option in options:
                if problem := self.check_option(name, *option.split("=", 1)):
                    return problem
        return None

    def check_setting(self, text):
        key, value = text.split("=", 1)
        if "." in key:
            return self.check_option(*key.split(".", 1), value)
        return self.check_choice(key, value) if key in self.roles else f"no role {key}"


class Command:
    """Options of a command from its `--help`: whether each takes a value, the values that it may have, and its
    default."""

    def __init__(self, *words):
        self.text = run(*words, "--help").stdout
        self.options, self.subcommands = {}, []
        block = re.search(r"^Subcommands:\n((?:  .*\n)+)", self.text, re.MULTILINE)
        if block:
            self.subcommands = re.findall(r"^  (\w+) ", block[1], re.MULTILINE)
        for match in re.finditer(r"^  (-\S+)(.*)$", self.text, re.MULTILINE):
            # An option has one blank, its value, several blanks, and the description; a flag has the description at
            # once.
            rest = re.match(r"(?: (\S+(?: \S+)*))?(?:  |$)", match[2])
            rest = re.sub(r"Excludes: \S+|REQUIRED", "", rest[1] or "" if rest else "")
            choices = re.search(r"\{([\w,]+)\}", rest)
            default = re.search(r"=(\S+)", rest)
            for name in re.sub(r"\{.*?\}", "", match[1]).split(","):
                self.options[name] = (bool(rest.strip()), choices and choices[1].split(","), default and default[1])


STAGES = Stages(EXAMPLE)  # stages of the library and of the example
LIBRARY = Stages(VOLCCD)
PROGRAM = Command()
COMMANDS = {(name,): Command(name) for name in PROGRAM.subcommands}
COMMANDS |= {(*path, name): Command(*path, name)
             for path, command in list(COMMANDS.items()) for name in command.subcommands}
SCENES = {scene["name"] for scene in json.loads(run("scene", "list", "--json").stdout)["scenes"]}
# These are listed only if their files exist.
SCENES |= {"ls-dyna-projectile", "openradioss-bullet", "openradioss-airbag", "openradioss-crash"}
EXPERIMENTS = {one["name"] for one in json.loads(run("experiment", "list", "--json").stdout)["experiments"]}


def known_sequence(name):
    return "." in name or name.isupper() or re.sub(r"(-quick)?(-seed-\d+)?$", "", name) in SCENES


def problem_in_value(option, value):
    if option == "--set":
        return STAGES.check_setting(value)
    if option in ROLE_OF_OPTION and not value.isupper():
        return STAGES.check_choice(ROLE_OF_OPTION[option], value)
    if option == "--pipeline" and value not in STAGES.pipelines:
        return f"no pipeline {value}"
    return None


def problem_in_command(words):
    """The first of the words after the program's name that the program does not accept, or None."""
    path = tuple(words[:1])
    if path not in COMMANDS:
        return None if path and (path[0].startswith("--") or path[0] == "COMMAND") else f"no command {path}"
    if COMMANDS[path].subcommands and len(words) > 1:
        path = tuple(words[:2])
        if path not in COMMANDS:
            return None if words[1].startswith("--help") else f"no command {path}"
    words, command, positionals = list(words[len(path):]), COMMANDS[path], []
    while words:
        word = words.pop(0)
        if not word.startswith("-"):
            positionals.append(word)
            continue
        if word not in command.options:
            return f"{' '.join(path)} has no option {word}"
        takes_value, choices, _ = command.options[word]
        if takes_value and words:
            value = words.pop(0)
            if choices and value not in choices:
                return f"{word} is one of {choices}, not {value}"
            sweep = path == ("experiment", "run") and word == "--set" and "." in value.split("=")[0]
            key, _, listed = value.partition("=")
            values = [f"{key}={one}" for one in listed.split(",")] if sweep else [value]
            if problem := next(filter(None, (problem_in_value(word, one) for one in values)), None):
                return problem
    names = {("scene", "generate"): SCENES, ("experiment", "run"): EXPERIMENTS,
             ("experiment", "table"): EXPERIMENTS}.get(path)
    if path in (("experiment", "compare"), ("report",)):
        return None  # the arguments are folders
    if path == ("help",):
        return None if not positionals or positionals == ["COMMAND"] or tuple(positionals) in COMMANDS else \
            f"no command {positionals}"
    if path == ("check",):
        names = {name for name in [*STAGES.options, *positionals[1:]] if name in STAGES.options or known_sequence(name)}
    known = names.__contains__ if names else known_sequence
    return next((f"{' '.join(path)}: what is {name}?" for word in positionals for name in word.split("|")
                 if not known(name) and not name.isupper()), None)


def code_in(text):
    """Lines of indented and fenced blocks, and texts between single backticks without their line breaks."""
    yield from re.findall(r"^    (\S.*)$", text, re.MULTILINE)
    for block in re.findall(r"^```.*?\n(.*?)^```", text, re.MULTILINE | re.DOTALL):
        yield from block.splitlines()
    for code in re.findall(r"(?<!`)`([^`]+)`(?!`)", text):
        yield " ".join(code.split())


class DocsAgainstProgram(unittest.TestCase):
    def test_the_program_is_understood(self):
        self.assertEqual(list(LIBRARY.roles),
                         ["broad-phase", "element-culling", "assignment", "orphans", "flood", "feature-filter",
                          "narrow-phase"])
        self.assertGreater(sum(map(len, LIBRARY.options.values())), 15)
        self.assertGreaterEqual(len(COMMANDS), 12)
        self.assertEqual(COMMANDS[("detect",)].options["--motion"],
                         (True, ["linear", "quadratic", "tentative", "query"], "linear"))
        self.assertEqual(COMMANDS[("detect",)].options["--first"][0], False)
        self.assertGreaterEqual(len(SCENES), 8)

    def test_table_of_presets(self):
        page = text_of("docs/pipelines.md")
        rows = {row[0]: row[1:] for row in ([cell.strip() for cell in line.strip("|").split("|")]
                                           for line in re.findall(r"^\| `[A-Z][\w-]+\+?` \|.*$", page, re.MULTILINE))}
        self.assertEqual(sorted(rows), sorted(f"`{name}`" for name in LIBRARY.pipelines))
        for name, cells in LIBRARY.pipelines.items():
            for documented, actual in zip(rows[f"`{name}`"], cells[:6], strict=True):
                values = re.findall(r"=(\w+)", actual)
                stages = [] if actual == "none" else re.sub(r"\(.*?\)", "", actual).replace(",", " ").split()
                named = re.findall(r"`([\w-]+)`", documented)
                self.assertEqual([word for word in named if word in LIBRARY.options], stages, f"{name}: {documented}")
                for value in values:
                    self.assertRegex(documented, rf"\b{value}\b", name)
        narrow = re.search(r"have the narrow phase\s+`(\w+)`, those of 2011 `(\w+)`", page)
        self.assertIsNotNone(narrow)
        for name, cells in LIBRARY.pipelines.items():
            self.assertEqual(cells[6], narrow[2] if name.endswith("-2011") else narrow[1], name)

    def test_lists_of_stages_and_choices_are_complete(self):
        def first_column_in_order(name):
            return re.findall(r"^\| `([a-z][a-z0-9-]+)` \|", text_of(name), re.MULTILINE)

        def first_column(name):
            return sorted(set(first_column_in_order(name)))

        self.assertEqual(first_column("docs/feature_filters.md"), sorted(LIBRARY.roles["feature-filter"]))
        self.assertEqual(first_column("docs/assignment.md"),
                         sorted(LIBRARY.roles["assignment"] + LIBRARY.roles["orphans"]))
        self.assertEqual(first_column("docs/csat.md"), sorted(LIBRARY.options["csat"]["axis"][0].split("|")))
        headings = re.findall(r"^## ([a-z]+-[a-z]+)$", text_of("docs/broad_phases.md"), re.MULTILINE)
        # broad phases of other libraries, as far as the build has them
        peers = first_column_in_order("docs/broad_phases.md")
        self.assertEqual(len(peers), 4)
        self.assertEqual(headings + [name for name in peers if name in LIBRARY.options], LIBRARY.roles["broad-phase"])
        roles = re.findall(r"^\| ([a-z-]+) \| `[A-Z]", text_of("docs/adding_a_stage.md"), re.MULTILINE)
        self.assertEqual(roles, list(LIBRARY.roles))

    def test_guarantees(self):
        for name in LIBRARY.roles["narrow-phase"]:
            for guarantee in re.findall(r"Guarantee:\s+`(\w+)`", text_of(f"docs/narrowphase_{name}.md")):
                self.assertEqual(guarantee, LIBRARY.guarantees[name], name)

    def test_options_named_exist(self):
        for document in DOCUMENTS:
            for code in code_in(document.read_text(encoding="utf-8")):
                match = re.fullmatch(r"(?:--set )?([a-z]+(?:-[a-z]+)*)\.([a-z_]+)(?:=(\w\S*))?", code)
                if match and match[1] != "stage" and (match[1] in STAGES.options or match[3]):
                    self.assertIsNone(STAGES.check_option(match[1], match[2], match[3]), f"{document.name}: {code}")

    def test_defaults_are_as_stated(self):
        every = [(name, default) for options in STAGES.options.values() for name, (_, default) in options.items()]
        command_defaults = {(name, option[2]) for command in COMMANDS.values()
                            for name, option in command.options.items()}
        values = {default for _, default in every} | {default for _, default in command_defaults}
        stated = 0
        for document in DOCUMENTS:
            text = " ".join(document.read_text(encoding="utf-8").split())
            for name, default in re.findall(r"`(\w+)` \((?:default )?(\d[\de.-]*)(?: of the step)?\)", text):
                of_name = [float(value) for option, value in every if option == name]
                if of_name:
                    stated += 1
                    self.assertIn(float(default), of_name, f"{document.name}: {name}")
            remark = r"(?:, the default\b| \((?:the )?default\)| is the default\b)"
            for value in re.findall(rf"`(?:--\w+ )?([\w-]+)`{remark}", text):
                stated += 1
                self.assertIn(value, values, document.name)
            for option, value in re.findall(r"`(--\w+) (\w+)` \(the default\)", text):
                self.assertIn((option, value), command_defaults, document.name)
        self.assertGreater(stated, 6)

    def test_commands_are_understood(self):
        seen = 0
        sources = {document.name: document.read_text(encoding="utf-8") for document in DOCUMENTS}
        sources |= {" ".join(path) + " --help": "\n".join("  " + line for line in
                                                       re.sub(r" \\\n +", " ", command.text).splitlines())
                    for path, command in COMMANDS.items()}
        for name, text in sources.items():
            for code in code_in(text):
                code = re.split(r"\s{3,}", code)[0]  # the rest of the line is a remark
                if match := re.match(r"(?:build/(?:release/)?)?(?:volccd|custom_culling) (\S.*)", code):
                    words = shlex.split(match[1])
                elif code.startswith("--pipeline ") and name.endswith(".md"):
                    words = ["detect", *shlex.split(code)]
                else:
                    continue
                seen += 1
                if name != "troubleshooting.md":  # its commands fail on purpose (test_how_to.py)
                    self.assertIsNone(problem_in_command(words), f"{name}: {code}")
        self.assertGreater(seen, 60)

    def test_single_options_exist(self):
        known = {option for command in (PROGRAM, *COMMANDS.values()) for option in command.options}
        scripts = "".join(text_of(name) for name in ("scripts/test", "scripts/reproduce", "scripts/benchmark-guard", "scripts/build-report",
                                                     "tools/import_sequence.py", "tools/plot_results.py"))
        for document in DOCUMENTS:
            for code in code_in(document.read_text(encoding="utf-8")):
                if match := re.match(r"(--[a-z][\w-]*)(?: (\S+=\S+))?", code):
                    self.assertTrue(match[1] in known or match[1] in scripts, f"{document.name}: {code}")
                    if match[1] == "--set" and match[2] and not match[2].startswith(("stage.", "role=")):
                        self.assertIsNone(STAGES.check_setting(match[2]), f"{document.name}: {code}")

    def test_exit_codes(self):
        said = re.search(r"Exit codes: (.*?)\.", PROGRAM.text, re.DOTALL)[1]
        documented = re.search(r"Exit\s+codes: (.*?)\.", text_of("README.md"), re.DOTALL)[1]
        self.assertEqual(re.findall(r"(?:^|,\s)(\d+) ", documented), re.findall(r"(?:^|,\s)(\d+) ", said))
        self.assertEqual(run("stages").returncode, 0)
        self.assertEqual(run("info", "no-such-file.vtkhdf").returncode, 2)

    def test_files_that_detect_writes(self):
        with tempfile.TemporaryDirectory() as folder:
            path = lambda name: os.path.join(folder, name)
            made = run("scene", "generate", "builtin", "--elements", "200", "--frames", "3", "-o", path("run.vtkhdf"))
            self.assertEqual(made.returncode, 0, made.stderr)
            done = run("detect", path("run.vtkhdf"), "--contacts", path("c.csv"), "--overlaps", path("o.csv"),
                       "--stats", path("s.json"))
            self.assertEqual(done.returncode, 0, done.stderr)
            contacts, overlaps, stats = (Path(path(name)).read_text(encoding="ascii")
                                         for name in ("c.csv", "o.csv", "s.json"))
        columns = contacts.splitlines()[0]
        self.assertIn(f"\n    {columns}\n", text_of("docs/sequence_files.md"))
        self.assertIn(f"//     {columns}\n", text_of("io/contacts_csv.hpp"))
        self.assertIn(f"`{overlaps.splitlines()[0]}`", text_of("docs/initial_overlaps.md"))
        self.check_stats_keys(json.loads(stats))

    def check_stats_keys(self, stats):
        page = text_of("docs/pipelines.md")
        rows = re.search(r"\| keys of `stats.json` \|.*?\n\|---\|---\|\n((?:\|.*\n)+)", page)[1].splitlines()
        for row in rows:
            keys, meaning = (re.findall(r"`(\w+)`", cell) for cell in row.strip("|").split("|"))
            for key in keys:
                self.assertIn(key, stats, "stats.json")
                inside = stats[key][0] if isinstance(stats[key], list) else stats[key]
                inner = {*inside, *inside.get("stages", [{}])[0]} if isinstance(inside, dict) else set()
                self.assertLessEqual(set(meaning), inner, f"stats.json, {key}")

    def test_figures_of_records(self):
        """Numbers above a thousand that stand beside the name of a record must occur in that record."""
        paragraphs = [(document.name, text) for document in DOCUMENTS
                      for text in re.split(r"\n\s*\n", document.read_text(encoding="utf-8"))]
        page = "docs/simulation.md"  # the name of its record is in the paragraph before the numbers
        paragraphs.append((page, text_of(page).split("## Which features collide")[1].split("\n## ")[0]))
        seen = 0
        for name, text in paragraphs:
            records = re.findall(r"results/[\w-]+\.(?:json|txt)", text)
            figures = "".join(text_of(record) for record in records).replace(",", "")
            for number in re.findall(r"\b\d{1,3}(?:,\d{3})+\b", text) if records else []:
                seen += 1
                self.assertRegex(figures, rf"\b{number.replace(',', '')}\b", f"{name}: {number} is not in {records}")
        self.assertGreater(seen, 3)


if __name__ == "__main__":
    unittest.main()
