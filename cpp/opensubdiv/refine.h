// C interface of the OpenSubdiv binding: plain structs in, plain arrays out, exceptions turned into error texts.
#pragma once
#include <stddef.h>
#include <stdint.h>

#ifdef __cplusplus
extern "C" {
#endif

// A control cage. Indices were checked by the caller.
typedef struct {
    int32_t point_count, face_count;
    const int32_t* face_sizes;
    const int32_t* corners;
    int32_t crease_count;
    const int32_t* crease_points; // two per crease
    const float* crease_sharpness;
    int32_t sharp_point_count;
    const int32_t* sharp_points;
    const float* sharp_point_sharpness;
    int32_t hole_count;
    const int32_t* holes;
    int32_t boundary_rule; // 0: edges and corners are sharp, 1: edges only
    int32_t isolation;     // 1..10
    int32_t single_crease; // use single-crease patches
} rlv_osd_cage;

// A patch of the adaptive table.
typedef struct {
    int32_t tile;       // Ptex face
    uint16_t u, v;      // position in units of the patch's size
    uint8_t depth;      // size is 2^-depth of the tile
    uint8_t boundary;   // bit e: edge e is a boundary, its outer points are phantoms
    uint8_t kind;       // 0: regular, 16 B-spline points; 1: Gregory, 20 points
    uint8_t crease;     // for single-crease patches 1 + the edge that is creased, else 0
    float sharpness;    // of that crease, at the patch's level
    uint32_t first;     // first index of its points
} rlv_osd_patch;

// Arrays owned by the table.
typedef struct {
    int32_t tile_count;
    int32_t patch_count;
    const rlv_osd_patch* patches;
    int32_t index_count;
    const int32_t* indices;
    // Points beyond the cage's: stencils over the cage's points.
    int32_t stencil_count;
    const int32_t* stencil_sizes;
    int64_t weight_count;
    const int32_t* stencil_indices;
    const double* stencil_weights;
} rlv_osd_arrays;

typedef struct rlv_osd_table rlv_osd_table;

// Patches expected at the isolations first to last, one number each; that of the cage is not looked at. Returns 0, or -1
// and a text in error (of error_size bytes) on failure.
int32_t rlv_osd_expected_patches(const rlv_osd_cage* cage, int32_t first, int32_t last, double* counts, char* error,
                                 size_t error_size);
// Refines and builds the patch table. Returns NULL and a text in error (of error_size bytes) on failure.
rlv_osd_table* rlv_osd_refine(const rlv_osd_cage* cage, char* error, size_t error_size);
void rlv_osd_arrays_of(const rlv_osd_table* table, rlv_osd_arrays* arrays);
void rlv_osd_free(rlv_osd_table* table);

// Reference evaluation in double: EvaluateBasis of the patch found by PatchMap, then the weighted sum of the table's
// points. out has 18 doubles per place: P, du, dv, duu, duv, dvv. Returns the number of places found, -1 on failure.
int32_t rlv_osd_evaluate(const rlv_osd_table* table, const double* points, int32_t place_count, const int32_t* tiles,
                         const double* uv, double* out);

// OpenSubdiv's Far evaluator as a peer, in float: P, du, dv on a size x size lattice of every tile, nine floats per
// sample, from the start of the buffer again when it is full. Returns the number of samples, -1 on failure.
int64_t rlv_osd_far_grid(const rlv_osd_table* table, const float* points, int32_t size, float* buffer,
                         int64_t buffer_floats);

// OpenSubdiv's Bfr evaluator as a peer; the grid is as above, points are the cage's.
typedef struct rlv_osd_bfr rlv_osd_bfr;
rlv_osd_bfr* rlv_osd_bfr_create(const rlv_osd_table* table, int32_t approximation_level, char* error, size_t error_size);
int64_t rlv_osd_bfr_grid(rlv_osd_bfr* bfr, const float* points, int32_t size, float* buffer, int64_t buffer_floats);
void rlv_osd_bfr_free(rlv_osd_bfr* bfr);

#ifdef __cplusplus
}
#endif
