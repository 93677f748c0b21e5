// What a host pays once that embeds the library: contexts, meshes of its own arrays, documents as bytes in its files.
#ifndef EMBEDDING_H
#define EMBEDDING_H

#include "../../c/check.h"
#include "../figure.h"
#include "allocations.h"

#include <chrono>
#include <cstring>
#include <filesystem>
#include <malloc.h>
#include <string>
#include <utility>
#include <vector>

/// One figure, beside the same with copied arrays where that is given.
inline void print_row(bool json, const char *name, double ours, const char *unit, const double *copied, const char *goal,
                      bool met) {
    if (json) {
        std::printf("{\"bench\":\"hosts\",\"case\":\"%s\",\"ours\":%g,\"peer\":", name, ours);
        if (copied) {
            std::printf("%g,\"peer_name\":\"copied arrays\",\"ratio\":%g", *copied, ours / *copied);
        } else {
            std::printf("null,\"peer_name\":null,\"ratio\":null");
        }
        std::printf(",\"unit\":\"%s\",\"goal\":\"%s\",\"met\":%s}\n", unit, goal, met ? "true" : "false");
        return;
    }
    std::printf("%-40s %12.6g %s", name, ours, unit);
    if (copied) {
        std::printf(" of %.0f", *copied);
    }
    std::printf("  %s  %s\n", goal, met ? "yes" : "NO");
}

inline double wall_seconds() {
    return std::chrono::duration<double>(std::chrono::steady_clock::now().time_since_epoch()).count();
}

/// How many threads the process has.
inline size_t threads_now() {
    size_t count = 0;
    for (const auto &thread : std::filesystem::directory_iterator("/proc/self/task")) {
        count += thread.path().empty() ? 0 : 1;
    }
    return count;
}

/// What a context takes, and a thousand of them that live at the same time.
inline void contexts(bool json) {
    const size_t before = threads_now();
    std::vector<double> times;
    std::vector<RlvContext> all(1000, RlvContext{0});
    for (RlvContext &context : all) {
        const double start = wall_seconds();
        CHECK_OK(rlv_context_create(nullptr, &context));
        times.push_back(1e3 * (wall_seconds() - start));
    }
    const double started = double(threads_now() - before), middle = median(times), most = quantile(times, 1.0);
    for (const RlvContext context : all) {
        RlvContextInfo info = RLV_CONTEXT_INFO_INIT;
        CHECK_OK(rlv_context_info(context, &info));
        CHECK_OK(rlv_context_release(context));
    }
    print_row(json, "a context, with default options", middle, "ms", nullptr, "<= 1 ms", middle <= 1.0);
    print_row(json, "the slowest of 1,000 that live at once", most, "ms", nullptr, "<= 1 ms", most <= 1.0);
    print_row(json, "threads that these 1,000 start", started, "threads", nullptr, "0", started == 0.0);
}

/// Adds up what objects take.
inline uint32_t add_up(void *user, int64_t taken) {
    *static_cast<int64_t *>(user) += taken;
    return RLV_PROGRESS_CONTINUE;
}

/// The bytes that a mesh takes: those that all threads ask malloc for, and those that the memory monitor counts.
struct Taken {
    int64_t asked = 0, told = 0;
};

/// Makes a grid of side² quads, whose arrays have the library's layout, of borrowed or of copied arrays. The context is new,
/// so that no memory of earlier calls is used again.
inline Taken make_grid(uint32_t side, bool is_borrowed) {
    std::vector<float> points;
    std::vector<uint32_t> corners, sizes(size_t(side) * side, 4);
    for (uint32_t at = 0; at < (side + 1) * (side + 1); ++at) {
        points.insert(points.end(), {float(at % (side + 1)), float(at / (side + 1)), 0.0f});
    }
    for (uint32_t face = 0; face < side * side; ++face) {
        const uint32_t first = face / side * (side + 1) + face % side;
        corners.insert(corners.end(), {first, first + 1, first + side + 2, first + side + 1});
    }
    RlvMeshArrays arrays = RLV_MESH_ARRAYS_INIT;
    arrays.points = points.data();
    arrays.point_count = points.size() / 3;
    arrays.corners = corners.data();
    arrays.corner_count = corners.size();
    arrays.face_sizes = sizes.data();
    arrays.face_count = sizes.size();
    RlvContext context = RLV_NULL;
    RlvMesh mesh = RLV_NULL;
    Taken taken;
    CHECK_OK(rlv_context_create(nullptr, &context));
    CHECK_OK(rlv_context_set_memory_monitor(context, add_up, &taken.told));
    const Allocations before = allocations();
    CHECK_OK(is_borrowed ? rlv_mesh_create_borrowed(context, &arrays, nullptr, nullptr, &mesh)
                         : rlv_mesh_create(context, &arrays, &mesh));
    taken.asked = int64_t((allocations() - before).bytes);
    CHECK_OK(rlv_context_set_memory_monitor(context, nullptr, nullptr));
    CHECK_OK(rlv_mesh_release(mesh));
    CHECK_OK(rlv_context_release(context));
    return taken;
}

/// What a mesh takes whose arrays are the host's, beside one whose arrays are copied: bytes that grow with the mesh, so
/// without the object itself, which is the same for a mesh of a quarter of the faces.
inline void borrowed_arrays(bool json) {
    Taken grown[2];
    for (int is_borrowed = 0; is_borrowed < 2; ++is_borrowed) {
        const Taken small = make_grid(250, is_borrowed != 0), large = make_grid(500, is_borrowed != 0);
        grown[is_borrowed] = {large.asked - small.asked, large.told - small.told};
    }
    for (const bool is_asked : {true, false}) {
        const double ours = double(is_asked ? grown[1].asked : grown[1].told);
        const double copied = double(is_asked ? grown[0].asked : grown[0].told);
        const char *const name = is_asked ? "borrowed arrays, asked of malloc" : "borrowed arrays, told to the monitor";
        print_row(json, name, ours, "bytes", &copied, "0", ours == 0.0);
    }
}

/// A document of more than 100 MB, whose texels cannot be compressed, to bytes and back: in memory that the allocator has
/// given back to the system before, which is slow to come again page by page, and in memory that it keeps, as those of most
/// hosts do.
inline void document_bytes(RlvContext context, bool json) {
    const uint32_t side = 29, size = 256;
    const RlvMesh cage = check_plane(context, side, side);
    RlvSurface surface = RLV_NULL;
    RlvDetailOptions options = RLV_DETAIL_OPTIONS_INIT;
    options.tile_size = size;
    CHECK_OK(rlv_surface_create(context, cage, nullptr, &surface));
    const auto detail_of = [&] {
        RlvDetail detail = RLV_NULL;
        CHECK_OK(rlv_detail_create(surface, &options, nullptr, &detail));
        return detail;
    };
    const RlvDetail detail = detail_of();
    std::vector<uint16_t> block((size + 2) * (size + 2));
    uint32_t state = 7;
    for (uint32_t tile = 0; tile < side * side; ++tile) {
        for (uint16_t &half : block) {
            state = state * 1664525u + 1013904223u;
            half = uint16_t((state >> 16) & 0xabffu); // Heights of up to a sixteenth, either way.
        }
        CHECK_OK(rlv_detail_write_block(detail, RLV_CHANNEL_DISPLACEMENT, tile, block.data(), 2 * block.size()));
    }
    CHECK_OK(rlv_detail_commit(detail, nullptr));
    RlvDocument document = RLV_NULL;
    CHECK_OK(rlv_document_create(detail, nullptr, 0, &document));
    for (const bool keeps : {false, true}) {
        if (keeps) {
            CHECK(mallopt(M_MMAP_THRESHOLD, 1 << 30) == 1 && mallopt(M_TRIM_THRESHOLD, 1 << 30) == 1);
        }
        std::vector<double> saved, opened;
        double megabytes = 0.0;
        for (int run = 0; run < 5; ++run) {
            RlvBytes bytes = RLV_NULL;
            RlvDocument again = RLV_NULL;
            const uint8_t *data = nullptr;
            size_t count = 0;
            const RlvDetail other = detail_of();
            double start = wall_seconds();
            CHECK_OK(rlv_document_save_bytes(document, &bytes));
            CHECK_OK(rlv_bytes_get(bytes, &data, &count));
            saved.push_back(1e-9 * double(count) / (wall_seconds() - start));
            start = wall_seconds();
            CHECK_OK(rlv_document_open_bytes(other, data, count, 0, &again));
            opened.push_back(1e-9 * double(count) / (wall_seconds() - start));
            megabytes = 1e-6 * double(count);
            CHECK_OK(rlv_document_release(again));
            CHECK_OK(rlv_detail_release(other));
            CHECK_OK(rlv_bytes_release(bytes));
        }
        const std::string of = " of a document of " + std::to_string(int(megabytes)) + " MB" + (keeps ? "" : ", fresh pages");
        for (const auto &[name, rates] : {std::pair{"bytes", saved}, std::pair{"opening", opened}}) {
            const double rate = median(rates);
            print_row(json, (name + of).c_str(), rate, "GB/s", nullptr, keeps ? ">= 1 GB/s" : "none",
                      !keeps || (megabytes >= 100.0 && rate >= 1.0));
        }
    }
    CHECK_OK(rlv_document_release(document));
    CHECK_OK(rlv_detail_release(detail));
    CHECK_OK(rlv_surface_release(surface));
    CHECK_OK(rlv_mesh_release(cage));
}

#endif
