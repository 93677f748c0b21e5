//! Edits that fade on a graphics device as they do on the processor.

use glam::{DAffine3, DVec3, Vec4};
use relievo_core::{Context, ErrorKind, Mesh};
use relievo_detail::{
    Action, Canvas, DecayingObject, DisplacedObject, Falloff, LayeredObject, PaintMode, SculptMode, Stroke,
    StrokePoint, StrokeSettings, TriangleObject,
};
use relievo_gpu::Device;
use relievo_surface::{Surface, SurfaceOptions, TriangleSurface};
use relievo_testing::device;
use relievo_tiles::triangle::{TriangleBlock, TriangleChannel, TriangleOptions};
use relievo_tiles::{ChannelOptions, DecayOptions, Displacement, DisplacementOptions, Paint, Rgba16};

const BLANK: Vec4 = Vec4::new(0.5, 0.25, 0.125, 1.0);

/// A square from 0 to 4 in z = 0, of unit faces.
fn plane() -> Mesh {
    let points = (0..25).map(|k| [(k % 5) as f32, (k / 5) as f32, 0.0]).collect();
    let squares = (0..16).map(|k| k / 4 * 5 + k % 4).flat_map(|a| [a, a + 1, a + 6, a + 5]);
    Mesh::new(points, vec![4; 16], squares.collect())
}

/// An object whose edits fade.
trait Object: Canvas + LayeredObject {
    fn new(context: &Context, halves: bool) -> Self;

    fn bring_to(&mut self, device: Option<&Device>);

    /// Blocks of displacement and of colours as numbers of an object that has the same ones.
    fn numbers(&self) -> [Vec<(u32, Vec<f32>)>; 2];

    fn fault(&mut self) -> Option<relievo_core::Error>;
}

/// What texels are: halves, or colours in 255ths.
fn numbers(bytes: &[u8], halves: bool) -> Vec<f32> {
    if halves {
        return bytemuck::pod_collect_to_vec::<u8, half::f16>(bytes).into_iter().map(f32::from).collect();
    }
    bytes.iter().map(|byte| f32::from(*byte) / 255.0).collect()
}

impl Object for DisplacedObject {
    fn new(context: &Context, halves: bool) -> Self {
        let mesh = plane();
        let surface = Surface::new(context, &mesh, &SurfaceOptions::default()).unwrap();
        let topology = surface.topology().clone();
        let options = DisplacementOptions { size: 16, face_sizes: vec![(5, 32)], ..Default::default() };
        let displacement = Displacement::new(topology.clone(), &options).unwrap();
        let mut object = Self::new(context, surface, &mesh.points, displacement, DAffine3::IDENTITY).unwrap();
        let options = ChannelOptions { size: 16, ..Default::default() };
        match halves {
            true => object.set_half_paint(Paint::<Rgba16>::of_color(topology, BLANK, &options).unwrap()).unwrap(),
            false => object.set_paint(Paint::of_color(topology, BLANK, &options).unwrap()).unwrap(),
        }
        object
    }

    fn bring_to(&mut self, device: Option<&Device>) {
        self.use_device(device).unwrap();
    }

    fn numbers(&self) -> [Vec<(u32, Vec<f32>)>; 2] {
        let field = self.displacement().field();
        let displacement = field.allocated().map(|tile| {
            let block = field.block(tile).unwrap();
            (tile, block.iter().map(|value| value.to_f32()).collect())
        });
        let bytes = self.paint().map(|paint| paint.field()).into_iter().flat_map(|field| {
            let block = |tile| numbers(bytemuck::cast_slice(field.block(tile).unwrap()), false);
            field.allocated().map(move |tile| (tile, block(tile)))
        });
        let halves = self.half_paint().map(|paint| paint.field()).into_iter().flat_map(|field| {
            let block = |tile| numbers(bytemuck::cast_slice(field.block(tile).unwrap()), true);
            field.allocated().map(move |tile| (tile, block(tile)))
        });
        [displacement.collect(), bytes.chain(halves).collect()]
    }

    fn fault(&mut self) -> Option<relievo_core::Error> {
        self.take_device_fault()
    }
}

impl Object for TriangleObject {
    fn new(context: &Context, halves: bool) -> Self {
        let surface = TriangleSurface::new(context, &plane()).unwrap();
        let options = TriangleOptions { segments: 16, ..Default::default() };
        let topology = surface.topology().clone();
        let displacement = TriangleChannel::displacement(topology.clone(), &options).unwrap();
        let mut object = Self::new(context, surface, displacement, DAffine3::IDENTITY).unwrap();
        match halves {
            true => object.set_half_paint(TriangleChannel::of_color(topology, BLANK, &options).unwrap()).unwrap(),
            false => object.set_paint(TriangleChannel::of_color(topology, BLANK, &options).unwrap()).unwrap(),
        }
        object
    }

    fn bring_to(&mut self, device: Option<&Device>) {
        self.use_device(device).unwrap();
    }

    fn numbers(&self) -> [Vec<(u32, Vec<f32>)>; 2] {
        let blocks = 0..TriangleBlock::count(self.surface().topology());
        let read = |read: &dyn Fn(u32) -> Option<Vec<u8>>, halves: bool| {
            let block = |block| Some((block, numbers(&read(block)?, halves)));
            blocks.clone().filter_map(block).collect::<Vec<_>>()
        };
        let colors = match (self.paint(), self.half_paint()) {
            (Some(paint), _) => read(&|block| paint.read(block).unwrap(), false),
            (_, Some(paint)) => read(&|block| paint.read(block).unwrap(), true),
            _ => Vec::new(),
        };
        [read(&|block| self.displacement().read(block).unwrap(), true), colors]
    }

    fn fault(&mut self) -> Option<relievo_core::Error> {
        self.take_device_fault()
    }
}

fn stroke(y: f64, action: Action) -> Stroke {
    let points = [0.9, 2.9].map(|x| StrokePoint::new(DVec3::new(x, y, 0.0), 1.0)).to_vec();
    let settings = StrokeSettings { radius: 0.8, spacing: 0.4, ..StrokeSettings::default() };
    Stroke::new(points, settings, Falloff::Smooth, action)
}

/// Compares what two objects have: blocks, displacement within a step of a half float, colours within 1/255. Returns how
/// many blocks there are.
fn compare<O: Object>(here: &O, there: &O, time: f64) -> usize {
    let [expected, found] = [here.numbers(), there.numbers()];
    let of =
        |all: &[Vec<(u32, Vec<f32>)>; 2]| all.each_ref().map(|kind| kind.iter().map(|it| it.0).collect::<Vec<_>>());
    assert_eq!(of(&expected), of(&found), "blocks at {time}");
    for (kind, (expected, found)) in expected.iter().zip(&found).enumerate() {
        for ((block, expected), (_, found)) in expected.iter().zip(found) {
            for (a, b) in expected.iter().zip(found) {
                let most = if kind == 0 { a.abs().max(1.0 / 1024.0) / 1024.0 } else { 1.0 / 255.0 };
                assert!((a - b).abs() <= 1.0001 * most, "{kind} of block {block} at {time}: {a} {b}");
            }
        }
    }
    expected.iter().map(Vec::len).sum()
}

fn fades<O: Object>() {
    let Some(device) = device() else { return };
    let context = Context::serial();
    let options = DecayOptions { delay: 0.5, duration: 2.0 };
    for halves in [false, true] {
        let [mut here, mut there] = [O::new(&context, halves), O::new(&context, halves)];
        let paint = |color| Action::Paint { mode: PaintMode::Mix, color };
        let strokes = [
            (0.0, stroke(1.3, Action::Sculpt { mode: SculptMode::Draw, height: 0.2 })),
            (0.25, stroke(1.3, paint([0.9, 0.1, 0.05, 1.0]))),
            // Over what fades already.
            (1.25, stroke(1.9, Action::Sculpt { mode: SculptMode::Draw, height: -0.1 })),
            (1.5, stroke(1.9, paint([0.05, 0.2, 0.9, 1.0]))),
        ];
        // Times that a float has no bits for.
        let first = 4321.1;
        for object in [&mut here, &mut there] {
            object.set_decay(options, 1 << 24).unwrap();
            object.advance(&context, first).unwrap();
        }
        for (time, stroke) in &strokes {
            for (object, device) in [(&mut here, None), (&mut there, Some(&device))] {
                object.bring_to(device);
                object.advance(&context, first + time).unwrap();
                // Edits are the same to the bit.
                object.bring_to(None);
                stroke.apply(&context, object).unwrap();
            }
        }
        there.bring_to(Some(&device));
        for (time, left) in [(1.6, true), (2.1, true), (2.7, true), (3.9, true), (4.1, false)] {
            context.stats().take();
            there.advance(&context, first + time).unwrap();
            let on_device = context.stats().take().iter().filter(|event| event.stage == "decay.device").count();
            here.advance(&context, first + time).unwrap();
            assert!(on_device > 0, "at {time}");
            assert_eq!(compare(&here, &there, time) > 0, left, "at {time}");
        }
        assert!(there.fault().is_none());
    }
}

#[test]
fn what_fades_on_a_device_is_what_fades_on_the_processor() {
    fades::<DisplacedObject>();
}

#[test]
fn what_fades_on_a_device_on_triangles_is_what_fades_on_the_processor() {
    fades::<TriangleObject>();
}

#[test]
fn the_processor_takes_over_a_fade_from_a_lost_device() {
    let Some(device) = device() else { return };
    let context = Context::serial();
    let [mut here, mut there] = [<DisplacedObject as Object>::new(&context, false), Object::new(&context, false)];
    for object in [&mut here, &mut there] {
        object.set_decay(DecayOptions { delay: 0.5, duration: 2.0 }, 1 << 24).unwrap();
        stroke(1.3, Action::Sculpt { mode: SculptMode::Draw, height: 0.2 }).apply(&context, object).unwrap();
    }
    there.bring_to(Some(&device));
    device.abandon();
    for object in [&mut here, &mut there] {
        object.advance(&context, 1.0).unwrap();
    }
    assert_eq!(here.numbers(), there.numbers());
    let fault = there.fault().expect("it is told");
    assert_eq!(fault.kind, ErrorKind::Device, "{fault}");
    assert!(there.fault().is_none(), "once");
}
