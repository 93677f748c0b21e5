//! What coarser tiles around a tile add to its colours near its edges, as lists that a graphics device reads.
//!
//! [`Field::color`] shifts what a tile has itself near edges where a coarser tile rules (see [`crate::quads::filter`]). Along an
//! edge that shift is a polygon: both sides are straight between texels, whose middles, and the middles between them,
//! are at whole numbers of halves of the finer side's texels.

use glam::Vec4;

use crate::quads::field::Field;
use crate::texel::ColorTexel;

/// Texels from an edge within which what rules there is seen; less and less towards the last.
pub const SEAM_REACH: u32 = 4;

impl<T: ColorTexel> Field<T> {
    /// What is added to the colours of `tile` at its four corners, then along each of its edges at `2 · size + 1` points
    /// from its start, ends included, where it has `size` texels; `None` where no coarser tile is around.
    ///
    /// Let `w_e` be 1 at edge e and fall to 0 within [`SEAM_REACH`] texels. At a place that is at `t_e` along edge e,
    /// the sum of `w_e` times the list of e at `t_e` is added, less that of `w_c w_(c−1)` times what corner c has.
    ///
    /// # Panics
    /// If there is no such tile.
    pub fn seams(&self, tile: u32) -> Option<Vec<Vec4>> {
        let uneven = self.uneven(tile);
        if uneven == 0 {
            return None;
        }
        let steps = 2 * self.size(tile);
        let corners = (0..4).map(|corner| self.corner_shift(tile, corner, 0.0, uneven));
        let at = |edge: u8, k: u32| self.edge_shift(tile, edge, k as f32 / steps as f32, 0.0, uneven);
        Some(corners.chain((0..4).flat_map(|edge| (0..=steps).map(move |k| at(edge, k)))).collect())
    }
}

#[cfg(test)]
mod tests {
    use std::sync::Arc;

    use relievo_core::Context;
    use relievo_surface::{Place, TileTopology};
    use relievo_testing::{Random, grid};

    use super::*;
    use crate::quads::filter::bilinear;
    use crate::{Channel, ChannelOptions, Rgba16, Sets};

    #[test]
    fn lists_say_what_colours_add_at_any_place() {
        let topology = Arc::new(TileTopology::new(&grid(3, true, &[2, 3, 0, 2, 1], false)).unwrap());
        let sizes = (0..topology.face_count() as u32).map(|face| (face, [64, 8, 16, 32][face as usize * 3 % 4]));
        let options = ChannelOptions { face_sizes: sizes.collect(), ..ChannelOptions::default() };
        let mut channel = Channel::<Rgba16>::of_color(topology, Vec4::splat(0.5), &options).unwrap();
        let tiles: Vec<u32> = (0..channel.field().tile_count() as u32).filter(|tile| tile % 4 != 3).collect();
        channel.apply(&Sets { allocate: tiles.clone(), ..Sets::default() }).unwrap();
        let mut random = Random(3);
        let context = Context::serial();
        let seed = random.below(1 << 20) as u64;
        let changes = channel.edit(&context, &tiles, |tile, texels| {
            let mut random = Random(seed + u64::from(tile));
            for j in 0..texels.size() {
                texels.row_mut(j).fill_with(|| Rgba16::of_color(Vec4::splat(random.unit())));
            }
        });
        channel.settle(&context, &changes.unwrap()).unwrap();
        let field = channel.field();
        let mut found = 0;
        for tile in 0..field.tile_count() as u32 {
            let Some(list) = field.seams(tile) else { continue };
            found += 1;
            let size = field.size(tile);
            for _ in 0..200 {
                let [u, v] = [0, 1].map(|_| (random.unit() * 1.2 - 0.1).clamp(0.0, 1.0));
                let weight = |away: f32| (1.0 - away * size as f32 / SEAM_REACH as f32).max(0.0);
                let weights = [v, 1.0 - u, 1.0 - v, u].map(weight);
                let place = Place::new(tile, u, v);
                let blank = field.blank().color();
                let mut sum = field.block(tile).map_or(blank, |block| bilinear(block, place, size));
                for (edge, t) in [u, v, 1.0 - u, 1.0 - v].into_iter().enumerate() {
                    let x = t * 2.0 * size as f32;
                    let k = (x as usize).min(2 * size as usize - 1);
                    let at = 4 + edge * (2 * size as usize + 1) + k;
                    sum += list[at].lerp(list[at + 1], x - k as f32) * weights[edge];
                    sum -= list[edge] * weights[edge] * weights[(edge + 3) & 3];
                }
                let expected = field.color(place);
                assert!((sum - expected).abs().max_element() < 1e-5, "{place:?}: {sum} {expected}");
            }
        }
        assert!(found > 3, "{found}");
    }
}
