//! Imprints on triangle meshes that a graphics device makes: which those are, what becomes of what comes back, and what
//! happens where the device fails.

use std::collections::BTreeMap;

use half::f16;
use relievo_core::{Context, Result};
use relievo_gpu::Device;
use relievo_tiles::triangle::{Pattern, TriangleField};

use super::device::TriangleDevice;
use super::object::TriangleObject;
use super::site::{Element, ElementEdit, values};
use crate::device::{
    DeviceMeshes, DeviceRow, ImprintJob, PressedValues, Standing, TriangleCast, TriangleChain, TriangleTarget,
};
use crate::geometry::grid::Grid;
use crate::imprint::Imprinter;
use crate::imprint::collider::Collider;
use crate::imprint::dents::key;
use crate::imprint::settings::{ImprintSettings, Report};

impl Imprinter {
    /// Culls, voxelises and casts rays on the object's device; `None` if the processor is to do it.
    pub(super) fn cast_triangles_on_device(
        &mut self,
        context: &Context,
        object: &mut TriangleObject,
        collider: &Collider,
        start: Option<&TriangleField>,
        grid: &Grid,
        settings: &ImprintSettings,
    ) -> Option<(TriangleCast, Known)> {
        if !is_for_device(object, settings) {
            return None;
        }
        let job = ImprintJob::new(context, 0, collider, grid, &settings.limits())?.raising(settings);
        let known = object.known();
        let casts = self.cast_together(context, &mut [object], start, &[collider], &[job]);
        casts?.pop().map(|cast| (cast, known))
    }

    /// What imprints on triangle meshes share on a device, and the meshes of colliders there.
    fn triangle_chain_on(&mut self, device: &Device) -> Result<(&mut TriangleChain, &mut DeviceMeshes)> {
        let (meshes, _, chain) = self.turn_to(device)?;
        let chain = match chain {
            Some(chain) => chain,
            none => none.insert(TriangleChain::new(device)?),
        };
        Ok((chain, meshes))
    }
}

/// Whether imprints of the given settings on `object` are for its device. Colliders that are too far from a grid are besides,
/// see [`ImprintJob::new`].
fn is_for_device(object: &TriangleObject, settings: &ImprintSettings) -> bool {
    object.device.is_some() && settings.share > 0.0
}

impl DeviceRow for TriangleObject {
    type Cast = TriangleCast;
    type Known = Known;

    const RINGS: bool = false;

    fn field(&self) -> &TriangleField {
        self.displacement().field()
    }

    fn bytes(&self) -> u64 {
        self.displacement().bytes()
    }

    fn is_for_row(&self, settings: &ImprintSettings) -> bool {
        is_for_device(self, settings)
    }

    fn device_of(state: &TriangleDevice) -> &Device {
        state.device()
    }

    fn cast(
        context: &Context,
        imprinter: &mut Imprinter,
        device: &Device,
        objects: Vec<(&mut TriangleDevice, &Self)>,
        start: Option<&TriangleField>,
        colliders: &[&Collider],
        jobs: &[ImprintJob],
    ) -> Result<Vec<TriangleCast>> {
        let targets = objects.into_iter().map(|(state, object)| {
            let (press, mesh) = state.pressing();
            TriangleTarget { press, mesh, object, start }
        });
        let mut targets: Vec<_> = targets.collect();
        let (chain, meshes) = imprinter.triangle_chain_on(device)?;
        chain.run(context, meshes, &mut targets, colliders, jobs)
    }

    fn known(&self) -> Known {
        Known { field: self.displacement().field().clone(), blocks: BTreeMap::new() }
    }

    /// Others would have found something else after one of which the budget refused faces, and where the device rounds
    /// values otherwise by more than a half float.
    fn finish(
        &mut self,
        context: &Context,
        imprinter: &mut Imprinter,
        cast: TriangleCast,
        known: &mut Known,
        Standing { settings, is_last, .. }: Standing<'_>,
        report: &mut Report,
    ) -> Result<bool> {
        imprinter.finish_triangles_there(context, self, &cast, known, settings, report)?;
        Ok(is_last || known.agrees(self.displacement().field(), &cast.pressed))
    }

    /// What changed is sent with the next submission.
    fn write_there(_: &Context, _: &mut Imprinter, _: &mut [&mut Self], _: &[(usize, &[u32])]) {}
}

/// The values of blocks that a device knows of a mesh, of which it changes some.
#[derive(Debug)]
pub(crate) struct Known {
    field: TriangleField,
    blocks: BTreeMap<u32, Vec<f16>>,
}

impl Known {
    /// What `pressed` changes, with all else as `field` has it, by element, ascending; it is known from then on, as is what
    /// smoothing left.
    pub(super) fn edits(&mut self, field: &TriangleField, pressed: &[PressedValues]) -> Vec<ElementEdit<f16>> {
        let pattern = field.pattern();
        let mut new: BTreeMap<Element, (Vec<f16>, Vec<bool>)> = BTreeMap::new();
        for piece in pressed {
            let block = self.blocks.entry(piece.face).or_insert_with(|| block_of(&self.field, piece.face));
            for (element, first, count) in elements_of(field, pattern, piece.face) {
                let (from, to) = (first.max(piece.first), (first + count).min(piece.first + piece.values.len()));
                if from >= to {
                    continue;
                }
                let made = &piece.values[from - piece.first..to - piece.first];
                let old = &mut block[from..to];
                if !piece.settled && old.iter().zip(made).any(|(old, new)| old != new) {
                    let own = || values(field, element, pattern).unwrap_or_else(|| vec![f16::ZERO; count]);
                    let (values, changed) = new.entry(element).or_insert_with(|| (own(), vec![false; count]));
                    for (k, (old, new)) in old.iter().zip(made).enumerate().filter(|(_, (old, new))| old != new) {
                        // All triangles that share a value have the same.
                        values[from - first + k] = *new;
                        changed[from - first + k] = *old != *new;
                    }
                }
                old.copy_from_slice(made);
            }
        }
        let edit = |(element, (values, changed)): (Element, (Vec<f16>, Vec<bool>))| {
            let count = changed.iter().filter(|changed| **changed).count() as u64;
            ElementEdit { element, pattern, values, count }
        };
        new.into_iter().map(edit).collect()
    }

    /// Whether `field` reads within a half float of what is known of the blocks of `pressed`.
    fn agrees(&self, field: &TriangleField, pressed: &[PressedValues]) -> bool {
        let near = |(a, b): (&f16, &f16)| key(*a).abs_diff(key(*b)) <= 1;
        pressed.chunk_by(|a, b| a.face == b.face).all(|pieces| {
            let known = self.blocks.get(&pieces[0].face);
            known.is_some_and(|known| known.iter().zip(&block_of(field, pieces[0].face)).all(near))
        })
    }
}

/// The values of a triangle's block, in the pattern of `field`.
fn block_of(field: &TriangleField, face: u32) -> Vec<f16> {
    let pattern = field.pattern();
    let elements = elements_of(field, pattern, face).into_iter();
    elements.flat_map(|(element, ..)| values(field, element, pattern).unwrap_or_default()).collect()
}

/// The elements of a triangle in the order of its block, with where each begins there and how many values it has.
fn elements_of(field: &TriangleField, pattern: Pattern, face: u32) -> [(Element, usize, usize); 7] {
    let topology = field.topology();
    let (inside, along) = (pattern.face_values(), pattern.edge_values());
    let (edges, corners) = (topology.edges_of(face), topology.face(face));
    let side = |k: usize| (Element::Edge(edges[k]), inside + k * along, along);
    let corner = |k: usize| (Element::Vertex(corners[k]), inside + 3 * along + k, 1);
    [(Element::Face(face), 0, inside), side(0), side(1), side(2), corner(0), corner(1), corner(2)]
}
