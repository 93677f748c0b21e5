//! How coarser levels follow what was edited (Derzapf, Grund, Guthe 2014, Section 4.2).
//!
//! Where a split has a vertex that has moved, or one around, it is as if it was taken back: its one vertex goes where the
//! quadrics of the triangles as they are now want it, and where the two would have had to be built is noted, so that to
//! split the vertex again puts them where they are. That vertex has moved then, and so on to the base. The mesh itself
//! stays as it is: what is around a split is known, so the work is of as many splits as have something near that moved.

use std::sync::atomic::{AtomicU32, Ordering::Relaxed};

use glam::{Vec3, Vec4Swizzles};
use relievo_core::Context;

use super::active::{ActiveMesh, Waiting};
use super::hierarchy::{Child, Progressive};
use super::moves::Moves;
use super::place::{Place, Surroundings};
use super::stars::{Star, depth};
use crate::connectivity::NONE;
use crate::decimation::normal;
use crate::placement::{self, BATCH, Batch, place};

/// Splits of one task.
const PART: usize = 4 * BATCH;

/// What an edit has replaced.
#[derive(Default)]
pub struct Replaced {
    pub places: Vec<(u32, Option<Place>)>,
    pub built: Vec<(u32, Option<[Place; 2]>)>,
}

impl Moves {
    /// Puts vertices of a mesh, told by their nodes, where they are from now on, and what is coarser where it belongs then.
    pub fn edit(&mut self, context: &Context, mesh: &ActiveMesh, reached: &[(u32, Place)]) -> Replaced {
        self.stars.complete(context, mesh);
        let mut replaced = Replaced::default();
        let mut set = |moves: &mut Self, node, place| {
            replaced.places.push((node, moves.places.set(node, Some(place))));
        };
        reached.iter().for_each(|(vertex, place)| set(self, mesh.node(*vertex), *place));
        let claimed = Claimed::new(mesh.whole.vertex_count());
        let mut waiting = Waiting::default();
        let found = context.map(reached.len().div_ceil(PART), |part| {
            let mut found = Vec::new();
            for (vertex, _) in &reached[part * PART..reached.len().min((part + 1) * PART)] {
                let around = mesh.spokes(*vertex).flatten().map(|vertex| mesh.node(vertex));
                claimed.claim(&mesh.whole, mesh.node(*vertex), around, &mut found);
            }
            found
        });
        found.into_iter().flatten().for_each(|(depth, split)| waiting.add(depth, split));
        let mut depth = 0;
        while depth < waiting.0.len() {
            let mut splits = std::mem::take(&mut waiting.0[depth]);
            splits.sort_unstable();
            let moves = &*self;
            let merged = context.map(splits.len().div_ceil(PART), |part| {
                let splits = &splits[part * PART..splits.len().min((part + 1) * PART)];
                let mut merging = Merging { context, whole: &mesh.whole, moves, claimed: &claimed, found: Vec::new() };
                let merged: Vec<Merged> = splits.chunks(BATCH).flat_map(|splits| merging.merge(splits)).collect();
                (merged, merging.found)
            });
            for (merged, found) in merged {
                for Merged { split, place, built } in merged {
                    let node = mesh.whole.parent(split);
                    replaced.places.push((node, self.places.set(node, Some(place))));
                    replaced.built.push((split, self.built.set(split, Some(built))));
                }
                found.into_iter().for_each(|(depth, split)| waiting.add(depth, split));
            }
            depth += 1;
        }
        replaced
    }
}

/// The splits that have something near that moved.
struct Claimed(Vec<AtomicU32>);

impl Claimed {
    fn new(splits: usize) -> Self {
        Self((0..splits.div_ceil(32)).map(|_| AtomicU32::new(0)).collect())
    }

    /// Finds the splits that have a node near that has moved, which is beside the nodes `around`. Tells their depths.
    fn claim(&self, whole: &Progressive, moved: u32, around: impl Iterator<Item = u32>, found: &mut Vec<(u32, u32)>) {
        let own = depth(whole, moved);
        let mut claim = |node: u32| {
            let split = node / 2;
            let bit = 1 << (split % 32);
            if self.0[split as usize / 32].fetch_or(bit, Relaxed) & bit == 0 {
                found.push((depth(whole, node), split));
            }
        };
        if own != NONE {
            claim(moved);
        }
        for mut node in around {
            // It goes while the one that has moved is still there, and so do those it becomes.
            while depth(whole, node) < own {
                claim(node);
                node = whole.parent(node / 2);
            }
        }
    }
}

/// A split as if it was taken back.
struct Merged {
    split: u32,
    /// Of its one vertex.
    place: Place,
    /// Where its two vertices would have been built.
    built: [Place; 2],
}

/// What is needed to merge splits of a depth.
struct Merging<'a> {
    context: &'a Context,
    whole: &'a Progressive,
    moves: &'a Moves,
    claimed: &'a Claimed,
    found: Vec<(u32, u32)>,
}

impl Merging<'_> {
    /// The splits of a batch.
    fn merge(&mut self, splits: &[u32]) -> Vec<Merged> {
        let mut batch = Batch::default();
        let scale = self.whole.scale();
        let sites: Vec<Site> = splits.iter().map(|split| Site::new(self.whole, self.moves, *split)).collect();
        sites.iter().enumerate().for_each(|(lane, site)| site.gather(scale, &mut batch, lane));
        place(self.context.level(), &mut batch);
        let merged = sites.iter().enumerate().map(|(lane, site)| {
            let around = site.star.ring.iter().copied();
            self.claimed.claim(self.whole, self.whole.parent(site.split), around, &mut self.found);
            site.merged(scale, &batch, lane)
        });
        merged.collect()
    }
}

/// A split with what is around it, as built and as it is now.
struct Site<'a> {
    split: u32,
    star: Star<'a>,
    /// Of the ring, then of the two vertices.
    places: Vec<[Place; 2]>,
    /// Where the one vertex was built.
    built: Place,
}

impl<'a> Site<'a> {
    fn new(whole: &Progressive, moves: &'a Moves, split: u32) -> Self {
        let star = moves.stars.star(split);
        let place = |node: u32| {
            let built = whole.node_place(node);
            [built, moves.place(node).unwrap_or(built)]
        };
        let nodes = star.ring.iter().copied().chain([2 * split, 2 * split + 1]);
        Self { split, star, places: nodes.map(place).collect(), built: whole.place(Child::Split(split), NONE) }
    }

    fn now(&self, number: usize) -> Vec3 {
        self.places[number][1].point
    }

    /// The normal of a triangle at a vertex, as simplification weighs it.
    fn normal(&self, scale: f32, here: Vec3, [after, before]: [usize; 2]) -> Vec3 {
        normal((self.now(after) - here) * scale, (self.now(before) - here) * scale).xyz()
    }

    /// What a vertex of the split knows of its triangles and borders.
    fn star(&self, scale: f32, side: usize) -> placement::Star {
        let here = self.now(self.star.end(side));
        let mut star = [0.0; 9];
        let mut add = |normal: Vec3, share: f32| {
            let [x, y, z] = normal.to_array();
            for (entry, value) in star.iter_mut().zip([x * x, y * y, z * z, x * y, x * z, y * z]) {
                *entry += share * value;
            }
        };
        let mut sum = Vec3::ZERO;
        let mut around = Vec::new();
        for ends in self.star.spokes(side) {
            let normal = self.normal(scale, here, ends);
            add(normal, 1.0);
            sum += normal;
            around.extend(ends);
        }
        around.sort_unstable();
        for run in around.chunk_by(|a, b| a == b).filter(|run| run.len() == 1) {
            let along = (self.now(run[0]) - here) * scale;
            let length = along.length();
            [Vec3::X, Vec3::Y, Vec3::Z].into_iter().for_each(|axis| add(axis * length, 1.0));
            add(along, -1.0);
        }
        star[6..].copy_from_slice(&sum.to_array());
        star
    }

    /// Puts the edge between the vertices of the split into a batch.
    fn gather(&self, scale: f32, batch: &mut Batch, lane: usize) {
        for side in 0..2 {
            for (entries, value) in batch.star[side].iter_mut().zip(self.star(scale, side)) {
                entries[lane] = value;
            }
        }
        let numbers = [self.star.end(0), self.star.end(1)];
        let [start, end] = numbers.map(|end| self.now(end));
        let mut sides = [Vec3::ZERO; 2];
        let mut count = 0;
        for spoke in self.star.spokes(0).filter(|spoke| spoke.contains(&numbers[1])) {
            if let Some(side) = sides.get_mut(count) {
                *side = self.normal(scale, start, spoke);
                count += 1;
            }
        }
        let edge = (end - start) * scale;
        for axis in 0..3 {
            batch.edge[axis][lane] = edge[axis];
            batch.side[0][axis][lane] = sides[0][axis];
            batch.side[1][axis][lane] = sides[1][axis];
        }
        // A vertex that stayed when the mesh was built still does.
        let [stays, goes] = numbers.map(|end| self.places[end][0].point == self.built.point);
        batch.pinned[lane] = if stays { -1.0 } else { f32::from(u8::from(goes)) };
        batch.open[lane] = f32::from(u8::from(count == 1));
        batch.before[lane] = 0.0;
    }

    /// The split as if it was taken back.
    fn merged(&self, scale: f32, batch: &Batch, lane: usize) -> Merged {
        let ends = [self.star.end(0), self.star.end(1)];
        let [start, end] = ends.map(|end| self.now(end));
        let offset = Vec3::from(batch.place.map(|axis| axis[lane])) / scale;
        let point = match batch.pinned[lane] {
            pinned if pinned < 0.0 => start,
            pinned if pinned > 0.0 => end,
            _ => 0.5 * (start + end) + offset,
        };
        let outer = |side: usize| self.star.spokes(side).filter(move |spoke| !spoke.contains(&ends[1 - side]));
        let sum: Vec3 = (0..2).flat_map(outer).map(|spoke| self.normal(scale, point, spoke)).sum();
        let place = Place { point, normal: sum.try_normalize().unwrap_or(self.built.normal) };
        let built = [0, 1].map(|side| {
            let around = Surroundings::new([self.built, place], &self.places[self.star.beside(side)]);
            around.back(self.places[ends[side]][1])
        });
        Merged { split: self.split, place, built }
    }
}
