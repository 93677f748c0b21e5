//! Which particles the surface of a fluid needs, as [`crate::classify`], found on a graphics device
//! (`shaders/fluid/surface`).
//!
//! Space is divided into bricks of 4³ corners of cells, as wide as the support radius. Corners of bricks that particles reach
//! gather their values, edges between inside and outside have vertices, and particles look for those near them. How many bricks
//! and vertices there are is read back in between, since room is made for them.

use std::sync::Arc;

use glam::Vec4;
use relievo_core::{Error, Result};
use relievo_gpu::wgsl::fluid_surface::SurfaceCall;
use relievo_gpu::{Access, Buffer, Device, GROUP, Kernel, KernelSpec, Readback, Scan, Sort, groups};

use crate::surface::blind::Distances;
use crate::surface::function::Combination;
use crate::surface::profile::Profile;
use crate::{Classes, SurfaceFunction, Visibility};

/// Corners of a brick.
const CORNERS: usize = 64;
/// Bricks around the box of all particles: particles reach one, which looks one farther, and quotients are rounded.
const MARGIN: i32 = 3;
/// Particles of a brick at most: a corner looks at those of 27, and some devices end loops after 65,535 turns.
const CROWD: u32 = 2000;
/// Bricks that a threshold reaches at most, for the same reason.
const REACH: i32 = 3;
/// Cells from 0 at most, as of meshes.
const FARTHEST: f32 = 1_048_576.0;
/// Workgroups that find the bounds of all particles.
const BOUNDING: u32 = 64;

/// What particles are for their surface, as [`crate::classify`] says of a [`crate::Surface`] of the function: particles whose
/// distance from it is that of a limit, but for rounding, may be of the class beside. `threshold` is in metres, and without one
/// the influence of particles.
///
/// # Errors
/// Fails if the function or the threshold is out of range, a position is not finite or more than 2²⁰ cells of a quarter
/// of the support radius from 0, or the device has no memory or is lost. Anisotropic kernels, thresholds of more than
/// 2.5 support radii, more than 2,000 particles in a cube as wide as the support radius and boxes of 2³² such cubes are
/// refused ([`ErrorKind::Unsupported`](relievo_core::ErrorKind)).
pub fn classify_on(
    device: &Device,
    positions: &[[f32; 3]],
    function: SurfaceFunction,
    threshold: Option<f32>,
) -> Result<Classes> {
    let places: Vec<Vec4> = positions.iter().map(|[x, y, z]| Vec4::new(*x, *y, *z, 0.0)).collect();
    let places = Buffer::of(device, "places of particles", &places)?;
    Ok(Classes::new(find(device, &places, function, threshold)?))
}

/// What the particles at these places are, in their order.
pub(super) fn find(
    device: &Device,
    places: &Buffer<Vec4>,
    function: SurfaceFunction,
    threshold: Option<f32>,
) -> Result<Vec<Visibility>> {
    let mut call = call_of(function, threshold)?;
    if places.is_empty() {
        return Ok(Vec::new());
    }
    call.particles = u32::try_from(places.len())
        .map_err(|_| Error::invalid(format!("there are {} particles", places.len())).advise("use less than 2^32"))?;
    let cells = Cells::new(device, places, &mut call)?;
    let bricks = cells.bricks(device, &mut call)?;
    let (vertices, counts) = cells.vertices(device, &bricks, &mut call)?;
    let classes = Buffer::<u32>::new(device, "classes of particles", places.len())?;
    let classify = kernel(device, "fluid_surface_blind", "classify", &[&[Access::Read; 5], &[Access::Write]])?;
    let from = [bricks.wgpu(), cells.places.wgpu(), cells.order.wgpu(), counts.wgpu(), vertices.wgpu()];
    let bindings = [device.bind(&classify, 0, &from)?, device.bind(&classify, 1, &[classes.wgpu()])?];
    let mut frame = device.frame()?;
    frame.pass("classes").run(&classify, &bindings.each_ref(), bytemuck::bytes_of(&call), over(call.particles))?;
    let classes = frame.read(&classes, 0..places.len())?;
    let _ = frame.submit()?;
    let class = |class| match class {
        0 => Visibility::Surface,
        1 => Visibility::Blind,
        _ => Visibility::Hidden,
    };
    Ok(classes.get(device)?.into_iter().map(class).collect())
}

/// Returns the parameters of kernels for a function and a threshold.
fn call_of(function: SurfaceFunction, threshold: Option<f32>) -> Result<SurfaceCall> {
    function.check()?;
    if matches!(function, SurfaceFunction::Anisotropic { .. }) {
        return Err(refused("surfaces of anisotropic kernels are not found on devices"));
    }
    let support = function.support();
    let threshold = threshold.unwrap_or(support + function.sight());
    let Distances { cell, layer, farthest } = Distances::new(support, threshold)?;
    let reach = (farthest / support) as i32 + 1;
    if reach > REACH {
        return Err(refused(&format!(
            "a threshold of {threshold} is more than devices look at, which is 2.5 support radii of {support}"
        )));
    }
    let (profile, sharpness) = match function.profile() {
        Profile::Gaussian(sharpness) => (0, sharpness),
        Profile::Cubic => (1, 0.0),
        Profile::Spline => (2, 0.0),
    };
    let (iso, radius, outside) = match function.combination() {
        Combination::Sum { iso } => (iso, 0.0, 0.0),
        Combination::Mean { radius, outside } => (0.0, radius, outside),
    };
    Ok(SurfaceCall {
        profile,
        support,
        cell,
        sharpness,
        floor: (-sharpness).exp(),
        iso,
        radius,
        outside,
        layer: layer * layer,
        farthest: farthest * farthest,
        reach,
        ..SurfaceCall::default()
    })
}

/// Sets the box of bricks that particles between two corners are in.
fn enclose(call: &mut SurfaceCall, [low, high]: [[f32; 3]; 2]) -> Result<()> {
    let SurfaceCall { support, cell, .. } = *call;
    if !low.into_iter().chain(high).all(f32::is_finite) {
        return Err(Error::invalid("a coordinate is not a finite number")
            .at("particles")
            .advise("remove the particle or repair its position"));
    }
    if low.into_iter().chain(high).any(|at| at.abs() > FARTHEST * cell) {
        return Err(Error::invalid(format!("particles are more than {FARTHEST} cells of {cell} from 0"))
            .advise("move them nearer to 0, or use a larger support radius"));
    }
    let brick = |at: f32| (at / support).floor() as i32;
    call.low = low.map(|at| brick(at) - MARGIN);
    call.size = std::array::from_fn(|axis| (brick(high[axis]) + MARGIN + 1 - call.low[axis]) as u32);
    if call.size.iter().map(|side| u128::from(*side)).product::<u128>() >> 32 > 0 {
        return Err(refused(&format!("particles are in a box of {:?} support radii", call.size)));
    }
    Ok(())
}

/// Returns the bits of the numbers of bricks.
fn bits(call: &SurfaceCall) -> u32 {
    u64::BITS - call.size.iter().map(|side| u64::from(*side)).product::<u64>().leading_zeros()
}

/// Particles in the order of bricks, and the bricks that have some.
struct Cells {
    places: Buffer<Vec4>,
    order: Buffer<u32>,
    cells: Buffer<u32>,
    starts: Buffer<u32>,
    /// How many bricks those before each list, which particles reach.
    counts: Buffer<u32>,
    report: Buffer<u32>,
}

impl Cells {
    fn new(device: &Device, from: &Buffer<Vec4>, call: &mut SurfaceCall) -> Result<Self> {
        use Access::{Read, Write};
        let count = from.len();
        let many = |label| Buffer::<u32>::new(device, label, count);
        let [keys, firsts] = [many("bricks of particles")?, many("first particles")?];
        let made = Self {
            places: Buffer::new(device, "sorted places", count)?,
            order: many("order")?,
            cells: many("bricks with particles")?,
            starts: Buffer::new(device, "particles of bricks", count + 1)?,
            counts: many("counts of bricks")?,
            report: Buffer::new(device, "report of a surface", 8)?,
        };
        let Self { places, order, cells, starts, counts, report } = &made;
        let sorting = |entry| kernel(device, "fluid_surface_sort", entry, &[&[Read], &[Write; 7]]);
        let [bound, number, arrange, note] =
            [sorting("bound")?, sorting("number_particles")?, sorting("arrange")?, sorting("note_cells")?];
        let to = [report, &keys, order].map(Buffer::wgpu).into_iter().chain([places.wgpu()]);
        let to: Vec<_> = to.chain([&firsts, cells, starts].map(Buffer::wgpu)).collect();
        let sorting = [device.bind(&bound, 0, &[from.wgpu()])?, device.bind(&bound, 1, &to)?];
        let size = over(call.particles);
        let mut frame = device.frame()?;
        let bounding = [size[0].min(BOUNDING), 1, 1];
        frame.pass("bounds").run(&bound, &sorting.each_ref(), bytemuck::bytes_of(call), bounding)?;
        let bounds = frame.read(report, 0..6)?;
        let _ = frame.submit()?;
        let bounds = bounds.get(device)?;
        let corner = |first: usize, mask: u32| std::array::from_fn(|axis| falling(bounds[first + axis] ^ mask));
        enclose(call, [corner(0, u32::MAX), corner(3, 0)])?;

        let sort = Sort::new(device, &keys, order)?;
        let [before, listed] = [Scan::new(device, &firsts, report)?, Scan::new(device, counts, report)?];
        let surround = kernel(device, "fluid_surface_around", "surround", &[&[Read; 2], &[Write; 2]])?;
        let around = [
            device.bind(&surround, 0, &[cells.wgpu(), starts.wgpu()])?,
            device.bind(&surround, 1, &[report.wgpu(), counts.wgpu()])?,
        ];
        let mut frame = device.frame()?;
        let (mut pass, bytes) = (frame.pass("bricks"), bytemuck::bytes_of(call));
        pass.run(&number, &sorting.each_ref(), bytes, size)?;
        sort.run(&mut pass, call.particles, bits(call))?;
        pass.run(&arrange, &sorting.each_ref(), bytes, size)?;
        before.run(&mut pass, call.particles)?;
        pass.run(&note, &sorting.each_ref(), bytes, size)?;
        pass.run(&surround, &around.each_ref(), bytes, size)?;
        listed.run(&mut pass, call.particles)?;
        drop(pass);
        let (told, all) = (frame.read(report, 6..8)?, total(&mut frame, &listed)?);
        let _ = frame.submit()?;
        let (told, all) = (told.get(device)?, all.get(device)?);
        if told[1] > CROWD {
            return Err(refused(&format!("{} particles are in a cube of a support radius", told[1])));
        }
        (call.cells, call.listed) = (told[0], all[0]);
        Ok(made)
    }

    /// The bricks that particles reach.
    fn bricks(&self, device: &Device, call: &mut SurfaceCall) -> Result<Buffer<u32>> {
        use Access::{Read, Write};
        let many = |label| Buffer::<u32>::new(device, label, call.listed as usize);
        let [listed, firsts, bricks, unused] =
            [many("listed bricks")?, many("first bricks")?, many("bricks")?, many("order of bricks")?];
        let around = |entry| kernel(device, "fluid_surface_around", entry, &[&[Read; 2], &[Write; 2], &[Write; 3]]);
        let [list, mark, keep] = [around("list_bricks")?, around("mark_bricks")?, around("keep_bricks")?];
        let bindings = [
            device.bind(&list, 0, &[self.cells.wgpu(), self.starts.wgpu()])?,
            device.bind(&list, 1, &[self.report.wgpu(), self.counts.wgpu()])?,
            device.bind(&list, 2, &[listed.wgpu(), firsts.wgpu(), bricks.wgpu()])?,
        ];
        let sort = Sort::new(device, &listed, &unused)?;
        let before = Scan::new(device, &firsts, &self.report)?;
        let mut frame = device.frame()?;
        let (mut pass, bytes) = (frame.pass("bricks"), bytemuck::bytes_of(call));
        pass.run(&list, &bindings.each_ref(), bytes, over(call.cells))?;
        sort.run(&mut pass, call.listed, bits(call))?;
        pass.run(&mark, &bindings.each_ref(), bytes, over(call.listed))?;
        before.run(&mut pass, call.listed)?;
        pass.run(&keep, &bindings.each_ref(), bytes, over(call.listed))?;
        drop(pass);
        let count = total(&mut frame, &before)?;
        let _ = frame.submit()?;
        call.bricks = count.get(device)?[0];
        Ok(bricks)
    }

    /// The vertices of the surface, and how many those of the corners before each corner are.
    fn vertices(
        &self,
        device: &Device,
        bricks: &Buffer<u32>,
        call: &mut SurfaceCall,
    ) -> Result<(Buffer<Vec4>, Buffer<u32>)> {
        use Access::{Read, Write};
        let corners = call.bricks as usize * CORNERS;
        let amplitudes = Buffer::<f32>::new(device, "amplitudes of particles", self.places.len())?;
        let values = Buffer::<f32>::new(device, "values of a surface", corners)?;
        let counts = Buffer::<u32>::new(device, "counts of vertices", corners)?;
        let valued = |entry| kernel(device, "fluid_surface_values", entry, &[&[Read; 4], &[Write; 2]]);
        let [measure, evaluate] = [valued("measure")?, valued("evaluate")?];
        let from = [self.cells.wgpu(), self.starts.wgpu(), self.places.wgpu(), bricks.wgpu()];
        let to = [amplitudes.wgpu(), values.wgpu()];
        let valued = [device.bind(&measure, 0, &from)?, device.bind(&measure, 1, &to)?];
        let count = kernel(device, "fluid_surface_cross", "count_vertices", &[&[Read; 2], &[Write]])?;
        let crossed =
            [device.bind(&count, 0, &[bricks.wgpu(), values.wgpu()])?, device.bind(&count, 1, &[counts.wgpu()])?];
        let before = Scan::new(device, &counts, &self.report)?;
        let mut frame = device.frame()?;
        let (mut pass, bytes) = (frame.pass("values"), bytemuck::bytes_of(call));
        pass.run(&measure, &valued.each_ref(), bytes, over(call.particles))?;
        pass.run(&evaluate, &valued.each_ref(), bytes, groups(call.bricks))?;
        pass.run(&count, &crossed.each_ref(), bytes, groups(call.bricks))?;
        before.run(&mut pass, corners as u32)?;
        drop(pass);
        let all = total(&mut frame, &before)?;
        let _ = frame.submit()?;
        call.vertices = all.get(device)?[0];
        let vertices = Buffer::new(device, "vertices of a surface", call.vertices.max(1) as usize)?;
        let place = kernel(device, "fluid_surface_cross", "place_vertices", &[&[Read; 2], &[Write], &[Write]])?;
        let [from, to] = &crossed;
        let placed = device.bind(&place, 2, &[vertices.wgpu()])?;
        let mut frame = device.frame()?;
        let bytes = bytemuck::bytes_of(call);
        frame.pass("vertices").run(&place, &[from, to, &placed], bytes, groups(call.bricks))?;
        let _ = frame.submit()?;
        Ok((vertices, counts))
    }
}

fn kernel(device: &Device, module: &str, entry: &str, groups: &[&[Access]]) -> Result<Arc<Kernel>> {
    let immediates = size_of::<SurfaceCall>() as u32;
    device.kernel(&KernelSpec { module, entry, groups, immediates, constants: &[] })
}

/// Workgroups over so many items.
fn over(count: u32) -> [u32; 3] {
    groups(count.div_ceil(GROUP))
}

/// The sum of all items of a scan that went over all of them.
fn total(frame: &mut relievo_gpu::Frame, scan: &Scan) -> Result<Readback<u32>> {
    let last = scan.sums().len() - 1;
    frame.read(scan.sums(), last..last + 1)
}

/// The number that `rising` of `fluid_surface_sort.wgsl` made one of.
fn falling(bits: u32) -> f32 {
    f32::from_bits(if bits >> 31 == 1 { bits & (u32::MAX >> 1) } else { !bits })
}

fn refused(what: &str) -> Error {
    Error::unsupported(what.to_owned()).advise("use the processor, `--device cpu`")
}
