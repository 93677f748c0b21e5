"""The client of the simulation server in Python: whole scenes, restarts of the server, and messages.

RELIEVO_COMMAND names the command, which serves."""

import os
import random
import subprocess
import tempfile
import unittest
from pathlib import Path

import librelievo as rl
from librelievo import client, messagepack

DAM = """
frames = 4
[fluid]
spacing = 0.05
[basin]
low = [0, 0, 0]
high = [0.8, 0.4, 0.4]
[[fill]]
mesh = "block.obj"
"""
LONG = DAM.replace('mesh = "block.obj"', "box = { low = [0, 0, 0], high = [0.4, 0.2, 0.4] }").replace("= 4", "= 4000")
BLOCK = "".join(f"v {x} {y} {z}\n" for z in (0, 0.4) for y in (0, 0.2) for x in (0, 0.4))
BLOCK += "f 1 3 4 2\nf 5 6 8 7\nf 1 2 6 5\nf 2 4 8 6\nf 4 3 7 8\nf 3 1 5 7\n"


# Certificates for tests alone.
TLS = Path(__file__).resolve().parent.parent / "tls"


class Messages(unittest.TestCase):
    def test_values_come_back(self):
        draw = random.Random(1)
        plain = [None, True, False, 0, 127, 128, -1, -33, 1 << 40, -(1 << 40), 0.5, "", "a" * 40, "ä" * 300, b"", b"x" * 70000]
        values = [plain, {"a": plain, "b": {"c": []}}, list(range(20)), {str(number): number for number in range(40)}]
        for value in values:
            rest = memoryview(messagepack.packed(value))
            at = [0]

            def take(count):
                at[0] += count
                if at[0] > len(rest):
                    raise ValueError("too short")
                return bytes(rest[at[0] - count : at[0]])

            self.assertEqual(messagepack.read(take), value)
            self.assertEqual(at[0], len(rest))
            for _ in range(20):
                cut = draw.randrange(len(rest))
                at[0], whole, rest = 0, rest, rest[:cut]
                with self.assertRaises(ValueError):
                    messagepack.read(take)
                rest = whole

    def test_what_is_too_deep_or_too_long_is_refused(self):
        for wrong in (b"\x91" * 1000, b"\xdb\xff\xff\xff\xff", b"\xdd\xff\xff\xff\xff", b"\xc1"):
            rest = iter(wrong)
            with self.assertRaises(ValueError):
                messagepack.read(lambda count: bytes(next(rest) for _ in range(count)))


def result_of(job):
    """What a job makes, when it has ended."""
    job.wait()
    return job.result()


class Serving(unittest.TestCase):
    def setUp(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.folder = Path(folder.name)
        self.begin("127.0.0.1:0")

    def begin(self, listen, *more):
        command = [os.environ["RELIEVO_COMMAND"], "server", "run", "--listen", listen, "--cache", self.folder / "cache", "--threads", "1", *more]
        self.server = subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.DEVNULL, text=True)
        self.addCleanup(self.server.stdout.close)
        self.addCleanup(self.server.wait)
        self.addCleanup(self.server.kill)
        self.address = self.server.stdout.readline().split()[-1]

    def test_frames_are_those_of_the_command_also_after_a_kill(self):
        (self.folder / "block.obj").write_text(BLOCK)
        description = self.folder / "dam.toml"
        description.write_text(DAM)
        local = self.folder / "local"
        run = [os.environ["RELIEVO_COMMAND"], "fluid", "sim", description, "-o", local]
        subprocess.run(run, check=True, capture_output=True)
        with client.Client(self.address) as server:
            self.assertEqual(server.welcome["user"], "local")
            server.submit("dam", DAM, {"block.obj": self.folder / "block.obj"})
            shares = []
            server.wait("dam", 1, lambda share, _stage: shares.append(share) or True)
            self.server.kill()
            self.server.wait()
            self.begin(self.address)
            self.assertEqual(server.wait("dam", 4)["state"], "done")
            for frame in range(5):
                path = self.folder / f"{frame:04}.rlvfluid"
                server.fetch("dam", frame, path)
                self.assertEqual(path.read_bytes(), (local / path.name).read_bytes())
            with rl.Particles.read(rl.Context(), str(path)) as particles:
                self.assertEqual(particles.info.count, server.status("dam")["particles"])
            self.assertEqual(server.steer("dam", 2, "fluid.viscosity = 0.1")["ready"], 3)
            server.cancel("dam")
            server.remove("dam")

    def test_surfaces_are_made_at_the_server_and_foam_is_a_kind(self):
        foam = LONG.replace("4000", "6") + "[foam]\ntrapped_air = [0.1, 1]\ncrests = [0.1, 1]\nenergy = [0.01, 0.5]\n"
        with client.Client(self.address) as server:
            server.submit("foam", foam, kind="foam")
            server.wait("foam", 6)
            mesh, level_set = self.folder / "6.ply", self.folder / "6.vdb"
            server.fetch_surface("foam", 6, mesh)
            server.fetch_surface("foam", 6, level_set, "level_set", "cell = 1.0")
            with rl.Mesh.read(rl.Context(), str(mesh)) as read:
                self.assertGreater(read.info.face_count, 100)
            self.assertEqual(level_set.read_bytes()[:4], b" BDV")
            with self.assertRaises(rl.Invalid):
                server.fetch_surface("foam", 6, mesh, settings="cells = 1")

    def test_the_client_over_the_library_has_the_same_frames(self):
        (self.folder / "block.obj").write_text(BLOCK)
        context = rl.Context()
        with rl.Connection(context, self.address) as server, client.Client(self.address) as other:
            self.assertEqual((server.info.user, server.info.kinds), ("local", "fluid foam"))
            files = {"block.obj": self.folder / "block.obj"}
            status = result_of(rl.job.submit_scene(server, "dam", DAM, files))
            self.assertEqual(status.frames, 5)
            self.assertEqual(server.submit("dam", DAM, files).frames, 5)
            shares = []
            status = server.wait("dam", 4, lambda share, _stage: shares.append(share))
            self.assertEqual((status.state, status.ready, status.text), (rl.ClientState.DONE, 5, ""))
            other.fetch("dam", 4, self.folder / "a")
            server.save("dam", 4, self.folder / "b")
            self.assertEqual((self.folder / "a").read_bytes(), (self.folder / "b").read_bytes())
            with server.fetch("dam", 4) as particles, result_of(rl.job.fetch_frame(server, "dam", 4, half=True)) as half:
                self.assertEqual(particles.info.count, status.particles)
                self.assertLess(abs(particles.points() - half.points()).max(), 1e-4)
            for mesh in (server.fetch_mesh("dam", 4), result_of(rl.job.fetch_frame_mesh(server, "dam", 4))):
                with mesh:
                    self.assertGreater(mesh.info.face_count, 100)
            self.assertEqual(server.steer("dam", 2, "fluid.viscosity = 0.1").ready, 3)
            server.control("dam", "remove")
            server.submit("forced", LONG, is_forced=True)
            count = server.wait("forced", 0).particles
            self.assertEqual(server.poll("forced").state, rl.ClientState.FORCES)
            server.force("forced", 0, [[0, 0, 1]] * count)
            self.assertEqual(server.wait("forced", 1).ready, 2)
            with self.assertRaises(rl.NotFound):
                server.poll("dam")
            with self.assertRaises(rl.Cancelled):
                server.wait("forced", 3000, lambda _share, _stage: False)
            with self.assertRaises(rl.Invalid):
                server.control("forced", "explode")

    def test_connections_are_encrypted_and_certificates_checked(self):
        files = TLS / "server.pem", TLS / "server.key"
        self.server.kill()
        self.server.wait()
        self.begin("127.0.0.1:0", "--tls-cert", files[0], "--tls-key", files[1])
        port = self.address.rpartition(":")[2]
        address = f"tls://localhost:{port}"
        with client.Client(address, authority=TLS / "authority.pem") as server:
            server.submit("dam", LONG.replace("4000", "2"))
            self.assertEqual(server.wait("dam", 2)["state"], "done")
        for wrong, authority in ((address, ""), (address, files[0]), (address, files[1]), (f"tls://127.0.0.1:{port}", TLS / "authority.pem")):
            with self.assertRaises(rl.Invalid):
                client.Client(wrong, authority=authority, patience=0.1)
        with self.assertRaises(rl.FileFailure):
            client.Client(f"localhost:{port}", patience=0.1, timeout=2.0)

    def test_failures_are_exceptions(self):
        with client.Client(self.address) as server:
            with self.assertRaises(rl.NotFound):
                server.status("none")
            with self.assertRaises(rl.Unsupported):
                server.call("no.method")
            with self.assertRaises(rl.Invalid):
                server.submit("wrong", "frames = 1\n[fluid]\nspacing = -1")
            with self.assertRaises(rl.Busy):
                server.submit("long", LONG)
                server.fetch("long", 3999, self.folder / "late")
        with self.assertRaises(rl.Invalid):
            client.Client("nowhere")
        with self.assertRaises(rl.FileFailure):
            client.Client(f"unix:{self.folder}/none", patience=0.1)


if __name__ == "__main__":
    unittest.main()
