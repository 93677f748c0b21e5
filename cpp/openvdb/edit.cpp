// Grids made of grids: set operations, offsets, filters, resampling, other kinds of values, labels.

#include "guard.h"

#include <openvdb/tools/Composite.h>
#include <openvdb/tools/Filter.h>
#include <openvdb/tools/GridTransformer.h>
#include <openvdb/tools/LevelSetFilter.h>
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

// An empty grid with the background, the class and the metadata of another, and a transform.
template <typename Grid>
typename Grid::Ptr like(const Grid& grid, const math::Transform::Ptr& transform) {
    auto made = grid.copyWithNewTree();
    made->setTransform(transform);
    return made;
}

// Resamples a grid; masks go by way of bools, which the sampler knows.
template <typename Grid>
typename Grid::Ptr resampled(const Grid& grid, const math::Transform::Ptr& transform, std::uint32_t order,
                             relievo::Interrupter& interrupter) {
    if constexpr (std::is_same_v<Grid, MaskGrid>) {
        BoolGrid bools(BoolTree::Ptr(new BoolTree(grid.tree(), false, true, TopologyCopy())));
        bools.setTransform(grid.transform().copy());
        const auto made = resampled(bools, transform, 0, interrupter);
        auto mask = like(grid, transform);
        mask->tree().topologyUnion(made->tree());
        return mask;
    } else {
        using Value = typename Grid::ValueType;
        constexpr bool is_smooth = std::is_floating_point_v<Value> || std::is_same_v<Grid, Vec3SGrid> || std::is_same_v<Grid, Vec3DGrid>;
        auto made = like(grid, transform);
        Watch& watch = interrupter;
        if constexpr (is_smooth) {
            if (order == 1) {
                tools::resampleToMatch<tools::BoxSampler>(grid, *made, watch);
                return made;
            }
        }
        if constexpr (std::is_floating_point_v<Value>) {
            if (order == 2) {
                tools::resampleToMatch<tools::QuadraticSampler>(grid, *made, watch);
                return made;
            }
        }
        tools::resampleToMatch<tools::PointSampler>(grid, *made, watch);
        return made;
    }
}

// Combines values where either grid has something.
template <typename Grid>
typename Grid::Ptr merged(const Grid& a, const Grid& b, std::int32_t operation) {
    using Value = typename Grid::ValueType;
    auto made = like(a, a.transform().copy());
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

// Throws unless the grid is a level set that its tracker can follow.
template <typename Grid>
void demand_level_set(const Grid& grid) {
    if (grid.getGridClass() != GRID_LEVEL_SET || !grid.hasUniformVoxels()) {
        refuse("the grid is not a level set with cubic voxels; make one of it first");
    }
}

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

template <typename Grid>
void smooth_level_set(Grid& grid, std::int32_t filter, int width, std::uint32_t iterations, relievo::Interrupter& interrupter) {
    tools::LevelSetFilter<Grid, Grid, Watch> filters(grid, &interrupter);
    for (std::uint32_t step = 0; step < iterations; ++step) {
        interrupter.check(static_cast<int>(100 * std::uint64_t(step) / iterations));
        switch (filter) {
            case RLVDB_MEAN: filters.mean(width); break;
            case RLVDB_GAUSSIAN: filters.gaussian(width); break;
            case RLVDB_MEDIAN: filters.median(width); break;
            case RLVDB_LAPLACIAN: filters.laplacian(); break;
            case RLVDB_MEAN_CURVATURE: filters.meanCurvature(); break;
            default: refuse("a filter does not exist");
        }
    }
}

template <typename Grid>
void smooth_values(Grid& grid, std::int32_t filter, int width, int iterations, relievo::Interrupter& interrupter) {
    tools::Filter<Grid, Grid, Watch> filters(grid, &interrupter);
    switch (filter) {
        case RLVDB_MEAN: filters.mean(width, iterations); break;
        case RLVDB_GAUSSIAN: filters.gaussian(width, iterations); break;
        case RLVDB_MEDIAN: filters.median(width, iterations); break;
        default: refuse("this filter is for level sets alone");
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
                second = resampled(*second, first.transform().copy(), 1, interrupter);
                interrupter.check();
            }
            give(out, combined(first, *second, operation));
        });
    });
}

std::int32_t rlvdb_offset(const RlvdbGrid* handle, double distance, const RlvdbCall* call, RlvdbGrid** out,
                          RlvdbError* error) {
    return bounded(call, error, [&](relievo::Interrupter& interrupter) {
        dispatch<relievo::Scalars>(*handle->grid, "offset", [&](const auto& grid) {
            using Grid = std::decay_t<decltype(grid)>;
            demand_level_set(grid);
            auto made = grid.deepCopy();
            tools::LevelSetFilter<Grid, Grid, Watch> filter(*made, &interrupter);
            // OpenVDB adds the number to the values, which moves the surface inwards.
            filter.offset(static_cast<typename Grid::ValueType>(-distance));
            interrupter.check();
            give(out, made);
        });
    });
}

std::int32_t rlvdb_filter(const RlvdbGrid* handle, std::int32_t filter, std::uint32_t width, std::uint32_t iterations,
                          const RlvdbCall* call, RlvdbGrid** out, RlvdbError* error) {
    return bounded(call, error, [&](relievo::Interrupter& interrupter) {
        dispatch<relievo::Scalars>(*handle->grid, "filtered", [&](const auto& grid) {
            auto made = grid.deepCopy();
            const int radius = static_cast<int>(std::min<std::uint32_t>(width, 1 << 10));
            if (grid.getGridClass() == GRID_LEVEL_SET) {
                demand_level_set(grid);
                smooth_level_set(*made, filter, radius, iterations, interrupter);
            } else {
                smooth_values(*made, filter, radius, static_cast<int>(std::min<std::uint32_t>(iterations, 1 << 10)), interrupter);
            }
            interrupter.check();
            give(out, made);
        });
    });
}

std::int32_t rlvdb_resample(const RlvdbGrid* handle, const double* matrix, std::uint32_t order, const RlvdbCall* call,
                            RlvdbGrid** out, RlvdbError* error) {
    return bounded(call, error, [&](relievo::Interrupter& interrupter) {
        const auto transform = relievo::transform_of(matrix);
        dispatch<relievo::Kinds>(*handle->grid, "resampled", [&](const auto& grid) {
            auto made = resampled(grid, transform, order, interrupter);
            interrupter.check();
            give(out, made);
        });
    });
}

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
