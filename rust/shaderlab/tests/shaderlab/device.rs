//! Shaders on a graphics device: pictures of plain and augmented shaders, logs, and both ways to run.

use relievo_core::Result;
use relievo_gpu::Device;
use relievo_render::Image;
use relievo_shaderlab::{
    Accumulation, Class, Classes, Example, Inputs, Language, Log, Program, Runner, Setting, Shader, Source, Stage,
    Texture, Textures, Value, Volume,
};

const SIZE: [u32; 2] = [24, 16];

/// A shader that takes eight vectors a pixel, with `way` to accumulate and `factor` for its colour.
fn text(way: &str, factor: &str, is_compute: bool) -> String {
    let body = format!(
        "    let uv = p * vec2<f32>(0.0625, 0.125);\n    var sum = 0.0;\n    for (var i = 0u; i < 8u; i++) {{\n        \
         let v = uv.x * f32(i) + uv.y;\n        //. accumulation {way}\n        //. vector v; uv.y - f32(i); f32(i)\n        \
         if v > 1.0 {{ sum += v * 0.0625; }}\n    }}\n    let color = vec4<f32>(sum {factor}, uv, 1.0);\n"
    );
    match is_compute {
        true => format!(
            "@group(0) @binding(0) var out: texture_storage_2d<rgba32float, write>;\n\
             @compute @workgroup_size(8, 8) fn cs(@builtin(global_invocation_id) id: vec3<u32>) {{\n    \
             let p = vec2<f32>(id.xy) + 0.5;\n{body}    textureStore(out, id.xy, color);\n}}\n"
        ),
        false => format!(
            "@fragment fn fs(@builtin(position) at: vec4<f32>) -> @location(0) vec4<f32> {{\n    let p = at.xy;\n{body}    \
             return color;\n}}\n"
        ),
    }
}

fn shader(text: &str, language: Language) -> Shader {
    Shader::new(Source::new("test", text, language, Stage::Fragment)).unwrap_or_else(|faults| panic!("{faults}"))
}

/// Runners of a shader as it is and augmented, and its classes without examples.
fn runners(device: &Device, shader: &Shader, inputs: &Inputs) -> (Runner, Runner, Classes) {
    let augmented = shader.augment().unwrap_or_else(|faults| panic!("{faults}"));
    let plain = Program::plain(shader).unwrap_or_else(|faults| panic!("{faults}"));
    let program = Program::augmented(shader, &augmented).unwrap_or_else(|faults| panic!("{faults}"));
    let plain = Runner::new(device, &plain, None, SIZE, inputs).unwrap();
    let marked = Runner::new(device, &program, None, SIZE, inputs).unwrap();
    (plain, marked, Classes::of(&augmented))
}

/// The values of the variables of a shader without inputs at a pixel.
fn values_at(device: &Device, shader: &Shader, pixel: [u32; 2]) -> Result<Vec<Result<Value>>> {
    let setting = Setting { device, vertex: None, entry: None, size: SIZE, inputs: &Inputs::default() };
    shader.values(&setting, &mut Textures::default(), pixel)
}

/// The vectors and weights that [`text`] takes at a pixel.
fn vectors([x, y]: [u32; 2]) -> (Vec<f32>, Vec<f32>) {
    let uv = [(x as f32 + 0.5) * 0.0625, (y as f32 + 0.5) * 0.125];
    let weights: Vec<_> = (0..8).map(|i| i as f32).collect();
    (weights.clone(), weights.iter().flat_map(|i| [uv[0] * i + uv[1], uv[1] - i]).collect())
}

#[test]
fn pictures_equal_and_logs_are_those_of_the_processor() {
    let Some(device) = relievo_testing::device() else { return };
    for (way, name) in Accumulation::ALL {
        for is_compute in [false, true] {
            let shader = shader(&text(name, "", is_compute), Language::Wgsl);
            let (plain, marked, classes) = runners(&device, &shader, &Inputs::default());
            let picture = plain.picture(None).unwrap();
            assert!(picture.data().iter().any(|value| *value > 1.5));
            assert_eq!(picture.data(), marked.picture(Some(&classes)).unwrap().data(), "{name}");
            for pixel in [[0, 0], [23, 15], [7, 9]] {
                let (weights, vectors) = vectors(pixel);
                let expected = way.of(2, &weights, &vectors).unwrap();
                let Log { vector, taken, weights: logged, vectors: taken_vectors } =
                    marked.classify(&classes, pixel).unwrap();
                assert_eq!((taken, &logged, &taken_vectors), (8, &weights, &vectors), "{name} {pixel:?}");
                for (a, b) in vector.iter().zip(&expected) {
                    assert!((a - b).abs() <= 1e-6 * b.abs().max(1.0), "{name}: {vector:?} is not {expected:?}");
                }
            }
            let mut taught = classes.clone();
            for (pixel, class) in [([3, 2], Class::Positive), ([20, 12], Class::Negative)] {
                let vector = marked.classify(&classes, pixel).unwrap().vector;
                taught.examples.push(Example { pixel, class, vector });
            }
            let mask = marked.mask(&taught).unwrap();
            for pixel in [[3, 2], [20, 12], [7, 9], [23, 0]] {
                let expected = taught.membership(&marked.classify(&classes, pixel).unwrap().vector);
                let found = mask.pixel(pixel[0], pixel[1])[0];
                assert!((found - expected).abs() < 1e-4, "{name} {pixel:?}: {found} is not {expected}");
            }
            // Classification changes no picture.
            assert_eq!(picture.data(), marked.picture(Some(&classes)).unwrap().data());
            assert!(marked.classify(&classes, [24, 0]).is_err());
            assert!(plain.classify(&classes, [0, 0]).is_err());
        }
    }
}

#[test]
fn confidence_is_the_membership_of_the_vector_taken_last() {
    let Some(device) = relievo_testing::device() else { return };
    for language in [Language::Wgsl, Language::Glsl] {
        let text = match language {
            Language::Wgsl => {
                "@fragment fn fs(@location(0) uv: vec2<f32>) -> @location(0) vec4<f32> {\n    \
                 //. vector uv.x; uv.y; 1.0\n    return vec4<f32>(1.0 /*. * confidence */, 0.0, 0.0, 1.0);\n}\n"
            }
            Language::Glsl => {
                "#version 450\nlayout(location = 0) in vec2 uv;\nlayout(location = 0) out vec4 color;\n\
                 void main() {\n    //. vector uv.x; uv.y; 1.0\n    color = vec4(1.0 /*. * confidence */, 0.0, 0.0, 1.0);\n}\n"
            }
        };
        let (plain, marked, mut classes) = runners(&device, &shader(text, language), &Inputs::default());
        assert!(plain.picture(None).unwrap().data().chunks_exact(4).all(|pixel| pixel[0] == 1.0));
        assert!(marked.picture(None).unwrap().data().chunks_exact(4).all(|pixel| pixel[0] == 0.5));
        for (pixel, class) in [([2, 3], Class::Positive), ([20, 12], Class::Negative), ([4, 14], Class::Negative)] {
            let vector = marked.classify(&classes, pixel).unwrap().vector;
            let expected = [(pixel[0] as f32 + 0.5) / 24.0, (pixel[1] as f32 + 0.5) / 16.0];
            assert!(vector.iter().zip(expected).all(|(a, b)| (a - b).abs() < 1e-5), "{vector:?} is not {expected:?}");
            classes.examples.push(Example { pixel, class, vector });
        }
        for (exponent, is_scaled) in [(2.0, false), (1.0, true), (5.0, false)] {
            classes.exponent = exponent;
            classes.is_scaled = is_scaled;
            let picture = marked.picture(Some(&classes)).unwrap();
            for (index, pixel) in picture.data().chunks_exact(4).enumerate() {
                let [x, y] = [index as u32 % 24, index as u32 / 24];
                let expected = classes.membership(&[(x as f32 + 0.5) / 24.0, (y as f32 + 0.5) / 16.0]);
                assert!((pixel[0] - expected).abs() < 2e-3, "{x}, {y}: {} is not {expected}", pixel[0]);
            }
            assert_eq!(picture.pixel(2, 3)[0], 1.0);
            assert_eq!(picture.pixel(20, 12)[0], 0.0);
        }
    }
}

#[test]
fn textures_volumes_and_uniforms_reach_the_shader() {
    let Some(device) = relievo_testing::device() else { return };
    let text = "#version 330\nuniform sampler2D photo;\nuniform float gain;\nuniform vec3 tint, other;\nuniform vec2 resolution;\n\
        in vec2 uv;\nout vec4 color;\nvoid main() {\n    vec4 texel = texture(photo, uv);\n    //. vector texel.r; texel.g; 1.0\n    \
        color = vec4(texel.rgb * gain + tint, resolution.x);\n}\n";
    let values: Vec<f32> =
        (0..24 * 16).flat_map(|index| [(index % 24) as f32 / 24.0, (index / 24) as f32 / 16.0, 0.25]).collect();
    let mut inputs = Inputs::default();
    inputs.textures.insert("photo".into(), Texture::Image(Image::from_data(24, 16, 3, values).unwrap()));
    inputs.numbers.insert("gain".into(), vec![2.0]);
    inputs.numbers.insert("tint".into(), vec![0.0, 0.5, 1.0]);
    let old = shader(text, Language::Glsl);
    let (plain, marked, classes) = runners(&device, &old, &inputs);
    let picture = plain.picture(None).unwrap();
    let pixel = picture.pixel(6, 4);
    for (found, expected) in pixel.iter().zip([0.5, 1.0, 1.5, 24.0]) {
        assert!((found - expected).abs() < 1e-3, "{pixel:?}");
    }
    assert_eq!(picture.data(), marked.picture(Some(&classes)).unwrap().data());
    // Names and counts of inputs are checked.
    let program = Program::plain(&old).unwrap();
    let mut wrong = inputs.clone();
    wrong.numbers.insert("gian".into(), vec![1.0]);
    let error = Runner::new(&device, &program, None, SIZE, &wrong).unwrap_err();
    assert!(error.remedy.contains("`gain`"), "{error}");
    wrong = inputs.clone();
    wrong.numbers.insert("tint".into(), vec![1.0]);
    assert!(Runner::new(&device, &program, None, SIZE, &wrong).is_err());
    inputs.textures.clear();
    let error = Runner::new(&device, &program, None, SIZE, &inputs).unwrap_err();
    assert!(error.place.contains("photo"), "{error}");
    let text = "@group(0) @binding(0) var body: texture_3d<f32>;\n@group(0) @binding(1) var linear: sampler;\n\
        @fragment fn fs(@location(0) uv: vec2<f32>) -> @location(0) vec4<f32> {\n    \
        let v = textureSampleLevel(body, linear, vec3<f32>(uv, 0.5), 0.0).r;\n    //. vector v; 1.0\n    return vec4<f32>(v);\n}\n";
    let values = (0..64).map(|index| (index % 4) as f32 * 10.0).collect();
    let volume = Volume { size: [4, 4, 4], spacing: [1.0; 3], values };
    inputs.numbers.clear();
    inputs.textures.insert("body".into(), Texture::Volume(volume));
    let (plain, _, _) = runners(&device, &shader(text, Language::Wgsl), &inputs);
    let picture = plain.picture(None).unwrap();
    assert!((picture.pixel(12, 8)[0] - 0.5277).abs() < 1e-2, "{:?}", picture.pixel(12, 8));
    assert_eq!(picture.pixel(0, 0)[0], 0.0);
}

#[test]
fn a_shader_that_never_ends_is_no_hang() {
    let Some(device) = relievo_testing::device() else { return };
    let text = "@fragment fn fs(@builtin(position) p: vec4<f32>) -> @location(0) vec4<f32> {\n    var v = p.x;\n    loop {\n        \
        v += 1.0;\n        //. vector v; 1.0\n        if v < 0.0 { break; }\n    }\n    return vec4<f32>(v);\n}\n";
    let shader = shader(text, Language::Wgsl);
    let augmented = shader.augment().unwrap();
    let program = Program::augmented(&shader, &augmented).unwrap();
    let runner = Runner::new(&device, &program, None, [2, 2], &Inputs::default()).unwrap();
    // Lavapipe stops the loop; another device may be lost. Both are results.
    if let Ok(log) = runner.classify(&Classes::of(&augmented), [1, 1]) {
        assert!(log.taken > 4096 && log.weights.len() == 4096);
    }
}

/// A head of concentric shells in two modalities: skin, skull and brain. Returns the value of both at a radius of 0 to 1.
fn head(radius: f32) -> [f32; 2] {
    match radius {
        _ if radius > 0.9 => [0.0, 0.0],
        _ if radius > 0.8 => [0.5, 0.3],
        _ if radius > 0.7 => [0.1, 1.0],
        _ if radius > 0.65 => [0.2, 0.3],
        _ => [0.7, 0.35],
    }
}

/// The first case study of the paper (Section 7.1): in a head that is cut open a pixel of the brain is positive, pixels of skull
/// and skin are negative; the head that is not cut shows its brain then.
#[test]
fn two_modalities_reveal_the_brain() {
    let Some(device) = relievo_testing::device() else { return };
    const EDGE: u32 = 48;
    let text = include_str!("../../../../examples/shaders/dual.wgsl");
    let shader = shader(text, Language::Wgsl);
    let augmented = shader.augment().unwrap_or_else(|faults| panic!("{faults}"));
    let names: Vec<_> = augmented.features.iter().map(|feature| feature.name.as_str()).collect();
    assert_eq!(names, ["MRI", "CT", "Gradient magnitude of MRI", "Gradient magnitude of CT"]);
    let program = Program::augmented(&shader, &augmented).unwrap_or_else(|faults| panic!("{faults}"));
    let mut inputs = Inputs::default();
    for (modality, name) in ["mri", "ct"].into_iter().enumerate() {
        let middle = 0.5 * (EDGE - 1) as f32;
        let value = |index: u32| {
            let place = [index % EDGE, index / EDGE % EDGE, index / EDGE / EDGE]
                .map(|at| (at as f32 - middle) / (middle + 0.5));
            head(place.iter().map(|at| at * at).sum::<f32>().sqrt())[modality]
        };
        let values = (0..EDGE * EDGE * EDGE).map(value).collect();
        inputs.textures.insert(name.into(), Texture::Volume(Volume { size: [EDGE; 3], spacing: [1.0; 3], values }));
    }
    for (name, number) in [("low", 0.1), ("high", 0.3), ("opacity", 0.5), ("steps", 120.0)] {
        inputs.numbers.insert(name.into(), vec![number]);
    }
    let runner = |inputs: &Inputs| Runner::new(&device, &program, None, [EDGE; 2], inputs).unwrap();
    let whole = runner(&inputs);
    inputs.numbers.insert("clip".into(), vec![0.5]);
    let cut = runner(&inputs);
    let none = Classes::of(&augmented);
    let mut classes = none.clone();
    (classes.exponent, classes.is_scaled) = (4.0, true);
    // At the cut, radii are distances from the middle: the brain, the skull, the skin above and beside it.
    for (pixel, class) in [
        ([24, 24], Class::Positive),
        ([42, 24], Class::Negative),
        ([24, 3], Class::Negative),
        ([44, 24], Class::Negative),
    ] {
        let vector = cut.classify(&none, pixel).unwrap().vector;
        classes.examples.push(Example { pixel, class, vector });
    }
    assert!((classes.examples[0].vector[0] - 1.0).abs() < 0.05, "the brain is the brightest of the MRI: {classes:?}");
    let (before, after) = (whole.picture(None).unwrap(), whole.picture(Some(&classes)).unwrap());
    // A ray beside the brain meets skin and skull alone; nothing of them is left.
    let ground = before.pixel(0, 0)[0];
    assert!(before.pixel(42, 24)[0] > ground + 0.2, "{:?}", before.pixel(42, 24));
    assert!(after.pixel(42, 24)[0] < ground + 0.05, "{:?}", after.pixel(42, 24));
    // In the middle the brain is seen, in the paint of bright voxels: its green part is that of the red one nearly.
    let share = |image: &Image| image.pixel(24, 24)[1] / image.pixel(24, 24)[0];
    assert!(share(&after) > share(&before) + 0.1, "{} {}", share(&before), share(&after));
    // Nothing else is classified: the vector of the middle of the whole head is that of the skin, which is negative.
    let skin = whole.classify(&none, [24, 24]).unwrap().vector;
    assert!(classes.membership(&skin) < 0.5, "{skin:?}");
}

#[test]
fn variables_have_their_values_at_a_pixel() {
    let Some(device) = relievo_testing::device() else { return };
    let text = text("max", "", false).replace("    let color", "    var late: f32;\n    late = sum;\n    let color");
    let shader = shader(&text, Language::Wgsl);
    let pixel = [7, 9];
    let values = values_at(&device, &shader, pixel).unwrap();
    let of = |name: &str| {
        let index = shader.variables().iter().position(|it| it.name == name).unwrap();
        values[index].as_ref()
    };
    let [x, y] = [7.5 * 0.0625, 9.5 * 0.125];
    let uv = of("uv").unwrap();
    assert_eq!((uv.taken, &uv.mean, &uv.low), (1, &vec![x, y], &vec![x, y]));
    // The vectors of the shader itself and its accumulation do not count: `v` is the mean of eight passes.
    let v = of("v").unwrap();
    assert_eq!((v.taken, v.low[0], v.high[0]), (8, y, 7.0 * x + y));
    assert!((v.mean[0] - (3.5 * x + y)).abs() < 1e-5, "{v:?}");
    let taken: f32 = (0..8).map(|i| x * i as f32 + y).filter(|v| *v > 1.0).sum();
    assert!((of("color").unwrap().mean[0] - 0.0625 * taken).abs() < 1e-5);
    assert!(of("late").unwrap_err().what.contains("gives it no value"));
    assert!(values_at(&device, &shader, [24, 0]).is_err());
}

#[test]
fn thousands_of_vectors_are_counted_and_those_with_room_are_read() {
    let Some(device) = relievo_testing::device() else { return };
    let text = "@fragment fn fs(@builtin(position) p: vec4<f32>) -> @location(0) vec4<f32> {\n    var sum = 0.0;\n    \
        for (var i = 0u; i < 5000u; i++) {\n        let v = f32(i % 10u);\n        //. vector v; 1.0\n        sum += v;\n    }\n    \
        return vec4<f32>(sum);\n}\n";
    let (_, marked, classes) = runners(&device, &shader(text, Language::Wgsl), &Inputs::default());
    let log = marked.classify(&classes, [3, 3]).unwrap();
    assert_eq!((log.taken, log.vectors.len()), (5000, relievo_shaderlab::MAX_VECTORS));
    assert!((log.vector[0] - 4.5).abs() < 1e-3 && log.vectors[4095] == 5.0, "{:?}", log.vector);
}

#[test]
fn what_a_device_has_no_room_for_or_has_lost_is_an_error() {
    let Some(device) = relievo_testing::device() else { return };
    let text = "@group(0) @binding(0) var body: texture_3d<f32>;\n@group(0) @binding(1) var linear: sampler;\n\
        @fragment fn fs(@location(0) uv: vec2<f32>) -> @location(0) vec4<f32> {\n    \
        let v = textureSampleLevel(body, linear, vec3<f32>(uv, 0.5), 0.0).r;\n    //. vector v; 1.0\n    return vec4<f32>(v);\n}\n";
    let shader = shader(text, Language::Wgsl);
    let program = Program::plain(&shader).unwrap();
    let most = device.limits().max_texture_dimension_3d;
    let mut inputs = Inputs::default();
    let mut give = |size: [u32; 3]| {
        let volume = Volume { size, spacing: [1.0; 3], values: vec![0.5; size.iter().product::<u32>() as usize] };
        inputs.textures.insert("body".into(), Texture::Volume(volume));
        Runner::new(&device, &program, None, SIZE, &inputs)
    };
    let error = give([most + 1, 1, 1]).unwrap_err();
    assert!(error.place.contains("body") && error.what.contains(&most.to_string()), "{error}");
    let runner = give([4, 4, 4]).unwrap();
    assert!(runner.picture(None).is_ok());
    device.abandon();
    assert!(!runner.picture(None).unwrap_err().what.is_empty());
}
