//! Culling by occlusion on the processor (Section 5.2): agents that others hide are not drawn.
//!
//! The agents that were seen in the last frame are rasterised first, as depths at the centres of pixels with the smallest of
//! each 8 × 8 tile. An agent is hidden if these depths are nearer than the front of its box at every pixel that the box covers, and
//! so are groups of clusters of agents that are cut group by group. What is the nearest at a pixel is never hidden there, since its
//! box begins no later than its surface; so a picture with one sample in the middle of each pixel is the same as without culling.
//! Agents and groups that were hidden are drawn again as soon as their boxes are seen. Where occluders have more triangles than
//! they hide, culling rests for a while.

use std::collections::HashMap;
use std::collections::hash_map::Entry;

use glam::{DMat3, DVec3, Vec3};
use relievo_core::{Context, Error, Result};

use crate::crowd::{Crowd, Drawn, Frame, PoseKey};
use crate::hierarchy::{CrowdModel, Group};
use crate::skinning::skin;

/// Triangles of occluders at most; the nearest agents come first.
const MAX_TRIANGLES: u64 = 1 << 18;
/// Pixels along the side of a tile.
const TILE: usize = 8;
/// Rows of a task.
const BAND: usize = 32;
/// Relative rounding of depths.
const ROUNDING: f32 = 1e-5;
/// Pixels that boxes are widened by, for rounding.
const WIDENED: f64 = 0.01;
/// Frames with a loss after which culling rests, at first and after a rest. In the first of them all agents are occluders.
const LOSSES: [u32; 2] = [4, 2];
/// Frames of a rest.
const REST: u32 = 32;
/// Pixels of a picture at most.
const MAX_PIXELS: u64 = 1 << 26;

/// A camera whose picture has one sample in the middle of each pixel.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PixelView {
    /// Where it is.
    pub eye: DVec3,
    /// Directions to the right, up, and against the direction of view, of length 1.
    pub axes: DMat3,
    /// Vertical field of view in radians.
    pub fov: f64,
    /// Pixels of the picture.
    pub size: [u32; 2],
}

/// What culling did.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Culled {
    /// Agents that were taken out of the frame.
    pub hidden: u32,
    /// Clusters that were taken out of agents that are still in it.
    pub hidden_clusters: u64,
    /// Triangles of all of these.
    pub hidden_triangles: u64,
    /// Triangles of the occluders.
    pub occluder_triangles: u64,
    /// Whether culling rested.
    pub is_resting: bool,
}

/// The state of culling between frames.
#[derive(Debug, Default)]
pub struct Occlusion {
    /// Whether each agent was seen in the last frame.
    seen: Vec<bool>,
    /// The groups of these that were hidden, in order.
    hidden_groups: Vec<(u32, u32)>,
    /// Inverse depth at each pixel, 0 where there is no occluder, row after row from the top.
    depths: Vec<f32>,
    /// The smallest of each tile.
    tiles: Vec<f32>,
    rest: Rest,
}

/// When culling rests: after some frames with a loss, for a while. It counts work, not time, so that frames do not depend on the
/// machine.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Rest {
    losses: u32,
    /// Frames that are left of a rest.
    frames: u32,
}

impl Rest {
    /// Returns whether culling rests in the next frame, which is counted.
    pub fn is_resting(&mut self) -> bool {
        let rests = self.frames > 0;
        self.frames = self.frames.saturating_sub(1);
        rests
    }

    /// Counts a frame in which culling did not rest, with the work that it saved and spent.
    pub fn count(&mut self, saved: u64, spent: u64) {
        self.losses = if saved < spent { self.losses + 1 } else { 0 };
        let [first, later] = LOSSES;
        if self.losses >= first {
            *self = Self { losses: first - later, frames: REST };
        }
    }
}

/// The corners of a triangle in pixels, with their inverse depths.
type Projected = [[f64; 3]; 3];

/// The clusters of an agent, with how far their vertices are on the way.
type Blended = Vec<(u32, f32)>;

/// A box in the picture.
struct Extent {
    /// First and last column and row of the pixels whose middle it may cover.
    columns: [usize; 2],
    rows: [usize; 2],
    /// The inverse depth of its front.
    front: f32,
}

impl Occlusion {
    /// Takes the agents that others hide out of a frame, which [`Crowd::cut`] found for the same view at `time` seconds. In
    /// the first frame all agents in view count as seen in the frame before.
    ///
    /// # Errors
    /// The view is not finite, or has no pixels or too many.
    pub fn cull(
        &mut self,
        context: &Context,
        crowd: &Crowd,
        (view, time): (&PixelView, f64),
        frame: &mut Frame,
    ) -> Result<Culled> {
        view.check()?;
        let is_first = self.seen.is_empty();
        self.seen.resize(crowd.agents().len(), false);
        if is_first {
            self.remember(frame);
        }
        if self.rest.is_resting() {
            self.remember(frame);
            self.hidden_groups.clear();
            return Ok(Culled { is_resting: true, ..Culled::default() });
        }
        let (occluders, occluder_triangles) = self.occluders(crowd, view, frame);
        self.rasterise(context, crowd, (view, time), &occluders)?;
        let width = view.size[0] as usize;
        let is_hidden = context.map(frame.drawn.len(), |at| {
            extent_of_agent(crowd, view, frame.drawn[at]).is_some_and(|extent| self.hides(&extent, width))
        });
        let hidden_groups = context.map(frame.drawn.len(), |at| match is_hidden[at] {
            true => Vec::new(),
            false => self.groups_hidden(crowd, view, (frame, frame.drawn[at])),
        });
        self.hidden_groups.clear();
        for (drawn, groups) in frame.drawn.iter().zip(&hidden_groups) {
            self.hidden_groups.extend(groups.iter().map(|group| (drawn.0, *group)));
        }
        let mut found = remove(crowd, frame, (&is_hidden, &hidden_groups));
        found.occluder_triangles = occluder_triangles;
        self.remember(frame);
        self.rest.count(found.hidden_triangles, found.occluder_triangles);
        Ok(found)
    }

    /// Returns the nearest agents that were seen in the last frame, with their clusters that were, and their number of triangles.
    fn occluders(&self, crowd: &Crowd, view: &PixelView, frame: &Frame) -> (Vec<(u32, Blended)>, u64) {
        let away =
            |drawn: &(u32, Drawn)| crowd.agents()[drawn.0 as usize].transform.translation.distance_squared(view.eye);
        let seen = frame.drawn.iter().filter(|drawn| self.seen[drawn.0 as usize] && drawn.1 != Drawn::Impostor);
        let mut order: Vec<&(u32, Drawn)> = seen.collect();
        order.sort_by(|a, b| away(a).total_cmp(&away(b)).then(a.0.cmp(&b.0)));
        let (mut occluders, mut triangles) = (Vec::new(), 0);
        for drawn in order {
            let model = model_of(crowd, drawn.0);
            let clusters = self.seen_before(crowd, frame, *drawn);
            let count: u64 = clusters.iter().map(|it| u64::from(model.clusters[it.0 as usize].count)).sum();
            if triangles + count > MAX_TRIANGLES {
                continue;
            }
            triangles += count;
            occluders.push((drawn.0, clusters));
        }
        (occluders, triangles)
    }

    /// Returns the groups of an agent that are hidden where it is cut group by group, in order.
    fn groups_hidden(&self, crowd: &Crowd, view: &PixelView, (frame, drawn): (&Frame, (u32, Drawn))) -> Vec<u32> {
        let Drawn::Mixed { .. } = drawn.1 else { return Vec::new() };
        let model = model_of(crowd, drawn.0);
        let clusters = crowd.clusters(frame, drawn).iter();
        let mut groups: Vec<u32> = clusters.map(|cluster| model.clusters[*cluster as usize].used_by).collect();
        groups.sort_unstable();
        groups.dedup();
        groups.retain(|group| {
            let Some(Group { low, high, .. }) = model.groups.get(*group as usize) else { return false };
            let found = extent(crowd, view, drawn.0, (low, high, crowd.moved(drawn.0)));
            found.is_some_and(|extent| self.hides(&extent, view.size[0] as usize))
        });
        groups
    }

    /// Returns the clusters of an agent, but those of groups that were hidden in the last frame.
    fn seen_before(&self, crowd: &Crowd, frame: &Frame, drawn: (u32, Drawn)) -> Blended {
        let model = model_of(crowd, drawn.0);
        let is_seen = |cluster: u32| {
            let group = model.clusters[cluster as usize].used_by;
            self.hidden_groups.binary_search(&(drawn.0, group)).is_err()
        };
        let blends = crowd.blends(frame, drawn).iter().copied().chain(std::iter::repeat(0.0));
        crowd.clusters(frame, drawn).iter().copied().zip(blends).filter(|(cluster, _)| is_seen(*cluster)).collect()
    }

    /// Notes which agents are drawn.
    fn remember(&mut self, frame: &Frame) {
        self.seen.fill(false);
        frame.drawn.iter().for_each(|drawn| self.seen[drawn.0 as usize] = true);
    }

    /// Fills the depths with the triangles of occluders.
    fn rasterise(
        &mut self,
        context: &Context,
        crowd: &Crowd,
        (view, time): (&PixelView, f64),
        occluders: &[(u32, Blended)],
    ) -> Result<()> {
        // Agents in the same pose share it.
        let mut poses: HashMap<PoseKey, Vec<[f32; 3]>> = HashMap::new();
        for (agent, _) in occluders {
            let key = crowd.pose_key(*agent, time);
            if let Entry::Vacant(place) = poses.entry(key) {
                let found = &crowd.models()[key.model as usize];
                place.insert(skin(context, &found.character, &crowd.posed(&key), found.blend)?);
            }
        }
        let projected: Vec<Vec<Projected>> = context.map(occluders.len(), |at| {
            let (number, clusters) = &occluders[at];
            let agent = &crowd.agents()[*number as usize];
            let model = &crowd.models()[agent.model as usize];
            let points = &poses[&crowd.pose_key(*number, time)];
            let corner = |of: (u32, f32), vertex: u32| {
                let place = Vec3::from(model.blended(of, vertex, points)).as_dvec3();
                view.project(agent.transform.transform_point3(place))
            };
            let of_cluster = |of: &(u32, f32)| {
                let of = *of;
                crowd.triangles(agent.model, of.0).0.iter().map(move |it| (of, it))
            };
            let triangles = clusters.iter().flat_map(of_cluster);
            // A triangle that reaches behind the camera hides nothing.
            triangles.filter_map(|(of, [a, b, c])| Some([corner(of, *a)?, corner(of, *b)?, corner(of, *c)?])).collect()
        });
        let [width, height] = view.size.map(|side| side as usize);
        self.depths.clear();
        self.depths.resize(width * height, 0.0);
        context.for_each_part(self.depths.as_mut_slice(), BAND * width, |first, rows| {
            let first = first / width;
            projected.iter().flatten().for_each(|triangle| fill(triangle, (first, width), rows));
            Ok(())
        })?;
        let across = width.div_ceil(TILE);
        self.tiles.clear();
        self.tiles.resize(across * height.div_ceil(TILE), f32::INFINITY);
        for (row, depths) in self.depths.chunks_exact(width).enumerate() {
            for (tile, depths) in depths.chunks(TILE).enumerate() {
                let smallest = &mut self.tiles[row / TILE * across + tile];
                *smallest = depths.iter().copied().fold(*smallest, f32::min);
            }
        }
        Ok(())
    }

    /// Whether all pixels of a box have something before its front.
    fn hides(&self, extent: &Extent, width: usize) -> bool {
        let front = extent.front * (1.0 + ROUNDING);
        let ([left, right], [top, bottom]) = (extent.columns, extent.rows);
        let across = width.div_ceil(TILE);
        (top / TILE..=bottom / TILE).all(|y| {
            (left / TILE..=right / TILE).all(|x| {
                self.tiles[y * across + x] > front || {
                    let rows = (y * TILE).max(top)..=(y * TILE + TILE - 1).min(bottom);
                    let (from, to) = ((x * TILE).max(left), (x * TILE + TILE - 1).min(right));
                    rows.into_iter().all(|row| {
                        self.depths[row * width + from..=row * width + to].iter().all(|depth| *depth > front)
                    })
                }
            })
        })
    }
}

impl PixelView {
    /// Checks that places are finite and that there are pixels, but not too many.
    ///
    /// # Errors
    /// Says what is out of range.
    pub(crate) fn check(&self) -> Result<()> {
        let [width, height] = self.size.map(u64::from);
        let is_finite = self.eye.is_finite() && self.axes.is_finite() && self.fov > 0.0 && self.fov < 3.1;
        if !is_finite || width * height == 0 || width * height > MAX_PIXELS {
            return Err(Error::invalid("the view is not finite, or has no pixels or more than 2^26").at("view"));
        }
        Ok(())
    }

    /// Returns the pixels of what has the length of its distance.
    pub(crate) fn pixels(&self) -> f64 {
        0.5 * f64::from(self.size[1]) / (0.5 * self.fov).tan()
    }

    /// Returns column, row and inverse depth of a place, nothing unless it is before the camera.
    fn project(&self, place: DVec3) -> Option<[f64; 3]> {
        let at = self.axes.transpose() * (place - self.eye);
        let inverse = -1.0 / at.z;
        if !(at.z < 0.0 && inverse.is_finite()) {
            return None;
        }
        let [half_width, half_height] = self.size.map(|side| 0.5 * f64::from(side));
        let factor = self.pixels() * inverse;
        Some([half_width + factor * at.x, half_height - factor * at.y, inverse])
    }
}

fn model_of(crowd: &Crowd, agent: u32) -> &CrowdModel {
    &crowd.models()[crowd.agents()[agent as usize].model as usize]
}

/// Takes hidden agents, and the clusters of hidden groups of others, out of a frame.
fn remove(crowd: &Crowd, frame: &mut Frame, (is_hidden, hidden_groups): (&[bool], &[Vec<u32>])) -> Culled {
    let mut culled = Culled::default();
    let (mut drawn, mut mixed, mut blends) = (Vec::with_capacity(frame.drawn.len()), Vec::new(), Vec::new());
    let (mut clusters, mut triangles) = (0, 0);
    for ((entry, is_hidden), groups) in frame.drawn.iter().zip(is_hidden).zip(hidden_groups) {
        let model = model_of(crowd, entry.0);
        let of = crowd.clusters(frame, *entry);
        let all = if entry.1 == Drawn::Impostor { 2 } else { model.triangle_count(of) };
        let is_seen = |cluster: u32| groups.binary_search(&model.clusters[cluster as usize].used_by).is_err();
        let left: Vec<usize> = match is_hidden {
            true => Vec::new(),
            false => (0..of.len()).filter(|at| groups.is_empty() || is_seen(of[*at])).collect(),
        };
        // Of a near agent whose groups are all beside the picture there is nothing to hide.
        let is_kept = !is_hidden && of.is_empty();
        if left.is_empty() && !is_kept {
            culled.hidden += 1;
            culled.hidden_triangles += all;
            continue;
        }
        let first = mixed.len() as u32;
        if let Drawn::Mixed { .. } = entry.1 {
            let known = crowd.blends(frame, *entry);
            mixed.extend(left.iter().map(|at| of[*at]));
            blends.extend(left.iter().filter_map(|at| known.get(*at)));
            let shown = model.triangle_count(&mixed[first as usize..]);
            culled.hidden_clusters += (of.len() - left.len()) as u64;
            culled.hidden_triangles += all - shown;
            triangles += shown;
            drawn.push((entry.0, Drawn::Mixed { first, count: left.len() as u32 }));
        } else {
            triangles += all;
            drawn.push(*entry);
        }
        clusters += left.len() as u64;
    }
    (frame.drawn, frame.mixed, frame.blends) = (drawn, mixed, blends);
    (frame.clusters, frame.triangles) = (clusters, triangles);
    culled
}

/// Returns the pixels that the box of an agent may cover; nothing where it reaches behind the camera or covers none.
fn extent_of_agent(crowd: &Crowd, view: &PixelView, (agent, drawn): (u32, Drawn)) -> Option<Extent> {
    let model = model_of(crowd, agent);
    // The square of an impostor is in a sphere around the box of the pose.
    let square = if drawn == Drawn::Impostor { 0.5 * model.size() } else { 0.0 };
    extent(crowd, view, agent, (&model.low, &model.high, crowd.moved(agent) + square))
}

/// Returns the pixels that a box in the space of an agent's model, widened on all sides, may cover; nothing as above.
fn extent(
    crowd: &Crowd,
    view: &PixelView,
    agent: u32,
    (low, high, moved): (&[f32; 3], &[f32; 3], f32),
) -> Option<Extent> {
    let agent = &crowd.agents()[agent as usize];
    let ends = [low.map(|value| value - moved), high.map(|value| value + moved)];
    let (mut low, mut high) = ([f64::INFINITY; 3], [f64::NEG_INFINITY; 3]);
    for corner in 0..8 {
        let place: [f64; 3] = std::array::from_fn(|axis| f64::from(ends[corner >> axis & 1][axis]));
        let place = view.project(agent.transform.transform_point3(DVec3::from(place)))?;
        for axis in 0..3 {
            (low[axis], high[axis]) = (low[axis].min(place[axis]), high[axis].max(place[axis]));
        }
    }
    let range = |axis: usize| {
        let first = (low[axis] - WIDENED - 0.5).ceil().max(0.0);
        let last = (high[axis] + WIDENED - 0.5).floor().min(f64::from(view.size[axis]) - 1.0);
        (first <= last).then_some([first as usize, last as usize])
    };
    Some(Extent { columns: range(0)?, rows: range(1)?, front: high[2] as f32 })
}

/// Raises the inverse depths of the pixels whose middle a triangle covers, in rows from `first` on.
fn fill(triangle: &Projected, (first, width): (usize, usize), rows: &mut [f32]) {
    let [a, b, c] = *triangle;
    let area = (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0]);
    if area == 0.0 || !area.is_finite() {
        return;
    }
    let low = |axis: usize| (a[axis].min(b[axis]).min(c[axis]) - 0.5).ceil().max(0.0) as usize;
    let high = |axis: usize| (a[axis].max(b[axis]).max(c[axis]) + 0.5).floor().max(0.0) as usize;
    let (top, bottom) = (low(1).max(first), high(1).min(first + rows.len() / width));
    let (left, right) = (low(0), high(0).min(width));
    for row in top..bottom {
        let y = row as f64 + 0.5;
        for column in left..right {
            let x = column as f64 + 0.5;
            let weight = |from: [f64; 3], to: [f64; 3]| {
                ((to[0] - from[0]) * (y - from[1]) - (to[1] - from[1]) * (x - from[0])) / area
            };
            let [u, v, w] = [weight(b, c), weight(c, a), weight(a, b)];
            if u >= 0.0 && v >= 0.0 && w >= 0.0 {
                let depth = (u * a[2] + v * b[2] + w * c[2]) as f32;
                let known = &mut rows[(row - first) * width + column];
                *known = known.max(depth);
            }
        }
    }
}
