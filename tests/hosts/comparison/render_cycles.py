"""Renders scripts that `relievo scene export blender` wrote by Cycles, under PyPI's bpy or in Blender's own Python:
`render_cycles.py SCRIPT PICTURE [SCRIPT PICTURE]...`. Pictures are EXR files with passes of colour, depth and normal; rays
go through the middles of pixels, and light comes from the sun alone, as in our ray caster."""

import runpy
import sys
from pathlib import Path

import bpy


def render(script, picture, change=None):
    """Renders a script's scene, once `change` has changed it."""
    scene = runpy.run_path(script)["scene"]
    if change is not None:
        change(scene)
    cycles = scene.cycles
    cycles.device = "CPU"
    cycles.samples = 1
    cycles.use_adaptive_sampling = cycles.use_denoising = False
    cycles.seed = 1
    cycles.max_bounces = 0
    # The narrowest filter there is: a sample is within half a hundredth of a pixel from the middle.
    cycles.pixel_filter_type = "BOX"
    cycles.filter_width = 0.01
    scene.render.film_transparent = True
    for thing in scene.objects:
        for modifier in thing.modifiers:
            # Twice as fine as our tiles: with the same chords they would agree however far they are from the surface.
            modifier.render_levels += 1
    for layer in scene.view_layers:
        layer.use_pass_combined = layer.use_pass_z = layer.use_pass_normal = True
    settings = scene.render.image_settings
    if hasattr(settings, "media_type"):
        settings.media_type = "MULTI_LAYER_IMAGE"
    settings.file_format = "OPEN_EXR_MULTILAYER"
    settings.color_depth = "32"
    scene.render.filepath = picture
    bpy.ops.render.render(write_still=True, scene=scene.name)


def arguments():
    return sys.argv[sys.argv.index("--") + 1 :] if "--" in sys.argv else sys.argv[1:]


if __name__ == "__main__":
    bpy.ops.wm.read_factory_settings(use_empty=True)
    for script, picture in zip(arguments()[::2], arguments()[1::2]):
        render(str(Path(script).resolve()), str(Path(picture).resolve()))
