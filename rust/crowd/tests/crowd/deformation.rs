//! Deformation levels and regions of characters of which both can be told by hand (Section 4.2).

use glam::{DAffine3, DQuat, DVec3};
use relievo_core::progress::Silent;
use relievo_core::{Attribute, Context, Domain, Mesh, Values};
use relievo_crowd::{BuildSettings, CrowdModel, NONE};
use relievo_meshio::{Animation, Channel, Interpolation, Model, Node, Part, Placement, Property, Skin};

/// Two bones with equal weight; both may be one.
type Pair = [u32; 2];

/// Makes a character of four bones: the root 0, which turns by 45 degrees, its children 1, which turns by 90 degrees, and 2,
/// which rests, and 3 at x = 1, a child of 1 that turns by 90 degrees more. The turns about z happen between two poses.
fn character(points: &[([f32; 3], Pair)], triangles: &[[u32; 3]]) -> Model {
    let mut mesh = Mesh::from_triangles(points.iter().map(|it| it.0).collect(), triangles);
    let attribute = |name: &str, values: Values| Attribute {
        name: name.into(),
        domain: Domain::Point,
        width: 4,
        values,
        indices: None,
    };
    let weights = |[a, b]: Pair| if a == b { [1.0, 0.0, 0.0, 0.0] } else { [0.5, 0.5, 0.0, 0.0] };
    let joints = points.iter().flat_map(|(_, [a, b])| [*a, if a == b { 0 } else { *b }, 0, 0]).collect();
    mesh.attributes.push(attribute("joints", Values::U32(joints)));
    mesh.attributes.push(attribute("weights", Values::F32(points.iter().flat_map(|it| weights(it.1)).collect())));
    let node = |parent: Option<usize>, x: f64| Node {
        name: String::new(),
        parent,
        local: Placement::Parts { translation: DVec3::X * x, rotation: DQuat::IDENTITY, scale: DVec3::ONE },
        mesh: None,
        skin: None,
        weights: None,
    };
    let turn = |node: usize, degrees: f64| Channel {
        node,
        property: Property::Rotation,
        interpolation: Interpolation::Linear,
        times: vec![0.0, 1.0, 2.0],
        values: [0.0, degrees, degrees]
            .iter()
            .flat_map(|angle| DQuat::from_rotation_z(angle.to_radians()).to_array().map(|value| value as f32))
            .collect(),
    };
    let shown = Node { mesh: Some(0), skin: Some(0), ..node(None, 0.0) };
    Model {
        meshes: vec![Part { mesh, ..Part::default() }],
        nodes: vec![shown, node(None, 0.0), node(Some(1), 0.0), node(Some(1), 0.0), node(Some(2), 1.0)],
        skins: vec![Skin {
            name: String::new(),
            joints: vec![1, 2, 3, 4],
            inverse_bind: [0.0, 0.0, 0.0, -1.0].map(|x| DAffine3::from_translation(DVec3::X * x)).to_vec(),
        }],
        animations: vec![Animation {
            name: "turn".into(),
            channels: vec![turn(1, 45.0), turn(2, 90.0), turn(4, 90.0)],
            ..Animation::default()
        }],
        ..Model::default()
    }
}

fn built(source: &Model, cluster_triangles: u32) -> CrowdModel {
    let settings = BuildSettings { cluster_triangles, pose_rate: 1.0, ..BuildSettings::default() };
    let model = CrowdModel::build(&Context::serial(), source, &[0], &settings, &mut Silent).unwrap();
    assert_eq!(model.clips[0].poses.len(), 2);
    model
}

#[test]
fn levels_are_paths_in_the_frame_of_the_least_common_ancestor() {
    // One triangle for each pair of bones, whose first corner deforms most, with its level.
    let half = 0.5f32.sqrt();
    let cases: [(Pair, f32, f32); 5] = [
        // One bone, however it moves.
        ([1, 1], 1.0, 0.0),
        // In the frame of the root, which turns too: from (1, 0) to the middle of (1, 0) and (0, 1).
        ([0, 1], 1.0, half),
        // Sisters: the frame is that of their parent.
        ([1, 2], 1.0, half),
        // In the frame of the child of the root: from (2, 0) to the middle of (2, 0) and (1, 1).
        ([1, 3], 2.0, half),
        // In that of the root: from (2, 0) to the middle of (2, 0) and, turned by 180 degrees about (0, 1), (-1, 1).
        ([2, 3], 2.0, 2.5f32.sqrt()),
    ];
    let (mut points, mut triangles) = (Vec::new(), Vec::new());
    for (pair, x, _) in cases {
        let first = points.len() as u32;
        triangles.push([first, first + 1, first + 2]);
        // Turns are about z, so places that differ in z alone have one level.
        points.extend([[x, 0.0, 0.0], [x, 0.0, 0.1], [x, 1e-3, 0.05]].map(|point| (point, pair)));
    }
    let model = built(&character(&points, &triangles), 8);
    for (triangle, (pair, _, level)) in triangles.iter().zip(cases) {
        let own = |cluster: &u32| model.triangles(*cluster).iter().flatten().any(|vertex| triangle.contains(vertex));
        let cluster = model.input_clusters().into_iter().find(own).unwrap();
        let found = model.clusters[cluster as usize];
        assert_eq!(found.count, 1, "triangles without a common edge are in clusters of their own");
        assert!((found.deformation - level).abs() < 2e-3, "{pair:?}: {} and not {level}", found.deformation);
    }
}

#[test]
fn neighbours_within_a_tenth_of_their_level_are_one_region() {
    // A sheet along z in 20 strips of two triangles. Its level is a share of its distance from the axis, which grows after
    // eight of them.
    let leaves = |far: f32| -> Vec<u32> {
        let mut points = Vec::new();
        for ring in 0..=20 {
            let radius = if ring <= 8 { 1.0 } else { far };
            for angle in [0.0f32, 0.2] {
                points.push(([radius * angle.cos(), radius * angle.sin(), 0.2 * ring as f32], [0, 1]));
            }
        }
        let strips = (0..20).map(|ring| 2 * ring);
        let triangles: Vec<[u32; 3]> = strips.flat_map(|a| [[a, a + 1, a + 3], [a, a + 3, a + 2]]).collect();
        let model = built(&character(&points, &triangles), 30);
        let mut counts: Vec<u32> = model.clusters.iter().filter(|it| it.made_by == NONE).map(|it| it.count).collect();
        counts.sort_unstable();
        counts
    };
    // Together they are more than a cluster holds, and are cut in the middle.
    assert_eq!(leaves(1.09), [20, 20]);
    // Apart each fits. The strip between has the level of its more deformed side.
    assert_eq!(leaves(1.2), [16, 24]);
}
