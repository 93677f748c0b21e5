//! Stickers that overlap themselves: which part lies on top, and how far a mesh of them is lifted.

use std::collections::{BTreeMap, BinaryHeap};

use glam::{DVec2, DVec3};
use relievo_core::{Mesh, Result};
use relievo_decal::Decal;

/// The way over which a mesh rises by an offset, in offsets.
const RAMP: f64 = 8.0;
/// How far two triangles may reach into one another without overlapping, as a share of their face.
const TOUCH: f64 = 1e-6;

/// Returns a decal as a mesh, as [`Decal::mesh`] does, lifted off the surface by `offset`, and where the sticker overlaps
/// itself by as many offsets as parts lie below. `depths` are those of the pins: the part near pins of larger depths lies on
/// top, without depths the right part of the image. The mesh rises to an upper part over a way of 8 offsets.
///
/// # Errors
/// There are depths, but not one for each pin.
pub fn lifted(decal: &Decal, depths: &[f64], offset: f64) -> Result<Mesh> {
    decal.check_depths(depths)?;
    let mut mesh = decal.mesh(0.0);
    let lifts = levels(decal, depths, offset);
    for (vertex, point) in mesh.points.iter_mut().enumerate() {
        let (place, normal) = (DVec3::from(decal.points[vertex]), DVec3::from(decal.normals[vertex]));
        *point = (place + offset * (1.0 + lifts[vertex]) * normal).as_vec3().to_array();
    }
    Ok(mesh)
}

/// A level that spreads from a vertex, the highest first.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Spread {
    level: f64,
    vertex: u32,
}

impl Eq for Spread {}

impl Ord for Spread {
    fn cmp(&self, other: &Self) -> std::cmp::Ordering {
        self.level.total_cmp(&other.level).then(other.vertex.cmp(&self.vertex))
    }
}

impl PartialOrd for Spread {
    fn partial_cmp(&self, other: &Self) -> Option<std::cmp::Ordering> {
        Some(self.cmp(other))
    }
}

/// How many parts of the sticker lie below each vertex, falling to 0 around the overlap. 0 everywhere for an offset that is
/// not positive.
fn levels(decal: &Decal, depths: &[f64], offset: f64) -> Vec<f64> {
    let mut levels = vec![0.0; decal.points.len()];
    if offset <= 0.0 {
        return levels;
    }
    for (triangle, below) in decal.triangles.iter().zip(parts_below(decal, depths)) {
        for vertex in triangle {
            let level = &mut levels[*vertex as usize];
            *level = f64::max(*level, f64::from(below));
        }
    }
    let mut beside: Vec<Vec<u32>> = vec![Vec::new(); levels.len()];
    for [a, b, c] in &decal.triangles {
        for (from, to) in [(a, b), (b, c), (c, a)] {
            beside[*from as usize].push(*to);
            beside[*to as usize].push(*from);
        }
    }
    let started = (0..).zip(&levels).filter(|(_, level)| **level > 0.0);
    let mut heap: BinaryHeap<Spread> = started.map(|(vertex, level)| Spread { level: *level, vertex }).collect();
    let point = |vertex: u32| DVec3::from(decal.points[vertex as usize]);
    while let Some(Spread { level, vertex }) = heap.pop() {
        if level < levels[vertex as usize] {
            continue;
        }
        for other in &beside[vertex as usize] {
            let fallen = level - point(vertex).distance(point(*other)) / (RAMP * offset);
            if fallen > levels[*other as usize] {
                levels[*other as usize] = fallen;
                heap.push(Spread { level: fallen, vertex: *other });
            }
        }
    }
    levels
}

/// Returns how many parts of the sticker lie below each triangle of a decal. `depths` are those of [`lifted`].
pub fn parts_below(decal: &Decal, depths: &[f64]) -> Vec<u32> {
    let mut on_faces: BTreeMap<u32, Vec<usize>> = BTreeMap::new();
    for (triangle, face) in decal.faces.iter().enumerate() {
        on_faces.entry(*face).or_default().push(triangle);
    }
    let middle = |triangle: usize| {
        let places = decal.triangles[triangle].map(|vertex| DVec2::from(decal.uv[vertex as usize]));
        (places[0] + places[1] + places[2]) / 3.0
    };
    let height = |triangle: usize| decal.height(middle(triangle).to_array(), depths);
    let mut below = vec![0; decal.triangles.len()];
    for mut triangles in on_faces.into_values().filter(|triangles| triangles.len() > 1) {
        triangles.sort_by(|a, b| height(*a).total_cmp(&height(*b)));
        for (at, upper) in triangles.iter().enumerate() {
            let under = triangles[..at].iter().filter(|lower| overlaps(decal, *upper, **lower));
            below[*upper] = under.map(|lower| below[*lower] + 1).max().unwrap_or(0);
        }
    }
    below
}

/// Whether two triangles in one plane overlap: no edge of them has all of the other beyond it.
fn overlaps(decal: &Decal, a: usize, b: usize) -> bool {
    let corners = |triangle: usize| decal.triangles[triangle].map(|vertex| DVec3::from(decal.points[vertex as usize]));
    let (a, b) = (corners(a), corners(b));
    let normal = |[p, q, r]: [DVec3; 3]| (q - p).cross(r - p);
    let across = normal(a) + normal(b);
    let slack = TOUCH * across.length();
    let apart = |from: [DVec3; 3], other: [DVec3; 3]| {
        (0..3).any(|corner| {
            let (start, end) = (from[corner], from[(corner + 1) % 3]);
            let outwards = (end - start).cross(across).normalize_or_zero();
            let reach = slack / (end - start).length().max(f64::MIN_POSITIVE);
            other.iter().all(|point| outwards.dot(*point - start) > -reach)
        })
    };
    !apart(a, b) && !apart(b, a)
}

#[cfg(test)]
mod tests {
    use super::*;
    use relievo_core::progress::Silent;
    use relievo_decal::{DecalSettings, Pin, Pose, Sticker, lay, nearest};

    /// A tube of radius 1 along z, from -3 to 3.
    fn tube() -> Mesh {
        const AROUND: u32 = 24;
        const RINGS: u32 = 15;
        let points = (0..AROUND * RINGS).map(|index| {
            let turn = f64::from(index % AROUND) * std::f64::consts::TAU / f64::from(AROUND);
            let z = 6.0 * f64::from(index / AROUND) / f64::from(RINGS - 1) - 3.0;
            [turn.cos() as f32, turn.sin() as f32, z as f32]
        });
        let quads = (0..AROUND * (RINGS - 1)).flat_map(|index| {
            let (ring, at) = (index / AROUND * AROUND, index % AROUND);
            let [a, b] = [ring + at, ring + (at + 1) % AROUND];
            [[a, b, b + AROUND], [a, b + AROUND, a + AROUND]]
        });
        Mesh::from_triangles(points.collect(), &quads.collect::<Vec<_>>())
    }

    /// A sticker of 300 by 60 pixels that goes around the tube one and a half times, with pins at its left and right end.
    fn wound() -> Decal {
        let mesh = tube();
        let pin = Pin { image: [150.0, 30.0], place: nearest(&mesh, [1.0, 0.0, 0.1]).unwrap().0 };
        let pose = Pose { width: 1.5 * std::f64::consts::TAU, up: [0.0, 0.0, 1.0] };
        let settings = DecalSettings { overlap: true, ..DecalSettings::default() };
        let sticker = Sticker::whole([300, 60]).unwrap();
        let mut decal = lay(&mesh, &sticker, &[pin], Some(pose), &settings, &mut Silent).unwrap();
        let end = |a: &u32, b: &u32| decal.uv[*a as usize][0].total_cmp(&decal.uv[*b as usize][0]);
        let all = || 0..decal.uv.len() as u32;
        decal.pins = vec![all().min_by(end).unwrap(), all().max_by(end).unwrap()];
        decal
    }

    #[test]
    fn the_upper_part_of_a_wound_sticker_lies_an_offset_above_the_lower_one() {
        let decal = wound();
        let offset = 0.01;
        for (depths, right_is_upper) in [(vec![], true), (vec![1.0, 0.0], false)] {
            let mesh = lifted(&decal, &depths, offset).unwrap();
            let height = |vertex: usize| {
                let way = DVec3::from(mesh.points[vertex].map(f64::from)) - DVec3::from(decal.points[vertex]);
                way.dot(decal.normals[vertex].into()) / offset
            };
            let below = parts_below(&decal, &depths);
            let mut upper = 0;
            for (triangle, below) in decal.triangles.iter().zip(&below) {
                let u = decal.uv[triangle[0] as usize][0];
                for vertex in triangle.map(|vertex| vertex as usize) {
                    // A third of the sticker lies on another third.
                    assert!(height(vertex) > 0.999 + f64::from(*below), "{u} {}", height(vertex));
                    assert!(height(vertex) < 2.001);
                }
                upper += below;
                assert!(*below == 0 || (u > 0.5) == right_is_upper, "{u}");
                let is_middle = (0.45..0.55).contains(&u);
                assert!(!is_middle || height(triangle[0] as usize) < 1.001);
            }
            let share = f64::from(upper) / decal.triangles.len() as f64;
            assert!((0.25..0.42).contains(&share), "{share}");
        }
        assert!(lifted(&decal, &[1.0], offset).unwrap_err().to_string().contains("1 depths for 2 pins"));
    }

    #[test]
    fn nothing_is_lifted_where_nothing_overlaps() {
        let mut decal = wound();
        let keep: Vec<bool> = decal.triangles.iter().map(|[a, ..]| decal.uv[*a as usize][0] < 0.5).collect();
        let mut at = keep.iter();
        decal.triangles.retain(|_| *at.next().unwrap());
        let mut at = keep.iter();
        decal.faces.retain(|_| *at.next().unwrap());
        assert_eq!(lifted(&decal, &[], 0.01).unwrap().points, decal.mesh(0.01).points);
    }
}
