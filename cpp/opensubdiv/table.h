// The patch table of a control cage, and OpenSubdiv's own evaluators of it.
#pragma once
#include <cstdint>
#include <memory>
#include <vector>

#include <opensubdiv/bfr/refinerSurfaceFactory.h>
#include <opensubdiv/far/patchTable.h>
#include <opensubdiv/far/topologyRefiner.h>
#include <rust/cxx.h>

#include "../exceptions.h"

namespace relievo {
namespace opensubdiv {

// Defined by the bridge (rust/native/opensubdiv/src/bridge.rs), which includes this header first.
struct Cage;
struct Sizes;
struct Patch;

class Table {
public:
    explicit Table(const Cage& cage);
    ~Table();

    int32_t tile_count() const { return patch_table->GetNumPtexFaces(); }
    rust::Slice<const Patch> patches() const;
    rust::Slice<const int32_t> indices() const;
    rust::Slice<const int32_t> stencil_sizes() const;
    rust::Slice<const int32_t> stencil_indices() const;
    rust::Slice<const double> stencil_weights() const;

    // P, du, dv, duu, duv and dvv, 18 numbers for each place, by EvaluateBasis of the patch that PatchMap finds, summed
    // in double. uv holds two numbers for each tile of tiles; points holds three for each point of the table.
    void evaluate(rust::Slice<const double> points, rust::Slice<const int32_t> tiles, rust::Slice<const double> uv,
                  rust::Slice<double> out) const;

    // P, du and dv by EvaluateBasis in float on a lattice of size x size places of every tile, nine numbers a sample,
    // into buffer, from its start again when it is full. Returns the number of samples.
    uint64_t far_grid(rust::Slice<const float> points, uint32_t size, rust::Slice<float> buffer) const;

    const OpenSubdiv::Far::TopologyRefiner& refiner() const { return *topology; }

private:
    void copy_patches(bool single_crease);
    void copy_stencils();

    std::unique_ptr<OpenSubdiv::Far::TopologyRefiner> topology;
    std::unique_ptr<OpenSubdiv::Far::PatchTable> patch_table;
    std::vector<Patch> records;
    std::vector<int32_t> point_indices, sizes, sources;
    std::vector<double> weights;
};

// OpenSubdiv's Bfr evaluator of a table's cage. The table must outlive it.
class BfrEvaluator {
public:
    BfrEvaluator(const Table& table, uint32_t level);

    // As far_grid; points holds three numbers for each point of the cage.
    uint64_t grid(rust::Slice<const float> points, uint32_t size, rust::Slice<float> buffer);

private:
    OpenSubdiv::Bfr::RefinerSurfaceFactory<> factory;
    int face_count;
};

// Estimates what a table holds at the isolations first, first + 1 and so on, one for each of sizes. Patches are estimated
// from above. Levels beyond the first with which there are more faces than face_limit are not refined, and guessed.
void expected_sizes(const Cage& cage, uint32_t first, double face_limit, rust::Slice<Sizes> sizes);
uint32_t version_number();
std::unique_ptr<Table> refine(const Cage& cage);
std::unique_ptr<BfrEvaluator> make_bfr(const Table& table, uint32_t level);

// Estimates, refines, computes the table's points from the cage's and evaluates, as a program in C++ alone does.
void refine_and_evaluate(const Cage& cage, rust::Slice<const double> cage_points, rust::Slice<const int32_t> tiles,
                         rust::Slice<const double> uv, rust::Slice<double> out);

} // namespace opensubdiv
} // namespace relievo
