//! Meshes that are as fine as a view needs them: by the deviation on the screen, more at outlines, none outside of it.

use glam::{Vec3, Vec4, Vec4Swizzles};
use relievo_core::{Context, Error, Result};

use super::active::ActiveMesh;
use super::bitset::BitSet;
use crate::progressive::build::hierarchy::{Child, Progressive};
use crate::progressive::edit::place::Place;

/// The cosine between normal and view within which a vertex may be at an outline.
const OUTLINE: f32 = 0.25;

/// A view, and how fine it wants a mesh.
#[derive(Clone, Debug, PartialEq)]
pub struct View {
    /// Where it is seen from.
    pub eye: [f32; 3],
    /// Pixels of what has the length of its distance: half the height of the picture by the tangent of half the angle.
    pub pixels: f32,
    /// Deviation that is allowed, in pixels, above 0.
    pub tolerance: f32,
    /// The same divided by this, at least 1, where the surface may be an outline.
    pub outline: f32,
    /// What is seen: all that has n · p + d ≥ 0 for each n and d, with n of length 1. None for everything.
    pub planes: Vec<[f32; 4]>,
}

/// How far what a split makes is from its vertex, at most.
pub struct Extents(pub(crate) Vec<f32>);

impl Extents {
    /// Of the splits of a mesh as it was built.
    pub fn new(mesh: &Progressive) -> Self {
        let mut splits: Vec<(u32, u32)> = mesh.splits().map(|(split, key, _)| (key.depth(), split)).collect();
        splits.sort_unstable();
        let mut extents = vec![0.0; mesh.vertex_count()];
        // What is split further is less deep.
        for (_, split) in splits {
            let here = mesh.place(Child::Split(split), split).point;
            let reach = |side: u32| {
                let child = mesh.child(2 * split + side);
                let place = mesh.place(child, mesh.leaf(2 * split + side)).point;
                let beyond = match child {
                    Child::Split(next) => extents[next as usize],
                    Child::Leaf(_) => 0.0,
                };
                here.distance(place) + beyond
            };
            extents[split as usize] = reach(0).max(reach(1));
        }
        Self(extents)
    }
}

impl View {
    pub(crate) fn check(&self) -> Result<()> {
        let is_usable = self.eye.iter().all(|value| value.is_finite())
            && self.pixels > 0.0
            && self.tolerance > 0.0
            && self.outline >= 1.0
            && self.planes.iter().flatten().all(|value| value.is_finite());
        if is_usable {
            Ok(())
        } else {
            Err(Error::invalid("a view needs finite places and a tolerance above 0").at("view"))
        }
    }

    /// Whether a split of a vertex at `place` is wanted, which deviates by `error` and reaches as far as `extent`.
    fn wants(&self, place: Place, error: f32, extent: f32) -> bool {
        let is_out = |plane: &[f32; 4]| {
            let plane = Vec4::from(*plane);
            plane.xyz().dot(place.point) + plane.w < -extent
        };
        if self.planes.iter().any(is_out) {
            return false;
        }
        let along = place.point - Vec3::from(self.eye);
        let distance = along.length();
        let near = distance - extent;
        if near <= 0.0 {
            return true;
        }
        let may_be_outline = place.normal.dot(along).abs() < OUTLINE * distance + extent;
        error * self.pixels * if may_be_outline { self.outline } else { 1.0 } > self.tolerance * near
    }
}

impl ActiveMesh {
    /// Becomes as fine as a view needs it. Splits that a wanted one stands on are made too, and those stay that a
    /// wanted one stands on. Returns how many splits were made and taken back.
    ///
    /// # Errors
    /// Fails if the view is not usable, or the extents are of another mesh.
    pub fn adapt_to(&mut self, context: &Context, view: &View, extents: &Extents) -> Result<[usize; 2]> {
        view.check()?;
        if extents.0.len() != self.whole.vertex_count() {
            return Err(Error::invalid("they are of another mesh").at("extents"));
        }
        self.is_mixed = true;
        Ok(context.within(|| [self.refine_to(context, view, extents), self.coarsen_to(context, view, extents)]))
    }

    fn refine_to(&mut self, context: &Context, view: &View, extents: &Extents) -> usize {
        let wanted = |mesh: &Self, vertex: u32| {
            let Some(Child::Split(split)) = mesh.child(vertex) else { return None };
            let key = mesh.whole.splits[split as usize].key;
            let place = mesh.place(vertex, Child::Split(split));
            // What is not read yet is not there to be wanted.
            (key.depth() > 0 && view.wants(place, key.error(), extents.0[split as usize])).then_some(vertex)
        };
        let mut list = self.scan(context, wanted);
        if list.is_empty() {
            return 0;
        }
        let listed = BitSet::new(self.whole.vertex_count());
        list.iter().for_each(|vertex| _ = listed.insert(*vertex));
        let mut splits = 0;
        while !list.is_empty() {
            let mesh = &*self;
            let under = context.map(list.len(), |index| mesh.stands_on(list[index]));
            let (mut ready, mut next) = (Vec::new(), Vec::new());
            for (vertex, under) in list.into_iter().zip(under) {
                if under.is_empty() {
                    ready.push(vertex);
                    continue;
                }
                next.push(vertex);
                next.extend(under.into_iter().filter(|other| listed.insert(*other)));
            }
            // Not before: others of this round may stand on them.
            ready.iter().for_each(|vertex| listed.remove(*vertex));
            splits += ready.len();
            let made = self.make(context, &ready, wanted);
            next.extend(made.into_iter().filter(|vertex| listed.insert(*vertex)));
            list = next;
        }
        splits
    }

    fn coarsen_to(&mut self, context: &Context, view: &View, extents: &Extents) -> usize {
        let unwanted = |mesh: &Self, split: u32| {
            let is_kept = || {
                let error = mesh.whole.splits[split as usize].key.error();
                view.wants(mesh.before_split(split), error, extents.0[split as usize])
            };
            (mesh.is_whole(split) && !is_kept()).then_some(split)
        };
        let mut list = self.scan(context, unwanted);
        let mut splits = 0;
        loop {
            list.sort_unstable();
            list.dedup();
            let mesh = &*self;
            let free = context.map(list.len(), |index| mesh.bears_nothing(list[index]));
            let (ready, rest): (Vec<_>, Vec<_>) = list.into_iter().zip(free).partition(|(_, free)| *free);
            if ready.is_empty() {
                return splits;
            }
            let ready: Vec<u32> = ready.into_iter().map(|(split, _)| split).collect();
            splits += ready.len();
            list = self.unmake(context, &ready, unwanted);
            list.extend(rest.into_iter().map(|(split, _)| split));
        }
    }

    /// The vertices around one whose splits have to be made before its own.
    fn stands_on(&self, vertex: u32) -> Vec<u32> {
        let depth = |vertex: u32| match self.child(vertex) {
            Some(Child::Split(split)) => self.whole.splits[split as usize].key.depth(),
            _ => 0,
        };
        let own = depth(vertex);
        let mut under: Vec<u32> = self.spokes(vertex).flatten().filter(|other| depth(*other) > own).collect();
        under.sort_unstable();
        under.dedup();
        under
    }

    /// Whether no split around stands on this one.
    fn bears_nothing(&self, split: u32) -> bool {
        let own = self.whole.splits[split as usize].key.depth();
        let ends = [self.target(split), split];
        let mut around = ends.into_iter().flat_map(|end| self.spokes(end).flatten());
        around.all(|vertex| ends.contains(&vertex) || self.made_by(vertex).is_none_or(|key| key.depth() > own))
    }
}
