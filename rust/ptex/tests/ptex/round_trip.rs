//! What is written is read again as it was.

use proptest::prelude::*;
use relievo_core::{Context, ContextOptions, Error};
use relievo_ptex::{
    BorderMode, Borders, DataType, EdgeFilter, Face, Format, MeshType, MetaData, MetaValue, Neighbor, Reader,
    Resolution, Summary, Writer,
};

#[derive(Clone, Debug)]
struct File {
    format: Format,
    borders: Borders,
    faces: Vec<(Face, Vec<u8>)>,
    meta: MetaData,
}

fn format() -> impl Strategy<Value = Format> {
    let mesh = prop_oneof![Just(MeshType::Quad), Just(MeshType::Triangle)];
    (mesh, data_type(), 1..6u16, any::<Option<prop::sample::Index>>()).prop_map(|(mesh, data_type, channels, alpha)| {
        let alpha = alpha.map(|index| index.index(usize::from(channels)) as u16);
        Format { mesh, data_type, channels, alpha }
    })
}

fn data_type() -> impl Strategy<Value = DataType> {
    prop_oneof![Just(DataType::U8), Just(DataType::U16), Just(DataType::F16), Just(DataType::F32)]
}

fn borders() -> impl Strategy<Value = Borders> {
    let mode = || prop_oneof![Just(BorderMode::Clamp), Just(BorderMode::Black), Just(BorderMode::Periodic)];
    let filter = prop_oneof![Just(EdgeFilter::None), Just(EdgeFilter::TangentVector)];
    (mode(), mode(), filter).prop_map(|(u, v, edge_filter)| Borders { u, v, edge_filter })
}

fn face(mesh: MeshType, count: u32) -> impl Strategy<Value = Face> {
    let edges = if mesh == MeshType::Triangle { 3u8 } else { 4 };
    let neighbor = prop::option::of((0..count, 0..edges).prop_map(|(face, edge)| Neighbor { face, edge }));
    (0..6u8, 0..6u8, prop::collection::vec(neighbor, 4), any::<bool>()).prop_map(move |(u, v, list, subface)| {
        let mut neighbors = [None; 4];
        neighbors.iter_mut().zip(list).take(usize::from(edges)).for_each(|(to, from)| *to = from);
        let v = if mesh == MeshType::Triangle { u } else { v };
        Face { resolution: Resolution::new(u, v), neighbors, subface }
    })
}

fn meta() -> impl Strategy<Value = MetaData> {
    // Above and below the size from which values are stored apart.
    let sizes = || prop_oneof![3 => 0..9usize, 1 => 200..1500usize];
    let value = prop_oneof![
        sizes().prop_map(|size| MetaValue::Text("ä".repeat(size))),
        sizes().prop_map(|size| MetaValue::I8((0..size).map(|index| index as i8).collect())),
        sizes().prop_map(|size| MetaValue::I16((0..size).map(|index| -300 * index as i16).collect())),
        sizes().prop_map(|size| MetaValue::I32(vec![i32::MIN; size])),
        sizes().prop_map(|size| MetaValue::F32((0..size).map(|index| 0.1 * index as f32).collect())),
        sizes().prop_map(|size| MetaValue::F64((0..size).map(|index| 0.1 * index as f64).collect())),
    ];
    prop::collection::btree_map("[A-Za-z é]{1,40}", value, 0..5)
}

fn file() -> impl Strategy<Value = File> {
    (format(), borders(), 1..7u32).prop_flat_map(|(format, borders, count)| {
        let face = face(format.mesh, count).prop_flat_map(move |face| {
            let length = face.resolution.texels() as usize * format.texel_size();
            let texels = prop_oneof![
                2 => prop::collection::vec(any::<u8>(), length),
                1 => prop::collection::vec(any::<u8>(), format.texel_size()).prop_map(move |texel| {
                    texel.iter().copied().cycle().take(length).collect()
                }),
            ];
            (Just(face), texels)
        });
        let faces = prop::collection::vec(face, count as usize);
        (Just(format), Just(borders), faces, meta()).prop_map(|(format, borders, faces, meta)| File {
            format,
            borders,
            faces,
            meta,
        })
    })
}

fn bytes(file: &File, backwards: bool) -> Vec<u8> {
    let mut writer = Writer::new(file.format, file.borders, file.faces.len() as u32).unwrap();
    let mut order: Vec<usize> = (0..file.faces.len()).collect();
    if backwards {
        order.reverse();
    }
    for index in order {
        let (face, texels) = &file.faces[index];
        writer.set(index as u32, face, texels).unwrap();
    }
    file.meta.iter().for_each(|(key, value)| writer.set_meta(key.clone(), value.clone()));
    writer.bytes().unwrap()
}

fn threaded(file: &File) -> Vec<u8> {
    let mut writer = Writer::new(file.format, file.borders, file.faces.len() as u32).unwrap();
    let context = Context::new(&ContextOptions { threads: 2, memory_limit: 0 }).unwrap();
    writer.set_all(&context, |index| Ok(file.faces[index as usize].clone())).unwrap();
    file.meta.iter().for_each(|(key, value)| writer.set_meta(key.clone(), value.clone()));
    writer.bytes().unwrap()
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 200, failure_persistence: None, ..ProptestConfig::default() })]

    #[test]
    fn everything_comes_back(file in file()) {
        let bytes = bytes(&file, false);
        prop_assert_eq!(&bytes, &self::bytes(&file, true));
        prop_assert_eq!(&bytes, &threaded(&file));
        let reader = Reader::new(&bytes, 1 << 24).unwrap();
        prop_assert_eq!(reader.format(), &file.format);
        prop_assert_eq!(reader.borders(), file.borders);
        prop_assert_eq!(reader.face_count() as usize, file.faces.len());
        prop_assert_eq!(reader.meta(), &file.meta);
        prop_assert_eq!(reader.edit_count(), 0);
        let size = file.format.texel_size();
        for (index, (face, texels)) in file.faces.iter().enumerate() {
            let index = index as u32;
            prop_assert_eq!(reader.face(index).unwrap(), face);
            prop_assert_eq!(&reader.texels(index).unwrap(), texels);
            let constant = texels.chunks_exact(size).all(|texel| texel == &texels[..size]);
            prop_assert_eq!(reader.constant(index).is_some(), constant);
            // Reductions go down to four texels along the shorter side.
            for level in 1..7u8 {
                let reduction = reader.reduction(index, usize::from(level)).unwrap();
                let resolution = face.resolution.halved(level).filter(|resolution| resolution.least() >= 2);
                let expected = resolution.filter(|_| !constant).map(|it| it.texels() as usize * size);
                prop_assert_eq!(reduction.map(|texels| texels.len()), expected);
            }
        }
        prop_assert_eq!(Summary::of(&reader).problem, None);
    }
}

#[test]
fn long_thin_and_tiled_faces_are_written() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a.ptx");
    let format = Format { mesh: MeshType::Quad, data_type: DataType::U16, channels: 3, alpha: None };
    let sizes = [(16, 0), (0, 16), (3, 13), (9, 9), (10, 8)];
    let texels = |u: u8, v: u8| -> Vec<u8> {
        // Waves, and half of the face without any.
        let count = 1usize << (u + v);
        let wave = |index: usize| if index < count / 2 { (index as f32 * 0.01).sin() * 0.5 + 0.5 } else { 0.25 };
        DataType::U16.encode(&(0..count * 3).map(|index| wave(index / 3)).collect::<Vec<_>>())
    };
    let mut writer = Writer::new(format, Borders::default(), sizes.len() as u32).unwrap();
    for (index, (u, v)) in sizes.into_iter().enumerate() {
        writer.set(index as u32, &Face::new(u, v), &texels(u, v)).unwrap();
    }
    writer.write(&path).unwrap();
    let reader = Reader::open(&path, 1 << 24).unwrap();
    for (index, (u, v)) in sizes.into_iter().enumerate() {
        assert!(reader.texels(index as u32).unwrap() == texels(u, v), "{u} {v}");
    }
    // The mean of a reduction is that of the texels, up to rounding.
    let mean = |bytes: &[u8]| {
        let values = DataType::U16.decode(bytes);
        values.iter().map(|value| f64::from(*value)).sum::<f64>() / values.len() as f64
    };
    let full = mean(&texels(9, 9));
    for level in 1..=7 {
        let reduction = reader.reduction(3, level).unwrap().unwrap();
        assert!((mean(&reduction) - full).abs() < 1e-4, "level {level}");
    }
    assert!((mean(reader.average(3).unwrap()) - full).abs() < 1e-4);
    assert!(Reader::open(&path, 1000).is_err());
    assert!(Reader::open(folder.path(), 1000).is_err());
}

#[test]
fn what_cannot_be_written_is_refused() {
    let format = Format { mesh: MeshType::Triangle, data_type: DataType::U8, channels: 1, alpha: None };
    let mut writer = Writer::new(format, Borders::default(), 2).unwrap();
    let link = |face, edge| Face { neighbors: [Some(Neighbor { face, edge }), None, None, None], ..Face::new(1, 1) };
    assert!(writer.set(0, &link(1, 2), &[1, 2, 3, 4]).is_ok());
    for (index, face, texels) in [
        (2, Face::new(1, 1), vec![1, 2, 3, 4]),
        (1, Face::new(1, 1), vec![1, 2, 3]),
        (1, Face::new(1, 0), vec![1, 2]),
        (1, Face::new(17, 17), vec![]),
        (1, link(2, 0), vec![1, 2, 3, 4]),
        (1, link(0, 3), vec![1, 2, 3, 4]),
    ] {
        let error = writer.set(index, &face, &texels).unwrap_err().to_string();
        assert!(error.starts_with(&format!("face {index}: ")) && error.contains(';'), "{error}");
    }
    assert!(writer.set_constant(1, &Face::new(1, 1), &[1, 2]).is_err());
    let error = writer.set_all(&Context::serial(), |index| match index {
        0 => Ok((Face::new(0, 0), vec![1])),
        _ => Err(Error::invalid("no texels")),
    });
    assert_eq!(error.unwrap_err().to_string(), "face 1: no texels");
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a.ptx");
    assert!(writer.clone().write(&path).unwrap_err().to_string().contains("face 1: its texels are missing"));
    assert!(!path.exists());
    writer.set_constant(1, &Face::new(1, 1), &[1]).unwrap();
    for key in ["", "a\0b", &"k".repeat(255)] {
        let mut writer = writer.clone();
        writer.set_meta(key, MetaValue::I8(vec![1]));
        assert!(writer.bytes().unwrap_err().to_string().contains("cannot be a key"));
    }
    assert!(writer.write(&path).is_ok() && path.exists());
    assert!(Writer::new(Format { channels: 0, ..format }, Borders::default(), 1).is_err());
}
