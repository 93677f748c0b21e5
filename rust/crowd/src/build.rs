//! Building a cluster hierarchy, level upon level.

mod collapse;
mod deformation;
mod eigen;
mod grouping;
pub(crate) mod measure;
pub(crate) mod norm;
mod partition;
mod places;
pub(crate) mod refit;
mod representative;

use glam::DVec3;
use relievo_core::{Context, Error, Progress, Result};
use relievo_meshio::Model;

pub(crate) use crate::build::collapse::Face;
use crate::build::measure::Gauged;
use crate::build::places::Places;
use crate::build::representative::representatives;
use crate::character::Character;
use crate::clip::{self, Clip, Skeleton};
use crate::geomorph::Collapse;
use crate::hierarchy::{BuildSettings, Cluster, CrowdModel, Group, NONE, Report, Variant};

/// Share of the triangles that are to be removed which a simplification has to remove to count as one.
const REMOVED: f64 = 0.3;
/// Share of the triangles that a level has of those of the level before.
const SHARE: f64 = 0.5;
/// The same once the whole surface is one group: there are no parts to choose cuts from, so levels are nearer.
const WHOLE_SHARE: f64 = 0.8;
/// The same for levels of at most so many triangles, which take little room.
const SMALL_SHARES: [(usize, f64); 2] = [(100, 0.95), (1024, 0.9)];
/// Triangles of the whole surface, in full groups, from which it is one group.
const WHOLE: usize = 10;
/// Groups that small models have at the first level.
const GROUPS: usize = 8;
/// Clusters of a group in small models.
const FEWEST: usize = 4;
/// Levels at most. Each leaves about half of the triangles.
const MAX_LEVELS: u32 = 64;
/// Relative difference of the lengths of a bone's axes between poses up to which it is rigid.
const RIGID: f64 = 1e-5;
/// Share of the model's size that boxes are widened by, for the rounding of skinned vertices.
const ROUNDING: f32 = 1e-5;
/// A place that belongs to several groups, or to none.
const SHARED: u32 = u32::MAX;

/// A character in its poses, with what simplification and measurement need of it.
pub(crate) struct Builder<'a> {
    character: &'a Character,
    places: Places,
    skeletons: Vec<&'a Skeleton>,
    /// Which skeletons are representative.
    is_representative: Vec<bool>,
    /// Positions of all vertices in the representative poses.
    posed: Vec<Vec<[f32; 3]>>,
    /// Boxes of the paths of all vertices.
    paths: Vec<[[f32; 3]; 2]>,
    levels: Vec<f32>,
    /// Whether each bone keeps all lengths alike in all poses.
    is_rigid: Vec<bool>,
    size: f32,
    low: [f32; 3],
    high: [f32; 3],
}

/// The result of simplifying a group.
struct Simplified {
    /// Faces of each new cluster.
    pieces: Vec<Vec<Face>>,
    /// Removed places and vertices with what they went to.
    places: Vec<(u32, u32)>,
    vertices: Vec<(u32, u32)>,
    gauged: Gauged,
}

/// The whole surface when it first was one group. Without neighbours it can be simplified from there to each level, and
/// distances are measured from it: the sum of those from level to level would be several times as large.
pub(crate) struct Base {
    pub faces: Vec<Face>,
    /// Its distance from the input's surface at most.
    pub error: f32,
}

pub(crate) fn build(
    context: &Context,
    (model, animations): (&Model, &[usize]),
    settings: &BuildSettings,
    variant: &Variant,
    progress: &mut dyn Progress,
) -> Result<CrowdModel> {
    progress.step(0.0, "read poses")?;
    let (character, morphs) = Character::animated(context, model, animations)?;
    let clips = clip::sample(context, model, (&character, &morphs), animations, settings.pose_rate)?;
    let mut builder = Builder::new(context, &character, &clips, settings)?;
    let most = settings.cluster_triangles as usize;
    let leaves = match variant.clusters {
        None => partition::leaves(&character, &builder.places, &builder.levels, builder.size, most),
        Some(clusters) => {
            check_clusters(&character, clusters, most)?;
            builder.levels.fill(0.0);
            clusters.to_vec()
        }
    };
    let made = builder.run(context, settings, (&leaves, variant.is_whole), progress)?;
    Ok(builder.finished(made, &clips))
}

impl<'a> Builder<'a> {
    /// Finds out what simplification and measurement need of a character and the poses of its clips.
    ///
    /// # Errors
    /// A vertex is not finite in some pose, or memory does not suffice.
    pub fn new(
        context: &Context,
        character: &'a Character,
        clips: &'a [clip::Sampled],
        settings: &BuildSettings,
    ) -> Result<Self> {
        let skeletons: Vec<&Skeleton> = clips.iter().flat_map(|clip| &clip.skeletons).collect();
        check_memory(context, character, skeletons.len())?;
        let paths = paths(context, character, &skeletons)?;
        let (low, high) = paths.iter().fold(([f32::INFINITY; 3], [f32::NEG_INFINITY; 3]), |(low, high), path| {
            (lower(low, path[0]), upper(high, path[1]))
        });
        let size = glam::Vec3::from(high).distance(low.into());
        if !size.is_finite() {
            return Err(Error::invalid("the model is larger than 10^19 units in some pose")
                .advise("scale it down, and check the scales of its bones"));
        }
        // Lengths between poses are compared with the model at rest, which does not walk away.
        let still = rest_size(character, skeletons[0]);
        let chosen = representatives(character, &skeletons, f64::from(settings.pose_distance) * still);
        let mut is_representative = vec![false; skeletons.len()];
        chosen.iter().for_each(|pose| is_representative[*pose] = true);
        Ok(Self {
            posed: chosen.iter().map(|pose| placed(context, character, skeletons[*pose])).collect(),
            levels: deformation::levels(context, character, &skeletons),
            is_rigid: rigid_bones(&skeletons),
            places: Places::of(character),
            size,
            character,
            skeletons,
            is_representative,
            paths,
            low,
            high,
        })
    }

    /// Returns the counts of poses, without measurements.
    pub fn report(&self) -> Report {
        Report { poses: self.skeletons.len() as u32, representatives: self.posed.len() as u32, ..Report::default() }
    }

    /// Returns a model with its bounds and clips.
    pub fn finished(&self, mut made: CrowdModel, clips: &[clip::Sampled]) -> CrowdModel {
        let margin = ROUNDING * self.size;
        (made.low, made.high) = (self.low.map(|value| value - margin), self.high.map(|value| value + margin));
        for group in &mut made.groups {
            (group.low, group.high) = (group.low.map(|value| value - margin), group.high.map(|value| value + margin));
        }
        let poses = |clip: &clip::Sampled| clip.skeletons.iter().map(Skeleton::pose).collect();
        made.clips =
            clips.iter().map(|clip| Clip { name: clip.name.clone(), rate: clip.rate, poses: poses(clip) }).collect();
        made
    }

    fn run(
        &self,
        context: &Context,
        settings: &BuildSettings,
        (leaves, is_whole): (&[Vec<u32>], bool),
        progress: &mut dyn Progress,
    ) -> Result<CrowdModel> {
        let most = settings.cluster_triangles as usize;
        let mut made = CrowdModel {
            input_triangles: self.character.triangles.len() as u32,
            report: self.report(),
            character: Character { triangles: Vec::new(), materials: Vec::new(), ..self.character.clone() },
            collapses: (0..self.character.points.len() as u32).map(|target| Collapse { group: NONE, target }).collect(),
            ..CrowdModel::default()
        };
        let face = |triangle: &u32| {
            let triangle = *triangle as usize;
            (self.character.triangles[triangle], self.character.materials[triangle])
        };
        for piece in leaves {
            self.add(&mut made, piece.iter().map(face).collect(), NONE, 0);
        }
        let mut front: Vec<u32> = (0..made.clusters.len() as u32).collect();
        let whole = (WHOLE * settings.group_clusters as usize * most) as u64;
        // Larger groups have fewer places on borders, smaller ones leave more choice to cuts.
        let group = (front.len() / GROUPS).clamp(FEWEST, settings.group_clusters as usize);
        for level in 1..=MAX_LEVELS {
            // Most levels have about half of the triangles of the one before.
            let start = 1.0 - 0.5f32.powi(level as i32 - 1);
            let span = [start, 0.5 * (1.0 + start)];
            if is_whole && made.triangle_count(&front) <= whole {
                self.whole(&mut made, front, (context, most), (progress, span))?;
                break;
            }
            let groups = grouping::grouped(&made, &self.places, &front, group, self.size);
            let owners = self.owners(&made, &groups);
            let results = context.map_watched(groups.len(), progress, ("simplify", span), |group| {
                self.simplify(&made, &groups[group], (group as u32, &owners), most)
            })?;
            let mut next = Vec::new();
            let mut is_done = true;
            for (clusters, result) in groups.iter().zip(results) {
                match result? {
                    Some(result) => {
                        next.extend(self.replace(&mut made, clusters, result, None));
                        is_done = false;
                    }
                    None => next.extend(clusters),
                }
            }
            if is_done {
                break;
            }
            front = next;
        }
        progress.step(1.0, "simplify")?;
        Ok(made)
    }

    /// Returns the largest deformation level of some vertices.
    pub fn deformation<'v>(&self, vertices: impl Iterator<Item = &'v u32>) -> f32 {
        vertices.map(|vertex| self.levels[*vertex as usize]).fold(0.0, f32::max)
    }

    /// Returns a group of clusters with the error of its simplification, above the groups below it. `added` is the distance
    /// that was measured from those clusters, or from a base.
    pub fn group(&self, made: &CrowdModel, clusters: &[u32], (added, base): (f32, Option<&Base>)) -> Group {
        let mut group = Group { error: 0.0, low: [f32::INFINITY; 3], high: [f32::NEG_INFINITY; 3], depth: 1 };
        for cluster in clusters {
            for vertex in made.triangles(*cluster).iter().flatten() {
                let [low, high] = self.paths[*vertex as usize];
                (group.low, group.high) = (lower(group.low, low), upper(group.high, high));
            }
            if let Some(below) = made.groups.get(made.clusters[*cluster as usize].made_by as usize) {
                group.error = group.error.max(below.error);
                group.depth = group.depth.max(below.depth + 1);
                (group.low, group.high) = (lower(group.low, below.low), upper(group.high, below.high));
            }
        }
        // Rounding must not bring the sum below what it bounds.
        let from = base.map_or(group.error, |base| base.error);
        let error = if added > 0.0 { (from + added).next_up() } else { from };
        group.error = group.error.max(error);
        group
    }

    /// Returns clusters of the whole surface as a base. Its distance from the input is measured, since those from level to level
    /// add up to more.
    ///
    /// # Errors
    /// Memory does not suffice.
    pub fn base(&self, context: &Context, made: &CrowdModel, clusters: &[u32]) -> Result<Base> {
        let faces = made.faces(clusters);
        let sum = self.group(made, clusters, (0.0, None)).error;
        if made.groups.is_empty() {
            return Ok(Base { faces, error: sum });
        }
        let input = made.clusters.iter().zip(0..).filter(|(cluster, _)| cluster.made_by == NONE);
        let input = made.faces(&input.map(|(_, number)| number).collect::<Vec<u32>>());
        let direct = self.measure(context, &input, &faces)?.distances.all;
        Ok(Base { faces, error: sum.min(direct) })
    }

    /// Adds a cluster and returns its index.
    fn add(&self, made: &mut CrowdModel, faces: Vec<Face>, made_by: u32, depth: u32) -> u32 {
        let first = made.character.triangles.len() as u32;
        let deformation = self.deformation(faces.iter().flat_map(|(triangle, _)| triangle));
        made.clusters.push(Cluster { first, count: faces.len() as u32, made_by, used_by: NONE, deformation, depth });
        made.character.triangles.extend(faces.iter().map(|face| face.0));
        made.character.materials.extend(faces.iter().map(|face| face.1));
        made.clusters.len() as u32 - 1
    }

    /// Makes a group of clusters with what they were simplified to. Returns the new clusters.
    fn replace(&self, made: &mut CrowdModel, clusters: &[u32], result: Simplified, base: Option<&Base>) -> Vec<u32> {
        let number = made.groups.len() as u32;
        let group = self.group(made, clusters, (result.gauged.distances.all, base));
        clusters.iter().for_each(|cluster| made.clusters[*cluster as usize].used_by = number);
        result.gauged.note(made);
        made.groups.push(group);
        self.note(made, number, &result);
        result.pieces.into_iter().map(|faces| self.add(made, faces, number, group.depth)).collect()
    }

    /// Notes where the vertices of the places went that a group removed. Simplification from a base has removed some before.
    fn note(&self, made: &mut CrowdModel, group: u32, result: &Simplified) {
        for (from, to) in &result.places {
            for vertex in self.places.at(*from) {
                let found = &mut made.collapses[*vertex as usize];
                if found.group == NONE {
                    let known = result.vertices.binary_search_by_key(vertex, |pair| pair.0);
                    let nearest = || collapse::nearest(self.character, *vertex, self.places.at(*to));
                    let target = known.map_or_else(|_| nearest(), |at| result.vertices[at].1);
                    *found = Collapse { group, target };
                }
            }
        }
    }

    /// Returns the group of every place; [`SHARED`] for places that several groups have, or none.
    fn owners(&self, made: &CrowdModel, groups: &[Vec<u32>]) -> Vec<u32> {
        const FREE: u32 = u32::MAX - 1;
        let mut owners = vec![FREE; self.places.len()];
        for (number, clusters) in groups.iter().enumerate() {
            for vertex in clusters.iter().flat_map(|cluster| made.triangles(*cluster)).flatten() {
                let owner = &mut owners[self.places.of[*vertex as usize] as usize];
                *owner = if *owner == FREE || *owner == number as u32 { number as u32 } else { SHARED };
            }
        }
        owners
    }

    /// Simplifies the clusters of a group to a share of their triangles. Returns nothing where too little could be removed.
    fn simplify(
        &self,
        made: &CrowdModel,
        clusters: &[u32],
        (number, owners): (u32, &[u32]),
        most: usize,
    ) -> Result<Option<Simplified>> {
        let faces = made.faces(clusters);
        let is_locked = |place: u32| owners[place as usize] != number;
        let input = self.input(&is_locked);
        let left = collapse::Work::new(&input, &faces).left((SHARE * faces.len() as f64) as usize);
        if !is_level(left.faces.len(), (SHARE, faces.len())) {
            return Ok(None);
        }
        let measured = self.measure(&Context::serial(), &faces, &left.faces)?;
        Ok(Some(self.simplified(left, measured, most)))
    }

    /// Simplifies the whole surface as one group to the end. It has no neighbours, so that every level goes on from the one before.
    fn whole(
        &self,
        made: &mut CrowdModel,
        mut front: Vec<u32>,
        (context, most): (&Context, usize),
        (progress, span): (&mut dyn Progress, [f32; 2]),
    ) -> Result<()> {
        front.sort_unstable();
        let base = self.base(context, made, &front)?;
        let input = self.input(&|_| false);
        let mut work = collapse::Work::new(&input, &base.faces);
        let (mut levels, mut count) = (Vec::new(), base.faces.len());
        loop {
            let small = SMALL_SHARES.iter().find(|(most, _)| count <= *most);
            let share = small.map_or(WHOLE_SHARE, |(_, share)| *share);
            let left = work.left((share * count as f64) as usize);
            if !is_level(left.faces.len(), (share, count)) {
                break;
            }
            count = left.faces.len();
            levels.push(left);
        }
        let measured = context.map_watched(levels.len(), progress, ("measure", span), |level| {
            self.measure(&Context::serial(), &base.faces, &levels[level].faces)
        })?;
        for (left, measured) in levels.into_iter().zip(measured) {
            front = self.replace(made, &front, self.simplified(left, measured?, most), Some(&base));
        }
        Ok(())
    }

    /// Returns what simplification works with.
    fn input<'b>(&'b self, is_locked: &'b (dyn Fn(u32) -> bool + Sync)) -> collapse::Input<'b> {
        collapse::Input { character: self.character, places: &self.places, posed: &self.posed, is_locked }
    }

    /// Divides what is left of a group into clusters.
    fn simplified(&self, left: collapse::Left, gauged: Gauged, most: usize) -> Simplified {
        let collapse::Left { faces: left, places, vertices } = left;
        let center = |face: u32| partition::center(self.character, left[face as usize].0);
        let pieces = partition::cut((0..left.len() as u32).collect(), most, &center);
        let pieces = pieces.iter().map(|piece| piece.iter().map(|face| left[*face as usize]).collect()).collect();
        Simplified { pieces, places, vertices, gauged }
    }
}

pub(crate) fn lower(a: [f32; 3], b: [f32; 3]) -> [f32; 3] {
    std::array::from_fn(|axis| a[axis].min(b[axis]))
}

pub(crate) fn upper(a: [f32; 3], b: [f32; 3]) -> [f32; 3] {
    std::array::from_fn(|axis| a[axis].max(b[axis]))
}

/// Whether a simplification to a share of some triangles left few enough to be a level.
fn is_level(left: usize, (share, triangles): (f64, usize)) -> bool {
    left > 0 && left as f64 <= (1.0 - REMOVED * (1.0 - share)) * triangles as f64
}

/// Returns the diagonal of the box of a character in a pose.
fn rest_size(character: &Character, skeleton: &Skeleton) -> f64 {
    let points = (0..character.points.len()).map(|vertex| skeleton.place(character, vertex));
    let (low, high) =
        points.fold((DVec3::INFINITY, DVec3::NEG_INFINITY), |(low, high), point| (low.min(point), high.max(point)));
    (high - low).length()
}

/// Returns the positions of all vertices in a pose.
fn placed(context: &Context, character: &Character, skeleton: &Skeleton) -> Vec<[f32; 3]> {
    context.map(character.points.len(), |vertex| skeleton.place(character, vertex).as_vec3().to_array())
}

/// Returns the boxes of the paths of all vertices.
fn paths(context: &Context, character: &Character, skeletons: &[&Skeleton]) -> Result<Vec<[[f32; 3]; 2]>> {
    let paths = context.map(character.points.len(), |vertex| {
        let places = skeletons.iter().map(|skeleton| skeleton.place(character, vertex));
        let (low, high) =
            places.fold((DVec3::INFINITY, DVec3::NEG_INFINITY), |(low, high), place| (low.min(place), high.max(place)));
        [low.as_vec3().to_array(), high.as_vec3().to_array()]
    });
    match paths.iter().position(|path| path.as_flattened().iter().any(|value| !value.is_finite())) {
        None => Ok(paths),
        Some(vertex) => Err(Error::invalid(format!("vertex {vertex} is not finite in some pose"))
            .advise("repair the animation and export it again")),
    }
}

/// Returns which bones turn and move only: the lengths and angles of their axes are those of the first pose.
fn rigid_bones(skeletons: &[&Skeleton]) -> Vec<bool> {
    let gram = |skeleton: &Skeleton, bone: usize| {
        let linear = skeleton.bones[bone].matrix3;
        linear.transpose() * linear
    };
    let count = skeletons.first().map_or(0, |skeleton| skeleton.bones.len());
    let is_rigid = |bone: usize| {
        let first = gram(skeletons[0], bone);
        let scale = first.to_cols_array().iter().fold(0.0, |most: f64, value| most.max(value.abs()));
        skeletons.iter().all(|skeleton| gram(skeleton, bone).abs_diff_eq(first, RIGID * scale))
    };
    (0..count).map(is_rigid).collect()
}

/// Fails unless every triangle is in one cluster and no cluster has more than `most`, or none.
fn check_clusters(character: &Character, clusters: &[Vec<u32>], most: usize) -> Result<()> {
    let mut is_used = vec![false; character.triangles.len()];
    for (number, cluster) in clusters.iter().enumerate() {
        let place = |what: String| Err(Error::invalid(what).at(format!("cluster {number}")));
        if cluster.is_empty() || cluster.len() > most {
            return place(format!("it has {} triangles, not 1 to {most}", cluster.len()));
        }
        for triangle in cluster {
            match is_used.get_mut(*triangle as usize) {
                Some(is_used) if !*is_used => *is_used = true,
                _ => return place(format!("triangle {triangle} does not exist or is in two clusters")),
            }
        }
    }
    match is_used.iter().position(|is_used| !is_used) {
        Some(triangle) => Err(Error::invalid(format!("triangle {triangle} is in no cluster"))),
        None => Ok(()),
    }
}

/// Fails if what a build keeps for every vertex does not fit.
fn check_memory(context: &Context, character: &Character, poses: usize) -> Result<()> {
    let bones = (poses * (character.bones.len() + character.parents.len())) as u64;
    let weights = (4 * poses * character.morphs.count as usize) as u64;
    let bytes = 160 * (character.points.len() + 2 * character.triangles.len()) as u64 + 200 * bones + 2 * weights;
    if bytes > context.memory_limit() {
        return Err(Error::memory(format!("the hierarchy needs {bytes} bytes, more than the memory limit"))
            .advise("raise the memory limit, or split the model"));
    }
    Ok(())
}
