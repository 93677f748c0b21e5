// What a table keeps, shared by the shim's files.
#pragma once
#include "refine.h"

#include <memory>
#include <vector>

#include <opensubdiv/far/patchMap.h>
#include <opensubdiv/far/patchTableFactory.h>
#include <opensubdiv/far/stencilTableFactory.h>
#include <opensubdiv/far/topologyDescriptor.h>

struct rlv_osd_table {
    std::unique_ptr<OpenSubdiv::Far::TopologyRefiner> refiner;
    std::unique_ptr<OpenSubdiv::Far::PatchTable> table;
    int tile_count = 0;
    std::vector<rlv_osd_patch> patches;
    std::vector<int> indices;
    std::vector<int> stencil_sizes, stencil_indices;
    std::vector<double> stencil_weights;
};

// Copies text into a caller's buffer.
void rlv_osd_report(char* error, size_t size, const char* text);
