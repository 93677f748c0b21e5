//! Any bytes as a document, and documents put together from them whose checksums and compressed parts are sound, so
//! that what is in them is reached. They are refused, or can be used, written and read again.
#![no_main]

use libfuzzer_sys::fuzz_target;
use relievo_bake::mosaic::{self, Mosaic};
use relievo_core::{Context, ContextOptions, Mesh};
use relievo_document::format::VERSION;
use relievo_document::{Change, Document, Edit, Head, Kind, Stamps};
use relievo_fuzz::MEMORY_LIMIT;

fuzz_target!(|data: &[u8]| {
    match data.split_first() {
        Some((1, rest)) => sound(&file(rest)),
        _ => sound(data),
    }
});

fn sound(bytes: &[u8]) {
    let Ok(mut document) = Document::parse(bytes, MEMORY_LIMIT) else { return };
    assert!(!document.to_string().is_empty());
    let topology = document.topology();
    for layer in document.layers() {
        assert_eq!(layer.blank().len(), layer.head().texel());
        for (index, block) in layer.blocks().iter().enumerate() {
            assert!(block.tile() < topology.block_count());
            if let Ok(unpacked) = layer.unpack(topology, index) {
                assert_eq!(unpacked.len() as u64, layer.block_bytes(topology, index));
            }
        }
    }
    shown(&document);
    let mesh = Mesh::new(vec![], vec![4, 3], vec![0, 1, 2, 3, 3, 2, 4]);
    if let Err(error) = document.fit(&mesh) {
        assert!(!error.what.is_empty());
    }
    // It is written without its journal, in the newest version.
    (document.version, document.notes) = (VERSION, Vec::new());
    let written = document.to_bytes().expect("a document");
    let again = Document::parse(&written, u64::MAX).expect("a document of ours");
    assert!(again == document && again.to_bytes().expect("a document") == written);
}

/// Pictures of it are refused, or every level can be read at its end.
fn shown(document: &Document) {
    let options = ContextOptions { threads: 1, memory_limit: MEMORY_LIMIT };
    let context = Context::new(&options).expect("a context");
    let (Ok(all), Ok(meeting)) = (mosaic::shown(document), mosaic::meeting(document)) else { return };
    for shown in &all {
        let Ok(mosaic) = Mosaic::new(&context, document, &meeting, shown) else { continue };
        for level in 0..shown.cells.levels() {
            let [columns, rows] = shown.cells.size(level).map(|size| size.saturating_sub(24)..size);
            let bytes = columns.len() * rows.len() * shown.kind.pixel_size();
            assert_eq!(mosaic.read(level, columns, rows).expect("a part of it").len(), bytes);
        }
    }
}

/// The index is what a document with the mesh and layers that `data` asks for has, and then some bytes of it changed.
fn file(data: &[u8]) -> Vec<u8> {
    let mut data = data.iter().copied();
    let mut byte = || data.next().unwrap_or_default();
    let triangles = byte() & 1 == 1;
    let sizes: Vec<u32> = (0..byte() & 7).map(|_| if triangles { 3 } else { u32::from(byte() & 7) }).collect();
    let corners = (0..sizes.iter().sum()).map(|_| u32::from(byte()) % if triangles { 8 } else { 256 }).collect();
    let mut mesh = Mesh::new(Vec::new(), sizes.clone(), corners);
    let document = if triangles {
        mesh.points = vec![[0.0; 3]; 8];
        Document::of_triangles(&mesh, "fuzz")
    } else {
        mesh.holes = (0..sizes.len() as u32).filter(|_| byte() & 3 == 0).collect();
        Document::new(&mesh, "fuzz")
    };
    // A mesh of triangles has some.
    let Ok(mut document) = document else { return Vec::new() };
    let topology = document.topology().clone();
    let context = Context::serial();
    for number in 0..byte() & 3 {
        let kind = Kind::ALL[usize::from(byte()) % Kind::ALL.len()];
        let size = 8 << (byte() & 1);
        let face_sizes = sizes.iter().map(|_| if triangles { size } else { 8 << (byte() & 1) }).collect();
        let fades = document.layers().first().map(|layer| layer.head().clone());
        let head = match (kind, fades) {
            (Kind::Stamps, Some(fades)) => {
                let [delay, duration] = [byte(), byte()].map(f32::from);
                let stamps = Stamps { layer: fades.id, texel: fades.kind, delay, duration };
                Head::of_stamps(document.free_id(), &fades, stamps)
            }
            (Kind::Stamps, None) => continue,
            _ => {
                let blank: Vec<u8> = (0..kind.texel()).map(|_| byte()).collect();
                Head::new(document.free_id(), &format!("layer {number}"), kind, &blank, face_sizes)
            }
        };
        let blocks: Vec<u32> = (0..topology.block_count()).filter(|_| byte() & 1 == 0).collect();
        let fill = byte();
        let (own, known) = (head.clone(), topology.clone());
        let read = move |block: u32| Ok(vec![fill; own.block_bytes(&known, block) as usize]);
        let stamps = head.stamps.is_some();
        let packed = document.pack_layer(&context, head, &blocks, read);
        assert!(packed.is_ok() || stamps, "a layer: {packed:?}");
    }
    let whole = document.to_bytes().expect("a document");
    let number = |at: usize| u64::from_le_bytes(whole[at..at + 8].try_into().expect("eight bytes")) as usize;
    let (packed, raw) = (number(16), number(24));
    let mut index = zstd::bulk::decompress(&whole[44..44 + packed], raw).expect("an index of ours");
    let mut blocks = whole[44 + packed..44 + packed + number(32)].to_vec();
    for _ in 0..byte() & 3 {
        let (high, low, value) = (byte(), byte(), byte());
        let at = usize::from(u16::from_le_bytes([low, high]));
        if let Some(place) = index.get_mut(at) {
            *place = value;
        }
    }
    if byte() & 7 == 0 {
        blocks.push(byte());
    }
    let packed = zstd::bulk::compress(&index, 1).expect("a list takes all");
    let mut out = b"RLVDOC\r\n".to_vec();
    out.extend(VERSION.to_le_bytes());
    out.extend(crc32fast::hash(&packed).to_le_bytes());
    out.extend([packed.len(), index.len(), blocks.len()].iter().flat_map(|length| (*length as u64).to_le_bytes()));
    out.extend(crc32fast::hash(&out).to_le_bytes());
    let head = out.clone();
    out.extend(&packed);
    out.extend(blocks);
    // The second copies.
    out.extend(packed);
    out.extend(head);
    // Records, some of them with bytes that say something else.
    for sequence in 0..u64::from(byte() & 7) {
        let kind = u32::from(byte() % 7);
        let layers = document.layers();
        let mut payload = match (kind, layers.get(usize::from(byte()) % layers.len().max(1))) {
            (2 | 5 | 6, Some(layer)) => {
                let (blank, tile) = (layer.blank(), u32::from(byte() & 7));
                let length = layer.head().block_bytes(&topology, tile) as usize;
                let states = [byte(), byte(), byte()].map(|fill| vec![fill; length.max(1)]);
                let chosen = byte();
                let change = |_| Change {
                    layer: layer.id(),
                    block: tile,
                    before: (chosen & 1 == 0).then(|| states[0].as_slice().into()),
                    after: (chosen & 1 == 1 || chosen & 2 == 2).then(|| states[1].as_slice().into()),
                    blank,
                    fades: chosen & 4 == 4,
                };
                Edit::encode(&context, None, usize::from(chosen & 3 != 0), change).expect("a small edit")
            }
            (3 | 4, _) => u64::from(byte() & 7).to_le_bytes().to_vec(),
            _ => vec![byte(), byte()],
        };
        if byte() & 3 == 0
            && let Some(place) = payload.get_mut(usize::from(byte()))
        {
            *place = byte();
        }
        let mut head = b"RLVR".to_vec();
        head.extend(kind.to_le_bytes());
        head.extend(sequence.to_le_bytes());
        head.extend((payload.len() as u64).to_le_bytes());
        head.extend(crc32fast::hash(&head).to_le_bytes());
        out.extend(head);
        let crc = crc32fast::hash(&payload);
        out.extend(payload);
        out.extend(crc.to_le_bytes());
    }
    out
}
