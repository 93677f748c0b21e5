//! What pictures of a model show: its outer elements, cut open or not, and the surfaces bound to it, in colours.

use glam::{DVec3, Vec3};
use relievo_core::{Context, Result};
use relievo_render as render;
use relievo_render::color::Color;
use relievo_tissue::{ElementState, Model, Simulation};

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

/// Returns the outer faces of the elements that a cut leaves as seen from `eye`, each with the colour of its element.
pub fn faces(simulation: &Simulation, cut: Option<Cut>, eye: DVec3, colors: &[Color]) -> render::Mesh {
    let model = simulation.model();
    let is_left = |corners: &[u32; 8]| {
        cut.is_none_or(|cut| {
            let sum: f32 = corners.iter().map(|node| model.nodes[*node as usize][cut.axis]).sum();
            (sum / 8.0 <= cut.at) == (eye[cut.axis] > f64::from(cut.at))
        })
    };
    let kept: Vec<usize> = (0..model.elements.len()).filter(|element| is_left(&model.elements[*element])).collect();
    let part = Model { elements: kept.iter().map(|element| model.elements[*element]).collect(), ..Model::default() };
    let positions = simulation.positions();
    let mut mesh = render::Mesh::default();
    for (element, nodes) in part.outer_faces() {
        let first = mesh.points.len() as u32;
        mesh.points.extend(nodes.map(|node| positions[node as usize]));
        mesh.colors.extend([colors[kept[element as usize]]; 4]);
        mesh.triangles.extend([[first, first + 1, first + 2], [first, first + 2, first + 3]]);
    }
    mesh
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
