//! The triangles that are drawn: they follow the object, and say which of their points changed.
//!
//! How finely faces are divided stays the same while a stroke is drawn, so that an event costs what it changed. Where a
//! stroke left more detail than its faces show, [`Triangles::refine`] divides them anew.

use std::ops::Range;

use relievo_core::{Context, Error, Marks, Mesh, Result, Values};
use relievo_decal::{Artwork, Decal, Print, Printed, TrianglePrint};
use relievo_detail::{AnyObject, DisplacedObject, TriangleObject};
use relievo_document::{Kind, Settings};
use relievo_tiles::triangle::{FaceRates, Offset, Pattern, TriangleField, TriangleTessellation};
use relievo_tiles::{
    ByFormat, Field, Rgba8, Rgba16, Tessellation, Tessellator, Texel, Vector, by_format, uniform_rates,
};

use crate::drawing::shaded::Arrays;

/// Triangles that faces are divided into at most, however fine their details are.
const MAX_TRIANGLES: u64 = 6_000_000;

/// The most cells along an edge of a face.
const FINEST: u32 = 256;

/// What colours stand for.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Shades {
    /// What is painted.
    #[default]
    Paint,
    /// Whether a face has detail, and whether the last edit changed it.
    Tiles,
    /// Texels along the edges of faces that have detail.
    Density,
}

impl Shades {
    /// All of them with the names that a user sees.
    pub const NAMES: [(Self, &str); 3] = [(Self::Paint, "paint"), (Self::Tiles, "tiles"), (Self::Density, "density")];

    /// The colours, linear Rec.709, and what they stand for. They can be told apart by the colour-blind (Okabe and Ito 2008;
    /// cividis).
    pub fn legend(self) -> &'static [(u32, &'static str)] {
        match self {
            Self::Paint => &[],
            Self::Tiles => &[(0xBBBBBB, "no detail"), (0x56B4E9, "detail"), (0xE69F00, "changed last")],
            Self::Density => &[
                (0xBBBBBB, "no detail"),
                (0x00204D, "8 texels an edge"),
                (0x31446B, "16"),
                (0x666970, "32"),
                (0x958F78, "64"),
                (0xCBBA69, "128"),
                (0xFFEA46, "256"),
            ],
        }
    }
}

/// The triangles of an object.
pub(crate) struct Triangles {
    made: Made,
    shades: Shades,
    /// The colours of points where they do not stand for paint.
    shaded: Vec<[f32; 3]>,
    /// The tiles that the last change was of.
    recent: Vec<u32>,
    /// Points that changed since they were last listed.
    marks: Marks,
    /// Cells along the edges of faces without detail.
    cells: u32,
    /// Counts how often the triangles became others.
    pub(crate) serial: u64,
}

enum Made {
    Surface { rates: Vec<u32>, tessellator: Tessellator, made: Tessellation, shown: Box<Tiles> },
    Triangles { rates: Vec<FaceRates>, made: TriangleTessellation, shown: Faces },
}

/// What of a surface the triangles show. Copies share their tiles until these are written.
struct Tiles {
    heights: Field,
    vectors: Option<Field<Vector>>,
    colors: Option<ByFormat<Field<Rgba8>, Field<Rgba16>>>,
}

/// What of a triangle mesh the triangles show.
struct Faces {
    heights: TriangleField,
    vectors: Option<TriangleField<Offset>>,
    colors: Option<ByFormat<TriangleField<Rgba8>, TriangleField<Rgba16>>>,
}

impl Tiles {
    fn of(object: &DisplacedObject) -> Self {
        Self {
            heights: object.displacement().field().clone(),
            vectors: object.vectors().map(|vectors| vectors.field().clone()),
            colors: object.colors().map(|colors| match colors {
                ByFormat::Rgba8(field) => ByFormat::Rgba8(field.clone()),
                ByFormat::Rgba16(field) => ByFormat::Rgba16(field.clone()),
            }),
        }
    }
}

impl Faces {
    fn of(object: &TriangleObject) -> Self {
        Self {
            heights: object.displacement().field().clone(),
            vectors: object.offsets().map(|(offsets, _)| offsets.clone()),
            colors: object.colors().map(|colors| match colors {
                ByFormat::Rgba8(field) => ByFormat::Rgba8(field.clone()),
                ByFormat::Rgba16(field) => ByFormat::Rgba16(field.clone()),
            }),
        }
    }
}

impl Triangles {
    /// Divides all faces into `cells` along an edge, or more where details are finer.
    ///
    /// # Errors
    /// `mesh` is not the one that the object is of, or memory runs out.
    pub(crate) fn new(context: &Context, object: &AnyObject, mesh: &Mesh, cells: u32) -> Result<Self> {
        let made = Made::new(context, object, mesh, cells)?;
        Ok(Self {
            marks: Marks::new(made.mesh().points.len()),
            made,
            shades: Shades::Paint,
            shaded: Vec::new(),
            recent: Vec::new(),
            cells,
            serial: 0,
        })
    }

    /// Divides faces anew if details are finer than they show. Returns whether it did.
    ///
    /// # Errors
    /// Those of [`Self::new`].
    pub(crate) fn refine(&mut self, context: &Context, object: &AnyObject, mesh: &Mesh) -> Result<bool> {
        let is_fine = match (&self.made, object) {
            (Made::Surface { rates, .. }, AnyObject::Tiles(object)) => *rates == surface_rates(object, self.cells),
            (Made::Triangles { rates, .. }, AnyObject::Triangles(object)) => {
                *rates == face_rates(context, object, self.cells)
            }
            _ => false,
        };
        if !is_fine {
            self.made = Made::new(context, object, mesh, self.cells)?;
            self.marks = Marks::new(self.mesh().points.len());
            self.shaded = self.shade(object);
            self.serial += 1;
        }
        Ok(!is_fine)
    }

    /// Brings the triangles to what the object is now. `ranges` become the points that changed, as [`Marks::take`] lists
    /// them.
    ///
    /// # Errors
    /// The object is another one, or memory runs out.
    pub(crate) fn update(&mut self, context: &Context, object: &AnyObject, ranges: &mut Vec<Range<u32>>) -> Result<()> {
        let Self { made, marks, recent, .. } = self;
        let changed = made.update(context, object, marks)?;
        if !changed.is_empty() {
            *recent = changed;
        }
        marks.take(ranges);
        if self.shades != Shades::Paint {
            self.reshade(object, ranges);
        }
        Ok(())
    }

    /// What colours stand for.
    pub(crate) fn shades(&self) -> Shades {
        self.shades
    }

    /// Has colours stand for something else. The points whose colours change are added to `ranges`.
    pub(crate) fn set_shades(&mut self, object: &AnyObject, shades: Shades, ranges: &mut Vec<Range<u32>>) {
        self.shades = shades;
        self.shaded = self.shade(object);
        ranges.clear();
        ranges.push(0..self.points().len() as u32);
    }

    /// Makes the colours that do not stand for paint anew, and adds the points whose colours changed to `ranges`.
    fn reshade(&mut self, object: &AnyObject, ranges: &mut Vec<Range<u32>>) {
        let new = self.shade(object);
        let differ = |at: &usize| self.shaded.get(*at) != new.get(*at);
        for at in (0..new.len()).filter(differ) {
            match ranges.last_mut() {
                Some(last) if last.end == at as u32 => last.end += 1,
                _ => ranges.push(at as u32..at as u32 + 1),
            }
        }
        ranges.sort_unstable_by_key(|range| range.start);
        self.shaded = new;
    }

    /// Makes a colour for each point that stands for what its faces are; none where colours stand for paint.
    fn shade(&self, object: &AnyObject) -> Vec<[f32; 3]> {
        let palette: Vec<[f32; 3]> =
            self.shades.legend().iter().map(|(hex, _)| relievo_render::color::from_hex(*hex)).collect();
        if palette.is_empty() {
            return Vec::new();
        }
        let density = |tile: u32| match object {
            AnyObject::Tiles(object) => {
                let colors = object.colors().map_or(0, |colors| by_format!(colors, field => field.density(tile)));
                let vectors = object.vectors().map_or(0, |vectors| vectors.field().density(tile));
                object.displacement().field().density(tile).max(colors).max(vectors)
            }
            AnyObject::Triangles(object) => {
                let heights = object.displacement().field().face_pattern(tile);
                let colors = object.colors().and_then(|colors| by_format!(colors, field => field.face_pattern(tile)));
                heights.max(colors).map_or(0, |pattern| pattern.segments())
            }
        };
        let rank = |tile: u32| match (density(tile), self.shades) {
            (0, _) => 0,
            (_, Shades::Tiles) => 1 + usize::from(self.recent.binary_search(&tile).is_ok()),
            (texels, _) => (texels.ilog2().saturating_sub(2) as usize).clamp(1, palette.len() - 1),
        };
        let mut ranks = vec![0_u8; self.points().len()];
        let tiles = match &self.made {
            Made::Surface { made, .. } => &made.tiles,
            Made::Triangles { made, .. } => &made.tiles,
        };
        let mut last = (u32::MAX, 0);
        for (corners, tile) in self.corners().as_chunks::<3>().0.iter().zip(tiles) {
            if last.0 != *tile {
                last = (*tile, rank(*tile) as u8);
            }
            for corner in corners {
                let found = &mut ranks[*corner as usize];
                *found = last.1.max(*found);
            }
        }
        ranks.into_iter().map(|rank| palette[rank as usize]).collect()
    }

    /// The mesh.
    pub(crate) fn mesh(&self) -> &Mesh {
        self.made.mesh()
    }

    /// Writes a decal that lies on the triangles into the active layer of colour of their object.
    ///
    /// # Errors
    /// The object is another one or has no colours, or the layer is hidden.
    pub(crate) fn paint_decal(
        &self,
        context: &Context,
        object: &mut AnyObject,
        decal: &Decal,
        artwork: &Artwork,
    ) -> Result<Printed> {
        let settings = Settings::of(Kind::Rgba8);
        match (&self.made, object) {
            (Made::Surface { made: tessellation, .. }, AnyObject::Tiles(object)) => {
                Print { context, tessellation, decal, artwork, depths: &[] }.paint(object, &settings)
            }
            (Made::Triangles { made: ground, .. }, AnyObject::Triangles(object)) => {
                TrianglePrint { context, ground, decal, artwork, depths: &[] }.paint(object, &settings)
            }
            _ => Err(Error::internal("the triangles are of another kind of object")),
        }
    }

    /// The points.
    pub(crate) fn points(&self) -> &[[f32; 3]] {
        &self.mesh().points
    }

    /// The points of the triangles, three numbers each.
    pub(crate) fn corners(&self) -> &[u32] {
        &self.mesh().corners
    }

    /// Three numbers for each point; none where the mesh does not have them.
    fn values(&self, name: &str) -> &[[f32; 3]] {
        match self.mesh().attribute(name).map(|attribute| (&attribute.values, attribute.width)) {
            Some((Values::F32(values), 3)) => values.as_chunks().0,
            _ => &[],
        }
    }

    /// Normals of length 1, one for each point.
    pub(crate) fn normals(&self) -> &[[f32; 3]] {
        self.values("normal")
    }

    /// Colours, linear Rec.709, one for each point.
    pub(crate) fn colors(&self) -> &[[f32; 3]] {
        if self.shades == Shades::Paint { self.values("color") } else { &self.shaded }
    }

    /// What is drawn of them.
    pub(crate) fn arrays(&self) -> Arrays<'_> {
        Arrays { points: self.points(), normals: self.normals(), colors: self.colors(), corners: self.corners() }
    }

    /// The sides of triangles that are on the borders of faces, two points each.
    pub(crate) fn borders(&self) -> Vec<u32> {
        let (parameters, is_surface) = match &self.made {
            Made::Surface { made, .. } => (&made.parameters, true),
            Made::Triangles { made, .. } => (&made.parameters, false),
        };
        let sides = |at: [f32; 2]| {
            let [u, v] = at;
            match is_surface {
                true => [u == 0.0, u == 1.0, v == 0.0, v == 1.0],
                false => [u == 0.0, v == 0.0, (u + v - 1.0).abs() < 1e-6, false],
            }
        };
        let mut lines: Vec<[u32; 2]> = Vec::new();
        for (corners, places) in self.corners().as_chunks::<3>().0.iter().zip(parameters.as_chunks::<3>().0) {
            for (a, b) in [(0, 1), (1, 2), (2, 0)] {
                let (from, to) = (sides(places[a]), sides(places[b]));
                if from.iter().zip(to).any(|(from, to)| *from && to) {
                    lines.push([corners[a].min(corners[b]), corners[a].max(corners[b])]);
                }
            }
        }
        // Most borders have a face on either side.
        lines.sort_unstable();
        lines.dedup();
        lines.into_flattened()
    }
}

impl Made {
    /// Brings the triangles to what the object is now. `marks` get the points that changed. Returns the tiles that did.
    fn update(&mut self, context: &Context, object: &AnyObject, marks: &Marks) -> Result<Vec<u32>> {
        match (self, object) {
            (Made::Surface { tessellator, made, shown, .. }, AnyObject::Tiles(object)) => {
                let mut changed: Vec<u32> = object.displacement().field().touched(&shown.heights).collect();
                match (object.vectors(), &shown.vectors) {
                    (Some(new), Some(old)) => changed.extend(new.field().touched(old)),
                    (Some(new), None) => changed.extend(new.field().allocated()),
                    (None, _) => {}
                }
                let (mut painted, mut seen) = (Vec::new(), Vec::new());
                match (object.colors(), &shown.colors) {
                    (Some(ByFormat::Rgba8(new)), Some(ByFormat::Rgba8(old))) => see(new, old, &mut painted, &mut seen),
                    (Some(ByFormat::Rgba16(new)), Some(ByFormat::Rgba16(old))) => {
                        see(new, old, &mut painted, &mut seen);
                    }
                    _ => seen = (0..object.surface().tile_count() as u32).collect(),
                }
                changed.extend(&seen);
                changed.sort_unstable();
                changed.dedup();
                tessellator.update(context, &object.displaced()?, &changed, made, marks)?;
                if let Some(colors) = object.colors() {
                    by_format!(colors, field => tessellator.paint(field, &seen, made, marks))?;
                }
                **shown = Tiles::of(object);
                Ok(changed)
            }
            (Made::Triangles { made, shown, .. }, AnyObject::Triangles(object)) => {
                let topology = object.surface().topology();
                let mut faces = object.displacement().field().changes(&shown.heights).faces_shown(topology);
                match (object.offsets(), &shown.vectors) {
                    (Some((new, _)), Some(old)) => faces.extend(new.changes(old).faces_shown(topology)),
                    (Some(_), None) => faces.extend(0..topology.face_count() as u32),
                    (None, _) => {}
                }
                match (object.colors(), &shown.colors) {
                    (Some(ByFormat::Rgba8(new)), Some(ByFormat::Rgba8(old))) => {
                        faces.extend(new.changes(old).faces_shown(topology));
                    }
                    (Some(ByFormat::Rgba16(new)), Some(ByFormat::Rgba16(old))) => {
                        faces.extend(new.changes(old).faces_shown(topology));
                    }
                    _ => faces.extend(0..topology.face_count() as u32),
                }
                faces.sort_unstable();
                faces.dedup();
                let points = made.points_near(topology, &faces)?;
                made.update(context, &object.displaced()?, object.normals(), &points, marks)?;
                match (object.colors(), &shown.colors) {
                    (Some(colors), Some(_)) => by_format!(colors, field => made.repaint(field, &points, marks))?,
                    (Some(colors), None) => {
                        by_format!(colors, field => made.paint(field))?;
                        marks.mark_all();
                    }
                    (None, _) => {}
                }
                *shown = Faces::of(object);
                Ok(faces)
            }
            _ => Err(Error::internal("the triangles are of another kind of object")),
        }
    }

    fn mesh(&self) -> &Mesh {
        match self {
            Self::Surface { made, .. } => &made.mesh,
            Self::Triangles { made, .. } => &made.mesh,
        }
    }

    fn new(context: &Context, object: &AnyObject, mesh: &Mesh, cells: u32) -> Result<Self> {
        match object {
            AnyObject::Tiles(object) => {
                let rates = surface_rates(object, cells);
                // Attributes of the mesh are not drawn.
                let bare = Mesh { attributes: Vec::new(), ..mesh.clone() };
                let tessellator = Tessellator::new(object.surface().topology(), &bare, rates.clone())?;
                let mut made = tessellator.tessellate(context, &object.displaced()?, &bare)?;
                if let Some(colors) = object.colors() {
                    by_format!(colors, field => made.paint(field));
                }
                Ok(Self::Surface { rates, tessellator, made, shown: Box::new(Tiles::of(object)) })
            }
            AnyObject::Triangles(object) => {
                let rates = face_rates(context, object, cells);
                let bare = Mesh { attributes: Vec::new(), ..mesh.clone() };
                let rate = |face: u32| rates[face as usize];
                let mut made = TriangleTessellation::new(context, &object.displaced()?, object.normals(), &bare, rate)?;
                if let Some(colors) = object.colors() {
                    by_format!(colors, field => made.paint(field))?;
                }
                Ok(Self::Triangles { rates, made, shown: Faces::of(object) })
            }
        }
    }
}

/// Puts the tiles whose colours are others into `changed`, and those in which other colours are seen into `seen`.
fn see<T: Texel>(new: &Field<T>, old: &Field<T>, changed: &mut Vec<u32>, seen: &mut Vec<u32>) {
    changed.extend(new.touched(old));
    new.seen_from(old, changed, seen);
}

/// Cells of the tiles of a surface: `cells` along an edge of a face, or as many as there are texels, as far as all that is
/// affordable.
fn surface_rates(object: &DisplacedObject, cells: u32) -> Vec<u32> {
    let topology = object.surface().topology();
    let coarse = uniform_rates(topology, cells);
    let fine = |(tile, rate): (u32, &u32)| {
        let colors = object.colors().map_or(0, |colors| by_format!(colors, field => field.density(tile)));
        let vectors = object.vectors().map_or(0, |vectors| vectors.field().density(tile));
        let density = object.displacement().field().density(tile).max(colors).max(vectors).min(FINEST);
        (*rate).max(if topology.is_sub(tile) { density / 2 } else { density })
    };
    let rates: Vec<u32> = (0..).zip(&coarse).map(fine).collect();
    let count: u64 = rates.iter().map(|rate| 2 * u64::from(*rate).pow(2)).sum();
    if count <= MAX_TRIANGLES { rates } else { coarse }
}

/// As [`surface_rates`], of the faces of a triangle mesh.
fn face_rates(context: &Context, object: &TriangleObject, cells: u32) -> Vec<FaceRates> {
    let faces = object.surface().topology().face_count();
    let least = match Pattern::new(cells) {
        Ok(pattern) => FaceRates { sides: [cells; 3], inside: Some(pattern) },
        Err(_) => FaceRates::SINGLE,
    };
    let rates = context.map(faces, |face| object.rates(face as u32).with(least));
    let inside = |rates: &FaceRates| rates.inside.map_or(1, |pattern| 3 * u64::from(pattern.segments()).pow(2) / 2);
    let count: u64 = rates.iter().map(inside).sum();
    if count <= MAX_TRIANGLES { rates } else { vec![least; faces] }
}
