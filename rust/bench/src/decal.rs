//! Bench `decal`: stickers with moved pins beside libigl's SLIM with soft pins and its LSCM with hard ones, dragging, a large
//! sticker beside potpourri3d's logarithmic map, its memory, geodesics beside those of potpourri3d, a sticker over most of a
//! bumpy ball beside the discrete exponential map, and a thousand small stickers. Peers map the same patch.

use std::path::Path;

use relievo_core::progress::Silent;
use relievo_core::{Context, ContextOptions, Error, Mesh, Result};
use relievo_decal::{
    Decal, DecalSettings, Pin, Place, Placement, Pose, Scatter, Sticker, exponential, lay, nearest, scatter,
    shortest_path, stretch,
};
use relievo_openmesh::Patch;

use crate::lod::Triangles;
use crate::measure::{Sample, anew, memory, printed, sample, seconds};
use crate::peers::Peer;
use crate::report::{Goal, Report};

/// Runs of each case.
const RUNS: usize = 3;
/// Pixels of the image in each direction.
const PIXELS: f64 = 100.0;

/// Measures all cases into `report`, beside the programs in a folder of peers.
pub fn run(report: &mut Report, peers: Option<&Path>) -> Result<()> {
    let peers = peers.map_or(Ok(Vec::new()), Peer::of_folder)?;
    let of = |name: &str| peers.iter().find(|peer| peer.name.contains(name));
    bytes(report);
    let cap = cap(104);
    for side in [2.9, 4.0] {
        moved(report, (&cap, side), of("SLIM"), of("LSCM"), of("flipped_triangles"))?;
    }
    drag(report)?;
    large(report, of("log map"))?;
    part(report)?;
    paths(report, of("geodesics"))?;
    around(report)?;
    small(report)
}

/// A bumpy cap of `2 count²` triangles over the square from -1 to 1.
fn cap(count: u32) -> Mesh {
    let (mut points, mut triangles) = (Vec::new(), Vec::new());
    for row in 0..=count {
        for column in 0..=count {
            let [x, y] = [column, row].map(|at| 2.0 * f64::from(at) / f64::from(count) - 1.0);
            let z = 0.6 * (1.0 - 0.5 * (x * x + y * y)) + 0.03 * (9.0 * x).sin() * (8.0 * y).cos();
            points.push([x, y, z].map(|value| value as f32));
            if row < count && column < count {
                let first = row * (count + 1) + column;
                let above = first + count + 1;
                triangles.extend([[first, first + 1, above + 1], [first, above + 1, above]]);
            }
        }
    }
    Mesh::from_triangles(points, &triangles)
}

/// The place of the cap over a point of the unit square.
fn over(mesh: &Mesh, [u, v]: [f64; 2]) -> Result<Place> {
    let [x, y] = [2.0 * u - 1.0, 2.0 * v - 1.0];
    let z = 0.6 * (1.0 - 0.5 * (x * x + y * y)) + 0.03 * (9.0 * x).sin() * (8.0 * y).cos();
    Ok(nearest(mesh, [x, y, z])?.0)
}

/// Pins in a grid over most of the cap, moved by a quarter of their spacing: as many as the square of `side`, at most.
fn pins(mesh: &Mesh, side: f64) -> Result<Vec<Pin>> {
    let columns = side.ceil() as usize;
    let count = (side * side) as usize;
    let pin = |index: usize| {
        let place = [index % columns, index / columns].map(|at| (at as f64 + 0.5) / columns as f64);
        let (turn, step) = (2.4 * index as f64, 0.25 / columns as f64);
        let moved = [place[0] + step * turn.cos(), place[1] + step * turn.sin()].map(|value| 0.05 + 0.9 * value);
        Ok(Pin { image: place.map(|value| PIXELS * value), place: over(mesh, moved)? })
    };
    (0..count).map(pin).collect()
}

fn whole() -> Result<Sticker> {
    Sticker::whole([PIXELS as u32; 2])
}

/// The farthest that a pin is from its point of the image, in widths of the image.
fn pin_error(decal: &Decal, pins: &[Pin]) -> f64 {
    let error = |(pin, vertex): (&Pin, &u32)| {
        let uv = decal.uv[*vertex as usize];
        (uv[0] - pin.image[0] / PIXELS).hypot(uv[1] - pin.image[1] / PIXELS)
    };
    pins.iter().zip(&decal.pins).map(error).fold(0.0, f64::max)
}

/// A patch for a peer: the triangles of a decal, and its pins in the plane.
fn patch(decal: &Decal, pins: &[Pin]) -> (Triangles, String) {
    // In widths of the image, as peers compare sizes on the surface with those between pins.
    let points = decal.points.iter().map(|point| point.map(|value| (decal.scale * value) as f32)).collect();
    let line = |(pin, vertex): (&Pin, &u32)| format!("{vertex} {} {}\n", pin.image[0] / PIXELS, pin.image[1] / PIXELS);
    ((points, decal.triangles.clone()), pins.iter().zip(&decal.pins).map(line).collect())
}

/// The plane that a peer maps a patch into, with its seconds.
fn mapped(peer: &Peer, (mesh, pins): &(Triangles, String)) -> Result<(Triangles, f64)> {
    let folder = tempfile::tempdir().map_err(|error| Error::io(Path::new("pins"), &error))?;
    let file = folder.path().join("pins");
    std::fs::write(&file, pins).map_err(|error| Error::io(&file, &error))?;
    peer.run(mesh, &[&file.to_string_lossy()])
}

/// The root mean square stretch of a map, scaled to 1 for an isometric one, and the number of flipped triangles.
fn quality(mesh: &Triangles, plane: &Triangles) -> (f64, usize) {
    let (mut squares, mut area, mut flat, mut flips) = (0.0, 0.0, 0.0, 0);
    for triangle in &mesh.1 {
        let space = triangle.map(|corner| mesh.0[corner as usize].map(f64::from));
        let at = triangle.map(|corner| plane.0[corner as usize]).map(|[x, y, _]| [f64::from(x), f64::from(y)]);
        let (larger, smaller, signed) = stretch(at, space);
        let size = larger * smaller * signed.abs();
        if size > 0.0 && size.is_finite() {
            squares += 0.5 * (larger * larger + smaller * smaller) * size;
            area += size;
            flat += signed.abs();
        }
        flips += usize::from(signed <= 0.0);
    }
    ((squares / area).sqrt() * (flat / area).sqrt(), flips)
}

fn one(value: f64) -> Sample {
    Sample::new(vec![value])
}

/// Lays a decal and measures how long that takes.
fn timed(mesh: &Mesh, sticker: &Sticker, pins: &[Pin]) -> Result<(Decal, Sample)> {
    let settings = DecalSettings::default();
    let decal = lay(mesh, sticker, pins, None, &settings, &mut Silent)?;
    Ok((decal, sample(RUNS, || seconds(|| lay(mesh, sticker, pins, None, &settings, &mut Silent)))))
}

/// Pins moved by a quarter of their spacing.
fn moved(
    report: &mut Report,
    (mesh, side): (&Mesh, f64),
    soft: Option<&Peer>,
    hard: Option<&Peer>,
    count: Option<&Peer>,
) -> Result<()> {
    let pins = pins(mesh, side)?;
    let (decal, time) = timed(mesh, &whole()?, &pins)?;
    let given = patch(&decal, &pins);
    let name = format!("{} pins on a cap of {} triangles", pins.len(), mesh.face_count());
    for peer in [soft, hard] {
        let other = peer.and_then(|peer| match mapped(peer, &given) {
            Ok((plane, seconds)) => Some((peer.name.as_str(), quality(&given.0, &plane), seconds)),
            Err(error) => {
                eprintln!("skipped: {}: {error}", peer.name);
                None
            }
        });
        let peer_time = other.map(|(name, _, seconds)| (name, one(seconds)));
        let peer_stretch = other.map(|(name, (l2, _), _)| (name, one(l2)));
        report.add(&name, &time, peer_time.as_ref().map(|(name, sample)| (*name, sample)), "s", Goal::AtMost(0.5));
        let stretch_peer = peer_stretch.as_ref().map(|(name, sample)| (*name, sample));
        report.add(&format!("{name}: L2 stretch"), &one(decal.quality.l2), stretch_peer, "", Goal::AtMost(1.1));
        let flips = other.map(|(name, (_, flips), _)| (name, one(flips as f64)));
        let flips = flips.as_ref().map(|(name, sample)| (*name, sample));
        report.add(&format!("{name}: flips"), &one(decal.quality.flips as f64), flips, "", Goal::AtMost(0.0));
    }
    let row = format!("{name}: flips as libigl counts them");
    let all = decal.uv.iter().enumerate().map(|(vertex, [u, v])| format!("{vertex} {u} {v}\n")).collect();
    match count.map(|peer| mapped(peer, &(given.0.clone(), all))) {
        Some(Ok((plane, _))) => report.add(&row, &one(plane.0[0][0].into()), None, "", Goal::AtMost(0.0)),
        Some(Err(error)) => report.skip(&row, &error.to_string()),
        None => report.skip(&row, "libigl is not there"),
    }
    let error = pin_error(&decal, &pins);
    report.add(&format!("{name}: pins off"), &one(error), None, "widths", Goal::AtMost(1e-6));
    Ok(())
}

/// Dragging one of nine pins on a patch of about 10,000 triangles.
fn drag(report: &mut Report) -> Result<()> {
    let mesh = cap(71);
    let pins = pins(&mesh, 3.0)?;
    let mut placed = Placement::new(&mesh, &whole()?, &pins, None, &DecalSettings::default(), &mut Silent)?;
    let mut steps = Vec::new();
    for step in 0..40 {
        let turn = 0.15 * f64::from(step);
        let place = over(&mesh, [0.5 + 0.02 * turn.sin(), 0.5 + 0.02 * turn.cos()])?;
        let mut done = Ok(());
        steps.push(1000.0 * seconds(|| done = placed.drag(4, place)));
        done?;
    }
    let name = format!("drag one pin, {} triangles", placed.decal().quality.triangles);
    report.add(&name, &Sample::new(steps), None, "ms", Goal::AtMost(30.0));
    Ok(())
}

/// A sticker over half of a cap of 100,000 triangles with 6 pins, and the same with one pin by the exponential map.
fn large(report: &mut Report, peer: Option<&Peer>) -> Result<()> {
    let mesh = cap(224);
    let pins = six(&mesh, 0.7)?;
    let (decal, time) = timed(&mesh, &whole()?, &pins)?;
    let given = patch(&decal, &pins);
    let other = peer.and_then(|peer| match mapped(peer, &given) {
        Ok((plane, seconds)) => Some((peer.name.as_str(), one(quality(&given.0, &plane).0), one(seconds))),
        Err(error) => {
            eprintln!("skipped: {}: {error}", peer.name);
            None
        }
    });
    let name = format!("6 pins, patch of {} of {} triangles", decal.quality.triangles, mesh.face_count());
    let peer_time = other.as_ref().map(|(name, _, seconds)| (*name, seconds));
    report.add(&name, &time, peer_time, "s", Goal::AtMost(2.0));
    let peer_stretch = other.as_ref().map(|(name, l2, _)| (*name, l2));
    report.add(&format!("{name}: L2 stretch"), &one(decal.quality.l2), peer_stretch, "", Goal::AtMost(1.25));
    Ok(())
}

/// Six pins of a sticker over the middle of the cap, as wide as a share of it.
fn six(mesh: &Mesh, share: f64) -> Result<Vec<Pin>> {
    let pins = [(20.0, 20.0), (80.0, 22.0), (50.0, 48.0), (25.0, 75.0), (78.0, 80.0), (52.0, 85.0)];
    let place = |(x, y): (f64, f64)| -> Result<Pin> {
        let place = over(mesh, [x, y].map(|value| 0.5 + share * (value / PIXELS - 0.5)))?;
        Ok(Pin { image: [x, y], place })
    };
    pins.into_iter().map(place).collect()
}

/// A sticker over the same number of triangles of a small mesh and of one of sixteen times as many.
fn part(report: &mut Report) -> Result<()> {
    let laid = |count: u32, share: f64| -> Result<(usize, usize, Sample)> {
        let mesh = cap(count);
        let (decal, time) = timed(&mesh, &whole()?, &six(&mesh, share)?)?;
        Ok((decal.quality.triangles, mesh.face_count(), time))
    };
    let (few, small, alone) = laid(112, 0.7)?;
    let (many, large, time) = laid(448, 0.175)?;
    let name = format!("6 pins, patch of {many} of {large} triangles, beside one of {few} of {small}");
    report.add(&name, &time, Some(("the small mesh", &alone)), "s", Goal::RatioAtMost(2.0));
    Ok(())
}

/// Lengths of geodesics from a vertex of a cap to others: the largest difference from those of edge flips (Sharp and Crane 2020),
/// as a share of the length.
fn paths(report: &mut Report, peer: Option<&Peer>) -> Result<()> {
    let mesh = cap(104);
    let at = |column: u32, row: u32| 105 * row + column;
    let ends = [at(90, 20), at(85, 84), at(15, 80), at(52, 95), at(97, 50), at(30, 13)];
    // A vertex as a corner of a face that has it.
    let triangles = mesh.corners.as_chunks::<3>().0;
    let place = |vertex: u32| {
        let face = triangles.iter().position(|corners| corners.contains(&vertex)).unwrap_or_default();
        let barycentric = triangles[face].map(|corner| f64::from(u8::from(corner == vertex)));
        Place { face: face as u32, barycentric }
    };
    let from = at(12, 15);
    let length = |to: &u32| -> Result<f64> {
        let path = shortest_path(&mesh, [place(from), place(*to)])?;
        let step = |pair: &[[f64; 3]]| (0..3).map(|axis| (pair[1][axis] - pair[0][axis]).powi(2)).sum::<f64>().sqrt();
        Ok(path.windows(2).map(step).sum())
    };
    let lengths = ends.iter().map(length).collect::<Result<Vec<f64>>>()?;
    let name = format!("{} geodesics on a cap of {} triangles", ends.len(), mesh.face_count());
    let Some(peer) = peer else {
        report.skip(&name, "there is no potpourri3d beside it");
        return Ok(());
    };
    let pins: String = [from].iter().chain(&ends).map(|vertex| format!("{vertex} 0 0\n")).collect();
    match mapped(peer, &((mesh.points.clone(), triangles.to_vec()), pins)) {
        Ok((plane, _)) => {
            let other = |end: &u32| f64::from(plane.0[*end as usize][0]);
            let far = ends.iter().zip(&lengths).map(|(end, length)| (other(end) / length - 1.0).abs());
            let far = one(far.fold(0.0, f64::max));
            report.add(
                &format!("{name}: difference from {}", peer.name),
                &far,
                None,
                "of the length",
                Goal::AtMost(1e-4),
            );
        }
        Err(error) => report.skip(&name, &error.to_string()),
    }
    Ok(())
}

/// Squares along each side of the caps that stickers are laid on by a process each, to see what memory it takes.
const SIDES: [u32; 2] = [224, 310];

/// Bytes for each triangle of the patch at the peak, the mesh included that the decal keeps: by how much the process grows, and by
/// how much where the allocator gives large blocks back that are freed (glibc keeps some of them).
fn bytes(report: &mut Report) {
    for (row, side) in SIDES.into_iter().enumerate() {
        let name = format!("peak memory, 6 pins on a cap of {} triangles", 2 * side * side);
        let process = || anew("sticker", "--row", &row.to_string());
        let grown = process().and_then(|mut process| printed(&mut process));
        let alive = process().and_then(|mut process| printed(process.env("MALLOC_MMAP_THRESHOLD_", "65536")));
        for (name, bytes) in [(name.clone(), grown), (format!("{name}: without freed blocks"), alive)] {
            match bytes {
                Some(bytes) => report.add(&name, &one(bytes), None, "bytes a triangle", Goal::AtMost(400.0)),
                None => report.skip(&name, "the system does not tell it"),
            }
        }
    }
    let name = "OpenMesh's half-edges of a patch";
    let structure = anew("sticker", "--row", &SIDES.len().to_string());
    match structure.and_then(|mut process| printed(process.env("MALLOC_MMAP_THRESHOLD_", "65536"))) {
        Some(bytes) => report.add(name, &one(bytes), None, "bytes a triangle", Goal::None),
        None => report.skip(name, "the system does not tell it"),
    }
}

/// Prints how many bytes for each triangle OpenMesh's structure of the first cap takes.
fn structure() -> Result<()> {
    let (small, mesh) = (cap(28), cap(SIDES[0]));
    Patch::new(&small.points, small.corners.as_chunks().0)?;
    let before = memory("VmRSS");
    let patch = Patch::new(&mesh.points, mesh.corners.as_chunks().0)?;
    if let Some((after, before)) = memory("VmRSS").zip(before) {
        println!("{}", (after - before) / patch.face_count() as f64);
    }
    Ok(())
}

/// Lays the sticker of a row of [`bytes`] and prints by how many bytes the process grew, for each triangle of the patch. The row
/// after the last one is that of OpenMesh's structure.
pub fn peak(row: usize) -> Result<()> {
    if row == SIDES.len() {
        return structure();
    }
    let Some(side) = SIDES.get(row) else { return Err(Error::invalid(format!("there is no row {row}"))) };
    // The pages of the program itself are read at first use, as many at a time as the system likes.
    let small = cap(28);
    lay(&small, &whole()?, &pins(&small, 2.5)?, None, &DecalSettings::default(), &mut Silent)?;
    let mesh = cap(*side);
    let pins = pins(&mesh, 2.5)?;
    let (sticker, before) = (whole()?, memory("VmRSS"));
    let placed = Placement::new(&mesh, &sticker, &pins, None, &DecalSettings::default(), &mut Silent)?;
    if let Some((peak, before)) = memory("VmHWM").zip(before) {
        println!("{}", (peak - before) / placed.decal().quality.triangles as f64);
    }
    Ok(())
}

/// A sticker over most of the upper half of a ball with bumps, by 9 pins, and by the exponential map around its middle.
fn around(report: &mut Report) -> Result<()> {
    let on = |x: f64, y: f64| -> [f64; 3] {
        // The azimuthal equidistant map of the plane, whose unit circle is the equator.
        let (radius, turn) = (x.hypot(y), y.atan2(x));
        let polar = std::f64::consts::FRAC_PI_2 * radius;
        let bump = 1.0 + 0.08 * (6.0 * x).sin() * (6.0 * y).cos();
        [polar.sin() * turn.cos(), polar.sin() * turn.sin(), polar.cos()].map(|value| bump * value)
    };
    let mut mesh = cap(150);
    for point in &mut mesh.points {
        let [x, y, _] = point.map(f64::from);
        *point = on(1.3 * x, 1.3 * y).map(|value| value as f32);
    }
    let pin = |index: usize| -> Result<Pin> {
        let place = [index % 3, index / 3].map(|at| 20.0 + 30.0 * at as f64);
        let [x, y] = place.map(|value| 1.3 * (value / PIXELS - 0.5));
        Ok(Pin { image: place, place: nearest(&mesh, on(x, y))?.0 })
    };
    let pins = (0..9).map(pin).collect::<Result<Vec<_>>>()?;
    let decal = lay(&mesh, &whole()?, &pins, None, &DecalSettings::default(), &mut Silent)?;
    let pose = Pose { width: 1.3 * std::f64::consts::FRAC_PI_2, up: [0.0, 1.0, 0.0] };
    let single = one(exponential(&mesh, &whole()?, &pins[4], pose)?.quality.l2);
    let name = format!("L2 stretch over most of half a bumpy ball, {} pins", pins.len());
    report.add(&name, &one(decal.quality.l2), Some(("one centre", &single)), "", Goal::AtMost(1.25));
    Ok(())
}

/// A thousand stickers around one point each on a cap of 100,000 triangles.
fn small(report: &mut Report) -> Result<()> {
    let mesh = cap(224);
    let sticker = whole()?;
    let context = Context::new(&ContextOptions { threads: 2, memory_limit: 0 })?;
    let up = [0.0, 1.0, 0.0];
    let settings = Scatter { density: 170.0, width: [0.04, 0.06], up, turn: 3.0, seed: 1 };
    let count = scatter(&context, &mesh, &sticker, &settings)?.len();
    let time = sample(RUNS, || seconds(|| scatter(&context, &mesh, &sticker, &settings)));
    let thousand = Sample::new(vec![time.median() * 1000.0 / count.max(1) as f64]);
    report.add(&format!("1,000 one-point decals, of {count} scattered"), &thousand, None, "s", Goal::AtMost(2.0));
    Ok(())
}
