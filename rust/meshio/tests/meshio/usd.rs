//! USD against stages written by hand, its own writer, and damage. `tests/usd` holds it against OpenUSD and Blender.

use std::path::Path;

use glam::{DAffine3, DQuat, DVec3};
use relievo_core::{Attribute, Context, Crease, Domain, ErrorKind, Mesh, Result, Values};
use relievo_meshio::{
    Instance, Model, PointInstancer, Root, StageOptions, StageWriter, read, read_model, read_usd, read_usd_instancers,
    write,
};

fn stage(text: &str) -> Result<Model> {
    read_usd(text.as_bytes().to_vec(), 1 << 28, Path::new("."), &Root::none())
}

fn merged(text: &str) -> Mesh {
    stage(text).and_then(|model| model.merged_mesh(&Context::serial())).unwrap_or_else(|error| panic!("{error}"))
}

fn floats<'a>(mesh: &'a Mesh, name: &str) -> (&'a [f32], Domain, Option<&'a [u32]>) {
    match mesh.attribute(name) {
        Some(Attribute { values: Values::F32(values), domain, indices, .. }) => (values, *domain, indices.as_deref()),
        _ => panic!("there are no floats {name} in {:?}", mesh.attributes),
    }
}

/// Two quads beside each other, a metre each, with everything that a mesh can have.
const QUADS: &str = r#"#usda 1.0
(
    defaultPrim = "hall"
    metersPerUnit = 0.01
    upAxis = "Z"
    timeCodesPerSecond = 10
    startTimeCode = 5
)

def Xform "hall"
{
    double3 xformOp:translate = (0, 0, 100)
    uniform token[] xformOpOrder = ["xformOp:translate"]

    def Mesh "quads" (
        prepend apiSchemas = ["MaterialBindingAPI"]
    )
    {
        point3f[] points = [(0, 0, 0), (100, 0, 0), (200, 0, 0), (0, 100, 0), (100, 100, 0), (200, 100, 0)]
        vector3f[] velocities = [(0, 0, 100), (0, 0, 100), (0, 0, 100), (0, 0, 100), (0, 0, 100), (0, 0, 100)]
        int[] faceVertexCounts = [4, 4]
        int[] faceVertexIndices = [0, 1, 4, 3, 1, 2, 5, 4]
        int[] creaseIndices = [0, 1, 2, 4, 5]
        int[] creaseLengths = [3, 2]
        float[] creaseSharpnesses = [2, 3, 10]
        int[] cornerIndices = [3]
        float[] cornerSharpnesses = [4.5]
        int[] holeIndices = [1]
        color3f[] primvars:displayColor = [(0.5, 0.25, 1)] (
            interpolation = "constant"
        )
        texCoord2f[] primvars:st = [(0, 0), (1, 0), (1, 1), (0, 1)] (
            interpolation = "faceVarying"
        )
        int[] primvars:st:indices = [0, 1, 2, 3, 0, 1, 2, 3]
        float[] primvars:weight = [1, 2] (
            interpolation = "uniform"
        )
        float3[] primvars:force = [(1, 2, 3), (4, 5, 6), (7, 8, 9), (1, 1, 1), (2, 2, 2), (3, 3, 3)] (
            interpolation = "vertex"
        )
        rel material:binding = </hall/looks/clay>

        def GeomSubset "shiny"
        {
            uniform token elementType = "face"
            uniform token familyName = "materialBind"
            int[] indices = [1]
            rel material:binding = </hall/looks/gold>
        }
    }
}
"#;

#[test]
fn a_mesh_comes_with_tags_primvars_and_materials_in_metres_with_y_up() {
    let model = stage(QUADS).unwrap();
    assert_eq!(model.notes, Vec::<String>::new());
    assert_eq!(model.materials, ["clay", "gold"]);
    let mesh = merged(QUADS);
    let points: Vec<[f32; 3]> =
        [[0, 0], [1, 0], [2, 0], [0, 1], [1, 1], [2, 1]].map(|[x, y]| [x as f32, 1.0, -y as f32]).to_vec();
    assert_eq!(mesh.points, points);
    assert_eq!((&mesh.face_sizes[..], &mesh.corners[..]), (&[4, 4][..], &[0, 1, 4, 3, 1, 2, 5, 4][..]));
    let crease = |a, b, sharpness| Crease { points: [a, b], sharpness };
    assert_eq!(mesh.creases, [crease(0, 1, 2.0), crease(1, 2, 3.0), crease(4, 5, 10.0)]);
    assert_eq!((&mesh.sharp_points[..], &mesh.holes[..]), (&[(3, 4.5)][..], &[1][..]));
    assert_eq!(floats(&mesh, "color"), ([0.5, 0.25, 1.0].repeat(6).as_slice(), Domain::Point, None));
    let corners = [0, 1, 2, 3, 0, 1, 2, 3];
    assert_eq!(
        floats(&mesh, "uv"),
        (&[0.0, 0.0, 1.0, 0.0, 1.0, 1.0, 0.0, 1.0][..], Domain::Corner, Some(&corners[..]))
    );
    assert_eq!(floats(&mesh, "weight"), (&[1.0, 2.0][..], Domain::Face, None));
    assert_eq!(floats(&mesh, "force").0[..6], [1.0, 2.0, 3.0, 4.0, 5.0, 6.0]);
    assert_eq!(floats(&mesh, "velocity"), ([0.0, 1.0, 0.0].repeat(6).as_slice(), Domain::Point, None));
    assert_eq!(mesh.attribute("material").unwrap().values, Values::U32(vec![0, 1]));
    mesh.check().unwrap();
}

#[test]
fn left_handed_faces_are_turned_with_the_values_of_their_corners() {
    let text =
        QUADS.replace("int[] holeIndices", "uniform token orientation = \"leftHanded\"\n        int[] holeIndices");
    let mesh = merged(&text);
    assert_eq!(mesh.corners, [0, 3, 4, 1, 1, 4, 5, 2]);
    assert_eq!(floats(&mesh, "uv").2, Some(&[0, 3, 2, 1, 0, 3, 2, 1][..]));
    let unshared = text.replace("int[] primvars:st:indices = [0, 1, 2, 3, 0, 1, 2, 3]", "").replace(
        "[(0, 0), (1, 0), (1, 1), (0, 1)] (",
        "[(0, 0), (1, 0), (2, 0), (3, 0), (4, 0), (5, 0), (6, 0), (7, 0)] (",
    );
    let mesh = merged(&unshared);
    let u: Vec<f32> = floats(&mesh, "uv").0.iter().step_by(2).copied().collect();
    assert_eq!(u, [0.0, 3.0, 2.0, 1.0, 4.0, 7.0, 6.0, 5.0]);
}

#[test]
fn points_and_transforms_move_over_time() {
    let moving = QUADS
        .replace(
            "double3 xformOp:translate = (0, 0, 100)",
            "double3 xformOp:translate.timeSamples = { 5: (0, 0, 0), 15: (0, 0, 200) }",
        )
        .replace(
            "point3f[] points = [",
            "point3f[] points.timeSamples = {
                10: [(0, 0, 0), (100, 0, 0), (200, 0, 0), (0, 100, 0), (100, 100, 0), (200, 100, 0)],
                20: [(0, 0, 0), (100, 0, 0), (200, 0, 0), (0, 100, 0), (100, 100, 0), (200, 100, 50)],
            }
            point3f[] points = [",
        );
    let model = stage(&moving).unwrap();
    let context = Context::serial();
    assert_eq!(model.animations.len(), 1);
    assert_eq!(model.animations[0].range(), (0.0, 1.5));
    // Second 0 is time code 5, and a second has ten.
    for (time, place, height) in [(0.0, 0.0, 0.0), (0.5, 1.0, 0.0), (1.0, 2.0, 0.25), (1.5, 2.0, 0.5), (9.0, 2.0, 0.5)]
    {
        let points = model.pose(&context, 0, time).unwrap().merged_points();
        assert!((f64::from(points[0][1]) - place).abs() < 1e-6, "{time}: {:?}", points[0]);
        assert!((f64::from(points[5][1]) - place - height).abs() < 1e-6, "{time}: {:?}", points[5]);
    }
    assert_eq!(model.merged_mesh(&context).unwrap().points[0], [0.0; 3]);
    // Points that become more stand still.
    let model = stage(&moving.replace("(200, 100, 50)]", "(200, 100, 50), (1, 1, 1)]")).unwrap();
    assert!(model.notes.iter().any(|note| note.contains("time code 20")), "{:?}", model.notes);
    assert_eq!(model.pose(&context, 0, 1.5).unwrap().merged_points()[5], [2.0, 2.0, -1.0]);
}

/// Triangles through every kind of arc.
const ARCS: &str = r#"#usda 1.0
(
    metersPerUnit = 1
    subLayers = [@over.usda@ (offset = 10; scale = 2)]
)
class "base"
{
    point3f[] points = [(0, 0, 0), (1, 0, 0), (0, 1, 0)]
    int[] faceVertexCounts = [3]
    int[] faceVertexIndices = [0, 1, 2]
}
def Mesh "inherited" (
    inherits = </base>
)
{
    point3f[] points = [(0, 0, 1), (1, 0, 1), (0, 1, 1)]
}
def "referenced" (
    prepend references = @part.usda@
    variants = {
        string size = "large"
    }
)
{
}
def "copied" (
    references = </inherited>
)
{
}
def "loaded" (
    payload = @part.usda@</part/inner>
)
{
}
def Mesh "hidden" (
    active = false
    inherits = </base>
)
{
}
def Mesh "guide" (
    inherits = </base>
)
{
    uniform token purpose = "guide"
}
over "none" (
    inherits = </base>
)
{
}
"#;

const PART: &str = r#"#usda 1.0
(
    defaultPrim = "part"
)
def Xform "part" (
    variantSets = "size"
    variants = {
        string size = "small"
    }
)
{
    def Mesh "inner"
    {
        point3f[] points = [(0, 0, 2), (1, 0, 2), (0, 1, 2)]
        int[] faceVertexCounts = [3]
        int[] faceVertexIndices = [0, 1, 2]
    }
    variantSet "size" = {
        "small" {
        }
        "large" {
            float3 xformOp:scale = (3, 3, 3)
            uniform token[] xformOpOrder = ["xformOp:scale"]
            def Mesh "more"
            {
                point3f[] points = [(0, 0, 3), (1, 0, 3), (0, 1, 3)]
                int[] faceVertexCounts = [3]
                int[] faceVertexIndices = [0, 1, 2]
            }
        }
    }
}
"#;

const OVER: &str = r#"#usda 1.0
over "inherited"
{
    float3 xformOp:translate.timeSamples = { 0: (0, 0, 0), 24: (24, 0, 0) }
    uniform token[] xformOpOrder = ["xformOp:translate"]
}
"#;

#[test]
fn arcs_are_composed_and_files_outside_are_left_out() {
    let folder = tempfile::tempdir().unwrap();
    for (name, text) in [("main.usda", ARCS), ("part.usda", PART), ("over.usda", OVER)] {
        std::fs::write(folder.path().join(name), text).unwrap();
    }
    let context = Context::serial();
    let model = read_model(&context, &folder.path().join("main.usda")).unwrap();
    let names: Vec<&str> = model.meshes.iter().map(|part| part.name.as_str()).collect();
    assert_eq!(names, ["inherited", "more", "inner", "copied", "loaded"], "{:?}", model.notes);
    let mesh = model.merged_mesh(&context).unwrap();
    let heights: Vec<f32> = mesh.points.iter().step_by(3).map(|point| point[2]).collect();
    assert_eq!(heights, [1.0, 9.0, 6.0, 1.0, 2.0]);
    // The offset of the sublayer is 10 and its scale 2: its time code 12 is 34 here.
    let points = model.pose(&context, 0, 34.0 / 24.0).unwrap().merged_points();
    assert!((points[0][0] - 12.0).abs() < 1e-5, "{:?}", points[0]);

    std::fs::create_dir(folder.path().join("deep")).unwrap();
    let outside = ARCS.replace("@part.usda@", "@../part.usda@").replace("@over.usda@", "@http://x/over.usda@");
    std::fs::write(folder.path().join("deep/main.usda"), outside).unwrap();
    let model = read_model(&context, &folder.path().join("deep/main.usda")).unwrap();
    assert_eq!(model.meshes.len(), 2);
    assert!(model.notes.iter().any(|note| note.contains("outside the folders")), "{:?}", model.notes);
    assert!(model.notes.iter().any(|note| note.contains("nothing is fetched")), "{:?}", model.notes);
}

#[test]
fn what_grows_without_bound_is_refused() {
    let triangle = "point3f[] points = [(0, 0, 0), (1, 0, 0), (0, 1, 0)]\nint[] faceVertexCounts = [3]\n\
                    int[] faceVertexIndices = [0, 1, 2]\n";
    let circle = "#usda 1.0\ndef \"a\" ( references = </b> ) {}\ndef \"b\" ( references = </a> ) {}\n";
    assert!(stage(circle).unwrap_err().what.contains("lead on to one another"));
    let within = format!("#usda 1.0\ndef Mesh \"a\" {{ {triangle} def \"b\" ( references = </a> ) {{}} }}\n");
    assert!(stage(&within).is_err());
    // Every prim stands for two of the next: 2²⁸ in all.
    let pair = |index: usize| {
        let next = index + 1;
        format!("def \"p{index}\" ( inherits = </p{next}>\n references = </p{next}> ) {{}}\n")
    };
    let doubling = format!("#usda 1.0\n{}def \"p28\" {{}}\n", (0..28).map(pair).collect::<String>());
    let error = stage(&doubling).unwrap_err();
    assert!(error.what.contains("multiply") || error.kind == ErrorKind::Memory, "{error}");
    let same = format!("#usda 1.0\n{}", "def \"a\" { ".repeat(100_000));
    assert!(stage(&same).unwrap_err().what.contains("nested"));

    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a.usda");
    std::fs::write(&path, "#usda 1.0\n( subLayers = [@a.usda@, @a.usda@] )\n").unwrap();
    assert!(read(&Context::serial(), &path).is_err());
}

#[test]
fn meshes_that_contradict_themselves_are_refused_at_their_prim() {
    for (from, to, says) in [
        ("faceVertexCounts = [4, 4]", "faceVertexCounts = [4, 5]", "corners"),
        ("1, 2, 5, 4]", "1, 2, 6, 4]", "point 6"),
        ("(200, 100, 0)]", "(200, 100, 1e400)]", "finite"),
        ("(200, 100, 0)]", "(200, 100, inf)]", "finite"),
        ("creaseIndices = [0,", "creaseIndices = [9,", "points 9 and 1"),
        ("creaseLengths = [3, 2]", "creaseLengths = [3, 3]", "creases"),
        ("cornerIndices = [3]", "cornerIndices = [6]", "corners"),
        ("holeIndices = [1]", "holeIndices = [2]", "hole 2"),
        ("indices = [1]", "indices = [2]", "face"),
        ("faceVertexIndices = [0,", "faceVertexIndices = [-1,", "no index"),
    ] {
        let error = stage(&QUADS.replacen(from, to, 1)).unwrap_err();
        assert!(error.to_string().contains(says) && error.to_string().contains("/hall/quads"), "{to}: {error}");
    }
    for text in
        ["#usda 1.0\n", "#usda 2.0\ndef \"a\" {}", "PXR-USDC", "PK\u{3}\u{4}", "#usda 1.0\ndef Mesh \"a\" {}", "x"]
    {
        assert!(stage(text).is_err(), "{text}");
    }
}

/// Everything that a mesh can have.
fn rich() -> Mesh {
    let mut mesh = Mesh::new(
        (0..9).map(|index| [(index % 3) as f32 * 0.1, (index / 3) as f32 / 3.0, index as f32 * 1e-7]).collect(),
        vec![4, 4, 4, 3, 3],
        vec![0, 1, 4, 3, 1, 2, 5, 4, 3, 4, 7, 6, 4, 5, 8, 4, 8, 7],
    );
    mesh.creases = vec![Crease { points: [4, 5], sharpness: 2.5 }, Crease { points: [1, 4], sharpness: 10.0 }];
    mesh.sharp_points = vec![(8, 3.25)];
    mesh.holes = vec![2];
    let mut add = |name: &str, domain, width, values, indices| {
        mesh.attributes.push(Attribute { name: name.into(), domain, width, values, indices });
    };
    let ramp = |count: usize| Values::F32((0..count).map(|number| number as f32 / 7.0).collect());
    add("color", Domain::Point, 4, ramp(36), None);
    add("material", Domain::Face, 1, Values::U32(vec![1, 0, 1, 0, 0]), None);
    add("tension", Domain::Point, 1, ramp(9), None);
    add("uv", Domain::Corner, 2, ramp(8), Some((0..18).map(|corner| corner % 4).collect()));
    add("velocity", Domain::Point, 3, ramp(27), None);
    add("count", Domain::Corner, 1, Values::U32((0..18).collect()), None);
    add("plane", Domain::Face, 4, ramp(20), None);
    mesh
}

fn sorted(mut mesh: Mesh) -> Mesh {
    mesh.attributes.sort_by(|a, b| a.name.cmp(&b.name));
    mesh
}

#[test]
fn what_is_written_is_read_back() {
    let folder = tempfile::tempdir().unwrap();
    let (mesh, context) = (rich(), Context::serial());
    for name in ["a.usda", "a.usd"] {
        let path = folder.path().join(name);
        write(&path, &mesh).unwrap();
        let model = read_model(&context, &path).unwrap();
        assert_eq!(model.notes, Vec::<String>::new(), "{name}");
        assert_eq!(model.materials, ["material_0", "material_1"]);
        assert_eq!(sorted(read(&context, &path).unwrap()), sorted(mesh.clone()), "{name}");
    }
    assert!(write(&folder.path().join("a.usdc"), &mesh).is_err());
}

#[test]
fn frames_become_time_samples_with_velocities() {
    let folder = tempfile::tempdir().unwrap();
    let (mut mesh, context) = (rich(), Context::serial());
    mesh.attributes.retain(|attribute| attribute.name == "uv");
    let options = StageOptions { time_codes_per_second: 25.0, ..StageOptions::default() };
    for name in ["a.usda"] {
        let path = folder.path().join(name);
        let mut writer = StageWriter::new(&options, 1 << 24).unwrap();
        let still = rich();
        let move_to = |frame: f32| DAffine3::from_translation(glam::DVec3::X * f64::from(frame));
        for frame in 0..5u8 {
            let frame = f32::from(frame);
            let mut moved = mesh.clone();
            moved.points.iter_mut().for_each(|point| point[2] = frame * frame);
            let instances =
                [Instance { transform: move_to(frame), ..Instance::new("a b", &moved) }, Instance::new("a b", &still)];
            writer.frame(f64::from(frame) + 1.0, &instances).unwrap();
            assert!(writer.frame(f64::from(frame), &instances).is_err());
            assert!(writer.frame(100.0, &instances[..1]).is_err());
        }
        writer.finish(&path).unwrap();
        let model = read_model(&context, &path).unwrap();
        assert_eq!((model.notes.len(), model.meshes.len()), (0, 2));
        assert_eq!(model.animations[0].range(), (0.0, 4.0 / 25.0));
        let points = model.pose(&context, 0, 2.5 / 25.0).unwrap().merged_points();
        assert!((points[0][0] - 2.5).abs() < 1e-6 && (points[0][2] - 6.5).abs() < 1e-6, "{:?}", points[0]);
        assert_eq!(points[9..], still.points);
        assert_eq!(sorted(model.meshes[1].mesh.clone()), sorted(still));
        // At rest is the first frame, from which to the second the points rise by 1 in a frame.
        assert_eq!(floats(&model.meshes[0].mesh, "velocity").0[..3], [0.0, 0.0, 25.0]);
    }
    let mut small = StageWriter::new(&options, 4096).unwrap();
    let error = (0..9).find_map(|code| small.frame(f64::from(code), &[Instance::new("a", &mesh)]).err());
    assert!(error.is_some_and(|error| error.kind == ErrorKind::Memory));
    assert!(StageWriter::new(&options, 1).unwrap().finish(&folder.path().join("b.usda")).is_err());
    assert!(StageWriter::new(&StageOptions { meters_per_unit: f64::NAN, ..options }, 1).is_err());
}

fn instancers(text: &str) -> Result<Vec<PointInstancer>> {
    read_usd_instancers(text.as_bytes().to_vec(), 1 << 28, Path::new("."), &Root::none())
}

/// Copies in centimetres with z up, below a prim that is moved; the last two are off.
const COPIES: &str = r#"#usda 1.0
(
    metersPerUnit = 0.01
    upAxis = "Z"
)
def Xform "square"
{
    double3 xformOp:translate = (100, 0, 0)
    uniform token[] xformOpOrder = ["xformOp:translate"]
    def PointInstancer "people" (
        inactiveIds = [7]
    )
    {
        rel prototypes = [</square/people/tall>, </square/people/small>]
        int[] protoIndices = [0, 1, 0, 1]
        int64[] ids = [3, 5, 7, 9]
        int64[] invisibleIds = [9]
        point3f[] positions = [(0, 0, 0), (200, 100, 50), (1, 1, 1), (1, 1, 1)]
        quath[] orientations = [(1, 0, 0, 0), (0.5, 0, 0, 0.5), (1, 0, 0, 0), (1, 0, 0, 0)]
        float3[] scales = [(1, 1, 1), (2, 2, 2), (1, 1, 1), (1, 1, 1)]
        vector3f[] velocities = [(0, 0, 0), (40, 0, 0), (0, 0, 0), (0, 0, 0)]
        string[] primvars:clip = ["nod", "bow", "bow", "bow"]
        float[] primvars:phase = [0.5]
        def Xform "tall" { }
        def Xform "small" { }
    }
}
"#;

#[test]
fn copies_of_point_instancers_are_placed_in_metres_with_y_up() {
    let found = instancers(COPIES).unwrap();
    assert_eq!(found.len(), 1);
    assert_eq!((found[0].path.as_str(), found[0].prototypes[1].as_str()), ("/square/people", "/square/people/small"));
    let copies = &found[0].copies;
    assert_eq!(copies.len(), 2, "{copies:?}");
    let (first, second) = (&copies[0], &copies[1]);
    assert_eq!((first.prototype, first.clip.as_str(), first.phase), (0, "nod", 0.5));
    assert!(first.transform.abs_diff_eq(DAffine3::from_translation(DVec3::X), 1e-12), "{first:?}");
    assert_eq!((second.prototype, second.clip.as_str(), second.phase), (1, "bow", 0.5));
    // z up at (300, 100, 50) is y up at (3, 0.5, -1), and a quarter turn about z one about y.
    let quarter = DQuat::from_rotation_y(std::f64::consts::FRAC_PI_2);
    let expected = DAffine3::from_scale_rotation_translation(DVec3::splat(2.0), quarter, DVec3::new(3.0, 0.5, -1.0));
    assert!(second.transform.abs_diff_eq(expected, 1e-6), "{second:?}");
    assert!(second.velocity.abs_diff_eq(DVec3::new(0.4, 0.0, 0.0), 1e-6));
    // Damage is an error that names the prim.
    for (from, to) in [
        ("[0, 1, 0, 1]", "[0, 2, 0, 1]"),
        ("[0, 1, 0, 1]", "[0, 1, 0]"),
        ("(200, 100, 50)", "(inf, 100, 50)"),
        ("(0.5, 0, 0, 0.5)", "(0, 0, 0, 0)"),
        ("= [0.5]", "= [0.5, 1]"),
    ] {
        let error = instancers(&COPIES.replace(from, to)).unwrap_err();
        assert!(error.to_string().contains("/square/people"), "{error}");
    }
    assert!(instancers("#usda 1.0\ndef Xform \"a\" { }\n").unwrap().is_empty());
}
