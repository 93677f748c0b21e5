//! Voxels against the sign of OpenVDB's `meshToVolume`.

use glam::{DAffine3, DMat3, DVec3, EulerRot};
use relievo_core::Context;
use relievo_detail::{Grid, Obb, Side, Solid, Voxels};
use relievo_openvdb::peer::{LevelSet, is_available};

type Soup = (Vec<[f32; 3]>, Vec<[u32; 3]>);

/// A closed surface over a lattice that wraps around both ways: a torus whose tube is shaken.
fn knot(n: u32, m: u32, turns: f32, shake: f32) -> Soup {
    let mut points = Vec::new();
    let mut triangles = Vec::new();
    for i in 0..n {
        for j in 0..m {
            let (a, b) = (std::f32::consts::TAU * i as f32 / n as f32, std::f32::consts::TAU * j as f32 / m as f32);
            let tube = 0.35 + shake * (turns * a + 3.0 * b).sin();
            let r = 1.0 + tube * b.cos();
            points.push([r * a.cos(), r * a.sin(), tube * b.sin() + 0.2 * (2.0 * a).sin()]);
            let at = |i: u32, j: u32| i % n * m + j % m;
            let [p, q, r, s] = [at(i, j), at(i + 1, j), at(i + 1, j + 1), at(i, j + 1)];
            triangles.extend([[p, q, r], [p, r, s]]);
        }
    }
    (points, triangles)
}

#[test]
fn signs_agree_with_openvdb_beyond_a_voxel_diagonal() {
    if !is_available() {
        return;
    }
    for (soup, half, angle) in [
        (knot(60, 30, 7.0, 0.05), [1.6, 1.6, 0.7], 0.0),
        (knot(90, 40, 13.0, 0.1), [1.8, 1.7, 1.5], 0.7),
        (knot(24, 9, 5.0, 0.02), [1.7, 2.5, 1.1], 2.0),
    ] {
        let axes = DMat3::from_euler(EulerRot::XYZ, angle, 0.3 * angle, -angle);
        let grid =
            Grid::new(&Obb { center: DVec3::new(0.01, 0.02, 0.03), axes, half: DVec3::from(half) }, 1 << 18, None);
        let solid =
            Solid { points: &soup.0, triangles: &soup.1, transform: DAffine3::IDENTITY, closed: true, lattice: None };
        let mut voxels = Voxels::default();
        voxels.fill(&Context::serial(), &grid, &solid, None, Side::Forward).unwrap();
        let points: Vec<[f32; 3]> = soup
            .0
            .iter()
            .map(|point| (grid.map.transform_point3(DVec3::from(point.map(f64::from))) - 0.5).as_vec3().to_array())
            .collect();
        let level_set = LevelSet::of_mesh(&points, &soup.1, 3.0).unwrap();
        let [nx, ny, nz] = grid.dims;
        let places: Vec<[i32; 3]> = (0..nx * ny * nz)
            .map(|index| [index % nx, index / nx % ny, index / (nx * ny)].map(|place| place as i32))
            .collect();
        let values = level_set.values(&places).unwrap();
        let (mut compared, mut solid_voxels) = (0, 0);
        for (place, value) in places.iter().zip(values) {
            // Values are in voxels; the diagonal of a voxel is √3 of them where voxels are cubes, as they nearly are.
            if value.abs() > 3f32.sqrt() {
                compared += 1;
                solid_voxels += u32::from(value < 0.0);
                assert_eq!(value < 0.0, voxels.get(place.map(|p| p as u32)), "{place:?} {value}");
            }
        }
        assert!(compared > nx * ny * nz / 2 && solid_voxels > 1000, "{compared} {solid_voxels}");
    }
}
