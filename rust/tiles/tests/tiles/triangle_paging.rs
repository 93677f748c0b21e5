//! Paging of triangle meshes against channels without a budget: whatever is edited, read, undone, composed or taken
//! away, both hold the same to the bit, and the budget holds after every edit.

use std::borrow::Cow;
use std::cell::Cell;
use std::fmt::Debug;
use std::sync::Arc;
use std::sync::atomic::Ordering;

use glam::Vec4;
use half::f16;
use proptest::prelude::*;
use proptest::test_runner::TestRunner;
use relievo_core::{Context, ContextOptions, Error, Mesh, Result};
use relievo_document::{Document, PageFile, PageStore, Settings};
use relievo_surface::TriangleTopology;
use relievo_testing::{Random, grid};
use relievo_tiles::triangle::{
    Pattern, TriangleBlock, TriangleChannel, TriangleField, TriangleOptions, TriangleSets, TriangleSheet,
    TriangleSnapshot, TriangleValues,
};
use relievo_tiles::{Blocks, Rgba8, StoredTexel, Trace, Vector};

use crate::support::Faulty;

const UNLIMITED: u64 = 1 << 40;
const SEGMENTS: u32 = 16;
/// Values of a face of 16 segments with its edges.
const WHOLE: u64 = 169 + 3 * 15;

fn options(budget: u64) -> TriangleOptions {
    TriangleOptions { segments: SEGMENTS, budget }
}

fn topology(mesh: &Mesh) -> Arc<TriangleTopology> {
    Arc::new(TriangleTopology::of_mesh(mesh).unwrap())
}

fn vertex_bytes<T>(channel: &TriangleChannel<T>) -> u64
where
    T: StoredTexel,
{
    (channel.field().topology().vertex_count() * size_of::<T>()) as u64
}

/// The blocks of faces and edges.
fn elements<T: StoredTexel>(field: &TriangleField<T>) -> Vec<u32> {
    let (topology, faces) = (field.topology(), field.allocated().map(TriangleBlock::Face));
    faces.chain(field.allocated_edges().map(TriangleBlock::Edge)).map(|block| block.number(topology)).collect()
}

fn pattern_of<T: StoredTexel>(field: &TriangleField<T>, block: u32) -> Option<Pattern> {
    match TriangleBlock::of(field.topology(), block) {
        Some(TriangleBlock::Face(face)) => field.face_pattern(face),
        Some(TriangleBlock::Edge(edge)) => field.edge_pattern(edge),
        _ => None,
    }
}

fn same<T: StoredTexel>(a: &TriangleField<T>, b: &TriangleField<T>) {
    for block in 0..TriangleBlock::count(b.topology()) {
        assert_eq!(pattern_of(a, block), pattern_of(b, block), "{block}");
        assert!(a.bytes(block) == b.bytes(block), "block {block}");
    }
}

/// A channel that pages, and one that need not.
struct Pair<T> {
    paging: TriangleChannel<T>,
    model: TriangleChannel<T>,
    store: PageFile,
}

impl<T: StoredTexel + Debug> Pair<T> {
    fn new(channel: TriangleChannel<T>, faces: u64) -> Self {
        let (mut paging, store) = (channel.clone(), PageFile::new(None));
        paging.page_to(Some(Arc::new(store.clone()))).unwrap();
        paging.set_budget(vertex_bytes(&channel) + faces * WHOLE * size_of::<T>() as u64);
        Self { paging, model: channel, store }
    }

    fn both(&mut self, mut work: impl FnMut(&mut TriangleChannel<T>)) {
        work(&mut self.paging);
        work(&mut self.model);
    }

    /// The budget holds, every block is either in the heap or on a page, and a face has its edges.
    fn check_memory(&self) {
        let Self { paging, model, .. } = self;
        assert!(paging.resident_bytes() <= paging.budget(), "{} of {}", paging.resident_bytes(), paging.budget());
        let field = paging.field();
        let (paged, all) = (paging.paged(), elements(field));
        assert!(paged.iter().all(|block| paging.is_paged(*block)));
        let here = all.iter().filter(|block| paged.binary_search(block).is_err());
        let values: usize = here.map(|block| field.bytes(*block).unwrap().len()).sum();
        assert_eq!(paging.bytes(), vertex_bytes(paging) + values as u64);
        assert_eq!(all, elements(model.field()));
        for face in field.allocated() {
            let least = field.face_pattern(face);
            assert!(field.topology().edges_of(face).iter().all(|edge| field.edge_pattern(*edge) >= least));
        }
    }
}

/// One edit at random, as dabs make them.
fn edit<T: StoredTexel>(
    context: &Context,
    channel: &mut TriangleChannel<T>,
    random: &mut Random,
    texel: &impl Fn(f32) -> T,
) {
    let topology = channel.field().topology().clone();
    let mut faces: Vec<u32> = (0..1 + random.below(2)).map(|_| random.below(topology.face_count()) as u32).collect();
    faces.sort_unstable();
    faces.dedup();
    let pattern = Pattern::new([4, 8, 16, 16][random.below(4)]).unwrap();
    let sets = TriangleSets { allocate: faces.clone(), ..Default::default() };
    assert_eq!(channel.apply(context, pattern, &sets).unwrap(), [0u32; 0]);
    let blank = channel.field().blank();
    let mut edges: Vec<u32> = faces.iter().flat_map(|face| topology.edges_of(*face)).collect();
    edges.sort_unstable();
    edges.dedup();
    edges.retain(|_| random.below(3) > 0);
    let mut written = |values: &[T]| {
        let (erase, start) = (random.below(4) == 0, random.below(values.len()));
        let mut values = values.to_vec();
        values[start..].fill_with(|| if erase { blank } else { texel(random.unit()) });
        values
    };
    let field = channel.field();
    let values = TriangleValues {
        faces: faces.iter().map(|face| (*face, written(field.face(*face).unwrap()))).collect(),
        edges: edges.iter().map(|edge| (*edge, written(field.edge(*edge).unwrap()))).collect(),
        vertices: vec![(topology.face(faces[0])[1], texel(0.5))],
    };
    channel.write(values).unwrap();
}

fn run<T: StoredTexel + Debug>(
    channel: TriangleChannel<T>,
    seed: u64,
    threads: usize,
    texel: impl Fn(f32) -> T,
) -> Vec<Vec<u32>> {
    let context = Context::new(&ContextOptions { threads, memory_limit: 0 }).unwrap();
    let random = &mut Random(seed | 1);
    let mut pair = Pair::new(channel, 5 + random.below(4) as u64);
    let (mut undo, mut snapshots, mut paged): (
        Vec<Vec<(u32, Option<Vec<u8>>)>>,
        Vec<[Arc<TriangleSnapshot<T>>; 2]>,
        _,
    ) = (Vec::new(), Vec::new(), Vec::new());
    for step in 0..60 {
        let state = random.below(1 << 30) as u64;
        match if step < 16 { 7 } else { random.below(8) } {
            0 => {
                // Readers look here and there.
                let count = TriangleBlock::count(pair.model.field().topology()) as usize;
                for _ in 0..random.below(20) {
                    let block = random.below(count) as u32;
                    assert_eq!(pair.paging.read(block).unwrap(), pair.model.read(block).unwrap(), "{block}");
                }
                pair.both(|channel| drop(channel.commit()));
            }
            1 => {
                let gone = pair.model.field().allocated().filter(|face| (u64::from(*face) ^ state).is_multiple_of(5));
                let sets = TriangleSets { deallocate: gone.collect(), ..Default::default() };
                pair.both(|channel| {
                    channel.apply(&context, channel.field().pattern(), &sets).unwrap();
                });
                let all: Vec<u32> = pair.model.field().allocated().collect();
                let [a, b] =
                    [&mut pair.paging, &mut pair.model].map(|channel| channel.reclaim(&context, &all).unwrap());
                assert_eq!(a, b);
                undo.clear();
            }
            2 => snapshots.push([pair.paging.commit(), pair.model.commit()]),
            3 if !undo.is_empty() => {
                // Every block that changed is put back, as an undo does it: blocks that go, then all others.
                let back = undo.pop().unwrap();
                pair.both(|channel| {
                    back.iter().for_each(|(block, bytes)| channel.write_block(*block, bytes.as_deref()).unwrap())
                });
                pair.both(|channel| drop(channel.commit()));
            }
            _ => {
                let before = [pair.paging.field().clone(), pair.model.field().clone()];
                pair.both(|channel| edit(&context, channel, &mut Random(state | 1), &texel));
                let differing = Blocks::changed(pair.model.field(), &before[1]);
                let bytes = |block: u32| before[1].bytes(block).map(Cow::into_owned);
                let mut back: Vec<(u32, Option<Vec<u8>>)> =
                    differing.iter().map(|block| (*block, bytes(*block))).collect();
                back.sort_by_key(|(_, bytes)| bytes.is_some());
                undo.push(back);
                assert_eq!(Blocks::changed(pair.paging.field(), &before[0]), differing);
            }
        }
        pair.check_memory();
        if step % 10 == 9 {
            same(pair.paging.field(), pair.model.field());
            // What that brought back goes at the next commit.
            pair.both(|channel| drop(channel.commit()));
            pair.check_memory();
        }
        paged.push(pair.paging.paged());
    }
    snapshots.iter().for_each(|[a, b]| same(a.field(), b.field()));
    drop((snapshots, undo));
    // All that is erased is given back: to the heap, and to the file.
    let all = TriangleSets { deallocate: pair.model.field().allocated().collect(), ..Default::default() };
    pair.both(|channel| drop(channel.apply(&context, channel.field().pattern(), &all).unwrap()));
    pair.check_memory();
    assert_eq!((pair.paging.bytes(), pair.paging.paged().len()), (vertex_bytes(&pair.paging), 0));
    assert_eq!((pair.store.pages(), pair.store.bytes()), (0, 0));
    paged
}

#[test]
fn paging_is_seen_by_memory_alone() {
    let cases = (prop::collection::vec(any::<u8>(), 1..40), any::<u64>());
    let mut paging = Cell::new(0);
    let ran = TestRunner::new(ProptestConfig::with_cases(16)).run(&cases, |(choices, seed)| {
        let topology = topology(&grid(6, false, &choices, false));
        let displacement = TriangleChannel::displacement(topology.clone(), &options(UNLIMITED)).unwrap();
        let one = run(displacement.clone(), seed, 1, |x| f16::from_f32(x - 0.5));
        // The same blocks are on pages for any number of threads.
        prop_assert_eq!(&one, &run(displacement, seed, 3, |x| f16::from_f32(x - 0.5)));
        paging.set(paging.get() + usize::from(one.iter().any(|paged| !paged.is_empty())));
        let grey = Vec4::new(0.5, 0.5, 0.5, 1.0);
        let paint = TriangleChannel::<Rgba8>::of_color(topology.clone(), grey, &options(UNLIMITED)).unwrap();
        run(paint, seed, 1, |x| Rgba8([(255.0 * x) as u8, 3, 9, 255]));
        let vectors = TriangleChannel::vectors(topology.clone(), &options(UNLIMITED)).unwrap();
        run(vectors, seed, 1, |x| Vector([x, 0.5 - x, 0.25].map(f16::from_f32)));
        let traces = TriangleChannel::blank(topology, Trace::default(), &options(UNLIMITED)).unwrap();
        run(traces, seed, 1, |x| Trace::default().pushed(x, 3.0));
        Ok(())
    });
    ran.unwrap();
    assert!(*paging.get_mut() >= 14, "{paging:?}");
}

fn square() -> Mesh {
    grid(4, false, &[2], false)
}

fn fill(channel: &mut TriangleChannel, face: u32, value: f32) -> Result<Vec<u32>> {
    let pattern = channel.field().pattern();
    let sets = TriangleSets { allocate: vec![face], ..Default::default() };
    let refused = channel.apply(&Context::serial(), pattern, &sets)?;
    if refused.is_empty() {
        let faces = vec![(face, vec![f16::from_f32(value); pattern.face_values()])];
        channel.write(TriangleValues { faces, ..Default::default() })?;
    }
    Ok(refused)
}

/// A displacement over 32 triangles that has been pushed all over and has room for `room` of them with three edges
/// each.
fn pushed(room: u64, store: Arc<dyn PageStore>) -> TriangleChannel {
    let mut channel = TriangleChannel::displacement(topology(&square()), &options(UNLIMITED)).unwrap();
    for face in 0..32 {
        fill(&mut channel, face, 1.0 + face as f32).unwrap();
    }
    channel.page_to(Some(store)).unwrap();
    channel.set_budget(vertex_bytes(&channel) + room * 2 * WHOLE);
    channel
}

#[test]
fn the_blocks_edited_longest_ago_go_first() {
    let mut channel = pushed(10, Arc::new(PageFile::new(None)));
    let version = |channel: &TriangleChannel, face: u32| channel.field().version(face);
    let split = |channel: &TriangleChannel| {
        (0..32).partition::<Vec<u32>, _>(|face| {
            channel.is_paged(TriangleBlock::Face(*face).number(channel.field().topology()))
        })
    };
    let (gone, here) = split(&channel);
    assert!(gone.len() > 15 && here.len() > 5, "{gone:?}");
    let newest = |channel: &TriangleChannel, faces: &[u32]| faces.iter().map(|face| version(channel, *face)).max();
    let oldest = |channel: &TriangleChannel, faces: &[u32]| faces.iter().map(|face| version(channel, *face)).min();
    assert!(newest(&channel, &gone) < oldest(&channel, &here));
    // A face that was read only is still the oldest; one that was edited is the newest.
    assert!(channel.read(gone[0]).unwrap().is_some());
    channel.commit();
    assert!(channel.is_paged(gone[0]));
    fill(&mut channel, gone[0], -1.0).unwrap();
    assert!(!channel.is_paged(gone[0]) && channel.field().face(gone[0]).unwrap()[0].to_f32() == -1.0);
    let (gone, here) = split(&channel);
    assert!(newest(&channel, &gone) < oldest(&channel, &here));
}

#[test]
fn faces_that_do_not_fit_together_are_refused_whole_and_faces_that_are_there_never_are() {
    let (context, store) = (Context::serial(), Arc::new(PageFile::new(None)));
    let mut channel = TriangleChannel::displacement(topology(&square()), &options(UNLIMITED)).unwrap();
    channel.page_to(Some(store)).unwrap();
    let vertices = vertex_bytes(&channel);
    channel.set_budget(vertices + 3 * 2 * WHOLE);
    let pattern = channel.field().pattern();
    let all: Vec<u32> = (0..32).collect();
    let sets = |allocate: &[u32]| TriangleSets { allocate: allocate.to_vec(), ..Default::default() };
    let refused = channel.apply(&context, pattern, &sets(&all)).unwrap();
    assert!((28..30).contains(&refused.len()) && channel.paged().is_empty(), "{refused:?}");
    for face in &refused {
        assert_eq!(channel.apply(&context, pattern, &sets(&[*face])).unwrap(), [0u32; 0]);
        assert!(channel.resident_bytes() <= channel.budget());
    }
    assert_eq!(channel.allocated_count(), 32);
    // All of them are edited at once, in a budget for three.
    let faces = all.iter().map(|face| (*face, vec![f16::ONE; pattern.face_values()])).collect();
    channel.write(TriangleValues { faces, ..Default::default() }).unwrap();
    assert!(channel.resident_bytes() <= channel.budget());
    assert!(all.iter().all(|face| channel.field().face(*face).unwrap().iter().all(|value| *value == f16::ONE)));
    // A budget that holds no block; and one that does not hold another's edges.
    channel.set_budget(vertices + 100);
    channel.apply(&context, pattern, &TriangleSets { deallocate: vec![31], ..Default::default() }).unwrap();
    assert_eq!((channel.bytes(), channel.allocated_count()), (vertices, 31));
    assert_eq!(channel.apply(&context, pattern, &sets(&[31])).unwrap(), [31]);
    assert_eq!(channel.field().face(31), None);
}

#[test]
fn what_cannot_be_read_back_is_blank_to_readers_and_an_error_to_the_next_edit() {
    let store = Arc::new(Faulty::default());
    let mut channel = pushed(10, store.clone());
    let good = pushed(32, store.clone());
    let paged: Vec<u32> = channel.paged().into_iter().filter(|block| *block < 32).collect();
    store.broken.store(true, Ordering::SeqCst);
    let face = paged[3];
    assert!(channel.field().face(face).unwrap().iter().all(|value| *value == f16::ZERO));
    let named = |error: Error| assert!(error.to_string().contains(&format!("block {face}")), "{error}");
    // Told once to whoever edits anything, and always to whoever wants the face itself.
    let free = (0..32).find(|face| !channel.is_paged(*face)).unwrap();
    named(fill(&mut channel, free, 3.0).unwrap_err());
    assert_eq!(fill(&mut channel, free, 3.0).unwrap(), [0u32; 0]);
    named(fill(&mut channel, face, 3.0).unwrap_err());
    named(channel.read(face).unwrap_err());
    let mut document = Document::of_triangles(&square(), "").unwrap();
    assert!(channel.field().store(&Context::serial(), &mut document, "heights").is_err());
    assert!(document.layers().is_empty());
    assert!(!channel.reclaim(&Context::serial(), &[face]).unwrap_or_default().contains(&face));
    // A disk that is there again.
    store.broken.store(false, Ordering::SeqCst);
    drop(channel.report_fault());
    channel.commit();
    channel.report_fault().unwrap();
    assert_eq!(channel.field().face(face), good.field().face(face));
    // A page that is lost can be erased, or written anew.
    channel.commit();
    store.broken.store(true, Ordering::SeqCst);
    let other = bytemuck::cast_slice(good.field().face(paged[4]).unwrap());
    channel.write_block(face, Some(other)).unwrap();
    assert_eq!(channel.field().face(face), good.field().face(paged[4]));
    channel.write_block(paged[5], None).unwrap();
    assert!(!channel.field().is_allocated(paged[5]));
}

#[test]
fn where_there_is_no_room_for_pages_nothing_is_lost() {
    let store = Arc::new(Faulty::default());
    let mut channel = pushed(32, store.clone());
    let good = channel.clone();
    store.full.store(true, Ordering::SeqCst);
    channel.set_budget(vertex_bytes(&channel) + 10 * 2 * WHOLE);
    assert!(channel.report_fault().unwrap_err().to_string().contains("no room"));
    same(channel.field(), good.field());
    assert!(channel.paged().is_empty());
    store.full.store(false, Ordering::SeqCst);
    channel.commit();
    assert!(channel.paged().len() > 20 && channel.bytes() <= channel.budget());
    same(channel.field(), good.field());
}

#[test]
fn comparing_and_bounds_read_no_pages() {
    let store = Arc::new(Faulty::default());
    let mut channel = pushed(32, store.clone());
    let before = channel.commit();
    channel.set_budget(vertex_bytes(&channel) + 6 * 2 * WHOLE);
    let between = channel.commit();
    assert_eq!(Blocks::changed(channel.field(), before.field()), [0u32; 0]);
    let blocks = || (0..32).map(TriangleBlock::Face);
    let ranges: Vec<_> = blocks().map(|block| between.range(block)).collect();
    assert_eq!(store.loads.load(Ordering::SeqCst), 0);
    assert_eq!(ranges, blocks().map(|block| before.range(block)).collect::<Vec<_>>());
    let field = channel.field().clone();
    fill(&mut channel, 3, 7.5).unwrap();
    assert_eq!(Blocks::changed(channel.field(), &field), [3]);
}

#[test]
fn a_copy_pages_for_itself() {
    let store = Arc::new(PageFile::new(None));
    let mut channel = pushed(10, store.clone());
    let (good, mut copy) = (pushed(32, store.clone()), channel.clone());
    fill(&mut copy, 0, 9.0).unwrap();
    fill(&mut channel, 1, -9.0).unwrap();
    copy.commit();
    assert!(copy.resident_bytes() <= copy.budget() && channel.resident_bytes() <= channel.budget());
    for face in 2..32 {
        assert!(copy.field().face(face) == good.field().face(face));
        assert!(channel.field().face(face) == good.field().face(face));
    }
    assert!(channel.field().face(0) == good.field().face(0) && copy.field().face(1) == good.field().face(1));
    // All comes back to memory.
    channel.page_to(None).unwrap();
    assert!(channel.paged().is_empty() && channel.bytes() == good.bytes());
}

#[test]
fn a_composite_in_a_budget_is_that_without() {
    let context = Context::serial();
    let topology = topology(&square());
    let mut sheets = Vec::new();
    for seed in 1..4u64 {
        let mut layer = TriangleChannel::displacement(topology.clone(), &options(UNLIMITED)).unwrap();
        for step in 0..8 {
            edit(&context, &mut layer, &mut Random(97 * seed + 13 * step + 1), &|x| f16::from_f32(x - 0.5));
        }
        sheets.push(layer);
    }
    let settings = Settings { opacity: 0.5, ..Settings::of(relievo_document::Kind::Scalar) };
    let fields: Vec<TriangleSheet<'_, f16>> =
        sheets.iter().map(|layer| TriangleSheet { field: layer.field(), settings }).collect();
    let whole = TriangleChannel::displacement(topology, &options(UNLIMITED)).unwrap();
    let mut small = whole.clone();
    small.page_to(Some(Arc::new(PageFile::new(None)))).unwrap();
    small.set_budget(vertex_bytes(&small) + 4 * 2 * WHOLE);
    let [(whole, a), (mut small, b)] =
        [&whole, &small].map(|channel| channel.recomposed(&context, &fields, f16::ZERO).unwrap());
    assert_eq!((a, b), (Vec::new(), Vec::new()));
    assert!(!small.paged().is_empty() && small.resident_bytes() <= small.budget());
    same(small.field(), whole.field());
    small.commit();
    assert!(small.resident_bytes() <= small.budget());
}

#[test]
fn a_document_larger_than_the_budget_stays_in_its_file() {
    let (context, mesh) = (Context::serial(), square());
    let good = pushed(32, Arc::new(PageFile::new(None)));
    let mut document = Document::of_triangles(&mesh, "").unwrap();
    good.field().store(&context, &mut document, "heights").unwrap();
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a.relievo");
    document.write(&path).unwrap();
    let document = Document::open(&path, 1 << 30).unwrap();
    let file = PageFile::new(Some(folder.path()));
    let store: Arc<dyn PageStore> = Arc::new(file.clone());
    let budget = vertex_bytes(&good) + 8 * 2 * WHOLE;
    let open =
        |pages| TriangleChannel::<f16>::stored_with(&context, topology(&mesh), &document, "heights", budget, pages);
    let mut channel = open(Some(&store)).unwrap().unwrap();
    assert!(channel.paged().len() > 20 && channel.bytes() <= budget && file.pages() == 0);
    same(channel.field(), good.field());
    let mut again = Document::of_triangles(&mesh, "").unwrap();
    channel.field().store(&context, &mut again, "heights").unwrap();
    assert_eq!(again.to_bytes().unwrap(), document.to_bytes().unwrap());
    // Only what is edited needs a page of its own.
    channel.commit();
    for face in 0..12 {
        fill(&mut channel, face, -2.0).unwrap();
    }
    assert!(file.pages() > 0 && file.pages() < 20, "{}", file.pages());
    // Without pages it is refused.
    assert!(open(None).is_err());
}
