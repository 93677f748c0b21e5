//! Evaluation at arrays of places; see `include/relievo/evaluate.h`.

use glam::Vec3;
use relievo_core::{Context, Error, Result};
use relievo_surface::{Order, Place, Samples, TriangleSurface};
use relievo_tiles::triangle::foot_at;

use crate::border::array::{Input, Output, Plain};
use crate::border::descriptor::read_descriptor;
use crate::border::registry;
use crate::details::detail::{RLV_CHANNEL_COLOR, RLV_CHANNEL_TRACES, RlvDetail, missing};
use crate::details::view::{Looked, Wanted};
use crate::surfaces::shape::{Shape, barycentric};
use crate::surfaces::surface::RlvSurface;

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
        footprints: *const f32,
        footprint_stride: usize,
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
    footprints: Option<Input<[f32; 4]>>,
}

impl Arrays {
    /// Checks the arrays and, by `check`, every place.
    ///
    /// # Errors
    /// Fails with `Invalid` if the descriptor is NULL, its `struct_size` is none of the type or an array cannot be
    /// used, with `Unsupported` if a field that this library lacks is not zero, and, naming the place, as `check` does.
    ///
    /// # Safety
    /// `arrays` is NULL or a descriptor whose arrays are as `evaluate.h` demands.
    pub unsafe fn new(arrays: *const RlvEvaluateArrays, check: impl Fn(u32, [f32; 2]) -> Result<()>) -> Result<Self> {
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
            // SAFETY: as above.
            footprints: unsafe {
                Input::optional("footprints", given.footprints.cast(), count, given.footprint_stride)
            }?,
        };
        for (index, (tile, uv)) in made.tiles.iter().zip(made.uvs.iter()).enumerate() {
            check(tile, uv).map_err(|error| error.at(format!("place {index}")))?;
        }
        Ok(made)
    }

    /// Checks that `what` is not asked for colours or traces, which only details have.
    ///
    /// # Errors
    /// Fails with `Unsupported` if it is.
    pub fn refuse_marks(&self, what: &str) -> Result<()> {
        let wanted = [("colors", self.colors.is_some()), ("traces", self.traces.is_some())];
        match wanted.iter().find(|(_, wanted)| *wanted) {
            Some((name, _)) => Err(Error::unsupported(format!("{what} have no colours and no traces"))
                .at(*name)
                .advise("leave them NULL, or evaluate a detail that was given some")),
            None => Ok(()),
        }
    }

    /// Where the pieces start.
    pub fn starts(&self) -> impl Iterator<Item = usize> + use<> {
        (0..self.count).step_by(CHUNK)
    }

    /// The places of the piece that starts at the index `first`, in place of those in `places`.
    pub fn places(&self, first: usize, places: &mut Vec<Place>) {
        let place = |index| {
            let [u, v] = self.uvs.get(index);
            Place { tile: self.tiles.get(index), u, v }
        };
        places.clear();
        places.extend((first..self.count.min(first + CHUNK)).map(place));
    }

    /// The footprints of `count` places from the index `first` on, in `room`, if there are any.
    fn footprints<'a>(
        &self,
        first: usize,
        count: usize,
        room: &'a mut Vec<[[f32; 2]; 2]>,
    ) -> Option<&'a [[[f32; 2]; 2]]> {
        let all = self.footprints?;
        let footprint = |[a, b, c, d]: [f32; 4]| [[a, b], [c, d]];
        room.clear();
        room.extend((first..first + count).map(|index| footprint(all.get(index))));
        Some(room)
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

/// What is asked and found of one piece.
#[derive(Default)]
struct Piece {
    places: Vec<Place>,
    footprints: Vec<[[f32; 2]; 2]>,
    samples: Samples,
    found: Looked,
}

/// Writes `count` values to the array, if there is one, from the index `first` on.
pub fn write<T: Plain>(out: Option<Output<T>>, first: usize, count: usize, value: impl Fn(usize) -> T) {
    if let Some(out) = out {
        for index in 0..count {
            out.set(first + index, value(index));
        }
    }
}

entry! {
    fn rlv_evaluate_surface(surface: RlvSurface, arrays: *const RlvEvaluateArrays) {
        let object = registry::get(surface)?;
        let shape = object.snapshot().shape;
        // SAFETY: the caller's arrays are as the header demands.
        let arrays = unsafe { Arrays::new(arrays, |tile, uv| shape.check_place(tile, uv)) }?;
        arrays.refuse_marks("bare surfaces")?;
        let surface = match &shape {
            Shape::Tiles(surface) => surface,
            Shape::Triangles(surface) => {
                evaluate_triangles(&object.context.context, &arrays, surface);
                return Ok(());
            }
        };
        let order = arrays.order();
        let context = &object.context.context;
        let mut room = context.scratch().lend::<Piece>();
        let Piece { places, samples, .. } = &mut *room;
        for first in arrays.starts() {
            arrays.places(first, places);
            surface.evaluate(context, places, order, samples)?;
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
        let shape = view.shape();
        // SAFETY: the caller's arrays are as the header demands.
        let arrays = unsafe { Arrays::new(arrays, |tile, uv| shape.check_place(tile, uv)) }?;
        if arrays.derivatives.iter().any(Option::is_some) {
            return Err(Error::unsupported("displaced surfaces have positions, normals and displacements only")
                .at("derivatives")
                .advise("leave du to dvv NULL, or evaluate the surface"));
        }
        if arrays.colors.is_some() && !view.has_paint() {
            return Err(missing(RLV_CHANNEL_COLOR).at("colors"));
        }
        if arrays.traces.is_some() && !view.has_traces() {
            return Err(missing(RLV_CHANNEL_TRACES).at("traces"));
        }
        let wanted = Wanted {
            displacements: arrays.displacements.is_some(),
            vectors: arrays.vectors.is_some(),
            marks: arrays.traces.is_some(),
            colors: arrays.colors.is_some(),
        };
        let context = &object.context.context;
        let mut room = context.scratch().lend::<Piece>();
        let Piece { places, footprints, found, .. } = &mut *room;
        for first in arrays.starts() {
            arrays.places(first, places);
            let count = places.len();
            let footprints = arrays.footprints(first, count, footprints);
            view.look(context, places, footprints, wanted, found)?;
            write(arrays.positions, first, count, |index| found.points.p[index]);
            write(arrays.normals, first, count, |index| found.points.normal[index]);
            write(arrays.displacements, first, count, |index| found.displacements[index]);
            write(arrays.vectors, first, count, |index| found.vectors[index]);
            write(arrays.traces, first, count, |index| {
                let mark = &found.marks[index];
                [mark.contact, mark.depth, view.age(mark)]
            });
            write(arrays.colors, first, count, |index| found.colors[index].to_array());
        }
        Ok(())
    }
}

/// Flat triangles, whose normals are interpolated, and whose derivatives are their edges.
fn evaluate_triangles(context: &Context, arrays: &Arrays, surface: &TriangleSurface) {
    let mut room = context.scratch().lend::<Piece>();
    let places = &mut room.places;
    for first in arrays.starts() {
        arrays.places(first, places);
        let count = places.len();
        let foot = |index: usize| {
            let Place { tile, u, v } = places[index];
            foot_at(surface, tile, barycentric(u, v))
        };
        write(arrays.positions, first, count, |index| foot(index).point.to_array());
        write(arrays.normals, first, count, |index| foot(index).normal.to_array());
        for (corner, out) in (1..3).zip(arrays.derivatives) {
            write(out, first, count, |index| {
                let corners = surface.corner_points(places[index].tile).map(Vec3::from);
                (corners[corner] - corners[0]).to_array()
            });
        }
        for out in &arrays.derivatives[2..] {
            write(*out, first, count, |_| [0.0; 3]);
        }
        write(arrays.displacements, first, count, |_| 0.0);
        write(arrays.vectors, first, count, |_| [0.0; 3]);
    }
}
