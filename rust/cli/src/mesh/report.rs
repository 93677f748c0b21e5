//! The options that checking and repairing share, and how a report on defects is printed.

use std::path::{Path, PathBuf};

use clap::ValueEnum;
use relievo_core::parameter::Switch;
use relievo_core::{Context, Mesh, Result};
use relievo_repair::{Element, Finding, RepairSettings, Report, Topology};
use serde_json::{Value, json};

use crate::args::limits::Limits;

/// The mesh, the steps, and how the report is printed.
#[derive(clap::Args)]
pub struct Common {
    /// The mesh: OBJ, PLY, GLB, glTF, USD, STL or OFF.
    pub file: PathBuf,
    /// Weld points within this distance, in units of the mesh; 0 welds equal coordinates only.
    #[arg(long, value_name = "DISTANCE", default_value_t = 0.0)]
    tolerance: f32,
    /// Leave a step out. May be repeated.
    #[arg(long, value_name = "STEP", value_enum)]
    skip: Vec<Step>,
    /// Elements of each kind that the report names.
    #[arg(long, value_name = "N", default_value_t = 8)]
    listed: u32,
    /// Print JSON for programs.
    #[arg(long)]
    pub json: bool,
    #[command(flatten)]
    pub limits: Limits,
}

#[derive(Clone, Copy, PartialEq, Eq, ValueEnum)]
enum Step {
    /// Joining points at the same place.
    Weld,
    /// Dropping faces with fewer than three different points.
    Degenerate,
    /// Dropping faces that occur twice.
    Duplicates,
    /// Turning faces over until they agree and face outwards.
    Orient,
    /// Splitting non-manifold edges and points.
    Split,
    /// Filling holes.
    Fill,
    /// Adding points to fillings.
    Refine,
    /// Smoothing fillings.
    Fair,
    /// Dropping points that no face uses.
    Unused,
}

impl Common {
    pub fn settings(&self) -> RepairSettings {
        let switch = |step: Step| if self.skip.contains(&step) { Switch::OFF } else { Switch::ON };
        RepairSettings {
            weld: switch(Step::Weld),
            tolerance: self.tolerance,
            degenerate: switch(Step::Degenerate),
            duplicates: switch(Step::Duplicates),
            orient: switch(Step::Orient),
            split: switch(Step::Split),
            fill: switch(Step::Fill),
            refine: switch(Step::Refine),
            fair: switch(Step::Fair),
            unused: switch(Step::Unused),
            listed: self.listed,
            ..RepairSettings::default()
        }
    }

    pub fn read(&self) -> Result<(Context, Mesh)> {
        let context = self.limits.context()?;
        let mesh = relievo_meshio::read(&context, &self.file)?;
        Ok((context, mesh))
    }

    pub fn place(&self) -> String {
        self.file.display().to_string()
    }
}

/// The defects that were found, one a line.
pub fn defects(report: &Report) -> String {
    let found = report.defects().into_iter().filter(|(_, finding)| finding.count > 0);
    found.map(|(name, finding)| format!("{:<22}{finding}\n", name.replace('_', " "))).collect()
}

/// A line about a mesh.
pub fn described(topology: &Topology) -> String {
    let Topology { points, faces, edges, components, closed_components, boundary_loops, .. } = topology;
    let Topology { euler, area, volume, .. } = topology;
    format!(
        "{points} points, {edges} edges, {faces} faces, {components} components ({closed_components} closed), \
         {boundary_loops} boundary loops, Euler number {euler}, area {area:.6}, volume {volume:.6}"
    )
}

pub fn machine_readable(file: &Path, report: &Report) -> Value {
    let defects: serde_json::Map<String, Value> =
        report.defects().into_iter().map(|(name, finding)| (name.to_owned(), finding_value(finding))).collect();
    json!({
        "file": file.display().to_string(),
        "solid": report.is_solid(),
        "defects": defects,
        "mesh": topology_value(&report.before),
    })
}

pub fn finding_value(finding: &Finding) -> Value {
    let element = |element: &Element| match element {
        Element::Point(number) | Element::Face(number) => json!(number),
        Element::Edge(points) => json!(points),
    };
    json!({ "count": finding.count, "first": finding.first.iter().map(element).collect::<Vec<_>>() })
}

pub fn topology_value(topology: &Topology) -> Value {
    json!({
        "points": topology.points,
        "edges": topology.edges,
        "faces": topology.faces,
        "boundary_edges": topology.boundary_edges,
        "boundary_loops": topology.boundary_loops,
        "non_manifold_edges": topology.non_manifold_edges,
        "components": topology.components,
        "closed_components": topology.closed_components,
        "euler": topology.euler,
        "area": topology.area,
        "volume": topology.volume,
    })
}
