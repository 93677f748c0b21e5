/* Relievo: jobs, long calls on a thread of their own.
 *
 * A job is one of the calls below made in the background. When the function that starts it returns, all that the call
 * could refuse at once has been refused, what was passed is no longer needed, and the objects that the call needs for
 * itself are its own: until it has ended, calls that change them, or read what it changes, return RLV_ERROR_BUSY, as
 * with any two threads. Readers of details see what was committed last and do not notice.
 *
 * A job has a thread besides those of its context. Nothing of the host is called on it: texts for the log wait, and are
 * handed over by rlv_job_poll and rlv_job_wait on the thread that calls those. When its last reference is released, a
 * job that still runs is asked to stop, and the release does not wait; wait before the process ends.
 *
 * What a job makes is known when it starts: the kind in RlvJobInfo. Each kind has one function, rlv_job_<noun>(job, &out),
 * with one rule for all. It fails with RLV_ERROR_BUSY while the job runs, with the job's own failure if that failed or was
 * cancelled, and with RLV_ERROR_INVALID if the job makes something else. What it gives is what the call would have given:
 * a handle is a reference of the caller's own, which the caller releases, to the same object every time; a report is
 * copied. Objects outlive their job, and what nobody asked for is released with the job.
 *
 * In a context with host_spawn a job is a task of the host: the function that starts it returns at once, what fails fails
 * as a job, and rlv_job_wait must not be called on the only thread that could run the task. */
#ifndef RELIEVO_JOB_H
#define RELIEVO_JOB_H

#include "relievo/bake.h"
#include "relievo/caster.h"
#include "relievo/client.h"
#include "relievo/crowd.h"
#include "relievo/decal.h"
#include "relievo/document.h"
#include "relievo/fluid.h"
#include "relievo/grid.h"
#include "relievo/imprint.h"
#include "relievo/picture.h"
#include "relievo/procedural.h"
#include "relievo/progressive.h"
#include "relievo/ptex.h"
#include "relievo/repair.h"
#include "relievo/simplify.h"
#include "relievo/tessellate.h"
#include "relievo/tissue.h"

typedef struct RlvJob {
    uint64_t id;
} RlvJob;

typedef enum RlvJobState {
    RLV_JOB_RUNNING = 0,
    RLV_JOB_DONE = 1,
    RLV_JOB_FAILED = 2,
    RLV_JOB_CANCELLED = 3
} RlvJobState;

/* What a job makes, and the function that gives it. */
typedef enum RlvJobKind {
    RLV_JOB_KIND_NONE = 0, /* nothing: a file was written, or steps made; rlv_job_result alone */
    RLV_JOB_KIND_MESH = 1, /* rlv_job_mesh; after rlv_job_simplify also rlv_job_simplify_error, after rlv_job_repair
                              rlv_job_repair_report */
    RLV_JOB_KIND_PROGRESSIVE = 2, /* rlv_job_progressive_mesh */
    RLV_JOB_KIND_GRID = 3, /* rlv_job_grid */
    RLV_JOB_KIND_DECAL = 4, /* rlv_job_decal */
    RLV_JOB_KIND_CROWD_MODEL = 5, /* rlv_job_crowd_model; after rlv_job_crowd_refit also rlv_job_crowd_refit_report */
    RLV_JOB_KIND_TISSUE = 6, /* rlv_job_tissue; after rlv_job_tissue_build also rlv_job_tissue_report */
    RLV_JOB_KIND_PARTICLES = 7, /* rlv_job_particles */
    RLV_JOB_KIND_SURFACE = 8, /* rlv_job_surface */
    RLV_JOB_KIND_CASTER = 9, /* rlv_job_caster */
    RLV_JOB_KIND_PROCEDURAL = 10, /* rlv_job_procedural */
    RLV_JOB_KIND_COLLIDER = 11, /* rlv_job_collider */
    RLV_JOB_KIND_PICTURE = 12, /* rlv_job_picture */
    RLV_JOB_KIND_DOCUMENT = 13, /* rlv_job_document */
    RLV_JOB_KIND_IMPRINT_REPORT = 14, /* rlv_job_imprint_report */
    RLV_JOB_KIND_BAKE_REPORT = 15, /* rlv_job_bake_report */
    RLV_JOB_KIND_PTEX_REPORT = 16, /* rlv_job_ptex_report */
    RLV_JOB_KIND_TRANSFER_REPORT = 17, /* rlv_job_transfer_report */
    RLV_JOB_KIND_FLUID_REPORT = 18, /* rlv_job_fluid_report */
    RLV_JOB_KIND_CLIENT_STATUS = 19, /* rlv_job_client_status */
    RLV_JOB_KIND_BYTES = 20 /* rlv_job_bytes */
} RlvJobKind;

typedef struct RlvJobInfo {
    uint32_t struct_size;
    uint32_t state;            /* RlvJobState */
    RlvResult result;          /* what the call returned; RLV_OK while it runs */
    float fraction;            /* how far it is, 0 to 1 */
    char stage[RLV_NAME_SIZE]; /* what is being done */
    uint32_t kind;             /* RlvJobKind: what it makes, or will have made */
} RlvJobInfo;

#define RLV_JOB_INFO_INIT {sizeof(RlvJobInfo), RLV_JOB_RUNNING, RLV_OK, 0.0f, {0}, RLV_JOB_KIND_NONE}

/* Starts rlv_tessellate_detail, of the last commit of the detail; rlv_job_mesh has the triangles. Stops
 * between pieces of at most a sixty-fourth of the tiles. Fails as rlv_tessellate_detail does, as a job or at once. */
RLV_API RlvResult rlv_job_tessellate(RlvDetail detail, const RlvTessellateOptions *options, RlvJob *out);

/* Edits the detail, and mutates the collider: starts rlv_imprint_sweep; rlv_job_imprint_report has what it did. Cancelled
 * or failed it leaves both as they were. Fails as rlv_imprint_sweep does, as a job or at once, with RLV_ERROR_BUSY if
 * another call is at work on either. */
RLV_API RlvResult rlv_job_sweep(RlvDetail detail, RlvCollider collider, const double *from, const double *to,
                                const RlvImprintSettings *settings, const RlvImprintMoment *moment, RlvJob *out);

/* Edits the detail, and mutates the collider: starts rlv_imprint_sweep_points, as rlv_job_sweep does. Fails as
 * rlv_imprint_sweep_points does, as a job or at once. */
RLV_API RlvResult rlv_job_sweep_points(RlvDetail detail, RlvCollider collider, const double *from, const double *to,
                                       const float *from_points, const float *to_points, size_t count, size_t stride,
                                       const RlvImprintSettings *settings, const RlvImprintMoment *moment, RlvJob *out);

/* Starts rlv_bake_write, of the last commit of the detail; rlv_job_bake_report has what it did. Fails as
 * rlv_bake_write does, as a job or at once. */
RLV_API RlvResult rlv_job_bake(RlvDetail detail, const RlvBakeOptions *options, const char *path, RlvJob *out);

/* Starts rlv_ptex_write, of the last commit of the detail. Fails as rlv_ptex_write does, as a job or at once. */
RLV_API RlvResult rlv_job_ptex_write(RlvDetail detail, uint32_t channel, const char *path, RlvJob *out);

/* Edits the detail: starts rlv_ptex_read; rlv_job_ptex_report has what became of the faces. Fails, and changes nothing, as
 * rlv_ptex_read does, as a job or at once. */
RLV_API RlvResult rlv_job_ptex_read(RlvDetail detail, const char *path, const RlvPtexOptions *options, RlvJob *out);

/* Starts rlv_document_transfer, to a copy of the mesh; rlv_job_transfer_report has what it did. Fails as
 * rlv_document_transfer does, as a job or at once. */
RLV_API RlvResult rlv_job_transfer(RlvContext context, RlvMesh mesh, const char *path, const char *to_path,
                                   const RlvTransferOptions *options, RlvJob *out);

/* Starts rlv_progressive_create, of a copy of the mesh; rlv_job_progressive_mesh has what it builds. Fails as
 * rlv_progressive_create does, as a job or at once. */
RLV_API RlvResult rlv_job_progressive(RlvMesh mesh, const RlvProgressiveOptions *options, RlvJob *out);

/* Starts rlv_simplify_mesh; rlv_job_mesh has the mesh it makes, rlv_job_simplify_error how far that deviates. Fails as
 * rlv_simplify_mesh does, as a job or at once. */
RLV_API RlvResult rlv_job_simplify(RlvMesh mesh, const RlvSimplifyOptions *options, RlvJob *out);

/* Starts rlv_repair_mesh; rlv_job_mesh has the mesh it makes, rlv_job_repair_report what was found and changed. Fails as
 * rlv_repair_mesh does, as a job or at once. */
RLV_API RlvResult rlv_job_repair(RlvMesh mesh, const RlvRepairSettings *settings, RlvJob *out);

/* Starts rlv_isosurface_mesh; rlv_job_mesh has the mesh it makes. Fails as rlv_isosurface_mesh does, as a job or at once. */
RLV_API RlvResult rlv_job_isosurface(RlvIsosurface isosurface, const RlvIsosurfaceMeshOptions *options, RlvJob *out);

/* Starts rlv_grid_read; rlv_job_grid has the grid. Fails as rlv_grid_read does, as a job or at once. */
RLV_API RlvResult rlv_job_grid_read(RlvContext context, const char *path, const char *name, const double *bounds,
                                    RlvJob *out);

/* Starts rlv_grid_from_mesh; rlv_job_grid has the level set it makes. Fails as rlv_grid_from_mesh does, as a job or at
 * once. */
RLV_API RlvResult rlv_job_grid_from_mesh(RlvMesh mesh, const RlvGridSettings *settings, RlvJob *out);

/* Starts rlv_grid_change; rlv_job_grid has the grid it makes. Fails as rlv_grid_change does, as a job or at once. */
RLV_API RlvResult rlv_job_grid_change(RlvGrid grid, uint32_t change, const RlvGridSettings *settings, RlvJob *out);

/* Starts rlv_grid_mesh; rlv_job_mesh has the mesh it makes. Fails as rlv_grid_mesh does, as a job or at once. */
RLV_API RlvResult rlv_job_grid_mesh(RlvGrid grid, const RlvGridSettings *settings, RlvJob *out);

/* Starts rlv_decal_on_mesh; rlv_job_decal has the decal it makes. Fails as rlv_decal_on_mesh does, as a job or at once. */
RLV_API RlvResult rlv_job_decal_on_mesh(RlvMesh mesh, const RlvDecalOptions *options, const RlvDecalPin *pins,
                                        size_t count, size_t stride, RlvJob *out);

/* Starts rlv_decal_on_detail; rlv_job_decal has the decal it makes. Fails as rlv_decal_on_detail does, as a job or at
 * once. */
RLV_API RlvResult rlv_job_decal_on_detail(RlvDetail detail, const RlvDecalOptions *options, const RlvDecalPin *pins,
                                          size_t count, size_t stride, RlvJob *out);

/* Starts rlv_crowd_model_build; rlv_job_crowd_model has the model it makes. Fails as rlv_crowd_model_build does, as a job or
 * at once. */
RLV_API RlvResult rlv_job_crowd(RlvContext context, const char *path, const RlvCrowdClipName *clips, size_t clip_count,
                                const RlvCrowdBuildSettings *settings, RlvJob *out);

/* Starts rlv_crowd_model_refit; rlv_job_crowd_model has the model it makes, rlv_job_crowd_refit_report what it changed. Fails
 * as rlv_crowd_model_refit does, as a job or at once. */
RLV_API RlvResult rlv_job_crowd_refit(RlvCrowdModel model, const char *path, const RlvCrowdClipName *clips,
                                      size_t clip_count, const RlvCrowdBuildSettings *settings, RlvJob *out);

/* Starts rlv_crowd_model_with_blend; rlv_job_crowd_model has the model it makes. Fails as rlv_crowd_model_with_blend does, as
 * a job or at once. */
RLV_API RlvResult rlv_job_crowd_model_with_blend(RlvCrowdModel model, uint32_t blend, RlvJob *out);

/* Mutates the fluid: starts rlv_fluid_advance; rlv_job_fluid_report has what the steps did. Cancelled or failed it leaves
 * the fluid as the last whole step left it. Fails as rlv_fluid_advance does, as a job or at once, with RLV_ERROR_BUSY if
 * another call is at work on the fluid. */
RLV_API RlvResult rlv_job_fluid(RlvFluid fluid, double seconds, RlvJob *out);

/* Starts rlv_tissue_build; rlv_job_tissue has the model it builds, rlv_job_tissue_report what that was built from. Fails as
 * rlv_tissue_build does, as a job or at once. */
RLV_API RlvResult rlv_job_tissue_build(RlvContext context, const RlvTissueDescription *description, RlvJob *out);

/* Mutates the simulation: starts rlv_tissue_simulation_advance. Cancelled it leaves the simulation at the last whole step.
 * Fails as rlv_tissue_simulation_advance does, as a job or at once, with RLV_ERROR_BUSY if another call is at work on the
 * simulation. */
RLV_API RlvResult rlv_job_tissue_advance(RlvTissueSimulation simulation, double seconds, RlvJob *out);

/* Starts rlv_client_submit; rlv_job_client_status has the state of the scene then. Fails as rlv_client_submit does, as a job or
 * at once. */
RLV_API RlvResult rlv_job_client_submit(RlvClient client, const RlvClientScene *scene, RlvJob *out);

/* Starts rlv_client_wait and then rlv_client_fetch; rlv_job_particles has the particles. Fails as these do, as a job or at
 * once. */
RLV_API RlvResult rlv_job_client_fetch(RlvClient client, const char *scene, uint64_t frame, const RlvClientFetch *fetch,
                                       RlvJob *out);

/* Starts rlv_client_wait and then rlv_client_fetch_mesh; rlv_job_mesh has the mesh. Fails as these do, as a job or at
 * once. */
RLV_API RlvResult rlv_job_client_fetch_mesh(RlvClient client, const char *scene, uint64_t frame, const char *settings,
                                            RlvJob *out);

/* Starts rlv_surface_create; rlv_job_surface has the surface. The cage must not be changed until the job has ended. Stops
 * before and after the refinement. Fails as rlv_surface_create does, as a job or at once. */
RLV_API RlvResult rlv_job_surface_create(RlvContext context, RlvMesh cage, const RlvSurfaceOptions *options,
                                         RlvJob *out);

/* Starts rlv_caster_create_mesh; rlv_job_caster has the caster. The mesh must not be changed until the job has ended.
 * Stops before and after the hierarchy is built. Fails as rlv_caster_create_mesh does, as a job or at once. */
RLV_API RlvResult rlv_job_caster_create_mesh(RlvContext context, RlvMesh mesh, RlvJob *out);

/* Starts rlv_caster_create_detail, of the last commit of the detail; rlv_job_caster has the caster. Stops as
 * rlv_job_tessellate and rlv_job_caster_create_mesh do. Fails as rlv_caster_create_detail does, as a job
 * or at once. */
RLV_API RlvResult rlv_job_caster_create_detail(RlvDetail detail, const RlvTessellateOptions *options, RlvJob *out);

/* Starts rlv_caster_create_tessellation; rlv_job_caster has the caster. The tessellation must not be updated until the
 * job has ended. Stops as rlv_job_caster_create_mesh does. Fails as rlv_caster_create_tessellation does, as a job or at
 * once. */
RLV_API RlvResult rlv_job_caster_create_tessellation(RlvTessellation tessellation, RlvJob *out);

/* Starts rlv_procedural_create, of the last commit of the detail; rlv_job_procedural has the primitives. Stops before
 * and after they are made. Fails as rlv_procedural_create does, as a job or at once. */
RLV_API RlvResult rlv_job_procedural_create(RlvDetail detail, const RlvProceduralOptions *options, RlvJob *out);

/* Starts rlv_procedural_create_moving, to the last commit of the detail; otherwise as rlv_job_procedural_create. Fails
 * as rlv_procedural_create_moving does, as a job or at once. */
RLV_API RlvResult rlv_job_procedural_create_moving(RlvProcedural begin, RlvDetail end, RlvJob *out);

/* Starts rlv_collider_create_mesh; rlv_job_collider has the collider. The mesh must not be changed until the job has ended.
 * Stops before and after its triangles are connected. Fails as rlv_collider_create_mesh does, as a job or at once. */
RLV_API RlvResult rlv_job_collider_create_mesh(RlvContext context, RlvMesh mesh, const double *matrix, RlvJob *out);

/* Starts rlv_collider_create_surface; rlv_job_collider has the collider. Stops as
 * rlv_job_tessellate and rlv_job_collider_create_mesh do. Fails as rlv_collider_create_surface does, as a job or at once. */
RLV_API RlvResult rlv_job_collider_create_surface(RlvSurface surface, const RlvTessellateOptions *options,
                                                  const double *matrix, RlvJob *out);

/* Starts rlv_collider_create_detail, of the last commit of the detail; rlv_job_collider has the collider. Stops
 * as rlv_job_collider_create_surface does. Fails as rlv_collider_create_detail does, as a job or at once. */
RLV_API RlvResult rlv_job_collider_create_detail(RlvDetail detail, const RlvTessellateOptions *options, RlvJob *out);

/* Starts rlv_mesh_read; rlv_job_mesh has the mesh. Stops before and after the file is read. Fails as rlv_mesh_read does,
 * as a job or at once. */
RLV_API RlvResult rlv_job_mesh_read(RlvContext context, const char *path, RlvJob *out);

/* Starts rlv_mesh_write. The mesh must not be changed until the job has ended. Stops before the file is written, which
 * then appears whole. Fails as rlv_mesh_write does, as a job or at once. */
RLV_API RlvResult rlv_job_mesh_write(RlvMesh mesh, const char *path, RlvJob *out);

/* Starts rlv_particles_read; rlv_job_particles has the particles. Stops before and after the file is read. Fails as
 * rlv_particles_read does, as a job or at once. */
RLV_API RlvResult rlv_job_particles_read(RlvContext context, const char *path, RlvJob *out);

/* Starts rlv_particles_write. Stops as rlv_job_mesh_write does. Fails as rlv_particles_write does, as a job or at once. */
RLV_API RlvResult rlv_job_particles_write(RlvParticles particles, const char *path, RlvJob *out);

/* Starts rlv_progressive_read; rlv_job_progressive_mesh has the progressive mesh. Stops before and after the file is read.
 * Fails as rlv_progressive_read does, as a job or at once. */
RLV_API RlvResult rlv_job_progressive_read(RlvContext context, const char *path, size_t triangles, RlvJob *out);

/* Starts rlv_progressive_write. Stops as rlv_job_mesh_write does. Fails as rlv_progressive_write does, as a job or at
 * once. */
RLV_API RlvResult rlv_job_progressive_write(RlvProgressive progressive, const char *path, RlvJob *out);

/* Starts rlv_crowd_model_read; rlv_job_crowd_model has the model. Stops before and after the file is read. Fails as
 * rlv_crowd_model_read does, as a job or at once. */
RLV_API RlvResult rlv_job_crowd_model_read(RlvContext context, const char *path, RlvJob *out);

/* Starts rlv_crowd_model_write. Stops as rlv_job_mesh_write does. Fails as rlv_crowd_model_write does, as a job or at
 * once. */
RLV_API RlvResult rlv_job_crowd_model_write(RlvCrowdModel model, const char *path, RlvJob *out);

/* Starts rlv_tissue_read; rlv_job_tissue has the model. Stops before and after the file is read. Fails as rlv_tissue_read
 * does, as a job or at once. */
RLV_API RlvResult rlv_job_tissue_read(RlvContext context, const char *path, RlvJob *out);

/* Starts rlv_tissue_write. Stops as rlv_job_mesh_write does. Fails as rlv_tissue_write does, as a job or at once. */
RLV_API RlvResult rlv_job_tissue_write(RlvTissue tissue, const char *path, RlvJob *out);

/* Starts rlv_grid_write. The grids must not be changed until the job has ended. Stops while the file is written, which
 * appears whole or not at all. Fails as rlv_grid_write does, as a job or at once. */
RLV_API RlvResult rlv_job_grid_write(const RlvGrid *grids, size_t count, const char *path, uint32_t writing, RlvJob *out);

/* Starts rlv_picture_open; rlv_job_picture has the picture. Stops before and after the file is read. Fails as
 * rlv_picture_open does, as a job or at once. */
RLV_API RlvResult rlv_job_picture_open(RlvContext context, const char *path, RlvJob *out);

/* Edits the detail while its layers are gathered: starts rlv_document_create; rlv_job_document has the document. Stops
 * before the file is written. Fails as rlv_document_create does, as a job or at once. */
RLV_API RlvResult rlv_job_document_create(RlvDetail detail, const char *path, uint64_t memory, RlvJob *out);

/* Edits the detail: starts rlv_document_open; rlv_job_document has the document. Stops before the detail takes up the
 * layers, and leaves it as it was then. Fails as rlv_document_open does, as a job or at once. */
RLV_API RlvResult rlv_job_document_open(RlvDetail detail, const char *path, uint64_t memory, RlvJob *out);

/* Mutates the document, and edits its detail while its layers are gathered: starts rlv_document_save. Stops before the
 * file is written. Fails as rlv_document_save does, as a job or at once. */
RLV_API RlvResult rlv_job_document_save(RlvDocument document, const char *path, RlvJob *out);

/* Edits the detail: starts rlv_document_open_bytes, of a copy of the bytes; rlv_job_document has the document. Stops as
 * rlv_job_document_open does. Fails as rlv_document_open_bytes does, as a job or at once. */
RLV_API RlvResult rlv_job_document_open_bytes(RlvDetail detail, const uint8_t *bytes, size_t size, uint64_t memory,
                                              RlvJob *out);

/* Mutates the document, and edits its detail while its layers are gathered: starts rlv_document_save_bytes; rlv_job_bytes
 * has the bytes. Stops before they are made. Fails as rlv_document_save_bytes does, as a job or at once. */
RLV_API RlvResult rlv_job_document_save_bytes(RlvDocument document, RlvJob *out);

/* Starts rlv_document_compact. Stops before the file is read. Fails as rlv_document_compact does, as a job or at once. */
RLV_API RlvResult rlv_job_document_compact(RlvContext context, const char *path, size_t keep, RlvJob *out);

RLV_API RlvResult rlv_job_retain(RlvJob job);
RLV_API RlvResult rlv_job_release(RlvJob job);

/* How far the job is, without waiting; hands over what it logged. out may be NULL. That the job failed is no failure of
 * this call. No failure of its own. */
RLV_API RlvResult rlv_job_poll(RlvJob job, RlvJobInfo *out);

/* Waits until the job has ended, but no longer than seconds; -1 for as long as it takes. Then as rlv_job_poll: state is
 * RLV_JOB_RUNNING if the time was up. Fails if seconds is another number below 0 or not finite. */
RLV_API RlvResult rlv_job_wait(RlvJob job, double seconds, RlvJobInfo *out);

/* Called when a job has ended. */
typedef void (*RlvJobDone)(void *user);

/* Sets what is called once when the job has ended, on the thread that ran it: on the calling thread at once if it has ended
 * already. It may ask for the job, but should not do long work. The last one counts; NULL for none. user must stay valid
 * until the call, or until NULL is set on a job that still runs. No failure of its own. */
RLV_API RlvResult rlv_job_notify(RlvJob job, RlvJobDone callback, void *user);

/* Asks the job to stop, and does not wait. It ends as cancelled when it notices, or as done if it was too late. No
 * failure of its own. */
RLV_API RlvResult rlv_job_cancel(RlvJob job);

/* Returns what the call of the job returned, and makes its failure the last error of this thread. Fails with
 * RLV_ERROR_BUSY while it runs. */
RLV_API RlvResult rlv_job_result(RlvJob job);

/* The mesh that rlv_job_tessellate, rlv_job_simplify, rlv_job_repair, rlv_job_isosurface, rlv_job_grid_mesh,
 * rlv_job_mesh_read or rlv_job_client_fetch_mesh made, the same one every time. Fails as rlv_job_result does, and if the job makes no mesh. */
RLV_API RlvResult rlv_job_mesh(RlvJob job, RlvMesh *out);

/* The largest deviation of the mesh that rlv_job_simplify made. Fails as rlv_job_result does, and if the job was another. */
RLV_API RlvResult rlv_job_simplify_error(RlvJob job, float *out);

/* What rlv_job_repair found and changed. Fails as rlv_job_result does, and if the job was another. */
RLV_API RlvResult rlv_job_repair_report(RlvJob job, RlvRepairReport *out);

/* The progressive mesh that rlv_job_progressive or rlv_job_progressive_read made, the same one every time. Fails as rlv_job_result does, and if the
 * job was another. */
RLV_API RlvResult rlv_job_progressive_mesh(RlvJob job, RlvProgressive *out);

/* The grid that rlv_job_grid_read, rlv_job_grid_from_mesh or rlv_job_grid_change made, the same one every time. Fails as
 * rlv_job_result does, and if the job was another. */
RLV_API RlvResult rlv_job_grid(RlvJob job, RlvGrid *out);

/* The decal that rlv_job_decal_on_mesh or rlv_job_decal_on_detail made, the same one every time. Fails as rlv_job_result
 * does, and if the job was another. */
RLV_API RlvResult rlv_job_decal(RlvJob job, RlvDecal *out);

/* The model that rlv_job_tissue_build or rlv_job_tissue_read made, the same one every time. Fails as rlv_job_result does, and if the job was
 * another. */
RLV_API RlvResult rlv_job_tissue(RlvJob job, RlvTissue *out);

/* What the model of rlv_job_tissue_build was built from. Fails as rlv_job_result does, and if the job was another. */
RLV_API RlvResult rlv_job_tissue_report(RlvJob job, RlvTissueReport *out);

/* The particles that rlv_job_client_fetch or rlv_job_particles_read made, the same ones every time. Fails as rlv_job_result does, and if the job was
 * another. */
RLV_API RlvResult rlv_job_particles(RlvJob job, RlvParticles *out);

/* The state of the scene after rlv_job_client_submit. Fails as rlv_job_result does, and if the job was another. */
RLV_API RlvResult rlv_job_client_status(RlvJob job, RlvClientStatus *out);

/* The surface that rlv_job_surface_create made, the same one every time. Fails as rlv_job_result does, and if the job was
 * another. */
RLV_API RlvResult rlv_job_surface(RlvJob job, RlvSurface *out);

/* The caster that rlv_job_caster_create_mesh, rlv_job_caster_create_detail or rlv_job_caster_create_tessellation made, the
 * same one every time. Fails as rlv_job_result does, and if the job was another. */
RLV_API RlvResult rlv_job_caster(RlvJob job, RlvCaster *out);

/* The primitives that rlv_job_procedural_create or rlv_job_procedural_create_moving made, the same ones every time. Fails
 * as rlv_job_result does, and if the job was another. */
RLV_API RlvResult rlv_job_procedural(RlvJob job, RlvProcedural *out);

/* The collider that rlv_job_collider_create_mesh, rlv_job_collider_create_surface or rlv_job_collider_create_detail made,
 * the same one every time. Fails as rlv_job_result does, and if the job was another. */
RLV_API RlvResult rlv_job_collider(RlvJob job, RlvCollider *out);

/* The picture that rlv_job_picture_open opened, the same one every time. Fails as rlv_job_result does, and if the job was
 * another. */
RLV_API RlvResult rlv_job_picture(RlvJob job, RlvPicture *out);

/* The document that rlv_job_document_create, rlv_job_document_open or rlv_job_document_open_bytes made, the same one every
 * time. Fails as rlv_job_result does, and if the job was another. */
RLV_API RlvResult rlv_job_document(RlvJob job, RlvDocument *out);

/* The bytes that rlv_job_document_save_bytes made, the same ones every time. Fails as rlv_job_result does, and if the job was
 * another. */
RLV_API RlvResult rlv_job_bytes(RlvJob job, RlvBytes *out);

/* The crowd model that rlv_job_crowd, rlv_job_crowd_refit or rlv_job_crowd_model_read made, the same one every time. Fails as
 * rlv_job_result does, and if the job was another. */
RLV_API RlvResult rlv_job_crowd_model(RlvJob job, RlvCrowdModel *out);

/* What rlv_job_crowd_refit changed. Fails as rlv_job_result does, and if the job was another. */
RLV_API RlvResult rlv_job_crowd_refit_report(RlvJob job, RlvCrowdRefitReport *out);

/* What rlv_job_sweep or rlv_job_sweep_points did. Fails as rlv_job_result does, and if the job was another. */
RLV_API RlvResult rlv_job_imprint_report(RlvJob job, RlvImprintReport *out);

/* What rlv_job_bake did. Fails as rlv_job_result does, and if the job was another. */
RLV_API RlvResult rlv_job_bake_report(RlvJob job, RlvBakeReport *out);

/* What the steps of rlv_job_fluid did. Fails as rlv_job_result does, and if the job was another. */
RLV_API RlvResult rlv_job_fluid_report(RlvJob job, RlvFluidReport *out);

/* What became of the faces of a file for rlv_job_ptex_read. Fails as rlv_job_result does, and if the job was another. */
RLV_API RlvResult rlv_job_ptex_report(RlvJob job, RlvPtexReport *out);

/* What rlv_job_transfer did. Fails as rlv_job_result does, and if the job was another. */
RLV_API RlvResult rlv_job_transfer_report(RlvJob job, RlvTransferReport *out);

#endif
