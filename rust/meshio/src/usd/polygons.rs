//! A prim `Mesh` (OpenUSD's `UsdGeomMesh`) as a mesh: faces, subdivision tags, primvars, parts with materials, and
//! points over time.

use openusd::sdf::{Path, Value};
use relievo_core::{Attribute, Crease, Domain, Error, Mesh, Result, Values};

use super::hierarchy::Clock;
use super::stage::{Prim, Stage, word};
use crate::model::{Part, ShapeKeys};

/// Names of materials and groups, in the order of their slots.
#[derive(Default)]
pub(crate) struct Slots {
    pub materials: Vec<String>,
    pub groups: Vec<String>,
}

impl Slots {
    fn slot(list: &mut Vec<String>, name: &str) -> u32 {
        let known = list.iter().position(|known| known == name);
        known.unwrap_or_else(|| {
            list.push(name.into());
            list.len() - 1
        }) as u32
    }
}

/// Reads a mesh and its points over time; `None` if it has no faces.
pub(crate) fn part(
    stage: &Stage,
    prim: &Prim,
    subsets: &[Prim],
    slots: &mut Slots,
    clock: Clock,
) -> Result<Option<(Part, Option<ShapeKeys>)>> {
    let points = points(stage, prim, "points")?.unwrap_or_default();
    let list = |name: &str| -> Result<Vec<u32>> {
        let value = stage.property(prim, name)?;
        let Some(value) = value.rest() else { return Ok(Vec::new()) };
        stage.integers(value)?.ok_or_else(|| Error::invalid(format!("`{name}` has a number that is no index")))
    };
    let (face_sizes, mut corners) = (list("faceVertexCounts")?, list("faceVertexIndices")?);
    if face_sizes.is_empty() || points.is_empty() {
        stage.note("meshes without faces or points are left out");
        return Ok(None);
    }
    let total: u64 = face_sizes.iter().map(|size| u64::from(*size)).sum();
    if total != corners.len() as u64 {
        return Err(Error::invalid(format!("its faces have {total} corners, but {} are given", corners.len()))
            .advise("export the file again"));
    }
    if let Some(corner) = corners.iter().position(|point| *point as usize >= points.len()) {
        return Err(Error::invalid(format!("point {} does not exist", corners[corner])).at(format!("corner {corner}")));
    }
    for name in ["faceVertexCounts", "faceVertexIndices"] {
        if stage.property(prim, name)?.samples.len() > 1 {
            stage.note(&format!("the faces of {} change over time; the first are taken", prim.path));
        }
    }
    // What the other side of the surface looks at is turned, so that its front is where it should be.
    let turned = stage.property(prim, "orientation")?.rest().and_then(word) == Some("leftHanded");
    let order = Turn::new(stage, turned.then_some(&face_sizes), corners.len())?;
    order.apply(&mut corners, 1);
    let mut mesh = Mesh::new(points, face_sizes, corners);
    tags(stage, prim, &mut mesh)?;
    primvars(stage, prim, &mut mesh, &order)?;
    materials(stage, prim, subsets, slots, &mut mesh)?;
    let keys = shapes(stage, prim, &mesh, clock)?;
    Ok(Some((Part { name: prim.name().into(), mesh, ..Part::default() }, keys)))
}

/// Triples of floats at rest.
fn points(stage: &Stage, prim: &Prim, name: &str) -> Result<Option<Vec<[f32; 3]>>> {
    let value = stage.property(prim, name)?;
    value.rest().map(|value| triples(stage, value, name)).transpose()
}

fn triples(stage: &Stage, value: &Value, name: &str) -> Result<Vec<[f32; 3]>> {
    let numbers = match stage.floats(value)? {
        Some((numbers, 3)) => numbers,
        // An empty list in text has no type.
        Some((numbers, _)) if numbers.is_empty() => numbers,
        _ => return Err(Error::invalid(format!("`{name}` are no triples of floats"))),
    };
    if let Some(bad) = numbers.iter().position(|number| !number.is_finite()) {
        return Err(Error::invalid("a coordinate is not a finite number").at(format!("`{name}`, number {}", bad / 3)));
    }
    let mut list = Vec::new();
    stage.budget.borrow_mut().reserve(&mut list, numbers.len() / 3)?;
    list.extend_from_slice(numbers.as_chunks::<3>().0);
    Ok(list)
}

/// The order of the corners of faces that are turned over: the first stays the first.
struct Turn(Option<Vec<u32>>);

impl Turn {
    fn new(stage: &Stage, faces: Option<&Vec<u32>>, corners: usize) -> Result<Self> {
        let Some(faces) = faces else { return Ok(Self(None)) };
        let mut order = Vec::new();
        stage.budget.borrow_mut().reserve(&mut order, corners)?;
        let mut start = 0;
        for size in faces {
            order.extend((start..start + size.min(&1)).chain((start + 1..start + size).rev()));
            start += size;
        }
        Ok(Self(Some(order)))
    }

    /// Brings `width` numbers of every corner into order.
    fn apply<T: Copy>(&self, list: &mut Vec<T>, width: usize) {
        let Some(order) = &self.0 else { return };
        let old = std::mem::take(list);
        list.reserve_exact(old.len());
        for corner in order {
            let start = *corner as usize * width;
            list.extend_from_slice(old.get(start..start + width).unwrap_or_default());
        }
    }
}

/// Creases, sharp points and holes.
fn tags(stage: &Stage, prim: &Prim, mesh: &mut Mesh) -> Result<()> {
    let scheme = stage.property(prim, "subdivisionScheme")?;
    match scheme.rest().and_then(word) {
        None | Some("catmullClark") => {}
        Some("none") => return Ok(()),
        Some(other) => stage.note(&format!("{} is to be subdivided by {other}; Catmull-Clark is used", prim.path)),
    }
    let rule = stage.property(prim, "interpolateBoundary")?;
    if let Some(rule) = rule.rest().and_then(word).filter(|rule| *rule != "edgeAndCorner") {
        stage.note(&format!("{} has the boundary rule {rule}, which is to be chosen with the surface", prim.path));
    }
    let ints = |name: &str| -> Result<Vec<u32>> {
        let value = stage.property(prim, name)?;
        let list = value.rest().map(|value| stage.integers(value)).transpose()?;
        Ok(list.flatten().unwrap_or_default())
    };
    let numbers = |name: &str| -> Result<Vec<f32>> {
        let value = stage.property(prim, name)?;
        let list = value.rest().map(|value| stage.floats(value)).transpose()?;
        Ok(list.flatten().map(|(list, _)| list).unwrap_or_default())
    };
    let usable = |sharpness: f32| sharpness.is_finite() && sharpness > 0.0;
    let count = mesh.points.len();
    let (points, lengths, sharpnesses) =
        (ints("creaseIndices")?, ints("creaseLengths")?, numbers("creaseSharpnesses")?);
    let total: u64 = lengths.iter().map(|length| u64::from(*length)).sum();
    let edges: u64 = lengths.iter().map(|length| u64::from(length.saturating_sub(1))).sum();
    let by_edge = sharpnesses.len() as u64 == edges && sharpnesses.len() != lengths.len();
    if total != points.len() as u64 || !by_edge && sharpnesses.len() != lengths.len() {
        return Err(Error::invalid("its creases have other numbers of points, lengths and sharpnesses"));
    }
    let (mut rest, mut edge) = (points.as_slice(), 0);
    for (index, length) in lengths.iter().enumerate() {
        let (chain, tail) = rest.split_at(*length as usize);
        rest = tail;
        for pair in chain.windows(2) {
            let sharpness = sharpnesses[if by_edge { edge } else { index }];
            edge += 1;
            let [a, b] = [pair[0], pair[1]];
            if a as usize >= count || b as usize >= count || a == b {
                return Err(Error::invalid(format!("there is no edge between points {a} and {b}"))
                    .at(format!("crease {index}")));
            }
            if usable(sharpness) {
                stage.budget.borrow_mut().push(&mut mesh.creases, Crease { points: [a, b], sharpness })?;
            }
        }
    }
    let (points, sharpnesses) = (ints("cornerIndices")?, numbers("cornerSharpnesses")?);
    if points.len() != sharpnesses.len() || points.iter().any(|point| *point as usize >= count) {
        return Err(Error::invalid("its corners are not points with a sharpness each"));
    }
    mesh.sharp_points = points.into_iter().zip(sharpnesses).filter(|(_, sharpness)| usable(*sharpness)).collect();
    mesh.holes = ints("holeIndices")?;
    if let Some(face) = mesh.holes.iter().find(|face| **face as usize >= mesh.face_sizes.len()) {
        return Err(Error::invalid(format!("hole {face} is no face")));
    }
    Ok(())
}

/// Normals, velocities and primvars as attributes.
fn primvars(stage: &Stage, prim: &Prim, mesh: &mut Mesh, order: &Turn) -> Result<()> {
    let names = stage.properties(prim)?;
    let primvar = |name: &str| names.iter().any(|known| known.strip_prefix("primvars:") == Some(name));
    let mut wanted: Vec<(&str, String)> = Vec::new();
    // Texture coordinates have the name that others look for, whatever the file calls the first.
    let texture = |name: &&String| {
        let kind = stage.property_field(prim, name, "typeName").ok().flatten();
        name.starts_with("primvars:")
            && kind.as_deref().and_then(word).is_some_and(|kind| kind.starts_with("texCoord2") || kind == "float2[]")
    };
    let first = ["st", "uv", "UVMap"].into_iter().find(|name| primvar(name)).map(|name| format!("primvars:{name}"));
    let first = first.or_else(|| names.iter().find(texture).cloned());
    for name in &names {
        let plain = match name.strip_prefix("primvars:") {
            Some(plain) if plain.ends_with(":indices") => continue,
            Some("displayOpacity") => continue,
            Some("displayColor") => "color",
            Some("normals") => "normal",
            Some(_) if Some(name) == first.as_ref() => "uv",
            Some("uv" | "normal" | "color" | "material" | "velocity" | "joints" | "weights") => continue,
            Some(plain) => plain.strip_prefix("skel:").map_or(plain, |_| ""),
            None if name == "normals" && !primvar("normals") => "normal",
            None if name == "velocities" => "velocity",
            None => continue,
        };
        if plain.is_empty() {
            stage.note("skeletons are left out");
            continue;
        }
        wanted.push((name, plain.into()));
    }
    for (name, plain) in wanted {
        let found = attribute(stage, prim, name, mesh, order).map_err(|error| error.at(format!("`{name}`")))?;
        let Some(mut attribute) = found else {
            stage.note(&format!("`{name}` is left out because its values fit nothing"));
            continue;
        };
        if matches!(plain.as_str(), "normal" | "velocity" | "color") && attribute.width != 3
            || plain == "uv" && attribute.width != 2
            || plain == "velocity" && attribute.domain != Domain::Point
        {
            stage.note(&format!("`{name}` is left out because it is of another type"));
            continue;
        }
        attribute.name = plain;
        if mesh.attribute(&attribute.name).is_none() {
            mesh.attributes.push(attribute);
        }
    }
    if primvar("displayOpacity") {
        opacity(stage, prim, mesh, order)?;
    }
    Ok(())
}

/// Adds the opacity to the colour, if both sit on the same elements.
fn opacity(stage: &Stage, prim: &Prim, mesh: &mut Mesh, order: &Turn) -> Result<()> {
    let found = attribute(stage, prim, "primvars:displayOpacity", mesh, order)?;
    let color = mesh.attributes.iter_mut().find(|attribute| attribute.name == "color");
    let (Some(Attribute { values: Values::F32(alpha), width: 1, domain, indices: None, .. }), Some(color)) =
        (found, color)
    else {
        return Ok(());
    };
    let Values::F32(rgb) = &color.values else { return Ok(()) };
    if color.domain != domain || color.indices.is_some() || rgb.len() != 3 * alpha.len() {
        stage.note("the opacity is left out because it does not sit where the colours do");
        return Ok(());
    }
    let mut both = Vec::new();
    stage.budget.borrow_mut().reserve(&mut both, 4 * alpha.len())?;
    both.extend(rgb.as_chunks::<3>().0.iter().zip(&alpha).flat_map(|([r, g, b], alpha)| [*r, *g, *b, *alpha]));
    (color.values, color.width) = (Values::F32(both), 4);
    Ok(())
}

/// A property with values on points, corners or faces; `None` if they are no numbers or of another count.
fn attribute(stage: &Stage, prim: &Prim, name: &str, mesh: &Mesh, order: &Turn) -> Result<Option<Attribute>> {
    let value = stage.property(prim, name)?;
    let Some(value) = value.rest() else { return Ok(None) };
    let (values, width) = match stage.integers(value)? {
        Some(list) => (Values::U32(list), 1),
        None => match stage.floats(value)? {
            Some((list, width)) if list.iter().all(|number| number.is_finite()) => (Values::F32(list), width),
            _ => return Ok(None),
        },
    };
    let size = stage.property_field(prim, name, "elementSize")?;
    if size.is_some_and(|size| super::value::number(&size) != Some(1.0)) {
        return Ok(None);
    }
    let count = values.len() / width as usize;
    let indices = match stage.property(prim, &format!("{name}:indices"))?.rest() {
        Some(value) => match stage.integers(value)? {
            Some(list) if list.iter().all(|index| (*index as usize) < count) => Some(list),
            _ => return Ok(None),
        },
        None => None,
    };
    let given = indices.as_ref().map_or(count, Vec::len);
    let (points, corners, faces) = (mesh.points.len(), mesh.corners.len(), mesh.face_sizes.len());
    let interpolation = stage.property_field(prim, name, "interpolation")?;
    let fallback = if name.starts_with("primvars:") { "constant" } else { "vertex" };
    let domain = match interpolation.as_deref().and_then(word).unwrap_or(fallback) {
        "constant" if given == 1 => None,
        "uniform" if given == faces => Some(Domain::Face),
        "varying" | "vertex" if given == points => Some(Domain::Point),
        "faceVarying" if given == corners => Some(Domain::Corner),
        _ => return Ok(None),
    };
    let mut found = Attribute { name: String::new(), domain: domain.unwrap_or(Domain::Point), width, values, indices };
    match (domain, found.indices.take()) {
        (Some(Domain::Corner), Some(mut indices)) => {
            order.apply(&mut indices, 1);
            found.indices = Some(indices);
        }
        (Some(Domain::Corner), None) => match &mut found.values {
            Values::F32(list) => order.apply(list, width as usize),
            Values::U32(list) => order.apply(list, width as usize),
        },
        (Some(_), None) => {}
        (Some(_), Some(indices)) => found.values = taken(stage, &found.values, width, indices.len(), |at| indices[at])?,
        (None, indices) => {
            let one = indices.and_then(|indices| indices.first().copied()).unwrap_or(0);
            found.values = taken(stage, &found.values, width, points, |_| one)?;
        }
    }
    Ok(Some(found))
}

/// `count` values, each the one that `index` says.
fn taken(stage: &Stage, from: &Values, width: u32, count: usize, index: impl Fn(usize) -> u32) -> Result<Values> {
    fn all<T: Copy>(
        stage: &Stage,
        from: &[T],
        width: usize,
        count: usize,
        index: impl Fn(usize) -> u32,
    ) -> Result<Vec<T>> {
        let mut list = Vec::new();
        stage.budget.borrow_mut().reserve(&mut list, count.saturating_mul(width))?;
        for at in 0..count {
            let start = index(at) as usize * width;
            list.extend_from_slice(&from[start..start + width]);
        }
        Ok(list)
    }
    Ok(match from {
        Values::F32(from) => Values::F32(all(stage, from, width as usize, count, index)?),
        Values::U32(from) => Values::U32(all(stage, from, width as usize, count, index)?),
    })
}

/// Face attributes `material` and `group` of what the mesh and its subsets are bound to and called.
fn materials(stage: &Stage, prim: &Prim, subsets: &[Prim], slots: &mut Slots, mesh: &mut Mesh) -> Result<()> {
    let bound = |prim: &Prim| -> Result<Option<String>> {
        for relationship in ["material:binding", "material:binding:preview", "material:binding:full"] {
            let targets = stage.property_field(prim, relationship, "targetPaths")?;
            if let Some(Value::PathListOp(list)) = targets.as_deref()
                && let Some(name) = list.iter().next().and_then(Path::name)
            {
                return Ok(Some(name.to_owned()));
            }
        }
        Ok(None)
    };
    let own = bound(prim)?;
    let mut parts = Vec::new();
    let mut groups = Vec::new();
    for subset in subsets {
        let kind = stage.property(subset, "elementType")?;
        if kind.rest().and_then(word).is_some_and(|kind| kind != "face") {
            stage.note("subsets of points and edges are left out");
            continue;
        }
        let value = stage.property(subset, "indices")?;
        let faces = value.rest().map(|value| stage.integers(value)).transpose()?.flatten();
        let faces = faces.unwrap_or_default();
        if faces.iter().any(|face| *face as usize >= mesh.face_sizes.len()) {
            return Err(Error::invalid("it has a face that does not exist").at(subset.path.clone()));
        }
        let material = bound(subset)?;
        let family = stage.property(subset, "familyName")?;
        let is_material = material.is_some() || family.rest().and_then(word) == Some("materialBind");
        let name = material.unwrap_or_else(|| subset.name().to_owned());
        if is_material { parts.push((name, faces)) } else { groups.push((name, faces)) }
    }
    let mut add = |name: &str, list: &mut Vec<String>, own: Option<String>, parts: Vec<(String, Vec<u32>)>| {
        if own.is_none() && parts.is_empty() {
            return Ok(());
        }
        let covered: usize = parts.iter().map(|(_, faces)| faces.len()).sum();
        // A slot without a name is none.
        let rest = match own {
            Some(own) => Slots::slot(list, &own),
            None if covered < mesh.face_sizes.len() => Slots::slot(list, ""),
            None => 0,
        };
        let mut values = stage.budget.borrow_mut().filled(mesh.face_sizes.len(), rest)?;
        for (name, faces) in parts {
            let slot = Slots::slot(list, &name);
            faces.iter().for_each(|face| values[*face as usize] = slot);
        }
        let values = Values::U32(values);
        mesh.attributes.push(Attribute { name: name.into(), domain: Domain::Face, width: 1, values, indices: None });
        Ok::<(), Error>(())
    };
    add("material", &mut slots.materials, own, parts)?;
    add("group", &mut slots.groups, None, groups)
}

/// The points over time, if they move and stay the same in number.
fn shapes(stage: &Stage, prim: &Prim, mesh: &Mesh, clock: Clock) -> Result<Option<ShapeKeys>> {
    let value = stage.property(prim, "points")?;
    if value.samples.len() < 2 && value.default.is_none() || value.samples.is_empty() {
        return Ok(None);
    }
    let mut keys = ShapeKeys { node: 0, times: Vec::new(), points: Vec::new() };
    for (code, value) in &value.samples {
        let points = triples(stage, value, "points").map_err(|error| error.at(format!("time code {code}")))?;
        if points.len() != mesh.points.len() {
            stage.note(&format!("{} changes its points at time code {code}; it stands still", prim.path));
            return Ok(None);
        }
        keys.times.push(clock.seconds(*code));
        keys.points.push(points);
    }
    Ok(Some(keys))
}
