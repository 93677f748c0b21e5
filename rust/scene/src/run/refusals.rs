//! Which faces of which objects a budget refused tiles, for the notes of a run.

use std::collections::{BTreeMap, BTreeSet};

use relievo_detail::refusal;

use crate::state::world::{Item, World};

/// Tiles that were refused, and faces of triangle meshes.
#[derive(Clone, Debug, Default)]
pub struct Refusals {
    tiles: BTreeMap<usize, BTreeSet<u32>>,
}

impl Refusals {
    /// Adds tiles of an object, or faces if it is a triangle mesh.
    pub fn add(&mut self, object: usize, tiles: &[u32]) {
        if !tiles.is_empty() {
            self.tiles.entry(object).or_default().extend(tiles);
        }
    }

    /// Adds refusals that came afterwards.
    pub fn merge(&mut self, other: &Self) {
        for (object, tiles) in &other.tiles {
            self.tiles.entry(*object).or_default().extend(tiles);
        }
    }

    /// A note for each object of `world` that has any.
    pub fn notes(&self, world: &World) -> Vec<String> {
        let note = |object: usize, tiles: &BTreeSet<u32>| {
            let numbers: Vec<u32> = tiles.iter().copied().collect();
            let faces = match world.items().get(object)? {
                Item::Surface(surface) => refusal::faces(surface.surface().topology(), &numbers),
                Item::Triangles(_) => numbers,
                Item::Mesh(_) => return None,
            };
            let name = world.scene.objects.get(object).map_or("", |entry| entry.name.text.as_str());
            Some(format!(
                "the budget refused {} tiles of {} of object `{name}`, which stayed as they were; raise `budget` in \
                 [details], or let tiles leave memory with `page`",
                tiles.len(),
                refusal::named(&faces)
            ))
        };
        self.tiles.iter().filter_map(|(object, tiles)| note(*object, tiles)).collect()
    }
}
