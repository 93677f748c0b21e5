//! What pictures of a model show: its outer elements, cut open or not, and the surfaces bound to it, in colours.

use glam::{DVec3, Vec3};
use relievo_core::{Context, Result};
use relievo_render as render;
use relievo_render::color::Color;
use relievo_tissue::{Anchor, ElementState, Model, Simulation};

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

/// What has colours.
pub enum Paint {
    /// Each element one.
    Elements(Vec<Color>),
    /// Each node one, with colours in between inside of elements.
    Nodes(Vec<Color>),
}

impl Paint {
    /// Returns the colour of an element at one of its nodes.
    fn at(&self, element: usize, node: u32) -> Color {
        match self {
            Self::Elements(colors) => colors[element],
            Self::Nodes(colors) => colors[node as usize],
        }
    }
}

/// Colours and their legend.
pub struct Coloring {
    pub paint: Paint,
    pub legend: Vec<(Color, String)>,
}

/// Returns the colour of a share from 0 to 1.
pub fn viridis(share: f32) -> Color {
    let at = share.clamp(0.0, 1.0) * (VIRIDIS.len() - 1) as f32;
    let low = (at as usize).min(VIRIDIS.len() - 2);
    std::array::from_fn(|part| VIRIDIS[low][part] + (at - low as f32) * (VIRIDIS[low + 1][part] - VIRIDIS[low][part]))
}

/// Returns the colours of a model. `most` is what the brightest colour stands for; left out, nearly the largest value.
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
            let paint = Paint::Elements((0..model.elements.len()).map(color).collect());
            Ok(Coloring { paint, legend: legend.collect() })
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
            let paint = Paint::Elements((0..model.elements.len()).map(color).collect());
            Ok(Coloring { paint, legend: legend.collect() })
        }
        Show::Stress => of_elements(context, simulation, most, "Pa", |state| state.von_mises),
        Show::Strain => of_elements(context, simulation, most, "", |state| {
            state.principal_strain.iter().fold(0.0, |most: f32, strain| most.max(strain.abs()))
        }),
        Show::Volume => of_elements(context, simulation, most, "of volume", |state| (state.volume - 1.0).abs()),
        Show::Pressure => {
            let pressures = simulation.contact_pressures(context)?;
            // Most nodes touch nothing.
            let touched: Vec<f32> = pressures.iter().copied().filter(|pressure| *pressure > 0.0).collect();
            let (most, legend) = scale(touched, most, "Pa");
            let colors = pressures.iter().map(|pressure| viridis(pressure / most)).collect();
            Ok(Coloring { paint: Paint::Nodes(colors), legend })
        }
        Show::Surface => Ok(Coloring { paint: Paint::Elements(vec![PALE; model.elements.len()]), legend: Vec::new() }),
    }
}

fn of_elements(
    context: &Context,
    simulation: &Simulation,
    most: Option<f32>,
    unit: &str,
    of: impl Fn(&ElementState) -> f32,
) -> Result<Coloring> {
    let values: Vec<f32> = simulation.element_states(context)?.iter().map(of).collect();
    let (most, legend) = scale(values.clone(), most, unit);
    let colors = values.iter().map(|value| viridis(value / most)).collect();
    Ok(Coloring { paint: Paint::Elements(colors), legend })
}

/// Returns what the brightest colour stands for, and the legend.
pub fn scale(mut values: Vec<f32>, most: Option<f32>, unit: &str) -> (f32, Vec<(Color, String)>) {
    values.sort_unstable_by(f32::total_cmp);
    // A few elements at edges have far more than all others.
    let nearly = || values.get(values.len().saturating_sub(1) * 98 / 100).copied().unwrap_or(0.0);
    let most = most.unwrap_or_else(nearly);
    let most = if most > 0.0 { most } else { 1.0 };
    let legend = (0..=4).rev().map(|step| {
        let share = step as f32 / 4.0;
        (viridis(share), format!("{:.3e} {unit}", share * most).trim_end().to_owned())
    });
    (most, legend.collect())
}

/// Tetrahedra that fill a hexahedron, around its diagonal from corner 0 to corner 6.
const TETRAHEDRA: [[usize; 4]; 6] =
    [[0, 1, 2, 6], [0, 2, 3, 6], [0, 3, 7, 6], [0, 7, 4, 6], [0, 4, 5, 6], [0, 5, 1, 6]];

/// A corner of a face: where it is, its colour, and its distance from the plane of a cut.
#[derive(Clone, Copy)]
struct Corner {
    at: Vec3,
    color: Color,
    distance: f32,
}

/// Returns the outer faces of what a cut leaves as seen from `eye`, and the faces that it lays open, in the colours of
/// elements or nodes.
pub fn faces(simulation: &Simulation, cut: Option<Cut>, eye: DVec3, paint: &Paint) -> render::Mesh {
    let model = simulation.model();
    let positions = simulation.positions();
    let mut mesh = render::Mesh::default();
    let sign = if cut.is_some_and(|cut| eye[cut.axis] > f64::from(cut.at)) { 1.0 } else { -1.0 };
    // Distances from the plane are those at rest, above 0 on the camera's side.
    let corner = |element: usize, node: u32| Corner {
        at: Vec3::from(positions[node as usize]),
        color: paint.at(element, node),
        distance: cut.map_or(0.0, |cut| sign * (model.nodes[node as usize][cut.axis] - cut.at)),
    };
    for (element, nodes) in model.outer_faces() {
        add(&mut mesh, &clipped(&nodes.map(|node| corner(element as usize, node))));
    }
    if cut.is_none() {
        return mesh;
    }
    for (element, nodes) in model.elements.iter().enumerate() {
        let corners = nodes.map(|node| corner(element, node));
        let kept = corners.iter().filter(|corner| corner.distance <= 0.0).count();
        if kept == 0 || kept == corners.len() {
            continue;
        }
        for tetrahedron in TETRAHEDRA {
            let mut face = section(&tetrahedron.map(|corner| corners[corner]));
            if let [a, b, c, ..] = face[..]
                && (b.at - a.at).cross(c.at - a.at).dot(eye.as_vec3() - a.at) < 0.0
            {
                face.reverse();
            }
            add(&mut mesh, &face);
        }
    }
    mesh
}

/// Adds a convex polygon.
fn add(mesh: &mut render::Mesh, polygon: &[Corner]) {
    let first = mesh.points.len() as u32;
    mesh.points.extend(polygon.iter().map(|corner| corner.at.to_array()));
    mesh.colors.extend(polygon.iter().map(|corner| corner.color));
    mesh.triangles.extend((2..polygon.len() as u32).map(|at| [first, first + at - 1, first + at]));
}

/// Returns where the distance is 0 between two corners, of which one has a distance above 0.
fn between(a: Corner, b: Corner) -> Corner {
    let share = (a.distance / (a.distance - b.distance)).clamp(0.0, 1.0);
    let color = Vec3::from(a.color).lerp(b.color.into(), share).to_array();
    Corner { at: a.at.lerp(b.at, share), color, distance: 0.0 }
}

/// Returns the part of a polygon whose distances are at most 0.
fn clipped(polygon: &[Corner]) -> Vec<Corner> {
    let mut kept = Vec::new();
    for (at, from) in polygon.iter().enumerate() {
        let to = &polygon[(at + 1) % polygon.len()];
        if from.distance <= 0.0 {
            kept.push(*from);
        }
        if (from.distance <= 0.0) != (to.distance <= 0.0) {
            kept.push(between(*from, *to));
        }
    }
    kept
}

/// Returns the triangle or quadrilateral in which distances of a tetrahedron are 0; empty if there is none.
fn section(corners: &[Corner; 4]) -> Vec<Corner> {
    let (inside, outside): (Vec<_>, Vec<_>) = corners.iter().copied().partition(|corner| corner.distance <= 0.0);
    match (&inside[..], &outside[..]) {
        ([one], others) | (others, [one]) => others.iter().map(|other| between(*one, *other)).collect(),
        ([a, b], [c, d]) => vec![between(*a, *c), between(*a, *d), between(*b, *d), between(*b, *c)],
        _ => Vec::new(),
    }
}

/// Returns the bound surfaces, smooth, with colours of the elements, or of the nearest nodes, that they follow.
pub fn surfaces(context: &Context, simulation: &Simulation, paint: &Paint) -> Vec<render::Mesh> {
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
            colors: binding.anchors.iter().map(|anchor| color(model, paint, anchor)).collect(),
            triangles: binding.triangles.clone(),
            points,
            ..render::Mesh::default()
        }
    };
    model.bindings.iter().map(mesh).collect()
}

/// Returns the colour of a point that follows an element: that of the element, or of its corner nearest to the point.
fn color(model: &Model, paint: &Paint, anchor: &Anchor) -> Color {
    let upper = anchor.weights.map(|weight| weight > 0.5);
    // Corners go around the lower face, then around the upper one.
    let around = match upper {
        [false, false, _] => 0,
        [true, false, _] => 1,
        [true, true, _] => 2,
        [false, true, _] => 3,
    };
    let element = anchor.element as usize;
    paint.at(element, model.elements[element][if upper[2] { around + 4 } else { around }])
}

#[cfg(test)]
mod tests {
    use relievo_tissue::{Material, SimulationOptions};

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
        let paint = Paint::Elements(vec![[0.5; 3]; model.elements.len()]);
        let simulation = Simulation::new(model, &SimulationOptions::default()).unwrap();
        let eye = DVec3::new(9.0, 1.0, 1.0);
        let [area, volume] = measures(&faces(&simulation, None, eye, &paint));
        assert!((area - 52.0).abs() < 1e-3 && (volume - 24.0).abs() < 1e-3, "{area} {volume}");
        // In the middle of elements, of the side away from the eye, which is closed.
        for (at, length) in [(1.3, 1.3), (2.0, 2.0)] {
            let cut = Cut { axis: 0, at };
            let [area, volume] = measures(&faces(&simulation, Some(cut), eye, &paint));
            assert!((area - (16.0 + 12.0 * length)).abs() < 1e-3, "{at}: {area}");
            assert!((volume - 8.0 * length).abs() < 1e-3, "{at}: {volume}");
        }
        let [_, volume] = measures(&faces(&simulation, Some(Cut { axis: 0, at: 1.3 }), -eye, &paint));
        assert!((volume - 8.0 * 1.7).abs() < 1e-3, "{volume}");
        // Colours of nodes stay linear across a cut.
        let model = simulation.model();
        let color = |[x, y, z]: [f32; 3]| [x / 3.0, y / 4.0, z / 2.0];
        let paint = Paint::Nodes(model.nodes.iter().map(|node| color(*node)).collect());
        for cut in [None, Some(Cut { axis: 0, at: 1.3 })] {
            let mesh = faces(&simulation, cut, eye, &paint);
            let is_near =
                |(point, found): (&[f32; 3], &Color)| Vec3::from(color(*point)).distance((*found).into()) < 1e-6;
            assert!(mesh.points.iter().zip(&mesh.colors).all(is_near), "{cut:?}");
        }
        for corner in 0..8 {
            let at = model.nodes[model.elements[0][corner] as usize];
            let weights = [at[0], 0.5 * at[1], at[2]].map(|at| 0.2 + 0.7 * at);
            assert_eq!(super::color(model, &paint, &Anchor { element: 0, weights }), color(at), "{corner}");
        }
    }
}
