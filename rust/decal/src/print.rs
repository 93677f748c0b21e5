//! Decals written into the layers of a surface (the paper's Section 6).
//!
//! The decal lies on a tessellation of the surface, whose corners have their tile and parameters: so each face has a chart
//! among the texels of its tile. Tiles are allocated where the decal lies. An edit goes to the active layer of its kind, as
//! strokes do. Units: object units for displacement, linear Rec.709 for colour.

use glam::Vec4;
use half::f16;
use relievo_core::{Context, Error, Result};
use relievo_detail::{DisplacedObject, LayeredObject};
use relievo_tiles::{Channel, ColorTexel, Sets, Tessellation, Texel, by_format};

use crate::artwork::Artwork;
use crate::decal::Decal;
use crate::texels::{Chart, Window, draw};

/// What writing a decal changed.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Printed {
    /// Tiles of which texels changed, ascending.
    pub tiles: Vec<u32>,
    /// Texels under the sticker.
    pub texels: u64,
    /// Tiles that the budget refused, ascending: the sticker is missing there.
    pub refused: Vec<u32>,
}

/// Paints a decal over the colours of an object: over the active layer of colour. `tessellation` is the one of the
/// object's surface that the decal lies on; `depths` are as for [`draw`].
///
/// # Errors
/// The object has no colours, or the active layer cannot be seen; the opacity is not in 0 to 1; or the decal lies on
/// another mesh. Nothing is changed then.
pub fn paint(
    context: &Context,
    object: &mut DisplacedObject,
    tessellation: &Tessellation,
    decal: &Decal,
    artwork: &Artwork,
    depths: &[f64],
    opacity: f32,
) -> Result<Printed> {
    check_opacity(opacity)?;
    let source = Source { context, tessellation, decal, artwork, depths };
    let mut paint = object.take_paint()?;
    let done = by_format!(&mut paint, paint => source.over(paint, opacity));
    object.put_paint(paint);
    let mut done = done?;
    done.refuse(object.settle(context)?);
    Ok(done)
}

/// Raises the displacement of an object by a decal: by `height` where the image is white and opaque, not where it is black
/// or transparent. Otherwise as [`paint`].
///
/// # Errors
/// As [`paint`]; the height is not finite.
pub fn emboss(
    context: &Context,
    object: &mut DisplacedObject,
    tessellation: &Tessellation,
    decal: &Decal,
    artwork: &Artwork,
    depths: &[f64],
    height: f32,
) -> Result<Printed> {
    if !(-60000.0..=60000.0).contains(&height) {
        return Err(Error::invalid(format!("the height is {height}"))
            .at("decal")
            .advise("use object units from -60000 to 60000"));
    }
    let source = Source { context, tessellation, decal, artwork, depths };
    let mut done = source.write(object.displacement_mut(), |old: f16, [red, green, blue, _]| {
        // The luminance of Rec.709; colours are premultiplied.
        f16::from_f32(old.to_f32() + height * (0.2126 * red + 0.7152 * green + 0.0722 * blue))
    })?;
    done.refuse(object.settle(context)?);
    Ok(done)
}

/// Fails unless an opacity is in 0 to 1.
pub fn check_opacity(opacity: f32) -> Result<()> {
    if (0.0..=1.0).contains(&opacity) {
        return Ok(());
    }
    Err(Error::invalid(format!("the opacity is {opacity}")).at("decal").advise("use 0 to 1"))
}

/// A decal with its image and the surface that it lies on.
struct Source<'a> {
    context: &'a Context,
    tessellation: &'a Tessellation,
    decal: &'a Decal,
    artwork: &'a Artwork,
    depths: &'a [f64],
}

impl Source<'_> {
    fn over<T: ColorTexel>(&self, paint: &mut Channel<T>, opacity: f32) -> Result<Printed> {
        self.write(paint, |old: T, color| {
            let color = opacity * Vec4::from(color);
            T::of_color(color + (1.0 - color.w) * old.color())
        })
    }

    /// Changes the texels under the decal: `change` makes a new texel of an old one and a colour.
    fn write<T: Texel>(&self, channel: &mut Channel<T>, change: impl Fn(T, [f32; 4]) -> T + Sync) -> Result<Printed> {
        let windows = self.windows(channel)?;
        let mut tiles: Vec<u32> = windows.iter().map(|window| window.target).collect();
        tiles.dedup();
        let applied = channel.apply(&Sets { allocate: tiles.clone(), modify: tiles.clone(), ..Sets::default() })?;
        let mut printed = Printed::default();
        printed.refuse(applied.refused);
        tiles.retain(|tile| printed.refused.binary_search(tile).is_err());
        let mut changes = channel.edit(self.context, &tiles, |tile, block| {
            let first = windows.partition_point(|window| window.target < tile);
            for window in windows[first..].iter().take_while(|window| window.target == tile) {
                let rows = window.colors.chunks_exact(window.size[0] as usize);
                for (row, colors) in (window.first[1] as usize..).zip(rows) {
                    let texels = &mut block.row_mut(row)[window.first[0] as usize..];
                    for (texel, color) in texels.iter_mut().zip(colors).filter(|(_, color)| color[3] > 0.0) {
                        *texel = change(*texel, *color);
                    }
                }
            }
        })?;
        let written = windows.iter().filter(|window| tiles.binary_search(&window.target).is_ok());
        let covered = written.map(|window| window.colors.iter().filter(|color| color[3] > 0.0).count() as u64);
        printed.texels = covered.sum();
        printed.tiles = changes.iter().map(|change| change.tile).collect();
        changes.extend(applied.changes);
        printed.refuse(channel.settle(self.context, &changes)?);
        Ok(printed)
    }

    fn windows<T: Texel>(&self, channel: &Channel<T>) -> Result<Vec<Window>> {
        let field = channel.field();
        let Tessellation { mesh, tiles, parameters } = self.tessellation;
        let mut charts = Vec::with_capacity(tiles.len());
        for (tile, corners) in tiles.iter().zip(parameters.as_chunks::<3>().0) {
            if *tile as usize >= field.tile_count() {
                return Err(Error::invalid("the tessellation is that of another surface")
                    .at("decal")
                    .advise("tessellate the surface of the object, and lay the sticker on that mesh"));
            }
            let size = f64::from(field.size(*tile));
            charts.push(Chart { target: *tile, corners: corners.map(|uv| uv.map(|value| f64::from(value) * size)) });
        }
        draw(self.context, mesh, &charts, &|tile| [field.size(tile); 2], self.decal, self.artwork, self.depths)
    }
}

impl Printed {
    fn refuse(&mut self, tiles: Vec<u32>) {
        self.refused.extend(tiles);
        self.refused.sort_unstable();
        self.refused.dedup();
    }
}
