// OpenSubdiv's own evaluators, for tests and benches.
#include <limits>

#include <opensubdiv/bfr/parameterization.h>
#include <opensubdiv/bfr/surface.h>
#include <opensubdiv/far/patchMap.h>

#include "relievo-opensubdiv/src/bridge.rs.h"

using namespace OpenSubdiv;

namespace relievo {
namespace opensubdiv {

namespace {

// Where in a buffer the next tile's samples go: from the start again when it is full.
struct Cursor {
    float* buffer;
    size_t floats, offset;
    float* next(size_t count) {
        if (offset + count > floats) offset = 0;
        float* out = buffer + offset;
        offset += count;
        return out;
    }
};

Bfr::SurfaceFactory::Options bfr_options(uint32_t level) {
    Bfr::SurfaceFactory::Options options;
    options.SetApproxLevelSmooth((int)level);
    options.SetApproxLevelSharp((int)level);
    return options;
}

} // namespace

void Table::evaluate(rust::Slice<const double> points, rust::Slice<const int32_t> tiles, rust::Slice<const double> uv,
                     rust::Slice<double> out) const {
    const double* const point = points.data();
    const int32_t* const tile = tiles.data();
    const double* const place_uv = uv.data();
    const size_t count = tiles.size();
    double* result = out.data();
    const Far::PatchMap map(*patch_table);
    for (size_t place = 0; place < count; ++place, result += 18) {
        for (int k = 0; k < 18; ++k) result[k] = 0.0;
        const double u = place_uv[2 * place], v = place_uv[2 * place + 1];
        const Far::PatchTable::PatchHandle* handle = map.FindPatch(tile[place], u, v);
        if (!handle) continue;
        double basis[6][20];
        patch_table->EvaluateBasis(*handle, u, v, basis[0], basis[1], basis[2], basis[3], basis[4], basis[5]);
        const Far::ConstIndexArray corners = patch_table->GetPatchVertices(*handle);
        for (int i = 0; i < corners.size(); ++i)
            for (int order = 0; order < 6; ++order)
                for (int axis = 0; axis < 3; ++axis)
                    result[3 * order + axis] += basis[order][i] * point[3 * (size_t)corners[i] + axis];
        // OpenSubdiv scales derivatives by the level, which on tiles of n-gons is one more than the tile's own.
        if (patch_table->GetPatchParam(*handle).NonQuadRoot())
            for (int k = 3; k < 18; ++k) result[k] *= k < 9 ? 0.5 : 0.25;
    }
}

uint64_t Table::far_grid(rust::Slice<const float> points, uint32_t size, rust::Slice<float> buffer) const {
    uint64_t samples = 0;
    const float* const first = points.data();
    Cursor cursor = {buffer.data(), buffer.size(), 0};
    const Far::PatchMap map(*patch_table);
    float basis[3][20];
    for (int tile = 0; tile < tile_count(); ++tile) {
        float* out = cursor.next(9 * (size_t)size * size);
        for (uint32_t j = 0; j < size; ++j)
            for (uint32_t i = 0; i < size; ++i, out += 9) {
                const float u = (float)i / (float)(size - 1), v = (float)j / (float)(size - 1);
                const Far::PatchTable::PatchHandle* handle = map.FindPatch(tile, u, v);
                if (!handle) continue;
                patch_table->EvaluateBasis(*handle, u, v, basis[0], basis[1], basis[2]);
                const Far::ConstIndexArray corners = patch_table->GetPatchVertices(*handle);
                float sum[9] = {};
                for (int k = 0; k < corners.size(); ++k) {
                    const float* point = first + 3 * (size_t)corners[k];
                    for (int order = 0; order < 3; ++order)
                        for (int axis = 0; axis < 3; ++axis) sum[3 * order + axis] += basis[order][k] * point[axis];
                }
                for (int k = 0; k < 9; ++k) out[k] = sum[k];
                ++samples;
            }
    }
    return samples;
}

BfrEvaluator::BfrEvaluator(const Table& table, uint32_t level)
    : factory(table.refiner(), bfr_options(level)), face_count(table.refiner().GetLevel(0).GetNumFaces()) {}

uint64_t BfrEvaluator::grid(rust::Slice<const float> points, uint32_t size, rust::Slice<float> buffer) {
    uint64_t samples = 0;
    Cursor cursor = {buffer.data(), buffer.size(), 0};
    std::vector<float> patch_points;
    Bfr::Surface<float> surface;
    for (int face = 0; face < face_count; ++face) {
        if (!factory.InitVertexSurface(face, &surface)) continue;
        patch_points.resize((size_t)surface.GetNumPatchPoints() * 3);
        surface.PreparePatchPoints(points.data(), 3, patch_points.data(), 3);
        const Bfr::Parameterization parameterization = surface.GetParameterization();
        const int tiles = parameterization.HasSubFaces() ? parameterization.GetFaceSize() : 1;
        for (int tile = 0; tile < tiles; ++tile) {
            float* out = cursor.next(9 * (size_t)size * size);
            for (uint32_t j = 0; j < size; ++j)
                for (uint32_t i = 0; i < size; ++i, out += 9) {
                    const float sub[2] = {(float)i / (float)(size - 1), (float)j / (float)(size - 1)};
                    float uv[2] = {sub[0], sub[1]};
                    if (tiles > 1) parameterization.ConvertNormalizedSubFaceToCoord(tile, sub, uv);
                    surface.Evaluate(uv, patch_points.data(), 3, out, out + 3, out + 6);
                    ++samples;
                }
        }
    }
    return samples;
}

std::unique_ptr<BfrEvaluator> make_bfr(const Table& table, uint32_t level) {
    return std::make_unique<BfrEvaluator>(table, level);
}

void refine_and_evaluate(const Cage& cage, rust::Slice<const double> cage_points, rust::Slice<const int32_t> tiles,
                         rust::Slice<const double> uv, rust::Slice<double> out) {
    Sizes expected = {};
    expected_sizes(cage, cage.isolation, std::numeric_limits<double>::infinity(), {&expected, 1});
    const Table table(cage);
    const rust::Slice<const int32_t> sizes = table.stencil_sizes();
    const int32_t* source = table.stencil_indices().data();
    const double* weight = table.stencil_weights().data();
    const double* const first = cage_points.data();
    std::vector<double> points(first, first + cage_points.size());
    points.reserve(points.size() + 3 * sizes.size());
    for (const int32_t size : sizes) {
        double sum[3] = {};
        for (int32_t k = 0; k < size; ++k, ++source, ++weight)
            for (int axis = 0; axis < 3; ++axis) sum[axis] += *weight * first[3 * (size_t)*source + axis];
        points.insert(points.end(), sum, sum + 3);
    }
    table.evaluate({points.data(), points.size()}, tiles, uv, out);
}

} // namespace opensubdiv
} // namespace relievo
