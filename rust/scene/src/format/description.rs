//! What a scene file says, as plain data with every name resolved to an index. Lengths are in scene units, angles in
//! radians, times in seconds.

use std::path::PathBuf;

use glam::DVec3;
use relievo_surface::{BoundaryRule, SurfaceOptions};
use relievo_tiles::DecayOptions;

use crate::format::diagnostic::Span;
pub use crate::format::placement::{Placement, Up};
use crate::format::reader::Name;
use crate::state::isosurface::FluidEntry;
use crate::state::shapes::Shape;

/// Where a mesh comes from.
#[derive(Clone, Debug, PartialEq)]
pub enum MeshSource {
    /// A file, and the animation of it to play.
    File {
        /// Path as written.
        path: Name,
        /// Name of the animation.
        animation: Option<Name>,
    },
    /// Numbered files.
    Sequence {
        /// Path as written, with a place for the number.
        pattern: Name,
        /// Number of the file of frame 0.
        first: u64,
        /// How many there are.
        count: u64,
        /// Path of the model of soft tissue whose frames they are.
        tissue: Option<Name>,
        /// Name of the surface that follows it; left out, the first.
        bound: Option<Name>,
    },
    /// A surface bound to soft tissue that the scene simulates.
    Tissue {
        /// The tissue.
        name: Name,
        /// Its index.
        tissue: usize,
        /// Name of the surface; left out, the first.
        bound: Option<Name>,
    },
    /// A generated shape.
    Shape(Shape),
}

/// `[meshes.NAME]`
#[derive(Clone, Debug, PartialEq)]
pub struct MeshEntry {
    /// Its name.
    pub name: Name,
    /// Where it comes from.
    pub source: MeshSource,
}

/// `[surfaces.NAME]`
#[derive(Clone, Debug, PartialEq)]
pub struct SurfaceEntry {
    /// Its name.
    pub name: Name,
    /// Index of its control cage.
    pub mesh: usize,
    /// Levels of isolation, if given.
    pub isolation: Option<u32>,
    /// Whether corners of an open cage are sharp.
    pub sharp_corners: bool,
    /// If the triangles of the mesh are the surface, how.
    pub triangles: Option<TrianglesEntry>,
}

impl SurfaceEntry {
    /// Returns how its cage becomes a surface.
    pub fn options(&self) -> SurfaceOptions {
        let mut options = SurfaceOptions::default();
        options.isolation = self.isolation.unwrap_or(options.isolation);
        if !self.sharp_corners {
            options.boundary = BoundaryRule::Edges;
        }
        options
    }
}

/// How a mesh becomes a surface of triangles.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TrianglesEntry {
    /// The length above which edges are split.
    pub longest_edge: Option<f64>,
}

/// How displacement and paint are stored.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct DetailEntry {
    /// Coefficients along a side of a tile.
    pub tile_size: u32,
    /// Texels of paint along a side of a tile.
    pub paint_size: u32,
    /// Whether paint is kept as half floats and not as bytes.
    pub halves: bool,
    /// Segments along an edge of a surface of triangles.
    pub segments: u32,
    /// Most bytes of tiles of displacement, and of paint.
    pub budget: u64,
    /// Whether tiles leave memory for a file beyond that.
    pub page: bool,
}

/// `[objects.NAME.traces]`: how pictures tint where colliders pushed.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TintEntry {
    /// Linear Rec.709.
    pub colour: [f32; 3],
    /// Object units at which the tint is full; 0, at once.
    pub depth: f32,
    /// Seconds after which the tint is gone; 0, never.
    pub fade: f32,
}

/// What an object shows.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Geometry {
    /// A surface, by index.
    Surface(usize),
    /// A mesh, by index.
    Mesh(usize),
}

/// `[objects.NAME]`
#[derive(Clone, Debug, PartialEq)]
pub struct ObjectEntry {
    /// Its name.
    pub name: Name,
    /// What it shows.
    pub geometry: Geometry,
    /// Where it is, unless a body moves it.
    pub placement: Placement,
    /// Linear Rec.709.
    pub colour: [f32; 3],
    /// Reflectance of the glossy part.
    pub specular: f32,
    /// Roughness of the glossy part.
    pub roughness: f32,
    /// Whether it takes imprints.
    pub deformable: bool,
    /// When edits of it fade; `None` if they stay.
    pub decay: Option<DecayOptions>,
    /// How its traces are tinted; `None` if imprints leave none.
    pub traces: Option<TintEntry>,
    /// How its points are a fluid; `None` if it shows its faces.
    pub fluid: Option<FluidEntry>,
    /// What is within it, if light goes through it.
    pub dielectric: Option<relievo_render::Dielectric>,
    /// Whether pictures show it.
    pub visible: bool,
    /// Layers beside those of its own, from the lowest.
    pub layers: Vec<LayerEntry>,
    /// How its displacement is stored.
    pub detail: DetailEntry,
    /// Path of the document it starts from, as written.
    pub document: Option<Name>,
}

/// `[[objects.NAME.layers]]`
#[derive(Clone, Debug, PartialEq)]
pub struct LayerEntry {
    /// Its name.
    pub name: Name,
    /// What is on it.
    pub kind: relievo_document::Kind,
    /// How it is seen.
    pub settings: relievo_document::Settings,
    /// Texels along an edge of every face.
    pub size: u32,
    /// When edits of it fade, if they do.
    pub decay: Option<DecayOptions>,
}

/// What physics sees of a body.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum StandIn {
    /// Nothing.
    None,
    /// The triangles of the control cage.
    TriMesh,
    /// The convex hull of the control cage.
    Convex,
    /// A height field made from the control cage, which must be a grid.
    HeightField,
    /// A ball.
    Ball,
    /// A cylinder along the thinnest side of the mesh.
    Cylinder,
    /// The bounding box.
    Box,
}

/// How a body moves.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Motion {
    /// By forces and contacts.
    Dynamic,
    /// Not at all.
    Fixed,
    /// As keyframes say.
    Keyframed,
}

/// Where a keyframed body is at a time.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Keyframe {
    /// When.
    pub time: f64,
    /// Where.
    pub placement: Placement,
}

/// A motor that turns a body about an axis of its own.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Motor {
    /// Unit axis in the body's coordinates.
    pub axis: DVec3,
    /// Radians per second it holds.
    pub speed: f64,
    /// Most torque.
    pub torque: f64,
}

/// Mass of a body.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Mass {
    /// Kilograms in all.
    Total(f64),
    /// Kilograms per cubic scene unit.
    Density(f64),
}

/// `[bodies.NAME]`
#[derive(Clone, Debug, PartialEq)]
pub struct BodyEntry {
    /// Its name.
    pub name: Name,
    /// Index of the object it moves.
    pub object: usize,
    /// How it moves.
    pub motion: Motion,
    /// What physics sees.
    pub stand_in: StandIn,
    /// How much smaller physics takes it.
    pub inset: f64,
    /// Radius of a ball or cylinder, if given.
    pub radius: Option<f64>,
    /// Mass or density.
    pub mass: Mass,
    /// Coulomb friction.
    pub friction: f64,
    /// Bounce.
    pub restitution: f64,
    /// At the start, units per second.
    pub velocity: DVec3,
    /// At the start, radians per second.
    pub angular_velocity: DVec3,
    /// Constant force.
    pub force: DVec3,
    /// Constant torque.
    pub torque: DVec3,
    /// Its motor.
    pub motor: Option<Motor>,
    /// Loss of velocity per second.
    pub damping: f64,
    /// Loss of angular velocity per second.
    pub angular_damping: f64,
    /// Locked translations and rotations: x, y, z, rx, ry, rz.
    pub locked: [bool; 6],
    /// Keyframes in order of time.
    pub keyframes: Vec<Keyframe>,
}

/// A force that presses a collider in.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ToolEntry {
    /// Newtons, not zero.
    pub force: DVec3,
    /// How the material resists.
    pub settings: relievo_detail::tool::ToolSettings,
}

/// `[colliders.NAME]`
#[derive(Clone, Debug, PartialEq)]
pub struct ColliderEntry {
    /// Its name.
    pub name: Name,
    /// Index of the object that presses.
    pub object: usize,
    /// Indices of the objects it presses into, in the order written.
    pub into: Vec<usize>,
    /// When it begins.
    pub from: f64,
    /// When it ends.
    pub until: f64,
    /// How it imprints.
    pub settings: relievo_detail::ImprintSettings,
    /// What presses it in, if a force does.
    pub tool: Option<ToolEntry>,
}

/// `[colliders.NAME]` with a crowd
#[derive(Clone, Debug, PartialEq)]
pub struct CrowdColliderEntry {
    /// Its name.
    pub name: Name,
    /// Index of the crowd whose agents press.
    pub crowd: usize,
    /// Most triangles of an agent that presses.
    pub triangles: u64,
    /// Indices of the objects they press into, in the order written.
    pub into: Vec<usize>,
    /// When it begins.
    pub from: f64,
    /// When it ends.
    pub until: f64,
    /// How they imprint.
    pub settings: relievo_detail::ImprintSettings,
}

/// `[[strokes]]`
#[derive(Clone, Debug, PartialEq)]
pub struct StrokeEntry {
    /// Indices of the objects it is on.
    pub objects: Vec<usize>,
    /// When it is made.
    pub time: f64,
    /// The stroke, still without its image.
    pub stroke: relievo_detail::Stroke,
    /// The layer it is made on, if not the lowest of its kind.
    pub layer: Option<Name>,
    /// Index of its image.
    pub stamp: Option<usize>,
}

/// `[[brushes]]`
#[derive(Clone, Debug, PartialEq)]
pub struct RiderEntry {
    /// Index of the object it rides on.
    pub by: usize,
    /// Indices of the objects it is made on.
    pub objects: Vec<usize>,
    /// Where it sits on it.
    pub place: DVec3,
    /// Where its right goes; zero for where it is going.
    pub along: DVec3,
    /// Whether one dab is made each time it touches.
    pub once: bool,
    /// From when to when, seconds.
    pub time: [f64; 2],
    /// The brush: a stroke without points, still without its image.
    pub brush: relievo_detail::Stroke,
    /// Index of its image.
    pub stamp: Option<usize>,
}

/// A pin of a decal.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct DecalPin {
    /// Pixels from the upper left corner of the image; none of strips.
    pub image: Option<[f64; 2]>,
    /// In the world.
    pub position: DVec3,
    /// Parts near pins of larger depths lie on top.
    pub depth: f64,
}

/// `[[decals]]`
#[derive(Clone, Debug, PartialEq)]
pub struct DecalEntry {
    /// Index of the object it lies on.
    pub object: usize,
    /// When it is laid.
    pub time: f64,
    /// Path of the image, as written.
    pub image: Name,
    /// Corners in pixels from the upper left corner of the image; empty for the whole image.
    pub outline: Vec<[f64; 2]>,
    /// Alpha of the contour that is the outline, and its tolerance in pixels.
    pub contour: Option<[f64; 2]>,
    /// Points of the image with their places.
    pub pins: Vec<DecalPin>,
    /// Whether the pins are a curve.
    pub strip: bool,
    /// With one pin, the width of the whole image.
    pub width: Option<f64>,
    /// With one pin, the direction in the world that is up in the image.
    pub up: DVec3,
    /// Whether it may lie on itself.
    pub overlap: bool,
    /// The layer it is written into, if not the lowest of its kind.
    pub layer: Option<Name>,
    /// How much of it is seen.
    pub opacity: f32,
    /// How much it raises the surface, if it does not paint.
    pub height: Option<f32>,
    /// Cells along an edge of a face.
    pub cells: u32,
}

/// `[[crowds]]`
#[derive(Clone, Debug, PartialEq)]
pub struct CrowdEntry {
    /// Its name, by which colliders call it.
    pub name: Option<Name>,
    /// Path of the character, or of its crowd model, as written.
    pub file: Name,
    /// Name of the only clip that is built; left out, all of the character.
    pub clip: Option<Name>,
    /// Path of the list of agents, as written.
    pub agents: Name,
    /// Error that may be seen, pixels.
    pub pixels: f32,
    /// Linear Rec.709.
    pub colour: [f32; 3],
}

/// `[[tissue]]`
#[derive(Clone, Debug, PartialEq)]
pub struct TissueEntry {
    /// Its name.
    pub name: Name,
    /// Path of its simulation, as written.
    pub simulation: Name,
    /// Indices of the objects that it meets.
    pub colliders: Vec<usize>,
    /// Coefficient of friction on them.
    pub friction: f32,
}

/// `[stamps.NAME]`
#[derive(Clone, Debug, PartialEq)]
pub struct StampEntry {
    /// Its name.
    pub name: Name,
    /// Where its pixels come from.
    pub source: StampSource,
    /// Which number of a pixel is the height.
    pub channel: relievo_detail::StampChannel,
    /// How it lies in the box.
    pub settings: relievo_detail::StampSettings,
}

/// Where the pixels of a stamp come from.
#[derive(Clone, Debug, PartialEq)]
pub enum StampSource {
    /// A file.
    File(Name),
    /// A pattern.
    Pattern(&'static str),
}

/// `[physics]`
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PhysicsEntry {
    /// Scene units per second squared.
    pub gravity: DVec3,
    /// Steps of a frame.
    pub sub_steps: u32,
}

/// The camera at a time.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct View {
    /// When.
    pub time: f64,
    /// Where it is, if given.
    pub position: Option<DVec3>,
    /// Where it looks, if given.
    pub target: Option<DVec3>,
    /// Vertical field of view, radians.
    pub fov: f64,
}

/// `[camera]`
#[derive(Clone, Debug, PartialEq)]
pub struct CameraEntry {
    /// Views in order of time, at least one.
    pub views: Vec<View>,
    /// Index of the object it travels with.
    pub follow: Option<usize>,
}

/// `[sun]`
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SunEntry {
    /// Unit vector towards the sun.
    pub direction: DVec3,
    /// Linear colour times brightness.
    pub radiance: [f32; 3],
    /// Diameter, radians.
    pub angle: f64,
}

/// `[sky]`
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SkyEntry {
    /// Overhead, linear, with brightness.
    pub zenith: [f32; 3],
    /// At the horizon.
    pub horizon: [f32; 3],
    /// From below.
    pub ground: [f32; 3],
}

/// Which frames something is written for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum When {
    /// None.
    Never,
    /// The last frame.
    Last,
    /// Every frame.
    Every,
}

impl When {
    /// Whether it is written for `frame` where `last` is the last one.
    pub fn includes(self, frame: u32, last: u32) -> bool {
        match self {
            When::Never => false,
            When::Last => frame == last,
            When::Every => true,
        }
    }
}

/// `[output]`
#[derive(Clone, Debug, PartialEq)]
pub struct OutputEntry {
    /// How many frames there are.
    pub frames: u32,
    /// Size and quality of pictures.
    pub settings: relievo_render::Settings,
    /// Formats: `png`, `exr`.
    pub images: Vec<&'static str>,
    /// Kinds: `beauty`, `wireframe`, `tiles`.
    pub pictures: Vec<&'static str>,
    /// Frames that get pictures.
    pub picture_frames: When,
    /// Frames whose meshes are written.
    pub mesh: When,
    /// Formats: `glb`, `obj`, `ply`, `usda`.
    pub mesh_formats: Vec<&'static str>,
    /// Quads along a side of an untouched tile.
    pub rate: u32,
    /// Most quads along a side of a tile in written meshes.
    pub mesh_rate: u32,
    /// Frames whose tiles are written.
    pub tiles: When,
    /// Frames whose documents are written.
    pub documents: When,
    /// Frames that are written as scenes for POV-Ray.
    pub povray: When,
    /// Frames that are written as scripts for Blender.
    pub blender: When,
    /// Stops.
    pub exposure: f64,
}

/// A scene.
#[derive(Clone, Debug, PartialEq)]
pub struct Scene {
    /// The file, as the user gave it.
    pub path: PathBuf,
    /// The text of the file.
    pub text: std::sync::Arc<str>,
    /// Frames per second.
    pub fps: f64,
    /// Metres in a scene unit.
    pub metres: f64,
    /// The axis that points up.
    pub up: Up,
    /// Seed of everything random.
    pub seed: u32,
    /// Meshes.
    pub meshes: Vec<MeshEntry>,
    /// Surfaces.
    pub surfaces: Vec<SurfaceEntry>,
    /// Objects.
    pub objects: Vec<ObjectEntry>,
    /// Bodies.
    pub bodies: Vec<BodyEntry>,
    /// Colliders that are objects.
    pub colliders: Vec<ColliderEntry>,
    /// Colliders that are crowds, which press after objects.
    pub crowd_colliders: Vec<CrowdColliderEntry>,
    /// Strokes, in the order they are made.
    pub strokes: Vec<StrokeEntry>,
    /// Brushes that ride on objects, in the order they are made.
    pub riders: Vec<RiderEntry>,
    /// Images of brushes.
    pub stamps: Vec<StampEntry>,
    /// Stickers, in the order they are laid.
    pub decals: Vec<DecalEntry>,
    /// Crowds.
    pub crowds: Vec<CrowdEntry>,
    /// Soft tissue.
    pub tissue: Vec<TissueEntry>,
    /// Physics.
    pub physics: PhysicsEntry,
    /// The camera.
    pub camera: CameraEntry,
    /// The sun.
    pub sun: SunEntry,
    /// The sky.
    pub sky: SkyEntry,
    /// What is written.
    pub output: OutputEntry,
}

impl Scene {
    /// When `frame` is, seconds.
    pub fn time(&self, frame: u32) -> f64 {
        f64::from(frame) / self.fps
    }

    /// The mesh that an object shows or whose limit surface it shows.
    pub fn cage_of(&self, object: &ObjectEntry) -> usize {
        match object.geometry {
            Geometry::Mesh(mesh) => mesh,
            Geometry::Surface(surface) => self.surfaces[surface].mesh,
        }
    }

    /// Whether any stroke or decal paints the object.
    pub fn is_painted(&self, object: usize) -> bool {
        let paints = |stroke: &relievo_detail::Stroke| matches!(stroke.action, relievo_detail::Action::Paint { .. });
        let strokes = self.strokes.iter().map(|entry| (&entry.objects, &entry.stroke));
        let mut brushes = strokes.chain(self.riders.iter().map(|entry| (&entry.objects, &entry.brush)));
        brushes.any(|(objects, stroke)| objects.contains(&object) && paints(stroke))
            || self.decals.iter().any(|decal| decal.object == object && decal.height.is_none())
            || self.objects.get(object).is_some_and(|object| object.layers.iter().any(|layer| layer.kind.is_color()))
    }

    /// Whether any stroke changes vector displacement of the object.
    pub fn is_bent(&self, object: usize) -> bool {
        let bends = |stroke: &relievo_detail::Stroke| matches!(stroke.action, relievo_detail::Action::Sculpt { mode, .. } if mode.needs_vectors());
        let strokes = self.strokes.iter().map(|entry| (&entry.objects, &entry.stroke));
        let mut brushes = strokes.chain(self.riders.iter().map(|entry| (&entry.objects, &entry.brush)));
        brushes.any(|(objects, stroke)| objects.contains(&object) && bends(stroke))
    }

    /// Where in the file a mesh's source is written.
    pub fn source_span(&self, mesh: usize) -> Span {
        match &self.meshes[mesh].source {
            MeshSource::File { path, .. } => path.span.clone(),
            MeshSource::Sequence { pattern, .. } => pattern.span.clone(),
            MeshSource::Tissue { name, .. } => name.span.clone(),
            MeshSource::Shape(_) => self.meshes[mesh].name.span.clone(),
        }
    }
}
