#include "refine.h"

#include <algorithm>
#include <cstdio>
#include <exception>
#include <stdexcept>

#include "table.h"

using namespace OpenSubdiv;

namespace {

Sdc::Options subdivision_options(const rlv_osd_cage& cage) {
    Sdc::Options options;
    options.SetVtxBoundaryInterpolation(cage.boundary_rule == 0 ? Sdc::Options::VTX_BOUNDARY_EDGE_AND_CORNER
                                                                : Sdc::Options::VTX_BOUNDARY_EDGE_ONLY);
    options.SetCreasingMethod(Sdc::Options::CREASE_UNIFORM);
    return options;
}

std::unique_ptr<Far::TopologyRefiner> make_refiner(const rlv_osd_cage& cage) {
    Far::TopologyDescriptor topology;
    topology.numVertices = cage.point_count;
    topology.numFaces = cage.face_count;
    topology.numVertsPerFace = cage.face_sizes;
    topology.vertIndicesPerFace = cage.corners;
    topology.numCreases = cage.crease_count;
    topology.creaseVertexIndexPairs = cage.crease_points;
    topology.creaseWeights = cage.crease_sharpness;
    topology.numCorners = cage.sharp_point_count;
    topology.cornerVertexIndices = cage.sharp_points;
    topology.cornerWeights = cage.sharp_point_sharpness;
    topology.numHoles = cage.hole_count;
    topology.holeIndices = cage.holes;
    typedef Far::TopologyRefinerFactory<Far::TopologyDescriptor> Factory;
    Factory::Options options(Sdc::SCHEME_CATMARK, subdivision_options(cage));
    std::unique_ptr<Far::TopologyRefiner> refiner(Factory::Create(topology, options));
    if (!refiner) throw std::runtime_error("OpenSubdiv cannot refine this topology");
    return refiner;
}

Far::PatchTableFactory::Options table_options(const rlv_osd_cage& cage, int isolation) {
    Far::PatchTableFactory::Options options(isolation);
    options.useInfSharpPatch = true;
    options.useSingleCreasePatch = cage.single_crease != 0;
    options.generateVaryingTables = false;
    options.generateVaryingLocalPoints = false;
    options.generateFVarLegacyLinearPatches = false;
    options.generateLegacySharpCornerPatches = false;
    options.SetPatchPrecision<double>();
    options.SetEndCapType(Far::PatchTableFactory::Options::ENDCAP_GREGORY_BASIS);
    return options;
}

int faces_at(const rlv_osd_cage& cage, int isolation) {
    std::unique_ptr<Far::TopologyRefiner> refiner = make_refiner(cage);
    refiner->RefineAdaptive(table_options(cage, isolation).GetRefineAdaptiveOptions());
    return refiner->GetNumFacesTotal();
}

// Faces of all levels, which are more than the patches: counted up to level 3. Beyond, point features add a fixed number
// a level, creases at most twice as many as the level before, so doubling what level 3 adds over level 2 is an upper
// estimate.
void expected_patches(const rlv_osd_cage& cage, int first, int last, double* counts) {
    double faces[4] = {};
    for (int level = last <= 3 ? first : std::min(first, 2); level <= std::min(last, 3); ++level)
        faces[level] = faces_at(cage, level);
    double added = faces[3] - faces[2], total = faces[3];
    for (int level = 1; level <= last; ++level) {
        if (level > 3) total += (added *= 2.0);
        if (level >= first) counts[level - first] = level <= 3 ? faces[level] : total;
    }
}

void copy_patches(rlv_osd_table& out, const Far::PatchTable& table, bool single_crease) {
    for (int array = 0; array < table.GetNumPatchArrays(); ++array) {
        const bool regular = table.GetPatchArrayDescriptor(array).GetType() == Far::PatchDescriptor::REGULAR;
        for (int patch = 0; patch < table.GetNumPatches(array); ++patch) {
            const Far::PatchParam param = table.GetPatchParam(array, patch);
            rlv_osd_patch record = {};
            record.tile = param.GetFaceId();
            record.u = param.GetU();
            record.v = param.GetV();
            record.depth = (uint8_t)(param.GetDepth() - (param.NonQuadRoot() ? 1 : 0));
            record.boundary = (uint8_t)(param.GetBoundary() & 0xf);
            record.kind = regular ? 0 : 1;
            const float sharpness = regular && single_crease ? table.GetSingleCreasePatchSharpnessValue(array, patch) : 0.0f;
            if (sharpness > 0.0f) {
                // The boundary bit of a single-crease patch names its creased edge.
                for (int edge = 0; edge < 4; ++edge)
                    if (record.boundary == 1 << edge) record.crease = (uint8_t)(1 + edge);
                record.boundary = 0;
                record.sharpness = sharpness;
            }
            record.first = (uint32_t)out.indices.size();
            const Far::ConstIndexArray points = table.GetPatchVertices(array, patch);
            out.indices.insert(out.indices.end(), points.begin(), points.end());
            out.patches.push_back(record);
        }
    }
}

void copy_stencils(rlv_osd_table& out, const Far::TopologyRefiner& refiner, const Far::PatchTable& table) {
    typedef Far::StencilTableReal<double> Stencils;
    typedef Far::StencilTableFactoryReal<double> Factory;
    Factory::Options options;
    options.generateOffsets = true;
    options.generateIntermediateLevels = true;
    std::unique_ptr<const Stencils> refined(Factory::Create(refiner, options));
    if (!refined) throw std::runtime_error("OpenSubdiv cannot build stencils");
    if (const Stencils* local = table.GetLocalPointStencilTable<double>()) {
        std::unique_ptr<const Stencils> all(Factory::AppendLocalPointStencilTable(refiner, refined.get(), local));
        if (all) refined = std::move(all);
    }
    out.stencil_sizes = refined->GetSizes();
    out.stencil_indices = refined->GetControlIndices();
    out.stencil_weights = refined->GetWeights();
}

} // namespace

void rlv_osd_report(char* error, size_t size, const char* text) {
    if (error && size) std::snprintf(error, size, "%s", text);
}

extern "C" int32_t rlv_osd_expected_patches(const rlv_osd_cage* cage, int32_t first, int32_t last, double* counts,
                                            char* error, size_t error_size) {
    try {
        expected_patches(*cage, first, last, counts);
        return 0;
    } catch (const std::exception& exception) {
        rlv_osd_report(error, error_size, exception.what());
    } catch (...) {
        rlv_osd_report(error, error_size, "unknown C++ exception");
    }
    return -1;
}

extern "C" rlv_osd_table* rlv_osd_refine(const rlv_osd_cage* cage, char* error, size_t error_size) {
    try {
        std::unique_ptr<rlv_osd_table> out(new rlv_osd_table);
        out->refiner = make_refiner(*cage);
        const Far::PatchTableFactory::Options options = table_options(*cage, cage->isolation);
        out->refiner->RefineAdaptive(options.GetRefineAdaptiveOptions());
        out->table.reset(Far::PatchTableFactory::Create(*out->refiner, options));
        if (!out->table) throw std::runtime_error("OpenSubdiv cannot build a patch table");
        out->tile_count = out->table->GetNumPtexFaces();
        copy_patches(*out, *out->table, cage->single_crease != 0);
        copy_stencils(*out, *out->refiner, *out->table);
        return out.release();
    } catch (const std::exception& exception) {
        rlv_osd_report(error, error_size, exception.what());
    } catch (...) {
        rlv_osd_report(error, error_size, "unknown C++ exception");
    }
    return nullptr;
}

extern "C" void rlv_osd_arrays_of(const rlv_osd_table* table, rlv_osd_arrays* arrays) {
    arrays->tile_count = table->tile_count;
    arrays->patch_count = (int32_t)table->patches.size();
    arrays->patches = table->patches.data();
    arrays->index_count = (int32_t)table->indices.size();
    arrays->indices = table->indices.data();
    arrays->stencil_count = (int32_t)table->stencil_sizes.size();
    arrays->stencil_sizes = table->stencil_sizes.data();
    arrays->weight_count = (int64_t)table->stencil_weights.size();
    arrays->stencil_indices = table->stencil_indices.data();
    arrays->stencil_weights = table->stencil_weights.data();
}

extern "C" void rlv_osd_free(rlv_osd_table* table) { delete table; }
