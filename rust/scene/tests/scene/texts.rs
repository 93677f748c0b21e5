//! Parts that several texts of scenes share, as macros, so that `concat!` makes constants of them.
// No program uses all of them.
#![allow(unused_macros)]

/// Writes a plane of a size and so many faces a side as the mesh of a surface, the ground, with other meshes between them.
macro_rules! ground {
    ($size:literal, $faces:literal $(, $meshes:literal)?) => {
        concat!(
            "[meshes.ground]\nshape = \"plane\"\nsize = [", $size, ", ", $size, ", 1]\nfaces = ", $faces, "\n",
            $($meshes,)?
            "[surfaces.ground]\nmesh = \"ground\"\n"
        )
    };
}

/// Writes the beginning of a scene of a ground and a tool, a box.
macro_rules! ground_and_tool {
    () => {
        concat!("version = 1\n", ground!("1", "4", "[meshes.tool]\nshape = \"box\"\nsize = [0.2, 0.2, 0.2]\n"))
    };
}

/// Writes the beginning of a scene of a ground whose texels can be painted.
macro_rules! painted_ground {
    () => {
        concat!(
            "version = 1\nfps = 10\n",
            ground!("4", "8"),
            "[details]\ntile_size = 16\npaint_size = 32\n",
            "[objects.ground]\nsurface = \"ground\"\ncolour = [0.5, 0.5, 0.5]\n"
        )
    };
}

/// Writes a tool that cannot be seen, on its way along keyframes, which presses; else over the middle of the ground, and up.
macro_rules! pressing_tool {
    () => {
        pressing_tool!(
            "{ time = 0, translation = [-0.2, 0, 0.07] }, { time = 0.125, translation = [0.2, 0, 0.07] }, \
             { time = 0.25, translation = [0.2, 0, 1] }"
        )
    };
    ($keyframes:literal) => {
        concat!(
            "[objects.tool]\nmesh = \"tool\"\nvisible = false\n[bodies.tool]\nkeyframes = [",
            $keyframes,
            "]\n[imprints]\nvoxels = 65536\n[colliders.tool]\n"
        )
    };
}

/// Writes small pictures of which a pixel has one sample.
macro_rules! small_pictures {
    () => {
        "width = 64\nheight = 64\nsamples = 1\nsky_rays = 1\nimages = [\"png\"]\n"
    };
}

/// Writes an object's place, a camera above it, and three frames of small pictures.
macro_rules! seen_from_above {
    () => {
        concat!(
            "translation = [1, 0, 0]\n[camera]\nposition = [1, 0, 6]\ntarget = [1, 0.001, 0]\n",
            "[output]\nframes = 3\nwidth = 64\nheight = 64\n"
        )
    };
}

/// Writes a stroke that paints a band across a ground.
macro_rules! red_band {
    () => {
        concat!(
            "[[strokes]]\nobject = \"ground\"\npaint = \"mix\"\ncolour = \"#c02010\"\nradius = 0.08\n",
            "points = [{ position = [-0.4, 0.1, 0] }, { position = [0.4, 0.2, 0], pressure = 0.5 }]\n"
        )
    };
}
