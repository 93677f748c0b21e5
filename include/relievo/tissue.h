/* Relievo: finite-element models of soft tissue, and their simulation.
 *
 * A model of hexahedra is built from closed surfaces with materials, layers of skin and muscles (Warburton and Maddock 2013),
 * from a labelled scan or from a grid. A simulation moves a copy of the model by total Lagrangian explicit dynamics (Miller,
 * Joldes, Lance, Wittek 2007). Lengths are metres, times seconds, masses kilograms, stresses pascals. Results do not depend
 * on the number of threads. A simulation takes some 300 bytes an element.
 *
 * On a context with a graphics device it takes the steps of simulations, but for contact of a model with itself, pressures and
 * halved steps, which the processor does, and takes over where a device fails. Forces then differ by less than 1e-5 of the
 * largest, and results are the same in every run on the same device. */
#ifndef RELIEVO_TISSUE_H
#define RELIEVO_TISSUE_H

#include "relievo/bytes.h"
#include "relievo/grid.h"
#include "relievo/mesh.h"

/* A model. */
typedef struct RlvTissue {
    uint64_t id;
} RlvTissue;

/* A model in motion. */
typedef struct RlvTissueSimulation {
    uint64_t id;
} RlvTissueSimulation;

typedef enum RlvTissuePurpose {
    RLV_TISSUE_HOLD = 0,  /* nodes near the surface do not move */
    RLV_TISSUE_SLIDE = 1, /* nodes near the surface keep their distance from it */
    RLV_TISSUE_BIND = 2   /* the surface follows the model */
} RlvTissuePurpose;

typedef enum RlvTissueBody {
    RLV_TISSUE_FLOOR = 0, /* all below z = 0 */
    RLV_TISSUE_BALL = 1,  /* a ball about the origin */
    RLV_TISSUE_MESH = 2   /* a closed mesh */
} RlvTissueBody;

/* A nearly incompressible neo-Hookean material. */
typedef struct RlvTissueMaterial {
    uint32_t struct_size;
    float density;       /* kg/m3; 0 for that of the library, or 1000 */
    const char *name;
    const char *library; /* stratum corneum, dermis, hypodermis, muscle or tendon; NULL for the numbers below */
    float young;         /* Young's modulus, Pa */
    float poisson;       /* Poisson's ratio, -0.99 to 0.4999 */
} RlvTissueMaterial;

#define RLV_TISSUE_MATERIAL_INIT {sizeof(RlvTissueMaterial), 0, NULL, NULL, 0, 0.49f}

/* A volume of a model: a closed mesh, counter-clockwise seen from outside, or a muscle of rings of control points. */
typedef struct RlvTissueVolume {
    uint32_t struct_size;
    uint32_t level; /* 0 makes elements; each lower level overrides those above it within them */
    const char *name;
    RlvMesh mesh;        /* the surface; RLV_NULL of a muscle of rings */
    uint32_t material;   /* index of the material */
    uint32_t has_layers; /* 1 if it has the layers of the skin */
    uint32_t is_muscle;  /* 1 for a muscle of the name of the volume */
    float stiffness;     /* passive stiffness of a muscle's fibres, Pa */
    float strength;      /* isometric stress of a muscle at full activation, Pa */
    uint32_t ring_size;  /* control points of a ring, 4 or more */
    double direction[3]; /* direction of the fibres of a muscle with a mesh */
    const double *rings; /* x, y, z and weight of each control point, ring after ring along the muscle; or NULL */
    size_t ring_count;   /* 2 or more, or 0 for a mesh */
} RlvTissueVolume;

#define RLV_TISSUE_VOLUME_INIT {sizeof(RlvTissueVolume), 0, NULL, {0}, 0, 0, 0, 0, 0, 0, {0, 0, 0}, NULL, 0}

/* A layer of the skin by its depth below the outer surface. Layers may overlap, and then mix. */
typedef struct RlvTissueLayer {
    uint32_t struct_size;
    uint32_t material; /* index of the material */
    float start;       /* depth at which it starts, metres */
    float thickness;   /* metres */
} RlvTissueLayer;

#define RLV_TISSUE_LAYER_INIT {sizeof(RlvTissueLayer), 0, 0, 0}

/* A surface that holds nodes or follows them. */
typedef struct RlvTissueSurface {
    uint32_t struct_size;
    uint32_t purpose; /* RlvTissuePurpose */
    const char *name; /* also of the set of the nodes that it holds */
    RlvMesh mesh;     /* its normals point out of the model */
    uint32_t is_internal; /* 1 if it lies within the model, 0 if it is a part of its border */
    float angle;      /* largest angle between its normals and those of the nodes that an external one holds, radians */
} RlvTissueSurface;

#define RLV_TISSUE_SURFACE_INIT {sizeof(RlvTissueSurface), 0, NULL, {0}, 0, 1.55334303f}

/* What a model is built from. Strides are in bytes, 0 for packed. */
typedef struct RlvTissueDescription {
    uint32_t struct_size;
    uint32_t samples; /* of a voxel along each axis, 1 to 32 */
    float cell[3];    /* size of a voxel along each axis, metres */
    float share;      /* share of its samples inside above which a voxel is an element, 0 to below 1 */
    const RlvTissueMaterial *materials;
    size_t material_count;
    size_t material_stride;
    const RlvTissueVolume *volumes; /* at most 64, of which one at least is on level 0 */
    size_t volume_count;
    size_t volume_stride;
    const RlvTissueSurface *surfaces;
    size_t surface_count;
    size_t surface_stride;
    RlvMesh skin; /* the outer skin, normals outwards, which need not be closed; RLV_NULL for none */
    const RlvTissueLayer *layers;
    size_t layer_count;
    size_t layer_stride;
    uint32_t epidermis_material; /* index of the material of an outermost layer that is thinner than voxels */
    float epidermis_thickness;   /* its thickness, metres; 0 for none */
    /* Radii in metres to which the finished model is bent: of arcs along x about a vertical axis, and of arcs along z. Its
     * skin is then the plane y = 0 and looks along -y. Two zeros do not bend the model. */
    double bend[2];
} RlvTissueDescription;

#define RLV_TISSUE_DESCRIPTION_INIT \
    {sizeof(RlvTissueDescription), 4, {0, 0, 0}, 0.5f, NULL, 0, 0, NULL, 0, 0, NULL, 0, 0, {0}, NULL, 0, 0, 0, 0, {0, 0}}

/* A range of values of a scan or a grid that is a material. */
typedef struct RlvTissueLabel {
    uint32_t struct_size;
    uint32_t material; /* index of the material */
    float low;         /* the least value */
    float high;        /* the largest value */
} RlvTissueLabel;

#define RLV_TISSUE_LABEL_INIT {sizeof(RlvTissueLabel), 0, 0, 0}

/* What a scan or a grid becomes. Strides are in bytes, 0 for packed. */
typedef struct RlvTissueLabels {
    uint32_t struct_size;
    uint32_t block; /* voxels along an edge of an element, 1 to 64 */
    float share;    /* share of labelled voxels above which a block is an element, 0 to below 1 */
    uint32_t reserved;
    const RlvTissueMaterial *materials;
    size_t material_count;
    size_t material_stride;
    const RlvTissueLabel *labels; /* the first whose range has the value of a voxel is its label */
    size_t label_count;
    size_t label_stride;
} RlvTissueLabels;

#define RLV_TISSUE_LABELS_INIT {sizeof(RlvTissueLabels), 1, 0.5f, 0, NULL, 0, 0, NULL, 0, 0}

/* What a model was built from. */
typedef struct RlvTissueReport {
    uint32_t struct_size;
    uint32_t voxels[3]; /* of the grid along each axis */
    double volume;      /* by the shares of all voxels, m3 */
} RlvTissueReport;

#define RLV_TISSUE_REPORT_INIT {sizeof(RlvTissueReport), {0, 0, 0}, 0}

/* Counts and sizes of a model. */
typedef struct RlvTissueInfo {
    uint32_t struct_size;
    uint32_t has_cells; /* 1 if all elements are boxes of the size cell */
    size_t node_count;
    size_t element_count;
    float cell[3]; /* size of an element, m */
    float low[3];  /* lowest corner of the box around the nodes, m */
    float high[3]; /* highest corner, m */
    uint32_t material_count;
    uint32_t muscle_count;
    uint32_t set_count;
    uint32_t bound_count; /* surfaces that follow the model */
    uint32_t checksum;    /* CRC-32 of its file without the header */
} RlvTissueInfo;

#define RLV_TISSUE_INFO_INIT {sizeof(RlvTissueInfo), 0, 0, 0, {0, 0, 0}, {0, 0, 0}, {0, 0, 0}, 0, 0, 0, 0, 0}

/* A muscle of a model. */
typedef struct RlvTissueMuscle {
    uint32_t struct_size;
    uint32_t reserved;
    float stiffness; /* passive stiffness of the fibres, Pa */
    float strength;  /* isometric stress at full activation, Pa */
    char name[RLV_NAME_SIZE];
} RlvTissueMuscle;

#define RLV_TISSUE_MUSCLE_INIT {sizeof(RlvTissueMuscle), 0, 0, 0, {0}}

/* Nodes that have a name. */
typedef struct RlvTissueSet {
    uint32_t struct_size;
    uint32_t reserved;
    size_t count;
    char name[RLV_NAME_SIZE];
} RlvTissueSet;

#define RLV_TISSUE_SET_INIT {sizeof(RlvTissueSet), 0, 0, {0}}

/* How a model is simulated. */
typedef struct RlvTissueOptions {
    uint32_t struct_size;
    uint32_t halvings;   /* how often a step may be halved where an element turns inside out, 0 to 16 */
    float gravity[3];    /* acceleration of all nodes, m/s2 */
    float damping;       /* proportional to mass, 1/s; 0 or more */
    float step;          /* seconds of a step; 0 for the stable step times safety */
    float safety;        /* share of the stable step at rest; above 0, at most 1 */
    float hourglass;     /* resistance to hourglass modes; 1 gives a beam of boxes its bending stiffness; 0 to 10 */
    float mass_scaling;  /* seconds of a step that elements get more mass for; 0 for none */
    float self_friction; /* friction of the model against itself, 0 or more; -1 lets it pass through itself */
} RlvTissueOptions;

#define RLV_TISSUE_OPTIONS_INIT {sizeof(RlvTissueOptions), 0, {0, 0, -9.81f}, 0, 0, 0.7f, 1, 0, -1}

/* Where a simulation is. */
typedef struct RlvTissueSimulationInfo {
    uint32_t struct_size;
    uint32_t stiffest_element; /* the element that allows no longer step */
    float step;                /* seconds of a step */
    float stable_step;         /* the longest stable step of the model at rest, with added mass */
    float added_mass;          /* for mass_scaling, as a share of the mass of the model */
    uint32_t reserved;
    uint64_t steps;  /* so far */
    double seconds;  /* so far */
    uint64_t halved; /* stretches of up to 64 steps that were gone by shorter ones */
} RlvTissueSimulationInfo;

#define RLV_TISSUE_SIMULATION_INFO_INIT {sizeof(RlvTissueSimulationInfo), 0, 0, 0, 0, 0, 0, 0, 0}

/* Energies of a simulation. */
typedef struct RlvTissueEnergies {
    uint32_t struct_size;
    uint32_t reserved;
    double kinetic;   /* of all nodes, J */
    double elastic;   /* of deformation, without that of active muscles, J */
    double potential; /* of gravity, J; 0 at rest */
} RlvTissueEnergies;

#define RLV_TISSUE_ENERGIES_INIT {sizeof(RlvTissueEnergies), 0, 0, 0, 0}

/* How the search for the rest ended. */
typedef struct RlvTissueRelaxation {
    uint32_t struct_size;
    uint32_t is_at_rest; /* 1 if the unbalanced force is at most the tolerance times the largest one */
    uint64_t steps;
    float unbalanced; /* largest unbalanced force on a node, N */
    float largest;    /* largest force of elements on a node, N */
} RlvTissueRelaxation;

#define RLV_TISSUE_RELAXATION_INIT {sizeof(RlvTissueRelaxation), 0, 0, 0, 0}

/* A body that nodes do not enter. Between keys it moves linearly; before the first and after the last it stands still. */
typedef struct RlvTissueCollider {
    uint32_t struct_size;
    uint32_t body;             /* RlvTissueBody */
    RlvMesh mesh;              /* of RLV_TISSUE_MESH, in the space of the body */
    float radius;              /* of RLV_TISSUE_BALL, metres */
    float friction;            /* coefficient of Coulomb friction, 0 or more */
    const double *times;       /* of the keys, seconds, in rising order */
    const float *translations; /* three numbers a key, metres; NULL for none */
    const float *rotations;    /* three numbers a key, a rotation vector in radians about the origin; NULL for none */
    size_t key_count;
} RlvTissueCollider;

#define RLV_TISSUE_COLLIDER_INIT {sizeof(RlvTissueCollider), 0, {0}, 0, 0, NULL, NULL, NULL, 0}

/* Arrays that rlv_tissue_simulation_get writes. Each is packed, and NULL leaves it out. */
typedef struct RlvTissueArrays {
    uint32_t struct_size;
    uint32_t reserved;
    size_t node_count;         /* room in the arrays of nodes */
    float *positions;          /* three numbers a node, metres */
    float *velocities;         /* three numbers a node, m/s, half a step ago */
    size_t element_count;      /* room in the arrays of elements */
    float *stresses;           /* six numbers an element, Cauchy stress in Pa: xx, yy, zz, yz, zx, xy */
    float *principal_stresses; /* three numbers an element, Pa, the largest first */
    float *von_mises;          /* von Mises stress, Pa */
    float *volumes;            /* volume as a share of that at rest */
    float *fibre_stretches;    /* stretch of the first family of fibres; 1 where there is none */
    float *strains;            /* six numbers an element, Green-Lagrange strain, of the tensor: xx, yy, zz, yz, zx, xy */
    float *principal_strains;  /* three numbers an element, the largest first: (l * l - 1) / 2 for a stretch l */
    float *contact_pressures;  /* a number a node, Pa: with which colliders press on it, 0 where none touches */
} RlvTissueArrays;

#define RLV_TISSUE_ARRAYS_INIT \
    {sizeof(RlvTissueArrays), 0, 0, NULL, NULL, 0, NULL, NULL, NULL, NULL, NULL, NULL, NULL, NULL}

/* Builds a model from surfaces. The six borders of the grid become the sets x-, x+, y-, y+, z- and z+. progress and report
 * may be NULL. Fails if a number is out of range, a material does not exist, the surface of a volume is open or inside out,
 * no voxel is an element, a place is too far from the skin to be bent, or the model does not fit the memory limit; the
 * message names the surface. */
RLV_API RlvResult rlv_tissue_build(RlvContext context, const RlvTissueDescription *description, RlvProgress progress,
                                   void *user, RlvTissueReport *report, RlvTissue *out);

/* Makes a block of equal boxes: its lowest corner and the size of an element, three numbers each in metres, and the number
 * of elements along each axis. Fails if a size is not positive, a number is 0, or memory does not suffice. */
RLV_API RlvResult rlv_tissue_block(RlvContext context, const double *low, const float *cell, const uint32_t *counts,
                                   const RlvTissueMaterial *material, RlvTissue *out);

/* Makes a model of a labelled scan, a file of NIfTI-1. report may be NULL. Fails if the file is damaged or its numbers are of
 * a kind that is not read, a label has no material, or no block has enough labelled voxels. */
RLV_API RlvResult rlv_tissue_scan(RlvContext context, const char *path, const RlvTissueLabels *labels,
                                  RlvTissueReport *report, RlvTissue *out);

/* Makes a model of the active voxels of a grid: a level set, whose values are negative inside, fog, or labels. report may be
 * NULL. Fails if voxels are not boxes along the axes, or as rlv_tissue_scan. */
RLV_API RlvResult rlv_tissue_from_grid(RlvGrid grid, const RlvTissueLabels *labels, RlvTissueReport *report,
                                       RlvTissue *out);

/* Reads a model: .inp of Abaqus and CalculiX, or otherwise .rtissue. Keywords of .inp that are passed over are logged as
 * warnings. Fails if the file is damaged, or the model cannot be simulated. */
RLV_API RlvResult rlv_tissue_read(RlvContext context, const char *path, RlvTissue *out);

/* Writes a model: .inp, which has no muscles, sliding nodes and bound surfaces, or otherwise .rtissue. The file appears when
 * it is complete. Fails if the system refuses. */
RLV_API RlvResult rlv_tissue_write(RlvTissue tissue, const char *path);

/* As rlv_tissue_read, from the size bytes of a .rtissue. Fails as that does. */
RLV_API RlvResult rlv_tissue_read_bytes(RlvContext context, const uint8_t *bytes, size_t size, RlvTissue *out);

/* Makes the bytes of the .rtissue that rlv_tissue_write writes. No failure of its own. */
RLV_API RlvResult rlv_tissue_write_bytes(RlvTissue tissue, RlvBytes *out);

RLV_API RlvResult rlv_tissue_retain(RlvTissue tissue);
RLV_API RlvResult rlv_tissue_release(RlvTissue tissue);

/* Counts and sizes. No failure of its own. */
RLV_API RlvResult rlv_tissue_info(RlvTissue tissue, RlvTissueInfo *out);

/* Copies the nodes at rest, three numbers each in metres. Fails if there is not room for all. */
RLV_API RlvResult rlv_tissue_get_nodes(RlvTissue tissue, float *nodes, size_t count, size_t stride);

/* Copies for each element its eight nodes, in VTK's order, and the material with the largest share, packed. Either may be
 * NULL. Fails if there is not room for count elements. */
RLV_API RlvResult rlv_tissue_get_elements(RlvTissue tissue, uint32_t *nodes, uint32_t *materials, size_t count);

/* Finds the muscle of a name. Fails if there is none. */
RLV_API RlvResult rlv_tissue_find_muscle(RlvTissue tissue, const char *name, uint32_t *out);

/* Describes a muscle. Fails if it does not exist. */
RLV_API RlvResult rlv_tissue_muscle(RlvTissue tissue, uint32_t index, RlvTissueMuscle *out);

/* Finds the set of a name. Fails if there is none. */
RLV_API RlvResult rlv_tissue_find_set(RlvTissue tissue, const char *name, uint32_t *out);

/* Describes a set. Fails if it does not exist. */
RLV_API RlvResult rlv_tissue_set(RlvTissue tissue, uint32_t index, RlvTissueSet *out);

/* Copies the nodes of a set. Fails if it does not exist, or there is not room for all. */
RLV_API RlvResult rlv_tissue_get_set(RlvTissue tissue, uint32_t index, uint32_t *nodes, size_t count);

/* Adds a set of the nodes within a box, borders included, of three numbers a corner. Fails if there is a set of that name, or
 * no node is in the box. */
RLV_API RlvResult rlv_tissue_add_set(RlvTissue tissue, const char *name, const double *low, const double *high,
                                     uint32_t *out);

/* Holds nodes along axes: 1 for x, 2 for y, 4 for z, or sums of them. Simulations that were made before do not change.
 * Fails, and holds none, if a node does not exist. */
RLV_API RlvResult rlv_tissue_hold(RlvTissue tissue, const uint32_t *nodes, size_t count, size_t stride, uint32_t axes);

/* Binds the triangles of a mesh to the elements, also points outside of them; out, which may be NULL, is the index of the bound surface.
 * Fails if a point is not finite. */
RLV_API RlvResult rlv_tissue_bind(RlvTissue tissue, RlvMesh mesh, const char *name, uint32_t *out);

/* Makes a simulation of a copy of the model at rest; options may be NULL for the defaults. Fails if an option is out of
 * range, or the step is longer than the stable one, with the element. */
RLV_API RlvResult rlv_tissue_simulate(RlvTissue tissue, const RlvTissueOptions *options, RlvTissueSimulation *out);

RLV_API RlvResult rlv_tissue_simulation_retain(RlvTissueSimulation simulation);
RLV_API RlvResult rlv_tissue_simulation_release(RlvTissueSimulation simulation);

/* Where it is, and its step. No failure of its own. */
RLV_API RlvResult rlv_tissue_simulation_info(RlvTissueSimulation simulation, RlvTissueSimulationInfo *out);

/* Computes the energies in the present state. Fails if an element is inside out. */
RLV_API RlvResult rlv_tissue_simulation_energies(RlvTissueSimulation simulation, RlvTissueEnergies *out);

/* Sets the activation of a muscle, 0 to 1, at count times in rising order; it is linear between them and constant outside.
 * Fails if the muscle does not exist, a value is out of range or times do not rise. */
RLV_API RlvResult rlv_tissue_simulation_activate(RlvTissueSimulation simulation, uint32_t muscle, const double *times,
                                                 const float *values, size_t count);

/* Moves nodes along axes, as for rlv_tissue_hold, by displacements of three numbers at key_count times; without keys they
 * stay where they are at rest. Fails if a node does not exist or times do not rise. */
RLV_API RlvResult rlv_tissue_simulation_drive(RlvTissueSimulation simulation, const uint32_t *nodes, size_t count,
                                              uint32_t axes, const double *times, const float *displacements,
                                              size_t key_count);

/* Sets forces on all nodes, three numbers each in N, in place of those before; a count of 0 takes them away. Fails if there
 * are not as many as nodes, or one is not finite. */
RLV_API RlvResult rlv_tissue_simulation_load(RlvTissueSimulation simulation, const float *forces, size_t count,
                                             size_t stride);

/* Presses on the outer faces of which all nodes are among some, in Pa at times in rising order. The pressure stays normal to
 * the faces. Fails if a node does not exist, there is no such face, or times do not rise. */
RLV_API RlvResult rlv_tissue_simulation_press(RlvTissueSimulation simulation, const uint32_t *nodes, size_t count,
                                              const double *times, const float *pressures, size_t key_count);

/* Adds a body that nodes do not enter. Fails if the radius is not positive, the friction negative, the mesh has no area, or
 * times do not rise. */
RLV_API RlvResult rlv_tissue_simulation_add_collider(RlvTissueSimulation simulation, const RlvTissueCollider *collider);

/* Takes count steps. Fails if an element turns inside out and the step may not be halved again; the state is then the one in
 * which it is, and the message names the element. */
RLV_API RlvResult rlv_tissue_simulation_step(RlvTissueSimulation simulation, uint64_t count);

/* Takes whole steps that end at or just after so many seconds more. progress may be NULL. Fails as
 * rlv_tissue_simulation_step; cancelled, it stays at the last whole step. */
RLV_API RlvResult rlv_tissue_simulation_advance(RlvTissueSimulation simulation, double seconds, RlvProgress progress,
                                                void *user);

/* Goes to rest under gravity, loads, pressures, drives and activations of the present time, in at most so many
 * steps. The time does not go on. progress and out may be NULL. Fails if an element turns inside out. */
RLV_API RlvResult rlv_tissue_simulation_relax(RlvTissueSimulation simulation, float tolerance, uint64_t steps,
                                              RlvProgress progress, void *user, RlvTissueRelaxation *out);

/* Copies the state of nodes and elements. The pressure of contact is the force, normal to a collider, that balances all other
 * forces on the node, by the node's share of the outer faces that look at the collider; contact of the model with itself is
 * left out. Fails, and copies nothing, if there is not room for all, or an element is inside out where pressures are asked
 * for. */
RLV_API RlvResult rlv_tissue_simulation_get(RlvTissueSimulation simulation, const RlvTissueArrays *arrays);

/* Copies the points of a bound surface, three numbers each in metres. Fails if it does not exist, or there is not room for
 * all. */
RLV_API RlvResult rlv_tissue_simulation_get_bound(RlvTissueSimulation simulation, uint32_t index, float *points,
                                                  size_t count, size_t stride);

/* Makes a mesh of a bound surface in the present state, with the point attribute `velocity` in m/s. Fails if it does not exist. */
RLV_API RlvResult rlv_tissue_simulation_mesh(RlvTissueSimulation simulation, uint32_t index, RlvMesh *out);

/* Writes the state to a file, .rtstate, which appears when it is complete. Fails if the system refuses. */
RLV_API RlvResult rlv_tissue_simulation_save(RlvTissueSimulation simulation, const char *path);

/* Goes on from a state file. Activations, drives, loads, pressures and colliders stay. Fails, and changes nothing, if the file
 * is damaged or of another model. */
RLV_API RlvResult rlv_tissue_simulation_restore(RlvTissueSimulation simulation, const char *path);

/* Makes the bytes of the file that rlv_tissue_simulation_save writes. No failure of its own. */
RLV_API RlvResult rlv_tissue_simulation_save_bytes(RlvTissueSimulation simulation, RlvBytes *out);

/* As rlv_tissue_simulation_restore, from the size bytes of a state file. Fails as that does. */
RLV_API RlvResult rlv_tissue_simulation_restore_bytes(RlvTissueSimulation simulation, const uint8_t *bytes, size_t size);

/* Writes the state for VTK, .vtu: displacements, velocities, pressures of contact, stresses, strains, volumes, stretches and
 * materials. Fails if an element is inside out, or the system refuses. */
RLV_API RlvResult rlv_tissue_simulation_write_vtu(RlvTissueSimulation simulation, const char *path);

/* Writes an OpenVDB file with grids of the elements at rest: labels of materials, von Mises stress and volume. Fails if the
 * elements are not equal boxes, or the system refuses. */
RLV_API RlvResult rlv_tissue_simulation_write_vdb(RlvTissueSimulation simulation, const char *path);

#endif
