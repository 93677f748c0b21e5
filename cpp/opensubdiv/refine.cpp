// Refinement of a cage, and copies of OpenSubdiv's tables.
#include <algorithm>
#include <cmath>
#include <stdexcept>

#include <opensubdiv/far/patchTableFactory.h>
#include <opensubdiv/far/stencilTableFactory.h>
#include <opensubdiv/version.h>

#include "relievo-opensubdiv/src/bridge.rs.h"

#include "descriptor.h"

using namespace OpenSubdiv;

namespace relievo {
namespace opensubdiv {

namespace {

std::unique_ptr<Far::TopologyRefiner> make_refiner(const Cage& cage) {
    const Far::TopologyDescriptor topology = describe(cage);
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

} // namespace

uint32_t version_number() { return OPENSUBDIV_VERSION_NUMBER; }

// Counts faces and vertices up to level 4, with creases up to level 5. By then features are isolated from one another, and
// every further level adds as many for points and creases that are patches of their own. Other creases, those that cross,
// add twice as many, so with creases what level 5 adds over level 4 is doubled from level to level. Sizes of stencils are
// those of a table of two levels; on later levels they are a quarter larger (measured: 12 to 29 % on cages of quads, of
// triangles and with creases). Counting ends at the first level with which there are more faces than face_limit; what
// further levels add then doubles from level to level.
void expected_sizes(const Cage& cage, uint32_t first, double face_limit, rust::Slice<Sizes> sizes) {
    const bool has_creases = !cage.crease_sharpness.empty() || !cage.sharp_points.empty();
    const int last = (int)first + (int)sizes.size() - 1, sampled = std::min(last, 2);
    const int deepest = std::min(last, has_creases ? 5 : 4);
    const std::unique_ptr<Far::TopologyRefiner> refiner = make_refiner(cage);
    // A level has at most four faces for each of the one before, and the first one for each corner.
    double most = (double)cage.corners.size();
    int counted = 0;
    while (counted < deepest && refiner->GetNumFacesTotal() <= face_limit) {
        double bound = (double)refiner->GetNumFacesTotal();
        for (int further = counted; further < deepest; ++further) bound += most * std::pow(4.0, further - counted);
        counted = bound <= face_limit ? deepest : counted + 1;
        refiner->Unrefine();
        refiner->RefineAdaptive(table_options(cage, (uint32_t)counted).GetRefineAdaptiveOptions());
        most = 4.0 * (double)refiner->GetLevel(refiner->GetMaxLevel()).GetNumFaces();
    }
    const bool is_cut = counted < deepest;
    double faces[11] = {}, vertices[11] = {}, growth[2] = {};
    for (int level = 0; level <= last; ++level) {
        // A cage without features has fewer levels than it may have.
        const bool there = level <= counted && level <= refiner->GetMaxLevel();
        faces[level] = there ? (double)refiner->GetLevel(level).GetNumFaces() : 0.0;
        vertices[level] = there ? (double)refiner->GetLevel(level).GetNumVertices() : 0.0;
        if (level > counted) {
            faces[level] = faces[level - 1] + (growth[0] *= 2.0);
            vertices[level] = vertices[level - 1] + (growth[1] *= 2.0);
        } else if (level > 1 && has_creases) {
            growth[0] = std::max(faces[level] - faces[level - 1], 0.0);
            growth[1] = std::max(vertices[level] - vertices[level - 1], 0.0);
        }
        if (is_cut && level == counted) {
            growth[0] = faces[level];
            growth[1] = vertices[level];
        }
    }
    // Where a sample would take long, it is guessed: cages of quads and triangles have 9 to 11 weights a stencil.
    const double sample_vertices = vertices[1] + vertices[2];
    Sizes sample = {faces[0] + faces[1] + faces[2], 11.0 * 1.6 * sample_vertices, 0.0};
    sample.pieces = (cage.crease_sharpness.empty() ? 1.0 : 3.0) * sample.patches;
    double stencils = 1.6 * sample_vertices;
    if (sample_vertices < 300000.0 && counted >= sampled) {
        Cage coarse = cage;
        coarse.isolation = (uint32_t)sampled;
        const Table table(coarse);
        const rust::Slice<const Patch> patches = table.patches();
        const auto creased = std::count_if(patches.begin(), patches.end(), [](const Patch& it) { return it.crease != 0; });
        sample.patches = (double)patches.size();
        sample.pieces = (double)patches.size() + 2.0 * (double)creased;
        sample.weights = (double)table.stencil_weights().size();
        stencils = (double)table.stencil_sizes().size();
    }
    const double weights = stencils > 0.0 ? sample.weights / stencils : 0.0;
    for (int level = (int)first; level <= last; ++level) {
        Sizes& expected = sizes[(size_t)(level - (int)first)];
        expected = sample;
        for (int further = sampled + 1; further <= level; ++further) {
            expected.patches += 0.5 * faces[further];
            expected.pieces += 0.5 * faces[further];
            expected.weights += 1.25 * weights * vertices[further];
        }
        if (level < sampled) expected.weights -= weights * vertices[sampled];
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
