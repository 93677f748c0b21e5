//! Meshes made from a few numbers: terrains, wheels with tread, spiked balls and simple solids. Solids are closed and
//! face outward, open grids face up. Lengths are in scene units; made with z up and axles along y, then turned to the
//! scene's up axis.

use std::collections::HashMap;
use std::f64::consts::{PI, TAU};

use relievo_core::{Crease, Mesh};

use crate::format::placement::Up;

/// A shape and its numbers.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Shape {
    /// A flat grid of quads around the origin.
    Plane {
        /// Sides.
        size: [f32; 2],
        /// Quads along a side.
        faces: u32,
    },
    /// A grid of quads with hills, some of whose faces are inset, which makes vertices of valence 3 and 5.
    Terrain {
        /// Sides, and the height from the deepest to the highest place.
        size: [f32; 3],
        /// Quads along a side.
        faces: u32,
        /// Which hills.
        seed: u32,
    },
    /// A box of quads around the origin.
    Box {
        /// Sides.
        size: [f32; 3],
        /// Quads along a side.
        faces: u32,
    },
    /// A sphere of quads, a cube blown up.
    Sphere {
        /// Radius.
        radius: f32,
        /// Quads along a side of the cube.
        faces: u32,
    },
    /// A cylinder along its axle.
    Cylinder {
        /// Radius.
        radius: f32,
        /// Length.
        width: f32,
        /// Quads around.
        segments: u32,
    },
    /// A wheel with two rows of slanted lugs.
    Wheel {
        /// Radius to the top of the lugs.
        radius: f32,
        /// Width along the axle.
        width: f32,
        /// Lugs around, in each row.
        lugs: u32,
        /// Height of the lugs.
        lug_height: f32,
    },
    /// A ball with cones all around: overlapping closed shells.
    SpikedBall {
        /// Radius without spikes.
        radius: f32,
        /// How many spikes.
        spikes: u32,
        /// Length of a spike above the ball.
        spike_length: f32,
        /// Radius of a spike where it leaves the ball.
        spike_radius: f32,
    },
}

impl Shape {
    /// The mesh, with `up` as the vertical axis.
    pub fn mesh(&self, up: Up) -> Mesh {
        let mut mesh = match *self {
            Shape::Plane { size, faces } => plane(size, faces),
            Shape::Terrain { size, faces, seed } => terrain(size, faces, seed),
            Shape::Box { size, faces } => {
                cube(faces, |p| std::array::from_fn(|axis| p[axis] * f64::from(size[axis]) / 2.0))
            }
            Shape::Sphere { radius, faces } => sphere(radius, faces),
            Shape::Cylinder { radius, width, segments } => cylinder(radius, width, segments),
            Shape::Wheel { radius, width, lugs, lug_height } => wheel(radius, width, lugs, lug_height),
            Shape::SpikedBall { radius, spikes, spike_length, spike_radius } => {
                spiked_ball(radius, spikes, spike_length, spike_radius)
            }
        };
        for point in &mut mesh.points {
            *point = up.from_z_up(*point);
        }
        mesh
    }
}

fn narrow(p: [f64; 3]) -> [f32; 3] {
    p.map(|value| value as f32)
}

fn push_face(mesh: &mut Mesh, face: &[u32]) {
    mesh.face_sizes.push(face.len() as u32);
    mesh.corners.extend_from_slice(face);
}

fn plane(size: [f32; 2], faces: u32) -> Mesh {
    let mut mesh = Mesh::default();
    for j in 0..=faces {
        for i in 0..=faces {
            let at = |k: u32, side: f32| (f64::from(k) / f64::from(faces) - 0.5) * f64::from(side);
            mesh.points.push(narrow([at(i, size[0]), at(j, size[1]), 0.0]));
        }
    }
    for j in 0..faces {
        for i in 0..faces {
            let first = j * (faces + 1) + i;
            push_face(&mut mesh, &[first, first + 1, first + faces + 2, first + faces + 1]);
        }
    }
    mesh
}

/// A well-mixed number in 0..1 for a counter.
fn random(seed: u32, index: u32) -> f64 {
    let mut state = (u64::from(seed) << 32 | u64::from(index)).wrapping_add(0x9e37_79b9_7f4a_7c15);
    state = (state ^ (state >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
    state = (state ^ (state >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
    (state ^ (state >> 31)) as f64 / u64::MAX as f64
}

fn terrain(size: [f32; 3], faces: u32, seed: u32) -> Mesh {
    // Waves of random direction and phase, shorter ones flatter: from two to seven hills across.
    const WAVES: u32 = 14;
    let waves: Vec<[f64; 4]> = (0..WAVES)
        .map(|wave| {
            let frequency = 1.6 * (4.5_f64).powf(f64::from(wave) / f64::from(WAVES - 1));
            let angle = TAU * random(seed, 3 * wave);
            [frequency * angle.cos(), frequency * angle.sin(), TAU * random(seed, 3 * wave + 1), frequency.powf(-1.7)]
        })
        .collect();
    let flat = plane([1.0, 1.0], faces);
    let heights: Vec<f64> = flat
        .points
        .iter()
        .map(|p| {
            let phase = |w: &[f64; 4]| TAU * 0.5 * (w[0] * f64::from(p[0]) + w[1] * f64::from(p[1])) + w[2];
            waves.iter().map(|wave| phase(wave).sin() * wave[3]).sum()
        })
        .collect();
    let low = heights.iter().copied().fold(f64::INFINITY, f64::min);
    let high = heights.iter().copied().fold(f64::NEG_INFINITY, f64::max);
    let scale = f64::from(size[2]) / (high - low).max(1e-9);
    let mut mesh = Mesh::default();
    for (p, height) in flat.points.iter().zip(&heights) {
        let z = (height - (low + high) * 0.5) * scale;
        mesh.points.push([p[0] * size[0], p[1] * size[1], z as f32]);
    }
    for (face, corners) in flat.faces().enumerate() {
        let (i, j) = (face as u32 % faces, face as u32 / faces);
        let inner = i % 9 == 4 && j % 7 == 3 && i + 2 < faces && j + 2 < faces;
        if !inner {
            push_face(&mut mesh, corners);
            continue;
        }
        // An inset face in the plane of the old one: its corners have valence 3, the outer ones 5.
        let outer: Vec<[f32; 3]> = corners.iter().map(|corner| mesh.points[*corner as usize]).collect();
        let middle: [f32; 3] = std::array::from_fn(|axis| outer.iter().map(|p| p[axis]).sum::<f32>() * 0.25);
        let first = mesh.points.len() as u32;
        mesh.points.extend(
            outer
                .iter()
                .map(|p| -> [f32; 3] { std::array::from_fn(|axis| middle[axis] + (p[axis] - middle[axis]) * 0.5) }),
        );
        push_face(&mut mesh, &[first, first + 1, first + 2, first + 3]);
        for side in 0..4_u32 {
            let next = (side + 1) % 4;
            push_face(&mut mesh, &[corners[side as usize], corners[next as usize], first + next, first + side]);
        }
    }
    mesh
}

/// A cube from −1 to 1 with `faces`² quads on a side, its points moved by `shape`.
fn cube(faces: u32, shape: impl Fn([f64; 3]) -> [f64; 3]) -> Mesh {
    let mut mesh = Mesh::default();
    let mut known: HashMap<[u32; 3], u32> = HashMap::new();
    for axis in 0..3_usize {
        for positive in [false, true] {
            let mut point = |i: u32, j: u32| {
                let mut lattice = [0; 3];
                lattice[axis] = if positive { faces } else { 0 };
                lattice[(axis + 1) % 3] = i;
                lattice[(axis + 2) % 3] = j;
                *known.entry(lattice).or_insert_with(|| {
                    let unit = lattice.map(|value| 2.0 * f64::from(value) / f64::from(faces) - 1.0);
                    mesh.points.push(narrow(shape(unit)));
                    mesh.points.len() as u32 - 1
                })
            };
            let mut list = Vec::new();
            for j in 0..faces {
                for i in 0..faces {
                    let mut face = [point(i, j), point(i + 1, j), point(i + 1, j + 1), point(i, j + 1)];
                    if !positive {
                        face.reverse();
                    }
                    list.push(face);
                }
            }
            for face in list {
                push_face(&mut mesh, &face);
            }
        }
    }
    mesh
}

fn sphere(radius: f32, faces: u32) -> Mesh {
    cube(faces, |p| {
        // Equal angles rather than equal steps, which keeps quads of similar size.
        let bent = p.map(|value| (value * PI / 4.0).tan());
        let length = bent.iter().map(|value| value * value).sum::<f64>().sqrt();
        bent.map(|value| value / length * f64::from(radius))
    })
}

/// Closed surface of revolution about y: rings of (radius, y) with increasing y, a fan at both ends.
fn revolve(mesh: &mut Mesh, rings: &[(f64, f64)], segments: u32) {
    let first = mesh.points.len() as u32;
    for (radius, y) in rings {
        for segment in 0..segments {
            let angle = TAU * f64::from(segment) / f64::from(segments);
            mesh.points.push(narrow([radius * angle.cos(), *y, radius * angle.sin()]));
        }
    }
    for ring in 0..rings.len() as u32 - 1 {
        for segment in 0..segments {
            let next = (segment + 1) % segments;
            let row = first + ring * segments;
            push_face(mesh, &[row + segment, row + segments + segment, row + segments + next, row + next]);
        }
    }
    for (ring, end) in [(0, 0), (rings.len() - 1, 1)] {
        let centre = mesh.points.len() as u32;
        mesh.points.push(narrow([0.0, rings[ring].1, 0.0]));
        let row = first + ring as u32 * segments;
        for segment in 0..segments {
            let next = (segment + 1) % segments;
            let (a, b) = if end == 0 { (segment, next) } else { (next, segment) };
            push_face(mesh, &[centre, row + a, row + b]);
        }
    }
}

fn cylinder(radius: f32, width: f32, segments: u32) -> Mesh {
    let mut mesh = Mesh::default();
    let (radius, half) = (f64::from(radius), f64::from(width) / 2.0);
    revolve(&mut mesh, &[(radius, -half), (radius, half)], segments);
    // As a control cage it keeps its rims.
    for ring in 0..2 {
        mesh.creases.extend((0..segments).map(|segment| Crease {
            points: [ring * segments + segment, ring * segments + (segment + 1) % segments],
            sharpness: relievo_core::mesh::INFINITE_SHARPNESS,
        }));
    }
    mesh
}

fn wheel(radius: f32, width: f32, lugs: u32, lug_height: f32) -> Mesh {
    let (top, half) = (f64::from(radius), f64::from(width) / 2.0);
    let base = top - f64::from(lug_height);
    // Columns across: shoulder, left lugs, groove, right lugs, shoulder. Lugs never meet at a corner.
    const LINES: [f64; 8] = [-1.0, -0.92, -0.5, -0.08, 0.08, 0.5, 0.92, 1.0];
    const PITCH: u32 = 8;
    let cells = lugs * PITCH;
    let raised = |cell: u32, column: usize| match column {
        1 | 2 => cell % PITCH < PITCH / 2,
        4 | 5 => (cell + PITCH / 2) % PITCH < PITCH / 2,
        _ => false,
    };
    let columns = LINES.len() - 1;
    let mut mesh = Mesh::default();
    // Two points at every lattice corner, on the base and on the tread; those without faces are dropped below.
    for cell in 0..cells {
        for line in LINES {
            // Lugs lean back towards the shoulders.
            let angle = TAU * (f64::from(cell) / f64::from(cells) - 0.45 * line.abs() / f64::from(lugs));
            for level in [base, top] {
                // Lugs get narrower towards their top.
                let y = half * line * if level == top { 0.985 } else { 1.0 };
                mesh.points.push(narrow([level * angle.cos(), y, level * angle.sin()]));
            }
        }
    }
    let point = |cell: u32, line: usize, high: bool| {
        ((cell % cells) as usize * LINES.len() * 2 + line * 2 + usize::from(high)) as u32
    };
    for cell in 0..cells {
        for column in 0..columns {
            let high = raised(cell, column);
            let at = |c: u32, l: usize| point(cell + c, column + l, high);
            push_face(&mut mesh, &[at(0, 0), at(0, 1), at(1, 1), at(1, 0)]);
            if !high {
                continue;
            }
            let wall = |mesh: &mut Mesh, a: (u32, usize), b: (u32, usize)| {
                let at = |p: (u32, usize), high| point(cell + p.0, column + p.1, high);
                push_face(mesh, &[at(a, false), at(b, false), at(b, true), at(a, true)]);
            };
            if !raised((cell + cells - 1) % cells, column) {
                wall(&mut mesh, (0, 0), (0, 1));
            }
            if !raised((cell + 1) % cells, column) {
                wall(&mut mesh, (1, 1), (1, 0));
            }
            if !raised(cell, column - 1) {
                wall(&mut mesh, (1, 0), (0, 0));
            }
            if !raised(cell, column + 1) {
                wall(&mut mesh, (0, 1), (1, 1));
            }
        }
    }
    // Sides: tyre wall, dished rim, hub.
    let rings = [(0.93, 1.04), (0.66, 1.0), (0.62, 0.72), (0.26, 0.5), (0.22, 0.86), (0.0, 0.86)];
    for side in [false, true] {
        let line = if side { LINES.len() - 1 } else { 0 };
        let mut previous: Vec<u32> = (0..cells).map(|cell| point(cell, line, false)).collect();
        for (share, depth) in rings {
            let y = half * depth * if side { 1.0 } else { -1.0 };
            let first = mesh.points.len() as u32;
            let count = if share == 0.0 { 1 } else { cells };
            for cell in 0..count {
                let angle = TAU * (f64::from(cell) / f64::from(cells) - 0.45 / f64::from(lugs));
                mesh.points.push(narrow([base * share * angle.cos(), y, base * share * angle.sin()]));
            }
            let ring: Vec<u32> = (0..cells).map(|cell| first + if count == 1 { 0 } else { cell }).collect();
            for cell in 0..cells as usize {
                let next = (cell + 1) % cells as usize;
                let mut face = vec![previous[cell], ring[cell], ring[next], previous[next]];
                if count == 1 {
                    face.remove(2);
                }
                if side {
                    // The winding of the tread continues over the far rim.
                } else {
                    face.reverse();
                }
                push_face(&mut mesh, &face);
            }
            previous = ring;
        }
    }
    drop_unused_points(&mut mesh);
    mesh
}

fn drop_unused_points(mesh: &mut Mesh) {
    let mut new = vec![u32::MAX; mesh.points.len()];
    let mut points = Vec::new();
    for corner in &mut mesh.corners {
        let slot = &mut new[*corner as usize];
        if *slot == u32::MAX {
            *slot = points.len() as u32;
            points.push(mesh.points[*corner as usize]);
        }
        *corner = *slot;
    }
    mesh.points = points;
}

fn spiked_ball(radius: f32, spikes: u32, length: f32, foot: f32) -> Mesh {
    const SIDES: u32 = 12;
    let mut mesh = sphere(radius, 12);
    let radius = f64::from(radius);
    // The foot sits inside the ball, below the sagitta of the cone's rim and of the quads of the sphere.
    let depth = (f64::from(foot).powi(2) / radius + 0.02 * radius).min(0.5 * radius);
    let rim = f64::from(foot) * (1.0 + depth / f64::from(length));
    let golden = PI * (3.0 - 5.0_f64.sqrt());
    for spike in 0..spikes {
        // Points of a Fibonacci lattice, evenly spread.
        let z = 1.0 - 2.0 * (f64::from(spike) + 0.5) / f64::from(spikes);
        let flat = (1.0 - z * z).sqrt();
        let angle = golden * f64::from(spike);
        let axis = glam::DVec3::new(flat * angle.cos(), flat * angle.sin(), z);
        let (side, other) = axis.any_orthonormal_pair();
        let first = mesh.points.len() as u32;
        let centre = axis * (radius - depth);
        mesh.points.push(narrow(centre.into()));
        mesh.points.push(narrow((axis * (radius + f64::from(length))).into()));
        for corner in 0..SIDES {
            let angle = TAU * f64::from(corner) / f64::from(SIDES);
            mesh.points.push(narrow((centre + (side * angle.cos() + other * angle.sin()) * rim).into()));
        }
        for corner in 0..SIDES {
            let (a, b) = (first + 2 + corner, first + 2 + (corner + 1) % SIDES);
            push_face(&mut mesh, &[first + 1, a, b]);
            push_face(&mut mesh, &[first, b, a]);
        }
    }
    mesh
}

#[cfg(test)]
mod tests {
    use super::*;

    const SOLIDS: [Shape; 5] = [
        Shape::Box { size: [1.0, 2.0, 3.0], faces: 3 },
        Shape::Sphere { radius: 0.5, faces: 6 },
        Shape::Cylinder { radius: 0.5, width: 0.4, segments: 24 },
        Shape::Wheel { radius: 0.5, width: 0.3, lugs: 18, lug_height: 0.05 },
        Shape::SpikedBall { radius: 0.4, spikes: 40, spike_length: 0.1, spike_radius: 0.04 },
    ];

    fn volume(mesh: &Mesh) -> f64 {
        let at = |index: u32| glam::DVec3::from(mesh.points[index as usize].map(f64::from));
        mesh.triangles().iter().map(|t| at(t[0]).dot(at(t[1]).cross(at(t[2]))) / 6.0).sum()
    }

    #[test]
    fn solids_are_closed_and_face_outward() {
        for shape in SOLIDS {
            for up in [Up::X, Up::Y, Up::Z] {
                let mesh = shape.mesh(up);
                mesh.check().unwrap();
                let mut edges: HashMap<(u32, u32), i32> = HashMap::new();
                for face in mesh.faces() {
                    for (at, a) in face.iter().enumerate() {
                        let b = face[(at + 1) % face.len()];
                        let edge = edges.entry((*a.min(&b), *a.max(&b))).or_default();
                        *edge += if *a < b { 1 } else { 1000 };
                    }
                }
                // Every edge is used once in each direction.
                assert!(edges.values().all(|uses| *uses == 1001), "{shape:?}");
                assert!(volume(&mesh) > 0.0, "{shape:?}");
            }
        }
    }

    #[test]
    fn solids_have_their_volume_and_extent() {
        let volume_of = |shape: Shape| volume(&shape.mesh(Up::Z));
        assert!((volume_of(SOLIDS[0]) - 6.0).abs() < 1e-5);
        let ball = 4.0 / 3.0 * PI * 0.125;
        assert!((volume_of(Shape::Sphere { radius: 0.5, faces: 32 }) / ball - 1.0).abs() < 2e-3);
        let (low, high) = SOLIDS[3].mesh(Up::Z).bounds().unwrap();
        assert!((high[0] - 0.5).abs() < 1e-3 && (low[2] + 0.5).abs() < 1e-2 && (high[1] - 0.156).abs() < 1e-3);
        let ball = SOLIDS[4].mesh(Up::Z);
        let reach = ball.points.iter().map(|p| p.iter().map(|v| v * v).sum::<f32>().sqrt());
        assert!((reach.fold(0.0, f32::max) - 0.5).abs() < 1e-5);
    }

    #[test]
    fn a_terrain_faces_up_and_has_extraordinary_vertices() {
        let shape = Shape::Terrain { size: [12.0, 8.0, 0.5], faces: 60, seed: 3 };
        let mesh = shape.mesh(Up::Z);
        mesh.check().unwrap();
        assert!(mesh.face_count() > 3600);
        for face in mesh.faces() {
            let at = |corner: usize| glam::Vec3::from(mesh.points[face[corner] as usize]);
            assert!((at(1) - at(0)).cross(at(3) - at(0)).z > 0.0);
        }
        let (low, high) = mesh.bounds().unwrap();
        assert!((high[2] - low[2] - 0.5).abs() < 1e-5 && (high[0] - 6.0).abs() < 1e-5);
        let mut valence = vec![0; mesh.points.len()];
        mesh.corners.iter().for_each(|corner| valence[*corner as usize] += 1);
        assert!(valence.contains(&3) && valence.contains(&5));
        assert_eq!(mesh, shape.mesh(Up::Z));
        assert_ne!(mesh, Shape::Terrain { size: [12.0, 8.0, 0.5], faces: 60, seed: 4 }.mesh(Up::Z));
    }
}
