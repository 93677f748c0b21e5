/* Relievo: surfaces of fluids of particles, as meshes and for rays without a mesh.
 *
 * An isosurface is where a function of particles is 0; the function is positive inside. It is a picture of the particles at
 * the time it was made: it does not change, so that its calls may run at the same time. Lengths are in metres, times in
 * seconds. All arrays are in the order in which particles were given. It takes some 80 bytes a particle. */
#ifndef RELIEVO_ISOSURFACE_H
#define RELIEVO_ISOSURFACE_H

#include "relievo/caster.h"

typedef struct RlvIsosurface {
    uint64_t id;
} RlvIsosurface;

typedef enum RlvIsosurfaceFunction {
    RLV_ISOSURFACE_BLOBS = 0,       /* a sum of Gaussians (Blinn 1982) */
    RLV_ISOSURFACE_ZHU_BRIDSON = 1, /* the distance to a weighted mean of particles (Zhu, Bridson 2005) */
    RLV_ISOSURFACE_DENSITY = 2,     /* the share of the density at rest */
    RLV_ISOSURFACE_ANISOTROPIC = 3  /* the same of kernels that are flat along the surface (Yu, Turk 2013) */
} RlvIsosurfaceFunction;

/* What the surface is for a particle, and the particle for it (Morgenroth, Weiskopf, Eberhardt 2013, Section 4.3). */
typedef enum RlvIsosurfaceClass {
    RLV_ISOSURFACE_SURFACE = 0, /* it is at the surface */
    RLV_ISOSURFACE_BLIND = 1,   /* it is near enough to change the surface if it were left out */
    RLV_ISOSURFACE_HIDDEN = 2   /* the surface does not need it */
} RlvIsosurfaceClass;

typedef struct RlvIsosurfaceOptions {
    uint32_t struct_size;
    uint32_t function;   /* RlvIsosurfaceFunction */
    float radius;        /* of a particle, half the distance between particles at rest; positive */
    float support;       /* distance from which on a particle is not seen; 0 for 4 radii */
    float sharpness;     /* of blobs: how fast weights fall off, more than 0 and less than 64 */
    float iso;           /* of densities: the share at the surface, more than 0 and less than 1 */
    float centring;      /* of anisotropic kernels: how far centres go to the mean of their neighbours, 0 to 1 */
    float shutter_open;  /* time of the first rays, from when the particles are where they are; not after shutter_close */
    float shutter_close; /* time of the last rays */
    float march_steps;   /* steps of rays in a support radius, 1 to 1,024: what is thinner than a step may be missed */
} RlvIsosurfaceOptions;

#define RLV_ISOSURFACE_OPTIONS_INIT \
    {sizeof(RlvIsosurfaceOptions), RLV_ISOSURFACE_ZHU_BRIDSON, 0.01f, 0.0f, 8.0f, 0.6f, 0.9f, 0.0f, 0.0f, 12.0f}

/* Particles. Strides are in bytes, 0 for packed; velocities and blind may be NULL. */
typedef struct RlvIsosurfaceParticles {
    uint32_t struct_size;
    uint32_t reserved; /* 0 */
    size_t count;      /* may be 0 */
    const float *points; /* three floats each */
    size_t point_stride;
    const float *velocities; /* three floats each, metres a second; NULL for what does not move */
    size_t velocity_stride;
    const uint8_t *blind; /* 1 for blind particles, 0 for those at the surface; NULL if none is blind */
    size_t blind_stride;
} RlvIsosurfaceParticles;

#define RLV_ISOSURFACE_PARTICLES_INIT {sizeof(RlvIsosurfaceParticles), 0, 0, NULL, 0, NULL, 0, NULL, 0}

typedef struct RlvIsosurfaceInfo {
    uint32_t struct_size;
    uint32_t has_velocities; /* 1 if particles move, else 0 */
    size_t particle_count;
    float support;   /* support radius */
    float reach;     /* distance from which on no kernel counts: the support radius, more of anisotropic kernels */
    float influence; /* distance from which on a particle does not change a value: what RLV_ISOSURFACE_BLIND goes by */
    float reserved;
} RlvIsosurfaceInfo;

#define RLV_ISOSURFACE_INFO_INIT {sizeof(RlvIsosurfaceInfo), 0, 0, 0.0f, 0.0f, 0.0f, 0.0f}

typedef struct RlvIsosurfaceMeshOptions {
    uint32_t struct_size;
    uint32_t iterations; /* of smoothing, 0 to 10,000 */
    float cell;          /* size of the cells of marching cubes, support / 128 to support; 0 for a radius */
    float forwards;      /* how far smoothing goes towards the mean of the neighbours, 0 to 1 */
    float backwards;     /* and then back, 0 to 1: a little more keeps the volume (Taubin 1995), 0 is Laplace's */
    uint32_t reserved;   /* 0 */
    const RlvAttributeArrays *channels; /* values of particles that vertices get the weighted mean of, as attributes of
                                           RLV_DOMAIN_POINT and RLV_TYPE_F32 without indices; NULL for none */
    size_t channel_count;
    size_t channel_stride; /* bytes, 0 for packed */
} RlvIsosurfaceMeshOptions;

#define RLV_ISOSURFACE_MESH_OPTIONS_INIT {sizeof(RlvIsosurfaceMeshOptions), 0, 0.0f, 0.5f, 0.53f, 0, NULL, 0, 0}

/* How many particles of each class there are. */
typedef struct RlvIsosurfaceClasses {
    uint32_t struct_size;
    uint32_t reserved;
    size_t surface_count;
    size_t blind_count;
    size_t hidden_count;
    double kept; /* share of particles not hidden, and of bytes in files; 1 without particles */
} RlvIsosurfaceClasses;

#define RLV_ISOSURFACE_CLASSES_INIT {sizeof(RlvIsosurfaceClasses), 0, 0, 0, 0, 0.0}

/* A ray for the function of a table. Distances are in multiples of its direction. */
typedef struct RlvIsosurfaceRay {
    float origin[3];    /* metres */
    float direction[3]; /* of any length but zero */
    float min_distance; /* smallest distance of a hit, 0 or more */
    float max_distance; /* largest distance of a hit; 0 for no limit */
    float time;         /* seconds, held within the shutter */
} RlvIsosurfaceRay;

/* Where a ray enters or leaves the fluid first. Without a hit, distance is infinite and the rest zero. */
typedef struct RlvIsosurfaceHit {
    float distance;    /* in multiples of the ray's direction */
    float position[3]; /* metres */
    float normal[3];   /* unit length, out of the fluid */
    float velocity[3]; /* of the fluid there, metres a second; zero if nothing moves */
    uint32_t enters;   /* 1 if the ray enters the fluid here, 0 if it leaves it */
} RlvIsosurfaceHit;

/* Traces one ray; data is that of the table. Writes the hit, and returns 1 if there is one. May be called on any number
 * of threads at a time; takes no lock, and asks for memory only the first times on a thread. NULL, and rays that hit nothing
 * by the rule of RlvRayArrays or whose time is not finite, meet nothing. */
typedef uint32_t (*RlvIsosurfaceIntersect)(const void *data, const RlvIsosurfaceRay *ray, RlvIsosurfaceHit *hit);

/* What renderers call. It is valid as long as the isosurface lives: a scene keeps a reference. */
typedef struct RlvIsosurfaceTable {
    uint32_t struct_size;
    uint32_t reserved;
    const void *data; /* to be given to the function */
    RlvIsosurfaceIntersect intersect;
    float low[3]; /* bounds of all that rays can meet while the shutter is open; low above high without particles */
    float high[3];
} RlvIsosurfaceTable;

#define RLV_ISOSURFACE_TABLE_INIT {sizeof(RlvIsosurfaceTable), 0, NULL, NULL, {0}, {0}}

/* Makes the surface of particles, which are copied. options may be NULL for the defaults. Fails if a number is out of its
 * range or not finite, if particles are more than a million support radii apart, of densities and anisotropic kernels if
 * so many lie on each other that it would take minutes, and with RLV_ERROR_MEMORY if it would take more than the context's
 * memory limit. */
RLV_API RlvResult rlv_isosurface_create(RlvContext context, const RlvIsosurfaceParticles *particles,
                                        const RlvIsosurfaceOptions *options, RlvIsosurface *out);

RLV_API RlvResult rlv_isosurface_retain(RlvIsosurface isosurface);
RLV_API RlvResult rlv_isosurface_release(RlvIsosurface isosurface);

/* What the surface is of. No failure of its own. */
RLV_API RlvResult rlv_isosurface_info(RlvIsosurface isosurface, RlvIsosurfaceInfo *out);

/* Makes the mesh of the surface by marching cubes: triangles, watertight and manifold, whose front is outside, with the
 * attribute `normal` and, if particles move, `velocity` on points, and one for each channel. Without particles it has no
 * faces. Blind particles are part of the surface. options may be NULL for the defaults, progress too. Fails if a number
 * is out of its range, a coordinate is more than 1,048,576 cells from 0, a channel is not as it has to be or has not as
 * many values as there are particles, with RLV_ERROR_MEMORY if it would take more than the context's memory limit, and
 * with RLV_ERROR_CANCELLED. */
RLV_API RlvResult rlv_isosurface_mesh(RlvIsosurface isosurface, const RlvIsosurfaceMeshOptions *options,
                                      RlvProgress progress, void *user, RlvMesh *out);

/* Says which particles the surface needs. A particle is blind if the surface is nearer than threshold; less than 0 is for
 * the influence, with which surface and blind particles alone have the same surface. Writes an RlvIsosurfaceClass for each
 * to classes, which has room for capacity, stride bytes apart; NULL if the counts are enough. out may be NULL, progress
 * too. Fails if there is not enough room, if the threshold is not finite, as rlv_isosurface_mesh does with cells of a
 * quarter of the support radius, and with RLV_ERROR_CANCELLED. */
RLV_API RlvResult rlv_isosurface_classify(RlvIsosurface isosurface, float threshold, uint8_t *classes, size_t capacity,
                                          size_t stride, RlvProgress progress, void *user, RlvIsosurfaceClasses *out);

/* Casts rays on the threads of the context and writes as many hits, hit_stride bytes apart, 0 for packed; hits of rays is not
 * used. Hits where blind particles have most of the weight are dropped: there the surface is that of the layer that was
 * kept and not of the fluid. An isosurface has no mask: a ray whose mask is 0 hits nothing, nor does one whose time is not
 * finite. Fails as RlvRayArrays says. */
RLV_API RlvResult rlv_isosurface_cast(RlvIsosurface isosurface, const RlvRayArrays *rays, RlvIsosurfaceHit *hits,
                                      size_t hit_stride);

/* The function for rays one by one, and what it works on, for another renderer. Finds the same hits as
 * rlv_isosurface_cast. No failure of its own. */
RLV_API RlvResult rlv_isosurface_table(RlvIsosurface isosurface, RlvIsosurfaceTable *out);

#endif
