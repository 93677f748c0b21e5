//! Hierarchies beside others of the same character, by distances that are measured in all poses.

use glam::{BVec3, Vec3};
use meshopt::clusterlod::{ClodMesh, clod_build, clod_default_config};
use relievo_core::progress::Silent;
use relievo_core::{Context, Result};
use relievo_crowd::{Blend, BuildSettings, Character, CrowdModel, Variant, skin};
use relievo_lod::{PosedDistance, distance};
use relievo_meshio::Model;

use super::WALK;
use super::refine::refined;
use crate::deviation::Deviation;
use crate::measure::Sample;
use crate::report::{Goal, Report};

/// How often the triangles of the person are divided into four beside clusterlod, and for root mean squares.
const DIVIDED: u32 = 2;
/// The same beside clusters by an octree: there have to be levels of many clusters.
const CLUSTERED: u32 = 4;
/// Poses that largest distances are compared in.
const POSES: f32 = 12.0;
/// Errors that clusterlod is asked for, as shares of the model's diagonal. The first is half a pixel where the diagonal has
/// a thousand.
const SHARES: [f32; 4] = [0.0005, 0.003, 0.01, 0.03];
/// Distances at which clusters are compared: half a pixel where the diagonal has 1,000, 500 and 167.
const DISTANCES: [f32; 3] = [0.0005, 0.001, 0.003];
/// Distance of poses within which they count as alike, for a hierarchy that is simplified over all of them.
const EVERY_POSE: f32 = 0.001;
/// A ratio below 1: strictly fewer.
const FEWER: f64 = 0.999;

/// Positions of all vertices in some poses.
type Poses = Vec<Vec<[f32; 3]>>;

/// Compares a character that plays a clip; `rate` gives the settings for a number of poses.
pub fn run(
    report: &mut Report,
    context: &Context,
    (bare, clip): (&Model, usize),
    rate: &dyn Fn(f32) -> BuildSettings,
) -> Result<()> {
    clusters(report, context, (&refined(bare, CLUSTERED), clip), &rate(POSES))?;
    let source = refined(bare, DIVIDED);
    let model = CrowdModel::build(context, &source, &[clip], &rate(POSES), &mut Silent)?;
    SHARES.into_iter().try_for_each(|share| bind_pose(report, context, &model, share))?;
    all_poses(report, context, (&source, clip), &BuildSettings { pose_distance: WALK.1, ..rate(WALK.0) })
}

/// Returns the positions of all vertices in the poses of the first clip.
fn posed(context: &Context, model: &CrowdModel) -> Result<Poses> {
    model.clips[0].poses.iter().map(|pose| skin(context, &model.character, pose, Blend::Linear)).collect()
}

/// Returns the triangles of clusters.
fn triangles(model: &CrowdModel, clusters: &[u32]) -> Vec<[u32; 3]> {
    clusters.iter().flat_map(|cluster| model.triangles(*cluster)).copied().collect()
}

/// Returns how many triangles the coarsest cut has whose measured distance from the input is at most `allowed` in all poses given.
fn fewest(context: &Context, model: &CrowdModel, poses: &[Vec<[f32; 3]>], allowed: f32) -> Result<usize> {
    let Some((first, others)) = poses.split_first() else { return Ok(0) };
    let input = triangles(model, &model.input_clusters());
    let mut errors: Vec<f32> = model.groups.iter().map(|group| group.error).collect();
    errors.sort_unstable_by(f32::total_cmp);
    let is_within = |error: f32| -> Result<bool> {
        let cut = triangles(model, &model.cut(error));
        let (mut posed, found) = PosedDistance::new(context, first, [&input, &cut], 0.0)?;
        Ok(found <= allowed && posed.largest(context, others, allowed)? <= allowed)
    };
    // Errors of cuts bound distances, so the coarsest cut within a distance is beyond its own error.
    let (mut low, mut high) = (errors.partition_point(|error| *error <= allowed), errors.len());
    while low < high {
        let middle = (low + high) / 2;
        if is_within(errors[middle])? { low = middle + 1 } else { high = middle }
    }
    Ok(if low == 0 { input.len() } else { model.triangle_count(&model.cut(errors[low - 1])) as usize })
}

/// Compares with clusters by an octree of the pose at binding. Both are joined and simplified in groups to the end, since a
/// surface that becomes one group is the same whatever its clusters were.
fn clusters(
    report: &mut Report,
    context: &Context,
    (source, clip): (&Model, usize),
    settings: &BuildSettings,
) -> Result<()> {
    let cells = octree(&Character::from_model(context, source)?, settings.cluster_triangles as usize);
    let build = |clusters: Option<&[Vec<u32>]>| {
        let variant = Variant { clusters, is_whole: false };
        CrowdModel::build_variant(context, (source, &[clip]), &variant, settings, &mut Silent)
    };
    let (model, peer) = (build(None)?, build(Some(&cells))?);
    let poses = posed(context, &model)?;
    for share in DISTANCES {
        let count = |model: &CrowdModel| -> Result<Sample> {
            let found = fewest(context, model, &poses, share * model.size())?;
            Ok(Sample::new(vec![found as f64]))
        };
        let case = format!(
            "triangles of {} within {:.2} % in all {} poses, groups to the end",
            model.input_triangles,
            100.0 * share,
            poses.len()
        );
        // The paper draws 50 % fewer.
        report.add(&case, &count(&model)?, Some(("octree", &count(&peer)?)), "", Goal::RatioAtMost(0.67));
    }
    Ok(())
}

/// Compares the triangles of cuts with those of the hierarchy of the bind pose that are as near to the input, in each pose by
/// itself. Reports the pose in which the ratio is worst.
fn bind_pose(report: &mut Report, context: &Context, model: &CrowdModel, share: f32) -> Result<()> {
    let input = triangles(model, &model.input_clusters());
    let peer = bind_pose_cut(model, &input, share * model.size());
    let poses = posed(context, model)?;
    let (mut worst, mut farthest) = (0, 0.0f32);
    for points in &poses {
        let allowed = distance(context, [(points, &input), (points, &peer)], &mut Silent)?.at_most;
        worst = worst.max(fewest(context, model, std::slice::from_ref(points), allowed)?);
        farthest = farthest.max(allowed);
    }
    let case = format!(
        "triangles as near as clusterlod's at {:.2} %, up to {:.2} %, in the worst of {} poses",
        100.0 * share,
        100.0 * farthest / model.size(),
        poses.len()
    );
    let [ours, theirs] = [worst, peer.len()].map(|count| Sample::new(vec![count as f64]));
    report.add(&case, &ours, Some(("clusterlod", &theirs)), "", Goal::RatioAtMost(FEWER));
    Ok(())
}

/// Compares the distance of cuts from the input, root mean square over all poses, with that of a hierarchy simplified over all
/// poses, for as many triangles as there are.
fn all_poses(
    report: &mut Report,
    context: &Context,
    (source, clip): (&Model, usize),
    settings: &BuildSettings,
) -> Result<()> {
    let build = |settings: &BuildSettings| CrowdModel::build(context, source, &[clip], settings, &mut Silent);
    let (model, peer) = (build(settings)?, build(&BuildSettings { pose_distance: EVERY_POSE, ..*settings })?);
    let input = triangles(&model, &model.input_clusters());
    let poses = posed(context, &model)?;
    let mean = |model: &CrowdModel, cut: &[u32]| -> Result<f64> {
        let triangles = triangles(model, cut);
        let of = |points: &Vec<[f32; 3]>| {
            Deviation::between(context, &(points.clone(), input.clone()), &(points.clone(), triangles.clone()))
        };
        let squares = poses.iter().map(|points| Ok(of(points)?.mean.powi(2))).collect::<Result<Vec<f64>>>()?;
        Ok((squares.iter().sum::<f64>() / squares.len() as f64).sqrt())
    };
    for share in [SHARES[1], SHARES[2]] {
        let cut = model.cut(share * model.size());
        let count = model.triangle_count(&cut);
        let cuts = peer.groups.iter().map(|group| peer.cut(group.error));
        let nearest = cuts.min_by_key(|cut| peer.triangle_count(cut).abs_diff(count)).unwrap_or_default();
        let [ours, theirs] = [mean(&model, &cut)?, mean(&peer, &nearest)?].map(|mean| Sample::new(vec![mean]));
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
