//! Which particles the surface of a fluid needs (Morgenroth, Weiskopf, Eberhardt 2013, Section 4.3): those at the
//! surface, blind ones below them, which keep a surface from showing where the rest was left out, and the rest.
//!
//! A particle is at the surface if the surface passes nearer than a distance. It is blind if the surface is nearer than
//! a threshold: by default the influence of particles, so that with surface and blind particles alone the function has
//! the same values on all of the surface. Distances are to the surface itself, of cells of a quarter of the support
//! radius, and not to particles at it, which lie below it by more or less. Hollows that are smaller than a cell are not
//! seen.

use relievo_core::{Context, Error, Progress, Result};

use crate::surface::Surface;
use crate::surface::isosurface;
use crate::surface::rows::Rows;

/// What a particle is for the surface.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Visibility {
    /// It is at the surface.
    Surface,
    /// It is near enough to change the surface if it were left out.
    Blind,
    /// The surface does not need it.
    Hidden,
}

/// What particles are for the surface, and how many of each kind there are.
#[derive(Clone, Debug, PartialEq)]
pub struct Classes {
    /// Of every particle, in the order of the positions.
    pub of: Vec<Visibility>,
    /// Particles at the surface.
    pub surface: usize,
    /// Blind particles.
    pub blind: usize,
}

impl Classes {
    pub(crate) fn new(of: Vec<Visibility>) -> Self {
        let count = |class| of.iter().filter(|other| **other == class).count();
        Self { surface: count(Visibility::Surface), blind: count(Visibility::Blind), of }
    }

    /// The share of particles that is kept, surface and blind: of bytes in files too. 1 without particles.
    pub fn kept(&self) -> f64 {
        if self.of.is_empty() { 1.0 } else { (self.surface + self.blind) as f64 / self.of.len() as f64 }
    }

    /// Indices of the particles that are kept, rising.
    pub fn indices(&self) -> impl Iterator<Item = usize> {
        (0..self.of.len()).filter(|at| self.of[*at] != Visibility::Hidden)
    }
}

/// Cells of a support radius.
const CELLS: f32 = 4.0;
/// The distance of particles at the surface from it, in support radii: of particles half a support radius apart the
/// first layer is half of this away, the next one and a half.
const LAYER: f32 = 0.5;
/// What decides about classes, in metres.
pub(crate) struct Distances {
    /// The size of the cells by which the surface is found.
    pub cell: f32,
    /// How far particles at the surface, and blind ones, are from a vertex of it at most.
    pub layer: f32,
    pub farthest: f32,
}

impl Distances {
    /// Fails if the threshold is negative or no number.
    pub fn new(support: f32, threshold: f32) -> Result<Self> {
        if !(0.0..1e15).contains(&threshold) {
            return Err(Error::invalid(format!("the threshold is {threshold}")).advise("use a distance of 0 or more"));
        }
        let cell = support / CELLS;
        // A place on the surface is in a cell that has vertices.
        Ok(Self { cell, layer: LAYER * support, farthest: threshold + 3.0f32.sqrt() * cell })
    }
}

/// Particles of one task, and vertices that are looked at together.
const CHUNK_LEN: usize = 1024;
const LANES: usize = 16;

/// What particles are for their surface. The surface was made of `positions`; a particle is blind if the
/// surface is nearer than `threshold`, in metres, which is [`Surface::influence`] where none is given.
///
/// # Errors
/// Fails if there are not as many positions as particles of the surface, if the threshold is negative or no number,
/// where the surface cannot be found, see [`crate::mesh`], or where `progress` asks to stop.
pub fn classify(
    context: &Context,
    positions: &[[f32; 3]],
    surface: &Surface,
    threshold: Option<f32>,
    progress: &mut dyn Progress,
) -> Result<Classes> {
    if positions.len() != surface.len() {
        let (count, expected) = (positions.len(), surface.len());
        return Err(Error::invalid(format!("{count} positions for a surface of {expected} particles"))
            .advise("give those that the surface was made of"));
    }
    let threshold = threshold.unwrap_or(surface.influence());
    let Distances { cell, layer, farthest } = Distances::new(surface.function().support(), threshold)?;
    let mut stage = context.stats().begin("fluid.classify");
    let vertices = isosurface::vertices(context, surface, cell, progress)?;
    let nearest = Nearest::new(context, &vertices, farthest.max(layer))?;
    let tasks: Vec<&[u32]> = surface.order.chunks(CHUNK_LEN).collect();
    let found = context.map(tasks.len(), |task| {
        let mut search = Search { nearest: &nearest, cell: None, ranges: Vec::new() };
        let class = |at: &u32| {
            let square = search.square(positions[*at as usize]);
            if square <= layer * layer {
                Visibility::Surface
            } else if square <= farthest * farthest {
                Visibility::Blind
            } else {
                Visibility::Hidden
            }
        };
        tasks[task].iter().map(class).collect::<Vec<_>>()
    });
    let mut of = vec![Visibility::Hidden; positions.len()];
    surface.order.iter().zip(found.into_iter().flatten()).for_each(|(at, class)| of[*at as usize] = class);
    let classes = Classes::new(of);
    stage.count("particles", positions.len() as u64);
    stage.count("surface", classes.surface as u64);
    stage.count("blind", classes.blind as u64);
    Ok(classes)
}

/// Points by cells as wide as the distance at which the nearest is sought.
struct Nearest {
    rows: Rows,
    axes: [Vec<f32>; 3],
}

impl Nearest {
    fn new(context: &Context, points: &[[f32; 3]], distance: f32) -> Result<Self> {
        let (rows, order) = Rows::new(context, points, 1.001 * distance)?;
        let axes = std::array::from_fn(|axis| order.iter().map(|at| points[*at as usize][axis]).collect());
        Ok(Self { rows, axes })
    }
}

/// Looks for the nearest point to one place after the other.
struct Search<'a> {
    nearest: &'a Nearest,
    cell: Option<[i64; 3]>,
    ranges: Vec<std::ops::Range<usize>>,
}

impl Search<'_> {
    /// The squared distance to the nearest point, or to one farther than the distance sought.
    fn square(&mut self, [x, y, z]: [f32; 3]) -> f32 {
        let Nearest { rows, axes: [xs, ys, zs] } = self.nearest;
        let cell = rows.cell([x, y, z]);
        if self.cell != Some(cell) {
            rows.ranges(cell.map(|at| at.saturating_sub(1)), cell.map(|at| at.saturating_add(1)), &mut self.ranges);
            self.cell = Some(cell);
        }
        let mut best = [f32::INFINITY; LANES];
        for range in &self.ranges {
            let axes = [xs, ys, zs].map(|axis| axis[range.clone()].chunks(LANES));
            let [xs, ys, zs] = axes;
            for ((xs, ys), zs) in xs.zip(ys).zip(zs) {
                for (((best, px), py), pz) in best.iter_mut().zip(xs).zip(ys).zip(zs) {
                    let (dx, dy, dz) = (px - x, py - y, pz - z);
                    let square = dx * dx + dy * dy + dz * dz;
                    *best = if square < *best { square } else { *best };
                }
            }
        }
        best.into_iter().fold(f32::INFINITY, f32::min)
    }
}
