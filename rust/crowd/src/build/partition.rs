//! Clusters of triangles: neighbours with similar deformation levels, cut into pieces by spatial median (Section 4.2).

use std::collections::HashMap;

use crate::build::places::Places;
use crate::character::Character;

/// Relative difference of deformation levels within which neighbours are similar.
const SIMILAR: f32 = 0.1;
/// Share of the model's size below which a difference of levels does not count.
const NEGLIGIBLE: f32 = 1e-3;
/// Share of a full cluster below which a region is joined to a neighbour.
const SMALL: f32 = 0.5;

/// Cuts the triangles of a character into clusters of at most `most` triangles. Each is a list of triangles.
pub(crate) fn leaves(character: &Character, places: &Places, levels: &[f32], size: f32, most: usize) -> Vec<Vec<u32>> {
    let place = |vertex: u32| places.of[vertex as usize] as usize;
    let mut of_place = vec![0.0f32; places.len()];
    for (vertex, level) in levels.iter().enumerate() {
        let known = &mut of_place[places.of[vertex] as usize];
        *known = known.max(*level);
    }
    // Regions of places, then of triangles, which belong to the region of their most deformed corner.
    let mut regions = Regions::new(places.len());
    for triangle in &character.triangles {
        for (from, to) in [(0, 1), (1, 2), (2, 0)] {
            let (a, b) = (place(triangle[from]), place(triangle[to]));
            let (one, other) = (of_place[a], of_place[b]);
            if (one - other).abs() <= (SIMILAR * one.max(other)).max(NEGLIGIBLE * size) {
                regions.join(a, b);
            }
        }
    }
    let region_of = |regions: &mut Regions, triangle: &[u32; 3]| {
        let corners = triangle.map(place);
        let deformed =
            corners.into_iter().fold(corners[0], |most, it| if of_place[it] > of_place[most] { it } else { most });
        regions.root(deformed)
    };
    let owners: Vec<usize> = character.triangles.iter().map(|triangle| region_of(&mut regions, triangle)).collect();
    let owners = absorbed(character, places, owners, &of_place, (SMALL * most as f32) as usize);
    let mut lists: HashMap<usize, usize> = HashMap::new();
    let mut pieces: Vec<Vec<u32>> = Vec::new();
    for (triangle, owner) in owners.iter().enumerate() {
        let list = *lists.entry(*owner).or_insert_with(|| {
            pieces.push(Vec::new());
            pieces.len() - 1
        });
        pieces[list].push(triangle as u32);
    }
    let center = |triangle: u32| center(character, character.triangles[triangle as usize]);
    pieces.into_iter().flat_map(|piece| cut(piece, most, &center)).collect()
}

/// Joins regions of fewer than `few` triangles to the neighbour of the nearest level until none is left that has a neighbour.
fn absorbed(
    character: &Character,
    places: &Places,
    mut owners: Vec<usize>,
    of_place: &[f32],
    few: usize,
) -> Vec<usize> {
    let mut neighbours: HashMap<(u32, u32), Vec<u32>> = HashMap::new();
    for (index, triangle) in character.triangles.iter().enumerate() {
        for (from, to) in [(0, 1), (1, 2), (2, 0)] {
            let (a, b) = (places.of[triangle[from] as usize], places.of[triangle[to] as usize]);
            neighbours.entry((a.min(b), a.max(b))).or_default().push(index as u32);
        }
    }
    let mut pairs: Vec<(u32, u32)> = neighbours
        .into_values()
        .flat_map(|list| list.windows(2).map(|pair| (pair[0], pair[1])).collect::<Vec<_>>())
        .collect();
    pairs.sort_unstable();
    loop {
        let mut counts: HashMap<usize, (usize, f32)> = HashMap::new();
        for (triangle, owner) in character.triangles.iter().zip(&owners) {
            let level =
                triangle.iter().fold(0.0, |most: f32, vertex| most.max(of_place[places.of[*vertex as usize] as usize]));
            let known = counts.entry(*owner).or_insert((0, 0.0));
            *known = (known.0 + 1, known.1.max(level));
        }
        // The best neighbour of each small region; ties go to the lower number.
        let mut best: HashMap<usize, (f32, usize)> = HashMap::new();
        for (one, other) in &pairs {
            let (one, other) = (owners[*one as usize], owners[*other as usize]);
            if one == other {
                continue;
            }
            for (from, to) in [(one, other), (other, one)] {
                if counts[&from].0 >= few {
                    continue;
                }
                let difference = (counts[&from].1 - counts[&to].1).abs();
                let known = best.entry(from).or_insert((f32::INFINITY, usize::MAX));
                if (difference, to) < *known {
                    *known = (difference, to);
                }
            }
        }
        if best.is_empty() {
            return owners;
        }
        let mut joined = Regions::new(owners.iter().max().map_or(0, |most| most + 1));
        let mut order: Vec<_> = best.into_iter().collect();
        order.sort_unstable_by_key(|(from, _)| *from);
        order.into_iter().for_each(|(from, (_, to))| joined.join(from, to));
        owners.iter_mut().for_each(|owner| *owner = joined.root(*owner));
    }
}

/// Returns the middle of a triangle at binding, times 3.
pub(crate) fn center(character: &Character, triangle: [u32; 3]) -> [f32; 3] {
    let points = triangle.map(|vertex| character.points[vertex as usize]);
    std::array::from_fn(|axis| points[0][axis] + points[1][axis] + points[2][axis])
}

/// Cuts a list into the fewest parts of at most `most` items that are about equally long, along the longest side of the
/// box of the items each time.
pub(crate) fn cut(list: Vec<u32>, most: usize, center: &impl Fn(u32) -> [f32; 3]) -> Vec<Vec<u32>> {
    let (mut done, mut open) = (Vec::new(), vec![list]);
    while let Some(mut list) = open.pop() {
        let parts = list.len().div_ceil(most.max(1));
        if parts <= 1 {
            if !list.is_empty() {
                list.sort_unstable();
                done.push(list);
            }
            continue;
        }
        let extent = |axis: usize| {
            let values = list.iter().map(|item| center(*item)[axis]);
            let (low, high) =
                values.fold((f32::INFINITY, f32::NEG_INFINITY), |(low, high), value| (low.min(value), high.max(value)));
            high - low
        };
        let extents = [extent(0), extent(1), extent(2)];
        let axis = (0..3).fold(0, |most, axis| if extents[axis] > extents[most] { axis } else { most });
        let at = list.len() * (parts / 2) / parts;
        let order = |a: &u32, b: &u32| center(*a)[axis].total_cmp(&center(*b)[axis]).then(a.cmp(b));
        list.select_nth_unstable_by(at, order);
        let high = list.split_off(at);
        open.extend([high, list]);
    }
    done
}

/// Disjoint sets.
pub(crate) struct Regions(Vec<usize>);

impl Regions {
    pub fn new(count: usize) -> Self {
        Self((0..count).collect())
    }

    pub fn root(&mut self, mut at: usize) -> usize {
        while self.0[at] != at {
            self.0[at] = self.0[self.0[at]];
            at = self.0[at];
        }
        at
    }

    /// Joins two sets; the lower number stands for both.
    pub fn join(&mut self, one: usize, other: usize) {
        let (a, b) = (self.root(one), self.root(other));
        self.0[a.max(b)] = a.min(b);
    }
}
