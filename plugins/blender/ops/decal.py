# SPDX-License-Identifier: GPL-3.0-or-later
"""Decals: an image whose points lie exactly on places of the active object. The object keeps image and pins; the decal
is painted or embossed into a layer of the object's detail, or made a mesh of its own that follows while a pin is dragged."""

import bpy
import librelievo as rl
import numpy
from bpy_extras import view3d_utils
from mathutils import Vector

from ..core import job, lengths, native
from ..core.error import Refused, said
from ..data import mesh, pose, state, stroke, view

# Pixels of the screen within which a pin is taken hold of.
NEAR = 30.0


def owner_of(active):
    """Returns the object that a decal's mesh or a detail's result belongs to, or the object itself."""
    if active is not None and state.is_used(active.relievo.decal.owner):
        return active.relievo.decal.owner
    return state.source_of(active)


def pixels_of(image):
    """Returns an image (height, width, channels) from the top row on, with linear colours."""
    pixels = stroke.pixels_of(image)
    if image.is_float or image.colorspace_settings.name != "sRGB":
        return pixels
    pixels = pixels.copy()
    colors = pixels[..., :3]
    low = colors / 12.92
    colors[...] = numpy.where(colors <= 0.04045, low, ((colors + 0.055) / 1.055) ** 2.4)
    return pixels


def given(target):
    """Returns the pins, the size of the image and the options of an object's decal, as the library takes them."""
    options = target.relievo.decal
    if options.image is None or not options.image.size[0]:
        raise Refused("Choose the image of the decal")
    if not len(options.pins):
        raise Refused("Add a pin: a point of the image and the place of the object that it belongs to")
    pins = [(tuple(pin.image), tuple(pin.position), pin.depth) for pin in options.pins]
    made = {"can_overlap": int(options.overlap)}
    if len(pins) == 1:
        made.update(pose_width=options.width, pose_up=tuple(options.up))
    return pins, tuple(options.image.size), made


def ground_of(target):
    """Returns what is shown of an object as arrays for the library."""
    shown = target.relievo.result if state.is_used(target.relievo.result) else target
    evaluated = shown.evaluated_get(bpy.context.evaluated_depsgraph_get())
    source = mesh.Source(evaluated.to_mesh(), attributes=False)
    evaluated.to_mesh_clear()
    if not len(source.sizes):
        raise Refused(f"{target.name} has no faces")
    return source


def lay(ground, pins, size, options, progress=None):
    """Lays the image on the arrays of a mesh."""
    with ground.build() as cage:
        return rl.Decal.on_mesh(cage, pins, size, progress=progress, **options)


def told(quality):
    """Returns the quality of a decal in words."""
    return f"{100 * quality.coverage:.1f} % covered, L2 stretch {quality.l2:.3f}"


def arrays_of(made, offset):
    """Returns the points, triangles and texture coordinates of the points of a decal."""
    with made.mesh(offset) as laid:
        return laid.points(), laid.triangles().reshape(-1).astype(numpy.int32), laid.attribute("uv").values


def show(target, points, corners, uvs):
    """Writes a decal into its mesh object, which is made where there is none."""
    options = target.relievo.decal
    shown = options.mesh
    if not state.is_used(shown):
        shown = bpy.data.objects.new(f"{target.name} decal", bpy.data.meshes.new(f"{target.name} decal"))
        shown.parent = target
        shown.relievo.decal.owner = target
        for collection in target.users_collection or [bpy.context.scene.collection]:
            collection.objects.link(shown)
        options.mesh = shown
    if shown.data.users > 1:
        # Linked duplicates share their mesh; what is written here is this object's own.
        shown.data = shown.data.copy()
    data = shown.data
    if not len(data.materials):
        data.materials.append(material_of(options.image))
    if len(data.vertices) == len(points) and numpy.array_equal(mesh.get_corners(data), corners):
        mesh.set_uvs(data, data.uv_layers[0], numpy.ascontiguousarray(uvs[corners]))
    else:
        data.clear_geometry()
        mesh.Filling(corners, len(points), numpy.ascontiguousarray(uvs[corners])).fill(data)
    mesh.set_points(data, points)
    return shown


def material_of(image):
    """Makes a material that shows an image with its alpha."""
    made = bpy.data.materials.new(f"{image.name} decal")
    if made.node_tree is None:
        made.use_nodes = True
    nodes, links = made.node_tree.nodes, made.node_tree.links
    surface = next(node for node in nodes if node.type == "BSDF_PRINCIPLED")
    texture = nodes.new("ShaderNodeTexImage")
    # The part of the mesh beyond the image shows nothing.
    texture.image, texture.extension = image, "CLIP"
    links.new(texture.outputs["Color"], surface.inputs["Base Color"])
    links.new(texture.outputs["Alpha"], surface.inputs["Alpha"])
    if bpy.app.version < (4, 2):
        made.blend_method = "CLIP"
    return made


def before_click(context, event):
    """What an operator that waits for a click answers to another event; None if the event is the click."""
    if event.type in {"ESC", "RIGHTMOUSE"} and event.value == "PRESS":
        context.workspace.status_text_set(None)
        return {"CANCELLED"}
    if event.type != "LEFTMOUSE" or event.value != "PRESS":
        return {"PASS_THROUGH"}
    return None


class OnDecal:
    """An operator on the decal of the active object."""

    bl_options = {"REGISTER", "UNDO"}
    failures = (Refused, rl.RelievoError, OSError)

    @classmethod
    def poll(cls, context):
        target = owner_of(context.active_object)
        return target is not None and target.type == "MESH" and target.mode == "OBJECT"


class RELIEVO_OT_decal_mesh(OnDecal, job.Steps, bpy.types.Operator):
    """Lay the image on what is shown of the active object, as a mesh with texture coordinates, or bring that up to date"""

    bl_idname = "relievo.decal_mesh"
    bl_label = "Decal mesh"

    def steps(self, context):
        target = owner_of(context.active_object)
        native.context()
        (pins, size, options), ground = given(target), ground_of(target)
        offset, found = target.relievo.decal.offset, []

        def work(progress):
            with lay(ground, pins, size, options, progress) as made:
                found.extend([*arrays_of(made, offset), made.quality])

        yield 0.0, 1.0, work
        *arrays, quality = found
        show(target, *arrays)
        self.report({"INFO"}, told(quality))


class RELIEVO_OT_decal_apply(OnDecal, job.Steps, bpy.types.Operator):
    """Paint the image into the active layer of colour of the active object, or raise its active layer of displacement"""

    bl_idname = "relievo.decal_apply"
    bl_label = "Apply to layer"

    def steps(self, context):
        target = owner_of(context.active_object)
        options = target.relievo.decal
        pins, size, laid = given(target)
        pixels = pixels_of(options.image)
        is_relief, amount = options.kind == "RELIEF", options.height if options.kind == "RELIEF" else options.opacity
        made = yield from state.opening(target)
        self.warn(made.take_notes())
        if not is_relief:
            view.reveal_paint(context)
        yield from state.placing(made, target, context.evaluated_depsgraph_get())
        found = []

        def work(progress):
            with rl.Decal.on_detail(made.detail, pins, size, progress=progress, **laid) as decal, made.edit("decal"):
                report = decal.emboss(pixels, amount) if is_relief else decal.paint(pixels, amount)
                found.extend([report, decal.quality])

        yield 0.1, 0.8, work
        made.record(target)
        yield from view.ensuring(target, made)
        report, quality = found
        if report.refused_tiles:
            self.warn([f"The memory limit refused {report.refused_tiles} tiles: the decal is missing there"])
        self.report({"INFO"}, f"{report.texels:,} texels; {told(quality)}")


class RELIEVO_OT_decal_pin_add(OnDecal, bpy.types.Operator):
    """Add a pin: click the place of the object that a point of the image belongs to"""

    bl_idname = "relievo.decal_pin_add"
    bl_label = "Add pin"

    image: bpy.props.FloatVectorProperty(name="Image", description="Pixels from the lower left corner", size=2)
    position: bpy.props.FloatVectorProperty(name="Position", description="In the space of the object", size=3)

    def execute(self, context):
        options = owner_of(context.active_object).relievo.decal
        lengths.follow_decal(owner_of(context.active_object))
        pin = options.pins.add()
        pin.image, pin.position = self.image, self.position
        options.active = len(options.pins) - 1
        return {"FINISHED"}

    def invoke(self, context, event):
        options = owner_of(context.active_object).relievo.decal
        if options.image is None:
            self.report({"ERROR"}, "Choose the image of the decal")
            return {"CANCELLED"}
        self.image = [0.5 * side for side in options.image.size]
        if is_press(context, event):
            # The tool's press is the click.
            hit = meet(context, event, owner_of(context.active_object))
            if hit is None:
                return {"CANCELLED"}
            self.position = hit
            return self.execute(context)
        context.workspace.status_text_set("Click a place of the object; Esc cancels")
        context.window_manager.modal_handler_add(self)
        return {"RUNNING_MODAL"}

    def modal(self, context, event):
        answer = before_click(context, event)
        if answer is not None:
            return answer
        hit = meet(context, event, owner_of(context.active_object))
        if hit is None:
            return {"RUNNING_MODAL"}
        context.workspace.status_text_set(None)
        self.position = hit
        return self.execute(context)


class RELIEVO_OT_decal_pin_remove(OnDecal, bpy.types.Operator):
    """Remove the active pin"""

    bl_idname = "relievo.decal_pin_remove"
    bl_label = "Remove pin"

    def execute(self, context):
        options = owner_of(context.active_object).relievo.decal
        if not 0 <= options.active < len(options.pins):
            return {"CANCELLED"}
        options.pins.remove(options.active)
        options.active = max(0, min(options.active, len(options.pins) - 1))
        return {"FINISHED"}


class RELIEVO_OT_decal_pin_image(bpy.types.Operator):
    """Click the point of the image that the active pin holds, in the image editor"""

    bl_idname = "relievo.decal_pin_image"
    bl_label = "Place in image"
    bl_options = {"REGISTER", "UNDO"}

    @classmethod
    def poll(cls, context):
        target = owner_of(context.active_object)
        return target is not None and 0 <= target.relievo.decal.active < len(target.relievo.decal.pins)

    def invoke(self, context, _event):
        context.workspace.status_text_set("Click a point of the image; Esc cancels")
        context.window_manager.modal_handler_add(self)
        return {"RUNNING_MODAL"}

    def modal(self, context, event):
        answer = before_click(context, event)
        if answer is not None:
            return answer
        options = owner_of(context.active_object).relievo.decal
        region = next(region for region in context.area.regions if region.type == "WINDOW")
        at = region.view2d.region_to_view(event.mouse_x - region.x, event.mouse_y - region.y)
        if not all(0 <= share <= 1 for share in at):
            return {"RUNNING_MODAL"}
        context.workspace.status_text_set(None)
        options.pins[options.active].image = [share * side for share, side in zip(at, options.image.size)]
        return {"FINISHED"}


class Drag:
    """A decal that follows a pin: its mesh object is written at every step."""

    def __init__(self, target, pin):
        self.target, self.pin = target, pin
        self.offset = target.relievo.decal.offset
        pins, size, options = given(target)
        if not 0 <= pin < len(pins):
            raise Refused(f"There is no pin {pin}")
        native.context()
        self.position = pins[pin][1]
        self.made = lay(ground_of(target), pins, size, options)
        self.show()

    def show(self):
        show(self.target, *arrays_of(self.made, self.offset))

    def move(self, position):
        """Moves the pin as far as the decal can follow without folds."""
        self.made.drag_pin(self.pin, position)
        self.position = position
        self.show()

    def release(self):
        """Settles the decal and keeps where the pin is now. Returns the quality."""
        self.made.settle()
        self.show()
        self.target.relievo.decal.pins[self.pin].position = self.position
        quality = self.made.quality
        self.end()
        return quality

    def end(self):
        self.made.release()


class RELIEVO_OT_decal_pin_drag(OnDecal, bpy.types.Operator):
    """Drag a pin over the object; the decal's mesh follows"""

    bl_idname = "relievo.decal_pin_drag"
    bl_label = "Drag pin"

    pin: bpy.props.IntProperty(name="Pin", min=0)
    position: bpy.props.FloatVectorProperty(name="Position", description="In the space of the object", size=3)

    def execute(self, context):
        try:
            drag = Drag(owner_of(context.active_object), self.pin)
            try:
                drag.move(tuple(self.position))
                quality = drag.release()
            except self.failures:
                drag.end()
                raise
        except self.failures as failure:
            self.report({"ERROR"}, said(failure))
            return {"CANCELLED"}
        self.report({"INFO"}, told(quality))
        return {"FINISHED"}

    def invoke(self, context, event):
        self.drag = None
        if is_press(context, event):
            # The tool's press takes hold of a pin, or does nothing.
            self.modal(context, event)
            if self.drag is None:
                return {"CANCELLED"}
        context.workspace.status_text_set("Press near a pin and drag it; Esc cancels")
        context.window_manager.modal_handler_add(self)
        return {"RUNNING_MODAL"}

    def modal(self, context, event):
        try:
            return self.respond(context, event)
        except self.failures as failure:
            self.report({"ERROR"}, said(failure))
            return self.ended(context, {"CANCELLED"})

    def respond(self, context, event):
        target = owner_of(context.active_object)
        if event.type in {"ESC", "RIGHTMOUSE"} and event.value == "PRESS":
            return self.ended(context, {"CANCELLED"})
        if event.type == "LEFTMOUSE" and event.value == "PRESS" and self.drag is None:
            pin = nearest_pin(context, event, target)
            if pin is not None:
                target.relievo.decal.active = self.pin = pin
                self.drag = Drag(target, pin)
            return {"RUNNING_MODAL"}
        if self.drag is None:
            return {"PASS_THROUGH"}
        if event.type == "MOUSEMOVE":
            hit = meet(context, event, target)
            if hit is not None:
                try:
                    self.drag.move(hit)
                except rl.RelievoError as failure:
                    # The pin stays where the decal could follow last.
                    context.workspace.status_text_set(said(failure))
            context.area.tag_redraw()
        elif event.type == "LEFTMOUSE" and event.value == "RELEASE":
            self.position = self.drag.position
            drag, self.drag = self.drag, None
            quality = drag.release()
            self.report({"INFO"}, told(quality))
            return self.ended(context, {"FINISHED"})
        return {"RUNNING_MODAL"}

    def ended(self, context, answer):
        if self.drag is not None:
            self.drag.end()
            self.drag = None
        context.workspace.status_text_set(None)
        return answer

    def cancel(self, context):
        """Blender ends it, say because the window closes."""
        self.ended(context, {"CANCELLED"})


def is_press(context, event):
    """Returns whether an event is the press of a tool in the view, and not of a button."""
    in_view = context.region is not None and context.region.type == "WINDOW" and context.region_data is not None
    return in_view and event.type == "LEFTMOUSE" and event.value == "PRESS"


def pointer_of(context, event):
    """Returns the window region of the area and the pointer in it."""
    region = next(region for region in context.area.regions if region.type == "WINDOW")
    return region, (event.mouse_x - region.x, event.mouse_y - region.y)


def meet(context, event, target):
    """Returns where the pointer meets what is shown of an object, in its space, or None."""
    region, place = pointer_of(context, event)
    origin = view3d_utils.region_2d_to_origin_3d(region, context.region_data, place)
    direction = view3d_utils.region_2d_to_vector_3d(region, context.region_data, place)
    inverse = pose.inverse_of(target)
    start, along = (inverse @ [*origin, 1.0])[:3], inverse[:3, :3] @ direction
    shown = target.relievo.result if state.is_used(target.relievo.result) else target
    is_hit, position, _normal, _face = shown.evaluated_get(context.evaluated_depsgraph_get()).ray_cast(start, along)
    return tuple(position) if is_hit else None


def nearest_pin(context, event, target):
    """Returns the pin that is nearest to the pointer on the screen, or None if none is near."""
    region, place = pointer_of(context, event)
    found = []
    for number, pin in enumerate(target.relievo.decal.pins):
        world = target.matrix_world @ Vector(pin.position)
        at = view3d_utils.location_3d_to_region_2d(region, context.region_data, world)
        if at is not None:
            found.append((numpy.hypot(at[0] - place[0], at[1] - place[1]), number))
    distance, number = min(found, default=(numpy.inf, None))
    return number if distance <= NEAR else None


CLASSES = [
    RELIEVO_OT_decal_mesh,
    RELIEVO_OT_decal_apply,
    RELIEVO_OT_decal_pin_add,
    RELIEVO_OT_decal_pin_remove,
    RELIEVO_OT_decal_pin_image,
    RELIEVO_OT_decal_pin_drag,
]

register, unregister = bpy.utils.register_classes_factory(CLASSES)
