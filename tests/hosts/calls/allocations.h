// Counts what a program and the libraries it links ask the C library for: their calls of malloc and its kin come here.
#pragma once

#include <atomic>
#include <cerrno>
#include <cstddef>
#include <cstdint>

extern "C" {
// The C library's own, which glibc names so.
void *__libc_malloc(size_t bytes) noexcept;
void *__libc_calloc(size_t count, size_t bytes) noexcept;
void *__libc_realloc(void *old, size_t bytes) noexcept;
void *__libc_memalign(size_t alignment, size_t bytes) noexcept;
void __libc_free(void *old) noexcept;
}

struct Allocations {
    uint64_t count = 0;
    uint64_t bytes = 0;

    Allocations operator-(const Allocations &before) const { return {count - before.count, bytes - before.bytes}; }
};

inline std::atomic<uint64_t> allocation_count{0}, allocation_bytes{0};

/// All since the program began, of all threads.
inline Allocations allocations() { return {allocation_count, allocation_bytes}; }

inline void *counted(void *block, size_t bytes) {
    allocation_count.fetch_add(1, std::memory_order_relaxed);
    allocation_bytes.fetch_add(bytes, std::memory_order_relaxed);
    return block;
}

extern "C" {
void *malloc(size_t bytes) noexcept { return counted(__libc_malloc(bytes), bytes); }
void *calloc(size_t count, size_t bytes) noexcept { return counted(__libc_calloc(count, bytes), count * bytes); }
void *realloc(void *old, size_t bytes) noexcept { return counted(__libc_realloc(old, bytes), bytes); }
void *memalign(size_t alignment, size_t bytes) noexcept { return counted(__libc_memalign(alignment, bytes), bytes); }
void *aligned_alloc(size_t alignment, size_t bytes) noexcept { return counted(__libc_memalign(alignment, bytes), bytes); }
int posix_memalign(void **out, size_t alignment, size_t bytes) noexcept {
    *out = counted(__libc_memalign(alignment, bytes), bytes);
    return *out ? 0 : ENOMEM;
}
void free(void *old) noexcept { __libc_free(old); }
}
