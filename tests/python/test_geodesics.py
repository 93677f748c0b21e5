"""Geodesics of strips beside those of potpourri3d, which flips edges (Sharp and Crane 2020)."""

import json
import os
import subprocess
import tempfile
import unittest
from pathlib import Path

import numpy
import potpourri3d

import shapes

COMMAND = os.environ["RELIEVO_COMMAND"]


class Geodesics(unittest.TestCase):
    def test_lengths_are_those_of_another_program(self):
        points, corners, _ = shapes.grid(24)
        x, y = points[:, 0].copy(), points[:, 1].copy()
        points[:, 2] = 0.25 * numpy.sin(4.0 * x + 1.0) * numpy.cos(3.0 * y)
        quads = corners.reshape(-1, 4)
        triangles = numpy.concatenate([quads[:, [0, 1, 2]], quads[:, [0, 2, 3]]])
        peer = potpourri3d.EdgeFlipGeodesicSolver(points.astype(float), triangles.astype(int))
        with tempfile.TemporaryDirectory() as folder:
            path = Path(folder, "bumps.obj")
            lines = [f"v {a!r} {b!r} {c!r}" for a, b, c in points.tolist()]
            lines += [f"f {a + 1} {b + 1} {c + 1}" for a, b, c in triangles.tolist()]
            path.write_text("\n".join(lines) + "\n")
            for start, end in ((78, 390), (155, 512), (260, 283), (84, 540)):
                way = peer.find_geodesic_path(start, end)
                expected = numpy.linalg.norm(numpy.diff(way, axis=0), axis=1).sum()
                curve = " ".join(",".join(map(repr, points[point].tolist())) for point in (start, end))
                call = [COMMAND, "decal", "info", str(path), "--size", "400x4", "--along", curve, "--json"]
                done = subprocess.run(call, capture_output=True, text=True)
                self.assertEqual(done.returncode, 0, done.stderr)
                self.assertAlmostEqual(json.loads(done.stdout)["length"] / expected, 1.0, 4)


if __name__ == "__main__":
    unittest.main()
