//! Decals that documents keep in layers of their own, from which they are taken up again.

use std::ffi::{c_char, c_void};
use std::sync::{Arc, RwLock};

use relievo_core::progress::Silent;
use relievo_core::{Error, Progress, Result};
use relievo_decal::{Ground, Ink, Pin, Printable, Recipe, recipes};
use relievo_detail::{DisplacedObject, TriangleObject, with_object};
use relievo_document::Settings;
use relievo_render::Image;

use super::{DecalObject, RlvDecal, RlvDecalImage, RlvDecalInk, RlvDecalPin, Triangles, read_ink, tessellate};
use crate::border::array::{Output, present, put, text};
use crate::border::descriptor::write_descriptor;
use crate::border::registry::{self, try_read};
use crate::details::detail::{RLV_CHANNEL_COLOR, RLV_CHANNEL_DISPLACEMENT, log_refusal};
use crate::details::document::{DocumentObject, RlvDocument};
use crate::runtime::context::{HostProgress, RlvProgress};

descriptor! {
    pub struct RlvDecalRecipe {
        struct_size: u32,
        id: u32,
        layer: u32,
        pin_count: u32,
        width: u32,
        height: u32,
        channel: u32,
        blend: u32,
        opacity: f32,
        relief: f32,
        image_hash: u64,
    }
}

/// Reads what a decal puts on its layer, and how that is seen.
///
/// # Safety
/// `ink` is NULL or a descriptor that starts with its size.
unsafe fn ink_of(ink: *const RlvDecalInk) -> Result<(Ink, Settings)> {
    // SAFETY: promised by the caller.
    let (given, settings) = unsafe { read_ink(ink) }?;
    let ink = match given.channel {
        RLV_CHANNEL_COLOR => Ink::Color,
        RLV_CHANNEL_DISPLACEMENT => Ink::Relief(given.height),
        other => {
            let error = Error::invalid(format!("channel {other} has no layers"));
            return Err(error.at("ink").advise("use colour or displacement"));
        }
    };
    Ok((ink, settings))
}

impl DecalObject {
    /// What the decal is made of as it lies now, to be written into a layer.
    fn recipe(&self, ink: Ink, seen: Settings) -> Result<Recipe> {
        let Some((_, triangles)) = &self.detail else {
            return Err(Error::invalid("it lies on a mesh").at("decal").advise("lay it with rlv_decal_on_detail"));
        };
        let placement = try_read(&self.placement, "decal")?;
        let keep = |pin: Pin| {
            let place = match triangles {
                Triangles::Cage(made) => DisplacedObject::kept(made, pin.place),
                Triangles::Mesh(made) => TriangleObject::kept(made, pin.place),
            };
            Ok(Pin { place: place?, ..pin })
        };
        Ok(Recipe {
            sticker: placement.sticker().clone(),
            image: 0,
            pins: placement.pins().into_iter().map(keep).collect::<Result<_>>()?,
            depths: self.depths.clone(),
            pose: self.pose,
            settings: *placement.settings(),
            cells: self.cells,
            layer: 0,
            ink,
            seen,
        })
    }

    /// Fails unless the decal lies on the detail of a document.
    fn check_document(&self, document: &DocumentObject) -> Result<()> {
        if self.detail.as_ref().is_some_and(|(detail, _)| Arc::ptr_eq(detail, &document.detail)) {
            return Ok(());
        }
        Err(Error::invalid("it does not lie on the detail of the document")
            .at("decal")
            .advise("lay it on that detail with rlv_decal_on_detail, or take it up with rlv_decal_take_up"))
    }
}

/// What is done with a decal of a document.
enum Task<'a> {
    Apply(Recipe, &'a str, &'a Image),
    Update(u32, Recipe, &'a Image),
    Remove(u32),
}

impl Task<'_> {
    /// Returns the number of the decal and the tiles that the budget refused.
    fn run<O: Printable>(self, ground: &mut Ground<'_, O>, progress: &mut dyn Progress) -> Result<(u32, Vec<u32>)> {
        let done = match self {
            Self::Apply(recipe, layer, image) => ground.apply(recipe, layer, image, progress)?,
            Self::Update(id, recipe, image) => ground.update(id, recipe, image, progress)?,
            Self::Remove(id) => return ground.remove(id).map(|()| (id, Vec::new())),
        };
        Ok((done.id, done.printed.refused))
    }
}

/// Changes the decals of a document: one edit. Returns the number of the decal.
fn edit(document: &DocumentObject, task: Task<'_>, progress: &mut dyn Progress) -> Result<u32> {
    let detail = &document.detail;
    let (mut history, mut editor) = (document.history()?, detail.edit()?);
    let (context, view) = (&detail.context.context, detail.view());
    let done = with_object!(&mut editor.object, object => {
        let mut ground = Ground { context, object: &mut **object, cage: &view.cage, history: &mut history };
        task.run(&mut ground, progress)
    });
    let budget = editor.budget();
    drop(history);
    detail.leave(editor);
    let (id, refused) = done?;
    log_refusal(detail, &refused, budget);
    Ok(id)
}

/// The decals of a document; a damaged one is an error of its own.
fn kept(document: &DocumentObject) -> Result<Vec<(u32, Result<Recipe>)>> {
    Ok(recipes(&*document.history()?))
}

/// The recipe of the decal with the number `id`.
fn find(document: &DocumentObject, id: u32) -> Result<Recipe> {
    let found = kept(document)?.into_iter().find(|(other, _)| *other == id);
    let missing = || Err(Error::invalid(format!("there is no decal {id}")).at("id").advise("ask rlv_decal_recipe"));
    found.map_or_else(missing, |(_, recipe)| recipe)
}

/// Lays a decal of a document on the detail as it was committed last.
fn take_up(document: &DocumentObject, id: u32, progress: &mut dyn Progress) -> Result<RlvDecal> {
    let (recipe, detail) = (find(document, id)?, &document.detail);
    let triangles = tessellate(&detail.context.context, detail, recipe.cells)?;
    let placement = match &triangles {
        Triangles::Cage(made) => recipe.lay_on::<DisplacedObject>(made, progress)?,
        Triangles::Mesh(made) => recipe.lay_on::<TriangleObject>(made, progress)?,
    };
    let depths = if recipe.depths.is_empty() { vec![0.0; recipe.pins.len()] } else { recipe.depths };
    registry::insert(DecalObject {
        context: detail.context.clone(),
        size: recipe.sticker.pixels(),
        detail: Some((detail.clone(), triangles)),
        depths,
        pose: recipe.pose,
        cells: recipe.cells,
        placement: RwLock::new(placement),
    })
}

entry! {
    fn rlv_decal_pins(decal: RlvDecal, pins: *mut RlvDecalPin, capacity: usize, count: *mut usize) {
        present("count", count)?;
        let object = registry::get(decal)?;
        // SAFETY: the caller gives room for `capacity` pins, or NULL to ask for the count alone.
        let out = unsafe { Output::optional("pins", pins, capacity, 0) }?;
        let placement = try_read(&object.placement, "decal")?;
        let found = placement.pins();
        // SAFETY: checked above.
        unsafe { put(count, found.len()) };
        if let Some(out) = out {
            let made = found.iter().zip(&object.depths).map(|(pin, depth)| {
                Ok(RlvDecalPin { image: pin.image, position: placement.position(pin.place)?, depth: *depth })
            });
            out.holds("pins", found.len())?.fill(made.collect::<Result<Vec<_>>>()?);
        }
        Ok(())
    }

    fn rlv_decal_count(document: RlvDocument, count: *mut usize) {
        present("count", count)?;
        let found = kept(&*registry::get(document)?)?.len();
        // SAFETY: checked above.
        unsafe { put(count, found) };
        Ok(())
    }

    fn rlv_decal_recipe(document: RlvDocument, index: usize, out: *mut RlvDecalRecipe) {
        let mut found = kept(&*registry::get(document)?)?;
        if index >= found.len() {
            return Err(Error::invalid(format!("there is no decal at {index}"))
                .at("index")
                .advise(format!("there are {}", found.len())));
        }
        let (id, recipe) = found.swap_remove(index);
        let recipe = recipe?;
        let (channel, relief) = match recipe.ink {
            Ink::Color => (RLV_CHANNEL_COLOR, 0.0),
            Ink::Relief(height) => (RLV_CHANNEL_DISPLACEMENT, height),
        };
        let [width, height] = recipe.sticker.pixels();
        let made = RlvDecalRecipe {
            struct_size: 0,
            id,
            layer: recipe.layer,
            pin_count: recipe.pins.len() as u32,
            width,
            height,
            channel,
            blend: recipe.seen.blend as u32,
            opacity: recipe.seen.opacity,
            relief,
            image_hash: recipe.image,
        };
        // SAFETY: the caller gives NULL or a descriptor that starts with its size.
        unsafe { write_descriptor(out, made) }
    }

    fn rlv_decal_apply(
        decal: RlvDecal,
        document: RlvDocument,
        layer: *const c_char,
        image: *const RlvDecalImage,
        ink: *const RlvDecalInk,
        progress: RlvProgress,
        user: *mut c_void,
        id: *mut u32,
    ) {
        present("id", id)?;
        let (object, document) = (registry::get(decal)?, registry::get(document)?);
        // SAFETY: the caller gives a NUL-terminated text, and descriptors that start with their size, with pixels of their count.
        let (layer, image, (ink, seen)) = unsafe { (text("layer", layer)?, object.image(image)?, ink_of(ink)?) };
        object.check_document(&document)?;
        let task = Task::Apply(object.recipe(ink, seen)?, layer, &image);
        let made = edit(&document, task, &mut HostProgress { callback: progress, user })?;
        // SAFETY: checked above.
        unsafe { put(id, made) };
        Ok(())
    }

    fn rlv_decal_take_up(
        document: RlvDocument,
        id: u32,
        progress: RlvProgress,
        user: *mut c_void,
        out: *mut RlvDecal,
    ) {
        present("out", out)?;
        let made = take_up(&*registry::get(document)?, id, &mut HostProgress { callback: progress, user })?;
        // SAFETY: checked above.
        unsafe { put(out, made) };
        Ok(())
    }

    fn rlv_decal_update(
        decal: RlvDecal,
        document: RlvDocument,
        id: u32,
        image: *const RlvDecalImage,
        ink: *const RlvDecalInk,
        progress: RlvProgress,
        user: *mut c_void,
    ) {
        let (object, document) = (registry::get(decal)?, registry::get(document)?);
        object.check_document(&document)?;
        let old = find(&document, id)?;
        // SAFETY: the caller gives descriptors that start with their size, with pixels of their count.
        let (image, (ink, seen)) = unsafe {
            (object.image(image)?, if ink.is_null() { (old.ink, old.seen) } else { ink_of(ink)? })
        };
        if ink.kind() != old.ink.kind() {
            return Err(Error::invalid("the decal lies in a layer of another kind").at("ink").advise("apply it anew"));
        }
        let task = Task::Update(id, object.recipe(ink, seen)?, &image);
        edit(&document, task, &mut HostProgress { callback: progress, user }).map(drop)
    }

    fn rlv_decal_remove(document: RlvDocument, id: u32) {
        let document = registry::get(document)?;
        edit(&document, Task::Remove(id), &mut Silent).map(drop)
    }
}
