//! Bézier patches; see `include/relievo/bezier.h`.

use std::ffi::c_char;
use std::path::Path;
use std::sync::Arc;

use relievo_core::{Error, Result};
use relievo_meshio::read_patches;
use relievo_surface::Sample;
use relievo_surface::bezier::{BezierSurface, CONTROLS, Levels, Viewpoint};

use crate::border::array::{Input, Output, present, put, text};
use crate::border::descriptor::{read_descriptor, read_optional, write_descriptor};
use crate::border::registry::{self, handle};
use crate::runtime::context::{ContextObject, RlvContext};
use crate::surfaces::evaluate::{Arrays, RlvEvaluateArrays, write};
use crate::surfaces::mesh::{self, RlvMesh};

handle!(RlvBezier, 14, BezierObject);

descriptor! {
    pub struct RlvBezierArrays {
        struct_size: u32,
        reserved: u32,
        points: *const f32,
        point_count: usize,
        point_stride: usize,
        weights: *const f32,
        weight_stride: usize,
        indices: *const u32,
        index_count: usize,
        index_stride: usize,
    }
}

descriptor! {
    pub struct RlvBezierInfo {
        struct_size: u32,
        is_rational: u32,
        patch_count: usize,
        curve_count: usize,
        low: [f32; 3],
        high: [f32; 3],
    }
}

descriptor! {
    pub struct RlvBezierView {
        struct_size: u32,
        most: u32,
        eye: [f64; 3],
        forward: [f64; 3],
        pixels: f64,
        corner: f64,
        tolerance: f64,
    }
}

descriptor! {
    pub struct RlvBezierLevels {
        struct_size: u32,
        level: u32,
        levels: *const u32,
        level_count: usize,
        level_stride: usize,
    }
}

descriptor! {
    pub struct RlvBezierTriangles {
        struct_size: u32,
        reserved: u32,
        positions: *mut f32,
        position_stride: usize,
        normals: *mut f32,
        normal_stride: usize,
        point_capacity: usize,
        corners: *mut u32,
        triangle_stride: usize,
        triangle_capacity: usize,
    }
}

pub struct BezierObject {
    context: Arc<ContextObject>,
    surface: BezierSurface,
}

impl BezierObject {
    /// The levels that are asked for.
    ///
    /// # Safety
    /// `levels` is NULL or a descriptor whose array is as the header demands.
    unsafe fn levels(&self, levels: *const RlvBezierLevels) -> Result<Levels> {
        let default =
            RlvBezierLevels { struct_size: 0, level: 4, levels: std::ptr::null(), level_count: 0, level_stride: 0 };
        // SAFETY: promised by the caller.
        let given = unsafe { read_optional(levels, default) }?;
        if given.levels.is_null() {
            return Levels::uniform(&self.surface, given.level).map_err(|error| error.at("level"));
        }
        // SAFETY: promised by the caller.
        let list = unsafe { Input::new("levels", given.levels, given.level_count, given.level_stride) }?;
        if list.len() != self.surface.count() {
            return Err(Error::invalid(format!(
                "{} levels are given for {} patches",
                list.len(),
                self.surface.count()
            ))
            .at("level_count"));
        }
        // What does not fit a byte is out of range all the same.
        let levels = list.iter().map(|level| u8::try_from(level).unwrap_or(u8::MAX)).collect();
        Levels::new(&self.surface, levels).map_err(|error| error.at("levels"))
    }
}

entry! {
    fn rlv_bezier_create(context: RlvContext, arrays: *const RlvBezierArrays, out: *mut RlvBezier) {
        present("out", out)?;
        let context = registry::get(context)?;
        // SAFETY: a descriptor of nothing but numbers and NULL pointers.
        let default: RlvBezierArrays = unsafe { std::mem::zeroed() };
        // SAFETY: the caller gives a descriptor that starts with its size, or NULL.
        let given = unsafe { read_descriptor(arrays, default) }?;
        // SAFETY: the caller promises `point_count` points and weights, and `index_count` indices.
        let (points, weights, indices) = unsafe {
            (
                Input::new("points", given.points.cast::<[f32; 3]>(), given.point_count, given.point_stride)?,
                Input::optional("weights", given.weights, given.point_count, given.weight_stride)?,
                Input::optional("indices", given.indices, given.index_count, given.index_stride)?,
            )
        };
        let limit = context.context.memory_limit();
        let points = points.to_vec("points", limit)?;
        let weights = weights.map(|weights| weights.to_vec("weights", limit)).transpose()?;
        let indices = indices.map(|indices| indices.to_vec("indices", limit)).transpose()?;
        let surface = BezierSurface::new(&context.context, &points, indices.as_deref(), weights.as_deref())?;
        let handle = registry::insert(BezierObject { context, surface })?;
        // SAFETY: checked above.
        unsafe { put(out, handle) };
        Ok(())
    }

    fn rlv_bezier_read(context: RlvContext, path: *const c_char, out: *mut RlvBezier) {
        present("out", out)?;
        let context = registry::get(context)?;
        // SAFETY: the caller gives NULL or a NUL-terminated text.
        let path = Path::new(unsafe { text("path", path) }?);
        let read = read_patches(&context.context, path)?;
        let surface = BezierSurface::new(&context.context, &read.points, Some(&read.indices), read.weights.as_deref())
            .map_err(|error| error.at(path.display().to_string()))?;
        let handle = registry::insert(BezierObject { context, surface })?;
        // SAFETY: checked above.
        unsafe { put(out, handle) };
        Ok(())
    }

    fn rlv_bezier_retain(bezier: RlvBezier) {
        registry::retain(bezier)
    }

    fn rlv_bezier_release(bezier: RlvBezier) {
        registry::release(bezier)
    }

    fn rlv_bezier_info(bezier: RlvBezier, out: *mut RlvBezierInfo) {
        let object = registry::get(bezier)?;
        let (low, high) = object.surface.total_bounds();
        let info = RlvBezierInfo {
            struct_size: 0,
            is_rational: u32::from(object.surface.is_rational()),
            patch_count: object.surface.count(),
            curve_count: object.surface.edges().curve_count(),
            low,
            high,
        };
        // SAFETY: the caller gives NULL or a descriptor that starts with its size.
        unsafe { write_descriptor(out, info) }
    }

    fn rlv_bezier_get_controls(bezier: RlvBezier, patch: usize, controls: *mut f32, stride: usize) {
        let object = registry::get(bezier)?;
        let found = object.surface.all_controls().get(patch).ok_or_else(|| {
            Error::invalid(format!("there are {} patches and no patch {patch}", object.surface.count())).at("patch")
        })?;
        // SAFETY: the caller promises room for 16 control points.
        let out = unsafe { Output::<[f32; 4]>::new("controls", controls.cast(), CONTROLS, stride) }?;
        out.fill(found.iter().copied());
        Ok(())
    }

    fn rlv_bezier_evaluate(bezier: RlvBezier, arrays: *const RlvEvaluateArrays) {
        let object = registry::get(bezier)?;
        let surface = &object.surface;
        // SAFETY: the caller's arrays are as the header demands.
        let arrays = unsafe { Arrays::new(arrays, |patch, [u, v]| surface.check_place(patch, u, v)) }?;
        arrays.refuse_marks("Bézier patches")?;
        let mut places = Vec::new();
        for first in arrays.starts() {
            arrays.places(first, &mut places);
            let found = surface.evaluate_many(&object.context.context, &places)?;
            let count = found.len();
            write(arrays.positions, first, count, |index| found[index].0.p);
            write(arrays.normals, first, count, |index| found[index].1);
            let derivatives: [fn(&Sample) -> [f32; 3]; 5] =
                [|at| at.du, |at| at.dv, |at| at.duu, |at| at.duv, |at| at.dvv];
            for (out, derivative) in arrays.derivatives.into_iter().zip(derivatives) {
                write(out, first, count, |index| derivative(&found[index].0));
            }
            write(arrays.displacements, first, count, |_| 0.0);
            write(arrays.vectors, first, count, |_| [0.0; 3]);
        }
        Ok(())
    }

    fn rlv_bezier_levels(bezier: RlvBezier, view: *const RlvBezierView, levels: *mut u32, capacity: usize) {
        let object = registry::get(bezier)?;
        // SAFETY: a descriptor of nothing but numbers.
        let default: RlvBezierView = unsafe { std::mem::zeroed() };
        // SAFETY: the caller gives a descriptor that starts with its size, or NULL.
        let given = unsafe { read_descriptor(view, default) }?;
        // SAFETY: the caller promises room for `capacity` levels.
        let out = unsafe { Output::new("levels", levels, capacity, 0) }?.holds("levels", object.surface.count())?;
        let RlvBezierView { eye, forward, pixels, corner, .. } = given;
        let view = Viewpoint { eye, forward, pixels, corner };
        let context = &object.context.context;
        let levels = Levels::select(context, &object.surface, &view, given.tolerance, given.most)?;
        out.fill((0..levels.count()).map(|patch| levels.patch(patch)));
        Ok(())
    }

    fn rlv_bezier_count(
        bezier: RlvBezier,
        levels: *const RlvBezierLevels,
        points: *mut usize,
        triangles: *mut usize,
    ) {
        present("points", points)?;
        present("triangles", triangles)?;
        let object = registry::get(bezier)?;
        // SAFETY: the caller gives NULL or a descriptor as the header demands.
        let levels = unsafe { object.levels(levels) }?;
        let [point_count, triangle_count] = object.surface.tessellated_counts(&levels)?;
        // SAFETY: both were checked above.
        unsafe {
            put(points, point_count);
            put(triangles, triangle_count);
        }
        Ok(())
    }

    fn rlv_bezier_tessellate(
        bezier: RlvBezier,
        levels: *const RlvBezierLevels,
        triangles: *const RlvBezierTriangles,
    ) {
        let object = registry::get(bezier)?;
        // SAFETY: the caller gives NULL or a descriptor as the header demands.
        let levels = unsafe { object.levels(levels) }?;
        // SAFETY: a descriptor of nothing but numbers and NULL pointers.
        let default: RlvBezierTriangles = unsafe { std::mem::zeroed() };
        // SAFETY: the caller gives a descriptor that starts with its size, or NULL.
        let given = unsafe { read_descriptor(triangles, default) }?;
        // SAFETY: the caller promises room for `point_capacity` points and `triangle_capacity` triangles, or NULL.
        let (positions, normals, corners) = unsafe {
            (
                Output::optional("positions", given.positions.cast(), given.point_capacity, given.position_stride)?,
                Output::optional("normals", given.normals.cast(), given.point_capacity, given.normal_stride)?,
                Output::optional("corners", given.corners.cast(), given.triangle_capacity, given.triangle_stride)?,
            )
        };
        let [point_count, triangle_count] = object.surface.tessellated_counts(&levels)?;
        let with_room = |out: Option<Output<[f32; 3]>>, name| out.map(|out| out.holds(name, point_count)).transpose();
        let (positions, normals) = (with_room(positions, "positions")?, with_room(normals, "normals")?);
        let corners: Option<Output<[u32; 3]>> = corners;
        let corners = corners.map(|out| out.holds("corners", triangle_count)).transpose()?;
        let made = object.surface.tessellate(&object.context.context, &levels)?;
        for (out, values) in [(positions, &made.points), (normals, &made.normals)] {
            if let Some(out) = out {
                out.fill(values.iter().copied());
            }
        }
        if let Some(out) = corners {
            out.fill(made.triangles);
        }
        Ok(())
    }

    fn rlv_bezier_mesh(bezier: RlvBezier, levels: *const RlvBezierLevels, out: *mut RlvMesh) {
        present("out", out)?;
        let object = registry::get(bezier)?;
        // SAFETY: the caller gives NULL or a descriptor as the header demands.
        let levels = unsafe { object.levels(levels) }?;
        let made = object.surface.tessellate(&object.context.context, &levels)?;
        let handle = mesh::register(object.context.clone(), made.mesh())?;
        // SAFETY: checked above.
        unsafe { put(out, handle) };
        Ok(())
    }
}
