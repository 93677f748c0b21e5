/* Relievo: diffuse particles, the spray, foam and bubbles of a fluid.
 *
 * They are made from the frames of any fluid of particles, without its solver (Ihmsen, Akinci, Akinci, Teschner 2012,
 * "Unified Spray, Foam and Air Bubbles for Particle-Based Fluids"). The host advances a run frame by frame and takes the
 * particles after each; rlv_foam_add draws them. A run depends on its settings, their seed and the frames alone, for any
 * number of threads. Lengths are metres, times seconds. */
#ifndef RELIEVO_DIFFUSE_H
#define RELIEVO_DIFFUSE_H

#include "relievo/context.h"
#include "relievo/parameter.h"
#include "relievo/particles.h"

typedef struct RlvDiffuse {
    uint64_t id;
} RlvDiffuse;

/* The fluid of a run. */
typedef struct RlvDiffuseOptions {
    uint32_t struct_size;
    float spacing;       /* distance between the fluid's particles at rest, above 0 */
    float gravity[3];    /* acceleration of spray, m/s2 */
    uint32_t has_bounds; /* 1: particles outside of low and high are removed; 0: no particle is removed by its place */
    double low[3];       /* lower corner, m */
    double high[3];      /* upper corner, m; greater than low along each axis */
} RlvDiffuseOptions;

#define RLV_DIFFUSE_OPTIONS_INIT \
    {sizeof(RlvDiffuseOptions), 0.02f, {0.0f, 0.0f, -9.81f}, 0, {0.0, 0.0, 0.0}, {0.0, 0.0, 0.0}}

/* How particles are born, move and dissolve. rlv_diffuse_params has ranges, units and defaults of every field. */
typedef struct RlvDiffuseSettings {
    uint32_t struct_size;
    float air_min; /* lower limit of the potential of trapped air, m/s */
    float air_max; /* upper limit of the potential of trapped air, above the lower one, m/s */
    float crest_min; /* lower limit of the potential of wave crests */
    float crest_max; /* upper limit of the potential of wave crests, above the lower one */
    float energy_min; /* lower limit of the kinetic energy of a kilogram, J/kg */
    float energy_max; /* upper limit of the kinetic energy of a kilogram, J/kg */
    float air_rate; /* particles that a particle of the fluid makes in a second at the upper limit of trapped air (k_ta) */
    float crest_rate; /* particles that a particle of the fluid makes in a second at the upper limit of crests (k_wc) */
    float lifetime_min; /* seconds that foam of the least potential lives */
    float lifetime_max; /* seconds that foam of the greatest potential lives, not below the least */
    uint32_t spray_below; /* a particle with fewer neighbours in the fluid is spray */
    uint32_t bubbles_above; /* a particle with more neighbours in the fluid is a bubble; not below the limit of spray */
    float buoyancy; /* acceleration of bubbles against gravity, as a share of gravity (k_b) */
    float drag; /* share of the difference to the fluid's velocity that a bubble loses in a step (k_d) */
    uint32_t steps; /* steps of a frame */
    uint32_t most; /* particles at a time; further births are refused and counted */
    uint32_t seed; /* seed of all random numbers */
} RlvDiffuseSettings;

#define RLV_DIFFUSE_SETTINGS_INIT                                                                                     \
    {sizeof(RlvDiffuseSettings), 5.0f, 20.0f, 2.0f, 8.0f, 5.0f, 50.0f, 4000.0f, 4000.0f, 2.0f, 5.0f, 6, 20, 2.0f, 0.8f, \
     2, 100000000, 1}

/* The particles of a fluid at the end of a frame. Strides are in bytes, 0 for packed. */
typedef struct RlvDiffuseFluid {
    uint32_t struct_size;
    uint32_t reserved; /* 0 */
    size_t count;
    const float *positions; /* three floats each, metres */
    size_t position_stride;
    const float *velocities; /* three floats each, m/s */
    size_t velocity_stride;
} RlvDiffuseFluid;

#define RLV_DIFFUSE_FLUID_INIT {sizeof(RlvDiffuseFluid), 0, 0, NULL, 0, NULL, 0}

typedef struct RlvDiffuseInfo {
    uint32_t struct_size;
    uint32_t reserved; /* 0 */
    size_t count;      /* particles now */
    uint64_t frames;   /* so far */
    uint64_t births;   /* in all frames so far */
} RlvDiffuseInfo;

#define RLV_DIFFUSE_INFO_INIT {sizeof(RlvDiffuseInfo), 0, 0, 0, 0}

/* What a frame did. */
typedef struct RlvDiffuseReport {
    uint32_t struct_size;
    uint32_t reserved; /* 0 */
    uint64_t born;
    uint64_t gone;    /* dissolved, or left the bounds */
    uint64_t refused; /* births beyond the greatest number of particles */
} RlvDiffuseReport;

#define RLV_DIFFUSE_REPORT_INIT {sizeof(RlvDiffuseReport), 0, 0, 0, 0}

/* Where potentials are written, each from 0 to 1 and one for each particle of the fluid, packed. NULL for an array that is
 * not wanted. */
typedef struct RlvDiffusePotentials {
    uint32_t struct_size;
    uint32_t reserved; /* 0 */
    size_t capacity;   /* of each array that is not NULL, at least as many as the fluid has particles */
    float *air;        /* of trapped air */
    float *crests;     /* of wave crests */
    float *energies;   /* of kinetic energy, by which the others are multiplied */
} RlvDiffusePotentials;

#define RLV_DIFFUSE_POTENTIALS_INIT {sizeof(RlvDiffusePotentials), 0, 0, NULL, NULL, NULL}

/* Where particles are written, packed. NULL for an array that is not wanted. positions, ids, kinds and lives are what
 * RlvFoamParticles takes. */
typedef struct RlvDiffuseArrays {
    uint32_t struct_size;
    uint32_t reserved; /* 0 */
    size_t capacity;   /* of each array that is not NULL, at least as many as there are particles */
    float *positions;  /* three floats each, metres */
    float *velocities; /* three floats each, m/s */
    uint32_t *ids;     /* in order of birth */
    uint32_t *kinds;   /* RlvFoamKind */
    float *ages;       /* seconds since birth */
    float *lifetimes;  /* seconds of foam that are left */
    float *lives;      /* shares of their lives that have passed, 0 to 1 */
} RlvDiffuseArrays;

#define RLV_DIFFUSE_ARRAYS_INIT {sizeof(RlvDiffuseArrays), 0, 0, NULL, NULL, NULL, NULL, NULL, NULL, NULL}

/* The fields of RlvDiffuseSettings in order: a table that lives as long as the process, and its length. No failure of its
 * own. */
RLV_API RlvResult rlv_diffuse_params(const RlvParameter **params, size_t *count);

/* Makes a run without particles; options and settings may be NULL for the defaults. Fails if a number is out of range. */
RLV_API RlvResult rlv_diffuse_create(RlvContext context, const RlvDiffuseOptions *options,
                                     const RlvDiffuseSettings *settings, RlvDiffuse *out);

RLV_API RlvResult rlv_diffuse_retain(RlvDiffuse diffuse);
RLV_API RlvResult rlv_diffuse_release(RlvDiffuse diffuse);

/* Writes the number of particles, and of frames and births so far. No failure of its own. */
RLV_API RlvResult rlv_diffuse_info(RlvDiffuse diffuse, RlvDiffuseInfo *out);

/* Mutating. Moves the particles by a time in seconds to the end of a frame of the fluid, and adds the particles born in it;
 * report may be NULL. Fails, and changes nothing, if a number is not finite, a velocity is above 1e15 m/s along an axis,
 * seconds is not above 0, particles are too far from each other, or the call is cancelled. */
RLV_API RlvResult rlv_diffuse_advance(RlvDiffuse diffuse, const RlvDiffuseFluid *fluid, float seconds,
                                      RlvDiffuseReport *report, RlvProgress progress, void *user);

/* Writes the potentials of a fluid's particles by the settings of the run, in the order of the particles. Fails as
 * rlv_diffuse_advance does, and if there is room for fewer. */
RLV_API RlvResult rlv_diffuse_potentials(RlvDiffuse diffuse, const RlvDiffuseFluid *fluid,
                                         const RlvDiffusePotentials *potentials);

/* Writes the particles. Fails, and writes nothing, if there is room for fewer, or if ids are wanted and have more than 32
 * bits. */
RLV_API RlvResult rlv_diffuse_get(RlvDiffuse diffuse, const RlvDiffuseArrays *arrays);

/* Makes a copy of the particles for files, with numbers and the channels velocity, type, age and lifetime, at a time in
 * seconds. Fails if ids have more than 32 bits or the time is not finite. */
RLV_API RlvResult rlv_diffuse_particles(RlvDiffuse diffuse, double time, RlvParticles *out);

/* Writes the particles and what a run continues from to a file of the form .rlvfluid, which appears whole or not at all;
 * path is UTF-8. Fails as rlv_diffuse_particles does, and if the file cannot be written. */
RLV_API RlvResult rlv_diffuse_save(RlvDiffuse diffuse, const char *path, double time);

/* Mutating. Continues from a file of rlv_diffuse_save or a frame of the command, with the options and settings of this run.
 * The file may be hostile. Fails, and changes nothing, if it cannot be read, is damaged, has no state of diffuse particles,
 * or is of a fluid of another spacing. */
RLV_API RlvResult rlv_diffuse_restore(RlvDiffuse diffuse, const char *path);

#endif
