"""Builds a crowd of a model and draws a thousand of them from far and near: python crowd.py MODEL FOLDER

MODEL is glTF, GLB, USD, OBJ, PLY, STL or OFF. Needs the package librelievo and NumPy, and prints how many triangles a
camera needs that goes through the crowd. A mesh for the distance is written as MODEL_far.ply."""

import sys
from pathlib import Path

import numpy

import librelievo

path, folder = Path(sys.argv[1]), Path(sys.argv[2])
context = librelievo.Context()
model = librelievo.CrowdModel.build(context, path)
info = model.info
model.write(folder / f"{path.stem}.rcrowd")
print(f"{info.input_triangles} triangles, {info.pose_count} poses, {info.cluster_count} clusters")

size = numpy.linalg.norm(numpy.subtract(info.high, info.low))
model.mesh(error=0.02 * size).write(folder / f"{path.stem}_far.ply")

generator = numpy.random.default_rng(1)
transforms = numpy.tile(numpy.eye(4), (1000, 1, 1))
transforms[:, 0, 3], transforms[:, 2, 3] = generator.uniform(-25 * size, 25 * size, (2, 1000))
crowd = librelievo.Crowd(context, [model])
crowd.add(transforms, clips=numpy.arange(1000) % info.clip_count, phases=generator.uniform(0, 1, 1000))
for frame in range(5):
    eye = (0, 2 * size, (40 - 10 * frame) * size)
    drawn = crowd.cut((1280, 720), eye, target=(0, 0, -30 * size), time=frame / 24)
    draws, clusters, instances, matrices = crowd.draws()
    full = info.input_triangles * drawn.agent_count
    print(f"{drawn.agent_count} of 1000 agents in {len(draws)} draws: {drawn.triangles} of {full} triangles")
