//! Brushes; see `include/relievo/brush.h`.

use std::sync::{OnceLock, RwLock};

use relievo_core::{Error, Result};
use relievo_detail::stamp::StampSettings;
use relievo_detail::{
    Action, Curve, Falloff, PaintMode, SculptMode, Stamp, StampChannel, StampImage, Stroke, StrokeSettings,
};

use crate::border::array::{Input, present, put};
use crate::border::descriptor::{numbered, read_descriptor};
use crate::border::registry::{self, handle, try_write};
use crate::runtime::context::RlvContext;
use crate::runtime::parameter::{RlvParameter, Table, settings, write_table};

handle!(RlvBrush, 8, BrushObject);

settings!(RlvBrushSettings, StrokeSettings);
settings!(RlvStampSettings, StampSettings);

constants! {
    u32:
    RLV_BRUSH_PAINT = 0,
    RLV_BRUSH_SCULPT = 1,
    RLV_PAINT_MIX = 0,
    RLV_PAINT_ADD = 1,
    RLV_PAINT_MULTIPLY = 2,
    RLV_PAINT_ERASE = 3,
    RLV_PAINT_BLUR = 4,
    RLV_PAINT_SMEAR = 5,
    RLV_SCULPT_DRAW = 0,
    RLV_SCULPT_SMOOTH = 1,
    RLV_SCULPT_FLATTEN = 2,
    RLV_SCULPT_ERASE = 3,
    RLV_SCULPT_CLAY = 4,
    RLV_SCULPT_SCRAPE = 5,
    RLV_SCULPT_LAYER = 6,
    RLV_SCULPT_INFLATE = 7,
    RLV_SCULPT_PINCH = 8,
    RLV_SCULPT_VECTOR = 9,
    RLV_FALLOFF_CONSTANT = 0,
    RLV_FALLOFF_LINEAR = 1,
    RLV_FALLOFF_SMOOTH = 2,
    RLV_FALLOFF_SPHERE = 3,
    RLV_FALLOFF_GAUSSIAN = 4,
    RLV_CURVE_SIZE = 0,
    RLV_CURVE_STRENGTH = 1,
    RLV_CURVE_ANGLE = 2,
}

descriptor! {
    pub struct RlvBrushOptions {
        struct_size: u32,
        action: u32,
        mode: u32,
        falloff: u32,
        color: [f32; 4],
        height: f32,
        reserved: u32,
    }
}

descriptor! {
    pub struct RlvStampOptions {
        struct_size: u32,
        channel: u32,
        width: u32,
        height: u32,
        channels: u32,
        reserved: u32,
        pixels: *const f32,
    }
}

/// A brush: a stroke without points.
pub struct BrushObject {
    pub stroke: RwLock<Stroke>,
}

impl RlvBrushOptions {
    fn stroke(&self, settings: StrokeSettings) -> Result<Stroke> {
        let action = match self.action {
            RLV_BRUSH_PAINT => {
                Action::Paint { mode: numbered("mode", &PaintMode::NAMES, self.mode)?, color: self.color }
            }
            RLV_BRUSH_SCULPT => {
                Action::Sculpt { mode: numbered("mode", &SculptMode::NAMES, self.mode)?, height: self.height }
            }
            other => {
                return Err(Error::invalid(format!("there is no action {other}"))
                    .at("action")
                    .advise("use RLV_BRUSH_PAINT or RLV_BRUSH_SCULPT"));
            }
        };
        let falloff = numbered("falloff", &Falloff::NAMES, self.falloff)?;
        let stroke = Stroke::new(Vec::new(), settings, falloff, action);
        stroke.check_brush()?;
        Ok(stroke)
    }
}

entry! {
    fn rlv_brush_params(params: *mut *const RlvParameter, count: *mut usize) {
        static TABLE: OnceLock<Table> = OnceLock::new();
        // SAFETY: the caller gives pointers to which a value may be written, or NULL.
        unsafe { write_table(&TABLE, StrokeSettings::PARAMETERS, params, count) }
    }

    fn rlv_brush_stamp_params(params: *mut *const RlvParameter, count: *mut usize) {
        static TABLE: OnceLock<Table> = OnceLock::new();
        // SAFETY: the caller gives pointers to which a value may be written, or NULL.
        unsafe { write_table(&TABLE, StampSettings::PARAMETERS, params, count) }
    }

    fn rlv_brush_create(context: RlvContext, options: *const RlvBrushOptions, settings: *const RlvBrushSettings, out: *mut RlvBrush) {
        present("out", out)?;
        registry::get(context)?;
        let none = RlvBrushOptions {
            struct_size: 0, action: 0, mode: 0, falloff: 0, color: [0.0; 4], height: 0.0, reserved: 0,
        };
        // SAFETY: the caller gives descriptors that start with their size, or NULL for the settings.
        let (options, settings) = unsafe { (read_descriptor(options, none)?, RlvBrushSettings::read(settings)?) };
        let stroke = RwLock::new(options.stroke(settings)?);
        let handle = registry::insert(BrushObject { stroke })?;
        // SAFETY: checked above.
        unsafe { put(out, handle) };
        Ok(())
    }

    fn rlv_brush_retain(brush: RlvBrush) {
        registry::retain(brush)
    }

    fn rlv_brush_release(brush: RlvBrush) {
        registry::release(brush)
    }

    fn rlv_brush_set(brush: RlvBrush, options: *const RlvBrushOptions, settings: *const RlvBrushSettings) {
        let brush = registry::get(brush)?;
        let none = RlvBrushOptions {
            struct_size: 0, action: 0, mode: 0, falloff: 0, color: [0.0; 4], height: 0.0, reserved: 0,
        };
        // SAFETY: the caller gives descriptors that start with their size, or NULL for the settings.
        let (options, settings) = unsafe { (read_descriptor(options, none)?, RlvBrushSettings::read(settings)?) };
        let made = options.stroke(settings)?;
        let mut stroke = try_write(&brush.stroke, "brush")?;
        let (stamp, curves) = (stroke.stamp.take(), std::mem::take(&mut stroke.curves));
        *stroke = Stroke { stamp, curves, ..made };
        Ok(())
    }

    fn rlv_brush_set_curve(brush: RlvBrush, curve: u32, points: *const f64, count: usize) {
        let brush = registry::get(brush)?;
        // SAFETY: the caller promises `count` pairs.
        let points = unsafe { Input::new("points", points.cast::<[f64; 2]>(), count, 0) }?;
        let made = if count == 0 { Curve::default() } else { Curve::new(points.iter().collect())? };
        let mut stroke = try_write(&brush.stroke, "brush")?;
        match curve {
            RLV_CURVE_SIZE => stroke.curves.size = made,
            RLV_CURVE_STRENGTH => stroke.curves.strength = made,
            RLV_CURVE_ANGLE => stroke.curves.angle = made,
            other => return Err(Error::invalid(format!("there is no curve {other}")).at("curve").advise("use 0 to 2")),
        }
        Ok(())
    }

    fn rlv_brush_set_stamp(brush: RlvBrush, options: *const RlvStampOptions, settings: *const RlvStampSettings) {
        let brush = registry::get(brush)?;
        let mut stroke = try_write(&brush.stroke, "brush")?;
        if options.is_null() {
            stroke.stamp = None;
            return Ok(());
        }
        let none = RlvStampOptions {
            struct_size: 0, channel: 0, width: 0, height: 0, channels: 0, reserved: 0, pixels: std::ptr::null(),
        };
        // SAFETY: the caller gives descriptors that start with their size, or NULL for the settings.
        let (options, settings) = unsafe { (read_descriptor(options, none)?, RlvStampSettings::read(settings)?) };
        StampImage::check_size(options.width, options.height, options.channels)?;
        let count = options.width as usize * options.height as usize * options.channels as usize;
        // SAFETY: the caller promises `width` × `height` × `channels` numbers, which were found to be a possible image.
        let pixels = unsafe { Input::new("pixels", options.pixels, count, 0) }?;
        let pixels: Vec<f32> = pixels.iter().collect();
        let image = StampImage::new(options.width, options.height, options.channels, &pixels)?;
        let channel = numbered("channel", &StampChannel::NAMES, options.channel)?;
        stroke.stamp = Some(Stamp::new(image, settings, channel)?);
        Ok(())
    }
}
