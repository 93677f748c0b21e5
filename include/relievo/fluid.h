/* Relievo: fluids of particles (smoothed particle hydrodynamics).
 *
 * A fluid is simulated in steps by pressures that are corrected until nothing is too dense, in metres, seconds and
 * kilograms. A particle has a number, which it keeps and no other gets; arrays of all particles are in the
 * order of rising numbers, so that a particle keeps its place until one before it is removed. Results do not depend on the
 * number of threads. A fluid takes some 700 bytes a particle. */
#ifndef RELIEVO_FLUID_H
#define RELIEVO_FLUID_H

#include "relievo/bytes.h"
#include "relievo/particles.h"

typedef struct RlvFluid {
    uint64_t id;
} RlvFluid;

typedef enum RlvFluidKernels {
    RLV_FLUID_WENDLAND = 0, /* Wendland's C2 kernel for density and pressure (Wendland 1995) */
    RLV_FLUID_MUELLER = 1   /* poly6 and the spiky kernel (Mueller, Charypar, Gross 2003); needs more viscosity to rest */
} RlvFluidKernels;

typedef enum RlvFluidSolver {
    RLV_FLUID_PCISPH = 0, /* by prediction and correction of densities (Solenthaler, Pajarola 2009) */
    RLV_FLUID_DFSPH = 1   /* velocities are kept from compressing the fluid too (Bender, Koschier 2017): fewer steps */
} RlvFluidSolver;

typedef enum RlvFluidSteps {
    RLV_FLUID_COURANT = 0, /* as long as nothing goes farther than a part of the spacing, and shorter where pressures need it */
    RLV_FLUID_FIXED = 1    /* all of the same length, converged or not */
} RlvFluidSteps;

typedef enum RlvFluidContact {
    RLV_FLUID_SLIP = 0,    /* a particle that meets a triangle keeps what of its velocity is along it */
    RLV_FLUID_STOP = 1,    /* it stays where it met it */
    RLV_FLUID_FRICTION = 2 /* it loses so much of what is along as friction times what it loses across (Coulomb) */
} RlvFluidContact;

/* The number that walls have where a collider is asked for. */
#define RLV_FLUID_WALLS 0xffffffffu

typedef enum RlvFluidForceKind {
    RLV_FLUID_GRAVITY = 0,   /* vector everywhere, m/s2 */
    RLV_FLUID_WIND = 1,      /* air of the velocity vector takes particles along, by strength of the difference in a second */
    RLV_FLUID_DRAG = 2,      /* particles lose strength of their velocity in a second, and rate of it a metre */
    RLV_FLUID_VORTEX = 3,    /* pushes around the axis vector through place: strength at radius, less farther and nearer */
    RLV_FLUID_ATTRACTOR = 4, /* pulls to place with strength within radius, by the inverse square beyond; less than 0 pushes */
    RLV_FLUID_TURBULENCE = 5 /* eddies without sources of about strength, as large as radius, that change at rate */
} RlvFluidForceKind;

typedef enum RlvFluidEmitterShape {
    RLV_FLUID_DISC = 0,      /* about center with a radius; particles go along the normal u */
    RLV_FLUID_RECTANGLE = 1, /* about center by half its sides u and v; particles go along u x v */
    RLV_FLUID_SURFACE = 2    /* a mesh, from which particles go along its normals */
} RlvFluidEmitterShape;

typedef struct RlvFluidOptions {
    uint32_t struct_size;
    uint32_t kernels;  /* RlvFluidKernels */
    float spacing;     /* distance between particles at rest, metres; 1e-9 to 1e9. Kernels reach twice as far */
    float density;     /* at rest, kg/m3; 1e-9 to 1e9 */
    float viscosity;   /* kinematic, m2/s; 0 to 1e9 */
    float friction;    /* the same between the fluid and walls; 0 lets it slip */
    float cohesion;    /* what pulls particles to each other (Becker, Teschner 2007), m5/(kg s2); 0 to 1e9 */
    float gravity[3];  /* acceleration of all particles, m/s2 */
    float max_excess;  /* how much denser than at rest a particle may be when a step ends, as a share; 1e-9 to 1e9 */
    float mean_excess; /* the same in the mean */
    uint32_t min_corrections; /* corrections of pressures in a step, at least; 1 or more */
    uint32_t max_corrections; /* and at most: a step that is not enough is made anew with half the time */
    uint32_t steps;           /* RlvFluidSteps */
    float courant;            /* part of the spacing that the fastest particle goes in a step; 1e-9 to 1e9 */
    float step;               /* length of a step at most, or of all that are fixed, seconds; 1e-9 to 1e9 */
    uint32_t solver;          /* RlvFluidSolver */
    float tension; /* surface tension (Akinci, Akinci, Teschner 2013), N/m, 0.072 of water; 0 to 1e9 */
} RlvFluidOptions;

#define RLV_FLUID_OPTIONS_INIT                                                                                \
    {sizeof(RlvFluidOptions), RLV_FLUID_WENDLAND, 0.02f, 1000.0f, 0.001f, 0.001f, 0.0f, {0.0f, 0.0f, -9.81f}, 0.01f, \
     0.001f, 3, 100, RLV_FLUID_COURANT, 0.4f, 0.005f, RLV_FLUID_PCISPH, 0.0f}

typedef struct RlvFluidInfo {
    uint32_t struct_size;
    uint32_t channel_count;
    size_t particle_count;
    size_t wall_count;    /* particles of walls */
    double seconds;       /* since the beginning */
    float mass;           /* of a particle, kg: 3.3 % (RLV_FLUID_MUELLER: 1.0 %) below density * spacing^3 */
    float time_step;      /* how long the next step should be, seconds */
    float momentum[3];    /* of all particles, kg m/s */
    float kinetic_energy; /* of all particles, J */
} RlvFluidInfo;

#define RLV_FLUID_INFO_INIT {sizeof(RlvFluidInfo), 0, 0, 0, 0.0, 0.0f, 0.0f, {0.0f, 0.0f, 0.0f}, 0.0f}

/* Particles that are added. Strides are in bytes, 0 for packed. */
typedef struct RlvFluidParticles {
    uint32_t struct_size;
    float lifetime; /* seconds until they are removed; 0 for unlimited */
    size_t count;   /* may be 0 */
    const float *points; /* three floats each, metres */
    size_t point_stride;
    const float *velocities; /* three floats each, m/s; NULL for velocity */
    size_t velocity_stride;
    float velocity[3]; /* of all, where velocities is NULL */
    uint32_t reserved; /* 0 */
    const RlvAttributeArrays *channels; /* what they carry, as for rlv_fluid_set_channel: count values, or one for all; NULL
                                           for none */
    size_t channel_count;
    size_t channel_stride; /* bytes, 0 for packed */
} RlvFluidParticles;

#define RLV_FLUID_PARTICLES_INIT \
    {sizeof(RlvFluidParticles), 0.0f, 0, NULL, 0, NULL, 0, {0.0f, 0.0f, 0.0f}, 0, NULL, 0, 0}

/* Where what particles have is written; strides are in bytes, 0 for packed. NULL for what is not wanted. */
typedef struct RlvFluidArrays {
    uint32_t struct_size;
    uint32_t reserved; /* 0 */
    size_t capacity;   /* of each array that is not NULL, at least as many as there are particles */
    float *points;     /* three floats each, metres */
    size_t point_stride;
    float *velocities; /* three floats each, m/s */
    size_t velocity_stride;
    uint32_t *numbers;
    size_t number_stride;
    float *pressures; /* in the last step, Pa */
    size_t pressure_stride;
    float *densities; /* now, kg/m3. Wanting them costs about a quarter of a step */
    size_t density_stride;
    double *births; /* when they were added, seconds since the beginning */
    size_t birth_stride;
} RlvFluidArrays;

#define RLV_FLUID_ARRAYS_INIT {sizeof(RlvFluidArrays), 0, 0, NULL, 0, NULL, 0, NULL, 0, NULL, 0, NULL, 0, NULL, 0}

typedef struct RlvFluidColliderOptions {
    uint32_t struct_size;
    uint32_t contact;      /* RlvFluidContact */
    float friction;        /* of RLV_FLUID_FRICTION, 0 or more */
    uint32_t is_container; /* 1: fluid is inside of the closed mesh; 0: around it */
} RlvFluidColliderOptions;

#define RLV_FLUID_COLLIDER_OPTIONS_INIT {sizeof(RlvFluidColliderOptions), RLV_FLUID_SLIP, 0.0f, 0}

/* A force on all particles. */
typedef struct RlvFluidForce {
    uint32_t kind; /* RlvFluidForceKind */
    uint32_t seed; /* of turbulence: other eddies for each number */
    float vector[3]; /* m/s2 or m/s, or an axis of any length */
    float strength;  /* m/s2; of wind and drag the share in a second, 0 to 100 */
    double place[3]; /* metres */
    float radius;    /* metres, positive where the kind has one */
    float rate;      /* changes a second, 0 or more; of drag the share a metre, 1/m */
} RlvFluidForce;

/* What particles come from: one layer after the other, each a spacing from the one before. */
typedef struct RlvFluidEmitterOptions {
    uint32_t struct_size;
    uint32_t shape;    /* RlvFluidEmitterShape */
    double center[3];  /* metres */
    float u[3];        /* of a disc the normal, of any length; of a rectangle half a side, metres */
    float v[3];        /* of a rectangle half the other side, metres */
    float radius;      /* of a disc, metres */
    float speed;       /* of the particles, m/s; positive */
    float lifetime;    /* of the particles, seconds; 0 for unlimited */
    uint32_t reserved; /* 0 */
    double begin;      /* when it begins, seconds since the beginning of the fluid */
    double end;        /* when it ends; 0 for never */
    const RlvAttributeArrays *channels; /* what its particles carry, as for rlv_fluid_set_channel with one value; NULL for
                                           none. They are copied */
    size_t channel_count;
    size_t channel_stride; /* bytes, 0 for packed */
} RlvFluidEmitterOptions;

#define RLV_FLUID_EMITTER_OPTIONS_INIT                                                                                   \
    {sizeof(RlvFluidEmitterOptions), RLV_FLUID_DISC, {0.0, 0.0, 0.0}, {0.0f, 0.0f, 1.0f}, {0.0f, 0.0f, 0.0f}, 0.1f, 1.0f, \
     0.0f, 0, 0.0, 0.0, NULL, 0, 0}

/* What a step or several did. */
typedef struct RlvFluidReport {
    uint32_t struct_size;
    uint32_t reserved;
    double seconds;       /* that were simulated */
    uint64_t steps;
    uint64_t corrections; /* of pressures, those of steps that were made anew too */
    float max_excess;     /* how much denser than at rest a particle was when a step ended, as a share */
    float mean_excess;    /* the same in the mean of particles, of the step where it was most */
    double gravity[3];    /* the momentum that particles were given by the gravity of the options, kg m/s */
    double host[3];       /* by the accelerations of the host */
    double forces[3];     /* by forces */
    double walls[3];      /* by walls and colliders */
    uint64_t added;       /* particles that emitters made */
    uint64_t removed;     /* particles that sinks took */
    uint64_t divergence_corrections; /* of velocities that compress, of RLV_FLUID_DFSPH */
} RlvFluidReport;

#define RLV_FLUID_REPORT_INIT \
    {sizeof(RlvFluidReport), 0, 0.0, 0, 0, 0.0f, 0.0f, {0.0, 0.0, 0.0}, {0.0, 0.0, 0.0}, {0.0, 0.0, 0.0}, {0.0, 0.0, 0.0}, 0, 0, 0}

/* Makes a fluid without particles and walls. options may be NULL for the defaults. Fails if a number is out of its range. */
RLV_API RlvResult rlv_fluid_create(RlvContext context, const RlvFluidOptions *options, RlvFluid *out);

RLV_API RlvResult rlv_fluid_retain(RlvFluid fluid);
RLV_API RlvResult rlv_fluid_release(RlvFluid fluid);

/* How many particles there are, when, and how they move together. No failure of its own. */
RLV_API RlvResult rlv_fluid_info(RlvFluid fluid, RlvFluidInfo *out);

/* Mutating. Adds particles, which should be a spacing from each other and from those there are. Fails, and adds none, if a
 * number is out of its range, and with RLV_ERROR_MEMORY if the fluid would take more than the context's memory limit or
 * have more than 2^30 particles. */
RLV_API RlvResult rlv_fluid_add(RlvFluid fluid, const RlvFluidParticles *particles);

/* Mutating. Fills a box from low to high, three doubles each, with particles half a spacing from its sides, so that it may
 * stand on a wall; velocity is three floats, NULL for rest. Sides should be whole spacings, as particles are otherwise a
 * little nearer to each other, or farther: nearer ones burst apart. Fails as rlv_fluid_add does, and if a side of the box is less
 * than a spacing. */
RLV_API RlvResult rlv_fluid_add_box(RlvFluid fluid, const double *low, const double *high, const float *velocity);

/* Mutating. Fills a closed mesh with particles half a spacing from its surface, but for places beside walls and colliders that
 * have no room. matrix is as for rlv_fluid_add_collider, velocity three floats, NULL for rest; added may be NULL and
 * receives how many there are. Fails as rlv_fluid_add does, and if the mesh has no triangle or is too large for the spacing. */
RLV_API RlvResult rlv_fluid_fill(RlvFluid fluid, RlvMesh mesh, const double *matrix, const float *velocity, size_t *added);

/* Mutating. Adds an emitter, which acts after every step from now on, but where particles are already. mesh is that of
 * RLV_FLUID_SURFACE, which may be released afterwards, with a matrix as for rlv_fluid_add_collider; RLV_NULL and NULL for
 * other shapes. Fails, and adds none, if a number is out of its range or it is too small for a particle. */
RLV_API RlvResult rlv_fluid_add_emitter(RlvFluid fluid, RlvMesh mesh, const double *matrix,
                                        const RlvFluidEmitterOptions *options);

/* Mutating. Removes particles that are in the box from low to high after a step, three doubles each in metres, or with
 * an is_outside of 1 particles outside it. Fails if is_outside is another number than 0 or 1. */
RLV_API RlvResult rlv_fluid_add_sink(RlvFluid fluid, const double *low, const double *high, uint32_t is_outside);

/* Mutating. The same of particles inside of a closed mesh, which may be released afterwards; matrix as for
 * rlv_fluid_add_collider. Fails if the mesh has no triangle. */
RLV_API RlvResult rlv_fluid_add_sink_mesh(RlvFluid fluid, RlvMesh mesh, const double *matrix);

/* Mutating. Forgets all emitters and sinks. No failure of its own. */
RLV_API RlvResult rlv_fluid_clear_sources(RlvFluid fluid);

/* Mutating. Sets how many particles there may be for emitters to add some; 0 for no limit. Beyond it steps fail, after what
 * they simulated, with RLV_ERROR_MEMORY, or with stops of 1 emitters wait until there is room. Fails if stops is another
 * number than 0 or 1. */
RLV_API RlvResult rlv_fluid_set_budget(RlvFluid fluid, size_t particles, uint32_t stops);

/* Mutating. Has forces act on all particles instead of those before, beside gravity of the options; count of them, stride
 * in bytes, 0 for packed. Fails, and changes nothing, if a number is out of its range. */
RLV_API RlvResult rlv_fluid_set_forces(RlvFluid fluid, const RlvFluidForce *forces, size_t count, size_t stride);

/* Mutating. Removes the particles of these numbers; stride is in bytes, 0 for packed. Numbers that no particle has are left
 * aside. removed may be NULL; it receives how many there were. No failure of its own. */
RLV_API RlvResult rlv_fluid_remove(RlvFluid fluid, const uint32_t *numbers, size_t count, size_t stride, size_t *removed);

/* Mutating. Takes particles at these places as walls at rest instead of those there were; three floats each, stride in
 * bytes, 0 for packed. They lie half a spacing behind the surface of a wall, a spacing from each other. A count of 0 is for
 * no walls. Fails, and changes nothing, if too many lie on each other, and with RLV_ERROR_MEMORY if they would take more
 * than the context's memory limit. */
RLV_API RlvResult rlv_fluid_set_walls(RlvFluid fluid, const float *points, size_t count, size_t stride);

/* Mutating. Takes the six sides of a box from low to high, three doubles each, as walls instead of those there were. Fails,
 * and changes nothing, as rlv_fluid_set_walls does, and if a side of the box is less than a spacing. */
RLV_API RlvResult rlv_fluid_set_basin(RlvFluid fluid, const double *low, const double *high);

/* Mutating. Has walls be at other places and go on from there with velocities in m/s, count as many as were set, in their
 * order, until this is called again; three floats each, strides in bytes, 0 for packed. Fails, and changes nothing, if
 * there are not as many. */
RLV_API RlvResult rlv_fluid_set_wall_points(RlvFluid fluid, const float *points, size_t count, size_t stride,
                                            const float *velocities, size_t velocity_stride);

/* Mutating. Adds a mesh that fluid does not pass, at rest, besides walls. matrix is twelve doubles, the affine map from the
 * mesh to the fluid in columns: three for the linear part, then the translation; NULL for the identity. The mesh may be
 * released or changed afterwards; out receives the number of the collider, counted from 0. Triangles may be without an
 * area, and the mesh may have holes, but then fluid is on both sides of it and rests a spacing from it. options may be NULL
 * for the defaults. Fails, and adds none, if no triangle has an area, a number is out of its range or the mesh is too large
 * for the spacing. */
RLV_API RlvResult rlv_fluid_add_collider(RlvFluid fluid, RlvMesh mesh, const double *matrix,
                                         const RlvFluidColliderOptions *options, uint32_t *out);

/* Mutating. Has a collider go from points to others in straight lines within seconds from now on, where it stays; 0 seconds
 * put it to from, at rest. Points are three floats each in the order of the mesh, in metres of the fluid; count is how many
 * it has, stride in bytes, 0 for packed. from may be NULL for where it is. Fails, and changes nothing, if there is no such
 * collider or there are not as many points. */
RLV_API RlvResult rlv_fluid_move_collider(RlvFluid fluid, uint32_t collider, const float *from, const float *to,
                                          size_t count, size_t stride, float seconds);

/* The momentum that a collider, or RLV_FLUID_WALLS, was given by the fluid in the last step: linear in kg m/s, angular about
 * the origin in kg m2/s, three doubles each; NULL for what is not wanted. Fails if there is no such collider. */
RLV_API RlvResult rlv_fluid_impulse(RlvFluid fluid, uint32_t collider, double *linear, double *angular);

/* Mutating. Has each particle accelerated by so much beside all else, from now on: count as many as there are particles,
 * three floats each in m/s2, stride in bytes, 0 for packed. Particles that are added later are not. Fails, and changes
 * nothing, if there are not as many. */
RLV_API RlvResult rlv_fluid_accelerate(RlvFluid fluid, const float *accelerations, size_t count, size_t stride);

/* Mutating. Makes one step of seconds, or a shorter one where pressures do not converge: out, which may be NULL, says how
 * long it was. RlvFluidInfo has how long it should be. Fails if seconds is negative, and, with the particles where they
 * were, if pressures do not converge at all or particles are where none can be. */
RLV_API RlvResult rlv_fluid_step(RlvFluid fluid, float seconds, RlvFluidReport *out);

/* Mutating. Simulates seconds, 0 or more, in as many steps as it takes. progress may be NULL, and out. Fails as
 * rlv_fluid_step does, and with RLV_ERROR_CANCELLED: the fluid is then as the last whole step left it, and goes on from
 * there. */
RLV_API RlvResult rlv_fluid_advance(RlvFluid fluid, double seconds, RlvProgress progress, void *user,
                                    RlvFluidReport *out);

/* Writes what particles have. Mutating where densities are wanted, though nothing is simulated. Fails if there is not
 * enough room. */
RLV_API RlvResult rlv_fluid_get(RlvFluid fluid, const RlvFluidArrays *arrays);

/* Mutating. Gives each particle a value of a channel, in the order of numbers, which it carries from now on; makes the channel if
 * there is none of the name. channel is an attribute of RLV_DOMAIN_POINT and RLV_TYPE_F32 without indices, 1 to 4 numbers
 * wide. Particles that are added without it have zeros. `color` is three numbers of scene-linear Rec.709; other names are the
 * host's own. Fails, and changes nothing, if there are not as many values as particles, one is not finite, the channel has
 * another width, would be the 256th or is called `velocity`, and with RLV_ERROR_MEMORY as rlv_fluid_add does. */
RLV_API RlvResult rlv_fluid_set_channel(RlvFluid fluid, const RlvAttributeArrays *channel);

/* The index of the channel called name, RLV_ERROR_NOT_FOUND if there is none. Indices do not change until a state is
 * restored. */
RLV_API RlvResult rlv_fluid_find_channel(RlvFluid fluid, const char *name, uint32_t *out);

/* What channel index, counted from 0, is; values are as many as particles. Fails if there is none. */
RLV_API RlvResult rlv_fluid_channel_info(RlvFluid fluid, uint32_t index, RlvAttributeInfo *out);

/* Writes the values of channel index in the order of numbers; capacity is in values, stride in bytes, 0 for packed. Fails, and
 * writes nothing, if there is no such channel or not enough room. */
RLV_API RlvResult rlv_fluid_get_channel(RlvFluid fluid, uint32_t index, float *values, size_t capacity, size_t stride);

/* Writes all that the fluid goes on from to a file of the form .rlvfluid, which appears whole or not at all; path is UTF-8. One
 * with the same options, walls, colliders, emitters, sinks, forces and budget, which are not in it, does the same from it, to
 * the bit at the same instruction level; a collider that moves is put where it was by rlv_fluid_move_collider. rlv_particles_read
 * and the command read its particles. Fails if the file cannot be written. */
RLV_API RlvResult rlv_fluid_save(RlvFluid fluid, const char *path);

/* Mutating. Goes on from such a file, with its particles, time and channels instead of those there were; of the command's frames
 * without their bodies. The file may be hostile. Fails, and changes nothing, if it cannot be read, is damaged, has no state,
 * or is of another spacing, and with RLV_ERROR_MEMORY as rlv_fluid_add does. */
RLV_API RlvResult rlv_fluid_restore(RlvFluid fluid, const char *path);

/* Makes the bytes of the file that rlv_fluid_save writes. No failure of its own. */
RLV_API RlvResult rlv_fluid_save_bytes(RlvFluid fluid, RlvBytes *out);

/* Mutating. As rlv_fluid_restore, from the size bytes of such a file. Fails as rlv_fluid_restore does. */
RLV_API RlvResult rlv_fluid_restore_bytes(RlvFluid fluid, const uint8_t *bytes, size_t size);

/* Makes a picture of the present particles, in the order of numbers, with velocities, channels, the time and the
 * spacing, for files. Fails with RLV_ERROR_MEMORY where there is no room. */
RLV_API RlvResult rlv_fluid_particles(RlvFluid fluid, RlvParticles *out);

/* Mutating. Adds particles with their velocities, or at rest, and what they carry but for the channels `blind` and `normal`.
 * They get numbers of the fluid. Fails as rlv_fluid_add does. */
RLV_API RlvResult rlv_fluid_add_particles(RlvFluid fluid, RlvParticles particles);

/* Makes the surface of the particles where they are now, with their velocities and channels, which its meshes have as
 * attributes, but for a channel called `normal`; none is blind. options may be NULL for the defaults with a radius of half the
 * spacing. Fails as rlv_isosurface_create does. */
RLV_API RlvResult rlv_fluid_isosurface(RlvFluid fluid, const RlvIsosurfaceOptions *options, RlvIsosurface *out);

#endif
