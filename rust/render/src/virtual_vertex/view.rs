//! The camera, the lights and the objects of a picture, as the shaders have them (`shaders/draw/shade.wgsl`).

use bytemuck::{Pod, Zeroable};
use glam::{DAffine3, DMat3, DMat4, DVec3, DVec4, Mat4, Vec3};
use relievo_gpu::wgsl::shade::{ObjectBlock, SunBlock, ViewBlock};

use super::placed::Placed;
use crate::camera::Camera;
use crate::scene::Material;
use crate::settings::View;
use crate::sky::ClearSky;

/// Suns that are drawn.
pub(super) const SUNS: usize = 4;
/// The near plane, as a share of how far the farthest point of the objects is; what is nearer is cut.
pub(super) const NEAR: f64 = 1e-6;

/// The block of an object, with what aligns one after another as dynamic offsets are.
#[repr(C)]
#[derive(Clone, Copy, Debug, Pod, Zeroable)]
pub(super) struct ObjectSlot {
    block: ObjectBlock,
    padding: [u32; 8],
}

const _: () = assert!(size_of::<ObjectSlot>() == 256);

/// Bytes of a block that are bound.
pub(super) const OBJECT_BYTES: u64 = size_of::<ObjectBlock>() as u64;

/// Smallest and largest coordinates of what is drawn, about the camera.
#[derive(Clone, Copy, Debug)]
pub(super) struct Extent {
    low: DVec3,
    high: DVec3,
}

impl Extent {
    pub fn empty() -> Self {
        Self { low: DVec3::INFINITY, high: DVec3::NEG_INFINITY }
    }

    /// Returns that of some objects.
    pub fn of<'a>(objects: impl Iterator<Item = &'a Placed<'a>>, eye: DVec3) -> Self {
        let mut extent = Self::empty();
        objects.for_each(|object| extent.add(object.bounds(), &object.transform, eye));
        extent
    }

    /// Adds an object that is within `bounds` of its own space.
    pub fn add(&mut self, (low, high): (DVec3, DVec3), transform: &DAffine3, eye: DVec3) {
        for corner in corners(low, high) {
            let p = transform.transform_point3(corner) - eye;
            self.low = self.low.min(p);
            self.high = self.high.max(p);
        }
    }

    /// How far its farthest corner is.
    pub fn farthest(&self) -> f64 {
        if self.low.cmple(self.high).all() { self.low.abs().max(self.high.abs()).length() } else { 1.0 }
    }
}

fn corners(low: DVec3, high: DVec3) -> impl Iterator<Item = DVec3> {
    (0..8).map(move |at| {
        let pick = |axis: usize| if at >> axis & 1 == 1 { high[axis] } else { low[axis] };
        DVec3::new(pick(0), pick(1), pick(2))
    })
}

/// From the space about the camera to the picture: depth goes from 1 at the near plane to 0 at infinity, which spends
/// the float's digits evenly.
pub(super) fn projection(camera: &Camera, [width, height]: [u32; 2], extent: &Extent) -> DMat4 {
    let half = (0.5 * camera.fov).tan();
    let aspect = f64::from(width) / f64::from(height);
    let [right, up, back] = [camera.axes.x_axis, camera.axes.y_axis, camera.axes.z_axis];
    let near = NEAR * extent.farthest();
    let rows = [
        (right / (half * aspect)).extend(0.0),
        (up / half).extend(0.0),
        DVec4::new(0.0, 0.0, 0.0, near),
        (-back).extend(0.0),
    ];
    DMat4::from_cols(rows[0], rows[1], rows[2], rows[3]).transpose()
}

/// From the space about the camera to the shadow map of a sun: all of `extent`, as seen from it, with the width of a
/// texel of `side` along a side.
pub(super) fn shadow(direction: [f32; 3], extent: &Extent, side: u32) -> (DMat4, f64) {
    let toward = Vec3::from(direction).as_dvec3().normalize_or(DVec3::Z);
    let right = toward.any_orthonormal_vector();
    let axes = DMat3::from_cols(right, toward.cross(right), toward).transpose();
    let (mut low, mut high) = (DVec3::INFINITY, DVec3::NEG_INFINITY);
    // Any box will do where nothing throws shadows.
    let is_empty = extent.low.cmpgt(extent.high).any();
    let ends = if is_empty { (DVec3::ZERO, DVec3::ONE) } else { (extent.low, extent.high) };
    for corner in corners(ends.0, ends.1) {
        low = low.min(axes * corner);
        high = high.max(axes * corner);
    }
    let middle = 0.5 * (low + high);
    // A margin for the offsets of look-ups.
    let half = (0.52 * (high - low)).max(DVec3::splat(1e-30));
    let scale = DVec3::new(1.0 / half.x, 1.0 / half.y, -0.5 / half.z);
    let linear = DMat3::from_diagonal(scale) * axes;
    let translation = DVec3::new(0.0, 0.0, 0.5) - scale * middle;
    (DMat4::from(DAffine3 { matrix3: linear, translation }), 2.0 * half.x.max(half.y) / f64::from(side))
}

/// Returns the block of a view. `scale` is by how much the picture is finer than the settings say; `shadows` are those of
/// the suns that have shadow maps.
pub(super) fn view_block(view: &View, scale: f32, shadows: &[(DMat4, f64)]) -> ViewBlock {
    let sky = &view.lights.sky;
    let mut block = ViewBlock {
        forward: (-view.camera.axes.z_axis).as_vec3().to_array(),
        lines: if view.settings.wireframe.is_on() { 1.0 } else { 0.0 },
        up: Vec3::from(sky.up).normalize_or(Vec3::Z).to_array(),
        line_width: view.settings.line_width * scale,
        line_color: view.line_color,
        sun_count: view.lights.suns.len().min(SUNS) as u32,
        false_color: view.settings.false_color,
        suns: [SunBlock::default(); SUNS],
        ..ViewBlock::default()
    };
    for (into, mean) in block.sky.iter_mut().zip(ClearSky::new(sky).means()) {
        *into = mean.extend(0.0).to_array();
    }
    for (into, color) in block.palette.iter_mut().zip(view.false_color.iter().flat_map(|colors| &colors.palette)) {
        *into = Vec3::from(*color).extend(0.0).to_array();
        block.palette_count += 1;
    }
    for (into, sun) in block.suns.iter_mut().zip(&view.lights.suns) {
        into.direction = Vec3::from(sun.direction).normalize_or(Vec3::Z).to_array();
        into.irradiance = sun.irradiance;
    }
    for (into, (matrix, texel)) in block.suns.iter_mut().zip(shadows) {
        into.shadow = matrix.as_mat4().to_cols_array_2d();
        into.texel = *texel as f32;
    }
    block
}

/// Returns the block of an object that `projection` maps from the space about the camera at `eye`. Its parts have numbers of
/// their own if it has none.
pub(super) fn object_slot(
    projection: DMat4,
    eye: DVec3,
    transform: &DAffine3,
    material: &Material,
    number: Option<u32>,
) -> ObjectSlot {
    let about = DAffine3 { matrix3: transform.matrix3, translation: transform.translation - eye };
    let normal = Mat4::from_mat3(about.matrix3.as_mat3().inverse().transpose());
    let block = ObjectBlock {
        clip: (projection * DMat4::from(about)).as_mat4().to_cols_array_2d(),
        world: DMat4::from(about).as_mat4().to_cols_array_2d(),
        normal: normal.to_cols_array_2d(),
        base_color: material.base_color,
        specular: material.specular,
        roughness: material.roughness,
        number: number.unwrap_or(0),
        parts: u32::from(number.is_none()),
        mirrored: u32::from(about.matrix3.determinant() < 0.0),
    };
    ObjectSlot { block, padding: [0; 8] }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn shadow_maps_have_all_of_the_extent() {
        let mut extent = Extent::empty();
        extent.add((DVec3::new(-1.0, 2.0, 0.0), DVec3::new(4.0, 3.0, 5.0)), &DAffine3::IDENTITY, DVec3::splat(7.0));
        for direction in [[0.0, 0.0, 1.0], [0.3, -0.5, 0.2], [-1.0, 0.0, 0.0]] {
            let (matrix, texel) = shadow(direction, &extent, 1000);
            assert!(texel > 0.001 && texel < 0.01, "{texel}");
            for corner in corners(extent.low, extent.high) {
                let p = matrix * corner.extend(1.0);
                assert!(p.x.abs() < 1.0 && p.y.abs() < 1.0 && p.z > 0.0 && p.z < 1.0 && p.w == 1.0, "{p}");
            }
            let toward = Vec3::from(direction).as_dvec3();
            let depth = |p: DVec3| (matrix * p.extend(1.0)).z;
            assert!(depth(toward) < depth(DVec3::ZERO), "what is nearer to the sun has the smaller depth");
        }
    }
}
