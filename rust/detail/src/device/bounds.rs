//! The bounds of points along three axes, reduced on a graphics device (`shaders/imprint_bounds.wgsl`): the box of a mesh
//! that is animated there.

use std::sync::Arc;

use bytemuck::{Pod, Zeroable};
use glam::{DMat3, DVec3};
use relievo_core::{Error, Result};
use relievo_gpu::{Access, Bindings, Buffer, Device, Frame, GROUP, Kernel, KernelSpec, groups};

use crate::obb::Obb;

/// As in `imprint_bounds.wgsl`.
#[repr(C)]
#[derive(Clone, Copy, Debug, Pod, Zeroable)]
struct Axes {
    x: [f32; 4],
    y: [f32; 4],
    z: [f32; 4],
    origin: [f32; 3],
    count: u32,
}

/// The bounds of the points of a buffer.
#[derive(Debug)]
pub struct DeviceBounds {
    kernel: Arc<Kernel>,
    buffers: Bindings,
    extrema: Buffer<u32>,
    count: u32,
}

impl DeviceBounds {
    /// Bounds of `points`, three numbers each. Fails where there are none, and where the device has no room.
    pub fn new(device: &Device, points: &Buffer<f32>) -> Result<Self> {
        let count = (points.len() / 3) as u32;
        if count == 0 {
            return Err(Error::invalid("a bounding box needs at least one point"));
        }
        let kernel = device.kernel(&KernelSpec {
            module: "imprint_bounds",
            entry: "bound",
            groups: &[&[Access::Read, Access::Write]],
            immediates: size_of::<Axes>() as u32,
            constants: &[],
        })?;
        let extrema = Buffer::new(device, "bounds", 6)?;
        let buffers = device.bind(&kernel, 0, &[points.wgpu(), extrema.wgpu()])?;
        Ok(Self { kernel, buffers, extrema, count })
    }

    /// Records the reduction along orthonormal `axes`, of the points less `origin`, as a pass of the given name. The
    /// origin is rounded to f32; near the points, little of them is lost.
    pub fn reduce(&self, frame: &mut Frame, name: &'static str, axes: &DMat3, origin: DVec3) -> Result<()> {
        frame.clear(&self.extrema);
        let row = |axis: usize| axes.col(axis).as_vec3().extend(0.0).to_array();
        let origin = origin.as_vec3().to_array();
        let work = Axes { x: row(0), y: row(1), z: row(2), origin, count: self.count };
        let size = groups(self.count.div_ceil(GROUP));
        frame.pass(name).run(&self.kernel, &[&self.buffers], bytemuck::bytes_of(&work), size)
    }

    /// The six words that the reduction leaves, for [`Self::obb`].
    pub fn extrema(&self) -> &Buffer<u32> {
        &self.extrema
    }

    /// The box that the words of a reduction stand for. Fails for other words, and where a point is not finite.
    pub fn obb(axes: &DMat3, origin: DVec3, extrema: &[u32]) -> Result<Obb> {
        let float = |key: u32| f64::from(f32::from_bits(if key >> 31 != 0 { key & 0x7fff_ffff } else { !key }));
        let &[x, y, z, minus_x, minus_y, minus_z] = extrema else {
            return Err(Error::internal(format!("bounds of {} words", extrema.len())));
        };
        let high = DVec3::new(float(x), float(y), float(z));
        let low = -DVec3::new(float(minus_x), float(minus_y), float(minus_z));
        if !low.is_finite() || !high.is_finite() {
            return Err(Error::invalid("a point of the bounding box is not finite"));
        }
        let shift = axes.transpose() * origin.as_vec3().as_dvec3();
        Ok(Obb::from_interval(*axes, low + shift, high + shift))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::EulerRot;
    use relievo_testing::{Random, device, wgsl::assert_layout};
    use std::mem::offset_of;

    #[test]
    fn the_layout_is_that_of_the_kernel() {
        let fields = [
            ("x", offset_of!(Axes, x)),
            ("y", offset_of!(Axes, y)),
            ("z", offset_of!(Axes, z)),
            ("origin", offset_of!(Axes, origin)),
            ("count", offset_of!(Axes, count)),
        ];
        assert_layout("imprint_bounds", "Axes", size_of::<Axes>(), &fields);
    }

    #[test]
    fn bounds_are_those_of_the_processor_in_any_order() {
        let Some(device) = device() else { return };
        let mut random = Random(11);
        let origin = DVec3::new(40.0, -7.0, 300.0);
        let axes = DMat3::from_euler(EulerRot::XYZ, 0.3, -1.1, 2.0);
        for count in [1, 255, 256, 257, 20_000] {
            let mut points: Vec<[f32; 3]> = (0..count)
                .map(|_| {
                    let unit = DVec3::new(random.unit().into(), random.unit().into(), random.unit().into());
                    (origin + (unit - 0.3) * DVec3::new(3.0, 1.0, 0.2)).as_vec3().to_array()
                })
                .collect();
            let buffer = Buffer::of(&device, "points", bytemuck::cast_slice(&points)).unwrap();
            let bounds = DeviceBounds::new(&device, &buffer).unwrap();
            let reduced = || {
                let mut frame = device.frame().unwrap();
                bounds.reduce(&mut frame, "overlap", &axes, origin).unwrap();
                let extrema = frame.read(bounds.extrema(), 0..6).unwrap();
                let _ = frame.submit().unwrap();
                extrema.get(&device).unwrap()
            };
            let extrema = reduced();
            let obb = DeviceBounds::obb(&axes, origin, &extrema).unwrap();
            let places = points.iter().map(|point| axes.transpose() * DVec3::from(point.map(f64::from)));
            let (low, high) = places
                .fold((DVec3::INFINITY, DVec3::NEG_INFINITY), |(low, high), place| (low.min(place), high.max(place)));
            let expected = Obb::from_interval(axes, low, high);
            assert!((obb.center - expected.center).length() < 1e-5, "{obb:?} {expected:?}");
            assert!((obb.half - expected.half).length() < 1e-6, "{obb:?} {expected:?}");
            points.reverse();
            buffer.write(&device, 0, bytemuck::cast_slice(&points)).unwrap();
            assert_eq!(reduced(), extrema);
            points[count / 2][1] = f32::INFINITY;
            buffer.write(&device, 0, bytemuck::cast_slice(&points)).unwrap();
            assert!(DeviceBounds::obb(&axes, origin, &reduced()).is_err());
        }
        assert!(DeviceBounds::obb(&axes, origin, &[1, 2]).is_err());
        let none = Buffer::new(&device, "points", 0).unwrap();
        assert!(DeviceBounds::new(&device, &none).is_err());
    }
}
