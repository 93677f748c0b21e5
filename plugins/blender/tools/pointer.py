# SPDX-License-Identifier: GPL-3.0-or-later
"""Edits of levels by the pointer, from press to release: what is tried at every event takes the place of what was tried at
the last one, and what is there at the release is kept as one edit."""

import numpy
from bpy_extras import view3d_utils

from ..core import job, lengths
from ..core.error import said
from ..data import pose, progressive
from ..ops import levels


class Edit(levels.OnLevels, job.Steps):
    """An operator that edits a level at once (`steps`), or by the pointer (`begin` to `release`). It has `text(measure)`,
    the edit as the object keeps it, and `stamp`, the name and the bytes of what that names."""

    stamp = None
    # Whether the pointer does it.
    is_drawn = False

    def steps(self, context):
        """The whole edit at once."""
        target = context.active_object
        lengths.follow(context.scene, target)
        measure = progressive.measure_of(target.relievo.progressive)
        shown = yield from progressive.opening(target)
        self.prepare(context, target, shown)
        text = self.text(measure)

        def work(_progress):
            shown.edit(text)
            shown.bring(measure)

        yield 0.9, 1.0, work
        progressive.keep(target, text, self.stamp)
        progressive.write(target, shown)
        if len(target.relievo.progressive.hooks):
            yield from progressive.showing(target)

    def prepare(self, context, target, shown):
        """Reads what an edit needs before it begins."""

    def begin(self, context):
        """Gets ready for the pointer. Fails as edits do."""
        self.target = context.active_object
        lengths.follow(context.scene, self.target)
        self.world = numpy.array(self.target.matrix_world)
        self.inverse = pose.inverse_of(self.target)
        self.measure = progressive.measure_of(self.target.relievo.progressive)
        self.shown = job.run(progressive.showing(self.target, is_resting=True))
        self.prepare(context, self.target, self.shown)
        self.caster = self.shown.pick()
        self.is_drawn, self.is_tried = True, False
        progressive.resting.add(self.target.name)
        # The button is in the sidebar, the surface in the window beside it.
        self.region = next(region for region in context.area.regions if region.type == "WINDOW")

    def mouse(self, event):
        return event.mouse_x - self.region.x, event.mouse_y - self.region.y

    def meet(self, context, event):
        """Where the pointer is on the surface as it was at the press, in the space of the object, or None."""
        view, place = context.region_data, self.mouse(event)
        origin = view3d_utils.region_2d_to_origin_3d(self.region, view, place)
        direction = view3d_utils.region_2d_to_vector_3d(self.region, view, place)
        start, along = (self.inverse @ [*origin, 1.0])[:3], self.inverse[:3, :3] @ direction
        hit = self.caster.cast([start], [along])[0]
        return hit["position"].astype(float).tolist() if numpy.isfinite(hit["distance"]) else None

    def attempt(self):
        """Makes the edit as it is now in place of the one of the last event."""
        self.take_back()
        self.shown.edit(self.text(self.measure))
        self.is_tried = True
        progressive.write_moved(self.target, self.shown)

    def take_back(self):
        if self.is_tried:
            self.shown.undo()
            self.is_tried = False

    def release(self, context):
        """Keeps the edit."""
        if not self.is_tried:
            return self.cancelled(context)
        progressive.keep(self.target, self.shown.edits[-1], self.stamp)
        return self.done_drawing(context, {"FINISHED"})

    def cancel(self, context):
        """Blender ends it, say because the window closes."""
        if self.is_drawn:
            self.cancelled(context)
        else:
            super().cancel(context)

    def cancelled(self, context):
        try:
            self.take_back()
            progressive.write_moved(self.target, self.shown)
        except self.failures as failure:
            self.report({"ERROR"}, said(failure))
        return self.done_drawing(context, {"CANCELLED"})

    def done_drawing(self, context, answer):
        progressive.resting.discard(self.target.name)
        if len(self.target.relievo.progressive.hooks):
            progressive.changed(self.target)
        if context.workspace is not None:
            context.workspace.status_text_set(None)
        if context.area is not None:
            context.area.tag_redraw()
        return answer


def is_in_view(context):
    """Whether a pointer can draw."""
    return context.area is not None and context.area.type == "VIEW_3D" and context.region_data is not None
