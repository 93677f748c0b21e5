"""Has a server simulate a fluid, and writes a mesh of each frame while later ones are computed.

    relievo server run
    python3 remote.py ../fluids/drop.toml meshes

It needs no shared library of Relievo: the server makes the meshes."""

import sys
from pathlib import Path

from librelievo import client

description, folder = Path(sys.argv[1]), Path(sys.argv[2])
address = sys.argv[3] if len(sys.argv) > 3 else "127.0.0.1:7350"
folder.mkdir(exist_ok=True)
with client.Client(address) as server:
    status = server.submit(description.stem, description.read_text())
    for frame in range(status["frames"]):
        status = server.wait(description.stem, frame)
        server.fetch_surface(description.stem, frame, folder / f"{frame:04}.ply")
        left = status.get("seconds_left")
        print(f"frame {frame} of {status['frames'] - 1}" + (f", {left:.0f} s left" if left else ""))
