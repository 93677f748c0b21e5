//! Paging against a channel without a budget: whatever is edited, read, undone or sized anew, both hold the same to the
//! bit, and the budget holds after every edit.

use std::cell::Cell;
use std::fmt::Debug;
use std::sync::Arc;
use std::sync::atomic::Ordering;

use glam::Vec4;
use half::f16;
use proptest::prelude::*;
use proptest::test_runner::TestRunner;
use relievo_core::{Context, ContextOptions, Error, Mesh, Result};
use relievo_document::{Document, PageFile, PageStore};
use relievo_surface::{Surface, SurfaceOptions, TileTopology};
use relievo_testing::{Random, grid};
use relievo_tiles::{
    Channel, ChannelOptions, Displacement, Field, Rgba8, Rgba16, Sets, Snapshot, StoredTexel, Traces, Vector,
    VectorDisplacement,
};

use crate::support::Faulty;

const UNLIMITED: u64 = 1 << 40;

/// A channel that pages, and one that need not.
struct Pair<T> {
    paging: Channel<T>,
    model: Channel<T>,
    store: PageFile,
}

impl<T: StoredTexel + Debug> Pair<T> {
    fn new(channel: Channel<T>, budget: u64) -> Self {
        let (mut paging, store) = (channel.clone(), PageFile::new(None));
        paging.page_to(Some(Arc::new(store.clone()))).unwrap();
        paging.set_budget(budget);
        Self { paging, model: channel, store }
    }

    fn both(&mut self, mut work: impl FnMut(&mut Channel<T>)) {
        work(&mut self.paging);
        work(&mut self.model);
    }

    /// The budget holds, and every tile is either in the heap or on a page.
    fn check_memory(&self) {
        let Self { paging, model, .. } = self;
        assert!(paging.resident_bytes() <= paging.budget(), "{} of {}", paging.resident_bytes(), paging.budget());
        let field = paging.field();
        let here: u64 =
            field.allocated().filter(|tile| !paging.is_paged(*tile)).map(|tile| field.tile_bytes(tile)).sum();
        assert_eq!(paging.bytes(), here);
        assert_eq!(paging.paged_count(), field.allocated().filter(|tile| paging.is_paged(*tile)).count());
        assert_eq!(paging.allocated_count(), model.allocated_count());
        assert!(field.allocated().eq(model.field().allocated()));
    }

    fn check_texels(&self) {
        same(self.paging.field(), self.model.field());
    }
}

fn same<T: StoredTexel>(a: &Field<T>, b: &Field<T>) {
    for tile in 0..b.tile_count() as u32 {
        assert_eq!(a.size(tile), b.size(tile), "{tile}");
        for level in 0..8 {
            let [a, b] = [a, b].map(|field| field.level(tile, level).map(bytemuck::cast_slice::<T, u8>));
            assert!(a == b, "tile {tile}, level {level}");
        }
    }
}

/// One edit at random, as dabs make them. Returns the number of tiles that were refused.
fn edit<T: StoredTexel>(
    context: &Context,
    channel: &mut Channel<T>,
    random: &mut Random,
    most: usize,
    texel: &(impl Fn(f32) -> T + Sync),
) -> usize {
    let count = channel.field().tile_count();
    let tiles: Vec<u32> = (0..1 + random.below(most)).map(|_| random.below(count) as u32).collect();
    let mut tiles: Vec<u32> = tiles.into_iter().filter(|tile| !channel.field().topology().is_hole(*tile)).collect();
    tiles.sort_unstable();
    tiles.dedup();
    let (seed, blank) = (random.below(1 << 30) as u64, channel.field().blank());
    let allocate = tiles.iter().copied().filter(|tile| !channel.field().is_allocated(*tile)).collect();
    let mut applied = channel.apply(&Sets { allocate, modify: tiles.clone(), ..Sets::default() }).unwrap();
    tiles.retain(|tile| !applied.refused.contains(tile));
    let changes = channel.edit(context, &tiles, |tile, texels| {
        let mut random = Random(seed ^ u64::from(tile) << 20 | 1);
        for _ in 0..1 + random.below(4) {
            let (row, erase) = (random.below(texels.size()), random.below(3) == 0);
            texels.row_mut(row).fill_with(|| if erase { blank } else { texel(random.unit()) });
        }
    });
    applied.changes.extend(changes.unwrap());
    applied.refused.len() + channel.settle(context, &applied.changes).unwrap().len()
}

fn run<T: StoredTexel + Debug>(
    channel: Channel<T>,
    seed: u64,
    threads: usize,
    texel: impl Fn(f32) -> T + Sync,
) -> Vec<Vec<u32>> {
    let context = Context::new(&ContextOptions { threads, memory_limit: 0 }).unwrap();
    let largest = (0..channel.field().tile_count() as u32).map(|tile| channel.field().tile_bytes(tile)).max().unwrap();
    let random = &mut Random(seed | 1);
    let mut pair = Pair::new(channel, largest * (18 + random.below(6) as u64));
    let (mut undo, mut snapshots, mut paged): (Vec<Vec<(u32, Option<Vec<u8>>)>>, Vec<[Arc<Snapshot<T>>; 2]>, _) =
        (Vec::new(), Vec::new(), Vec::new());
    for step in 0..50 {
        let state = random.below(1 << 30) as u64;
        match if step < 16 { 7 } else { random.below(8) } {
            0 => {
                // Readers look here and there.
                let count = pair.model.field().tile_count();
                for _ in 0..random.below(12) {
                    let tile = random.below(count) as u32;
                    let [a, b] = [&pair.paging, &pair.model].map(|channel| channel.read(tile).unwrap_or_default());
                    assert_eq!(a, b, "{tile}");
                }
                pair.paging.commit();
                pair.model.commit();
            }
            1 => {
                let tiles: Vec<u32> = pair
                    .model
                    .field()
                    .allocated()
                    .filter(|tile| (u64::from(*tile) ^ state).is_multiple_of(5))
                    .collect();
                pair.both(|channel| {
                    let applied = channel.apply(&Sets { deallocate: tiles.clone(), ..Sets::default() }).unwrap();
                    channel.update_rings(&context, &applied.changes).unwrap();
                    let all: Vec<u32> = channel.field().allocated().collect();
                    channel.reclaim(&context, &all).unwrap();
                });
            }
            2 => snapshots.push([pair.paging.commit(), pair.model.commit()]),
            3 if !undo.is_empty() => {
                // Every tile that changed is put back.
                let back = undo.swap_remove(random.below(undo.len()));
                pair.both(|channel| {
                    back.iter().for_each(|(tile, bytes)| channel.write(*tile, bytes.as_deref()).unwrap())
                });
                pair.both(|channel| channel.update_mips(&context));
                pair.both(|channel| drop(channel.commit()));
            }
            4 if step % 3 == 0 => {
                let face = random.below(pair.model.field().topology().face_count()) as u32;
                let size = 8 << random.below(2);
                pair.both(|channel| assert!(channel.resize(&context, &[(face, size)]).unwrap().is_empty()));
                undo.clear();
            }
            _ => {
                let before = [pair.paging.field().clone(), pair.model.field().clone()];
                pair.both(|channel| assert_eq!(edit(&context, channel, &mut Random(state | 1), 2, &texel), 0));
                let differing = pair.model.field().differing(&before[1]);
                let bytes = |tile: &u32| before[1].block(*tile).map(|block| bytemuck::cast_slice(block).to_vec());
                undo.push(differing.iter().map(|tile| (*tile, bytes(tile))).collect());
                assert_eq!(pair.paging.field().differing(&before[0]), differing);
            }
        }
        pair.check_memory();
        if step % 10 == 9 {
            pair.check_texels();
            // What that brought back goes at the next commit.
            pair.both(|channel| drop(channel.commit()));
            pair.check_memory();
        }
        paged.push(pair.paging.field().allocated().filter(|tile| pair.paging.is_paged(*tile)).collect());
    }
    snapshots.iter().for_each(|[a, b]| same(a.field(), b.field()));
    drop(snapshots);
    // All that is erased is given back: to the heap, and to the file.
    let all: Vec<u32> = pair.model.field().allocated().collect();
    pair.both(|channel| drop(channel.apply(&Sets { deallocate: all.clone(), ..Sets::default() }).unwrap()));
    pair.check_memory();
    assert_eq!((pair.paging.bytes(), pair.paging.paged_count(), pair.paging.allocated_count()), (0, 0, 0));
    assert_eq!((pair.store.pages(), pair.store.bytes()), (0, 0));
    paged
}

fn options(faces: u32, random: &mut Random) -> ChannelOptions {
    let sizes = (0..faces).map(|face| (face, 8 << random.below(2)));
    ChannelOptions { size: 8, face_sizes: sizes.collect(), budget: UNLIMITED }
}

#[test]
fn paging_is_seen_by_memory_alone() {
    let cases = (prop::collection::vec(any::<u8>(), 1..40), any::<u64>());
    let mut paging = Cell::new(0);
    let ran = TestRunner::new(ProptestConfig::with_cases(16)).run(&cases, |(choices, seed)| {
        let mut mesh = grid(10, false, &choices, false);
        mesh.holes.push(3);
        let surface = Surface::new(&Context::serial(), &mesh, &SurfaceOptions::default()).unwrap();
        let topology = surface.topology().clone();
        let random = &mut Random(seed | 1);
        let options = options(topology.face_count() as u32, random);
        let displacement = Displacement::new(topology.clone(), &options).unwrap();
        let one = run(displacement.clone(), seed, 1, |x| f16::from_f32(x - 0.5));
        // The same tiles are on pages for any number of threads.
        prop_assert_eq!(&one, &run(displacement.clone(), seed, 3, |x| f16::from_f32(x - 0.5)));
        paging.set(paging.get() + usize::from(one.iter().any(|paged| !paged.is_empty())));
        let grey = Vec4::new(0.5, 0.5, 0.5, 1.0);
        let paint = Channel::<Rgba8>::of_color(topology.clone(), grey, &options).unwrap();
        run(paint, seed, 1, |x| Rgba8([(255.0 * x) as u8, 3, 9, 255]));
        let light = Channel::<Rgba16>::of_color(topology.clone(), grey, &options).unwrap();
        run(light, seed, 1, |x| Rgba16([f16::from_f32(x * 9.0); 4]));
        let vectors = VectorDisplacement::on(&surface, &options).unwrap();
        run(vectors, seed, 1, |x| Vector([x, 0.5 - x, 0.25].map(f16::from_f32)));
        let traces = Traces::of(displacement.field(), UNLIMITED).unwrap();
        run(traces, seed, 1, |x| relievo_tiles::Trace::default().pushed(x, 3.0));
        Ok(())
    });
    ran.unwrap();
    // Where faces are small and hardly any was edited, the budget may be enough.
    assert!(*paging.get_mut() >= 12, "{paging:?}");
}

fn square(size: u32) -> Mesh {
    grid(size, false, &[2], false)
}

/// A displacement over 8 by 8 quads that has been pushed all over and has room for `room` tiles.
fn pushed(room: u64, store: Arc<dyn PageStore>) -> Displacement {
    let topology = Arc::new(TileTopology::new(&square(8)).unwrap());
    let options = ChannelOptions { size: 8, budget: UNLIMITED, ..ChannelOptions::default() };
    let mut channel = Displacement::new(topology, &options).unwrap();
    let tiles: Vec<u32> = (0..channel.field().tile_count() as u32).collect();
    channel.apply(&Sets { allocate: tiles.clone(), ..Sets::default() }).unwrap();
    for tile in &tiles {
        let changes = channel.edit(&Context::serial(), &[*tile], |tile, texels| {
            (0..8).for_each(|row| texels.row_mut(row).fill(f16::from_f32(1.0 + tile as f32)));
        });
        channel.update_rings(&Context::serial(), &changes.unwrap()).unwrap();
    }
    channel.page_to(Some(store)).unwrap();
    channel.set_budget(room * channel.field().tile_bytes(0));
    channel
}

fn push(channel: &mut Displacement, tile: u32) -> Result<Vec<u32>> {
    let context = Context::serial();
    let mut applied = channel.apply(&Sets { allocate: vec![tile], ..Sets::default() })?;
    if applied.refused.is_empty() {
        applied.changes.extend(channel.edit(&context, &[tile], |_, texels| texels.row_mut(3).fill(f16::NEG_ONE))?);
    }
    applied.refused.extend(channel.settle(&context, &applied.changes)?);
    Ok(applied.refused)
}

#[test]
fn the_blocks_edited_longest_ago_go_first() {
    let mut channel = pushed(40, Arc::new(PageFile::new(None)));
    let versions = |channel: &Displacement, paged: bool| {
        let tiles = channel.field().allocated().filter(|tile| channel.is_paged(*tile) == paged);
        tiles.map(|tile| (channel.field().version(tile), tile)).collect::<Vec<_>>()
    };
    assert_eq!(channel.paged_count(), 24);
    assert!(versions(&channel, true).iter().max() < versions(&channel, false).iter().min());
    // A tile that was read only is still the oldest; one that was edited is the newest.
    let oldest = versions(&channel, true).iter().min().unwrap().1;
    assert!(channel.read(oldest).unwrap().is_some());
    channel.commit();
    assert!(channel.is_paged(oldest));
    push(&mut channel, oldest).unwrap();
    assert!(!channel.is_paged(oldest));
    assert!(versions(&channel, true).iter().max() < versions(&channel, false).iter().min());
}

#[test]
fn what_does_not_fit_together_is_refused_and_tiles_that_are_there_never_are() {
    let topology = Arc::new(TileTopology::new(&square(8)).unwrap());
    let mut channel = Displacement::new(topology, &ChannelOptions { size: 8, ..ChannelOptions::default() }).unwrap();
    channel.page_to(Some(Arc::new(PageFile::new(None)))).unwrap();
    channel.set_budget(12 * channel.field().tile_bytes(0));
    let all: Vec<u32> = (0..64).collect();
    let applied = channel.apply(&Sets { allocate: all.clone(), ..Sets::default() }).unwrap();
    assert_eq!(applied.refused, all[12..]);
    let applied = channel.apply(&Sets { allocate: all[12..20].to_vec(), ..Sets::default() }).unwrap();
    assert_eq!((applied.refused, channel.paged_count()), (Vec::new(), 8));
    // With the twelve of the edit that are there already none is left.
    let applied = channel.apply(&Sets { allocate: vec![30], modify: all[..12].to_vec(), ..Sets::default() }).unwrap();
    assert_eq!((applied.refused, channel.paged_count()), (vec![30], 8));
    let changes = channel.edit(&Context::serial(), &all[..20], |_, texels| texels.row_mut(3).fill(f16::ONE)).unwrap();
    assert_eq!(changes.len(), 20);
    channel.update_rings(&Context::serial(), &changes).unwrap();
    assert!(channel.resident_bytes() <= channel.budget());
    assert!((0..20).all(|tile| channel.field().block(tile).unwrap()[4 * 10 + 5] == f16::ONE));
    // A budget that holds no tile.
    channel.set_budget(100);
    assert_eq!((channel.bytes(), channel.paged_count()), (0, 20));
    assert_eq!(channel.apply(&Sets { allocate: vec![40], ..Sets::default() }).unwrap().refused, [40]);
}

#[test]
fn what_cannot_be_read_back_is_blank_to_readers_and_an_error_to_the_next_edit() {
    let store = Arc::new(Faulty::default());
    let mut channel = pushed(40, store.clone());
    let (good, snapshot) = (pushed(64, store.clone()), channel.commit());
    let paged: Vec<u32> = channel.field().allocated().filter(|tile| channel.is_paged(*tile)).collect();
    store.broken.store(true, Ordering::SeqCst);
    let tile = paged[3];
    assert!(channel.field().block(tile).unwrap().iter().all(|c| *c == f16::ZERO));
    let named = |error: Error| assert!(error.to_string().contains(&format!("tile {tile}")), "{error}");
    // Told once to whoever edits anything, and always to whoever wants the tile itself.
    named(push(&mut channel, 63).unwrap_err());
    assert_eq!(push(&mut channel, 63).unwrap(), [0u32; 0]);
    named(push(&mut channel, tile).unwrap_err());
    named(channel.read(tile).unwrap_err());
    let mut document = Document::new(&square(8), "").unwrap();
    assert!(channel.field().store(&Context::serial(), &mut document, "heights").is_err());
    assert!(document.layers().is_empty());
    assert_eq!(channel.reclaim(&Context::serial(), &[tile]).unwrap_or_default(), [0u32; 0]);
    // A disk that is there again.
    store.broken.store(false, Ordering::SeqCst);
    drop(channel.report_fault());
    channel.commit();
    channel.report_fault().unwrap();
    assert_eq!(channel.field().block(tile), good.field().block(tile));
    drop(snapshot);
    // A page that is lost can be erased, or written anew.
    channel.commit();
    store.broken.store(true, Ordering::SeqCst);
    channel.write(tile, Some(bytemuck::cast_slice(good.field().block(paged[4]).unwrap()))).unwrap();
    assert_eq!(channel.field().block(tile), good.field().block(paged[4]));
    channel.write(paged[5], None).unwrap();
    assert!(!channel.field().is_allocated(paged[5]));
}

#[test]
fn where_there_is_no_room_for_pages_nothing_is_lost() {
    let store = Arc::new(Faulty::default());
    let mut channel = pushed(64, store.clone());
    let good = channel.clone();
    store.full.store(true, Ordering::SeqCst);
    channel.set_budget(40 * channel.field().tile_bytes(0));
    assert!(channel.report_fault().unwrap_err().to_string().contains("no room"));
    same(channel.field(), good.field());
    assert_eq!(channel.paged_count(), 0);
    store.full.store(false, Ordering::SeqCst);
    channel.commit();
    assert_eq!(channel.paged_count(), 24);
    same(channel.field(), good.field());
}

#[test]
fn readers_that_look_at_once_read_a_page_once() {
    let store = Arc::new(Faulty::default());
    let mut channel = pushed(16, store.clone());
    let (good, snapshot) = (pushed(64, store.clone()), channel.commit());
    let before = store.loads.load(Ordering::SeqCst);
    std::thread::scope(|scope| {
        for start in 0..8 {
            let (good, snapshot) = (&good, &snapshot);
            scope.spawn(move || {
                for k in 0..64 {
                    let tile = (start * 8 + k) % 64;
                    assert_eq!(snapshot.block(tile), good.field().block(tile));
                }
            });
        }
        // Edits go on meanwhile.
        (0..64).for_each(|tile| assert_eq!(push(&mut channel, tile).unwrap(), [0u32; 0]));
    });
    assert!(store.loads.load(Ordering::SeqCst) - before <= 48 + 64 * 9, "{before}");
    let before = store.loads.load(Ordering::SeqCst);
    same(snapshot.field(), good.field());
    assert_eq!(store.loads.load(Ordering::SeqCst), before);
}

#[test]
fn comparing_reads_no_pages() {
    let store = Arc::new(Faulty::default());
    let mut channel = pushed(64, store.clone());
    let before = channel.commit();
    channel.set_budget(10 * channel.field().tile_bytes(0));
    let between = channel.commit();
    assert_eq!(channel.field().differing(before.field()), [0u32; 0]);
    assert_eq!(store.loads.load(Ordering::SeqCst), 0);
    let field = channel.field().clone();
    push(&mut channel, 20).unwrap();
    let changed = channel.field().differing(&field);
    let loads = store.loads.load(Ordering::SeqCst);
    assert!(changed.contains(&20) && changed.len() <= 9 && loads <= 18, "{changed:?}, {loads}");
    assert_eq!(between.field().differing(before.field()), [0u32; 0]);
    assert_eq!(store.loads.load(Ordering::SeqCst), loads);
    // Ranges of pages are known without reading them.
    let ranges: Vec<[f32; 2]> = (0..64).map(|tile| between.range(tile)).collect();
    assert_eq!(store.loads.load(Ordering::SeqCst), loads);
    assert_eq!(ranges, (0..64).map(|tile| before.range(tile)).collect::<Vec<_>>());
}

#[test]
fn a_document_larger_than_the_budget_stays_in_its_file() {
    let (context, mesh) = (Context::serial(), square(8));
    let good = pushed(64, Arc::new(PageFile::new(None)));
    let mut document = Document::new(&mesh, "").unwrap();
    good.field().store(&context, &mut document, "heights").unwrap();
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a.relievo");
    document.write(&path).unwrap();
    let document = Document::open(&path, 1 << 30).unwrap();
    let (file, topology) = (PageFile::new(Some(folder.path())), Arc::new(TileTopology::new(&mesh).unwrap()));
    let store: Arc<dyn PageStore> = Arc::new(file.clone());
    let budget = 10 * good.field().tile_bytes(0);
    let stored = Channel::<f16>::stored_with(&context, topology.clone(), &document, "heights", budget, Some(&store));
    let mut channel = stored.unwrap().unwrap();
    assert_eq!((channel.paged_count(), channel.bytes(), file.pages()), (54, budget, 0));
    same(channel.field(), good.field());
    let mut again = Document::new(&mesh, "").unwrap();
    channel.field().store(&context, &mut again, "heights").unwrap();
    assert_eq!(again.to_bytes().unwrap(), document.to_bytes().unwrap());
    // Only what is edited needs a page of its own.
    for tile in 0..20 {
        push(&mut channel, tile).unwrap();
    }
    assert!(file.pages() > 0 && file.pages() < 40, "{}", file.pages());
    // The file loses its copies of header and index, and the end of its blocks: tiles are blank and known by name, and
    // nothing panics.
    channel.commit();
    let length = std::fs::metadata(&path).unwrap().len();
    let packed: usize = again.layers()[0].blocks().iter().map(|block| block.packed_bytes()).sum();
    let end = (length + packed as u64) / 2;
    std::fs::OpenOptions::new().write(true).open(&path).unwrap().set_len(end - 3).unwrap();
    assert!(channel.field().block(63).is_some());
    let error = channel.apply(&Sets { allocate: vec![0], ..Sets::default() }).unwrap_err();
    assert!(error.to_string().contains("tile 63"), "{error}");
    // Without pages it is refused.
    let document = Document::parse(&again.to_bytes().unwrap(), 1 << 30).unwrap();
    assert!(Channel::<f16>::stored(&context, topology, &document, "heights", budget).is_err());
}
