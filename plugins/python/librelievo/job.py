"""Jobs: long calls in the background. Nothing of Python runs on their threads: texts for the log of the context come with
`poll` and `wait`."""

import ctypes

from . import abi, library, record
from .array import address, matrix
from .bake import options_of
from .connection import fetch_of, scene_of
from .crowd import CrowdModel
from .crowd import arguments as crowd_arguments
from .decal import Decal
from .decal import arguments as decal_arguments
from .detail import number_of
from .document import transfer_arguments
from .grid import Grid
from .grid import settings_of as grid_settings
from .handle import Handle, held, path_bytes, text_bytes
from .imprint import Deforming, moment_of, settings_of
from .isosurface import mesh_options
from .mesh import Mesh, simplify_options
from .parameter import address_of
from .particles import Particles
from .progressive import Progressive
from .progressive import options_of as progressive_options
from .ptex import options_of as ptex_options
from .repair import report_of, settings_of as repair_settings
from .surface import tessellate_options
from .tissue import Tissue, description_of


class Job(Handle):
    """A call that runs. One that is let go of while it runs is cancelled."""

    noun, kind = "job", abi.RlvJob

    def poll(self):
        """How far it is: state, result, fraction, stage."""
        out = record.empty(abi.RlvJobInfo)
        library.call("rlv_job_poll", self.handle, ctypes.byref(out))
        return record.read(out)

    def wait(self, seconds=None):
        """Waits for its end, no longer than that; how far it is then."""
        out = record.empty(abi.RlvJobInfo)
        library.call("rlv_job_wait", self.handle, -1.0 if seconds is None else seconds, ctypes.byref(out))
        return record.read(out)

    def cancel(self):
        """Asks it to stop."""
        library.call("rlv_job_cancel", self.handle)

    def result(self):
        """What the call returns; raises what it raises, and Busy while it runs."""
        library.call("rlv_job_result", self.handle)
        return self._fetch(self)


def _report(function, struct):
    def fetch(job):
        report = record.empty(struct)
        library.call(function, held(job, "job"), ctypes.byref(report))
        return record.read(report)

    return fetch


def _started(fetch, function, *arguments):
    job = Job.of(function, *arguments)
    job._fetch = fetch
    return job


def tessellate(detail, **options):
    """Starts `Detail.tessellate`; the result is the mesh."""
    fetch = lambda job: Mesh.of("rlv_job_mesh", held(job, "job"))
    return _started(fetch, "rlv_job_tessellate", held(detail, "detail"), tessellate_options(options))


def sweep(detail, collider, before, after, settings=None, moment=None):
    """Starts `imprint.sweep`; the result is its report."""
    before, after = matrix(before), matrix(after)
    arguments = (address(before), address(after), settings_of(settings), moment_of(moment))
    fetch = _report("rlv_job_imprint_report", abi.RlvImprintReport)
    return _started(fetch, "rlv_job_sweep", held(detail, "detail"), held(collider, "collider"), *arguments)


def sweep_points(detail, collider, before, after, settings=None, moment=None):
    """Starts `imprint.sweep_points`; the result is its report."""
    path = Deforming(before, after)
    fetch = _report("rlv_job_imprint_report", abi.RlvImprintReport)
    arguments = (*path.arguments(), settings_of(settings), moment_of(moment))
    return _started(fetch, "rlv_job_sweep_points", held(detail, "detail"), held(collider, "collider"), *arguments)


def decal_on_mesh(mesh, pins, size, outline=None, **options):
    """Starts `Decal.on_mesh`; the result is the decal."""
    return _decal("rlv_job_decal_on_mesh", mesh, pins, size, outline, options)


def decal_on_detail(detail, pins, size, outline=None, **options):
    """Starts `Decal.on_detail`; the result is the decal."""
    return _decal("rlv_job_decal_on_detail", detail, pins, size, outline, options)


def _decal(function, ground, pins, size, outline, options):
    given, kept = decal_arguments(pins, size, outline, **options)
    made = _started(lambda job: Decal.of("rlv_job_decal", held(job, "job")), function, held(ground, "ground"), *given)
    del kept
    return made


def write(detail, path, **options):
    """Starts `bake.write`; the result is its report."""
    fetch = _report("rlv_job_bake_report", abi.RlvBakeReport)
    return _started(fetch, "rlv_job_bake", held(detail, "detail"), options_of(options), path_bytes(path))


def write_ptex(detail, channel, path):
    """Starts `ptex.write`; there is no result."""
    return _started(lambda job: None, "rlv_job_ptex_write", held(detail, "detail"), number_of(channel), path_bytes(path))


def read_ptex(detail, path, **options):
    """Starts `ptex.read`; the result is its report."""
    fetch = _report("rlv_job_ptex_report", abi.RlvPtexReport)
    return _started(fetch, "rlv_job_ptex_read", held(detail, "detail"), path_bytes(path), ptex_options(options))


def build(mesh, base_triangles=None, locked=None, weights=None, left_out=None):
    """Starts `Progressive(mesh)`; the result is the progressive mesh."""
    options, kept = progressive_options(base_triangles, locked, weights, left_out)
    fetch = lambda job: Progressive.of("rlv_job_progressive_mesh", held(job, "job"))
    made = _started(fetch, "rlv_job_progressive", held(mesh, "mesh"), ctypes.byref(options))
    del kept
    return made


def simplify(mesh, **options):
    """Starts `Mesh.simplify`; the result is the mesh, and how far it deviates."""

    def fetch(job):
        deviation = ctypes.c_float()
        library.call("rlv_job_simplify_error", held(job, "job"), address_of(deviation))
        return Mesh.of("rlv_job_mesh", held(job, "job")), deviation.value

    options, kept = simplify_options(**options)
    made = _started(fetch, "rlv_job_simplify", held(mesh, "mesh"), ctypes.byref(options))
    del kept
    return made


def repair(mesh, **settings):
    """Starts `repair.mesh`; the result is the repaired mesh and the report."""

    def fetch(job):
        report = record.empty(abi.RlvRepairReport)
        library.call("rlv_job_repair_report", held(job, "job"), ctypes.byref(report))
        return Mesh.of("rlv_job_mesh", held(job, "job")), report_of(report)

    return _started(fetch, "rlv_job_repair", held(mesh, "mesh"), repair_settings(settings))


def build_tissue(context, cell, materials, volumes, **description):
    """Starts `Tissue(context)`; the result is the model."""
    given, kept = description_of(cell, materials, volumes, **description)

    def fetch(job):
        made = Tissue.of("rlv_job_tissue", held(job, "job"))
        made.report = _report("rlv_job_tissue_report", abi.RlvTissueReport)(job)
        return made

    made = _started(fetch, "rlv_job_tissue_build", held(context, "context"), ctypes.byref(given))
    del kept
    return made


def crowd_model(context, path, clips=None, **settings):
    """Starts `CrowdModel.build`; the result is the model."""
    given, kept = crowd_arguments(path, clips, settings)
    made = _started(lambda job: CrowdModel.of("rlv_job_crowd_model", held(job, "job")), "rlv_job_crowd", held(context, "context"), *given)
    del kept
    return made


def advance_tissue(simulation, seconds):
    """Starts `TissueSimulation.advance`; there is no result."""
    return _started(lambda job: None, "rlv_job_tissue_advance", held(simulation, "simulation"), seconds)


def advance(fluid, seconds):
    """Starts `Fluid.advance`; the result is its report."""
    fetch = _report("rlv_job_fluid_report", abi.RlvFluidReport)
    return _started(fetch, "rlv_job_fluid", held(fluid, "fluid"), seconds)


def mesh(isosurface, channels=None, **options):
    """Starts `Isosurface.mesh`; the result is the mesh."""
    options, kept = mesh_options(channels, **options)
    fetch = lambda job: Mesh.of("rlv_job_mesh", held(job, "job"))
    made = _started(fetch, "rlv_job_isosurface", held(isosurface, "isosurface"), ctypes.byref(options))
    del kept
    return made


def transfer(context, path, to, to_path, source=None, reach=0.0):
    """Starts `document.transfer`; the result is its report."""
    fetch = _report("rlv_job_transfer_report", abi.RlvTransferReport)
    arguments = transfer_arguments(path, to, to_path, source, reach)
    return _started(fetch, "rlv_job_transfer", held(context, "context"), *arguments)


def _grid(job):
    return Grid.of("rlv_job_grid", held(job, "job"))


def read_grid(context, path, name=None):
    """Starts `Grid.read`; the result is the grid."""
    return _started(_grid, "rlv_job_grid_read", held(context, "context"), path_bytes(path), text_bytes(name), None)


def grid_from_mesh(mesh, **settings):
    """Starts `Grid.from_mesh`; the result is the grid."""
    return _started(_grid, "rlv_job_grid_from_mesh", held(mesh, "mesh"), grid_settings(settings))


def change_grid(grid, change, **settings):
    """Starts `Grid.change`; the result is the grid."""
    number = record.named(abi.RlvGridChange, change, "change")
    return _started(_grid, "rlv_job_grid_change", held(grid, "grid"), number, grid_settings(settings))


def mesh_grid(grid, **settings):
    """Starts `Grid.mesh`; the result is the mesh."""
    fetch = lambda job: Mesh.of("rlv_job_mesh", held(job, "job"))
    return _started(fetch, "rlv_job_grid_mesh", held(grid, "grid"), grid_settings(settings))


def submit_scene(connection, name, description, files=None, kind="fluid", is_forced=False):
    """Starts `Connection.submit`; the result is the status of the scene."""
    scene, kept = scene_of(name, description, files, kind, is_forced)
    fetch = _report("rlv_job_client_status", abi.RlvClientStatus)
    made = _started(fetch, "rlv_job_client_submit", held(connection, "connection"), ctypes.byref(scene))
    del kept
    return made


def fetch_frame(connection, scene, frame, particles="all", channels=None, half=False, plain=False):
    """Starts `Connection.wait` and `fetch`; the result is the particles."""
    how = fetch_of(particles, channels, half, plain)
    fetch = lambda job: Particles.of("rlv_job_particles", held(job, "job"))
    return _started(fetch, "rlv_job_client_fetch", held(connection, "connection"), text_bytes(scene), frame, ctypes.byref(how))


def fetch_frame_mesh(connection, scene, frame, settings=""):
    """Starts `Connection.wait` and `fetch_mesh`; the result is the mesh."""
    fetch = lambda job: Mesh.of("rlv_job_mesh", held(job, "job"))
    arguments = (text_bytes(scene), frame, text_bytes(settings))
    return _started(fetch, "rlv_job_client_fetch_mesh", held(connection, "connection"), *arguments)
