//! Files that are cut off, or say what cannot be: errors, and memory within the limit.

use relievo_core::{Context, ContextOptions, ErrorKind};
use relievo_particleio::{Format, read, read_bgeo, read_vtk, write};

use crate::particles;

/// What errors name that say what can be read.
const FORMATS: &str = ".rlvfluid, .bgeo, .vtk, .ply or .vdb";

#[test]
fn every_cut_of_every_format_is_an_error_or_fewer_channels() {
    let folder = tempfile::tempdir().unwrap();
    let context = Context::serial();
    for format in Format::ALL {
        let path = folder.path().join("a").with_extension(format.extension());
        let whole = particles(9);
        write(&context, &path, &whole).unwrap();
        let bytes = std::fs::read(&path).unwrap();
        let known = read(&context, &path).unwrap().particles;
        for length in (0..bytes.len()).step_by(5) {
            std::fs::write(&path, &bytes[..length]).unwrap();
            match read(&context, &path) {
                Ok(read) => assert!(read.particles.channels.len() < 4 || read.particles == known, "{format} {length}"),
                Err(error) => assert!(error.to_string().contains("a."), "{error}"),
            }
        }
    }
}

#[test]
fn what_needs_more_than_the_limit_is_refused() {
    let folder = tempfile::tempdir().unwrap();
    for format in Format::ALL {
        let path = folder.path().join("a").with_extension(format.extension());
        write(&Context::serial(), &path, &particles(5000)).unwrap();
        let length = std::fs::metadata(&path).unwrap().len();
        for limit in [length / 2, length + 1000] {
            let context = Context::new(&ContextOptions { threads: 1, memory_limit: limit }).unwrap();
            assert_eq!(read(&context, &path).unwrap_err().kind, ErrorKind::Memory, "{format}");
        }
    }
}

#[test]
fn counts_of_others_are_compared_with_the_file() {
    let bgeo = |counts: [i32; 8]| {
        let counts = counts.map(i32::to_be_bytes).concat();
        [&b"BgeoV\0\0\0\x05"[..], &counts, &[0; 64]].concat()
    };
    for counts in [
        [i32::MAX, 0, 0, 0, 0, 0, 0, 0],
        [-1, 0, 0, 0, 0, 0, 0, 0],
        [1, 0, 0, 0, i32::MAX, 0, 0, 0],
        [1, 0, 0, 0, 0, 0, 0, 200],
        [5, 0, 0, 0, 0, 0, 0, 0],
    ] {
        assert!(read_bgeo(&bgeo(counts), 1 << 16).is_err(), "{counts:?}");
    }
    let head = "# vtk DataFile Version 3.0\nt\nBINARY\nDATASET POLYDATA\n";
    for rest in [
        "POINTS 18446744073709551615 float\n",
        "POINTS 2000000000 double\n",
        "POINTS 0 float\nPOINT_DATA 0\nFIELD f 9999999999\n",
        "POINTS 0 float\nVERTICES 1 18446744073709551615\n",
        "POINTS 0 float\nFIELD f 1\na 18446744073709551615 18446744073709551615 float\n",
        "LOOKUP_TABLE a 9223372036854775807\n",
    ] {
        assert!(read_vtk(format!("{head}{rest}").as_bytes(), 1 << 16).is_err(), "{rest}");
    }
}

#[test]
fn what_is_no_file_of_particles_is_refused_by_name() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a.vtu");
    let context = Context::serial();
    let refused = |bytes: &[u8], why: &str| {
        std::fs::write(&path, bytes).unwrap();
        let error = read(&context, &path).unwrap_err().to_string();
        assert!(error.contains(why) && error.contains("a.vtu"), "{error}");
    };
    refused(b"<?xml version=\"1.0\"?>\n<VTKFile type=\"PolyData\">", "VTK's XML");
    refused(b"\x7fNSJ rest", "Houdini 12");
    refused(b"", "the file is empty");
    refused(b"", FORMATS);
    for format in Format::ALL {
        for bytes in [&b""[..], b"\0\x01", b"some text\n"] {
            let path = path.with_extension(format.extension());
            std::fs::write(&path, bytes).unwrap();
            let error = read(&context, &path).unwrap_err().to_string();
            assert!(error.contains(FORMATS) && !error.contains("OBJ"), "{format}: {error}");
        }
    }
    let error = write(&context, &path, &particles(1)).unwrap_err().to_string();
    assert!(error.contains(FORMATS), "{error}");
    let lost = read(&context, &folder.path().join("none.bgeo")).unwrap_err();
    assert_eq!(lost.kind, ErrorKind::NotFound);
}
