//! The layers of a session: each change of them is an edit that can be undone.

use relievo_core::Result;
use relievo_detail::{AnyObject, LayerInfo, LayeredObject, with_object};
use relievo_document::{Kind, Settings};
use relievo_tiles::Blocks;

use super::Session;

impl Session {
    /// The layers, from the lowest: those of displacement, then those of colour.
    pub fn layers(&self) -> Vec<LayerInfo> {
        with_object!(&self.object, it => it.layers())
    }

    /// Adds a layer of displacement or of colour above those of its kind, which edits then go to.
    ///
    /// # Errors
    /// There are as many layers as there may be.
    pub fn add_layer(&mut self, is_color: bool) -> Result<()> {
        let layers = self.layers();
        let like = layers.iter().rfind(|layer| layer.kind.is_color() == is_color);
        let kind = like.map_or(Kind::Scalar, |layer| layer.kind);
        let (what, size) = (if is_color { "paint" } else { "relief" }, self.texels());
        let name = (1..).map(|number| format!("{what} {number}")).find(|name| layers.iter().all(|it| it.name != *name));
        let name = name.unwrap_or_default();
        self.edit(&format!("add layer {name}"), |context, object| {
            with_object!(object, it => it.add_layer(context, kind, &name, Settings::of(kind), size)).map(drop)
        })
    }

    /// Texels along an edge of a face, or segments of a side.
    fn texels(&self) -> u32 {
        match &self.object {
            AnyObject::Tiles(object) => object.displacement().field().face_sizes().first().copied().unwrap_or(8),
            AnyObject::Triangles(object) => object.displacement().field().pattern().segments(),
        }
    }

    /// Removes a layer with all that is on it.
    ///
    /// # Errors
    /// It is the last of its kind.
    pub fn remove_layer(&mut self, layer: &LayerInfo) -> Result<()> {
        let id = layer.id;
        self.edit(&format!("remove layer {}", layer.name), |context, object| {
            with_object!(object, it => it.remove_layer(context, id)).map(drop)
        })
    }

    /// Changes how a layer is seen.
    ///
    /// # Errors
    /// There is no such layer.
    pub fn set_layer(&mut self, layer: &LayerInfo, to: Settings) -> Result<()> {
        let what = match (layer.settings.visible, to.visible) {
            (true, false) => "hide",
            (false, true) => "show",
            _ => "opacity of",
        };
        let id = layer.id;
        self.edit(&format!("{what} layer {}", layer.name), |context, object| {
            with_object!(object, it => it.set_layer(context, id, to)).map(drop)
        })
    }

    /// Puts a layer one place higher or lower among those of its kind.
    ///
    /// # Errors
    /// There is no such layer.
    pub fn shift_layer(&mut self, layer: &LayerInfo, is_up: bool) -> Result<()> {
        let layers = self.layers();
        let kin = layers.iter().filter(|other| other.kind.is_color() == layer.kind.is_color());
        let Some(place) = kin.map(|other| other.id).position(|id| id == layer.id) else { return Ok(()) };
        let to = if is_up { place + 1 } else { place.saturating_sub(1) };
        let id = layer.id;
        self.edit(&format!("move layer {}", layer.name), |context, object| {
            with_object!(object, it => it.place_layer(context, id, to)).map(drop)
        })
    }

    /// Names a layer.
    ///
    /// # Errors
    /// The name is taken, or none.
    pub fn rename_layer(&mut self, layer: &LayerInfo, name: &str) -> Result<()> {
        let id = layer.id;
        self.edit(&format!("rename layer {name}"), |_, object| with_object!(object, it => it.rename_layer(id, name)))
    }

    /// Has edits of its kind go to a layer.
    ///
    /// # Errors
    /// There is no such layer.
    pub fn activate_layer(&mut self, layer: &LayerInfo) -> Result<()> {
        with_object!(&mut self.object, it => it.set_active_layer(&self.context, layer.id))
    }
}
