use relievo_particleio::{Channel, Particles, read_vtk, write_vtk};

use crate::particles;

fn bytes(particles: &Particles) -> Vec<u8> {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a.vtk");
    write_vtk(&path, particles).unwrap();
    std::fs::read(&path).unwrap()
}

#[test]
fn what_is_written_is_the_legacy_form_byte_by_byte() {
    let particles = Particles {
        points: vec![[0.5, 1.0, 2.0]],
        time: Some(0.5),
        numbers: Some(vec![3]),
        channels: vec![Channel { name: "a b".into(), width: 1, values: vec![4.0] }],
        ..Particles::default()
    };
    let expected = [
        &b"# vtk DataFile Version 3.0\nRelievo\nBINARY\nDATASET POLYDATA\nFIELD FieldData 1\nTIME 1 1 double\n"[..],
        &0.5f64.to_be_bytes(),
        b"\nPOINTS 1 float\n",
        &[0.5f32, 1.0, 2.0].map(f32::to_be_bytes).concat(),
        b"\nVERTICES 1 2\n\0\0\0\x01\0\0\0\0\nPOINT_DATA 1\nFIELD FieldData 2\nid 1 1 unsigned_int\n\0\0\0\x03\n",
        b"a%20b 1 1 float\n",
        &4.0f32.to_be_bytes(),
        b"\n",
    ];
    assert_eq!(bytes(&particles), expected.concat());
}

#[test]
fn what_is_written_is_read() {
    for particles in [particles(100), particles(0), Particles { numbers: None, spacing: None, ..particles(3) }] {
        let read = read_vtk(&bytes(&particles), 1 << 20).unwrap();
        assert!(read.particles == particles && read.notes.is_empty());
    }
}

#[test]
fn text_of_any_version_is_read_with_all_kinds_of_arrays() {
    let text = "# vtk DataFile Version 5.1\nanything\nASCII\nDATASET UNSTRUCTURED_GRID\n\
        FIELD FieldData 1\nTIME 1 1 double\n2.5\nPOINTS 2 double\n0 1 2 3e0 4\n5\nMETADATA\nINFORMATION 0\n\n\
        CELLS 3 2\nOFFSETS vtktypeint64\n0 1 2\nCONNECTIVITY vtktypeint64\n0 1\nCELL_TYPES 2\n1 1\n\
        CELL_DATA 2\nSCALARS material int\nLOOKUP_TABLE default\n7 8\n\
        POINT_DATA 2\nSCALARS id unsigned_int 1\nLOOKUP_TABLE id_table\n9 4\nVECTORS velocity float\n1 2 3 4 5 6\n\
        TENSORS stress float\n1 2 3 4 5 6 7 8 9 1 2 3 4 5 6 7 8 9\nFIELD more 2\npressure 1 2 float\n-1 1e3\n\
        wide 5 2 int\n0 0 0 0 0 0 0 0 0 0\n";
    for text in [text.to_owned(), text.replace('\n', "\r\n")] {
        let read = read_vtk(text.as_bytes(), 1 << 20).unwrap();
        let particles = read.particles;
        assert_eq!(particles.points, [[0.0, 1.0, 2.0], [3.0, 4.0, 5.0]]);
        assert_eq!((particles.time, particles.numbers.as_deref()), (Some(2.5), Some(&[9, 4][..])));
        let names: Vec<_> = particles.channels.iter().map(|it| (it.name.as_str(), it.width)).collect();
        assert_eq!(names, [("velocity", 3), ("pressure", 1)]);
        assert_eq!(particles.channels[1].values, [-1.0, 1000.0]);
        assert_eq!(read.notes.len(), 2, "{:?}", read.notes);
    }
}

#[test]
fn what_has_no_particles_is_refused_by_name() {
    let head = "# vtk DataFile Version 3.0\nt\nASCII\n";
    let refused = |text: &str, why: &str| {
        let error = read_vtk(text.as_bytes(), 1 << 20).unwrap_err().to_string();
        assert!(error.contains(why), "{error}");
    };
    refused(&format!("{head}DATASET STRUCTURED_POINTS\nDIMENSIONS 1 1 1\n"), "STRUCTURED_POINTS");
    refused(&format!("{head}DATASET POLYDATA\n"), "POINTS");
    refused(&format!("{head}DATASET POLYDATA\nPOINTS 2 float\n1 2 3 4 5\n"), "POINTS: the file ends");
    refused(&format!("{head}DATASET POLYDATA\nPOINTS 1 float\n1 2 x\n"), "\"x\"");
    refused(&format!("{head}DATASET POLYDATA\nPOINTS 1 float\n1 2 nan\n"), "particle 0: its place");
    refused(&format!("{head}DATASET POLYDATA\nPOINTS 1 string\n1 2 3\n"), "\"string\"");
    refused(&format!("{head}DATASET POLYDATA\nPOINTS 1 float\n1 2 3\nPOINT_DATA 2\n"), "2 points");
    refused(&format!("{head}DATASET POLYDATA\nPOINTS 1 float\n1 2 3\nOTHER 2\n"), "OTHER");
    refused("# vtk DataFile Version 9.0\nt\nASCII\n", "version 9");
    refused("# vtk DataFile Version 3.0\nt\nHEX\n", "HEX");
}
