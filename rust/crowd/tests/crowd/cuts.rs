//! Cuts have no cracks, and the finest is the input.

use std::collections::HashMap;

use relievo_core::Context;
use relievo_crowd::{Character, CrowdModel, NONE};
use relievo_testing::Random;

use crate::arm::{arm, built, walking};

/// Returns the points of vertices that are at one place with the same bones as numbers.
pub fn places(character: &Character) -> Vec<u32> {
    let mut known = HashMap::new();
    let keys = character.points.iter().zip(&character.influences).map(|(point, influence)| {
        (point.map(|value| (value + 0.0).to_bits()), influence.bones, influence.weights.map(f32::to_bits))
    });
    keys.map(|key| {
        let next = known.len() as u32;
        *known.entry(key).or_insert(next)
    })
    .collect()
}

/// Returns how often every directed edge of places is there, less than its reverse: all 0 in a closed surface.
pub fn borders<'a>(places: &[u32], triangles: impl Iterator<Item = &'a [u32; 3]>) -> HashMap<(u32, u32), i32> {
    let mut counts = HashMap::new();
    for triangle in triangles {
        let [a, b, c] = triangle.map(|vertex| places[vertex as usize]);
        for (from, to) in [(a, b), (b, c), (c, a)].into_iter().filter(|(from, to)| from != to) {
            *counts.entry((from.min(to), from.max(to))).or_insert(0) += if from < to { 1 } else { -1 };
        }
    }
    counts.retain(|_, count| *count != 0);
    counts
}

/// Returns groups that are coarse: each with some chance, if all below it are.
fn random_coarse(model: &CrowdModel, random: &mut Random, chance: f32) -> Vec<bool> {
    let mut coarse = vec![false; model.groups.len()];
    for group in 0..model.groups.len() {
        let mut below = model.clusters.iter().filter(|cluster| cluster.used_by == group as u32);
        let may = below.all(|cluster| cluster.made_by == NONE || coarse[cluster.made_by as usize]);
        coarse[group] = may && random.unit() < chance;
    }
    coarse
}

fn drawn<'a>(model: &'a CrowdModel, coarse: &[bool]) -> impl Iterator<Item = &'a [u32; 3]> {
    let clusters = model.drawn(coarse);
    clusters.into_iter().flat_map(|cluster| model.triangles(cluster))
}

#[test]
fn random_cuts_of_a_closed_surface_are_closed() {
    let model = built(60, 24);
    let places = places(&model.character);
    assert!(borders(&places, drawn(&model, &vec![false; model.groups.len()])).is_empty());
    let mut random = Random(7);
    let mut sizes = Vec::new();
    for round in 0..200 {
        let coarse = random_coarse(&model, &mut random, 0.5 + 0.0025 * round as f32);
        let open = borders(&places, drawn(&model, &coarse));
        assert!(open.is_empty(), "round {round}: {open:?}");
        sizes.push(drawn(&model, &coarse).count());
    }
    // The cuts differ, and reach far down.
    sizes.sort_unstable();
    assert!(sizes[0] * 8 < sizes[199], "{} to {}", sizes[0], sizes[199]);
}

#[test]
fn random_cuts_of_characters_open_only_at_borders_of_the_input() {
    for (name, clip) in [("robot", "Robot_Walking"), ("girl", "RunTrack")] {
        let Some((_, model)) = walking(name, clip) else { return };
        let places = places(&model.character);
        let input = borders(&places, drawn(&model, &vec![false; model.groups.len()]));
        let is_border = |place: u32| input.keys().any(|(a, b)| *a == place || *b == place);
        let mut random = Random(3);
        for round in 0..50 {
            let coarse = random_coarse(&model, &mut random, 0.5 + 0.01 * round as f32);
            let open = borders(&places, drawn(&model, &coarse));
            let cracks: Vec<_> = open.iter().filter(|((a, b), _)| !is_border(*a) || !is_border(*b)).collect();
            assert!(cracks.is_empty(), "{name}, round {round}: {cracks:?}");
        }
    }
}

#[test]
fn the_finest_cut_is_the_input_to_the_bit() {
    let sorted = |triangles: Vec<[u32; 3]>, materials: Vec<u32>| {
        let mut pairs: Vec<_> = triangles.into_iter().zip(materials).collect();
        pairs.sort_unstable();
        pairs
    };
    let check = |source: &relievo_meshio::Model, model: &CrowdModel| {
        let input = Character::from_model(&Context::serial(), source).unwrap();
        let bits = |points: &[[f32; 3]]| points.iter().flatten().map(|value| value.to_bits()).collect::<Vec<_>>();
        assert_eq!(bits(&model.character.points), bits(&input.points));
        assert_eq!(model.character.influences, input.influences);
        assert_eq!(model.character.attributes, input.attributes);
        let count = model.input_triangles as usize;
        let clusters = model.input_clusters();
        assert_eq!(model.triangle_count(&clusters), count as u64);
        let finest = model.character.triangles[..count].to_vec();
        assert_eq!(
            sorted(finest, model.character.materials[..count].to_vec()),
            sorted(input.triangles, input.materials)
        );
    };
    check(&arm(30, 16), &built(30, 16));
    for (name, clip) in [("robot", "Robot_Walking"), ("greenman", "2_move")] {
        let Some((source, model)) = walking(name, clip) else { return };
        check(&source, &model);
    }
}

#[test]
fn coarser_cuts_have_fewer_triangles_and_keep_texture_coordinates_apart() {
    let model = built(60, 24);
    let mut before = u64::MAX;
    for step in 0..16 {
        let cut = model.cut(1e-4 * 2f32.powi(step));
        let count = model.triangle_count(&cut);
        assert!(count <= before);
        before = count;
        // A triangle that mixed both sides of the seam would span the whole image.
        let uv = model.character.values("uv").unwrap();
        for triangle in cut.iter().flat_map(|cluster| model.triangles(*cluster)) {
            let u = triangle.map(|vertex| uv[2 * vertex as usize]);
            let is_cap =
                triangle.iter().any(|vertex| u32::from(*vertex as usize >= model.character.points.len() - 2) == 1);
            let span = u.iter().fold(0.0f32, |most, u| most.max(*u)) - u.iter().fold(1.0f32, |least, u| least.min(*u));
            assert!(is_cap || span < 0.75 || count < 300, "{u:?}");
        }
    }
    assert!(before * 50 < u64::from(model.input_triangles), "{before}");
}
