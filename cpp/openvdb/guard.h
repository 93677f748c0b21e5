// What every entry of the module shares: exceptions become errors, threads are bounded, grids are dispatched by kind.
#pragma once

#include "module.h"

#include <openvdb/openvdb.h>
#include <openvdb/util/NullInterrupter.h>

#include <tbb/global_control.h>
#include <tbb/info.h>
#include <tbb/task_arena.h>

#include <algorithm>
#include <atomic>
#include <cmath>
#include <cstdint>
#include <cstdio>
#include <exception>
#include <memory>
#include <new>
#include <stdexcept>
#include <string>
#include <thread>
#include <type_traits>

struct RlvdbGrid {
    openvdb::GridBase::Ptr grid;
};

namespace relievo {

// A failure with its code.
struct Failure : std::runtime_error {
    Failure(std::int32_t code, const std::string& text) : std::runtime_error(text), code(code) {}
    std::int32_t code;
};

[[noreturn]] inline void refuse(const std::string& text) { throw Failure(RLVDB_INVALID, text); }

// Runs `call` and turns any exception into a code and a text.
template <typename Call>
std::int32_t guarded(RlvdbError* error, const Call& call) noexcept {
    const auto failed = [error](std::int32_t code, const char* text) {
        std::snprintf(error->text, sizeof error->text, "%s", text);
        return code;
    };
    try {
        call();
        return RLVDB_OK;
    } catch (const Failure& failure) {
        return failed(failure.code, failure.what());
    } catch (const std::bad_alloc&) {
        return failed(RLVDB_MEMORY, "an allocation failed");
    } catch (const std::length_error&) {
        return failed(RLVDB_MEMORY, "an array would be longer than memory is");
    } catch (const openvdb::IoError& exception) {
        return failed(RLVDB_FAILED, exception.what());
    } catch (const openvdb::Exception& exception) {
        // OpenVDB throws these for numbers and grids that an operation cannot take.
        return failed(RLVDB_INVALID, exception.what());
    } catch (const std::exception& exception) {
        return failed(RLVDB_FAILED, exception.what());
    } catch (...) {
        return failed(RLVDB_FAILED, "an exception of an unknown type");
    }
}

// The same on this thread alone. OpenVDB also counts voxels, copies and frees trees in parallel, for which TBB would start
// its threads.
template <typename Call>
std::int32_t alone(RlvdbError* error, const Call& call) noexcept {
    return guarded(error, [&] { tbb::task_arena(1).execute(call); });
}

// Passes progress to the caller, on its own thread alone, and keeps its wish to stop.
class Interrupter final : public openvdb::util::NullInterrupter {
  public:
    explicit Interrupter(const RlvdbCall& call) : call_(call), owner_(std::this_thread::get_id()) {}

    bool wasInterrupted(int percent = -1) override {
        if (call_.progress && !stopped_ && std::this_thread::get_id() == owner_ && !call_.progress(call_.user, percent)) {
            stopped_ = true;
        }
        return stopped_;
    }

    // Throws if the caller wishes to stop; a call that was stopped leaves an unfinished grid.
    void check(int percent = -1) {
        if (wasInterrupted(percent)) {
            throw Failure(RLVDB_CANCELLED, "cancelled");
        }
    }

  private:
    const RlvdbCall& call_;
    const std::thread::id owner_;
    std::atomic<bool> stopped_{false};
};

// Runs `work(interrupter)` on at most as many threads as the caller allows. With one thread TBB starts none.
template <typename Call>
std::int32_t bounded(const RlvdbCall* call, RlvdbError* error, const Call& work) noexcept {
    return guarded(error, [&] {
        // TBB prints a warning where more threads are asked for than it may start.
        const std::size_t allowed = std::min<std::size_t>(
            tbb::info::default_concurrency(),
            tbb::global_control::active_value(tbb::global_control::max_allowed_parallelism));
        tbb::task_arena arena(static_cast<int>(std::clamp<std::size_t>(call->threads, 1, std::max<std::size_t>(allowed, 1))));
        arena.execute([&] {
            Interrupter interrupter(*call);
            interrupter.check(0);
            work(interrupter);
        });
    });
}

using Scalars = openvdb::TypeList<openvdb::FloatGrid, openvdb::DoubleGrid>;
using Integers = openvdb::TypeList<openvdb::Int32Grid, openvdb::Int64Grid>;
using Masks = openvdb::TypeList<openvdb::BoolGrid, openvdb::MaskGrid>;
using Vectors = openvdb::TypeList<openvdb::Vec3SGrid, openvdb::Vec3DGrid, openvdb::Vec3IGrid>;
using Kinds = Scalars::Append<Masks>::Append<Integers>::Append<Vectors>;

// Calls `work` with the grid as what it is, if that is among `Types`.
template <typename Types, typename Work>
void dispatch(const openvdb::GridBase& grid, const char* what, const Work& work) {
    if (!grid.apply<Types>(work)) {
        refuse(std::string("a grid of type ") + grid.type() + " cannot be " + what);
    }
}

// How many numbers a value has.
template <typename Value>
constexpr int components = 1;
template <typename Number>
constexpr int components<openvdb::math::Vec3<Number>> = 3;

// Writes the numbers of a value.
template <typename Value>
void put(const Value& value, double* out) {
    if constexpr (components<Value> == 3) {
        for (int axis = 0; axis < 3; ++axis) {
            out[axis] = static_cast<double>(value[axis]);
        }
    } else {
        *out = static_cast<double>(value);
    }
}

inline openvdb::math::Transform::Ptr transform_of(const double* matrix) {
    const openvdb::Mat4R rows(matrix);
    if (!(std::abs(rows.det()) > 0.0)) {
        refuse("a transform has no inverse");
    }
    return openvdb::math::Transform::createLinearTransform(rows);
}

// Makes an entry of metadata from text.
inline openvdb::Metadata::Ptr metadata_of(const std::string& type, const std::string& value) {
    if (type == "string") {
        return std::make_shared<openvdb::StringMetadata>(value);
    }
    if (type == "bool") {
        return std::make_shared<openvdb::BoolMetadata>(value == "true" || value == "1");
    }
    if (type == "float" || type == "double") {
        const double number = std::stod(value);
        if (type == "float") {
            return std::make_shared<openvdb::FloatMetadata>(static_cast<float>(number));
        }
        return std::make_shared<openvdb::DoubleMetadata>(number);
    }
    if (type == "int32" || type == "int64") {
        const long long number = std::stoll(value);
        if (type == "int64") {
            return std::make_shared<openvdb::Int64Metadata>(number);
        }
        if (number < INT32_MIN || number > INT32_MAX) {
            refuse("a number of metadata has more than 32 bits");
        }
        return std::make_shared<openvdb::Int32Metadata>(static_cast<std::int32_t>(number));
    }
    refuse("metadata of type " + type + " cannot be set");
}

// Hands out a grid.
inline void give(RlvdbGrid** out, openvdb::GridBase::Ptr grid) { *out = new RlvdbGrid{std::move(grid)}; }

}  // namespace relievo
