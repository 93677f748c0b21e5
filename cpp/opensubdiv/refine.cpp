// Refinement of a cage, and copies of OpenSubdiv's tables.
#include <algorithm>
#include <stdexcept>

#include <opensubdiv/far/patchTableFactory.h>
#include <opensubdiv/far/stencilTableFactory.h>
#include <opensubdiv/far/topologyDescriptor.h>

#include "relievo-opensubdiv/src/bridge.rs.h"

using namespace OpenSubdiv;

namespace relievo {
namespace opensubdiv {

namespace {

std::unique_ptr<Far::TopologyRefiner> make_refiner(const Cage& cage) {
    Far::TopologyDescriptor topology;
    topology.numVertices = (int)cage.point_count;
    topology.numFaces = (int)cage.face_sizes.size();
    topology.numVertsPerFace = cage.face_sizes.data();
    topology.vertIndicesPerFace = cage.corners.data();
    topology.numCreases = (int)cage.crease_sharpness.size();
    topology.creaseVertexIndexPairs = cage.crease_points.data();
    topology.creaseWeights = cage.crease_sharpness.data();
    topology.numCorners = (int)cage.sharp_points.size();
    topology.cornerVertexIndices = cage.sharp_points.data();
    topology.cornerWeights = cage.sharp_point_sharpness.data();
    topology.numHoles = (int)cage.holes.size();
    topology.holeIndices = cage.holes.data();
    Sdc::Options scheme;
    scheme.SetVtxBoundaryInterpolation(cage.round_corners ? Sdc::Options::VTX_BOUNDARY_EDGE_ONLY
                                                          : Sdc::Options::VTX_BOUNDARY_EDGE_AND_CORNER);
    scheme.SetCreasingMethod(Sdc::Options::CREASE_UNIFORM);
    typedef Far::TopologyRefinerFactory<Far::TopologyDescriptor> Factory;
    std::unique_ptr<Far::TopologyRefiner> refiner(
        Factory::Create(topology, Factory::Options(Sdc::SCHEME_CATMARK, scheme)));
    if (!refiner) throw std::runtime_error("OpenSubdiv cannot refine this topology");
    return refiner;
}

Far::PatchTableFactory::Options table_options(const Cage& cage, uint32_t isolation) {
    Far::PatchTableFactory::Options options(isolation);
    options.useInfSharpPatch = true;
    options.useSingleCreasePatch = cage.single_crease;
    options.generateVaryingTables = false;
    options.generateVaryingLocalPoints = false;
    options.generateFVarLegacyLinearPatches = false;
    options.generateLegacySharpCornerPatches = false;
    options.SetPatchPrecision<double>();
    options.SetEndCapType(Far::PatchTableFactory::Options::ENDCAP_GREGORY_BASIS);
    return options;
}

int faces_at(const Cage& cage, uint32_t isolation) {
    const std::unique_ptr<Far::TopologyRefiner> refiner = make_refiner(cage);
    refiner->RefineAdaptive(table_options(cage, isolation).GetRefineAdaptiveOptions());
    return refiner->GetNumFacesTotal();
}

} // namespace

// Counts the faces of all levels, which are more than the patches, up to level 3. Beyond, point features add a fixed
// number a level, creases at most twice as many as the level before, so doubling what level 3 adds over level 2 is an
// upper estimate.
void expected_patches(const Cage& cage, uint32_t first, rust::Slice<double> counts) {
    const uint32_t last = first + (uint32_t)counts.size() - 1;
    double faces[4] = {};
    for (uint32_t level = last <= 3 ? first : std::min(first, 2u); level <= std::min(last, 3u); ++level)
        faces[level] = faces_at(cage, level);
    double added = faces[3] - faces[2], total = faces[3];
    for (uint32_t level = 1; level <= last; ++level) {
        if (level > 3) total += (added *= 2.0);
        if (level >= first) counts[level - first] = level <= 3 ? faces[level] : total;
    }
}

std::unique_ptr<Table> refine(const Cage& cage) { return std::make_unique<Table>(cage); }

Table::Table(const Cage& cage) : topology(make_refiner(cage)) {
    const Far::PatchTableFactory::Options options = table_options(cage, cage.isolation);
    topology->RefineAdaptive(options.GetRefineAdaptiveOptions());
    patch_table.reset(Far::PatchTableFactory::Create(*topology, options));
    if (!patch_table) throw std::runtime_error("OpenSubdiv cannot build a patch table");
    copy_patches(cage.single_crease);
    copy_stencils();
}

Table::~Table() = default;

void Table::copy_patches(bool single_crease) {
    for (int array = 0; array < patch_table->GetNumPatchArrays(); ++array) {
        const bool regular = patch_table->GetPatchArrayDescriptor(array).GetType() == Far::PatchDescriptor::REGULAR;
        for (int patch = 0; patch < patch_table->GetNumPatches(array); ++patch) {
            const Far::PatchParam param = patch_table->GetPatchParam(array, patch);
            Patch record = {};
            record.tile = (uint32_t)param.GetFaceId();
            record.u = param.GetU();
            record.v = param.GetV();
            record.depth = (uint8_t)(param.GetDepth() - (param.NonQuadRoot() ? 1 : 0));
            record.boundary = (uint8_t)(param.GetBoundary() & 0xf);
            record.is_gregory = !regular;
            const float sharpness =
                regular && single_crease ? patch_table->GetSingleCreasePatchSharpnessValue(array, patch) : 0.0f;
            if (sharpness > 0.0f) {
                // The boundary bit of a single-crease patch names its creased edge.
                for (int edge = 0; edge < 4; ++edge)
                    if (record.boundary == 1 << edge) record.crease = (uint8_t)(1 + edge);
                record.boundary = 0;
                record.sharpness = sharpness;
            }
            record.first = (uint32_t)point_indices.size();
            const Far::ConstIndexArray points = patch_table->GetPatchVertices(array, patch);
            point_indices.insert(point_indices.end(), points.begin(), points.end());
            records.push_back(record);
        }
    }
}

void Table::copy_stencils() {
    typedef Far::StencilTableReal<double> Stencils;
    typedef Far::StencilTableFactoryReal<double> Factory;
    Factory::Options options;
    options.generateOffsets = true;
    options.generateIntermediateLevels = true;
    std::unique_ptr<const Stencils> refined(Factory::Create(*topology, options));
    if (!refined) throw std::runtime_error("OpenSubdiv cannot build stencils");
    if (const Stencils* local = patch_table->GetLocalPointStencilTable<double>()) {
        std::unique_ptr<const Stencils> all(Factory::AppendLocalPointStencilTable(*topology, refined.get(), local));
        if (all) refined = std::move(all);
    }
    sizes = refined->GetSizes();
    sources = refined->GetControlIndices();
    weights = refined->GetWeights();
    // OpenSubdiv leaves one weight more for each point of the cage behind the last stencil where there are no local
    // points.
    size_t count = 0;
    for (const int size : sizes) count += (size_t)size;
    if (sources.size() < count || weights.size() < count)
        throw std::runtime_error("OpenSubdiv's stencils lack sources or weights");
    sources.resize(count);
    weights.resize(count);
}

rust::Slice<const Patch> Table::patches() const { return {records.data(), records.size()}; }
rust::Slice<const int32_t> Table::indices() const { return {point_indices.data(), point_indices.size()}; }
rust::Slice<const int32_t> Table::stencil_sizes() const { return {sizes.data(), sizes.size()}; }
rust::Slice<const int32_t> Table::stencil_indices() const { return {sources.data(), sources.size()}; }
rust::Slice<const double> Table::stencil_weights() const { return {weights.data(), weights.size()}; }

} // namespace opensubdiv
} // namespace relievo
