//! Imprints on triangle meshes that a graphics device makes: which those are, what becomes of what comes back, and what
//! happens where the device fails.

use std::collections::BTreeMap;

use half::f16;
use relievo_core::{Context, Error, ErrorKind, Result};
use relievo_gpu::Device;
use relievo_tiles::triangle::{Pattern, TriangleField};

use super::object::TriangleObject;
use super::site::{Element, ElementEdit, values};
use crate::collider::Collider;
use crate::device::{Link, PressedValues, TriangleCast, TriangleChain, TriangleTarget};
use crate::grid::Grid;
use crate::imprint::{ImprintSettings, Imprinter, Moment, Report, grid_over};
use crate::layered::LayeredObject;
use crate::motion::Pose;
use crate::raycast::key;

/// An imprint on a triangle mesh that is to be submitted with others.
#[derive(Debug)]
struct Ready {
    /// `None` where the two do not meet.
    grid: Option<Grid>,
    /// How far outwards the boxes reach that it was found by.
    most: f32,
}

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
        let link = Link::new(context, 0, collider, grid, &settings.limits())?;
        let known = Known::of(object.displacement().field());
        self.cast_triangles_together(context, object, collider, start, &[link])?.pop().map(|cast| (cast, known))
    }

    /// Presses `collider` into `object` where it is at `steps`, in one submission, and adds what those did that stay. Returns
    /// how many these are: up to one after which others would have found something else, none where the device does not
    /// make them.
    #[allow(clippy::too_many_arguments)]
    pub(super) fn press_triangles_together(
        &mut self,
        context: &Context,
        object: &mut TriangleObject,
        collider: &mut Collider,
        settings: &ImprintSettings,
        steps: &[(Pose, Moment)],
        start: Option<&TriangleField>,
        report: &mut Report,
    ) -> Result<usize> {
        let (mut all, mut links) = (Vec::new(), Vec::new());
        for (pose, moment) in steps {
            collider.set_pose(context, pose)?;
            let find = || grid_over(context, object, collider, settings, *moment);
            let grid = context.stats().time("imprint.obb", find)?;
            if let Some(grid) = &grid {
                match Link::new(context, 0, collider, grid, &settings.limits()) {
                    Some(link) => links.push(link),
                    None => break,
                }
            }
            all.push(Ready { grid, most: object.reach()[1] });
        }
        let mut known = Known::of(object.displacement().field());
        let casts = if links.is_empty() {
            Some(Vec::new())
        } else {
            self.cast_triangles_together(context, object, collider, start, &links)
        };
        let Some(casts) = casts else { return Ok(0) };
        let mut casts = casts.into_iter();
        let mut made = 0;
        for ready in &all {
            if object.reach()[1] != ready.most {
                break;
            }
            let mut own = Report { bytes: object.displacement().bytes(), sub_steps: 1, ..Report::default() };
            let mut stays = true;
            if let Some(grid) = &ready.grid {
                own.voxel_diagonal = grid.diagonal();
                let cast = casts.next().ok_or_else(|| Error::internal("an imprint was not made"))?;
                self.finish_triangles_there(context, object, &cast, &mut known, settings, &mut own)?;
                let is_last = made + 1 == all.len();
                stays =
                    own.refused.is_empty() && (is_last || known.agrees(object.displacement().field(), &cast.pressed));
            }
            report.merge(&own);
            own.give_back(context);
            made += 1;
            if !stays {
                break;
            }
        }
        Ok(made)
    }

    /// Makes `links` of `collider` on the device of `object`; `None` where it fails, which the object then tells.
    fn cast_triangles_together(
        &mut self,
        context: &Context,
        object: &mut TriangleObject,
        collider: &Collider,
        start: Option<&TriangleField>,
        links: &[Link],
    ) -> Option<Vec<TriangleCast>> {
        let mut state = object.device.take()?;
        let device = state.device().clone();
        let _stage = context.stats().begin("imprint.device");
        let made = self.triangle_chain_on(&device).and_then(|chain| {
            let (press, mesh) = state.pressing();
            let target = TriangleTarget { press, mesh, object, start };
            chain.run(context, &mut [target], &[collider], links)
        });
        let fault = match made {
            Ok(casts) => {
                object.device = Some(state);
                return Some(casts);
            }
            Err(fault) => fault,
        };
        // What has no room there, or is too far, is for the processor; the device goes on with the rest.
        if !matches!(fault.kind, ErrorKind::Unsupported | ErrorKind::Memory) || device.check().is_err() {
            object.lose_device(fault);
            return None;
        }
        object.device = Some(state);
        // Several are tried one by one before anything is told.
        if links.len() == 1 {
            object.device_fault.get_or_insert(fault);
        }
        None
    }

    /// What imprints on triangle meshes share on a device.
    fn triangle_chain_on(&mut self, device: &Device) -> Result<&mut TriangleChain> {
        if self.triangles.as_ref().is_some_and(|chain| !chain.is_on(device)) {
            self.triangles = None;
        }
        Ok(match &mut self.triangles {
            Some(chain) => chain,
            none => none.insert(TriangleChain::new(device)?),
        })
    }
}

/// Whether imprints of the given settings on `object` are for its device: displacement along normals without a rim, which
/// looks at the processor's voxels. Colliders that are too far from a grid are besides, see [`Link::new`].
pub(super) fn is_for_device(object: &TriangleObject, settings: &ImprintSettings) -> bool {
    object.device.is_some() && object.vectors.is_none() && settings.share > 0.0 && settings.rim <= 0.0
}

/// The values of blocks that a device knows of a mesh, of which it changes some.
#[derive(Debug)]
pub(super) struct Known {
    field: TriangleField,
    blocks: BTreeMap<u32, Vec<f16>>,
}

impl Known {
    /// Of a mesh with this displacement.
    fn of(field: &TriangleField) -> Self {
        Self { field: field.clone(), blocks: BTreeMap::new() }
    }

    /// What `pressed` changes, with all else as `field` has it, by element, ascending; it is known from then on.
    pub fn edits(&mut self, field: &TriangleField, pressed: &[PressedValues]) -> Vec<ElementEdit<f16>> {
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
                let is_edit = !(piece.follows && matches!(element, Element::Face(_)));
                if is_edit && old.iter().zip(made).any(|(old, new)| old != new) {
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
