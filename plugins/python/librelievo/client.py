"""A client of the simulation server, `relievo server run`. docs/protocol.md describes the protocol and every method.

    with client.Client("127.0.0.1:7350") as server:
        server.submit("dam", open("dam.toml").read())
        server.wait("dam", 10)
        server.fetch("dam", 10, "0010.rlvfluid")

Every method may be repeated, so a call whose connection breaks is made again on a new one."""

from __future__ import annotations

import hashlib
import os
import socket
import ssl
import time
from collections.abc import Mapping
from typing import Any

from . import error, messagepack
from .array import integer, mapped, number
from .handle import path_bytes
from .hint import FilePath, Progress
from .progress import function_of

# Version of the protocol, and bytes of a part of a file.
VERSION, PART = [1, 1], 4 << 20
# The kinds of errors of the protocol.
KINDS = {
    "invalid": error.Invalid,
    "unsupported": error.Unsupported,
    "not_found": error.NotFound,
    "io": error.FileFailure,
    "limit": error.MemoryLimit,
    "busy": error.Busy,
    "cancelled": error.Cancelled,
    "device": error.DeviceFailure,
    "internal": error.Internal,
}


def failure(parts: Any) -> Any:
    """The exception of an error of the protocol."""
    what, place, remedy = (parts.get(name, "") for name in ("what", "place", "remedy"))
    message = (f"{place}: " if place else "") + what + (f"; {remedy}" if remedy else "")
    return KINDS.get(parts.get("kind"), error.RelievoError)(message, what, place, remedy)


def address_of(text: Any) -> tuple[Any, ...]:
    """The family and the address of `host:port`, `[host]:port`, `tls://host:port` or `unix:/path`, and whether connections are
    encrypted."""
    if text_of(text, "address").startswith("unix:"):
        return socket.AF_UNIX, text[5:], False
    encrypted = text.startswith("tls://")
    host, colon, port = text.removeprefix("tls://").rpartition(":")
    if not colon or not port.isdecimal() or not port.isascii() or int(port) > 0xFFFF:
        raise error.Invalid(f"{text!r} is no address; use host:port, tls://host:port or unix:/path")
    return None, (host.strip("[]"), int(port)), encrypted


def text_of(text: Any, name: str) -> str:
    """A text; Invalid where the value is none."""
    if not isinstance(text, str):
        raise error.Invalid(f"{name}: a text is needed, not {type(text).__name__}")
    return text


def opened(path: Any, mode: str) -> Any:
    """An open file; FileFailure, or NotFound, where the system refuses."""
    name = os.fsdecode(path_bytes(path))
    try:
        return open(name, mode)
    except FileNotFoundError:
        raise error.NotFound(f"{name}: there is no such file or folder; check the path") from None
    except OSError as problem:
        raise error.FileFailure(f"{name}: {problem.strerror}; choose another path") from None


def encryption(authority: Any) -> Any:
    """The settings of encrypted connections to a server whose certificate is one of an authority, a file in PEM."""
    if authority is None or path_bytes(authority, "authority") == b"":
        raise error.Invalid("there are no certificates to check the server's against; name a file with those of its authority")
    try:
        return ssl.create_default_context(cafile=authority)
    except (OSError, ssl.SSLError) as wrong:
        raise error.Invalid(f"{authority}: the certificates cannot be used: {wrong}") from None


class Client:
    """A connection to a server that is made again when it breaks, for up to `patience` seconds."""

    def __init__(
        self,
        address: str = "127.0.0.1:7350",
        token: str = "",
        patience: float = 10.0,
        timeout: float = 60.0,
        authority: FilePath = "",
    ) -> None:
        """`authority` is a file with the certificates, in PEM, that a server at tls:// is checked against."""
        *self.address, encrypted = address_of(address)
        self.token, self.patience = text_of(token, "token"), number(patience, "patience")
        self.timeout = number(timeout, "timeout")
        if not 0 < self.timeout < 1e9 or not 0 <= self.patience < 1e9:
            raise error.Invalid(f"timeout, patience: seconds are needed, not {timeout!r} and {patience!r}")
        self.encryption = encryption(authority) if encrypted else None
        self.link, self.count, self.welcome = None, 0, None
        self._retry(lambda: None)

    def __enter__(self) -> Client:
        return self

    def __exit__(self, *_exception: Any) -> None:
        self.close()

    def close(self) -> None:
        """Closes the connection."""
        if self.link is not None:
            self.link.close()
            self.link = None

    def _retry(self, task: Any) -> Any:
        until, pause = time.monotonic() + self.patience, 0.02
        while True:
            try:
                if self.link is None:
                    self._greet()
                return task()
            except error.RelievoError:
                raise
            except ssl.SSLCertVerificationError as wrong:
                self.close()
                raise error.Invalid(f"the certificate of the server is refused: {wrong.verify_message}") from None
            except (OSError, ValueError) as broken:
                self.close()
                if time.monotonic() + pause > until:
                    advice = "check that the server runs and the address is right"
                    raise error.FileFailure(f"the server does not answer: {broken}; {advice}") from None
            time.sleep(pause)
            pause = min(1.0, 2 * pause)

    def _greet(self) -> None:
        family, address = self.address
        if family is None:
            self.link = socket.create_connection(address, self.timeout)
            self.link.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)
            if self.encryption is not None:
                self.link = self.encryption.wrap_socket(self.link, server_hostname=address[0])
        else:
            self.link = socket.socket(family)
            self.link.settimeout(self.timeout)
            self.link.connect(address)
        try:
            hello = {"version": VERSION, "client": "librelievo", "token": self.token}
            self.welcome = self._exchange(messagepack.packed(["hello", [hello]]))
        except error.RelievoError:
            self.close()
            raise

    def _take(self, count: Any) -> bytes:
        """The next bytes from the server."""
        taken = bytearray()
        while len(taken) < count:
            part = self.link.recv(min(count - len(taken), 1 << 20))
            if not part:
                raise OSError("the connection was closed")
            taken += part
        return bytes(taken)

    def _exchange(self, request: bytes) -> Any:
        """Sends a list of a method and its parameters, packed, and takes the answer."""
        self.count += 1
        # The list has two more entries, the kind and the number of the message, in front.
        self.link.sendall(b"\x94\x00" + messagepack.packed(self.count) + request[1:])
        while True:
            message = messagepack.read(self._take)
            if not isinstance(message, list) or len(message) != 4:
                raise ValueError("it does not speak MessagePack-RPC; see whether its address begins with tls://")
            kind, number, problem, result = message
            if kind == 1 and number in (self.count, 0):
                if problem is not None:
                    raise failure(problem)
                return result

    def call(self, method: str, **parameters: Any) -> Any:
        """Calls a method and returns its result."""
        request = messagepack.packed([text_of(method, "method"), [parameters]])
        return self._retry(lambda: self._exchange(request))

    def send_files(self, files: Mapping[str, Any] | None) -> Any:
        """Sends those of the files, paths by their names in a description, that the server lacks. Returns their hashes."""
        hashes, files = {}, mapped(files, "files")
        for name, path in files.items():
            with opened(path, "rb") as file:
                hashes[text_of(name, "files")] = hashlib.file_digest(file, "sha256").hexdigest()
        missing = self.call("file.missing", files=hashes)["files"] if hashes else {}
        for name in hashes.keys() & missing.keys():
            size, received = os.path.getsize(files[name]), 0
            with opened(files[name], "rb") as file:
                while True:
                    file.seek(received)
                    part = {"offset": received, "data": file.read(PART)}
                    received = self.call("file.put", name=name, hash=hashes[name], size=size, **part)["received"]
                    if received >= size:
                        break
        return hashes

    def submit(
        self, scene: str, description: str | bytes, files: Mapping[str, Any] | None = None, kind: str = "fluid"
    ) -> dict[str, Any]:
        """Has the server simulate a description, with the files, paths by their names, that it names. Returns the status."""
        hashes = self.send_files(files)
        return self.call("scene.submit", scene=scene, kind=kind, description=description, files=hashes)

    def status(self, scene: str) -> dict[str, Any]:
        """What a scene is doing."""
        return self.call("scene.status", scene=scene)

    def wait(self, scene: str, frame: int, progress: Progress | None = None) -> dict[str, Any]:
        """Waits until a frame is stored and returns the status. Fails where the scene stops before."""
        frame = integer(frame, "frame")
        function_of(progress, "progress")
        while True:
            status = self.call("scene.wait", scene=scene, frame=frame, seconds=0.2)
            if status["ready"] > frame:
                return status
            if status["error"] is not None:
                raise failure(status["error"])
            if status["state"] not in ("running", "forces"):
                raise error.Cancelled(f"{scene} is {status['state']} at frame {status['ready']}")
            part = (status["ready"] + status["fraction"]) / (frame + 1)
            if progress is not None and not progress(min(1.0, part), "simulate"):
                raise error.Cancelled("the caller cancelled the operation")

    def fetch(self, scene: str, frame: int, path: FilePath) -> None:
        """Writes a frame to a file, which has its name when it is whole."""
        self._save(path, "frame.file", scene=scene, frame=frame)

    def fetch_surface(self, scene: str, frame: int, path: FilePath, form: str = "mesh", settings: str = "") -> None:
        """Writes the surface of a frame, which the server makes, to a file: a `mesh` in binary PLY or a `level_set` in
        OpenVDB's format. `settings` are keys and values in TOML, such as `cell = 1.0` in spacings."""
        self._save(path, "frame.surface", scene=scene, frame=frame, form=form, settings=settings)

    def _save(self, path: Any, method: Any, **parameters: Any) -> None:
        path = os.fsdecode(path_bytes(path))
        unfinished, size, key = f"{path}.unfinished", 0, None
        with opened(unfinished, "wb") as file:
            while True:
                part = self.call(method, offset=size, length=PART, **parameters)
                if key not in (None, part.get("key")):
                    raise error.Busy("the frame was computed anew while it was fetched; fetch it again")
                key = part.get("key")
                size += file.write(part["data"])
                if size >= part["size"]:
                    break
        os.replace(unfinished, path)

    def steer(self, scene: str, frame: int, changes: str | Mapping[str, Any]) -> dict[str, Any]:
        """Changes keys of a description after a frame."""
        return self.call("scene.steer", scene=scene, frame=frame, changes=changes)

    def cancel(self, scene: str) -> dict[str, Any]:
        """Stops a scene. Its frames stay."""
        return self.call("scene.cancel", scene=scene)

    def remove(self, scene: str) -> None:
        """Has the server forget a scene."""
        self.call("scene.remove", scene=scene)
