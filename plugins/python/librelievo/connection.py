"""Clients of the simulation server over the library: frames arrive as particles and meshes.

`librelievo.client` has a client in Python alone, for where the library is not installed."""

from __future__ import annotations

import ctypes
from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

import numpy

from . import abi, library, record
from .array import Reading, flag, list_of, mapped
from .error import Invalid
from .handle import Handle, held, path_bytes, text_bytes
from .hint import ArrayLike, FilePath, Progress
from .mesh import Mesh
from .particles import Particles
from .progress import watched

if TYPE_CHECKING:
    from .context import Context


def scene_of(name: str, description: Any, files: Any, kind: Any, is_forced: Any) -> tuple[Any, ...]:
    """A scene as the library takes it, and what it points to."""
    kept = [(text_bytes(file, "files"), path_bytes(path, "files")) for file, path in mapped(files, "files").items()]
    entries = (abi.RlvClientFile * len(kept))(*kept)
    given = record.fill(abi.RlvClientScene, {"is_forced": flag(is_forced, "is_forced"), "file_count": len(kept)})
    given.name, given.kind, given.description = text_bytes(name, "name"), text_bytes(kind, "kind"), text_bytes(description, "description")
    given.files = entries
    return given, (kept, entries)


def fetch_of(particles: Any, channels: Any, half: Any, plain: Any) -> Any:
    """How a frame is fetched."""
    given = {"particles": particles, "is_half": flag(half, "half"), "is_plain": flag(plain, "plain")}
    fetch = record.fill(abi.RlvClientFetch, given, particles=abi.RlvClientParticles)
    if channels is not None:
        names = [text_bytes(name, "channels") for name in list_of(channels, "channels")]
        if None in names:
            raise Invalid("channels: names are needed, not None")
        fetch.channels = b",".join(names)
    return fetch


class Connection(Handle):
    """A client of `relievo server run`. It connects again by itself; calls may run at the same time."""

    noun, kind = "client", abi.RlvClient

    def __init__(
        self,
        context: Context,
        address: str | None = None,
        token: str | None = None,
        authorities: Any = None,
        timeout: float = 60.0,
        patience: float = 30.0,
    ) -> None:
        """Connects to host:port, tls://host:port or unix:/path. `authorities` is a file of certificates in PEM that a server
        at tls:// is checked against; times are in seconds."""
        options = record.fill(abi.RlvClientOptions, {"timeout": timeout, "patience": patience})
        options.address, options.token = text_bytes(address, "address"), text_bytes(token, "token")
        options.authorities = None if authorities is None else path_bytes(authorities, "authorities")
        super().__init__("rlv_client_connect", held(context, "context"), ctypes.byref(options))

    @property
    def info(self) -> Any:
        """The server: protocol, server, user, kinds."""
        return self._read(abi.RlvClientInfo, "rlv_client_info")

    def submit(
        self,
        name: str,
        description: str,
        files: Mapping[str, Any] | None = None,
        kind: str = "fluid",
        is_forced: bool = False,
        progress: Progress | None = None,
    ) -> Any:
        """Has the server simulate a description, with the files, paths by their names, that it names. Returns the status."""
        scene, _kept = scene_of(name, description, files, kind, is_forced)
        with watched(progress) as callback:
            return self._read(abi.RlvClientStatus, "rlv_client_submit", ctypes.byref(scene), callback, None)

    def poll(self, scene: str) -> Any:
        """The status of a scene: state, ready, frames, particles, seconds_left, fraction, text."""
        return self._read(abi.RlvClientStatus, "rlv_client_poll", text_bytes(scene, "scene"))

    def wait(self, scene: str, frame: int, progress: Progress | None = None) -> Any:
        """Waits until a frame can be fetched. Returns the status."""
        with watched(progress) as callback:
            return self._read(abi.RlvClientStatus, "rlv_client_wait", text_bytes(scene, "scene"), frame, callback, None)

    def steer(self, scene: str, frame: int, changes: Any) -> Any:
        """Changes keys of a description after a frame. Returns the status."""
        return self._read(abi.RlvClientStatus, "rlv_client_steer", text_bytes(scene, "scene"), frame, text_bytes(changes, "changes"))

    def force(self, scene: str, frame: int, accelerations: ArrayLike) -> Any:
        """Sends accelerations (n, 3) in m/s² of all particles of a frame on the way to the next one. Returns the status."""
        given = Reading(accelerations, numpy.float32, 3, "accelerations")
        arguments = (text_bytes(scene, "scene"), frame, given.address, given.count, given.stride)
        return self._read(abi.RlvClientStatus, "rlv_client_force", *arguments)

    def control(self, scene: str, action: str | int) -> None:
        """Has a scene `pause`, `resume`, `cancel` or `remove`."""
        number = record.named(abi.RlvClientAction, action, "action")
        library.call("rlv_client_control", self.handle, text_bytes(scene, "scene"), number)

    def fetch(
        self,
        scene: str,
        frame: int,
        particles: str = "all",
        channels: Any = None,
        half: bool = False,
        plain: bool = False,
        progress: Progress | None = None,
    ) -> Particles:
        """The particles of a frame: `all`, `blind` or `surface`, with all channels or the named ones."""
        fetch = fetch_of(particles, channels, half, plain)
        with watched(progress) as callback:
            arguments = (text_bytes(scene, "scene"), frame, ctypes.byref(fetch), callback, None)
            return Particles.of("rlv_client_fetch", self.handle, *arguments)

    def fetch_mesh(self, scene: str, frame: int, settings: str = "", progress: Progress | None = None) -> Mesh:
        """A mesh of the surface of a frame, which the server makes; settings are keys and values in TOML."""
        with watched(progress) as callback:
            arguments = (text_bytes(scene, "scene"), frame, text_bytes(settings, "settings"), callback, None)
            return Mesh.of("rlv_client_fetch_mesh", self.handle, *arguments)

    def save(
        self, scene: str, frame: int, path: FilePath, form: str = "frame", settings: str = "", progress: Progress | None = None
    ) -> None:
        """Writes a `frame`, or its surface as a `mesh` or `level_set`, to a file."""
        number = record.named(abi.RlvClientForm, form, "form")
        with watched(progress) as callback:
            arguments = (text_bytes(scene, "scene"), frame, number, text_bytes(settings, "settings"), path_bytes(path), callback, None)
            library.call("rlv_client_save", self.handle, *arguments)

    def _read(self, struct: Any, function: str, *arguments: Any) -> Any:
        out = record.empty(struct)
        library.call(function, self.handle, *arguments, ctypes.byref(out))
        return record.read(out)
