//! Passes 5 to 7 on a device, and the layers that it has.

use std::sync::{Mutex, MutexGuard, PoisonError};

use relievo_core::{Context, Progress, Result};
use relievo_gpu::{Access, Bindings, Buffer, Device, KernelSpec, PassTime};

use super::{FARTHEST_DEPTH, FoamLook, FoamPixel, NONE, SHARED, Splats, add_times, look};
use crate::foam::FoamLayers;
use crate::foam::environment::Environment;
use crate::foam::halton::Ball;
use crate::foam::layers::Surfaces;
use crate::foam::projection::{FoamView, Projection};
use crate::foam::settings::FoamSettings;
use crate::foam::thickness::of_sum;
use crate::image::Image;

/// Pixels of a workgroup along both axes.
const SIDE: u32 = 16;
/// Accesses of the kernels that shade: samples, their counts, the map of light, and the results.
const SHADED: &[Access] = &[Access::Read, Access::Read, Access::Read, Access::Write];

/// The layers of a picture of foam that a device has, to lay them over pictures.
#[derive(Debug)]
pub struct DeviceLayers {
    device: Device,
    shared: Bindings,
    lights: Buffer<[f32; 4]>,
    size: [u32; 2],
    times: Mutex<Vec<PassTime>>,
    /// What the bindings are of.
    _buffers: (Buffer<FoamLook>, Buffer<FoamPixel>, Buffer<[f32; 4]>),
}

/// Workgroups over all pixels.
fn over([width, height]: [u32; 2]) -> [u32; 3] {
    [width.div_ceil(SIDE), height.div_ceil(SIDE), 1]
}

impl Splats {
    /// Returns the layers of all particles that were drawn, lit by an environment. Fails if `progress` asks to stop, or the
    /// device has no memory or is lost.
    pub fn finish(
        mut self,
        context: &Context,
        (settings, view): (FoamSettings, FoamView),
        environment: &Environment,
        progress: &mut dyn Progress,
    ) -> Result<FoamLayers> {
        progress.step(0.0, "foam on the device")?;
        let device = self.device.clone();
        let map = match settings.irradiance_map.is_on() {
            true => environment.irradiance_map(context),
            false => environment.radiance_map(),
        };
        let mut look = look::look(&settings, &view);
        look::light(&mut look, &map);
        self.look.write(&device, 0, &[look])?;
        let ball = Ball::new(settings.ao_max_samp.max(settings.ao_min_samp));
        let samples: Vec<_> = ball.samples().iter().map(|it| it.place.extend(it.weight).to_array()).collect();
        let texels: Vec<_> = map.values.iter().map(|value| value.extend(0.0).to_array()).collect();
        let samples = Buffer::of(&device, "samples of foam", &samples)?;
        let counts = Buffer::of(&device, "counts of samples of foam", ball.counts())?;
        let texels = Buffer::of(&device, "light of foam", &texels)?;
        let lights = Buffer::new(&device, "lights of foam", view.pixels())?;
        let kernel = |entry| {
            let groups: &[&[Access]] = &[SHARED, SHADED];
            device.kernel(&KernelSpec { module: "foam_shade", entry, groups, immediates: 0, constants: &[] })
        };
        let kernels = [
            ("intensity", kernel("intensify")?),
            ("occlusion", kernel("occlude")?),
            ("irradiance", kernel("irradiate")?),
        ];
        let shaded = device.bind(&kernels[0].1, 1, &[samples.wgpu(), counts.wgpu(), texels.wgpu(), lights.wgpu()])?;
        let mut frame = device.frame()?;
        let size = [view.width, view.height];
        for (name, kernel) in &kernels {
            frame.pass(name).run(kernel, &[&self.shared, &shaded], &[], over(size))?;
        }
        let all = 0..view.pixels();
        let pixels = frame.read(&self.pixels, all.clone())?;
        let fronts = frame.read(&self.fronts, all.clone())?;
        let light = frame.read(&lights, all)?;
        self.submissions.push_back(frame.submit()?);
        while !self.submissions.is_empty() {
            self.wait()?;
        }
        let Self { look, pixels: splats, fronts: depths, shared, times, .. } = self;
        let layers = DeviceLayers {
            device: device.clone(),
            shared,
            lights,
            size,
            times: Mutex::new(times),
            _buffers: (look, splats, depths),
        };
        let pixels = pixels.get(&device)?;
        let intensity = fronts.get(&device)?.into_iter().map(|front| front[1]).collect();
        let light = light.get(&device)?;
        progress.step(1.0, "foam on the device")?;
        Ok(FoamLayers {
            settings,
            view,
            projection: Projection::new(&view),
            surfaces: Surfaces {
                depth: pixels.iter().map(depth).collect(),
                search: pixels.iter().map(|pixel| pixel.search).collect(),
                disc: pixels.iter().map(|pixel| [pixel.u, pixel.v]).collect(),
            },
            thickness: pixels.iter().map(thickness).collect(),
            intensity,
            occlusion: light.iter().map(|value| value[3]).collect(),
            irradiance: light.iter().map(|[red, green, blue, _]| [*red, *green, *blue]).collect(),
            device: Some(layers.into()),
        })
    }
}

/// Returns the depth of the nearest fragment, infinite where there is none.
fn depth(pixel: &FoamPixel) -> f32 {
    if pixel.id == NONE && pixel.depth == FARTHEST_DEPTH.to_bits() ^ 1 << 31 {
        return f32::INFINITY;
    }
    f32::from_bits(if pixel.depth >> 31 == 1 { pixel.depth & (u32::MAX >> 1) } else { !pixel.depth })
}

fn thickness(pixel: &FoamPixel) -> f32 {
    of_sum(u64::from(pixel.high) << 32 | u64::from(pixel.low))
}

impl DeviceLayers {
    /// Returns a picture of three channels or more with the foam over it, which has the size of the foam. Fails if the
    /// device has no memory or is lost.
    pub fn composite(&self, background: &Image) -> Result<Image> {
        let device = &self.device;
        let picture = Buffer::of(device, "picture", background.data())?;
        let spec = KernelSpec {
            module: "foam_compose",
            entry: "compose",
            groups: &[SHARED, &[Access::Read, Access::Write]],
            immediates: 4,
            constants: &[],
        };
        let kernel = device.kernel(&spec)?;
        let laid = device.bind(&kernel, 1, &[self.lights.wgpu(), picture.wgpu()])?;
        let mut frame = device.frame()?;
        let channels = background.channels();
        let bytes = bytemuck::bytes_of(&channels);
        frame.pass("composition").run(&kernel, &[&self.shared, &laid], bytes, over(self.size))?;
        let read = frame.read(&picture, 0..background.data().len())?;
        add_times(&mut self.lock(), frame.submit()?.wait()?);
        let mut made = background.clone();
        made.data_mut().copy_from_slice(&read.get(device)?);
        Ok(made)
    }

    /// Returns the times of all passes so far.
    pub fn times(&self) -> Vec<PassTime> {
        self.lock().clone()
    }

    fn lock(&self) -> MutexGuard<'_, Vec<PassTime>> {
        // Times are whole whenever the lock is free.
        self.times.lock().unwrap_or_else(PoisonError::into_inner)
    }
}
