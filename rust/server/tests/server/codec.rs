//! Messages and chunks against closed forms, peers and strangers.

use proptest::prelude::*;
use relievo_client::{Column, Form, Layout, MAX_DEPTH, Message, Packing, Scanner, Values, parse, request};

const LAYOUTS: [Layout; 3] = [Layout::Rows, Layout::Planes, Layout::Differences];
const PACKINGS: [Packing; 3] = [Packing::None, Packing::Zstd, Packing::Lz4];

/// Bytes of every kind of item, from the specification's table.
fn items() -> Vec<Vec<u8>> {
    let mut items: Vec<Vec<u8>> =
        [0x00, 0x7f, 0xe0, 0xff, 0xc0, 0xc2, 0xc3, 0x80, 0x90, 0xa0].iter().map(|byte| vec![*byte]).collect();
    for (marker, bytes) in [(0xcc, 1), (0xcd, 2), (0xce, 4), (0xcf, 8), (0xd0, 1), (0xd1, 2), (0xd2, 4), (0xd3, 8)] {
        items.push([vec![marker], vec![1; bytes]].concat());
    }
    items.extend([vec![0xca, 0, 0, 0, 0], [vec![0xcb], vec![0; 8]].concat()]);
    for (marker, bytes) in [(0xd4, 1), (0xd5, 2), (0xd6, 4), (0xd7, 8), (0xd8, 16)] {
        items.push([vec![marker, 9], vec![0; bytes]].concat());
    }
    for (head, bytes) in [
        (vec![0xa3], 3),
        (vec![0xc4, 3], 3),
        (vec![0xc5, 0, 3], 3),
        (vec![0xc6, 0, 0, 0, 3], 3),
        (vec![0xd9, 3], 3),
        (vec![0xda, 0, 3], 3),
        (vec![0xdb, 0, 0, 0, 3], 3),
        (vec![0xc7, 3], 4),
        (vec![0xc8, 0, 3], 4),
        (vec![0xc9, 0, 0, 0, 3], 4),
        (vec![0x92], 2),
        (vec![0x81], 2),
        (vec![0xdc, 0, 2], 2),
        (vec![0xdd, 0, 0, 0, 2], 2),
        (vec![0xde, 0, 1], 2),
        (vec![0xdf, 0, 0, 0, 1], 2),
    ] {
        items.push([head, vec![b'a' & 0x7f; bytes]].concat());
    }
    items
}

#[test]
fn the_scanner_finds_the_end_of_every_kind_of_item_however_it_is_cut() {
    for item in items() {
        let mut scanner = Scanner::new(100);
        for length in 0..item.len() {
            assert_eq!(scanner.scan(&item[..length]).unwrap(), None, "{item:x?} of {length}");
        }
        // What follows is left alone.
        let more = [item.clone(), vec![0xc1]].concat();
        assert_eq!(scanner.scan(&more).unwrap(), Some(item.len()), "{item:x?}");
        assert_eq!(Scanner::new(100).scan(&more).unwrap(), Some(item.len()), "{item:x?} at once");
    }
}

#[test]
fn too_long_and_too_deep_messages_are_refused_by_their_heads() {
    let refused = |bytes: &[u8]| Scanner::new(1000).scan(bytes).is_err();
    assert!(refused(&[0xdb, 0xff, 0xff, 0xff, 0xff]), "a text of 4 GiB");
    assert!(refused(&[0xdd, 0xff, 0xff, 0xff, 0xff]), "a list of 4 Gi items");
    assert!(refused(&[0xdf, 0x80, 0, 0, 0]), "a map of 2 Gi items");
    assert!(refused(&[0xc5, 0x03, 0xe8]), "1,000 bytes and a head");
    assert!(!refused(&[0xc5, 0x03, 0xe0]));
    assert!(refused(&[0xc1]));
    assert!(refused(&[0x91; MAX_DEPTH + 1]));
    let deep = [vec![0x91; MAX_DEPTH], vec![0xc0]].concat();
    assert_eq!(Scanner::new(1000).scan(&deep).unwrap(), Some(deep.len()));
}

#[test]
fn messages_are_split_as_the_specification_says() {
    let bytes = request(7, "scene.status", &relievo_client::SceneName { scene: "a".into() }).unwrap();
    let wire = b"\x94\x00\x07\xacscene.status\x91\x81\xa5scene\xa1a";
    assert_eq!(bytes, wire);
    let Message::Request { id: 7, method: "scene.status", parameters } = parse(&bytes).unwrap() else { panic!() };
    assert_eq!(parameters, b"\x91\x81\xa5scene\xa1a");
    assert_eq!(parse(b"\x94\x01\x07\xc0\xa1x").unwrap(), Message::Response { id: 7, error: b"\xc0", result: b"\xa1x" });
    assert_eq!(parse(b"\x93\x02\xa1m\x90").unwrap(), Message::Notification { method: "m", parameters: b"\x90" });
    for wrong in
        [&b"\x90"[..], b"\x94\x03\x07\xa1m\x90", b"\x93\x00\xa1m\x90", b"\x94\x00\xc0\xa1m\x90", b"\x81\xa1a\xa1b"]
    {
        assert!(parse(wrong).is_err(), "{wrong:x?}");
    }
}

proptest! {
    #[test]
    fn columns_come_back_to_the_bit(bits in prop::collection::vec(any::<u32>(), 0..60), width in 1u32..=4) {
        let count = bits.len() as u32 / width;
        let bits = &bits[..(count * width) as usize];
        let floats: Vec<f32> = bits.iter().copied().map(f32::from_bits).collect();
        for layout in LAYOUTS {
            for packing in PACKINGS {
                let column = Column::of_floats("a", width, &floats, false, layout, packing).unwrap();
                let Values::Floats(values) = column.values(count).unwrap() else { panic!() };
                prop_assert_eq!(values.iter().map(|value| value.to_bits()).collect::<Vec<_>>(), bits);
                if width == 1 {
                    let column = Column::of_integers("n", bits, layout, packing).unwrap();
                    prop_assert_eq!(column.values(count).unwrap(), Values::Integers(bits.to_vec()));
                }
            }
        }
    }

    #[test]
    fn strangers_do_not_harm_the_decoders(bytes in prop::collection::vec(any::<u8>(), 0..200)) {
        if let Ok(Some(length)) = Scanner::new(1000).scan(&bytes) {
            let _ = parse(&bytes[..length]);
            let _ = relievo_client::parameters::<relievo_client::Submit>(&bytes[..length]);
            let _ = relievo_client::decode::<relievo_client::Chunk>(&bytes[..length]);
        }
    }
}

#[test]
fn halves_are_as_near_as_they_say() {
    let places: Vec<f32> = (0..300).map(|at| (at as f32 * 0.77).sin() * 3.0).collect();
    for layout in LAYOUTS {
        let column = Column::of_floats("position", 3, &places, true, layout, Packing::Zstd).unwrap();
        assert_eq!(column.form, Form::Unorm16);
        let Values::Floats(values) = column.values(100).unwrap() else { panic!() };
        // Half a step of 65,535 of a box that is 6 wide, and rounding.
        assert!(places.iter().zip(&values).all(|(a, b)| (a - b).abs() <= 6.0 / 65535.0 * 0.51));
        let column = Column::of_floats("velocity", 3, &places, true, layout, Packing::Lz4).unwrap();
        assert_eq!(column.form, Form::F16);
        let Values::Floats(values) = column.values(100).unwrap() else { panic!() };
        assert!(places.iter().zip(&values).all(|(a, b)| (a - b).abs() <= a.abs() / 2048.0 + 1e-7));
    }
}

#[test]
fn a_bomb_unpacks_to_no_more_than_its_particles_need() {
    let bytes = vec![0u8; 256 << 20];
    let bomb = Column::of_floats("a", 1, &[0.0; 4], false, Layout::Planes, Packing::Zstd).unwrap();
    let packed = lz4_bomb(&bytes);
    for (packing, data) in [(Packing::Lz4, packed), (Packing::Zstd, vec![0x28, 0xb5, 0x2f, 0xfd, 0xe0])] {
        let column = Column { packing, data, ..bomb.clone() };
        assert!(column.values(4).is_err());
    }
    let wide = Column { width: 200, ..bomb.clone() };
    assert!(wide.values(4).is_err());
    assert!(bomb.values(u32::MAX).is_err() && bomb.values(3).is_err() && bomb.values(5).is_err());
}

/// A block of LZ4 that unpacks to `bytes` zeros, 255 times smaller.
fn lz4_bomb(bytes: &[u8]) -> Vec<u8> {
    let mut block = vec![0x1f, 0, 1, 0];
    block.extend(vec![255; bytes.len() / 255]);
    block.extend([0, 0x50, 0, 0, 0, 0, 0]);
    block
}
