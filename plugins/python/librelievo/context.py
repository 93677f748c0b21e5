"""Contexts, which own the threads that work, the memory limit and the statistics."""

from __future__ import annotations

import ctypes
from collections.abc import Callable, Mapping
from typing import Any

import numpy

from . import abi, library, record
from .array import SIZE, address, integer, mapped
from .error import text
from .handle import Handle, held, text_bytes
from .parameter import address_of
from .progress import function_of


class Context(Handle):
    """Threads, memory limit and statistics; every object is made with one."""

    noun, kind = "context", abi.RlvContext
    _log, _monitor = abi.RlvLog(), abi.RlvMemoryMonitor()

    def __init__(self, vulkan: Mapping[str, int] | None = None, **options: Any) -> None:
        """Options are the fields of `abi.RlvContextOptions`: device ("cpu", "gpu", "auto"), adapter, threads, memory_limit,
        device_memory_limit, and shared, a context whose threads this one uses. `vulkan` is a Vulkan device of the host, by
        the fields of `abi.RlvVulkanDevice`, objects and functions of C as numbers; its handles outlive the context."""
        if options.get("shared") is not None:
            options["shared"] = held(options["shared"], "shared", abi.RlvContext)
        if options.get("adapter") is not None:
            options["adapter"] = text_bytes(options["adapter"], "adapter")
        options = record.fill(abi.RlvContextOptions, options, device=abi.RlvDevice)
        if vulkan is None:
            super().__init__("rlv_context_create", ctypes.byref(options))
        else:
            kinds = dict(abi.RlvVulkanDevice._fields_)
            functions = ("loader", "lock", "unlock", "released")
            given = dict(mapped(vulkan, "vulkan"))
            for name in given.keys() & set(functions):
                given[name] = kinds[name](integer(given[name], name, SIZE))
            given = record.fill(abi.RlvVulkanDevice, given)
            super().__init__("rlv_vulkan_create_context", ctypes.byref(given), ctypes.byref(options))

    def release(self) -> None:
        """Gives the context back. Log and monitor hear no more of objects that outlive it, as their functions end with it."""
        if self._log:
            self.set_log(None)
        if self._monitor:
            self.set_memory_monitor(None)
        super().release()

    @property
    def info(self) -> Any:
        """Device, threads, memory limits, instruction level, and why there is no graphics device if one was asked for."""
        out = record.empty(abi.RlvContextInfo)
        library.call("rlv_context_info", self.handle, ctypes.byref(out))
        return record.read(out)

    def close_device(self) -> None:
        """Lets the graphics device go; the processor takes over."""
        library.call("rlv_context_close_device", self.handle)

    def wait(self, semaphore: int, value: int = 0) -> None:
        """Has its later work on the device wait for a `VkSemaphore`: a timeline semaphore until it has the value, a binary one
        where that is 0."""
        library.call("rlv_vulkan_wait", self.handle, semaphore, value)

    def signal(self, semaphore: int, value: int = 0) -> None:
        """Signals a `VkSemaphore` once its work on the device is done, a binary one where the value is 0."""
        library.call("rlv_vulkan_signal", self.handle, semaphore, value)

    def set_log(self, log: Callable[[int, str], Any] | None) -> None:
        """`log(level, text)` gets what is worth knowing but no failure; None for silence."""
        function_of(log, "log")
        function = abi.RlvLog()
        if log is not None:
            function = abi.RlvLog(lambda _user, level, line: log(abi.RlvLogLevel(level), text(line)))
        library.call("rlv_context_set_log", self.handle, function, None)
        self._log = function

    def set_memory_monitor(self, monitor: Callable[[int], bool | None] | None) -> None:
        """`monitor(bytes)` hears of bytes that meshes and casters take or, below 0, give back, on any thread; where it
        returns False, the call that needs them fails with MemoryLimit. None for no monitor."""

        def answer(_user: Any, taken: int) -> int:
            refused = monitor(taken) is False
            return abi.RlvProgressAnswer.CANCEL if refused else abi.RlvProgressAnswer.CONTINUE

        function_of(monitor, "monitor")
        function = abi.RlvMemoryMonitor() if monitor is None else abi.RlvMemoryMonitor(answer)
        library.call("rlv_context_set_memory_monitor", self.handle, function, None)
        self._monitor = function

    def stats(self) -> list[Any]:
        """Time and counts per stage since the last reset: rows of stage, quantity, total and samples."""
        count = ctypes.c_size_t()
        library.call("rlv_context_stats", self.handle, None, 0, address_of(count))
        rows = numpy.zeros(count.value + 16, numpy.dtype(abi.RlvContextStat))
        pointer = ctypes.cast(address(rows), ctypes.POINTER(abi.RlvContextStat))
        library.call("rlv_context_stats", self.handle, pointer, len(rows), address_of(count))
        return [record.read(pointer[index]) for index in range(count.value)]

    def reset_stats(self) -> None:
        """Forgets the statistics."""
        library.call("rlv_context_reset_stats", self.handle)
