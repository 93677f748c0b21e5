//! Rings that a graphics device makes against the processor's.

use std::sync::Arc;

use glam::Vec4;
use half::f16;
use relievo_core::{Context, Mesh};
use relievo_gpu::{Buffer, Device};
use relievo_surface::{Surface, SurfaceOptions, TileTopology};
use relievo_testing::{Random, cage, device, grid};
use relievo_tiles::{
    Channel, ChannelOptions, DeviceMips, DeviceRing, DeviceTiles, Displacement, Paint, Rgba8, Rgba16, Sets, Texel,
    Vector, VectorDisplacement,
};

/// Texels of the last edits' whole rows, as an editor has them before anything is settled.
fn scrawl<T: Texel>(
    context: &Context,
    channel: &mut Channel<T>,
    random: &mut Random,
    make: impl Fn(&mut Random) -> T + Sync,
) -> Vec<(u32, Vec<T>)> {
    let usable: Vec<u32> =
        (0..channel.field().tile_count() as u32).filter(|tile| !channel.field().topology().is_hole(*tile)).collect();
    let mut tiles: Vec<u32> = (0..1 + random.below(4)).map(|_| usable[random.below(usable.len())]).collect();
    tiles.sort_unstable();
    tiles.dedup();
    channel.apply(&Sets { allocate: tiles.clone(), ..Sets::default() }).unwrap();
    tiles.retain(|tile| channel.field().is_allocated(*tile));
    let seed = random.below(1 << 30) as u64;
    let changes = channel.edit(context, &tiles, |tile, texels| {
        let mut random = Random(seed ^ u64::from(tile) << 20);
        for _ in 0..3 {
            let (row, start) = (random.below(texels.size()), random.below(texels.size()));
            texels.row_mut(row)[start..].fill_with(|| make(&mut random));
            texels.row_mut(start)[..row.max(1)].fill_with(|| make(&mut random));
        }
    });
    let written = tiles.iter().map(|tile| (*tile, channel.field().block(*tile).unwrap().to_vec())).collect();
    channel.settle(context, &changes.unwrap()).unwrap();
    written
}

fn words<T: Texel>(texels: &[T]) -> Vec<u32> {
    bytemuck::cast_slice(texels).chunks_exact(4).map(|word| u32::from_le_bytes(word.try_into().unwrap())).collect()
}

/// Edits that reach the device as what was written alone, with `apart` of two texels at most 1. Returns how many
/// texels of all differ.
fn follow<T: Texel>(
    device: &Device,
    ring: impl FnOnce(DeviceRing, &Channel<T>) -> DeviceRing,
    mut channel: Channel<T>,
    make: impl Fn(&mut Random) -> T + Sync,
    apart: impl Fn(T, T) -> f32,
) -> (usize, usize) {
    let context = Context::serial();
    let ring = ring(DeviceRing::new(device, channel.field().topology()).unwrap(), &channel);
    let mut tiles = DeviceTiles::new(device, channel.field()).unwrap();
    let mut random = Random(17);
    let (mut differ, mut all) = (0, 0);
    for step in 0..8 {
        let mut written = Vec::new();
        if step == 5 {
            let gone = channel.field().allocated().nth(1).into_iter().collect();
            let applied = channel.apply(&Sets { deallocate: gone, ..Sets::default() }).unwrap();
            channel.settle(&context, &applied.changes).unwrap();
        } else {
            written = scrawl(&context, &mut channel, &mut random, &make);
        }
        let mut from = vec![7; 3];
        let starts: Vec<(u32, u32)> = written
            .iter()
            .map(|(tile, texels)| {
                let first = from.len() as u32;
                from.extend(words(texels));
                (*tile, first)
            })
            .collect();
        let from = Buffer::of(device, "written", &from).unwrap();
        let changed = channel.field().differing(tiles.field());
        assert_eq!(tiles.follow(device, &ring, channel.field(), (&starts, &from)).unwrap(), changed);
        for (tile, block) in tiles.read_back(device).unwrap() {
            for (at, (ours, theirs)) in block.iter().zip(channel.field().block(tile).unwrap()).enumerate() {
                all += 1;
                differ += usize::from(!ours.same(*theirs));
                let far = apart(*ours, *theirs);
                assert!(far <= 1.0, "step {step}, texel {at} of tile {tile}: {ours:?} {theirs:?}");
            }
        }
        assert!(tiles.update(device, channel.field()).unwrap().is_empty());
    }
    (differ, all)
}

fn steps(a: f16, b: f16) -> f32 {
    let ordered = |half: f16| {
        let bits = half.to_bits();
        f32::from(bits & 0x7fff) * if bits >> 15 == 1 { -1.0 } else { 1.0 }
    };
    (ordered(a) - ordered(b)).abs()
}

/// Faces of all kinds and sizes, some wound against the others, holes, and a fin.
fn meshes() -> Vec<(Mesh, ChannelOptions)> {
    let mut made = Vec::new();
    let mixed = [2, 3, 0, 0x32, 1, 0x71, 2, 0x30, 5, 9];
    for (torus, reversed) in [(true, true), (false, true), (true, false)] {
        let mut mesh = grid(5, torus, &mixed, reversed);
        mesh.holes.push(4);
        // A third face at an edge.
        let new = mesh.points.len() as u32;
        mesh.points.extend([[9.0, 0.0, 1.0], [9.0, 0.0, 2.0]]);
        mesh.face_sizes.push(4);
        let [a, b] = [mesh.corners[8], mesh.corners[9]];
        mesh.corners.extend([a, b, new, new + 1]);
        let sizes = vec![(0, 64), (3, 8), (7, 32), (8, 128), (12, 8), (13, 64)];
        let even = ChannelOptions { size: 16, ..Default::default() };
        let uneven = ChannelOptions { size: 16, face_sizes: sizes, ..Default::default() };
        let tight = ChannelOptions { budget: 20_000, ..uneven.clone() };
        made.extend([even, uneven, tight].map(|options| (mesh.clone(), options)));
    }
    made.insert(0, (grid(4, false, &[2], false), ChannelOptions { size: 32, ..Default::default() }));
    // A fan of 60 quads round a point, and a face of 120 corners on its other side.
    let circle = (0..120).map(|k| f32::to_radians(3.0 * k as f32)).map(|angle| [angle.cos(), angle.sin(), 0.0]);
    let points = std::iter::once([0.0, 0.0, 1.0]).chain(circle).collect();
    let fan = (0..60).flat_map(|k| [0, 1 + 2 * k, 2 + 2 * k, 1 + (2 * k + 2) % 120]);
    let mesh = Mesh::new(points, [vec![4; 60], vec![120]].concat(), fan.chain((1..=120).rev()).collect());
    let options = ChannelOptions { size: 16, face_sizes: vec![(3, 64), (60, 128)], ..Default::default() };
    made.push((mesh, options));
    if let Some(mesh) = cage("rabbit.obj") {
        made.push((mesh, ChannelOptions { size: 16, face_sizes: vec![(7, 64), (30, 8)], budget: 1 << 20 }));
    }
    made
}

fn tiles_of(mesh: &Mesh) -> Arc<TileTopology> {
    Arc::new(TileTopology::new(mesh).unwrap())
}

#[test]
fn rings_of_a_device_are_those_of_the_processor() {
    let Some(device) = device() else { return };
    for (mesh, options) in meshes() {
        let displacement = Displacement::new(tiles_of(&mesh), &options).unwrap();
        let make = |random: &mut Random| f16::from_f32(random.unit() - 0.75);
        let (differ, all) = follow(&device, |ring, _| ring, displacement, make, steps);
        println!("{differ} of {all} coefficients differ");
        assert_eq!(differ, 0);
    }
}

#[test]
fn rings_of_vectors_are_those_of_the_processor() {
    let Some(device) = device() else { return };
    let context = Context::serial();
    let mut of_all = [0; 2];
    for (mut mesh, options) in meshes() {
        // No angle between the sides of a face is right, and none like another.
        for point in &mut mesh.points {
            let [x, y, z] = *point;
            *point = [x + 0.3 * y, y + 0.2 * (1.7 * x).sin(), z + 0.25 * (x - 1.3 * y).cos()];
        }
        let surface = Surface::new(&context, &mesh, &SurfaceOptions::default()).unwrap();
        let vectors = VectorDisplacement::on(&surface, &options).unwrap();
        let make = |random: &mut Random| Vector([0; 3].map(|_| f16::from_f32(random.unit() - 0.6)));
        // Between tiles of different density what is left of two numbers is as exact as they were.
        let apart = |a: Vector, b: Vector| {
            let far = |k: usize| (a.0[k].to_f32() - b.0[k].to_f32()).abs() * 4194304.0;
            (0..3).map(|k| far(k).min(steps(a.0[k], b.0[k]))).fold(0.0, f32::max)
        };
        let even = options.face_sizes.is_empty();
        let framed = |ring: DeviceRing, vectors: &VectorDisplacement| {
            assert!(!ring.is_of(vectors.field()));
            let mut ring = ring.framed(&device, vectors.field()).unwrap();
            ring.turn(&context, &device, 0..vectors.field().tile_count() as u32).unwrap();
            assert!(ring.is_of(vectors.field()));
            ring
        };
        let (differ, all) = follow(&device, framed, vectors, make, apart);
        println!("{differ} of {all} vectors differ");
        assert!(!even || differ == 0);
        of_all = [of_all[0] + differ, of_all[1] + all];
    }
    assert!(of_all[0] * 10_000 < of_all[1], "{of_all:?}");
}

/// The mips of edited colours, made on the device after each edit. Returns how many texels differ, and all.
fn mips<T: Texel>(
    device: &Device,
    mut channel: Channel<T>,
    make: impl Fn(&mut Random) -> T + Sync,
    far: impl Fn(T, T) -> f32,
    most: f32,
) -> (usize, usize) {
    let context = Context::serial();
    let ring = DeviceRing::new(device, channel.field().topology()).unwrap();
    let mut tiles = DeviceTiles::new(device, channel.field()).unwrap();
    let mut mips = DeviceMips::new(device, &ring, &tiles).unwrap();
    let mut random = Random(23);
    let (mut differ, mut all) = (0, 0);
    for step in 0..5 {
        if step == 3 {
            let gone = channel.field().allocated().nth(1).into_iter().collect();
            let applied = channel.apply(&Sets { deallocate: gone, ..Sets::default() }).unwrap();
            channel.settle(&context, &applied.changes).unwrap();
        } else {
            scrawl(&context, &mut channel, &mut random, &make);
        }
        tiles.update(device, channel.field()).unwrap();
        mips.update(device, &ring, &tiles).unwrap();
        let there = mips.read_back(device).unwrap();
        assert_eq!(there.len(), channel.field().allocated().count());
        for (tile, texels) in there {
            let levels = 1..=channel.field().class(tile).mips();
            let expected = levels.flat_map(|level| channel.field().level(tile, level).unwrap().to_vec());
            for (at, (ours, theirs)) in texels.iter().zip(expected).enumerate() {
                all += 1;
                differ += usize::from(!ours.same(theirs));
                assert!(far(*ours, theirs) <= most, "step {step}, texel {at} of tile {tile}: {ours:?} {theirs:?}");
            }
        }
    }
    (differ, all)
}

/// Makes a colour of any bytes.
fn any_bytes(random: &mut Random) -> Rgba8 {
    Rgba8([(); 4].map(|()| random.below(256) as u8))
}

/// Returns the largest difference of the bytes of two colours.
fn bytes_apart(a: Rgba8, b: Rgba8) -> f32 {
    (0..4).map(|i| f32::from(a.0[i].abs_diff(b.0[i]))).fold(0.0, f32::max)
}

#[test]
fn mips_of_a_device_are_those_of_the_processor() {
    let Some(device) = device() else { return };
    for (mesh, options) in meshes().into_iter().take(4) {
        let topology = tiles_of(&mesh);
        let blank = Vec4::new(0.5, 0.03, 1.0, 1.0);
        let paint = Paint::<Rgba8>::of_color(topology.clone(), blank, &options).unwrap();
        let (differ, all) = mips(&device, paint, any_bytes, bytes_apart, 1.0);
        println!("{differ} of {all} colours of mips differ");
        assert!(differ * 1000 < all);
        let half = |random: &mut Random| f16::from_f32(3.0 * random.unit());
        let make = |random: &mut Random| Rgba16([half(random), half(random), half(random), half(random)]);
        let far = |a: Rgba16, b: Rgba16| (0..4).map(|i| steps(a.0[i], b.0[i])).fold(0.0, f32::max);
        let paint = Paint::<Rgba16>::of_color(topology, blank, &options).unwrap();
        let (differ, all) = mips(&device, paint, make, far, 1.0);
        println!("{differ} of {all} colours of mips of half floats differ");
        assert!(differ * 1000 < all);
    }
}

#[test]
fn rings_of_colors_are_those_of_the_processor() {
    let Some(device) = device() else { return };
    for (mesh, options) in meshes().into_iter().take(3) {
        let topology = tiles_of(&mesh);
        let blank = Vec4::new(0.5, 0.03, 1.0, 1.0);
        let paint = Paint::<Rgba8>::of_color(topology.clone(), blank, &options).unwrap();
        let (differ, all) = follow(&device, |ring, _| ring, paint, any_bytes, bytes_apart);
        println!("{differ} of {all} colours differ");
        assert!(differ * 1000 < all);
        let half = |random: &mut Random| f16::from_f32(3.0 * random.unit());
        let make = |random: &mut Random| Rgba16([half(random), half(random), half(random), half(random)]);
        let far = |a: Rgba16, b: Rgba16| (0..4).map(|i| steps(a.0[i], b.0[i])).fold(0.0, f32::max);
        let paint = Paint::<Rgba16>::of_color(topology, blank, &options).unwrap();
        let (differ, all) = follow(&device, |ring, _| ring, paint, make, far);
        println!("{differ} of {all} colours of half floats differ");
        assert!(differ * 1000 < all);
    }
}
