//! Subdivision surfaces with primvars; see `include/relievo/subdivision.h`.

use std::ffi::c_char;
use std::sync::{Arc, PoisonError, RwLock};

use relievo_core::{Error, Result};
use relievo_surface::Place;
use relievo_surface::subdivision::{Boundary, FaceVarying, PointRule, Primvar, Rules, Scheme, Subdivision};

use crate::border::array::{Input, Rows, present, put, text};
use crate::border::descriptor::{read_descriptor, read_optional, write_descriptor};
use crate::border::registry::{self, handle, try_read};
use crate::runtime::context::{ContextObject, RlvContext};
use crate::surfaces::mesh::{self, RlvMesh};
use crate::surfaces::surface::{RLV_BOUNDARY_EDGES, RLV_BOUNDARY_EDGES_AND_CORNERS, RLV_BOUNDARY_NONE};

handle!(RlvSubdivision, 35, SubdivisionObject);

constants! {
    u32:
    RLV_SCHEME_CATMULL_CLARK = 0,
    RLV_SCHEME_LOOP = 1,
    RLV_SCHEME_BILINEAR = 2,
    RLV_FACE_VARYING_NONE = 0,
    RLV_FACE_VARYING_CORNERS_ONLY = 1,
    RLV_FACE_VARYING_CORNERS_PLUS_1 = 2,
    RLV_FACE_VARYING_CORNERS_PLUS_2 = 3,
    RLV_FACE_VARYING_BOUNDARIES = 4,
    RLV_FACE_VARYING_ALL = 5,
    RLV_CREASING_UNIFORM = 0,
    RLV_CREASING_CHAIKIN = 1,
    RLV_TRIANGLE_CATMULL_CLARK = 0,
    RLV_TRIANGLE_SMOOTH = 1,
    RLV_POINT_VERTEX = 0,
    RLV_POINT_VARYING = 1,
}

descriptor! {
    pub struct RlvSubdivisionOptions {
        struct_size: u32,
        scheme: u32,
        boundary: u32,
        face_varying: u32,
        creasing: u32,
        triangle_rule: u32,
        isolation: u32,
        reserved: u32,
    }
}

descriptor! {
    pub struct RlvSubdivisionInfo {
        struct_size: u32,
        scheme: u32,
        point_count: usize,
        face_count: usize,
        tile_count: usize,
    }
}

descriptor! {
    pub struct RlvSubdivisionArrays {
        struct_size: u32,
        point_rule: u32,
        count: usize,
        tiles: *const u32,
        tile_stride: usize,
        uvs: *const f32,
        uv_stride: usize,
        values: *mut f32,
        value_stride: usize,
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
    }
}

/// Places evaluated between two writes to the caller's arrays, which bounds the memory of a call.
const CHUNK: usize = 1 << 16;

/// A subdivision surface whose pose can be replaced while others read the one before.
pub struct SubdivisionObject {
    context: Arc<ContextObject>,
    subdivision: Subdivision,
    points: RwLock<Arc<[[f32; 3]]>>,
}

impl SubdivisionObject {
    fn points(&self) -> Arc<[[f32; 3]]> {
        self.points.read().unwrap_or_else(PoisonError::into_inner).clone()
    }
}

/// Returns the choice that `number` stands for.
fn choose<T: Copy>(number: u32, choices: &[(u32, T)], field: &str, prefix: &str) -> Result<T> {
    let found = choices.iter().find(|(choice, _)| *choice == number);
    found.map(|(_, choice)| *choice).ok_or_else(|| {
        Error::invalid(format!("{number} is none of its values")).at(field).advise(format!("use an {prefix} value"))
    })
}

fn rules(given: &RlvSubdivisionOptions) -> Result<Rules> {
    let schemes = [
        (RLV_SCHEME_CATMULL_CLARK, Scheme::CatmullClark),
        (RLV_SCHEME_LOOP, Scheme::Loop),
        (RLV_SCHEME_BILINEAR, Scheme::Bilinear),
    ];
    let boundaries = [
        (RLV_BOUNDARY_EDGES_AND_CORNERS, Boundary::EdgesAndCorners),
        (RLV_BOUNDARY_EDGES, Boundary::Edges),
        (RLV_BOUNDARY_NONE, Boundary::None),
    ];
    let face_varying = [
        (RLV_FACE_VARYING_NONE, FaceVarying::None),
        (RLV_FACE_VARYING_CORNERS_ONLY, FaceVarying::CornersOnly),
        (RLV_FACE_VARYING_CORNERS_PLUS_1, FaceVarying::CornersPlus1),
        (RLV_FACE_VARYING_CORNERS_PLUS_2, FaceVarying::CornersPlus2),
        (RLV_FACE_VARYING_BOUNDARIES, FaceVarying::Boundaries),
        (RLV_FACE_VARYING_ALL, FaceVarying::All),
    ];
    let creasing = [(RLV_CREASING_UNIFORM, false), (RLV_CREASING_CHAIKIN, true)];
    let triangles = [(RLV_TRIANGLE_CATMULL_CLARK, false), (RLV_TRIANGLE_SMOOTH, true)];
    if given.isolation > 10 {
        return Err(Error::invalid(format!("{} levels of isolation are too many", given.isolation))
            .at("isolation")
            .advise("use 1 to 10, or 0 for the default"));
    }
    Ok(Rules {
        scheme: choose(given.scheme, &schemes, "scheme", "RLV_SCHEME_")?,
        boundary: choose(given.boundary, &boundaries, "boundary", "RLV_BOUNDARY_")?,
        face_varying: choose(given.face_varying, &face_varying, "face_varying", "RLV_FACE_VARYING_")?,
        chaikin: choose(given.creasing, &creasing, "creasing", "RLV_CREASING_")?,
        smooth_triangles: choose(given.triangle_rule, &triangles, "triangle_rule", "RLV_TRIANGLE_")?,
        isolation: if given.isolation == 0 { 6 } else { given.isolation },
    })
}

entry! {
    fn rlv_subdivision_create(
        context: RlvContext,
        cage: RlvMesh,
        options: *const RlvSubdivisionOptions,
        out: *mut RlvSubdivision,
    ) {
        present("out", out)?;
        let context = registry::get(context)?;
        let mesh_object = registry::get(cage)?;
        let default = RlvSubdivisionOptions {
            struct_size: 0,
            scheme: RLV_SCHEME_CATMULL_CLARK,
            boundary: RLV_BOUNDARY_EDGES_AND_CORNERS,
            face_varying: RLV_FACE_VARYING_CORNERS_ONLY,
            creasing: RLV_CREASING_UNIFORM,
            triangle_rule: RLV_TRIANGLE_CATMULL_CLARK,
            isolation: 0,
            reserved: 0,
        };
        // SAFETY: the caller gives NULL or a descriptor that starts with its size.
        let rules = rules(&unsafe { read_optional(options, default) }?)?;
        let cage = Arc::new(try_read(&mesh_object.mesh, "mesh")?.clone());
        let points = RwLock::new(cage.points.as_slice().into());
        let subdivision = Subdivision::new(&context.context, cage, &rules)?;
        let handle = registry::insert(SubdivisionObject { context, subdivision, points })?;
        // SAFETY: checked above.
        unsafe { put(out, handle) };
        Ok(())
    }

    fn rlv_subdivision_retain(subdivision: RlvSubdivision) {
        registry::retain(subdivision)
    }

    fn rlv_subdivision_release(subdivision: RlvSubdivision) {
        registry::release(subdivision)
    }

    fn rlv_subdivision_info(subdivision: RlvSubdivision, out: *mut RlvSubdivisionInfo) {
        let object = registry::get(subdivision)?;
        let surface = &object.subdivision;
        let info = RlvSubdivisionInfo {
            struct_size: 0,
            scheme: match surface.rules().scheme {
                Scheme::CatmullClark => RLV_SCHEME_CATMULL_CLARK,
                Scheme::Loop => RLV_SCHEME_LOOP,
                Scheme::Bilinear => RLV_SCHEME_BILINEAR,
            },
            point_count: surface.mesh().points.len(),
            face_count: surface.mesh().face_count(),
            tile_count: surface.tile_count(),
        };
        // SAFETY: the caller gives NULL or a descriptor that starts with its size.
        unsafe { write_descriptor(out, info) }
    }

    fn rlv_subdivision_set_points(
        subdivision: RlvSubdivision,
        points: *const f32,
        count: usize,
        stride: usize,
    ) {
        let object = registry::get(subdivision)?;
        // SAFETY: the caller promises `count` points.
        let points = unsafe { Input::new("points", points.cast::<[f32; 3]>(), count, stride) }?;
        let expected = object.subdivision.mesh().points.len();
        if count != expected {
            return Err(Error::invalid(format!("the pose has {count} points, the cage {expected}")).at("count"));
        }
        let points = points.to_vec("points", object.context.context.memory_limit())?;
        if let Some(index) = points.iter().position(|point| !point.iter().all(|value| value.is_finite())) {
            return Err(Error::invalid("a coordinate is not a finite number").at(format!("point {index}")));
        }
        *object.points.write().unwrap_or_else(PoisonError::into_inner) = points.into();
        Ok(())
    }

    fn rlv_subdivision_face_tiles(
        subdivision: RlvSubdivision,
        face: u32,
        first: *mut u32,
        count: *mut u32,
    ) {
        present("first", first)?;
        present("count", count)?;
        let object = registry::get(subdivision)?;
        let tiles = object.subdivision.tiles(face).ok_or_else(|| {
            Error::invalid(format!("face {face} does not exist"))
                .at("face")
                .advise(format!("the cage has {} faces", object.subdivision.mesh().face_count()))
        })?;
        // SAFETY: both were checked above.
        unsafe {
            put(first, tiles.start);
            put(count, tiles.len() as u32);
        }
        Ok(())
    }

    fn rlv_subdivision_evaluate(
        subdivision: RlvSubdivision,
        attribute: *const c_char,
        arrays: *const RlvSubdivisionArrays,
    ) {
        let object = registry::get(subdivision)?;
        let (surface, context) = (&object.subdivision, &object.context.context);
        // SAFETY: a descriptor of nothing but numbers and NULL pointers.
        let default: RlvSubdivisionArrays = unsafe { std::mem::zeroed() };
        // SAFETY: the caller gives a descriptor that starts with its size, or NULL.
        let given = unsafe { read_descriptor(arrays, default) }?;
        let rules = [(RLV_POINT_VERTEX, PointRule::Vertex), (RLV_POINT_VARYING, PointRule::Varying)];
        let rule = choose(given.point_rule, &rules, "point_rule", "RLV_POINT_")?;
        let points = object.points();
        let primvar = if attribute.is_null() {
            Primvar::Points(&points)
        } else {
            // SAFETY: the caller gives NULL or a NUL-terminated text.
            Primvar::Attribute(unsafe { text("attribute", attribute) }?, rule)
        };
        let (width, count) = (surface.width(primvar)?, given.count);
        // SAFETY: the caller promises `count` tiles and places.
        let (tiles, uvs) = unsafe {
            (
                Input::new("tiles", given.tiles, count, given.tile_stride)?,
                Input::new("uvs", given.uvs.cast::<[f32; 2]>(), count, given.uv_stride)?,
            )
        };
        // SAFETY: the caller promises `count` values unless the pointer is NULL.
        let rows = |name, pointer: *mut f32, stride| unsafe {
            Rows::optional((name, pointer.cast(), count, stride), width)
        };
        let outputs = [
            rows("values", given.values, given.value_stride)?,
            rows("du", given.du, given.du_stride)?,
            rows("dv", given.dv, given.dv_stride)?,
            rows("duu", given.duu, given.duu_stride)?,
            rows("duv", given.duv, given.duv_stride)?,
            rows("dvv", given.dvv, given.dvv_stride)?,
        ];
        let place = |index| {
            let [u, v] = uvs.get(index);
            Place { tile: tiles.get(index), u, v }
        };
        for index in 0..count {
            surface.check_place(place(index)).map_err(|error| error.at(format!("place {index}")))?;
        }
        let derivatives = match outputs.iter().rposition(Option::is_some) {
            None | Some(0) => 0,
            Some(1 | 2) => 1,
            Some(_) => 2,
        };
        let (mut places, mut found) = (Vec::new(), Vec::new());
        for first in (0..count).step_by(CHUNK) {
            places.clear();
            places.extend((first..count.min(first + CHUNK)).map(place));
            surface.evaluate(context, primvar, &places, derivatives, &mut found)?;
            for (index, result) in found.chunks_exact(6 * width).enumerate() {
                for (output, numbers) in outputs.iter().zip(result.chunks_exact(width)) {
                    if let Some(output) = output {
                        output.set(first + index, numbers.iter().map(|number| number.to_bits()));
                    }
                }
            }
        }
        Ok(())
    }

    fn rlv_subdivision_refine(subdivision: RlvSubdivision, level: u32, out: *mut RlvMesh) {
        present("out", out)?;
        let object = registry::get(subdivision)?;
        let refined = object.subdivision.refined(&object.context.context, &object.points(), level)?;
        let handle = mesh::register(object.context.clone(), refined)?;
        // SAFETY: checked above.
        unsafe { put(out, handle) };
        Ok(())
    }
}
