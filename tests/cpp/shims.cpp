// The C++ side of the OpenSubdiv binding, compiled with the sanitizers as the library's own build cannot be: cages with
// creases, corners, boundaries, holes and faces of any size, small ones and made by chance, refined, read to their last
// number and evaluated; what cannot be refined is an exception with a text.
#include "relievo-opensubdiv/src/bridge.rs.h"

#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <exception>
#include <vector>

#define CHECK(condition)                                                              \
    do {                                                                              \
        if (!(condition)) {                                                           \
            std::fprintf(stderr, "%s:%d: failed: %s\n", __FILE__, __LINE__, #condition); \
            std::exit(1);                                                             \
        }                                                                             \
    } while (0)

// Slices of cxx, which the library has from Rust: a pointer and a length. There is no Rust in this program.
namespace rust {
inline namespace cxxbridge1 {
void sliceInit(void *slice, const void *data, std::size_t length) noexcept {
    const std::uintptr_t words[2] = {reinterpret_cast<std::uintptr_t>(data), length};
    std::memcpy(slice, words, sizeof words);
}
void *slicePtr(const void *slice) noexcept {
    std::uintptr_t data;
    std::memcpy(&data, slice, sizeof data);
    return reinterpret_cast<void *>(data);
}
std::size_t sliceLen(const void *slice) noexcept {
    std::uintptr_t words[2];
    std::memcpy(words, slice, sizeof words);
    return words[1];
}
} // namespace cxxbridge1
} // namespace rust

using namespace relievo::opensubdiv;

namespace {

template <typename T>
rust::Slice<const T> slice(const std::vector<T> &values) {
    return {values.data(), values.size()};
}

template <typename T>
rust::Slice<T> room(std::vector<T> &values) {
    return {values.data(), values.size()};
}

struct Control {
    std::vector<float> points;
    std::vector<int32_t> sizes, corners, creases, sharp, holes;
    std::vector<float> crease_sharpness, point_sharpness;

    Cage record(bool round_corners, uint32_t isolation, bool single_crease) const {
        Cage cage{};
        cage.point_count = uint32_t(points.size() / 3);
        cage.face_sizes = slice(sizes);
        cage.corners = slice(corners);
        cage.crease_points = slice(creases);
        cage.crease_sharpness = slice(crease_sharpness);
        cage.sharp_points = slice(sharp);
        cage.sharp_point_sharpness = slice(point_sharpness);
        cage.holes = slice(holes);
        cage.round_corners = round_corners;
        cage.isolation = isolation;
        cage.single_crease = single_crease;
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
Control by_chance(uint32_t seed) {
    Random random{seed};
    Control cage;
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
double read(const Table &table) {
    double sum = table.tile_count();
    for (const Patch &patch : table.patches()) {
        const uint32_t points = patch.is_gregory ? 20 : 16;
        CHECK(patch.crease <= 4 && patch.tile < uint32_t(table.tile_count()));
        CHECK(patch.first + points <= table.indices().size());
    }
    for (const int32_t index : table.indices()) {
        sum += index;
    }
    size_t weights = 0;
    for (const int32_t size : table.stencil_sizes()) {
        weights += size_t(size);
    }
    CHECK(weights == table.stencil_weights().size() && weights == table.stencil_indices().size());
    for (size_t k = 0; k < weights; ++k) {
        sum += table.stencil_indices()[k] + table.stencil_weights()[k];
    }
    return sum;
}

/// The points of a table: the cage's, and those of the stencils.
std::vector<double> points_of(const Control &cage, const Table &table) {
    std::vector<double> points(cage.points.begin(), cage.points.end());
    size_t weight = 0;
    for (const int32_t size : table.stencil_sizes()) {
        double sum[3] = {};
        for (int32_t j = 0; j < size; ++j, ++weight) {
            const size_t source = 3 * size_t(table.stencil_indices()[weight]);
            for (size_t axis = 0; axis < 3; ++axis) {
                sum[axis] += table.stencil_weights()[weight] * double(cage.points.at(source + axis));
            }
        }
        points.insert(points.end(), sum, sum + 3);
    }
    return points;
}

void check(const Control &cage, bool round_corners, uint32_t isolation, bool single_crease) {
    const Cage record = cage.record(round_corners, isolation, single_crease);
    std::vector<Sizes> expected(isolation);
    expected_sizes(record, 1, 1e9, room(expected));
    CHECK(expected[0].patches > 0);
    const std::unique_ptr<Table> table = refine(record);
    CHECK(expected.back().patches >= (double)table->patches().size());
    const double weights = (double)table->stencil_weights().size();
    CHECK(expected.back().weights >= 0.9 * weights && expected.back().weights <= 1.25 * weights + 1000);
    CHECK(std::isfinite(read(*table)));
    const std::vector<double> points = points_of(cage, *table);
    const std::vector<float> rounded(points.begin(), points.end());
    std::vector<int32_t> tiles;
    std::vector<double> uv;
    for (int32_t tile = 0; tile < table->tile_count(); ++tile) {
        for (const double at : {0.0, 0.375, 1.0}) {
            tiles.push_back(tile);
            uv.insert(uv.end(), {at, 1.0 - at});
        }
    }
    std::vector<double> out(18 * tiles.size(), NAN);
    table->evaluate(slice(points), slice(tiles), slice(uv), room(out));
    for (const double value : out) {
        CHECK(std::isfinite(value));
    }
    std::vector<float> buffer(9 * 50);
    const uint64_t samples = table->far_grid(slice(rounded), 4, room(buffer));
    CHECK(samples <= 16 * uint64_t(table->tile_count()) && (samples > 0 || !cage.holes.empty()));
    // OpenSubdiv's own Bfr, a peer of benches alone, reads beyond its arrays where some creases end.
    if (cage.creases.empty() && cage.sharp.empty()) {
        CHECK(make_bfr(*table, 2)->grid(slice(cage.points), 4, room(buffer)) <= samples);
    }
}

} // namespace

int main() {
    for (uint32_t seed = 1; seed <= 40; ++seed) {
        check(by_chance(seed), seed % 2 != 0, 1 + seed % 4, seed / 2 % 2 != 0);
    }
    // A face with a point twice is refined or refused, as OpenSubdiv likes.
    Control folded = by_chance(1);
    folded.sizes = {4};
    folded.corners = {0, 1, 1, 0};
    folded.creases.clear();
    folded.crease_sharpness.clear();
    folded.sharp.clear();
    folded.point_sharpness.clear();
    folded.holes.clear();
    try {
        CHECK(std::isfinite(read(*refine(folded.record(false, 2, true)))));
    } catch (const std::exception &exception) {
        CHECK(exception.what()[0] != 0);
    }
    return 0;
}
