"""Tears a model, as a bad scan is torn: `python tear.py MODEL.obj TORN.obj` drops the faces in eight balls, turns every seventh
face over and gives each face points of its own. `relievo mesh repair` makes a closed model of the result again."""

import random
import sys


def read(path):
    """Returns the points and the faces of an OBJ file."""
    points, faces = [], []
    with open(path) as file:
        for words in map(str.split, file):
            if words and words[0] == "v":
                points.append([float(word) for word in words[1:4]])
            elif words and words[0] == "f":
                faces.append([int(word.split("/")[0]) - 1 for word in words[1:]])
    return points, faces


def tear(points, faces, seed=7):
    """Returns the faces that are left, each as a list of points."""
    chance = random.Random(seed)
    shapes = [[points[corner] for corner in face] for face in faces]
    middles = [[sum(axis) / len(shape) for axis in zip(*shape)] for shape in shapes]
    low, high = ([end(axis) for axis in zip(*points)] for end in (min, max))
    size = max(b - a for a, b in zip(low, high))
    holes = [(chance.choice(middles), share * size) for share in (0.12, 0.09, 0.08, 0.06, 0.065, 0.055, 0.07, 0.05)]
    torn = []
    for shape, middle in zip(shapes, middles):
        if all(sum((a - b) ** 2 for a, b in zip(middle, centre)) > radius * radius for centre, radius in holes):
            torn.append(shape[::-1] if chance.random() < 1 / 7 else shape)
    return torn


def main():
    source, out = sys.argv[1:]
    torn = tear(*read(source))
    with open(out, "w") as file:
        for shape in torn:
            file.writelines("v {} {} {}\n".format(*point) for point in shape)
        first = 1
        for shape in torn:
            file.write("f " + " ".join(str(first + corner) for corner in range(len(shape))) + "\n")
            first += len(shape)


if __name__ == "__main__":
    main()
