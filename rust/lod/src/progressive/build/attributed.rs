//! Progressive meshes of meshes as files and hosts have them: polygons with named attributes, and levels as such meshes.

use glam::Vec4;
use relievo_core::{Attribute, Context, Domain, Error, Mesh, Progress, Result, Values};

use super::hierarchy::{BuildOptions, Progressive};
use super::wedges::{Wedged, widths};
use crate::connectivity::NONE;
use crate::progressive::mesh::active::{ActiveMesh, Extract};
use crate::simplify::attributes::{Attributes, SimplifiedWith, fours, range, sides};
use crate::simplify::mesh::{AttributeOptions, Chosen, Corners, assemble, bits, default_weight, like};
use crate::simplify::wedges;
use crate::simplify::{SimplifyOptions, check, check_memory, unit};
use crate::weld::{Welded, weld};

/// Bytes of the name of an attribute at most.
pub const NAME: usize = 255;
/// Numbers of attributes that a triangle may have.
pub const FACE_NUMBERS: usize = 64;

impl Progressive {
    /// Builds a progressive mesh of the triangles of a mesh, fanned from its polygons, with its attributes, as
    /// [`crate::simplify_mesh`] takes them: points at the same place are one, with a seam where attributes differ. Also
    /// returns the names of attributes that are not kept, and of tags. The finest mesh has the attributes' values at
    /// every corner, 0 for −0.
    ///
    /// # Errors
    /// Fails as [`crate::simplify_mesh`], if a name has more than 255 bytes, and if faces have more than 64 numbers.
    pub fn build_mesh(
        context: &Context,
        mesh: &Mesh,
        options: &BuildOptions,
        attributes: &AttributeOptions,
        progress: &mut dyn Progress,
    ) -> Result<(Self, Vec<String>)> {
        let limits =
            SimplifyOptions { target_triangles: options.faces, locked: options.locked.clone(), ..Default::default() };
        limits.check(mesh.points.len())?;
        // Before anything is made of its corners.
        check_memory(context, mesh.corners.len().saturating_sub(2 * mesh.face_count()), 0)?;
        let chosen = Chosen::of(mesh, attributes)?;
        let Welded { points, triangles, numbers } = weld(&mesh.points, &mesh.triangles());
        let locked = options.locked.iter().map(|point| numbers[*point as usize]).collect();
        let options = BuildOptions { locked, ..options.clone() };
        let made = if chosen.is_empty() {
            drop(numbers);
            Self::build(context, &points, &triangles, &options, progress)?
        } else {
            let limits = SimplifyOptions { locked: options.locked.clone(), ..limits };
            check(context, &points, &triangles, &limits)?;
            let wedged = wedged(&chosen, mesh, &numbers)?;
            drop(numbers);
            build(context, (&points, &triangles), &chosen, wedged, &options, progress)?
        };
        Ok((made, chosen.left_out))
    }

    /// As [`Self::build`], of a mesh with attributes, which weigh as much as they do where nobody tells.
    pub(super) fn build_extract(
        context: &Context,
        attributes: &[Attribute],
        mesh: Extract,
        options: &BuildOptions,
        progress: &mut dyn Progress,
    ) -> Result<Self> {
        let Extract { points, triangles, wedges: corners, values, face_values: faces, .. } = mesh;
        if attributes.is_empty() {
            return Self::build(context, &points, &triangles, options, progress);
        }
        let limits =
            SimplifyOptions { target_triangles: options.faces, locked: options.locked.clone(), ..Default::default() };
        check(context, &points, &triangles, &limits)?;
        let (on_faces, others): (Vec<_>, Vec<_>) =
            attributes.iter().partition(|attribute| attribute.domain == Domain::Face);
        let floats = others.into_iter().map(|attribute| (attribute, default_weight(&attribute.name))).collect();
        let chosen = Chosen { floats, faces: on_faces, left_out: Vec::new() };
        let wedged = Wedged { attributes: attributes.to_vec(), corners, values, faces };
        build(context, (&points, &triangles), &chosen, wedged, options, progress)
    }
}

/// Builds a progressive mesh with as many numbers as attributes have.
fn build(
    context: &Context,
    places: (&[[f32; 3]], &[[u32; 3]]),
    chosen: &Chosen,
    wedged: Wedged,
    options: &BuildOptions,
    progress: &mut dyn Progress,
) -> Result<Progressive> {
    match chosen.numbers().0.len() {
        ..=4 => build_fours::<1>(context, places, chosen, wedged, options, progress),
        5..=8 => build_fours::<2>(context, places, chosen, wedged, options, progress),
        _ => build_fours::<4>(context, places, chosen, wedged, options, progress),
    }
}

fn build_fours<const Q: usize>(
    context: &Context,
    (points, triangles): (&[[f32; 3]], &[[u32; 3]]),
    chosen: &Chosen,
    wedged: Wedged,
    options: &BuildOptions,
    progress: &mut dyn Progress,
) -> Result<Progressive> {
    check_memory(context, triangles.len().max(points.len()), wedges::Wedges::<Q>::BYTES)?;
    let (weights, [directions, uvs]) = chosen.numbers();
    let values = &wedged.values;
    let attributes = Attributes { values, weights: &weights, directions: &directions, uvs: &uvs, labels: &[] };
    attributes.check(wedged.count())?;
    let values: Vec<[Vec4; Q]> = match weights.len() {
        0 => vec![[Vec4::ZERO; Q]; wedged.count()],
        width => wedged.values.chunks(width).map(fours).collect(),
    };
    let range = range(points, &values, &attributes, unit(points));
    let wedges = wedges::Wedges::new(context, points.len(), &wedged.corners, values, range);
    Progressive::build_wedged(context, (points, triangles), (wedged, wedges), options, progress)
}

/// The wedges of a mesh, whose points have these places: its vertices, those at one place with the same values as one.
fn wedged(chosen: &Chosen, mesh: &Mesh, numbers: &[u32]) -> Result<Wedged> {
    let corners = Corners::of(mesh);
    let attributes: Vec<Attribute> =
        chosen.floats.iter().map(|(attribute, _)| *attribute).chain(chosen.faces.iter().copied()).map(like).collect();
    if let Some(attribute) = attributes.iter().find(|attribute| attribute.name.len() > NAME) {
        return Err(Error::unsupported(format!("a name of {} bytes is too long", attribute.name.len()))
            .at("attributes")
            .advise(format!("use at most {NAME}, or leave the attribute out")));
    }
    let [_, face_numbers] = widths(&attributes);
    if face_numbers > FACE_NUMBERS {
        return Err(Error::unsupported(format!("{face_numbers} numbers of attributes of faces are too many"))
            .at("attributes")
            .advise(format!("use at most {FACE_NUMBERS}: leave attributes out")));
    }
    let (mut vertices, split) = chosen.split(mesh, &corners);
    let places: Vec<u32> = split.numbers.iter().map(|point| numbers[*point as usize]).collect();
    let width = chosen.numbers().0.len();
    let first = sides(&places, &split.labels, &split.values, width);
    let mut numbers = vec![NONE; first.len()];
    let (mut values, mut count) = (Vec::new(), 0);
    for vertex in &mut vertices {
        let first = first[*vertex as usize] as usize;
        if numbers[first] == NONE {
            numbers[first] = count;
            count += 1;
            values.extend(split.values[first * width..(first + 1) * width].iter().map(|value| value + 0.0));
        }
        *vertex = numbers[first];
    }
    let mut faces = Vec::with_capacity(face_numbers * corners.faces.len());
    for face in &corners.faces {
        for attribute in &chosen.faces {
            faces.extend(bits(attribute, *face as usize).into_iter().take(attribute.width as usize));
        }
    }
    Ok(Wedged { attributes, corners: vertices.as_chunks::<3>().0.to_vec(), values, faces })
}

impl ActiveMesh {
    /// The mesh with its attributes, and of every point the vertex it is: a vertex has several where attributes on points
    /// differ about it. Points of no triangle have zeros. The finest mesh has the points of the input in their order.
    pub fn to_mesh(&self) -> (Mesh, Vec<u32>) {
        let made = self.extract();
        let attributes = self.whole.attributes();
        if attributes.is_empty() {
            let vertices = (0..made.points.len() as u32).collect();
            return (Mesh::from_triangles(made.points, &made.triangles), vertices);
        }
        let (on_faces, others): (Vec<_>, Vec<_>) =
            attributes.iter().partition(|attribute| attribute.domain == Domain::Face);
        let width: usize = others.iter().map(|attribute| attribute.width as usize).sum();
        // Vertices with their wedges, in the order of vertices.
        let ends = made.triangles.as_flattened().iter().zip(made.wedges.as_flattened());
        let pair = |(vertex, wedge): (&u32, &u32)| u64::from(*vertex) << 32 | u64::from(*wedge);
        let mut is_lonely = vec![true; made.points.len()];
        made.triangles.as_flattened().iter().for_each(|vertex| is_lonely[*vertex as usize] = false);
        let lonely = (0u64..).zip(is_lonely).filter(|(_, is_lonely)| *is_lonely);
        let mut pairs: Vec<u64> =
            ends.clone().map(pair).chain(lonely.map(|(vertex, _)| vertex << 32 | u64::from(NONE))).collect();
        pairs.sort_unstable();
        pairs.dedup();
        let number = |end: (&u32, &u32)| pairs.partition_point(|other| *other < pair(end)) as u32;
        let corners: Vec<u32> = ends.map(number).collect();
        let mut split = SimplifiedWith { triangles: corners.as_chunks::<3>().0.to_vec(), ..Default::default() };
        for [vertex, wedge] in pairs.iter().map(|pair| [(pair >> 32) as u32, *pair as u32]) {
            split.points.push(made.points[vertex as usize]);
            split.places.push(vertex);
            match wedge {
                NONE => split.values.resize(split.values.len() + width, 0.0),
                wedge => {
                    split.values.extend_from_slice(&made.values[wedge as usize * width..(wedge as usize + 1) * width])
                }
            }
        }
        let (mut mesh, vertices) = assemble(&others, &split);
        let all: usize = on_faces.iter().map(|attribute| attribute.width as usize).sum();
        let mut first = 0;
        for attribute in on_faces {
            let width = attribute.width as usize;
            let numbers = made.face_values.chunks(all).flat_map(|face| &face[first..first + width]);
            let values = match attribute.values {
                Values::F32(_) => Values::F32(numbers.map(|bits| f32::from_bits(*bits)).collect()),
                Values::U32(_) => Values::U32(numbers.copied().collect()),
            };
            mesh.attributes.push(Attribute { values, ..like(attribute) });
            first += width;
        }
        (mesh, vertices)
    }
}
