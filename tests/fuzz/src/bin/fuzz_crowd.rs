//! Crowd models: arbitrary bytes, and a whole file whose contents are changed and whose sums and lengths are right. A model
//! that is read is cut, posed and drawn, also while its clusters are read.
#![no_main]

use std::sync::{Arc, LazyLock};

use libfuzzer_sys::fuzz_target;
use relievo_core::{Context, ContextOptions};
use relievo_crowd::{Agent, Crowd, CrowdModel, CrowdView, DrawList, Frame, Stream};
use relievo_fuzz::MEMORY_LIMIT;

static CONTEXT: LazyLock<Context> = LazyLock::new(|| {
    let options = ContextOptions { threads: 1, memory_limit: MEMORY_LIMIT };
    Context::new(&options).expect("a thread")
});

const GOLDEN: &[u8] = include_bytes!("../../../golden/model-1.rcrowd");
/// Bytes of the head without its sum, and with it.
const HEAD: [usize; 2] = [48, 52];
/// Chunks before those of the clusters.
const COMMON: usize = 4;

/// The contents of all chunks.
static CHUNKS: LazyLock<Vec<Vec<u8>>> = LazyLock::new(|| {
    let mut rest = &GOLDEN[HEAD[1]..];
    let mut chunks = Vec::new();
    while let Some((head, more)) = rest.split_at_checked(12) {
        let [raw, packed] =
            [0, 4].map(|at| u32::from_le_bytes([head[at], head[at + 1], head[at + 2], head[at + 3]]) as usize);
        chunks.push(zstd::bulk::decompress(&more[..packed], raw).expect("a chunk of the golden file"));
        rest = &more[packed..];
    }
    chunks
});

fn packed(content: &[u8]) -> Vec<u8> {
    let packed = zstd::bulk::compress(content, 1).unwrap_or_default();
    let head = [content.len() as u32, packed.len() as u32, crc32fast::hash(&packed)];
    head.into_iter().flat_map(u32::to_le_bytes).chain(packed).collect()
}

/// The golden file with changes: four bytes each say which chunk, or the head, where, and the new value.
fn changed(data: &[u8]) -> Vec<u8> {
    let (mut head, mut chunks) = (GOLDEN[..HEAD[0]].to_vec(), CHUNKS.clone());
    for [chunk, low, high, value] in data.as_chunks::<4>().0 {
        let at = usize::from(u16::from_le_bytes([*low, *high]));
        let count = chunks.len();
        let content = match usize::from(*chunk) {
            255 => &mut head,
            chunk => &mut chunks[chunk % count],
        };
        let length = content.len();
        if let Some(byte) = content.get_mut(at % length.max(1)) {
            *byte = *value;
        }
    }
    let clusters: Vec<Vec<u8>> = chunks[COMMON..].iter().map(|content| packed(content)).collect();
    // The hierarchy ends with the lengths of the chunks of clusters, in planes of bytes.
    let start = chunks[1].len() - 4 * clusters.len();
    for plane in 0..4 {
        for (index, chunk) in clusters.iter().enumerate() {
            chunks[1][start + plane * clusters.len() + index] = (chunk.len() >> (8 * plane)) as u8;
        }
    }
    head.extend(crc32fast::hash(&head).to_le_bytes());
    chunks[..COMMON].iter().for_each(|content| head.extend(packed(content)));
    clusters.iter().for_each(|chunk| head.extend(chunk));
    head
}

/// Adds agents at some distances, cuts the crowd a few times and lists its draws. A cluster of a file may be damaged.
fn draw(crowd: &mut Crowd, cuts: u32, may_fail: bool) {
    for away in [0.0, 2.0, 50.0] {
        let transform = glam::DAffine3::from_translation(glam::DVec3::new(0.0, 0.0, -away));
        // A model may be too large to be placed.
        let _ = crowd.add(Agent { model: 0, clip: 0, phase: away, transform });
    }
    let planes = vec![[0.0, 0.0, -1.0, 4.0]];
    let view = CrowdView { eye: [0.0, 1.0, 4.0], pixels: 500.0, planes, ..CrowdView::default() };
    let (mut frame, mut list) = (Frame::default(), DrawList::default());
    for _ in 0..cuts {
        match crowd.cut(&CONTEXT, &view, &mut frame) {
            Ok(()) => list.update(crowd, &frame, 0.5).expect("a small model"),
            Err(error) => assert!(may_fail, "a view: {error}"),
        }
        let Some(stream) = crowd.stream() else { continue };
        assert!(stream.counts().resident <= stream.slot_count(), "the budget is held");
    }
}

/// Reads clusters of a file while they are drawn, within a budget and by a number of reads that the first bytes say.
fn stream(file: &[u8], [budget, most_read]: [u8; 2]) {
    let path = std::env::temp_dir().join(format!("relievo-fuzz-crowd-{}.rcrowd", std::process::id()));
    std::fs::write(&path, file).expect("a folder for files");
    let opened = Stream::open(&CONTEXT, &[&path], 64 * u64::from(budget), u32::from(most_read));
    let Ok(opened) = opened else { return };
    draw(&mut Crowd::streamed(opened), 4, true);
}

fuzz_target!(|data: &[u8]| {
    let made = match data.split_first() {
        Some((1, rest)) => changed(rest),
        Some((2, [budget, reads, rest @ ..])) => return stream(&changed(rest), [*budget, *reads]),
        _ => data.to_vec(),
    };
    let Ok(model) = CrowdModel::from_bytes(&made, MEMORY_LIMIT) else { return };
    if model.has_triangles() {
        let pose = &model.clips[0].poses[0];
        model.mesh(&CONTEXT, &model.cut(0.1 * model.size()), pose).expect("a pose of the model");
    }
    draw(&mut Crowd::new(vec![Arc::new(model)]), 1, false);
});
