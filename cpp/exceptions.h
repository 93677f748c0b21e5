// Turns every C++ exception of a bridge into an error of Rust. A bridge includes this header, and cxx then uses this
// function in place of its own, which catches std::exception alone and ends the process for everything else.
#pragma once
#include <exception>

namespace rust {
namespace behavior {

template <typename Try, typename Fail>
static void trycatch(Try&& call, Fail&& fail) noexcept {
    try {
        call();
    } catch (const std::exception& exception) {
        fail(exception.what());
    } catch (...) {
        fail("an exception of an unknown type");
    }
}

} // namespace behavior
} // namespace rust
