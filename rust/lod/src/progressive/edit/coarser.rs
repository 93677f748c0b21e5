//! How coarser levels follow what was edited (Derzapf, Grund, Guthe 2014, Section 4.2).
//!
//! Where a split has a vertex that has moved, or one around, it is as if it was taken back: its one vertex goes where the
//! quadrics of the triangles as they are now want it, and where the two would have had to be built is noted, so that to
//! split the vertex again puts them where they are. That vertex has moved then, and so on to the base. The mesh itself
//! stays as it is: what is around a split is known, so the work is of as many splits as have something near that moved.

use std::sync::atomic::{AtomicU32, Ordering::Relaxed};

use glam::{Vec3, Vec3A};
use relievo_core::Context;

use super::moves::Moves;
use super::place::{Place, Surroundings};
use super::stars::{Star, depth};
use crate::connectivity::NONE;
use crate::progressive::build::hierarchy::{Child, Progressive};
use crate::progressive::mesh::active::{ActiveMesh, Waiting};
use crate::simplify::decimation::normal;
use crate::simplify::placement::{self, BATCH, Batch, place};

/// Splits of one task.
const CHUNK_LEN: usize = BATCH;

/// What an edit has replaced.
#[derive(Default)]
pub struct Replaced {
    pub places: Vec<(u32, Option<Place>)>,
    pub built: Vec<(u32, Option<[Place; 2]>)>,
}

impl Moves {
    /// Puts vertices of a level, told by their nodes, where they are from now on, and what is coarser where it belongs then.
    /// `mesh` is of that level or a finer one; `around` tells the nodes around each vertex at the level.
    pub fn edit<I: Iterator<Item = u32>>(
        &mut self,
        context: &Context,
        mesh: &ActiveMesh,
        reached: &[(u32, Place)],
        around: impl Fn(usize) -> I + Sync,
    ) -> Replaced {
        self.stars.complete(context, mesh);
        let mut replaced = Replaced::default();
        let mut set = |moves: &mut Self, node, place| {
            replaced.places.push((node, moves.places.set(node, Some(place))));
        };
        reached.iter().for_each(|(node, place)| set(self, *node, *place));
        let claimed = Claimed::new(mesh.whole.vertex_count());
        let mut waiting = Waiting::default();
        let found = context.map(reached.len().div_ceil(CHUNK_LEN), |part| {
            let mut found = Vec::new();
            for index in part * CHUNK_LEN..reached.len().min((part + 1) * CHUNK_LEN) {
                claimed.claim(&mesh.whole, reached[index].0, around(index), &mut found);
            }
            found
        });
        found.into_iter().flatten().for_each(|(depth, split)| waiting.add(depth, split));
        let mut depth = 0;
        while depth < waiting.0.len() {
            let mut splits = std::mem::take(&mut waiting.0[depth]);
            splits.sort_unstable();
            let moves = &*self;
            let merged = context.map(splits.len().div_ceil(CHUNK_LEN), |part| {
                let splits = &splits[part * CHUNK_LEN..splits.len().min((part + 1) * CHUNK_LEN)];
                let mut merging = Merging::new(context, &mesh.whole, moves, &claimed);
                splits.chunks(BATCH).for_each(|splits| merging.merge(splits));
                (merging.merged, merging.found)
            });
            for (merged, found) in merged {
                self.places.ask_ahead(merged.iter().map(|merged| mesh.whole.parent(merged.split)));
                self.built.ask_ahead(merged.iter().map(|merged| merged.split));
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
        // Neighbours that go while it is still there. What they become has moved then, and tells of what is next.
        for node in around.filter(|node| depth(whole, *node) < own).chain((own != NONE).then_some(moved)) {
            let split = node / 2;
            let (word, bit) = (&self.0[split as usize / 32], 1 << (split % 32));
            if word.load(Relaxed) & bit == 0 && word.fetch_or(bit, Relaxed) & bit == 0 {
                found.push((depth(whole, node), split));
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
    scale: f32,
    /// Of the splits of a batch, as built and as they are now.
    places: Vec<[Place; 2]>,
    /// How many triangles at a vertex have each of the ring.
    counts: Vec<u8>,
    merged: Vec<Merged>,
    found: Vec<(u32, u32)>,
}

/// A split of a batch.
struct Site<'a> {
    split: u32,
    star: Star<'a>,
    /// Where its ring is in `places`, before its two vertices.
    first: usize,
    /// Where its one vertex was built.
    built: Place,
}

impl<'a> Merging<'a> {
    fn new(context: &'a Context, whole: &'a Progressive, moves: &'a Moves, claimed: &'a Claimed) -> Self {
        Self {
            context,
            whole,
            moves,
            claimed,
            scale: whole.scale(),
            places: Vec::new(),
            counts: Vec::new(),
            merged: Vec::with_capacity(CHUNK_LEN),
            found: Vec::new(),
        }
    }

    /// The splits of a batch.
    fn merge(&mut self, splits: &[u32]) {
        let mut batch = Batch::default();
        self.places.clear();
        self.ask_ahead(splits);
        let mut sites: [Option<Site>; BATCH] = [const { None }; BATCH];
        for (lane, (split, site)) in splits.iter().zip(&mut sites).enumerate() {
            let found = self.site(*split);
            self.gather(&found, &mut batch, lane);
            *site = Some(found);
        }
        place(self.context.level(), &mut batch);
        for (lane, site) in sites.iter().flatten().enumerate() {
            let around = site.star.ring.iter().copied();
            self.claimed.claim(self.whole, self.whole.parent(site.split), around, &mut self.found);
            let merged = self.merged(site, &batch, lane);
            self.merged.push(merged);
        }
    }

    /// Asks for what [`Self::site`] will touch, for all of a batch at once: it is all over memory.
    fn ask_ahead(&self, splits: &[u32]) {
        let (whole, moves) = (self.whole, self.moves);
        moves.stars.ask_ahead(splits);
        let own = splits.iter().map(|split| whole.parent(*split));
        let around = splits.iter().flat_map(|split| moves.stars.star(*split).ring.iter().copied());
        let ends = splits.iter().flat_map(|split| [2 * split, 2 * split + 1]);
        whole.ask_ahead(around.clone().chain(own).chain(ends.clone()));
        moves.places.ask_ahead(around.chain(ends));
    }

    fn site(&mut self, split: u32) -> Site<'a> {
        let (whole, moves) = (self.whole, self.moves);
        let (star, first) = (moves.stars.star(split), self.places.len());
        let nodes = star.ring.iter().copied().chain([2 * split, 2 * split + 1]);
        self.places.extend(nodes.map(|node| moves.both(whole, node)));
        Site { split, star, first, built: whole.place(Child::Split(split), NONE) }
    }

    fn now(&self, site: &Site, number: usize) -> Vec3 {
        self.places[site.first + number][1].point
    }

    /// The normal of a triangle at a vertex, as simplification weighs it.
    fn normal(&self, site: &Site, here: Vec3, [after, before]: [usize; 2]) -> Vec3 {
        let [after, before] = [after, before].map(|end| Vec3A::from((self.now(site, end) - here) * self.scale));
        normal(after, before).into()
    }

    /// What a vertex of the split knows of its triangles and borders; and the normals of those on both sides of the split,
    /// with their number.
    fn star(&mut self, site: &Site, side: usize) -> (placement::Star, [Vec3; 2], usize) {
        let (here, other) = (self.now(site, site.star.end(side)), site.star.end(1 - side));
        let mut star = [0.0; 9];
        let mut add = |normal: Vec3, share: f32| {
            let [x, y, z] = normal.to_array();
            for (entry, value) in star.iter_mut().zip([x * x, y * y, z * z, x * y, x * z, y * z]) {
                *entry += share * value;
            }
        };
        let mut sum = Vec3::ZERO;
        let (mut sides, mut count) = ([Vec3::ZERO; 2], 0);
        self.counts.clear();
        self.counts.resize(site.star.ring.len() + 2, 0);
        for ends in site.star.spokes(side) {
            let normal = self.normal(site, here, ends);
            add(normal, 1.0);
            sum += normal;
            ends.into_iter().for_each(|end| self.counts[end] = self.counts[end].saturating_add(1));
            if ends.contains(&other) && count < 2 {
                sides[count] = normal;
                count += 1;
            }
        }
        for (end, _) in self.counts.iter().enumerate().filter(|(_, count)| **count == 1) {
            let along = (self.now(site, end) - here) * self.scale;
            let length = along.length();
            [Vec3::X, Vec3::Y, Vec3::Z].into_iter().for_each(|axis| add(axis * length, 1.0));
            add(along, -1.0);
        }
        star[6..].copy_from_slice(&sum.to_array());
        (star, sides, count)
    }

    /// Puts the edge between the vertices of a split into a batch.
    fn gather(&mut self, site: &Site, batch: &mut Batch, lane: usize) {
        let [(first, sides, count), (second, ..)] = [0, 1].map(|side| self.star(site, side));
        for (star, values) in batch.star.iter_mut().zip([first, second]) {
            star.iter_mut().zip(values).for_each(|(entries, value)| entries[lane] = value);
        }
        let numbers = [site.star.end(0), site.star.end(1)];
        let [start, end] = numbers.map(|end| self.now(site, end));
        let edge = (end - start) * self.scale;
        for axis in 0..3 {
            batch.edge[axis][lane] = edge[axis];
            batch.side[0][axis][lane] = sides[0][axis];
            batch.side[1][axis][lane] = sides[1][axis];
        }
        // A vertex that stayed when the mesh was built still does.
        let [stays, goes] = numbers.map(|end| self.places[site.first + end][0].point == site.built.point);
        batch.pinned[lane] = if stays { -1.0 } else { f32::from(u8::from(goes)) };
        batch.open[lane] = f32::from(u8::from(count == 1));
    }

    /// A split as if it was taken back.
    fn merged(&self, site: &Site, batch: &Batch, lane: usize) -> Merged {
        let ends = [site.star.end(0), site.star.end(1)];
        let [start, end] = ends.map(|end| self.now(site, end));
        let offset = Vec3::from(batch.place.map(|axis| axis[lane])) / self.scale;
        let point = match batch.pinned[lane] {
            pinned if pinned < 0.0 => start,
            pinned if pinned > 0.0 => end,
            _ => 0.5 * (start + end) + offset,
        };
        let mut sum = Vec3::ZERO;
        for side in 0..2 {
            for spoke in site.star.spokes(side).filter(|spoke| !spoke.contains(&ends[1 - side])) {
                sum += self.normal(site, point, spoke);
            }
        }
        let place = Place { point, normal: sum.try_normalize().unwrap_or(site.built.normal) };
        let built = [0, 1].map(|side| {
            let beside = site.star.beside(side);
            let neighbours = &self.places[site.first + beside.start..site.first + beside.end];
            Surroundings::new([site.built, place], neighbours).back(self.places[site.first + ends[side]][1])
        });
        Merged { split: site.split, place, built }
    }
}
