// Level sets from meshes and spheres, and meshes from grids.

#include "guard.h"

#include <openvdb/tools/MeshToVolume.h>
#include <openvdb/tools/ParticlesToLevelSet.h>
#include <openvdb/tools/VolumeToMesh.h>

#include <vector>

struct RlvdbMesh {
    std::vector<openvdb::Vec3s> points;
    std::vector<openvdb::Vec3I> triangles;
    std::vector<openvdb::Vec4I> quads;
};

namespace {

using namespace openvdb;
using relievo::bounded, relievo::dispatch;

// Spheres in the form that openvdb::tools::ParticlesToLevelSet takes.
struct Spheres {
    using PosType = Vec3R;

    const float* points;
    const float* radii;
    std::size_t count;

    std::size_t size() const { return count; }
    void getPos(std::size_t index, Vec3R& place) const {
        place = Vec3R(points[3 * index], points[3 * index + 1], points[3 * index + 2]);
    }
    void getPosRad(std::size_t index, Vec3R& place, Real& radius) const {
        getPos(index, place);
        radius = radii[index];
    }
};

}  // namespace

extern "C" {

std::int32_t rlvdb_from_mesh(const float* points, std::size_t point_count, const std::uint32_t* triangles,
                             std::size_t triangle_count, const double* matrix, float exterior, float interior,
                             const RlvdbCall* call, RlvdbGrid** out, RlvdbError* error) {
    return bounded(call, error, [&](relievo::Interrupter& interrupter) {
        const auto transform = relievo::transform_of(matrix);
        std::vector<Vec3s> places(point_count);
        for (std::size_t index = 0; index < point_count; ++index) {
            places[index] = Vec3s(transform->worldToIndex(Vec3d(Vec3s(points + 3 * index))));
        }
        // The library has this type of adapter compiled in; Vec3I is three unsigned integers.
        const tools::QuadAndTriangleDataAdapter<Vec3s, Vec3I> mesh(
            places.data(), places.size(), reinterpret_cast<const Vec3I*>(triangles), triangle_count);
        auto grid = tools::meshToVolume<FloatGrid>(static_cast<util::NullInterrupter&>(interrupter), mesh, *transform,
                                                   exterior, interior);
        interrupter.check();
        relievo::give(out, grid);
    });
}

std::int32_t rlvdb_from_spheres(const float* points, const float* radii, std::size_t count, double voxel, float band,
                                const RlvdbCall* call, RlvdbGrid** out, RlvdbError* error) {
    return bounded(call, error, [&](relievo::Interrupter& interrupter) {
        auto grid = createLevelSet<FloatGrid>(voxel, band);
        util::NullInterrupter* watch = &interrupter;
        tools::ParticlesToLevelSet<FloatGrid, void, util::NullInterrupter> raster(*grid, watch);
        raster.setRmin(0.0);
        const Spheres spheres{points, radii, count};
        raster.rasterizeSpheres(spheres);
        interrupter.check();
        raster.finalize(/*prune=*/true);
        relievo::give(out, grid);
    });
}

std::int32_t rlvdb_to_mesh(const RlvdbGrid* handle, double value, double adaptivity, const RlvdbCall* call,
                           RlvdbMesh** out, RlvdbError* error) {
    return bounded(call, error, [&](relievo::Interrupter&) {
        auto mesh = std::make_unique<RlvdbMesh>();
        using Types = relievo::Scalars::Append<relievo::Integers>;
        dispatch<Types>(*handle->grid, "meshed; convert it to a level set or to floats", [&](const auto& grid) {
            tools::volumeToMesh(grid, mesh->points, mesh->triangles, mesh->quads, value, adaptivity);
        });
        // OpenVDB turns polygons clockwise, seen from outside; a mirrored transform turns them once more.
        const auto& transform = handle->grid->transform();
        const bool is_mirrored = transform.isLinear() && transform.baseMap()->determinant() < 0.0;
        if (!is_mirrored) {
            for (auto& triangle : mesh->triangles) {
                std::swap(triangle[0], triangle[2]);
            }
            for (auto& quad : mesh->quads) {
                std::swap(quad[0], quad[3]);
                std::swap(quad[1], quad[2]);
            }
        }
        *out = mesh.release();
    });
}

void rlvdb_mesh_view(const RlvdbMesh* mesh, RlvdbMeshView* out) {
    out->points = mesh->points.empty() ? nullptr : mesh->points.front().asPointer();
    out->point_count = mesh->points.size();
    out->triangles = mesh->triangles.empty() ? nullptr : mesh->triangles.front().asPointer();
    out->triangle_count = mesh->triangles.size();
    out->quads = mesh->quads.empty() ? nullptr : mesh->quads.front().asPointer();
    out->quad_count = mesh->quads.size();
}

void rlvdb_mesh_free(RlvdbMesh* mesh) { delete mesh; }

}
