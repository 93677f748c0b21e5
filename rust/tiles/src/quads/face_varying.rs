//! Face-varying attributes on a tessellation, subdivided rather than interpolated in straight lines.

use relievo_core::{Context, Domain, Error, Result, Values};
use relievo_surface::{Order, Place, Samples, Surface};

use crate::quads::tessellate::Tessellation;

impl Tessellation {
    /// Replaces the corner attribute `name`, which was carried from the cage, by its limit: what
    /// [`Surface::face_varying`] made of the same cage and attribute.
    ///
    /// # Errors
    /// Fails if there is no such attribute of up to three floats, or the limit has other tiles.
    pub fn smooth_attribute(&mut self, context: &Context, name: &str, limit: &Surface) -> Result<()> {
        let place = format!("attribute `{name}`");
        let attribute = self.mesh.attributes.iter_mut().find(|attribute| attribute.name == name);
        let attribute = attribute.ok_or_else(|| Error::invalid("there is no such attribute").at(place.clone()))?;
        let (Domain::Corner, Some(indices), 1..=3) = (attribute.domain, &attribute.indices, attribute.width) else {
            return Err(Error::invalid("only indexed corner attributes of up to three floats can be smooth").at(place));
        };
        let Values::F32(values) = &mut attribute.values else {
            return Err(Error::invalid("integers cannot be subdivided").at(place));
        };
        let width = attribute.width as usize;
        let mut places = vec![Place::default(); values.len() / width];
        for (corner, index) in indices.iter().enumerate() {
            let [u, v] = self.parameters[corner];
            places[*index as usize] = Place::new(self.tiles[corner / 3], u, v);
        }
        let mut samples = Samples::default();
        limit.evaluate(context, &places, Order::Position, &mut samples).map_err(|error| error.at(place))?;
        for (index, value) in values.chunks_exact_mut(width).enumerate() {
            for (axis, number) in value.iter_mut().enumerate() {
                *number = samples.p[axis][index];
            }
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use relievo_core::{Attribute, Mesh};
    use relievo_surface::SurfaceOptions;

    use super::*;
    use crate::{Displaced, Displacement, DisplacementOptions, uniform_rates};

    #[test]
    fn texture_coordinates_that_follow_the_cage_follow_the_surface() {
        let context = Context::serial();
        let points = (0..8).map(|i| [(i & 1) as f32, (i >> 1 & 1) as f32, (i >> 2 & 1) as f32]).collect();
        let corners = vec![0, 2, 3, 1, 4, 5, 7, 6, 0, 1, 5, 4, 2, 6, 7, 3, 0, 4, 6, 2, 1, 3, 7, 5];
        let mut cage = Mesh::new(points, vec![4; 6], corners);
        cage.attributes.push(Attribute {
            name: "uv".into(),
            domain: Domain::Corner,
            width: 2,
            values: Values::F32(cage.points.iter().flat_map(|p| [p[0] + p[2], p[1]]).collect()),
            indices: Some(cage.corners.clone()),
        });
        let options = SurfaceOptions::default();
        let surface = Surface::new(&context, &cage, &options).unwrap();
        let limit = Surface::face_varying(&context, &cage, "uv", &options).unwrap();
        let displacement = Displacement::new(surface.topology().clone(), &DisplacementOptions::default()).unwrap();
        let displaced = Displaced::new(&surface, displacement.field()).unwrap();
        let mut tessellation = displaced.tessellate(&context, &cage, &uniform_rates(surface.topology(), 8)).unwrap();
        tessellation.smooth_attribute(&context, "uv", &limit).unwrap();
        let mesh = &tessellation.mesh;
        mesh.check().unwrap();
        let uv = mesh.attribute("uv").unwrap();
        let (Values::F32(values), Some(indices)) = (&uv.values, &uv.indices) else { panic!("{uv:?}") };
        for (corner, index) in indices.iter().enumerate() {
            let p = mesh.points[mesh.corners[corner] as usize];
            let uv = &values[2 * *index as usize..][..2];
            assert!((uv[0] - p[0] - p[2]).abs() < 1e-5 && (uv[1] - p[1]).abs() < 1e-5, "{uv:?} at {p:?}");
        }
        assert!(tessellation.smooth_attribute(&context, "st", &limit).is_err());
    }
}
