//! Vectors that vertex shaders take: with a fragment shader in one text or in two, alone, and in several instances.

use relievo_gpu::Device;
use relievo_shaderlab::{
    Accumulation, Class, Classes, Example, Inputs, Language, Program, Runner, Setting, Shader, Source, Stage, Texture,
    Textures, Volume,
};

const SIZE: [u32; 2] = [20, 16];

fn shader(text: &str, language: Language, stage: Stage) -> Shader {
    Shader::new(Source::new("test", text, language, stage)).unwrap_or_else(|faults| panic!("{faults}"))
}

/// A wall that is seen from one side, two triangles whose corners have different depths, with a level at each corner.
fn wall() -> Inputs {
    let corner = |x: f64, y: f64, w: f64| [x * w, y * w, 0.5 * w, w];
    let [a, b, c, d] = [corner(-0.9, -0.9, 1.0), corner(0.8, -0.7, 3.0), corner(0.8, 0.7, 3.0), corner(-0.9, 0.9, 1.0)];
    let mut inputs = Inputs::default();
    inputs.numbers.insert("place".into(), [a, b, c, a, c, d].concat());
    inputs.numbers.insert("level".into(), vec![1.0, 2.0, 4.0, 1.0, 4.0, 3.0]);
    inputs
}

/// A vertex and a fragment shader in one text; the vertex shader takes three vectors and returns at two places.
fn text(way: &str, factor: &str) -> String {
    format!(
        "struct Out {{ @builtin(position) at: vec4<f32>, @location(0) shade: f32, @location(1) sure: f32 }}\n\
         @vertex fn vs(@location(0) place: vec4<f32>, @location(1) level: f32) -> Out {{\n    var out: Out;\n    \
         out.at = place;\n    out.shade = level;\n    for (var i = 0u; i < 3u; i++) {{\n        let v = level + f32(i);\n        \
         //. accumulation {way}\n        //. vector v; level * f32(i); f32(i)\n    }}\n    out.sure = 1.0 {factor};\n    \
         if level > 3.5 {{ return out; }}\n    return out;\n}}\n\
         @fragment fn fs(in: Out) -> @location(0) vec4<f32> {{ return vec4<f32>(in.shade, in.sure, 0.0, 1.0); }}\n"
    )
}

fn runners(device: &Device, text: &str, inputs: &Inputs) -> (Runner, Runner, Classes) {
    let shader = shader(text, Language::Wgsl, Stage::Fragment);
    let augmented = shader.augment().unwrap_or_else(|faults| panic!("{faults}"));
    let plain = Runner::new(device, &Program::plain(&shader).unwrap(), None, SIZE, inputs).unwrap();
    let program = Program::augmented(&shader, &augmented).unwrap();
    (plain, Runner::new(device, &program, None, SIZE, inputs).unwrap(), Classes::of(&augmented))
}

#[test]
fn a_pixel_has_the_interpolated_vectors_of_its_triangle() {
    let Some(device) = relievo_testing::device() else { return };
    for (way, name) in Accumulation::ALL {
        let (plain, marked, classes) = runners(&device, &text(name, ""), &wall());
        let picture = plain.picture(None).unwrap();
        assert_eq!(picture.data(), marked.picture(Some(&classes)).unwrap().data(), "{name}");
        assert!(marked.classify(&classes, [0, 0]).unwrap_err().what.contains("takes no vector"));
        let pixels = [[3, 8], [10, 8], [16, 7], [16, 9], [9, 5], [2, 12]];
        for pixel in pixels {
            let log = marked.classify(&classes, pixel).unwrap();
            // What the device itself interpolates between the corners.
            let level = picture.pixel(pixel[0], pixel[1])[0];
            assert!((1.0..=4.0).contains(&level), "{pixel:?} shows the wall");
            assert_eq!((log.taken, log.weights.len(), log.vectors.len()), (9, 9, 18));
            assert!((log.weights.iter().sum::<f32>() - 3.0).abs() < 1e-5);
            let expected = way.of(2, &log.weights, &log.vectors).unwrap();
            for (a, b) in log.vector.iter().zip(&expected) {
                assert!((a - b).abs() <= 1e-5 * b.abs().max(1.0), "{name}: {:?} is not {expected:?}", log.vector);
            }
            if way == Accumulation::Average {
                let [first, second] = [level + 5.0 / 3.0, level * 5.0 / 3.0];
                assert!((log.vector[0] - first).abs() < 2e-4, "{pixel:?}: {:?} is not {first}", log.vector);
                assert!((log.vector[1] - second).abs() < 4e-4, "{pixel:?}: {:?} is not {second}", log.vector);
            }
        }
        let mut taught = classes.clone();
        for (pixel, class) in [([3, 8], Class::Positive), ([16, 7], Class::Negative)] {
            let vector = marked.classify(&classes, pixel).unwrap().vector;
            taught.examples.push(Example { pixel, class, vector });
        }
        let mask = marked.mask(&taught).unwrap();
        for pixel in pixels {
            let expected = taught.membership(&marked.classify(&classes, pixel).unwrap().vector);
            let found = mask.pixel(pixel[0], pixel[1])[0];
            assert!((found - expected).abs() < 1e-5, "{name} {pixel:?}: {found} is not {expected}");
        }
        assert_eq!(mask.pixel(0, 0)[0], 0.5, "nothing is seen there");
        assert!(way != Accumulation::Average || (mask.pixel(3, 8)[0] > 0.999 && mask.pixel(16, 7)[0] < 0.001));
        assert_eq!(picture.data(), marked.picture(Some(&classes)).unwrap().data());
    }
}

#[test]
fn confidence_in_a_vertex_shader_is_the_membership_of_its_vertex() {
    let Some(device) = relievo_testing::device() else { return };
    let (plain, marked, mut classes) = runners(&device, &text("last", "/*. * confidence */"), &wall());
    assert_eq!(plain.picture(None).unwrap().pixel(9, 8)[1], 1.0);
    assert_eq!(marked.picture(None).unwrap().pixel(9, 8)[1], 0.5);
    // The last vector of a corner is (level + 2, 2 level): the corners at the left are sure, those at the right are not.
    for (level, class) in
        [(1.0, Class::Positive), (3.0, Class::Positive), (2.0, Class::Negative), (4.0, Class::Negative)]
    {
        classes.examples.push(Example { pixel: [0, 0], class, vector: vec![level + 2.0, 2.0 * level] });
    }
    let picture = marked.picture(Some(&classes)).unwrap();
    let [left, middle, right] = [2, 9, 17].map(|x| picture.pixel(x, 8)[1]);
    assert!(left > 0.8 && right < 0.2 && middle < left && middle > right, "{left} {middle} {right}");
}

const VERTEX: &str = "#version 450\nlayout(set = 0, binding = 0) uniform Move { vec2 shift; };\n\
    layout(location = 0) in vec3 position;\nlayout(location = 0) out vec3 color;\nvoid main() {\n    \
    float height = position.y;\n    //. vector height; position.z; 1.0\n    color = position;\n    \
    gl_Position = vec4(position.xy + shift, 0.5, 1.0);\n    if (height > 0.5)\n        return;\n    color.z = 0.0;\n}\n";

const FRAGMENT: &str = "#version 450\nlayout(set = 0, binding = 0) uniform Look { float gain; };\n\
    layout(location = 0) in vec3 color;\nlayout(location = 0) out vec4 paint;\nvoid main() {\n    \
    float tone = color.x * gain;\n    paint = vec4(tone, color.yz, 1.0);\n}\n";

fn triangle() -> Inputs {
    let mut inputs = Inputs::default();
    inputs.numbers.insert("position".into(), vec![-1.0, -1.0, 1.0, 1.0, -1.0, 2.0, 0.0, 1.0, 3.0]);
    inputs.numbers.insert("shift".into(), vec![0.0, 0.0]);
    inputs.numbers.insert("gain".into(), vec![2.0]);
    inputs
}

#[test]
fn two_texts_make_a_pair_whose_bindings_do_not_meet() {
    let Some(device) = relievo_testing::device() else { return };
    let vertex = shader(VERTEX, Language::Glsl, Stage::Vertex);
    let of_vertices = vertex.augment().unwrap_or_else(|faults| panic!("{faults}"));
    let classes = Classes::of(&of_vertices);
    let plain = shader(FRAGMENT, Language::Glsl, Stage::Fragment);
    let program = Program::plain(&plain).unwrap().with_vertex(&vertex, Some(&of_vertices)).unwrap();
    let runner = Runner::new(&device, &program, None, SIZE, &triangle()).unwrap();
    // At the middle of a pixel the position is the place on the screen; the third feature of the corners is linear in it.
    let place = |[x, y]: [u32; 2]| [(2.0 * x as f32 + 1.0) / 20.0 - 1.0, 1.0 - (2.0 * y as f32 + 1.0) / 16.0];
    let pixel = [9, 9];
    let [x, y] = place(pixel);
    let picture = runner.picture(None).unwrap();
    assert!((picture.pixel(9, 9)[0] - 2.0 * x).abs() < 1e-4 && (picture.pixel(9, 9)[1] - y).abs() < 1e-4);
    assert_eq!(picture.pixel(0, 0), [0.0; 4]);
    let log = runner.classify(&classes, pixel).unwrap();
    assert_eq!(log.taken, 3);
    let expected = [y, 1.5 + 0.5 * x + 0.75 * (y + 1.0)];
    assert!(log.vector.iter().zip(expected).all(|(a, b)| (a - b).abs() < 1e-5), "{log:?} is not {expected:?}");
    // Uniforms of one name reach both, and those of each its own text.
    let mut moved = triangle();
    moved.numbers.insert("shift".into(), vec![0.5, 0.0]);
    let runner = Runner::new(&device, &program, None, SIZE, &moved).unwrap();
    let log = runner.classify(&classes, [14, 9]).unwrap();
    assert!((log.vector[0] - y).abs() < 1e-5, "{log:?}");
    // Vectors of both shaders are joined, those of the vertices first.
    let text = FRAGMENT.replace("    paint", "    //. vector tone; gain; 3.0\n    paint");
    let marked = shader(&text, Language::Glsl, Stage::Fragment);
    let augmented = marked.augment().unwrap();
    let program = Program::augmented(&marked, &augmented).unwrap().with_vertex(&vertex, Some(&of_vertices)).unwrap();
    let runner = Runner::new(&device, &program, None, SIZE, &triangle()).unwrap();
    let both = runner.classify(&classes, pixel).unwrap();
    assert_eq!((both.taken, both.weights[3]), (4, 3.0));
    let expected = [0.25 * y + 0.75 * 2.0 * x, 0.25 * expected[1] + 0.75 * 2.0];
    assert!(both.vector.iter().zip(expected).all(|(a, b)| (a - b).abs() < 1e-5), "{both:?} is not {expected:?}");
    assert!(runner.mask(&classes).unwrap_err().what.contains("vertices and fragments"));
    assert_eq!(runner.picture(None).unwrap().data(), picture.data());
    // A fragment shader alone may take vectors, too.
    let program = Program::augmented(&marked, &augmented).unwrap().with_vertex(&vertex, None).unwrap();
    let runner = Runner::new(&device, &program, None, SIZE, &triangle()).unwrap();
    assert_eq!(runner.classify(&classes, pixel).unwrap().taken, 1);
    assert!(runner.mask(&classes).is_ok());
    // Two lengths do not go together.
    let short = shader(&text.replace("tone; gain; 3.0", "tone; 3.0"), Language::Glsl, Stage::Fragment);
    let program = Program::augmented(&short, &short.augment().unwrap()).unwrap();
    assert!(program.with_vertex(&vertex, Some(&of_vertices)).unwrap_err().what.contains("other features"));
    assert!(Program::plain(&plain).unwrap().with_vertex(&plain, None).is_err());
    // A variable of the vertex shader has its values at the corners.
    let setting =
        Setting { device: &device, vertex: None, entry: None, size: SIZE, inputs: &moved_without_gain(triangle()) };
    let values = vertex.values(&setting, &mut Textures::default(), pixel).unwrap();
    let index = vertex.variables().iter().position(|it| it.name == "height").unwrap();
    let height = values[index].as_ref().unwrap();
    assert_eq!((height.taken, height.low[0], height.high[0]), (3, -1.0, 1.0));
    assert!((height.mean[0] - y).abs() < 1e-5, "{height:?}");
}

/// The inputs of the vertex shader alone.
fn moved_without_gain(mut inputs: Inputs) -> Inputs {
    inputs.numbers.remove("gain");
    inputs
}

#[test]
fn a_vertex_shader_runs_alone_with_instances_and_without_inputs() {
    let Some(device) = relievo_testing::device() else { return };
    // A triangle at the left and one at the right, the nearer of which lies over it in part.
    let text = "struct Out { @builtin(position) at: vec4<f32>, @location(0) color: vec3<f32> }\n\
        @vertex fn vs(@builtin(vertex_index) v: u32, @builtin(instance_index) n: u32) -> Out {\n    \
        let x = f32(v % 2u) * 2.0 - 1.0 + f32(n) * 0.5;\n    let y = f32(v / 2u) * 2.0 - 1.0;\n    \
        let number = f32(10u * n + v);\n    //. vector number; f32(n); 1.0\n    \
        return Out(vec4<f32>(x, y, 0.5 - 0.25 * f32(n), 1.0), vec3<f32>(f32(n), 0.25, 0.5));\n}\n";
    let inputs = Inputs { instances: Some(2), ..Inputs::default() };
    let (plain, marked, classes) = runners(&device, text, &inputs);
    let picture = plain.picture(None).unwrap();
    assert_eq!(picture.data(), marked.picture(None).unwrap().data());
    for (pixel, instance) in [([1, 12], 0.0), ([15, 14], 1.0), ([6, 14], 1.0)] {
        let found = picture.pixel(pixel[0], pixel[1])[0];
        assert!((found - instance).abs() < 1e-5, "{pixel:?}: {found}");
        let log = marked.classify(&classes, pixel).unwrap();
        assert!(log.taken == 3 && (log.vector[1] - instance).abs() < 1e-5, "{log:?}");
        let numbers: Vec<_> = log.vectors.chunks_exact(2).map(|vector| vector[0]).collect();
        assert_eq!(numbers, [0.0, 1.0, 2.0].map(|v| 10.0 * instance + v));
    }
    // Old dialects, a return before the end, and numbers of several vertices of which some are drawn.
    let text = "attribute vec3 position;\nuniform float lift;\nvarying vec2 uv;\nvoid main() {\n    float h = position.z + lift;\n    \
        //. vector h; 1.0\n    uv = position.xy;\n    gl_Position = vec4(position.xy, 0.5, 1.0);\n    return;\n}\n";
    let old = shader(text, Language::Glsl, Stage::Vertex);
    let augmented = old.augment().unwrap_or_else(|faults| panic!("{faults}"));
    let mut inputs = triangle();
    inputs.numbers.retain(|name, _| name == "position");
    inputs.numbers.insert("lift".into(), vec![4.0]);
    inputs.numbers.get_mut("position").unwrap().extend([9.0; 9]);
    inputs.vertices = Some(3);
    let program = Program::augmented(&old, &augmented).unwrap();
    let runner = Runner::new(&device, &program, None, SIZE, &inputs).unwrap();
    let log = runner.classify(&Classes::of(&augmented), [9, 15]).unwrap();
    assert!((log.vector[0] - (4.0 + 1.475 + 0.75 * 0.0625)).abs() < 1e-4, "{log:?}");
}

#[test]
fn faulty_inputs_of_vertices_are_refused_with_their_names() {
    let Some(device) = relievo_testing::device() else { return };
    let shader = shader(&text("last", ""), Language::Wgsl, Stage::Fragment);
    let program = Program::augmented(&shader, &shader.augment().unwrap()).unwrap();
    let refused = |change: &dyn Fn(&mut Inputs)| {
        let mut inputs = wall();
        change(&mut inputs);
        Runner::new(&device, &program, None, SIZE, &inputs).unwrap_err()
    };
    let error = refused(&|inputs| drop(inputs.numbers.remove("level")));
    assert!(error.place.contains("level") && error.what.contains("no numbers"), "{error}");
    let error = refused(&|inputs| drop(inputs.numbers.insert("level".into(), vec![1.0; 5])));
    assert!(error.place.contains("level") && error.what.contains("6 of `place`"), "{error}");
    let error = refused(&|inputs| drop(inputs.numbers.insert("place".into(), vec![1.0; 5])));
    assert!(error.what.contains("no multiple of 4"), "{error}");
    let error = refused(&|inputs| drop(inputs.numbers.insert("levle".into(), vec![1.0; 6])));
    assert!(error.remedy.contains("`level`"), "{error}");
    assert!(refused(&|inputs| inputs.vertices = Some(7)).what.contains("have 6"));
    assert!(refused(&|inputs| inputs.instances = Some(0)).place.contains("vertices"));
    assert!(refused(&|inputs| inputs.instances = Some(u32::MAX)).place.contains("vertices"));
    // Without any of its inputs, vectors of the vertex shader cannot be taken.
    let error = refused(&|inputs| inputs.numbers.clear());
    assert!(error.place.contains("place"), "{error}");
}

#[test]
fn textures_are_sent_once_for_all_runs_that_share_them() {
    let Some(device) = relievo_testing::device() else { return };
    let text = "@group(0) @binding(0) var body: texture_3d<f32>;\n@group(0) @binding(1) var linear: sampler;\n\
        @fragment fn fs(@location(0) uv: vec2<f32>) -> @location(0) vec4<f32> {\n    \
        let v = textureSampleLevel(body, linear, vec3<f32>(uv, 0.5), 0.0).r;\n    let w = v * 2.0;\n    \
        return vec4<f32>(w);\n}\n";
    let shader = shader(text, Language::Wgsl, Stage::Fragment);
    let volume = Volume { size: [32; 3], spacing: [1.0; 3], values: (0..32 * 32 * 32).map(|it| it as f32).collect() };
    let mut inputs = Inputs::default();
    inputs.textures.insert("body".into(), Texture::Volume(volume));
    let program = Program::plain(&shader).unwrap();
    let mut textures = Textures::default();
    let before = device.memory();
    let first = Runner::sharing(&device, &program, None, SIZE, &inputs, &mut textures).unwrap();
    let of_one = device.memory() - before;
    assert!(of_one > 2 * 32 * 32 * 32, "{of_one}");
    let second = Runner::sharing(&device, &program, None, SIZE, &inputs, &mut textures).unwrap();
    let more = device.memory() - before - of_one;
    assert!(more < 32 * 32 * 32, "a second runner holds {more} bytes more, beside {of_one}");
    assert_eq!(first.picture(None).unwrap().data(), second.picture(None).unwrap().data());
    drop((first, second));
    assert!(device.memory() > before + 2 * 32 * 32 * 32, "the textures stay for the next run");
    let setting = Setting { device: &device, vertex: None, entry: None, size: SIZE, inputs: &inputs };
    let values = shader.values(&setting, &mut textures, [10, 8]).unwrap();
    let of = |name: &str| {
        let index = shader.variables().iter().position(|it| it.name == name).unwrap();
        values[index].as_ref().unwrap().mean[0]
    };
    assert!(of("v") > 0.4 && of("w") == 2.0 * of("v"));
    let held = device.memory();
    drop(textures);
    assert!(held - device.memory() >= 2 * 32 * 32 * 32);
}
