use std::path::Path;

use relievo_particleio::{Format, FrameNumber, frames, path};

#[test]
fn frames_and_sub_frames_have_names_that_sort() {
    let name = |step: u64, parts: u32| path(Path::new(""), step, parts, Format::Ply).display().to_string();
    assert_eq!(
        [name(12, 1), name(12, 0), name(50, 4), name(51, 4), name(2, 3)],
        ["0012.ply", "0012.ply", "0012.500.ply", "0012.750.ply", "0000.666.ply"]
    );
    let folder = tempfile::tempdir().unwrap();
    for name in ["0002.ply", "0001.250.bgeo", "0001.000.rlvfluid", "10000.vtk", "0001.txt", "a.ply", "1.5.ply", ".ply"]
    {
        std::fs::write(folder.path().join(name), b"").unwrap();
    }
    let found: Vec<_> = frames(folder.path()).unwrap().into_iter().map(|(number, _)| number.to_string()).collect();
    assert_eq!(found, ["1", "1.250", "2", "10000"]);
    assert!(FrameNumber(1500) < FrameNumber(2000) && frames(&folder.path().join("none")).is_err());
}
