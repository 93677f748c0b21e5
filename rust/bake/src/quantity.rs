//! What is baked: numbers of the surface at its places.
//!
//! Tangent space is that of the undisplaced limit surface: N is its normal, T the direction of increasing s across N,
//! and B completes them so that it goes along increasing t, on mirrored texture coordinates too. That is what
//! MikkTSpace (Mikkelsen 2008) tends to where a host tessellates finely. Values are raw: object units for displacement,
//! unit vectors for normals, linear Rec.709 for colours.

use glam::{Vec3, Vec4};
use relievo_core::{Context, Error, Result};
use relievo_surface::{Order, Place, Samples, Surface};
use relievo_tiles::texel::Vector;
use relievo_tiles::trace::Trace;
use relievo_tiles::{ColorTexel, Displaced, Field, Points, Texel};

/// The space of a vector.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Space {
    /// The object's own axes.
    Object,
    /// The tangent space of the texture coordinates.
    Tangent,
}

/// In what order a vector's parts in tangent space are stored.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Axes {
    /// T, B, N: as normal maps have them.
    Tbn,
    /// T, N, B: as the vector displacement of Blender's Cycles and of Mudbox takes them.
    Tnb,
}

/// Which way the second number of a tangent-space normal points.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Handedness {
    /// Along increasing t, as OpenGL, Blender and Maya have it.
    OpenGl,
    /// Against it, as DirectX and Unreal have it.
    DirectX,
}

/// Colours that can be looked up, whatever their texels.
pub trait Colors: Sync + std::fmt::Debug {
    /// The linear colour and alpha at a place, in its own tile.
    fn color(&self, place: Place) -> Vec4;

    /// Number of tiles.
    fn tiles(&self) -> usize;
}

impl<T: ColorTexel> Colors for Field<T> {
    fn color(&self, place: Place) -> Vec4 {
        Field::color(self, place)
    }

    fn tiles(&self) -> usize {
        self.tile_count()
    }
}

/// What is baked, and of what.
#[derive(Clone, Copy, Debug)]
pub enum Quantity<'a> {
    /// The scalar displacement along the normal. One number.
    Displacement(&'a Field),
    /// From the undisplaced surface to the displaced one. Three numbers.
    Vector(Displaced<'a>, Space, Axes),
    /// The normal of the displaced surface. Three numbers.
    Normal(Displaced<'a>, Space, Handedness),
    /// Colour and alpha, which it is not multiplied by. Four numbers.
    Color(&'a dyn Colors),
    /// The alpha of colours: where something was painted. One number.
    Mask(&'a dyn Colors),
    /// Where colliders have pushed, 0 to 1. One number.
    Contact(&'a Field<Trace>),
    /// How far colliders have pushed in all, object units. One number.
    Depth(&'a Field<Trace>),
    /// When a collider pushed last, seconds; −1 where none ever did. One number.
    Time(&'a Field<Trace>),
}

/// What the numbers of a bake are, whatever they are of.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Meaning {
    /// See [`Quantity::Displacement`].
    Displacement,
    /// See [`Quantity::Vector`].
    Vector(Space, Axes),
    /// See [`Quantity::Normal`].
    Normal(Space, Handedness),
    /// See [`Quantity::Color`].
    Color,
    /// See [`Quantity::Mask`].
    Mask,
    /// See [`Quantity::Contact`].
    Contact,
    /// See [`Quantity::Depth`].
    Depth,
    /// See [`Quantity::Time`].
    Time,
}

impl Meaning {
    /// Numbers of a pixel.
    pub fn channels(self) -> usize {
        match self {
            Meaning::Displacement | Meaning::Mask => 1,
            Meaning::Contact | Meaning::Depth | Meaning::Time => 1,
            Meaning::Vector(..) | Meaning::Normal(..) => 3,
            Meaning::Color => 4,
        }
    }

    /// What stands where nothing lies.
    pub(crate) fn background(self) -> &'static [f32] {
        match self {
            Meaning::Normal(Space::Tangent, _) => &[0.0, 0.0, 1.0],
            Meaning::Time => &[-1.0],
            _ => &[0.0; 4][..self.channels()],
        }
    }
}

impl Quantity<'_> {
    /// What its numbers are.
    pub fn meaning(&self) -> Meaning {
        match self {
            Quantity::Displacement(_) => Meaning::Displacement,
            Quantity::Vector(_, space, axes) => Meaning::Vector(*space, *axes),
            Quantity::Normal(_, space, handedness) => Meaning::Normal(*space, *handedness),
            Quantity::Color(_) => Meaning::Color,
            Quantity::Mask(_) => Meaning::Mask,
            Quantity::Contact(_) => Meaning::Contact,
            Quantity::Depth(_) => Meaning::Depth,
            Quantity::Time(_) => Meaning::Time,
        }
    }

    /// Numbers of a pixel.
    pub fn channels(&self) -> usize {
        self.meaning().channels()
    }

    /// As far as the numbers may go from 0: where lengths or times are to fit into a picture.
    pub fn largest(&self) -> f32 {
        match self {
            Quantity::Displacement(field) => largest(field),
            Quantity::Vector(displaced, ..) => {
                // A vector is no longer than the root of three times its largest part squared.
                largest(displaced.field()) + 1.8 * displaced.vectors().map_or(0.0, largest_part)
            }
            Quantity::Depth(traces) => texels(traces).map(|trace| trace.depth.to_f32()).fold(0.0, f32::max),
            Quantity::Time(traces) => texels(traces).map(|trace| trace.moment).fold(0.0, f32::max),
            Quantity::Normal(..) | Quantity::Color(_) | Quantity::Mask(_) | Quantity::Contact(_) => 1.0,
        }
    }

    /// Appends the numbers at each of `places`, which are of the surface that has the texture coordinates `limit`.
    pub(crate) fn evaluate(
        &self,
        context: &Context,
        limit: &Surface,
        places: &[Place],
        out: &mut Vec<f32>,
    ) -> Result<()> {
        match self {
            Quantity::Displacement(field) => {
                out.extend(places.iter().map(|place| field.point(context.level(), *place).d));
            }
            Quantity::Color(colors) => out.extend(places.iter().flat_map(|place| colors.color(*place).to_array())),
            Quantity::Mask(colors) => out.extend(places.iter().map(|place| colors.color(*place).w)),
            Quantity::Contact(traces) => out.extend(places.iter().map(|place| traces.mark(*place).contact)),
            Quantity::Depth(traces) => out.extend(places.iter().map(|place| traces.mark(*place).depth)),
            Quantity::Time(traces) => out.extend(places.iter().map(|place| traces.mark(*place).time.unwrap_or(-1.0))),
            Quantity::Vector(displaced, space, axes) => {
                let mut moved = Points::default();
                displaced.evaluate_in_place(context, places, &mut moved)?;
                let mut still = Samples::default();
                displaced.surface().evaluate(context, places, Order::First, &mut still)?;
                let frames = match space {
                    Space::Object => Vec::new(),
                    Space::Tangent => frames(context, limit, places, &still)?,
                };
                for (k, p) in moved.p.iter().enumerate() {
                    let from = at(&still.p, k);
                    let vector = Vec3::from(*p) - from;
                    let parts = frames.get(k).map_or(vector, |[t, b, n]| match axes {
                        Axes::Tbn => Vec3::new(vector.dot(*t), vector.dot(*b), vector.dot(*n)),
                        Axes::Tnb => Vec3::new(vector.dot(*t), vector.dot(*n), vector.dot(*b)),
                    });
                    out.extend(parts.to_array());
                }
            }
            Quantity::Normal(displaced, space, handedness) => {
                let mut moved = Points::default();
                displaced.evaluate_in_place(context, places, &mut moved)?;
                let frames = match space {
                    Space::Object => Vec::new(),
                    Space::Tangent => {
                        let mut still = Samples::default();
                        displaced.surface().evaluate(context, places, Order::First, &mut still)?;
                        frames(context, limit, places, &still)?
                    }
                };
                let up = if *handedness == Handedness::OpenGl { 1.0 } else { -1.0 };
                for (k, normal) in moved.normal.iter().enumerate() {
                    let normal = Vec3::from(*normal);
                    let turned = |[t, b, n]: &[Vec3; 3]| Vec3::new(normal.dot(*t), up * normal.dot(*b), normal.dot(*n));
                    out.extend(frames.get(k).map_or(normal, turned).to_array());
                }
            }
        }
        Ok(())
    }

    /// What the mean of several values is to be: normals have length 1.
    pub(crate) fn settle(&self, value: &mut [f32]) {
        if let (Quantity::Normal(..), [x, y, z]) = (self, value) {
            let normal = Vec3::new(*x, *y, *z).normalize_or_zero();
            (*x, *y, *z) = (normal.x, normal.y, normal.z);
        }
    }

    /// Fails unless it is of a surface with as many tiles as `limit`.
    pub(crate) fn check(&self, limit: &Surface) -> Result<()> {
        let tiles = match self {
            Quantity::Displacement(field) => field.tile_count(),
            Quantity::Vector(displaced, ..) | Quantity::Normal(displaced, ..) => displaced.field().tile_count(),
            Quantity::Contact(traces) | Quantity::Depth(traces) | Quantity::Time(traces) => traces.tile_count(),
            Quantity::Color(colors) | Quantity::Mask(colors) => colors.tiles(),
        };
        if tiles != limit.tile_count() {
            return Err(Error::invalid("the texture coordinates are of another surface than what is baked"));
        }
        Ok(())
    }
}

/// The largest number that coefficients allow.
pub fn largest(field: &Field) -> f32 {
    field.allocated().flat_map(|tile| field.range(tile)).fold(0.0, |most, value| most.max(value.abs()))
}

/// The largest part of a vector that coefficients allow.
pub fn largest_part(vectors: &Field<Vector>) -> f32 {
    texels(vectors).flat_map(|vector| vector.0).fold(0.0, |most, value| most.max(value.to_f32().abs()))
}

fn texels<T: Texel>(field: &Field<T>) -> impl Iterator<Item = &T> {
    field.allocated().filter_map(|tile| field.block(tile)).flatten()
}

fn at(values: &[Vec<f32>; 3], k: usize) -> Vec3 {
    Vec3::new(values[0][k], values[1][k], values[2][k])
}

/// T, B and N at places whose limit points and tangents are `still`. Where the texture coordinates are degenerate, T is
/// along u.
fn frames(context: &Context, limit: &Surface, places: &[Place], still: &Samples) -> Result<Vec<[Vec3; 3]>> {
    let mut coordinates = Samples::default();
    limit.evaluate(context, places, Order::First, &mut coordinates)?;
    let frame = |k: usize| {
        let (p_u, p_v) = (at(&still.du, k), at(&still.dv, k));
        let (uv_u, uv_v) = (at(&coordinates.du, k), at(&coordinates.dv, k));
        let n = p_u.cross(p_v).try_normalize().unwrap_or(Vec3::Z);
        let sign = if uv_u.x * uv_v.y - uv_u.y * uv_v.x < 0.0 { -1.0 } else { 1.0 };
        let along = sign * (p_u * uv_v.y - p_v * uv_u.y);
        let across = |p: Vec3| p - n * n.dot(p);
        let t = across(along).try_normalize().or_else(|| across(p_u).try_normalize());
        let t = t.unwrap_or_else(|| n.any_orthonormal_vector());
        [t, sign * n.cross(t), n]
    };
    Ok((0..places.len()).map(frame).collect())
}
