//! Objects with vector displacement: where their surface is found.

use glam::{DAffine3, DVec3};
use half::f16;
use relievo_core::{Context, Mesh};
use relievo_detail::DisplacedObject;
use relievo_surface::{Surface, SurfaceOptions};
use relievo_tiles::{ChannelOptions, Displacement, Sets, Vector, VectorDisplacement};

#[test]
fn the_nearest_point_is_on_the_surface_that_vectors_moved() {
    let context = Context::serial();
    let points = (0..16).map(|i| [(i % 4) as f32, (i / 4) as f32, 0.0]).collect();
    let face = |i: u32| [i, i + 1, i + 5, i + 4];
    let corners = (0..3).flat_map(|y| (0..3).flat_map(move |x| face(4 * y + x))).collect();
    let mesh = Mesh::new(points, vec![4; 9], corners);
    let surface = Surface::new(&context, &mesh, &SurfaceOptions::default()).unwrap();
    let options = ChannelOptions { size: 16, ..ChannelOptions::default() };
    let nothing = Displacement::new(surface.topology().clone(), &options).unwrap();
    let mut vectors = VectorDisplacement::on(&surface, &options).unwrap();
    let tiles: Vec<u32> = (0..9).collect();
    vectors.apply(&Sets { allocate: tiles.clone(), ..Sets::default() }).unwrap();
    let push = Vector([1.5, -0.5, 0.75].map(f16::from_f32));
    let changes = vectors.edit(&context, &tiles, |_, texels| (0..16).for_each(|j| texels.row_mut(j).fill(push)));
    vectors.settle(&context, &changes.unwrap()).unwrap();
    let mut object = DisplacedObject::new(&context, surface, &mesh.points, nothing, DAffine3::IDENTITY).unwrap();
    let at = DVec3::new(3.2, 1.1, 1.0);
    assert!(object.nearest(&context, at, 0.3).unwrap().is_none());
    object.set_vectors(vectors).unwrap();
    let found = object.nearest(&context, at, 0.3).unwrap().unwrap();
    assert!((found.point - DVec3::new(3.2, 1.1, 0.75)).length() < 1e-3, "{found:?}");
    let other = Surface::new(
        &context,
        &Mesh::new(mesh.points[..4].to_vec(), vec![4], vec![0, 1, 2, 3]),
        &SurfaceOptions::default(),
    );
    assert!(object.set_vectors(VectorDisplacement::on(&other.unwrap(), &options).unwrap()).is_err());
}
