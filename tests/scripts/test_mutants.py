#!/usr/bin/env python3
"""scripts/mutants: its list agrees with the sources and the tests, and changes are written where they belong."""

import contextlib
import dataclasses
import importlib.machinery
import importlib.util
import io
import re
import sys
import tempfile
import unittest
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
LOADER = importlib.machinery.SourceFileLoader("mutants", str(ROOT / "scripts/mutants"))
mutants = importlib.util.module_from_spec(importlib.util.spec_from_loader("mutants", LOADER))
sys.modules["mutants"] = mutants  # for its dataclass
LOADER.exec_module(mutants)

SUITE = re.compile(r"(?:TEST(?:_F|_P)?|TYPED_TEST)\((\w+),")


def mutant(name, old, new, context=None):
    return mutants.Mutant(name, "a.cpp", old, new, "clause", ("m.S",), context or old)


def list_of(text):
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "list"
        path.write_text(text)
        return mutants.read_list(path)


class List(unittest.TestCase):
    def test_original_texts_are_in_the_sources(self):
        mutants.check_places(ROOT, mutants.read_list(mutants.LIST))

    def test_functions_are_in_their_files(self):
        one = next(m for m in mutants.read_list(mutants.LIST) if m.function)
        with self.assertRaisesRegex(mutants.Failure, "has no function Gone::gone"):
            mutants.check_places(ROOT, [dataclasses.replace(one, function="Gone::gone")])

    def test_each_entry_names_suites_that_there_are(self):
        suites = {}
        for m in mutants.read_list(mutants.LIST):
            self.assertTrue(m.clause and m.tests, m.name)
            self.assertNotEqual(m.old, m.new, m.name)
            for test in m.tests:
                module, _, suite = test.partition(".")
                if module not in suites:
                    files = (ROOT / "tests").glob(f"**/{module}/**/*.cpp")
                    suites[module] = {s for f in files for s in SUITE.findall(f.read_text())}
                found = [s for s in suites[module] if re.match(suite, s) and not s.startswith("Long")]
                self.assertTrue(found, f"[{m.name}]: no quick suite of tests/{module} begins with '{suite}'")

    def test_bad_entries(self):
        good = "[a]\nfile = f\nold = x\nnew =\nclause = c\ntests = m.S\n"
        self.assertEqual(list_of(good)[0].new, "")
        for bad in (good.replace("clause = c\n", ""), good + "more = 1\n", good + good, "file = f\n"):
            with self.assertRaises(mutants.Failure):
                list_of(bad)

    def test_texts_that_cannot_be_compiled(self):
        mutants.check_texts(mutant("m", "f(a);", ""))
        mutants.check_texts(mutant("m", "a && f(b)", "a"))
        for old, new in (("a", ""), ("a &&", "a"), ("if (a)", "if (false)"), ("f({.a = b}});", ""), ("a", "(b")):
            with self.assertRaisesRegex(mutants.Failure, r"^\[m\]: "):
                mutants.check_texts(mutant("m", old, new))

    def test_choice_by_pattern(self):
        every = [mutant(name, "x", "y") for name in ("a-1", "a-2", "b-1")]
        self.assertEqual([m.name for m in mutants.chosen(every, ["a-*", "b-1"])], ["a-1", "a-2", "b-1"])
        self.assertEqual(mutants.chosen(every, []), every)
        with self.assertRaises(mutants.Failure):
            mutants.chosen(every, ["c*"])


class Rewrite(unittest.TestCase):
    def rewritten(self, text, *changes):
        return mutants.rewrite(text, list(changes))

    def test_expressions_and_statements(self):
        m, n = mutant("m", "a + b", "a"), mutant("n", "f();", "")
        text, lines = self.rewritten("int x = a + b;\nf();\n", m, n)
        self.assertEqual(text, "#include <volccd/core/mutant.hpp>\n"
                         f"int x = (::volccd_mutant({m.number}u) ? (a) : (a + b));\n"
                         f"{{ if (::volccd_mutant({n.number}u)) {{  }} else {{ f(); }} }}\n")
        self.assertEqual({name: list(span) for name, span in lines.items()}, {"m": [2], "n": [3]})

    def test_several_changes_in_one_place(self):
        changes = [mutant("inner", "b", "c"), mutant("same", "a + b", "a - b"), mutant("outer", "f(a + b)", "0")]
        text, _ = self.rewritten("f(a + b)", *changes)
        for m in changes:
            self.assertIn(f"volccd_mutant({m.number}u) ? ({m.new})", text)
        self.assertEqual(re.sub(r"\(::volccd_mutant\(\d+u\) \? \([^()]*\) : \(", "", text.split("\n")[1]).replace(")", ""),
                         "f(a + b")

    def test_context(self):
        with self.assertRaises(mutants.Failure):
            self.rewritten("x; y; x;", mutant("m", "x;", ""))
        text, _ = self.rewritten("x; y;\n    x;", mutant("m", "x;", "", "y;\nx;"))
        self.assertTrue(text.endswith("else { x; } }"))
        self.assertIn("\nx; y;\n", text)

    def test_what_is_not_there_or_overlaps(self):
        for changes in ([mutant("m", "z", "")], [mutant("m", "a + b", "0"), mutant("n", "b + c", "0")]):
            with self.assertRaises(mutants.Failure):
                self.rewritten("a + b + c", *changes)

    def test_mutants_that_do_not_compile(self):
        m, n = mutant("m", "x", "y"), mutant("n", "x2", "y")
        output = "/tree/a.cpp: In function\n/tree/a.cpp:7:3: error: no\n/tree/b.cpp:9:1: error: no\n"
        self.assertEqual(mutants.broken_mutants(output, {"m": range(7, 8), "n": range(9, 10)}, [m, n]), {m: "no"})


class Tests(unittest.TestCase):
    def test_selection(self):
        m = mutants.Mutant("m", "a.cpp", "x", "y", "c", ("culling.Rings", "broadphase."), "x")
        for name, selected in (("culling.Rings.A", True), ("culling.All/RingsB.C/1", True), ("culling.Other.A", False),
                               ("broadphase.Any.Thing", True), ("x.culling.Rings", False)):
            self.assertEqual(bool(re.search(m.selection(), name)), selected, name)

    def test_output_of_ctest(self):
        for line, result in (("1/9 Test #12: a.B.C ....***Failed    0.01 sec", ("a.B.C", "Failed")),
                             ("1/9 Test  #2: a.B.C .....***Timeout  30.01 sec", ("a.B.C", "Timeout")),
                             ("1/9 Test  #2: a.B.C ..Subprocess aborted***Exception:   0.1 sec", ("a.B.C", "Exception")),
                             ("1/9 Test  #2: a.B.C ...***Exception: SegFault  0.1 sec", ("a.B.C", "Exception"))):
            self.assertEqual(mutants.FINISHED.search(line).groups(), result)
        passed = "2/9 Test #3: a.B.C ............   Passed    0.25 sec"
        failed = "3/9 Test #4: a.B.D ....***Failed    0.01 sec"
        self.assertEqual(mutants.FINISHED.search(f"{passed}\n{failed}").groups(), ("a.B.D", "Failed"))
        self.assertIsNone(mutants.FINISHED.search(passed))
        self.assertEqual(mutants.PASSED.findall(passed), ["0.25"])


class Arguments(unittest.TestCase):
    def run_main(self, *arguments):
        out, err = io.StringIO(), io.StringIO()
        with contextlib.redirect_stdout(out), contextlib.redirect_stderr(err):
            code = mutants.main(list(arguments))
        return code, out.getvalue(), err.getvalue()

    def test_check_and_list(self):
        count = len(mutants.read_list(mutants.LIST))
        self.assertEqual(self.run_main("--check"), (0, f"{count} mutants agree with the sources\n", ""))
        self.assertEqual(self.run_main("--list")[1].count("\n"), 2 * count)

    def test_bad_usage(self):
        code, _, err = self.run_main("--only", "no-such-name")
        self.assertEqual(code, 2)
        self.assertIn("no mutant has a name like 'no-such-name'", err)
        with self.assertRaises(SystemExit) as stopped:
            self.run_main("--unknown")
        self.assertEqual(stopped.exception.code, 2)


if __name__ == "__main__":
    unittest.main()
