// OpenSubdiv's own evaluators, for tests and benches.
#include <exception>
#include <memory>
#include <vector>

#include <opensubdiv/bfr/parameterization.h>
#include <opensubdiv/bfr/refinerSurfaceFactory.h>
#include <opensubdiv/bfr/surface.h>

#include "table.h"

using namespace OpenSubdiv;

namespace {

// Where in a buffer the next tile's samples go: from the start again when it is full.
struct Cursor {
    float* buffer;
    int64_t floats, offset;
    float* next(int64_t count) {
        if (offset + count > floats) offset = 0;
        float* out = buffer + offset;
        offset += count;
        return out;
    }
};

} // namespace

extern "C" int32_t rlv_osd_evaluate(const rlv_osd_table* table, const double* points, int32_t place_count,
                                    const int32_t* tiles, const double* uv, double* out) {
    int32_t found = 0;
    try {
        const Far::PatchTable& patches = *table->table;
        const Far::PatchMap map(patches);
        for (int32_t place = 0; place < place_count; ++place) {
            double* result = out + 18 * (size_t)place;
            for (int k = 0; k < 18; ++k) result[k] = 0.0;
            const double u = uv[2 * place], v = uv[2 * place + 1];
            const Far::PatchTable::PatchHandle* handle = map.FindPatch(tiles[place], u, v);
            if (!handle) continue;
            double weights[6][20];
            patches.EvaluateBasis(*handle, u, v, weights[0], weights[1], weights[2], weights[3], weights[4], weights[5]);
            const Far::ConstIndexArray indices = patches.GetPatchVertices(*handle);
            for (int i = 0; i < indices.size(); ++i)
                for (int order = 0; order < 6; ++order)
                    for (int axis = 0; axis < 3; ++axis)
                        result[3 * order + axis] += weights[order][i] * points[3 * (size_t)indices[i] + axis];
            // OpenSubdiv scales derivatives by the level, which on tiles of n-gons is one more than the tile's own.
            if (patches.GetPatchParam(*handle).NonQuadRoot())
                for (int k = 3; k < 18; ++k) result[k] *= k < 9 ? 0.5 : 0.25;
            ++found;
        }
    } catch (const std::exception&) {
        return -1;
    }
    return found;
}

extern "C" int64_t rlv_osd_far_grid(const rlv_osd_table* table, const float* points, int32_t size, float* buffer,
                                    int64_t buffer_floats) {
    int64_t samples = 0;
    Cursor cursor = {buffer, buffer_floats, 0};
    try {
        const Far::PatchTable& patches = *table->table;
        const Far::PatchMap map(patches);
        float weights[3][20];
        for (int tile = 0; tile < table->tile_count; ++tile) {
            float* out = cursor.next(9 * (int64_t)size * size);
            for (int j = 0; j < size; ++j)
                for (int i = 0; i < size; ++i, out += 9) {
                    const float u = (float)i / (float)(size - 1), v = (float)j / (float)(size - 1);
                    const Far::PatchTable::PatchHandle* handle = map.FindPatch(tile, u, v);
                    if (!handle) continue;
                    patches.EvaluateBasis(*handle, u, v, weights[0], weights[1], weights[2]);
                    const Far::ConstIndexArray indices = patches.GetPatchVertices(*handle);
                    float sum[9] = {};
                    for (int k = 0; k < indices.size(); ++k) {
                        const float* point = points + 3 * (size_t)indices[k];
                        for (int order = 0; order < 3; ++order)
                            for (int axis = 0; axis < 3; ++axis) sum[3 * order + axis] += weights[order][k] * point[axis];
                    }
                    for (int k = 0; k < 9; ++k) out[k] = sum[k];
                    ++samples;
                }
        }
    } catch (const std::exception&) {
        return -1;
    }
    return samples;
}

struct rlv_osd_bfr {
    typedef Bfr::RefinerSurfaceFactory<> Factory;
    std::unique_ptr<Factory> factory;
    int face_count = 0;
};

extern "C" rlv_osd_bfr* rlv_osd_bfr_create(const rlv_osd_table* table, int32_t approximation_level, char* error,
                                           size_t error_size) {
    try {
        Bfr::SurfaceFactory::Options options;
        options.SetApproxLevelSmooth(approximation_level);
        options.SetApproxLevelSharp(approximation_level);
        std::unique_ptr<rlv_osd_bfr> bfr(new rlv_osd_bfr);
        bfr->factory.reset(new rlv_osd_bfr::Factory(*table->refiner, options));
        bfr->face_count = table->refiner->GetLevel(0).GetNumFaces();
        return bfr.release();
    } catch (const std::exception& exception) {
        rlv_osd_report(error, error_size, exception.what());
    }
    return nullptr;
}

extern "C" int64_t rlv_osd_bfr_grid(rlv_osd_bfr* bfr, const float* points, int32_t size, float* buffer,
                                    int64_t buffer_floats) {
    int64_t samples = 0;
    Cursor cursor = {buffer, buffer_floats, 0};
    try {
        std::vector<float> patch_points;
        Bfr::Surface<float> surface;
        for (int face = 0; face < bfr->face_count; ++face) {
            if (!bfr->factory->InitVertexSurface(face, &surface)) continue;
            patch_points.resize((size_t)surface.GetNumPatchPoints() * 3);
            surface.PreparePatchPoints(points, 3, patch_points.data(), 3);
            const Bfr::Parameterization parameterization = surface.GetParameterization();
            const int tiles = parameterization.HasSubFaces() ? parameterization.GetFaceSize() : 1;
            for (int tile = 0; tile < tiles; ++tile) {
                float* out = cursor.next(9 * (int64_t)size * size);
                for (int j = 0; j < size; ++j)
                    for (int i = 0; i < size; ++i, out += 9) {
                        const float sub[2] = {(float)i / (float)(size - 1), (float)j / (float)(size - 1)};
                        float uv[2] = {sub[0], sub[1]};
                        if (tiles > 1) parameterization.ConvertNormalizedSubFaceToCoord(tile, sub, uv);
                        surface.Evaluate(uv, patch_points.data(), 3, out, out + 3, out + 6);
                        ++samples;
                    }
            }
        }
    } catch (const std::exception&) {
        return -1;
    }
    return samples;
}

extern "C" void rlv_osd_bfr_free(rlv_osd_bfr* bfr) { delete bfr; }
