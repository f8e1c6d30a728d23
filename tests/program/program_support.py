"""The `volccd` program and the custom-culling example, as a user runs them: what the tests of this folder share.

Usage of a test: test_NAME.py VOLCCD EXAMPLE [options of unittest]."""

import csv
import json
import os
import pty
import re
import resource
import shutil
import signal
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
    """Runs a command and returns its result. `disk`: files cannot grow beyond this number of bytes, as on a full
    disk."""
    def limit():
        resource.setrlimit(resource.RLIMIT_FSIZE, (disk, disk))
    return subprocess.run([program, *arguments], capture_output=True, text=True, env={**os.environ, **(env or {})},
                          check=False, preexec_fn=limit if disk is not None else None)


def copy_results(target):
    """Copies results/ with one round of the largest records: all rounds take seconds in each command."""
    shutil.copytree(os.path.join(SOURCE, "results"), target)
    for name in ("plus.json", "baselines.json", "table1.json"):
        path = os.path.join(target, name)
        with open(path, encoding="utf-8") as file:
            record = json.load(file)
        record["rows"] = [row for row in record["rows"] if row["round"] == 0]
        with open(path, "w", encoding="utf-8") as file:
            json.dump(record, file)


def with_bad_last_step(sequence):
    """The bytes of a sequence whose steps have one chunk of points each, with the last of these chunks destroyed."""
    chunks = {}
    for match in re.finditer(rb"\x78[\x01\x5e\x9c\xda]", sequence):
        try:
            chunks.setdefault(len(zlib.decompressobj().decompress(sequence[match.start():])), []).append(match.start())
        except zlib.error:
            pass
    begin = max(chunks[max(chunks)])  # the largest arrays are the points
    return sequence[:begin + 100] + bytes(64) + sequence[begin + 164:]


class Interruption:
    """Runs a command on a terminal of its own and sends Ctrl-C when its progress shows `done` steps. `seconds`: the
    time from then to its end."""

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
                except OSError:  # the program has closed the terminal
                    break
                if not data:
                    break
                self.screen += data
                shown = re.findall(rb" (\d+) of \d+ ", self.screen)
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
        made = run("scene", "generate", "builtin", "--elements", "300", "--frames", "5", "-o", cls.sequence)
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

    def read(self, name):
        with open(self.path(name), "rb") as file:
            return file.read()

    def write(self, name, text):
        with open(self.path(name), "w", encoding="ascii") as file:
            file.write(text)
        return self.path(name)

    def no_leftovers(self):
        every = [name for _, _, names in os.walk(self.folder.name) for name in names]
        self.assertEqual([name for name in every if name.endswith("tmp")], [])
