//! Embree's `rtcInterpolate1` as a second source for positions and first derivatives.

use relievo_core::{Context, Crease, Mesh};
use relievo_embree::{Boundary, Cage, Device, Subdivision};
use relievo_surface::{Place, Surface, SurfaceOptions};

fn cages() -> Vec<(&'static str, Mesh)> {
    let cube = Mesh::new(
        (0..8).map(|i| [(i & 1) as f32, (i >> 1 & 1) as f32, (i >> 2 & 1) as f32]).collect(),
        vec![4; 6],
        vec![0, 2, 3, 1, 4, 5, 7, 6, 0, 1, 5, 4, 2, 6, 7, 3, 0, 4, 6, 2, 1, 3, 7, 5],
    );
    let mut plane = Mesh::default();
    for j in 0..=5_u32 {
        for i in 0..=5_u32 {
            plane.points.push([i as f32, j as f32, (i as f32 * 1.3).sin() + (j as f32 * 0.7).cos()]);
            if i < 5 && j < 5 {
                let a = 6 * j + i;
                plane.corners.extend([a, a + 1, a + 7, a + 6]);
                plane.face_sizes.push(4);
            }
        }
    }
    let mut creased = plane.clone();
    creased.creases.extend((0..5).map(|k| Crease { points: [12 + k, 13 + k], sharpness: 2.0 }));
    let pentagon = Mesh::new(
        (0..5).map(|k| k as f32 * 1.2566).map(|a| [a.cos(), a.sin(), 0.0]).chain([[0.0, 0.0, 1.0]]).collect(),
        vec![5, 3, 3, 3, 3, 3],
        vec![4, 3, 2, 1, 0, 0, 1, 5, 1, 2, 5, 2, 3, 5, 3, 4, 5, 4, 0, 5],
    );
    vec![("plane", plane), ("creased plane", creased), ("cube", cube), ("pyramid", pentagon)]
}

#[test]
fn positions_and_derivatives_agree_with_embree() {
    let device = match Device::new() {
        Ok(device) => device,
        Err(error) => panic!("Embree is part of the set-up: {error}"),
    };
    let context = Context::serial();
    for (name, mesh) in cages() {
        let surface = Surface::new(&context, &mesh, &SurfaceOptions::default()).unwrap();
        let creases: Vec<_> = mesh.creases.iter().map(|crease| (crease.points, crease.sharpness)).collect();
        let cage = Cage {
            points: &mesh.points,
            face_sizes: &mesh.face_sizes,
            corners: &mesh.corners,
            edge_creases: &creases,
            ..Cage::default()
        };
        let embree = Subdivision::new(&device, &cage, Boundary::EdgesAndCorners).unwrap();
        let extent = surface.extent();
        let mut worst = [0.0_f32; 2];
        for tile in 0..surface.tile_count() as u32 {
            let topology = surface.topology();
            let (face, sub) = (topology.face(tile), topology.sub_corner(tile));
            for k in 0..64_u32 {
                let (u, v) = ((k % 8) as f32 / 8.0 + 0.07, (k / 8) as f32 / 8.0 + 0.03);
                let ours = surface.sample(context.level(), Place::new(tile, u, v)).unwrap();
                let theirs = embree.evaluate(face, sub, u, v).unwrap();
                for axis in 0..3 {
                    worst[0] = worst[0].max((ours.p[axis] - theirs.p[axis]).abs() / extent);
                    worst[1] = worst[1].max((ours.du[axis] - theirs.du[axis]).abs() / extent);
                    worst[1] = worst[1].max((ours.dv[axis] - theirs.dv[axis]).abs() / extent);
                }
            }
        }
        println!("{name}: positions {:.1e}, derivatives {:.1e} of the extent", worst[0], worst[1]);
        assert!(worst[0] <= 1e-6, "{name}: positions {:e}", worst[0]);
        assert!(worst[1] <= 1e-5, "{name}: derivatives {:e}", worst[1]);
    }
}
