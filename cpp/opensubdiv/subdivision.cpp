// Evaluation and uniform refinement of cages under any of OpenSubdiv's schemes.
#include "subdivision.h"

#include <cmath>
#include <stdexcept>

#include <opensubdiv/bfr/parameterization.h>
#include <opensubdiv/bfr/surface.h>
#include <opensubdiv/far/patchMap.h>
#include <opensubdiv/far/patchTableFactory.h>
#include <opensubdiv/far/primvarRefiner.h>
#include <opensubdiv/far/ptexIndices.h>
#include <opensubdiv/far/stencilTableFactory.h>
#include <opensubdiv/osd/cpuEvaluator.h>
#include <opensubdiv/osd/cpuPatchTable.h>

#include "relievo-opensubdiv/src/bridge.rs.h"

#include "descriptor.h"

using namespace OpenSubdiv;

namespace relievo {
namespace opensubdiv {

namespace {

enum { VERTEX = 0, VARYING = 1, FACE_VARYING = 2 };

std::unique_ptr<Far::TopologyRefiner> make_refiner(const Cage& cage, const Rules& rules) {
    static const Sdc::SchemeType schemes[] = {Sdc::SCHEME_CATMARK, Sdc::SCHEME_LOOP, Sdc::SCHEME_BILINEAR};
    static const Sdc::Options::VtxBoundaryInterpolation boundaries[] = {
        Sdc::Options::VTX_BOUNDARY_EDGE_AND_CORNER, Sdc::Options::VTX_BOUNDARY_EDGE_ONLY, Sdc::Options::VTX_BOUNDARY_NONE};
    static const Sdc::Options::FVarLinearInterpolation channels[] = {
        Sdc::Options::FVAR_LINEAR_NONE,         Sdc::Options::FVAR_LINEAR_CORNERS_ONLY,
        Sdc::Options::FVAR_LINEAR_CORNERS_PLUS1, Sdc::Options::FVAR_LINEAR_CORNERS_PLUS2,
        Sdc::Options::FVAR_LINEAR_BOUNDARIES,   Sdc::Options::FVAR_LINEAR_ALL};
    Far::TopologyDescriptor description = describe(cage);
    std::vector<Far::TopologyDescriptor::FVarChannel> described(rules.channel_sizes.size());
    for (size_t k = 0; k < described.size(); ++k) {
        described[k].numValues = rules.channel_sizes[k];
        described[k].valueIndices = rules.channel_corners.data() + k * cage.corners.size();
    }
    description.numFVarChannels = (int)described.size();
    description.fvarChannels = described.data();
    Sdc::Options options;
    options.SetVtxBoundaryInterpolation(boundaries[rules.boundary]);
    options.SetFVarLinearInterpolation(channels[rules.face_varying]);
    options.SetCreasingMethod(rules.chaikin ? Sdc::Options::CREASE_CHAIKIN : Sdc::Options::CREASE_UNIFORM);
    options.SetTriangleSubdivision(rules.smooth_triangles ? Sdc::Options::TRI_SUB_SMOOTH : Sdc::Options::TRI_SUB_CATMARK);
    typedef Far::TopologyRefinerFactory<Far::TopologyDescriptor> Factory;
    std::unique_ptr<Far::TopologyRefiner> refiner(
        Factory::Create(description, Factory::Options(schemes[rules.scheme], options)));
    if (!refiner) throw std::runtime_error("OpenSubdiv cannot refine this topology");
    return refiner;
}

// Up to four numbers, as the refiner of attributes wants a type for them.
struct Value {
    double numbers[4] = {};
    void Clear() { *this = Value(); }
    void AddWithWeight(const Value& other, double weight) {
        for (int k = 0; k < 4; ++k) numbers[k] += weight * other.numbers[k];
    }
};

// Whether second derivatives have the wrong sign, as OpenSubdiv 3.5 gives them in triangles that lie turned in a refined
// level: whether they contradict how first ones change on a small step towards the middle of the triangle.
bool turned(const Bfr::Surface<double>& surface, const double* points, int width, const double uv[2],
            const double found[6][4]) {
    double step[2] = {1e-4 * (1.0 / 3.0 - uv[0]), 1e-4 * (1.0 / 3.0 - uv[1])};
    if (std::abs(step[0]) + std::abs(step[1]) < 1e-5) step[0] = step[1] = 1e-5;
    const double other[2] = {uv[0] + step[0], uv[1] + step[1]};
    double there[3][4] = {}, agreement = 0.0;
    surface.Evaluate(other, points, width, there[0], there[1], there[2]);
    for (int i = 0; i < width; ++i)
        for (int axis = 0; axis < 2; ++axis)
            agreement += (there[1 + axis][i] - found[1 + axis][i]) *
                         (step[0] * found[3 + axis][i] + step[1] * found[4 + axis][i]);
    return agreement < 0.0;
}

} // namespace

Subdivision::Subdivision(const Cage& cage, const Rules& rules) : topology(make_refiner(cage, rules)) {
    Bfr::SurfaceFactory::Options options;
    options.SetApproxLevelSmooth((int)cage.isolation);
    options.SetApproxLevelSharp((int)cage.isolation);
    factory = std::make_unique<Bfr::RefinerSurfaceFactory<Cache>>(*topology, options);
}

void Subdivision::evaluate(const Primvar& primvar, rust::Slice<const Spot> spots, uint32_t derivatives,
                           rust::Slice<float> out) const {
    const uint32_t interpolation = primvar.interpolation, width = primvar.width;
    const Bfr::SurfaceFactory::FVarID channel = (Bfr::SurfaceFactory::FVarID)primvar.channel;
    Bfr::Surface<double> surface;
    std::vector<double> points;
    int32_t face = -1;
    bool there = false;
    float* result = out.data();
    for (size_t k = 0; k < spots.size(); ++k, result += 6 * width) {
        const Spot spot = spots[k];
        if (spot.face != face) {
            face = spot.face;
            there = interpolation == VERTEX    ? factory->InitVertexSurface(face, &surface)
                    : interpolation == VARYING ? factory->InitVaryingSurface(face, &surface)
                                               : factory->InitFaceVaryingSurface(face, &surface, channel);
            if (there) {
                points.resize((size_t)surface.GetNumPatchPoints() * width);
                surface.GatherControlPoints(primvar.values.data(), (int)width, points.data(), (int)width);
                surface.ComputePatchPoints(points.data(), (int)width);
            }
        }
        for (uint32_t i = 0; i < 6 * width; ++i) result[i] = 0.0f;
        if (!there) continue;
        double uv[2] = {spot.u, spot.v}, scale = 1.0;
        const Bfr::Parameterization parameterization = surface.GetParameterization();
        if (parameterization.HasSubFaces()) {
            // A tile of an n-gon covers half a unit of Bfr's parameters each way.
            const double part[2] = {uv[0], uv[1]};
            parameterization.ConvertNormalizedSubFaceToCoord(spot.part, part, uv);
            scale = 0.5;
        }
        double found[6][4] = {};
        if (derivatives == 0) surface.Evaluate(uv, points.data(), (int)width, found[0]);
        else if (derivatives == 1) surface.Evaluate(uv, points.data(), (int)width, found[0], found[1], found[2]);
        else
            surface.Evaluate(uv, points.data(), (int)width, found[0], found[1], found[2], found[3], found[4], found[5]);
        if (derivatives == 2 && factory->GetSchemeType() == Sdc::SCHEME_LOOP && !surface.IsRegular() &&
            turned(surface, points.data(), (int)width, uv, found))
            for (int order = 3; order < 6; ++order)
                for (double& number : found[order]) number = -number;
        for (uint32_t order = 0; order < 6; ++order) {
            const double by = order == 0 ? 1.0 : order < 3 ? scale : scale * scale;
            for (uint32_t i = 0; i < width; ++i) result[order * width + i] = (float)(by * found[order][i]);
        }
    }
}

Refined::Refined(const Cage& cage, const Rules& rules, uint32_t level) : topology(make_refiner(cage, rules)) {
    Far::TopologyRefiner::UniformOptions options((int)level);
    options.fullTopologyInLastLevel = true;
    topology->RefineUniform(options);
    const Far::TopologyLevel last = topology->GetLevel((int)level);
    for (int face = 0; face < last.GetNumFaces(); ++face) {
        if (last.IsFaceHole(face)) continue;
        visible.push_back(face);
        const Far::ConstIndexArray vertices = last.GetFaceVertices(face);
        sizes.push_back((uint32_t)vertices.size());
        points.insert(points.end(), vertices.begin(), vertices.end());
        int parent = face;
        for (uint32_t from = level; from > 0; --from) parent = topology->GetLevel((int)from).GetFaceParentFace(parent);
        cage_faces.push_back((uint32_t)parent);
    }
}

rust::Vec<uint32_t> Refined::channel_corners(uint32_t channel) const {
    rust::Vec<uint32_t> out;
    out.reserve(points.size());
    const Far::TopologyLevel last = topology->GetLevel(topology->GetMaxLevel());
    for (const int face : visible)
        for (const int value : last.GetFaceFVarValues(face, (int)channel)) out.push_back((uint32_t)value);
    return out;
}

rust::Vec<float> Refined::values(const Primvar& primvar) const {
    const uint32_t interpolation = primvar.interpolation, width = primvar.width;
    const rust::Slice<const float> cage_values = primvar.values;
    const Far::PrimvarRefinerReal<double> refiner(*topology);
    std::vector<Value> from(cage_values.size() / width), to;
    for (size_t k = 0; k < cage_values.size(); ++k) from[k / width].numbers[k % width] = cage_values[k];
    const int last = topology->GetMaxLevel(), number = (int)primvar.channel;
    for (int level = 1; level <= last; ++level) {
        const Far::TopologyLevel refined = topology->GetLevel(level);
        to.assign((size_t)(interpolation == FACE_VARYING ? refined.GetNumFVarValues(number) : refined.GetNumVertices()),
                  Value());
        if (interpolation == VERTEX) refiner.Interpolate(level, from, to);
        else if (interpolation == VARYING) refiner.InterpolateVarying(level, from, to);
        else refiner.InterpolateFaceVarying(level, from, to, number);
        from.swap(to);
    }
    if (interpolation != VARYING) {
        to.assign(from.size(), Value());
        if (interpolation == VERTEX) refiner.Limit(from, to);
        else refiner.LimitFaceVarying(from, to, number);
        from.swap(to);
    }
    rust::Vec<float> out;
    out.reserve(from.size() * width);
    for (const Value& value : from)
        for (uint32_t k = 0; k < width; ++k) out.push_back((float)value.numbers[k]);
    return out;
}

void osd_evaluate(const Cage& cage, const Rules& rules, const Primvar& primvar, rust::Slice<const Spot> spots,
                  rust::Slice<float> out) {
    const uint32_t interpolation = primvar.interpolation, width = primvar.width;
    const int channel = (int)primvar.channel;
    const rust::Slice<const float> values = primvar.values;
    const std::unique_ptr<Far::TopologyRefiner> refiner = make_refiner(cage, rules);
    Far::PatchTableFactory::Options options(cage.isolation);
    options.useInfSharpPatch = true;
    options.generateVaryingTables = true;
    options.generateFVarTables = true;
    options.generateFVarLegacyLinearPatches = false;
    options.SetEndCapType(Far::PatchTableFactory::Options::ENDCAP_GREGORY_BASIS);
    Far::TopologyRefiner::AdaptiveOptions adaptive = options.GetRefineAdaptiveOptions();
    adaptive.considerFVarChannels = refiner->GetNumFVarChannels() > 0;
    refiner->RefineAdaptive(adaptive);
    const std::unique_ptr<const Far::PatchTable> table(Far::PatchTableFactory::Create(*refiner, options));
    typedef Far::StencilTableFactory Factory;
    Factory::Options stencil_options;
    stencil_options.generateOffsets = true;
    stencil_options.generateIntermediateLevels = true;
    stencil_options.interpolationMode = interpolation == VERTEX    ? Factory::INTERPOLATE_VERTEX
                                        : interpolation == VARYING ? Factory::INTERPOLATE_VARYING
                                                                   : Factory::INTERPOLATE_FACE_VARYING;
    stencil_options.fvarChannel = primvar.channel;
    std::unique_ptr<const Far::StencilTable> stencils(Factory::Create(*refiner, stencil_options));
    const Far::StencilTable* const local = interpolation == VERTEX    ? table->GetLocalPointStencilTable()
                                           : interpolation == VARYING ? table->GetLocalPointVaryingStencilTable()
                                                                      : table->GetLocalPointFaceVaryingStencilTable(channel);
    if (local) {
        const Far::StencilTable* all =
            interpolation == FACE_VARYING
                ? Factory::AppendLocalPointStencilTableFaceVarying(*refiner, stencils.get(), local, channel)
            : interpolation == VARYING ? Factory::AppendLocalPointStencilTableVarying(*refiner, stencils.get(), local)
                                       : Factory::AppendLocalPointStencilTable(*refiner, stencils.get(), local);
        if (all) stencils.reset(all);
    }
    const size_t count = values.size() / width;
    std::vector<float> points(values.begin(), values.end());
    points.resize((count + (size_t)stencils->GetNumStencils()) * width);
    const Osd::BufferDescriptor from(0, (int)width, (int)width), to((int)(count * width), (int)width, (int)width);
    Osd::CpuEvaluator::EvalStencils(points.data(), from, points.data(), to, stencils->GetSizes().data(),
                                    stencils->GetOffsets().data(), stencils->GetControlIndices().data(),
                                    stencils->GetWeights().data(), 0, stencils->GetNumStencils());
    const Osd::CpuPatchTable patches(table.get());
    const Far::PatchMap map(*table);
    const Far::PtexIndices tiles(*refiner);
    for (size_t k = 0; k < spots.size(); ++k) {
        const Spot spot = spots[k];
        const int tile = tiles.GetFaceId(spot.face) + spot.part;
        const Far::PatchTable::PatchHandle* handle = map.FindPatch(tile, spot.u, spot.v);
        if (!handle) continue;
        const Osd::PatchCoord place(*handle, spot.u, spot.v);
        float found[6][4] = {};
        const Osd::BufferDescriptor one(0, (int)width, (int)width);
        if (interpolation == VERTEX)
            Osd::CpuEvaluator::EvalPatches(points.data(), from, found[0], one, found[1], one, found[2], one, found[3], one,
                                           found[4], one, found[5], one, 1, &place, patches.GetPatchArrayBuffer(),
                                           patches.GetPatchIndexBuffer(), patches.GetPatchParamBuffer());
        else if (interpolation == VARYING)
            Osd::CpuEvaluator::EvalPatches(points.data(), from, found[0], one, found[1], one, found[2], one, found[3], one,
                                           found[4], one, found[5], one, 1, &place, patches.GetVaryingPatchArrayBuffer(),
                                           patches.GetVaryingPatchIndexBuffer(), patches.GetPatchParamBuffer());
        else
            Osd::CpuEvaluator::EvalPatches(points.data(), from, found[0], one, found[1], one, found[2], one, found[3], one,
                                           found[4], one, found[5], one, 1, &place,
                                           patches.GetFVarPatchArrayBuffer(channel),
                                           patches.GetFVarPatchIndexBuffer(channel),
                                           patches.GetFVarPatchParamBuffer(channel));
        // OpenSubdiv scales derivatives by the level, which on tiles of n-gons is one more than the tile's own.
        const double scale = table->GetPatchParam(*handle).NonQuadRoot() ? 0.5 : 1.0;
        for (uint32_t order = 0; order < 6; ++order) {
            const double by = order == 0 ? 1.0 : order < 3 ? scale : scale * scale;
            for (uint32_t i = 0; i < width; ++i) out[(6 * k + order) * width + i] = (float)(by * found[order][i]);
        }
    }
}

std::unique_ptr<Subdivision> make_subdivision(const Cage& cage, const Rules& rules) {
    return std::make_unique<Subdivision>(cage, rules);
}

std::unique_ptr<Refined> refine_uniformly(const Cage& cage, const Rules& rules, uint32_t level) {
    return std::make_unique<Refined>(cage, rules, level);
}

} // namespace opensubdiv
} // namespace relievo
