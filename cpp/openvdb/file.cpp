// Grids of files. Files were checked by the caller, which knows how much memory reading one takes.

#include "guard.h"

#include <openvdb/io/File.h>
#include <openvdb/io/Stream.h>

#include <fstream>

namespace {

using namespace openvdb;
using relievo::bounded;

}  // namespace

extern "C" {

std::int32_t rlvdb_read(const char* path, const char* unique_name, const double* box, const RlvdbCall* call,
                        RlvdbGrid** out, RlvdbError* error) {
    return bounded(call, error, [&](relievo::Interrupter&) {
        io::File file(path);
        // Values that are loaded later would follow a file that somebody may have changed by then.
        file.open(/*delayLoad=*/false);
        if (!file.hasGrid(unique_name)) {
            throw relievo::Failure(RLVDB_NOT_FOUND, std::string("the file has no grid ") + unique_name);
        }
        BBoxd bounds;
        if (box) {
            bounds = BBoxd(Vec3d(box[0], box[1], box[2]), Vec3d(box[3], box[4], box[5]));
        }
        auto grid = file.readGrid(unique_name, bounds);
        file.close();
        relievo::dispatch<relievo::Kinds>(*grid, "read", [](const auto&) {});
        relievo::give(out, grid);
    });
}

std::int32_t rlvdb_write(const char* path, const RlvdbGrid* const* grids, std::size_t count, std::uint32_t packing,
                         const char* const* metadata, std::size_t metadata_count, const RlvdbCall* call,
                         RlvdbError* error) {
    return bounded(call, error, [&](relievo::Interrupter&) {
        GridCPtrVec list;
        for (std::size_t index = 0; index < count; ++index) {
            list.push_back(grids[index]->grid);
        }
        MetaMap entries;
        for (std::size_t index = 0; index < metadata_count; ++index) {
            const char* const* entry = metadata + 3 * index;
            entries.insertMeta(entry[0], *relievo::metadata_of(entry[1], entry[2]));
        }
        const std::uint32_t flags = packing & (RLVDB_ZIP | RLVDB_ACTIVE | RLVDB_BLOSC);
        if (packing & RLVDB_STREAM) {
            std::ofstream out(path, std::ios::binary);
            io::Stream stream(out);
            stream.setCompression(flags);
            stream.write(list, entries);
            out.close();
            if (!out) {
                throw std::runtime_error("the file could not be written");
            }
        } else {
            io::File file(path);
            file.setCompression(flags);
            file.write(list, entries);
            file.close();
        }
    });
}

}
