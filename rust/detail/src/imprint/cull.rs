//! Conservative culling of a displaced surface against an overlap (Schäfer et al. 2014, Section 5, Culling Geometry
//! within Overlap): which tiles, and which blocks of 16 × 16 of their coefficients, may have points in the voxel grid.
//!
//! Tiles are found through the hierarchy, so that the cost does not grow with the scene. Of their patches the Bézier
//! hulls are bounded in voxel coordinates and widened by the tile's range of displacement along the cone of normals
//! (Sederberg and Meyers 1988). Patches larger than a block are cut along the blocks' borders first.

use std::ops::Range;

use glam::{DAffine3, DMat3, DVec3};
use relievo_core::simd::{Arithmetic, Level};
use relievo_core::{Context, dispatch_simd};
use relievo_surface::{PatchForm, PatchView};

use crate::channels::knots::block_edge;
use crate::geometry::grid::Grid;
use crate::geometry::hierarchy::Region;
use crate::geometry::obb::Obb;
use crate::geometry::voxel_frame::VoxelFrame;
use crate::imprint::culled::{Block, BlockList, CulledTile, left};
use crate::object::DisplacedObject;
use crate::object::fit::Reach;
use crate::object::ranges::range;
use crate::paint::ground::Ground;

/// The tiles and blocks that may have points in `grid`, ascending by the hierarchy's order.
pub fn cull(context: &Context, object: &mut DisplacedObject, grid: &Grid) -> Vec<CulledTile> {
    let frame = VoxelFrame::new(grid, &object.transform);
    let map = grid.map * object.transform;
    cull_frame(context, object, &frame, &map)
}

/// Parts of a box that count as a voxel where surfaces are culled against the box alone.
const PARTS: f64 = 64.0;

/// The tiles that may have points in `obb`, and which of their blocks of texels, where a tile has the size that `size`
/// says (Schäfer et al. 2015, Local Painting and Deformation of Meshes on the GPU, Section 3). With `start`, tiles that
/// had points in the box with that displacement are found as well.
pub(crate) fn cull_box(
    context: &Context,
    object: &mut DisplacedObject,
    obb: &Obb,
    size: impl Fn(&DisplacedObject, u32) -> u32 + Sync,
    start: Option<Ground<'_>>,
) -> Vec<CulledTile> {
    let scale = DMat3::from_diagonal(0.5 * PARTS / obb.half) * obb.axes.transpose();
    let map = DAffine3 { matrix3: scale, translation: 0.5 * PARTS - scale * obb.center } * object.transform;
    let center = object.transform.inverse().transform_point3(obb.center);
    let frame = VoxelFrame::of_map(&map, center, [PARTS as f32; 3]);
    let fit = object.follow(context, start);
    let mut found = context.scratch().list();
    fit.hierarchy().query(context, &Region::new(map, DVec3::ZERO, DVec3::splat(PARTS)), &mut found);
    let mut tiles = context.scratch().list::<(u32, Reach)>();
    tiles.extend(found.iter().map(|tile| (*tile, fit.reach(*tile))));
    let object = &*object;
    let mut culled = context.scratch().list();
    context.map_into(tiles.len(), &mut culled, |index| {
        let (tile, reach) = tiles[index];
        CulledTile { tile, blocks: blocks(context, object, &frame, tile, size(object, tile), reach) }
    });
    left(context, culled)
}

fn cull_frame(context: &Context, object: &mut DisplacedObject, frame: &VoxelFrame, map: &DAffine3) -> Vec<CulledTile> {
    let [least, most] = object.reach();
    let object = &*object;
    let reach = f64::from(most.max(-least) + object.longest());
    let rows = map.matrix3.transpose();
    let margin = DVec3::new(rows.x_axis.length(), rows.y_axis.length(), rows.z_axis.length()) * reach;
    let dims = DVec3::from(frame.dims.map(f64::from));
    let map = *map;
    let mut tiles = context.scratch().list();
    object.hierarchy.query(context, &Region::new(map, -margin, dims + margin), &mut tiles);
    let mut culled = context.scratch().list();
    context.map_into(tiles.len(), &mut culled, |index| {
        let tile = tiles[index];
        let field = object.displacement().field();
        let range = field.block(tile).map_or([0.0; 2], range);
        let length = object.vectors().map_or(0.0, |vectors| vectors.field().length(tile));
        let reach = Reach { range, length };
        CulledTile { tile, blocks: blocks(context, object, frame, tile, field.size(tile), reach) }
    });
    left(context, culled)
}

/// Every tile with every block: what imprints cost without culling.
pub fn everything(object: &DisplacedObject) -> Vec<CulledTile> {
    let field = object.displacement().field();
    let tiles = (0..field.tile_count() as u32).filter(|tile| !field.topology().is_hole(*tile));
    tiles
        .map(|tile| {
            let size = field.size(tile);
            let everywhere = |index| Block { index, low: [f32::NEG_INFINITY; 3], high: [f32::INFINITY; 3] };
            let blocks = (0..(size / block_edge(size)).pow(2)).map(everywhere).collect();
            CulledTile { tile, blocks: BlockList::Many(blocks) }
        })
        .collect()
}

/// The blocks of a tile that may have points in the grid.
fn blocks(
    context: &Context,
    object: &DisplacedObject,
    frame: &VoxelFrame,
    tile: u32,
    size: u32,
    reach: Reach,
) -> BlockList {
    let count = size / block_edge(size);
    let mut blocks = BlockList::new(context, count * count);
    for patch in object.surface.patches(tile) {
        mark(context.level(), &patch, frame, reach, count, blocks.blocks_mut());
    }
    blocks.retain(|block| block.low[0] <= block.high[0]);
    blocks
}

/// Widens the blocks of `count` × `count` in which the patch may have points in the grid.
fn mark(level: Level, patch: &PatchView<'_>, frame: &VoxelFrame, reach: Reach, count: u32, blocks: &mut [Block]) {
    let (low, size) = (patch.patch.low, patch.patch.size);
    let touched = |axis: usize| {
        let from = (low[axis] * count as f32) as u32;
        let to = ((low[axis] + size[axis]) * count as f32).ceil() as u32;
        from.min(count - 1)..to.clamp(from.min(count - 1) + 1, count)
    };
    let (columns, rows) = (touched(0), touched(1));
    let mut points = [[0.0f32; 20]; 3];
    let mut points_count = 0;
    for point in patch.points() {
        let place = frame.place(point);
        for axis in 0..3 {
            points[axis][points_count] = place[axis];
        }
        points_count += 1;
    }
    let spread = displacement(patch, frame, reach);
    let bounds = |values: &[f32], axis: usize| {
        let (low, high) = values
            .iter()
            .fold((f32::INFINITY, f32::NEG_INFINITY), |(low, high), value| (low.min(*value), high.max(*value)));
        (low + spread[axis].0, high + spread[axis].1)
    };
    let whole = [0, 1, 2].map(|axis| bounds(&points[axis][..points_count], axis));
    let (least, most) = (whole.map(|bounds| bounds.0), whole.map(|bounds| bounds.1));
    if !frame.meets(least, most) {
        return;
    }
    let single = columns.len() == 1 && rows.len() == 1;
    if single || patch.patch.form == PatchForm::Gregory {
        for v in rows {
            for u in columns.clone() {
                blocks[(v * count + u) as usize].grow(least, most);
            }
        }
        return;
    }
    let parts = |axis: usize, blocks: &Range<u32>| {
        let place = |border: u32| ((border as f32 / count as f32 - low[axis]) / size[axis]).clamp(0.0, 1.0);
        let mut parts = [[[0.0; MAX]; 4]; 4];
        for (at, block) in blocks.clone().enumerate() {
            for (weights, values) in parts.iter_mut().zip(restriction(place(block), place(block + 1))) {
                for (weight, value) in weights.iter_mut().zip(values) {
                    weight[at] = value;
                }
            }
        }
        parts
    };
    let (in_u, in_v) = (parts(0, &columns), parts(1, &rows));
    for (at, u) in columns.enumerate() {
        let mut bounds = [([0.0; MAX], [0.0; MAX]); 3];
        for (axis, bounds) in bounds.iter_mut().enumerate() {
            // Restricted along u: row by row, four points.
            let mut strip = [0.0f32; 16];
            for row in 0..4 {
                for (i, weights) in in_u.iter().enumerate() {
                    strip[4 * row + i] = (0..4).map(|k| weights[k][at] * points[axis][4 * row + k]).sum();
                }
            }
            *bounds = piece_bounds(level, &strip, &in_v);
        }
        for (at, v) in rows.clone().enumerate() {
            let least = [0, 1, 2].map(|axis| bounds[axis].0[at] + spread[axis].0);
            let most = [0, 1, 2].map(|axis| bounds[axis].1[at] + spread[axis].1);
            if frame.meets(least, most) {
                blocks[(v * count + u) as usize].grow(least, most);
            }
        }
    }
}

/// Blocks along an edge of a tile at most.
const MAX: usize = 16;

dispatch_simd! {
    /// The least and the largest of the control points of a strip's pieces along v, side by side. The strip has four
    /// points in each of four rows, the weights are those of [`restriction`] for every piece.
    fn piece_bounds = piece_bounds_body(
        strip: &[f32; 16], weights: &[[[f32; MAX]; 4]; 4]
    ) -> ([f32; MAX], [f32; MAX])
}

#[inline(always)]
fn piece_bounds_body<A: Arithmetic>(
    _: A,
    strip: &[f32; 16],
    weights: &[[[f32; MAX]; 4]; 4],
) -> ([f32; MAX], [f32; MAX]) {
    let (mut low, mut high) = ([f32::INFINITY; MAX], [f32::NEG_INFINITY; MAX]);
    for weights in weights {
        for i in 0..4 {
            for v in 0..MAX {
                let near = A::fma(weights[1][v], strip[4 + i], weights[0][v] * strip[i]);
                let value = near + A::fma(weights[3][v], strip[12 + i], weights[2][v] * strip[8 + i]);
                low[v] = low[v].min(value);
                high[v] = high[v].max(value);
            }
        }
    }
    (low, high)
}

/// How far displacements reach along each voxel axis, from the patch's cone of normals and the longest vector.
fn displacement(patch: &PatchView<'_>, frame: &VoxelFrame, reach: Reach) -> [(f32, f32); 3] {
    let Reach { range, length } = reach;
    if reach == Reach::default() {
        return [(0.0, 0.0); 3];
    }
    let cone = patch.normals();
    frame.rows.map(|row| {
        let (least, most) = cone.span(row);
        let ends = [range[0] * least, range[0] * most, range[1] * least, range[1] * most];
        let around = length * (row[0] * row[0] + row[1] * row[1] + row[2] * row[2]).sqrt();
        let least = ends.into_iter().fold(f32::INFINITY, f32::min);
        (least - around, ends.into_iter().fold(f32::NEG_INFINITY, f32::max) + around)
    })
}

/// The cubic Bézier points of a curve's part from `a` to `b` as weights of the curve's own points, by blossoming.
fn restriction(a: f32, b: f32) -> [[f32; 4]; 4] {
    [[a, a, a], [a, a, b], [a, b, b], [b, b, b]].map(|[r, s, t]| {
        let (r1, s1, t1) = (1.0 - r, 1.0 - s, 1.0 - t);
        [r1 * s1 * t1, r * s1 * t1 + r1 * s * t1 + r1 * s1 * t, r * s * t1 + r * s1 * t + r1 * s * t, r * s * t]
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_restricted_curve_ends_where_it_is_cut() {
        let curve = [0.0f32, 1.0, -1.0, 2.0];
        let value = |points: [f32; 4], t: f32| {
            let s = 1.0 - t;
            s * s * s * points[0] + 3.0 * s * s * t * points[1] + 3.0 * s * t * t * points[2] + t * t * t * points[3]
        };
        let part = restriction(0.25, 0.75).map(|weights| (0..4).map(|k| weights[k] * curve[k]).sum::<f32>());
        for t in [0.0, 0.3, 1.0] {
            assert!((value(part, t) - value(curve, 0.25 + 0.5 * t)).abs() < 1e-6);
        }
    }
}
