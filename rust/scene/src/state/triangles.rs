//! Triangle meshes of a scene that are painted, sculpted and pressed into: made, kept in caches, shown in pictures.

use std::sync::Arc;

use glam::{DAffine3, Vec4};
use relievo_core::{Context, Error, Mesh, Result};
use relievo_detail::{DecayingObject, LayeredObject, TriangleObject};
use relievo_document::{Kind, PageFile};
use relievo_render as render;
use relievo_surface::TriangleSurface;
use relievo_surface::triangle::split;
use relievo_tiles::Mark;
use relievo_tiles::triangle::{TriangleBlock, TriangleChannel, TriangleOptions};

use crate::format::description::{DetailEntry, ObjectEntry, TrianglesEntry};
use crate::run::cache::Layer;

/// A triangle mesh of a scene.
#[derive(Debug)]
pub struct TriangleItem {
    /// The mesh with its displacement and colours.
    pub object: TriangleObject,
    /// The mesh it was made from, at time 0, where that is not the scene's own.
    pub cage: Option<Mesh>,
    /// What was done to the mesh, and what may surprise.
    pub notes: Vec<String>,
}

impl TriangleItem {
    /// The triangles of `mesh`, painted if there is a colour where nothing is painted, and with `vectors` if it is to
    /// have vector displacement.
    ///
    /// # Errors
    /// Fails with `Invalid` if the mesh does not pass [`Mesh::check`] or all its faces are holes, edges cannot get as
    /// short as `entry` says, the segments are not 8, 16, 32 or 64, or the transform cannot be undone, and with
    /// `Memory` if the split mesh exceeds the memory limit, or the budget does not hold the values of the points.
    pub fn new(
        context: &Context,
        mesh: &Mesh,
        entry: &TrianglesEntry,
        detail: &DetailEntry,
        paint: Option<Vec4>,
        vectors: bool,
        transform: DAffine3,
    ) -> Result<Self> {
        let mut notes = Vec::new();
        let cage = match entry.longest_edge {
            None => None,
            Some(longest) => {
                let (cage, report) = split(context, mesh, longest)?;
                if report.split > 0 {
                    notes.push(format!(
                        "{} triangles with edges of up to {:.4} were split, which makes {} of all",
                        report.split, report.longest, report.triangles
                    ));
                }
                Some(cage)
            }
        };
        let surface = TriangleSurface::new(context, cage.as_ref().unwrap_or(mesh))?;
        let branching = surface.topology().branching_count();
        if branching > 0 {
            notes.push(format!("{branching} edges have more than two faces, which all follow what is sculpted there"));
        }
        if surface.topology().boundary_count() == 0 && surface.volume() < 0.0 {
            notes.push("its faces look inwards, so what is drawn goes inwards too; turn them over".into());
        }
        let flat = surface.normals().iter().filter(|normal| **normal == [0.0; 3]).count();
        if flat > 0 {
            notes.push(format!("{flat} points have no normal and stay where they are"));
        }
        let options = TriangleOptions { segments: detail.segments, budget: detail.budget };
        let topology = surface.topology().clone();
        let displacement = TriangleChannel::displacement(topology.clone(), &options)?;
        let mut object = TriangleObject::new(context, surface, displacement, transform)?;
        if let Some(color) = paint {
            match detail.halves {
                true => object.set_half_paint(TriangleChannel::of_color(topology.clone(), color, &options)?)?,
                false => object.set_paint(TriangleChannel::of_color(topology.clone(), color, &options)?)?,
            }
        }
        if vectors {
            object.set_vectors(TriangleChannel::vectors(topology, &options)?)?;
        }
        if detail.page {
            object.page_to(Some(Arc::new(PageFile::new(None))))?;
        }
        Ok(Self { object, cage, notes })
    }

    /// The values of a block; `None` if it has none, or the mesh has no such layer.
    ///
    /// # Errors
    /// Fails with `Invalid` if there is no such block, and with `Io`, `Invalid` or `Memory` if it is on a page that
    /// cannot be read back.
    pub fn read(&self, layer: Layer, block: u32) -> Result<Option<Vec<u8>>> {
        match layer {
            Layer::Displacement => self.object.read_displacement(block),
            Layer::Paint => self.object.read_paint(block),
            Layer::Traces => Ok(self.object.traces().map(|traces| traces.read(block)).transpose()?.flatten()),
            Layer::Vectors => Ok(self.object.vectors().map(|vectors| vectors.read(block)).transpose()?.flatten()),
            Layer::DisplacementStamps => Ok(self.object.read_stamps(Kind::Scalar, block)),
            Layer::PaintStamps => Ok(self.object.read_stamps(Kind::Rgba8, block)),
            // Faces never have other sizes.
            Layer::Sizes => Ok(None),
        }
    }

    /// Puts a block back, or takes it away.
    ///
    /// # Errors
    /// Fails with `Invalid` if the mesh has no such layer or block, or the block does not fit it, and with `Memory` if
    /// the budget does not hold it.
    pub fn write(&mut self, layer: Layer, block: u32, bytes: Option<&[u8]>) -> Result<()> {
        let missing = || Error::invalid("an object has no such layer");
        match layer {
            Layer::Displacement => self.object.write_displacement(block, bytes),
            Layer::Paint => self.object.write_paint(block, bytes),
            Layer::Traces => self.object.traces_mut().ok_or_else(missing)?.write_block(block, bytes),
            Layer::Vectors => self.object.vectors_mut().ok_or_else(missing)?.write_block(block, bytes),
            Layer::DisplacementStamps => self.object.write_stamps(Kind::Scalar, block, bytes),
            Layer::PaintStamps => self.object.write_stamps(Kind::Rgba8, block, bytes),
            Layer::Sizes => Err(missing()),
        }
    }

    /// All blocks there are.
    pub fn allocated(&self) -> Vec<(Layer, u32)> {
        let displacement = self.object.displaced_tiles().into_iter().map(|block| (Layer::Displacement, block));
        let paint = self.object.painted_tiles().into_iter().map(|block| (Layer::Paint, block));
        let traces = self.object.traces().into_iter().flat_map(TriangleChannel::blocks);
        let mut all: Vec<(Layer, u32)> =
            displacement.chain(paint).chain(traces.map(|block| (Layer::Traces, block))).collect();
        let vectors = self.object.vectors().into_iter().flat_map(TriangleChannel::blocks);
        all.extend(vectors.map(|block| (Layer::Vectors, block)));
        let stamps = self.object.stamped_blocks(Kind::Scalar);
        all.extend(stamps.into_iter().map(|block| (Layer::DisplacementStamps, block)));
        let stamps = self.object.stamped_blocks(Kind::Rgba8);
        all.extend(stamps.into_iter().map(|block| (Layer::PaintStamps, block)));
        all
    }

    /// Makes what was edited visible to readers. Returns the blocks that changed since this was done last.
    ///
    /// # Errors
    /// Fails with `Invalid` only if a displacement is that of another mesh, which the object refuses when it is set.
    pub fn commit(&mut self, context: &Context) -> Result<Vec<(Layer, u32)>> {
        // Measured anew, so that a frame does not depend on whether the frames before were computed or opened.
        let sculpted = self.object.commit_displacement();
        let topology = self.object.surface().topology().clone();
        let bent = self.object.vectors_mut().map(|vectors| vectors.commit().changed().blocks(&topology));
        self.object.renew(context)?;
        let painted = self.object.commit_paint();
        let traced = self.object.traces_mut().map(|traces| traces.commit().changed().blocks(&topology));
        let sculpted = sculpted.into_iter().map(|block| (Layer::Displacement, block));
        let painted = painted.into_iter().map(|block| (Layer::Paint, block));
        let traced = traced.into_iter().flatten().map(|block| (Layer::Traces, block));
        let mut all: Vec<(Layer, u32)> = sculpted.chain(painted).chain(traced).collect();
        all.extend(bent.into_iter().flatten().map(|block| (Layer::Vectors, block)));
        let stamps = self.object.commit_stamps(Kind::Scalar);
        all.extend(stamps.into_iter().map(|block| (Layer::DisplacementStamps, block)));
        let stamps = self.object.commit_stamps(Kind::Rgba8);
        all.extend(stamps.into_iter().map(|block| (Layer::PaintStamps, block)));
        Ok(all)
    }

    /// Makes edits fade and imprints leave traces, if `entry` asks for it.
    ///
    /// # Errors
    /// Fails with `Invalid` if the times of fading are out of range, and with `Memory` if the budget does not hold the
    /// values of the points.
    pub fn keep(&mut self, entry: &ObjectEntry) -> Result<()> {
        if let Some(decay) = entry.decay {
            self.object.set_decay(decay, entry.detail.budget)?;
        }
        if entry.traces.is_none() || self.object.traces().is_some() {
            return Ok(());
        }
        let traces = TriangleChannel::of(self.object.displacement().field(), entry.detail.budget)?;
        self.object.set_traces(traces)
    }
}

/// Faces that are one mesh for the ray caster, so that there are not as many as faces.
pub const CHUNK_LEN: usize = 256;

/// The faces that look different after blocks changed, ascending. Normals of the neighbours may be others too.
pub fn stale_faces(object: &TriangleObject, blocks: &[u32]) -> Vec<u32> {
    let topology = object.surface().topology();
    let changed = TriangleBlock::change(topology, blocks.iter().copied()).faces_shown(topology);
    let vertices = changed.iter().flat_map(|face| topology.face(*face));
    let mut faces: Vec<u32> = vertices.flat_map(|vertex| topology.faces_around(vertex)).map(|(face, _)| face).collect();
    faces.sort_unstable();
    faces.dedup();
    faces
}

/// The parts that look different after blocks changed, ascending.
pub fn stale_parts(object: &TriangleObject, blocks: &[u32]) -> Vec<u32> {
    let mut parts: Vec<u32> = stale_faces(object, blocks).into_iter().map(|face| face / CHUNK_LEN as u32).collect();
    parts.dedup();
    parts
}

/// The parts that look different although nothing was written to them, because their traces fade, ascending.
pub fn fading_parts(object: &TriangleObject, entry: &ObjectEntry) -> Vec<u32> {
    let fades = entry.traces.as_ref().is_some_and(|tint| tint.fade > 0.0);
    let traces = object.traces().filter(|_| fades).map(TriangleChannel::blocks);
    stale_parts(object, &traces.unwrap_or_default())
}

/// The triangles of a part of the object that `entry` describes for the ray caster. `tag` says the tag of a face.
///
/// # Errors
/// Fails with `Invalid` only if a displacement is that of another mesh, which the object refuses when it is set.
pub fn part(object: &TriangleObject, entry: &ObjectEntry, part: u32, tag: impl Fn(u32) -> u32) -> Result<render::Mesh> {
    let count = object.surface().topology().face_count();
    let first = part as usize * CHUNK_LEN;
    let mut mesh = render::Mesh::default();
    for face in first..(first + CHUNK_LEN).min(count) {
        let face = face as u32;
        let (piece, colors) = object.piece(face)?;
        let base = mesh.points.len() as u32;
        mesh.tags.extend(std::iter::repeat_n(tag(face), piece.triangles.len()));
        mesh.edges.extend(std::iter::repeat_n(0b111, piece.triangles.len()));
        mesh.triangles.extend(piece.triangles.iter().map(|triangle| triangle.map(|at| base + at)));
        mesh.points.extend(piece.points);
        mesh.normals.extend(piece.normals);
        let painted = colors.into_iter().map(|[r, g, b, _]| [r, g, b]);
        match &entry.traces {
            Some(tint) if object.traces().is_some() => {
                let tinted = |(base, mark): ([f32; 3], Mark)| tint.over(base.into(), &mark, object.time() as f32);
                // Without paint it has the object's own colour.
                let base = painted.chain(std::iter::repeat(entry.colour));
                mesh.colors.extend(base.zip(object.marks(face)).map(tinted));
            }
            _ => mesh.colors.extend(painted),
        }
    }
    Ok(mesh)
}

/// What a graphics device draws of the colours and traces of the object that `entry` describes.
pub fn coat<'a>(object: &'a TriangleObject, entry: &ObjectEntry) -> render::virtual_vertex::TriangleCoat<'a> {
    let traces = object.traces().map(TriangleChannel::field).zip(entry.traces.as_ref());
    render::virtual_vertex::TriangleCoat {
        colors: object.colors(),
        traces: traces.map(|(traces, tint)| (traces, tint.drawn(object.time() as f32))),
    }
}

/// How many parts there are.
pub fn part_count(object: &TriangleObject) -> u32 {
    object.surface().topology().face_count().div_ceil(CHUNK_LEN) as u32
}
