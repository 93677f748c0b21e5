//! Decals written into the colours, the displacement or the vector displacement of triangle meshes, as the dabs of a stroke are.
//!
//! A value is the mean of the sticker around its vertex of the pattern: of 4 by 4 samples over a parallelogram that has the
//! sides of a segment along two sides of the face. All faces that show a changed value get a block, so that the sticker ends
//! within a segment. Vectors are in the frame of the face, edge or vertex they belong to: the image's directions are turned into
//! it, and what only gets a block is written too, because a mean of vectors in several frames means nothing. Units: object units
//! for displacement, linear Rec.709 for colour.

use std::collections::BTreeMap;

use glam::{DMat3, DVec2, DVec3, Vec4};
use relievo_core::{Context, Error, Result};
use relievo_detail::{LayeredObject, TriangleObject};
use relievo_document::{Kind, Settings};
use relievo_surface::{TriangleSurface, TriangleTopology};
use relievo_tiles::triangle::vectors::{edge_frame, face_frame, vertex_frame};
use relievo_tiles::triangle::{
    Node, Offset, Pattern, Slot, TriangleChannel, TriangleField, TriangleSets, TriangleTessellation, TriangleValues,
    edge_foot, foot,
};
use relievo_tiles::{ColorTexel, Layered, Texel, Vector, by_format};

use crate::artwork::Artwork;
use crate::decal::Decal;
use crate::print::{Printed, check_height, raised, signed_height};

/// Samples along each side of the surroundings of a vertex.
const SAMPLES: u32 = 4;
/// How far outside of a triangle of the decal, in barycentric coordinates, a vertex still belongs to it, so that none is
/// missed on the line between two.
const SLACK: f64 = 1e-4;
/// Places of the image that are closer, in widths and heights of it, are one place in two triangles of the decal.
const SAME: f64 = 1e-3;

/// A decal with its image and the triangle mesh that it lies on, to be written into layers of that mesh.
pub struct TrianglePrint<'a> {
    /// Runs the work.
    pub context: &'a Context,
    /// The tessellation of the displaced mesh that the decal lies on.
    pub ground: &'a TriangleTessellation,
    /// The decal.
    pub decal: &'a Decal,
    /// Its image.
    pub artwork: &'a Artwork,
    /// The depth of each pin, or none: see [`Decal::height`].
    pub depths: &'a [f64],
}

/// A triangle of a decal in a face of the mesh.
#[derive(Clone, Copy, Debug)]
struct Piece {
    /// Its corners, in barycentric coordinates of the second and third corner of the face.
    places: [DVec2; 3],
    /// Their places in the image.
    uv: [DVec2; 3],
    /// By how much the place in the image changes with each of the two coordinates.
    slopes: [DVec2; 2],
    /// The direction in space to the right of the image; not of unit length.
    right: DVec3,
}

/// What has values: the inside of a face or of an edge, or a vertex.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
enum Element {
    Face(u32),
    Edge(u32),
    Vertex(u32),
}

/// The colours that a decal has at the values of an element, premultiplied.
type Colored = (Element, Vec<[f32; 4]>);

impl TrianglePrint<'_> {
    /// Puts the decal over the active layer of colour, with a blend mode and an opacity. Tiles of the result are faces, its
    /// texels values.
    ///
    /// # Errors
    /// The mesh has no colours, or the active layer cannot be seen; the settings are not those of a colour; there are depths,
    /// but not one for each pin; or the decal lies on another mesh.
    pub fn paint(&self, object: &mut TriangleObject, settings: &Settings) -> Result<Printed> {
        settings.check(Kind::Rgba8).map_err(|error| error.at("decal"))?;
        let mut paint = object.take_paint()?;
        let done = by_format!(&mut paint, stack => self.over(stack.active_mut(), settings));
        object.put_paint(paint);
        self.settle(object, done?)
    }

    /// Raises the active layer of displacement by `height`, in object units, times the luminance of the image and its alpha,
    /// with a blend mode and an opacity.
    ///
    /// # Errors
    /// As [`Self::paint`]; the height is not in -60000 to 60000.
    pub fn emboss(&self, object: &mut TriangleObject, height: f32, settings: &Settings) -> Result<Printed> {
        check_height(height)?;
        settings.check(Kind::Scalar).map_err(|error| error.at("decal"))?;
        let done = self.write(object.displacement_mut(), |old, color| raised(old, color, height, settings))?;
        self.settle(object, done)
    }

    /// Adds vectors to the vector displacement, as [`Print::displace`](crate::Print::displace) does.
    ///
    /// # Errors
    /// As [`Print::displace`](crate::Print::displace).
    pub fn displace(&self, object: &mut TriangleObject, height: f32, settings: &Settings) -> Result<Printed> {
        let height = signed_height(height, settings)?;
        self.decal.check_depths(self.depths)?;
        object.renew(self.context)?;
        let (Some(vectors), Some((offsets, _))) = (object.vectors(), object.offsets()) else {
            return Err(Error::invalid("the object has no vector displacement")
                .at("decal")
                .advise("give it some first"));
        };
        let (field, surface) = (vectors.field(), object.surface());
        let (topology, pattern) = (field.topology().clone(), field.pattern());
        let pieces = self.pieces(&topology)?;
        let colored = self.colored(&topology, pattern)?;
        let covered: Vec<Element> = colored.into_iter().map(|(element, _)| element).collect();
        let faces = shown(&covered, &topology);
        // What gets a finer block has values in it that are no means of those of the old one.
        let elements = elements(&topology, faces.iter().copied());
        let made = self.context.map(elements.len(), |index| {
            let element = elements[index];
            let mut count = 0;
            let value = |step: u32| {
                let frame = element.frame(surface, pattern, step);
                let added = self.vector(self.hits(&pieces, &topology, element, pattern, step), pattern, &frame, height);
                count += u64::from(added.is_some());
                let old = element.vector(field, offsets, pattern, step, &frame);
                added.map_or(old, |added| Vector::nearest(old.value() + added))
            };
            let values: Vec<Vector> = (0..element.count(pattern)).map(value).collect();
            (values, count)
        });
        let vectors = object.vectors_mut().ok_or_else(|| Error::internal("the vectors are gone"))?;
        let (faces, refused) = allocate(self.context, vectors, pattern, faces)?;
        let field = vectors.field();
        let (mut values, mut texels) = (TriangleValues::default(), 0);
        for (element, (new, count)) in elements.into_iter().zip(made) {
            // An edge or a vertex that changed without all its faces would drag those along.
            let is_whole = || element.faces(&topology).all(|face| refused.binary_search(&face).is_err());
            let is_written = match element {
                Element::Face(face) => field.face_pattern(face) == Some(pattern),
                Element::Edge(edge) => field.edge_pattern(edge) == Some(pattern) && (count == 0 || is_whole()),
                Element::Vertex(_) => count > 0 && is_whole(),
            };
            if !is_written {
                continue;
            }
            texels += count;
            match element {
                Element::Face(face) => values.faces.push((face, new)),
                Element::Edge(edge) => values.edges.push((edge, new)),
                Element::Vertex(vertex) => values.vertices.extend(new.first().map(|value| (vertex, *value))),
            }
        }
        vectors.write(values)?;
        self.settle(object, Printed { tiles: faces, texels, refused })
    }

    fn settle(&self, object: &mut TriangleObject, mut done: Printed) -> Result<Printed> {
        done.refuse(object.settle(self.context)?);
        object.renew(self.context)?;
        Ok(done)
    }

    fn over<T: ColorTexel + Layered<Sum = Vec4>>(
        &self,
        paint: &mut TriangleChannel<T>,
        settings: &Settings,
    ) -> Result<Printed> {
        self.write(paint, |old: T, color| T::of_sum(T::blend(old.sum(), Vec4::from(color), settings)))
    }

    /// Changes the values under the decal: `change` makes a new value of an old one and a colour, which is not transparent.
    fn write<T: Layered>(
        &self,
        channel: &mut TriangleChannel<T>,
        change: impl Fn(T, [f32; 4]) -> T + Sync,
    ) -> Result<Printed> {
        self.decal.check_depths(self.depths)?;
        let (topology, pattern) = (channel.field().topology().clone(), channel.field().pattern());
        let colored = self.colored(&topology, pattern)?;
        let covered: Vec<Element> = colored.iter().map(|(element, _)| *element).collect();
        let (faces, refused) = allocate(self.context, channel, pattern, shown(&covered, &topology))?;
        let field = channel.field();
        let mut count = 0;
        let mut new = |block: &[T], colors: &[[f32; 4]]| -> Vec<T> {
            let pairs = block.iter().zip(colors);
            count += pairs.clone().filter(|(_, color)| color[3] > 0.0).count() as u64;
            pairs.map(|(old, color)| if color[3] > 0.0 { change(*old, *color) } else { *old }).collect()
        };
        let mut values = TriangleValues::default();
        for (element, colors) in &colored {
            // An edge or a vertex that changed without all its faces would drag those along.
            let is_whole = || element.faces(&topology).all(|face| refused.binary_search(&face).is_err());
            match *element {
                Element::Face(face) => {
                    let block = field.face(face).filter(|_| field.face_pattern(face) == Some(pattern));
                    values.faces.extend(block.map(|block| (face, new(block, colors))));
                }
                Element::Edge(edge) => {
                    let block = field.edge(edge).filter(|_| field.edge_pattern(edge) == Some(pattern) && is_whole());
                    values.edges.extend(block.map(|block| (edge, new(block, colors))));
                }
                Element::Vertex(vertex) if is_whole() => {
                    let value = new(&[field.vertex(vertex)], colors);
                    values.vertices.extend(value.into_iter().map(|value| (vertex, value)));
                }
                Element::Vertex(_) => {}
            }
        }
        channel.write(values)?;
        Ok(Printed { tiles: faces, texels: count, refused })
    }

    /// The elements under the decal, in order, with their colours.
    fn colored(&self, topology: &TriangleTopology, pattern: Pattern) -> Result<Vec<Colored>> {
        let pieces = self.pieces(topology)?;
        let elements = elements(topology, pieces.keys().copied());
        let colored = self.context.map(elements.len(), |index| {
            let element = elements[index];
            let color = |step: u32| self.color(self.hits(&pieces, topology, element, pattern, step), pattern);
            let colors: Vec<[f32; 4]> = (0..element.count(pattern)).map(color).collect();
            colors.iter().any(|color| color[3] > 0.0).then_some((element, colors))
        });
        Ok(colored.into_iter().flatten().collect())
    }

    /// The triangles of the decal by the face of the mesh that they lie in.
    fn pieces(&self, topology: &TriangleTopology) -> Result<BTreeMap<u32, Vec<Piece>>> {
        let TriangleTessellation { mesh, tiles, parameters, .. } = self.ground;
        let mut pieces: BTreeMap<u32, Vec<Piece>> = BTreeMap::new();
        for (triangle, part) in self.decal.triangles.iter().zip(&self.decal.faces) {
            let first = 3 * *part as usize;
            let face = tiles.get(*part as usize).filter(|face| (**face as usize) < topology.face_count());
            let corners = mesh.corners.get(first..first + 3).zip(parameters.get(first..first + 3));
            let (Some(face), Some((corners, parameters))) = (face, corners) else {
                return Err(Error::internal("a decal lies on another mesh"));
            };
            let corner = |at: usize| DVec3::from(mesh.points[corners[at] as usize].map(f64::from));
            let [a, b, c] = [0, 1, 2].map(corner);
            let normal = (b - a).cross(c - a);
            let place = |vertex: u32| {
                let point = DVec3::from(self.decal.points[vertex as usize]);
                let share =
                    |from: DVec3, to: DVec3| normal.dot((to - from).cross(point - from)) / normal.length_squared();
                let shares = [share(b, c), share(c, a), share(a, b)];
                let corners = shares.into_iter().zip(parameters);
                corners.map(|(share, [u, v])| share * DVec2::new(f64::from(*u), f64::from(*v))).sum::<DVec2>()
            };
            let uv = triangle.map(|vertex| DVec2::from(self.decal.uv[vertex as usize]));
            let points = triangle.map(|vertex| DVec3::from(self.decal.points[vertex as usize]));
            if let Some(piece) = Piece::new(triangle.map(place), uv, points) {
                pieces.entry(*face).or_default().push(piece);
            }
        }
        Ok(pieces)
    }

    /// The triangles of the decal at a value of an element, with the place in the image.
    fn hits<'a>(
        &self,
        pieces: &'a BTreeMap<u32, Vec<Piece>>,
        topology: &TriangleTopology,
        element: Element,
        pattern: Pattern,
        step: u32,
    ) -> Vec<(DVec2, &'a Piece)> {
        let mut hits = Vec::new();
        element.knots(topology, pattern, step, |face, place| {
            let of_face = pieces.get(&face).into_iter().flatten();
            hits.extend(of_face.filter_map(|piece| piece.hit(place).map(|uv| (uv, piece))));
        });
        hits
    }

    /// The means of the image around a vertex of the pattern, premultiplied, from the lowest layer of the sticker to the top.
    fn means<'a>(&self, mut hits: Vec<(DVec2, &'a Piece)>, pattern: Pattern) -> Vec<([f32; 4], &'a Piece)> {
        let size = DVec2::from(self.artwork.sticker().size);
        let height = |(uv, _): &(DVec2, &Piece)| self.decal.height(uv.to_array(), self.depths);
        hits.sort_by(|a, b| height(a).total_cmp(&height(b)));
        let mut seen: Vec<DVec2> = Vec::new();
        let mut means = Vec::new();
        for (uv, piece) in hits {
            if seen.iter().any(|other| other.distance(uv) < SAME) {
                continue;
            }
            seen.push(uv);
            let slopes = piece.slopes;
            // Of a sample, in segments and in pixels.
            let side = 1.0 / f64::from(SAMPLES * pattern.segments());
            let footprint = ((slopes[0] * size).perp_dot(slopes[1] * size)).abs().sqrt() * side;
            let mut mean = [0.0_f32; 4];
            for sample in 0..SAMPLES * SAMPLES {
                let [a, b] = [sample % SAMPLES, sample / SAMPLES]
                    .map(|at| (f64::from(at) + 0.5 - 0.5 * f64::from(SAMPLES)) * side);
                let place = uv + a * slopes[0] + b * slopes[1];
                for (mean, value) in mean.iter_mut().zip(self.artwork.color(place.to_array(), footprint)) {
                    *mean += value / (SAMPLES * SAMPLES) as f32;
                }
            }
            means.push((mean, piece));
        }
        means
    }

    /// The colour of what lies at a vertex of the pattern, one over the other.
    fn color(&self, hits: Vec<(DVec2, &Piece)>, pattern: Pattern) -> [f32; 4] {
        let over = |color: [f32; 4], (mean, _): ([f32; 4], &Piece)| -> [f32; 4] {
            std::array::from_fn(|channel| mean[channel] + (1.0 - mean[3]) * color[channel])
        };
        self.means(hits, pattern).into_iter().fold([0.0; 4], over)
    }

    /// The vector of what lies at a vertex of the pattern, one over the other, in a frame; `None` where nothing does.
    fn vector(&self, hits: Vec<(DVec2, &Piece)>, pattern: Pattern, frame: &DMat3, height: f32) -> Option<DVec3> {
        let mut sum = None;
        for (mean, piece) in self.means(hits, pattern).into_iter().filter(|(mean, _)| mean[3] > 0.0) {
            let [red, green, blue, alpha] = mean.map(f64::from);
            // Colours are premultiplied.
            let [right, up, out] = [red, green, blue].map(|value| f64::from(height) * (2.0 * value - alpha));
            let turn = (frame.transpose() * piece.right).truncate().normalize_or_zero();
            let own = DVec3::new(turn.x * right - turn.y * up, turn.y * right + turn.x * up, out);
            sum = Some(own + (1.0 - alpha) * sum.unwrap_or(DVec3::ZERO));
        }
        sum
    }
}

/// The faces, their edges and their corners, in order.
fn elements(topology: &TriangleTopology, faces: impl Iterator<Item = u32>) -> Vec<Element> {
    let mut elements = Vec::new();
    for face in faces {
        elements.push(Element::Face(face));
        elements.extend(topology.edges_of(face).map(Element::Edge));
        elements.extend(topology.face(face).map(Element::Vertex));
    }
    elements.sort_unstable();
    elements.dedup();
    elements
}

/// The faces that show elements, in order.
fn shown(elements: &[Element], topology: &TriangleTopology) -> Vec<u32> {
    let mut faces: Vec<u32> = elements.iter().flat_map(|element| element.faces(topology)).collect();
    faces.sort_unstable();
    faces.dedup();
    faces
}

/// Gives faces blocks of a pattern; returns the faces that have one, and the faces that the budget refused.
fn allocate<T: Texel>(
    context: &Context,
    channel: &mut TriangleChannel<T>,
    pattern: Pattern,
    mut faces: Vec<u32>,
) -> Result<(Vec<u32>, Vec<u32>)> {
    let sets = TriangleSets { allocate: faces.clone(), modify: faces.clone(), ..TriangleSets::default() };
    let refused = channel.apply(context, pattern, &sets)?;
    faces.retain(|face| refused.binary_search(face).is_err());
    Ok((faces, refused))
}

impl Piece {
    /// `None` for a triangle without area.
    fn new(places: [DVec2; 3], uv: [DVec2; 3], points: [DVec3; 3]) -> Option<Self> {
        let [first, second] = [places[1] - places[0], places[2] - places[0]];
        let area = first.perp_dot(second);
        let [p, q] = [uv[1] - uv[0], uv[2] - uv[0]];
        let slopes = [(p * second.y - q * first.y) / area, (q * first.x - p * second.x) / area];
        // The first coordinate of the image grows along it.
        let right = ((points[1] - points[0]) * q.y - (points[2] - points[0]) * p.y) / p.perp_dot(q);
        let is_finite = slopes.iter().all(|slope| slope.is_finite()) && right.is_finite();
        is_finite.then_some(Self { places, uv, slopes, right })
    }

    /// The place in the image at a place of the face; `None` outside of the triangle.
    fn hit(&self, place: DVec2) -> Option<DVec2> {
        let [a, b, c] = self.places;
        let area = (b - a).perp_dot(c - a);
        let share = |from: DVec2, to: DVec2| (to - from).perp_dot(place - from) / area;
        let shares = [share(b, c), share(c, a), share(a, b)];
        if shares.iter().any(|share| *share < -SLACK) {
            return None;
        }
        Some((0..3).map(|corner| shares[corner] * self.uv[corner]).sum())
    }
}

impl Element {
    /// The faces that show it.
    fn faces(self, topology: &TriangleTopology) -> impl Iterator<Item = u32> + '_ {
        let (inside, along, around) = match self {
            Self::Face(face) => (Some(face), None, None),
            Self::Edge(edge) => (None, Some(topology.faces_along(edge)), None),
            Self::Vertex(vertex) => (None, None, Some(topology.faces_around(vertex))),
        };
        let beside = along.into_iter().flatten().chain(around.into_iter().flatten());
        inside.into_iter().chain(beside.map(|(face, _)| face))
    }

    /// The frame of its value number `step`.
    fn frame(self, surface: &TriangleSurface, pattern: Pattern, step: u32) -> DMat3 {
        let frame = match self {
            Self::Face(face) => {
                face_frame(surface, face, foot(surface, face, pattern, pattern.at_slot(Slot::Inside(step))).normal)
            }
            Self::Edge(edge) => {
                edge_frame(surface, edge, edge_foot(surface, edge, step + 1, pattern.segments()).normal)
            }
            Self::Vertex(vertex) => vertex_frame(surface, vertex),
        };
        frame.as_dmat3()
    }

    /// Its vector number `step` in a pattern: its own, or what it reads as, turned into its frame.
    fn vector(
        self,
        field: &TriangleField<Vector>,
        offsets: &TriangleField<Offset>,
        pattern: Pattern,
        step: u32,
        frame: &DMat3,
    ) -> Vector {
        let own = match self {
            Self::Face(face) => field.face(face).filter(|_| field.face_pattern(face) == Some(pattern)),
            Self::Edge(edge) => field.edge(edge).filter(|_| field.edge_pattern(edge) == Some(pattern)),
            Self::Vertex(vertex) => return field.vertex(vertex),
        };
        if let Some(vector) = own.and_then(|block| block.get(step as usize)) {
            return *vector;
        }
        let (face, node) = match self {
            Self::Face(face) => (face, pattern.at_slot(Slot::Inside(step))),
            Self::Edge(edge) => {
                let topology = field.topology();
                let Some((face, side)) = topology.faces_along(edge).next() else { return Vector::ZERO };
                let is_reversed = topology.side(face, side).reversed;
                (face, pattern.node(0, side, if is_reversed { pattern.segments() - step - 1 } else { step + 1 }))
            }
            Self::Vertex(vertex) => return field.vertex(vertex),
        };
        if offsets.is_blank(face) {
            Vector::ZERO
        } else {
            Vector::nearest(frame.transpose() * offsets.at(face, pattern, node))
        }
    }

    /// How many values it has.
    fn count(self, pattern: Pattern) -> u32 {
        match self {
            Self::Face(_) => pattern.face_values() as u32,
            Self::Edge(_) => pattern.edge_values() as u32,
            Self::Vertex(_) => 1,
        }
    }

    /// Calls `take` with each face that has value number `index` and with its place there, in barycentric coordinates of the
    /// second and third corner.
    fn knots(self, topology: &TriangleTopology, pattern: Pattern, index: u32, mut take: impl FnMut(u32, DVec2)) {
        let place = |node: Node| {
            let [_, u, v] = pattern.weights(node).map(f64::from);
            DVec2::new(u, v) / f64::from(3 * pattern.segments())
        };
        match self {
            Self::Face(face) => take(face, place(pattern.at_slot(Slot::Inside(index)))),
            Self::Edge(edge) => {
                for (face, side) in topology.faces_along(edge) {
                    let is_reversed = topology.side(face, side).reversed;
                    let step = if is_reversed { pattern.segments() - index - 1 } else { index + 1 };
                    take(face, place(pattern.node(0, side, step)));
                }
            }
            Self::Vertex(vertex) => {
                for (face, corner) in topology.faces_around(vertex) {
                    take(face, place(pattern.node(0, corner, 0)));
                }
            }
        }
    }
}
