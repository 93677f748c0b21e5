//! Triangles of single tiles of a displaced surface, for pictures in which few tiles change from frame to frame: every
//! tile a grid, its borders refined to what both sides need, so that no cracks open between tiles of different rates.
//!
//! A tile of rate r has (r−1)² inner points. Along an edge both sides use the larger of their rates (a quad beside two
//! sub-tiles counts theirs twice, for each has half of the edge), and points there are the canonical ones, equal to the
//! bit from both sides. The strip between the inner points and the border is stitched by parameter.

use relievo_core::{Context, Result};
use relievo_surface::{Grid, Link, Place, Placement, TileTopology};
use relievo_tiles::{Displaced, Points};

use crate::state::coat::Coat;

/// Quads along a side of every tile, powers of two from 2 up.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Rates(Vec<u32>);

/// The triangles of a tile.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Piece {
    /// Positions in object space: the inner points row by row, then the border from corner 0 around.
    pub points: Vec<[f32; 3]>,
    /// Colours, linear Rec.709; none if it has no coat.
    pub colors: Vec<[f32; 3]>,
    /// Unit normals.
    pub normals: Vec<[f32; 3]>,
    /// Triangles, counter-clockwise from the front.
    pub triangles: Vec<[u32; 3]>,
    /// Per triangle the edges that are not diagonals of quads, bit e for the edge from corner e to the next.
    pub edges: Vec<u8>,
    /// How many of the points, at the end, are on the border.
    pub border: usize,
}

impl Rates {
    /// Tiles with displacement or a coat get one quad per texel but at most `most`, others `coarse`; sub-tiles half of
    /// it.
    pub fn new(displaced: &Displaced, coat: Option<&Coat>, coarse: u32, most: u32) -> Self {
        let field = displaced.field();
        let topology = field.topology();
        let rate = |tile: u32| {
            let coarse = (coarse >> u32::from(topology.is_sub(tile))).max(2).next_power_of_two();
            let displacement = field.is_allocated(tile).then(|| field.size(tile));
            let vectors =
                displaced.vectors().filter(|vectors| vectors.is_allocated(tile)).map(|field| field.size(tile));
            let wanted = displacement
                .max(vectors)
                .max(coat.and_then(|coat| coat.size(tile)))
                .map_or(coarse, |size| size.min(most).max(coarse));
            wanted.next_power_of_two()
        };
        Self((0..field.tile_count() as u32).map(rate).collect())
    }

    /// Divides every tile as finely as `other` does too.
    pub fn refine(&mut self, other: &Self) {
        self.0.iter_mut().zip(&other.0).for_each(|(rate, other)| *rate = (*rate).max(*other));
    }

    /// All rates, by tile.
    pub fn as_slice(&self) -> &[u32] {
        &self.0
    }

    /// Quads along a side of `tile`.
    pub fn of(&self, tile: u32) -> u32 {
        self.0.get(tile as usize).copied().unwrap_or(0)
    }

    /// Segments along an edge of `tile`.
    fn edge(&self, topology: &TileTopology, tile: u32, edge: u8) -> u32 {
        let own = self.of(tile);
        match topology.link(tile, edge) {
            Link::Boundary => own,
            Link::Whole { side, .. } => own.max(self.of(side.tile)),
            Link::Halves { first, second, .. } => own.max(2 * self.of(first.tile).max(self.of(second.tile))),
            // The quad's own edge decides, which looks at both halves.
            Link::Half { side, .. } => self.edge(topology, side.tile, side.edge) / 2,
            Link::Pinned { edge } => {
                topology.pinned_sides(edge).map(|side| self.of(side.tile)).max().unwrap_or(own).max(own)
            }
        }
    }

    /// The rates along all four edges of `tile`.
    pub fn edges(&self, topology: &TileTopology, tile: u32) -> [u32; 4] {
        [0, 1, 2, 3].map(|edge| self.edge(topology, tile, edge))
    }
}

/// Cosine of the angle from which the normals on both sides of an edge show a sharp edge, not rounding.
const SHARP: f32 = 0.94;

/// The triangles of `tile`, none for a hole and where `rates` has no such tile.
///
/// # Errors
/// Fails with `Invalid` if `rates` are those of another surface and have a place that is not on this one.
pub fn tile(context: &Context, displaced: &Displaced, coat: Option<&Coat>, rates: &Rates, tile: u32) -> Result<Piece> {
    let topology = displaced.field().topology();
    let rate = rates.of(tile);
    if rate < 2 || topology.is_hole(tile) {
        return Ok(Piece::default());
    }
    let edges = rates.edges(topology, tile);
    let inner = rate - 1;
    let grid = Grid { size: rate, placement: Placement::Lattice, columns: 1..rate, rows: 1..rate };
    let mut points = Points::default();
    displaced.grid(context, tile, &grid, &mut points)?;
    let places: Vec<Place> = edges
        .iter()
        .zip(0..)
        .flat_map(|(count, edge)| {
            (0..*count).map(move |k| Place::on_edge(tile, edge, (f64::from(k) / f64::from(*count)) as f32))
        })
        .collect();
    let mut border = Points::default();
    displaced.evaluate(context, &places, &mut border)?;
    let mut own = Points::default();
    displaced.evaluate_in_place(context, &places, &mut own)?;
    for (normal, own) in border.normal.iter_mut().zip(own.normal) {
        if glam::Vec3::from(*normal).dot(own.into()) < SHARP {
            *normal = own;
        }
    }
    let mut piece = Piece { points: points.p, normals: points.normal, border: places.len(), ..Piece::default() };
    if let Some(coat) = coat {
        let at = |i: u32| i as f32 / rate as f32;
        let inner = (1..rate).flat_map(|j| (1..rate).map(move |i| Place::new(tile, at(i), at(j))));
        piece.colors = inner.chain(places.iter().copied()).map(|place| coat.color(place)).collect();
    }
    let first_border = piece.points.len() as u32;
    piece.points.extend(border.p);
    piece.normals.extend(border.normal);

    let at = |i: u32, j: u32| (j - 1) * inner + i - 1;
    for j in 1..rate - 1 {
        for i in 1..rate - 1 {
            let quad = [at(i, j), at(i + 1, j), at(i + 1, j + 1), at(i, j + 1)];
            piece.triangles.extend([[quad[0], quad[1], quad[2]], [quad[0], quad[2], quad[3]]]);
            piece.edges.extend([0b011, 0b110]);
        }
    }
    let mut start = first_border;
    for (edge, count) in edges.iter().enumerate() {
        // Inner point k of the row beside this edge, counted along the edge.
        let row = |k: u32| match edge {
            0 => at(k, 1),
            1 => at(inner, k),
            2 => at(rate - k, inner),
            _ => at(1, rate - k),
        };
        let total = piece.border as u32;
        let outer = |k: u32| first_border + (start - first_border + k) % total;
        stitch(&mut piece, rate, *count, row, outer);
        start += count;
    }
    Ok(piece)
}

/// Triangles between inner points 1 to `rate − 1` and border points 0 to `count`, in order of their parameters.
fn stitch(piece: &mut Piece, rate: u32, count: u32, row: impl Fn(u32) -> u32, outer: impl Fn(u32) -> u32) {
    let (mut i, mut k) = (1, 0);
    while k < count || i < rate - 1 {
        // Middle of the next step on either side, in units of 1 / (2 · rate · count).
        let outer_next = (2 * k + 1) * rate;
        let inner_next = (2 * i + 1) * count;
        if k < count && (i == rate - 1 || outer_next <= inner_next) {
            piece.triangles.push([outer(k), outer(k + 1), row(i)]);
            // The outer edge shows; of the two others, lines that meet the border where the grid's lines do.
            let line = |k: u32| k * rate == i * count;
            piece.edges.push(0b001 | if line(k + 1) { 0b010 } else { 0 } | if line(k) { 0b100 } else { 0 });
            k += 1;
        } else {
            piece.triangles.push([row(i), outer(k), row(i + 1)]);
            let line = |i: u32| k * rate == i * count;
            piece.edges.push(0b100 | if line(i) { 0b001 } else { 0 } | if line(i + 1) { 0b010 } else { 0 });
            i += 1;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::collections::HashMap;

    use crate::format::placement::Up;
    use crate::state::shapes::Shape;
    use half::f16;
    use relievo_surface::{Surface, SurfaceOptions};
    use relievo_tiles::{Displacement, DisplacementOptions, Sets};

    fn displacement(context: &Context, surface: &Surface, tiles: &[u32]) -> Displacement {
        let options = DisplacementOptions { size: 16, ..DisplacementOptions::default() };
        let mut displacement = Displacement::new(surface.topology().clone(), &options).unwrap();
        let sets = Sets { allocate: tiles.to_vec(), ..Sets::default() };
        let mut changes = displacement.apply(&sets).unwrap().changes;
        let edit = displacement.edit(context, tiles, |_, texels| {
            for j in 0..texels.size() {
                for (i, value) in texels.row_mut(j).iter_mut().enumerate() {
                    *value = f16::from_f32(0.01 * ((i * 7 + j * 3) % 5) as f32);
                }
            }
        });
        changes.extend(edit.unwrap());
        displacement.settle(context, &changes).unwrap();
        displacement
    }

    /// How often the edges between the positions of all pieces are used, forward by 1 and backward by 1000.
    fn edge_uses(context: &Context, displaced: &Displaced, rates: &Rates) -> Vec<i32> {
        let mut edges = HashMap::new();
        for index in 0..displaced.field().tile_count() as u32 {
            let piece = tile(context, displaced, None, rates, index).unwrap();
            // Adding zero turns −0 into +0, which is the same place.
            let at = |corner: u32| piece.points[corner as usize].map(|value| (value + 0.0).to_bits());
            for [a, b, c] in &piece.triangles {
                for (a, b) in [(at(*a), at(*b)), (at(*b), at(*c)), (at(*c), at(*a))] {
                    *edges.entry((a.min(b), a.max(b))).or_default() += if a < b { 1 } else { 1000 };
                }
            }
        }
        edges.into_values().collect()
    }

    #[test]
    fn displaced_surfaces_with_tiles_of_all_kinds_are_watertight() {
        let context = Context::serial();
        // Quads only, and triangles and quads beside each other, which makes sub-tiles.
        let shapes = [
            Shape::Box { size: [1.0; 3], faces: 2 },
            Shape::Cylinder { radius: 0.5, width: 0.4, segments: 6 },
            Shape::Sphere { radius: 1.0, faces: 3 },
        ];
        for shape in shapes {
            let cage = shape.mesh(Up::Z);
            let surface = Surface::new(&context, &cage, &SurfaceOptions::default()).unwrap();
            let displacement = displacement(&context, &surface, &[0, 5, 7]);
            let displaced = Displaced::new(&surface, displacement.field()).unwrap();
            for (coarse, most) in [(2, 16), (4, 64), (8, 4)] {
                let rates = Rates::new(&displaced, None, coarse, most);
                let open = edge_uses(&context, &displaced, &rates).into_iter().filter(|uses| *uses != 1001).count();
                assert_eq!(open, 0, "{shape:?} {coarse} {most}");
            }
        }
    }

    #[test]
    fn an_equal_rate_makes_two_triangles_per_quad_and_marks_no_diagonal_twice() {
        let context = Context::serial();
        let cage = Shape::Plane { size: [1.0; 2], faces: 3 }.mesh(Up::Z);
        let surface = Surface::new(&context, &cage, &SurfaceOptions::default()).unwrap();
        let displacement = Displacement::new(surface.topology().clone(), &DisplacementOptions::default()).unwrap();
        let displaced = Displaced::new(&surface, displacement.field()).unwrap();
        let rates = Rates::new(&displaced, None, 8, 8);
        let piece = tile(&context, &displaced, None, &rates, 4).unwrap();
        assert_eq!(piece.triangles.len(), 128);
        assert_eq!(piece.points.len(), 81);
        // Every quad has one diagonal, which both its triangles leave unmarked.
        let unmarked: u32 = piece.edges.iter().map(|edges| 3 - edges.count_ones()).sum();
        assert_eq!(unmarked, 128);
        let area: f32 = piece
            .triangles
            .iter()
            .map(|t| {
                let [a, b, c] = t.map(|corner| glam::Vec3::from(piece.points[corner as usize]));
                (b - a).cross(c - a).z * 0.5
            })
            .sum();
        assert!((area - 1.0 / 9.0).abs() < 0.01, "{area}");
    }

    #[test]
    fn both_sides_of_a_sharp_edge_keep_their_own_normals() {
        let context = Context::serial();
        let cage = Shape::Cylinder { radius: 0.5, width: 0.4, segments: 12 }.mesh(Up::Z);
        let surface = Surface::new(&context, &cage, &SurfaceOptions::default()).unwrap();
        let displacement = Displacement::new(surface.topology().clone(), &DisplacementOptions::default()).unwrap();
        let displaced = Displaced::new(&surface, displacement.field()).unwrap();
        let rates = Rates::new(&displaced, None, 4, 4);
        for index in 0..displaced.field().tile_count() as u32 {
            let piece = tile(&context, &displaced, None, &rates, index).unwrap();
            // The axis is y: normals of the ends are along it, those of the side across.
            let along = piece.normals.iter().map(|normal| normal[1].abs());
            assert!(along.clone().all(|y| y > 0.9) || along.clone().all(|y| y < 0.3), "tile {index}");
        }
    }
}
