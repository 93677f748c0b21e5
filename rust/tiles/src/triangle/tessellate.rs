//! A displaced triangle mesh as one mesh with shared vertices and the attributes it was made with, for export.
//!
//! Every face has the triangles of its [`FaceRates`]. Vertices of the mesh keep their numbers; those on edges follow,
//! then those inside faces. Integers, and the weights that belong to joints, are those of the nearest corner.

use relievo_core::progress::Silent;
use relievo_core::{Attribute, Context, Domain, Error, Marks, Mesh, Progress, Result, Values};
use relievo_surface::TriangleTopology;
use relievo_surface::triangle::Pieces;

use super::displaced::TriangleDisplaced;
use super::field::TriangleField;
use super::normals::TriangleNormals;
use super::pattern::{Node, Pattern, Slot};
use super::piece::FaceRates;
use crate::texel::ColorTexel;

/// What is being done, for progress.
const STAGE: &str = "tessellate";

/// A tessellated triangle mesh.
#[derive(Clone, Debug)]
pub struct TriangleTessellation {
    /// The mesh, with point normals and the attributes of the undisplaced one.
    pub mesh: Mesh,
    /// The face of every triangle, ascending.
    pub tiles: Vec<u32>,
    /// Of every corner the barycentric coordinates of the second and third corner of its face.
    pub parameters: Vec<[f32; 2]>,
    /// Per point a face, a pattern and a vertex of it that is there; `None` for a vertex without a face.
    places: Vec<Option<(u32, Pattern, Node)>>,
}

impl TriangleTessellation {
    /// The triangles of all faces at `rates`, where the undisplaced mesh is `cage`. Rates of an edge must be the same
    /// from all its faces, as those of [`FaceRates::of`] are.
    ///
    /// # Errors
    /// Fails if `cage` is another mesh or there are too many vertices.
    pub fn new(
        context: &Context,
        displaced: &TriangleDisplaced<'_>,
        normals: &TriangleNormals,
        cage: &Mesh,
        rates: impl Fn(u32) -> FaceRates + Sync,
    ) -> Result<Self> {
        Self::new_watched(context, displaced, normals, cage, rates, &mut Silent)
    }

    /// As [`Self::new`], in pieces between which `progress` hears of the stage `tessellate`.
    ///
    /// # Errors
    /// As there, and where `progress` asks to stop.
    pub fn new_watched(
        context: &Context,
        displaced: &TriangleDisplaced<'_>,
        normals: &TriangleNormals,
        cage: &Mesh,
        rates: impl Fn(u32) -> FaceRates + Sync,
        progress: &mut dyn Progress,
    ) -> Result<Self> {
        let topology = displaced.field().topology();
        let missing = |what: &str| Error::invalid(what).advise("give the mesh that the surface was made from");
        if cage.points.len() != topology.vertex_count() || cage.triangles() != topology.faces() {
            return Err(missing("the mesh has other faces than the surface"));
        }
        let faces = topology.face_count();
        let rates = context.map(faces, |face| rates(face as u32));
        // The first vertex inside each edge and face.
        let mut next = topology.vertex_count() as u64;
        let mut take = |count: u64| {
            let first = next;
            next += count;
            first
        };
        let edges: Vec<u64> = (0..topology.edge_count() as u32)
            .map(|edge| {
                let side = topology.faces_along(edge).next();
                take(side.map_or(0, |(face, side)| u64::from(rates[face as usize].sides[side as usize] - 1)))
            })
            .collect();
        let insides: Vec<u64> =
            rates.iter().map(|rates| take(rates.places().len() as u64 - u64::from(rates.border()))).collect();
        let count = u32::try_from(next)
            .map_err(|_| Error::memory("the mesh has 2^32 or more vertices").advise("use a lower rate"))?;

        let parts = context.map_watched(faces, progress, (STAGE, [0.0, 0.3]), |face| {
            let (rates, face) = (&rates[face], face as u32);
            let vertices: Vec<u32> = rates
                .places()
                .into_iter()
                .enumerate()
                .map(|(at, (pattern, node))| match pattern.slot(node) {
                    Slot::Corner(corner) => topology.face(face)[corner as usize],
                    Slot::Side(side, step) => {
                        let along = topology.side(face, side);
                        let step = if along.reversed { pattern.segments() - step } else { step };
                        (edges[along.edge as usize] + u64::from(step) - 1) as u32
                    }
                    Slot::Inside(_) => (insides[face as usize] + at as u64 - u64::from(rates.border())) as u32,
                })
                .collect();
            (vertices, rates.triangles())
        })?;
        let mut places = vec![None; count as usize];
        let mut pieces = Pieces { points: vec![None; count as usize], ..Pieces::default() };
        let (mut triangles, mut tiles) = (Vec::new(), Vec::new());
        for (face, (vertices, parts)) in (0..).zip(parts) {
            let first = pieces.places.len() as u32;
            for (at, ((pattern, node), vertex)) in (0..).zip(rates[face as usize].places().into_iter().zip(&vertices)) {
                let vertex = *vertex as usize;
                if places[vertex].is_none() {
                    places[vertex] = Some((face, pattern, node));
                    pieces.points[vertex] = (vertex >= topology.vertex_count()).then_some(first + at);
                }
                pieces.places.push((face, super::field::barycentric(pattern, node)));
            }
            for triangle in parts {
                triangles.push(triangle.map(|at| vertices[at as usize]));
                tiles.push(face);
                pieces.corners.extend(triangle.map(|at| first + at));
            }
        }
        let found =
            context.map_watched(count as usize, progress, (STAGE, [0.4, 0.9]), |vertex| match places[vertex] {
                Some((face, pattern, node)) => {
                    let point = displaced.point(face, pattern, node);
                    (point.to_array(), normals.at(displaced.surface(), face, pattern, node).to_array())
                }
                None => (displaced.surface().points()[vertex], [0.0; 3]),
            })?;
        progress.step(0.9, STAGE)?;
        let (points, normals): (Vec<_>, Vec<[f32; 3]>) = found.into_iter().unzip();
        let mut mesh = Mesh::from_triangles(points, &triangles);
        mesh.attributes = pieces.carry(cage, topology, &["normal"]);
        mesh.attributes.push(point_attribute("normal", 3, normals.into_flattened()));
        let parameter = |corner: &u32| {
            let (_, [_, u, v]) = pieces.places[*corner as usize];
            [u, v]
        };
        let parameters = pieces.corners.iter().map(parameter).collect();
        Ok(Self { mesh, tiles, parameters, places })
    }

    /// Returns the points of `faces` and of all faces around them, ascending: what may have changed where these faces came
    /// to look different.
    ///
    /// # Errors
    /// A face does not exist.
    pub fn points_near(&self, topology: &TriangleTopology, faces: &[u32]) -> Result<Vec<u32>> {
        let mut near = vec![false; topology.face_count()];
        for face in faces {
            if *face as usize >= near.len() {
                return Err(Error::invalid(format!("face {face} does not exist")));
            }
            for (face, _) in topology.face(*face).iter().flat_map(|vertex| topology.faces_around(*vertex)) {
                near[face as usize] = true;
            }
        }
        let is_near = |place: &Option<(u32, Pattern, Node)>| {
            place.is_some_and(|(face, ..)| near.get(face as usize).copied().unwrap_or(false))
        };
        Ok((0..).zip(&self.places).filter(|(_, place)| is_near(place)).map(|(point, _)| point).collect())
    }

    /// Moves `changed` points and their normals to where they now are, as [`Self::points_near`] lists them; the rates of
    /// faces are the same as before. `marks` get the points whose position or normal differs from before.
    ///
    /// # Errors
    /// The tessellation is that of another mesh, or its mesh was changed.
    pub fn update(
        &mut self,
        context: &Context,
        displaced: &TriangleDisplaced<'_>,
        normals: &TriangleNormals,
        changed: &[u32],
        marks: &Marks,
    ) -> Result<()> {
        let faces = displaced.field().topology().face_count();
        let Mesh { points, attributes, .. } = &mut self.mesh;
        let attribute = attributes.iter_mut().find(|attribute| attribute.name == "normal");
        let Some(Values::F32(facing)) = attribute.map(|attribute| &mut attribute.values) else {
            return Err(Error::invalid("the tessellation has no normals any more"));
        };
        if points.len() != self.places.len() || facing.len() != 3 * points.len() {
            return Err(Error::invalid("the mesh of the tessellation was changed"));
        }
        let moved = changed.iter().map(|point| (*point as usize, self.places.get(*point as usize).copied().flatten()));
        let moved: Vec<_> = moved
            .filter_map(|(point, place)| place.map(|place| (point, place)))
            .filter(|(_, (face, ..))| (*face as usize) < faces)
            .collect();
        let found = context.map(moved.len(), |index| {
            let (face, pattern, node) = moved[index].1;
            let normal = normals.at(displaced.surface(), face, pattern, node);
            (displaced.point(face, pattern, node), normal)
        });
        let facing = facing.as_chunks_mut::<3>().0;
        for ((point, _), (position, normal)) in moved.into_iter().zip(found) {
            marks.renew(point, &mut points[point..=point], &[position.to_array()]);
            marks.renew(point, &mut facing[point..=point], &[normal.to_array()]);
        }
        Ok(())
    }

    /// Per point a face, a pattern and a vertex of it that is there; `None` for a vertex without a face.
    pub(super) fn places(&self) -> &[Option<(u32, Pattern, Node)>] {
        &self.places
    }

    /// Gives the mesh the colours of `paint` as the point attribute `color`, in place of one it may have: red, green
    /// and blue, linear.
    ///
    /// # Errors
    /// None at present: faces that `paint` does not have get its blank colour.
    pub fn paint<T: ColorTexel>(&mut self, paint: &TriangleField<T>) -> Result<()> {
        let values = self.places.iter().flat_map(|place| color(paint, *place)).collect();
        self.mesh.attributes.retain(|attribute| attribute.name != "color");
        self.mesh.attributes.push(point_attribute("color", 3, values));
        Ok(())
    }

    /// Gives `changed` points the colours of `paint`, as [`Self::paint`] gives them to all. `marks` get the points whose
    /// colour differs from before.
    ///
    /// # Errors
    /// Fails, and changes nothing, if the mesh has no colours yet.
    pub fn repaint<T: ColorTexel>(&mut self, paint: &TriangleField<T>, changed: &[u32], marks: &Marks) -> Result<()> {
        self.renew::<3>("color", changed, marks, |place| color(paint, place))
    }

    /// Gives `changed` points the values of `of` at their places, in the point attribute `name` of N numbers. `marks` get
    /// the points whose values differ from before.
    pub(super) fn renew<const N: usize>(
        &mut self,
        name: &str,
        changed: &[u32],
        marks: &Marks,
        of: impl Fn(Option<(u32, Pattern, Node)>) -> [f32; N],
    ) -> Result<()> {
        let attribute = self.mesh.attributes.iter_mut().find(|attribute| attribute.name == name);
        let values = match attribute.map(|attribute| &mut attribute.values) {
            Some(Values::F32(values)) if values.len() == N * self.places.len() => values.as_chunks_mut::<N>().0,
            _ => return Err(Error::invalid(format!("the tessellation has no attribute \"{name}\"")).at("name")),
        };
        for point in changed.iter().map(|point| *point as usize) {
            if let (Some(old), Some(place)) = (values.get_mut(point..=point), self.places.get(point)) {
                marks.renew(point, old, &[of(*place)]);
            }
        }
        Ok(())
    }
}

/// Returns the colour at a place, red, green and blue; the blank one where there is none.
fn color<T: ColorTexel>(paint: &TriangleField<T>, place: Option<(u32, Pattern, Node)>) -> [f32; 3] {
    let color = match place {
        Some((face, pattern, node)) if (face as usize) < paint.topology().face_count() => {
            paint.at(face, pattern, node).as_vec4()
        }
        _ => paint.blank().color(),
    };
    color.truncate().to_array()
}

/// Numbers of every point.
pub(super) fn point_attribute(name: &str, width: u32, values: Vec<f32>) -> Attribute {
    Attribute { name: name.into(), domain: Domain::Point, width, values: Values::F32(values), indices: None }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::layers::trace::Trace;
    use crate::texel::Rgba8;
    use crate::triangle::shapes;
    use crate::triangle::{TriangleChannel, TriangleOptions, TriangleSets, TriangleValues};
    use glam::Vec4;
    use half::f16;
    use relievo_core::marks::GAP;
    use relievo_surface::{TriangleSurface, TriangleTopology};

    #[test]
    fn the_mesh_is_whole_and_has_all_attributes() {
        let context = Context::serial();
        let mut cage = shapes::sail(3);
        let uv = cage
            .corners
            .iter()
            .flat_map(|point| [cage.points[*point as usize][0] * 2.0, cage.points[*point as usize][1]]);
        let uv = Values::F32(uv.collect());
        cage.attributes.push(Attribute {
            name: "uv".into(),
            domain: Domain::Corner,
            width: 2,
            values: uv,
            indices: None,
        });
        let faces = Values::U32((0..cage.face_count() as u32).collect());
        cage.attributes.push(Attribute {
            name: "material".into(),
            domain: Domain::Face,
            width: 1,
            values: faces,
            indices: None,
        });
        let surface = TriangleSurface::new(&context, &cage).unwrap();
        let options = TriangleOptions { segments: 16, budget: 1 << 20 };
        let mut channel = TriangleChannel::displacement(surface.topology().clone(), &options).unwrap();
        for (segments, faces) in [(16, vec![4, 5]), (8, vec![7])] {
            let sets = TriangleSets { allocate: faces, ..Default::default() };
            channel.apply(&context, Pattern::new(segments).unwrap(), &sets).unwrap();
        }
        channel.write(TriangleValues { vertices: vec![(5, f16::from_f32(0.2))], ..Default::default() }).unwrap();
        let displaced = TriangleDisplaced::new(&surface, channel.field()).unwrap();
        let normals = TriangleNormals::of(&context, &displaced).unwrap();
        let rates = |face: u32| FaceRates::of(channel.field(), face);
        let mut whole = TriangleTessellation::new(&context, &displaced, &normals, &cage, rates).unwrap();
        whole
            .paint(TriangleChannel::<Rgba8>::of_color(surface.topology().clone(), Vec4::ONE, &options).unwrap().field())
            .unwrap();
        let mesh = &whole.mesh;
        mesh.check().unwrap();
        let topology = TriangleTopology::of_mesh(mesh).unwrap();
        let segments = |edge: u32| channel.field().edge_pattern(edge).map_or(1, Pattern::segments) as usize;
        let of = surface.topology();
        let open =
            (0..of.edge_count() as u32).filter(|edge| of.faces_along(*edge).len() == 1).map(segments).sum::<usize>();
        assert_eq!(topology.boundary_count(), open);
        let uv = mesh.attribute("uv").unwrap();
        let (Values::F32(values), Some(indices)) = (&uv.values, &uv.indices) else { panic!() };
        let Values::U32(material) = &mesh.attribute("material").unwrap().values else { panic!() };
        assert!(material.windows(2).all(|pair| pair[0] <= pair[1]));
        for (corner, point) in mesh.corners.iter().enumerate().filter(|(corner, _)| material[corner / 3] < 18) {
            // The sail is displaced by a fifth at most.
            let p = mesh.points[*point as usize];
            let at = indices[corner] as usize;
            assert!((values[2 * at] - 2.0 * p[0]).abs() < 0.2 && (values[2 * at + 1] - p[1]).abs() < 0.1);
        }
        assert_eq!(mesh.attribute("color").unwrap().values, Values::F32(vec![1.0; 3 * mesh.points.len()]));
        assert!(TriangleTessellation::new(&context, &displaced, &normals, &shapes::sail(4), rates).is_err());
    }

    #[test]
    fn what_differs_is_renewed_and_marked() {
        let context = Context::serial();
        let cage = shapes::sail(6);
        let surface = TriangleSurface::new(&context, &cage).unwrap();
        let topology = surface.topology();
        let options = TriangleOptions { segments: 16, budget: 1 << 20 };
        let mut heights = TriangleChannel::displacement(topology.clone(), &options).unwrap();
        let mut colors = TriangleChannel::<Rgba8>::of_color(topology.clone(), Vec4::ONE, &options).unwrap();
        let mut traces = TriangleChannel::<Trace>::of(heights.field(), 1 << 20).unwrap();
        let sets = || TriangleSets { allocate: (0..topology.face_count() as u32).collect(), ..Default::default() };
        heights.apply(&context, Pattern::new(16).unwrap(), &sets()).unwrap();
        colors.apply(&context, Pattern::new(16).unwrap(), &sets()).unwrap();
        traces.apply(&context, Pattern::new(16).unwrap(), &sets()).unwrap();
        let rates = |face: u32| FaceRates::of(heights.field(), face);
        let rates: Vec<FaceRates> = (0..topology.face_count() as u32).map(rates).collect();
        let whole = |heights: &TriangleField, colors: &TriangleField<Rgba8>, traces: &TriangleField<Trace>| {
            let displaced = TriangleDisplaced::new(&surface, heights).unwrap();
            let normals = TriangleNormals::of(&context, &displaced).unwrap();
            let rate = |face: u32| rates[face as usize];
            let mut made = TriangleTessellation::new(&context, &displaced, &normals, &cage, rate).unwrap();
            made.trace(traces, 2.0);
            made.paint(colors).unwrap();
            made
        };
        let numbers = |made: &TriangleTessellation, point: usize| {
            let list = ["normal", "color", "contact", "depth", "age"].map(|name| made.mesh.attribute(name).unwrap());
            let of = |attribute: &Attribute| match (&attribute.values, attribute.width as usize) {
                (Values::F32(values), width) => values[width * point..][..width].to_vec(),
                (Values::U32(_), _) => Vec::new(),
            };
            let mut numbers = made.mesh.points[point].to_vec();
            numbers.extend(list.into_iter().flat_map(of));
            numbers
        };
        let mut made = whole(heights.field(), colors.field(), traces.field());
        let mut marks = Marks::new(made.mesh.points.len());
        for step in 0..3 {
            let (start, before) =
                (made.clone(), (heights.field().clone(), colors.field().clone(), traces.field().clone()));
            if step == 0 {
                heights
                    .write(TriangleValues { vertices: vec![(5, f16::from_f32(0.2))], ..Default::default() })
                    .unwrap();
            } else if step == 1 {
                let red = Rgba8::of_color(Vec4::new(1.0, 0.0, 0.0, 1.0));
                colors.write(TriangleValues { vertices: vec![(20, red)], ..Default::default() }).unwrap();
            } else {
                let trace = Trace::default().pushed(0.5, 1.0);
                traces.write(TriangleValues { vertices: vec![(30, trace)], ..Default::default() }).unwrap();
            }
            let mut faces = heights.field().changes(&before.0).faces_shown(topology);
            faces.extend(colors.field().changes(&before.1).faces_shown(topology));
            faces.extend(traces.field().changes(&before.2).faces_shown(topology));
            let points = made.points_near(topology, &faces).unwrap();
            let displaced = TriangleDisplaced::new(&surface, heights.field()).unwrap();
            let normals = TriangleNormals::of(&context, &displaced).unwrap();
            made.update(&context, &displaced, &normals, &points, &marks).unwrap();
            made.retrace(traces.field(), 2.0, &points, &marks).unwrap();
            made.repaint(colors.field(), &points, &marks).unwrap();
            assert_eq!(made.mesh, whole(heights.field(), colors.field(), traces.field()).mesh, "step {step}");
            let differs = |point: &u32| numbers(&start, *point as usize) != numbers(&made, *point as usize);
            let differing: Vec<u32> = (0..made.mesh.points.len() as u32).filter(differs).collect();
            let expected = differing.chunk_by(|a, b| b - a <= GAP + 1).map(|run| run[0]..run[run.len() - 1] + 1);
            let mut ranges = Vec::new();
            marks.take(&mut ranges);
            assert!(
                !differing.is_empty() && 4 * differing.len() < points.len(),
                "{} of {}",
                differing.len(),
                points.len()
            );
            assert_eq!(ranges, expected.collect::<Vec<_>>());
        }
        assert!(made.points_near(topology, &[9999]).is_err());
        let mut bare = made;
        bare.mesh.attributes.retain(|attribute| attribute.name == "normal");
        assert!(bare.repaint(colors.field(), &[0], &marks).is_err());
        assert!(bare.retrace(traces.field(), 2.0, &[0], &marks).is_err());
    }
}
