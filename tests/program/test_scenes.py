"""scene and info: scenes by name, generated sequences, pictures, lists."""

import json
import os
import shutil
import struct
import unittest

from program_support import ProgramTest


class Scenes(ProgramTest):
    def test_picture(self):
        target = self.path("picture.png")
        self.good("scene", "picture", self.sequence, "--frames", "2", "--size", "160x120", "-o", target)
        with open(target, "rb") as file:
            png = file.read()
        self.assertEqual(png[:8], b"\x89PNG\r\n\x1a\n")
        self.assertEqual(struct.unpack(">II", png[16:24]), (160, 120))
        self.good("scene", "picture", self.sequence, self.sequence, "--frames", "0,4", "--size", "200", "--cut", "y=50%",
                  "--edges", "--no-contacts", "-o", self.path("panels.png"))
        self.bad("scene", "picture", self.sequence, "--frames", "5", "-o", target, says="0:5")
        self.bad("scene", "picture", self.sequence, "--size", "0x7", "-o", target, says="--size")
        self.bad("scene", "picture", self.sequence, "--view", "up", "-o", target, says="view")
        self.bad("scene", "picture", self.sequence, "--objects", "nobody", "-o", target, says="nobody")
        self.bad("scene", "picture", self.sequence, "-o", self.path("no/such/picture.png"), says="picture.png")
        with open(target, "rb") as file:
            self.assertEqual(file.read(), png)

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
        self.assertIn("candidates", self.good("queries", "builtin", "--candidates", "--sample", "20",
                                              "--judge", "exact", "--steps", "0", "--rounds", "0", env=env))
        target, stats = self.path("copy.vtkhdf"), self.path("scene-stats.json")
        self.good("scene", "generate", "openradioss-bullet", "-o", target, "--stats", stats, env=env)
        with open(target, "rb") as copy, open(self.sequence, "rb") as original:
            self.assertEqual(copy.read(), original.read())
        with open(stats, encoding="ascii") as file:
            motions = json.load(file)["steps"]
        self.assertEqual(len(motions), 4)
        counted = sum(sum(motion["contacts"].values()) for motion in motions)
        self.assertEqual(counted, len(self.contacts()) - 1)
        self.bad("scene", "generate", "octopus", "-o", target, says="there are: octopi, bullet, airbag, crash, liver,")
        self.bad("scene", "generate", "crash", "--copies", "2", "-o", target, says="scene crash has no option --copies")
        self.bad("scene", "generate", "builtin", "--quick", "-o", target, says="no quick size")
        self.bad("scene", "generate", "crash", "--elements", "0", "-o", target,
                 says="--elements: '0' is not a positive number")


if __name__ == "__main__":
    unittest.main()
