# SPDX-License-Identifier: GPL-3.0-or-later
"""Long work in steps. A generator reads and writes Blender's data and yields what is to be done without it: where that
begins and ends, as shares of the whole, and a function that takes a progress callback. The functions run on a thread of
their own while a window is there, and in place under `blender -b`."""

import threading
import time

import bpy
from bpy_extras.io_utils import ExportHelper, ImportHelper

from .error import said

# What the main thread may wait for a step before it lets Blender go on, seconds: a frame.
FRAME = 1 / 60
# Events that turn, move and zoom views, which they may while something is at work.
TURNING = {"MIDDLEMOUSE", "WHEELUPMOUSE", "WHEELDOWNMOUSE", "TRACKPADPAN", "TRACKPADZOOM", "NDOF_MOTION"}


def run(steps):
    """Does all of a generator in place, and returns what it returns."""
    try:
        _first, _last, function = next(steps)
        while True:
            try:
                function(None)
            except BaseException as failure:
                _first, _last, function = steps.throw(failure)
            else:
                _first, _last, function = next(steps)
    except StopIteration as end:
        return end.value


def within(first, last, steps):
    """Steps that are a part of others: their shares of the whole go from `first` to `last`. Returns what they return."""
    try:
        begin, end, function = next(steps)
        while True:
            try:
                yield first + begin * (last - first), first + end * (last - first), function
            except BaseException as failure:
                begin, end, function = steps.throw(failure)
            else:
                begin, end, function = next(steps)
    except StopIteration as done:
        return done.value


class Worker:
    """A generator whose functions run on a thread, one after the other."""

    def __init__(self, steps):
        self.steps, self.thread, self.failure, self.value = steps, None, None, None
        self.share, self.span = 0.0, (0.0, 0.0)
        self.is_cancelled = self.is_done = False

    def progress(self, fraction, _stage=None):
        """What functions tell how far they came; the answer is whether to go on."""
        first, last = self.span
        self.share = first + fraction * (last - first)
        return not self.is_cancelled

    def advance(self, patience=0.0):
        """Goes on as far as it can within `patience` seconds; raises what the generator raises. Says whether it has
        ended."""
        until = time.perf_counter() + patience
        while not self.is_done:
            if self.thread is not None:
                self.thread.join(max(0.0, until - time.perf_counter()))
                if self.thread.is_alive():
                    return False
                self.thread = None
            if self.is_cancelled:
                # What was begun is taken back: the generator sees GeneratorExit.
                self.is_done = True
                self.steps.close()
                return True
            failure, self.failure = self.failure, None
            try:
                first, last, function = self.steps.throw(failure) if failure else next(self.steps)
            except StopIteration as end:
                self.is_done, self.value = True, end.value
                return True
            except BaseException:
                self.is_done = True
                raise
            self.span, self.share = (first, last), first
            self.thread = threading.Thread(target=self._work, args=(function,), daemon=True)
            self.thread.start()
        return True

    def _work(self, function):
        try:
            function(self.progress)
        except BaseException as failure:
            self.failure = failure

    def stop(self):
        """Cancels and waits."""
        self.is_cancelled = True
        if self.thread is not None:
            self.thread.join()
        self.advance()


# What is at work on threads for operators.
working = []


def is_busy():
    """Whether an operator is at work on a thread."""
    return bool(working)


# Functions that stop what works unasked, called before an operator begins.
interrupts = []


def interrupt():
    """Stops what works unasked, such as a preview."""
    for function in interrupts:
        function()


class Steps:
    """An operator whose work is `steps(context)`. What it raises of `failures` is reported; Esc cancels it."""

    _timer = None
    failures = ()
    # Whether it may end before its `invoke` does.
    is_quick = True

    def warn(self, notes):
        """Tells what should be known."""
        for note in notes:
            self.report({"WARNING"}, note)

    def execute(self, context):
        interrupt()
        try:
            run(self.steps(context))
        except self.failures as failure:
            self.report({"ERROR"}, said(failure))
            return {"CANCELLED"}
        return {"FINISHED"}

    def invoke(self, context, _event):
        if bpy.app.background or context.window is None:
            return self.execute(context)
        if is_busy():
            self.report({"ERROR"}, "Relievo is at work; wait for it, or cancel it with Esc")
            return {"CANCELLED"}
        interrupt()
        self.work = Worker(self.steps(context))
        try:
            # What is quick needs no timer.
            if self.is_quick and self.work.advance(FRAME):
                return {"FINISHED"}
        except self.failures as failure:
            self.report({"ERROR"}, said(failure))
            return {"CANCELLED"}
        working.append(self.work)
        context.window_manager.progress_begin(0, 100)
        self._timer = context.window_manager.event_timer_add(0.02, window=context.window)
        context.window_manager.modal_handler_add(self)
        return {"RUNNING_MODAL"}

    def modal(self, context, event):
        if event.type == "ESC" and event.value == "PRESS":
            self.work.is_cancelled = True
        if event.type in TURNING:
            return {"PASS_THROUGH"}
        if event.type != "TIMER":
            # The file must not be changed under the work.
            return {"RUNNING_MODAL"}
        answer = {"CANCELLED"} if self.work.is_cancelled else {"FINISHED"}
        try:
            if self.work.advance():
                return self.done(context, answer)
        except self.failures as failure:
            if not self.work.is_cancelled:
                self.report({"ERROR"}, said(failure))
            return self.done(context, {"CANCELLED"})
        except BaseException:
            self.done(context, {"CANCELLED"})
            raise
        share = int(100 * self.work.share)
        context.window_manager.progress_update(share)
        if context.workspace is not None:
            what = "being cancelled" if self.work.is_cancelled else f"{share} %, Esc cancels"
            context.workspace.status_text_set(f"{self.bl_label}: {what}")
        return {"RUNNING_MODAL"}

    def cancel(self, context):
        """Blender ends it, say because the window closes."""
        self.work.stop()
        self.done(context, {"CANCELLED"})

    def done(self, context, answer):
        if self.work in working:
            working.remove(self.work)
        context.window_manager.event_timer_remove(self._timer)
        context.window_manager.progress_end()
        if context.workspace is not None:
            context.workspace.status_text_set(None)
        for area in context.screen.areas if context.screen else []:
            area.tag_redraw()
        return answer


def ask(operator, context, event, text):
    """Asks whether an operator is to go on, and executes it then. Returns what its `invoke` returns."""
    # Blender 3.4 shows the label alone.
    shown = {} if bpy.app.version < (4, 1) else {"title": operator.bl_label, "message": text, "icon": "WARNING"}
    return context.window_manager.invoke_confirm(operator, event, **shown)


class Asking(Steps):
    """The same for operators that ask first, for a file or whether to go on, by the `dialog` of a class."""

    # The dialog ends, and makes a step of undo, when the work has begun: it must have changed nothing until then.
    is_quick = False
    is_confirmed: bpy.props.BoolProperty(options={"HIDDEN", "SKIP_SAVE"})

    def invoke(self, context, event):
        if self.is_confirmed:
            return Steps.invoke(self, context, event)
        return self.dialog.invoke(self, context, event)

    def execute(self, context):
        if bpy.app.background or context.window is None or self.is_confirmed:
            return Steps.execute(self, context)
        # The file was chosen in a dialog, which cannot go on in the background itself.
        group, name = self.bl_idname.split("_OT_") if "_OT_" in self.bl_idname else self.bl_idname.split(".")
        keywords = self.as_keywords(ignore=("check_existing", "filter_glob", "is_confirmed"))
        answer = getattr(getattr(bpy.ops, group.lower()), name)("INVOKE_DEFAULT", is_confirmed=True, **keywords)
        return answer & {"FINISHED", "CANCELLED"} or {"FINISHED"}


class FileSteps(Asking, ExportHelper):
    """The same for operators that ask for a file to write."""

    dialog = ExportHelper


class Question:
    """The dialog of operators that ask whether to go on; a class has the `question`."""

    def invoke(self, context, event):
        return ask(self, context, event, self.question)


class ConfirmedSteps(Asking):
    """The same for operators that ask whether to go on."""

    dialog = Question


class ReadSteps(Asking, ImportHelper):
    """The same for operators that ask for a file to read."""

    dialog = ImportHelper
