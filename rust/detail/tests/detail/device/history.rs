//! Undo, documents and journals of edits that a graphics device makes, which know nothing of it.

use std::path::Path;

use glam::{DAffine3, DVec3, Vec4};
use relievo_core::{Context, Mesh};
use relievo_detail::{
    Action, Canvas, DisplacedObject, Falloff, History, LayeredObject, PaintMode, Recorded, SculptMode, Stroke,
    StrokePoint, StrokeSettings, TriangleObject,
};
use relievo_document::Document;
use relievo_gpu::Device;
use relievo_surface::{Surface, SurfaceOptions, TriangleSurface};
use relievo_testing::device;
use relievo_tiles::triangle::{TriangleChannel, TriangleOptions};
use relievo_tiles::{ChannelOptions, Displacement, DisplacementOptions, Paint};

const LIMIT: u64 = 1 << 30;
const BLANK: Vec4 = Vec4::new(0.5, 0.25, 0.125, 1.0);

/// A square from 0 to 4 in z = 0, of unit faces with `corners` corners.
fn plane(corners: u32) -> Mesh {
    let points = (0..25).map(|k| [(k % 5) as f32, (k / 5) as f32, 0.0]).collect();
    let squares = (0..16).map(|k| k / 4 * 5 + k % 4).map(|a| [a, a + 1, a + 6, a + 5]);
    match corners {
        3 => {
            let halves: Vec<_> = squares.flat_map(|[a, b, c, d]| [[a, b, c], [a, c, d]]).collect();
            Mesh::from_triangles(points, &halves)
        }
        _ => Mesh::new(points, vec![4; 16], squares.flatten().collect()),
    }
}

/// An object that strokes are made on, on a device if there is one.
trait Object: Canvas + LayeredObject + Recorded {
    fn new(context: &Context, device: Option<&Device>) -> Self;

    fn empty(context: &Context) -> Document;

    fn is_sound(&mut self) -> bool;
}

impl Object for DisplacedObject {
    fn new(context: &Context, device: Option<&Device>) -> Self {
        let mesh = plane(4);
        let surface = Surface::new(context, &mesh, &SurfaceOptions::default()).unwrap();
        let topology = surface.topology().clone();
        let options = DisplacementOptions { size: 16, ..Default::default() };
        let displacement = Displacement::new(topology.clone(), &options).unwrap();
        let mut object = Self::new(context, surface, &mesh.points, displacement, DAffine3::IDENTITY).unwrap();
        let options = ChannelOptions { size: 16, ..Default::default() };
        object.set_paint(Paint::of_color(topology, BLANK, &options).unwrap()).unwrap();
        object.use_device(device).unwrap();
        object
    }

    fn empty(context: &Context) -> Document {
        Document::new(&plane(4), context.level().name()).unwrap()
    }

    fn is_sound(&mut self) -> bool {
        self.take_device_fault().is_none()
    }
}

impl Object for TriangleObject {
    fn new(context: &Context, device: Option<&Device>) -> Self {
        let surface = TriangleSurface::new(context, &plane(3)).unwrap();
        let options = TriangleOptions { segments: 8, ..Default::default() };
        let topology = surface.topology().clone();
        let displacement = TriangleChannel::displacement(topology.clone(), &options).unwrap();
        let mut object = Self::new(context, surface, displacement, DAffine3::IDENTITY).unwrap();
        object.set_paint(TriangleChannel::of_color(topology, BLANK, &options).unwrap()).unwrap();
        object.use_device(device).unwrap();
        object
    }

    fn empty(context: &Context) -> Document {
        Document::of_triangles(&plane(3), context.level().name()).unwrap()
    }

    fn is_sound(&mut self) -> bool {
        self.take_device_fault().is_none()
    }
}

fn stored<O: Object>(context: &Context, object: &mut O) -> Document {
    let mut document = O::empty(context);
    object.states(context).unwrap();
    object.store(context, &mut document).unwrap();
    document
}

fn bytes<O: Object>(context: &Context, object: &mut O) -> Vec<u8> {
    stored(context, object).to_bytes().unwrap()
}

const STROKES: usize = 4;

/// What an input says.
fn stroke(input: &str) -> Stroke {
    let number: usize = input.strip_prefix("stroke ").unwrap().parse().unwrap();
    let y = 1.1 + 0.5 * number as f64;
    let points = [0.9, 2.3].map(|x| StrokePoint::new(DVec3::new(x, y, 0.0), 1.0)).to_vec();
    let action = match number % 3 {
        0 => Action::Sculpt { mode: SculptMode::Draw, height: 0.05 },
        1 => Action::Paint { mode: PaintMode::Mix, color: [0.9, 0.1, 0.2, 1.0] },
        _ => Action::Sculpt { mode: SculptMode::Clay, height: 0.1 },
    };
    let settings = StrokeSettings { radius: 0.7, spacing: 0.5, ..StrokeSettings::default() };
    Stroke::new(points, settings, Falloff::Smooth, action)
}

fn make<O: Object>(context: &Context, object: &mut O, history: &mut History, input: &str) {
    history.begin(context, object, input).unwrap();
    stroke(input).apply(context, object).unwrap();
    history.end(context, object).unwrap().unwrap();
}

/// Opens what a program left at `path`, as it was killed, and makes again what was under way. Returns what there is then,
/// how many edits came from the journal and how many dabs the device made.
fn recovered<O: Object>(context: &Context, device: &Device, path: &Path) -> (O, History, [usize; 2]) {
    context.stats().take();
    let (document, mut history) = History::open(path, LIMIT, LIMIT).unwrap();
    let mut object = O::new(context, Some(device));
    assert!(object.take_up(context, &document, LIMIT).unwrap().is_empty());
    let taken_up = history.undo_count();
    for note in &document.notes {
        let (_, input) = note.split_once("is not in it: ").expect("what was under way");
        make(context, &mut object, &mut history, input);
    }
    let made = context.stats().take().iter().filter(|event| event.stage == "dab.device").count();
    (object, history, [taken_up, made])
}

fn recover<O: Object>() {
    let Some(device) = device() else { return };
    let context = Context::serial();
    let inputs: Vec<String> = (0..STROKES).map(|number| format!("stroke {number}")).collect();
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a.relievo");
    let mut object = O::new(&context, Some(&device));
    let mut history = History::new(LIMIT);
    history.save(&path, &stored(&context, &mut object)).unwrap();
    let mut states = vec![bytes(&context, &mut object)];
    for (number, input) in inputs.iter().enumerate() {
        history.begin(&context, &mut object, input).unwrap();
        stroke(input).apply(&context, &mut object).unwrap();
        // The texels are back, and the program ends before they are in the journal: their input is.
        let killed = folder.path().join("killed.relievo");
        std::fs::copy(&path, &killed).unwrap();
        history.end(&context, &mut object).unwrap().unwrap();
        states.push(bytes(&context, &mut object));
        assert!(states[number] != states[number + 1]);
        let (mut again, _, [taken_up, made]) = recovered::<O>(&context, &device, &killed);
        assert_eq!(taken_up, number);
        assert!(made > 0 && again.is_sound());
        assert!(bytes(&context, &mut again) == states[number + 1], "{input}");
    }
    drop(history);
    // What is in the journal is not made again, neither then nor when it is undone and redone.
    let (mut again, mut history, [taken_up, made]) = recovered::<O>(&context, &device, &path);
    assert_eq!([taken_up, made], [STROKES, 0]);
    for state in states.iter().rev() {
        assert!(bytes(&context, &mut again) == *state);
        history.undo(&context, &mut again).unwrap();
    }
    for state in &states[1..] {
        history.redo(&context, &mut again).unwrap().unwrap();
        assert!(bytes(&context, &mut again) == *state);
    }
    // The device follows what was undone.
    history.undo(&context, &mut again).unwrap().unwrap();
    make(&context, &mut again, &mut history, &inputs[STROKES - 1]);
    assert!(bytes(&context, &mut again) == states[STROKES]);
    assert!(context.stats().take().iter().any(|event| event.stage == "dab.device"));
    assert!(again.is_sound() && object.is_sound());
    // As does a processor that goes on where the device is lost.
    device.abandon();
    history.undo(&context, &mut again).unwrap().unwrap();
    make(&context, &mut again, &mut history, &inputs[STROKES - 1]);
    assert!(!again.is_sound());
    assert_eq!(history.undo_count(), STROKES);
}

#[test]
fn edits_of_a_device_on_tiles_are_recovered_from_the_journal() {
    recover::<DisplacedObject>();
}

#[test]
fn edits_of_a_device_on_triangles_are_recovered_from_the_journal() {
    recover::<TriangleObject>();
}
