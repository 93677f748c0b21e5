// Grids combined by set operations.

#include "guard.h"
#include "resample.h"

#include <openvdb/tools/Composite.h>
#include <openvdb/tools/Prune.h>

namespace {

using namespace openvdb;
using relievo::bounded, relievo::dispatch, relievo::give, relievo::refuse;

// Combines values where either grid has something.
template <typename Grid>
typename Grid::Ptr merged(const Grid& a, const Grid& b, std::int32_t operation) {
    using Value = typename Grid::ValueType;
    auto made = a.copyWithNewTree();
    const Value background = a.background();
    const auto both = [operation, background](CombineArgs<Value>& args) {
        const Value x = args.a(), y = args.b();
        if constexpr (std::is_integral_v<Value>) {
            // Bools and labels: what is not the background is inside.
            const bool in_x = x != background, in_y = y != background;
            if (operation == RLVDB_UNION) {
                args.setResult(in_x ? x : y);
                args.setResultIsActive(args.aIsActive() || args.bIsActive());
            } else {
                const bool is_kept = in_x && in_y == (operation == RLVDB_INTERSECTION);
                args.setResult(is_kept ? x : background);
                args.setResultIsActive(is_kept);
            }
        } else {
            args.setResult(operation == RLVDB_UNION          ? std::max(x, y)
                           : operation == RLVDB_INTERSECTION ? std::min(x, y)
                                                             : std::max(x - y, std::min(x, Value(0))));
            args.setResultIsActive(args.aIsActive() || args.bIsActive());
        }
    };
    made->tree().combine2Extended(a.tree(), b.tree(), both);
    tools::prune(made->tree());
    return made;
}

template <typename Grid>
typename Grid::Ptr combined(const Grid& a, const Grid& b, std::int32_t operation) {
    using Value = typename Grid::ValueType;
    if constexpr (std::is_same_v<Grid, MaskGrid>) {
        auto made = a.deepCopy();
        switch (operation) {
            case RLVDB_UNION: made->topologyUnion(b); break;
            case RLVDB_INTERSECTION: made->topologyIntersection(b); break;
            default: made->topologyDifference(b);
        }
        return made;
    } else {
        if constexpr (std::is_floating_point_v<Value>) {
            if (a.getGridClass() == GRID_LEVEL_SET) {
                switch (operation) {
                    case RLVDB_UNION: return tools::csgUnionCopy(a, b);
                    case RLVDB_INTERSECTION: return tools::csgIntersectionCopy(a, b);
                    default: return tools::csgDifferenceCopy(a, b);
                }
            }
        }
        return merged(a, b, operation);
    }
}

}  // namespace

extern "C" {

std::int32_t rlvdb_combine(const RlvdbGrid* a, const RlvdbGrid* b, std::int32_t operation, const RlvdbCall* call,
                           RlvdbGrid** out, RlvdbError* error) {
    return bounded(call, error, [&](relievo::Interrupter& interrupter) {
        if (operation < RLVDB_UNION || operation > RLVDB_DIFFERENCE) {
            refuse("an operation does not exist");
        }
        using Types = relievo::Scalars::Append<relievo::Masks>::Append<relievo::Integers>;
        dispatch<Types>(*a->grid, "combined", [&](const auto& first) {
            using Grid = std::decay_t<decltype(first)>;
            auto second = gridConstPtrCast<Grid>(b->grid);
            if (!second || first.getGridClass() != second->getGridClass()) {
                refuse("the grids are not of one kind and class");
            }
            if (first.transform() != second->transform()) {
                second = gridConstPtrCast<Grid>(relievo::resampled(*second, first.transform().copy(), 1, interrupter));
                interrupter.check();
            }
            give(out, combined(first, *second, operation));
        });
    });
}

}
