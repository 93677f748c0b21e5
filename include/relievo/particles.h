/* Relievo: particles at a time, and their files.
 *
 * Particles are places in metres with named channels of 1 to 4 numbers each, and with numbers by which each is found again
 * at other times. The channel `velocity` has three numbers in m/s, `blind` is 1 for blind particles and 0 for those at
 * the surface, `color` is three numbers of scene-linear Rec.709; other names are the host's own. Particles do not change, so
 * that their calls may run at the same time. */
#ifndef RELIEVO_PARTICLES_H
#define RELIEVO_PARTICLES_H

#include "relievo/isosurface.h"

typedef struct RlvParticles {
    uint64_t id;
} RlvParticles;

/* What particles are made from. Strides are in bytes, 0 for packed. */
typedef struct RlvParticlesArrays {
    uint32_t struct_size;
    uint32_t has_time; /* 1 if time is known, else 0 */
    double time;       /* seconds since the beginning */
    float spacing;     /* distance between particles at rest, metres; 0 where it is not known */
    uint32_t reserved; /* 0 */
    size_t count;      /* may be 0 */
    const float *points; /* three floats each, metres */
    size_t point_stride;
    const uint32_t *numbers; /* NULL for none */
    size_t number_stride;
    const RlvAttributeArrays *channels; /* RLV_DOMAIN_POINT and RLV_TYPE_F32 without indices, with count values; NULL for none */
    size_t channel_count;
    size_t channel_stride;
} RlvParticlesArrays;

#define RLV_PARTICLES_ARRAYS_INIT {sizeof(RlvParticlesArrays), 0, 0.0, 0.0f, 0, 0, NULL, 0, NULL, 0, NULL, 0, 0}

typedef struct RlvParticlesInfo {
    uint32_t struct_size;
    uint32_t channel_count;
    size_t count;
    uint32_t has_numbers; /* 1 or 0 */
    uint32_t has_time;    /* 1 or 0 */
    double time;          /* seconds since the beginning; 0 where it is not known */
    float spacing;        /* distance between particles at rest, metres; 0 where it is not known */
    uint32_t reserved;
} RlvParticlesInfo;

#define RLV_PARTICLES_INFO_INIT {sizeof(RlvParticlesInfo), 0, 0, 0, 0, 0.0, 0.0f, 0}

/* Makes particles from arrays, which are copied. Fails if a number is not finite, there are not as many of something as
 * particles, two channels have the same name, or there are more than 256, and with RLV_ERROR_MEMORY if an array would take
 * more than the context's memory limit. */
RLV_API RlvResult rlv_particles_create(RlvContext context, const RlvParticlesArrays *arrays, RlvParticles *out);

/* Reads a file, in the order of numbers where it has some: a frame of a cache (.rlvfluid), classic .bgeo, legacy VTK, PLY,
 * OpenVDB's points, told by what it begins with, or the points of any mesh that rlv_mesh_read reads. path is UTF-8. The
 * file may be hostile: sizes that it tells are compared with its length, and the context's memory limit bounds what reading it
 * takes. Fails if the file cannot be read, is damaged, or of a form that is known and not read, which the message names. */
RLV_API RlvResult rlv_particles_read(RlvContext context, const char *path, RlvParticles *out);

/* Writes particles as the extension of the path says: .rlvfluid, .bgeo, .vtk, .ply or .vdb. path is UTF-8. The file appears
 * whole or not at all. Fails if the extension is another, the format cannot hold them, or the file cannot be written. */
RLV_API RlvResult rlv_particles_write(RlvParticles particles, const char *path);

RLV_API RlvResult rlv_particles_retain(RlvParticles particles);
RLV_API RlvResult rlv_particles_release(RlvParticles particles);

/* How many there are, and what they have. No failure of its own. */
RLV_API RlvResult rlv_particles_info(RlvParticles particles, RlvParticlesInfo *out);

/* Writes the places, three floats each in metres; capacity is in points. Fails, and writes nothing, if there is not enough room. */
RLV_API RlvResult rlv_particles_get_points(RlvParticles particles, float *points, size_t capacity, size_t stride);

/* Writes the numbers of particles. Fails, and writes nothing, if there is not enough room, with RLV_ERROR_NOT_FOUND if they
 * have none. */
RLV_API RlvResult rlv_particles_get_numbers(RlvParticles particles, uint32_t *numbers, size_t capacity, size_t stride);

/* The index of the channel called name, RLV_ERROR_NOT_FOUND if there is none. */
RLV_API RlvResult rlv_particles_find_channel(RlvParticles particles, const char *name, uint32_t *out);

/* What channel index, counted from 0, is; values are as many as particles. Fails if there is none. */
RLV_API RlvResult rlv_particles_channel_info(RlvParticles particles, uint32_t index, RlvAttributeInfo *out);

/* Writes the values of channel index; capacity is in values, stride in bytes, 0 for packed. Fails, and writes nothing, if
 * there is no such channel or not enough room. */
RLV_API RlvResult rlv_particles_get_channel(RlvParticles particles, uint32_t index, float *values, size_t capacity,
                                            size_t stride);

/* Makes an object with the particles that a surface needs: classes are count values of RlvIsosurfaceClass, as
 * rlv_isosurface_classify writes them, stride is in bytes. Hidden particles are left out; the others have the channel
 * `blind`. Fails if there are not as many classes as particles, or a number is not a class. */
RLV_API RlvResult rlv_particles_keep(RlvParticles particles, const uint8_t *classes, size_t count, size_t stride,
                                     RlvParticles *out);

/* Makes the surface of particles, with their velocities and channels, which its meshes have as attributes; blind are those of the
 * channel `blind`. options may be NULL for the defaults, with a radius of half the spacing where that is known. Fails as
 * rlv_isosurface_create does. */
RLV_API RlvResult rlv_particles_isosurface(RlvParticles particles, const RlvIsosurfaceOptions *options, RlvIsosurface *out);

#endif
