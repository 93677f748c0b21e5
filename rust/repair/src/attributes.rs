//! The repaired mesh with the attributes of the one that was given.

use relievo_core::{Attribute, Crease, Domain, Mesh, Values};

use crate::corners::Corners;

/// Attributes that belong to points even where points with different values are welded: a skin has one pose for each.
const OF_POINTS: [&str; 2] = ["joints", "weights"];

/// Returns the attributes on points whose values differ between welded points, and which hence become attributes on
/// corners.
pub fn seams(mesh: &Mesh, joined: &[u32]) -> Vec<String> {
    let is_seam = |attribute: &&Attribute| {
        attribute.domain == Domain::Point
            && !OF_POINTS.contains(&attribute.name.as_str())
            && (0..).zip(joined).any(|(point, to)| point != *to && !same(attribute, point, *to))
    };
    mesh.attributes.iter().filter(is_seam).map(|attribute| attribute.name.clone()).collect()
}

fn same(attribute: &Attribute, a: u32, b: u32) -> bool {
    let width = attribute.width as usize;
    let range = |at: u32| at as usize * width..(at as usize + 1) * width;
    match &attribute.values {
        Values::F32(values) => values[range(a)].iter().zip(&values[range(b)]).all(|(a, b)| a.to_bits() == b.to_bits()),
        Values::U32(values) => values[range(a)] == values[range(b)],
    }
}

/// A mesh, and the point and face of the input of each of its own; `u32::MAX` for points of fillings.
pub struct Assembled {
    pub mesh: Mesh,
    pub point_origins: Vec<u32>,
    pub face_origins: Vec<u32>,
}

/// Makes the repaired mesh. `joined` is the point that each point of the input was welded to, `seams` the attributes on
/// points that become attributes on corners.
pub fn assemble(input: &Mesh, corners: Corners, joined: &[u32], seams: &[String], drop_unused: bool) -> Assembled {
    // Points without gaps.
    let mut is_kept = vec![false; corners.places.len()];
    if !drop_unused {
        let is_single =
            |point: usize| joined[point] as usize == point && input.points[point].iter().all(|it| it.is_finite());
        (0..input.points.len()).filter(|point| is_single(*point)).for_each(|point| is_kept[point] = true);
    }
    corners.points.iter().for_each(|point| is_kept[*point as usize] = true);
    let mut numbers = vec![NONE; corners.places.len()];
    let mut kept = Vec::new();
    for point in (0..corners.places.len()).filter(|point| is_kept[*point]) {
        numbers[point] = kept.len() as u32;
        kept.push(point);
    }
    let values = Blended { input, corners: &corners };
    let mut mesh = Mesh::new(
        kept.iter().map(|point| corners.places[*point]).collect(),
        corners.starts.windows(2).map(|face| face[1] - face[0]).collect(),
        corners.points.iter().map(|point| numbers[*point as usize]).collect(),
    );
    for attribute in &input.attributes {
        mesh.attributes.push(match attribute.domain {
            Domain::Point if seams.contains(&attribute.name) => values.of_seam(attribute),
            Domain::Point => values.of_points(attribute, &kept),
            Domain::Corner => values.of_corners(attribute),
            Domain::Face => values.of_faces(attribute),
        });
    }
    tags(input, &mut mesh, &corners, joined, &numbers);
    let point_origins = kept.iter().map(|point| corners.input_point(*point as u32).unwrap_or(NONE)).collect();
    Assembled { mesh, point_origins, face_origins: corners.face_origins }
}

const NONE: u32 = u32::MAX;

/// Carries creases, sharp points and holes over.
fn tags(input: &Mesh, mesh: &mut Mesh, corners: &Corners, joined: &[u32], numbers: &[u32]) {
    let moved = |point: u32| numbers[joined[point as usize] as usize];
    mesh.creases = input
        .creases
        .iter()
        .map(|crease| Crease { points: crease.points.map(moved), ..*crease })
        .filter(|crease| !crease.points.contains(&NONE) && crease.points[0] != crease.points[1])
        .collect();
    let sharp = input.sharp_points.iter().map(|(point, sharpness)| (moved(*point), *sharpness));
    mesh.sharp_points = sharp.filter(|(point, _)| *point != NONE).collect();
    if input.holes.is_empty() {
        return;
    }
    let mut is_hole = vec![false; input.face_count()];
    input.holes.iter().for_each(|face| is_hole[*face as usize] = true);
    // Fillings are no holes, whatever lies beside them.
    let faces = (0..corners.first_filling).zip(&corners.face_origins);
    mesh.holes = faces.filter(|(_, origin)| is_hole[**origin as usize]).map(|(face, _)| face).collect();
}

/// Attributes of the input, and the values of new points and corners.
struct Blended<'a> {
    input: &'a Mesh,
    corners: &'a Corners,
}

impl Blended<'_> {
    fn of_points(&self, attribute: &Attribute, kept: &[usize]) -> Attribute {
        let own = |corner: u32| self.input.corners[corner as usize];
        let origin = |point: &usize| self.corners.place_origins[*point];
        let values = self.gathered(attribute, own, self.corners.input_points, kept.iter().map(origin));
        Attribute { name: attribute.name.clone(), values, indices: None, ..*attribute }
    }

    /// An attribute on points as one on corners that refer to the same values.
    fn of_seam(&self, attribute: &Attribute) -> Attribute {
        let own = |corner: u32| self.input.corners[corner as usize];
        self.listed(attribute, &own)
    }

    fn of_corners(&self, attribute: &Attribute) -> Attribute {
        if let Some(indices) = &attribute.indices {
            return self.listed(attribute, &|corner| indices[corner as usize]);
        }
        let origins = self.corners.origins.iter().copied();
        let values = self.gathered(attribute, |corner| corner, self.corners.input_corners, origins);
        Attribute { name: attribute.name.clone(), values, indices: None, ..*attribute }
    }

    fn of_faces(&self, attribute: &Attribute) -> Attribute {
        let none = u32::MAX;
        let values = self.gathered(attribute, |_| 0, none, self.corners.face_origins.iter().copied());
        Attribute { name: attribute.name.clone(), values, indices: None, ..*attribute }
    }

    /// An attribute on corners that keeps the list of its values and adds those of blends. `own` is the value of a corner of
    /// the input.
    fn listed(&self, attribute: &Attribute, own: &dyn Fn(u32) -> u32) -> Attribute {
        let count = (attribute.values.len() / attribute.width as usize) as u32;
        let all = (0..count).chain((0..self.corners.blends.len() as u32).map(|blend| count + blend));
        let values = self.gathered(attribute, own, count, all);
        let index = |origin: &u32| match origin.checked_sub(self.corners.input_corners) {
            None => own(*origin),
            Some(blend) => count + blend,
        };
        let indices = Some(self.corners.origins.iter().map(index).collect());
        Attribute { name: attribute.name.clone(), domain: Domain::Corner, width: attribute.width, values, indices }
    }

    /// The values of elements by their origins, which are blends from `first_blend` on. `own` is the value of a corner of
    /// the input.
    fn gathered(
        &self,
        attribute: &Attribute,
        own: impl Fn(u32) -> u32,
        first_blend: u32,
        origins: impl Iterator<Item = u32>,
    ) -> Values {
        let width = attribute.width as usize;
        // A skin is one pose: its joints and their weights come from the same point.
        let is_skin = OF_POINTS.contains(&attribute.name.as_str());
        let is_direction = width == 3 && attribute.name.starts_with("normal");
        match &attribute.values {
            Values::F32(values) => {
                let mix = |three: [[f32; 4]; 3]| {
                    if is_skin {
                        return three[0];
                    }
                    let mean: [f32; 4] = std::array::from_fn(|at| (three[0][at] + three[1][at] + three[2][at]) / 3.0);
                    let length = mean.iter().map(|value| value * value).sum::<f32>().sqrt();
                    if is_direction && length > 0.0 { mean.map(|value| value / length) } else { mean }
                };
                let blends = self.blends(values, width, own, mix);
                Values::F32(gather(values, &blends, width, first_blend, origins))
            }
            Values::U32(values) => {
                let most = |three: [[u32; 4]; 3]| if !is_skin && three[1] == three[2] { three[1] } else { three[0] };
                let blends = self.blends(values, width, own, most);
                Values::U32(gather(values, &blends, width, first_blend, origins))
            }
        }
    }

    /// The values of all blends, each made of three earlier ones.
    fn blends<T: Copy + Default>(
        &self,
        values: &[T],
        width: usize,
        own: impl Fn(u32) -> u32,
        mix: impl Fn([[T; 4]; 3]) -> [T; 4],
    ) -> Vec<T> {
        let mut made: Vec<T> = Vec::with_capacity(self.corners.blends.len() * width);
        for parents in &self.corners.blends {
            let three = parents.map(|parent| {
                let value = match parent.checked_sub(self.corners.input_corners) {
                    None => &values[own(parent) as usize * width..],
                    Some(blend) => &made[blend as usize * width..],
                };
                std::array::from_fn(|at| if at < width { value[at] } else { T::default() })
            });
            made.extend_from_slice(&mix(three)[..width]);
        }
        made
    }
}

fn gather<T: Copy>(
    values: &[T],
    blends: &[T],
    width: usize,
    first_blend: u32,
    origins: impl Iterator<Item = u32>,
) -> Vec<T> {
    let mut out = Vec::with_capacity(origins.size_hint().0 * width);
    for origin in origins {
        let (from, at) = match origin.checked_sub(first_blend) {
            None => (values, origin as usize),
            Some(blend) => (blends, blend as usize),
        };
        out.extend_from_slice(&from[at * width..(at + 1) * width]);
    }
    out
}
