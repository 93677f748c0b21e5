//! What the library defines so that it needs no newer glibc than 2.28.

// The shared pointers of libstdc++, which OpenSubdiv's headers use, ask glibc 2.32 and later whether the process has one
// thread, to leave out atomic operations. With a definition of our own that says no they are always atomic. It is weak and
// hidden, so that no other library sees it.
#[cfg(all(target_os = "linux", target_env = "gnu"))]
std::arch::global_asm!(
    ".pushsection .data.__libc_single_threaded,\"aw\"",
    ".weak __libc_single_threaded",
    ".hidden __libc_single_threaded",
    "__libc_single_threaded:",
    ".byte 0",
    ".popsection",
);
