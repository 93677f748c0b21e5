"""Simulated events in the window of Blender, and screenshots of it. What is to be done is a generator, which goes on once per turn of
the main loop (`run`). Needs `--enable-event-simulate` and a folder for screenshots in RELIEVO_SCREENSHOTS."""

import os
import sys
import traceback

import bpy
import numpy

FOLDER = os.environ.get("RELIEVO_SCREENSHOTS", "")


def area():
    return next(found for found in bpy.context.window_manager.windows[0].screen.areas if found.type == "VIEW_3D")


def region():
    return next(found for found in area().regions if found.type == "WINDOW")


def override():
    window = bpy.context.window_manager.windows[0]
    return bpy.context.temp_override(window=window, area=area(), region=region())


def event(kind, value="NOTHING", x=0.5, y=0.5, **keys):
    """An event at a place of the view, 0 to 1."""
    window, place = bpy.context.window_manager.windows[0], region()
    at = (int(place.x + x * place.width), int(place.y + y * place.height))
    window.event_simulate(type=kind, value=value, x=at[0], y=at[1], **keys)


def drag(start, end, steps=5):
    """A drag of the left button, an event per turn of the main loop."""
    event("MOUSEMOVE", x=start[0], y=start[1])
    yield
    event("LEFTMOUSE", "PRESS", x=start[0], y=start[1])
    yield
    for step in range(1, steps + 1):
        share = step / steps
        event("MOUSEMOVE", x=start[0] + share * (end[0] - start[0]), y=start[1] + share * (end[1] - start[1]))
        yield
    event("LEFTMOUSE", "RELEASE", x=end[0], y=end[1])
    yield


def screenshot(name):
    """Writes a screenshot and returns its pixels, the lowest row first."""
    path = os.path.join(FOLDER, name)
    with override():
        bpy.ops.screen.screenshot(filepath=path)
    image = bpy.data.images.load(path)
    width, height = image.size
    pixels = numpy.empty(width * height * image.channels, numpy.float32)
    image.pixels.foreach_get(pixels)
    bpy.data.images.remove(image)
    return pixels.reshape(height, width, -1)[:, :, :3]


def part(pixels, place):
    """The pixels of a region of the window."""
    return pixels[place.y : place.y + place.height, place.x : place.x + place.width]


def view(pixels):
    """The pixels of the view that the sidebar and the toolbar leave."""
    side = next(found for found in area().regions if found.type == "UI")
    place = region()
    right = min(place.x + place.width, side.x)
    return pixels[place.y : place.y + place.height - 80, place.x + 100 : right]


def open_tab():
    """Presses the tab of our panels, the second one of the sidebar where others are gone."""
    side = next(found for found in area().regions if found.type == "UI")
    window = bpy.context.window_manager.windows[0]
    at = {"x": side.x + side.width - 10, "y": side.y + side.height - 75}
    window.event_simulate(type="MOUSEMOVE", value="NOTHING", **at)
    yield
    for value in ("PRESS", "RELEASE"):
        window.event_simulate(type="LEFTMOUSE", value=value, **at)
        yield


def only_our_panels():
    """Takes the tabs of others away, so that the sidebar shows ours."""
    for name in dir(bpy.types):
        kind = getattr(bpy.types, name)
        if getattr(kind, "bl_space_type", "") == "VIEW_3D" and getattr(kind, "bl_region_type", "") == "UI":
            if not name.startswith("RELIEVO") and isinstance(kind, type) and issubclass(kind, bpy.types.Panel):
                try:
                    bpy.utils.unregister_class(kind)
                except RuntimeError:
                    pass


def plain(space):
    """Leaves out what Blender draws besides the objects: without a graphics card every pass over the view takes long."""
    system, overlay = bpy.context.preferences.system, space.overlay
    system.viewport_aa, system.use_overlay_smooth_wire = "OFF", False
    space.shading.show_object_outline = overlay.show_outline_selected = False
    overlay.show_floor = overlay.show_ortho_grid = overlay.show_axis_x = overlay.show_axis_y = False


def over(x, y):
    """Moves the pointer to a place of the view."""
    event("MOUSEMOVE", x=x, y=y)
    yield from wait(2)


def wait(turns=5):
    for _ in range(turns):
        yield


def until(holds, turns=1000):
    """Waits until something holds. Where it never does, what is asserted next fails."""
    for _ in range(turns):
        if holds():
            return
        yield


def grab(start, end):
    """Presses the left button and goes on with it in two events."""
    event("MOUSEMOVE", x=start[0], y=start[1])
    yield
    event("LEFTMOUSE", "PRESS", x=start[0], y=start[1])
    yield
    for share in (0.5, 1.0):
        event("MOUSEMOVE", x=start[0] + share * (end[0] - start[0]), y=start[1] + share * (end[1] - start[1]))
        yield
    yield from wait(2)


def press(key, x, y, **keys):
    for value in ("PRESS", "RELEASE"):
        event(key, value, x=x, y=y, **keys)
    yield


def run(work, name):
    """Does the steps of a generator, one per turn of the main loop, and ends Blender; what fails leaves a screenshot."""
    # The splash screen would take the first press.
    bpy.context.preferences.view.show_splash = False

    def turn():
        try:
            next(work)
        except StopIteration:
            print(f"{name}: passed")
            sys.stdout.flush()
            os._exit(0)
        except BaseException:
            traceback.print_exc()
            screenshot("failed.png")
            os._exit(1)
        return 0.01

    bpy.app.timers.register(turn, first_interval=1.0)
