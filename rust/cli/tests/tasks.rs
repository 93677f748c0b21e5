//! Five first tasks in the window of `relievo view` (`docs/tasks.md`), by scripted mouse and keyboard alone, on models that are
//! made here. `cargo xtask window` renews their strips of pictures.
#![cfg(feature = "view")]

mod display;

use std::f64::consts::TAU;
use std::fmt::Write as _;
use std::path::Path;

use relievo_render::{Image, write_png};
use relievo_testing::{Limb, write_limbs};

use display::{difference, is_possible, pictures, share, view};

/// The part of a picture that the view has, of a model and of what is played.
const MODEL: [f32; 4] = [0.2, 0.05, 0.72, 0.95];
const PLAYED: [f32; 4] = [0.25, 0.05, 0.99, 0.88];

/// A mesh that is written as OBJ.
#[derive(Default)]
struct Shape {
    points: Vec<[f64; 3]>,
    faces: Vec<Vec<usize>>,
}

impl Shape {
    fn write(&self, path: &Path) {
        let mut text = String::new();
        for [x, y, z] in &self.points {
            writeln!(text, "v {x:.6} {y:.6} {z:.6}").unwrap();
        }
        for face in &self.faces {
            let corners: Vec<String> = face.iter().map(|point| (point + 1).to_string()).collect();
            writeln!(text, "f {}", corners.join(" ")).unwrap();
        }
        std::fs::write(path, text).unwrap();
    }

    /// A field of snow of 4 by 4.
    fn field() -> Self {
        const SIDE: usize = 24;
        let place = |at: usize| {
            let [x, y] = [at % (SIDE + 1), at / (SIDE + 1)].map(|at| 4.0 * at as f64 / SIDE as f64 - 2.0);
            [x, y, 0.06 * (2.1 * x).sin() * (1.7 * y).cos()]
        };
        let quad = |at: usize| {
            let first = at % SIDE + at / SIDE * (SIDE + 1);
            vec![first, first + 1, first + SIDE + 2, first + SIDE + 1]
        };
        let points = (0..(SIDE + 1) * (SIDE + 1)).map(place).collect();
        Self { points, faces: (0..SIDE * SIDE).map(quad).collect() }
    }

    /// A body that turns a profile of radius and height about z.
    fn turned(profile: &[[f64; 2]], around: usize) -> Self {
        let mut shape = Self::default();
        for [radius, height] in profile {
            let place = |at: usize| {
                let angle = TAU * at as f64 / around as f64;
                [radius * angle.cos(), radius * angle.sin(), *height]
            };
            shape.points.extend((0..around).map(place));
        }
        for row in 0..profile.len() - 1 {
            let [low, high] = [row * around, (row + 1) * around];
            let quad = |at: usize| vec![low + at, low + (at + 1) % around, high + (at + 1) % around, high + at];
            shape.faces.extend((0..around).map(quad));
        }
        let last = (profile.len() - 1) * around;
        shape.faces.extend([(0..around).rev().collect(), (last..last + around).collect()]);
        shape
    }

    fn bottle() -> Self {
        let mut profile = vec![[0.1, 0.0], [0.36, 0.0], [0.4, 0.03]];
        profile.extend((0..7).map(|at| [0.4, 0.1 + 0.15 * f64::from(at)]));
        profile.extend([[0.38, 1.1], [0.3, 1.25], [0.17, 1.36], [0.14, 1.45], [0.13, 1.6], [0.13, 1.68]]);
        profile.extend([[0.15, 1.69], [0.15, 1.75], [0.13, 1.76], [0.05, 1.76]]);
        Self::turned(&profile, 32)
    }

    fn ball() -> Self {
        let profile: Vec<[f64; 2]> =
            (1..16).map(|at| TAU * f64::from(at) / 32.0).map(|a| [a.sin(), -a.cos()]).collect();
        Self::turned(&profile, 24)
    }

    /// A frog that sits: an ellipsoid with bumps for eyes and legs, of a cube's divided sides.
    fn frog() -> Self {
        const SIDE: usize = 20;
        const BUMPS: [([f64; 3], f64, f64); 6] = [
            ([0.34, -0.62, 0.62], 0.198, 0.3),
            ([-0.34, -0.62, 0.62], 0.198, 0.3),
            ([0.8, 0.45, -0.3], 0.33, 0.5),
            ([-0.8, 0.45, -0.3], 0.33, 0.5),
            ([0.55, -0.6, -0.6], 0.22, 0.35),
            ([-0.55, -0.6, -0.6], 0.22, 0.35),
        ];
        let length = |[x, y, z]: [f64; 3]| (x * x + y * y + z * z).sqrt();
        let place = |corner: [i32; 3]| {
            let at = corner.map(|at| f64::from(at) / SIDE as f64 * 2.0 - 1.0);
            let way = at.map(|value| value / length(at));
            let mut radius = 1.0 / length([way[0] / 0.75, way[1], way[2] / 0.55]);
            for (middle, width, height) in BUMPS {
                let cosine: f64 = (0..3).map(|axis| way[axis] * middle[axis]).sum::<f64>() / length(middle);
                radius += height * (-(cosine.clamp(-1.0, 1.0).acos() / width).powi(2)).exp();
            }
            way.map(|value| radius * value)
        };
        let mut shape = Self::default();
        let mut known = std::collections::HashMap::new();
        for (axis, is_high, at) in (0..3).flat_map(|axis| {
            [false, true].into_iter().flat_map(move |side| (0..SIDE * SIDE).map(move |at| (axis, side, at)))
        }) {
            let mut quad: Vec<usize> = [[0, 0], [1, 0], [1, 1], [0, 1]]
                .into_iter()
                .map(|[right, up]| {
                    let mut corner = [0; 3];
                    corner[axis] = if is_high { SIDE as i32 } else { 0 };
                    corner[(axis + 1) % 3] = (at % SIDE) as i32 + right;
                    corner[(axis + 2) % 3] = (at / SIDE) as i32 + up;
                    *known.entry(corner).or_insert_with(|| {
                        shape.points.push(place(corner));
                        shape.points.len() - 1
                    })
                })
                .collect();
            if !is_high {
                quad.reverse();
            }
            shape.faces.push(quad);
        }
        shape
    }
}

/// A label: a border, a sun over hills.
fn label(path: &Path) {
    let mut image = Image::new(256, 256, 3).unwrap();
    for (column, row) in (0..256).flat_map(|y| (0..256).map(move |x| (x, y))) {
        let [x, y] = [column as f32 / 255.0, 1.0 - row as f32 / 255.0];
        let color = match () {
            () if x.min(y) < 0.04 || x.max(y) > 0.96 => [0.1, 0.005, 0.003],
            () if y < 0.35 + 0.1 * (7.0 * x).sin() => [0.01, 0.07, 0.027],
            () if (x - 0.5).hypot(y - 0.6) < 0.2 => [0.6, 0.05, 0.003],
            () => [0.83, 0.69, 0.39],
        };
        image.set_color(column, row, color);
    }
    write_png(path, &image).unwrap();
}

/// Seconds that a person takes for the input of a script: 0.3 for a letter, 1 for a key, 2 for a click or a file that is
/// dropped, 4 for a drag.
fn seconds(script: &str) -> f64 {
    let act = |line: &str| match line.split(' ').next() {
        Some("drag") => 4.0,
        Some("press" | "drop" | "point") => 2.0,
        Some("key" | "wheel") => 1.0,
        Some("type") => 0.3 * line.len() as f64,
        _ => 0.0,
    };
    script.lines().map(act).sum()
}

/// Plays a task and returns its pictures, which are `NAME_0.png` and so on. Where `RELIEVO_STRIPS` names a folder, puts them
/// there side by side, half as large.
fn play<const N: usize>(folder: &Path, name: &str, arguments: &[&str], acts: &str) -> [Image; N] {
    let script = format!("resize 1000 620\nwait_frames 2\n{acts}quit\n");
    let pace = seconds(acts);
    assert!(pace < 300.0, "{name} takes {pace} s");
    view(folder, arguments, &script);
    let names: [String; N] = std::array::from_fn(|at| format!("{name}_{at}"));
    let shown = pictures(folder, std::array::from_fn(|at| names[at].as_str()));
    if let Some(strips) = std::env::var_os("RELIEVO_STRIPS") {
        let [width, height] = [shown[0].width() / 2, shown[0].height() / 2];
        let mut strip = Image::new(width * N as u32, height, 3).unwrap();
        for (at, image) in shown.iter().enumerate() {
            for (x, y) in (0..height).flat_map(|y| (0..width).map(move |x| (x, y))) {
                let pixels =
                    [[0, 0], [1, 0], [0, 1], [1, 1]].map(|[right, down]| image.color(2 * x + right, 2 * y + down));
                let mean = std::array::from_fn(|channel| pixels.iter().map(|pixel| 0.25 * pixel[channel]).sum());
                strip.set_color(at as u32 * width + x, y, mean);
            }
        }
        write_png(&Path::new(&strips).join(format!("window_{name}.png")), &strip).unwrap();
        println!("{name}: {pace:.0} seconds of a person's input");
    }
    shown
}

#[test]
fn tracks_are_pressed_into_snow() {
    if !is_possible() {
        return;
    }
    let folder = tempfile::tempdir().unwrap();
    Shape::field().write(&folder.path().join("snow.obj"));
    Shape::ball().write(&folder.path().join("ball.obj"));
    let acts = "screenshot snow_0.png\ndrop ball.obj\npress press ball\ndrag left 0.32 0.42 0.45 0.55\npoint 0.02 0.02\n\
        wait_frames 2\nscreenshot snow_1.png\ndrag left 0.45 0.55 0.62 0.45\ndrag left 0.62 0.45 0.72 0.6\npoint 0.02 0.02\n\
        wait_frames 2\nkey r\nrest\nscreenshot snow_2.png\n";
    let [before, one, all] = play(folder.path(), "snow", &["snow.obj"], acts);
    assert!(difference(&before, &one) > 0.005 && difference(&one, &all) > 0.01);
}

#[test]
fn a_frog_is_dented_and_painted() {
    if !is_possible() {
        return;
    }
    let folder = tempfile::tempdir().unwrap();
    Shape::frog().write(&folder.path().join("frog.obj"));
    let acts = "point 0.02 0.02\nscreenshot frog_0.png\ndrag ctrl+left 0.59 0.38 0.63 0.4\ndrag ctrl+left 0.69 0.43 0.73 0.46\n\
        point 0.02 0.02\nwait_frames 2\nscreenshot frog_1.png\npress paint mix\ndrag left 0.57 0.37 0.8 0.5\n\
        drag left 0.62 0.5 0.77 0.6\npoint 0.02 0.02\nwait_frames 2\nkey r\nrest\nscreenshot frog_2.png\n";
    let [before, dented, painted] = play(folder.path(), "frog", &["frog.obj"], acts);
    assert!(difference(&before, &dented) > 0.005);
    let is_red = |[r, g, b]: [f32; 3]| r > 2.0 * g && r > 2.0 * b && r > 0.05;
    assert!(share(&dented, MODEL, is_red) < 1e-4 && share(&painted, MODEL, is_red) > 0.005);
}

#[test]
fn a_label_is_laid_on_a_bottle() {
    if !is_possible() {
        return;
    }
    let folder = tempfile::tempdir().unwrap();
    Shape::bottle().write(&folder.path().join("bottle.obj"));
    label(&folder.path().join("label.png"));
    let acts = "key 1\nwait_frames 2\npoint 0.02 0.02\nscreenshot bottle_0.png\npress decal\ndrop label.png\n\
        drag left 0.5 0.62 0.5 0.62\nkey f\npoint 0.57 0.62\ndrag left 0.57 0.62 0.57 0.62\npoint 0.02 0.02\nwait_frames 2\n\
        screenshot bottle_1.png\ndrag left 0.5 0.62 0.5 0.58\npoint 0.02 0.02\nwait_frames 2\nscreenshot bottle_2.png\n\
        key Enter\nwait_frames 2\ndrag middle 0.5 0.5 0.56 0.47\npoint 0.02 0.02\nwait_frames 2\nscreenshot bottle_3.png\n";
    let [before, laid, dragged, written] = play(folder.path(), "bottle", &["bottle.obj"], acts);
    let is_green = |[r, g, b]: [f32; 3]| g > 2.0 * r && g > 1.5 * b;
    assert!(share(&before, MODEL, is_green) < 1e-4);
    for image in [&laid, &dragged, &written] {
        assert!(share(image, MODEL, is_green) > 0.004, "{}", share(image, MODEL, is_green));
    }
    assert!(difference(&laid, &dragged) > 0.002);
}

#[test]
fn a_wave_breaks_with_foam() {
    if !is_possible() {
        return;
    }
    let folder = tempfile::tempdir().unwrap();
    let wave = "frames = 20\nfps = 24\n[fluid]\nspacing = 0.05\n[basin]\nlow = [0, 0, 0]\nhigh = [2, 0.8, 1.5]\n\
        [[fill]]\nbox = { low = [0, 0, 0], high = [0.6, 0.8, 0.8] }\nvelocity = [1.5, 0, 0]\n";
    std::fs::write(folder.path().join("wave.toml"), wave).unwrap();
    let acts = "screenshot wave_0.png\npress surface\npress Bake\nrest\nkey Left\nkey Left\nkey Left\nkey Left\nkey Left\n\
        key Left\nkey Left\nkey Left\nkey Left\nkey Left\nwait_frames 2\nscreenshot wave_1.png\nkey Space\nwait_frames 5\nkey Space\n\
        wait_frames 2\nscreenshot wave_2.png\n";
    let [before, running, breaking] = play(folder.path(), "wave", &["wave.toml"], acts);
    assert!(difference(&before, &running) > 0.05 && difference(&running, &breaking) > 0.02);
    let is_white = |[r, g, b]: [f32; 3]| r > 0.3 && r > 0.7 * b && g > 0.7 * b;
    assert!(share(&before, PLAYED, is_white) < 1e-4 && share(&breaking, PLAYED, is_white) > 5e-4);
}

/// Metres that a robot goes in a step, of half a second.
const STEP: f32 = 0.48;

/// A robot that walks with y up: a trunk with a head, and for each side a leg and a foot, which stays where it stands.
fn robot() -> Vec<Limb> {
    const HIP: f32 = 0.55;
    let times: Vec<f32> = (0..=12).map(|at| at as f32 / 12.0).collect();
    let still = vec![[0.0, 0.0, 0.0, 1.0]; times.len()];
    let mut trunk = Limb {
        places: times.iter().map(|time| [0.0, 0.015 * (2.0 * TAU as f32 * time).cos(), 0.0]).collect(),
        turns: still.clone(),
        times: times.clone(),
        ..Limb::default()
    };
    trunk.add_box([-0.16, HIP, -0.1], [0.16, 1.0, 0.1]);
    trunk.add_box([-0.1, 1.02, -0.1], [0.1, 1.22, 0.1]);
    let mut limbs = vec![trunk];
    for (side, ahead) in [(-0.09, 0.0), (0.09, 0.5)] {
        // It stands for half of the time, and is lifted over the other half.
        let place = |time: &f32| {
            let phase = (time + ahead).fract();
            let (height, along) = match phase < 0.5 {
                true => (0.0, 0.5 - 2.0 * phase),
                false => (0.12 * (TAU as f32 * (phase - 0.5)).sin(), 2.0 * (phase - 0.5) - 0.5),
            };
            [side, height, STEP * along]
        };
        let places: Vec<[f32; 3]> = times.iter().map(place).collect();
        let lean = |[_, height, along]: &[f32; 3]| {
            let half = 0.5 * (-along).atan2(HIP - height);
            [half.sin(), 0.0, 0.0, half.cos()]
        };
        let mut leg = Limb {
            times: times.clone(),
            turns: places.iter().map(lean).collect(),
            places: vec![[side, HIP, 0.0]; times.len()],
            ..Limb::default()
        };
        leg.add_box([-0.06, -0.5, -0.06], [0.06, 0.02, 0.06]);
        let mut foot = Limb { times: times.clone(), places, turns: still.clone(), ..Limb::default() };
        foot.add_box([-0.06, 0.0, -0.08], [0.06, 0.07, 0.14]);
        limbs.extend([leg, foot]);
    }
    limbs
}

#[test]
fn robots_sink_into_sand() {
    if !is_possible() {
        return;
    }
    let folder = tempfile::tempdir().unwrap();
    write_limbs(&folder.path().join("robot.gltf"), &robot());
    let mut scene = String::from(
        "version = 1\nfps = 12\n[meshes.sand]\nshape = \"plane\"\nsize = [5, 5, 1]\n[surfaces.sand]\nmesh = \"sand\"\n\
         [details]\ntile_size = 128\n[objects.sand]\nsurface = \"sand\"\ncolour = [0.76, 0.6, 0.38]\n[imprints]\n\
         max_displacement = 0.3\nsmoothing = 0.3\nrim = 0.3\nrim_width = 0.08\nrepose = 34\n[output]\nframes = 25\npictures = []\n",
    );
    let colors = ["0.6, 0.1, 0.08", "0.1, 0.3, 0.6", "0.1, 0.5, 0.2", "0.7, 0.5, 0.05", "0.4, 0.15, 0.5"];
    for (at, color) in colors.iter().enumerate() {
        let agents: String = (0..2)
            .map(|row| {
                let [x, z] = [0.8 * at as f32 - 1.6 + 0.3 * row as f32, 2.0 - 0.9 * row as f32 - 0.2 * (at % 2) as f32];
                format!("{x} -0.07 {z} 180 1 walk {} 0 {}\n", 0.23 * at as f32, 2.0 * STEP)
            })
            .collect();
        std::fs::write(folder.path().join(format!("agents{at}.txt")), agents).unwrap();
        write!(
            scene,
            "[[crowds]]\nname = \"robots {at}\"\nfile = \"robot.gltf\"\nagents = \"agents{at}.txt\"\ncolour = [{color}]\n\
             [colliders.\"robots {at}\"]\ncrowd = \"robots {at}\"\n"
        )
        .unwrap();
    }
    std::fs::write(folder.path().join("crowd.toml"), scene).unwrap();
    let acts = "wheel 2\nwait_frames 2\nscreenshot crowd_0.png\npress Bake\nrest\nkey Left\nkey Left\nkey Left\nkey Left\nkey Left\nkey Left\n\
        key Left\nkey Left\nkey Left\nkey Left\nkey Left\nkey Left\nwait_frames 2\nscreenshot crowd_1.png\nkey Space\nwait_frames 10\n\
        key Space\nkey r\nrest\nscreenshot crowd_2.png\n";
    let [before, walking, sunk] = play(folder.path(), "crowd", &["crowd.toml"], acts);
    assert!(difference(&before, &walking) > 0.02 && difference(&walking, &sunk) > 0.02);
    // Robots are where they walk, in frames that are not baked too.
    let is_blue = |[r, g, b]: [f32; 3]| b > 1.8 * g && b > 3.0 * r;
    for image in [&before, &walking, &sunk] {
        assert!(share(image, PLAYED, is_blue) > 5e-4, "{}", share(image, PLAYED, is_blue));
    }
}
