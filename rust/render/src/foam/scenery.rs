//! Passes 1 and 2: depths of solids and of the fluid, of our ray caster or of a file.

use relievo_core::{Error, Result};

use super::projection::FoamView;
use crate::image::Image;

/// Depths of what stands about foam, in metres along the direction of view. What is not finite or not above 0 counts as
/// nothing there.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Scenery {
    /// Depth of the nearest solid of each pixel; `None` if there are no solids.
    pub solids: Option<Image>,
    /// Depth of the nearest surface of the fluid of each pixel; `None` if there is no fluid.
    pub fluid: Option<Image>,
}

/// Depths of all pixels, row after row.
#[derive(Debug)]
pub struct Depths {
    pub solids: Vec<f32>,
    pub fluid: Vec<f32>,
}

impl Scenery {
    /// Returns the depths as lists, infinite where nothing is. Fails if a picture has another size than the view.
    pub(super) fn depths(&self, view: &FoamView) -> Result<Depths> {
        Ok(Depths { solids: list(&self.solids, view, "solids")?, fluid: list(&self.fluid, view, "fluid")? })
    }
}

fn list(image: &Option<Image>, view: &FoamView, name: &str) -> Result<Vec<f32>> {
    let Some(image) = image else { return Ok(vec![f32::INFINITY; view.pixels()]) };
    let [width, height] = [image.width(), image.height()];
    if (width, height) != (view.width, view.height) {
        return Err(Error::invalid(format!(
            "the depths have {width} × {height} pixels, and the view {} × {}",
            view.width, view.height
        ))
        .at(name)
        .advise("render the depths in the size of the picture"));
    }
    let depths = image.data().iter().step_by(image.channels() as usize);
    Ok(depths.map(|depth| if *depth > 0.0 { *depth } else { f32::INFINITY }).collect())
}
