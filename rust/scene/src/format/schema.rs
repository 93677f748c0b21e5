//! The format of scene files as tables: every key with its type, unit, default, range and help. The reader, the
//! `relievo scene schema` command and the documentation all come from here.

use relievo_core::Parameter;

/// The type of a key's value.
#[derive(Clone, Copy, Debug)]
pub enum Kind {
    /// A string.
    Text,
    /// A path of a file to read, relative to the scene file.
    Path,
    /// The name of an entry of the given section.
    Name(&'static str),
    /// One name or a list of names of the given section.
    Names(&'static str),
    /// `true` or `false`.
    Flag,
    /// A whole number in a range.
    Whole(u64, u64),
    /// A power of two in a range.
    Power(u64, u64),
    /// A number in a range.
    Number(f64, f64),
    /// A list of so many numbers.
    Numbers(usize),
    /// A list of pairs of numbers.
    Pairs,
    /// A number, or a list of three for x, y and z.
    Scale,
    /// Three linear Rec.709 components, or the sRGB string `"#rrggbb"`.
    Colour,
    /// One of these words.
    Choice(&'static [&'static str]),
    /// A list of any of these words.
    Choices(&'static [&'static str]),
    /// A table.
    Table(&'static Section),
    /// A list of tables.
    List(&'static Section),
    /// A table of named tables.
    Named(&'static Section),
}

/// One key of a section.
#[derive(Clone, Copy, Debug)]
pub struct Key {
    /// The key.
    pub name: &'static str,
    /// Type of its value.
    pub kind: Kind,
    /// The default as written in TOML, empty if leaving the key out means something of its own (said in `help`).
    pub default: &'static str,
    /// Unit, empty for pure numbers and everything that is not a number.
    pub unit: &'static str,
    /// What it does.
    pub help: &'static str,
}

/// A table of the scene file.
#[derive(Debug)]
pub struct Section {
    /// Its name as shown in messages and in the printed schema.
    pub name: &'static str,
    /// What it is for.
    pub help: &'static str,
    /// Its keys.
    pub keys: &'static [Key],
    /// Further keys that are numbers of a parameter struct.
    pub parameters: &'static [Parameter],
}

const fn key(name: &'static str, kind: Kind, default: &'static str, unit: &'static str, help: &'static str) -> Key {
    Key { name, kind, default, unit, help }
}

const UNITS: &str = "scene units";
const DEGREES: &str = "degrees";
const ANY: Kind = Kind::Number(-1e9, 1e9);
const POSITIVE: Kind = Kind::Number(1e-9, 1e9);
const NOT_NEGATIVE: Kind = Kind::Number(0.0, 1e12);

/// Words for the axis that points up.
pub const AXES: &[&str] = &["x", "y", "z"];
/// Shapes a mesh can be generated as.
pub const SHAPES: &[&str] = &["plane", "terrain", "box", "sphere", "cylinder", "wheel", "spiked_ball"];
/// Physical stand-ins of a body.
pub const STAND_INS: &[&str] = &["none", "trimesh", "convex", "heightfield", "ball", "cylinder", "box"];
/// What can be locked of a body's motion.
pub const LOCKS: &[&str] = &["x", "y", "z", "rx", "ry", "rz"];
/// How a stroke paints.
pub const PAINT_MODES: [&str; 6] = ["mix", "add", "multiply", "erase", "blur", "smear"];
/// How a stroke sculpts.
pub const SCULPT_MODES: [&str; 10] =
    ["draw", "smooth", "flatten", "erase", "clay", "scrape", "layer", "inflate", "pinch", "vector"];
/// Functions of a brush.
pub const FALLOFFS: [&str; 5] = ["constant", "linear", "smooth", "sphere", "gaussian"];
/// Images of stamps that need no file.
pub const PATTERNS: [&str; 7] = ["checker", "stripes", "rings", "star", "sole", "mushroom", "horn"];
/// Which number of a pixel is a height.
pub const CHANNELS: [&str; 4] = ["red", "green", "blue", "alpha"];
/// What a layer holds.
pub const LAYER_KINDS: &[&str] = &["displacement", "colour"];
/// How a layer is put on what is below it.
pub const BLENDS: [&str; 8] = ["normal", "add", "subtract", "multiply", "screen", "overlay", "max", "min"];
/// When meshes, tiles and documents are written.
pub const WHEN: &[&str] = &["none", "last", "every"];

/// `[meshes.NAME]`
pub static MESH: Section = Section {
    name: "meshes.NAME",
    help: "A mesh: read from a file, from numbered files, or generated",
    keys: &[
        key("file", Kind::Path, "", "", "OBJ, PLY, OFF, STL, glTF, GLB or USD file to read"),
        key(
            "sequence",
            Kind::Path,
            "",
            "",
            "Numbered files with the same topology, one per frame; `####`, `%04d` or `%d` stands for the number",
        ),
        key("first", Kind::Whole(0, 1_000_000_000), "0", "", "Number of the sequence's file that belongs to frame 0"),
        key(
            "count",
            Kind::Whole(1, 1_000_000),
            "1",
            "",
            "How many files the sequence has; the last one stays afterwards",
        ),
        key(
            "tissue",
            Kind::Path,
            "",
            "",
            "Model of soft tissue (`.rtissue`) that the sequence has frames of (`.rtstate`, by `relievo tissue sim`)",
        ),
        key("bound", Kind::Text, "", "", "Surface that follows the tissue; left out, the first of the model"),
        key("simulated", Kind::Text, "", "", "Name of the `[[tissue]]` of which it is a bound surface"),
        key(
            "animation",
            Kind::Text,
            "",
            "",
            "Animation of a glTF file to play, or `stage` for that of USD; left out, the mesh keeps its rest pose",
        ),
        key("shape", Kind::Choice(SHAPES), "", "", "Shape to generate instead of reading a file"),
        key(
            "size",
            Kind::Numbers(3),
            "[1, 1, 1]",
            UNITS,
            "Size of a plane, terrain or box; the third number of a terrain is the height of its hills",
        ),
        key("faces", Kind::Whole(1, 1024), "8", "", "Faces along a side of a plane, terrain, box or sphere"),
        key(
            "radius",
            POSITIVE,
            "0.5",
            UNITS,
            "Radius of a sphere, cylinder, wheel (to its tread) or spiked ball (without spikes)",
        ),
        key("width", POSITIVE, "0.4", UNITS, "Width of a wheel or length of a cylinder, along its axle"),
        key("lugs", Kind::Whole(3, 256), "24", "", "Lugs around a wheel"),
        key("lug_height", POSITIVE, "0.05", UNITS, "Height of a wheel's lugs"),
        key("spikes", Kind::Whole(4, 2048), "60", "", "Spikes on a ball"),
        key("spike_length", POSITIVE, "0.15", UNITS, "Length of a ball's spikes"),
        key("spike_radius", POSITIVE, "0.05", UNITS, "Radius of a spike at its foot"),
        key("segments", Kind::Whole(3, 1024), "48", "", "Segments around a cylinder"),
        key("seed", Kind::Whole(0, 4_294_967_295), "1", "", "Seed of a terrain's hills"),
    ],
    parameters: &[],
};

/// `[surfaces.NAME]`
pub static SURFACE: Section = Section {
    name: "surfaces.NAME",
    help: "A surface over a mesh: the Catmull-Clark surface with the mesh as control cage, or the triangles of the mesh",
    keys: &[
        key("mesh", Kind::Name("meshes"), "", "", "The control cage, or the mesh"),
        key(
            "kind",
            Kind::Choice(&["catmull_clark", "triangles"]),
            "\"catmull_clark\"",
            "",
            "What is painted and sculpted; for triangles polygons are cut up",
        ),
        key(
            "longest_edge",
            POSITIVE,
            "",
            UNITS,
            "Triangles with longer edges are split, so that `segments` of `details` lie denser; left out, none",
        ),
        key(
            "isolation",
            Kind::Whole(1, 10),
            "",
            "",
            "Levels of feature-adaptive isolation; left out, as the library chooses",
        ),
        key(
            "boundary",
            Kind::Choice(&["edge_and_corner", "edge_only"]),
            "\"edge_and_corner\"",
            "",
            "Whether corners of an open cage are sharp",
        ),
    ],
    parameters: &[],
};

/// `[details]` and `detail` of an object.
pub static DETAIL: Section = Section {
    name: "details",
    help: "How displacement and paint are stored; `detail` of an object overrides single keys",
    keys: &[
        key("tile_size", Kind::Power(8, 256), "128", "", "Coefficients along a side of a tile"),
        key("paint_size", Kind::Power(8, 256), "128", "", "Texels of paint along a side of a tile"),
        key(
            "paint_format",
            Kind::Choice(&["rgba8", "rgba16f"]),
            "\"rgba8\"",
            "",
            "Whether paint is kept as bytes, 0 to 1, or as half floats, which may be brighter",
        ),
        key("segments", Kind::Power(8, 64), "16", "", "Segments along an edge of a surface of triangles"),
        key(
            "budget",
            Kind::Whole(1 << 16, 1 << 40),
            "268435456",
            "bytes",
            "Most memory the displacement of an object may occupy, and as much again its paint and its vectors",
        ),
        key(
            "page",
            Kind::Flag,
            "false",
            "",
            "Whether tiles edited longest ago leave memory for a file when it is full",
        ),
    ],
    parameters: &[],
};

/// `[objects.NAME]`
pub static OBJECT: Section = Section {
    name: "objects.NAME",
    help: "Something in the scene: a surface or a mesh, placed",
    keys: &[
        key("surface", Kind::Name("surfaces"), "", "", "The surface it shows"),
        key("mesh", Kind::Name("meshes"), "", "", "The mesh it shows, as it is"),
        key("translation", Kind::Numbers(3), "[0, 0, 0]", UNITS, "Where its origin is"),
        key("rotation", Kind::Numbers(3), "[0, 0, 0]", DEGREES, "Turn about x, then y, then z"),
        key("scale", Kind::Scale, "1", "", "Size, for all axes or for x, y and z"),
        key(
            "shear",
            Kind::Numbers(3),
            "[0, 0, 0]",
            "",
            "How far x goes along with y, x with z, and y with z, after scaling",
        ),
        key("colour", Kind::Colour, "[0.6, 0.6, 0.6]", "", "Colour, linear Rec.709 or \"#rrggbb\" in sRGB"),
        key("specular", Kind::Number(0.0, 1.0), "0.02", "", "Reflectance of the glossy part seen straight on"),
        key("roughness", Kind::Number(0.0, 1.0), "0.5", "", "Roughness of the glossy part"),
        key(
            "role",
            Kind::Choice(&["deformable", "rigid"]),
            "",
            "",
            "Whether it takes imprints; left out, surfaces do and meshes do not",
        ),
        key("visible", Kind::Flag, "true", "", "Whether pictures show it"),
        key("detail", Kind::Table(&DETAIL), "", "", "Detail settings that differ from [details]"),
        key("layers", Kind::List(&LAYER), "[]", "", "Layers above its own displacement and colours"),
        key("decay", Kind::Table(&DECAY), "", "", "Makes imprints and strokes fade"),
        key(
            "traces",
            Kind::Table(&TRACES),
            "",
            "",
            "Makes imprints leave traces of contact, and how pictures tint them",
        ),
        key("fluid", Kind::Table(&FLUID), "", "", "Shows the surface of a fluid whose particles are the mesh's points"),
        key("dielectric", Kind::Table(&DIELECTRIC), "", "", "Lets light through, as water and glass do"),
        key(
            "document",
            Kind::Path,
            "",
            "",
            "Document (.relievo) to start from: displacement and colours with the sizes of their tiles",
        ),
    ],
    parameters: &[],
};

/// `[[objects.NAME.layers]]`
pub static LAYER: Section = Section {
    name: "objects.NAME.layers",
    help: "Layers of displacement or colour, `[[objects.NAME.layers]]` each, from the lowest; strokes name theirs",
    keys: &[
        key("name", Kind::Text, "", "", "Its name; `displacement` and `colour` are those the object has anyway"),
        key("kind", Kind::Choice(LAYER_KINDS), "\"displacement\"", "", "What is on it"),
        key("opacity", Kind::Number(0.0, 1.0), "1", "", "How much of it is seen"),
        key(
            "blend",
            Kind::Choice(&BLENDS),
            "",
            "",
            "How it is put on what is below; left out, displacement adds up and colour covers. Displacement can `add`, \
             `subtract` or be the `max` or `min`; colours all but `subtract`, in linear light",
        ),
        key("visible", Kind::Flag, "true", "", "Whether it is seen at all"),
        key(
            "tile_size",
            Kind::Power(8, 256),
            "128",
            "",
            "Texels along the edge of a face; surfaces of triangles have `segments` of `details`",
        ),
        key("decay", Kind::Table(&LAYER_DECAY), "", "", "Makes edits of the layer fade"),
    ],
    parameters: &[],
};

/// When edits fade.
const FADING: &[Key] = &[
    key("delay", Kind::Number(0.0, 1e6), "0", "seconds", "How long an edit stays as it is"),
    key("duration", Kind::Number(1e-3, 1e6), "10", "seconds", "How long it then takes to fade"),
];

/// `[objects.NAME.layers.decay]`
pub static LAYER_DECAY: Section = Section {
    name: "objects.NAME.layers.decay",
    help: "When edits of the layer fade; each place counts from its last edit. Where the budget is full, tiles of the layer \
           are lost to newer ones, the oldest first",
    keys: FADING,
    parameters: &[],
};

/// `[objects.NAME.decay]`
pub static DECAY: Section = Section {
    name: "objects.NAME.decay",
    help: "When what was imprinted, painted and sculpted on the object's own displacement and colours goes back to what it \
           was; each place counts from its last edit. Where the budget is full, tiles are lost to newer ones, the oldest first",
    keys: FADING,
    parameters: &[],
};

/// `[objects.NAME.traces]`
pub static TRACES: Section = Section {
    name: "objects.NAME.traces",
    help: "Where colliders pushed, how far in all and when last; meshes get the point attributes contact, depth and age",
    keys: &[
        key(
            "colour",
            Kind::Colour,
            "[0.05, 0.04, 0.03]",
            "",
            "Tint in pictures, linear Rec.709 or \"#rrggbb\" in sRGB",
        ),
        key("depth", Kind::Number(0.0, 60000.0), "0", "object units", "Depth at which the tint is full; 0, at once"),
        key("fade", Kind::Number(0.0, 1e6), "0", "seconds", "Age at which the tint is gone; 0, never"),
    ],
    parameters: &[],
};

/// `[objects.NAME.fluid]`
pub static FLUID: Section = Section {
    name: "objects.NAME.fluid",
    help: "The surface of a fluid whose particles are the points of the object's mesh",
    keys: &[
        key("spacing", POSITIVE, "", "object units", "Distance between particles at rest"),
        key(
            "function",
            Kind::Choice(&["blobs", "zhu_bridson", "density", "anisotropic"]),
            "\"zhu_bridson\"",
            "",
            "What the surface is of",
        ),
        key(
            "cell",
            Kind::Number(0.02, 2.0),
            "",
            "spacings",
            "Size of the cells of a mesh; left out, pictures trace rays against the surface itself",
        ),
        key(
            "povray",
            Kind::Choice(&["mesh", "blobs", "df3"]),
            "\"mesh\"",
            "",
            "What scenes for POV-Ray have: a mesh, a blob for each particle, or a grid of values and its isosurface",
        ),
        key("foam", Kind::Table(&FOAM), "", "", "Spray, foam and bubbles over pictures, made from the mesh's sequence"),
    ],
    parameters: &[],
};

/// `[objects.NAME.fluid.foam]`
pub static FOAM: Section = Section {
    name: "objects.NAME.fluid.foam",
    help: "Spray, foam and bubbles of a fluid: generated from the files of the mesh's sequence, which have velocities or \
           numbers of their particles, and laid over pictures of kind `beauty`",
    keys: &[key("look", Kind::Table(&FOAM_LOOK), "", "", "How particles are drawn")],
    parameters: crate::run::foam::PARAMETERS,
};

/// `[objects.NAME.fluid.foam.look]`
pub static FOAM_LOOK: Section = Section {
    name: "objects.NAME.fluid.foam.look",
    help: "How foam is drawn in screen space; lengths are in scene units. Without `radius`, particles have half of the \
           fluid's spacing",
    keys: &[],
    parameters: relievo_render::foam::FoamSettings::PARAMETERS,
};

/// `[objects.NAME.dielectric]`
pub static DIELECTRIC: Section = Section {
    name: "objects.NAME.dielectric",
    help: "What is within a closed object that light goes through; the colour of the object then does not count",
    keys: &[
        key("index", Kind::Number(1.0, 4.0), "1.333", "", "Index of refraction by that of what is around it"),
        key(
            "absorption",
            Kind::Numbers(3),
            "[0.45, 0.09, 0.06]",
            "per scene unit",
            "Absorbed red, green and blue light: exp(-absorption) of it is left after a unit",
        ),
    ],
    parameters: &[],
};

/// An item of a body's `keyframes`.
pub static KEYFRAME: Section = Section {
    name: "keyframes",
    help: "Where a body is at a time; between keyframes it moves evenly",
    keys: &[
        key("time", Kind::Number(0.0, 1e6), "", "seconds", "When; later than the keyframe before"),
        key("translation", Kind::Numbers(3), "", UNITS, "Where; left out, as before"),
        key(
            "rotation",
            Kind::Numbers(3),
            "",
            DEGREES,
            "Turn about x, then y, then z, which may exceed a full turn; left out, as before",
        ),
        key("scale", Kind::Scale, "", "", "Size; left out, as before"),
        key("shear", Kind::Numbers(3), "", "", "Shear; left out, as before"),
    ],
    parameters: &[],
};

/// `[bodies.NAME]`
pub static BODY: Section = Section {
    name: "bodies.NAME",
    help: "How an object moves: a rigid body, or keyframes. Starts where the object is placed",
    keys: &[
        key("object", Kind::Name("objects"), "", "", "The object it moves; left out, the object of the body's name"),
        key(
            "motion",
            Kind::Choice(&["dynamic", "fixed", "keyframed"]),
            "",
            "",
            "Left out, `keyframed` with keyframes and else `dynamic`",
        ),
        key(
            "shape",
            Kind::Choice(STAND_INS),
            "\"convex\"",
            "",
            "What physics sees of it; `trimesh` is the control cage itself, `none` passes through everything",
        ),
        key(
            "inset",
            NOT_NEGATIVE,
            "0",
            UNITS,
            "How much smaller than the object physics takes it, which is how deep it sinks in where it rests",
        ),
        key("radius", POSITIVE, "", UNITS, "Radius of a ball or cylinder; left out, from the mesh"),
        key("mass", POSITIVE, "", "kg", "Mass; left out, from the density"),
        key(
            "density",
            POSITIVE,
            "",
            "kg per cubic unit",
            "Density; 1000 kg per cubic metre if there is no mass either",
        ),
        key("friction", Kind::Number(0.0, 100.0), "0.7", "", "Coulomb friction"),
        key("restitution", Kind::Number(0.0, 1.0), "0", "", "Bounce"),
        key("velocity", Kind::Numbers(3), "[0, 0, 0]", "scene units per second", "Velocity at the start"),
        key(
            "angular_velocity",
            Kind::Numbers(3),
            "[0, 0, 0]",
            "degrees per second",
            "Angular velocity about x, y and z at the start",
        ),
        key("force", Kind::Numbers(3), "[0, 0, 0]", "newtons", "Constant force at the centre of mass"),
        key("torque", Kind::Numbers(3), "[0, 0, 0]", "newton units", "Constant torque"),
        key("motor_axis", Kind::Numbers(3), "", "", "Axis of the body that a motor turns, in its own coordinates"),
        key("motor_speed", ANY, "0", "degrees per second", "Speed the motor holds about its axis"),
        key("motor_torque", NOT_NEGATIVE, "0", "newton units", "Most the motor can do"),
        key("damping", NOT_NEGATIVE, "0", "per second", "Loss of velocity"),
        key("angular_damping", NOT_NEGATIVE, "0", "per second", "Loss of angular velocity"),
        key(
            "locked",
            Kind::Choices(LOCKS),
            "[]",
            "",
            "Translations (x, y, z) and rotations (rx, ry, rz) in world axes that do not happen",
        ),
        key("keyframes", Kind::List(&KEYFRAME), "[]", "", "Where it is when"),
    ],
    parameters: &[],
};

/// An item of a stroke's `points`.
pub static STROKE_POINT: Section = Section {
    name: "strokes.points",
    help: "A point of a stroke; the stroke goes straight from point to point, a dab at every step",
    keys: &[
        key("position", Kind::Numbers(3), "", UNITS, "Where, in the world; the nearest place of the surface is meant"),
        key("pressure", Kind::Number(0.0, 1.0), "1", "", "How hard"),
        key("time", Kind::Number(0.0, 1e9), "", "seconds", "When; a brush with a `rate` needs it of every point"),
    ],
    parameters: &[],
};

// The keys of a brush, of strokes and of brushes that ride alike.
const BRUSH_PAINT: Key = key(
    "paint",
    Kind::Choice(&PAINT_MODES),
    "",
    "",
    "Changes colours: toward `colour`, by adding it, by multiplying with it, back to the object's own, blurred, or \
     smeared",
);
const BRUSH_SCULPT: Key = key(
    "sculpt",
    Kind::Choice(&SCULPT_MODES),
    "",
    "",
    "Changes displacement: raised by `height`, smoothed, flattened to the tangent plane, back to none, built up to a \
             plane `height` over it, scraped down to it, a layer of `height` over what was, inflated, pinched toward the \
             middle (away from it with a negative `height`), or moved by the vectors of `stamp` times `height`",
);
const BRUSH_COLOUR: Key =
    key("colour", Kind::Colour, "[0.6, 0.03, 0.02]", "", "Colour to paint with, linear Rec.709 or \"#rrggbb\"");
const BRUSH_HEIGHT: Key = key(
    "height",
    Kind::Number(-60000.0, 60000.0),
    "0.1",
    "object units",
    "What one dab of `draw` raises the surface by; negative digs. Dabs that overlap add up. The unit of `vector`",
);
const BRUSH_FALLOFF: Key =
    key("falloff", Kind::Choice(&FALLOFFS), "\"smooth\"", "", "How the edit fades from the middle to the rim");
const BRUSH_STAMP: Key = key(
    "stamp",
    Kind::Name("stamps"),
    "",
    "",
    "Image of the brush, which the colour or the height is multiplied by; for `vector` red is along the brush's \
             right, green along its top, blue out of the surface",
);
const BRUSH_SIZE_CURVE: Key =
    key("size_curve", Kind::Pairs, "[]", "", "Points [pressure, size] of what `size_pressure` takes pressure as");
const BRUSH_STRENGTH_CURVE: Key =
    key("strength_curve", Kind::Pairs, "[]", "", "Points [pressure, strength], for `strength_pressure`");
const BRUSH_ANGLE_CURVE: Key =
    key("angle_curve", Kind::Pairs, "[]", "", "Points [pressure, angle], for `angle_pressure`, 1 being all of it");

/// `[[strokes]]`
pub static STROKE: Section = Section {
    name: "strokes",
    help: "Strokes of a brush, `[[strokes]]` each, in the order they are made, which paint or sculpt a surface",
    keys: &[
        key(
            "object",
            Kind::Names("objects"),
            "",
            "",
            "The objects it is on, each of which shows a surface; left out, all that do. A dab is put on the nearest and \
             made on all in its box",
        ),
        key("layer", Kind::Text, "", "", "The layer of the objects it is made on; left out, the lowest of its kind"),
        key("time", Kind::Number(0.0, 1e6), "0", "seconds", "When: at the first frame that is not before it"),
        BRUSH_PAINT,
        BRUSH_SCULPT,
        BRUSH_COLOUR,
        BRUSH_HEIGHT,
        BRUSH_FALLOFF,
        BRUSH_STAMP,
        BRUSH_SIZE_CURVE,
        BRUSH_STRENGTH_CURVE,
        BRUSH_ANGLE_CURVE,
        key("points", Kind::List(&STROKE_POINT), "[]", "", "The points, at least one"),
    ],
    parameters: relievo_detail::StrokeSettings::PARAMETERS,
};

/// `[[brushes]]`
pub static RIDER: Section = Section {
    name: "brushes",
    help: "Brushes that ride on objects, `[[brushes]]` each: where their place touches a surface a dab is made, such as a \
           footprint. `reach` says from how far that counts as touching",
    keys: &[
        key("by", Kind::Name("objects"), "", "", "The object it rides on"),
        key(
            "object",
            Kind::Names("objects"),
            "",
            "",
            "The objects it is made on, each of which shows a surface; left out, all that do but `by`. A dab is put on the \
             nearest and made on all in its box",
        ),
        key(
            "place",
            Kind::Numbers(3),
            "[0, 0, 0]",
            UNITS,
            "Where it sits, in the coordinates of the object it rides on",
        ),
        key(
            "along",
            Kind::Numbers(3),
            "",
            "",
            "Where its right goes, in those coordinates; left out, where it is going",
        ),
        key("once", Kind::Flag, "false", "", "Whether one dab is made each time it touches, and none on its way"),
        key("from", Kind::Number(0.0, 1e6), "0", "seconds", "When it begins"),
        key("until", Kind::Number(0.0, 1e6), "1e6", "seconds", "When it ends"),
        BRUSH_PAINT,
        BRUSH_SCULPT,
        BRUSH_COLOUR,
        BRUSH_HEIGHT,
        BRUSH_FALLOFF,
        BRUSH_STAMP,
        BRUSH_SIZE_CURVE,
        BRUSH_STRENGTH_CURVE,
        BRUSH_ANGLE_CURVE,
    ],
    parameters: relievo_detail::StrokeSettings::PARAMETERS,
};

/// `[stamps.NAME]`
pub static STAMP: Section = Section {
    name: "stamps.NAME",
    help: "An image of brushes: a PNG or EXR file, or a pattern. Its colours multiply the brush's; alpha is its share",
    keys: &[
        key("image", Kind::Path, "", "", "PNG or EXR file; heights are its numbers as they are, colours are linear"),
        key(
            "pattern",
            Kind::Choice(&PATTERNS),
            "",
            "",
            "Pattern instead of a file, white where its alpha is 1; `mushroom` and `horn` are vectors, in their true shape where `height` is the radius",
        ),
        key("channel", Kind::Choice(&CHANNELS), "\"red\"", "", "Which number of a pixel is the height"),
    ],
    parameters: relievo_detail::StampSettings::PARAMETERS,
};

/// An item of a decal's `pins`.
pub static DECAL_PIN: Section = Section {
    name: "decals.pins",
    help: "A point of the image and the place of the surface that it lies on",
    keys: &[
        key(
            "image",
            Kind::Numbers(2),
            "",
            "pixels",
            "The point, from the upper left corner of the image; not of strips",
        ),
        key("position", Kind::Numbers(3), "", UNITS, "Where, in the world; the nearest place of the surface is meant"),
        key(
            "depth",
            ANY,
            "0",
            "",
            "Where the sticker overlaps itself, the part near pins of larger depths lies on top",
        ),
    ],
    parameters: &[],
};

/// `[[crowds]]`
pub static CROWD: Section = Section {
    name: "crowds",
    help: "Agents of an articulated or static model, `[[crowds]]` each, in pictures by the ray caster. Each is drawn with \
           as few triangles as its pixels need in its pose. Agents press into surfaces if a collider names the crowd",
    keys: &[
        key("name", Kind::Text, "", "", "Its name, by which `crowd` of a collider calls it"),
        key(
            "file",
            Kind::Path,
            "",
            "",
            "The character (glTF, USD, OBJ, PLY, STL or OFF) in metres with y up, or its crowd model (`.rcrowd`, by \
             `relievo crowd build`), which loads at once",
        ),
        key("clip", Kind::Text, "", "", "The only clip of the character that is built; left out, all of them"),
        key(
            "agents",
            Kind::Path,
            "",
            "",
            "List of agents, one a line: x y z, heading in degrees about y, scale, clip, phase in seconds, and after a \
             0 the speed along the heading; lengths in metres with y up",
        ),
        key("pixels", Kind::Number(1e-3, 1000.0), "0.5", "pixels", "Error that may be seen"),
        key("colour", Kind::Colour, "\"#c9c2b2\"", "", "Colour, linear Rec.709 or \"#rrggbb\" in sRGB"),
    ],
    parameters: &[],
};

/// `[[tissue]]`
pub static TISSUE: Section = Section {
    name: "tissue",
    help: "Soft tissue, `[[tissue]]` each, that is simulated frame by frame and meets objects of the scene. A mesh shows it by \
           `simulated`, where the object is that shows the mesh first",
    keys: &[
        key("name", Kind::Text, "", "", "Its name, by which meshes and its frames in the cache are called"),
        key(
            "simulation",
            Kind::Path,
            "",
            "",
            "What moves it, in TOML, as `relievo tissue sim` takes it; `frames` and `fps` are those of the scene",
        ),
        key(
            "colliders",
            Kind::Names("objects"),
            "",
            "",
            "Objects that it does not enter, by closed meshes that do not change but may move as bodies do",
        ),
        key("friction", Kind::Number(0.0, 100.0), "0.3", "", "Coefficient of friction on these objects"),
    ],
    parameters: &[],
};

/// `[[decals]]`
pub static DECAL: Section = Section {
    name: "decals",
    help: "Stickers on surfaces, `[[decals]]` each, in the order they are laid, before the strokes of their \
           frame. Points of the image lie exactly on their pins",
    keys: &[
        key("object", Kind::Name("objects"), "", "", "The object it lies on; left out, the only one with a surface"),
        key("image", Kind::Path, "", "", "PNG or EXR file"),
        key(
            "outline",
            Kind::Pairs,
            "[]",
            "pixels",
            "Corners of the part of the image that is the sticker, from the upper left; left out, the whole image",
        ),
        key("contour", Kind::Number(1e-3, 0.999), "", "", "Cuts the sticker out where the image has this alpha"),
        key(
            "tolerance",
            Kind::Number(0.0, 1000.0),
            "0.5",
            "pixels",
            "How far the outline may be from the contour of the alpha",
        ),
        key("pins", Kind::List(&DECAL_PIN), "[]", "", "The pins, at least one"),
        key(
            "strip",
            Kind::Flag,
            "false",
            "",
            "Lays the middle line of the image along a curve through the pins, from its left end to its right one",
        ),
        key("width", POSITIVE, "", UNITS, "With one pin: the width of the whole image on the surface"),
        key(
            "up",
            Kind::Numbers(3),
            "",
            "",
            "With one pin: the direction in the world that is up in the image; left out, that of the scene",
        ),
        key("overlap", Kind::Flag, "false", "", "Whether the sticker may lie on itself, as around a finger"),
        key(
            "layer",
            Kind::Text,
            "",
            "",
            "The layer of the object it is written into; left out, the lowest of its kind",
        ),
        key("opacity", Kind::Number(0.0, 1.0), "1", "", "How much of it is seen"),
        key(
            "height",
            Kind::Number(-60000.0, 60000.0),
            "",
            "object units",
            "Raises the surface by this much where the image is white, instead of painting it",
        ),
        key(
            "cells",
            Kind::Power(1, 64),
            "8",
            "",
            "On a Catmull-Clark surface: cells along an edge of a face of the triangles it is laid on",
        ),
        key("time", Kind::Number(0.0, 1e6), "0", "seconds", "When: at the first frame that is not before it"),
    ],
    parameters: &[],
};

/// `[physics]`
pub static PHYSICS: Section = Section {
    name: "physics",
    help: "Rigid-body physics on control cages or simpler stand-ins",
    keys: &[
        key(
            "gravity",
            Kind::Numbers(3),
            "",
            "scene units per second²",
            "Left out, 9.81 m/s² downwards in the scene's units",
        ),
        key("sub_steps", Kind::Whole(1, 1000), "10", "", "Physics steps of a frame"),
    ],
    parameters: &[],
};

/// An item of the camera's `keyframes`.
pub static VIEW: Section = Section {
    name: "camera.keyframes",
    help: "The camera at a time; it moves smoothly in between",
    keys: &[
        key("time", Kind::Number(0.0, 1e6), "", "seconds", "When; later than the keyframe before"),
        key("position", Kind::Numbers(3), "", UNITS, "Where it is; left out, as before"),
        key("target", Kind::Numbers(3), "", UNITS, "Where it looks; left out, as before"),
        key("fov", Kind::Number(1.0, 150.0), "", DEGREES, "Vertical field of view; left out, as before"),
    ],
    parameters: &[],
};

/// `[camera]`
pub static CAMERA: Section = Section {
    name: "camera",
    help: "The camera; left out, one that sees everything",
    keys: &[
        key(
            "position",
            Kind::Numbers(3),
            "",
            UNITS,
            "Where it is; with `follow`, seen from the object. Left out, far enough to see everything",
        ),
        key(
            "target",
            Kind::Numbers(3),
            "",
            UNITS,
            "Where it looks; with `follow`, seen from the object. Left out, the middle of everything",
        ),
        key("fov", Kind::Number(1.0, 150.0), "40", DEGREES, "Vertical field of view"),
        key("follow", Kind::Name("objects"), "", "", "Object it travels with, without turning"),
        key("keyframes", Kind::List(&VIEW), "[]", "", "Where it is when"),
    ],
    parameters: &[],
};

/// `[sun]`
pub static SUN: Section = Section {
    name: "sun",
    help: "A distant light",
    keys: &[
        key("elevation", Kind::Number(-90.0, 90.0), "35", DEGREES, "Height above the horizon"),
        key("azimuth", Kind::Number(-720.0, 720.0), "45", DEGREES, "Direction it comes from, about the up axis"),
        key("strength", NOT_NEGATIVE, "3", "", "Brightness"),
        key("colour", Kind::Colour, "[1, 0.95, 0.88]", "", "Colour"),
        key("angle", Kind::Number(0.0, 45.0), "0.53", DEGREES, "Diameter it appears under, which softens shadows"),
    ],
    parameters: &[],
};

/// `[sky]`
pub static SKY: Section = Section {
    name: "sky",
    help: "Light from everywhere else",
    keys: &[
        key("zenith", Kind::Colour, "[0.25, 0.42, 0.75]", "", "Colour overhead"),
        key("horizon", Kind::Colour, "[0.75, 0.82, 0.9]", "", "Colour at the horizon"),
        key("ground", Kind::Colour, "[0.35, 0.34, 0.33]", "", "Colour from below"),
        key("strength", NOT_NEGATIVE, "1", "", "Brightness"),
    ],
    parameters: &[],
};

/// `[output]`
pub static OUTPUT: Section = Section {
    name: "output",
    help: "What `relievo scene run` writes",
    keys: &[
        key("frames", Kind::Whole(1, 1_000_000), "1", "", "How many frames there are; they are numbered from 0"),
        key("images", Kind::Choices(&["png", "exr"]), "[\"png\"]", "", "Formats of pictures"),
        key(
            "pictures",
            Kind::Choices(&["beauty", "wireframe", "tiles"]),
            "[\"beauty\"]",
            "",
            "Pictures: the lit scene, the same with the lines of its tessellation, and false colours of its tiles",
        ),
        key("picture_frames", Kind::Choice(WHEN), "\"every\"", "", "Frames that get pictures"),
        key("mesh", Kind::Choice(WHEN), "\"last\"", "", "Frames whose displaced meshes are written"),
        key(
            "mesh_formats",
            Kind::Choices(&["glb", "obj", "ply", "usda"]),
            "[\"glb\"]",
            "",
            "Formats of meshes; USD (`usda`) has all frames of a run in one file",
        ),
        key(
            "rate",
            Kind::Power(2, 256),
            "8",
            "",
            "Quads along a side of an untouched tile in pictures and meshes; touched tiles get one per coefficient",
        ),
        key("mesh_rate", Kind::Power(2, 256), "64", "", "Most quads along a side of a touched tile in written meshes"),
        key("tiles", Kind::Choice(WHEN), "\"none\"", "", "Frames whose tiles are written as EXR"),
        key(
            "documents",
            Kind::Choice(WHEN),
            "\"none\"",
            "",
            "Frames whose surfaces are written as documents (.relievo), which objects can start from",
        ),
        key("povray", Kind::Choice(WHEN), "\"none\"", "", "Frames that are written as scenes for POV-Ray 3.7 (.pov)"),
        key(
            "blender",
            Kind::Choice(WHEN),
            "\"none\"",
            "",
            "Frames that are written as scripts that make them in Blender (.py, with .bin beside it)",
        ),
        key(
            "exposure",
            Kind::Number(-20.0, 20.0),
            "0",
            "stops",
            "Brightness of PNG pictures, and of lights in scenes for POV-Ray",
        ),
    ],
    parameters: relievo_render::Settings::PARAMETERS,
};

/// `[imprints]`
pub static IMPRINT: Section = Section {
    name: "imprints",
    help: "How colliders imprint themselves; a collider overrides single keys",
    keys: &[],
    parameters: relievo_detail::ImprintSettings::PARAMETERS,
};

/// `tool` of a collider
pub static TOOL: Section = Section {
    name: "tool",
    help: "A tool that a force presses into the surface, as a pen does: from where it is placed it goes along the force to \
           the undented surface, and sinks until the material carries it; `tool = { force = [0, 0, -30] }`",
    keys: &[key("force", Kind::Numbers(3), "", "newtons", "Force on the tool, which also says where it is pressed to")],
    parameters: relievo_detail::tool::ToolSettings::PARAMETERS,
};

/// `[colliders.NAME]`
pub static COLLIDER: Section = Section {
    name: "colliders.NAME",
    help: "Which object leaves imprints in which others, or which crowd",
    keys: &[
        key(
            "object",
            Kind::Name("objects"),
            "",
            "",
            "The object that presses; left out, the object of the collider's name. Holes of its mesh are covered, so that \
             it is solid inside; a sheet is solid behind its front",
        ),
        key(
            "crowd",
            Kind::Text,
            "",
            "",
            "The `name` of the crowd whose agents press, in place of an object. Each agent is a collider in its pose, where it \
             walks. Crowds press after objects",
        ),
        key(
            "triangles",
            Kind::Whole(1, 100_000_000),
            "5000",
            "",
            "Triangles of an agent of a crowd that presses at most: all press with the finest level of the model that has no \
             more, or else with its coarsest",
        ),
        key(
            "into",
            Kind::Names("objects"),
            "",
            "",
            "The deformable objects it presses into; left out, all others that are deformable",
        ),
        key("from", Kind::Number(0.0, 1e6), "0", "seconds", "When it begins"),
        key("until", Kind::Number(0.0, 1e9), "1e9", "seconds", "When it ends"),
        key(
            "tool",
            Kind::Table(&TOOL),
            "",
            "",
            "Force that presses it in; left out, it is where it is placed or moved to",
        ),
    ],
    parameters: relievo_detail::ImprintSettings::PARAMETERS,
};

/// The whole file.
pub static SCENE: Section = Section {
    name: "",
    help: "A scene",
    keys: &[
        key("version", Kind::Whole(1, 1), "", "", "Version of this format; always 1"),
        key("fps", Kind::Number(1e-3, 1e4), "24", "frames per second", "Frame n is at n / fps seconds"),
        key("units", Kind::Choice(&["mm", "cm", "dm", "m", "in", "ft"]), "\"m\"", "", "Length of a scene unit"),
        key("up", Kind::Choice(AXES), "\"z\"", "", "Axis that points up"),
        key("seed", Kind::Whole(0, 4_294_967_295), "1", "", "Seed of everything random"),
        key("meshes", Kind::Named(&MESH), "", "", "Meshes by name"),
        key("surfaces", Kind::Named(&SURFACE), "", "", "Surfaces by name"),
        key("details", Kind::Table(&DETAIL), "", "", "How displacement and paint are stored"),
        key("objects", Kind::Named(&OBJECT), "", "", "Objects by name"),
        key("bodies", Kind::Named(&BODY), "", "", "Bodies by name"),
        key("colliders", Kind::Named(&COLLIDER), "", "", "Colliders by name"),
        key("imprints", Kind::Table(&IMPRINT), "", "", "How colliders imprint themselves"),
        key("stamps", Kind::Named(&STAMP), "", "", "Images of brushes by name"),
        key("strokes", Kind::List(&STROKE), "[]", "", "Painting and sculpting"),
        key("brushes", Kind::List(&RIDER), "[]", "", "Brushes that ride on objects"),
        key("decals", Kind::List(&DECAL), "[]", "", "Stickers"),
        key("crowds", Kind::List(&CROWD), "[]", "", "Crowds"),
        key("tissue", Kind::List(&TISSUE), "[]", "", "Soft tissue"),
        key("physics", Kind::Table(&PHYSICS), "", "", "Physics"),
        key("camera", Kind::Table(&CAMERA), "", "", "The camera"),
        key("sun", Kind::Table(&SUN), "", "", "The sun"),
        key("sky", Kind::Table(&SKY), "", "", "The sky"),
        key("output", Kind::Table(&OUTPUT), "", "", "What is written"),
    ],
    parameters: &[],
};

impl Section {
    /// The key called `name`, unless it is a parameter.
    pub fn key(&self, name: &str) -> Option<&'static Key> {
        self.keys.iter().find(|key| key.name == name)
    }

    /// The parameter called `name`.
    pub fn parameter(&self, name: &str) -> Option<&'static Parameter> {
        self.parameters.iter().find(|parameter| parameter.name == name)
    }

    /// Names of all keys.
    pub fn names(&self) -> impl Iterator<Item = &'static str> {
        let parameters = self.parameters.iter().map(|parameter| parameter.name);
        self.keys.iter().map(|key| key.name).chain(parameters)
    }
}

impl Kind {
    /// The type in words.
    pub fn words(&self) -> String {
        match self {
            Kind::Text => "text".into(),
            Kind::Path => "path".into(),
            Kind::Name(section) => format!("name in [{section}]"),
            Kind::Names(section) => format!("one or more names in [{section}]"),
            Kind::Flag => "true or false".into(),
            Kind::Whole(low, high) => format!("whole number {low} to {high}"),
            Kind::Power(low, high) => format!("power of two from {low} to {high}"),
            Kind::Number(low, high) => format!("number {low} to {high}"),
            Kind::Numbers(count) => format!("list of {count} numbers"),
            Kind::Pairs => "list of pairs of numbers".into(),
            Kind::Scale => "number or list of 3 numbers".into(),
            Kind::Colour => "list of 3 numbers or \"#rrggbb\"".into(),
            Kind::Choice(words) => format!("one of {}", words.join(", ")),
            Kind::Choices(words) => format!("list of {}", words.join(", ")),
            Kind::Table(section) => format!("table, see [{}]", section.name),
            Kind::List(section) => format!("list of tables, see [[{}]]", section.name),
            Kind::Named(section) => format!("tables by name, see [{}]", section.name),
        }
    }
}

/// Factor, and unit as scene files show it: radians are written in degrees.
pub fn shown_unit(parameter: &Parameter) -> (f64, &'static str) {
    match parameter.unit {
        "rad" => (180.0 / std::f64::consts::PI, DEGREES),
        "rad/s" => (180.0 / std::f64::consts::PI, "degrees per second"),
        "force / world units³" => (1.0, "newtons per cubic scene unit"),
        "world units" => (1.0, UNITS),
        unit => (1.0, unit),
    }
}

/// The sections in the order they are documented.
pub fn sections() -> Vec<&'static Section> {
    vec![
        &SCENE,
        &MESH,
        &SURFACE,
        &DETAIL,
        &OBJECT,
        &LAYER,
        &DECAY,
        &TRACES,
        &FLUID,
        &FOAM,
        &FOAM_LOOK,
        &DIELECTRIC,
        &BODY,
        &KEYFRAME,
        &IMPRINT,
        &COLLIDER,
        &TOOL,
        &STROKE,
        &STROKE_POINT,
        &RIDER,
        &STAMP,
        &DECAL,
        &DECAL_PIN,
        &CROWD,
        &TISSUE,
        &PHYSICS,
        &CAMERA,
        &VIEW,
        &SUN,
        &SKY,
        &OUTPUT,
    ]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_key_has_help_and_names_are_unique() {
        for section in sections() {
            let names: Vec<_> = section.names().collect();
            for (at, name) in names.iter().enumerate() {
                assert!(!names[..at].contains(name), "{}.{name} twice", section.name);
            }
            assert!(section.keys.iter().all(|key| !key.help.is_empty()));
        }
    }
}
