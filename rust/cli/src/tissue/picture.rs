//! What pictures of a model show: its outer elements, cut open or not, and the surfaces bound to it, in colours.

use glam::{DVec3, Vec3};
use relievo_core::{Context, Result};
use relievo_render as render;
use relievo_render::color::Color;
use relievo_tissue::{ElementState, Simulation};

use super::render::{Cut, Show};

/// Colours of materials and muscles (Okabe, Ito 2008), linear.
const COLORS: [Color; 8] = [
    [0.791, 0.347, 0.0],
    [0.093, 0.456, 0.815],
    [0.0, 0.342, 0.171],
    [0.871, 0.776, 0.054],
    [0.0, 0.168, 0.445],
    [0.665, 0.112, 0.0],
    [0.604, 0.191, 0.386],
    [0.2, 0.2, 0.2],
];
/// The colour of what has no muscle.
const PALE: Color = [0.62, 0.5, 0.42];
/// The colour map viridis at equal distances, linear.
const VIRIDIS: [Color; 6] = [
    [0.058, 0.000_3, 0.089],
    [0.054, 0.059, 0.237],
    [0.023, 0.146, 0.271],
    [0.013, 0.264, 0.243],
    [0.119, 0.462, 0.12],
    [0.984, 0.799, 0.018],
];

/// Colours of elements and their legend.
pub struct Coloring {
    pub colors: Vec<Color>,
    pub legend: Vec<(Color, String)>,
}

/// Returns the colour of a share from 0 to 1.
fn viridis(share: f32) -> Color {
    let at = share.clamp(0.0, 1.0) * (VIRIDIS.len() - 1) as f32;
    let low = (at as usize).min(VIRIDIS.len() - 2);
    std::array::from_fn(|part| VIRIDIS[low][part] + (at - low as f32) * (VIRIDIS[low + 1][part] - VIRIDIS[low][part]))
}

/// Returns the colours of the elements. `most` is what the brightest colour stands for; left out, nearly the largest value.
pub fn coloring(context: &Context, simulation: &Simulation, show: Show, most: Option<f32>) -> Result<Coloring> {
    let model = simulation.model();
    match show {
        Show::Material => {
            let color = |element: usize| {
                let mut sum = [0.0; 3];
                for portion in model.mixtures.get(element) {
                    let color = COLORS[portion.material as usize % COLORS.len()];
                    (0..3).for_each(|part| sum[part] += portion.share * color[part]);
                }
                sum.map(|part: f32| part.clamp(0.0, 1.0))
            };
            let legend =
                (0..).zip(&model.materials).map(|(at, material)| (COLORS[at % COLORS.len()], material.name.clone()));
            Ok(Coloring { colors: (0..model.elements.len()).map(color).collect(), legend: legend.collect() })
        }
        Show::Muscle => {
            let color = |element: usize| {
                let mut sum = PALE;
                for fibre in model.fibres.get(element) {
                    let color = COLORS[fibre.muscle as usize % COLORS.len()];
                    (0..3).for_each(|part| sum[part] += fibre.share * (color[part] - PALE[part]));
                }
                sum.map(|part| part.clamp(0.0, 1.0))
            };
            let legend = (0..).zip(&model.muscles).map(|(at, muscle)| (COLORS[at % COLORS.len()], muscle.name.clone()));
            Ok(Coloring { colors: (0..model.elements.len()).map(color).collect(), legend: legend.collect() })
        }
        Show::Stress => {
            let states = simulation.element_states(context)?;
            Ok(measured(&states, most, "Pa", |state| state.von_mises))
        }
        Show::Strain => {
            let states = simulation.element_states(context)?;
            Ok(measured(&states, most, "of volume", |state| (state.volume - 1.0).abs()))
        }
        Show::Surface => Ok(Coloring { colors: vec![PALE; model.elements.len()], legend: Vec::new() }),
    }
}

fn measured(states: &[ElementState], most: Option<f32>, unit: &str, of: impl Fn(&ElementState) -> f32) -> Coloring {
    let values: Vec<f32> = states.iter().map(of).collect();
    let mut sorted = values.clone();
    sorted.sort_unstable_by(f32::total_cmp);
    // A few elements at edges have far more than all others.
    let most = most.unwrap_or_else(|| sorted[(sorted.len() - 1) * 98 / 100]);
    let most = if most > 0.0 { most } else { 1.0 };
    let legend = (0..=4).rev().map(|step| {
        let share = step as f32 / 4.0;
        (viridis(share), format!("{:.3e} {unit}", share * most))
    });
    Coloring { colors: values.iter().map(|value| viridis(value / most)).collect(), legend: legend.collect() }
}

/// Tetrahedra that fill a hexahedron, around its diagonal from corner 0 to corner 6.
const TETRAHEDRA: [[usize; 4]; 6] =
    [[0, 1, 2, 6], [0, 2, 3, 6], [0, 3, 7, 6], [0, 7, 4, 6], [0, 4, 5, 6], [0, 5, 1, 6]];

/// Returns the outer faces of what a cut leaves as seen from `eye`, and the faces that it lays open, each with the colour of
/// its element.
pub fn faces(simulation: &Simulation, cut: Option<Cut>, eye: DVec3, colors: &[Color]) -> render::Mesh {
    let model = simulation.model();
    let positions = simulation.positions();
    let mut mesh = render::Mesh::default();
    let Some(cut) = cut else {
        for (element, nodes) in model.outer_faces() {
            add(&mut mesh, &nodes.map(|node| Vec3::from(positions[node as usize])), colors[element as usize]);
        }
        return mesh;
    };
    let sign = if eye[cut.axis] > f64::from(cut.at) { 1.0 } else { -1.0 };
    // Places with their distances from the plane at rest, above 0 on the camera's side.
    let place = |node: u32| {
        let distance = sign * (model.nodes[node as usize][cut.axis] - cut.at);
        (Vec3::from(positions[node as usize]), distance)
    };
    for (element, nodes) in model.outer_faces() {
        add(&mut mesh, &clipped(&nodes.map(place)), colors[element as usize]);
    }
    for (element, nodes) in model.elements.iter().enumerate() {
        let corners = nodes.map(place);
        if corners.iter().all(|(_, distance)| *distance <= 0.0) || corners.iter().all(|(_, distance)| *distance > 0.0) {
            continue;
        }
        for tetrahedron in TETRAHEDRA {
            let mut face = section(&tetrahedron.map(|corner| corners[corner]));
            if let [a, b, c, ..] = face[..]
                && (b - a).cross(c - a).dot(eye.as_vec3() - a) < 0.0
            {
                face.reverse();
            }
            add(&mut mesh, &face, colors[element]);
        }
    }
    mesh
}

/// Adds a convex polygon of one colour.
fn add(mesh: &mut render::Mesh, polygon: &[Vec3], color: Color) {
    let first = mesh.points.len() as u32;
    mesh.points.extend(polygon.iter().map(|point| point.to_array()));
    mesh.colors.extend(polygon.iter().map(|_| color));
    mesh.triangles.extend((2..polygon.len() as u32).map(|at| [first, first + at - 1, first + at]));
}

/// Returns where the distance is 0 between two places, of which one has a distance above 0.
fn between((a, near): (Vec3, f32), (b, far): (Vec3, f32)) -> Vec3 {
    a.lerp(b, (near / (near - far)).clamp(0.0, 1.0))
}

/// Returns the part of a polygon whose distances are at most 0.
fn clipped(polygon: &[(Vec3, f32)]) -> Vec<Vec3> {
    let mut kept = Vec::new();
    for (at, from) in polygon.iter().enumerate() {
        let to = &polygon[(at + 1) % polygon.len()];
        if from.1 <= 0.0 {
            kept.push(from.0);
        }
        if (from.1 <= 0.0) != (to.1 <= 0.0) {
            kept.push(between(*from, *to));
        }
    }
    kept
}

/// Returns the triangle or quadrilateral in which distances of a tetrahedron are 0; empty if there is none.
fn section(corners: &[(Vec3, f32); 4]) -> Vec<Vec3> {
    let (inside, outside): (Vec<_>, Vec<_>) = corners.iter().copied().partition(|(_, distance)| *distance <= 0.0);
    match (&inside[..], &outside[..]) {
        ([one], others) | (others, [one]) => others.iter().map(|other| between(*one, *other)).collect(),
        ([a, b], [c, d]) => vec![between(*a, *c), between(*a, *d), between(*b, *d), between(*b, *c)],
        _ => Vec::new(),
    }
}

/// Returns the bound surfaces, smooth, with colours of the elements that they follow.
pub fn surfaces(context: &Context, simulation: &Simulation, colors: &[Color]) -> Vec<render::Mesh> {
    let model = simulation.model();
    let mesh = |binding: &relievo_tissue::Binding| {
        let points = binding.points(context, model, &simulation.state().displacements);
        let mut normals = vec![Vec3::ZERO; points.len()];
        for triangle in &binding.triangles {
            let [a, b, c] = triangle.map(|point| Vec3::from(points[point as usize]));
            let normal = (b - a).cross(c - a);
            triangle.iter().for_each(|point| normals[*point as usize] += normal);
        }
        render::Mesh {
            normals: normals.into_iter().map(|normal| normal.normalize_or(Vec3::Z).to_array()).collect(),
            colors: binding.anchors.iter().map(|anchor| colors[anchor.element as usize]).collect(),
            triangles: binding.triangles.clone(),
            points,
            ..render::Mesh::default()
        }
    };
    model.bindings.iter().map(mesh).collect()
}

#[cfg(test)]
mod tests {
    use relievo_tissue::{Material, Model, SimulationOptions};

    use super::*;

    /// Area and enclosed volume of triangles.
    fn measures(mesh: &render::Mesh) -> [f32; 2] {
        let at = |point: u32| Vec3::from(mesh.points[point as usize]);
        mesh.triangles.iter().fold([0.0; 2], |[area, volume], [a, b, c]| {
            let (a, b, c) = (at(*a), at(*b), at(*c));
            [area + 0.5 * (b - a).cross(c - a).length(), volume + a.dot(b.cross(c)) / 6.0]
        })
    }

    #[test]
    fn a_cut_goes_through_elements_and_closes_what_it_leaves() {
        let gel = Material { name: "gel".into(), density: 1000.0, shear: 1000.0, bulk: 1e4 };
        let model = Model::block([0.0; 3], [1.0, 2.0, 1.0], [3, 2, 2], gel).unwrap();
        let colors = vec![[0.5; 3]; model.elements.len()];
        let simulation = Simulation::new(model, &SimulationOptions::default()).unwrap();
        let eye = DVec3::new(9.0, 1.0, 1.0);
        let [area, volume] = measures(&faces(&simulation, None, eye, &colors));
        assert!((area - 52.0).abs() < 1e-3 && (volume - 24.0).abs() < 1e-3, "{area} {volume}");
        // In the middle of elements, of the side away from the eye, which is closed.
        for (at, length) in [(1.3, 1.3), (2.0, 2.0)] {
            let cut = Cut { axis: 0, at };
            let [area, volume] = measures(&faces(&simulation, Some(cut), eye, &colors));
            assert!((area - (16.0 + 12.0 * length)).abs() < 1e-3, "{at}: {area}");
            assert!((volume - 8.0 * length).abs() < 1e-3, "{at}: {volume}");
        }
        let [_, volume] = measures(&faces(&simulation, Some(Cut { axis: 0, at: 1.3 }), -eye, &colors));
        assert!((volume - 8.0 * 1.7).abs() < 1e-3, "{volume}");
    }
}
