# SPDX-License-Identifier: GPL-3.0-or-later
"""Long work in steps. A generator reads and writes Blender's data and yields what is to be done without it; that runs on
a thread of its own while a window is there, and in place under `blender -b`. The generator is told how far it came."""

import threading

import bpy


class Worker:
    """One thread that runs one function at a time."""

    def __init__(self):
        self.thread = self.failure = None

    def start(self, function):
        self.failure = None

        def work():
            try:
                function()
            except BaseException as failure:
                self.failure = failure

        self.thread = threading.Thread(target=work, daemon=True)
        self.thread.start()

    @property
    def is_busy(self):
        return self.thread is not None and self.thread.is_alive()

    def join(self):
        if self.thread is not None:
            self.thread.join()


class Steps:
    """An operator whose work is `steps(context)`, a generator that yields a fraction and a function without bpy. What
    it raises is reported; Esc cancels it, which it sees as GeneratorExit."""

    _timer = None

    def execute(self, context):
        steps = self.steps(context)
        try:
            for _fraction, function in steps:
                try:
                    function()
                except BaseException as failure:
                    steps.throw(failure)
        except self.failures as failure:
            self.report({"ERROR"}, str(failure))
            return {"CANCELLED"}
        return {"FINISHED"}

    def invoke(self, context, _event):
        if bpy.app.background or context.window is None:
            return self.execute(context)
        self.work, self.worker = self.steps(context), Worker()
        context.window_manager.progress_begin(0, 100)
        self._timer = context.window_manager.event_timer_add(0.02, window=context.window)
        context.window_manager.modal_handler_add(self)
        return {"RUNNING_MODAL"}

    def modal(self, context, event):
        if event.type == "ESC":
            self.worker.join()
            self.work.close()
            return self.done(context, {"CANCELLED"})
        if event.type != "TIMER" or self.worker.is_busy:
            # The file must not be changed under the work.
            return {"RUNNING_MODAL"}
        try:
            if self.worker.failure is not None:
                failure, self.worker.failure = self.worker.failure, None
                fraction, function = self.work.throw(failure)
            else:
                fraction, function = next(self.work)
        except StopIteration:
            return self.done(context, {"FINISHED"})
        except self.failures as failure:
            self.report({"ERROR"}, str(failure))
            return self.done(context, {"CANCELLED"})
        context.window_manager.progress_update(100 * fraction)
        self.worker.start(function)
        return {"RUNNING_MODAL"}

    def done(self, context, answer):
        context.window_manager.event_timer_remove(self._timer)
        context.window_manager.progress_end()
        for area in context.screen.areas if context.screen else []:
            area.tag_redraw()
        return answer
