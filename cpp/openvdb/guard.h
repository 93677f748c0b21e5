// What all calls into OpenVDB share: no exception leaves them, and grids go to files in one way.
#pragma once

#include <openvdb/io/File.h>
#include <openvdb/openvdb.h>

#include <cstdint>
#include <cstdio>
#include <exception>

namespace relievo {

inline void tell(char* message, std::size_t size, const char* what) {
    std::snprintf(message, size, "%s", what);
}

// What `call` returns, or `failed` and a message where it throws.
template <typename Value, typename Call>
Value guarded(Value failed, char* message, std::size_t message_size, const Call& call) {
    try {
        return call();
    } catch (const std::exception& error) {
        tell(message, message_size, error.what());
    } catch (...) {
        tell(message, message_size, "unknown exception");
    }
    return failed;
}

// Writes the only grid of a file, packed as OpenVDB is told to.
inline void store(const char* path, const openvdb::GridBase::Ptr& grid, std::uint32_t packing) {
    openvdb::io::File file(path);
    file.setCompression(packing);
    file.write({grid});
    file.close();
}

}  // namespace relievo
