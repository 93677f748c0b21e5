#include "heap.hpp"

#include <relievo/relievo.hpp>

#include <algorithm>
#include <atomic>
#include <cstdlib>

namespace studio::heap {

namespace {

std::atomic<std::size_t> bytes{0}, most{0}, blocks{0};

void *allocate(void *, std::size_t size, std::size_t alignment) {
    // Sizes are multiples of the alignment for aligned_alloc, which takes none below that of a pointer.
    const std::size_t unit = std::max(alignment, sizeof(void *));
    void *const block = std::aligned_alloc(unit, (size + unit - 1) / unit * unit);
    if (block) {
        ++blocks;
        const std::size_t now = bytes += size;
        std::size_t before = most;
        while (before < now && !most.compare_exchange_weak(before, now)) {
        }
    }
    return block;
}

void release(void *, void *block, std::size_t size, std::size_t) {
    bytes -= size;
    --blocks;
    std::free(block);
}

} // namespace

void install() { relievo::set_allocator(allocate, release); }

Use use() { return {bytes, most, blocks}; }

} // namespace studio::heap
