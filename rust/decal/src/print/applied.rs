//! Decals as edits of an object: each lies in a layer of its own, and the document keeps its recipe, so that it is taken up,
//! changed and written anew, whatever lies in the layers above it.

use relievo_core::{Context, Error, Mesh, Progress, Result};
use relievo_detail::{DisplacedObject, History, LayerInfo, LayerState};
use relievo_document::{Kind, Settings};
use relievo_render::Image;

use crate::artwork::Artwork;
use crate::map::quality::Quality;
use crate::print::Printed;
use crate::print::printable::Printable;
use crate::print::recipe::{Recipe, hash};

/// A decal in a layer of its own.
#[derive(Clone, Debug, PartialEq)]
pub struct Applied {
    /// The number of its recipe.
    pub id: u32,
    /// What it changed.
    pub printed: Printed,
    /// The distortion.
    pub quality: Quality,
}

/// The object that decals are applied to.
pub struct Ground<'a, O = DisplacedObject> {
    /// Runs the work.
    pub context: &'a Context,
    /// The object.
    pub object: &'a mut O,
    /// The cage of its surface, or the triangle mesh that it was made from.
    pub cage: &'a Mesh,
    /// Its edits.
    pub history: &'a mut History,
}

/// The layer that a decal had before it was written anew.
struct Old {
    /// Its place among the layers of its kind, from the lowest.
    place: usize,
    /// The texels along an edge of its finest face.
    size: Option<u32>,
    /// Whether it was seen.
    is_visible: bool,
}

/// Returns the decals of a history with the numbers of their recipes; a damaged one is an error of its own.
pub fn recipes(history: &History) -> Vec<(u32, Result<Recipe>)> {
    let decals = history.recipes().iter().filter(|recipe| Recipe::is_one(&recipe.bytes));
    decals.map(|recipe| (recipe.id, Recipe::decode(&recipe.bytes))).collect()
}

/// Returns the number for one more recipe, ascending.
///
/// # Errors
/// Fails with `Invalid` if the last one has the greatest number.
pub fn next_recipe(recipes: &[relievo_document::Recipe]) -> Result<u32> {
    let Some(last) = recipes.last() else { return Ok(0) };
    last.id.checked_add(1).ok_or_else(|| {
        Error::invalid("a recipe of the document has the greatest number there is")
            .at(format!("recipe {}", last.id))
            .advise("write into a layer that the document has, or remove that recipe's decal")
    })
}

impl<O: Printable> Ground<'_, O> {
    /// Lays a sticker and writes it into a new layer called `name`, above those of its kind; the history keeps its recipe.
    /// One edit. The layer and the hash of the image in the recipe are set here.
    ///
    /// # Errors
    /// The name is taken, the image is not that of the sticker, the object has no colours, or as [`lay`](crate::lay).
    /// Nothing is changed then.
    pub fn apply(&mut self, recipe: Recipe, name: &str, image: &Image, progress: &mut dyn Progress) -> Result<Applied> {
        let id = next_recipe(self.history.recipes())?;
        self.edit(&format!("decal `{name}`"), |ground| ground.put(id, recipe, name, None, (image, progress)))
    }

    /// Writes a decal anew after its recipe changed, in place of what its layer has. One edit. Pins are where
    /// [`Printable::kept`] says, on the surface without the decal.
    ///
    /// # Errors
    /// There is no such decal, its layer is gone, or as [`Self::apply`]. Nothing is changed then.
    pub fn update(&mut self, id: u32, recipe: Recipe, image: &Image, progress: &mut dyn Progress) -> Result<Applied> {
        let (place, layer) = self.layer(id)?;
        let size = self.finest(|state| state.id == layer.id);
        self.edit(&format!("decal `{}` changed", layer.name), |ground| {
            ground.object.remove_layer(ground.context, layer.id)?;
            let old = Some(Old { place, size, is_visible: layer.settings.visible });
            ground.put(id, recipe, &layer.name, old, (image, progress))
        })
    }

    /// Removes a decal with its layer and its recipe. One edit.
    ///
    /// # Errors
    /// There is no such decal, or its layer is gone or the last of its kind. Nothing is changed then.
    pub fn remove(&mut self, id: u32) -> Result<()> {
        let (_, layer) = self.layer(id)?;
        self.edit(&format!("decal `{}` removed", layer.name), |ground| {
            ground.object.remove_layer(ground.context, layer.id)?;
            ground.history.put_recipe(id, None)
        })
    }

    /// Does something as one edit, and takes it back if it fails.
    fn edit<T>(&mut self, input: &str, edit: impl FnOnce(&mut Self) -> Result<T>) -> Result<T> {
        let active = self.active();
        self.history.begin(self.context, self.object, input)?;
        let done = edit(self);
        let done = match done {
            Ok(done) => self.history.end(self.context, self.object).map(|_| done),
            Err(error) => {
                self.history.abandon(self.context, self.object)?;
                Err(error)
            }
        };
        for id in active.into_iter().flatten() {
            if self.object.layers().iter().any(|layer| layer.id == id) {
                self.object.set_active_layer(self.context, id)?;
            }
        }
        done
    }

    /// The active layers of displacement and of colour.
    fn active(&self) -> [Option<u32>; 2] {
        let layers = self.object.layers();
        [false, true].map(|is_color| {
            let active = layers.iter().find(|layer| layer.active && layer.kind.is_color() == is_color);
            active.map(|layer| layer.id)
        })
    }

    /// The layer of a decal with its place among those of its kind.
    fn layer(&self, id: u32) -> Result<(usize, LayerInfo)> {
        let kept = self.history.recipes().iter().find(|recipe| recipe.id == id);
        let kept = kept.ok_or_else(|| Error::invalid(format!("there is no decal {id}")).at("decal"))?;
        let number = Recipe::decode(&kept.bytes)?.layer;
        let layers = self.object.layers();
        let layer = layers.iter().find(|layer| layer.id == number).cloned().ok_or_else(|| {
            Error::invalid("its layer is gone").at(format!("decal {id}")).advise("undo its removal, or apply it anew")
        })?;
        let alike = layers.iter().filter(|other| other.kind.is_color() == layer.kind.is_color());
        let place = alike.take_while(|other| other.id != number).count();
        Ok((place, layer))
    }

    /// The texels along an edge of the finest face of some layers.
    fn finest(&self, is_one: impl Fn(&LayerState) -> bool) -> Option<u32> {
        let states = self.object.layer_states();
        states.iter().filter(|state| is_one(state)).flat_map(|state| state.blocks.face_sizes()).max()
    }

    fn put(
        &mut self,
        id: u32,
        mut recipe: Recipe,
        name: &str,
        old: Option<Old>,
        (image, progress): (&Image, &mut dyn Progress),
    ) -> Result<Applied> {
        let artwork = Artwork::new(&recipe.sticker, image)?;
        let triangles = self.object.triangles(self.context, self.cage, recipe.cells)?;
        let decal = recipe.lay_on::<O>(&triangles, progress)?.decal();
        // A new layer is as fine as the finest one below.
        let is_below = |state: &LayerState| {
            let kind = state.blocks.kind();
            kind.is_color() == recipe.ink.kind().is_color() && matches!(kind, Kind::Scalar | Kind::Rgba8 | Kind::Rgba16)
        };
        let size = old.as_ref().and_then(|old| old.size).or_else(|| self.finest(is_below)).unwrap_or(8);
        let (layer, mut refused) = self.object.add_layer(self.context, recipe.ink.kind(), name, recipe.seen, size)?;
        // Blend mode and opacity are those of the layer.
        let plain = Settings::of(recipe.ink.kind());
        let what = (&decal, &artwork, recipe.depths.as_slice());
        let mut printed = self.object.print(self.context, &triangles, what, recipe.ink, &plain)?;
        if let Some(Old { place, is_visible, .. }) = old {
            refused.extend(self.object.place_layer(self.context, layer, place)?);
            if !is_visible {
                let hidden = Settings { visible: false, ..recipe.seen };
                refused.extend(self.object.set_layer(self.context, layer, hidden)?);
            }
        }
        printed.refuse(refused);
        (recipe.layer, recipe.image) = (layer, hash(image));
        self.history.put_recipe(id, Some(recipe.encode()))?;
        Ok(Applied { id, printed, quality: decal.quality })
    }
}
