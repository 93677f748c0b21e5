//! Files that other programs wrote.

use relievo_core::Context;
use relievo_particleio::read;

#[test]
fn files_of_splishsplash_and_of_vtk_are_read() {
    let Some(folder) = relievo_testing::file("particles") else { return };
    let expected = [
        ("ParticleData_Fluid_50.bgeo", 4732, true),
        ("dam_break_frame_9_6859_particles.bgeo", 6859, true),
        ("hilbert_46843_particles.bgeo", 46_843, false),
        ("ParticleData_Fluid_5.vtk", 4732, true),
        ("bunny_frame_14_7705_particles.vtk", 7706, true),
        ("cube_2366_particles.vtk", 2366, false),
        ("cube_8_particles.vtk", 8, false),
    ];
    for (name, count, has_velocities) in expected {
        let read = read(&Context::serial(), &folder.join(name)).unwrap();
        assert_eq!(read.particles.points.len(), count, "{name}");
        assert_eq!(read.particles.velocities().is_some() && read.particles.numbers.is_some(), has_velocities, "{name}");
        assert!(read.notes.is_empty(), "{name}: {:?}", read.notes);
    }
    let error = read(&Context::serial(), &folder.join("fluid_250_particles.vtu")).unwrap_err().to_string();
    assert!(error.contains("VTK's XML"), "{error}");
}
