// The C++ side of the OpenSubdiv binding, compiled with the sanitizers as the library's own build cannot be: cages with
// creases, corners, boundaries, holes and faces of any size, small ones and made by chance, refined, read to their last
// number and evaluated; what cannot be refined is an error with a text that ends.
#include "../../cpp/opensubdiv/refine.h"

#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <vector>

#define CHECK(condition)                                                              \
    do {                                                                              \
        if (!(condition)) {                                                           \
            std::fprintf(stderr, "%s:%d: failed: %s\n", __FILE__, __LINE__, #condition); \
            std::exit(1);                                                             \
        }                                                                             \
    } while (0)

namespace {

struct Cage {
    std::vector<float> points;
    std::vector<int32_t> sizes, corners, creases, sharp, holes;
    std::vector<float> crease_sharpness, point_sharpness;

    rlv_osd_cage record(int32_t rule, int32_t isolation, int32_t single) const {
        rlv_osd_cage cage = {};
        cage.point_count = int32_t(points.size() / 3);
        cage.face_count = int32_t(sizes.size());
        cage.face_sizes = sizes.data();
        cage.corners = corners.data();
        cage.crease_count = int32_t(crease_sharpness.size());
        cage.crease_points = creases.data();
        cage.crease_sharpness = crease_sharpness.data();
        cage.sharp_point_count = int32_t(sharp.size());
        cage.sharp_points = sharp.data();
        cage.sharp_point_sharpness = point_sharpness.data();
        cage.hole_count = int32_t(holes.size());
        cage.holes = holes.data();
        cage.boundary_rule = rule;
        cage.isolation = isolation;
        cage.single_crease = single;
        return cage;
    }
};

struct Random {
    uint32_t state;

    uint32_t below(uint32_t count) {
        state = state * 1664525u + 1013904223u;
        return (state >> 8) % count;
    }
};

/// A patch of a plane whose faces are quads, pairs of triangles or pentagons and triangles, with some of all that a cage
/// can have.
Cage by_chance(uint32_t seed) {
    Random random{seed};
    Cage cage;
    const int32_t columns = 1 + int32_t(random.below(4)), rows = 1 + int32_t(random.below(3));
    for (int32_t y = 0; y <= rows; ++y) {
        for (int32_t x = 0; x <= columns; ++x) {
            cage.points.insert(cage.points.end(), {float(x), float(y), 0.125f * float(random.below(9))});
        }
    }
    for (int32_t y = 0; y < rows; ++y) {
        for (int32_t x = 0; x < columns; ++x) {
            const int32_t a = y * (columns + 1) + x, b = a + 1, c = b + columns + 1, d = c - 1;
            switch (random.below(3)) {
            case 0:
                cage.sizes.push_back(4);
                cage.corners.insert(cage.corners.end(), {a, b, c, d});
                break;
            case 1:
                cage.sizes.insert(cage.sizes.end(), {3, 3});
                cage.corners.insert(cage.corners.end(), {a, b, c, a, c, d});
                break;
            default: {
                const int32_t middle = int32_t(cage.points.size() / 3);
                cage.points.insert(cage.points.end(), {float(x) + 0.5f, float(y) + 0.25f, 0.0f});
                cage.sizes.insert(cage.sizes.end(), {3, 5});
                cage.corners.insert(cage.corners.end(), {a, b, middle, a, middle, b, c, d});
            }
            }
            if (random.below(3) == 0) {
                cage.creases.insert(cage.creases.end(), {a, b});
                cage.crease_sharpness.push_back(0.5f * float(random.below(9)));
            }
        }
    }
    if (random.below(2)) {
        cage.sharp.push_back(int32_t(random.below(uint32_t(cage.points.size() / 3))));
        cage.point_sharpness.push_back(random.below(2) ? 10.0f : 1.5f);
    }
    if (cage.sizes.size() > 2 && random.below(3) == 0) {
        cage.holes.push_back(int32_t(random.below(uint32_t(cage.sizes.size()))));
    }
    return cage;
}

/// Reads all arrays: what the sanitizers do not stop is within them.
double read(const rlv_osd_table *table) {
    rlv_osd_arrays arrays = {};
    rlv_osd_arrays_of(table, &arrays);
    double sum = arrays.tile_count;
    for (int32_t k = 0; k < arrays.patch_count; ++k) {
        const rlv_osd_patch &patch = arrays.patches[k];
        const uint32_t points = patch.kind == 0 ? 16 : 20;
        CHECK(patch.kind <= 1 && patch.crease <= 4 && patch.tile >= 0 && patch.tile < arrays.tile_count);
        CHECK(patch.first + points <= uint32_t(arrays.index_count));
    }
    for (int32_t k = 0; k < arrays.index_count; ++k) {
        sum += arrays.indices[k];
    }
    int64_t weights = 0;
    for (int32_t k = 0; k < arrays.stencil_count; ++k) {
        weights += arrays.stencil_sizes[k];
    }
    CHECK(weights == arrays.weight_count);
    for (int64_t k = 0; k < weights; ++k) {
        sum += arrays.stencil_indices[k] + arrays.stencil_weights[k];
    }
    return sum;
}

/// The points of a table: the cage's, and what stencils make of them.
std::vector<double> points_of(const Cage &cage, const rlv_osd_arrays &arrays) {
    std::vector<double> points(cage.points.begin(), cage.points.end());
    int64_t weight = 0;
    for (int32_t k = 0; k < arrays.stencil_count; ++k) {
        double sum[3] = {};
        for (int32_t j = 0; j < arrays.stencil_sizes[k]; ++j, ++weight) {
            for (size_t axis = 0; axis < 3; ++axis) {
                sum[axis] += arrays.stencil_weights[weight] * double(cage.points.at(3 * size_t(arrays.stencil_indices[weight]) + axis));
            }
        }
        points.insert(points.end(), sum, sum + 3);
    }
    return points;
}

void check(const Cage &cage, int32_t rule, int32_t isolation, int32_t single) {
    char error[64] = {};
    const rlv_osd_cage record = cage.record(rule, isolation, single);
    double expected[10] = {};
    CHECK(rlv_osd_expected_patches(&record, 1, isolation, expected, error, sizeof error) == 0 && expected[0] > 0);
    rlv_osd_table *const table = rlv_osd_refine(&record, error, sizeof error);
    CHECK(table && error[0] == 0 && std::isfinite(read(table)));
    rlv_osd_arrays arrays = {};
    rlv_osd_arrays_of(table, &arrays);
    const std::vector<double> points = points_of(cage, arrays);
    const std::vector<float> rounded(points.begin(), points.end());
    std::vector<double> out;
    std::vector<int32_t> tiles;
    std::vector<double> uv;
    for (int32_t tile = 0; tile < arrays.tile_count; ++tile) {
        for (const double at : {0.0, 0.375, 1.0}) {
            tiles.push_back(tile);
            uv.insert(uv.end(), {at, 1.0 - at});
        }
    }
    out.resize(18 * tiles.size());
    const int32_t found = rlv_osd_evaluate(table, points.data(), int32_t(tiles.size()), tiles.data(), uv.data(), out.data());
    CHECK(found >= 0 && size_t(found) <= tiles.size() && (found > 0 || !cage.holes.empty()));
    std::vector<float> buffer(9 * 50);
    CHECK(rlv_osd_far_grid(table, rounded.data(), 4, buffer.data(), int64_t(buffer.size())) >= 0);
    // OpenSubdiv's own Bfr, a peer of benches alone, reads beyond its arrays where some creases end.
    if (cage.creases.empty() && cage.sharp.empty()) {
        rlv_osd_bfr *const bfr = rlv_osd_bfr_create(table, 2, error, sizeof error);
        CHECK(bfr && rlv_osd_bfr_grid(bfr, cage.points.data(), 4, buffer.data(), int64_t(buffer.size())) >= 0);
        rlv_osd_bfr_free(bfr);
    }
    rlv_osd_free(table);
}

} // namespace

int main() {
    for (uint32_t seed = 1; seed <= 40; ++seed) {
        check(by_chance(seed), int32_t(seed % 2), 1 + int32_t(seed % 4), int32_t(seed / 2 % 2));
    }
    // A face with a point twice cannot be refined; its text fits whatever room there is for it.
    Cage folded = by_chance(1);
    folded.sizes = {4};
    folded.corners = {0, 1, 1, 0};
    folded.creases.clear();
    folded.crease_sharpness.clear();
    folded.sharp.clear();
    folded.point_sharpness.clear();
    folded.holes.clear();
    for (const size_t room : {size_t(0), size_t(1), size_t(8), size_t(200)}) {
        std::vector<char> error(room, 'x');
        const rlv_osd_cage record = folded.record(0, 2, 1);
        rlv_osd_table *const table = rlv_osd_refine(&record, error.data(), room);
        CHECK(table || room == 0 || std::memchr(error.data(), 0, room) != nullptr);
        rlv_osd_free(table);
    }
    return 0;
}
