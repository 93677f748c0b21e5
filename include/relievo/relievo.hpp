// Relievo in C++17: objects that release themselves, arrays as vectors, failures as exceptions. Header only; everything
// is a thin layer over the C functions of the same names, whose headers say what they do. Where a program is compiled
// without exceptions, a failure prints its message to stderr and aborts: call the C functions to go on after failures.
#ifndef RELIEVO_RELIEVO_HPP
#define RELIEVO_RELIEVO_HPP

#include <array>
#include <cstddef>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <exception>
#include <functional>
#include <memory>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

#include "relievo/relievo.h"

#if defined(__cpp_exceptions) || defined(_CPPUNWIND)
#define RELIEVO_TRY try
#define RELIEVO_CATCH catch (...)
#define RELIEVO_RETHROW throw
#else
#define RELIEVO_TRY if (true)
#define RELIEVO_CATCH else
#define RELIEVO_RETHROW static_cast<void>(0)
#endif

namespace relievo {

using Float2 = std::array<float, 2>;
using Float3 = std::array<float, 3>;
using Double3 = std::array<double, 3>;
using Triangle = std::array<std::uint32_t, 3>;

/// A failed call. what() is the whole message; the parts say what went wrong, where, and what can be done.
class Error : public std::runtime_error {
public:
    Error(RlvResult result, const std::string &message, std::string reason, std::string place, std::string remedy,
          std::uint32_t code = 0, RlvElement element_kind = RLV_ELEMENT_NONE, std::uint64_t element = 0)
        : std::runtime_error(message), result_(result), reason_(std::move(reason)), place_(std::move(place)),
          remedy_(std::move(remedy)), code_(code), element_kind_(element_kind), element_(element) {}

    RlvResult result() const noexcept { return result_; }
    const std::string &reason() const noexcept { return reason_; }
    const std::string &place() const noexcept { return place_; }
    const std::string &remedy() const noexcept { return remedy_; }
    /// Number of the sentence of reason(), for tables of translations; see RlvError.
    std::uint32_t code() const noexcept { return code_; }
    /// What element() counts; RLV_ELEMENT_NONE where the failure is about no single element.
    RlvElement element_kind() const noexcept { return element_kind_; }
    std::uint64_t element() const noexcept { return element_; }

private:
    RlvResult result_;
    std::string reason_, place_, remedy_;
    std::uint32_t code_;
    RlvElement element_kind_;
    std::uint64_t element_;
};

/// Throws failure, or prints its message and aborts where there are no exceptions.
template <class Failure> [[noreturn]] void raise(const Failure &failure) {
#if defined(__cpp_exceptions) || defined(_CPPUNWIND)
    throw failure;
#else
    std::fprintf(stderr, "relievo: %s\n", failure.what());
    std::abort();
#endif
}

/// Throws the calling thread's last error unless result is RLV_OK.
inline void check(RlvResult result) {
    if (result == RLV_OK) {
        return;
    }
    RlvError error = RLV_ERROR_INIT;
    if (rlv_error_get(&error) != RLV_OK) {
        raise(Error(result, "an error without a text", "", "", ""));
    }
    raise(Error(result, error.message, error.what, error.place, error.remedy, error.code,
                static_cast<RlvElement>(error.element_kind), error.element));
}

/// One reference to an object of the library. Copies share the object.
template <class Handle, RlvResult (*retain)(Handle), RlvResult (*release)(Handle)> class Reference {
public:
    Reference() noexcept = default;
    /// Takes over a reference that the caller has.
    explicit Reference(Handle handle) noexcept : handle_(handle) {}
    Reference(const Reference &other) : handle_(other.handle_) {
        if (handle_.id != 0) {
            check(retain(handle_));
        }
    }
    Reference(Reference &&other) noexcept : handle_(std::exchange(other.handle_, Handle{0})) {}
    Reference &operator=(Reference other) noexcept {
        std::swap(handle_, other.handle_);
        return *this;
    }
    ~Reference() {
        if (handle_.id != 0) {
            release(handle_);
        }
    }

    /// The handle, for C functions. The reference stays here.
    Handle get() const noexcept { return handle_; }
    explicit operator bool() const noexcept { return handle_.id != 0; }

protected:
    Handle *out() noexcept { return &handle_; }

private:
    Handle handle_{0};
};

/// Takes all memory from the host; see relievo/allocator.h.
inline void set_allocator(RlvAllocate allocate, RlvFree free, void *user = nullptr) {
    RlvAllocator allocator = RLV_ALLOCATOR_INIT;
    allocator.allocate = allocate;
    allocator.free = free;
    allocator.user = user;
    check(rlv_allocator_set(&allocator));
}

/// What the library occupies, and what it may.
inline RlvAllocatorInfo allocator_info() {
    RlvAllocatorInfo info = RLV_ALLOCATOR_INFO_INIT;
    check(rlv_allocator_info(&info));
    return info;
}

/// Bounds what the library's blocks occupy together, in bytes; 0 for no limit.
inline void set_memory_limit(std::uint64_t bytes) { check(rlv_allocator_set_limit(bytes)); }

/// The adapters of this machine, best first; see relievo/adapter.h.
inline std::vector<RlvAdapterInfo> adapters() {
    // One may be plugged in between the two calls; then there is room for it.
    std::size_t count = 0;
    check(rlv_adapter_list(nullptr, 0, &count));
    std::vector<RlvAdapterInfo> rows(count + 4);
    check(rlv_adapter_list(rows.data(), rows.size(), &count));
    rows.resize(count);
    return rows;
}

/// What the loaded library can do on this machine; see relievo/capability.h.
inline RlvCapability capability() {
    RlvCapability out = RLV_CAPABILITY_INIT;
    check(rlv_capability_get(&out));
    return out;
}

/// The formats of files that can be read or written, by content; see relievo/capability.h.
inline std::vector<RlvCapabilityFormat> formats() {
    // The module of OpenVDB may be installed between the two calls; then there is room for it.
    std::size_t count = 0;
    check(rlv_capability_list(nullptr, 0, &count));
    std::vector<RlvCapabilityFormat> rows(count + 4);
    check(rlv_capability_list(rows.data(), rows.size(), &count));
    rows.resize(count);
    return rows;
}

/// Waits until no call is at work on an object, no longer than seconds; -1 for as long as it takes. See relievo/object.h.
template <class Object> RlvObjectInfo wait(const Object &object, double seconds = -1.0) {
    RlvObjectInfo info = RLV_OBJECT_INFO_INIT;
    check(rlv_object_wait(object.get().id, seconds, &info));
    return info;
}

/// See relievo/context.h.
class Context : public Reference<RlvContext, rlv_context_retain, rlv_context_release> {
public:
    using Reference::Reference;

    static Context create(const RlvContextOptions &options = RLV_CONTEXT_OPTIONS_INIT) {
        Context made;
        check(rlv_context_create(&options, made.out()));
        return made;
    }

    /// On a Vulkan device of the host; see relievo/vulkan.h.
    static Context create(const RlvVulkanDevice &device, const RlvContextOptions &options = RLV_CONTEXT_OPTIONS_INIT) {
        Context made;
        check(rlv_vulkan_create_context(&device, &options, made.out()));
        return made;
    }

    /// Has its later work wait for a VkSemaphore, a binary one where value is 0.
    void wait(std::uint64_t semaphore, std::uint64_t value) const { check(rlv_vulkan_wait(get(), semaphore, value)); }

    /// Signals a VkSemaphore behind its work, a binary one where value is 0.
    void signal(std::uint64_t semaphore, std::uint64_t value) const { check(rlv_vulkan_signal(get(), semaphore, value)); }

    RlvContextInfo info() const {
        RlvContextInfo info = RLV_CONTEXT_INFO_INIT;
        check(rlv_context_info(get(), &info));
        return info;
    }

    /// Lets the graphics device go; the processor takes over.
    void close_device() const { check(rlv_context_close_device(get())); }

    void set_log(RlvLog callback, void *user) const { check(rlv_context_set_log(get(), callback, user)); }

    void set_memory_monitor(RlvMemoryMonitor callback, void *user) const {
        check(rlv_context_set_memory_monitor(get(), callback, user));
    }

    std::vector<RlvContextStat> stats() const {
        // Other threads may add rows between the two calls; then the second one is made again.
        for (;;) {
            std::size_t count = 0;
            check(rlv_context_stats(get(), nullptr, 0, &count));
            std::vector<RlvContextStat> rows(count + 16);
            if (rlv_context_stats(get(), rows.data(), rows.size(), &count) == RLV_OK) {
                rows.resize(count);
                return rows;
            }
        }
    }

    void reset_stats() const { check(rlv_context_reset_stats(get())); }
};

/// See relievo/bytes.h.
class Bytes : public Reference<RlvBytes, rlv_bytes_retain, rlv_bytes_release> {
public:
    using Reference::Reference;

    /// Valid as long as a reference is there.
    const std::uint8_t *data() const {
        const std::uint8_t *data = nullptr;
        std::size_t size = 0;
        check(rlv_bytes_get(get(), &data, &size));
        return data;
    }

    std::size_t size() const {
        const std::uint8_t *data = nullptr;
        std::size_t size = 0;
        check(rlv_bytes_get(get(), &data, &size));
        return size;
    }
};

/// Storage of the host in which a document lives; see relievo/stream.h. A function that throws fails its call.
class Storage {
public:
    virtual ~Storage() = default;
    virtual void read(std::uint64_t place, std::uint8_t *bytes, std::size_t size) = 0;
    virtual void write(std::uint64_t place, const std::uint8_t *bytes, std::size_t size) = 0;
    virtual std::uint64_t length() = 0;
    virtual void cut(std::uint64_t length) = 0;
    virtual void sync() {}

    /// A table for one call, which keeps the storage until its document uses it no longer.
    static RlvStream stream(std::shared_ptr<Storage> storage) {
        RlvStream made = RLV_STREAM_INIT;
        made.user = new std::shared_ptr<Storage>(std::move(storage));
        made.read = [](void *user, std::uint64_t place, std::uint8_t *bytes, std::size_t size) {
            return answer([&] { of(user).read(place, bytes, size); });
        };
        made.write = [](void *user, std::uint64_t place, const std::uint8_t *bytes, std::size_t size) {
            return answer([&] { of(user).write(place, bytes, size); });
        };
        made.length = [](void *user, std::uint64_t *length) { return answer([&] { *length = of(user).length(); }); };
        made.cut = [](void *user, std::uint64_t length) { return answer([&] { of(user).cut(length); }); };
        made.sync = [](void *user) { return answer([&] { of(user).sync(); }); };
        made.close = [](void *user) { delete static_cast<std::shared_ptr<Storage> *>(user); };
        return made;
    }

private:
    static Storage &of(void *user) { return **static_cast<std::shared_ptr<Storage> *>(user); }

    template <class Work> static std::uint32_t answer(Work &&work) noexcept {
        RELIEVO_TRY {
            std::forward<Work>(work)();
            return 0;
        } RELIEVO_CATCH {
            return 1;
        }
    }
};

/// See relievo/mesh.h.
class Mesh : public Reference<RlvMesh, rlv_mesh_retain, rlv_mesh_release> {
public:
    using Reference::Reference;

    static Mesh create(const Context &context, const RlvMeshArrays &arrays) {
        Mesh made;
        check(rlv_mesh_create(context.get(), &arrays, made.out()));
        return made;
    }

    /// A mesh of faces of the given sizes.
    static Mesh create(const Context &context, const std::vector<Float3> &points,
                       const std::vector<std::uint32_t> &face_sizes, const std::vector<std::uint32_t> &corners) {
        RlvMeshArrays arrays = RLV_MESH_ARRAYS_INIT;
        arrays.points = points.empty() ? nullptr : points.front().data();
        arrays.point_count = points.size();
        arrays.face_sizes = face_sizes.data();
        arrays.face_count = face_sizes.size();
        arrays.corners = corners.data();
        arrays.corner_count = corners.size();
        return create(context, arrays);
    }

    /// Reads the arrays where they lie, until released(user) is called.
    static Mesh borrow(const Context &context, const RlvMeshArrays &arrays, RlvMeshReleased released = nullptr,
                       void *user = nullptr) {
        Mesh made;
        check(rlv_mesh_create_borrowed(context.get(), &arrays, released, user, made.out()));
        return made;
    }

    /// Reads arrays that `owner` keeps alive, which is held as long as they are read.
    static Mesh borrow(const Context &context, const RlvMeshArrays &arrays, std::shared_ptr<const void> owner) {
        auto held = std::make_unique<std::shared_ptr<const void>>(std::move(owner));
        Mesh made = borrow(
            context, arrays, [](void *user) { delete static_cast<std::shared_ptr<const void> *>(user); }, held.get());
        held.release();
        return made;
    }

    static Mesh read(const Context &context, const std::string &path) {
        Mesh made;
        check(rlv_mesh_read(context.get(), path.c_str(), made.out()));
        return made;
    }

    void write(const std::string &path) const { check(rlv_mesh_write(get(), path.c_str())); }

    /// From the bytes of a file with the extension `format`.
    static Mesh read_bytes(const Context &context, const std::string &format, const std::uint8_t *bytes, std::size_t size) {
        Mesh made;
        check(rlv_mesh_read_bytes(context.get(), format.c_str(), bytes, size, made.out()));
        return made;
    }

    /// As "obj", "ply" or "glb".
    Bytes write_bytes(const std::string &format) const {
        RlvBytes made{0};
        check(rlv_mesh_write_bytes(get(), format.c_str(), &made));
        return Bytes(made);
    }

    /// Its triangles, split until no edge is longer.
    Mesh split(double longest_edge) const {
        Mesh made;
        check(rlv_mesh_split(get(), longest_edge, made.out()));
        return made;
    }

    RlvMeshInfo info() const {
        RlvMeshInfo info = RLV_MESH_INFO_INIT;
        check(rlv_mesh_info(get(), &info));
        return info;
    }

    void set_points(const std::vector<Float3> &points) const {
        check(rlv_mesh_set_points(get(), points.empty() ? nullptr : points.front().data(), points.size(), 0));
    }

    void add_attribute(const RlvAttributeArrays &arrays) const { check(rlv_mesh_add_attribute(get(), &arrays)); }

    std::vector<Float3> points() const {
        std::vector<Float3> points(info().point_count);
        check(rlv_mesh_get_points(get(), points.empty() ? nullptr : points.front().data(), points.size(), 0));
        return points;
    }

    std::vector<std::uint32_t> face_sizes() const {
        std::vector<std::uint32_t> sizes(info().face_count);
        check(rlv_mesh_get_faces(get(), sizes.data(), sizes.size(), nullptr, 0));
        return sizes;
    }

    std::vector<std::uint32_t> corners() const {
        std::vector<std::uint32_t> corners(info().corner_count);
        check(rlv_mesh_get_faces(get(), nullptr, 0, corners.data(), corners.size()));
        return corners;
    }

    std::vector<Triangle> triangles() const {
        std::vector<Triangle> triangles(info().triangle_count);
        std::uint32_t *first = triangles.empty() ? nullptr : triangles.front().data();
        check(rlv_mesh_get_triangles(get(), first, triangles.size(), 0));
        return triangles;
    }

    std::uint32_t find_attribute(const std::string &name) const {
        std::uint32_t index = 0;
        check(rlv_mesh_find_attribute(get(), name.c_str(), &index));
        return index;
    }

    RlvAttributeInfo attribute_info(std::uint32_t index) const {
        RlvAttributeInfo info = RLV_ATTRIBUTE_INFO_INIT;
        check(rlv_mesh_attribute_info(get(), index, &info));
        return info;
    }

    /// The numbers of a float attribute, width per value.
    std::vector<float> attribute_floats(const std::string &name) const { return numbers<float>(name, RLV_TYPE_F32); }
    /// The numbers of an integer attribute, width per value.
    std::vector<std::uint32_t> attribute_integers(const std::string &name) const {
        return numbers<std::uint32_t>(name, RLV_TYPE_U32);
    }

private:
    template <class Number> std::vector<Number> numbers(const std::string &name, std::uint32_t type) const {
        const std::uint32_t index = find_attribute(name);
        const RlvAttributeInfo info = attribute_info(index);
        if (info.type != type) {
            raise(Error(RLV_ERROR_INVALID, "attribute `" + name + "` has numbers of another type",
                        "it has numbers of another type", "attribute `" + name + "`", ""));
        }
        std::vector<Number> values(info.value_count * info.width);
        check(rlv_mesh_get_attribute(get(), index, values.data(), values.size(), nullptr, 0));
        return values;
    }
};

/// A place on a surface.
struct Place {
    std::uint32_t tile;
    Float2 uv;
};

/// What evaluation gives, one element per place; what was not evaluated is empty.
struct Samples {
    std::vector<Float3> positions, normals, du, dv;
    std::vector<float> displacements;
    /// What the vector displacement adds; contact, depth and age of a detail with traces.
    std::vector<Float3> vectors, traces;

    /// Makes room for positions and normals at places, of which there is at least one, and points arrays at them.
    void prepare(const std::vector<Place> &places, RlvEvaluateArrays &arrays) {
        positions.resize(places.size());
        normals.resize(places.size());
        arrays.count = places.size();
        arrays.tiles = &places.front().tile;
        arrays.uvs = places.front().uv.data();
        arrays.tile_stride = arrays.uv_stride = sizeof(Place);
        arrays.positions = positions.front().data();
        arrays.normals = normals.front().data();
    }
};

/// See relievo/surface.h.
class Surface : public Reference<RlvSurface, rlv_surface_retain, rlv_surface_release> {
public:
    using Reference::Reference;

    static Surface create(const Context &context, const Mesh &cage,
                          const RlvSurfaceOptions &options = RLV_SURFACE_OPTIONS_INIT) {
        Surface made;
        check(rlv_surface_create(context.get(), cage.get(), &options, made.out()));
        return made;
    }

    RlvSurfaceInfo info() const {
        RlvSurfaceInfo info = RLV_SURFACE_INFO_INIT;
        check(rlv_surface_info(get(), &info));
        return info;
    }

    void set_points(const std::vector<Float3> &points) const {
        check(rlv_surface_set_points(get(), points.empty() ? nullptr : points.front().data(), points.size(), 0));
    }

    RlvTileInfo tile_info(std::uint32_t tile) const {
        RlvTileInfo info = RLV_TILE_INFO_INIT;
        check(rlv_surface_tile_info(get(), tile, &info));
        return info;
    }

    /// The first tile of a face and how many it has.
    std::pair<std::uint32_t, std::uint32_t> face_tiles(std::uint32_t face) const {
        std::pair<std::uint32_t, std::uint32_t> tiles;
        check(rlv_surface_face_tiles(get(), face, &tiles.first, &tiles.second));
        return tiles;
    }

    /// Positions, normals and first derivatives.
    Samples evaluate(const std::vector<Place> &places) const {
        Samples made;
        RlvEvaluateArrays arrays = RLV_EVALUATE_ARRAYS_INIT;
        if (!places.empty()) {
            made.prepare(places, arrays);
            made.du.resize(places.size());
            made.dv.resize(places.size());
            arrays.du = made.du.front().data();
            arrays.dv = made.dv.front().data();
            check(rlv_evaluate_surface(get(), &arrays));
        }
        return made;
    }

    Mesh tessellate(const RlvTessellateOptions &options = RLV_TESSELLATE_OPTIONS_INIT) const {
        RlvMesh made{0};
        check(rlv_tessellate_surface(get(), &options, &made));
        return Mesh(made);
    }
};

/// An affine map in columns: three for the linear part, then the translation.
using Matrix = std::array<double, 12>;

/// The map that moves by (x, y, z).
inline Matrix moved(double x, double y, double z) { return {1, 0, 0, 0, 1, 0, 0, 0, 1, x, y, z}; }

/// See relievo/detail.h.
class Detail : public Reference<RlvDetail, rlv_detail_retain, rlv_detail_release> {
public:
    using Reference::Reference;

    static Detail create(const Surface &surface, const RlvDetailOptions &options = RLV_DETAIL_OPTIONS_INIT,
                         const Matrix &matrix = moved(0, 0, 0)) {
        Detail made;
        check(rlv_detail_create(surface.get(), &options, matrix.data(), made.out()));
        return made;
    }

    /// Gives it colours, so that it can be painted.
    void add_paint(const RlvPaintOptions &options = RLV_PAINT_OPTIONS_INIT) const {
        check(rlv_detail_add_paint(get(), &options));
    }

    RlvDetailInfo info() const {
        RlvDetailInfo info = RLV_DETAIL_INFO_INIT;
        check(rlv_detail_info(get(), &info));
        return info;
    }

    RlvChannelInfo channel_info(RlvChannel channel) const {
        RlvChannelInfo info = RLV_CHANNEL_INFO_INIT;
        check(rlv_detail_channel_info(get(), channel, &info));
        return info;
    }

    /// Counts where the displaced surface is folded.
    RlvDetailFolds folds() const {
        RlvDetailFolds folds = RLV_DETAIL_FOLDS_INIT;
        check(rlv_detail_folds(get(), &folds));
        return folds;
    }

    /// Gives it a vector displacement.
    void add_vectors(const RlvVectorOptions &options = RLV_VECTOR_OPTIONS_INIT) const {
        check(rlv_detail_add_vectors(get(), &options));
    }

    /// Lets imprints leave traces; 0 for the default budget.
    void add_traces(std::uint64_t budget = 0) const { check(rlv_detail_add_traces(get(), budget)); }
    /// Lets edits fade.
    void set_decay(const RlvDecayOptions &options) const { check(rlv_detail_set_decay(get(), &options)); }
    /// Comes to a time in seconds.
    void advance(double time) const { check(rlv_detail_advance(get(), time)); }

    /// Throws what went wrong when the processor took over from the graphics device, if it did.
    void check_device() const { check(rlv_detail_device_fault(get())); }

    void set_budget(std::uint64_t budget) const { check(rlv_detail_set_budget(get(), budget)); }
    /// Lets tiles leave memory for a file when a budget is spent; the file is in `folder`, or where temporary files
    /// are.
    void set_paging(bool page, const char *folder = nullptr) const
    {
        check(rlv_detail_set_paging(get(), page ? 1 : 0, folder));
    }
    void set_transform(const Matrix &matrix) const { check(rlv_detail_set_transform(get(), matrix.data())); }

    void set_points(const std::vector<Float3> &points) const {
        check(rlv_detail_set_points(get(), points.empty() ? nullptr : points.front().data(), points.size(), 0));
    }

    RlvDetailChanges commit() const {
        RlvDetailChanges changes = RLV_DETAIL_CHANGES_INIT;
        check(rlv_detail_commit(get(), &changes));
        return changes;
    }

    std::vector<std::uint32_t> changed_tiles() const {
        std::vector<std::uint32_t> tiles(info().tile_count);
        std::size_t count = 0;
        check(rlv_detail_changed_tiles(get(), tiles.data(), tiles.size(), &count));
        tiles.resize(count);
        return tiles;
    }

    RlvDetailTileInfo tile_info(std::uint32_t tile, RlvChannel channel = RLV_CHANNEL_DISPLACEMENT) const {
        RlvDetailTileInfo info = RLV_DETAIL_TILE_INFO_INIT;
        check(rlv_detail_tile_info(get(), channel, tile, &info));
        return info;
    }

    /// The block of a tile, empty if it is not allocated.
    std::vector<unsigned char> read_block(std::uint32_t tile, RlvChannel channel = RLV_CHANNEL_DISPLACEMENT) const {
        std::vector<unsigned char> bytes(tile_info(tile, channel).block_size);
        std::size_t size = 0;
        check(rlv_detail_read_block(get(), channel, tile, bytes.data(), bytes.size(), &size));
        bytes.resize(size);
        return bytes;
    }

    void write_block(std::uint32_t tile, const std::vector<unsigned char> &bytes,
                     RlvChannel channel = RLV_CHANNEL_DISPLACEMENT) const {
        check(rlv_detail_write_block(get(), channel, tile, bytes.data(), bytes.size()));
    }

    /// Positions, normals and displacements of the displaced surface, and its vectors and traces if it has any.
    Samples evaluate(const std::vector<Place> &places) const {
        Samples made;
        RlvEvaluateArrays arrays = RLV_EVALUATE_ARRAYS_INIT;
        if (!places.empty()) {
            made.prepare(places, arrays);
            made.displacements.resize(places.size());
            arrays.displacements = made.displacements.data();
            if (channel_info(RLV_CHANNEL_VECTORS).is_there != 0) {
                made.vectors.resize(places.size());
                arrays.vectors = made.vectors.front().data();
            }
            if (channel_info(RLV_CHANNEL_TRACES).is_there != 0) {
                made.traces.resize(places.size());
                arrays.traces = made.traces.front().data();
            }
            check(rlv_evaluate_detail(get(), &arrays));
        }
        return made;
    }

    Mesh tessellate(const RlvTessellateOptions &options = RLV_TESSELLATE_OPTIONS_INIT) const {
        RlvMesh made{0};
        check(rlv_tessellate_detail(get(), &options, &made));
        return Mesh(made);
    }
};

/// Triangles of a detail that follow its commits; see relievo/tessellate.h.
class Tessellation : public Reference<RlvTessellation, rlv_tessellation_retain, rlv_tessellation_release> {
public:
    using Reference::Reference;

    /// A first point and the number of points.
    struct Range {
        std::uint32_t first, count;
    };

    static Tessellation create(const Detail &detail,
                               const RlvTessellateOptions &options = RLV_TESSELLATE_OPTIONS_INIT) {
        Tessellation made;
        check(rlv_tessellation_create(detail.get(), &options, made.out()));
        return made;
    }

    RlvTessellationInfo info() const {
        RlvTessellationInfo info = RLV_TESSELLATION_INFO_INIT;
        check(rlv_tessellation_info(get(), &info));
        return info;
    }

    RlvTessellationChanges update() const {
        RlvTessellationChanges changes = RLV_TESSELLATION_CHANGES_INIT;
        check(rlv_tessellation_update(get(), &changes));
        return changes;
    }

    /// The ranges of points that the last update changed.
    std::vector<Range> changed_ranges() const {
        std::size_t count = 0;
        check(rlv_tessellation_changed_ranges(get(), nullptr, 0, &count));
        std::vector<Range> ranges(count);
        check(rlv_tessellation_changed_ranges(get(), count == 0 ? nullptr : &ranges.front().first, count, &count));
        return ranges;
    }

    /// Copies a range of points into arrays of all points.
    void get_points(Range range, std::vector<Float3> &positions, std::vector<Float3> &normals) const {
        const std::size_t end = std::size_t{range.first} + range.count;
        if (end > positions.size() || end > normals.size()) {
            raise(Error(RLV_ERROR_INVALID, "the arrays end before the range", "the arrays end before the range",
                        "get_points", "make them as long as info().point_count"));
        }
        if (range.count > 0) {
            check(rlv_tessellation_get_points(get(), range.first, range.count, positions[range.first].data(), 0,
                                              normals[range.first].data(), 0));
        }
    }

    Mesh mesh() const {
        RlvMesh made{0};
        check(rlv_tessellation_mesh(get(), &made));
        return Mesh(made);
    }
};

/// See relievo/collider.h.
class Collider : public Reference<RlvCollider, rlv_collider_retain, rlv_collider_release> {
public:
    using Reference::Reference;

    static Collider create(const Context &context, const Mesh &mesh, const Matrix &matrix = moved(0, 0, 0)) {
        Collider made;
        check(rlv_collider_create_mesh(context.get(), mesh.get(), matrix.data(), made.out()));
        return made;
    }

    static Collider create(const Surface &surface, const Matrix &matrix = moved(0, 0, 0),
                           const RlvTessellateOptions &options = RLV_TESSELLATE_OPTIONS_INIT) {
        Collider made;
        check(rlv_collider_create_surface(surface.get(), &options, matrix.data(), made.out()));
        return made;
    }

    static Collider create(const Detail &detail,
                           const RlvTessellateOptions &options = RLV_TESSELLATE_OPTIONS_INIT) {
        Collider made;
        check(rlv_collider_create_detail(detail.get(), &options, made.out()));
        return made;
    }

    RlvColliderInfo info() const {
        RlvColliderInfo info = RLV_COLLIDER_INFO_INIT;
        check(rlv_collider_info(get(), &info));
        return info;
    }

    void set_transform(const Matrix &matrix) const { check(rlv_collider_set_transform(get(), matrix.data())); }

    /// Places a tool as a pen presses it.
    void press(const Double3 &place, const Double3 &normal, double force,
               const RlvToolSettings &settings = RLV_TOOL_SETTINGS_INIT) const {
        check(rlv_collider_press(get(), place.data(), normal.data(), force, &settings));
    }

    void set_points(const std::vector<Float3> &points) const {
        check(rlv_collider_set_points(get(), points.empty() ? nullptr : points.front().data(), points.size(), 0));
    }
};

/// Presses a collider into a detail where it stands; commit the detail to see it.
inline RlvImprintReport imprint(const Detail &detail, const Collider &collider,
                                const RlvImprintSettings &settings = RLV_IMPRINT_SETTINGS_INIT,
                                const RlvImprintMoment &moment = RLV_IMPRINT_MOMENT_INIT) {
    RlvImprintReport report = RLV_IMPRINT_REPORT_INIT;
    check(rlv_imprint_run(detail.get(), collider.get(), &settings, &moment, &report));
    return report;
}

/// Answers true to go on; gets a fraction from 0 to 1 and the name of the stage. It may throw, which cancels.
using Progress = std::function<bool(float, const char *)>;

/// Carries callbacks into a call. Exceptions must not pass through the library: one is kept until the call has
/// returned.
class Watch {
public:
    explicit Watch(const Progress &progress) : progress_(progress) {}

    /// Runs what may throw; the answer is that of a callback.
    template <class Work> std::uint32_t run(Work &&work) noexcept {
        RELIEVO_TRY {
            return std::forward<Work>(work)() ? RLV_PROGRESS_CONTINUE : RLV_PROGRESS_CANCEL;
        } RELIEVO_CATCH {
            thrown_ = std::current_exception();
            return RLV_PROGRESS_CANCEL;
        }
    }

    RlvProgress callback() const noexcept {
        return progress_ ? [](void *user, float fraction, const char *stage) -> std::uint32_t {
            Watch &watch = *static_cast<Watch *>(user);
            return watch.run([&] { return watch.progress_(fraction, stage); });
        } : RlvProgress(nullptr);
    }

    /// Throws what was kept, or the last error unless result is RLV_OK.
    void check(RlvResult result) const {
        if (thrown_) {
            std::rethrow_exception(thrown_);
        }
        relievo::check(result);
    }

private:
    const Progress &progress_;
    std::exception_ptr thrown_;
};

/// Moves a collider from one place to another and presses it in on the way; commit the detail to see it.
inline RlvImprintReport sweep(const Detail &detail, const Collider &collider, const Matrix &from, const Matrix &to,
                              const RlvImprintSettings &settings = RLV_IMPRINT_SETTINGS_INIT,
                              const RlvImprintMoment &moment = RLV_IMPRINT_MOMENT_INIT,
                              const Progress &progress = nullptr) {
    Watch watch(progress);
    RlvImprintReport report = RLV_IMPRINT_REPORT_INIT;
    watch.check(rlv_imprint_sweep(detail.get(), collider.get(), from.data(), to.data(), &settings, &moment,
                                  watch.callback(), &watch, &report));
    return report;
}

/// The same for a collider that deforms: its points at either place, as many as it has.
inline RlvImprintReport sweep(const Detail &detail, const Collider &collider, const Matrix &from, const Matrix &to,
                              const std::vector<std::array<float, 3>> &from_points,
                              const std::vector<std::array<float, 3>> &to_points,
                              const RlvImprintSettings &settings = RLV_IMPRINT_SETTINGS_INIT,
                              const RlvImprintMoment &moment = RLV_IMPRINT_MOMENT_INIT,
                              const Progress &progress = nullptr) {
    if (from_points.size() != to_points.size()) {
        raise(std::invalid_argument("sweep: a collider has as many points before as after"));
    }
    Watch watch(progress);
    RlvImprintReport report = RLV_IMPRINT_REPORT_INIT;
    watch.check(rlv_imprint_sweep_points(
        detail.get(), collider.get(), from.data(), to.data(), reinterpret_cast<const float *>(from_points.data()),
        reinterpret_cast<const float *>(to_points.data()), from_points.size(), 0, &settings, &moment, watch.callback(),
        &watch, &report));
    return report;
}

/// Bakes to files; see relievo/bake.h.
inline RlvBakeReport bake(const Detail &detail, const RlvBakeOptions &options, const std::string &path,
                          const Progress &progress = nullptr) {
    Watch watch(progress);
    RlvBakeReport report = RLV_BAKE_REPORT_INIT;
    watch.check(rlv_bake_write(detail.get(), &options, path.c_str(), watch.callback(), &watch, &report));
    return report;
}

/// Bakes to memory: calls receive for every picture, which may throw, which cancels.
inline RlvBakeReport bake(const Detail &detail, const RlvBakeOptions &options,
                          const std::function<void(const RlvBakePicture &)> &receive,
                          const Progress &progress = nullptr) {
    struct Baking : Watch {
        Baking(const Progress &watched, const std::function<void(const RlvBakePicture &)> &each)
            : Watch(watched), receive(each) {}
        const std::function<void(const RlvBakePicture &)> &receive;
    } baking(progress, receive);
    const RlvBakeReceiver each = [](void *user, const RlvBakePicture *picture) -> std::uint32_t {
        Baking &own = *static_cast<Baking *>(static_cast<Watch *>(user));
        return own.run([&] {
            own.receive(*picture);
            return true;
        });
    };
    RlvBakeReport report = RLV_BAKE_REPORT_INIT;
    baking.check(rlv_bake_run(detail.get(), &options, each, baking.callback(), static_cast<Watch *>(&baking), &report));
    return report;
}

/// Writes a channel as Ptex; see relievo/ptex.h.
inline void write_ptex(const Detail &detail, RlvChannel channel, const std::string &path,
                       const Progress &progress = nullptr) {
    Watch watch(progress);
    watch.check(rlv_ptex_write(detail.get(), channel, path.c_str(), watch.callback(), &watch));
}

/// Gives a detail what a Ptex file has; commit it to see it.
inline RlvPtexReport read_ptex(const Detail &detail, const std::string &path,
                               const RlvPtexOptions &options = RLV_PTEX_OPTIONS_INIT,
                               const Progress &progress = nullptr) {
    Watch watch(progress);
    RlvPtexReport report = RLV_PTEX_REPORT_INIT;
    watch.check(rlv_ptex_read(detail.get(), path.c_str(), &options, watch.callback(), &watch, &report));
    return report;
}

/// Takes a document to another mesh; see relievo/document.h.
inline RlvTransferReport transfer(const Context &context, const std::string &path, const Mesh &to,
                                  const std::string &to_path,
                                  const RlvTransferOptions &options = RLV_TRANSFER_OPTIONS_INIT,
                                  const Progress &progress = nullptr) {
    Watch watch(progress);
    RlvTransferReport report = RLV_TRANSFER_REPORT_INIT;
    watch.check(rlv_document_transfer(context.get(), to.get(), path.c_str(), to_path.c_str(), &options, watch.callback(),
                                      &watch, &report));
    return report;
}

/// Presses two details into each other; commit both to see it.
inline std::pair<RlvImprintReport, RlvImprintReport> collide(const Detail &first, const Detail &second,
                                                             const RlvImprintSettings &first_settings,
                                                             const RlvImprintSettings &second_settings,
                                                             const RlvImprintMoment &moment = RLV_IMPRINT_MOMENT_INIT) {
    std::pair<RlvImprintReport, RlvImprintReport> reports{RLV_IMPRINT_REPORT_INIT, RLV_IMPRINT_REPORT_INIT};
    check(rlv_imprint_collide(first.get(), second.get(), &first_settings, &second_settings, &moment, &reports.first,
                              &reports.second));
    return reports;
}

/// The layers of a detail. See relievo/layer.h.
class Layers {
public:
    explicit Layers(Detail detail) noexcept : detail_(std::move(detail)) {}

    std::vector<RlvLayerInfo> list() const {
        std::size_t count = 0;
        check(rlv_layer_count(detail_.get(), &count));
        std::vector<RlvLayerInfo> layers(count, RLV_LAYER_INFO_INIT);
        for (std::size_t index = 0; index < count; ++index) {
            check(rlv_layer_info(detail_.get(), index, &layers[index]));
        }
        return layers;
    }

    /// Returns the number of the new layer.
    std::uint32_t add(const std::string &name, const RlvLayerOptions &options) const {
        std::uint32_t id = 0;
        check(rlv_layer_add(detail_.get(), name.c_str(), &options, &id));
        return id;
    }

    void set(std::uint32_t id, const RlvLayerOptions &options) const { check(rlv_layer_set(detail_.get(), id, &options)); }
    void set_active(std::uint32_t id) const { check(rlv_layer_set_active(detail_.get(), id)); }
    void rename(std::uint32_t id, const std::string &name) const {
        check(rlv_layer_rename(detail_.get(), id, name.c_str()));
    }
    void place(std::uint32_t id, std::size_t place) const { check(rlv_layer_place(detail_.get(), id, place)); }
    void remove(std::uint32_t id) const { check(rlv_layer_remove(detail_.get(), id)); }
    void merge(std::uint32_t id) const { check(rlv_layer_merge(detail_.get(), id)); }
    void flatten() const { check(rlv_layer_flatten(detail_.get())); }

private:
    Detail detail_;
};

/// The history of a detail, in a file or not. See relievo/document.h.
class Document : public Reference<RlvDocument, rlv_document_retain, rlv_document_release> {
public:
    using Reference::Reference;

    /// An empty path keeps the history without a file.
    static Document create(const Detail &detail, const std::string &path = "", std::uint64_t memory = 0) {
        Document made;
        check(rlv_document_create(detail.get(), path.empty() ? nullptr : path.c_str(), memory, made.out()));
        return made;
    }

    static Document open(const Detail &detail, const std::string &path, std::uint64_t memory = 0) {
        Document made;
        check(rlv_document_open(detail.get(), path.c_str(), memory, made.out()));
        return made;
    }

    /// In storage of the host in place of a file.
    static Document create(const Detail &detail, std::shared_ptr<Storage> storage, std::uint64_t memory = 0) {
        Document made;
        const RlvStream stream = Storage::stream(std::move(storage));
        check(rlv_document_create_stream(detail.get(), &stream, memory, made.out()));
        return made;
    }

    static Document open(const Detail &detail, std::shared_ptr<Storage> storage, std::uint64_t memory = 0) {
        Document made;
        const RlvStream stream = Storage::stream(std::move(storage));
        check(rlv_document_open_stream(detail.get(), &stream, memory, made.out()));
        return made;
    }

    static Document open_bytes(const Detail &detail, const std::uint8_t *bytes, std::size_t size, std::uint64_t memory = 0) {
        Document made;
        check(rlv_document_open_bytes(detail.get(), bytes, size, memory, made.out()));
        return made;
    }

    RlvDocumentInfo info() const {
        RlvDocumentInfo info = RLV_DOCUMENT_INFO_INIT;
        check(rlv_document_info(get(), &info));
        return info;
    }

    /// Calls `work`, whose edits become one; an exception takes them back and goes on.
    template <class Work> RlvDocumentChanges edit(const std::string &input, Work &&work) const {
        check(rlv_document_begin(get(), input.c_str()));
        RELIEVO_TRY {
            std::forward<Work>(work)();
        } RELIEVO_CATCH {
            rlv_document_abandon(get());
            RELIEVO_RETHROW;
        }
        RlvDocumentChanges changes = RLV_DOCUMENT_CHANGES_INIT;
        check(rlv_document_end(get(), &changes));
        return changes;
    }

    /// is_done of the result says whether there was anything to undo.
    RlvDocumentChanges undo() const {
        RlvDocumentChanges changes = RLV_DOCUMENT_CHANGES_INIT;
        check(rlv_document_undo(get(), &changes));
        return changes;
    }

    RlvDocumentChanges redo() const {
        RlvDocumentChanges changes = RLV_DOCUMENT_CHANGES_INIT;
        check(rlv_document_redo(get(), &changes));
        return changes;
    }

    /// The mesh that a file was made on, without creases and attributes.
    static Mesh mesh(const Context &context, const std::string &path) {
        RlvMesh made{0};
        check(rlv_document_mesh(context.get(), path.c_str(), &made));
        return Mesh(made);
    }

    /// The mesh that a document in bytes was made on.
    static Mesh mesh(const Context &context, const std::uint8_t *bytes, std::size_t size) {
        RlvMesh made{0};
        check(rlv_document_mesh_bytes(context.get(), bytes, size, &made));
        return Mesh(made);
    }

    void save(const std::string &path) const { check(rlv_document_save(get(), path.c_str())); }

    void save(std::shared_ptr<Storage> storage) const {
        const RlvStream stream = Storage::stream(std::move(storage));
        check(rlv_document_save_stream(get(), &stream));
    }

    Bytes save_bytes() const {
        RlvBytes made{0};
        check(rlv_document_save_bytes(get(), &made));
        return Bytes(made);
    }

    void sync() const { check(rlv_document_sync(get())); }
};

/// See relievo/brush.h.
class Brush : public Reference<RlvBrush, rlv_brush_retain, rlv_brush_release> {
public:
    using Reference::Reference;

    static Brush create(const Context &context, const RlvBrushOptions &options,
                        const RlvBrushSettings &settings = RLV_BRUSH_SETTINGS_INIT) {
        Brush made;
        check(rlv_brush_create(context.get(), &options, &settings, made.out()));
        return made;
    }

    void set(const RlvBrushOptions &options, const RlvBrushSettings &settings = RLV_BRUSH_SETTINGS_INIT) const {
        check(rlv_brush_set(get(), &options, &settings));
    }

    /// Pairs of a pressure and what it is taken as; none takes the pressure itself.
    void set_curve(RlvCurve curve, const std::vector<std::array<double, 2>> &points) const {
        const auto count = points.size();
        check(rlv_brush_set_curve(get(), curve, count == 0 ? nullptr : points.front().data(), count));
    }

    /// width times height pixels of `channels` numbers each, row by row from the top.
    void set_stamp(std::uint32_t width, std::uint32_t height, std::uint32_t channels, const std::vector<float> &pixels,
                   const RlvStampSettings &settings = RLV_STAMP_SETTINGS_INIT, std::uint32_t channel = 0) const {
        if (pixels.size() != std::size_t{width} * height * channels) {
            raise(Error(RLV_ERROR_INVALID, "stamp: the pixels are not as many as its size says",
                        "the pixels are not as many as its size says", "stamp", "give width * height * channels numbers"));
        }
        RlvStampOptions options = RLV_STAMP_OPTIONS_INIT;
        options.channel = channel;
        options.width = width;
        options.height = height;
        options.channels = channels;
        options.pixels = pixels.data();
        check(rlv_brush_set_stamp(get(), &options, &settings));
    }

    void remove_stamp() const { check(rlv_brush_set_stamp(get(), nullptr, nullptr)); }
};

/// A stroke that is being drawn. See relievo/stroke.h.
class Stroke : public Reference<RlvStroke, rlv_stroke_retain, rlv_stroke_release> {
public:
    using Reference::Reference;

    static Stroke begin(const Detail &detail, const Brush &brush) {
        Stroke made;
        check(rlv_stroke_begin(detail.get(), brush.get(), made.out()));
        return made;
    }

    RlvStrokeReport extend(const std::vector<RlvStrokePoint> &points) const {
        RlvStrokeReport report = RLV_STROKE_REPORT_INIT;
        check(rlv_stroke_extend(get(), points.data(), points.size(), 0, &report));
        return report;
    }

    RlvStrokeReport end() const {
        RlvStrokeReport report = RLV_STROKE_REPORT_INIT;
        check(rlv_stroke_end(get(), &report));
        return report;
    }
};

/// Makes a whole stroke; commit the detail to see it.
inline RlvStrokeReport stroke(const Detail &detail, const Brush &brush, const std::vector<RlvStrokePoint> &points) {
    RlvStrokeReport report = RLV_STROKE_REPORT_INIT;
    check(rlv_stroke_run(detail.get(), brush.get(), points.data(), points.size(), 0, &report));
    return report;
}

/// A ray; the direction may have any length but zero. It hits nothing of a caster with whose mask it shares no bit; time
/// is of isosurfaces, in seconds.
struct CastRay {
    Float3 origin, direction;
    std::uint32_t mask = 0xffffffffu;
    float time = 0.0f;

    /// What the C functions take of rays, as long as these live; without hits.
    static RlvRayArrays arrays(const std::vector<CastRay> &rays, float max_distance) {
        RlvRayArrays arrays = RLV_RAY_ARRAYS_INIT;
        arrays.count = rays.size();
        if (!rays.empty()) {
            const CastRay &first = rays.front();
            arrays.origins = first.origin.data();
            arrays.directions = first.direction.data();
            arrays.masks = &first.mask;
            arrays.times = &first.time;
        }
        arrays.origin_stride = arrays.direction_stride = arrays.mask_stride = arrays.time_stride = sizeof(CastRay);
        arrays.max_distance = max_distance;
        return arrays;
    }
};

/// See relievo/caster.h.
class Caster : public Reference<RlvCaster, rlv_caster_retain, rlv_caster_release> {
public:
    using Reference::Reference;

    static Caster create(const Context &context, const Mesh &mesh) {
        Caster made;
        check(rlv_caster_create_mesh(context.get(), mesh.get(), made.out()));
        return made;
    }

    static Caster create(const Detail &detail,
                         const RlvTessellateOptions &options = RLV_TESSELLATE_OPTIONS_INIT) {
        Caster made;
        check(rlv_caster_create_detail(detail.get(), &options, made.out()));
        return made;
    }

    /// One that follows a tessellation; see update.
    static Caster create(const Tessellation &tessellation) {
        Caster made;
        check(rlv_caster_create_tessellation(tessellation.get(), made.out()));
        return made;
    }

    /// Goes to the last update of the tessellation.
    void update() const { check(rlv_caster_update(get())); }

    /// Has rays that share no bit with it hit nothing; all bits are set at first.
    void set_mask(std::uint32_t mask) const { check(rlv_caster_set_mask(get(), mask)); }

    std::vector<RlvHit> cast(const std::vector<CastRay> &rays, float max_distance = 0.0f) const {
        std::vector<RlvHit> hits(rays.size());
        RlvRayArrays arrays = CastRay::arrays(rays, max_distance);
        arrays.hits = hits.data();
        check(rlv_caster_cast(get(), &arrays));
        return hits;
    }

    /// 1 for each ray that hits anything, 0 for the others.
    std::vector<std::uint8_t> occluded(const std::vector<CastRay> &rays, float max_distance = 0.0f) const {
        std::vector<std::uint8_t> found(rays.size());
        const RlvRayArrays arrays = CastRay::arrays(rays, max_distance);
        check(rlv_caster_occluded(get(), &arrays, found.data(), 0));
        return found;
    }
};

/// What is at hits of a procedural, one element per hit; colours are empty unless they were asked for.
struct ShadedHits {
    std::vector<std::uint32_t> tiles;
    std::vector<Float3> positions, normals;
    std::vector<std::array<float, 4>> colors;
};

/// A hit as the functions of the table write it; its time is 0 to 1 over the interval of the motion.
struct ProceduralHit {
    std::uint32_t primitive;
    Float2 uv;
    float time = 0.0f;
};

/// See relievo/procedural.h.
class Procedural : public Reference<RlvProcedural, rlv_procedural_retain, rlv_procedural_release> {
public:
    using Reference::Reference;

    static Procedural create(const Detail &detail,
                             const RlvProceduralOptions &options = RLV_PROCEDURAL_OPTIONS_INIT) {
        Procedural made;
        check(rlv_procedural_create(detail.get(), &options, made.out()));
        return made;
    }

    /// One that moves from what begin was made of to a detail as it was committed last.
    static Procedural create_moving(const Procedural &begin, const Detail &end) {
        Procedural made;
        check(rlv_procedural_create_moving(begin.get(), end.get(), made.out()));
        return made;
    }

    RlvProceduralInfo info() const {
        RlvProceduralInfo info = RLV_PROCEDURAL_INFO_INIT;
        check(rlv_procedural_info(get(), &info));
        return info;
    }

    /// The functions for a renderer's callbacks, valid as long as a reference lives.
    RlvProceduralTable table() const {
        RlvProceduralTable table = RLV_PROCEDURAL_TABLE_INIT;
        check(rlv_procedural_table(get(), &table));
        return table;
    }

    ShadedHits evaluate(const std::vector<ProceduralHit> &hits, bool colors = false) const {
        ShadedHits made;
        if (hits.empty()) {
            return made;
        }
        RlvProceduralHits arrays = RLV_PROCEDURAL_HITS_INIT;
        made.tiles.resize(hits.size());
        made.positions.resize(hits.size());
        made.normals.resize(hits.size());
        arrays.count = hits.size();
        arrays.primitives = &hits.front().primitive;
        arrays.uvs = hits.front().uv.data();
        arrays.times = &hits.front().time;
        arrays.primitive_stride = arrays.uv_stride = arrays.time_stride = sizeof(ProceduralHit);
        arrays.tiles = made.tiles.data();
        arrays.positions = made.positions.front().data();
        arrays.normals = made.normals.front().data();
        if (colors) {
            made.colors.resize(hits.size());
            arrays.colors = made.colors.front().data();
        }
        check(rlv_procedural_evaluate(get(), &arrays));
        return made;
    }
};

/// Something that is said of the whole file of a picture.
struct PictureMeta {
    std::string name;
    /// Empty if it is numbers.
    std::string text;
    /// Empty if it is a text.
    std::vector<double> numbers;
};

/// See relievo/picture.h.
class Picture : public Reference<RlvPicture, rlv_picture_retain, rlv_picture_release> {
public:
    using Reference::Reference;

    static Picture open(const Context &context, const std::string &path) {
        Picture made;
        check(rlv_picture_open(context.get(), path.c_str(), made.out()));
        return made;
    }

    RlvPictureInfo info() const {
        RlvPictureInfo info = RLV_PICTURE_INFO_INIT;
        check(rlv_picture_info(get(), &info));
        return info;
    }

    RlvPictureImage image(std::uint32_t index) const {
        RlvPictureImage image = RLV_PICTURE_IMAGE_INIT;
        check(rlv_picture_image(get(), index, &image));
        return image;
    }

    std::vector<PictureMeta> meta() const {
        std::vector<PictureMeta> all(info().meta_count);
        for (std::uint32_t index = 0; index < all.size(); ++index) {
            RlvPictureMeta meta = RLV_PICTURE_META_INIT;
            check(rlv_picture_meta(get(), index, &meta));
            all[index].name = meta.name;
            switch (meta.type) {
            case RLV_PICTURE_TEXT:
                all[index].text.assign(static_cast<const char *>(meta.values), meta.count);
                break;
            case RLV_PICTURE_I32: all[index].numbers = numbers<std::int32_t>(meta); break;
            case RLV_PICTURE_F32: all[index].numbers = numbers<float>(meta); break;
            default: all[index].numbers = numbers<double>(meta); break;
            }
        }
        return all;
    }

    /// The bytes of a whole level, row by row, without padding.
    std::vector<unsigned char> read(std::uint32_t index, std::uint32_t level = 0) const {
        const RlvPictureImage image = this->image(index);
        if (level >= image.level_count) {
            raise(Error(RLV_ERROR_INVALID, "read: there is no such level", "there is no such level", "read",
                        "levels are counted from 0 to image().level_count - 1"));
        }
        const std::uint32_t width = image.width >> level, height = image.height >> level;
        const std::size_t number = image.type == RLV_PICTURE_U8 ? 1 : image.type == RLV_PICTURE_F32 ? 4 : 2;
        std::vector<unsigned char> pixels(number * image.channels * width * height);
        check(rlv_picture_read(get(), index, level, 0, 0, width, height, pixels.data(), 0));
        return pixels;
    }

private:
    template <class Number> static std::vector<double> numbers(const RlvPictureMeta &meta) {
        const Number *const first = static_cast<const Number *>(meta.values);
        return std::vector<double>(first, first + meta.count);
    }
};

/// See relievo/subdivision.h.
class Subdivision : public Reference<RlvSubdivision, rlv_subdivision_retain, rlv_subdivision_release> {
public:
    using Reference::Reference;

    static Subdivision create(const Context &context, const Mesh &cage,
                              const RlvSubdivisionOptions &options = RLV_SUBDIVISION_OPTIONS_INIT) {
        Subdivision made;
        check(rlv_subdivision_create(context.get(), cage.get(), &options, made.out()));
        return made;
    }

    RlvSubdivisionInfo info() const {
        RlvSubdivisionInfo info = RLV_SUBDIVISION_INFO_INIT;
        check(rlv_subdivision_info(get(), &info));
        return info;
    }

    void set_points(const std::vector<Float3> &points) const {
        check(rlv_subdivision_set_points(get(), points.empty() ? nullptr : points.front().data(), points.size(), 0));
    }

    /// The first tile of a face and how many it has.
    std::pair<std::uint32_t, std::uint32_t> face_tiles(std::uint32_t face) const {
        std::pair<std::uint32_t, std::uint32_t> tiles;
        check(rlv_subdivision_face_tiles(get(), face, &tiles.first, &tiles.second));
        return tiles;
    }

    /// Evaluates the points of the cage: positions and first derivatives.
    Samples evaluate(const std::vector<Place> &places) const {
        Samples made;
        made.positions.resize(places.size());
        made.du.resize(places.size());
        made.dv.resize(places.size());
        if (!places.empty()) {
            RlvSubdivisionArrays arrays = arrays_of(places);
            arrays.values = made.positions.front().data();
            arrays.du = made.du.front().data();
            arrays.dv = made.dv.front().data();
            check(rlv_subdivision_evaluate(get(), nullptr, &arrays));
        }
        return made;
    }

    /// Evaluates an attribute of N floats.
    template <std::size_t N>
    std::vector<std::array<float, N>> evaluate(const std::string &attribute, const std::vector<Place> &places,
                                               RlvPointRule rule = RLV_POINT_VERTEX) const {
        std::vector<std::array<float, N>> values(places.size());
        if (places.empty()) return values;
        RlvSubdivisionArrays arrays = arrays_of(places);
        arrays.point_rule = rule;
        arrays.values = values.front().data();
        arrays.value_stride = sizeof values.front();
        check(rlv_subdivision_evaluate(get(), attribute.c_str(), &arrays));
        return values;
    }

    Mesh refine(std::uint32_t level) const {
        RlvMesh made{0};
        check(rlv_subdivision_refine(get(), level, &made));
        return Mesh(made);
    }

private:
    static RlvSubdivisionArrays arrays_of(const std::vector<Place> &places) {
        RlvSubdivisionArrays arrays = RLV_SUBDIVISION_ARRAYS_INIT;
        arrays.count = places.size();
        arrays.tiles = &places.front().tile;
        arrays.tile_stride = sizeof(Place);
        arrays.uvs = places.front().uv.data();
        arrays.uv_stride = sizeof(Place);
        return arrays;
    }
};

/// See relievo/bezier.h.
class Bezier : public Reference<RlvBezier, rlv_bezier_retain, rlv_bezier_release> {
public:
    using Reference::Reference;

    /// Triangles of all patches: grids of points, patch after patch.
    struct Triangles {
        std::vector<Float3> positions, normals;
        std::vector<Triangle> corners;
    };

    static Bezier create(const Context &context, const RlvBezierArrays &arrays) {
        Bezier made;
        check(rlv_bezier_create(context.get(), &arrays, made.out()));
        return made;
    }

    /// Patches of points, 16 after 16, or of the points that the indices name; weights, if there are some, are of the
    /// points.
    static Bezier create(const Context &context, const std::vector<Float3> &points,
                         const std::vector<std::uint32_t> &indices = {}, const std::vector<float> &weights = {}) {
        RlvBezierArrays arrays = RLV_BEZIER_ARRAYS_INIT;
        arrays.points = points.empty() ? nullptr : points.front().data();
        arrays.point_count = points.size();
        arrays.indices = indices.empty() ? nullptr : indices.data();
        arrays.index_count = indices.size();
        if (!weights.empty() && weights.size() != points.size()) {
            raise(Error(RLV_ERROR_INVALID, "weights: there is not one for every point",
                        "there is not one for every point", "weights", ""));
        }
        arrays.weights = weights.empty() ? nullptr : weights.data();
        return create(context, arrays);
    }

    static Bezier read(const Context &context, const std::string &path) {
        Bezier made;
        check(rlv_bezier_read(context.get(), path.c_str(), made.out()));
        return made;
    }

    RlvBezierInfo info() const {
        RlvBezierInfo info = RLV_BEZIER_INFO_INIT;
        check(rlv_bezier_info(get(), &info));
        return info;
    }

    /// Positions, normals and first derivatives; the tile of a place is a patch.
    Samples evaluate(const std::vector<Place> &places) const {
        Samples made;
        RlvEvaluateArrays arrays = RLV_EVALUATE_ARRAYS_INIT;
        if (!places.empty()) {
            made.prepare(places, arrays);
            made.du.resize(places.size());
            made.dv.resize(places.size());
            arrays.du = made.du.front().data();
            arrays.dv = made.dv.front().data();
            check(rlv_bezier_evaluate(get(), &arrays));
        }
        return made;
    }

    /// A level for every patch.
    std::vector<std::uint32_t> levels(const RlvBezierView &view) const {
        std::vector<std::uint32_t> levels(info().patch_count);
        check(rlv_bezier_levels(get(), &view, levels.data(), levels.size()));
        return levels;
    }

    Triangles tessellate(const RlvBezierLevels &levels = RLV_BEZIER_LEVELS_INIT) const {
        std::size_t points = 0, triangles = 0;
        check(rlv_bezier_count(get(), &levels, &points, &triangles));
        Triangles made;
        made.positions.resize(points);
        made.normals.resize(points);
        made.corners.resize(triangles);
        RlvBezierTriangles room = RLV_BEZIER_TRIANGLES_INIT;
        room.positions = made.positions.front().data();
        room.normals = made.normals.front().data();
        room.point_capacity = points;
        room.corners = made.corners.front().data();
        room.triangle_capacity = triangles;
        check(rlv_bezier_tessellate(get(), &levels, &room));
        return made;
    }

    Mesh mesh(const RlvBezierLevels &levels = RLV_BEZIER_LEVELS_INIT) const {
        RlvMesh made{0};
        check(rlv_bezier_mesh(get(), &levels, &made));
        return Mesh(made);
    }
};

struct RefittedCrowdModel;

/// A character or a static model with its clips and clusters; see relievo/crowd.h.
class CrowdModel : public Reference<RlvCrowdModel, rlv_crowd_model_retain, rlv_crowd_model_release> {
public:
    using Reference::Reference;

    /// Builds the hierarchy of a file for some of its clips, or for all without names.
    static CrowdModel build(const Context &context, const std::string &path, const std::vector<std::string> &clips = {},
                            const RlvCrowdBuildSettings &settings = RLV_CROWD_BUILD_SETTINGS_INIT,
                            const Progress &progress = nullptr) {
        Watch watch(progress);
        CrowdModel made;
        const std::vector<RlvCrowdClipName> names = names_of(clips);
        watch.check(rlv_crowd_model_build(context.get(), path.c_str(), names.data(), names.size(), &settings,
                                          watch.callback(), &watch, made.out()));
        return made;
    }

    /// Makes a model with the same clusters of a file that was sculpted or has other clips since.
    RefittedCrowdModel refit(const std::string &path, const std::vector<std::string> &clips = {},
                             const RlvCrowdBuildSettings &settings = RLV_CROWD_BUILD_SETTINGS_INIT,
                             const Progress &progress = nullptr) const;

    /// Makes a model with the same clusters whose bones are blended as an RlvCrowdBlend says.
    CrowdModel with_blend(std::uint32_t blend) const {
        CrowdModel made;
        check(rlv_crowd_model_with_blend(get(), blend, made.out()));
        return made;
    }

    static CrowdModel read(const Context &context, const std::string &path) {
        CrowdModel made;
        check(rlv_crowd_model_read(context.get(), path.c_str(), made.out()));
        return made;
    }

    void write(const std::string &path) const { check(rlv_crowd_model_write(get(), path.c_str())); }

    static CrowdModel read_bytes(const Context &context, const std::uint8_t *bytes, std::size_t size) {
        CrowdModel made;
        check(rlv_crowd_model_read_bytes(context.get(), bytes, size, made.out()));
        return made;
    }

    Bytes write_bytes() const {
        RlvBytes made{0};
        check(rlv_crowd_model_write_bytes(get(), &made));
        return Bytes(made);
    }

    RlvCrowdModelInfo info() const {
        RlvCrowdModelInfo info = RLV_CROWD_MODEL_INFO_INIT;
        check(rlv_crowd_model_info(get(), &info));
        return info;
    }

    RlvCrowdClip clip(std::uint32_t index) const {
        RlvCrowdClip clip = RLV_CROWD_CLIP_INIT;
        check(rlv_crowd_model_clip(get(), index, &clip));
        return clip;
    }

    /// Returns the name of a material.
    std::string material(std::uint32_t index) const {
        RlvCrowdMaterial material = RLV_CROWD_MATERIAL_INIT;
        check(rlv_crowd_model_material(get(), index, &material));
        return material.name;
    }

    /// Returns the positions at binding, which all clusters share.
    std::vector<Float3> points() const {
        std::vector<Float3> points(info().vertex_count);
        RlvCrowdVertices vertices = RLV_CROWD_VERTICES_INIT;
        vertices.capacity = points.size();
        vertices.points = reinterpret_cast<float *>(points.data());
        check(rlv_crowd_model_get_vertices(get(), &vertices));
        return points;
    }

    /// Returns the triangles of all clusters, one cluster after the other.
    std::vector<Triangle> triangles() const {
        std::vector<Triangle> triangles(info().triangle_count);
        auto *first = reinterpret_cast<std::uint32_t *>(triangles.data());
        check(rlv_crowd_model_get_triangles(get(), first, nullptr, triangles.size()));
        return triangles;
    }

    /// Returns where each vertex goes when its place is removed.
    std::vector<RlvCrowdCollapse> collapses() const {
        std::vector<RlvCrowdCollapse> collapses(info().vertex_count);
        check(rlv_crowd_model_get_collapses(get(), collapses.data(), collapses.size(), 0));
        return collapses;
    }

    /// Returns what morph targets that clips move add to vertices.
    std::vector<RlvCrowdOffset> offsets() const {
        std::vector<RlvCrowdOffset> offsets(info().offset_count);
        check(rlv_crowd_model_get_offsets(get(), offsets.data(), offsets.size(), 0));
        return offsets;
    }

    std::vector<RlvCrowdCluster> clusters() const {
        std::vector<RlvCrowdCluster> clusters(info().cluster_count);
        check(rlv_crowd_model_get_clusters(get(), clusters.data(), clusters.size(), 0));
        return clusters;
    }

    /// Makes a mesh of the clusters at an error, in a pose of a clip.
    Mesh mesh(float error, std::uint32_t clip = 0, std::uint32_t pose = 0) const {
        RlvMesh made = RLV_NULL;
        check(rlv_crowd_model_mesh(get(), error, clip, pose, &made));
        return Mesh(made);
    }

    /// Clips as the C ABI takes them, while the texts live.
    static std::vector<RlvCrowdClipName> names_of(const std::vector<std::string> &clips) {
        std::vector<RlvCrowdClipName> names;
        for (const std::string &clip : clips) {
            names.push_back({clip.c_str()});
        }
        return names;
    }
};

/// A model that was refitted, and what changed.
struct RefittedCrowdModel {
    CrowdModel model;
    RlvCrowdRefitReport report;
};

inline RefittedCrowdModel CrowdModel::refit(const std::string &path, const std::vector<std::string> &clips,
                                            const RlvCrowdBuildSettings &settings, const Progress &progress) const {
    Watch watch(progress);
    RefittedCrowdModel made{{}, RLV_CROWD_REFIT_REPORT_INIT};
    const std::vector<RlvCrowdClipName> names = names_of(clips);
    watch.check(rlv_crowd_model_refit(get(), path.c_str(), names.data(), names.size(), &settings, watch.callback(), &watch,
                                      &made.report, made.model.out()));
    return made;
}

/// The parts of a skin matrix that dual quaternions blend: three rows of its stretch, then its rotation and its dual part.
using CrowdDualRows = std::array<float, 20>;

/// What a view draws of a crowd.
struct CrowdDraws {
    std::vector<RlvCrowdDraw> draws;
    /// Model and cluster of each draw.
    std::vector<std::array<std::uint32_t, 2>> clusters;
    std::vector<RlvCrowdInstance> instances;
    std::vector<std::array<float, 12>> matrices;
    /// Weights of the morph targets of the poses that are shown, and the first of the pose of each instance.
    std::vector<float> weights;
    std::vector<std::uint32_t> first_weights;
    /// How far the vertices of each draw are on the way to their targets, 0 to 1.
    std::vector<float> blends;

    /// Makes room for what a cut found, which `counts` has the numbers of, and returns buffers that lie in it.
    template <class Counts> RlvCrowdBuffers make_room(const Counts &counts) {
        draws.resize(counts.draw_count);
        clusters.resize(counts.draw_count);
        instances.resize(counts.agent_count);
        matrices.resize(counts.matrix_count);
        weights.resize(counts.weight_count);
        first_weights.resize(counts.agent_count);
        blends.resize(counts.draw_count);
        RlvCrowdBuffers buffers = RLV_CROWD_BUFFERS_INIT;
        buffers.draws = draws.data();
        buffers.draw_capacity = draws.size();
        buffers.clusters = reinterpret_cast<std::uint32_t *>(clusters.data());
        buffers.instances = instances.data();
        buffers.instance_capacity = instances.size();
        buffers.matrices = reinterpret_cast<float *>(matrices.data());
        buffers.matrix_capacity = matrices.size();
        buffers.weights = weights.data();
        buffers.weight_capacity = weights.size();
        buffers.first_weights = first_weights.data();
        buffers.blends = blends.data();
        return buffers;
    }
};

/// The quads of agents of a few pixels, with their pictures and the texels of one picture after the other.
struct CrowdQuads {
    std::vector<RlvCrowdImpostor> impostors;
    std::vector<RlvCrowdPicture> pictures;
    std::vector<RlvCrowdTexel> texels;

    /// Makes room for what a cut found, which `counts` has the numbers of, and returns buffers that lie in it.
    template <class Counts> RlvCrowdImpostors make_room(const Counts &counts) {
        impostors.resize(counts.impostor_count);
        pictures.resize(counts.picture_count);
        texels.resize(std::size_t{RLV_CROWD_PICTURE_SIDE} * RLV_CROWD_PICTURE_SIDE * counts.picture_count);
        RlvCrowdImpostors buffers = RLV_CROWD_IMPOSTORS_INIT;
        buffers.impostors = impostors.data();
        buffers.impostor_capacity = impostors.size();
        buffers.pictures = pictures.data();
        buffers.picture_capacity = pictures.size();
        buffers.texels = texels.data();
        buffers.texel_capacity = texels.size();
        return buffers;
    }
};

/// Agents of some models; see relievo/crowd.h.
class Crowd : public Reference<RlvCrowd, rlv_crowd_retain, rlv_crowd_release> {
public:
    using Reference::Reference;

    static Crowd create(const Context &context, const std::vector<CrowdModel> &models) {
        std::vector<RlvCrowdModel> handles;
        for (const CrowdModel &model : models) {
            handles.push_back(model.get());
        }
        Crowd made;
        check(rlv_crowd_create(context.get(), handles.data(), handles.size(), made.out()));
        return made;
    }

    /// Adds agents and returns the number of the first.
    std::uint32_t add(const std::vector<RlvCrowdAgent> &agents) const {
        std::uint32_t first = 0;
        check(rlv_crowd_add(get(), agents.data(), agents.size(), 0, &first));
        return first;
    }

    void set(std::uint32_t first, const std::vector<RlvCrowdAgent> &agents) const {
        check(rlv_crowd_set(get(), first, agents.data(), agents.size(), 0));
    }

    /// Gives an agent weights of its own for the morph targets of its model.
    void set_weights(std::uint32_t agent, const std::vector<float> &weights) const {
        check(rlv_crowd_set_weights(get(), agent, weights.data(), weights.size()));
    }

    /// Gives an agent the weights of its clip again.
    void reset_weights(std::uint32_t agent) const { check(rlv_crowd_set_weights(get(), agent, nullptr, 0)); }

    /// As below, with agents out of sight that may throw shadows of suns into the view.
    RlvCrowdFrame cut(RlvCrowdView view, const std::vector<RlvCrowdSun> &suns) {
        view.suns = suns.data();
        view.sun_count = suns.size();
        return cut(view);
    }

    RlvCrowdFrame cut(const RlvCrowdView &view) {
        RlvCrowdFrame frame = RLV_CROWD_FRAME_INIT;
        check(rlv_crowd_cut(get(), &view, &frame));
        return frame;
    }

    /// Returns what a cut found; `frame` is that of the last one.
    CrowdDraws draws(const RlvCrowdFrame &frame) const {
        CrowdDraws found;
        const RlvCrowdBuffers buffers = found.make_room(frame);
        check(rlv_crowd_get(get(), &buffers));
        return found;
    }

    /// Returns the matrices as they are blended by dual quaternions; `frame` is that of the last cut.
    std::vector<CrowdDualRows> dual_rows(const RlvCrowdFrame &frame) const {
        std::vector<CrowdDualRows> found(frame.matrix_count);
        RlvCrowdBuffers buffers = RLV_CROWD_BUFFERS_INIT;
        buffers.dual_rows = reinterpret_cast<float *>(found.data());
        buffers.matrix_capacity = found.size();
        check(rlv_crowd_get(get(), &buffers));
        return found;
    }

    /// Returns the impostors of a cut; `frame` is that of the last one.
    CrowdQuads impostors(const RlvCrowdFrame &frame) const {
        CrowdQuads found;
        const RlvCrowdImpostors buffers = found.make_room(frame);
        check(rlv_crowd_get_impostors(get(), &buffers));
        return found;
    }
};

/// A crowd whose cuts read clusters of files; see relievo/crowd_stream.h.
class CrowdStream : public Crowd {
public:
    using Crowd::Crowd;

    static CrowdStream open(const Context &context, const std::vector<std::string> &paths,
                            const RlvCrowdStreamSettings &settings = RLV_CROWD_STREAM_SETTINGS_INIT) {
        std::vector<RlvCrowdStreamFile> files;
        for (const std::string &path : paths) {
            files.push_back({path.c_str()});
        }
        CrowdStream made;
        check(rlv_crowd_stream_open(context.get(), files.data(), files.size(), &settings, made.out()));
        return made;
    }

    /// Returns a model, which has no triangles.
    CrowdModel model(std::uint32_t index) const {
        RlvCrowdModel made = RLV_NULL;
        check(rlv_crowd_stream_model(get(), index, &made));
        return CrowdModel(made);
    }

    RlvCrowdStreamInfo info() const {
        RlvCrowdStreamInfo info = RLV_CROWD_STREAM_INFO_INIT;
        check(rlv_crowd_stream_info(get(), &info));
        return info;
    }

    /// Returns the clusters that the last cut has read, or opening has.
    std::vector<RlvCrowdStreamCluster> read() const {
        std::vector<RlvCrowdStreamCluster> clusters(info().read);
        check(rlv_crowd_stream_get_read(get(), clusters.data(), clusters.size(), 0));
        return clusters;
    }

    /// Returns the triangles of a cluster that was read.
    std::vector<Triangle> triangles(const RlvCrowdStreamCluster &cluster) const {
        std::vector<Triangle> triangles(cluster.triangle_count);
        auto *first = reinterpret_cast<std::uint32_t *>(triangles.data());
        check(rlv_crowd_stream_get_triangles(get(), cluster.slot, first, nullptr, triangles.size()));
        return triangles;
    }
};

/// Agents of a crowd on the graphics device of its context; see relievo/device_crowd.h.
class DeviceCrowd : public Reference<RlvDeviceCrowd, rlv_device_crowd_retain, rlv_device_crowd_release> {
public:
    using Reference::Reference;

    static DeviceCrowd create(const Crowd &crowd) {
        DeviceCrowd made;
        check(rlv_device_crowd_create(crowd.get(), made.out()));
        return made;
    }

    /// As below, with agents out of sight that may throw shadows of suns into the view.
    RlvDeviceCrowdInfo cut(RlvCrowdView view, const std::vector<RlvCrowdSun> &suns) {
        view.suns = suns.data();
        view.sun_count = suns.size();
        return cut(view);
    }

    RlvDeviceCrowdInfo cut(const RlvCrowdView &view) {
        RlvDeviceCrowdInfo info = RLV_DEVICE_CROWD_INFO_INIT;
        check(rlv_device_crowd_cut(get(), &view, &info));
        return info;
    }

    /// Copies what a cut found back; `info` is that of the last one.
    CrowdDraws draws(const RlvDeviceCrowdInfo &info) const {
        CrowdDraws found;
        const RlvCrowdBuffers buffers = found.make_room(info);
        check(rlv_device_crowd_get(get(), &buffers));
        return found;
    }

    /// Returns the matrices as they are blended by dual quaternions; `info` is that of the last cut.
    std::vector<CrowdDualRows> dual_rows(const RlvDeviceCrowdInfo &info) const {
        std::vector<CrowdDualRows> found(info.matrix_count);
        RlvCrowdBuffers buffers = RLV_CROWD_BUFFERS_INIT;
        buffers.dual_rows = reinterpret_cast<float *>(found.data());
        buffers.matrix_capacity = found.size();
        check(rlv_device_crowd_get(get(), &buffers));
        return found;
    }

    /// Returns the impostors of a cut; `info` is that of the last one.
    CrowdQuads impostors(const RlvDeviceCrowdInfo &info) const {
        CrowdQuads found;
        const RlvCrowdImpostors buffers = found.make_room(info);
        check(rlv_device_crowd_get_impostors(get(), &buffers));
        return found;
    }

    RlvDeviceCrowdVulkan vulkan() const {
        RlvDeviceCrowdVulkan vulkan = RLV_DEVICE_CROWD_VULKAN_INIT;
        check(rlv_device_crowd_vulkan(get(), &vulkan));
        return vulkan;
    }
};

/// A sticker on a surface; see relievo/decal.h.
class Decal : public Reference<RlvDecal, rlv_decal_retain, rlv_decal_release> {
public:
    using Reference::Reference;

    static Decal on(const Mesh &mesh, const RlvDecalOptions &options, const std::vector<RlvDecalPin> &pins,
                    const Progress &progress = nullptr) {
        Watch watch(progress);
        Decal made;
        watch.check(rlv_decal_on_mesh(mesh.get(), &options, pins.data(), pins.size(), 0, watch.callback(), &watch,
                                      made.out()));
        return made;
    }

    static Decal on(const Detail &detail, const RlvDecalOptions &options, const std::vector<RlvDecalPin> &pins,
                    const Progress &progress = nullptr) {
        Watch watch(progress);
        Decal made;
        watch.check(rlv_decal_on_detail(detail.get(), &options, pins.data(), pins.size(), 0, watch.callback(), &watch,
                                        made.out()));
        return made;
    }

    RlvDecalQuality quality() const {
        RlvDecalQuality quality = RLV_DECAL_QUALITY_INIT;
        check(rlv_decal_quality(get(), &quality));
        return quality;
    }

    Mesh mesh(double offset = 0.0) const {
        RlvMesh made = RLV_NULL;
        check(rlv_decal_mesh(get(), offset, &made));
        return Mesh(made);
    }

    void drag_pin(std::size_t pin, const Double3 &position) const {
        check(rlv_decal_drag_pin(get(), pin, position.data()));
    }

    void move_image(std::size_t pin, const std::array<double, 2> &image, const Progress &progress = nullptr) const {
        Watch watch(progress);
        watch.check(rlv_decal_move_image(get(), pin, image.data(), watch.callback(), &watch));
    }

    void pose(const std::vector<std::array<float, 3>> &points, const Progress &progress = nullptr) const {
        Watch watch(progress);
        const float *const first = points.empty() ? nullptr : points.front().data();
        watch.check(rlv_decal_pose(get(), first, points.size(), 0, watch.callback(), &watch));
    }

    void settle(const Progress &progress = nullptr) const {
        Watch watch(progress);
        watch.check(rlv_decal_settle(get(), watch.callback(), &watch));
    }

    RlvDecalReport paint(const RlvDecalImage &image, float opacity = 1.0f) const {
        RlvDecalReport report = RLV_DECAL_REPORT_INIT;
        check(rlv_decal_paint(get(), &image, opacity, &report));
        return report;
    }

    RlvDecalReport emboss(const RlvDecalImage &image, float height) const {
        RlvDecalReport report = RLV_DECAL_REPORT_INIT;
        check(rlv_decal_emboss(get(), &image, height, &report));
        return report;
    }

    RlvDecalReport write(const RlvDecalImage &image, const RlvDecalInk &ink) const {
        RlvDecalReport report = RLV_DECAL_REPORT_INIT;
        check(rlv_decal_write(get(), &image, &ink, &report));
        return report;
    }

    /// Returns the present pins.
    std::vector<RlvDecalPin> pins() const {
        std::size_t count = 0;
        check(rlv_decal_pins(get(), nullptr, 0, &count));
        std::vector<RlvDecalPin> pins(count);
        check(rlv_decal_pins(get(), pins.data(), count, &count));
        return pins;
    }

    /// Writes it into a new layer; the document keeps what it is made of. Returns its number there.
    std::uint32_t apply(const Document &document, const char *layer, const RlvDecalImage &image,
                        const RlvDecalInk &ink = RLV_DECAL_INK_INIT, const Progress &progress = nullptr) const {
        Watch watch(progress);
        std::uint32_t id = 0;
        watch.check(rlv_decal_apply(get(), document.get(), layer, &image, &ink, watch.callback(), &watch, &id));
        return id;
    }

    /// Lays a decal of a document again.
    static Decal take_up(const Document &document, std::uint32_t id, const Progress &progress = nullptr) {
        Watch watch(progress);
        Decal made;
        watch.check(rlv_decal_take_up(document.get(), id, watch.callback(), &watch, made.out()));
        return made;
    }

    /// Writes a decal of a document anew, made as this one; without `ink` as it was.
    void update(const Document &document, std::uint32_t id, const RlvDecalImage &image,
                const RlvDecalInk *ink = nullptr, const Progress &progress = nullptr) const {
        Watch watch(progress);
        watch.check(rlv_decal_update(get(), document.get(), id, &image, ink, watch.callback(), &watch));
    }

    /// Removes a decal of a document with its layer.
    static void remove(const Document &document, std::uint32_t id) { check(rlv_decal_remove(document.get(), id)); }

    /// Returns the decals that a document keeps.
    static std::vector<RlvDecalRecipe> recipes(const Document &document) {
        std::size_t count = 0;
        check(rlv_decal_count(document.get(), &count));
        std::vector<RlvDecalRecipe> found(count, RLV_DECAL_RECIPE_INIT);
        for (std::size_t index = 0; index < count; ++index) {
            check(rlv_decal_recipe(document.get(), index, &found[index]));
        }
        return found;
    }

    /// Returns the number of pixels that it changed.
    std::size_t paint_texture(const RlvDecalImage &image, const RlvDecalTexture &texture, float opacity = 1.0f) const {
        std::size_t painted = 0;
        check(rlv_decal_paint_texture(get(), &image, opacity, &texture, &painted));
        return painted;
    }

    /// Returns the outline of an image by its alpha.
    static std::vector<std::array<double, 2>> contour(const RlvDecalImage &image, std::uint32_t width,
                                                      std::uint32_t height, double level = 0.5,
                                                      double tolerance = 0.5) {
        std::size_t count = 0;
        check(rlv_decal_contour(&image, width, height, level, tolerance, nullptr, 0, &count));
        std::vector<std::array<double, 2>> corners(count);
        double *const first = corners.empty() ? nullptr : corners.front().data();
        check(rlv_decal_contour(&image, width, height, level, tolerance, first, count, &count));
        return corners;
    }

    /// Returns pins for a strip along a curve; `length`, if given, is that of the curve.
    static std::vector<RlvDecalPin> strip(const Mesh &mesh, const RlvDecalOptions &options,
                                          const std::vector<Double3> &curve, double *length = nullptr) {
        return strip_on(rlv_decal_strip_on_mesh, mesh.get(), options, curve, length);
    }

    static std::vector<RlvDecalPin> strip(const Detail &detail, const RlvDecalOptions &options,
                                          const std::vector<Double3> &curve, double *length = nullptr) {
        return strip_on(rlv_decal_strip_on_detail, detail.get(), options, curve, length);
    }

private:
    template <typename Function, typename Ground>
    static std::vector<RlvDecalPin> strip_on(Function function, Ground ground, const RlvDecalOptions &options,
                                             const std::vector<Double3> &curve, double *length) {
        const double *const first = curve.empty() ? nullptr : curve.front().data();
        std::vector<RlvDecalPin> pins(512);
        std::size_t count = 0;
        check(function(ground, &options, first, curve.size(), 0, pins.data(), pins.size(), &count, length));
        pins.resize(count);
        return pins;
    }
};

/// A mesh that was repaired, and what was found and changed.
struct Repaired {
    Mesh mesh;
    RlvRepairReport report;
};

/// Checks a mesh; see relievo/repair.h.
inline RlvRepairReport check(const Mesh &mesh, const RlvRepairSettings &settings = RLV_REPAIR_SETTINGS_INIT,
                             const Progress &progress = nullptr) {
    Watch watch(progress);
    RlvRepairReport report = RLV_REPAIR_REPORT_INIT;
    watch.check(rlv_repair_check(mesh.get(), &settings, watch.callback(), &watch, &report));
    return report;
}

/// Makes a repaired mesh of a mesh.
inline Repaired repair(const Mesh &mesh, const RlvRepairSettings &settings = RLV_REPAIR_SETTINGS_INIT,
                       const Progress &progress = nullptr) {
    Watch watch(progress);
    RlvRepairReport report = RLV_REPAIR_REPORT_INIT;
    RlvMesh made{0};
    watch.check(rlv_repair_mesh(mesh.get(), &settings, watch.callback(), &watch, &report, &made));
    return {Mesh(made), report};
}

/// Makes a repaired mesh of a file that Mesh::read may refuse.
inline Repaired repair(const Context &context, const char *path,
                       const RlvRepairSettings &settings = RLV_REPAIR_SETTINGS_INIT,
                       const Progress &progress = nullptr) {
    Watch watch(progress);
    RlvRepairReport report = RLV_REPAIR_REPORT_INIT;
    RlvMesh made{0};
    watch.check(rlv_repair_read(context.get(), path, &settings, watch.callback(), &watch, &report, &made));
    return {Mesh(made), report};
}

/// What a mesh is simplified to; see relievo/simplify.h.
struct Simplify {
    /// Without its arrays, which are those below.
    RlvSimplifyOptions options = RLV_SIMPLIFY_OPTIONS_INIT;
    /// Names of attributes and their weights.
    std::vector<std::pair<std::string, float>> weights;
    /// Names of attributes that are left out.
    std::vector<std::string> left_out;
    /// Points that stay where they are.
    std::vector<std::uint32_t> locked;
    /// What costs at every point are multiplied by, or none.
    std::vector<float> factors;

    /// A mesh of fewer triangles; `error`, if given, is how far it deviates.
    Mesh run(const Mesh &mesh, float *error = nullptr, const Progress &progress = nullptr) const {
        std::vector<RlvSimplifyWeight> told;
        const RlvSimplifyOptions given = pointing(told);
        Watch watch(progress);
        RlvMesh made{0};
        watch.check(rlv_simplify_mesh(mesh.get(), &given, watch.callback(), &watch, error, &made));
        return Mesh(made);
    }

private:
    friend class Job;

    /// The options with pointers into this object and into `told`, which it fills.
    RlvSimplifyOptions pointing(std::vector<RlvSimplifyWeight> &told) const {
        for (const auto &[name, weight] : weights) {
            told.push_back({name.c_str(), weight, 0});
        }
        for (const std::string &name : left_out) {
            told.push_back({name.c_str(), 0.0f, 1});
        }
        RlvSimplifyOptions given = options;
        given.weights = told.data();
        given.weight_count = told.size();
        given.locked = locked.data();
        given.locked_count = locked.size();
        given.factors = factors.data();
        given.factor_count = factors.size();
        return given;
    }
};

/// See relievo/progressive.h.
class Progressive : public Reference<RlvProgressive, rlv_progressive_retain, rlv_progressive_release> {
public:
    using Reference::Reference;

    /// Builds one of a mesh's triangles.
    static Progressive create(const Mesh &mesh,
                              const RlvProgressiveOptions &options = RLV_PROGRESSIVE_OPTIONS_INIT,
                              const Progress &progress = nullptr) {
        Watch watch(progress);
        Progressive made;
        watch.check(rlv_progressive_create(mesh.get(), &options, watch.callback(), &watch, made.out()));
        return made;
    }

    /// Reads a file, or as much of it as so many triangles need.
    static Progressive read(const Context &context, const std::string &path, std::size_t triangles = SIZE_MAX) {
        Progressive made;
        check(rlv_progressive_read(context.get(), path.c_str(), triangles, made.out()));
        return made;
    }

    void write(const std::string &path) const { check(rlv_progressive_write(get(), path.c_str())); }

    static Progressive read_bytes(const Context &context, const std::uint8_t *bytes, std::size_t size,
                                  std::size_t triangles = SIZE_MAX) {
        Progressive made;
        check(rlv_progressive_read_bytes(context.get(), bytes, size, triangles, made.out()));
        return made;
    }

    Bytes write_bytes() const {
        RlvBytes made{0};
        check(rlv_progressive_write_bytes(get(), &made));
        return Bytes(made);
    }

    RlvProgressiveInfo info() const {
        RlvProgressiveInfo info = RLV_PROGRESSIVE_INFO_INIT;
        check(rlv_progressive_info(get(), &info));
        return info;
    }

    RlvAttributeInfo attribute_info(std::uint32_t index) const {
        RlvAttributeInfo info = RLV_ATTRIBUTE_INFO_INIT;
        check(rlv_progressive_attribute_info(get(), index, &info));
        return info;
    }
};

/// See relievo/arrival.h.
class Arrival : public Reference<RlvArrival, rlv_arrival_retain, rlv_arrival_release> {
public:
    using Reference::Reference;

    static Arrival create(const Context &context) {
        Arrival made;
        check(rlv_arrival_create(context.get(), made.out()));
        return made;
    }

    /// Takes the next bytes, and says what is there then.
    RlvArrivalInfo push(const void *bytes, std::size_t count) const {
        RlvArrivalInfo info = RLV_ARRIVAL_INFO_INIT;
        check(rlv_arrival_push(get(), bytes, count, &info));
        return info;
    }

    /// The progressive mesh of what has arrived.
    Progressive progressive() const {
        RlvProgressive made{0};
        check(rlv_arrival_progressive(get(), &made));
        return Progressive(made);
    }
};

/// See relievo/level.h.
class Level : public Reference<RlvLevel, rlv_level_retain, rlv_level_release> {
public:
    using Reference::Reference;

    /// What an update keeps up to date. Vectors have room for the finest mesh and more elements than there are.
    struct Buffers {
        std::vector<Float3> points, normals;
        std::vector<Triangle> triangles;
        /// Wedges of every triangle, numbers of every wedge, and numbers of every triangle; empty without attributes.
        std::vector<Triangle> wedges;
        std::vector<float> wedge_values;
        std::vector<std::uint32_t> face_values;
        /// What the last update left in them.
        RlvLevelUpdate last = RLV_LEVEL_UPDATE_INIT;

        /// With room for any level of a mesh.
        explicit Buffers(const Progressive &whole) {
            const RlvProgressiveInfo info = whole.info();
            points.resize(info.vertex_count);
            normals.resize(info.vertex_count);
            triangles.resize(info.triangle_count);
            wedges.resize(info.attribute_count == 0 ? 0 : info.triangle_count);
            wedge_values.resize(info.wedge_count * info.wedge_width);
            face_values.resize(info.triangle_count * info.face_width);
            wedge_count = info.wedge_count;
        }

        /// What the C functions take.
        RlvLevelBuffers room() {
            RlvLevelBuffers room = RLV_LEVEL_BUFFERS_INIT;
            room.points = points.empty() ? nullptr : points.front().data();
            room.normals = normals.empty() ? nullptr : normals.front().data();
            room.vertex_capacity = (std::min)(points.size(), normals.size());
            room.triangles = triangles.empty() ? nullptr : triangles.front().data();
            room.triangle_capacity = triangles.size();
            room.wedges = wedges.empty() ? nullptr : wedges.front().data();
            room.wedge_values = wedge_values.empty() ? nullptr : wedge_values.data();
            room.wedge_capacity = wedge_count;
            room.face_values = face_values.empty() ? nullptr : face_values.data();
            return room;
        }

    private:
        std::size_t wedge_count = 0;
    };

    /// The base mesh.
    static Level create(const Progressive &whole) {
        Level made;
        check(rlv_level_create(whole.get(), made.out()));
        return made;
    }

    RlvLevelInfo info() const {
        RlvLevelInfo info = RLV_LEVEL_INFO_INIT;
        check(rlv_level_info(get(), &info));
        return info;
    }

    /// Goes on with more of the same progressive mesh.
    void take_up(const Progressive &more) const { check(rlv_level_take_up(get(), more.get())); }

    void set_error(float error) const { check(rlv_level_set_error(get(), error)); }

    /// Returns the measured distance from the finest mesh, which is at most `bound`.
    float set_bound(float bound, const Progress &progress = nullptr) const {
        Watch watch(progress);
        float distance = 0.0f;
        watch.check(rlv_level_set_bound(get(), bound, watch.callback(), &watch, &distance));
        return distance;
    }
    void set_triangles(std::size_t triangles) const { check(rlv_level_set_triangles(get(), triangles)); }
    void set_view(const RlvLevelView &view) const { check(rlv_level_set_view(get(), &view)); }

    /// Moves and turns regions. Returns how many vertices were reached.
    std::size_t edit(const std::vector<RlvLevelHandle> &handles, const std::vector<RlvLevelRegion> &anchors = {}) const {
        RlvLevelEdit edit = RLV_LEVEL_EDIT_INIT;
        edit.handles = handles.data();
        edit.handle_count = handles.size();
        edit.anchors = anchors.data();
        edit.anchor_count = anchors.size();
        std::size_t reached = 0;
        check(rlv_level_edit(get(), &edit, &reached));
        return reached;
    }

    /// Makes a whole stroke of a brush that sculpts.
    RlvLevelSculpted sculpt(const Brush &brush, const std::vector<RlvStrokePoint> &points) const {
        RlvLevelSculpted done = RLV_LEVEL_SCULPTED_INIT;
        check(rlv_level_sculpt(get(), brush.get(), points.data(), points.size(), 0, &done));
        return done;
    }

    void undo() const { check(rlv_level_undo(get())); }
    void redo() const { check(rlv_level_redo(get())); }

    /// A handle over time.
    struct Track {
        RlvLevelRegion region;
        std::vector<RlvLevelKey> keys;
    };

    /// What the C functions take of an edit over time, as long as its tracks and anchors live.
    struct Motion {
        std::vector<RlvLevelTrack> rows;
        RlvLevelMotion motion = RLV_LEVEL_MOTION_INIT;

        Motion(const std::vector<Track> &tracks, const std::vector<RlvLevelRegion> &anchors) {
            for (const Track &track : tracks) {
                rows.push_back({track.region, track.keys.data(), track.keys.size(), 0});
            }
            motion.tracks = rows.data();
            motion.track_count = rows.size();
            motion.anchors = anchors.data();
            motion.anchor_count = anchors.size();
        }
        Motion(const Motion &) = delete;
        Motion &operator=(const Motion &) = delete;
    };

    /// Adds an edit over time, of the mesh at its present fineness.
    void add_motion(const std::vector<Track> &tracks, const std::vector<RlvLevelRegion> &anchors = {}) const {
        const Motion made(tracks, anchors);
        check(rlv_level_add_motion(get(), &made.motion));
    }

    /// Applies the edits over time for a time in seconds. Returns how many vertices were reached.
    std::size_t set_time(double time) const {
        std::size_t reached = 0;
        check(rlv_level_set_time(get(), time, &reached));
        return reached;
    }

    void clear_motions() const { check(rlv_level_clear_motions(get())); }

    /// Writes the edits that follow down in a file, after making those again that a killed host left there.
    void open_journal(const std::string &path) const { check(rlv_level_open_journal(get(), path.c_str())); }
    void sync_journal() const { check(rlv_level_sync_journal(get())); }
    void close_journal() const { check(rlv_level_close_journal(get())); }

    /// Writes what has changed since the last update of the same buffers, or everything.
    void update(Buffers &buffers, bool is_whole = false) const {
        RlvLevelBuffers room = buffers.room();
        room.is_whole = is_whole ? 1 : 0;
        check(rlv_level_update(get(), &room, &buffers.last));
    }

    /// A range of vertices, triangles or wedges.
    struct Range {
        std::uint32_t first, count;
    };

    /// What the last update wrote of a domain: vertices of points, triangles of faces, values of wedges of corners.
    std::vector<Range> changed_ranges(RlvDomain domain) const {
        std::size_t count = 0;
        check(rlv_level_changed_ranges(get(), domain, nullptr, 0, &count));
        std::vector<Range> ranges(count);
        check(rlv_level_changed_ranges(get(), domain, count == 0 ? nullptr : &ranges.front().first, count, &count));
        return ranges;
    }

    /// Returns a mesh of its present state.
    Mesh mesh() const {
        RlvMesh made{0};
        check(rlv_level_mesh(get(), &made));
        return Mesh(made);
    }

    /// The splits that are out of order, the worst one first.
    std::vector<RlvLevelMisplaced> misplaced() const {
        std::size_t count = 0;
        check(rlv_level_misplaced(get(), nullptr, 0, &count));
        std::vector<RlvLevelMisplaced> found(count);
        check(rlv_level_misplaced(get(), found.data(), count, &count));
        return found;
    }

    /// A progressive mesh that is built anew of the finest level with its edits.
    Progressive rebuild(const RlvProgressiveOptions &options = RLV_PROGRESSIVE_OPTIONS_INIT,
                        const Progress &progress = nullptr) const {
        Watch watch(progress);
        RlvProgressive made{0};
        watch.check(rlv_level_rebuild(get(), &options, watch.callback(), &watch, &made));
        return Progressive(made);
    }

    /// A progressive mesh of its own with the edits at all levels.
    Progressive settle() const {
        RlvProgressive made{0};
        check(rlv_level_settle(get(), &made));
        return Progressive(made);
    }
};

/// See relievo/device_level.h.
class DeviceLevel : public Reference<RlvDeviceLevel, rlv_device_level_retain, rlv_device_level_release> {
public:
    using Reference::Reference;

    /// The base mesh, on the device of the context.
    static DeviceLevel create(const Progressive &whole) {
        DeviceLevel made;
        check(rlv_device_level_create(whole.get(), made.out()));
        return made;
    }

    RlvDeviceLevelInfo info() const {
        RlvDeviceLevelInfo info = RLV_DEVICE_LEVEL_INFO_INIT;
        check(rlv_device_level_info(get(), &info));
        return info;
    }

    void set_error(float error) const { check(rlv_device_level_set_error(get(), error)); }
    void set_triangles(std::size_t triangles) const { check(rlv_device_level_set_triangles(get(), triangles)); }
    void set_view(const RlvLevelView &view) const { check(rlv_device_level_set_view(get(), &view)); }

    /// Moves and turns regions. Returns how many vertices were reached.
    std::size_t edit(const std::vector<RlvLevelHandle> &handles, const std::vector<RlvLevelRegion> &anchors = {}) const {
        RlvLevelEdit edit = RLV_LEVEL_EDIT_INIT;
        edit.handles = handles.data();
        edit.handle_count = handles.size();
        edit.anchors = anchors.data();
        edit.anchor_count = anchors.size();
        std::size_t reached = 0;
        check(rlv_device_level_edit(get(), &edit, &reached));
        return reached;
    }

    void undo() const { check(rlv_device_level_undo(get())); }
    void redo() const { check(rlv_device_level_redo(get())); }

    /// Adds an edit over time, of the mesh at its present fineness.
    void add_motion(const std::vector<Level::Track> &tracks, const std::vector<RlvLevelRegion> &anchors = {}) const {
        const Level::Motion made(tracks, anchors);
        check(rlv_device_level_add_motion(get(), &made.motion));
    }

    /// Applies the edits over time for a time in seconds. Returns how many vertices were reached.
    std::size_t set_time(double time) const {
        std::size_t reached = 0;
        check(rlv_device_level_set_time(get(), time, &reached));
        return reached;
    }

    void clear_motions() const { check(rlv_device_level_clear_motions(get())); }

    /// Copies the mesh back from the device.
    void read(Level::Buffers &buffers) const {
        const RlvLevelBuffers room = buffers.room();
        check(rlv_device_level_read(get(), &room, &buffers.last));
    }

    RlvDeviceLevelVulkan vulkan() const {
        RlvDeviceLevelVulkan vulkan = RLV_DEVICE_LEVEL_VULKAN_INIT;
        check(rlv_device_level_vulkan(get(), &vulkan));
        return vulkan;
    }
};

/// Numbers of particles, which a mesh of their surface gets as an attribute on points.
struct ParticleChannel {
    std::string name;
    /// Numbers per particle, 1 to 4.
    std::uint32_t width;
    std::vector<float> values;

    /// As the C ABI takes it, while this lives.
    RlvAttributeArrays arrays() const {
        RlvAttributeArrays arrays = RLV_ATTRIBUTE_ARRAYS_INIT;
        arrays.domain = RLV_DOMAIN_POINT;
        arrays.type = RLV_TYPE_F32;
        arrays.width = width;
        arrays.name = name.c_str();
        arrays.values = values.data();
        arrays.value_count = width == 0 ? 0 : values.size() / width;
        return arrays;
    }

    static std::vector<RlvAttributeArrays> arrays(const std::vector<ParticleChannel> &channels) {
        std::vector<RlvAttributeArrays> list;
        for (const ParticleChannel &channel : channels) {
            list.push_back(channel.arrays());
        }
        return list;
    }
};

/// The layers of foam, an element a pixel, row after row from the top.
struct FoamLayers {
    std::vector<float> intensity, thickness, depth, occlusion;
    std::vector<Float3> normal, irradiance;
};

/// See relievo/foam.h.
class Foam : public Reference<RlvFoam, rlv_foam_retain, rlv_foam_release> {
public:
    using Reference::Reference;

    static Foam create(const Context &context, const RlvFoamView &view,
                       const RlvFoamSettings &settings = RLV_FOAM_SETTINGS_INIT) {
        Foam made;
        check(rlv_foam_create(context.get(), &view, &settings, made.out()));
        made.pixels_ = static_cast<std::size_t>(view.width) * view.height;
        return made;
    }

    void add(const RlvFoamParticles &particles) const { check(rlv_foam_add(get(), &particles)); }

    /// Makes the layers, lit by white light from everywhere unless there is another.
    void shade(const RlvFoamLight *light = nullptr, const Progress &progress = nullptr) const {
        Watch watch(progress);
        watch.check(rlv_foam_shade(get(), light, watch.callback(), &watch));
    }

    FoamLayers layers() const {
        FoamLayers found;
        for (std::vector<float> *values : {&found.intensity, &found.thickness, &found.depth, &found.occlusion}) {
            values->resize(pixels_);
        }
        found.normal.resize(pixels_);
        found.irradiance.resize(pixels_);
        RlvFoamLayers layers = RLV_FOAM_LAYERS_INIT;
        layers.intensity = found.intensity.data();
        layers.thickness = found.thickness.data();
        layers.depth = found.depth.data();
        layers.occlusion = found.occlusion.data();
        layers.normal = reinterpret_cast<float *>(found.normal.data());
        layers.irradiance = reinterpret_cast<float *>(found.irradiance.data());
        check(rlv_foam_get(get(), &layers));
        return found;
    }

    /// Returns the picture with the foam over it; it has 3 or 4 channels.
    std::vector<float> composite(const std::vector<float> &background, std::uint32_t channels) const {
        if (background.size() != pixels_ * channels) {
            raise(std::invalid_argument("Foam::composite: the picture has as many numbers as pixels have channels"));
        }
        std::vector<float> picture(background.size());
        check(rlv_foam_composite(get(), background.data(), channels, picture.data()));
        return picture;
    }

private:
    std::size_t pixels_ = 0;
};

/// Diffuse particles, an element for each; what Foam::add takes is among it.
struct DiffuseParticles {
    std::vector<Float3> positions, velocities;
    std::vector<std::uint32_t> ids, kinds;
    std::vector<float> ages, lifetimes, lives;

    /// As foam takes them, while this lives.
    RlvFoamParticles foam() const {
        RlvFoamParticles particles = RLV_FOAM_PARTICLES_INIT;
        particles.count = positions.size();
        particles.positions = reinterpret_cast<const float *>(positions.data());
        particles.ids = ids.data();
        particles.kinds = kinds.data();
        particles.lives = lives.data();
        particles.velocities = reinterpret_cast<const float *>(velocities.data());
        return particles;
    }
};

/// The potentials of a fluid's particles, each 0 to 1.
struct DiffusePotentials {
    std::vector<float> air, crests, energies;
};

/// See relievo/diffuse.h.
class Diffuse : public Reference<RlvDiffuse, rlv_diffuse_retain, rlv_diffuse_release> {
public:
    using Reference::Reference;

    static Diffuse create(const Context &context, const RlvDiffuseOptions &options = RLV_DIFFUSE_OPTIONS_INIT,
                          const RlvDiffuseSettings &settings = RLV_DIFFUSE_SETTINGS_INIT) {
        Diffuse made;
        check(rlv_diffuse_create(context.get(), &options, &settings, made.out()));
        return made;
    }

    RlvDiffuseInfo info() const {
        RlvDiffuseInfo found = RLV_DIFFUSE_INFO_INIT;
        check(rlv_diffuse_info(get(), &found));
        return found;
    }

    RlvDiffuseReport advance(const std::vector<Float3> &positions, const std::vector<Float3> &velocities, float seconds,
                             const Progress &progress = nullptr) const {
        const RlvDiffuseFluid given = fluid(positions, velocities);
        RlvDiffuseReport report = RLV_DIFFUSE_REPORT_INIT;
        Watch watch(progress);
        watch.check(rlv_diffuse_advance(get(), &given, seconds, &report, watch.callback(), &watch));
        return report;
    }

    DiffusePotentials potentials(const std::vector<Float3> &positions, const std::vector<Float3> &velocities) const {
        const RlvDiffuseFluid given = fluid(positions, velocities);
        DiffusePotentials found;
        for (std::vector<float> *values : {&found.air, &found.crests, &found.energies}) {
            values->resize(positions.size());
        }
        RlvDiffusePotentials arrays = RLV_DIFFUSE_POTENTIALS_INIT;
        arrays.capacity = positions.size();
        arrays.air = found.air.data();
        arrays.crests = found.crests.data();
        arrays.energies = found.energies.data();
        check(rlv_diffuse_potentials(get(), &given, &arrays));
        return found;
    }

    DiffuseParticles particles() const {
        const std::size_t count = info().count;
        DiffuseParticles found;
        found.positions.resize(count);
        found.velocities.resize(count);
        found.ids.resize(count);
        found.kinds.resize(count);
        for (std::vector<float> *values : {&found.ages, &found.lifetimes, &found.lives}) {
            values->resize(count);
        }
        RlvDiffuseArrays arrays = RLV_DIFFUSE_ARRAYS_INIT;
        arrays.capacity = count;
        arrays.positions = reinterpret_cast<float *>(found.positions.data());
        arrays.velocities = reinterpret_cast<float *>(found.velocities.data());
        arrays.ids = found.ids.data();
        arrays.kinds = found.kinds.data();
        arrays.ages = found.ages.data();
        arrays.lifetimes = found.lifetimes.data();
        arrays.lives = found.lives.data();
        check(rlv_diffuse_get(get(), &arrays));
        return found;
    }

    /// Writes what restore continues from, at a time in seconds.
    void save(const std::string &path, double time) const { check(rlv_diffuse_save(get(), path.c_str(), time)); }

    void restore(const std::string &path) const { check(rlv_diffuse_restore(get(), path.c_str())); }

private:
    static RlvDiffuseFluid fluid(const std::vector<Float3> &positions, const std::vector<Float3> &velocities) {
        if (positions.size() != velocities.size()) {
            raise(std::invalid_argument("Diffuse: there are as many velocities as positions"));
        }
        RlvDiffuseFluid given = RLV_DIFFUSE_FLUID_INIT;
        given.count = positions.size();
        given.positions = reinterpret_cast<const float *>(positions.data());
        given.velocities = reinterpret_cast<const float *>(velocities.data());
        return given;
    }
};

/// Classified pixels and how vectors are compared with them; see relievo/shader.h. Vectors lie one behind the other.
struct ShaderExamples {
    std::uint32_t feature_count = 1;
    std::vector<std::uint32_t> classes;
    std::vector<float> vectors;
    float exponent = 2;
    bool is_scaled = false;

    void add(RlvShaderClass kind, const std::vector<float> &vector) {
        classes.push_back(kind);
        vectors.insert(vectors.end(), vector.begin(), vector.end());
    }

    /// Returns the words of the buffer of examples.
    std::vector<std::uint32_t> pack(RlvShaderMode mode = RLV_SHADER_RENDER, std::uint32_t x = 0, std::uint32_t y = 0) const {
        const RlvShaderExamples examples = record();
        std::size_t count = 0;
        check(rlv_shader_pack_examples(&examples, mode, x, y, nullptr, 0, &count));
        std::vector<std::uint32_t> words(count);
        check(rlv_shader_pack_examples(&examples, mode, x, y, words.data(), words.size(), &count));
        return words;
    }

    /// Returns the membership of each of some vectors.
    std::vector<float> membership(const std::vector<float> &given) const {
        const RlvShaderExamples examples = record();
        if (given.size() % feature_count != 0) {
            raise(std::invalid_argument("ShaderExamples::membership: a vector is incomplete"));
        }
        std::vector<float> found(given.size() / feature_count);
        check(rlv_shader_membership(&examples, given.data(), found.size(), 0, found.data()));
        return found;
    }

private:
    RlvShaderExamples record() const {
        if (feature_count == 0 || vectors.size() != classes.size() * feature_count) {
            raise(std::invalid_argument("ShaderExamples: each example has a class and feature_count numbers"));
        }
        RlvShaderExamples examples = RLV_SHADER_EXAMPLES_INIT;
        examples.feature_count = feature_count;
        examples.count = classes.size();
        examples.classes = classes.data();
        examples.vectors = vectors.data();
        examples.exponent = exponent;
        examples.is_scaled = is_scaled;
        return examples;
    }
};

/// See relievo/shader.h.
class Shader : public Reference<RlvShader, rlv_shader_retain, rlv_shader_release> {
public:
    using Reference::Reference;

    static Shader create(const std::string &source, const RlvShaderOptions &options = RLV_SHADER_OPTIONS_INIT) {
        Shader made;
        check(rlv_shader_create(source.c_str(), &options, made.out()));
        return made;
    }

    std::vector<RlvShaderVariable> variables() const {
        std::size_t count = 0;
        check(rlv_shader_variable_count(get(), &count));
        std::vector<RlvShaderVariable> found(count, RlvShaderVariable(RLV_SHADER_VARIABLE_INIT));
        for (std::size_t index = 0; index < count; ++index) {
            check(rlv_shader_variable(get(), index, &found[index]));
        }
        return found;
    }

    /// Returns the shader with a mark that takes a vector of variables, by their indices.
    Shader mark(const std::vector<std::uint32_t> &chosen, const std::string &weight = "1.0") const {
        Shader made;
        check(rlv_shader_mark(get(), chosen.data(), chosen.size(), weight.c_str(), made.out()));
        return made;
    }

    std::string text(RlvShaderText kind = RLV_SHADER_AUGMENTED) const {
        std::size_t length = 0;
        check(rlv_shader_text(get(), kind, nullptr, 0, &length));
        std::string found(length + 1, '\0');
        check(rlv_shader_text(get(), kind, &found[0], found.size(), &length));
        found.resize(length);
        return found;
    }

    RlvShaderLayout layout() const {
        RlvShaderLayout layout = RLV_SHADER_LAYOUT_INIT;
        check(rlv_shader_layout(get(), &layout));
        return layout;
    }

    std::vector<RlvShaderFeature> features() const {
        std::vector<RlvShaderFeature> found(layout().feature_count, RlvShaderFeature(RLV_SHADER_FEATURE_INIT));
        for (std::size_t index = 0; index < found.size(); ++index) {
            check(rlv_shader_feature(get(), index, &found[index]));
        }
        return found;
    }

    /// Returns examples for the vectors of this shader, without any yet.
    ShaderExamples examples() const {
        ShaderExamples made;
        made.feature_count = layout().feature_count;
        return made;
    }

    /// Returns the vector of the pixel that wrote a log.
    std::vector<float> unpack(const std::vector<std::uint32_t> &log) const {
        std::vector<float> vector(layout().feature_count);
        check(rlv_shader_unpack_log(get(), log.data(), log.size(), vector.data(), vector.size(), nullptr));
        return vector;
    }
};

/// See relievo/isosurface.h.
class Isosurface : public Reference<RlvIsosurface, rlv_isosurface_retain, rlv_isosurface_release> {
public:
    using Reference::Reference;

    /// Of particles; velocities and flags are as many as points, or none.
    static Isosurface create(const Context &context, const std::vector<Float3> &points,
                             const RlvIsosurfaceOptions &options = RLV_ISOSURFACE_OPTIONS_INIT,
                             const std::vector<Float3> &velocities = {}, const std::vector<std::uint8_t> &blind = {}) {
        if ((!velocities.empty() && velocities.size() != points.size()) ||
            (!blind.empty() && blind.size() != points.size())) {
            raise(std::invalid_argument("Isosurface::create: there are as many velocities and flags as points, or none"));
        }
        RlvIsosurfaceParticles particles = RLV_ISOSURFACE_PARTICLES_INIT;
        Isosurface made;
        particles.count = points.size();
        particles.points = reinterpret_cast<const float *>(points.data());
        particles.velocities = velocities.empty() ? nullptr : velocities.front().data();
        particles.blind = blind.empty() ? nullptr : blind.data();
        check(rlv_isosurface_create(context.get(), &particles, &options, made.out()));
        return made;
    }

    RlvIsosurfaceInfo info() const {
        RlvIsosurfaceInfo info = RLV_ISOSURFACE_INFO_INIT;
        check(rlv_isosurface_info(get(), &info));
        return info;
    }

    /// The mesh of it; channels take the place of those of the options.
    Mesh mesh(RlvIsosurfaceMeshOptions options = RLV_ISOSURFACE_MESH_OPTIONS_INIT,
              const std::vector<ParticleChannel> &channels = {}, const Progress &progress = nullptr) const {
        const std::vector<RlvAttributeArrays> arrays = ParticleChannel::arrays(channels);
        if (!arrays.empty()) {
            options.channels = arrays.data();
            options.channel_count = arrays.size();
            options.channel_stride = 0;
        }
        Watch watch(progress);
        RlvMesh made{0};
        watch.check(rlv_isosurface_mesh(get(), &options, watch.callback(), &watch, &made));
        return Mesh(made);
    }

    /// An RlvIsosurfaceClass for each particle; a threshold below 0 is for the influence.
    std::vector<std::uint8_t> classify(float threshold = -1.0f, const Progress &progress = nullptr) const {
        std::vector<std::uint8_t> classes(info().particle_count);
        Watch watch(progress);
        watch.check(rlv_isosurface_classify(get(), threshold, classes.data(), classes.size(), 0, watch.callback(),
                                            &watch, nullptr));
        return classes;
    }

    /// The first hit of each ray; one whose mask is 0 hits nothing.
    std::vector<RlvIsosurfaceHit> cast(const std::vector<CastRay> &rays, float max_distance = 0.0f) const {
        std::vector<RlvIsosurfaceHit> hits(rays.size());
        const RlvRayArrays arrays = CastRay::arrays(rays, max_distance);
        check(rlv_isosurface_cast(get(), &arrays, hits.data(), 0));
        return hits;
    }

    /// The function for a renderer's own rays, valid as long as a reference lives.
    RlvIsosurfaceTable table() const {
        RlvIsosurfaceTable table = RLV_ISOSURFACE_TABLE_INIT;
        check(rlv_isosurface_table(get(), &table));
        return table;
    }
};

/// See relievo/particles.h.
class Particles : public Reference<RlvParticles, rlv_particles_retain, rlv_particles_release> {
public:
    using Reference::Reference;

    /// Of points, and channels with a value for each; a spacing of 0 is for one that is not known. Numbers may be none.
    static Particles create(const Context &context, const std::vector<Float3> &points,
                            const std::vector<ParticleChannel> &channels = {}, float spacing = 0.0f,
                            const std::vector<std::uint32_t> &numbers = {}) {
        if (!numbers.empty() && numbers.size() != points.size()) {
            raise(std::invalid_argument("Particles::create: there are as many numbers as points, or none"));
        }
        const std::vector<RlvAttributeArrays> list = ParticleChannel::arrays(channels);
        RlvParticlesArrays arrays = RLV_PARTICLES_ARRAYS_INIT;
        Particles made;
        arrays.spacing = spacing;
        arrays.count = points.size();
        arrays.points = reinterpret_cast<const float *>(points.data());
        arrays.numbers = numbers.empty() ? nullptr : numbers.data();
        arrays.channels = list.data();
        arrays.channel_count = list.size();
        check(rlv_particles_create(context.get(), &arrays, made.out()));
        return made;
    }

    static Particles read(const Context &context, const std::string &path) {
        Particles made;
        check(rlv_particles_read(context.get(), path.c_str(), made.out()));
        return made;
    }

    void write(const std::string &path) const { check(rlv_particles_write(get(), path.c_str())); }

    RlvParticlesInfo info() const {
        RlvParticlesInfo info = RLV_PARTICLES_INFO_INIT;
        check(rlv_particles_info(get(), &info));
        return info;
    }

    std::vector<Float3> points() const {
        std::vector<Float3> points(info().count);
        check(rlv_particles_get_points(get(), reinterpret_cast<float *>(points.data()), points.size(), 0));
        return points;
    }

    std::vector<std::uint32_t> numbers() const {
        std::vector<std::uint32_t> numbers(info().count);
        check(rlv_particles_get_numbers(get(), numbers.data(), numbers.size(), 0));
        return numbers;
    }

    ParticleChannel channel(std::uint32_t index) const {
        RlvAttributeInfo info = RLV_ATTRIBUTE_INFO_INIT;
        check(rlv_particles_channel_info(get(), index, &info));
        ParticleChannel channel{info.name, info.width, std::vector<float>(info.value_count * info.width)};
        check(rlv_particles_get_channel(get(), index, channel.values.data(), info.value_count, 0));
        return channel;
    }

    ParticleChannel channel(const std::string &name) const {
        std::uint32_t index = 0;
        check(rlv_particles_find_channel(get(), name.c_str(), &index));
        return channel(index);
    }

    /// Returns the particles that a surface needs, by the classes of Isosurface::classify.
    Particles keep(const std::vector<std::uint8_t> &classes) const {
        Particles made;
        check(rlv_particles_keep(get(), classes.data(), classes.size(), 0, made.out()));
        return made;
    }

    /// Their surface, of a radius of half the spacing where that is known.
    Isosurface isosurface() const {
        RlvIsosurface made{0};
        check(rlv_particles_isosurface(get(), nullptr, &made));
        return Isosurface(made);
    }

    Isosurface isosurface(const RlvIsosurfaceOptions &options) const {
        RlvIsosurface made{0};
        check(rlv_particles_isosurface(get(), &options, &made));
        return Isosurface(made);
    }
};

/// What particles of a fluid have, in the order of rising numbers.
struct FluidState {
    std::vector<Float3> points, velocities;
    std::vector<std::uint32_t> numbers;
    std::vector<float> pressures;
    std::vector<double> births;
};

/// See relievo/fluid.h.
class Fluid : public Reference<RlvFluid, rlv_fluid_retain, rlv_fluid_release> {
public:
    using Reference::Reference;

    static Fluid create(const Context &context, const RlvFluidOptions &options = RLV_FLUID_OPTIONS_INIT) {
        Fluid made;
        check(rlv_fluid_create(context.get(), &options, made.out()));
        return made;
    }

    RlvFluidInfo info() const {
        RlvFluidInfo info = RLV_FLUID_INFO_INIT;
        check(rlv_fluid_info(get(), &info));
        return info;
    }

    /// Adds particles that have one velocity; a lifetime of 0 is unlimited. Channels have a value for each of them,
    /// or one for all.
    void add(const std::vector<Float3> &points, const Float3 &velocity = {0, 0, 0}, float lifetime = 0.0f,
             const std::vector<ParticleChannel> &channels = {}) const {
        const std::vector<RlvAttributeArrays> arrays = ParticleChannel::arrays(channels);
        RlvFluidParticles particles = RLV_FLUID_PARTICLES_INIT;
        particles.count = points.size();
        particles.points = reinterpret_cast<const float *>(points.data());
        particles.lifetime = lifetime;
        for (std::size_t axis = 0; axis < 3; ++axis) {
            particles.velocity[axis] = velocity[axis];
        }
        particles.channels = arrays.data();
        particles.channel_count = arrays.size();
        check(rlv_fluid_add(get(), &particles));
    }

    /// Adds particles that have a velocity each.
    void add(const std::vector<Float3> &points, const std::vector<Float3> &velocities, float lifetime = 0.0f,
             const std::vector<ParticleChannel> &channels = {}) const {
        if (velocities.size() != points.size()) {
            raise(std::invalid_argument("Fluid::add: there are as many velocities as points"));
        }
        const std::vector<RlvAttributeArrays> arrays = ParticleChannel::arrays(channels);
        RlvFluidParticles particles = RLV_FLUID_PARTICLES_INIT;
        particles.count = points.size();
        particles.points = reinterpret_cast<const float *>(points.data());
        particles.velocities = reinterpret_cast<const float *>(velocities.data());
        particles.lifetime = lifetime;
        particles.channels = arrays.data();
        particles.channel_count = arrays.size();
        check(rlv_fluid_add(get(), &particles));
    }

    void add_box(const Double3 &low, const Double3 &high, const Float3 &velocity = {0, 0, 0}) const {
        check(rlv_fluid_add_box(get(), low.data(), high.data(), velocity.data()));
    }

    /// Fills a closed mesh, and returns how many particles there are in it.
    std::size_t fill(const Mesh &mesh, const Matrix &matrix = moved(0, 0, 0), const Float3 &velocity = {0, 0, 0}) const {
        std::size_t added = 0;
        check(rlv_fluid_fill(get(), mesh.get(), matrix.data(), velocity.data(), &added));
        return added;
    }

    void add_emitter(const RlvFluidEmitterOptions &options) const {
        check(rlv_fluid_add_emitter(get(), RlvMesh{0}, nullptr, &options));
    }

    /// Adds one that is the surface of a mesh.
    void add_emitter(RlvFluidEmitterOptions options, const Mesh &mesh, const Matrix &matrix = moved(0, 0, 0)) const {
        options.shape = RLV_FLUID_SURFACE;
        check(rlv_fluid_add_emitter(get(), mesh.get(), matrix.data(), &options));
    }

    void add_sink(const Double3 &low, const Double3 &high, bool is_outside = false) const {
        check(rlv_fluid_add_sink(get(), low.data(), high.data(), is_outside ? 1 : 0));
    }

    void add_sink(const Mesh &mesh, const Matrix &matrix = moved(0, 0, 0)) const {
        check(rlv_fluid_add_sink_mesh(get(), mesh.get(), matrix.data()));
    }

    void clear_sources() const { check(rlv_fluid_clear_sources(get())); }

    /// Particles at most for emitters, which then are an error or stop.
    void set_budget(std::size_t particles, bool stops = false) const {
        check(rlv_fluid_set_budget(get(), particles, stops ? 1 : 0));
    }

    void set_forces(const std::vector<RlvFluidForce> &forces) const {
        check(rlv_fluid_set_forces(get(), forces.data(), forces.size(), 0));
    }

    /// Removes the particles of these numbers, and returns how many there were.
    std::size_t remove(const std::vector<std::uint32_t> &numbers) const {
        std::size_t removed = 0;
        check(rlv_fluid_remove(get(), numbers.data(), numbers.size(), 0, &removed));
        return removed;
    }

    void set_walls(const std::vector<Float3> &points) const {
        check(rlv_fluid_set_walls(get(), reinterpret_cast<const float *>(points.data()), points.size(), 0));
    }

    void set_basin(const Double3 &low, const Double3 &high) const {
        check(rlv_fluid_set_basin(get(), low.data(), high.data()));
    }

    void move_walls(const std::vector<Float3> &points, const std::vector<Float3> &velocities) const {
        if (velocities.size() != points.size()) {
            raise(std::invalid_argument("Fluid::move_walls: there are as many velocities as points"));
        }
        check(rlv_fluid_set_wall_points(get(), reinterpret_cast<const float *>(points.data()), points.size(), 0,
                                        reinterpret_cast<const float *>(velocities.data()), 0));
    }

    /// Adds a mesh that fluid does not pass, and returns its number.
    std::uint32_t add_collider(const Mesh &mesh, const Matrix &matrix = moved(0, 0, 0),
                               const RlvFluidColliderOptions &options = RLV_FLUID_COLLIDER_OPTIONS_INIT) const {
        std::uint32_t number = 0;
        check(rlv_fluid_add_collider(get(), mesh.get(), matrix.data(), &options, &number));
        return number;
    }

    /// Has a collider go from where it is to points, in straight lines and within so many seconds.
    void move_collider(std::uint32_t collider, const std::vector<Float3> &to, float seconds) const {
        check(rlv_fluid_move_collider(get(), collider, nullptr, reinterpret_cast<const float *>(to.data()), to.size(), 0,
                                      seconds));
    }

    /// The momentum that a collider, or RLV_FLUID_WALLS, was given in the last step, kg m/s.
    Double3 impulse(std::uint32_t collider) const {
        Double3 linear{};
        check(rlv_fluid_impulse(get(), collider, linear.data(), nullptr));
        return linear;
    }

    void accelerate(const std::vector<Float3> &accelerations) const {
        check(rlv_fluid_accelerate(get(), reinterpret_cast<const float *>(accelerations.data()), accelerations.size(),
                                   0));
    }

    RlvFluidReport step(float seconds) const {
        RlvFluidReport report = RLV_FLUID_REPORT_INIT;
        check(rlv_fluid_step(get(), seconds, &report));
        return report;
    }

    RlvFluidReport advance(double seconds, const Progress &progress = nullptr) const {
        RlvFluidReport report = RLV_FLUID_REPORT_INIT;
        Watch watch(progress);
        watch.check(rlv_fluid_advance(get(), seconds, watch.callback(), &watch, &report));
        return report;
    }

    FluidState state() const {
        FluidState state;
        RlvFluidArrays arrays = RLV_FLUID_ARRAYS_INIT;
        const std::size_t count = info().particle_count;
        state.points.resize(count);
        state.velocities.resize(count);
        state.numbers.resize(count);
        state.pressures.resize(count);
        state.births.resize(count);
        arrays.capacity = count;
        arrays.points = reinterpret_cast<float *>(state.points.data());
        arrays.velocities = reinterpret_cast<float *>(state.velocities.data());
        arrays.numbers = state.numbers.data();
        arrays.pressures = state.pressures.data();
        arrays.births = state.births.data();
        check(rlv_fluid_get(get(), &arrays));
        return state;
    }

    /// Densities in the order of rising numbers, kg/m3; needs the fluid alone.
    std::vector<float> densities() const {
        std::vector<float> densities(info().particle_count);
        RlvFluidArrays arrays = RLV_FLUID_ARRAYS_INIT;
        arrays.capacity = densities.size();
        arrays.densities = densities.data();
        check(rlv_fluid_get(get(), &arrays));
        return densities;
    }

    /// Writes all that it goes on from to a file.
    void save(const std::string &path) const { check(rlv_fluid_save(get(), path.c_str())); }

    /// Goes on from such a file, with the same options, walls, colliders and sources.
    void restore(const std::string &path) const { check(rlv_fluid_restore(get(), path.c_str())); }

    Bytes save_bytes() const {
        RlvBytes made{0};
        check(rlv_fluid_save_bytes(get(), &made));
        return Bytes(made);
    }

    void restore_bytes(const std::uint8_t *bytes, std::size_t size) const {
        check(rlv_fluid_restore_bytes(get(), bytes, size));
    }

    /// Returns a picture of the present particles, for files.
    Particles particles() const {
        RlvParticles made{0};
        check(rlv_fluid_particles(get(), &made));
        return Particles(made);
    }

    void add(const Particles &particles) const { check(rlv_fluid_add_particles(get(), particles.get())); }

    /// Gives each particle a value of a channel, in the order of rising numbers.
    void set_channel(const ParticleChannel &channel) const {
        const RlvAttributeArrays arrays = channel.arrays();
        check(rlv_fluid_set_channel(get(), &arrays));
    }

    ParticleChannel channel(std::uint32_t index) const {
        RlvAttributeInfo info = RLV_ATTRIBUTE_INFO_INIT;
        check(rlv_fluid_channel_info(get(), index, &info));
        ParticleChannel channel{info.name, info.width, std::vector<float>(info.value_count * info.width)};
        check(rlv_fluid_get_channel(get(), index, channel.values.data(), info.value_count, 0));
        return channel;
    }

    ParticleChannel channel(const std::string &name) const {
        std::uint32_t index = 0;
        check(rlv_fluid_find_channel(get(), name.c_str(), &index));
        return channel(index);
    }

    /// The surface of the particles where they are now, of a radius of half the spacing.
    Isosurface isosurface() const {
        RlvIsosurface made{0};
        check(rlv_fluid_isosurface(get(), nullptr, &made));
        return Isosurface(made);
    }

    Isosurface isosurface(const RlvIsosurfaceOptions &options) const {
        RlvIsosurface made{0};
        check(rlv_fluid_isosurface(get(), &options, &made));
        return Isosurface(made);
    }
};

/// See relievo/grid.h.
class Grid : public Reference<RlvGrid, rlv_grid_retain, rlv_grid_release> {
public:
    using Reference::Reference;

    static Grid create(const Context &context, RlvGridKind kind, const Double3 &background, double voxel) {
        Grid made;
        check(rlv_grid_create(context.get(), kind, background.data(), voxel, made.out()));
        return made;
    }

    /// Reads the grid called `name`, or the first one if that is empty.
    static Grid read(const Context &context, const std::string &path, const std::string &name = "",
                     const Progress &progress = nullptr) {
        Watch watch(progress);
        Grid made;
        const char *const wanted = name.empty() ? nullptr : name.c_str();
        watch.check(rlv_grid_read(context.get(), path.c_str(), wanted, nullptr, watch.callback(), &watch, made.out()));
        return made;
    }

    static Grid from_mesh(const Mesh &mesh, const RlvGridSettings &settings = RLV_GRID_SETTINGS_INIT,
                          const Progress &progress = nullptr) {
        Watch watch(progress);
        Grid made;
        watch.check(rlv_grid_from_mesh(mesh.get(), &settings, watch.callback(), &watch, made.out()));
        return made;
    }

    static Grid from_particles(const Particles &particles, const RlvGridSettings &settings = RLV_GRID_SETTINGS_INIT,
                               const Progress &progress = nullptr) {
        Watch watch(progress);
        Grid made;
        watch.check(rlv_grid_from_particles(particles.get(), &settings, watch.callback(), &watch, made.out()));
        return made;
    }

    /// Describes the grids of a file.
    static std::vector<RlvGridInfo> list(const Context &context, const std::string &path) {
        std::size_t count = 0;
        check(rlv_grid_file_count(context.get(), path.c_str(), &count));
        std::vector<RlvGridInfo> found(count, RlvGridInfo(RLV_GRID_INFO_INIT));
        for (std::size_t index = 0; index < count; ++index) {
            check(rlv_grid_file_info(context.get(), path.c_str(), index, &found[index]));
        }
        return found;
    }

    void write(const std::string &path, std::uint32_t writing = RLV_GRID_PACK_BLOSC) const {
        const RlvGrid grid = get();
        check(rlv_grid_write(&grid, 1, path.c_str(), writing));
    }

    RlvGridInfo info() const {
        RlvGridInfo info = RLV_GRID_INFO_INIT;
        check(rlv_grid_info(get(), &info));
        return info;
    }

    void set_name(const std::string &name) const { check(rlv_grid_set_name(get(), name.c_str())); }

    /// Returns one number a point, three of vectors.
    std::vector<double> sample(const std::vector<Double3> &points, bool is_linear = true) const {
        const std::uint32_t kind = info().kind;
        const bool is_vector = kind >= RLV_GRID_VEC3S && kind <= RLV_GRID_VEC3I;
        std::vector<double> values(points.size() * (is_vector ? 3 : 1));
        const double *const places = points.empty() ? nullptr : points.front().data();
        check(rlv_grid_sample(get(), places, points.size(), 0, is_linear, values.data(), values.size()));
        return values;
    }

    Mesh mesh(const RlvGridSettings &settings = RLV_GRID_SETTINGS_INIT, const Progress &progress = nullptr) const {
        Watch watch(progress);
        RlvMesh made = RLV_NULL;
        watch.check(rlv_grid_mesh(get(), &settings, watch.callback(), &watch, &made));
        return Mesh(made);
    }

    Grid change(RlvGridChange change, const RlvGridSettings &settings = RLV_GRID_SETTINGS_INIT,
                const Progress &progress = nullptr) const {
        Watch watch(progress);
        Grid made;
        watch.check(rlv_grid_change(get(), change, &settings, watch.callback(), &watch, made.out()));
        return made;
    }

    Grid convert(RlvGridKind kind) const {
        Grid made;
        check(rlv_grid_convert(get(), kind, made.out()));
        return made;
    }

    Grid combine(const Grid &other, RlvGridOperation operation, const Progress &progress = nullptr) const {
        Watch watch(progress);
        Grid made;
        watch.check(rlv_grid_combine(get(), other.get(), operation, watch.callback(), &watch, made.out()));
        return made;
    }

    Grid label_mask(std::int64_t label) const {
        Grid made;
        check(rlv_grid_label_mask(get(), label, made.out()));
        return made;
    }
};

/// A simulation of soft tissue; see relievo/tissue.h.
class TissueSimulation
    : public Reference<RlvTissueSimulation, rlv_tissue_simulation_retain, rlv_tissue_simulation_release> {
public:
    using Reference::Reference;

    RlvTissueSimulationInfo info() const {
        RlvTissueSimulationInfo info = RLV_TISSUE_SIMULATION_INFO_INIT;
        check(rlv_tissue_simulation_info(get(), &info));
        return info;
    }

    RlvTissueEnergies energies() const {
        RlvTissueEnergies energies = RLV_TISSUE_ENERGIES_INIT;
        check(rlv_tissue_simulation_energies(get(), &energies));
        return energies;
    }

    /// Sets the activation of a muscle at times.
    void activate(std::uint32_t muscle, const std::vector<std::pair<double, float>> &keys) const {
        std::vector<double> times;
        std::vector<float> values;
        split(keys, times, values);
        check(rlv_tissue_simulation_activate(get(), muscle, times.data(), values.data(), times.size()));
    }

    /// Moves nodes along axes by displacements at times; without keys they stay where they are.
    void drive(const std::vector<std::uint32_t> &nodes, std::uint32_t axes,
               const std::vector<std::pair<double, Float3>> &keys = {}) const {
        std::vector<double> times;
        std::vector<Float3> values;
        split(keys, times, values);
        check(rlv_tissue_simulation_drive(get(), nodes.data(), nodes.size(), axes, times.data(), first(values),
                                          times.size()));
    }

    void load(const std::vector<Float3> &forces) const {
        check(rlv_tissue_simulation_load(get(), first(forces), forces.size(), 0));
    }

    /// Presses on the outer faces of which all nodes are among some, in Pa at times.
    void press(const std::vector<std::uint32_t> &nodes, const std::vector<std::pair<double, float>> &keys) const {
        std::vector<double> times;
        std::vector<float> values;
        split(keys, times, values);
        check(rlv_tissue_simulation_press(get(), nodes.data(), nodes.size(), times.data(), values.data(), times.size()));
    }

    void add_collider(const RlvTissueCollider &collider) const {
        check(rlv_tissue_simulation_add_collider(get(), &collider));
    }

    void step(std::uint64_t count = 1) const { check(rlv_tissue_simulation_step(get(), count)); }

    void advance(double seconds, const Progress &progress = nullptr) const {
        Watch watch(progress);
        watch.check(rlv_tissue_simulation_advance(get(), seconds, watch.callback(), &watch));
    }

    RlvTissueRelaxation relax(float tolerance, std::uint64_t steps, const Progress &progress = nullptr) const {
        Watch watch(progress);
        RlvTissueRelaxation done = RLV_TISSUE_RELAXATION_INIT;
        watch.check(rlv_tissue_simulation_relax(get(), tolerance, steps, watch.callback(), &watch, &done));
        return done;
    }

    /// Copies the state into arrays that have room for all nodes and elements.
    void get_arrays(const RlvTissueArrays &arrays) const { check(rlv_tissue_simulation_get(get(), &arrays)); }

    /// Returns the Green-Lagrange strains of as many elements as the model has: xx, yy, zz, yz, zx and xy.
    std::vector<std::array<float, 6>> strains(std::size_t element_count) const {
        std::vector<std::array<float, 6>> strains(element_count);
        RlvTissueArrays arrays = RLV_TISSUE_ARRAYS_INIT;
        arrays.element_count = element_count;
        arrays.strains = strains.empty() ? nullptr : strains.front().data();
        get_arrays(arrays);
        return strains;
    }

    /// Returns the principal strains of as many elements as the model has, the largest first.
    std::vector<Float3> principal_strains(std::size_t element_count) const {
        std::vector<Float3> strains(element_count);
        RlvTissueArrays arrays = RLV_TISSUE_ARRAYS_INIT;
        arrays.element_count = element_count;
        arrays.principal_strains = strains.empty() ? nullptr : strains.front().data();
        get_arrays(arrays);
        return strains;
    }

    /// Returns the pressures in Pa with which colliders press on as many nodes as the model has.
    std::vector<float> contact_pressures(std::size_t node_count) const {
        std::vector<float> pressures(node_count);
        RlvTissueArrays arrays = RLV_TISSUE_ARRAYS_INIT;
        arrays.node_count = node_count;
        arrays.contact_pressures = pressures.data();
        get_arrays(arrays);
        return pressures;
    }

    /// Returns a bound surface in the present state, with its velocity.
    Mesh mesh(std::uint32_t index) const {
        RlvMesh made = RLV_NULL;
        check(rlv_tissue_simulation_mesh(get(), index, &made));
        return Mesh(made);
    }

    void save(const std::string &path) const { check(rlv_tissue_simulation_save(get(), path.c_str())); }
    void restore(const std::string &path) const { check(rlv_tissue_simulation_restore(get(), path.c_str())); }

    Bytes save_bytes() const {
        RlvBytes made{0};
        check(rlv_tissue_simulation_save_bytes(get(), &made));
        return Bytes(made);
    }

    void restore_bytes(const std::uint8_t *bytes, std::size_t size) const {
        check(rlv_tissue_simulation_restore_bytes(get(), bytes, size));
    }

    void write_vtu(const std::string &path) const { check(rlv_tissue_simulation_write_vtu(get(), path.c_str())); }
    void write_vdb(const std::string &path) const { check(rlv_tissue_simulation_write_vdb(get(), path.c_str())); }

private:
    template <class Value>
    static void split(const std::vector<std::pair<double, Value>> &keys, std::vector<double> &times,
                      std::vector<Value> &values) {
        for (const auto &key : keys) {
            times.push_back(key.first);
            values.push_back(key.second);
        }
    }

    static const float *first(const std::vector<Float3> &rows) { return rows.empty() ? nullptr : rows.front().data(); }
};

/// A finite-element model of soft tissue; see relievo/tissue.h.
class Tissue : public Reference<RlvTissue, rlv_tissue_retain, rlv_tissue_release> {
public:
    using Reference::Reference;

    static Tissue build(const Context &context, const RlvTissueDescription &description,
                        const Progress &progress = nullptr) {
        Watch watch(progress);
        Tissue made;
        watch.check(rlv_tissue_build(context.get(), &description, watch.callback(), &watch, nullptr, made.out()));
        return made;
    }

    /// Makes a block of equal boxes.
    static Tissue block(const Context &context, const Double3 &low, const Float3 &cell, const Triangle &counts,
                        const RlvTissueMaterial &material) {
        Tissue made;
        check(rlv_tissue_block(context.get(), low.data(), cell.data(), counts.data(), &material, made.out()));
        return made;
    }

    static Tissue scan(const Context &context, const std::string &path, const RlvTissueLabels &labels) {
        Tissue made;
        check(rlv_tissue_scan(context.get(), path.c_str(), &labels, nullptr, made.out()));
        return made;
    }

    static Tissue from(const Grid &grid, const RlvTissueLabels &labels) {
        Tissue made;
        check(rlv_tissue_from_grid(grid.get(), &labels, nullptr, made.out()));
        return made;
    }

    static Tissue read(const Context &context, const std::string &path) {
        Tissue made;
        check(rlv_tissue_read(context.get(), path.c_str(), made.out()));
        return made;
    }

    void write(const std::string &path) const { check(rlv_tissue_write(get(), path.c_str())); }

    static Tissue read_bytes(const Context &context, const std::uint8_t *bytes, std::size_t size) {
        Tissue made;
        check(rlv_tissue_read_bytes(context.get(), bytes, size, made.out()));
        return made;
    }

    Bytes write_bytes() const {
        RlvBytes made{0};
        check(rlv_tissue_write_bytes(get(), &made));
        return Bytes(made);
    }

    RlvTissueInfo info() const {
        RlvTissueInfo info = RLV_TISSUE_INFO_INIT;
        check(rlv_tissue_info(get(), &info));
        return info;
    }

    std::vector<Float3> nodes() const {
        std::vector<Float3> nodes(info().node_count);
        check(rlv_tissue_get_nodes(get(), nodes.empty() ? nullptr : nodes.front().data(), nodes.size(), 0));
        return nodes;
    }

    std::uint32_t find_muscle(const std::string &name) const {
        std::uint32_t index = 0;
        check(rlv_tissue_find_muscle(get(), name.c_str(), &index));
        return index;
    }

    /// Returns the nodes of the set of a name.
    std::vector<std::uint32_t> set(const std::string &name) const {
        std::uint32_t index = 0;
        check(rlv_tissue_find_set(get(), name.c_str(), &index));
        RlvTissueSet set = RLV_TISSUE_SET_INIT;
        check(rlv_tissue_set(get(), index, &set));
        std::vector<std::uint32_t> nodes(set.count);
        check(rlv_tissue_get_set(get(), index, nodes.data(), nodes.size()));
        return nodes;
    }

    std::uint32_t add_set(const std::string &name, const Double3 &low, const Double3 &high) const {
        std::uint32_t index = 0;
        check(rlv_tissue_add_set(get(), name.c_str(), low.data(), high.data(), &index));
        return index;
    }

    void hold(const std::vector<std::uint32_t> &nodes, std::uint32_t axes = 7) const {
        check(rlv_tissue_hold(get(), nodes.data(), nodes.size(), 0, axes));
    }

    std::uint32_t bind(const std::string &name, const Mesh &mesh) const {
        std::uint32_t index = 0;
        check(rlv_tissue_bind(get(), mesh.get(), name.c_str(), &index));
        return index;
    }

    TissueSimulation simulate(const RlvTissueOptions &options = RLV_TISSUE_OPTIONS_INIT) const {
        RlvTissueSimulation made = RLV_NULL;
        check(rlv_tissue_simulate(get(), &options, &made));
        return TissueSimulation(made);
    }
};

/// A scene for Client::submit.
struct ClientScene {
    std::string name, description;
    /// Paths of files by the names that the description gives them.
    std::vector<std::pair<std::string, std::string>> files;
    std::string kind = "fluid";
    /// Whether each frame waits for Client::force.
    bool is_forced = false;

    /// Calls `use` with the scene as the C ABI takes it.
    template <class Use> void pass(Use &&use) const {
        std::vector<RlvClientFile> list;
        for (const auto &[file, path] : files) {
            list.push_back({file.c_str(), path.c_str()});
        }
        RlvClientScene given = RLV_CLIENT_SCENE_INIT;
        given.is_forced = is_forced ? 1 : 0;
        given.name = name.c_str();
        given.kind = kind.c_str();
        given.description = description.c_str();
        given.files = list.data();
        given.file_count = list.size();
        std::forward<Use>(use)(given);
    }
};

/// See relievo/client.h.
class Client : public Reference<RlvClient, rlv_client_retain, rlv_client_release> {
public:
    using Reference::Reference;

    static Client connect(const Context &context, const RlvClientOptions &options = RLV_CLIENT_OPTIONS_INIT) {
        Client made;
        check(rlv_client_connect(context.get(), &options, made.out()));
        return made;
    }

    RlvClientInfo info() const {
        RlvClientInfo info = RLV_CLIENT_INFO_INIT;
        check(rlv_client_info(get(), &info));
        return info;
    }

    RlvClientStatus submit(const ClientScene &scene, const Progress &progress = nullptr) const {
        Watch watch(progress);
        RlvClientStatus status = RLV_CLIENT_STATUS_INIT;
        scene.pass([&](const RlvClientScene &given) {
            watch.check(rlv_client_submit(get(), &given, watch.callback(), &watch, &status));
        });
        return status;
    }

    RlvClientStatus poll(const std::string &scene) const {
        RlvClientStatus status = RLV_CLIENT_STATUS_INIT;
        check(rlv_client_poll(get(), scene.c_str(), &status));
        return status;
    }

    RlvClientStatus wait(const std::string &scene, std::uint64_t frame, const Progress &progress = nullptr) const {
        Watch watch(progress);
        RlvClientStatus status = RLV_CLIENT_STATUS_INIT;
        watch.check(rlv_client_wait(get(), scene.c_str(), frame, watch.callback(), &watch, &status));
        return status;
    }

    RlvClientStatus steer(const std::string &scene, std::uint64_t frame, const std::string &changes) const {
        RlvClientStatus status = RLV_CLIENT_STATUS_INIT;
        check(rlv_client_steer(get(), scene.c_str(), frame, changes.c_str(), &status));
        return status;
    }

    RlvClientStatus force(const std::string &scene, std::uint64_t frame,
                          const std::vector<Float3> &accelerations) const {
        RlvClientStatus status = RLV_CLIENT_STATUS_INIT;
        check(rlv_client_force(get(), scene.c_str(), frame, reinterpret_cast<const float *>(accelerations.data()),
                               accelerations.size(), 0, &status));
        return status;
    }

    void control(const std::string &scene, RlvClientAction action) const {
        check(rlv_client_control(get(), scene.c_str(), action));
    }

    Particles fetch(const std::string &scene, std::uint64_t frame,
                    const RlvClientFetch &fetch = RLV_CLIENT_FETCH_INIT, const Progress &progress = nullptr) const {
        Watch watch(progress);
        RlvParticles made{0};
        watch.check(rlv_client_fetch(get(), scene.c_str(), frame, &fetch, watch.callback(), &watch, &made));
        return Particles(made);
    }

    Mesh fetch_mesh(const std::string &scene, std::uint64_t frame, const std::string &settings = "",
                    const Progress &progress = nullptr) const {
        Watch watch(progress);
        RlvMesh made{0};
        watch.check(rlv_client_fetch_mesh(get(), scene.c_str(), frame, settings.c_str(), watch.callback(), &watch, &made));
        return Mesh(made);
    }

    void save(const std::string &scene, std::uint64_t frame, RlvClientForm form, const std::string &path,
              const std::string &settings = "", const Progress &progress = nullptr) const {
        Watch watch(progress);
        watch.check(rlv_client_save(get(), scene.c_str(), frame, form, settings.c_str(), path.c_str(), watch.callback(),
                                    &watch));
    }
};

/// See relievo/job.h. A job that is released while it runs is cancelled.
class AnyJob : public Reference<RlvJob, rlv_job_retain, rlv_job_release> {
public:
    using Reference::Reference;

    /// Returns the grid that the job made.
    Grid grid() const {
        RlvGrid made = RLV_NULL;
        check(rlv_job_grid(get(), &made));
        return Grid(made);
    }

    /// What it makes: an RlvJobKind.
    std::uint32_t kind() const { return poll().kind; }

    RlvJobInfo poll() const {
        RlvJobInfo info = RLV_JOB_INFO_INIT;
        check(rlv_job_poll(get(), &info));
        return info;
    }

    /// Waits for its end, no longer than so many seconds; -1 for as long as it takes.
    RlvJobInfo wait(double seconds = -1.0) const {
        RlvJobInfo info = RLV_JOB_INFO_INIT;
        check(rlv_job_wait(get(), seconds, &info));
        return info;
    }

    /// Has callback(user) called once when it has ended, on the thread that ran it.
    void notify(RlvJobDone callback, void *user) const { check(rlv_job_notify(get(), callback, user)); }

    void cancel() const { check(rlv_job_cancel(get())); }
    /// Throws what the call failed at.
    void result() const { check(rlv_job_result(get())); }

    Mesh mesh() const {
        RlvMesh made{0};
        check(rlv_job_mesh(get(), &made));
        return Mesh(made);
    }

    Particles particles() const {
        RlvParticles made{0};
        check(rlv_job_particles(get(), &made));
        return Particles(made);
    }

    RlvClientStatus client_status() const {
        RlvClientStatus status = RLV_CLIENT_STATUS_INIT;
        check(rlv_job_client_status(get(), &status));
        return status;
    }

    RlvRepairReport repair_report() const {
        RlvRepairReport report = RLV_REPAIR_REPORT_INIT;
        check(rlv_job_repair_report(get(), &report));
        return report;
    }

    /// How far the mesh that was simplified deviates.
    float deviation() const {
        float error = 0.0f;
        check(rlv_job_simplify_error(get(), &error));
        return error;
    }

    Progressive progressive() const {
        RlvProgressive made{0};
        check(rlv_job_progressive_mesh(get(), &made));
        return Progressive(made);
    }

    Decal decal() const {
        RlvDecal made = RLV_NULL;
        check(rlv_job_decal(get(), &made));
        return Decal(made);
    }

    Tissue tissue() const {
        RlvTissue made = RLV_NULL;
        check(rlv_job_tissue(get(), &made));
        return Tissue(made);
    }

    CrowdModel crowd_model() const {
        RlvCrowdModel made = RLV_NULL;
        check(rlv_job_crowd_model(get(), &made));
        return CrowdModel(made);
    }

    RlvCrowdRefitReport crowd_refit_report() const {
        RlvCrowdRefitReport report = RLV_CROWD_REFIT_REPORT_INIT;
        check(rlv_job_crowd_refit_report(get(), &report));
        return report;
    }

    Surface surface() const {
        RlvSurface made = RLV_NULL;
        check(rlv_job_surface(get(), &made));
        return Surface(made);
    }

    Caster caster() const {
        RlvCaster made = RLV_NULL;
        check(rlv_job_caster(get(), &made));
        return Caster(made);
    }

    Procedural procedural() const {
        RlvProcedural made = RLV_NULL;
        check(rlv_job_procedural(get(), &made));
        return Procedural(made);
    }

    Collider collider() const {
        RlvCollider made = RLV_NULL;
        check(rlv_job_collider(get(), &made));
        return Collider(made);
    }

    Picture picture() const {
        RlvPicture made = RLV_NULL;
        check(rlv_job_picture(get(), &made));
        return Picture(made);
    }

    Document document() const {
        RlvDocument made = RLV_NULL;
        check(rlv_job_document(get(), &made));
        return Document(made);
    }

    Bytes bytes() const {
        RlvBytes made = RLV_NULL;
        check(rlv_job_bytes(get(), &made));
        return Bytes(made);
    }

    RlvFluidReport fluid_report() const {
        RlvFluidReport report = RLV_FLUID_REPORT_INIT;
        check(rlv_job_fluid_report(get(), &report));
        return report;
    }

    RlvImprintReport imprint_report() const {
        RlvImprintReport report = RLV_IMPRINT_REPORT_INIT;
        check(rlv_job_imprint_report(get(), &report));
        return report;
    }

    RlvBakeReport bake_report() const {
        RlvBakeReport report = RLV_BAKE_REPORT_INIT;
        check(rlv_job_bake_report(get(), &report));
        return report;
    }

    RlvPtexReport ptex_report() const {
        RlvPtexReport report = RLV_PTEX_REPORT_INIT;
        check(rlv_job_ptex_report(get(), &report));
        return report;
    }

    RlvTransferReport transfer_report() const {
        RlvTransferReport report = RLV_TRANSFER_REPORT_INIT;
        check(rlv_job_transfer_report(get(), &report));
        return report;
    }

protected:
    // What JobOf takes, by its type.
    void taken(void *) const { result(); }
    Mesh taken(Mesh *) const { return mesh(); }
    Progressive taken(Progressive *) const { return progressive(); }
    Grid taken(Grid *) const { return grid(); }
    Decal taken(Decal *) const { return decal(); }
    CrowdModel taken(CrowdModel *) const { return crowd_model(); }
    Tissue taken(Tissue *) const { return tissue(); }
    Particles taken(Particles *) const { return particles(); }
    Surface taken(Surface *) const { return surface(); }
    Caster taken(Caster *) const { return caster(); }
    Procedural taken(Procedural *) const { return procedural(); }
    Collider taken(Collider *) const { return collider(); }
    Picture taken(Picture *) const { return picture(); }
    Document taken(Document *) const { return document(); }
    Bytes taken(Bytes *) const { return bytes(); }
    RlvImprintReport taken(RlvImprintReport *) const { return imprint_report(); }
    RlvBakeReport taken(RlvBakeReport *) const { return bake_report(); }
    RlvPtexReport taken(RlvPtexReport *) const { return ptex_report(); }
    RlvTransferReport taken(RlvTransferReport *) const { return transfer_report(); }
    RlvFluidReport taken(RlvFluidReport *) const { return fluid_report(); }
    RlvClientStatus taken(RlvClientStatus *) const { return client_status(); }
};

/// A job that makes a T: an object, a report, or nothing for void.
template <class T> class JobOf : public AnyJob {
public:
    using AnyJob::AnyJob;

    /// Waits for the end and returns what the call returns, or throws what it failed at. An object is the same one every
    /// time.
    T take() const {
        wait();
        return taken(static_cast<T *>(nullptr));
    }

private:
    friend class Job;
};

/// Starts jobs, and holds one whose result is not known from its type.
class Job : public AnyJob {
public:
    using AnyJob::AnyJob;
    Job(AnyJob job) : AnyJob(std::move(job)) {}

    static JobOf<Mesh> tessellate(const Detail &detail,
                          const RlvTessellateOptions &options = RLV_TESSELLATE_OPTIONS_INIT) {
        JobOf<Mesh> made;
        check(rlv_job_tessellate(detail.get(), &options, made.out()));
        return made;
    }

    static JobOf<Grid> grid_from_mesh(const Mesh &mesh, const RlvGridSettings &settings = RLV_GRID_SETTINGS_INIT) {
        JobOf<Grid> made;
        check(rlv_job_grid_from_mesh(mesh.get(), &settings, made.out()));
        return made;
    }

    static JobOf<Grid> grid_read(const Context &context, const std::string &path, const std::string &name = "") {
        JobOf<Grid> made;
        const char *const wanted = name.empty() ? nullptr : name.c_str();
        check(rlv_job_grid_read(context.get(), path.c_str(), wanted, nullptr, made.out()));
        return made;
    }

    static JobOf<Grid> grid_change(const Grid &grid, RlvGridChange change,
                           const RlvGridSettings &settings = RLV_GRID_SETTINGS_INIT) {
        JobOf<Grid> made;
        check(rlv_job_grid_change(grid.get(), change, &settings, made.out()));
        return made;
    }

    static JobOf<Mesh> grid_mesh(const Grid &grid, const RlvGridSettings &settings = RLV_GRID_SETTINGS_INIT) {
        JobOf<Mesh> made;
        check(rlv_job_grid_mesh(grid.get(), &settings, made.out()));
        return made;
    }

    static JobOf<RlvImprintReport> sweep(const Detail &detail, const Collider &collider, const Matrix &from, const Matrix &to,
                     const RlvImprintSettings &settings = RLV_IMPRINT_SETTINGS_INIT,
                     const RlvImprintMoment &moment = RLV_IMPRINT_MOMENT_INIT) {
        JobOf<RlvImprintReport> made;
        check(rlv_job_sweep(detail.get(), collider.get(), from.data(), to.data(), &settings, &moment, made.out()));
        return made;
    }

    /// Of a collider that deforms: its points at either place, as many as it has.
    static JobOf<RlvImprintReport> sweep(const Detail &detail, const Collider &collider, const Matrix &from, const Matrix &to,
                     const std::vector<std::array<float, 3>> &from_points,
                     const std::vector<std::array<float, 3>> &to_points,
                     const RlvImprintSettings &settings = RLV_IMPRINT_SETTINGS_INIT,
                     const RlvImprintMoment &moment = RLV_IMPRINT_MOMENT_INIT) {
        if (from_points.size() != to_points.size()) {
            raise(std::invalid_argument("sweep: a collider has as many points before as after"));
        }
        JobOf<RlvImprintReport> made;
        check(rlv_job_sweep_points(detail.get(), collider.get(), from.data(), to.data(),
                                   reinterpret_cast<const float *>(from_points.data()),
                                   reinterpret_cast<const float *>(to_points.data()), from_points.size(), 0, &settings,
                                   &moment, made.out()));
        return made;
    }

    static JobOf<void> write_ptex(const Detail &detail, std::uint32_t channel, const std::string &path) {
        JobOf<void> made;
        check(rlv_job_ptex_write(detail.get(), channel, path.c_str(), made.out()));
        return made;
    }

    static JobOf<RlvPtexReport> read_ptex(const Detail &detail, const std::string &path,
                         const RlvPtexOptions &options = RLV_PTEX_OPTIONS_INIT) {
        JobOf<RlvPtexReport> made;
        check(rlv_job_ptex_read(detail.get(), path.c_str(), &options, made.out()));
        return made;
    }

    static JobOf<RlvTransferReport> transfer(const Context &context, const std::string &path, const Mesh &to, const std::string &to_path,
                        const RlvTransferOptions &options = RLV_TRANSFER_OPTIONS_INIT) {
        JobOf<RlvTransferReport> made;
        check(rlv_job_transfer(context.get(), to.get(), path.c_str(), to_path.c_str(), &options, made.out()));
        return made;
    }

    static JobOf<RlvBakeReport> bake(const Detail &detail, const std::string &path,
                    const RlvBakeOptions &options = RLV_BAKE_OPTIONS_INIT) {
        JobOf<RlvBakeReport> made;
        check(rlv_job_bake(detail.get(), &options, path.c_str(), made.out()));
        return made;
    }

    static JobOf<RlvFluidReport> advance(const Fluid &fluid, double seconds) {
        JobOf<RlvFluidReport> made;
        check(rlv_job_fluid(fluid.get(), seconds, made.out()));
        return made;
    }

    static JobOf<Mesh> mesh(const Isosurface &isosurface,
                    const RlvIsosurfaceMeshOptions &options = RLV_ISOSURFACE_MESH_OPTIONS_INIT) {
        JobOf<Mesh> made;
        check(rlv_job_isosurface(isosurface.get(), &options, made.out()));
        return made;
    }

    static JobOf<Progressive> build(const Mesh &mesh, const RlvProgressiveOptions &options = RLV_PROGRESSIVE_OPTIONS_INIT) {
        JobOf<Progressive> made;
        check(rlv_job_progressive(mesh.get(), &options, made.out()));
        return made;
    }

    static JobOf<Mesh> simplify(const Mesh &mesh, const Simplify &how) {
        std::vector<RlvSimplifyWeight> told;
        const RlvSimplifyOptions given = how.pointing(told);
        JobOf<Mesh> made;
        check(rlv_job_simplify(mesh.get(), &given, made.out()));
        return made;
    }

    static JobOf<Mesh> repair(const Mesh &mesh, const RlvRepairSettings &settings = RLV_REPAIR_SETTINGS_INIT) {
        JobOf<Mesh> made;
        check(rlv_job_repair(mesh.get(), &settings, made.out()));
        return made;
    }

    static JobOf<Decal> decal(const Mesh &mesh, const RlvDecalOptions &options, const std::vector<RlvDecalPin> &pins) {
        JobOf<Decal> made;
        check(rlv_job_decal_on_mesh(mesh.get(), &options, pins.data(), pins.size(), 0, made.out()));
        return made;
    }

    static JobOf<Decal> decal(const Detail &detail, const RlvDecalOptions &options, const std::vector<RlvDecalPin> &pins) {
        JobOf<Decal> made;
        check(rlv_job_decal_on_detail(detail.get(), &options, pins.data(), pins.size(), 0, made.out()));
        return made;
    }

    static JobOf<Tissue> tissue(const Context &context, const RlvTissueDescription &description) {
        JobOf<Tissue> made;
        check(rlv_job_tissue_build(context.get(), &description, made.out()));
        return made;
    }

    static JobOf<void> advance(const TissueSimulation &simulation, double seconds) {
        JobOf<void> made;
        check(rlv_job_tissue_advance(simulation.get(), seconds, made.out()));
        return made;
    }

    static JobOf<RlvClientStatus> submit(const Client &client, const ClientScene &scene) {
        JobOf<RlvClientStatus> made;
        scene.pass([&](const RlvClientScene &given) { check(rlv_job_client_submit(client.get(), &given, made.out())); });
        return made;
    }

    /// Waits for a frame and fetches it.
    static JobOf<Particles> fetch(const Client &client, const std::string &scene, std::uint64_t frame,
                     const RlvClientFetch &fetch = RLV_CLIENT_FETCH_INIT) {
        JobOf<Particles> made;
        check(rlv_job_client_fetch(client.get(), scene.c_str(), frame, &fetch, made.out()));
        return made;
    }

    /// Waits for a frame and fetches a mesh of its surface.
    static JobOf<Mesh> fetch_mesh(const Client &client, const std::string &scene, std::uint64_t frame,
                          const std::string &settings = "") {
        JobOf<Mesh> made;
        check(rlv_job_client_fetch_mesh(client.get(), scene.c_str(), frame, settings.c_str(), made.out()));
        return made;
    }

    static JobOf<CrowdModel> crowd(const Context &context, const std::string &path, const std::vector<std::string> &clips = {},
                     const RlvCrowdBuildSettings &settings = RLV_CROWD_BUILD_SETTINGS_INIT) {
        JobOf<CrowdModel> made;
        const std::vector<RlvCrowdClipName> names = CrowdModel::names_of(clips);
        check(rlv_job_crowd(context.get(), path.c_str(), names.data(), names.size(), &settings, made.out()));
        return made;
    }

    static JobOf<CrowdModel> refit(const CrowdModel &model, const std::string &path,
                                   const std::vector<std::string> &clips = {},
                                   const RlvCrowdBuildSettings &settings = RLV_CROWD_BUILD_SETTINGS_INIT) {
        JobOf<CrowdModel> made;
        const std::vector<RlvCrowdClipName> names = CrowdModel::names_of(clips);
        check(rlv_job_crowd_refit(model.get(), path.c_str(), names.data(), names.size(), &settings, made.out()));
        return made;
    }

    static JobOf<CrowdModel> with_blend(const CrowdModel &model, std::uint32_t blend) {
        JobOf<CrowdModel> made;
        check(rlv_job_crowd_model_with_blend(model.get(), blend, made.out()));
        return made;
    }

    static JobOf<Surface> surface(const Context &context, const Mesh &cage, const RlvSurfaceOptions &options = RLV_SURFACE_OPTIONS_INIT) {
        JobOf<Surface> made;
        check(rlv_job_surface_create(context.get(), cage.get(), &options, made.out()));
        return made;
    }

    static JobOf<Caster> caster(const Context &context, const Mesh &mesh) {
        JobOf<Caster> made;
        check(rlv_job_caster_create_mesh(context.get(), mesh.get(), made.out()));
        return made;
    }

    static JobOf<Caster> caster(const Detail &detail, const RlvTessellateOptions &options = RLV_TESSELLATE_OPTIONS_INIT) {
        JobOf<Caster> made;
        check(rlv_job_caster_create_detail(detail.get(), &options, made.out()));
        return made;
    }

    /// Of a caster that follows.
    static JobOf<Caster> caster(const Tessellation &tessellation) {
        JobOf<Caster> made;
        check(rlv_job_caster_create_tessellation(tessellation.get(), made.out()));
        return made;
    }

    static JobOf<Procedural> procedural(const Detail &detail, const RlvProceduralOptions &options = RLV_PROCEDURAL_OPTIONS_INIT) {
        JobOf<Procedural> made;
        check(rlv_job_procedural_create(detail.get(), &options, made.out()));
        return made;
    }

    /// Of a surface that moves.
    static JobOf<Procedural> procedural(const Procedural &begin, const Detail &end) {
        JobOf<Procedural> made;
        check(rlv_job_procedural_create_moving(begin.get(), end.get(), made.out()));
        return made;
    }

    static JobOf<Collider> collider(const Context &context, const Mesh &mesh, const Matrix &matrix) {
        JobOf<Collider> made;
        check(rlv_job_collider_create_mesh(context.get(), mesh.get(), matrix.data(), made.out()));
        return made;
    }

    static JobOf<Collider> collider(const Surface &surface, const Matrix &matrix, const RlvTessellateOptions &options = RLV_TESSELLATE_OPTIONS_INIT) {
        JobOf<Collider> made;
        check(rlv_job_collider_create_surface(surface.get(), &options, matrix.data(), made.out()));
        return made;
    }

    static JobOf<Collider> collider(const Detail &detail, const RlvTessellateOptions &options = RLV_TESSELLATE_OPTIONS_INIT) {
        JobOf<Collider> made;
        check(rlv_job_collider_create_detail(detail.get(), &options, made.out()));
        return made;
    }

    static JobOf<Mesh> read_mesh(const Context &context, const std::string &path) {
        JobOf<Mesh> made;
        check(rlv_job_mesh_read(context.get(), path.c_str(), made.out()));
        return made;
    }

    static JobOf<void> write_mesh(const Mesh &mesh, const std::string &path) {
        JobOf<void> made;
        check(rlv_job_mesh_write(mesh.get(), path.c_str(), made.out()));
        return made;
    }

    static JobOf<Particles> read_particles(const Context &context, const std::string &path) {
        JobOf<Particles> made;
        check(rlv_job_particles_read(context.get(), path.c_str(), made.out()));
        return made;
    }

    static JobOf<void> write_particles(const Particles &particles, const std::string &path) {
        JobOf<void> made;
        check(rlv_job_particles_write(particles.get(), path.c_str(), made.out()));
        return made;
    }

    static JobOf<Picture> open_picture(const Context &context, const std::string &path) {
        JobOf<Picture> made;
        check(rlv_job_picture_open(context.get(), path.c_str(), made.out()));
        return made;
    }

    static JobOf<Document> create_document(const Detail &detail, const std::string &path, std::uint64_t memory = 0) {
        JobOf<Document> made;
        check(rlv_job_document_create(detail.get(), path.c_str(), memory, made.out()));
        return made;
    }

    static JobOf<Document> open_document(const Detail &detail, const std::string &path, std::uint64_t memory = 0) {
        JobOf<Document> made;
        check(rlv_job_document_open(detail.get(), path.c_str(), memory, made.out()));
        return made;
    }

    static JobOf<void> save_document(const Document &document, const std::string &path) {
        JobOf<void> made;
        check(rlv_job_document_save(document.get(), path.c_str(), made.out()));
        return made;
    }

    static JobOf<Document> open_document(const Detail &detail, const std::uint8_t *bytes, std::size_t size,
                                         std::uint64_t memory = 0) {
        JobOf<Document> made;
        check(rlv_job_document_open_bytes(detail.get(), bytes, size, memory, made.out()));
        return made;
    }

    static JobOf<Bytes> document_bytes(const Document &document) {
        JobOf<Bytes> made;
        check(rlv_job_document_save_bytes(document.get(), made.out()));
        return made;
    }

    static JobOf<Progressive> read_progressive(const Context &context, const std::string &path, std::size_t triangles = SIZE_MAX) {
        JobOf<Progressive> made;
        check(rlv_job_progressive_read(context.get(), path.c_str(), triangles, made.out()));
        return made;
    }

    static JobOf<void> write_progressive(const Progressive &progressive, const std::string &path) {
        JobOf<void> made;
        check(rlv_job_progressive_write(progressive.get(), path.c_str(), made.out()));
        return made;
    }

    static JobOf<CrowdModel> read_crowd_model(const Context &context, const std::string &path) {
        JobOf<CrowdModel> made;
        check(rlv_job_crowd_model_read(context.get(), path.c_str(), made.out()));
        return made;
    }

    static JobOf<void> write_crowd_model(const CrowdModel &model, const std::string &path) {
        JobOf<void> made;
        check(rlv_job_crowd_model_write(model.get(), path.c_str(), made.out()));
        return made;
    }

    static JobOf<Tissue> read_tissue(const Context &context, const std::string &path) {
        JobOf<Tissue> made;
        check(rlv_job_tissue_read(context.get(), path.c_str(), made.out()));
        return made;
    }

    static JobOf<void> write_tissue(const Tissue &tissue, const std::string &path) {
        JobOf<void> made;
        check(rlv_job_tissue_write(tissue.get(), path.c_str(), made.out()));
        return made;
    }

    /// `writing` is bits of RlvGridWriting.
    static JobOf<void> write_grids(const std::vector<Grid> &grids, const std::string &path,
                                      std::uint32_t writing = RLV_GRID_PACK_BLOSC) {
        std::vector<RlvGrid> handles;
        for (const Grid &grid : grids) {
            handles.push_back(grid.get());
        }
        JobOf<void> made;
        check(rlv_job_grid_write(handles.data(), handles.size(), path.c_str(), writing, made.out()));
        return made;
    }

    static JobOf<void> compact_document(const Context &context, const std::string &path, std::size_t keep = 0) {
        JobOf<void> made;
        check(rlv_job_document_compact(context.get(), path.c_str(), keep, made.out()));
        return made;
    }
};

/// See relievo/buffer.h.
class Buffer : public Reference<RlvBuffer, rlv_buffer_retain, rlv_buffer_release> {
public:
    using Reference::Reference;

    static Buffer create(const Tessellation &tessellation) {
        Buffer made;
        check(rlv_buffer_create(tessellation.get(), made.out()));
        return made;
    }

    /// In buffers of the host; see relievo/vulkan.h.
    static Buffer create(const Tessellation &tessellation, const RlvVulkanBuffers &buffers) {
        Buffer made;
        check(rlv_vulkan_create_buffer(tessellation.get(), &buffers, made.out()));
        return made;
    }

    RlvBufferInfo info() const {
        RlvBufferInfo info = RLV_BUFFER_INFO_INIT;
        check(rlv_buffer_info(get(), &info));
        return info;
    }

    RlvBufferInfo update() const {
        RlvBufferInfo info = RLV_BUFFER_INFO_INIT;
        check(rlv_buffer_update(get(), &info));
        return info;
    }

    RlvBufferVulkan vulkan() const {
        RlvBufferVulkan vulkan = RLV_BUFFER_VULKAN_INIT;
        check(rlv_buffer_vulkan(get(), &vulkan));
        return vulkan;
    }

    /// Positions and normals, 6 floats a point.
    std::vector<std::array<float, 6>> read() const {
        std::vector<std::array<float, 6>> points(info().point_count);
        check(rlv_buffer_read(get(), 0, points.size(), points.empty() ? nullptr : points.front().data(), 0));
        return points;
    }
};

/// See relievo/color_buffer.h.
class ColorBuffer : public Reference<RlvColorBuffer, rlv_color_buffer_retain, rlv_color_buffer_release> {
public:
    using Reference::Reference;

    static ColorBuffer create(const Detail &detail) {
        ColorBuffer made;
        check(rlv_color_buffer_create(detail.get(), made.out()));
        return made;
    }

    RlvColorBufferInfo info() const {
        RlvColorBufferInfo info = RLV_COLOR_BUFFER_INFO_INIT;
        check(rlv_color_buffer_info(get(), &info));
        return info;
    }

    RlvColorBufferInfo update() const {
        RlvColorBufferInfo info = RLV_COLOR_BUFFER_INFO_INIT;
        check(rlv_color_buffer_update(get(), &info));
        return info;
    }

    RlvColorBufferVulkan vulkan() const {
        RlvColorBufferVulkan vulkan = RLV_COLOR_BUFFER_VULKAN_INIT;
        check(rlv_color_buffer_vulkan(get(), &vulkan));
        return vulkan;
    }

    /// The block of a tile at a level, 0 for itself; empty if it has none.
    std::vector<std::uint8_t> read(std::uint32_t tile, std::uint32_t level = 0) const {
        std::size_t size = 0;
        check(rlv_color_buffer_read(get(), tile, level, nullptr, 0, &size));
        std::vector<std::uint8_t> bytes(size);
        if (size > 0) {
            check(rlv_color_buffer_read(get(), tile, level, bytes.data(), bytes.size(), &size));
        }
        return bytes;
    }
};

} // namespace relievo

#undef RELIEVO_TRY
#undef RELIEVO_CATCH
#undef RELIEVO_RETHROW

#endif
