// Grids of other kinds: other values, fog, level sets, labels.

#include "guard.h"

#include <openvdb/tools/LevelSetRebuild.h>
#include <openvdb/tools/LevelSetUtil.h>
#include <openvdb/tools/Prune.h>
#include <openvdb/tools/TopologyToLevelSet.h>
#include <openvdb/tools/ValueTransformer.h>

namespace {

using namespace openvdb;
using relievo::bounded, relievo::components, relievo::dispatch, relievo::give, relievo::refuse;
using Watch = util::NullInterrupter;

template <typename Grid>
constexpr bool is_mask = std::is_same_v<Grid, BoolGrid> || std::is_same_v<Grid, MaskGrid>;

// A grid of another kind with the topology of `grid`.
template <typename To, typename From>
typename To::Ptr converted(const From& grid) {
    using Out = typename To::ValueType;
    using In = typename From::ValueType;
    const auto with = [&](typename To::TreeType::Ptr tree) {
        auto made = To::create(tree);
        made->insertMeta(grid);
        made->setTransform(grid.transform().copy());
        return made;
    };
    if constexpr (std::is_same_v<To, From>) {
        return grid.deepCopy();
    } else if constexpr (std::is_same_v<To, MaskGrid>) {
        return with(MaskTree::Ptr(new MaskTree(grid.tree(), false, TopologyCopy())));
    } else if constexpr (std::is_same_v<To, BoolGrid>) {
        return with(BoolTree::Ptr(new BoolTree(grid.tree(), false, true, TopologyCopy())));
    } else if constexpr (is_mask<From> && components<Out> == 1) {
        auto made = with(typename To::TreeType::Ptr(
            new typename To::TreeType(grid.tree(), Out(0), Out(1), TopologyCopy())));
        if constexpr (std::is_same_v<From, BoolGrid>) {
            // An active voxel may be false.
            tools::foreach(made->beginValueOn(), [&grid](const auto& at) {
                at.setValue(Out(grid.tree().getValue(at.getCoord()) ? 1 : 0));
            });
        }
        return made;
    } else if constexpr (components<In> == 3 && components<Out> == 3) {
        // Trees of vectors have no conversion of their own.
        auto made = with(typename To::TreeType::Ptr(
            new typename To::TreeType(grid.tree(), Out(grid.background()), TopologyCopy())));
        tools::foreach(made->beginValueOn(), [&grid](const auto& at) {
            at.setValue(Out(grid.tree().getValue(at.getCoord())));
        });
        return made;
    } else if constexpr (!is_mask<From> && components<In> == components<Out>) {
        return with(typename To::TreeType::Ptr(new typename To::TreeType(grid.tree())));
    } else {
        refuse("scalars and vectors cannot be converted to one another");
    }
}

template <typename From>
GridBase::Ptr converted(const From& grid, std::int32_t kind) {
    switch (kind) {
        case RLVDB_FLOAT: return converted<FloatGrid>(grid);
        case RLVDB_DOUBLE: return converted<DoubleGrid>(grid);
        case RLVDB_BOOL: return converted<BoolGrid>(grid);
        case RLVDB_MASK: return converted<MaskGrid>(grid);
        case RLVDB_INT32: return converted<Int32Grid>(grid);
        case RLVDB_INT64: return converted<Int64Grid>(grid);
        case RLVDB_VEC3S: return converted<Vec3SGrid>(grid);
        case RLVDB_VEC3D: return converted<Vec3DGrid>(grid);
        case RLVDB_VEC3I: return converted<Vec3IGrid>(grid);
        default: refuse("a kind of grids does not exist");
    }
}

}  // namespace

extern "C" {

std::int32_t rlvdb_convert(const RlvdbGrid* handle, std::int32_t kind, const RlvdbCall* call, RlvdbGrid** out,
                           RlvdbError* error) {
    return bounded(call, error, [&](relievo::Interrupter&) {
        dispatch<relievo::Kinds>(*handle->grid, "converted", [&](const auto& grid) { give(out, converted(grid, kind)); });
    });
}

std::int32_t rlvdb_to_fog(const RlvdbGrid* handle, const RlvdbCall* call, RlvdbGrid** out, RlvdbError* error) {
    return bounded(call, error, [&](relievo::Interrupter&) {
        dispatch<relievo::Scalars>(*handle->grid, "made fog", [&](const auto& grid) {
            if (grid.getGridClass() != GRID_LEVEL_SET) {
                refuse("the grid is not a level set");
            }
            auto made = grid.deepCopy();
            tools::sdfToFogVolume(*made);
            give(out, made);
        });
    });
}

std::int32_t rlvdb_to_level_set(const RlvdbGrid* handle, double value, float band, const RlvdbCall* call,
                                RlvdbGrid** out, RlvdbError* error) {
    return bounded(call, error, [&](relievo::Interrupter& interrupter) {
        using Types = relievo::Scalars::Append<relievo::Masks>;
        dispatch<Types>(*handle->grid, "made a level set", [&](const auto& grid) {
            using Grid = std::decay_t<decltype(grid)>;
            if constexpr (is_mask<Grid>) {
                const int half = static_cast<int>(std::clamp(band, 1.0f, 100.0f));
                auto made = tools::topologyToLevelSet(grid, half, 1, 0, 0, static_cast<Watch*>(&interrupter));
                interrupter.check();
                give(out, made);
            } else {
                auto made = tools::levelSetRebuild(grid, static_cast<float>(value), band, band, nullptr,
                                                   static_cast<Watch*>(&interrupter));
                interrupter.check();
                give(out, made);
            }
        });
    });
}

std::int32_t rlvdb_labels(const RlvdbGrid* const* level_sets, const std::int32_t* labels, std::size_t count,
                          const RlvdbCall* call, RlvdbGrid** out, RlvdbError* error) {
    return bounded(call, error, [&](relievo::Interrupter& interrupter) {
        auto made = Int32Grid::create(0);
        made->setName("labels");
        for (std::size_t index = 0; index < count; ++index) {
            interrupter.check(static_cast<int>(100 * index / count));
            const auto level_set = gridConstPtrCast<FloatGrid>(level_sets[index]->grid);
            if (!level_set || level_set->getGridClass() != GRID_LEVEL_SET) {
                refuse("labels are made of level sets of floats");
            }
            if (index == 0) {
                made->setTransform(level_set->transform().copy());
            } else if (made->transform() != level_set->transform()) {
                refuse("the level sets have different transforms");
            }
            const auto inside = tools::sdfInteriorMask(*level_set);
            Int32Tree part(inside->tree(), 0, labels[index], TopologyCopy());
            made->tree().combine2Extended(Int32Tree(made->tree()), part, [](CombineArgs<std::int32_t>& args) {
                args.setResult(args.bIsActive() ? args.b() : args.a());
                args.setResultIsActive(args.aIsActive() || args.bIsActive());
            });
        }
        tools::prune(made->tree());
        give(out, made);
    });
}

std::int32_t rlvdb_label_mask(const RlvdbGrid* handle, std::int64_t label, const RlvdbCall* call, RlvdbGrid** out,
                              RlvdbError* error) {
    return bounded(call, error, [&](relievo::Interrupter&) {
        dispatch<relievo::Integers>(*handle->grid, "read as labels", [&](const auto& grid) {
            auto made = MaskGrid::create();
            made->setTransform(grid.transform().copy());
            made->setName(grid.getName());
            auto accessor = made->getAccessor();
            for (auto at = grid.cbeginValueOn(); at; ++at) {
                if (at.getValue() != label) {
                    continue;
                }
                if (at.isVoxelValue()) {
                    accessor.setValueOn(at.getCoord());
                } else {
                    CoordBBox box;
                    at.getBoundingBox(box);
                    made->sparseFill(box, true, true);
                }
            }
            give(out, made);
        });
    });
}

}
