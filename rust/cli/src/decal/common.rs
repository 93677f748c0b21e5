//! What the tasks of `relievo decal` share: the mesh, the sticker and its pins, read and laid.

use std::path::PathBuf;

use relievo_core::{Context, Error, Mesh, Result};
use relievo_decal::{
    Contour, Decal, DecalSettings, Pin, Place, Pose, Quality, Sticker, lay, nearest, strip, triangulated,
};
use relievo_render::{Image, read_image};
use serde_json::{Value, json};

use super::picture;
use crate::args::limits::Limits;
use crate::args::numbers::numbers;
use crate::bar::Bar;

/// The mesh, the sticker and its pins.
#[derive(clap::Args)]
pub struct Common {
    /// The mesh: OBJ, PLY, GLB, glTF, USD, STL or OFF.
    pub file: PathBuf,
    /// The image, a PNG or EXR file; transparent parts belong to the sticker as well.
    #[arg(long, value_name = "FILE", required_unless_present = "size")]
    pub image: Option<PathBuf>,
    /// The size of the image in pixels, WIDTHxHEIGHT, where there is no file.
    #[arg(long, value_name = "PIXELS", value_parser = crate::args::numbers::pixels, conflicts_with = "image")]
    pub size: Option<[u32; 2]>,
    /// A pin: a point of the image in pixels from its upper left corner, and the point of space whose nearest place on the
    /// mesh it belongs to. May be repeated.
    #[arg(long = "pin", value_name = "X,Y@X,Y,Z", value_parser = pin, required_unless_present = "along", allow_hyphen_values = true)]
    pub pins: Vec<Pair>,
    /// Points of space whose nearest places on the mesh are a curve: the middle line of the image lies along it, in place of
    /// pins.
    #[arg(long, value_name = "X,Y,Z X,Y,Z ...", value_parser = curve, conflicts_with = "pins", allow_hyphen_values = true)]
    pub along: Option<Line>,
    /// The outline of the sticker in pixels from the upper left corner, corner after corner; left out, the whole image.
    #[arg(long, value_name = "X,Y X,Y ...", value_parser = outline, allow_hyphen_values = true)]
    pub outline: Option<Corners>,
    /// Cut the sticker out along the contour at which the alpha of the image has this value, above 0 and below 1.
    #[arg(long, value_name = "ALPHA", conflicts_with = "outline")]
    pub contour: Option<f64>,
    /// How far the outline may be from the contour, in pixels.
    #[arg(long, value_name = "PIXELS", default_value_t = Contour::default().tolerance, requires = "contour")]
    pub tolerance: f64,
    /// With one pin: the width of the whole image on the mesh.
    #[arg(long, value_name = "LENGTH")]
    pub width: Option<f64>,
    /// With one pin: the direction in space that is up in the image.
    #[arg(long, value_name = "X,Y,Z", value_parser = numbers::<3>, default_value = "0,1,0", allow_hyphen_values = true)]
    pub up: [f64; 3],
    /// Let the sticker lie on itself, as around a finger.
    #[arg(long)]
    pub overlap: bool,
    /// A picture of the decal on the mesh: .png.
    #[arg(long, value_name = "FILE")]
    pub picture: Option<PathBuf>,
    /// What the picture shows of the decal.
    #[arg(long, value_enum, default_value = "checker")]
    pub show: picture::Show,
    /// Print JSON for programs.
    #[arg(long)]
    pub json: bool,
    #[command(flatten)]
    pub limits: Limits,
}

/// What lies on top where a sticker overlaps itself.
#[derive(clap::Args)]
pub struct Depths {
    /// The depth of a pin, one for each in their order: where the sticker overlaps itself, the part near pins of larger
    /// depths lies on top.
    #[arg(long = "depth", value_name = "NUMBER", allow_hyphen_values = true)]
    pub depths: Vec<f64>,
}

/// A point of the image and a point of space.
#[derive(Clone, Copy, Debug)]
pub struct Pair {
    pub image: [f64; 2],
    pub space: [f64; 3],
}

#[derive(Clone, Debug)]
pub struct Corners(pub Vec<[f64; 2]>);

/// Points of space along a curve.
#[derive(Clone, Debug)]
pub struct Line(pub Vec<[f64; 3]>);

pub fn pin(text: &str) -> std::result::Result<Pair, String> {
    let (image, space) = text.split_once('@').ok_or_else(|| format!("{text:?} has no @ between image and mesh"))?;
    Ok(Pair { image: numbers(image)?, space: numbers(space)? })
}

pub fn outline(text: &str) -> std::result::Result<Corners, String> {
    Ok(Corners(text.split_whitespace().map(numbers::<2>).collect::<std::result::Result<_, _>>()?))
}

pub fn curve(text: &str) -> std::result::Result<Line, String> {
    Ok(Line(text.split_whitespace().map(numbers::<3>).collect::<std::result::Result<_, _>>()?))
}

/// A decal with what it lies on.
pub struct Laid {
    pub context: Context,
    pub mesh: Mesh,
    pub image: Option<Image>,
    pub size: [u32; 2],
    pub sticker: Sticker,
    pub decal: Decal,
    pub pins: Vec<Pin>,
    pub pose: Option<Pose>,
    pub settings: DecalSettings,
    /// The length of the curve of a strip.
    pub length: Option<f64>,
}

impl Laid {
    /// The height of the image for each unit of its width.
    pub fn ratio(&self) -> f64 {
        f64::from(self.size[1]) / f64::from(self.size[0])
    }
}

impl Common {
    pub fn place(&self) -> String {
        self.file.display().to_string()
    }

    /// Lays the sticker on the triangles of the mesh.
    pub fn lay(&self) -> Result<Laid> {
        let context = self.limits.context()?;
        let mesh = triangulated(&relievo_meshio::read(&context, &self.file)?);
        self.lay_on(context, mesh)
    }

    /// Lays the sticker on a mesh of triangles.
    pub fn lay_on(&self, context: Context, mesh: Mesh) -> Result<Laid> {
        let image = self.image.as_deref().map(|file| read_image(file, context.memory_limit())).transpose()?;
        let size = match (&image, self.size) {
            (Some(image), _) => [image.width(), image.height()],
            (None, Some(size)) => size,
            (None, None) => {
                return Err(Error::invalid("the size of the image is missing").advise("give --image or --size"));
            }
        };
        let height = f64::from(size[1]);
        let upward = |[x, y]: [f64; 2]| [x, height - y];
        let sticker = match (&self.outline, self.contour, &image) {
            (Some(Corners(corners)), ..) => Sticker::new(size, corners.iter().copied().map(upward).collect())?,
            (None, Some(level), Some(image)) => {
                let contour = Contour { level, tolerance: self.tolerance };
                Sticker::of_alpha(image, &contour)?
            }
            (None, Some(_), None) => {
                return Err(Error::invalid("there is no image whose alpha has a contour").advise("give --image"));
            }
            (None, None, _) => Sticker::whole(size)?,
        };
        let place = |index: usize, space: [f64; 3]| -> Result<Place> {
            let found = nearest(&mesh, space).map_err(|error| error.at(format!("pin {index}")).at(self.place()))?;
            Ok(found.0)
        };
        let (pins, length): (Vec<Pin>, _) = match &self.along {
            Some(Line(points)) => {
                let places = points.iter().enumerate().map(|(index, point)| place(index, *point));
                let strip = strip(&mesh, &sticker, &places.collect::<Result<Vec<_>>>()?)?;
                (strip.pins, Some(strip.length))
            }
            None => {
                let pairs = self.pins.iter().enumerate();
                let pin = |(index, pair): (usize, &Pair)| {
                    Ok(Pin { image: upward(pair.image), place: place(index, pair.space)? })
                };
                (pairs.map(pin).collect::<Result<_>>()?, None)
            }
        };
        let pose = self.width.map(|width| Pose { width, up: self.up });
        let settings = DecalSettings { overlap: self.overlap, ..DecalSettings::default() };
        let decal =
            lay(&mesh, &sticker, &pins, pose, &settings, &mut Bar::new()).map_err(|error| error.at(self.place()))?;
        Ok(Laid { context, mesh, image, size, sticker, decal, pins, pose, settings, length })
    }

    /// Writes the picture, if one is wanted. `depths` are those of the pins, or none.
    pub fn draw(&self, laid: &Laid, depths: &[f64]) -> Result<()> {
        match &self.picture {
            Some(file) => picture::draw(laid, depths, self.show, file),
            None => Ok(()),
        }
    }
}

/// The distortion, one number a line.
pub fn described(quality: &Quality) -> String {
    let Quality {
        l2,
        l_infinity,
        worst_angle,
        area_ratio,
        flips,
        turned_twice,
        overlaps,
        coverage,
        doubled,
        triangles,
    } = quality;
    format!(
        "triangles              {triangles}\ncovered                {:.2} % of the sticker\n\
         covered twice          {:.2} % of the sticker\nL2 stretch             {l2:.6}\nL-infinity stretch     {l_infinity:.4}\n\
         worst angle            {:.2} degrees\narea ratio             {area_ratio:.4}\nflipped triangles      {flips}\n\
         turned twice           {turned_twice} vertices\noverlapped faces       {overlaps}\n",
        100.0 * coverage,
        100.0 * doubled,
        worst_angle.to_degrees()
    )
}

pub fn machine_readable(common: &Common, laid: &Laid) -> Value {
    let quality = &laid.decal.quality;
    let mut value = json!({
        "file": common.place(),
        "pins": laid.decal.pins.len(),
        "triangles": quality.triangles,
        "l2": quality.l2,
        "l_infinity": quality.l_infinity,
        "worst_angle": quality.worst_angle,
        "area_ratio": quality.area_ratio,
        "flips": quality.flips,
        "turned_twice": quality.turned_twice,
        "overlaps": quality.overlaps,
        "coverage": quality.coverage,
        "doubled": quality.doubled,
    });
    if let Some(length) = laid.length {
        value["length"] = json!(length);
    }
    value
}
