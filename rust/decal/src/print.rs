//! Decals written into the layers of a surface (the paper's Section 6).
//!
//! The decal lies on a tessellation of the surface, whose corners have their tile and parameters: so each face has a chart
//! among the texels of its tile. Tiles are allocated where the decal lies. An edit goes to the active layer of its kind, as
//! strokes do. Units: object units for displacement, linear Rec.709 for colour. Vector
//! displacement has no layers: it is changed itself.

pub(crate) mod applied;
pub(crate) mod buckets;
pub(crate) mod coverage;
pub(crate) mod printable;
pub(crate) mod recipe;
pub(crate) mod texels;
pub(crate) mod texture;
pub(crate) mod triangle_print;

use glam::{DVec3, Vec4};
use half::f16;
use relievo_core::{Context, Error, Result};
use relievo_detail::{DisplacedObject, LayeredObject};
use relievo_document::{Blend, Kind, Settings};
use relievo_render::color::luminance;
use relievo_tiles::{Channel, ColorTexel, Layered, Sets, Tessellation, Texel, Vector, by_format};

use crate::artwork::Artwork;
use crate::decal::Decal;
use crate::map::energy::Vec2;
use crate::print::texels::{Chart, Window, draw};

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

/// A decal with its image and the surface that it lies on, to be written into layers.
pub struct Print<'a> {
    /// Runs the work.
    pub context: &'a Context,
    /// The tessellation of the object's surface that the decal lies on.
    pub tessellation: &'a Tessellation,
    /// The decal.
    pub decal: &'a Decal,
    /// Its image.
    pub artwork: &'a Artwork,
    /// Depths of the pins, as for [`draw`].
    pub depths: &'a [f64],
}

/// Paints a decal over the colours of an object: over the active layer of colour. `tessellation` is the one of the
/// object's surface that the decal lies on; `depths` are as for [`draw`].
///
/// # Errors
/// As [`Print::paint`].
pub fn paint(
    context: &Context,
    object: &mut DisplacedObject,
    tessellation: &Tessellation,
    decal: &Decal,
    artwork: &Artwork,
    depths: &[f64],
    opacity: f32,
) -> Result<Printed> {
    let settings = Settings { opacity, ..Settings::of(Kind::Rgba8) };
    Print { context, tessellation, decal, artwork, depths }.paint(object, &settings)
}

/// Raises the displacement of an object by a decal: by `height` where the image is white and opaque, not where it is black
/// or transparent. Otherwise as [`paint`].
///
/// # Errors
/// As [`Print::emboss`].
pub fn emboss(
    context: &Context,
    object: &mut DisplacedObject,
    tessellation: &Tessellation,
    decal: &Decal,
    artwork: &Artwork,
    depths: &[f64],
    height: f32,
) -> Result<Printed> {
    Print { context, tessellation, decal, artwork, depths }.emboss(object, height, &Settings::of(Kind::Scalar))
}

/// Fails unless a height is one that layers can hold.
pub(crate) fn check_height(height: f32) -> Result<()> {
    if (-60000.0..=60000.0).contains(&height) {
        return Ok(());
    }
    Err(Error::invalid(format!("the height is {height}")).at("decal").advise("use object units from -60000 to 60000"))
}

/// Returns what vectors of a decal are multiplied by: a height with the opacity and the sign of the blend mode.
///
/// # Errors
/// The height or the opacity is out of range, or the blend mode neither adds nor subtracts.
pub(crate) fn signed_height(height: f32, settings: &Settings) -> Result<f32> {
    check_height(height)?;
    settings.check(Kind::Vector).map_err(|error| error.at("decal"))?;
    match settings.blend {
        Blend::Add => Ok(settings.opacity * height),
        Blend::Subtract => Ok(-settings.opacity * height),
        _ => Err(Error::unsupported(format!("vectors have no blend mode `{}`", settings.blend.name()))
            .at("decal")
            .advise("use add or subtract")),
    }
}

/// Fails unless an opacity is in 0 to 1.
pub fn check_opacity(opacity: f32) -> Result<()> {
    if (0.0..=1.0).contains(&opacity) {
        return Ok(());
    }
    Err(Error::invalid(format!("the opacity is {opacity}")).at("decal").advise("use 0 to 1"))
}

/// A displacement that is raised by `height` times the luminance of a premultiplied colour that is not transparent.
pub fn raised(old: f16, color: [f32; 4], height: f32, settings: &Settings) -> f16 {
    let [red, green, blue, alpha] = color;
    let relief = height * luminance([red, green, blue]) / alpha;
    let settings = Settings { opacity: settings.opacity * alpha, ..*settings };
    f16::of_sum(f16::blend(old.sum(), relief, &settings))
}

impl Print<'_> {
    /// Puts the decal on the texels of the active layer of colour, with the blend mode and opacity of `settings`.
    ///
    /// # Errors
    /// The object has no colours, or the active layer cannot be seen; the opacity is not in 0 to 1 or the blend mode not for
    /// colours; or the decal lies on another mesh. Nothing is changed then.
    pub fn paint(&self, object: &mut DisplacedObject, settings: &Settings) -> Result<Printed> {
        settings.check(Kind::Rgba8).map_err(|error| error.at("decal"))?;
        let mut paint = object.take_paint()?;
        let done = by_format!(&mut paint, stack => self.over(stack.active_mut(), settings));
        object.put_paint(paint);
        let mut done = done?;
        done.refuse(object.settle(self.context)?);
        Ok(done)
    }

    /// Puts a relief on the displacement: `height`, in object units, times the luminance of the image, with the blend mode of
    /// `settings`, and their opacity times the alpha of the image.
    ///
    /// # Errors
    /// As [`Self::paint`]; the height is not in -60000 to 60000.
    pub fn emboss(&self, object: &mut DisplacedObject, height: f32, settings: &Settings) -> Result<Printed> {
        check_height(height)?;
        settings.check(Kind::Scalar).map_err(|error| error.at("decal"))?;
        let mut done = self.write(object.displacement_mut(), |old, color, _| raised(old, color, height, settings))?;
        done.refuse(object.settle(self.context)?);
        Ok(done)
    }

    /// Adds vectors to the vector displacement: `height`, in object units, times the colour of the image, where 0 means -1,
    /// 0.5 means 0 and 1 means 1, times the alpha of the image. Red points to the right of the image on the surface, green
    /// upwards, blue along the normal. `settings` can add or subtract, with an opacity.
    ///
    /// # Errors
    /// The object has no vector displacement; the blend mode is another one; or as [`Self::emboss`].
    pub fn displace(&self, object: &mut DisplacedObject, height: f32, settings: &Settings) -> Result<Printed> {
        let height = signed_height(height, settings)?;
        let vectors = object.vectors_mut().ok_or_else(|| {
            Error::invalid("the object has no vector displacement").at("decal").advise("give it some first")
        })?;
        self.write(vectors, |old: Vector, [red, green, blue, alpha], [cos, sin]| {
            // Colours are premultiplied.
            let [right, up, out] = [red, green, blue].map(|value| f64::from(height * (2.0 * value - alpha)));
            let added = DVec3::new(cos * right - sin * up, sin * right + cos * up, out);
            Vector::nearest(old.value() + added)
        })
    }

    fn over<T: ColorTexel + Layered<Sum = Vec4>>(
        &self,
        paint: &mut Channel<T>,
        settings: &Settings,
    ) -> Result<Printed> {
        self.write(paint, |old: T, color, _| T::of_sum(T::blend(old.sum(), Vec4::from(color), settings)))
    }

    /// Changes the texels under the decal: `change` makes a new texel of an old one, a colour and a turn
    /// ([`Window::turns`]).
    fn write<T: Texel>(
        &self,
        channel: &mut Channel<T>,
        change: impl Fn(T, [f32; 4], Vec2) -> T + Sync,
    ) -> Result<Printed> {
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
                let columns = window.size[0] as usize;
                let rows = window.colors.chunks_exact(columns).zip(window.turns.chunks_exact(columns));
                for (row, (colors, turns)) in (window.first[1] as usize..).zip(rows) {
                    let texels = &mut block.row_mut(row)[window.first[0] as usize..];
                    for (texel, (color, turn)) in texels.iter_mut().zip(colors.iter().zip(turns)) {
                        if color[3] > 0.0 {
                            *texel = change(*texel, *color, *turn);
                        }
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
    pub(crate) fn refuse(&mut self, tiles: Vec<u32>) {
        self.refused.extend(tiles);
        self.refused.sort_unstable();
        self.refused.dedup();
    }
}
