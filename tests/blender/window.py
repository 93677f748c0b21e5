"""The panels and the tools in a real window, driven by simulated events: a stroke of the sculpt tool, its undo and redo
by the keyboard, a stroke of paint, a live preview, an imprint that is cancelled by Esc and one that runs to its end, a
region of a level that is grabbed, a pin of a decal that is dragged. What is seen is asked of screenshots. What does not come to an end is ended by who
runs it. Needs a display, `--enable-event-simulate` and a folder for screenshots in RELIEVO_SCREENSHOTS; `cargo xtask
blender --test` runs it as

    xvfb-run --server-args "-screen 0 1040x700x24" blender --factory-startup --enable-event-simulate \\
        --window-geometry 0 0 1040 700 --python tests/blender/window.py
"""

import json
import sys
from pathlib import Path

import bpy
import numpy
from bpy_extras import view3d_utils

sys.path.append(str(Path(__file__).resolve().parent))

import host
from events import (
    area,
    drag,
    event,
    grab,
    only_our_panels,
    open_tab,
    over,
    override,
    part,
    plain,
    press,
    region,
    run,
    screenshot,
    until,
    view,
    wait,
)


def heights():
    return host.positions(bpy.data.objects["field"].relievo.result)[:, 2]


def reds(pixels):
    """How many pixels are of the paint's colour."""
    return int(((pixels[:, :, 0] > 0.35) & (pixels[:, :, 1] < 0.5 * pixels[:, :, 0])).sum())


def play():
    relievo = host.enable()
    for target in list(bpy.data.objects):
        bpy.data.objects.remove(target)
    field = host.field(8)
    field.relievo.cells = "16"
    host.select(field)
    only_our_panels()
    with override():
        bpy.ops.screen.screen_full_area()
    yield from wait()
    space = area().spaces.active
    plain(space)
    space.show_region_ui = True
    space.shading.type, space.shading.color_type = "SOLID", "MATERIAL"
    with override():
        bpy.ops.view3d.view_axis(type="TOP")
        bpy.ops.view3d.view_all()
        bpy.ops.wm.tool_set_by_id(name="relievo.sculpt_tool")
        bpy.ops.ed.undo_push(message="field")
    group = bpy.context.scene.relievo.brush
    group.settings.radius, group.height, group.color = 0.15, 0.05, (0.9, 0.01, 0.01, 1)
    yield from wait(10)
    before = screenshot("start.png")
    yield from open_tab()
    yield from drag((0.4, 0.45), (0.55, 0.55))
    yield from until(lambda: strokes() == 1)
    assert heights().max() > 0.04, heights().max()
    assert len(bpy.data.objects["field"].relievo.strokes) == 1
    raised = heights()
    sculpted = screenshot("sculpt.png")
    side = next(found for found in area().regions if found.type == "UI")
    panel = part(sculpted, side)
    # Our panel has the sidebar: what was there is gone, and rows of text and fields are.
    assert numpy.abs(panel - part(before, side)).max(2).mean() > 0.01
    assert (panel.max((1, 2)) - panel.min((1, 2)) > 0.3).mean() > 0.3, "the panel is empty"
    assert (numpy.abs(view(sculpted) - view(before)).max(2) > 0.02).sum() > 500, "the stroke is not seen"
    for value, wanted in (("undo", None), ("redo", raised)):
        event("Z", "PRESS", ctrl=True, shift=value == "redo")
        yield
        event("Z", "RELEASE", ctrl=True, shift=value == "redo")
        yield from until(lambda: strokes() == (0 if value == "undo" else 1))
        field = bpy.data.objects["field"]
        if wanted is None:
            assert len(field.relievo.strokes) == 0, "the stroke is not undone"
            state = relievo.data.state.of(field)
            assert state.position == 0, state.position
        else:
            assert len(field.relievo.strokes) == 1
            numpy.testing.assert_array_equal(heights(), wanted)
    yield from keys()
    with override():
        bpy.ops.wm.tool_set_by_id(name="relievo.paint_tool")
    yield from wait()
    yield from drag((0.42, 0.58), (0.56, 0.42))
    yield from until(lambda: strokes() == 2)
    field = bpy.data.objects["field"]
    assert relievo.data.state.of(field).detail.info.painted_count > 0
    yield from over(0.1, 0.9)
    painted = screenshot("paint.png")
    assert reds(view(painted)) > reds(view(sculpted)) + 300, (reds(view(painted)), reds(view(sculpted)))
    # A ball that moves, in steps off the main thread.
    ball = host.ball(0.3)
    for frame, x in ((1, -0.6), (6, 0.6)):
        ball.location = (x, -0.6, 0.2)
        ball.keyframe_insert("location", frame=frame)
    bpy.context.scene.frame_start, bpy.context.scene.frame_end = 1, 6
    bpy.context.scene.relievo.imprint.voxels = 2**18
    host.select(field, ball)
    # A preview follows the ball by Blender's own timer.
    edits = relievo.data.state.of(field).document.info.undo_count
    with override():
        bpy.ops.relievo.preview("INVOKE_DEFAULT")
    for height in (0.2, 0.25):
        ball.animation_data_clear()
        ball.location = (0.3, -0.6, height)
        while abs(heights().min() - (height - 0.3)) > 0.02:
            yield
    with override():
        bpy.ops.relievo.preview("INVOKE_DEFAULT")
    assert heights().min() > -0.02, heights().min()
    assert relievo.data.state.of(field).document.info.undo_count == edits
    for frame, x in ((1, -0.6), (6, 0.6)):
        ball.location = (x, -0.6, 0.2)
        ball.keyframe_insert("location", frame=frame)
    host.select(field, ball)
    # Esc takes an imprint that is under way back.
    bpy.context.scene.frame_end = 2000
    with override():
        answer = bpy.ops.relievo.imprint("INVOKE_DEFAULT")
    assert answer == {"RUNNING_MODAL"}, answer
    while heights().min() > -0.05:
        yield
    for value in ("PRESS", "RELEASE"):
        event("ESC", value)
        yield
    while relievo.core.job.is_busy():
        yield
    assert heights().min() > -0.02, heights().min()
    assert relievo.data.state.of(field).document.info.undo_count == edits
    bpy.context.scene.frame_end = 6
    with override():
        answer = bpy.ops.relievo.imprint("INVOKE_DEFAULT")
    assert answer <= {"RUNNING_MODAL", "FINISHED"}, answer
    while relievo.core.job.is_busy():
        yield
    assert heights().min() < -0.08, heights().min()
    ball.hide_set(True)
    yield from wait()
    dented = screenshot("imprint.png")
    assert (numpy.abs(view(dented) - view(painted)).max(2) > 0.02).sum() > 500, "the track is not seen"
    yield from asked(relievo)
    yield from levels(relievo)
    yield from decal()


def keys():
    """The circle of the brush, F and Shift+F, Ctrl, Shift and the right button, by the sculpt tool."""
    field, brush = bpy.data.objects["field"], bpy.context.scene.relievo.brush
    before, revision, radius = heights(), field.relievo.revision, brush.settings.radius
    yield from over(0.1, 0.9)
    away = screenshot("circle_away.png")
    yield from over(0.5, 0.3)
    shown = screenshot("circle.png")
    assert 100 < (numpy.abs(view(shown) - view(away)).max(2) > 0.2).sum() < 5000, "there is no circle on the surface"
    pixel = 20 / region().width
    for shift, name, answer in ((False, "radius", "LEFTMOUSE"), (True, "strength", "RET"), (False, "radius", "RIGHTMOUSE")):
        start = getattr(brush.settings, name)
        yield from press("F", 0.5, 0.3, shift=shift)
        yield from over(0.5 - pixel, 0.3)
        found = getattr(brush.settings, name)
        assert 0.02 < found < start - 0.05, (name, start, found)
        if answer == "LEFTMOUSE":
            # The circle stays, and its border is where the pointer's way says.
            screenshot("circle_small.png")
        yield from press(answer, 0.5 - pixel, 0.3)
        assert getattr(brush.settings, name) == (start if answer == "RIGHTMOUSE" else found), (name, answer)
        if name == "radius":
            brush.settings.radius = radius
        else:
            brush.settings.strength = 1.0
    # A number that is typed.
    yield from press("F", 0.5, 0.3)
    for key, sign in (("PERIOD", "."), ("TWO", "2")):
        event(key, "PRESS", x=0.5, y=0.3, unicode=sign)
        event(key, "RELEASE", x=0.5, y=0.3)
        yield
    yield from press("RET", 0.5, 0.3)
    assert abs(brush.settings.radius - 0.2) < 1e-6, brush.settings.radius
    brush.settings.radius = radius
    # The right button takes a stroke back.
    yield from grab((0.4, 0.3), (0.55, 0.3))
    assert heights().max() > before.max() - 1e-6 and numpy.abs(heights() - before).max() > 0.04
    yield from press("RIGHTMOUSE", 0.55, 0.3)
    event("LEFTMOUSE", "RELEASE", x=0.55, y=0.3)
    yield from wait()
    numpy.testing.assert_array_equal(heights(), before)
    assert field.relievo.revision == revision
    # With Ctrl it sinks, with Shift it smooths what sank.
    for held in ({"ctrl": True}, {"shift": True}):
        lowest, made = (heights() - before).min(), strokes()
        event("MOUSEMOVE", x=0.4, y=0.3)
        yield
        event("LEFTMOUSE", "PRESS", x=0.4, y=0.3, **held)
        yield
        for x in (0.45, 0.5, 0.55):
            event("MOUSEMOVE", x=x, y=0.3, **held)
            yield
        event("LEFTMOUSE", "RELEASE", x=0.55, y=0.3, **held)
        yield from until(lambda: strokes() == made + 1)
        found = (heights() - before).min()
        assert found < -0.04 if "ctrl" in held else lowest < found < 0.9 * lowest, (held, lowest, found)
    screenshot("inverted.png")
    for left in (2, 1):
        event("Z", "PRESS", ctrl=True)
        event("Z", "RELEASE", ctrl=True)
        yield from until(lambda: strokes() == left)
    numpy.testing.assert_array_equal(heights(), before)


def asked(relievo):
    """What removes an imprint asks before it does so, and the keyboard answers; undo brings the imprint back."""
    dented, uid = heights(), bpy.data.objects["field"].relievo.uid
    for operator in (bpy.ops.relievo.clear, bpy.ops.relievo.replay):
        with override():
            bpy.ops.ed.undo_push(message="dented")
        for key in ("ESC", "RET"):
            event("MOUSEMOVE")
            yield from wait()
            host.select(bpy.data.objects["field"])
            with override():
                operator("INVOKE_DEFAULT")
            yield from wait(10)
            numpy.testing.assert_array_equal(heights(), dented)
            yield from press(key, 0.5, 0.5)
            yield from wait(10)
            while relievo.core.job.is_busy():
                yield
        result = bpy.data.objects["field"].relievo.result
        assert result is None or heights().min() > -0.02, operator
        while bpy.data.objects["field"].relievo.result is None or heights().min() > -0.02:
            for value in ("PRESS", "RELEASE"):
                event("Z", value, ctrl=True)
            yield from wait(10)
        numpy.testing.assert_array_equal(heights(), dented)
        assert bpy.data.objects["field"].relievo.uid == uid, "the document is not the one of before"


def purples(pixels):
    """How many pixels are of the ball of what is grabbed."""
    return int(((pixels[:, :, 0] > 1.3 * pixels[:, :, 1]) & (pixels[:, :, 2] > 1.3 * pixels[:, :, 1])).sum())


def strokes():
    return len(bpy.data.objects["field"].relievo.strokes)


def levels(relievo):
    """A level that the pointer grabs by the tool, moves, turns and leaves, with a ball drawn over the view."""
    for target in list(bpy.data.objects):
        bpy.data.objects.remove(target)
    ball = host.ball(1.0, "levels", rings=32)
    host.select(ball)
    area().spaces.active.shading.color_type = "MATERIAL"
    with override():
        bpy.ops.view3d.view_axis(type="FRONT")
        bpy.ops.view3d.view_all()
        bpy.ops.relievo.levels_build()
        bpy.ops.wm.tool_set_by_id(name="relievo.handle_tool")
        bpy.context.scene.relievo.handle.radius = 0.5
        ball.relievo.progressive.ratio = 0.2
        bpy.ops.ed.undo_push(message="levels")
    yield from wait()
    round_ball = host.positions(ball)
    before = screenshot("levels.png")
    # Esc takes back what was tried.
    yield from grab((0.5, 0.5), (0.5, 0.59))
    grabbed = screenshot("levels_grab.png")
    assert purples(view(grabbed)) > purples(view(before)) + 1000, (purples(view(grabbed)), purples(view(before)))
    assert numpy.abs(host.positions(ball) - round_ball).max() > 0.05, "nothing moved"
    yield from press("ESC", 0.5, 0.59)
    event("LEFTMOUSE", "RELEASE", x=0.5, y=0.59)
    yield from wait(2)
    numpy.testing.assert_allclose(host.positions(ball), round_ball, atol=1e-6)
    assert not len(ball.relievo.progressive.edits)
    # The wheel widens the region, R turns it, letting go keeps it.
    yield from grab((0.5, 0.5), (0.5, 0.68))
    for _ in range(3):
        event("WHEELUPMOUSE", "PRESS", x=0.5, y=0.68)
    yield from press("R", 0.5, 0.68)
    for x in (0.55, 0.6):
        event("MOUSEMOVE", x=x, y=0.68)
        yield
    event("LEFTMOUSE", "RELEASE", x=0.6, y=0.68)
    yield from wait(2)
    kept = json.loads(ball.relievo.progressive.edits[0].text)["handles"][0]
    assert abs(kept["radius"] - 0.5 * 1.1**3) < 1e-3, kept
    assert kept["translation"][2] > 0.1 and abs(kept["translation"][1]) < 1e-3, kept
    assert abs(kept["angle"]) > 0.01 and kept["axis"][1] < -0.99, kept
    ball.relievo.progressive.ratio = 1.0
    moved = host.positions(ball)
    assert numpy.abs(numpy.linalg.norm(moved, axis=1) - 1).max() > 0.1, "finer levels do not follow"
    with override():
        bpy.ops.ed.undo_push(message="finest")
    yield from wait(2)
    after = screenshot("levels_fine.png")
    assert purples(view(after)) <= purples(view(before)) + 50, "the ball stays"
    # Undo takes the ratio back, and then the edit.
    for _ in range(2):
        event("Z", "PRESS", ctrl=True)
        event("Z", "RELEASE", ctrl=True)
        yield from wait(2)
    ball = bpy.data.objects["levels"]
    assert not len(ball.relievo.progressive.edits), "the edit is not undone"
    numpy.testing.assert_allclose(numpy.linalg.norm(host.positions(ball), axis=1), 1, atol=1e-2)
    ball.relievo.progressive.ratio = 1.0
    numpy.testing.assert_allclose(numpy.linalg.norm(host.positions(ball), axis=1), 1, atol=1e-5)
    # The button of the panel waits for a press; A holds what is under the pointer until then.
    with override():
        assert bpy.ops.relievo.levels_edit("INVOKE_DEFAULT") == {"RUNNING_MODAL"}
    event("MOUSEMOVE", x=0.45, y=0.5)
    yield
    yield from press("A", 0.45, 0.5)
    yield from grab((0.55, 0.5), (0.55, 0.56))
    event("LEFTMOUSE", "RELEASE", x=0.55, y=0.56)
    yield from wait(2)
    kept = json.loads(ball.relievo.progressive.edits[0].text)
    (held,), (handle,) = kept["anchors"], kept["handles"]
    assert held["center"][0] < handle["center"][0] - 0.1 and held["radius"] == handle["radius"], kept
    yield from carved(ball)


def carved(ball):
    """A level that the pointer sculpts by the tool: Esc takes the stroke back, letting go keeps it as one edit."""
    edits = len(ball.relievo.progressive.edits)
    with override():
        bpy.ops.wm.tool_set_by_id(name="relievo.level_sculpt_tool")
    group = bpy.context.scene.relievo.brush
    group.sculpt_mode, group.height, group.settings.radius = "DRAW", 0.1, 0.2
    before = host.positions(ball)
    yield from grab((0.42, 0.42), (0.58, 0.4))
    assert numpy.abs(host.positions(ball) - before).max() > 0.05, "nothing moved"
    yield from press("ESC", 0.58, 0.4)
    event("LEFTMOUSE", "RELEASE", x=0.58, y=0.4)
    yield from wait(2)
    numpy.testing.assert_allclose(host.positions(ball), before, atol=1e-6)
    assert len(ball.relievo.progressive.edits) == edits
    # The button of the panel waits for a press.
    with override():
        assert bpy.ops.relievo.levels_sculpt("INVOKE_DEFAULT") == {"RUNNING_MODAL"}
    event("MOUSEMOVE", x=0.4, y=0.6)
    yield
    numpy.testing.assert_array_equal(host.positions(ball), before)
    yield from grab((0.42, 0.42), (0.58, 0.4))
    event("LEFTMOUSE", "RELEASE", x=0.58, y=0.4)
    yield from wait(2)
    assert len(ball.relievo.progressive.edits) == edits + 1
    kept = json.loads(ball.relievo.progressive.edits[-1].text)["stroke"]
    assert len(kept["points"]) >= 3, kept
    # Seen from the front the ridge comes nearer.
    moved = host.positions(ball)
    assert (before - moved)[:, 1].max() > 0.05, "there is no ridge"
    screenshot("levels_sculpt.png")
    ball.relievo.progressive.ratio = 0.3
    coarse = host.positions(ball)
    ball.relievo.progressive.ratio = 1.0
    assert len(coarse) < len(moved)
    numpy.testing.assert_allclose(numpy.sort(host.positions(ball), 0), numpy.sort(moved, 0), atol=1e-5)


SIDE = 256


def label():
    """An image of squares with a border, and a red dot at each pin."""
    y, x = numpy.mgrid[0:SIDE, 0:SIDE]
    pixels = numpy.ones((SIDE, SIDE, 4), numpy.float32)
    pixels[..., :3] = numpy.where(((x // 32 + y // 32) % 2 == 0)[..., None], (0.05, 0.42, 0.46), (0.93, 0.87, 0.7))
    pixels[(numpy.minimum(x, y) < 8) | (numpy.maximum(x, y) >= SIDE - 8), :3] = (0.04, 0.12, 0.2)
    for u, v in PINS:
        pixels[numpy.hypot(x - u, y - v) < 13, :3] = (0.8, 0.05, 0.05)
    image = bpy.data.images.new("label", SIDE, SIDE, alpha=True)
    image.pixels.foreach_set(pixels.ravel())
    return image


PINS = ((32, 32), (224, 32), (128, 128), (32, 224), (224, 224))


def on_ball(u, v):
    """The place of a point of the image on a ball that is seen from the front."""
    across, up = 1.5 * (u / SIDE - 0.5), 1.5 * (v / SIDE - 0.5)
    return numpy.sin(across) * numpy.cos(up), -numpy.cos(across) * numpy.cos(up), numpy.sin(up)


def decal():
    """A pin that the pointer drags over a ball: the decal's mesh follows, and undo takes it back."""
    for target in list(bpy.data.objects):
        bpy.data.objects.remove(target)
    ball = host.ball(1.0, "ball", rings=32)
    ball.data.polygons.foreach_set("use_smooth", [True] * len(ball.data.polygons))
    ball.relievo.decal.image = label()
    host.select(ball)
    for u, v in PINS:
        bpy.ops.relievo.decal_pin_add(image=(u, v), position=on_ball(u, v))
    area().spaces.active.shading.color_type = "TEXTURE"
    with override():
        bpy.ops.view3d.view_axis(type="FRONT")
        bpy.ops.view3d.view_all()
        bpy.ops.wm.tool_set_by_id(name="builtin.select")
        assert bpy.ops.relievo.decal_mesh() == {"FINISHED"}
        bpy.ops.ed.undo_push(message="decal")
    yield from wait()
    before = screenshot("decal_start.png")
    laid = host.positions(ball.relievo.decal.mesh)
    with override():
        assert bpy.ops.relievo.decal_pin_drag("INVOKE_DEFAULT") == {"RUNNING_MODAL"}

    def spot(position):
        at = view3d_utils.location_3d_to_region_2d(region(), area().spaces.active.region_3d, position)
        return at[0] / region().width, at[1] / region().height

    aim = on_ball(165, 155)
    yield from grab(spot(on_ball(128, 128)), spot(aim))
    dragged = screenshot("decal_drag.png")
    assert (numpy.abs(view(dragged) - view(before)).max(2) > 0.1).sum() > 2000, "the decal does not follow"
    event("LEFTMOUSE", "RELEASE", x=spot(aim)[0], y=spot(aim)[1])
    yield from wait(10)
    screenshot("decal_end.png")
    shown = ball.relievo.decal.mesh
    found = numpy.array(ball.relievo.decal.pins[2].position)
    assert numpy.linalg.norm(found - aim) < 0.03, found
    point = int(numpy.linalg.norm(host.positions(shown) - found, axis=1).argmin())
    corner = next(loop.index for loop in shown.data.loops if loop.vertex_index == point)
    numpy.testing.assert_allclose(shown.data.uv_layers[0].data[corner].uv, (0.5, 0.5), atol=1e-3)
    for value in ("PRESS", "RELEASE"):
        event("Z", value, ctrl=True)
    yield from wait(10)
    ball = bpy.data.objects["ball"]
    numpy.testing.assert_allclose(ball.relievo.decal.pins[2].position, on_ball(128, 128), atol=1e-5)
    numpy.testing.assert_allclose(host.positions(ball.relievo.decal.mesh), laid, atol=1e-6)
    # The tool draws the pins, drags them, and adds one with Ctrl.
    with override():
        bpy.ops.wm.tool_set_by_id(name="relievo.pin_tool")
    yield from over(0.1, 0.9)
    screenshot("decal_pins.png")
    start, aim = on_ball(224, 224), on_ball(210, 205)
    yield from grab(spot(start), spot(aim))
    event("LEFTMOUSE", "RELEASE", x=spot(aim)[0], y=spot(aim)[1])
    yield from wait(10)
    pins = bpy.data.objects["ball"].relievo.decal.pins
    assert numpy.linalg.norm(numpy.array(pins[4].position) - aim) < 0.03, tuple(pins[4].position)
    # What is painted into a layer is seen in a view that shows materials.
    shading = area().spaces.active.shading
    shading.color_type = "MATERIAL"
    with override():
        assert bpy.ops.relievo.decal_apply() == {"FINISHED"}
    assert shading.color_type == "VERTEX", shading.color_type
    place = spot(on_ball(70, 128))
    for value in ("PRESS", "RELEASE"):
        event("LEFTMOUSE", value, x=place[0], y=place[1], ctrl=True)
    yield from wait()
    assert len(pins) == 6 and numpy.linalg.norm(numpy.array(pins[5].position) - on_ball(70, 128)) < 0.03


run(play(), "window")
