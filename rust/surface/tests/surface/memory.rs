//! The estimate of memory against what a process takes at its peak while it makes a surface. Each cage has a process of
//! its own, since memory that others have freed may be used again.

use std::process::Command;

use relievo_core::{Context, ContextOptions, Crease, Mesh};
use relievo_surface::{Surface, SurfaceOptions};

/// Names the cage and the isolation of a measuring process.
const CASE: &str = "RELIEVO_MEASURED_CAGE";

/// Makes a torus of `around` × `across` quads. Where `split` says so for a quad, it is two triangles.
fn torus(around: u32, across: u32, split: impl Fn(u32) -> bool) -> Mesh {
    let angle = |at: u32, count: u32| at as f32 / count as f32 * std::f32::consts::TAU;
    let points = (0..around * across).map(|at| {
        let (u, v) = (angle(at / across, around), angle(at % across, across));
        let radius = 3.0 + v.cos();
        [radius * u.cos(), radius * u.sin(), v.sin()]
    });
    let place = |u: u32, v: u32| u % around * across + v % across;
    let (mut sizes, mut corners) = (Vec::new(), Vec::new());
    for at in 0..around * across {
        let (u, v) = (at / across, at % across);
        let [a, b, c, d] = [place(u, v), place(u + 1, v), place(u + 1, v + 1), place(u, v + 1)];
        if split(at) {
            sizes.extend([3, 3]);
            corners.extend([a, b, c, a, c, d]);
        } else {
            sizes.push(4);
            corners.extend([a, b, c, d]);
        }
    }
    Mesh::new(points.collect(), sizes, corners)
}

/// Makes a plane of `side` × `side` quads with creases along every fourth row and column, so that some cross.
fn creased(side: u32) -> Mesh {
    let row = side + 1;
    let points = (0..row * row).map(|at| [(at % row) as f32, (at / row) as f32, 0.1 * ((at * 7) % 5) as f32]);
    let corners = (0..side).flat_map(|y| (0..side).map(move |x| y * row + x));
    let corners = corners.flat_map(|at| [at, at + 1, at + row + 1, at + row]).collect();
    let mut mesh = Mesh::new(points.collect(), vec![4; (side * side) as usize], corners);
    for line in (4..side).step_by(4) {
        mesh.creases.extend((0..side).map(|at| {
            let from = line * row + at;
            Crease { points: [from, from + 1], sharpness: 2.5 }
        }));
        if line % 8 == 0 {
            mesh.creases.extend((0..side).map(|at| {
                let from = at * row + line;
                Crease { points: [from, from + row], sharpness: 4.0 }
            }));
        }
    }
    mesh
}

/// Makes an ordinary cage: quads with a few triangles, hexagons and points of three, five and six faces.
fn ordinary() -> Mesh {
    let quads = torus(80, 78, |at| at % 41 == 0);
    let (mut points, mut sizes, mut corners) = (quads.points.clone(), Vec::new(), Vec::new());
    for (at, face) in quads.faces().enumerate() {
        let middle = points.len() as u32;
        match (face, at % 97) {
            // A quad in a quad, of which five faces are made.
            ([a, b, c, d], 5) => {
                let corner = [a, b, c, d].map(|corner| quads.points[*corner as usize]);
                let center: [f32; 3] = std::array::from_fn(|axis| 0.25 * corner.iter().map(|it| it[axis]).sum::<f32>());
                points
                    .extend(corner.map(|it| std::array::from_fn::<f32, 3, _>(|axis| 0.5 * (it[axis] + center[axis]))));
                let [e, f, g, h] = [0, 1, 2, 3].map(|number| middle + number);
                sizes.extend([4; 5]);
                corners.extend([*a, *b, f, e, *b, *c, g, f, *c, *d, h, g, *d, *a, e, h, e, f, g, h]);
            }
            _ => {
                sizes.push(face.len() as u32);
                corners.extend_from_slice(face);
            }
        }
    }
    Mesh::new(points, sizes, corners)
}

fn cage(name: &str) -> Mesh {
    match name {
        "regular" => torus(64, 64, |_| false),
        "creased" => creased(64),
        "creased a little" => creased(24),
        "ordinary" => ordinary(),
        "triangles" => torus(40, 40, |_| true),
        "many triangles" => torus(80, 75, |_| true),
        name => panic!("there is no cage `{name}`"),
    }
}

fn context(memory_limit: u64) -> Context {
    Context::new(&ContextOptions { threads: 1, memory_limit }).unwrap()
}

/// Returns the bytes that the process has (`VmRSS`) or had at its peak (`VmHWM`).
fn resident(what: &str) -> Option<u64> {
    let status = std::fs::read_to_string("/proc/self/status").ok()?;
    let line = status.lines().find_map(|line| line.strip_prefix(what)?.strip_prefix(':'))?;
    Some(1024 * line.trim().strip_suffix("kB")?.trim().parse::<u64>().ok()?)
}

/// Makes a surface and prints what it took, in the processes that [`used`] starts; does nothing in any other.
#[test]
fn measured_cage() {
    let Ok(case) = std::env::var(CASE) else { return };
    let (name, isolation) = case.split_once('/').unwrap();
    let (mesh, context) = (cage(name), context(0));
    let options = SurfaceOptions { isolation: isolation.parse().unwrap(), ..SurfaceOptions::default() };
    let before = resident("VmRSS").unwrap();
    let surface = Surface::new(&context, &mesh, &options).unwrap();
    let used = resident("VmHWM").unwrap() - before;
    println!("used {used}");
    drop(surface);
}

/// Returns the bytes that making a surface takes at the peak.
fn used(name: &str, isolation: u32) -> u64 {
    let mut command = Command::new(std::env::current_exe().unwrap());
    command.args(["--exact", "memory::measured_cage", "--nocapture"]).env(CASE, format!("{name}/{isolation}"));
    let output = command.output().unwrap();
    let text = String::from_utf8_lossy(&output.stdout);
    let figure = text.split("used ").nth(1).and_then(|rest| rest.split_whitespace().next());
    figure.unwrap_or_else(|| panic!("{output:?}")).parse().unwrap()
}

#[test]
fn memory_is_estimated_within_30_percent_above_what_is_used() {
    if resident("VmHWM").is_none() {
        println!("skipped: the system does not tell the peak of a process");
        return;
    }
    let cases = [
        ("regular", 6),
        ("creased", 6),
        ("creased a little", 4),
        ("ordinary", 3),
        ("ordinary", 6),
        ("triangles", 2),
        ("triangles", 4),
        ("many triangles", 2),
    ];
    let mut wrong = Vec::new();
    for (name, isolation) in cases {
        let options = SurfaceOptions { isolation, ..SurfaceOptions::default() };
        let expected = Surface::expected_bytes(&context(0), &cage(name), &options).unwrap();
        let used = used(name, isolation);
        let ratio = expected / used as f64;
        println!(
            "{name} at isolation {isolation}: {:.1} MB estimated, {:.1} MB used, {ratio:.2}",
            expected / 1e6,
            used as f64 / 1e6
        );
        if !(1.0..1.3).contains(&ratio) {
            wrong.push((name, isolation, ratio));
        }
    }
    assert!(wrong.is_empty(), "{wrong:?}");
}

#[test]
fn the_default_isolation_is_lowered_with_a_note_until_the_surface_fits() {
    let (mesh, options) = (cage("triangles"), SurfaceOptions::default());
    let expected =
        |isolation| Surface::expected_bytes(&context(0), &mesh, &SurfaceOptions { isolation, ..options }).unwrap();
    // Between what four levels and what five need.
    let limit = (0.5 * (expected(4) + expected(5))) as u64;
    let context = context(limit);
    let (chosen, note) = Surface::choose_isolation(&context, &mesh, &options, None).unwrap();
    assert_eq!(chosen.isolation, 4);
    let note = note.unwrap();
    assert!(note.contains("isolated by 4 levels") && note.contains("6 would exceed"), "{note}");
    assert!(Surface::new(&context, &mesh, &chosen).is_ok());
    // What is asked for is not lowered, and is refused where it does not fit.
    let (wanted, note) = Surface::choose_isolation(&context, &mesh, &options, Some(6)).unwrap();
    assert_eq!((wanted.isolation, note), (6, None));
    let error = Surface::new(&context, &mesh, &wanted).unwrap_err().to_string();
    assert!(error.contains("memory limit"), "{error}");
    // Nothing is lowered where all fits.
    let (chosen, note) = Surface::choose_isolation(&self::context(0), &mesh, &options, None).unwrap();
    assert_eq!((chosen, note), (options, None));
}
