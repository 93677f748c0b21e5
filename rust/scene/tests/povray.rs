//! Scenes written for POV-Ray, rendered by it, beside the pictures of our own ray caster.

use std::path::Path;
use std::process::{Command, Stdio};

use relievo_render::{Image, Picture, read_png};

#[path = "scene/support/mod.rs"]
mod support;
use support::run_in;

/// A limit surface on which nothing happened, one that is sculpted and painted, a triangle mesh with a dent, its rim
/// and traces, and the meshes that press, under a sun alone.
const SCENE: &str = r##"version = 1
[meshes.ground]
shape = "plane"
size = [3, 3, 1]
faces = 6
[meshes.ball]
shape = "sphere"
radius = 0.4
faces = 4
[meshes.sheet]
shape = "plane"
size = [1.2, 1.2, 1]
faces = 8
[meshes.post]
shape = "box"
size = [0.2, 0.3, 0.3]
[surfaces.ground]
mesh = "ground"
[surfaces.ball]
mesh = "ball"
[surfaces.sheet]
mesh = "sheet"
kind = "triangles"
[details]
segments = 16
tile_size = 32
[objects.ground]
surface = "ground"
colour = [0.6, 0.6, 0.6]
specular = 0
[objects.ball]
surface = "ball"
translation = [0.55, 0.5, 0.5]
rotation = [20, 30, 0]
colour = [0.7, 0.6, 0.2]
specular = 0
[objects.sheet]
surface = "sheet"
translation = [-0.5, -0.2, 0.1]
colour = [0.5, 0.6, 0.8]
specular = 0
traces = { depth = 0.05, colour = [0.9, 0.3, 0.1] }
[objects.tool]
mesh = "ball"
translation = [-0.5, -0.2, 0.44]
scale = 0.999
colour = [0.4, 0.7, 0.4]
specular = 0
visible = false
[objects.post]
mesh = "post"
translation = [0.9, -0.4, 0.15]
rotation = [0, 0, 25]
colour = [0.5, 0.2, 0.2]
specular = 0
[imprints]
voxels = 262144
[colliders.tool]
into = ["sheet"]
rim = 0.5
rim_width = 0.15
[[strokes]]
object = "ground"
sculpt = "draw"
height = 0.05
radius = 0.25
points = [{ position = [-0.2, -1.1, 0] }, { position = [1.1, -0.9, 0] }]
[[strokes]]
object = "ground"
paint = "mix"
colour = [0.1, 0.2, 0.8]
radius = 0.2
points = [{ position = [0.2, -1.3, 0] }, { position = [1.2, -0.2, 0] }]
[camera]
position = [0.9, -2.9, 2.2]
target = [0.05, -0.1, 0.1]
fov = 40
[sun]
elevation = 50
azimuth = 300
strength = 2.5
angle = 0
[sky]
strength = 0
[output]
frames = 1
width = 320
height = 240
samples = 1
sky_rays = 0
images = ["exr"]
pictures = ["beauty"]
mesh = "none"
mesh_rate = 64
povray = "last"
"##;

/// What POV-Ray makes of the scene `name`, with transparency where nothing is; `None`, with a word about it, where
/// there is no POV-Ray.
fn rendered(folder: &Path, name: &str) -> Option<Image> {
    let found = Command::new("povray").arg("--version").stdout(Stdio::null()).stderr(Stdio::null()).status();
    if found.is_err() {
        println!("skipped: povray is not installed");
        return None;
    }
    let picture = folder.join("povray.png");
    let done = Command::new("povray")
        .current_dir(folder.join(name))
        .args(["+Iscene-000000.pov", "+W320", "+H240", "-D", "-A", "+FN16", "+UA", "File_Gamma=sRGB"])
        .arg(format!("+O{}", picture.display()))
        .output()
        .unwrap();
    let said = String::from_utf8_lossy(&done.stderr);
    let error = said.lines().position(|line| line.contains("Error")).unwrap_or(0);
    let error: Vec<&str> = said.lines().skip(error).take(3).collect();
    assert!(done.status.success(), "{error:?}");
    Some(read_png(&picture, u64::MAX).unwrap())
}

#[test]
fn povray_shows_what_our_ray_caster_shows() {
    let folder = tempfile::tempdir().unwrap();
    let summary = run_in(folder.path(), "scene", SCENE, None, 2);
    assert!(summary.files.iter().any(|file| file.ends_with("scene-000000.pov")), "{:?}", summary.files);
    let text = std::fs::read_to_string(folder.path().join("scene/scene-000000.pov")).unwrap();
    let count = |what: &str| text.matches(what).count();
    assert!(count("bicubic_patch") > 10 && count("mesh2") == 4 && count("light_source") == 1, "{}", text.len());
    assert!(
        count("texture_list") == 2
            && count("#macro Surface_Texture") == 1
            && count("normal_vectors") == 3
            && count("radiosity") == 0
    );
    assert_eq!(text.matches('{').count(), text.matches('}').count());
    let Some(theirs) = rendered(folder.path(), "scene") else { return };
    let ours = Picture::read(&folder.path().join("scene/beauty-000000.exr"), u64::MAX).unwrap();
    let depth = ours.depth.unwrap();
    assert_eq!((theirs.width(), theirs.height(), theirs.channels()), (320, 240, 4));
    let (mut covered, mut other, mut far, mut sum) = (0, 0, 0, 0.0);
    for (x, y) in (0..240).flat_map(|y| (0..320).map(move |x| (x, y))) {
        let (is_ours, is_theirs) = (depth.pixel(x, y)[0].is_finite(), theirs.pixel(x, y)[3] > 0.5);
        covered += u32::from(is_ours);
        other += u32::from(is_ours != is_theirs);
        if is_ours && is_theirs {
            let (a, b) = (ours.color.color(x, y), theirs.color(x, y));
            let off = (0..3).map(|k| f64::from((a[k].min(1.0) - b[k].min(1.0)).abs())).fold(0.0, f64::max);
            sum += off;
            far += u32::from(off > 0.03);
        }
    }
    println!("{covered} pixels, {other} of one alone, {far} of other colours, {} on average", sum / f64::from(covered));
    assert!(covered > 30_000);
    // Under 0.2 % of what is covered, and shading but for the edges of shadows.
    assert!(f64::from(other) < 0.002 * f64::from(covered), "{other} of {covered}");
    assert!(f64::from(far) < 0.01 * f64::from(covered) && sum / f64::from(covered) < 4e-3, "{far} {sum}");
}
