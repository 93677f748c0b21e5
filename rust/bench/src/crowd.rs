//! Bench `crowd`: hierarchies of articulated models beside meshoptimizer's cluster hierarchy, which knows the bind pose
//! alone, clusters by an octree, and hierarchies over all poses; the cuts of a thousand agents; whole crowds on a graphics device.

mod device;

use std::collections::HashMap;
use std::sync::Arc;

use glam::{BVec3, DAffine3, DMat3, DVec3, Vec3};
use meshopt::clusterlod::{ClodMesh, clod_build, clod_default_config};
use relievo_core::progress::Silent;
use relievo_core::{Attribute, Context, ContextOptions, Mesh, Result, Values};
use relievo_crowd::{
    Agent, Blend, BuildSettings, Character, Crowd, CrowdModel, CrowdView, Frame, parse_agents, skin, square,
};
use relievo_lod::distance;
use relievo_meshio::Model;

use crate::deviation::Deviation;
use crate::measure::{Sample, seconds};
use crate::report::{Goal, Report};

/// A walking person, its clip, and how often its triangles are divided into four.
const PERSON: (&str, &str, u32) = ("characters/girl.glb", "RunTrack", 4);
/// The same for comparisons in every pose.
const COMPARED: u32 = 2;
/// Poses that distances are compared in.
const COMPARED_POSES: f32 = 12.0;
/// Errors that the peer is asked for, as shares of the model's diagonal.
const SHARES: [f32; 3] = [0.003, 0.01, 0.03];
/// Distance of poses within which they count as alike, for a hierarchy that is simplified over all of them.
const EVERY_POSE: f32 = 0.001;
/// Poses of the clip.
const POSES: f32 = 8.0;
const AGENTS: usize = 1000;
/// Frames of a walk through the crowd.
const FRAMES: usize = 300;
const SIZE: [u32; 2] = [1280, 720];

pub fn run(report: &mut Report) -> Result<()> {
    let context = Context::new(&ContextOptions::default())?;
    let (name, clip, times) = PERSON;
    let path = relievo_testing::folder().join(name);
    if !path.is_file() {
        report.skip("crowd", "characters/girl.glb is not there");
        return Ok(());
    }
    let source = relievo_meshio::read_model(&context, &path)?;
    let clip = source.animation(clip)?;
    let (start, end) = source.animations[clip].range();
    let rate = |poses: f32| BuildSettings { pose_rate: poses / (end - start) as f32, ..BuildSettings::default() };
    let fine = refined(&source, times);
    let mut model = CrowdModel::default();
    let time =
        seconds(|| model = CrowdModel::build(&context, &fine, &[clip], &rate(POSES), &mut Silent).unwrap_or_default());
    let triangles = f64::from(model.input_triangles);
    let case = format!("build of a person, {triangles} triangles, {POSES} poses");
    report.add(&case, &Sample::new(vec![time]), None, "s", Goal::AtMost(10.0));
    let mut file = Vec::new();
    model.write(&mut file).map_err(|error| relievo_core::Error::internal(error.to_string()))?;
    report.add(
        "its file",
        &Sample::new(vec![file.len() as f64 / triangles]),
        None,
        "bytes/triangle",
        Goal::AtMost(48.0),
    );
    cuts(report, &context, model)?;
    device::run(report, &context, (&source, clip), &rate(POSES))?;
    // The peer takes vertices at one place as one, so that both have the shape alone. Seams would open where the weights of
    // both sides are rounded apart when triangles are divided.
    let mut bare = source.clone();
    for part in &mut bare.meshes {
        part.mesh.attributes.retain(|attribute| attribute.name == "joints" || attribute.name == "weights");
        part.mesh = joined(&part.mesh);
    }
    let bare = refined(&bare, COMPARED);
    let settings = rate(COMPARED_POSES);
    let model = CrowdModel::build(&context, &bare, &[clip], &settings, &mut Silent)?;
    SHARES.into_iter().try_for_each(|share| compare(report, &context, &model, share))?;
    all_poses(report, &context, (&bare, clip), (&model, &settings))?;
    let character = Character::from_model(&context, &bare)?;
    let cells = octree(&character, settings.cluster_triangles as usize);
    let peer = CrowdModel::build_from(&context, (&bare, &[clip]), &cells, &settings, &mut Silent)?;
    for share in SHARES {
        let count =
            |model: &CrowdModel| Sample::new(vec![model.triangle_count(&model.cut(share * model.size())) as f64]);
        let case = format!("triangles at an error of {:.1} %, beside clusters by an octree", 100.0 * share);
        // The paper draws 50 % fewer.
        report.add(&case, &count(&model), Some(("octree", &count(&peer))), "", Goal::RatioAtMost(0.67));
    }
    Ok(())
}

/// Compares the distance of cuts from the input, root mean square over all poses, with that of a hierarchy simplified over all
/// poses, for as many triangles as there are.
fn all_poses(
    report: &mut Report,
    context: &Context,
    (source, clip): (&Model, usize),
    (model, settings): (&CrowdModel, &BuildSettings),
) -> Result<()> {
    let settings = BuildSettings { pose_distance: EVERY_POSE, ..*settings };
    let peer = CrowdModel::build(context, source, &[clip], &settings, &mut Silent)?;
    let input = model.character.triangles[..model.input_triangles as usize].to_vec();
    let poses = model.clips[0].poses.iter().map(|pose| skin(context, &model.character, pose, Blend::Linear));
    let poses = poses.collect::<Result<Vec<_>>>()?;
    let mean = |model: &CrowdModel, cut: &[u32]| -> Result<f64> {
        let triangles: Vec<[u32; 3]> = cut.iter().flat_map(|it| model.triangles(*it)).copied().collect();
        let of = |points: &Vec<[f32; 3]>| {
            Deviation::between(context, &(points.clone(), input.clone()), &(points.clone(), triangles.clone()))
        };
        let squares = poses.iter().map(|points| Ok(of(points)?.mean.powi(2))).collect::<Result<Vec<f64>>>()?;
        Ok((squares.iter().sum::<f64>() / squares.len() as f64).sqrt())
    };
    for share in [SHARES[0], SHARES[1]] {
        let cut = model.cut(share * model.size());
        let count = model.triangle_count(&cut);
        let cuts = peer.groups.iter().map(|group| peer.cut(group.error));
        let nearest = cuts.min_by_key(|cut| peer.triangle_count(cut).abs_diff(count)).unwrap_or_default();
        let [ours, theirs] = [mean(model, &cut)?, mean(&peer, &nearest)?].map(|mean| Sample::new(vec![mean]));
        let case = format!(
            "root mean square in all poses, {count} triangles; over {} of {} poses, and {} triangles over {}",
            model.report.representatives,
            model.report.poses,
            peer.triangle_count(&nearest),
            peer.report.representatives
        );
        report.add(&case, &ours, Some(("over all poses", &theirs)), "% of the diagonal", Goal::RatioAtMost(1.02));
    }
    Ok(())
}

/// Divides the triangles of a character at binding by an octree until no cell has more than `most`, as the paper's naive
/// method does (Section 6).
fn octree(character: &Character, most: usize) -> Vec<Vec<u32>> {
    let middle = |triangle: u32| {
        let corners =
            character.triangles[triangle as usize].map(|vertex| Vec3::from(character.points[vertex as usize]));
        corners.iter().sum::<Vec3>() / 3.0
    };
    let all: Vec<u32> = (0..character.triangles.len() as u32).collect();
    let bounds = all.iter().fold((Vec3::INFINITY, Vec3::NEG_INFINITY), |(low, high), triangle| {
        (low.min(middle(*triangle)), high.max(middle(*triangle)))
    });
    let (mut open, mut cells) = (vec![(all, bounds)], Vec::new());
    while let Some((list, (low, high))) = open.pop() {
        let center = 0.5 * (low + high);
        if list.len() <= most {
            cells.push(list);
            continue;
        }
        if center == low || center == high {
            // All are at one place.
            cells.extend(list.chunks(most).map(<[u32]>::to_vec));
            continue;
        }
        let mut octants: [Vec<u32>; 8] = Default::default();
        for triangle in list {
            octants[middle(triangle).cmpge(center).bitmask() as usize].push(triangle);
        }
        for (number, octant) in octants.into_iter().enumerate().filter(|(_, octant)| !octant.is_empty()) {
            let is_high = BVec3::new(number & 1 != 0, number & 2 != 0, number & 4 != 0);
            let bounds = (Vec3::select(is_high, center, low), Vec3::select(is_high, high, center));
            open.push((octant, bounds));
        }
    }
    cells
}

/// Measures the cuts of a crowd that walks while the camera goes through it.
fn cuts(report: &mut Report, context: &Context, model: CrowdModel) -> Result<()> {
    let size = f64::from(model.size());
    let agents = parse_agents(&square(&model, AGENTS, 0.8 * size), &[&model])?;
    let full = u64::from(model.input_triangles);
    let mut crowd = Crowd::new(vec![Arc::new(model)]);
    for agent in &agents {
        crowd.add(*agent)?;
    }
    let half = 0.4 * size * (AGENTS as f64).sqrt();
    let (mut times, mut drawn, mut in_view) = (Vec::new(), 0.0, 0.0);
    let mut frame = Frame::default();
    for number in 0..FRAMES {
        let time = number as f64 / 60.0;
        let eye = DVec3::new(0.3 * half, size, half * (1.3 - 0.2 * time));
        let axes = DMat3::from_rotation_y(0.1 * time);
        let view = CrowdView::perspective(eye, axes, 0.7, SIZE, 0.5)?;
        let mut done = Ok(());
        times.push(1e3 * seconds(|| done = walk(&mut crowd, context, &agents, time, &view, &mut frame)));
        done?;
        drawn += frame.triangles as f64;
        in_view += (full * frame.drawn.len() as u64) as f64;
    }
    let case = format!("cut of {AGENTS} agents that walk, a frame");
    report.add(&case, &Sample::new(times), None, "ms", Goal::AtMost(0.3));
    let share = 100.0 * drawn / in_view;
    // The exhibition of the paper draws 3.14 of 24.66 million triangles without culling by occlusion (Table 1).
    let goal = Goal::AtMost(12.7);
    report.add("triangles drawn at 0.5 pixels", &Sample::new(vec![share]), None, "% of those in view", goal);
    Ok(())
}

/// Moves all agents ahead and cuts the crowd.
fn walk(
    crowd: &mut Crowd,
    context: &Context,
    agents: &[Agent],
    time: f64,
    view: &CrowdView,
    frame: &mut Frame,
) -> Result<()> {
    for (index, agent) in agents.iter().enumerate() {
        crowd.set(index as u32, moved(agent, time))?;
    }
    crowd.cut(context, view, frame)
}

/// Returns an agent that has gone ahead by so many of its own units.
fn moved(agent: &Agent, distance: f64) -> Agent {
    let step = DAffine3::from_translation(agent.transform.matrix3 * DVec3::Z * distance);
    Agent { transform: step * agent.transform, ..*agent }
}

/// Compares the triangles of a cut with those of the peer at the same distance from the input in the worst pose.
fn compare(report: &mut Report, context: &Context, model: &CrowdModel, share: f32) -> Result<()> {
    let input: Vec<[u32; 3]> = model.character.triangles[..model.input_triangles as usize].to_vec();
    let poses = model.clips[0].poses.iter().map(|pose| skin(context, &model.character, pose, Blend::Linear));
    let poses = poses.collect::<Result<Vec<_>>>()?;
    let worst = |triangles: &[[u32; 3]]| -> Result<f32> {
        let of = |points: &Vec<[f32; 3]>| distance(context, [(points, &input), (points, triangles)], &mut Silent);
        poses.iter().try_fold(0.0f32, |most, points| Ok(most.max(of(points)?.at_most)))
    };
    let peer = bind_pose_cut(model, &input, share * model.size());
    let allowed = worst(&peer)?;
    // Errors of cuts bound distances, so the coarsest cut within the peer's distance is beyond its own error.
    let mut errors: Vec<f32> = model.groups.iter().map(|group| group.error).collect();
    errors.sort_unstable_by(f32::total_cmp);
    let triangles = |error: f32| -> Vec<[u32; 3]> {
        model.cut(error).iter().flat_map(|cluster| model.triangles(*cluster)).copied().collect()
    };
    let (mut low, mut high) = (0, errors.len());
    while low < high {
        let middle = (low + high) / 2;
        if worst(&triangles(errors[middle]))? <= allowed { low = middle + 1 } else { high = middle }
    }
    let ours = if low == 0 { input.len() } else { triangles(errors[low - 1]).len() };
    let case = format!("triangles within {:.2} % in all {} poses", 100.0 * allowed / model.size(), poses.len());
    let [ours, theirs] = [ours, peer.len()].map(|count| Sample::new(vec![count as f64]));
    report.add(&case, &ours, Some(("clusterlod", &theirs)), "", Goal::RatioAtMost(1.0));
    Ok(())
}

/// Returns the triangles that meshoptimizer's hierarchy of the bind pose draws at an error.
fn bind_pose_cut(model: &CrowdModel, input: &[[u32; 3]], error: f32) -> Vec<[u32; 3]> {
    // It takes vertices at one place as one.
    let welded = relievo_lod::weld(&model.character.points, input);
    let mut first = vec![0; welded.points.len()];
    for (vertex, number) in welded.numbers.iter().enumerate().rev() {
        first[*number as usize] = vertex as u32;
    }
    let bytes = meshopt::typed_to_bytes(&welded.points);
    let Ok(vertices) = meshopt::VertexDataAdapter::new(bytes, size_of::<[f32; 3]>(), 0) else { return Vec::new() };
    let mesh = ClodMesh::new(welded.triangles.as_flattened(), &vertices);
    let (mut errors, mut clusters) = (Vec::new(), Vec::new());
    clod_build(clod_default_config(100), &mesh, |group, made| {
        errors.push(group.simplified.error);
        clusters.extend(made.iter().map(|cluster| (errors.len() - 1, cluster.refined, cluster.indices.to_vec())));
        errors.len() as i32 - 1
    });
    let is_coarse = |group: usize| errors[group] <= error;
    let drawn = clusters
        .iter()
        .filter(|(group, refined, _)| !is_coarse(*group) && usize::try_from(*refined).map_or(true, is_coarse));
    let corners = |triangle: &[u32; 3]| triangle.map(|corner| first[corner as usize]);
    drawn.flat_map(|(_, _, indices)| indices.as_chunks::<3>().0).map(corners).collect()
}

/// Divides all triangles of a model into four, some times, and adds waves, so that no level is without error.
fn refined(source: &Model, times: u32) -> Model {
    let mut model = source.clone();
    for part in &mut model.meshes {
        let extent = part.mesh.bounds().map_or(1.0, |(low, high)| Vec3::from(high).distance(low.into()));
        for _ in 0..times {
            part.mesh = divided(&part.mesh);
        }
        part.targets.clear();
        part.weights.clear();
        for point in &mut part.mesh.points {
            let place = Vec3::from(*point) / extent;
            let wave =
                |k: f32| Vec3::new((k * place.y).sin(), (k * place.z + 1.0).sin(), (k * place.x + 2.0).sin()) / k;
            *point = (Vec3::from(*point) + 0.04 * extent * (wave(23.0) + wave(61.0) + wave(149.0))).to_array();
        }
    }
    model
}

/// Joins the vertices of a mesh at one point with the same bones and weights.
fn joined(mesh: &Mesh) -> Mesh {
    let values = |name: &str| mesh.attribute(name).map(|attribute| &attribute.values);
    let (Some(Values::U32(joints)), Some(Values::F32(weights))) = (values("joints"), values("weights")) else {
        return mesh.clone();
    };
    let (joints, weights) = (joints.as_chunks::<4>().0, weights.as_chunks::<4>().0);
    let (mut known, mut firsts) = (HashMap::new(), Vec::new());
    let numbers: Vec<u32> = (0..mesh.points.len())
        .map(|at| {
            let key = (mesh.points[at].map(f32::to_bits), joints[at], weights[at].map(f32::to_bits));
            *known.entry(key).or_insert_with(|| {
                firsts.push(at);
                firsts.len() as u32 - 1
            })
        })
        .collect();
    let triangles: Vec<[u32; 3]> =
        mesh.triangles().iter().map(|triangle| triangle.map(|corner| numbers[corner as usize])).collect();
    let mut made = Mesh::from_triangles(firsts.iter().map(|at| mesh.points[*at]).collect(), &triangles);
    let joints = Values::U32(firsts.iter().flat_map(|at| joints[*at]).collect());
    let weights = Values::F32(firsts.iter().flat_map(|at| weights[*at]).collect());
    for (name, values) in [("joints", joints), ("weights", weights)] {
        let source = mesh.attribute(name).cloned();
        made.attributes.extend(source.map(|attribute| Attribute { values, ..attribute }));
    }
    made
}

/// Divides all triangles of a mesh into four.
fn divided(mesh: &Mesh) -> Mesh {
    let mut middles: HashMap<(u32, u32), u32> = HashMap::new();
    let mut ends: Vec<(u32, u32)> = Vec::new();
    let count = mesh.points.len() as u32;
    let mut middle = |a: u32, b: u32| {
        *middles.entry((a.min(b), a.max(b))).or_insert_with(|| {
            ends.push((a.min(b), a.max(b)));
            count + ends.len() as u32 - 1
        })
    };
    let mut triangles = Vec::new();
    for [a, b, c] in mesh.triangles() {
        let [ab, bc, ca] = [middle(a, b), middle(b, c), middle(c, a)];
        triangles.extend([[a, ab, ca], [ab, b, bc], [ca, bc, c], [ab, bc, ca]]);
    }
    let mut points = mesh.points.clone();
    points.extend(ends.iter().map(|(a, b)| {
        let (a, b) = (Vec3::from(mesh.points[*a as usize]), Vec3::from(mesh.points[*b as usize]));
        (0.5 * (a + b)).to_array()
    }));
    let mut made = Mesh::from_triangles(points, &triangles);
    made.attributes =
        mesh.attributes.iter().filter(|it| it.name != "joints" && it.name != "material").cloned().collect();
    for attribute in &mut made.attributes {
        let width = attribute.width as usize;
        if let Values::F32(values) = &mut attribute.values {
            let mean = |(a, b): &(u32, u32), at: usize| {
                0.5 * (values[*a as usize * width + at] + values[*b as usize * width + at])
            };
            let more: Vec<f32> = ends.iter().flat_map(|end| (0..width).map(move |at| mean(end, at))).collect();
            values.extend(more);
        }
    }
    blend_influences(mesh, &mut made, &ends);
    made
}

/// Gives the middles of edges the four strongest of the bones of both ends.
fn blend_influences(mesh: &Mesh, made: &mut Mesh, ends: &[(u32, u32)]) {
    let values = |name: &str| mesh.attribute(name).map(|attribute| &attribute.values);
    let (Some(Values::U32(joints)), Some(Values::F32(weights))) = (values("joints"), values("weights")) else { return };
    let (mut all_joints, mut all_weights) = (joints.clone(), weights.clone());
    for (a, b) in ends {
        let mut sums: Vec<(u32, f32)> = Vec::new();
        for vertex in [*a as usize, *b as usize] {
            for at in 4 * vertex..4 * vertex + 4 {
                match sums.iter_mut().find(|known| known.0 == joints[at]) {
                    Some(known) => known.1 += weights[at],
                    None => sums.push((joints[at], weights[at])),
                }
            }
        }
        sums.sort_by(|a, b| b.1.total_cmp(&a.1));
        sums.resize(4, (0, 0.0));
        let total: f32 = sums.iter().map(|sum| sum.1).sum();
        all_joints.extend(sums.iter().map(|sum| sum.0));
        all_weights.extend(sums.iter().map(|sum| sum.1 / total));
    }
    for attribute in &mut made.attributes {
        if attribute.name == "weights" {
            attribute.values = Values::F32(all_weights.clone());
        }
    }
    let joints = mesh.attribute("joints").cloned();
    made.attributes.extend(joints.map(|attribute| Attribute { values: Values::U32(all_joints), ..attribute }));
}
