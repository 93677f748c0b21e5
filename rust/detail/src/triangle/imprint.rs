//! The imprint of a collider on a triangle mesh: the values of faces, edges and vertices in the collider are moved
//! along the inverted interpolated normal until they leave it.
//!
//! The stages are those of [`crate::imprint`] (Schäfer et al. 2014, Real-Time Deformation of Subdivision Surfaces from
//! Object Collisions, Sections 5 and 6); what is written and allocated is as for dabs (Schäfer et al. 2015, Local
//! Painting and Deformation of Meshes on the GPU, Section 6).

use glam::{DAffine3, DMat3, DVec3};
use half::f16;
use relievo_core::{Context, Progress, Result};
use relievo_tiles::triangle::TriangleField;

use super::dab::{is_kept, write};
use super::device_imprint::Known;
use super::object::{TriangleGround, TriangleObject, field_length};
use super::site::{Element, ElementEdit, Run, values};
use super::{rim, smoothing, traces};
use crate::channels::frame::STILL;
use crate::channels::knots::{BLOCK_KNOTS, KnotBlock};
use crate::device::TriangleCast;
use crate::geometry::grid::Grid;
use crate::geometry::hierarchy::Region;
use crate::geometry::obb::Obb;
use crate::geometry::voxel::Voxels;
use crate::geometry::voxel_frame::VoxelFrame;
use crate::imprint::collider::Collider;
use crate::imprint::dents::{Limits, TileDents};
use crate::imprint::raycast::{Scratch, cast_block};
use crate::imprint::rim::Volumes;
use crate::imprint::row::Sweep;
use crate::imprint::settings::{ImprintSettings, Moment, Report};
use crate::imprint::{Imprintable, Imprinted, Imprinter, Pressed, grid_over};

impl Imprintable for TriangleObject {
    type Field = TriangleField;
}

impl Imprinted for TriangleObject {
    fn prepare(&mut self, context: &Context) -> Result<()> {
        // An undo may have put vectors back.
        self.renew_vectors(context);
        self.measure();
        self.layers.displacement.check_editable()?;
        self.traces.as_ref().map_or(Ok(()), |traces| traces::check(self.displacement().field(), traces.field()))
    }

    fn press(
        &mut self,
        context: &Context,
        imprinter: &mut Imprinter,
        collider: &Collider,
        (settings, moment): (&ImprintSettings, Moment),
        start: Option<&TriangleField>,
    ) -> Result<Report> {
        let stats = context.stats();
        let mut report = Report::before(self.displacement().bytes(), collider.open_edges() as u64);
        let Some(grid) = stats.time("imprint.obb", || grid_over(context, self, collider, settings, moment))? else {
            return Ok(report);
        };
        report.voxel_diagonal = grid.diagonal();
        let before = start.map(|heights| TriangleGround { heights, vectors: None });
        match imprinter.cast_triangles_on_device(context, self, collider, start, &grid, settings) {
            Some((cast, mut known)) => {
                imprinter.finish_triangles_there(context, self, &cast, &mut known, settings, &mut report)?;
            }
            None => {
                let (faces, mut edits) =
                    imprinter.cast_triangles_here(context, self, collider, start, &grid, settings, &mut report)?;
                if faces.is_empty() {
                    return Ok(report);
                }
                let mut volumes = Vec::new();
                if settings.rim > 0.0 {
                    let _stage = stats.begin("imprint.rim");
                    volumes = rim::raise(context, self, before, &mut edits, &imprinter.voxels, settings)?;
                }
                let kept = |field: &TriangleField, refused: &[u32]| {
                    let kept = |element| is_kept(field, refused, element, field.pattern());
                    volumes.iter().filter(|(element, _)| kept(*element)).map(|(_, volumes)| *volumes).sum()
                };
                let tested = finish_triangles(context, self, (&faces, edits, kept), settings, &mut report)?;
                [report.tested_tiles, report.tested_coefficients] = tested;
            }
        }
        Ok(report)
    }

    fn sweep(
        context: &Context,
        imprinter: &mut Imprinter,
        objects: &mut [&mut Self],
        colliders: &mut [&mut Collider],
        sweeps: &[Sweep<'_>],
        progress: &mut dyn Progress,
    ) -> Result<Vec<Report>> {
        imprinter.sweep_steps(context, objects, colliders, sweeps, progress)
    }
}

impl Imprinter {
    /// Writes what the rays of a device found, by what is `known` of its blocks.
    pub(super) fn finish_triangles_there(
        &mut self,
        context: &Context,
        object: &mut TriangleObject,
        cast: &TriangleCast,
        known: &mut Known,
        settings: &ImprintSettings,
        report: &mut Report,
    ) -> Result<()> {
        report.triangles = cast.triangles;
        report.clamped = cast.clamped;
        [report.tested_tiles, report.tested_coefficients] = [cast.faces, cast.tested];
        let mut faces: Vec<u32> = cast.pressed.iter().filter(|it| !it.settled).map(|piece| piece.face).collect();
        faces.dedup();
        if faces.is_empty() {
            return Ok(());
        }
        let edits = known.edits(object.displacement().field(), &cast.pressed);
        let kept = |_: &TriangleField, refused: &[u32]| {
            let kept = cast.volumes.iter().filter(|(face, _)| refused.binary_search(face).is_err());
            kept.map(|(_, volumes)| *volumes).sum()
        };
        finish_triangles(context, object, (&faces, edits, kept), settings, report).map(drop)
    }

    /// Culls, voxelises and casts rays on the processor. Returns the faces that were looked at and what changes.
    #[allow(clippy::too_many_arguments)]
    fn cast_triangles_here(
        &mut self,
        context: &Context,
        object: &TriangleObject,
        collider: &Collider,
        start: Option<&TriangleField>,
        grid: &Grid,
        settings: &ImprintSettings,
        report: &mut Report,
    ) -> Result<(Vec<u32>, Vec<ElementEdit<f16>>)> {
        let stats = context.stats();
        let before = start.map(|heights| TriangleGround { heights, vectors: None });
        let faces = stats.time("imprint.cull", || object.faces_near(context, &grid.obb, before));
        if faces.is_empty() {
            return Ok((faces, Vec::new()));
        }
        {
            let mut stage = stats.begin("imprint.voxelise");
            report.triangles = collider.voxelise(context, grid, &mut self.voxels)? as u64;
            stage.count("triangles", report.triangles);
        }
        let mut stage = stats.begin("imprint.raycast");
        let (edits, clamped) = cast(context, object, start, &faces, &self.voxels, settings);
        report.clamped = clamped;
        stage.count("changed", edits.iter().map(|edit| edit.count).sum());
        Ok((faces, edits))
    }
}

/// Writes what rays changed in and around `faces`; `kept` says what that moved by the displacement after it and the faces
/// that were refused. Returns how many faces and values these are.
fn finish_triangles(
    context: &Context,
    object: &mut TriangleObject,
    (faces, edits, kept): (&[u32], Vec<ElementEdit<f16>>, impl FnOnce(&TriangleField, &[u32]) -> Volumes),
    settings: &ImprintSettings,
    report: &mut Report,
) -> Result<[u64; 2]> {
    let with = |sum: [f32; 2], range: [f32; 2]| [sum[0].min(range[0]), sum[1].max(range[1])];
    object.widen(edits.iter().map(|edit| crate::object::ranges::range(&edit.values)).fold([0.0; 2], with));
    let before = object.displacement().field().clone();
    let finest = before.pattern();
    let (done, shown) = write(context, object.layers.displacement.composite_mut(), finest, faces, edits, false)?;
    object.touch(&shown);
    // What the budget refused moved nothing.
    report.volumes = kept(object.displacement().field(), &done.refused);
    let mut refused = done.refused;
    if let Some(traces) = &mut object.traces {
        let fields = [&before, object.layers.displacement.composite().field()];
        refused.extend(traces::record(context, fields, traces, &shown, object.layers.time)?);
        refused.sort_unstable();
        refused.dedup();
    }
    if settings.smoothing > 0.0 {
        let _stage = context.stats().begin("imprint.smooth");
        let shown = smoothing::smooth(context, object.layers.displacement.composite_mut(), &before, &shown, settings)?;
        object.touch(&shown);
    }
    report.changed = done.changed;
    report.changed_coefficients = done.changed_texels;
    report.allocated = done.allocated;
    report.refused = refused;
    report.bytes = done.bytes;
    Ok([done.tested_tiles, done.tested_texels])
}

impl Pressed for TriangleObject {
    fn transform(&self) -> &DAffine3 {
        TriangleObject::transform(self)
    }

    fn reach(&mut self) -> [f32; 2] {
        TriangleObject::reach(self)
    }

    fn obb(&self, margin: f64) -> Obb {
        TriangleObject::obb(self, margin)
    }

    fn occupied(&mut self, context: &Context, obb: &Obb, range: [f64; 2]) -> Option<Obb> {
        self.faces_in(context, obb, range).map(|(part, _)| part)
    }

    fn facing(&mut self, context: &Context, obb: &Obb, range: [f64; 2]) -> DVec3 {
        self.faces_in(context, obb, range).map_or(DVec3::ZERO, |(_, facing)| facing)
    }
}

impl TriangleObject {
    /// The part of `obb`, along its axes, that holds all faces in it, displaced by `range` object units along their
    /// normals, and how much these normals run along each of its axes, 0 to 1; `None` without such faces.
    fn faces_in(&self, context: &Context, obb: &Obb, range: [f64; 2]) -> Option<(Obb, DVec3)> {
        let map = DAffine3::from_mat3_translation(obb.axes, obb.center).inverse() * self.transform;
        let rows = [0, 1, 2].map(|axis| map.matrix3.row(axis));
        let stretch = DVec3::from(rows.map(|row| row.length()));
        let margin = stretch * (range[0].abs().max(range[1].abs()) + f64::from(self.vector_reach()));
        let mut faces = Vec::new();
        self.hierarchy.query(context, &Region::new(map, -obb.half - margin, obb.half + margin), &mut faces);
        let (mut low, mut high) = (DVec3::INFINITY, DVec3::NEG_INFINITY);
        let (mut facing, mut count) = (DVec3::ZERO, 0.0);
        for face in faces {
            let corners = self.surface.corner_points(face).map(|p| map.transform_point3(DVec3::from(p.map(f64::from))));
            let normals = self.surface.corner_normals(face).map(|n| DVec3::from(n.map(f64::from)));
            // The mean of unit normals is no shorter than this, and they are made as long as one again.
            let (a, b, c) = (normals[0].dot(normals[1]), normals[1].dot(normals[2]), normals[2].dot(normals[0]));
            let shortest = ((1.0 + 2.0 * a.min(b).min(c)) / 3.0).max(0.0).sqrt();
            let length = self.offsets.as_ref().map_or(0.0, |(offsets, _)| f64::from(field_length(offsets, face)));
            let mut down = corners[0].min(corners[1]).min(corners[2]);
            let mut up = corners[0].max(corners[1]).max(corners[2]);
            for axis in 0..3 {
                let far = rows[axis].length();
                let along = normals.map(|normal| normal.dot(rows[axis]));
                let bound = |value: f64| if shortest > 0.3 { (value / shortest).clamp(-far, far) } else { far };
                let least = -bound(-along.into_iter().fold(0.0, f64::min));
                let most = bound(along.into_iter().fold(0.0, f64::max));
                let ends = [range[0] * least, range[0] * most, range[1] * least, range[1] * most];
                let aside = stretch[axis] * length;
                down[axis] += ends.into_iter().fold(0.0, f64::min) - aside;
                up[axis] += ends.into_iter().fold(0.0, f64::max) + aside;
            }
            // A face beside the box does not widen it.
            if down.cmple(obb.half).all() && up.cmpge(-obb.half).all() {
                (low, high) = (low.min(down), high.max(up));
                facing += (map.matrix3 * (normals[0] + normals[1] + normals[2])).normalize_or_zero().abs();
                count += 1.0;
            }
        }
        let slack = 1e-5 * obb.half;
        let (low, high) = ((low - slack).max(-obb.half), (high + slack).min(obb.half));
        if low.cmpgt(high).any() {
            return None;
        }
        let local = Obb::from_interval(DMat3::IDENTITY, low, high);
        let part = Obb { center: obb.center + obb.axes * local.center, axes: obb.axes, half: local.half };
        Some((part, facing / f64::max(count, 1.0)))
    }
}

/// Casts the rays of all values in and around `faces`. Returns what changes, and how many rays were held at the border
/// of the grid.
fn cast(
    context: &Context,
    object: &TriangleObject,
    start: Option<&TriangleField>,
    faces: &[u32],
    voxels: &Voxels,
    settings: &ImprintSettings,
) -> (Vec<ElementEdit<f16>>, u64) {
    if settings.share <= 0.0 {
        return (Vec::new(), 0);
    }
    let frame = VoxelFrame::new(voxels.grid(), &object.transform);
    let limits =
        Limits { share: settings.share, max_displacement: settings.max_displacement, depth: settings.depth_limit };
    let field = object.displacement().field();
    let elements = Element::of_faces(field.topology(), faces);
    let level = context.level();
    let done = context.map(elements.len(), |index| {
        let element = elements[index];
        let pattern = element.pattern(field).unwrap_or(field.pattern()).max(field.pattern());
        let mut new = values(field, element, pattern)?;
        let (mut places, mut way, mut scratch) = (KnotBlock::ZERO, STILL, Scratch::default());
        let mut dents = TileDents::default();
        let mut before = [f16::ZERO; BLOCK_KNOTS];
        let mut count = 0;
        let total = new.len();
        for first in (0..total).step_by(BLOCK_KNOTS) {
            let run = Run { element, pattern, start: first, count: BLOCK_KNOTS.min(total - first), at: 0 };
            run.places(&object.surface, &mut places);
            if let Some(vectors) = object.ground().vectors {
                run.vectors(vectors, &mut way);
                places.shift_by(&way);
            }
            // Beyond the last, rays without a normal go nowhere.
            places.n.iter_mut().for_each(|n| n[run.count..].fill(0.0));
            if let Some(start) = start {
                let mut heights = [0.0; BLOCK_KNOTS];
                run.heights(start, &mut heights);
                before = heights.map(f16::from_f32);
            }
            let old = &mut new[first..first + run.count];
            let since = start.map(|_| &before);
            let columns = voxels.columns();
            let changed = cast_block(level, &frame, &places, old, since, &columns, &limits, &mut scratch, &mut dents);
            if changed > 0 {
                old.copy_from_slice(&scratch.new()[..run.count]);
                count += u64::from(changed);
            }
        }
        let clamped = u64::from(dents.clamped);
        Some((ElementEdit { element, pattern, values: new, count }, clamped))
    });
    let clamped = done.iter().flatten().map(|(_, clamped)| clamped).sum();
    (done.into_iter().flatten().map(|(edit, _)| edit).filter(|edit| edit.count > 0).collect(), clamped)
}
