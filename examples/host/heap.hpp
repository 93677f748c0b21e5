// The memory of the host: an allocator that knows how much there is, for all memory of the library's own code.
#pragma once

#include <cstddef>

namespace studio::heap {

/// Gives the library its memory from now on. Called first of all, before there are threads and contexts.
void install();

struct Use {
    /// Bytes that are in use now, and the most that ever were.
    std::size_t bytes, most;
    /// Blocks that are in use.
    std::size_t blocks;
};

Use use();

} // namespace studio::heap
