//! Meshes that come back from a device.

use relievo_core::Result;

use super::hierarchy::Vertex;
use super::level::DeviceLevel;
use crate::connectivity::NONE;
use crate::progressive::files::packing::Normal;
use crate::progressive::mesh::active::Extract;

impl DeviceLevel {
    /// Waits for what was submitted. Returns how many vertices, triangles and wedges there are, of which some may be of no
    /// triangle.
    ///
    /// # Errors
    /// Fails where the device is lost or has no memory.
    pub fn counts(&self) -> Result<[usize; 3]> {
        let device = &self.hierarchy.device;
        let mut frame = device.frame()?;
        let arguments = frame.read(self.arguments(), 0..7)?;
        let _ = frame.submit()?;
        let arguments = arguments.get(device)?;
        Ok([arguments[5] as usize, arguments[0] as usize / 3, arguments[6] as usize])
    }

    /// Waits for what was submitted. Returns the mesh as [`ActiveMesh::extract`](crate::progressive::ActiveMesh::extract).
    ///
    /// # Errors
    /// Fails where the device is lost or has no memory.
    pub fn extract(&self) -> Result<Extract> {
        let device = &self.hierarchy.device;
        let [vertices, triangles, wedges] = self.counts()?;
        let mut frame = device.frame()?;
        let places = frame.read(self.vertices(), 0..vertices)?;
        let corners = frame.read(self.indices(), 0..3 * triangles)?;
        let _ = frame.submit()?;
        let (mut places, mut corners) = (places.get(device)?, corners.get(device)?);
        let numbers = &self.hierarchy.numbers;
        if vertices == numbers.len() && !numbers.contains(&NONE) {
            let by_leaf = std::mem::take(&mut places);
            places.resize(vertices, Vertex::default());
            by_leaf.iter().zip(numbers).for_each(|(vertex, number)| places[*number as usize] = *vertex);
            corners.iter_mut().for_each(|corner| *corner = numbers[*corner as usize]);
        }
        let mut made = Extract {
            points: places.iter().map(|[x, y, z, _]| [*x, *y, *z].map(f32::from_bits)).collect(),
            normals: places.iter().map(|[_, _, _, normal]| Normal(*normal).vector().to_array()).collect(),
            triangles: corners.as_chunks::<3>().0.to_vec(),
            ..Extract::default()
        };
        if let Some(own) = &self.wedges {
            own.extract(device, [wedges, triangles], &mut made)?;
        }
        Ok(made)
    }
}
