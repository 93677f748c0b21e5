//! What is not saved when a window ends for a reason of its own is written beside the files.

use relievo_gpu::{Device, DeviceOptions};
use relievo_shaderlab::{Class, Inputs, Project};
use relievo_view::shader::{Opening, Session};

#[test]
fn what_is_not_saved_is_rescued_beside_the_files() {
    let Ok(device) = Device::open(&DeviceOptions::default()) else {
        let is_required = std::env::var_os("RELIEVO_GPU_TESTS").is_some_and(|it| it == "required");
        assert!(!is_required, "there is no graphics device");
        println!("skipped: there is no graphics device");
        return;
    };
    let folder = tempfile::tempdir().unwrap();
    let [shader, file] = ["ramp.wgsl", "ramp.toml"].map(|name| folder.path().join(name));
    let text = "@fragment fn fs(@location(0) uv: vec2<f32>) -> @location(0) vec4<f32> {\n    //. vector uv.x; 1.0\n    \
        return vec4<f32>(uv, 0.0, 1.0);\n}\n";
    let saved = "version = 1\nshader = \"ramp.wgsl\"\nsize = [8, 4]\n";
    std::fs::write(&shader, text).unwrap();
    std::fs::write(&file, saved).unwrap();
    let project = Project::read(&file).unwrap();
    let opening = Opening { device, project, file: Some(file.clone()), inputs: Inputs::default(), size: [8, 4] };
    let mut session = Session::open(opening).unwrap();
    assert!(!session.is_changed() && session.rescue().unwrap().is_none());
    session.classify([6, 1], Class::Positive).unwrap();
    let rescued = session.rescue().unwrap().unwrap();
    assert_eq!(rescued, folder.path().join("ramp.toml.rescued"));
    assert!(std::fs::read_to_string(rescued).unwrap().contains("pixel = ["));
    assert_eq!(std::fs::read_to_string(folder.path().join("ramp.wgsl.rescued")).unwrap(), text);
    // The files themselves are as they were.
    assert_eq!(std::fs::read_to_string(&file).unwrap(), saved);
    assert!(session.is_changed());
}
