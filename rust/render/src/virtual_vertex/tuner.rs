//! Which level, how many patches a draw and which storage a device draws best with, by measuring: the tuning of {L, N_d,
//! N_DP} of Concheiro et al. 2013, Sections 3 and 5.

use std::time::{Duration, Instant};

use relievo_core::{Error, Result};
use relievo_gpu::Device;
use relievo_surface::bezier::{BezierSurface, Levels, ParametricMap};

use super::{Placed, Rasterizer, Shape, Storage, VirtualVertices};
use crate::scene::Material;
use crate::settings::View;

/// What is tried, and how often.
#[derive(Clone, Debug, PartialEq)]
pub struct Tuning {
    /// Levels, ascending.
    pub levels: Vec<u32>,
    /// Patches of a draw (N_d).
    pub per_draw: Vec<u32>,
    /// Storages.
    pub storages: Vec<Storage>,
    /// The time of a frame that is not to be exceeded.
    pub budget: Duration,
    /// Frames that are measured, after one that is not.
    pub frames: u32,
}

impl Default for Tuning {
    fn default() -> Self {
        Self {
            levels: (1..=5).collect(),
            per_draw: vec![1, 2, 4, 8, 16],
            storages: Storage::ALL.to_vec(),
            budget: Duration::from_micros(16_667),
            frames: 9,
        }
    }
}

/// A way to draw and what it costs.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Measured {
    /// The level of all patches (L).
    pub level: u32,
    /// Patches of a draw (N_d).
    pub per_draw: u32,
    /// Draws of a frame (N_DP).
    pub draw_calls: usize,
    /// Where control points are kept.
    pub storage: Storage,
    /// The median time of a frame, by the device's clock, or by the processor's if the device has none.
    pub time: Duration,
}

impl Measured {
    /// Samples that are evaluated in a second: the vertices that the strips have, repeated ones counted twice.
    pub fn samples_per_second(&self, patches: usize) -> f64 {
        let vertices = ParametricMap::new(self.level).map_or(0, ParametricMap::strip_vertices);
        vertices as f64 * patches as f64 / self.time.as_secs_f64().max(1e-12)
    }
}

/// The result of tuning.
#[derive(Clone, Debug, PartialEq)]
pub struct Tuned {
    /// The highest level that stays within the budget, or the lowest if none does, as it is drawn fastest.
    pub best: Measured,
    /// All that was measured, by level, storage and patches of a draw.
    pub all: Vec<Measured>,
}

impl Rasterizer {
    /// Measures how fast the device draws `surface` and picks the best way. Levels above the first that no way draws in
    /// the budget are not tried.
    ///
    /// # Errors
    /// There is nothing to try, a combination cannot be drawn, or the device fails.
    pub fn tune(
        &mut self,
        device: &Device,
        surface: &BezierSurface,
        view: &View,
        material: &Material,
        tuning: &Tuning,
    ) -> Result<Tuned> {
        let mut all: Vec<Measured> = Vec::new();
        let mut best: Option<Measured> = None;
        for level in &tuning.levels {
            let levels = Levels::uniform(surface, *level)?;
            let first = all.len();
            for storage in &tuning.storages {
                for per_draw in tuning.per_draw.iter().filter(|count| **count <= storage.most()) {
                    let patches = VirtualVertices::new(device, surface, &levels, *storage, *per_draw)?;
                    let placed = Placed::new(Shape::Patches(&patches), *material);
                    let time = self.median(&[placed], view, tuning.frames)?;
                    let draw_calls = patches.draws().len();
                    let (level, per_draw, storage) = (*level, *per_draw, *storage);
                    all.push(Measured { level, per_draw, draw_calls, storage, time });
                }
            }
            // Of equals the first, so that what is picked does not depend on the sort.
            let Some(fastest) = all[first..].iter().min_by_key(|measured| measured.time).copied() else { continue };
            if best.is_some() && fastest.time > tuning.budget {
                break;
            }
            best = Some(fastest);
        }
        let best = best.ok_or_else(|| Error::invalid("there is nothing to try").advise("name levels and storages"))?;
        Ok(Tuned { best, all })
    }

    /// The median time of `frames` frames, after one that is not counted.
    ///
    /// # Errors
    /// As of [`Rasterizer::time`].
    pub fn median(&mut self, objects: &[Placed<'_>], view: &View, frames: u32) -> Result<Duration> {
        let size = [view.settings.width, view.settings.height];
        let mut times = Vec::with_capacity(frames as usize + 1);
        for _ in 0..=frames.max(1) {
            let start = Instant::now();
            let time = self.time(objects, view, size)?;
            times.push(if time.is_zero() { start.elapsed() } else { time });
        }
        let counted = &mut times[1..];
        counted.sort_unstable();
        Ok(counted[counted.len() / 2])
    }
}
