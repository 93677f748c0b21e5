//! What a simulation did, frame by frame: `statistics.csv`, a row a frame or sub-frame.

use std::fs::{File, OpenOptions};
use std::io::Write;
use std::path::{Path, PathBuf};

use relievo_core::{Error, Result, file};
use relievo_fluid::StepStatistics;

/// The name of the file in the folder of frames.
pub const NAME: &str = "statistics.csv";
/// Its first line: frame; seconds of the fluid; particles; steps and corrections since the frame before; the most that a
/// particle, and the most that all in the mean, were too dense after a step, as shares; energy of all motion in J;
/// seconds that it took.
pub const COLUMNS: [&str; 9] = [
    "frame",
    "seconds",
    "particles",
    "steps",
    "corrections",
    "excess_most",
    "excess_mean",
    "kinetic_energy",
    "duration",
];
/// Bytes of the file at most: a row for each of 10⁸ frames would be more.
const LONGEST: u64 = 1 << 33;

/// What was done from one frame to the next.
#[derive(Clone, Copy, Debug, Default)]
pub struct Row {
    pub seconds: f64,
    pub particles: usize,
    pub steps: u64,
    pub corrections: u64,
    pub excess: [f32; 2],
    pub energy: f32,
    pub duration: f64,
}

impl Row {
    /// Counts a step.
    pub fn add(&mut self, done: &StepStatistics) {
        self.steps += 1;
        self.corrections += u64::from(done.corrections);
        self.excess[0] = self.excess[0].max(done.excess.most);
        self.excess[1] = self.excess[1].max(done.excess.mean);
    }
}

/// The file, to which rows are added.
pub struct Statistics {
    path: PathBuf,
    file: File,
}

impl Statistics {
    /// Opens the file in `folder` behind the first `kept` rows of what it has; later ones are dropped.
    pub fn open(folder: &Path, kept: usize) -> Result<Self> {
        let path = folder.join(NAME);
        let header = COLUMNS.join(",");
        let old = if kept > 0 && path.exists() { file::load(&path, LONGEST)? } else { Vec::new() };
        let text = String::from_utf8_lossy(&old);
        let is_ours = text.lines().next() == Some(&header);
        // A row without its end is what a killed program leaves.
        let rows =
            text.split_inclusive('\n').skip(1).take(if is_ours { kept } else { 0 }).filter(|row| row.ends_with('\n'));
        let rows: String = rows.collect();
        file::store(&path, |out| write!(out, "{header}\n{rows}"))?;
        let file = OpenOptions::new().append(true).open(&path).map_err(|error| Error::io(&path, &error))?;
        Ok(Self { path, file })
    }

    /// Adds the row of a frame.
    pub fn add(&mut self, frame: &str, row: &Row) -> Result<()> {
        let Row { seconds, particles, steps, corrections, excess: [most, mean], energy, duration } = row;
        let line =
            format!("{frame},{seconds},{particles},{steps},{corrections},{most},{mean},{energy},{duration:.6}\n");
        self.file.write_all(line.as_bytes()).map_err(|error| Error::io(&self.path, &error))
    }
}
