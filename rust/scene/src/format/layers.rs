//! `[[objects.NAME.layers]]` of a scene file: read, and made.

use relievo_core::{Context, Result};
use relievo_detail::{DecayingObject, LayeredObject};
use relievo_document::{Blend, Kind, Settings};
use relievo_tiles::DecayOptions;

use crate::format::description::LayerEntry;
use crate::format::diagnostic::Diagnostic;
use crate::format::reader::{Reader, Table};

pub(crate) fn read_layers(reader: &mut Reader, object: Table) -> Vec<LayerEntry> {
    let mut layers: Vec<LayerEntry> = Vec::new();
    for table in reader.list(object, "layers") {
        let kind = match reader.choice(table, "kind") {
            Some("colour") => Kind::Rgba8,
            _ => Kind::Scalar,
        };
        let chosen = table.has("blend").then(|| reader.choice(table, "blend")).flatten();
        let blend = Blend::NAMES.into_iter().find(|(_, name)| Some(*name) == chosen).map(|(blend, _)| blend);
        let settings = Settings {
            opacity: reader.number(table, "opacity") as f32,
            blend: blend.unwrap_or(Blend::of(kind)),
            visible: reader.flag(table, "visible"),
        };
        let size = reader.whole(table, "tile_size") as u32;
        let decay = read_decay(reader, table);
        if let Err(error) = settings.check(kind) {
            let place = if table.has("blend") { table.span_of("blend") } else { table.span() };
            reader.fault(Diagnostic::from_error(place, &error));
        }
        let Some(name) = reader.text(table, "name") else {
            if !table.has("name") {
                reader.fault(Diagnostic::new(table.span(), "the layer has no name").advise("give it `name`"));
            }
            continue;
        };
        if let Some(other) = layers.iter().find(|layer| layer.name.text == name.text) {
            let said = Diagnostic::new(name.span.clone(), format!("layer `{}` is there already", name.text));
            let said = said.relate(other.name.span.clone(), "the other one").advise("name it otherwise");
            reader.fault(said);
            continue;
        }
        layers.push(LayerEntry { name, kind, settings, size, decay });
    }
    layers
}

/// `decay` of an object or a layer, if it has it.
pub(crate) fn read_decay(reader: &mut Reader, table: Table) -> Option<DecayOptions> {
    table.has("decay").then(|| {
        let table = reader.sub_table(table, "decay");
        DecayOptions { delay: reader.number(table, "delay") as f32, duration: reader.number(table, "duration") as f32 }
    })
}

impl LayerEntry {
    /// As [`Self::make`], with the decay of the layer, whose stamps may occupy `budget` bytes.
    pub(crate) fn make_fading(
        &self,
        context: &Context,
        object: &mut impl LayeredObject,
        size: u32,
        budget: u64,
    ) -> Result<()> {
        self.make(context, object, size)?;
        match (self.decay, object.layer(&self.name.text)) {
            (Some(decay), Some(id)) => object.set_layer_decay(context, id, Some(decay), budget),
            _ => Ok(()),
        }
    }

    /// Adds the layer to `object`, or makes the one of that name, which a document brought, be seen as the scene says.
    /// Edits go to the layers that they went to before. A new layer has `size` texels or segments along an edge.
    pub(crate) fn make(&self, context: &Context, object: &mut impl LayeredObject, size: u32) -> Result<()> {
        if let Some(id) = object.layer(&self.name.text) {
            return object.set_layer(context, id, self.settings).map(drop);
        }
        let active =
            object.layers().into_iter().find(|layer| layer.active && layer.kind.is_color() == self.kind.is_color());
        object.add_layer(context, self.kind, &self.name.text, self.settings, size)?;
        match active {
            Some(active) => object.set_active_layer(context, active.id),
            None => Ok(()),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::format::schema::BLENDS;

    #[test]
    fn the_words_of_scene_files_are_those_of_the_modes() {
        assert_eq!(Blend::NAMES.map(|(_, name)| name), BLENDS);
    }
}
