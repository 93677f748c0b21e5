//! A first scene for a user's mesh, with comments, that runs as it is.

use std::fmt::Write as _;

use relievo_core::{Context, Error, Mesh, Result};
use relievo_surface::{Grid, Order, Placement, Samples, Surface, SurfaceOptions};

/// A mesh for the scene.
#[derive(Clone, Debug)]
pub struct Entry<'a> {
    /// Path as the scene is to write it.
    pub path: String,
    /// The mesh.
    pub mesh: &'a Mesh,
}

/// Most patches to expect from a cage, so that its scene opens within seconds.
const MAX_PATCHES: u32 = 1_000_000;

/// A number as the scene shows it: four digits are enough to begin with.
fn short(value: f64) -> String {
    let text = format!("{value:.3e}").parse::<f64>().unwrap_or(value).to_string();
    if text == "-0" { "0".into() } else { text }
}

fn list(values: [f64; 3]) -> String {
    format!("[{}]", values.map(short).join(", "))
}

fn quoted(text: &str) -> String {
    toml::Value::String(text.to_string()).to_string()
}

/// A scene in which the first mesh, as a Catmull-Clark surface, is dented from above: by the other meshes, or by a ball
/// without other meshes. `up` is 0 to 2 for x to z.
///
/// # Errors
/// Fails with `Invalid` if there is no mesh, a mesh has no points, or the first does not pass [`Mesh::check`] or has no
/// surface; with `Memory` if its surface would exceed the memory limit even with one level of isolation; and with
/// `Unsupported` if that makes more patches than the limit of [`SurfaceOptions`].
pub fn starter(context: &Context, entries: &[Entry], up: usize) -> Result<String> {
    let Some((target, tools)) = entries.split_first() else {
        return Err(Error::invalid("there is no mesh").advise("name at least one mesh file"));
    };
    let up = up.min(2);
    let (low, high) = target.mesh.bounds().ok_or_else(|| Error::invalid("the mesh is empty").at(&target.path))?;
    let (low, high) = (low.map(f64::from), high.map(f64::from));
    let named = |error: Error| error.at(&target.path);
    let all = SurfaceOptions::default();
    let within = SurfaceOptions { patch_limit: MAX_PATCHES, ..all };
    let isolation = Surface::affordable_isolation(context, target.mesh, &within).map_err(named)?.unwrap_or(1);
    let fine = isolation < all.isolation;
    let options = SurfaceOptions { isolation, ..all };
    let top = top(context, target.mesh, &options, up).map_err(named)?;
    let side: [f64; 3] = std::array::from_fn(|axis| high[axis] - low[axis]);
    let diagonal = side.iter().map(|side| side * side).sum::<f64>().sqrt().max(1e-6);
    let axis = ["x", "y", "z"][up];
    let mut out = format!(
        "# A scene for Relievo. Run it with `relievo scene run`; `relievo scene schema` lists every key.\n\
         # Angles are in degrees, times in seconds, paths relative to this file.\n\
         version = 1\n\
         fps = 24\n\
         units = \"m\"  # length of a scene unit\n\
         up = \"{axis}\"     # the axis that points up\n\n\
         # The control cage of the surface that takes dents.\n\
         [meshes.target]\nfile = {}\n\n",
        quoted(&target.path)
    );
    out.push_str(
        "# The Catmull-Clark surface over that cage; creases and corners of the file are kept.\n\
         [surfaces.target]\nmesh = \"target\"\n",
    );
    if fine {
        let _ = write!(
            out,
            "# The mesh is fine for a cage: with all levels of isolation around its irregular points it would make too\n\
             # many patches. Fewer levels are less exact only close to these points.\nisolation = {isolation}\n"
        );
    }
    out.push_str(
        "\n[objects.target]\nsurface = \"target\"\ncolour = [0.72, 0.55, 0.42]  # linear, or \"#rrggbb\" in sRGB\n\n",
    );
    let _ = write!(
        out,
        "# Displacement is kept in tiles, one per face, made where something happens.\n\
         [details]\ntile_size = 128  # 8 to 256 coefficients along a side\n\n\
         # How deep dents may become, in units of the object.\n[imprints]\nmax_displacement = {}\n\n",
        short(diagonal * 0.1)
    );
    let _ = write!(
        out,
        "# A stroke paints or sculpts along its points. Take off the `#~` to make this one.\n\
         #~ [[strokes]]\n#~ object = \"target\"\n#~ paint = \"mix\"  # or sculpt = \"draw\" with a `height`\n\
         #~ colour = \"#a03020\"\n#~ radius = {}\n#~ points = [{{ position = {} }}]\n\n",
        short(diagonal * 0.08),
        list(top)
    );
    let names: Vec<String> = match tools.len() {
        0 | 1 => vec!["tool".into()],
        count => (1..=count).map(|number| format!("tool{number}")).collect(),
    };
    for (index, name) in names.iter().enumerate() {
        let (reach, source) = match tools.get(index) {
            None => {
                let radius = diagonal * 0.12;
                (radius, format!("shape = \"sphere\"\nradius = {}\nfaces = 16\n", short(radius)))
            }
            Some(tool) => {
                let (low, _) = tool.mesh.bounds().ok_or_else(|| Error::invalid("the mesh is empty").at(&tool.path))?;
                (-f64::from(low[up]), format!("file = {}\n", quoted(&tool.path)))
            }
        };
        // Above the highest point of the target, so that the tool surely meets it.
        let mut start = top;
        start[up] += reach + diagonal * 0.1;
        let mut end = top;
        end[up] += reach - diagonal * 0.06;
        let shift = diagonal * 0.3 * index as f64;
        start[(up + 1) % 3] += shift;
        end[(up + 1) % 3] += shift;
        let _ = write!(
            out,
            "# {}\n[meshes.{name}]\n{source}\n\
             [objects.{name}]\nmesh = \"{name}\"\ntranslation = {}\ncolour = [0.25, 0.3, 0.35]\n\n\
             # It comes down, dents, and goes up again. Without keyframes it would be a rigid body that falls.\n\
             [bodies.{name}]\nkeyframes = [\n    {{ time = 0, translation = {} }},\n    \
             {{ time = 0.5, translation = {} }},\n    {{ time = 1, translation = {} }},\n]\n\n\
             # What presses into what.\n[colliders.{name}]\ninto = [\"target\"]\n\
             # A force instead, in newtons, would press it as a pen is pressed, wherever it is over the target:\n\
             # tool = {{ force = {}, stiffness = 1000 }}\n\n",
            if tools.is_empty() { "A ball to dent it with." } else { "A mesh to dent it with." },
            list(start),
            list(start),
            list(end),
            list(start),
            list(std::array::from_fn(|axis| if axis == up { -30.0 } else { 0.0 }))
        );
    }
    out.push_str(
        "# Without position and target the camera sees everything.\n[camera]\nfov = 35\n\n\
         [sun]\nelevation = 40\nazimuth = 30\n\n\
         [output]\nframes = 25\nwidth = 640\nheight = 480\nsamples = 16\nimages = [\"png\"]\n\
         mesh = \"last\"        # the displaced mesh: \"none\", \"last\" or \"every\" frame\n\
         mesh_formats = [\"glb\", \"obj\"]\n",
    );
    Ok(out)
}

/// The highest point of the limit surface, nearly: it lies below its cage.
fn top(context: &Context, mesh: &Mesh, options: &SurfaceOptions, up: usize) -> Result<[f64; 3]> {
    let surface = Surface::new(context, mesh, options)?;
    let grid = Grid::whole(4, Placement::Lattice);
    let mut samples = Samples::default();
    let mut best: Option<[f32; 3]> = None;
    for tile in (0..surface.tile_count() as u32).filter(|tile| !surface.topology().is_hole(*tile)) {
        surface.grid(context.level(), tile, &grid, Order::Position, &mut samples);
        for index in 0..samples.len() {
            let point = samples.p.each_ref().map(|values| values[index]);
            if best.is_none_or(|best| point[up] > best[up]) {
                best = Some(point);
            }
        }
    }
    best.map(|point| point.map(f64::from)).ok_or_else(|| Error::invalid("the mesh has no surface"))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::format::placement::Up;
    use crate::state::shapes::Shape;

    #[test]
    fn a_starter_scene_is_valid_for_any_number_of_meshes() {
        let context = Context::serial();
        let mesh = Shape::Sphere { radius: 3.0, faces: 4 }.mesh(Up::Z);
        for count in 1..4 {
            for up in 0..3 {
                let entries = vec![Entry { path: "a \"b\".obj".into(), mesh: &mesh }; count];
                let text = starter(&context, &entries, up).unwrap();
                let scene = crate::format::file::parse(std::path::Path::new("a.toml"), &text);
                let scene = scene.unwrap_or_else(|faults| panic!("{faults}\n{text}"));
                assert_eq!(scene.colliders.len(), count.max(2) - 1);
                let text = text.replace("#~ ", "");
                let scene = crate::format::file::parse(std::path::Path::new("a.toml"), &text);
                assert_eq!(scene.unwrap_or_else(|faults| panic!("{faults}\n{text}")).strokes.len(), 1);
            }
        }
        assert!(starter(&context, &[], 1).is_err());
    }

    #[test]
    fn a_mesh_too_fine_for_a_cage_gets_fewer_levels_of_isolation() {
        let ball = Shape::Sphere { radius: 1.0, faces: 12 }.mesh(Up::Z);
        let corners = ball.triangles().concat();
        let mesh = Mesh::new(ball.points.clone(), vec![3; corners.len() / 3], corners);
        let entries = [Entry { path: "a.obj".into(), mesh: &mesh }];
        let surface = |context: &Context| {
            let text = starter(context, &entries, 2).unwrap();
            let scene = crate::format::file::parse(std::path::Path::new("a.toml"), &text).unwrap();
            (scene.surfaces[0].isolation, text.contains("fine for a cage"))
        };
        assert_eq!(surface(&Context::serial()), (None, false));
        let options = relievo_core::ContextOptions { threads: 1, memory_limit: 80 << 20 };
        let small = Context::new(&options).unwrap();
        let (Some(isolation), true) = surface(&small) else { panic!("nothing says why") };
        assert!((1..6).contains(&isolation), "{isolation}");
        let with = |isolation| SurfaceOptions { isolation, ..SurfaceOptions::default() };
        assert!(Surface::new(&small, &mesh, &with(isolation)).is_ok());
        assert!(Surface::new(&small, &mesh, &with(isolation + 1)).is_err());
    }
}
