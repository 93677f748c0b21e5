//! Meshes on a graphics device, against the processor's.

use std::sync::Arc;

use relievo_core::progress::Silent;
use relievo_core::{Context, ErrorKind};
use relievo_gpu::Device;
use relievo_lod::Progressive;
use relievo_lod::progressive::{ActiveMesh, BuildOptions, Cut, DeviceHierarchy, DeviceLevel, Extents, Extract, View};
use relievo_testing::device;

use crate::shapes::{Triangles, lifted, torus, two_tori};

fn shapes() -> [Triangles; 4] {
    let bumps = lifted(40, |x, y| 0.1 * (9.0 * x).sin() * (7.0 * y).cos() + 0.02 * (40.0 * x * y).sin());
    [torus(120, 60), bumps, lifted(30, |_, _| 0.0), two_tori()]
}

fn build((points, triangles): &Triangles, locked: Vec<u32>) -> Arc<Progressive> {
    let options = BuildOptions { faces: 60, locked };
    Arc::new(Progressive::build(&Context::serial(), points, triangles, &options, &mut Silent).unwrap())
}

fn at(device: &Device, level: &DeviceLevel, cut: Cut) -> Extract {
    let mut frame = device.frame().unwrap();
    level.adapt(&mut frame, cut).unwrap();
    let _ = frame.submit().unwrap();
    level.extract().unwrap()
}

#[test]
fn levels_on_a_device_are_those_of_the_processor() {
    let Some(device) = device() else { return };
    let context = Context::serial();
    for shape in shapes() {
        // In the last case hardly a split is left, and most of the base are vertices of the input.
        for locked in [Vec::new(), (0..shape.0.len() as u32).filter(|vertex| vertex % 7 != 0).collect()] {
            let mesh = build(&shape, locked);
            let hierarchy = Arc::new(DeviceHierarchy::new(&device, &mesh).unwrap());
            assert!(hierarchy.bytes() < 44 * shape.1.len());
            let level = DeviceLevel::new(&hierarchy).unwrap();
            let mut active = ActiveMesh::new(&mesh);
            let faces = [0, 61, 333, 1500].map(|faces| Cut::of_faces(&mesh, faces));
            let errors = [0.0, 1e-3, 0.02, 0.1].map(Cut::of_error);
            let cuts = faces.into_iter().chain(errors).chain([Cut::FINEST, Cut::BASE]);
            for cut in cuts {
                active.adapt(&context, cut);
                let made = at(&device, &level, cut);
                assert!(made == active.extract(), "{cut:?}");
                assert_eq!(level.counts().unwrap(), [active.vertex_count(), active.triangle_count()]);
            }
            let finest = at(&device, &level, Cut::FINEST);
            assert!(finest.points == shape.0 && finest.triangles == shape.1);
        }
    }
}

/// How near to a limit of a view a split is, as a share, that may be made or not.
const MARGIN: f32 = 1e-5;

#[test]
fn views_on_a_device_are_those_of_the_processor() {
    let Some(device) = device() else { return };
    let context = Context::serial();
    let everything = View { eye: [1.8, 0.0, 0.3], pixels: 500.0, tolerance: 3.0, outline: 1.0, planes: Vec::new() };
    let views = [
        everything.clone(),
        View { tolerance: 0.3, ..everything.clone() },
        View { eye: [-0.4, 0.5, 6.0], tolerance: 2.0, outline: 8.0, ..everything.clone() },
        View { planes: vec![[0.6, 0.8, 0.0, -0.3], [0.0, 0.0, 1.0, 0.05]], ..everything.clone() },
        View { eye: [400.0, 0.0, 0.0], ..everything },
    ];
    let mut same = 0;
    for shape in shapes() {
        let mesh = build(&shape, Vec::new());
        let extents = Extents::new(&mesh);
        let hierarchy = Arc::new(DeviceHierarchy::for_views(&context, &device, &mesh, &extents).unwrap());
        assert!(hierarchy.bytes() < 70 * shape.1.len());
        let level = DeviceLevel::new(&hierarchy).unwrap();
        let after_finest = |view: &View| {
            let mut active = ActiveMesh::new(&mesh);
            active.adapt(&context, Cut::FINEST);
            active.adapt_to(&context, view, &extents).unwrap();
            active.extract()
        };
        for view in &views {
            let mut frame = device.frame().unwrap();
            level.adapt_to(&mut frame, view).unwrap();
            let _ = frame.submit().unwrap();
            let made = level.extract().unwrap();
            // Splits within the margin that roundings have may be made or not.
            let limit = |share: f32| {
                let moved = |plane: &[f32; 4]| [plane[0], plane[1], plane[2], plane[3] - share * 4.0];
                let planes = view.planes.iter().map(moved).collect();
                after_finest(&View { tolerance: view.tolerance * (1.0 + share), planes, ..view.clone() })
            };
            let [fewest, most] = [MARGIN, -MARGIN].map(limit);
            let count = made.triangles.len();
            assert!(fewest.triangles.len() <= count && count <= most.triangles.len(), "{count} {view:?}");
            if fewest.triangles.len() == most.triangles.len() {
                assert!(made == after_finest(view), "{view:?}");
                same += 1;
            }
        }
    }
    assert!(same > 12, "{same}");
    let plain = Arc::new(DeviceHierarchy::new(&device, &build(&shapes()[1], Vec::new())).unwrap());
    let level = DeviceLevel::new(&plain).unwrap();
    let mut frame = device.frame().unwrap();
    assert_eq!(level.adapt_to(&mut frame, &views[0]).unwrap_err().kind, ErrorKind::Invalid);
}
