//! A document as its tests model it: plain lists of layers and blocks, and changes by number.

// Not every test uses all of it.
#![allow(dead_code)]

use relievo_core::{Context, Mesh};
use relievo_document::{Blend, Change, Document, Edit, Head, Kind, Recipe, Settings, recipe};

pub const SIZE: usize = 10 * 10 * 2;
/// Tiles of the mesh.
const TILES: u32 = 6;

pub fn mesh() -> Mesh {
    let points = (0..14).map(|i| [(i / 2) as f32, (i % 2) as f32, 0.0]).collect();
    let corners = (0..6).flat_map(|i| [2 * i, 2 * i + 2, 2 * i + 3, 2 * i + 1]).collect();
    Mesh::new(points, vec![4; TILES as usize], corners)
}

pub fn head(id: u32, name: &str) -> Head {
    Head::new(id, name, Kind::Scalar, &[0; 2], vec![8; 6])
}

/// What every tile of the layers holds; the plain model that documents are held against.
#[derive(Clone, Debug, PartialEq)]
pub struct Model {
    pub heads: Vec<Head>,
    pub blocks: std::collections::BTreeMap<(u32, u32), Vec<u8>>,
    pub recipes: Vec<Recipe>,
}

impl Model {
    pub fn new() -> Self {
        let blocks = [((4, 0), vec![5; SIZE]), ((4, 2), vec![6; SIZE])].into();
        Self { heads: vec![head(4, "first")], blocks, recipes: Vec::new() }
    }

    pub fn document(&self) -> Document {
        let mut document = Document::new(&mesh(), "baseline").unwrap();
        for head in &self.heads {
            let tiles: Vec<u32> = self.blocks.keys().filter(|key| key.0 == head.id).map(|key| key.1).collect();
            let read = |tile| Ok(self.blocks[&(head.id, tile)].clone());
            document.pack_layer(&Context::serial(), head.clone(), &tiles, read).unwrap();
        }
        for recipe in &self.recipes {
            document.put_recipe(recipe.id, Some(recipe.bytes.clone())).unwrap();
        }
        document
    }

    /// The payload of the edit from here to `after`.
    pub fn edit(&self, after: &Model) -> Vec<u8> {
        let mut keys: Vec<_> = self.blocks.keys().chain(after.blocks.keys()).copied().collect();
        keys.sort_unstable();
        keys.dedup();
        keys.retain(|key| self.blocks.get(key) != after.blocks.get(key));
        let layers = (self.heads != after.heads).then_some([self.heads.as_slice(), &after.heads]);
        let of = |model: &'_ Model, key| model.blocks.get(key).map(Vec::len);
        assert!(keys.iter().all(|key| of(self, key).or(of(after, key)) == Some(SIZE)));
        let recipes = recipe::difference(&self.recipes, &after.recipes);
        Edit::encode_with(&Context::serial(), layers, &recipes, keys.len(), |index| Change {
            layer: keys[index].0,
            block: keys[index].1,
            before: self.blocks.get(&keys[index]).map(|bytes| bytes.as_slice().into()),
            after: after.blocks.get(&keys[index]).map(|bytes| bytes.as_slice().into()),
            blank: &[0, 0],
            fades: false,
        })
        .unwrap()
    }

    /// Some change, for every number another.
    pub fn changed(&self, number: u32) -> Self {
        let mut next = self.clone();
        let layer = next.heads[number as usize % next.heads.len()].id;
        for tile in [number % TILES, (number * 7 + 3) % TILES] {
            if number % 5 == 3 && next.blocks.remove(&(layer, tile)).is_some() {
                continue;
            }
            let block = next.blocks.entry((layer, tile)).or_insert_with(|| vec![0; SIZE]);
            block[number as usize % 90..number as usize % 90 + 40]
                .iter_mut()
                .for_each(|byte| *byte ^= number as u8 & 0x3b);
        }
        let bytes = (number % 4 != 3).then(|| vec![number as u8; 3 * number as usize % 50]);
        recipe::put(&mut next.recipes, number % 3, bytes).unwrap();
        if number % 7 == 4 {
            next.heads.push(head(100 + number, &format!("layer {number}")));
            next.heads[0].settings = Settings { opacity: 0.5, blend: Blend::Max, visible: number.is_multiple_of(2) };
        }
        if number % 11 == 8 && next.heads.len() > 1 {
            let gone = next.heads.pop().unwrap();
            next.blocks.retain(|key, _| key.0 != gone.id);
        }
        next
    }
}
