//! Layers of details; see `include/relievo/layer.h`.

use std::ffi::c_char;

use relievo_core::{Error, Result};
use relievo_detail::{LayerInfo, LayeredObject, with_object};
use relievo_document::{Blend, Kind, Settings};

use crate::border::array::{fixed, present, put, text};
use crate::border::descriptor::{read_descriptor, write_descriptor};
use crate::border::registry;
use crate::details::detail::{RlvDetail, log_refusal};
use crate::details::view::ViewKind;

constants! {
    u32:
    RLV_LAYER_DISPLACEMENT = 0,
    RLV_LAYER_COLOR = 1,
    RLV_LAYER_NAME_SIZE = 256,
    RLV_BLEND_NORMAL = 0,
    RLV_BLEND_ADD = 1,
    RLV_BLEND_SUBTRACT = 2,
    RLV_BLEND_MULTIPLY = 3,
    RLV_BLEND_SCREEN = 4,
    RLV_BLEND_OVERLAY = 5,
    RLV_BLEND_MAX = 6,
    RLV_BLEND_MIN = 7,
}

descriptor! {
    pub struct RlvLayerOptions {
        struct_size: u32,
        kind: u32,
        blend: u32,
        is_visible: u32,
        opacity: f32,
        tile_size: u32,
    }
}

descriptor! {
    pub struct RlvLayerInfo {
        struct_size: u32,
        id: u32,
        kind: u32,
        blend: u32,
        is_visible: u32,
        is_active: u32,
        opacity: f32,
        reserved: u32,
        tile_count: usize,
        name: [u8; RLV_LAYER_NAME_SIZE as usize],
    }
}

/// # Safety
/// `options` is a descriptor that starts with its size.
unsafe fn options_of(options: *const RlvLayerOptions) -> Result<(RlvLayerOptions, Settings)> {
    let none = RlvLayerOptions { struct_size: 0, kind: 0, blend: 0, is_visible: 0, opacity: 0.0, tile_size: 0 };
    // SAFETY: promised by the caller.
    let options = unsafe { read_descriptor(options, none) }?;
    let blend = Blend::NAMES.get(options.blend as usize).map(|(blend, _)| *blend).ok_or_else(|| {
        Error::invalid(format!("there is no blend mode {}", options.blend)).at("blend").advise("use 0 to 7")
    })?;
    Ok((options, Settings { opacity: options.opacity, blend, visible: options.is_visible != 0 }))
}

fn info_of(layer: &LayerInfo) -> RlvLayerInfo {
    RlvLayerInfo {
        struct_size: 0,
        id: layer.id,
        kind: if layer.kind.is_color() { RLV_LAYER_COLOR } else { RLV_LAYER_DISPLACEMENT },
        blend: layer.settings.blend as u32,
        is_visible: u32::from(layer.settings.visible),
        is_active: u32::from(layer.active),
        opacity: layer.settings.opacity,
        reserved: 0,
        tile_count: layer.tiles,
        name: fixed(&layer.name),
    }
}

/// Edits the layers of a detail, whatever its surface, and tells of what the budget refused.
macro_rules! edit {
    ($detail:expr, |$context:ident, $object:ident| $body:expr) => {{
        let detail = registry::get($detail)?;
        let mut editor = detail.edit()?;
        let $context = &detail.context.context;
        let refused: Result<Vec<u32>> = with_object!(&mut editor.object, $object => $body);
        let (refused, budget) = (refused?, editor.budget());
        // The log may call back.
        drop(editor);
        log_refusal(&detail, &refused, budget);
        Ok(())
    }};
}

fn layers_of(detail: RlvDetail) -> Result<Vec<LayerInfo>> {
    Ok(with_object!(&registry::get(detail)?.edit()?.object, object => object.layers()))
}

entry! {
    fn rlv_layer_count(detail: RlvDetail, count: *mut usize) {
        present("count", count)?;
        let layers = layers_of(detail)?.len();
        // SAFETY: checked above.
        unsafe { put(count, layers) };
        Ok(())
    }

    fn rlv_layer_info(detail: RlvDetail, index: usize, out: *mut RlvLayerInfo) {
        let layers = layers_of(detail)?;
        let layer = layers.get(index).ok_or_else(|| {
            Error::invalid(format!("there is no layer {index}")).at("index").advise(format!("there are {}", layers.len()))
        })?;
        // SAFETY: the caller gives NULL or a descriptor that starts with its size.
        unsafe { write_descriptor(out, info_of(layer)) }
    }

    fn rlv_layer_add(detail: RlvDetail, name: *const c_char, options: *const RlvLayerOptions, out: *mut u32) {
        present("out", out)?;
        // SAFETY: the caller gives a NUL-terminated text and a descriptor that starts with its size.
        let (name, (options, settings)) = unsafe { (text("name", name)?, options_of(options)?) };
        let kind = match options.kind {
            RLV_LAYER_DISPLACEMENT => Kind::Scalar,
            RLV_LAYER_COLOR => Kind::Rgba8,
            other => {
                return Err(Error::invalid(format!("there is no kind {other} of layers"))
                    .at("kind")
                    .advise("use RLV_LAYER_DISPLACEMENT or RLV_LAYER_COLOR"));
            }
        };
        let default = match registry::get(detail)?.view().layers {
            ViewKind::Tiles(_) => 128,
            ViewKind::Triangles(_) => 16,
        };
        let size = if options.tile_size == 0 { default } else { options.tile_size };
        let mut id = 0;
        let done: Result<()> = edit!(detail, |context, object| {
            object.add_layer(context, kind, name, settings, size).map(|(made, refused)| {
                id = made;
                refused
            })
        });
        done?;
        // SAFETY: checked above.
        unsafe { put(out, id) };
        Ok(())
    }

    fn rlv_layer_set(detail: RlvDetail, id: u32, options: *const RlvLayerOptions) {
        // SAFETY: the caller gives a descriptor that starts with its size.
        let (_, settings) = unsafe { options_of(options) }?;
        edit!(detail, |context, object| object.set_layer(context, id, settings))
    }

    fn rlv_layer_set_active(detail: RlvDetail, id: u32) {
        edit!(detail, |context, object| object.set_active_layer(context, id).map(|()| Vec::new()))
    }

    fn rlv_layer_rename(detail: RlvDetail, id: u32, name: *const c_char) {
        // SAFETY: the caller gives a NUL-terminated text.
        let name = unsafe { text("name", name) }?;
        edit!(detail, |_context, object| object.rename_layer(id, name).map(|()| Vec::new()))
    }

    fn rlv_layer_place(detail: RlvDetail, id: u32, place: usize) {
        edit!(detail, |context, object| object.place_layer(context, id, place))
    }

    fn rlv_layer_remove(detail: RlvDetail, id: u32) {
        edit!(detail, |context, object| object.remove_layer(context, id))
    }

    fn rlv_layer_merge(detail: RlvDetail, id: u32) {
        edit!(detail, |context, object| object.merge_layer(context, id))
    }

    fn rlv_layer_flatten(detail: RlvDetail) {
        edit!(detail, |context, object| object.flatten_layers(context))
    }
}
