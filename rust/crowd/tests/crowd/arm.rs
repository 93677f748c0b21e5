//! A bending arm: a closed tube of three bones with bumps and a seam of texture coordinates, and models of the folder.

use std::collections::BTreeMap;
use std::sync::{Arc, Mutex, OnceLock};

use glam::{DAffine3, DQuat, DVec3};
use relievo_core::progress::Silent;
use relievo_core::{Attribute, Context, Domain, Mesh, Values};
use relievo_crowd::{Blend, BuildSettings, CrowdModel};
use relievo_meshio::{Animation, Channel, Interpolation, Model, Node, Part, Placement, Property, Skin};

/// Makes an arm of `rings` rings of `sides` sides each along y, from 0 to 3. Its joints at 1 and 2 bend within a second.
pub fn arm(rings: usize, sides: usize) -> Model {
    let mut mesh = Mesh::default();
    let (mut uv, mut joints, mut weights) = (Vec::new(), Vec::new(), Vec::new());
    // The first column of each ring is there twice, for the seam.
    let columns = sides + 1;
    let mut add = |mesh: &mut Mesh, point: [f64; 3], place: [f32; 2]| {
        mesh.points.push(point.map(|value| value as f32));
        uv.extend(place);
        let along = (point[1] - 0.5).clamp(0.0, 2.0);
        let bone = (along.floor() as u32).min(1);
        let share = ((along - f64::from(bone) - 0.3) / 0.4).clamp(0.0, 1.0) as f32;
        joints.extend([bone, bone + 1, 0, 0]);
        weights.extend([1.0 - share, share, 0.0, 0.0]);
    };
    for ring in 0..rings {
        let height = 3.0 * ring as f64 / (rings - 1) as f64;
        for column in 0..columns {
            let angle = std::f64::consts::TAU * (column % sides) as f64 / sides as f64;
            let radius = 0.3 + 0.02 * (5.0 * angle).sin() * (7.0 * height).cos();
            let place = [column as f32 / sides as f32, height as f32 / 3.0];
            add(&mut mesh, [radius * angle.cos(), height, radius * angle.sin()], place);
        }
    }
    let ends = [mesh.points.len() as u32, mesh.points.len() as u32 + 1];
    add(&mut mesh, [0.0, -0.1, 0.0], [0.5, 0.0]);
    add(&mut mesh, [0.0, 3.1, 0.0], [0.5, 1.0]);
    let at = |ring: usize, column: usize| (ring * columns + column) as u32;
    let mut triangles = Vec::new();
    for column in 0..sides {
        for ring in 1..rings {
            let [a, b, c, d] = [at(ring - 1, column), at(ring - 1, column + 1), at(ring, column + 1), at(ring, column)];
            triangles.extend([[a, d, c], [a, c, b]]);
        }
        // The caps have their own texture coordinates at the rim only where columns meet.
        triangles.push([ends[0], at(0, column), at(0, column + 1)]);
        triangles.push([ends[1], at(rings - 1, column + 1), at(rings - 1, column)]);
    }
    mesh.face_sizes = vec![3; triangles.len()];
    mesh.corners = triangles.as_flattened().to_vec();
    let attribute = |name: &str, width: u32, values: Values| Attribute {
        name: name.into(),
        domain: Domain::Point,
        width,
        values,
        indices: None,
    };
    mesh.attributes = vec![
        attribute("uv", 2, Values::F32(uv)),
        attribute("joints", 4, Values::U32(joints)),
        attribute("weights", 4, Values::F32(weights)),
    ];
    let node = |name: &str, parent: Option<usize>, height: f64| Node {
        name: name.into(),
        parent,
        local: Placement::Parts { translation: DVec3::Y * height, rotation: DQuat::IDENTITY, scale: DVec3::ONE },
        mesh: None,
        skin: None,
        weights: None,
    };
    let shown = Node { mesh: Some(0), skin: Some(0), ..node("mesh", None, 0.0) };
    let channels = vec![turning(2, DVec3::Z, 100.0), turning(3, DVec3::Z, -70.0)];
    let inverse = |height: f64| DAffine3::from_translation(-DVec3::Y * height);
    Model {
        meshes: vec![Part { mesh, ..Part::default() }],
        nodes: vec![shown, node("upper", None, 0.0), node("middle", Some(1), 1.0), node("lower", Some(2), 1.0)],
        skins: vec![Skin {
            name: String::new(),
            joints: vec![1, 2, 3],
            inverse_bind: vec![inverse(0.0), inverse(1.0), inverse(2.0)],
        }],
        animations: vec![Animation { name: "bend".into(), channels, ..Animation::default() }],
        ..Model::default()
    }
}

/// Turns a node about an axis within half a second, and back.
fn turning(node: usize, axis: DVec3, degrees: f64) -> Channel {
    let turns = [0.0, 1.0, 0.0].map(|share: f64| DQuat::from_axis_angle(axis, share * degrees.to_radians()));
    Channel {
        node,
        property: Property::Rotation,
        interpolation: Interpolation::Linear,
        times: vec![0.0, 0.5, 1.0],
        values: turns.iter().flat_map(|turn| turn.to_array().map(|value| value as f32)).collect(),
    }
}

/// Makes an arm that is wrung like a cloth: blended matrices make it thin where dual quaternions do not.
pub fn twisting_arm(rings: usize, sides: usize) -> Model {
    let mut model = arm(rings, sides);
    let axis = DVec3::new(0.3, 1.0, 0.0).normalize();
    model.animations[0].channels = vec![turning(2, axis, 165.0), turning(3, DVec3::Y, -150.0)];
    model
}

/// What tests share, made once for each name.
type Shared<T> = Mutex<BTreeMap<String, Arc<OnceLock<T>>>>;

/// Returns what `make` makes for a name; other tests that ask for it meanwhile wait.
fn shared<T: Clone>(made: &Shared<T>, name: String, make: impl FnOnce() -> T) -> T {
    let slot = Arc::clone(made.lock().unwrap().entry(name).or_default());
    slot.get_or_init(make).clone()
}

/// Returns the hierarchy of an arm of about `2 * rings * sides` triangles.
pub fn built(rings: usize, sides: usize) -> CrowdModel {
    static MADE: Shared<CrowdModel> = Mutex::new(BTreeMap::new());
    let settings =
        BuildSettings { cluster_triangles: 40, group_clusters: 4, pose_rate: 12.0, ..BuildSettings::default() };
    let build = || CrowdModel::build(&Context::serial(), &arm(rings, sides), &[0], &settings, &mut Silent).unwrap();
    shared(&MADE, format!("{rings} {sides}"), build)
}

/// Returns the hierarchy of an arm that is wrung, with its bones blended as dual quaternions.
pub fn wrung(rings: usize, sides: usize) -> CrowdModel {
    static MADE: Shared<CrowdModel> = Mutex::new(BTreeMap::new());
    let settings =
        BuildSettings { cluster_triangles: 40, group_clusters: 4, pose_rate: 12.0, ..BuildSettings::default() };
    let context = Context::serial();
    let build = || {
        let built = CrowdModel::build(&context, &twisting_arm(rings, sides), &[0], &settings, &mut Silent).unwrap();
        built.with_blend(&context, Blend::DualQuaternion).unwrap()
    };
    shared(&MADE, format!("{rings} {sides}"), build)
}

/// Reads a character of the folder of models, or nothing where it is absent.
pub fn character(name: &str) -> Option<Model> {
    let path = relievo_testing::file(&format!("characters/{name}.glb"))?;
    Some(relievo_meshio::read_model(&Context::serial(), &path).unwrap())
}

/// Returns a character and its hierarchy for one of its clips, or nothing where it is absent.
pub fn walking(name: &str, clip: &str) -> Option<(Model, CrowdModel)> {
    static MADE: Shared<Option<(Model, CrowdModel)>> = Mutex::new(BTreeMap::new());
    shared(&MADE, format!("{name} {clip}"), || {
        let model = character(name)?;
        let clip = model.animation(clip).unwrap();
        let context = Context::new(&Default::default()).unwrap();
        let settings = BuildSettings { pose_rate: 12.0, ..BuildSettings::default() };
        let built = CrowdModel::build(&context, &model, &[clip], &settings, &mut Silent).unwrap();
        Some((model, built))
    })
}

/// Makes an arm whose middle swells while it bends, by a morph target of the same clip.
pub fn swelling_arm(rings: usize, sides: usize) -> Model {
    let mut model = arm(rings, sides);
    let part = &mut model.meshes[0];
    let offset = |point: &[f32; 3]| {
        let bump = 1.5 * (1.0 - (point[1] - 1.5).abs()).max(0.0);
        [bump * point[0], 0.0, bump * point[2]]
    };
    part.targets = vec![part.mesh.points.iter().map(offset).collect()];
    part.weights = vec![0.0];
    model.animations[0].channels.push(Channel {
        node: 0,
        property: Property::Weights,
        interpolation: Interpolation::Linear,
        times: vec![0.0, 0.25, 1.0],
        values: vec![0.0, 1.0, 0.0],
    });
    model
}
