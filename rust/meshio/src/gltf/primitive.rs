//! Meshes of a glTF file: the primitives of each become one mesh with a material per face.

use gltf::json::accessor::Type;
use gltf::json::mesh::{Mode, Primitive, Semantic};
use gltf::json::validation::Checked;
use relievo_core::{Attribute, Domain, Error, Mesh, Result, Values};

use super::accessor::{Wanted, floats, integers};
use super::container::{Container, understood};
use super::influences;
use crate::budget::Budget;
use crate::merge::Joiner;
use crate::model::Part;
use crate::notes::Notes;

/// Reads mesh `index`. `materials` gets a slot without a name where a face needs one.
pub(crate) fn mesh(
    file: &Container,
    budget: &mut Budget,
    notes: &mut Notes,
    index: usize,
    materials: &mut Vec<String>,
) -> Result<Part> {
    let source = &file.json.meshes[index];
    let mut joiner = Joiner::default();
    let mut targets: Vec<Vec<[f32; 3]>> = Vec::new();
    // Primitives often share their points and differ only in faces and material.
    let mut shared: Option<(&Primitive, usize)> = None;
    for (number, primitive) in source.primitives.iter().enumerate() {
        let place = |error: Error| error.at(format!("mesh {index}, primitive {number}"));
        let Some(mode) = triangles_mode(primitive).map_err(place)? else {
            notes.add("points and lines are left out", 0);
            continue;
        };
        let same = |other: &Primitive| {
            other.attributes == primitive.attributes && target_indices(other) == target_indices(primitive)
        };
        let (base, count) = match shared.filter(|(other, _)| same(other)) {
            Some((_, base)) => (base, joiner.mesh().points.len() - base),
            None => {
                let base = joiner.mesh().points.len();
                let points = points(file, budget, notes, primitive).map_err(place)?;
                let count = points.points.len();
                morph(file, budget, primitive, base, count, shared.is_some(), &mut targets).map_err(place)?;
                joiner.append(budget, &points, None, false).map_err(place)?;
                shared = Some((primitive, base));
                (base, count)
            }
        };
        let corners = corners(file, budget, notes, primitive, mode, count).map_err(place)?;
        let slot = match primitive.material {
            Some(material) if material.value() < file.json.materials.len() => Some(material.value() as u32),
            Some(material) => {
                return Err(place(Error::invalid(format!("material {} does not exist", material.value()))));
            }
            None if file.json.materials.is_empty() => None,
            None => {
                // The slot of no material comes behind those of the file.
                if materials.len() == file.json.materials.len() {
                    materials.push(String::new());
                }
                Some(file.json.materials.len() as u32)
            }
        };
        joiner.add_faces(budget, base as u32, &corners, slot).map_err(place)?;
    }
    notes.extend(joiner.notes());
    let mut mesh = joiner.into_mesh();
    influences::normalise(&mut mesh, notes);
    let mut weights = source.weights.clone().unwrap_or_default();
    if weights.iter().any(|weight| !weight.is_finite()) {
        return Err(Error::invalid("a morph weight is not finite")
            .at(format!("mesh {index}"))
            .advise("give every weight an ordinary number"));
    }
    weights.resize(targets.len(), 0.0);
    Ok(Part { name: source.name.clone().unwrap_or_default(), mesh, targets, weights })
}

/// How the primitive makes triangles, `None` if it does not.
fn triangles_mode(primitive: &Primitive) -> Result<Option<Mode>> {
    Ok(match understood(&primitive.mode, "mode")? {
        mode @ (Mode::Triangles | Mode::TriangleStrip | Mode::TriangleFan) => Some(mode),
        _ => None,
    })
}

fn target_indices(primitive: &Primitive) -> Vec<Option<usize>> {
    let targets = primitive.targets.as_deref().unwrap_or_default();
    targets.iter().map(|target| target.positions.map(|index| index.value())).collect()
}

/// Sets of texture coordinates, of colours and of joints that are read.
pub(super) const SETS: u32 = 8;

/// The points of a primitive with their attributes.
fn points(file: &Container, budget: &mut Budget, notes: &mut Notes, primitive: &Primitive) -> Result<Mesh> {
    let find = |semantic: Semantic| primitive.attributes.get(&Checked::Valid(semantic)).map(|index| index.value());
    let positions = find(Semantic::Positions)
        .ok_or_else(|| Error::invalid("it has no positions").advise("export the mesh with positions"))?;
    let wanted = Wanted { shapes: &[Type::Vec3], count: None };
    let (values, _) = floats(file, budget, positions, &wanted).map_err(|error| error.at("POSITION"))?;
    let mut points: Vec<[f32; 3]> = Vec::new();
    budget.reserve(&mut points, values.len() / 3)?;
    points.extend_from_slice(values.as_chunks().0);
    let count = Some(points.len());
    let mut attributes = Vec::new();
    let mut add = |name: String, width: usize, values: Values| {
        attributes.push(Attribute { name, domain: Domain::Point, width: width as u32, values, indices: None });
    };
    for (semantic, index) in &primitive.attributes {
        let index = index.value();
        let Checked::Valid(semantic) = semantic else {
            notes.add("attributes of the application's own are left out", 0);
            continue;
        };
        let place = |error: Error| error.at(format!("{semantic:?}"));
        match semantic {
            Semantic::TexCoords(SETS..) | Semantic::Colors(SETS..) => {
                notes.add("only the first eight sets of texture coordinates and colours are read", 0);
            }
            Semantic::Normals => {
                let wanted = Wanted { shapes: &[Type::Vec3], count };
                add("normal".into(), 3, Values::F32(floats(file, budget, index, &wanted).map_err(place)?.0));
            }
            Semantic::TexCoords(set) => {
                let wanted = Wanted { shapes: &[Type::Vec2], count };
                let (mut values, _) = floats(file, budget, index, &wanted).map_err(place)?;
                // glTF counts v from the top of the image.
                values.iter_mut().skip(1).step_by(2).for_each(|v| *v = 1.0 - *v);
                add(numbered("uv", *set), 2, Values::F32(values));
            }
            Semantic::Colors(set) => {
                let wanted = Wanted { shapes: &[Type::Vec3, Type::Vec4], count };
                let (values, shape) = floats(file, budget, index, &wanted).map_err(place)?;
                add(numbered("color", *set), shape.multiplicity(), Values::F32(values));
            }
            // Read together below.
            Semantic::Joints(_) | Semantic::Weights(_) => {}
            Semantic::Positions | Semantic::Tangents => {}
        }
    }
    if let Some((joints, weights)) = influences::read(file, (budget, notes), primitive, points.len())? {
        add("joints".into(), 4, Values::U32(joints));
        add("weights".into(), 4, Values::F32(weights));
    }
    Ok(Mesh { points, attributes, ..Mesh::default() })
}

fn numbered(name: &str, set: u32) -> String {
    if set == 0 { name.into() } else { format!("{name}{set}") }
}

/// Appends the morph targets of a primitive whose points begin at `base`.
fn morph(
    file: &Container,
    budget: &mut Budget,
    primitive: &Primitive,
    base: usize,
    count: usize,
    later: bool,
    targets: &mut Vec<Vec<[f32; 3]>>,
) -> Result<()> {
    let sources = primitive.targets.as_deref().unwrap_or_default();
    if later && sources.len() != targets.len() {
        return Err(Error::invalid(format!("it has {} morph targets instead of {}", sources.len(), targets.len()))
            .advise("primitives of one mesh have equally many"));
    }
    for (number, source) in sources.iter().enumerate() {
        if number == targets.len() {
            budget.push(targets, Vec::new())?;
        }
        let target = &mut targets[number];
        budget.reserve_more(target, count)?;
        match source.positions {
            Some(index) => {
                let wanted = Wanted { shapes: &[Type::Vec3], count: Some(count) };
                let (values, _) = floats(file, budget, index.value(), &wanted)
                    .map_err(|error| error.at(format!("morph target {number}")))?;
                target.extend_from_slice(values.as_chunks().0);
            }
            None => target.resize(base + count, [0.0; 3]),
        }
    }
    Ok(())
}

/// The corners of a primitive's triangles among its `count` points. Triangles that repeat a point, of which strips
/// are full, are left out.
fn corners(
    file: &Container,
    budget: &mut Budget,
    notes: &mut Notes,
    primitive: &Primitive,
    mode: Mode,
    count: usize,
) -> Result<Vec<u32>> {
    let indices = match primitive.indices {
        Some(index) => {
            let wanted = Wanted { shapes: &[Type::Scalar], count: None };
            integers(file, budget, index.value(), &wanted).map_err(|error| error.at("indices"))?
        }
        None => {
            let mut indices = Vec::new();
            budget.reserve(&mut indices, count)?;
            indices.extend(0..u32::try_from(count).map_err(|_| Error::unsupported("it has 2^32 or more points"))?);
            indices
        }
    };
    if let Some(at) = indices.iter().position(|index| *index as usize >= count) {
        return Err(Error::invalid(format!("point {} does not exist", indices[at]))
            .at(format!("index {at}"))
            .advise(format!("its {count} points count from 0")));
    }
    let whole = mode != Mode::Triangles || indices.len() % 3 == 0;
    if !whole || (!indices.is_empty() && indices.len() < 3) {
        return Err(Error::invalid(format!("{} corners make no whole triangles", indices.len()))
            .advise("the file is damaged; export it again"));
    }
    let triangles = match mode {
        Mode::Triangles => indices.len() / 3,
        _ => indices.len().saturating_sub(2),
    };
    let mut corners = Vec::new();
    budget.reserve(&mut corners, 3 * triangles)?;
    for index in 0..triangles {
        let triangle = match mode {
            Mode::Triangles => [3 * index, 3 * index + 1, 3 * index + 2],
            Mode::TriangleStrip => [index, index + 1 + index % 2, index + 2 - index % 2],
            _ => [0, index + 1, index + 2],
        };
        let [a, b, c] = triangle.map(|at| indices[at]);
        if a != b && b != c && c != a {
            corners.extend([a, b, c]);
        } else if mode == Mode::Triangles {
            notes.add("triangles that repeat a point are left out", 0);
        }
    }
    Ok(corners)
}
