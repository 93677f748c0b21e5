//! Colliders of a fluid on a device: their triangles by the cells in which a particle may meet them (`shaders/fluid/step/fluid_hold.wgsl`).

use glam::{IVec3, Vec3, Vec4};
use relievo_core::{Error, Result};
use relievo_gpu::{Buffer, Device};

use super::passes::CELL_BITS;
use crate::boundary::collider::{Collider, Contact};
use crate::boundary::wall::Wall;
use crate::solver::options::{FluidOptions, TimeStep};

/// How far a particle goes in a step at most by itself, in spacings, and a little more for rounding.
const REACH: f32 = 1.02;
/// Entries of triangles in cells at most, and of one cell.
const MAX: [usize; 2] = [1 << 26, 2000];

/// Colliders, and what a device has of them.
#[derive(Debug)]
pub struct Obstacles {
    colliders: Vec<Collider>,
    /// The first particle of walls of each.
    firsts: Vec<usize>,
    /// How far what is met may take a particle along in a step, in metres.
    taken: f32,
    pub cells: Buffer<[u32; 2]>,
    pub list: Buffer<u32>,
    pub triangles: Buffer<[u32; 4]>,
    pub points: Buffer<Vec4>,
    pub paces: Buffer<Vec4>,
}

impl Obstacles {
    /// Of colliders with the first particles of walls of each, in cells of a side of two spacings. Fails if too many triangles
    /// are in a cell, or the device has no memory.
    pub fn new(device: &Device, colliders: &[Collider], firsts: Vec<usize>, options: &FluidOptions) -> Result<Self> {
        let FluidOptions { spacing, time_step, .. } = *options;
        let taken = match time_step {
            TimeStep::Fixed(step) => step * speed(colliders),
            TimeStep::Courant { number, .. } => number * spacing,
        };
        let [side, reach] = [2.0 * spacing, REACH * spacing + taken];
        let (mut triangles, mut entries, mut first) = (Vec::new(), Vec::new(), 0);
        for (number, collider) in colliders.iter().enumerate() {
            let contact = match collider.options.contact {
                Contact::Stop => -1.0f32,
                Contact::Slip => 0.0,
                Contact::Friction(share) => share,
            };
            for (at, [a, b, c]) in collider.triangles.iter().enumerate() {
                list_cells(&collider.shapes(at), [side, reach], |cell| {
                    entries.push((cell, triangles.len() as u32));
                    entries.len() <= MAX[0]
                });
                triangles.push([first + a, first + b, first + c, contact.to_bits()]);
            }
            if entries.len() > MAX[0] {
                return Err(crowded("its triangles reach more cells than a device has room for").at(named(number)));
            }
            first += collider.points.len() as u32;
        }
        // A triangle that is longer than what cells repeat after is in some of them twice.
        entries.sort_unstable();
        entries.dedup();
        let mut cells = vec![[0u32; 2]; if colliders.is_empty() { 1 } else { 1 << CELL_BITS }];
        for (at, (cell, _)) in (0u32..).zip(&entries) {
            let range = &mut cells[*cell as usize];
            *range = [if range[1] == 0 { at } else { range[0] }, at + 1];
        }
        let most = cells.iter().map(|[first, last]| last - first).max().unwrap_or(0);
        if most as usize > MAX[1] {
            return Err(crowded(&format!("{most} triangles are within a few spacings")).at("colliders"));
        }
        let list: Vec<u32> = entries.iter().map(|(_, triangle)| *triangle).collect();
        let made = Self {
            colliders: colliders.to_vec(),
            firsts,
            taken,
            cells: Buffer::of(device, "cells of triangles", &cells)?,
            list: Buffer::new(device, "triangles of cells", list.len().max(1))?,
            triangles: Buffer::new(device, "triangles of colliders", triangles.len().max(1))?,
            points: Buffer::new(device, "points of colliders", (first as usize).max(1))?,
            paces: Buffer::new(device, "velocities of colliders", (first as usize).max(1))?,
        };
        made.list.write(device, 0, &list)?;
        made.triangles.write(device, 0, &triangles)?;
        made.send(device)?;
        Ok(made)
    }

    /// Whether it has no obstacle.
    pub fn is_empty(&self) -> bool {
        self.colliders.is_empty()
    }

    /// How many seconds a step may have: until one is where it goes, and none goes farther than lists of triangles reckon with.
    pub fn longest(&self) -> f32 {
        let speed = speed(&self.colliders);
        let most = if speed > 0.0 { self.taken / speed } else { f32::INFINITY };
        self.colliders.iter().map(Collider::left).fold(most, f32::min)
    }

    /// Goes on by so many seconds, with the particles of obstacles that have come to rest.
    pub fn arrive(&mut self, device: &Device, wall: &mut Wall, seconds: f32) -> Result<()> {
        if self.longest().is_infinite() {
            return Ok(());
        }
        for (collider, first) in self.colliders.iter_mut().zip(&self.firsts) {
            if collider.arrive(seconds) {
                wall.put(*first, collider.particles().into_iter(), collider.velocities().into_iter());
            }
        }
        self.send(device)
    }

    /// Sends where points are and how they move.
    fn send(&self, device: &Device) -> Result<()> {
        let rows = |of: fn(&Collider) -> &[Vec3]| -> Vec<Vec4> {
            self.colliders.iter().flat_map(of).map(|row| row.extend(0.0)).collect()
        };
        self.points.write(device, 0, &rows(|collider| &collider.points))?;
        self.paces.write(device, 0, &rows(|collider| &collider.paces))
    }
}

/// The speed of the fastest point, in m/s.
fn speed(colliders: &[Collider]) -> f32 {
    colliders.iter().map(Collider::speed).fold(0.0, f32::max)
}

/// Lists the cells in which a particle may meet a triangle on its way from one shape to the other, until `push` has enough.
fn list_cells(shapes: &[[Vec3; 3]; 2], [side, reach]: [f32; 2], mut push: impl FnMut(u32) -> bool) {
    let corners = || shapes.iter().flatten().copied();
    let low = corners().fold(Vec3::INFINITY, Vec3::min) - reach;
    let high = corners().fold(Vec3::NEG_INFINITY, Vec3::max) + reach;
    let [low, high] = [low, high].map(|at| (at / side).floor().as_ivec3());
    // Cells repeat themselves, so that more along an axis are no others.
    let high = high.min(low + ((1 << (CELL_BITS / 3)) - 1));
    let [[a, b, c], then] = *shapes;
    let normal = (b - a).cross(c - a).normalize_or_zero();
    let is_still = [a, b, c] == then;
    for z in low.z..=high.z {
        for y in low.y..=high.y {
            for x in low.x..=high.x {
                let cell = IVec3::new(x, y, z);
                let apart = (side * (cell.as_vec3() + 0.5) - a).dot(normal).abs();
                // Within the box of a large one most cells are far from its plane.
                let is_near = !is_still || apart <= 0.5 * side * normal.abs().element_sum() + reach;
                if is_near && !push(number(cell)) {
                    return;
                }
            }
        }
    }
}

/// The number of a cell, as in `fluid.wgsl`.
fn number(cell: IVec3) -> u32 {
    let spread = |at: i32| (0..CELL_BITS / 3).map(|bit| (at as u32 >> bit & 1) << (3 * bit)).sum::<u32>();
    spread(cell.x) | spread(cell.y) << 1 | spread(cell.z) << 2
}

fn named(number: usize) -> String {
    format!("collider {number}")
}

fn crowded(what: &str) -> Error {
    Error::unsupported(what.to_owned()).advise("use `--device cpu`, or a mesh with fewer triangles")
}
