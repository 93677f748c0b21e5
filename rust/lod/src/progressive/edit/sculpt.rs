//! Strokes of a brush on a mesh of a progressive mesh, at the level it is of: the brushes, modes and images that sculpt
//! displacement elsewhere (Schäfer, Keinert, Nießner, Stamminger 2015, Sections 3 and 5.2) move its vertices. A stroke is an
//! edit: coarser and finer levels follow, and it is taken back as a whole.

use std::collections::BTreeMap;

use glam::{DAffine3, DMat3, DVec3, Vec3};
use relievo_core::{Context, Error, Result};
use relievo_detail::knots::{BLOCK_KNOTS, KnotBlock, PerKnot};
use relievo_detail::mode::{SculptInput, VectorInput};
use relievo_detail::{Action, BrushParameters, Dab, SculptMode, Stroke, Weights};
use relievo_surface::triangle::closest;

use super::place::{Place, arc};
use crate::progressive::mesh::active::ActiveMesh;

/// What a stroke did.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Sculpted {
    /// Dabs that were made, with mirror images.
    pub dabs: usize,
    /// Dabs that were left out because no surface is near enough there.
    pub missed: usize,
    /// Vertices that moved.
    pub vertices: usize,
}

/// A place of a mesh where a dab is put.
struct Found {
    point: DVec3,
    normal: DVec3,
}

/// Vertices that a stroke has moved, as they are.
type Moved = BTreeMap<u32, Place>;

impl ActiveMesh {
    /// Makes the dabs of a stroke on this mesh, whose space is the world's. Dabs are put on the mesh as it was when the
    /// stroke began. What the brush draws is along the normals of then; inflating goes by those of now, smoothing to the
    /// mean of the neighbours, erasing to where the vertices were built.
    ///
    /// # Errors
    /// Fails, and changes nothing, if the stroke cannot be ([`Stroke::check`]), paints, has an image of vectors, a
    /// level or dabs beside their places, or if no vertex is reached.
    pub fn sculpt(&mut self, context: &Context, stroke: &Stroke) -> Result<Sculpted> {
        let stations = stroke.stations()?;
        let Action::Sculpt { mode, height } = stroke.action else {
            return Err(refused("a progressive mesh has no colours", "use a mode of sculpting"));
        };
        if mode == SculptMode::Vector && stroke.stamp.is_some() {
            return Err(refused("images of vectors are not known here", "use heights, or no image"));
        }
        if stroke.settings.level != 0 || stroke.settings.jitter_position != 0.0 {
            return Err(refused("`level` and `jitter_position` are not known here", "leave them at 0"));
        }
        self.rest(context);
        let within = f64::from(stroke.settings.radius * stroke.settings.reach);
        let (mut dabs, mut done) = (Vec::new(), Sculpted::default());
        for station in &stations {
            for sign in stroke.mirrors() {
                let mirror = DMat3::from_diagonal(sign);
                let Some(found) = self.nearest(context, mirror * station.position, within) else {
                    done.missed += 1;
                    continue;
                };
                let (way, over) = (mirror * station.direction, sign.element_product() < 0.0);
                dabs.push(stroke.dab_on(station, (found.point, found.normal), way, over)?);
            }
        }
        let mut moved = Moved::new();
        for dab in &dabs {
            self.dab(context, (mode, height), dab, &mut moved);
        }
        moved.retain(|vertex, place| *place != self.now(*vertex));
        if moved.is_empty() {
            return Err(Error::invalid("no vertex is in the brush")
                .at("stroke")
                .advise("move it to the surface, make its radius larger, or use a finer level"));
        }
        done.dabs = dabs.len();
        done.vertices = moved.len();
        let reached = self.turned(&moved);
        self.change(context, reached)?;
        Ok(done)
    }

    /// The place of the mesh that is nearest to a point: of the triangles at the nearest vertex, and of those at theirs for
    /// as long as that is nearer.
    fn nearest(&mut self, context: &Context, point: DVec3, within: f64) -> Option<Found> {
        let far = |place: Place| place.point.as_dvec3().distance(point);
        let nearest = |list: Vec<(f64, u32)>| list.into_iter().min_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)));
        let center = point.as_vec3();
        let near = |low: Vec3, high: Vec3| f64::from(center.distance(center.clamp(low, high))) <= within;
        let distance = |mesh: &Self, vertex| Some((far(mesh.place(vertex, mesh.child(vertex)?)), vertex));
        let found = self.find_near(context, |low, high| low.x <= high.x && near(low, high), distance);
        // Vertices of large triangles may be far.
        let (_, mut vertex) = nearest(found).or_else(|| nearest(self.scan(context, distance)))?;
        let mut best: Option<(f64, Found)> = None;
        loop {
            let mut next = None;
            for [after, before] in self.spokes(vertex) {
                let corners = [vertex, after, before];
                let places = corners.map(|corner| self.now(corner));
                let shares = closest(point, places.map(|place| place.point.as_dvec3()));
                let sum = |of: fn(&Place) -> Vec3| -> DVec3 {
                    places.iter().zip(shares).map(|(place, share)| of(place).as_dvec3() * share).sum()
                };
                let (place, normal) = (sum(|place| place.point), sum(|place| place.normal));
                let distance = place.distance(point);
                if best.as_ref().is_none_or(|(best, _)| distance < *best)
                    && let Some(normal) = normal.try_normalize()
                {
                    best = Some((distance, Found { point: place, normal }));
                    let most = if shares[1] > shares[2] { 1 } else { 2 };
                    next = Some(corners[most]).filter(|_| shares[most] > 0.0);
                }
            }
            match next {
                Some(other) => vertex = other,
                None => return best.filter(|(distance, _)| *distance <= within).map(|(_, found)| found),
            }
        }
    }

    fn now(&self, vertex: u32) -> Place {
        self.child(vertex).map_or_else(Place::default, |child| self.place(vertex, child))
    }

    /// Where a vertex is after the dabs so far.
    fn so_far(&self, moved: &Moved, vertex: u32) -> Place {
        moved.get(&vertex).copied().unwrap_or_else(|| self.now(vertex))
    }

    /// Makes a dab.
    fn dab(&mut self, context: &Context, (mode, height): (SculptMode, f32), dab: &Dab, moved: &mut Moved) {
        let brush = BrushParameters::new(&dab.brush, dab.strength, &DAffine3::IDENTITY);
        let (center, reach) = (dab.brush.obb().center.as_vec3(), dab.brush.obb().half.length() as f32);
        let is_near = |point: Vec3| point.distance(center) <= reach;
        // Boxes are of the mesh as it was when the stroke began; what has moved since is looked at besides.
        let (before, mesh_moved) =
            (&*moved, |low: Vec3, high: Vec3| low.x <= high.x && is_near(center.clamp(low, high)));
        let find = |mesh: &Self, vertex: u32| {
            (mesh.child(vertex).is_some() && !before.contains_key(&vertex) && is_near(mesh.now(vertex).point))
                .then_some(vertex)
        };
        let mut vertices = self.find_near(context, mesh_moved, find);
        vertices.extend(before.iter().filter(|(_, place)| is_near(place.point)).map(|(vertex, _)| *vertex));
        vertices.sort_unstable();
        let mesh = &*self;
        let made = context.map(vertices.len().div_ceil(BLOCK_KNOTS), |part| {
            let vertices = &vertices[part * BLOCK_KNOTS..vertices.len().min((part + 1) * BLOCK_KNOTS)];
            mesh.dab_block(context, (mode, height), (dab, &brush), (before, vertices))
        });
        for (vertex, point) in made.into_iter().flatten() {
            let place = self.now(vertex);
            moved.entry(vertex).or_insert(place).point = point;
        }
    }

    /// Where a dab puts up to 256 vertices, as far as it has a share in them.
    fn dab_block(
        &self,
        context: &Context,
        (mode, height): (SculptMode, f32),
        (dab, brush): (&Dab, &BrushParameters),
        (moved, vertices): (&Moved, &[u32]),
    ) -> Vec<(u32, Vec3)> {
        const ZERO: PerKnot = [0.0; BLOCK_KNOTS];
        let level = context.level();
        let mut places = Box::new(KnotBlock::ZERO);
        // Far from any brush, where there is no vertex.
        places.p = [[f32::MAX; BLOCK_KNOTS]; 3];
        let (mut risen, mut footprint) = (ZERO, ZERO);
        for (k, vertex) in vertices.iter().enumerate() {
            let (start, place) = (self.now(*vertex), self.so_far(moved, *vertex));
            let normal = if mode == SculptMode::Inflate { self.normal_now(moved, *vertex) } else { start.normal };
            for axis in 0..3 {
                places.p[axis][k] = place.point[axis];
                places.n[axis][k] = normal[axis];
            }
            risen[k] = (place.point - start.point).dot(start.normal);
            if dab.brush.stamp().is_some() {
                let near = self.spokes(*vertex).flatten().map(|other| self.now(other).point.distance(start.point));
                footprint[k] = near.fold(f32::INFINITY, f32::min).min(1e6) / dab.brush.obb().half.x as f32;
            }
        }
        let mut weights = Weights::default();
        weights.evaluate(level, brush, &places, &ZERO);
        weights.share[vertices.len()..].fill(0.0);
        let mut heights = [height; BLOCK_KNOTS];
        if let Some(stamp) = dab.brush.stamp() {
            stamp.sculpt(&footprint, &mut weights, &mut heights, !mode.has_height());
        }
        let place = |k: usize| Vec3::new(places.p[0][k], places.p[1][k], places.p[2][k]);
        let mut shift = [ZERO; 3];
        match mode {
            SculptMode::Smooth | SculptMode::Erase | SculptMode::Pinch | SculptMode::Vector => {
                // Vectors from the vertices, by what is to be added where the share is 1.
                let (mut change, axis) = ([ZERO; 3], dab.brush.axes().z_axis.as_vec3());
                for (k, vertex) in vertices.iter().enumerate().filter(|(k, _)| weights.share[*k] > 0.0) {
                    let here = place(k);
                    let to = match mode {
                        SculptMode::Smooth => self.mean_around(moved, *vertex) - here,
                        SculptMode::Erase => self.built(*vertex).point - here,
                        SculptMode::Vector => axis * heights[k],
                        _ => {
                            let off = here - dab.brush.obb().center.as_vec3();
                            (axis * off.dot(axis) - off) * if height < 0.0 { -1.0 } else { 1.0 }
                        }
                    };
                    (0..3).for_each(|axis| change[axis][k] = to[axis]);
                }
                let input = VectorInput { share: &weights.share, change: &change, mean: None };
                SculptMode::Vector.apply_vectors(level, &input, &mut shift);
            }
            mode => {
                // The weights are those of where a vertex is, so what it has risen counts for layers alone.
                let risen = if mode == SculptMode::Layer { &risen } else { &ZERO };
                let facing = &[1.0; BLOCK_KNOTS];
                let input = SculptInput { weights: &weights, height: &heights, risen, mean: None, facing };
                let mut along = ZERO;
                mode.apply(level, &input, &mut along);
                for axis in 0..3 {
                    (0..vertices.len()).for_each(|k| shift[axis][k] = places.n[axis][k] * along[k]);
                }
            }
        }
        let reached = vertices.iter().enumerate().filter(|(k, _)| weights.share[*k] > 0.0);
        reached.map(|(k, vertex)| (*vertex, place(k) + Vec3::new(shift[0][k], shift[1][k], shift[2][k]))).collect()
    }

    /// The mean of the vertices around one, each as often as triangles have it; along a border only of those at it.
    fn mean_around(&self, moved: &Moved, vertex: u32) -> Vec3 {
        let mut around: Vec<u32> = self.spokes(vertex).flatten().filter(|other| *other != vertex).collect();
        around.sort_unstable();
        let is_open = around.chunk_by(|a, b| a == b).any(|run| run.len() == 1);
        let used = around.chunk_by(|a, b| a == b).filter(|run| !is_open || run.len() == 1).map(|run| run[0]);
        let (sum, count) =
            used.fold((Vec3::ZERO, 0.0), |(sum, count), other| (sum + self.so_far(moved, other).point, count + 1.0));
        if count > 0.0 { sum / count } else { self.so_far(moved, vertex).point }
    }

    /// The sum of the normals of the triangles at a vertex, by their areas.
    fn sum_of_normals(&self, vertex: u32, place: impl Fn(u32) -> Place) -> Vec3 {
        let here = place(vertex).point;
        self.spokes(vertex).map(|ends| ends.map(|end| place(end).point - here)).map(|[a, b]| a.cross(b)).sum()
    }

    /// The normal of a vertex, turned as its triangles have.
    fn normal_now(&self, moved: &Moved, vertex: u32) -> Vec3 {
        let normal = self.now(vertex).normal;
        let before = self.sum_of_normals(vertex, |other| self.now(other)).try_normalize();
        let after = self.sum_of_normals(vertex, |other| self.so_far(moved, other)).try_normalize();
        match before.zip(after) {
            Some((before, after)) if before != after => arc(before, after) * normal,
            _ => normal,
        }
    }

    /// Vertices that have moved and those around them, with their new normals.
    fn turned(&self, moved: &Moved) -> Vec<(u32, Place)> {
        let around = moved.keys().flat_map(|vertex| self.spokes(*vertex).flatten());
        let mut all: Vec<u32> = moved.keys().copied().chain(around).collect();
        all.sort_unstable();
        all.dedup();
        let place = |vertex| Place { point: self.so_far(moved, vertex).point, normal: self.normal_now(moved, vertex) };
        all.into_iter()
            .map(|vertex| (vertex, place(vertex)))
            .filter(|(vertex, place)| *place != self.now(*vertex))
            .collect()
    }
}

fn refused(what: &str, remedy: &str) -> Error {
    Error::invalid(what).at("stroke").advise(remedy)
}
