"""Misuse of every public function, constructor and method is an error of the library: an odd value for one argument at a time."""

import enum
import inspect
import io
import os
import socket
import sys
import tempfile
import types
import unittest
import warnings
from pathlib import Path

import numpy

ROOT = Path(__file__).resolve().parents[2]
sys.path += [str(ROOT / "plugins" / "python"), str(Path(__file__).resolve().parent)]

import librelievo as rl
import shapes
from librelievo.error import shown
from librelievo import abi, bake, client, decal, document, imprint, job, level, ptex, record, repair, stroke


class Odd:
    """What no argument can be."""

    def __repr__(self):
        return "Odd()"


ODD = [None, Odd(), "abc", "\udc80", "a\0b", b"abc", -1, 3.5, float("nan"), 2**70, -(2**70), 10**5000, [1, "x"], [[]], (1, 2, 3)]
ODD += [{}, {"a": 1}, {1: "a"}, {"a": Odd()}, iter(()), lambda *_: 1, numpy.zeros((2, 2)), numpy.zeros(0), numpy.array("abc"), io.BytesIO()]

MODULES = (bake, rl.brush, rl.caster, rl.collider, rl.crowd, decal, rl.diffuse, document, rl.foam, rl.grid, imprint, job, ptex)
MODULES += (repair, rl.shader, stroke, rl.tessellation, level, client)
# Functions with which modules of the package serve one another, after their public callers have checked what they pass.
HELPERS = {"arguments", "call", "depths", "draws_of", "image_of", "impostors_of", "moment_of", "number_of", "opened", "options_of"}
HELPERS |= {"pins_of", "points_of", "ray_arrays", "report_of", "settings_of", "transfer_arguments", "view_of", "text_of", "failure"}
HELPERS |= {"writing_of", "dual_rows_of"}
# Methods that are not walked: they end the object, or take the name of a function of C.
ENDS = {"release", "of"}
# Values that are right in places, and would be simulated or waited for as many seconds, or sought in the network.
RIGHT = {"seconds": (3.5, 2**70), "patience": (3.5, 2**70), "address": ("abc",)}


def variants(function, right, name):
    """Keywords of calls in which one argument is odd and the others are right, and positional arguments."""
    parameters = [one for one in inspect.signature(function).parameters.values() if one.name not in ("self", "cls")]
    base = {}
    for one in parameters:
        if one.kind is one.VAR_KEYWORD:
            base |= right.get(f"{name}.{one.name}", {})
        elif f"{name}.{one.name}" in right:
            base[one.name] = right[f"{name}.{one.name}"]
        elif one.default is one.empty and one.kind in (one.POSITIONAL_OR_KEYWORD, one.KEYWORD_ONLY):
            base[one.name] = right[one.name]
    for one in parameters:
        for odd in ODD:
            if isinstance(odd, (int, float, str)) and odd in RIGHT.get(one.name, ()):
                continue
            if one.kind is one.VAR_POSITIONAL:
                before = [given for given in parameters if given.name in base and given.kind is one.POSITIONAL_OR_KEYWORD]
                rest = {name: value for name, value in base.items() if name not in {given.name for given in before}}
                yield (*(base[given.name] for given in before), odd), rest
            elif one.kind is one.VAR_KEYWORD:
                yield (), {**base, "unknown": odd}
            else:
                yield (), {**base, one.name: odd}


def functions(module):
    for name, found in inspect.getmembers(module, inspect.isfunction):
        if found.__module__ == module.__name__ and not name.startswith("_") and name not in HELPERS:
            yield f"{module.__name__.removeprefix('librelievo.')}.{name}", found


def methods(thing):
    for name, found in inspect.getmembers(type(thing), inspect.isfunction):
        if not name.startswith("_") and name not in ENDS:
            yield f"{type(thing).__name__}.{name}", getattr(thing, name)


def classes():
    for name, found in inspect.getmembers(rl, inspect.isclass):
        if found.__module__.startswith("librelievo.") and not issubclass(found, (BaseException, enum.Enum, tuple, rl.Parameter)):
            yield name, found


def unmade(kind, **fields):
    """An object whose constructor needs a server, a graphics device or a module: the library refuses its empty handle."""
    made = kind.__new__(kind)
    made.handle = kind.kind()
    for name, value in fields.items():
        setattr(made, name, value)
    return made


class Misuse(unittest.TestCase):
    def setUp(self):
        folder, before = tempfile.TemporaryDirectory(), os.getcwd()
        self.addCleanup(folder.cleanup)
        self.addCleanup(os.chdir, before)
        # Texts that are odd values are paths in places.
        os.chdir(folder.name)
        self.faults = set()
        caught = warnings.catch_warnings()
        caught.__enter__()
        self.addCleanup(caught.__exit__, None, None, None)
        warnings.simplefilter("ignore")

    def tearDown(self):
        self.assertFalse(self.faults, "\n" + "\n".join(sorted(self.faults)))

    def misuse(self, name, function, /, *arguments, **keywords):
        try:
            made = function(*arguments, **keywords)
            if isinstance(made, types.GeneratorType):
                list(made)
        except rl.RelievoError as refused:
            if not str(refused):
                self.faults.add(f"{name}: an error without a sentence")
        except BaseException as fault:
            odd = [(key, shown(value)) for key, value in keywords.items() if any(value is one for one in ODD)]
            self.faults.add(f"{name}: {type(fault).__name__}: {fault} {shown(arguments)} {odd}")

    def walk(self, name, function, right):
        for arguments, keywords in variants(function, right, name):
            self.misuse(name, function, *arguments, **keywords)

    def things(self):
        """Objects of all kinds, and right values of arguments by their names."""
        context = rl.Context(threads=1)
        points, corners, uv = shapes.grid(2)
        mesh = rl.Mesh(context, points, corners, 4)
        mesh.add_attribute("uv", uv, "corner", indices=corners)
        surface = rl.Surface(context, mesh)
        detail = rl.Detail(surface, tile_size=8)
        detail.add_paint()
        detail.commit()
        far = rl.Detail(surface, numpy.eye(4) + numpy.eye(4, k=3) * 9, tile_size=8)
        brush, collider = rl.Brush(context), rl.Collider(context, mesh)
        box, box_corners = shapes.cube()
        cube = rl.Mesh(context, box, box_corners, 4)
        cube.write("cube.obj")
        whole = rl.Progressive(cube, base_triangles=4)
        fluid = rl.Fluid(context, spacing=0.5)
        fluid.add([(0, 0, 0)])
        particles = rl.Particles(context, [(0, 0, 0)], {"velocity": [(0, 0, 1)]}, numbers=[3], spacing=0.5)
        isosurface = particles.isosurface()
        tissue = rl.Tissue.block(context, (0, 0, 0), 0.5, (1, 1, 1), young=8000, poisson=0.45)
        tissue.bind("skin", cube)
        simulation = tissue.simulate()
        model = rl.CrowdModel.build(context, "cube.obj")
        crowd = rl.Crowd(context, [model])
        crowd.add(numpy.eye(4)[None])
        model.write("kept.rcrowd")
        stream = rl.CrowdStream(context, ["kept.rcrowd"])
        pins = [((1, 1), (-0.5, -0.5, 0)), ((9, 1), (0.5, -0.5, 0)), ((5, 9), (0, 0.5, 0))]
        kept = rl.Document(detail, "kept.relievo")
        shader = rl.Shader("uniform float a;\nvoid main() {\n//. vector a; 1.0\n}\n")
        examples = rl.ShaderExamples([(0, 1)], [1])
        ended = job.tessellate(detail)
        ended.wait()
        reader = client.Client.__new__(client.Client)
        reader.address, reader.encryption, reader.link, reader.count = (socket.AF_UNIX, "none"), None, None, 0
        reader.token, reader.patience, reader.timeout = "", 0.0, 1.0
        laid = rl.Decal.on_detail(detail, pins, (10, 10), cells=2)
        picture = numpy.ones((10, 10, 4), numpy.float32)
        grid, empty = unmade(rl.Grid), unmade(rl.Connection)
        try:
            grid = rl.Grid(context)
            grid.set_block((0, 0, 0), numpy.ones((2, 2, 2)))
        except rl.NotFound:
            pass
        level_of = rl.Level(whole)
        level_of.update()
        objects = [context, mesh, cube, surface, detail, detail.layers, brush, collider, whole, level_of, fluid, particles]
        objects += [isosurface, tissue, simulation, model, crowd, stream, laid, kept, shader, examples, ended, reader, grid, empty]
        objects += [rl.Arrival(context), rl.Bezier(context, numpy.random.default_rng(1).random((16, 3))), rl.Caster(context, mesh)]
        objects += [rl.Diffuse(context, 0.5), rl.Foam(context, (4, 4), (0, 0, 5), (0, 0, 0), (0, 1, 0)), rl.Picture(context, "kept.relievo")]
        objects += [rl.Procedural(detail), rl.Stroke(detail, brush), rl.Subdivision(context, mesh), rl.Tessellation(detail)]
        objects += [unmade(kind) for kind in (rl.Buffer, rl.ColorBuffer, rl.DeviceLevel, rl.DeviceCrowd)]
        right = {
            "context": context, "mesh": mesh, "cage": mesh, "surface": surface, "detail": detail, "first": detail, "second": far,
            "brush": brush, "collider": collider, "whole": whole, "more": whole, "fluid": fluid, "particles": particles,
            "model": model, "tissue": tissue, "progressive": whole,
            "isosurface": isosurface, "simulation": simulation, "models": [model], "crowd": crowd, "document": kept, "grid": grid,
            "tessellation": rl.Tessellation(detail), "begin": rl.Procedural(detail), "end": detail, "connection": empty, "other": grid, "to": mesh,
            "points": points, "corners": corners.reshape(-1, 4), "face_sizes": 4, "path": "none.obj", "to_path": "none.relievo", "data": b"abc",
            "state": b"abc", "format": "obj", "name": "abc", "values": [1.0], "domain": "point", "index": 0, "tile": 0, "face": 0, "paths": ["kept.rcrowd"],
            "channel": "displacement", "tiles": [0], "uvs": [[0.5, 0.5]], "wanted": ["positions"], "matrix_world": numpy.eye(4),
            "budget": 1 << 30, "page": 0, "time": 0.0, "pairs": [[0, 8]], "origins": [[0, 0, 1]], "directions": [[0, 0, -1]],
            "place": [0, 0, 0], "normal": [0, 0, 1], "force": 1.0, "mask": 3, "curve": "size", "pixels": picture, "number": 0, "layer": "label",
            "image": picture, "texture": picture, "height": 0.1, "size": (10, 10), "pins": pins, "pin": 0, "position": (0, 0, 0),
            "before": numpy.eye(4), "after": numpy.eye(4), "semaphore": 1, "log": None, "monitor": None, "done": None, "error": 0.1,
            "bound": 0.1, "grips": [], "tracks": [], "patch": 0, "patches": [0], "transforms": numpy.eye(4)[None], "agent": 0,
            "weights": None, "eye": (0, 1, 5), "target": (0, 0, 0), "spacing": 0.5, "positions": [(0, 0, 0)], "seconds": 0.001,
            "velocities": [(0, 0, 0)], "background": picture[:4, :4], "low": (0, 0, 0), "high": (1, 1, 1), "forces": [], "file": None,
            "numbers": [3], "accelerations": [(0, 0, 1)], "classes": [1], "vectors": [(0, 1)], "source": "void main() {}", 
            "cell": 0.5, "materials": [{"name": "gel", "young": 8000.0}], "volumes": [{"name": "gel", "mesh": cube}], "counts": (1, 1, 1),
            "labels": [{"material": 0, "low": 1, "high": 2}], "nodes": [0], "muscle": 0, "keys": [(0.0, 0.0)], "out": None,
            "scene": "dam", "description": "frames = 1", "frame": 0, "changes": "", "action": "pause", "method": "hello", "files": {},
            "primitives": [0], "longest_edge": 1.0, "level_sets": [grid], "meaning": "fog", "matrix": numpy.eye(4)[:, :3],
            "voxels": [(0, 0, 0), (1, 1, 1)], "taper": 0.5, "depth": 1.0, "value": "x", "change": "mean", "kind": "float", "label": 1,
            "grids": [grid], "function": None, "level": 1, "allocate": 16, "free": 16, "attribute": "uv", "text": "", "authority": "none.pem", "blend": "linear",
        }  # fmt: skip
        return objects, right

    def test_functions_and_constructors(self):
        _, right = self.things()
        pose = (None, right["points"])
        right |= {
            "Connection.address": "unix:none", "Connection.patience": 0.0, "Client.address": "unix:none", "Client.patience": 0.0,
            "imprint.sweep_points.before": pose, "imprint.sweep_points.after": pose, "job.sweep_points.before": pose,
            "job.sweep_points.after": pose, "decal.strip_on_mesh.curve": right["points"], "decal.strip_on_detail.curve": right["points"],
            "crowd.agents_of.models": 0, "Bezier.points": numpy.zeros((16, 3)), "grid.labels.numbers": [1], "ptex.write.path": "none.ptx",
            "client.address_of.text": "unix:none", "bake.run.options": {"width": 8, "height": 8, "gutter": 0},
            "bake.write.options": {"width": 8, "height": 8, "gutter": 0}, "bake.write.path": "a.png",
            "job.write.options": {"width": 8, "height": 8, "gutter": 0}, "job.write.path": "b.png",
        }  # fmt: skip
        for module in MODULES:
            for name, function in functions(module):
                self.walk(name, function, right)
        for name, function in inspect.getmembers(rl, inspect.isfunction):
            self.walk(name, function, right)
        for name, kind in [*classes(), ("Client", client.Client)]:
            self.walk(name, kind, right)
            for place, found in inspect.getmembers(kind, inspect.ismethod):
                if not place.startswith("_") and place not in ENDS:
                    self.walk(f"{name}.{place}", found, right)

    def test_methods(self):
        objects, right = self.things()
        right |= {
            "Picture.image.image": 0, "Picture.read.image": 0, "Brush.set_curve.points": [(0, 0), (1, 1)], "Subdivision.evaluate.wanted": ["values"], "Stroke.points": [(0, 0, 0)], "Crowd.cut.size": (8, 8),
            "Crowd.set.first": 0, "CrowdStream.set.first": 0, "CrowdStream.cut.size": (8, 8), "CrowdStream.set_weights.weights": None,
            "CrowdStream.model.model": 0, "CrowdStream.triangles.slot": 0, "CrowdStream.triangles.count": 400, "Fluid.move_collider.collider": 0, "Fluid.move_collider.to": [(0, 0, 0)], "Shader.unpack.log": [1, 1],
            "DeviceCrowd.cut.size": (8, 8), "Decal.move_image.image": (1, 1), "Layers.place.place": 0, "Fluid.add.points": [(0, 0, 0)],
            "TissueSimulation.relax.steps": 1, "TissueSimulation.drive.keys": [(0.0, (0, 0, 0))], "TissueSimulation.bound_points.out": None,
            "Grid.set_block.values": numpy.ones((1, 1, 1)), "Particles.keep.classes": [1], "Crowd.set_weights.weights": None,
            "Grid.sample.points": [(0, 0, 0)], "Fluid.set_channel.values": [1.0], "TissueSimulation.add_collider.keys": (),
        }  # fmt: skip
        for thing in objects:
            for name, method in methods(thing):
                self.walk(name, method, right)

    def test_fields_of_options(self):
        """Every field of every struct that keywords fill."""
        for struct in vars(abi).values():
            if isinstance(struct, type) and issubclass(struct, abi.Structure) and struct is not abi.Structure:
                for field, _ in struct._fields_:
                    for odd in ODD:
                        self.misuse(f"{struct.__name__}.{field}", record.fill, struct, {field: odd})

    def test_what_lists_have(self):
        objects, right = self.things()
        kinds = {type(thing).__name__: thing for thing in objects}
        of_level, simulation, mesh = kinds["Level"], kinds["TissueSimulation"], right["mesh"]
        region = rl.Region((0, 0, 0), 1.0)
        for odd in ODD:
            grips = [odd, rl.Grip(odd), rl.Grip(rl.Region(odd, 1.0)), rl.Grip(rl.Region((0, 0, 0), odd)), rl.Grip(region, odd)]
            grips += [rl.Grip(rl.Region((0, 0, 0), 1.0, odd)), rl.Grip(region, axis=odd), rl.Grip(region, angle=odd)]
            for grip in grips:
                self.misuse("Level.edit", of_level.edit, [grip])
            for key in (odd, rl.GripKey(odd), rl.GripKey(0.0, odd), rl.GripKey(0.0, axis=odd), rl.GripKey(0.0, angle=odd)):
                self.misuse("Level.add_motion", of_level.add_motion, [rl.GripTrack(region, [key])])
            self.misuse("Level.add_motion", of_level.add_motion, [rl.GripTrack(region, odd)], [odd])
            self.misuse("Level.edit", of_level.edit, [], [odd])
            for pin in (odd, (odd, (0, 0, 0)), ((1, 1), odd), ((1, 1), (0, 0, 0), odd)):
                self.misuse("Decal.on_mesh", rl.Decal.on_mesh, mesh, [pin], (10, 10))
            for size in ((odd, 10), (10, odd)):
                self.misuse("Decal.on_mesh", rl.Decal.on_mesh, mesh, right["pins"], size)
            for material in (odd, {"name": odd}, {"name": "a", "young": odd}):
                self.misuse("Tissue", rl.Tissue, right["context"], 0.5, [material], right["volumes"])
            for volume in (odd, {"name": odd}, {"material": odd}, {"name": "a", "mesh": odd}, {"name": "a", "rings": odd}):
                self.misuse("Tissue", rl.Tissue, right["context"], 0.5, right["materials"], [volume])
            for field in ("surfaces", "layers", "skin", "epidermis", "bend"):
                self.misuse(f"Tissue.{field}", rl.Tissue, right["context"], 0.5, right["materials"], right["volumes"], **{field: odd})
                self.misuse(f"Tissue.{field}", rl.Tissue, right["context"], 0.5, right["materials"], right["volumes"], **{field: [odd]})
            self.misuse("Tissue.epidermis", rl.Tissue, right["context"], 0.5, right["materials"], right["volumes"], epidermis={"material": odd})
            for keys in ([odd], [(odd, 0.0)], [(0.0, odd)], [(0.0, (0, 0, 0), odd)]):
                for method in (simulation.activate, simulation.press):
                    self.misuse("TissueSimulation.keys", method, 0, keys)
                self.misuse("TissueSimulation.drive", simulation.drive, [0], keys)
                self.misuse("TissueSimulation.add_collider", simulation.add_collider, keys=keys)
            for attribute in (odd, (odd, [1.0], "point"), ("a", odd, "point"), ("a", [1.0], odd), ("a", [1.0], "point", odd)):
                self.misuse("repair.arrays", repair.arrays, right["context"], right["points"], right["corners"], 4, [attribute])
            for pair in (odd, (odd, [1.0]), ([[0, 1]], odd)):
                self.misuse("Mesh.creases", rl.Mesh, right["context"], right["points"], right["corners"], 4, pair)
            for given in ([odd], {"a": odd}, {odd: "a"} if isinstance(odd, (str, int, float, bytes)) else {}):
                self.misuse("Connection.submit", kinds["Connection"].submit, "a", "b", given)
                self.misuse("Client.submit", kinds["Client"].submit, "a", "b", given)
                self.misuse("Mesh.simplify", mesh.simplify, 1, weights=given, left_out=given)
                self.misuse("Fluid.add", kinds["Fluid"].add, [(0, 0, 0)], channels=given)
                self.misuse("Fluid.add_emitter", kinds["Fluid"].add_emitter, channels=given)
                self.misuse("Fluid.set_forces", kinds["Fluid"].set_forces, given)
                self.misuse("Crowd", rl.Crowd, right["context"], given)
                self.misuse("grid.write", rl.grid.write, "a.vdb", given)
                self.misuse("CrowdModel.build", rl.CrowdModel.build, right["context"], "cube.obj", given)


if __name__ == "__main__":
    unittest.main()
