"""Figures of the add-on in a host: a mesh of a million points into the library and a result of as many points back, and
what an event of the brush tool costs on a surface of 200,000 faces; levels of a million triangles. Milliseconds: the
best of several or, of events, the median and what 95 of 100 stay below, of the processor (all threads together, since
others may be busy) and by the clock. One line each, `name milliseconds goal` with tabs between. `cargo xtask bench
hosts` runs it."""

import statistics
import sys
import time
from pathlib import Path

import bpy
import numpy

sys.path.append(str(Path(__file__).resolve().parent))

import host
import shapes

relievo = host.empty()

import librelievo as rl
from relievo.data import mesh, state, view


def grid(cells, name):
    """A grid of quads as an object, made without lists."""
    points, corners, _ = shapes.grid(cells)
    made = bpy.data.meshes.new(name)
    count = cells * cells
    made.vertices.add(len(points))
    made.loops.add(len(corners))
    made.polygons.add(count)
    made.polygons.foreach_set("loop_start", numpy.arange(0, 4 * count, 4, dtype=numpy.int32))
    if bpy.app.version < (4, 0):
        made.polygons.foreach_set("loop_total", numpy.full(count, 4, numpy.int32))
    made.loops.foreach_set("vertex_index", corners.astype(numpy.int32))
    made.update(calc_edges=True)
    mesh.set_points(made, points)
    target = bpy.data.objects.new(name, made)
    bpy.context.scene.collection.objects.link(target)
    return target


def best(work, times=5):
    took = []
    for _ in range(times):
        start = time.perf_counter()
        work()
        took.append(time.perf_counter() - start)
    return 1000 * min(took)


def report(name, milliseconds, goal=""):
    print(f"{name}\t{milliseconds:.2f}\t{goal}", flush=True)


def million():
    target = grid(999, "million")
    whole = best(lambda: mesh.to_native(target.data, attributes=False).release(), 3)
    made = mesh.to_native(target.data, attributes=False)
    buffer = numpy.empty((len(target.data.vertices), 3), numpy.float32)
    into = best(lambda: made.set_points(mesh.get_points(target.data, buffer)))
    # A result of as many points: 250,000 faces of two by two cells.
    cage = grid(499, "cage")
    with mesh.to_native(cage.data, attributes=False) as low:
        surface = rl.Surface(relievo.core.native.context(), low)
    detail = rl.Detail(surface, tile_size=8)
    follow = rl.Tessellation(detail, coarse=2, fine=2)
    count = follow.info.point_count
    result = bpy.data.meshes.new("result")
    result.vertices.add(count)
    positions = numpy.empty((count, 3), numpy.float32)
    back = best(lambda: mesh.set_points(result, follow.positions(out=positions)))
    report("a million points in and back", into + back, 60)
    report("a million points in", into)
    report(f"{count} points back", back)
    report("a mesh of a million points in, faces too", whole)


def brush():
    """What `RELIEVO_OT_stroke.extend` does with every event."""
    from relievo.tools import brush as tool

    target = grid(447, "brush")
    target.relievo.tile_size, target.relievo.cells = "8", "1"
    scene = bpy.context.scene.relievo.brush
    scene.settings.radius, scene.height = 0.05, 0.02
    made = state.of(target)
    view.ensure(target, made)
    for action in ("SCULPT", "PAINT"):
        brush, _ = tool.brush_of(bpy.context.scene, action)
        took, worked, first = [], [], []
        # Where nothing was, over what is there, and beside it.
        for y in (0.1, 0.1, 0.13):
            start = time.perf_counter()
            caster = made.pick()
            drawn = rl.Stroke(made.detail, brush)
            first.append(1000 * (time.perf_counter() - start))
            for step in range(60):
                x = -0.6 + 0.02 * step
                start, begun = time.perf_counter(), time.process_time()
                hit = caster.cast([[x, y, 1.0]], [[0, 0, -1]])[0]
                drawn.extend([[*hit["position"].astype(float), 1.0, -1.0]])
                made.detail.commit()
                view.refresh(target, made)
                took.append(1000 * (time.perf_counter() - start))
                worked.append(1000 * (time.process_time() - begun))
            drawn.end()
            drawn.release()
        name = f"an event of the brush in Blender, {action.lower()}"
        report(f"{name}, median", statistics.median(worked[5:]), 8)
        report(f"{name}, 95 %", statistics.quantiles(worked[5:], n=20)[-1])
        report(f"{name}, by the clock", statistics.median(took[5:]))
        report("pressing the button before it", statistics.median(first))


def levels():
    """Another level of a million triangles, and what an event of a handle does to a hundredth of its points."""
    from relievo.data import progressive

    target = grid(707, "levels")
    points = mesh.get_points(target.data)
    points[:, 2] = 0.05 * numpy.sin(9 * points[:, 0]) * numpy.cos(11 * points[:, 1])
    mesh.set_points(target.data, points)
    host.select(target)
    start = time.perf_counter()
    bpy.ops.relievo.levels_build()
    report("building levels of a million triangles", 1000 * (time.perf_counter() - start))
    options = target.relievo.progressive
    for ratio in (0.5, 0.1):
        ratios = iter(numpy.linspace(0.99 * ratio, 0.95 * ratio, 5))
        options.ratio = ratio
        report(f"another level near {ratio}", best(lambda: setattr(options, "ratio", next(ratios))))
    for ratio in (1.0, 0.1):
        options.ratio = ratio
        shown, measure = progressive.job.run(progressive.showing(target)), progressive.measure_of(options)
        handle = {"center": [0.3, 0.2, 0.0], "radius": 0.16, "translation": [0.0, 0.0, 0.05]}
        text = progressive.text_of(measure, [handle])
        reached = shown.edit(text)

        def event():
            shown.undo()
            shown.edit(text)
            progressive.write_moved(target, shown)

        report(f"an event of a handle at {ratio}, {reached} points", best(event))
        shown.undo()


million()
brush()
levels()
