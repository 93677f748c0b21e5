//! Triangles with long edges cut into smaller ones, large and slender ones alike, for values at a given number of
//! places along an edge to be dense enough.
//!
//! Schäfer, Keinert, Nießner and Stamminger 2015, Local Painting and Deformation of Meshes on the GPU, Section 9, where
//! large input faces are subdivided until they are small enough. Edges are halved until none is too long; whether an
//! edge is depends on its ends alone, so that both its faces agree and no cracks open. Memory is counted before it is
//! taken. Units: object units; bytes.

use std::collections::BTreeMap;

use glam::DVec3;
use relievo_core::{Context, Crease, Domain, Error, Mesh, Result};

use super::carried::Pieces;
use super::topology::TriangleTopology;

/// What was split.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct SplitReport {
    /// Triangles that had an edge too long.
    pub split: u64,
    /// Triangles afterwards.
    pub triangles: u64,
    /// The longest edge before.
    pub longest: f64,
}

/// Most triangles that come of it.
const MAX: usize = 1 << 26;

/// A triangle on the way: its points, the face it lies in, and where its corners are in that face.
#[derive(Clone, Copy, Debug)]
struct Part {
    points: [u32; 3],
    face: u32,
    at: [[f32; 3]; 3],
}

/// The triangles of `mesh` with no edge longer than `longest`, with all attributes and creases; polygons are fanned,
/// holes left out.
///
/// # Errors
/// Fails as [`TriangleTopology::of_mesh`] does; with `Invalid` if `longest` is not positive and finite, or an edge
/// cannot get as short because no number lies between those of its ends; and with `Memory` if there would be over 2²⁶
/// triangles or points, or they would take more than the context's memory limit.
pub fn split(context: &Context, mesh: &Mesh, longest: f64) -> Result<(Mesh, SplitReport)> {
    if !(longest > 0.0 && longest.is_finite()) {
        return Err(Error::invalid(format!("edges cannot be as short as {longest}")).advise("give a length above 0"));
    }
    let topology = TriangleTopology::of_mesh(mesh)?;
    let mut points = mesh.points.clone();
    let mut creases: BTreeMap<[u32; 2], f32> = BTreeMap::new();
    for crease in &mesh.creases {
        let [a, b] = crease.points;
        creases.insert([a.min(b), a.max(b)], crease.sharpness);
    }
    let whole = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
    let faces = (0..).zip(topology.faces());
    let check = |triangles: usize, points: usize| check_size(context, mesh, longest, triangles, points);
    check((least_count(mesh, &topology, longest) as usize).max(topology.face_count()), points.len())?;
    let mut parts: Vec<Part> = faces.map(|(face, corners)| Part { points: *corners, face, at: whole }).collect();
    let mut report = SplitReport::default();
    for pass in 0.. {
        let length = |a: u32, b: u32| {
            let [a, b] = [a, b].map(|point| DVec3::from(points[point as usize].map(f64::from)));
            a.distance(b)
        };
        let mut middles: BTreeMap<[u32; 2], u32> = BTreeMap::new();
        let mut added = Vec::new();
        let (mut marked, mut count) = (0, parts.len());
        let mut stuck = None;
        for part in &parts {
            let mut any = false;
            for side in 0..3 {
                let [a, b] = [part.points[side], part.points[(side + 1) % 3]];
                let far = length(a, b);
                if pass == 0 {
                    report.longest = report.longest.max(far);
                }
                if far > longest {
                    any = true;
                    count += 1;
                    middles.entry([a.min(b), a.max(b)]).or_insert_with(|| {
                        let ends = [a.min(b), a.max(b)].map(|point| points[point as usize]);
                        let middle = std::array::from_fn(|axis| 0.5 * ends[0][axis] + 0.5 * ends[1][axis]);
                        if stuck.is_none() && is_stuck(ends, middle, longest) {
                            stuck = Some(middle);
                        }
                        added.push(middle);
                        (points.len() + added.len() - 1) as u32
                    });
                }
            }
            marked += u64::from(any);
        }
        if pass == 0 {
            report.split = marked;
        }
        if middles.is_empty() {
            break;
        }
        if let Some([x, y, z]) = stuck {
            return Err(Error::invalid(format!("an edge cannot get as short as {longest} between numbers of 32 bits"))
                .at(format!("({x}, {y}, {z})"))
                .advise("allow longer edges, or move the mesh nearer to the origin"));
        }
        check(count, points.len() + added.len())?;
        for (ends, middle) in &middles {
            if let Some(sharpness) = creases.remove(ends) {
                creases.insert([ends[0], *middle], sharpness);
                creases.insert([ends[1], *middle], sharpness);
            }
        }
        points.extend(added);
        let mut next = Vec::with_capacity(count);
        for part in parts {
            cut(&part, &middles, &points, &mut next);
        }
        parts = next;
    }
    report.triangles = parts.len() as u64;
    let mut pieces = Pieces { points: vec![None; points.len()], ..Pieces::default() };
    for part in &parts {
        for (point, at) in part.points.iter().zip(part.at) {
            if *point as usize >= mesh.points.len() {
                pieces.points[*point as usize] = Some(pieces.places.len() as u32);
            }
            pieces.corners.push(pieces.places.len() as u32);
            pieces.places.push((part.face, at));
        }
    }
    let triangles: Vec<[u32; 3]> = parts.iter().map(|part| part.points).collect();
    let mut new = Mesh::from_triangles(points, &triangles);
    new.attributes = pieces.carry(mesh, &topology, &[]);
    new.creases = creases.into_iter().map(|(points, sharpness)| Crease { points, sharpness }).collect();
    new.sharp_points = mesh.sharp_points.clone();
    Ok((new, report))
}

/// Fails if so many triangles with so many points are too many, or take too much memory.
fn check_size(context: &Context, mesh: &Mesh, longest: f64, triangles: usize, points: usize) -> Result<()> {
    if triangles.max(points) > MAX {
        return Err(Error::memory(format!("edges no longer than {longest} take over {MAX} triangles"))
            .advise("allow longer edges"));
    }
    let (bytes, limit) = (bytes(mesh, triangles as u64, points as u64), context.memory_limit());
    if bytes > limit {
        return Err(Error::memory(format!(
            "edges no longer than {longest} take {triangles} triangles or more with {bytes} bytes, over the limit of {limit}"
        ))
        .advise("allow longer edges, or raise the memory limit of the context"));
    }
    Ok(())
}

/// What so many triangles with so many points take at most while they are made.
fn bytes(mesh: &Mesh, triangles: u64, points: u64) -> u64 {
    let values = |domain: Domain| -> u64 {
        let of = mesh.attributes.iter().filter(|attribute| attribute.domain == domain);
        of.map(|attribute| 4 * u64::from(attribute.width) + if domain == Domain::Corner { 4 } else { 0 }).sum()
    };
    let size = |bytes: usize| bytes as u64;
    // Parts before and after a pass, the corners of the mesh twice, its face sizes, places and where values come from.
    let corner =
        size(3 * size_of::<u32>() + size_of::<(u32, [f32; 3])>() + size_of::<(usize, Option<(u32, [f32; 3])>)>());
    let triangle = size(2 * size_of::<Part>() + size_of::<u32>()) + values(Domain::Face);
    // Points twice, the middles that they were, and the places of those.
    let point = size(2 * size_of::<[f32; 3]>() + 2 * size_of::<([u32; 2], u32)>() + size_of::<Option<u32>>());
    triangles * (triangle + 3 * (corner + values(Domain::Corner))) + points * (point + values(Domain::Point))
}

/// Whether an edge with such ends stays too long however often it is halved.
fn is_stuck(ends: [[f32; 3]; 2], middle: [f32; 3], longest: f64) -> bool {
    let [a, b] = ends;
    let held = |axis: usize| {
        let far = (f64::from(a[axis]) - f64::from(b[axis])).abs();
        far > longest && (middle[axis] == a[axis] || middle[axis] == b[axis])
    };
    middle == a || middle == b || (0..3).any(held)
}

/// How many triangles there will be at least, by the area of the largest with such edges.
fn least_count(mesh: &Mesh, topology: &TriangleTopology, longest: f64) -> f64 {
    let point = |point: u32| DVec3::from(mesh.points[point as usize].map(f64::from));
    let area = |corners: &[u32; 3]| {
        let [a, b, c] = corners.map(point);
        0.5 * (b - a).cross(c - a).length()
    };
    topology.faces().iter().map(area).sum::<f64>() / (0.25 * 3f64.sqrt() * longest * longest)
}

/// The triangles that `part` becomes where some of its edges have a middle.
fn cut(part: &Part, middles: &BTreeMap<[u32; 2], u32>, points: &[[f32; 3]], out: &mut Vec<Part>) {
    let middle = |side: usize| {
        let [a, b] = [part.points[side], part.points[(side + 1) % 3]];
        middles.get(&[a.min(b), a.max(b)]).copied()
    };
    // Corners 0 to 2 and the middles of the sides after them, 3 to 5.
    let at: [[f32; 3]; 6] = std::array::from_fn(|k| match k {
        0..3 => part.at[k],
        _ => std::array::from_fn(|axis| 0.5 * (part.at[k - 3][axis] + part.at[(k - 2) % 3][axis])),
    });
    let found = [0, 1, 2].map(middle);
    let mut add = |corners: [usize; 3]| {
        let point = |k: usize| if k < 3 { part.points[k] } else { found[k - 3].unwrap_or(part.points[k - 3]) };
        out.push(Part { points: corners.map(point), face: part.face, at: corners.map(|k| at[k]) });
    };
    let count = found.iter().flatten().count();
    match count {
        0 => add([0, 1, 2]),
        3 => [[0, 3, 5], [3, 1, 4], [5, 4, 2], [3, 4, 5]].into_iter().for_each(add),
        _ => {
            // Turned so that side 0 is the first with a middle, after one without if there are two.
            let first = (0..3).find(|side| found[*side].is_some() && (count == 1 || found[(side + 2) % 3].is_none()));
            let s = first.unwrap_or(0);
            let [a, b, c] = [s, (s + 1) % 3, (s + 2) % 3];
            let (p, q) = (3 + a, 3 + b);
            if count == 1 {
                add([a, p, c]);
                add([p, b, c]);
                return;
            }
            // The quad a, p, q, c is cut along its shorter diagonal.
            let place = |point: Option<u32>, corner: usize| {
                DVec3::from(points[point.unwrap_or(part.points[corner]) as usize].map(f64::from))
            };
            let (pc, aq) = (place(found[a], a) - place(None, c), place(None, a) - place(found[b], b));
            add([p, b, q]);
            if pc.length_squared() <= aq.length_squared() {
                add([a, p, c]);
                add([p, q, c]);
            } else {
                add([a, p, q]);
                add([a, q, c]);
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use relievo_core::{Attribute, Domain, Values};

    fn sheet() -> Mesh {
        let points = vec![[0.0; 3], [4.0, 0.0, 0.0], [4.0, 0.1, 0.0], [0.0, 3.0, 0.0], [9.0; 3], [0.1, 3.1, 0.5]];
        let mut mesh = Mesh::new(points, vec![3, 4], vec![0, 1, 2, 0, 2, 5, 3]);
        let uv = (0..7).flat_map(|k| {
            let p = mesh.points[mesh.corners[k] as usize];
            [p[0] + 10.0 * f32::from(k > 2), p[1]]
        });
        let uv = Values::F32(uv.collect());
        mesh.attributes.push(Attribute {
            name: "uv".into(),
            domain: Domain::Corner,
            width: 2,
            values: uv,
            indices: None,
        });
        let place = Values::F32(mesh.points.as_flattened().to_vec());
        mesh.attributes.push(Attribute {
            name: "place".into(),
            domain: Domain::Point,
            width: 3,
            values: place,
            indices: None,
        });
        let material = Values::U32(vec![7, 8]);
        mesh.attributes.push(Attribute {
            name: "material".into(),
            domain: Domain::Face,
            width: 1,
            values: material,
            indices: None,
        });
        mesh.creases.push(Crease { points: [2, 0], sharpness: 3.0 });
        mesh
    }

    #[test]
    fn no_edge_is_too_long_and_nothing_opens() {
        let (context, mesh) = (Context::serial(), sheet());
        for longest in [10.0, 2.0, 0.7, 0.11] {
            let (new, report) = split(&context, &mesh, longest).unwrap();
            new.check().unwrap();
            let topology = TriangleTopology::of_mesh(&new).unwrap();
            assert_eq!(report.triangles as usize, topology.face_count());
            assert!((report.longest - 5.0).abs() < 0.1);
            let point = |point: u32| DVec3::from(new.points[point as usize].map(f64::from));
            for edge in 0..topology.edge_count() as u32 {
                let [a, b] = topology.edge(edge).map(point);
                assert!(a.distance(b) <= longest);
            }
            let area = |mesh: &Mesh| -> f64 {
                let at = |p: u32| DVec3::from(mesh.points[p as usize].map(f64::from));
                mesh.triangles().iter().map(|[a, b, c]| (at(*b) - at(*a)).cross(at(*c) - at(*a)).length()).sum()
            };
            assert!((area(&new) - area(&mesh)).abs() < 1e-4);
            // One boundary as long as before.
            let boundary = |topology: &TriangleTopology, points: &[[f32; 3]]| -> f64 {
                let open = (0..topology.edge_count() as u32).filter(|edge| topology.faces_along(*edge).len() == 1);
                open.map(|edge| {
                    let [a, b] = topology.edge(edge).map(|p| DVec3::from(points[p as usize].map(f64::from)));
                    a.distance(b)
                })
                .sum()
            };
            let old = TriangleTopology::of_mesh(&mesh).unwrap();
            assert!((boundary(&topology, &new.points) - boundary(&old, &mesh.points)).abs() < 1e-4);
        }
        assert_eq!(split(&context, &mesh, 10.0).unwrap().1.split, 0);
        assert!(
            split(&context, &mesh, 0.0).is_err()
                && split(&context, &mesh, f64::NAN).is_err()
                && split(&context, &mesh, 1e-9).is_err()
        );
    }

    #[test]
    fn attributes_and_creases_are_kept() {
        let (context, mesh) = (Context::serial(), sheet());
        let (new, _) = split(&context, &mesh, 0.5).unwrap();
        let floats = |name: &str| match &new.attribute(name).unwrap().values {
            Values::F32(values) => values.clone(),
            Values::U32(_) => panic!(),
        };
        let Values::U32(material) = &new.attribute("material").unwrap().values else { panic!() };
        let (uv, place) = (floats("uv"), floats("place"));
        let indices = new.attribute("uv").unwrap().indices.clone().unwrap();
        for (corner, point) in new.corners.iter().enumerate() {
            let p = new.points[*point as usize];
            let seam = if material[corner / 3] == 8 { 10.0 } else { 0.0 };
            let value = indices[corner] as usize;
            assert!((uv[2 * value] - p[0] - seam).abs() < 1e-5 && (uv[2 * value + 1] - p[1]).abs() < 1e-5);
            assert!((0..3).all(|axis| (place[3 * *point as usize + axis] - p[axis]).abs() < 1e-5));
        }
        let length: f64 = new
            .creases
            .iter()
            .map(|crease| {
                assert_eq!(crease.sharpness, 3.0);
                let [a, b] = crease.points.map(|p| DVec3::from(new.points[p as usize].map(f64::from)));
                a.distance(b)
            })
            .sum();
        assert!(new.creases.len() > 4 && (length - 4.00125).abs() < 1e-3, "{length}");
    }

    #[test]
    fn what_exceeds_the_memory_limit_is_refused_before_it_is_made() {
        use relievo_core::{ContextOptions, ErrorKind};
        let mesh = sheet();
        let limit = 1 << 20;
        let small = Context::new(&ContextOptions { threads: 1, memory_limit: limit }).unwrap();
        let (some, report) = split(&small, &mesh, 0.2).unwrap();
        assert!(bytes(&mesh, report.triangles, some.points.len() as u64) <= limit);
        assert_eq!(split(&Context::serial(), &mesh, 0.2).unwrap().0, some);
        // By the area at once, and by the count on the way.
        for longest in [1e-3, 0.06] {
            let error = split(&small, &mesh, longest).map(|(_, report)| report).unwrap_err();
            assert!(error.kind == ErrorKind::Memory && error.to_string().contains("memory limit"), "{error}");
        }
        assert!(split(&Context::serial(), &mesh, 0.06).is_ok());
        let none = Context::new(&ContextOptions { threads: 1, memory_limit: 100 }).unwrap();
        assert!(split(&none, &mesh, 100.0).is_err());
    }

    #[test]
    fn edges_between_neighbouring_numbers_are_refused() {
        let context = Context::serial();
        // Numbers above 2²⁰ are 1/8 apart.
        let far = |offset: [f32; 3]| {
            let mut mesh = sheet();
            mesh.points.iter_mut().for_each(|p| (0..3).for_each(|axis| p[axis] += offset[axis]));
            mesh.attributes.clear();
            mesh
        };
        for offset in [[1_048_576.0, 0.0, 0.0], [1_048_576.0; 3], [0.0, -1_048_600.0, 0.0]] {
            let error = split(&context, &far(offset), 0.1).map(|(_, report)| report).unwrap_err();
            assert!(error.to_string().contains("cannot get as short as 0.1"), "{error}");
            let (mesh, _) = split(&context, &far(offset), 0.5).unwrap();
            mesh.check().unwrap();
        }
        assert!(split(&context, &far([1000.0; 3]), 0.1).is_ok());
    }
}
