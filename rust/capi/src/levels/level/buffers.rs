//! The buffers of a host that levels are written to.

use std::ops::Range;

use relievo_core::Result;
use relievo_lod::Progressive;
use relievo_lod::progressive::{Buffers, Update};

use crate::border::array::{Output, Rows};

descriptor! {
    pub struct RlvLevelBuffers {
        struct_size: u32,
        is_whole: u32,
        points: *mut f32,
        point_stride: usize,
        normals: *mut f32,
        normal_stride: usize,
        vertex_capacity: usize,
        triangles: *mut u32,
        triangle_stride: usize,
        triangle_capacity: usize,
        wedges: *mut u32,
        wedge_stride: usize,
        wedge_values: *mut f32,
        wedge_value_stride: usize,
        wedge_capacity: usize,
        face_values: *mut u32,
        face_value_stride: usize,
    }
}

descriptor! {
    pub struct RlvLevelUpdate {
        struct_size: u32,
        reserved: u32,
        vertex_count: usize,
        triangle_count: usize,
        first_vertex: usize,
        changed_vertex_count: usize,
        first_triangle: usize,
        changed_triangle_count: usize,
        wedge_count: usize,
        first_wedge: usize,
        changed_wedge_count: usize,
    }
}

impl RlvLevelUpdate {
    /// What an update has done.
    pub fn of(update: &Update) -> Self {
        let [vertices, triangles, wedges] =
            [&update.changed_vertices, &update.changed_triangles, &update.changed_wedges].map(|ranges| span(ranges));
        Self {
            struct_size: 0,
            reserved: 0,
            vertex_count: update.vertices,
            triangle_count: update.triangles,
            first_vertex: vertices.start,
            changed_vertex_count: vertices.len(),
            first_triangle: triangles.start,
            changed_triangle_count: triangles.len(),
            wedge_count: update.wedges,
            first_wedge: wedges.start,
            changed_wedge_count: wedges.len(),
        }
    }
}

/// From the first element of ascending ranges to the last one.
fn span(ranges: &[Range<u32>]) -> Range<usize> {
    match ranges {
        [first, .., last] => first.start as usize..last.end as usize,
        [only] => only.start as usize..only.end as usize,
        [] => 0..0,
    }
}

/// A host's buffers.
pub struct HostBuffers {
    pub points: Output<[f32; 3]>,
    normals: Option<Output<[f32; 3]>>,
    pub triangles: Output<[u32; 3]>,
    wedges: Option<Output<[u32; 3]>>,
    wedge_values: Option<Rows>,
    face_values: Option<Rows>,
}

impl HostBuffers {
    /// Those of a level of `whole`.
    ///
    /// # Errors
    /// Fails with `Invalid` if a pointer or stride cannot be used, or there is too little room for wedges.
    ///
    /// # Safety
    /// There is room for the capacities.
    pub unsafe fn new(given: &RlvLevelBuffers, whole: &Progressive) -> Result<Self> {
        let [width, face_width] = whole.attribute_widths();
        let values = given.wedge_values.cast::<u32>();
        let (points, normals) = (given.points.cast::<[f32; 3]>(), given.normals.cast::<[f32; 3]>());
        // SAFETY: promised by the caller.
        let made = unsafe {
            Self {
                points: Output::new("points", points, given.vertex_capacity, given.point_stride)?,
                normals: Output::optional("normals", normals, given.vertex_capacity, given.normal_stride)?,
                triangles: Output::new(
                    "triangles",
                    given.triangles.cast::<[u32; 3]>(),
                    given.triangle_capacity,
                    given.triangle_stride,
                )?,
                wedges: Output::optional(
                    "wedges",
                    given.wedges.cast::<[u32; 3]>(),
                    given.triangle_capacity,
                    given.wedge_stride,
                )?,
                wedge_values: Rows::optional(
                    ("wedge_values", values, given.wedge_capacity, given.wedge_value_stride),
                    width,
                )?,
                face_values: Rows::optional(
                    ("face_values", given.face_values, given.triangle_capacity, given.face_value_stride),
                    face_width,
                )?,
            }
        };
        if let Some(rows) = &made.wedge_values {
            rows.holds("wedge_values", whole.wedge_count())?;
        }
        Ok(made)
    }
}

impl Buffers for HostBuffers {
    fn set_vertex(&mut self, place: usize, point: [f32; 3], normal: [f32; 3]) {
        self.points.set(place, point);
        if let Some(normals) = &self.normals {
            normals.set(place, normal);
        }
    }

    fn set_triangle(&mut self, place: usize, vertices: [u32; 3]) {
        self.triangles.set(place, vertices);
    }

    fn set_wedge(&mut self, place: usize, values: &[f32]) {
        if let Some(rows) = &self.wedge_values {
            rows.set(place, values.iter().map(|value| value.to_bits()));
        }
    }

    fn set_corners(&mut self, place: usize, wedges: [u32; 3], values: &[u32]) {
        if let Some(list) = &self.wedges {
            list.set(place, wedges);
        }
        if let Some(rows) = &self.face_values {
            rows.set(place, values.iter().copied());
        }
    }
}
