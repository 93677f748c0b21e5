//! Models from labelled scans: blocks of voxels whose values are in ranges of materials become elements.

use glam::Vec3;
use relievo_core::{Context, Error, Result};

use crate::build::voxel::{Grid, Voxel};
use crate::build::{BuildReport, elements};
use crate::files::scan::Scan;
use crate::material::Material;
use crate::model::Model;

/// What a scan becomes.
#[derive(Clone, Debug, Default)]
pub struct Labels {
    /// Voxels of the scan along each edge of an element.
    pub block: u32,
    /// Share of labelled voxels above which a block is an element.
    pub share: f32,
    /// Materials.
    pub materials: Vec<Material>,
    /// Ranges of values, of which the first that fits a voxel is its label.
    pub ranges: Vec<Range>,
}

/// Values that are a material.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Range {
    /// Index of the material.
    pub material: u32,
    /// The least value.
    pub low: f32,
    /// The largest value.
    pub high: f32,
}

impl Labels {
    /// Makes a model of a scan, with the sets of its borders. Voxels of a block are samples of an element, so that mixtures
    /// are shares of labels.
    ///
    /// # Errors
    /// A material does not exist, a number is out of range, or no block has enough labelled voxels.
    pub fn build(&self, context: &Context, scan: &Scan) -> Result<(Model, BuildReport)> {
        if !(1..=64).contains(&self.block) {
            return Err(Error::invalid(format!("{} voxels along an edge cannot be", self.block))
                .at("block")
                .advise("use 1 to 64"));
        }
        if !(0.0..1.0).contains(&self.share) {
            return Err(Error::invalid(format!("a share of {} cannot be", self.share))
                .at("share")
                .advise("use 0 to below 1"));
        }
        self.materials.iter().try_for_each(Material::check)?;
        if let Some(range) = self.ranges.iter().find(|range| range.material as usize >= self.materials.len()) {
            return Err(Error::invalid(format!("material {} does not exist", range.material)).at("label"));
        }
        let block = self.block as usize;
        let counts = scan.counts.map(|count| count.div_ceil(block));
        let cell = scan.cell.map(|size| size * block as f32);
        let columns = context.map(counts[0] * counts[1], |column| {
            let place = [column % counts[0], column / counts[0]];
            (0..counts[2]).filter_map(|z| self.voxel(scan, [place[0], place[1], z])).collect::<Vec<Voxel>>()
        });
        let voxels = columns.concat();
        let grid = Grid { low: Vec3::from(scan.low), cell: Vec3::from(cell), counts };
        let volume = f64::from(grid.cell.x) * f64::from(grid.cell.y) * f64::from(grid.cell.z);
        let report = BuildReport {
            voxels: counts.map(|count| count as u32),
            volume: volume * voxels.iter().map(|voxel| f64::from(voxel.share)).sum::<f64>(),
        };
        let base = Model { cell: Some(cell), materials: self.materials.clone(), ..Model::default() };
        let (model, _) = elements(base, &grid, &voxels, self.share, &[])?;
        model.check()?;
        Ok((model, report))
    }

    /// Counts the labels of a block; `None` if there is none.
    fn voxel(&self, scan: &Scan, at: [usize; 3]) -> Option<Voxel> {
        let block = self.block as usize;
        let span = |axis: usize| at[axis] * block..((at[axis] + 1) * block).min(scan.counts[axis]);
        let mut counts = vec![0u32; self.materials.len()];
        for z in span(2) {
            for y in span(1) {
                let row = Grid::index([0, y, z], scan.counts);
                for value in &scan.values[row + span(0).start..row + span(0).end] {
                    let label = self.ranges.iter().find(|range| *value >= range.low && *value <= range.high);
                    if let Some(range) = label {
                        counts[range.material as usize] += 1;
                    }
                }
            }
        }
        let all: u32 = counts.iter().sum();
        let materials = (0u32..).zip(&counts).filter(|(_, count)| **count > 0);
        (all > 0).then(|| Voxel {
            at: at.map(|index| index as u32),
            share: all as f32 / block.pow(3) as f32,
            materials: materials.map(|(material, count)| (material, *count as f32 / all as f32)).collect(),
            muscles: Vec::new(),
        })
    }
}
