//! Several meshes as one: points and faces one after the other, attributes united by name.

use relievo_core::{Attribute, Context, Crease, Domain, Error, Mesh, Result, Values};

use crate::budget::Budget;
use crate::model::Model;
use crate::pose::Pose;

/// Replaces the points, and the point attributes `normal` and `velocity`, of a mesh that is appended.
#[derive(Clone, Copy)]
pub(crate) struct Placed<'a> {
    pub points: &'a [[f32; 3]],
    pub normals: Option<&'a [[f32; 3]]>,
    pub velocities: Option<&'a [[f32; 3]]>,
}

impl<'a> Placed<'a> {
    /// What replaces an attribute.
    fn of(&self, attribute: &Attribute) -> Option<&'a [[f32; 3]]> {
        match attribute.name.as_str() {
            "normal" if attribute.domain == Domain::Point => self.normals,
            "velocity" if attribute.domain == Domain::Point => self.velocities,
            _ => None,
        }
    }
}

/// Grows one mesh out of several.
#[derive(Default)]
pub(crate) struct Joiner {
    mesh: Mesh,
    refused: Vec<String>,
}

impl Joiner {
    pub fn mesh(&self) -> &Mesh {
        &self.mesh
    }

    pub fn into_mesh(self) -> Mesh {
        self.mesh
    }

    /// What could not be united, as sentences.
    pub fn notes(&self) -> Vec<String> {
        let note = |name: &String| format!("`{name}` is left out because its parts have it in different forms");
        self.refused.iter().map(note).collect()
    }

    /// Appends a mesh. With `turned` its faces run the other way round, as a mirror needs.
    pub fn append(&mut self, budget: &mut Budget, piece: &Mesh, placed: Option<Placed>, turned: bool) -> Result<()> {
        let before = Counts::of(&self.mesh);
        let added = Counts::of(piece);
        for (first, second) in [(before.points, added.points), (before.corners, added.corners)] {
            if u32::try_from(first + second).is_err() {
                return Err(Error::unsupported("the whole has 2^32 or more points or corners").advise("split it"));
            }
        }
        self.unite(budget, piece, placed, before, added, turned)?;
        budget.reserve_more(&mut self.mesh.points, added.points)?;
        self.mesh.points.extend_from_slice(placed.map_or(&piece.points, |placed| placed.points));
        budget.reserve_more(&mut self.mesh.face_sizes, added.faces)?;
        self.mesh.face_sizes.extend_from_slice(&piece.face_sizes);
        budget.reserve_more(&mut self.mesh.corners, added.corners)?;
        let base = before.points as u32;
        let order = Order::of(piece, turned);
        order.each(|corner| self.mesh.corners.push(base + piece.corners[corner]));
        budget.reserve_more(&mut self.mesh.creases, piece.creases.len())?;
        self.mesh.creases.extend(
            piece.creases.iter().map(|crease| Crease { points: crease.points.map(|point| base + point), ..*crease }),
        );
        budget.reserve_more(&mut self.mesh.sharp_points, piece.sharp_points.len())?;
        self.mesh.sharp_points.extend(piece.sharp_points.iter().map(|(point, sharpness)| (base + point, *sharpness)));
        budget.reserve_more(&mut self.mesh.holes, piece.holes.len())?;
        self.mesh.holes.extend(piece.holes.iter().map(|face| before.faces as u32 + face));
        Ok(())
    }

    /// Appends triangles among the points from `base` on, with their material slot.
    pub fn add_faces(&mut self, budget: &mut Budget, base: u32, corners: &[u32], slot: Option<u32>) -> Result<()> {
        let faces = corners.len() / 3;
        let mut piece = Mesh::default();
        if let Some(slot) = slot {
            piece.attributes.push(Attribute {
                name: "material".into(),
                domain: Domain::Face,
                width: 1,
                values: Values::U32(budget.filled(faces, slot)?),
                indices: None,
            });
        }
        let before = Counts::of(&self.mesh);
        let added = Counts { points: 0, corners: corners.len(), faces };
        if u32::try_from(before.corners + added.corners).is_err() {
            return Err(Error::unsupported("the whole has 2^32 or more corners").advise("split it"));
        }
        self.unite(budget, &piece, None, before, added, false)?;
        budget.reserve_more(&mut self.mesh.face_sizes, faces)?;
        self.mesh.face_sizes.resize(before.faces + faces, 3);
        budget.reserve_more(&mut self.mesh.corners, corners.len())?;
        self.mesh.corners.extend(corners.iter().map(|corner| base + corner));
        Ok(())
    }

    /// Gives every attribute of either side values for the elements of both.
    fn unite(
        &mut self,
        budget: &mut Budget,
        piece: &Mesh,
        placed: Option<Placed>,
        before: Counts,
        added: Counts,
        turned: bool,
    ) -> Result<()> {
        for source in &piece.attributes {
            if self.refused.contains(&source.name) {
                continue;
            }
            let found = self.mesh.attributes.iter().position(|attribute| attribute.name == source.name);
            let at = match found {
                Some(at) if same_form(&self.mesh.attributes[at], source) => at,
                Some(at) => {
                    self.mesh.attributes.remove(at);
                    self.refused.push(source.name.clone());
                    continue;
                }
                None => {
                    let values = match &source.values {
                        Values::F32(_) => Values::F32(Vec::new()),
                        Values::U32(_) => Values::U32(Vec::new()),
                    };
                    self.mesh.attributes.push(Attribute {
                        name: source.name.clone(),
                        domain: source.domain,
                        width: source.width,
                        values,
                        indices: None,
                    });
                    self.mesh.attributes.len() - 1
                }
            };
            let target = &mut self.mesh.attributes[at];
            fill(budget, target, before.of_domain(source.domain))?;
            let order = Order::of(piece, turned && source.domain == Domain::Corner);
            match placed.and_then(|placed| placed.of(source)) {
                Some(vectors) => {
                    if let Values::F32(values) = &mut target.values {
                        budget.reserve_more(values, 3 * vectors.len())?;
                        values.extend_from_slice(vectors.as_flattened());
                    }
                }
                None => extend(budget, target, source, &order)?,
            }
        }
        for target in &mut self.mesh.attributes {
            let domain = target.domain;
            fill(budget, target, before.of_domain(domain) + added.of_domain(domain))?;
        }
        Ok(())
    }
}

/// Numbers of elements.
#[derive(Clone, Copy)]
struct Counts {
    points: usize,
    corners: usize,
    faces: usize,
}

impl Counts {
    fn of(mesh: &Mesh) -> Self {
        Self { points: mesh.points.len(), corners: mesh.corners.len(), faces: mesh.face_sizes.len() }
    }

    fn of_domain(&self, domain: Domain) -> usize {
        match domain {
            Domain::Point => self.points,
            Domain::Corner => self.corners,
            Domain::Face => self.faces,
        }
    }
}

/// The order in which the corners of a mesh are taken.
struct Order<'a> {
    /// The faces, if each is to be taken backwards.
    turned: Option<&'a [u32]>,
    corners: usize,
}

impl<'a> Order<'a> {
    fn of(mesh: &'a Mesh, turned: bool) -> Self {
        Self { turned: turned.then_some(&mesh.face_sizes), corners: mesh.corners.len() }
    }

    fn each(&self, mut work: impl FnMut(usize)) {
        let Some(faces) = self.turned else { return (0..self.corners).for_each(work) };
        let mut start = 0;
        for size in faces {
            let end = start + *size as usize;
            // The first corner stays the first.
            if start < end {
                work(start);
                (start + 1..end).rev().for_each(&mut work);
            }
            start = end;
        }
    }
}

fn same_form(a: &Attribute, b: &Attribute) -> bool {
    a.domain == b.domain && a.width == b.width && std::mem::discriminant(&a.values) == std::mem::discriminant(&b.values)
}

/// Fills the attribute up to `count` elements: colours with white, others with zeros.
fn fill(budget: &mut Budget, target: &mut Attribute, count: usize) -> Result<()> {
    let width = target.width as usize;
    let white = target.name.starts_with("color");
    if let Some(indices) = &mut target.indices {
        if indices.len() == count {
            return Ok(());
        }
        let value = target.values.len() / width;
        push_values(budget, &mut target.values, width, white)?;
        let gap = count - indices.len();
        budget.reserve_more(indices, gap)?;
        indices.resize(count, value as u32);
        return Ok(());
    }
    let gap = (count * width).saturating_sub(target.values.len());
    push_values(budget, &mut target.values, gap, white)
}

fn push_values(budget: &mut Budget, values: &mut Values, count: usize, white: bool) -> Result<()> {
    match values {
        Values::F32(values) => {
            budget.reserve_more(values, count)?;
            values.resize(values.len() + count, if white { 1.0 } else { 0.0 });
        }
        Values::U32(values) => {
            budget.reserve_more(values, count)?;
            values.resize(values.len() + count, 0);
        }
    }
    Ok(())
}

/// Appends the values of `source`. If one of the two is indexed, the result is.
fn extend(budget: &mut Budget, target: &mut Attribute, source: &Attribute, order: &Order) -> Result<()> {
    let width = target.width as usize;
    let have = target.values.len() / width;
    if source.indices.is_some() && target.indices.is_none() {
        let mut indices = Vec::new();
        budget.reserve(&mut indices, have)?;
        indices.extend(0..have as u32);
        target.indices = Some(indices);
    }
    if u32::try_from(have + source.values.len() / width).is_err() {
        return Err(Error::unsupported(format!("`{}` has 2^32 or more values", source.name)).advise("split it"));
    }
    if let Some(indices) = &mut target.indices {
        budget.reserve_more(indices, order.corners)?;
        order.each(|corner| {
            let index = source.indices.as_ref().map_or(corner as u32, |indices| indices[corner]);
            indices.push(have as u32 + index);
        });
        return append_values(budget, &mut target.values, &source.values, width, None);
    }
    let order = if source.domain == Domain::Corner { Some(order) } else { None };
    append_values(budget, &mut target.values, &source.values, width, order)
}

fn append_values(
    budget: &mut Budget,
    target: &mut Values,
    source: &Values,
    width: usize,
    order: Option<&Order>,
) -> Result<()> {
    fn append<T: Copy>(
        budget: &mut Budget,
        target: &mut Vec<T>,
        source: &[T],
        width: usize,
        order: Option<&Order>,
    ) -> Result<()> {
        budget.reserve_more(target, source.len())?;
        match order {
            Some(order) => {
                order.each(|corner| target.extend_from_slice(&source[corner * width..(corner + 1) * width]));
            }
            None => target.extend_from_slice(source),
        }
        Ok(())
    }
    match (target, source) {
        (Values::F32(target), Values::F32(source)) => append(budget, target, source, width, order),
        (Values::U32(target), Values::U32(source)) => append(budget, target, source, width, order),
        _ => Ok(()),
    }
}

/// All instances of a model in a pose as one mesh, in the model's space.
pub(crate) fn model(context: &Context, model: &Model, pose: &Pose) -> Result<Mesh> {
    let mut budget = Budget::new(context.memory_limit());
    let mut joiner = Joiner::default();
    for (number, node) in model.instances().enumerate() {
        let Some(part) = node.mesh.and_then(|mesh| model.meshes.get(mesh)) else { continue };
        let shape = &pose.shapes[number];
        let (normals, velocities) = (shape.normals.as_deref(), shape.velocities.as_deref());
        let placed = Placed { points: &shape.points, normals, velocities };
        joiner.append(&mut budget, &part.mesh, Some(placed), shape.mirrored)?;
    }
    let mut mesh = joiner.into_mesh();
    // They refer to the joints of different skins, and the pose has used them.
    mesh.attributes.retain(|attribute| !matches!(attribute.name.as_str(), "joints" | "weights"));
    Ok(mesh)
}
