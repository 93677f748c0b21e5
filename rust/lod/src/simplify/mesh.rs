//! Simplification of meshes as files and hosts have them: polygons with named attributes on points, corners and faces.

use std::collections::HashMap;
use std::hash::Hash;

use relievo_core::{Attribute, Context, Domain, Error, Mesh, Progress, Result, Values};

use crate::simplify::attributes::{Attributes, SimplifiedWith, sides, simplify_with};
use crate::simplify::{SimplifyOptions, check_memory, simplify};
use crate::weld::weld;

/// How attributes of a mesh are simplified.
#[derive(Clone, Debug, Default)]
pub struct AttributeOptions {
    /// Weights of attributes, as [`Attributes::weights`]. Others have [`default_weight`].
    pub weights: Vec<(String, f32)>,
    /// Attributes that are left out.
    pub left_out: Vec<String>,
}

/// A mesh that was simplified.
#[derive(Clone, Debug, PartialEq)]
pub struct SimplifiedMesh {
    /// Triangles, with the attributes that were kept on what they were on.
    pub mesh: Mesh,
    /// The largest distance between both surfaces, never less than the true one, if there is a
    /// [`SimplifyOptions::bound`]; else the largest estimated deviation of a vertex.
    pub error: f32,
    /// Names of attributes that are not there any more, and of tags.
    pub left_out: Vec<String>,
}

/// The weight of an attribute without a given one: of directions 0.0005, of colours 0.002, of texture coordinates 0.02,
/// and 0 of others, whose ranges are not known. At a tenth of a model's triangles that is about what places deviate by.
pub fn default_weight(name: &str) -> f32 {
    match name {
        "normal" | "tangent" => 0.0005,
        _ if name.starts_with("color") => 0.002,
        _ if name.starts_with("uv") => 0.02,
        _ => 0.0,
    }
}

/// Whether the first two numbers of an attribute are texture coordinates.
fn is_uv(attribute: &Attribute) -> bool {
    attribute.name.starts_with("uv") && attribute.width >= 2
}

/// Whether the first three numbers of an attribute are a direction.
pub fn is_direction(attribute: &Attribute) -> bool {
    matches!(attribute.name.as_str(), "normal" | "tangent") && attribute.width >= 3
}

/// Simplifies the triangles of a mesh, fanned from its polygons, with its attributes; points at the same place are
/// taken as one, with a seam where attributes differ. Attributes of whole numbers are kept on faces alone; where those
/// of faces differ there is a seam too. What `left_out` of the result names is not kept. Locked points and factors are
/// those of the mesh. Triangles with two corners at one place are left out at the end. The mesh is one that
/// [`Mesh::check`] takes, but faces may repeat points.
///
/// # Errors
/// Fails as [`simplify_with`], and if there is no attribute of a name.
pub fn simplify_mesh(
    context: &Context,
    mesh: &Mesh,
    options: &SimplifyOptions,
    attributes: &AttributeOptions,
    progress: &mut dyn Progress,
) -> Result<SimplifiedMesh> {
    options.check(mesh.points.len())?;
    // Before anything is made of its corners.
    check_memory(context, mesh.corners.len().saturating_sub(2 * mesh.face_count()), 0)?;
    let chosen = Chosen::of(mesh, attributes)?;
    let (made, error) = if chosen.is_empty() {
        plain(context, mesh, options, progress)?
    } else {
        chosen.simplify(context, mesh, options, progress)?
    };
    Ok(SimplifiedMesh { mesh: made, error, left_out: chosen.left_out })
}

/// A mesh without attributes.
fn plain(
    context: &Context,
    mesh: &Mesh,
    options: &SimplifyOptions,
    progress: &mut dyn Progress,
) -> Result<(Mesh, f32)> {
    let welded = weld(&mesh.points, &mesh.triangles());
    let number = |point: &u32| welded.numbers[*point as usize];
    let mut factors = vec![0.0f32; if options.vertex_weights.is_empty() { 0 } else { welded.points.len() }];
    for (factor, number) in options.vertex_weights.iter().zip(&welded.numbers) {
        let known = &mut factors[*number as usize];
        *known = known.max(*factor);
    }
    let options = SimplifyOptions {
        locked: options.locked.iter().map(number).collect(),
        vertex_weights: factors,
        ..options.clone()
    };
    let mut made = simplify(context, &welded.points, &welded.triangles, &options, progress)?;
    made.triangles.retain(is_apart);
    Ok((Mesh::from_triangles(made.points, &made.triangles), made.error))
}

/// Whether a triangle has three different vertices.
fn is_apart([a, b, c]: &[u32; 3]) -> bool {
    a != b && b != c && c != a
}

/// Attributes that are kept.
pub struct Chosen<'a> {
    /// On points and corners, with the weight of each.
    pub floats: Vec<(&'a Attribute, f32)>,
    /// On faces.
    pub faces: Vec<&'a Attribute>,
    pub left_out: Vec<String>,
}

/// Corners of the triangles of a mesh, and their faces.
pub struct Corners {
    pub triangles: Vec<[u32; 3]>,
    pub faces: Vec<u32>,
}

impl Corners {
    /// Fanned from the first corner of each face; holes are left out, as [`Mesh::triangles`] does.
    pub fn of(mesh: &Mesh) -> Self {
        let mut is_hole = vec![false; mesh.face_count()];
        mesh.holes.iter().for_each(|face| is_hole[*face as usize] = true);
        let mut made = Self { triangles: Vec::new(), faces: Vec::new() };
        let mut start = 0;
        for ((face, size), is_hole) in (0..).zip(&mesh.face_sizes).zip(is_hole) {
            if !is_hole {
                made.triangles.extend((2..*size).map(|last| [start, start + last - 1, start + last]));
                made.faces.resize(made.triangles.len(), face);
            }
            start += size;
        }
        made
    }
}

/// Numbers pairs, the same ones alike, in the order of their first.
fn number<K: Hash + Eq>(pairs: impl Iterator<Item = K>) -> Vec<u32> {
    let mut known = HashMap::new();
    pairs
        .map(|pair| {
            let next = known.len() as u32;
            *known.entry(pair).or_insert(next)
        })
        .collect()
}

/// The bits of an element of an attribute.
pub fn bits(attribute: &Attribute, element: usize) -> [u32; 4] {
    let width = attribute.width as usize;
    std::array::from_fn(|index| match &attribute.values {
        _ if index >= width => 0,
        Values::F32(values) => values[element * width + index].to_bits(),
        Values::U32(values) => values[element * width + index],
    })
}

/// The numbers of a value of an attribute of floats.
fn floats(attribute: &Attribute, value: usize) -> &[f32] {
    let width = attribute.width as usize;
    match &attribute.values {
        Values::F32(values) => &values[value * width..(value + 1) * width],
        Values::U32(_) => &[],
    }
}

impl<'a> Chosen<'a> {
    /// Fails if there is no attribute of a name.
    pub fn of(mesh: &'a Mesh, options: &AttributeOptions) -> Result<Self> {
        let mut names = options.weights.iter().map(|(name, _)| name).chain(&options.left_out);
        if let Some(name) = names.find(|name| mesh.attribute(name).is_none()) {
            return Err(Error::invalid(format!("the mesh has no attribute `{name}`")).at("attributes"));
        }
        let mut made = Self { floats: Vec::new(), faces: Vec::new(), left_out: Vec::new() };
        let mut width = 0;
        for attribute in &mesh.attributes {
            let Attribute { name, domain, values, .. } = attribute;
            let wide = attribute.width as usize;
            // Joints of skins mean nothing between their numbers, and their weights nothing without them.
            let is_skin = matches!(name.as_str(), "joints" | "weights");
            match (domain, values) {
                _ if options.left_out.contains(name) || is_skin => made.left_out.push(name.clone()),
                (Domain::Face, _) => made.faces.push(attribute),
                (_, Values::F32(_)) if width + wide <= Attributes::MAX => {
                    let told = options.weights.iter().rev().find(|(told, _)| told == name);
                    let weight = told.map_or_else(|| default_weight(name), |(_, weight)| *weight);
                    made.floats.push((attribute, weight));
                    width += wide;
                }
                _ => made.left_out.push(name.clone()),
            }
        }
        if !mesh.creases.is_empty() || !mesh.sharp_points.is_empty() {
            made.left_out.push("creases".into());
        }
        Ok(made)
    }

    pub fn is_empty(&self) -> bool {
        self.floats.is_empty() && self.faces.is_empty()
    }

    /// Weights of the numbers of a vertex, and which of them are the first of a direction, and of texture coordinates.
    pub fn numbers(&self) -> (Vec<f32>, [Vec<usize>; 2]) {
        let (mut weights, mut firsts) = (Vec::new(), [Vec::new(), Vec::new()]);
        for (attribute, weight) in &self.floats {
            for (firsts, is_kind) in firsts.iter_mut().zip([is_direction, is_uv]) {
                if is_kind(attribute) {
                    firsts.push(weights.len());
                }
            }
            weights.resize(weights.len() + attribute.width as usize, *weight);
        }
        (weights, firsts)
    }

    /// A vertex for each corner of triangles: points, by what their corners and faces have. Those of no triangle come last.
    pub fn split(&self, mesh: &Mesh, corners: &Corners) -> (Vec<u32>, Split) {
        let used = || corners.triangles.as_flattened().iter().map(|corner| *corner as usize);
        let mut faces = vec![0; mesh.face_count()];
        for attribute in &self.faces {
            faces = number(faces.iter().enumerate().map(|(face, label)| (*label, bits(attribute, face))));
        }
        let owners = corners.faces.iter().flat_map(|face| [*face as usize; 3]);
        let mut vertices = number(used().zip(owners).map(|(corner, face)| (mesh.corners[corner], faces[face])));
        for (attribute, ..) in self.floats.iter().filter(|(attribute, ..)| attribute.domain == Domain::Corner) {
            vertices = match &attribute.indices {
                Some(indices) => number(vertices.iter().zip(used()).map(|(vertex, at)| (*vertex, indices[at]))),
                None => number(vertices.iter().zip(used()).map(|(vertex, at)| (*vertex, bits(attribute, at)))),
            };
        }
        let mut split = Split { points: Vec::new(), numbers: Vec::new(), values: Vec::new(), labels: Vec::new() };
        for ((vertex, corner), triangle) in
            vertices.iter().zip(used()).zip((0..corners.faces.len()).flat_map(|it| [it; 3]))
        {
            if *vertex as usize == split.numbers.len() {
                let label = faces[corners.faces[triangle] as usize];
                split.add(mesh, self, mesh.corners[corner], Some(corner), label);
            }
        }
        let mut is_lonely = vec![true; mesh.points.len()];
        split.numbers.iter().for_each(|point| is_lonely[*point as usize] = false);
        (0..)
            .zip(is_lonely)
            .filter(|(_, is_lonely)| *is_lonely)
            .for_each(|(point, _)| split.add(mesh, self, point, None, 0));
        (vertices, split)
    }

    fn simplify(
        &self,
        context: &Context,
        mesh: &Mesh,
        options: &SimplifyOptions,
        progress: &mut dyn Progress,
    ) -> Result<(Mesh, f32)> {
        let corners = Corners::of(mesh);
        let (vertices, split) = self.split(mesh, &corners);
        let (weights, [directions, uvs]) = self.numbers();
        let Split { values, labels, .. } = &split;
        let attributes = Attributes { values, weights: &weights, directions: &directions, uvs: &uvs, labels };
        let options = split.options(mesh, options);
        let triangles = vertices.as_chunks::<3>().0;
        let made = simplify_with(context, &split.points, triangles, &attributes, &options, progress)?;
        let error = made.error;
        Ok((self.assemble(&corners, made), error))
    }

    /// The mesh of what was made.
    fn assemble(&self, corners: &Corners, mut made: SimplifiedWith) -> Mesh {
        let SimplifiedWith { triangles, origins, places, .. } = &mut made;
        let place = |triangle: &[u32; 3]| triangle.map(|vertex| places[vertex as usize]);
        let mut stays = triangles.iter().map(|triangle| is_apart(&place(triangle)));
        origins.retain(|_| stays.next() == Some(true));
        triangles.retain(|triangle| is_apart(&place(triangle)));
        let floats: Vec<&Attribute> = self.floats.iter().map(|(attribute, _)| *attribute).collect();
        let (mut mesh, _) = assemble(&floats, &made);
        for attribute in &self.faces {
            let width = attribute.width as usize;
            let faces = || made.origins.iter().map(|triangle| corners.faces[*triangle as usize] as usize);
            let range = |face: usize| face * width..(face + 1) * width;
            let values = match &attribute.values {
                Values::F32(values) => Values::F32(faces().flat_map(|face| &values[range(face)]).copied().collect()),
                Values::U32(values) => Values::U32(faces().flat_map(|face| &values[range(face)]).copied().collect()),
            };
            mesh.attributes.push(Attribute { values, ..like(attribute) });
        }
        mesh
    }
}

/// The mesh of triangles whose vertices have the numbers of attributes on points and corners, one after the other; and of
/// every point its place.
pub fn assemble(attributes: &[&Attribute], made: &SimplifiedWith) -> (Mesh, Vec<u32>) {
    let mut width = 0;
    let firsts = attributes.iter().map(|attribute| {
        width += attribute.width as usize;
        (*attribute, width - attribute.width as usize)
    });
    let all: Vec<(&Attribute, usize)> = firsts.collect();
    let values = |vertex: usize, first: usize, width_of: u32| {
        let start = vertex * width + first;
        &made.values[start..start + width_of as usize]
    };
    // Of all vertices some numbers.
    let gathered = |attributes: &[(&Attribute, usize)]| -> Vec<f32> {
        let of = |vertex: usize| attributes.iter().flat_map(move |(it, first)| values(vertex, *first, it.width));
        (0..made.points.len()).flat_map(of).copied().collect()
    };
    // Attributes that are first of their kind, and the number among them of each vertex's.
    let listed = |attributes: &[(&Attribute, usize)]| {
        let width = attributes.iter().map(|(attribute, _)| attribute.width as usize).sum();
        let first = sides(&made.places, &[], &gathered(attributes), width);
        let kept: Vec<usize> = (0..first.len()).filter(|vertex| first[*vertex] as usize == *vertex).collect();
        let mut numbers = vec![0; first.len()];
        (0..).zip(&kept).for_each(|(number, vertex)| numbers[*vertex] = number);
        (kept, first.iter().map(|vertex| numbers[*vertex as usize]).collect::<Vec<u32>>())
    };
    let (on_points, on_corners): (Vec<_>, Vec<_>) =
        all.into_iter().partition(|(attribute, _)| attribute.domain == Domain::Point);
    let (points, numbers) = listed(&on_points);
    let triangles: Vec<[u32; 3]> =
        made.triangles.iter().map(|triangle| triangle.map(|vertex| numbers[vertex as usize])).collect();
    let mut mesh = Mesh::from_triangles(points.iter().map(|vertex| made.points[*vertex]).collect(), &triangles);
    for (attribute, first) in &on_points {
        let all = points.iter().flat_map(|vertex| values(*vertex, *first, attribute.width)).copied();
        mesh.attributes.push(Attribute { values: Values::F32(all.collect()), ..like(attribute) });
    }
    for one in &on_corners {
        let (attribute, first) = one;
        let (kept, numbers) = listed(&[*one]);
        let all = kept.iter().flat_map(|vertex| values(*vertex, *first, attribute.width)).copied();
        let indices = made.triangles.as_flattened().iter().map(|vertex| numbers[*vertex as usize]);
        let (values, indices) = (Values::F32(all.collect()), Some(indices.collect()));
        mesh.attributes.push(Attribute { values, indices, ..like(attribute) });
    }
    (mesh, points.iter().map(|vertex| made.places[*vertex]).collect())
}

/// An attribute of the same name and kind without values.
pub fn like(attribute: &Attribute) -> Attribute {
    let Attribute { name, domain, width, .. } = attribute;
    let values = match attribute.values {
        Values::F32(_) => Values::F32(Vec::new()),
        Values::U32(_) => Values::U32(Vec::new()),
    };
    Attribute { name: name.clone(), domain: *domain, width: *width, values, indices: None }
}

/// The mesh with a vertex for each side of a seam.
pub struct Split {
    points: Vec<[f32; 3]>,
    /// The point of the mesh of every vertex.
    pub numbers: Vec<u32>,
    pub values: Vec<f32>,
    pub labels: Vec<u32>,
}

impl Split {
    /// Adds a vertex; a point of no triangle has no corner, and zeros where others have values of theirs.
    fn add(&mut self, mesh: &Mesh, chosen: &Chosen, point: u32, corner: Option<usize>, label: u32) {
        self.points.push(mesh.points[point as usize]);
        self.numbers.push(point);
        self.labels.push(label);
        for (attribute, ..) in &chosen.floats {
            let value = match (attribute.domain, &attribute.indices) {
                (Domain::Corner, Some(indices)) => corner.map(|corner| indices[corner] as usize),
                (Domain::Corner, None) => corner,
                _ => Some(point as usize),
            };
            match value {
                Some(value) => self.values.extend_from_slice(floats(attribute, value)),
                None => self.values.resize(self.values.len() + attribute.width as usize, 0.0),
            }
        }
    }

    /// Options of the mesh as those of its vertices.
    fn options(&self, mesh: &Mesh, options: &SimplifyOptions) -> SimplifyOptions {
        let mut is_locked = vec![false; mesh.points.len()];
        for point in &options.locked {
            is_locked[*point as usize] = true;
        }
        let locked = (0..).zip(&self.numbers).filter(|(_, point)| is_locked[**point as usize]);
        let factors =
            self.numbers.iter().filter_map(|point| options.vertex_weights.get(*point as usize)).copied().collect();
        SimplifyOptions {
            locked: locked.map(|(vertex, _)| vertex).collect(),
            vertex_weights: factors,
            ..options.clone()
        }
    }
}
