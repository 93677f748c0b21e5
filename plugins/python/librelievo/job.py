"""Jobs: long calls in the background. Nothing of Python runs on their threads: texts for the log of the context come with
`poll` and `wait`."""

from __future__ import annotations

import ctypes
from collections.abc import Callable
from typing import TYPE_CHECKING, Any

from . import abi, library, record
from .array import address, matrix
from .bake import options_of
from .bytes import given, made
from .caster import Caster
from .collider import Collider
from .connection import fetch_of, scene_of
from .crowd import CrowdModel
from .crowd import arguments as crowd_arguments
from .decal import Decal
from .decal import arguments as decal_arguments
from .detail import number_of
from .document import Document, transfer_arguments
from .grid import Grid
from .grid import settings_of as grid_settings
from .grid import writing_of
from .handle import Handle, held, path_bytes, text_bytes
from .hint import FilePath, Settings
from .imprint import Deforming, moment_of, settings_of
from .isosurface import mesh_options
from .mesh import Mesh, simplify_options
from .parameter import address_of
from .particles import Particles
from .picture import Picture
from .procedural import Procedural
from .progress import function_of
from .progressive import Progressive
from .progressive import options_of as progressive_options
from .ptex import options_of as ptex_options
from .repair import report_of, settings_of as repair_settings
from .surface import Surface, surface_options, tessellate_options
from .tissue import Tissue, description_of

if TYPE_CHECKING:
    from .context import Context
    from .detail import Detail
    from .isosurface import Isosurface

# Functions that jobs call when they end, and whether they were called.
_notices: list[list[Any]] = []


class Job(Handle):
    """A call that runs. A job that is released while it runs is cancelled."""

    noun, kind = "job", abi.RlvJob

    def poll(self) -> Any:
        """How far it is: state, result, fraction, stage, and the kind of what it makes."""
        out = record.empty(abi.RlvJobInfo)
        library.call("rlv_job_poll", self.handle, ctypes.byref(out))
        return record.read(out)

    def wait(self, seconds: float | None = None) -> Any:
        """Waits for its end, no longer than that; how far it is then."""
        out = record.empty(abi.RlvJobInfo)
        library.call("rlv_job_wait", self.handle, -1.0 if seconds is None else seconds, ctypes.byref(out))
        return record.read(out)

    def notify(self, done: Callable[[], Any] | None) -> None:
        """Has `done()` called once when it has ended, on its thread, or here at once if it has ended; None for nothing."""
        # The library may call it when this object is gone, so it lives until a later call finds that it was made.
        _notices[:] = [notice for notice in _notices if not notice[1]]
        notice: list[Any] = [None, False]

        def run(_user: Any) -> None:
            try:
                done()
            finally:
                notice[1] = True

        function_of(done, "done")
        notice[0] = abi.RlvJobDone() if done is None else abi.RlvJobDone(run)
        library.call("rlv_job_notify", self.handle, notice[0], None)
        if done is not None:
            _notices.append(notice)

    def cancel(self) -> None:
        """Asks it to stop."""
        library.call("rlv_job_cancel", self.handle)

    def result(self) -> Any:
        """What the call returns; raises what it raises, and Busy while it runs."""
        library.call("rlv_job_result", self.handle)
        return self._fetch(self)


def _report(function: str, struct: Any) -> Any:
    def fetch(job: Any) -> Any:
        report = record.empty(struct)
        library.call(function, held(job, "job"), ctypes.byref(report))
        return record.read(report)

    return fetch


def _started(fetch: Any, function: str, *arguments: Any) -> Any:
    job = Job.of(function, *arguments)
    job._fetch = fetch
    return job


def tessellate(detail: Any, **options: Any) -> Any:
    """Starts `Detail.tessellate`; the result is the mesh."""
    fetch = lambda job: Mesh.of("rlv_job_mesh", held(job, "job"))
    return _started(fetch, "rlv_job_tessellate", held(detail, "detail"), tessellate_options(options))


def sweep(
    detail: Detail,
    collider: Collider,
    before: Any,
    after: Any,
    settings: Settings | None = None,
    moment: Settings | None = None,
) -> Any:
    """Starts `imprint.sweep`; the result is its report."""
    before, after = matrix(before), matrix(after)
    arguments = (address(before), address(after), settings_of(settings), moment_of(moment))
    fetch = _report("rlv_job_imprint_report", abi.RlvImprintReport)
    return _started(fetch, "rlv_job_sweep", held(detail, "detail"), held(collider, "collider"), *arguments)


def sweep_points(
    detail: Detail,
    collider: Collider,
    before: Any,
    after: Any,
    settings: Settings | None = None,
    moment: Settings | None = None,
) -> Any:
    """Starts `imprint.sweep_points`; the result is its report."""
    path = Deforming(before, after)
    fetch = _report("rlv_job_imprint_report", abi.RlvImprintReport)
    arguments = (*path.arguments(), settings_of(settings), moment_of(moment))
    return _started(fetch, "rlv_job_sweep_points", held(detail, "detail"), held(collider, "collider"), *arguments)


def decal_on_mesh(mesh: Any, pins: Any, size: Any, outline: Any = None, **options: Any) -> Any:
    """Starts `Decal.on_mesh`; the result is the decal."""
    return _decal("rlv_job_decal_on_mesh", mesh, pins, size, outline, options)


def decal_on_detail(detail: Any, pins: Any, size: Any, outline: Any = None, **options: Any) -> Any:
    """Starts `Decal.on_detail`; the result is the decal."""
    return _decal("rlv_job_decal_on_detail", detail, pins, size, outline, options)


def _decal(function: str, ground: Any, pins: Any, size: Any, outline: Any, options: Any) -> Any:
    given, kept = decal_arguments(pins, size, outline, **options)
    made = _started(lambda job: Decal.of("rlv_job_decal", held(job, "job")), function, held(ground, "ground"), *given)
    del kept
    return made


def write(detail: Detail, path: FilePath, **options: Any) -> Any:
    """Starts `bake.write`; the result is its report."""
    fetch = _report("rlv_job_bake_report", abi.RlvBakeReport)
    return _started(fetch, "rlv_job_bake", held(detail, "detail"), options_of(options), path_bytes(path))


def write_ptex(detail: Any, channel: Any, path: Any) -> Any:
    """Starts `ptex.write`; there is no result."""
    return _started(lambda job: None, "rlv_job_ptex_write", held(detail, "detail"), number_of(channel), path_bytes(path))


def read_ptex(detail: Any, path: Any, **options: Any) -> Any:
    """Starts `ptex.read`; the result is its report."""
    fetch = _report("rlv_job_ptex_report", abi.RlvPtexReport)
    return _started(fetch, "rlv_job_ptex_read", held(detail, "detail"), path_bytes(path), ptex_options(options))


def build(mesh: Any, base_triangles: Any = None, locked: Any = None, weights: Any = None, left_out: Any = None) -> Any:
    """Starts `Progressive(mesh)`; the result is the progressive mesh."""
    options, kept = progressive_options(base_triangles, locked, weights, left_out)
    fetch = lambda job: Progressive.of("rlv_job_progressive_mesh", held(job, "job"))
    made = _started(fetch, "rlv_job_progressive", held(mesh, "mesh"), ctypes.byref(options))
    del kept
    return made


def simplify(
    mesh: Any,
    triangles: int = 0,
    error: Any = None,
    weights: Any = None,
    left_out: Any = (),
    locked: Any = None,
    factors: Any = None,
    bound: Any = None,
    is_border_locked: bool = False,
) -> Any:
    """Starts `Mesh.simplify`; the result is the mesh, and how far it deviates."""

    def fetch(job: Any) -> tuple[Any, ...]:
        deviation = ctypes.c_float()
        library.call("rlv_job_simplify_error", held(job, "job"), address_of(deviation))
        return Mesh.of("rlv_job_mesh", held(job, "job")), deviation.value

    options, kept = simplify_options(triangles, error, weights, left_out, locked, factors, bound, is_border_locked)
    made = _started(fetch, "rlv_job_simplify", held(mesh, "mesh"), ctypes.byref(options))
    del kept
    return made


def repair(mesh: Any, **settings: Any) -> Any:
    """Starts `repair.mesh`; the result is the repaired mesh and the report."""

    def fetch(job: Any) -> tuple[Any, ...]:
        report = record.empty(abi.RlvRepairReport)
        library.call("rlv_job_repair_report", held(job, "job"), ctypes.byref(report))
        return Mesh.of("rlv_job_mesh", held(job, "job")), report_of(report)

    return _started(fetch, "rlv_job_repair", held(mesh, "mesh"), repair_settings(settings))


def build_tissue(context: Any, cell: Any, materials: Any, volumes: Any, **description: Any) -> Any:
    """Starts `Tissue(context)`; the result is the model."""
    given, kept = description_of(cell, materials, volumes, **description)

    def fetch(job: Any) -> Any:
        made = Tissue.of("rlv_job_tissue", held(job, "job"))
        made.report = _report("rlv_job_tissue_report", abi.RlvTissueReport)(job)
        return made

    made = _started(fetch, "rlv_job_tissue_build", held(context, "context"), ctypes.byref(given))
    del kept
    return made


def crowd_model(context: Any, path: Any, clips: Any = None, **settings: Any) -> Any:
    """Starts `CrowdModel.build`; the result is the model."""
    given, kept = crowd_arguments(path, clips, settings)
    made = _started(
        lambda job: CrowdModel.of("rlv_job_crowd_model", held(job, "job")), "rlv_job_crowd", held(context, "context"), *given
    )
    del kept
    return made


def refit_crowd_model(model: Any, path: Any, clips: Any = None, **settings: Any) -> Any:
    """Starts `CrowdModel.refit`; the result is the model and the report."""
    given, kept = crowd_arguments(path, clips, settings)
    report = _report("rlv_job_crowd_refit_report", abi.RlvCrowdRefitReport)
    fetch = lambda job: (CrowdModel.of("rlv_job_crowd_model", held(job, "job")), report(job))
    made = _started(fetch, "rlv_job_crowd_refit", held(model, "model"), *given)
    del kept
    return made


def blend_crowd_model(model: Any, blend: Any) -> Any:
    """Starts `CrowdModel.with_blend`; the result is the model."""
    number = record.named(abi.RlvCrowdBlend, blend, "blend")
    fetch = lambda job: CrowdModel.of("rlv_job_crowd_model", held(job, "job"))
    return _started(fetch, "rlv_job_crowd_model_with_blend", held(model, "model"), number)


def advance_tissue(simulation: Any, seconds: Any) -> Any:
    """Starts `TissueSimulation.advance`; there is no result."""
    return _started(lambda job: None, "rlv_job_tissue_advance", held(simulation, "simulation"), seconds)


def advance(fluid: Any, seconds: Any) -> Any:
    """Starts `Fluid.advance`; the result is its report."""
    fetch = _report("rlv_job_fluid_report", abi.RlvFluidReport)
    return _started(fetch, "rlv_job_fluid", held(fluid, "fluid"), seconds)


def mesh(isosurface: Isosurface, channels: Any = None, **options: Any) -> Any:
    """Starts `Isosurface.mesh`; the result is the mesh."""
    options, kept = mesh_options(channels, **options)
    fetch = lambda job: Mesh.of("rlv_job_mesh", held(job, "job"))
    made = _started(fetch, "rlv_job_isosurface", held(isosurface, "isosurface"), ctypes.byref(options))
    del kept
    return made


def transfer(context: Context, path: FilePath, to: Any, to_path: FilePath, source: Any = None, reach: float = 0.0) -> Any:
    """Starts `document.transfer`; the result is its report."""
    fetch = _report("rlv_job_transfer_report", abi.RlvTransferReport)
    arguments = transfer_arguments(path, to, to_path, source, reach)
    return _started(fetch, "rlv_job_transfer", held(context, "context"), *arguments)


def _grid(job: Any) -> Grid:
    return Grid.of("rlv_job_grid", held(job, "job"))


def read_grid(context: Any, path: Any, name: Any = None) -> Any:
    """Starts `Grid.read`; the result is the grid."""
    return _started(_grid, "rlv_job_grid_read", held(context, "context"), path_bytes(path), text_bytes(name, "name"), None)


def grid_from_mesh(mesh: Any, **settings: Any) -> Any:
    """Starts `Grid.from_mesh`; the result is the grid."""
    return _started(_grid, "rlv_job_grid_from_mesh", held(mesh, "mesh"), grid_settings(settings))


def change_grid(grid: Any, change: Any, **settings: Any) -> Any:
    """Starts `Grid.change`; the result is the grid."""
    number = record.named(abi.RlvGridChange, change, "change")
    return _started(_grid, "rlv_job_grid_change", held(grid, "grid"), number, grid_settings(settings))


def mesh_grid(grid: Any, **settings: Any) -> Any:
    """Starts `Grid.mesh`; the result is the mesh."""
    fetch = lambda job: Mesh.of("rlv_job_mesh", held(job, "job"))
    return _started(fetch, "rlv_job_grid_mesh", held(grid, "grid"), grid_settings(settings))


def create_surface(context: Any, cage: Any, **options: Any) -> Any:
    """Starts `Surface(context, cage)`; the result is the surface."""
    fetch = lambda job: Surface.of("rlv_job_surface", held(job, "job"))
    given = surface_options(options)
    return _started(fetch, "rlv_job_surface_create", held(context, "context"), held(cage, "cage"), given)


def _caster(job: Any) -> Caster:
    return Caster.of("rlv_job_caster", held(job, "job"))


def caster_of_mesh(context: Any, mesh: Any) -> Any:
    """Starts `Caster(context, mesh)`; the result is the caster."""
    return _started(_caster, "rlv_job_caster_create_mesh", held(context, "context"), held(mesh, "mesh"))


def caster_of_detail(detail: Any, **options: Any) -> Any:
    """Starts `Caster.of_detail`; the result is the caster."""
    return _started(_caster, "rlv_job_caster_create_detail", held(detail, "detail"), tessellate_options(options))


def caster_of_tessellation(tessellation: Any) -> Any:
    """Starts `Caster.of_tessellation`; the result is the caster."""
    return _started(_caster, "rlv_job_caster_create_tessellation", held(tessellation, "tessellation"))


def _procedural(job: Any) -> Procedural:
    return Procedural.of("rlv_job_procedural", held(job, "job"))


def create_procedural(detail: Any, **options: Any) -> Any:
    """Starts `Procedural(detail)`; the result is the procedural."""
    given = ctypes.byref(record.fill(abi.RlvProceduralOptions, options))
    return _started(_procedural, "rlv_job_procedural_create", held(detail, "detail"), given)


def create_moving_procedural(begin: Any, end: Any) -> Any:
    """Starts `Procedural.moving`; the result is the procedural."""
    return _started(_procedural, "rlv_job_procedural_create_moving", held(begin, "begin"), held(end, "end"))


def _collider(job: Any) -> Collider:
    return Collider.of("rlv_job_collider", held(job, "job"))


def collider_of_mesh(context: Any, mesh: Any, matrix_world: Any = None) -> Any:
    """Starts `Collider(context, mesh)`; the result is the collider."""
    placed = matrix(matrix_world)
    return _started(
        _collider, "rlv_job_collider_create_mesh", held(context, "context"), held(mesh, "mesh"), address(placed)
    )


def collider_of_surface(surface: Any, matrix_world: Any = None, **options: Any) -> Any:
    """Starts `Collider.of_surface`; the result is the collider."""
    placed, given = matrix(matrix_world), tessellate_options(options)
    return _started(_collider, "rlv_job_collider_create_surface", held(surface, "surface"), given, address(placed))


def collider_of_detail(detail: Any, **options: Any) -> Any:
    """Starts `Collider.of_detail`; the result is the collider."""
    return _started(_collider, "rlv_job_collider_create_detail", held(detail, "detail"), tessellate_options(options))


def read_mesh(context: Any, path: Any) -> Any:
    """Starts `Mesh.read`; the result is the mesh."""
    fetch = lambda job: Mesh.of("rlv_job_mesh", held(job, "job"))
    return _started(fetch, "rlv_job_mesh_read", held(context, "context"), path_bytes(path))


def write_mesh(mesh: Any, path: Any) -> Any:
    """Starts `Mesh.write`; there is no result."""
    return _started(lambda job: None, "rlv_job_mesh_write", held(mesh, "mesh"), path_bytes(path))


def read_particles(context: Any, path: Any) -> Any:
    """Starts `Particles.read`; the result is the particles."""
    fetch = lambda job: Particles.of("rlv_job_particles", held(job, "job"))
    return _started(fetch, "rlv_job_particles_read", held(context, "context"), path_bytes(path))


def write_particles(particles: Any, path: Any) -> Any:
    """Starts `Particles.write`; there is no result."""
    return _started(lambda job: None, "rlv_job_particles_write", held(particles, "particles"), path_bytes(path))


def read_progressive(context: Any, path: Any, triangles: int | None = None) -> Any:
    """Starts `Progressive.read`; the result is the progressive mesh."""
    fetch = lambda job: Progressive.of("rlv_job_progressive_mesh", held(job, "job"))
    most = ctypes.c_size_t(-1).value if triangles is None else triangles
    return _started(fetch, "rlv_job_progressive_read", held(context, "context"), path_bytes(path), most)


def write_progressive(progressive: Any, path: Any) -> Any:
    """Starts `Progressive.write`; there is no result."""
    return _started(lambda job: None, "rlv_job_progressive_write", held(progressive, "progressive"), path_bytes(path))


def read_crowd_model(context: Any, path: Any) -> Any:
    """Starts `CrowdModel.read`; the result is the model."""
    fetch = lambda job: CrowdModel.of("rlv_job_crowd_model", held(job, "job"))
    return _started(fetch, "rlv_job_crowd_model_read", held(context, "context"), path_bytes(path))


def write_crowd_model(model: Any, path: Any) -> Any:
    """Starts `CrowdModel.write`; there is no result."""
    return _started(lambda job: None, "rlv_job_crowd_model_write", held(model, "model"), path_bytes(path))


def read_tissue(context: Any, path: Any) -> Any:
    """Starts `Tissue.read`; the result is the model."""
    fetch = lambda job: Tissue.of("rlv_job_tissue", held(job, "job"))
    return _started(fetch, "rlv_job_tissue_read", held(context, "context"), path_bytes(path))


def write_tissue(tissue: Any, path: Any) -> Any:
    """Starts `Tissue.write`; there is no result."""
    return _started(lambda job: None, "rlv_job_tissue_write", held(tissue, "tissue"), path_bytes(path))


def write_grids(path: Any, grids: Any, pack: str | None = "blosc", half: bool = False, stream: bool = False) -> Any:
    """Starts `grid.write`; there is no result."""
    handles, count, writing = writing_of(grids, pack, half, stream)
    return _started(lambda job: None, "rlv_job_grid_write", handles, count, path_bytes(path), writing)


def open_picture(context: Any, path: Any) -> Any:
    """Starts `Picture(context, path)`; the result is the picture."""
    fetch = lambda job: Picture.of("rlv_job_picture", held(job, "job"))
    return _started(fetch, "rlv_job_picture_open", held(context, "context"), path_bytes(path))


def _document(job: Any) -> Document:
    return Document.of("rlv_job_document", held(job, "job"))


def create_document(detail: Any, path: Any, memory: int = 0) -> Any:
    """Starts `Document(detail, path)`; the result is the document."""
    return _started(_document, "rlv_job_document_create", held(detail, "detail"), path_bytes(path), memory)


def open_document(detail: Any, path: Any, memory: int = 0) -> Any:
    """Starts `Document.open`; the result is the document."""
    return _started(_document, "rlv_job_document_open", held(detail, "detail"), path_bytes(path), memory)


def save_document(document: Any, path: Any) -> Any:
    """Starts `Document.save`; there is no result."""
    return _started(lambda job: None, "rlv_job_document_save", held(document, "document"), path_bytes(path))


def open_document_bytes(detail: Any, data: Any, memory: int = 0) -> Any:
    """Starts `Document.open_bytes`, of a copy of the bytes; the result is the document."""
    address, size, _kept = given(data)
    return _started(_document, "rlv_job_document_open_bytes", held(detail, "detail"), address, size, memory)


def save_document_bytes(document: Any) -> Any:
    """Starts `Document.save_bytes`; the result is the bytes."""
    fetch = lambda job: made("rlv_job_bytes", held(job, "job"))
    return _started(fetch, "rlv_job_document_save_bytes", held(document, "document"))


def compact_document(context: Any, path: Any, keep: int = 0) -> Any:
    """Starts `document.compact`; there is no result."""
    return _started(lambda job: None, "rlv_job_document_compact", held(context, "context"), path_bytes(path), keep)


def submit_scene(
    connection: Any, name: str, description: Any, files: Any = None, kind: str = "fluid", is_forced: bool = False
) -> Any:
    """Starts `Connection.submit`; the result is the status of the scene."""
    scene, kept = scene_of(name, description, files, kind, is_forced)
    fetch = _report("rlv_job_client_status", abi.RlvClientStatus)
    made = _started(fetch, "rlv_job_client_submit", held(connection, "connection"), ctypes.byref(scene))
    del kept
    return made


def fetch_frame(
    connection: Any,
    scene: Any,
    frame: Any,
    particles: str = "all",
    channels: Any = None,
    half: bool = False,
    plain: bool = False,
) -> Any:
    """Starts `Connection.wait` and `fetch`; the result is the particles."""
    how = fetch_of(particles, channels, half, plain)
    fetch = lambda job: Particles.of("rlv_job_particles", held(job, "job"))
    return _started(fetch, "rlv_job_client_fetch", held(connection, "connection"), text_bytes(scene, "scene"), frame, ctypes.byref(how))


def fetch_frame_mesh(connection: Any, scene: Any, frame: Any, settings: str = "") -> Any:
    """Starts `Connection.wait` and `fetch_mesh`; the result is the mesh."""
    fetch = lambda job: Mesh.of("rlv_job_mesh", held(job, "job"))
    arguments = (text_bytes(scene, "scene"), frame, text_bytes(settings, "settings"))
    return _started(fetch, "rlv_job_client_fetch_mesh", held(connection, "connection"), *arguments)
