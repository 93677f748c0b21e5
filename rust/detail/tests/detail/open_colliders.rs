//! Colliders with open edges: what they leave is within their own boxes, on cages and on triangle meshes, whatever the
//! pose of the voxel grid; sheets are solid behind their front. And imprints into hidden layers.

use glam::{DAffine3, DVec3};
use relievo_core::{Context, ContextOptions, Mesh};
use relievo_detail::{
    Collider, DisplacedObject, ImprintSettings, Imprinter, LayeredObject, Moment, Motion, Pose, Report, TriangleObject,
};
use relievo_document::{Kind, Settings};
use relievo_surface::{Place, Surface, SurfaceOptions, TriangleSurface};
use relievo_tiles::triangle::{FaceRates, TriangleChannel, TriangleOptions};
use relievo_tiles::{Displacement, DisplacementOptions, Trace, Traces};

const SIDE: u32 = 6;

/// A flat plate of squares of edge 1 around the origin, facing +z.
fn plate() -> Mesh {
    let points = (0..=SIDE).flat_map(|y| (0..=SIDE).map(move |x| [x as f32 - 3.0, y as f32 - 3.0, 0.0])).collect();
    let corners = (0..SIDE * SIDE).map(|k| (SIDE + 1) * (k / SIDE) + k % SIDE);
    let corners = corners.flat_map(|a| [a, a + 1, a + SIDE + 2, a + SIDE + 1]).collect();
    Mesh::new(points, vec![4; (SIDE * SIDE) as usize], corners)
}

fn cage(context: &Context) -> DisplacedObject {
    let surface = Surface::new(context, &plate(), &SurfaceOptions::default()).unwrap();
    let options = DisplacementOptions { size: 32, ..DisplacementOptions::default() };
    let displacement = Displacement::new(surface.topology().clone(), &options).unwrap();
    DisplacedObject::new(context, surface, &plate().points, displacement, DAffine3::IDENTITY).unwrap()
}

fn triangles(context: &Context) -> TriangleObject {
    let mesh = plate();
    let surface = TriangleSurface::new(context, &Mesh::from_triangles(mesh.points.clone(), &mesh.triangles())).unwrap();
    let options = TriangleOptions { segments: 32, budget: 1 << 30 };
    let displacement = TriangleChannel::displacement(surface.topology().clone(), &options).unwrap();
    TriangleObject::new(context, surface, displacement, DAffine3::IDENTITY).unwrap()
}

/// The depth of dents by their place on the plate.
type Dents = Vec<([f32; 2], f32)>;

/// Presses a collider into a plate of either kind. Returns the dents and reports.
fn press(context: &Context, collider: &Collider, settings: &ImprintSettings, frame: u64) -> [(Dents, Report); 2] {
    let moment = Moment { frame, ..Moment::default() };
    let (mut cage, mut mesh) = (cage(context), triangles(context));
    let on_cage = Imprinter::new().imprint(context, &mut cage, collider, settings, moment).unwrap();
    let on_mesh = Imprinter::new().imprint(context, &mut mesh, collider, settings, moment).unwrap();
    let field = cage.displacement().field();
    let mut dents = Vec::new();
    for tile in 0..field.tile_count() as u32 {
        for at in 0..32u32 * 32 {
            let (i, j) = (at % 32, at / 32);
            let place = Place { tile, u: (i as f32 + 0.5) / 32.0, v: (j as f32 + 0.5) / 32.0 };
            let p = cage.surface().sample(context.level(), place).unwrap().p;
            let value = field.block(tile).map_or(0.0, |block| block[((j + 1) * 34 + i + 1) as usize].to_f32());
            dents.push(([p[0], p[1]], -value));
        }
    }
    let displaced = mesh.displaced().unwrap();
    let pattern = mesh.displacement().field().pattern();
    let rates = FaceRates { sides: [pattern.segments(); 3], inside: Some(pattern) };
    let knots = (0..mesh.surface().topology().face_count() as u32)
        .flat_map(|face| rates.places().into_iter().map(move |(pattern, node)| (face, pattern, node)));
    let on_knots = knots.map(|(face, pattern, node)| {
        let (foot, height) = displaced.at(face, pattern, node);
        ([foot.point.x, foot.point.y], -height)
    });
    [(dents, on_cage), (on_knots.collect(), on_mesh)]
}

/// A box of half edges 0.3 without the sides in `gone`: two triangles each, -x, +x, -y, +y, -z, +z.
fn part_of_box(gone: &[usize], split: bool) -> (Vec<[f32; 3]>, Vec<[u32; 3]>) {
    let points: Vec<[f32; 3]> =
        (0..8).map(|i| [0, 1, 2].map(|axis| if i >> axis & 1 == 0 { -0.3 } else { 0.3 })).collect();
    let quads = [[0u32, 4, 6, 2], [1, 3, 7, 5], [0, 1, 5, 4], [2, 6, 7, 3], [0, 2, 3, 1], [4, 5, 7, 6]];
    let kept = quads.iter().enumerate().filter(|(side, _)| !gone.contains(side));
    let faces: Vec<[u32; 3]> = kept.flat_map(|(_, q)| [[q[0], q[1], q[2]], [q[0], q[2], q[3]]]).collect();
    if !split {
        return (points, faces);
    }
    let corners = faces.iter().flatten().map(|point| points[*point as usize]).collect();
    (corners, (0..faces.len() as u32).map(|face| [3 * face, 3 * face + 1, 3 * face + 2]).collect())
}

#[test]
fn boxes_without_sides_dent_the_plate_under_them_alone() {
    for threads in [1, 3] {
        let context = Context::new(&ContextOptions { threads, memory_limit: 0 }).unwrap();
        let settings = ImprintSettings { voxels: 1 << 20, ..ImprintSettings::default() };
        let place = DAffine3::from_translation(DVec3::new(0.21, -0.13, 0.1)) * DAffine3::from_rotation_z(0.4);
        for (gone, split, open) in
            [(&[][..], true, 0), (&[0], false, 4), (&[0], true, 4), (&[5], true, 4), (&[1, 3], false, 6)]
        {
            let (points, faces) = part_of_box(gone, split);
            let collider = Collider::new(&context, points, faces, place).unwrap();
            assert_eq!((collider.open_edges(), collider.is_sheet()), (open, false), "{gone:?}");
            for (frame, (dents, report)) in
                (0..4).flat_map(|frame| press(&context, &collider, &settings, frame).map(|pressed| (frame, pressed)))
            {
                assert_eq!(report.open_edges, open as u64);
                let slack = report.voxel_diagonal as f32 + 1e-3;
                let mut deep = 0;
                for ([x, y], depth) in dents {
                    let local = place.inverse().transform_point3(DVec3::new(f64::from(x), f64::from(y), 0.0));
                    let outside = local.x.abs().max(local.y.abs()) as f32 - 0.3;
                    if outside > slack {
                        assert_eq!(depth, 0.0, "{gone:?} frame {frame}: {x} {y}");
                    } else if outside < -slack && gone.len() < 2 {
                        assert!((depth - 0.2).abs() <= slack, "{gone:?} frame {frame}: {x} {y} {depth}");
                    }
                    deep += usize::from(depth > 0.1);
                }
                assert!(deep > 100, "{gone:?} frame {frame}: {deep}");
            }
        }
    }
}

#[test]
fn seams_that_are_skinned_with_other_roundings_stay_closed() {
    let context = Context::serial();
    let settings = ImprintSettings { voxels: 1 << 20, ..ImprintSettings::default() };
    let place = DAffine3::from_translation(DVec3::new(0.2, 0.1, 0.1));
    let [whole, mut split] = [false, true].map(|split| {
        let (points, faces) = part_of_box(&[], split);
        Collider::new(&context, points, faces, place).unwrap()
    });
    let rounded: Vec<[f32; 3]> =
        split.points().iter().enumerate().map(|(k, p)| p.map(|value| value * (1.0 + 1e-7 * (k % 7) as f32))).collect();
    split.set_points(&context, &rounded).unwrap();
    assert!(split.is_closed());
    let (expected, found) = (press(&context, &whole, &settings, 3), press(&context, &split, &settings, 3));
    for ((expected, one), (found, other)) in expected.iter().zip(&found) {
        let slack = one.voxel_diagonal as f32;
        assert!(expected.iter().zip(found).all(|(a, b)| (a.1 - b.1).abs() <= slack));
        assert_eq!([one.open_edges, other.open_edges], [0; 2]);
    }
    // What comes apart is open, until it is together again.
    let mut torn = rounded;
    torn[..6].iter_mut().for_each(|point| point[0] -= 1.0);
    split.set_points(&context, &torn).unwrap();
    assert_eq!(split.open_edges(), 8);
    let (points, _) = part_of_box(&[], true);
    split.set_points(&context, &points).unwrap();
    assert_eq!(split.open_edges(), 0);
    assert!(press(&context, &split, &settings, 3)[0].0 == expected[0].0);
}

/// Checks that dents are within the box of their collider, by as much as a voxel, and counts them.
fn count_dents_within_box(collider: &Collider, dents: &Dents, report: &Report, when: &str) -> usize {
    let check = |&([x, y], depth): &([f32; 2], f32)| {
        let is_over = collider.obb().contains(DVec3::new(f64::from(x), f64::from(y), 0.0), report.voxel_diagonal);
        assert!(is_over || depth == 0.0, "{when}: {x} {y} {depth}");
        depth > 0.0
    };
    dents.iter().map(|dent| usize::from(check(dent))).sum()
}

#[test]
fn characters_leave_nothing_beside_their_boxes() {
    let Some(path) = relievo_testing::file("characters/girl.glb") else { return };
    let context = Context::new(&ContextOptions::default()).unwrap();
    let mesh = relievo_meshio::read(&context, &path).unwrap();
    let (low, high) = mesh.bounds().unwrap();
    let [low, high] = [low, high].map(|point| DVec3::from(point.map(f64::from)));
    // Two long, and half of it in the plate.
    let scale = 2.0 / (high - low).max_element();
    let place = DAffine3::from_scale(DVec3::splat(scale)) * DAffine3::from_translation(-0.5 * (low + high));
    let collider = Collider::of_mesh(&context, &mesh, place).unwrap();
    assert!(
        collider.open_edges() > 0 && collider.open_edges() < 60 && !collider.is_sheet(),
        "{}",
        collider.open_edges()
    );
    let settings = ImprintSettings { voxels: 1 << 20, ..ImprintSettings::default() };
    for frame in 0..3 {
        for (dents, report) in press(&context, &collider, &settings, frame) {
            let dented = count_dents_within_box(&collider, &dents, &report, &format!("frame {frame}"));
            assert!(dented > 200, "frame {frame}: {dented}");
        }
    }
}

#[test]
fn a_walking_character_leaves_nothing_beside_its_box() {
    let Some(path) = relievo_testing::file("characters/robot.glb") else { return };
    let context = Context::new(&ContextOptions::default()).unwrap();
    let model = relievo_meshio::read_model(&context, &path).unwrap();
    let walk = model.animation("Robot_Walking").unwrap();
    let (start, end) = model.animations[walk].range();
    let mesh = model.merged_mesh(&context).unwrap();
    let mut collider = Collider::of_mesh(&context, &mesh, DAffine3::IDENTITY).unwrap();
    let settings = ImprintSettings { voxels: 1 << 19, ..ImprintSettings::default() };
    for (frame, share) in [0.0, 0.2, 0.45, 0.7].into_iter().enumerate() {
        let points = model.pose(&context, walk, start + share * (end - start)).unwrap().merged_points();
        let ends = |pick: fn(DVec3, DVec3) -> DVec3| {
            points.iter().map(|point| DVec3::from(point.map(f64::from))).reduce(pick).unwrap()
        };
        let [low, high] = [ends(DVec3::min), ends(DVec3::max)];
        // Two long, y up turned to z, its lower quarter in the plate.
        let scale = 2.0 / (high - low).max_element();
        let hip = DVec3::new(0.5 * (low.x + high.x), low.y + 0.25 * (high.y - low.y), 0.5 * (low.z + high.z));
        let turn = DAffine3::from_rotation_x(std::f64::consts::FRAC_PI_2);
        collider.set_points(&context, &points).unwrap();
        collider
            .set_transform(DAffine3::from_scale(DVec3::splat(scale)) * turn * DAffine3::from_translation(-hip))
            .unwrap();
        for (dents, report) in press(&context, &collider, &settings, frame as u64) {
            let dented = count_dents_within_box(&collider, &dents, &report, &format!("pose {frame}"));
            assert!(dented > 20, "pose {frame}: {dented}");
        }
    }
}

#[test]
fn sheets_with_an_angle_dent_within_their_boxes_and_behind_their_front() {
    // A flat part below the plate's surface, facing down, and a flap up from its edge at y = 0.3, facing away from it.
    let points: Vec<[f32; 3]> = vec![
        [-0.5, -0.6, -0.1],
        [0.5, -0.6, -0.1],
        [0.5, 0.3, -0.1],
        [-0.5, 0.3, -0.1],
        [-0.5, 0.3, 0.3],
        [0.5, 0.3, 0.3],
    ];
    let faces = vec![[0, 2, 1], [0, 3, 2], [3, 5, 2], [3, 4, 5]];
    let settings = ImprintSettings { voxels: 1 << 20, max_displacement: 0.5, ..ImprintSettings::default() };
    let context = Context::serial();
    for angle in [0.0, 0.5] {
        let place = DAffine3::from_translation(DVec3::new(0.2, 0.1, 0.0)) * DAffine3::from_rotation_z(angle);
        let sheet = Collider::new(&context, points.clone(), faces.clone(), place).unwrap();
        assert!(sheet.is_sheet() && sheet.open_edges() == 6);
        for (dents, report) in press(&context, &sheet, &settings, 2) {
            let slack = report.voxel_diagonal as f32 + 0.05;
            let mut deep = 0;
            for ([x, y], depth) in dents {
                let local = place.inverse().transform_point3(DVec3::new(f64::from(x), f64::from(y), 0.0)).as_vec3();
                let outside = (local.x.abs() - 0.5).max((local.y + 0.15).abs() - 0.45);
                assert!(outside <= slack || depth == 0.0, "{angle}: {x} {y} {depth}");
                deep += usize::from(depth > 0.05);
            }
            assert!(deep > 100, "{angle}: {deep}");
        }
    }
}

#[test]
fn sheets_are_solid_behind_their_front_and_not_beside_it() {
    let context = Context::serial();
    let settings = ImprintSettings { voxels: 1 << 20, max_displacement: 0.5, ..ImprintSettings::default() };
    // The underside of the box alone, which faces down, and turned over.
    let (points, faces) = part_of_box(&[0, 1, 2, 3, 5], false);
    let turned: Vec<[u32; 3]> = faces.iter().map(|[a, b, c]| [*a, *c, *b]).collect();
    for (faces, is_solid) in [(faces, true), (turned, false)] {
        let place = DAffine3::from_translation(DVec3::new(0.2, 0.1, 0.1));
        let mut sheet = Collider::new(&context, points.clone(), faces, place).unwrap();
        assert!(sheet.is_sheet() && sheet.open_edges() == 4);
        for (dents, report) in press(&context, &sheet, &settings, 1) {
            // Columns are turned by up to 0.1 against the front.
            let slack = report.voxel_diagonal as f32 + 0.05;
            let mut deep = 0;
            for ([x, y], depth) in dents {
                let outside = (x - 0.2).abs().max((y - 0.1).abs()) - 0.3;
                assert!(outside <= slack || depth == 0.0, "{x} {y} {depth}");
                assert!(!is_solid || outside > -slack || (depth - 0.2).abs() <= slack, "{x} {y} {depth}");
                deep += usize::from(depth > 0.1);
            }
            assert_eq!(deep > 100, is_solid, "{deep}");
        }
        // A turned pose of its points turns the front along.
        let over: Vec<[f32; 3]> = points.iter().map(|[x, y, z]| [*x, -*y, -*z]).collect();
        sheet.set_points(&context, &over).unwrap();
        sheet.set_transform(DAffine3::from_translation(DVec3::new(0.2, 0.1, -0.5))).unwrap();
        let dented =
            press(&context, &sheet, &settings, 1).map(|(dents, _)| dents.iter().filter(|it| it.1 > 0.1).count());
        assert!(dented.iter().all(|count| (*count > 100) == !is_solid), "{dented:?}");
    }
}

#[test]
fn what_columns_through_a_rim_fill_is_cut_off_at_the_box_of_a_sheet() {
    // A roof above the plate that faces down, and a flap that hangs from it into the plate. Columns run across the flap,
    // the only part that is met, and find no other side.
    let points: Vec<[f32; 3]> = vec![
        [-1.0, -1.0, 1.0],
        [1.0, -1.0, 1.0],
        [1.0, 1.0, 1.0],
        [-1.0, 1.0, 1.0],
        [1.0, -0.15, 1.0],
        [1.0, 0.15, 1.0],
        [1.0, 0.15, -0.2],
        [1.0, -0.15, -0.2],
    ];
    let faces = vec![[0, 2, 1], [0, 3, 2], [4, 6, 5], [4, 7, 6]];
    let settings = ImprintSettings { voxels: 1 << 20, max_displacement: 0.6, ..ImprintSettings::default() };
    let context = Context::serial();
    for (mirrored, faces) in [(false, faces.clone()), (true, faces)] {
        let sign = if mirrored { -1.0 } else { 1.0 };
        let place = DAffine3::from_scale(DVec3::new(sign, 1.0, 1.0));
        let sheet = Collider::new(&context, points.clone(), faces, place).unwrap();
        assert!(sheet.is_sheet());
        for (dents, report) in press(&context, &sheet, &settings, 1) {
            // The front looks by a tenth to the side, and boxes are turned by up to 0.1.
            let slack = report.voxel_diagonal as f32 + 0.2;
            let dented = dents.iter().filter(|(_, depth)| *depth > 0.1);
            assert!(dented.clone().count() > 100);
            for ([x, y], depth) in dented {
                assert!(x.abs() <= 1.0 + slack && y.abs() <= 0.15 + slack, "{mirrored} {x} {y} {depth}");
            }
        }
    }
}

/// Adds a hidden layer to an object, to which edits go.
fn hide_edits<O: LayeredObject>(context: &Context, object: &mut O) {
    let hidden = Settings { visible: false, ..Settings::of(Kind::Scalar) };
    let layer = object.add_layer(context, Kind::Scalar, "more", hidden, 32).unwrap().0;
    object.set_active_layer(context, layer).unwrap();
}

#[test]
fn nothing_is_pressed_into_hidden_layers_and_no_trace_is_left() {
    let context = Context::serial();
    let (points, faces) = part_of_box(&[], false);
    let place = DAffine3::from_translation(DVec3::new(0.2, 0.1, 0.1));
    let mut collider = Collider::new(&context, points, faces, place).unwrap();
    let settings = ImprintSettings { voxels: 1 << 18, ..ImprintSettings::default() };
    let motion = Motion::new(&collider, Pose::rigid(place), Pose::rigid(place)).unwrap();
    let (moment, mut imprinter) = (Moment::default(), Imprinter::new());
    let is_refused = |done: relievo_core::Result<Report>| done.unwrap_err().to_string().contains("cannot be seen");

    let mut object = cage(&context);
    object.set_traces(Traces::of(object.displacement().field(), 1 << 30).unwrap()).unwrap();
    hide_edits(&context, &mut object);
    assert!(is_refused(imprinter.imprint(&context, &mut object, &collider, &settings, moment)));
    assert!(is_refused(imprinter.sweep(&context, &mut object, &mut collider, &motion, &settings, moment)));
    let traced = object.traces().unwrap().field().allocated().count();
    assert_eq!([traced, object.displacement().field().allocated().count()], [0, 0]);

    let mut object = triangles(&context);
    let traces = TriangleChannel::<Trace>::of(object.displacement().field(), 1 << 30).unwrap();
    object.set_traces(traces).unwrap();
    hide_edits(&context, &mut object);
    assert!(is_refused(imprinter.imprint(&context, &mut object, &collider, &settings, moment)));
    assert!(is_refused(imprinter.sweep(&context, &mut object, &mut collider, &motion, &settings, moment)));
    let traced = object.traces().unwrap().field().allocated().count();
    assert_eq!([traced, object.displacement().field().allocated().count()], [0, 0]);
}
