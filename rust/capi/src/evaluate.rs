//! Evaluation at arrays of places; see `include/relievo/evaluate.h`.

use relievo_core::{Error, Result};
use relievo_surface::{Order, Place, Samples, Surface};
use relievo_tiles::Displaced;
use relievo_tiles::displaced::Points;

use crate::array::{Input, Output, Plain};
use crate::descriptor::read_descriptor;
use crate::detail::RlvDetail;
use crate::registry;
use crate::surface::{RlvSurface, check_tile};

descriptor! {
    pub struct RlvEvaluateArrays {
        struct_size: u32,
        reserved: u32,
        count: usize,
        tiles: *const u32,
        tile_stride: usize,
        uvs: *const f32,
        uv_stride: usize,
        positions: *mut f32,
        position_stride: usize,
        normals: *mut f32,
        normal_stride: usize,
        du: *mut f32,
        du_stride: usize,
        dv: *mut f32,
        dv_stride: usize,
        duu: *mut f32,
        duu_stride: usize,
        duv: *mut f32,
        duv_stride: usize,
        dvv: *mut f32,
        dvv_stride: usize,
        displacements: *mut f32,
        displacement_stride: usize,
        colors: *mut f32,
        color_stride: usize,
        vectors: *mut f32,
        vector_stride: usize,
        traces: *mut f32,
        trace_stride: usize,
    }
}

/// Places evaluated between two writes to the caller's arrays, which bounds the memory of a call.
const CHUNK: usize = 1 << 16;

/// The caller's arrays, checked.
pub struct Arrays {
    pub count: usize,
    tiles: Input<u32>,
    uvs: Input<[f32; 2]>,
    pub positions: Option<Output<[f32; 3]>>,
    pub normals: Option<Output<[f32; 3]>>,
    /// du, dv, duu, duv, dvv.
    pub derivatives: [Option<Output<[f32; 3]>>; 5],
    pub displacements: Option<Output<f32>>,
    pub colors: Option<Output<[f32; 4]>>,
    pub vectors: Option<Output<[f32; 3]>>,
    pub traces: Option<Output<[f32; 3]>>,
}

impl Arrays {
    /// Checks the arrays and that every place is on `surface`.
    ///
    /// # Safety
    /// `arrays` is NULL or a descriptor whose arrays are as `evaluate.h` demands.
    pub unsafe fn new(arrays: *const RlvEvaluateArrays, surface: &Surface) -> Result<Self> {
        // SAFETY: a descriptor of nothing but numbers and NULL pointers.
        let default: RlvEvaluateArrays = unsafe { std::mem::zeroed() };
        // SAFETY: promised by the caller.
        let given = unsafe { read_descriptor(arrays, default) }?;
        let count = given.count;
        // SAFETY: for all of these, the caller promises `count` elements unless the pointer is NULL.
        let output = |name, pointer: *mut f32, stride| unsafe {
            Output::optional(name, pointer.cast::<[f32; 3]>(), count, stride)
        };
        let made = Self {
            count,
            // SAFETY: as above.
            tiles: unsafe { Input::new("tiles", given.tiles, count, given.tile_stride) }?,
            // SAFETY: as above.
            uvs: unsafe { Input::new("uvs", given.uvs.cast(), count, given.uv_stride) }?,
            positions: output("positions", given.positions, given.position_stride)?,
            normals: output("normals", given.normals, given.normal_stride)?,
            derivatives: [
                output("du", given.du, given.du_stride)?,
                output("dv", given.dv, given.dv_stride)?,
                output("duu", given.duu, given.duu_stride)?,
                output("duv", given.duv, given.duv_stride)?,
                output("dvv", given.dvv, given.dvv_stride)?,
            ],
            // SAFETY: as above.
            displacements: unsafe {
                Output::optional("displacements", given.displacements, count, given.displacement_stride)
            }?,
            // SAFETY: as above.
            colors: unsafe { Output::optional("colors", given.colors.cast(), count, given.color_stride) }?,
            vectors: output("vectors", given.vectors, given.vector_stride)?,
            traces: output("traces", given.traces, given.trace_stride)?,
        };
        for (index, (tile, [u, v])) in made.tiles.iter().zip(made.uvs.iter()).enumerate() {
            check_tile(surface, tile).map_err(|error| error.at(format!("place {index}")))?;
            if !((0.0..=1.0).contains(&u) && (0.0..=1.0).contains(&v)) {
                return Err(Error::invalid(format!("({u}, {v}) is outside the tile"))
                    .at(format!("place {index}"))
                    .advise("use u and v from 0 to 1"));
            }
        }
        Ok(made)
    }

    /// The places, in pieces that start at the given index.
    pub fn chunks(&self) -> impl Iterator<Item = (usize, Vec<Place>)> + '_ {
        (0..self.count).step_by(CHUNK).map(|first| {
            let range = first..self.count.min(first + CHUNK);
            let place = |index| {
                let [u, v] = self.uvs.get(index);
                Place { tile: self.tiles.get(index), u, v }
            };
            (first, range.map(place).collect())
        })
    }

    /// Up to which derivative the wanted outputs need the surface.
    fn order(&self) -> Order {
        if self.derivatives[2..].iter().any(Option::is_some) {
            Order::Second
        } else if self.normals.is_some() || self.derivatives.iter().any(Option::is_some) {
            Order::First
        } else {
            Order::Position
        }
    }
}

fn write<T: Plain>(out: Option<Output<T>>, first: usize, count: usize, value: impl Fn(usize) -> T) {
    if let Some(out) = out {
        for index in 0..count {
            out.set(first + index, value(index));
        }
    }
}

entry! {
    fn rlv_evaluate_surface(surface: RlvSurface, arrays: *const RlvEvaluateArrays) {
        let object = registry::get(surface)?;
        let surface = object.snapshot().surface;
        // SAFETY: the caller's arrays are as the header demands.
        let arrays = unsafe { Arrays::new(arrays, &surface) }?;
        if arrays.colors.is_some() || arrays.traces.is_some() {
            return Err(Error::unsupported("bare surfaces have no colours and no traces")
                .at(if arrays.colors.is_some() { "colors" } else { "traces" })
                .advise("leave them NULL, or evaluate a detail that was given some"));
        }
        let order = arrays.order();
        let mut samples = Samples::default();
        for (first, places) in arrays.chunks() {
            surface.evaluate(&object.context.context, &places, order, &mut samples)?;
            let vector = |from: &[Vec<f32>; 3], index: usize| [from[0][index], from[1][index], from[2][index]];
            let count = places.len();
            write(arrays.positions, first, count, |index| vector(&samples.p, index));
            write(arrays.normals, first, count, |index| {
                let du = glam::Vec3::from(vector(&samples.du, index));
                du.cross(vector(&samples.dv, index).into()).normalize_or_zero().to_array()
            });
            let all = [&samples.du, &samples.dv, &samples.duu, &samples.duv, &samples.dvv];
            for (out, from) in arrays.derivatives.iter().zip(all) {
                write(*out, first, count, |index| vector(from, index));
            }
            write(arrays.displacements, first, count, |_| 0.0);
            write(arrays.vectors, first, count, |_| [0.0; 3]);
        }
        Ok(())
    }

    fn rlv_evaluate_detail(detail: RlvDetail, arrays: *const RlvEvaluateArrays) {
        let object = registry::get(detail)?;
        let view = object.view();
        // SAFETY: the caller's arrays are as the header demands.
        let arrays = unsafe { Arrays::new(arrays, &view.surface) }?;
        if arrays.derivatives.iter().any(Option::is_some) {
            return Err(Error::unsupported("displaced surfaces have positions, normals and displacements only")
                .at("derivatives")
                .advise("leave du to dvv NULL, or evaluate the surface"));
        }
        if arrays.colors.is_some() && view.paint.is_none() {
            return Err(Error::invalid("the detail has no colours")
                .at("colors")
                .advise("give it some with rlv_detail_add_paint, and commit"));
        }
        if arrays.traces.is_some() && view.traces.is_none() {
            return Err(Error::invalid("the detail has no traces")
                .at("traces")
                .advise("let imprints leave some with rlv_detail_add_traces, and commit"));
        }
        let (context, displaced, field) = (&object.context.context, view.displaced()?, view.snapshot.field());
        let plain = Displaced::new(&view.surface, field)?;
        let (mut points, mut without) = (Points::default(), Points::default());
        for (first, places) in arrays.chunks() {
            displaced.evaluate(context, &places, &mut points)?;
            write(arrays.positions, first, places.len(), |index| points.p[index]);
            write(arrays.normals, first, places.len(), |index| points.normal[index]);
            write(arrays.displacements, first, places.len(), |index| {
                field.point(context.level(), field.canonical(places[index])).d
            });
            if arrays.vectors.is_some() {
                // What the vectors add, where the whole is evaluated.
                let places: Vec<Place> = places.iter().map(|place| displaced.canonical(*place)).collect();
                plain.evaluate_in_place(context, &places, &mut without)?;
                write(arrays.vectors, first, places.len(), |index| {
                    let [from, to] = [without.p[index], points.p[index]];
                    [0, 1, 2].map(|axis| to[axis] - from[axis])
                });
            }
            if let Some(traces) = view.traces.as_ref().map(|traces| traces.field()) {
                write(arrays.traces, first, places.len(), |index| {
                    let mark = traces.mark(traces.canonical(places[index]));
                    let age = mark.time.map_or(-1.0, |time| (view.time - f64::from(time)).max(0.0) as f32);
                    [mark.contact, mark.depth, age]
                });
            }
            if let Some(paint) = &view.paint {
                let paint = paint.field();
                write(arrays.colors, first, places.len(), |index| {
                    paint.color(paint.canonical(places[index])).to_array()
                });
            }
        }
        Ok(())
    }
}
