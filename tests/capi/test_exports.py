#!/usr/bin/env python3
"""The shared library for C exports the functions of volccd.h and nothing else, under its version, and says in its name
which interface it has. Usage: test_exports.py LIBRARY VERSION"""

import re
import subprocess
import sys
import unittest
from pathlib import Path

HEADER = Path(__file__).resolve().parents[2] / "capi/volccd.h"
LIBRARY, VERSION = sys.argv[1:3]


def output(*command):
    return subprocess.run(command, check=True, capture_output=True, text=True).stdout


class Exports(unittest.TestCase):
    def test_exported_are_the_functions_of_the_header(self):
        text = re.sub(r"/\*.*?\*/", "", HEADER.read_text(), flags=re.DOTALL)
        declared = set(re.findall(r"\b(volccd_\w+)\(", text))
        self.assertGreater(len(declared), 10)
        exported, nodes = set(), set()
        for line in output("nm", "-D", "--defined-only", LIBRARY).splitlines():
            name, _, version = line.split()[-1].partition("@@")
            (exported if version else nodes).add(name)
        self.assertEqual(exported, declared)
        self.assertEqual(nodes, {f"VOLCCD_{VERSION.rpartition('.')[0]}"})

    def test_soname(self):
        soname = re.search(r"SONAME.*\[(.*)\]", output("readelf", "-d", LIBRARY)).group(1)
        self.assertEqual(soname, f"libvolccd_c.so.{VERSION.rpartition('.')[0]}")

    def test_the_header_is_c99(self):
        subprocess.run(["cc", "-std=c99", "-Wall", "-Wextra", "-Wpedantic", "-Wstrict-prototypes", "-Werror",
                        "-fsyntax-only", "-x", "c", "-include", str(HEADER), "/dev/null"], check=True)


if __name__ == "__main__":
    unittest.main(argv=sys.argv[:1])
