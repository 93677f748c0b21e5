/* Relievo: checks and repairs of meshes as users import them.
 *
 * A repair welds points, drops degenerate and doubled faces, turns faces over until neighbours agree and closed parts
 * face outwards, splits non-manifold edges and points, and fills holes (Liepa 2003). The result is an oriented manifold
 * with the attributes of the mesh. A check reports the same and changes nothing. Results do not depend on the number of
 * threads. Lengths are in object units. */
#ifndef RELIEVO_REPAIR_H
#define RELIEVO_REPAIR_H

#include "relievo/mesh.h"
#include "relievo/parameter.h"

/* The steps of a repair, 1 to make them and 0 to leave them out. rlv_repair_params has ranges, units and defaults. */
typedef struct RlvRepairSettings {
    uint32_t struct_size;
    uint32_t weld;       /* joins points at the same place; points that faces surround stay */
    float tolerance;     /* distance within which points are joined, 0 for equal coordinates only, object units */
    uint32_t degenerate; /* drops faces with fewer than three different points */
    uint32_t duplicates; /* drops all but the first of the faces that have the same points */
    uint32_t orient;     /* turns faces over until neighbours agree and closed components face outwards */
    uint32_t split;      /* splits edges of more than two faces and points of more than one fan */
    uint32_t fill;       /* fills holes */
    uint32_t hole_edges; /* most edges of a hole that is filled; 0 for any number */
    float hole_area;     /* largest area of a filling, as a share of the area of its component */
    uint32_t refine;     /* adds points to fillings until their triangles are as large as those around */
    uint32_t fair;       /* moves these points so that the filling continues the curvature around */
    uint32_t unused;     /* drops points that no face uses */
    uint32_t listed;     /* most elements of each kind that the report names; it has room for 8 */
} RlvRepairSettings;

#define RLV_REPAIR_SETTINGS_INIT {sizeof(RlvRepairSettings), 1, 0.0f, 1, 1, 1, 1, 1, 0, 0.75f, 1, 1, 1, 8}

/* How many elements have a defect, and the first of them by their numbers in the mesh that was given. */
typedef struct RlvRepairFinding {
    size_t count;
    uint32_t first[16]; /* pairs: the two points of an edge, or a point or face and UINT32_MAX; UINT32_MAX after the last */
} RlvRepairFinding;

/* The connectivity of a mesh and its measures. */
typedef struct RlvRepairTopology {
    size_t points; /* that a face uses */
    size_t faces;
    size_t edges;
    size_t boundary_edges; /* of one face */
    size_t boundary_loops;
    size_t non_manifold_edges; /* of more than two faces */
    size_t components;         /* that share no edge */
    size_t closed_components;  /* all of whose edges have two faces */
    int32_t euler;             /* points less edges plus faces */
    uint32_t reserved;
    double area;               /* square object units */
    double volume;             /* signed, of the closed components, cubic object units */
} RlvRepairTopology;

/* What a check found and a repair changed. */
typedef struct RlvRepairReport {
    uint32_t struct_size;
    uint32_t is_solid;                    /* 1: closed, manifold and oriented, without degenerate or doubled faces */
    RlvRepairFinding invalid_faces;       /* points that do not exist or are not finite; always dropped */
    RlvRepairFinding coincident_points;   /* that are or would be welded to an earlier one */
    RlvRepairFinding unused_points;       /* that no face uses */
    RlvRepairFinding degenerate_faces;    /* fewer than three different points, or a point twice */
    RlvRepairFinding flat_faces;          /* different points and no area; these stay */
    RlvRepairFinding duplicate_faces;     /* the points of an earlier face */
    RlvRepairFinding non_manifold_edges;  /* more than two faces */
    RlvRepairFinding non_manifold_points; /* faces that share no edge there */
    RlvRepairFinding misoriented_edges;   /* two faces that do not agree about their front */
    RlvRepairFinding one_sided_edges;     /* where a one-sided part has to be cut */
    RlvRepairFinding inverted_components; /* closed ones that face inwards, by their first face */
    RlvRepairFinding holes;               /* boundary loops, by an edge of each */
    RlvRepairFinding open_holes;          /* boundary loops that a repair left open */
    RlvRepairTopology before;             /* after welding points and dropping faces, before all else */
    RlvRepairTopology after;              /* of the repaired mesh */
    size_t turned_faces;                  /* faces that were turned over */
    size_t split_points;                  /* points that splits have added */
    size_t filled_holes;                  /* boundary loops that were filled */
    size_t filling_points;                /* points that fillings have added */
    size_t filling_faces;                 /* faces that fillings have added */
    size_t seam_attributes; /* attributes of points that are now of corners, because welded points had different values */
} RlvRepairReport;

#define RLV_REPAIR_REPORT_INIT \
    {sizeof(RlvRepairReport), 0, {0, {0}}, {0, {0}}, {0, {0}}, {0, {0}}, {0, {0}}, {0, {0}}, {0, {0}}, {0, {0}}, \
     {0, {0}}, {0, {0}}, {0, {0}}, {0, {0}}, {0, {0}}, {0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0.0, 0.0}, \
     {0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0.0, 0.0}, 0, 0, 0, 0, 0, 0}

/* The table of RlvRepairSettings, which lives as long as the process. No failure of its own. */
RLV_API RlvResult rlv_repair_params(const RlvParameter **params, size_t *count);

/* Checks a mesh. settings and progress may be NULL. Fails if a setting is out of range, with RLV_ERROR_MEMORY if it would
 * take more than the context's memory limit, and with RLV_ERROR_CANCELLED. */
RLV_API RlvResult rlv_repair_check(RlvMesh mesh, const RlvRepairSettings *settings, RlvProgress progress, void *user,
                                   RlvRepairReport *report);

/* Makes a repaired mesh of a mesh. settings, progress and report may be NULL. Attributes of points at which welded points
 * differ become attributes of corners; new points of fillings have mean values, and new faces those of the face beside
 * the hole. Fails as rlv_repair_check does, and if no face is left. */
RLV_API RlvResult rlv_repair_mesh(RlvMesh mesh, const RlvRepairSettings *settings, RlvProgress progress, void *user,
                                  RlvRepairReport *report, RlvMesh *out);

/* Makes a repaired mesh of arrays that rlv_mesh_create may refuse: faces may repeat points, have fewer than three corners
 * or name points that do not exist, and coordinates need not be finite. attributes are attribute_count descriptors
 * without gaps, NULL for none. Fails as rlv_repair_mesh does, and if face sizes or attributes do not fit. */
RLV_API RlvResult rlv_repair_arrays(RlvContext context, const RlvMeshArrays *arrays, const RlvAttributeArrays *attributes,
                                    size_t attribute_count, const RlvRepairSettings *settings, RlvProgress progress,
                                    void *user, RlvRepairReport *report, RlvMesh *out);

/* Makes a repaired mesh of a file that rlv_mesh_read may refuse. path is UTF-8. Fails as rlv_repair_mesh does, and if the
 * file cannot be read. */
RLV_API RlvResult rlv_repair_read(RlvContext context, const char *path, const RlvRepairSettings *settings,
                                  RlvProgress progress, void *user, RlvRepairReport *report, RlvMesh *out);

#endif
