//! Traces of contact: where they are, how deep and how old, and that imprints do not depend on them.

use glam::{DAffine3, DVec3};
use relievo_core::{Context, ContextOptions, Mesh};
use relievo_detail::{Collider, DisplacedObject, ImprintSettings, Imprinter, LayeredObject, Moment, Report};
use relievo_surface::{Place, Surface, SurfaceOptions};
use relievo_tiles::{Displaced, Displacement, DisplacementOptions, Trace, Traces, uniform_rates};

const SIZE: u32 = 32;

/// 6 × 6 quads of edge 1 around the origin, facing +z.
fn cage() -> Mesh {
    let points = (0..49).map(|k| [(k % 7) as f32 - 3.0, (k / 7) as f32 - 3.0, 0.0]).collect();
    let corners = (0..36u32).map(|k| 7 * (k / 6) + k % 6).flat_map(|a| [a, a + 1, a + 8, a + 7]);
    Mesh::new(points, vec![4; 36], corners.collect())
}

fn plate(context: &Context, budget: Option<u64>) -> DisplacedObject {
    let mesh = cage();
    let surface = Surface::new(context, &mesh, &SurfaceOptions::default()).unwrap();
    let options = DisplacementOptions { size: SIZE, ..DisplacementOptions::default() };
    let displacement = Displacement::new(surface.topology().clone(), &options).unwrap();
    let traces = budget.map(|budget| Traces::of(displacement.field(), budget).unwrap());
    let mut object = DisplacedObject::new(context, surface, &mesh.points, displacement, DAffine3::IDENTITY).unwrap();
    traces.into_iter().for_each(|traces| object.set_traces(traces).unwrap());
    object
}

/// A box of half extents 0.7 × 0.4 whose underside is at `z`.
fn stamp(context: &Context, x: f64, y: f64, z: f64) -> Collider {
    let points = (0..8).map(|i| [0, 1, 2].map(|axis| if i >> axis & 1 == 0 { -1.0 } else { 1.0 })).collect();
    let quads = [[0, 4, 6, 2], [1, 3, 7, 5], [0, 1, 5, 4], [2, 6, 7, 3], [0, 2, 3, 1], [4, 5, 7, 6]];
    let triangles = quads.iter().flat_map(|q| [[q[0], q[1], q[2]], [q[0], q[2], q[3]]]).collect();
    let transform = DAffine3::from_scale_rotation_translation(
        DVec3::new(0.7, 0.4, 1.0),
        glam::DQuat::IDENTITY,
        DVec3::new(x, y, z + 1.0),
    );
    Collider::new(context, points, triangles, transform).unwrap()
}

fn press(context: &Context, object: &mut DisplacedObject, collider: &Collider, time: f64, rim: f32) -> Report {
    object.set_time(time).unwrap();
    let settings = ImprintSettings { voxels: 1 << 20, rim, ..ImprintSettings::default() };
    let moment = Moment { frame: time as u64, ..Moment::default() };
    Imprinter::new().imprint(context, object, collider, &settings, moment).unwrap()
}

#[test]
fn traces_say_where_how_deep_and_when_and_change_nothing_else() {
    for (threads, rim) in [(1, 0.0), (3, 0.5)] {
        let context = Context::new(&ContextOptions { threads, memory_limit: 0 }).unwrap();
        let (mut traced, mut bare) = (plate(&context, Some(1 << 30)), plate(&context, None));
        let presses = [(0.1, 0.2, -0.25, 3.0), (0.6, 0.1, -0.375, 7.0)];
        for (x, y, z, time) in presses {
            let stamp = stamp(&context, x, y, z);
            let reports =
                [press(&context, &mut traced, &stamp, time, rim), press(&context, &mut bare, &stamp, time, rim)];
            assert_eq!(reports[0], reports[1]);
        }
        let inside = |p: [f32; 3], (x, y, ..): (f64, f64, f64, f64), slack: f64| {
            (f64::from(p[0]) - x).abs() < 0.7 + slack && (f64::from(p[1]) - y).abs() < 0.4 + slack
        };
        let (field, traces) = (traced.displacement().field(), traced.traces().unwrap().field());
        let (mut touched, mut seen) = (0, [0; 2]);
        for tile in 0..field.tile_count() as u32 {
            assert_eq!(field.block(tile), bare.displacement().field().block(tile));
            for at in 0..SIZE * SIZE {
                let (i, j) = (at % SIZE, at / SIZE);
                let index = ((j + 1) * (SIZE + 2) + i + 1) as usize;
                let trace = traces.block(tile).map_or(Trace::default(), |block| block[index]);
                let place = Place { tile, u: (i as f32 + 0.5) / SIZE as f32, v: (j as f32 + 0.5) / SIZE as f32 };
                let sample = traced.surface().sample(context.level(), place).unwrap();
                let under = [0, 1].map(|k| inside(sample.p, presses[k], -0.06));
                let clear = [0, 1].map(|k| !inside(sample.p, presses[k], 0.06));
                touched += u32::from(trace.contact.to_f32() == 1.0);
                let value = field.block(tile).map_or(0.0, |block| block[index].to_f32());
                match (under, clear) {
                    ([_, true], _) => {
                        assert_eq!((trace.contact.to_f32(), trace.moment), (1.0, 7.0), "{:?}", sample.p);
                        seen[1] += 1;
                    }
                    ([true, _], [_, true]) => {
                        assert_eq!((trace.contact.to_f32(), trace.moment), (1.0, 3.0), "{:?}", sample.p);
                        seen[0] += 1;
                    }
                    (_, [true, true]) => assert_eq!(trace, Trace::default(), "{:?}", sample.p),
                    _ => {}
                }
                // Depth is all that was pushed: what is missing now, and any rim that was pushed down with it.
                if trace.contact.to_f32() == 1.0 {
                    let depth = trace.depth.to_f32();
                    assert!(depth + value >= -1e-3 && (rim > 0.0 || depth + value <= 1e-3), "{depth} {value}");
                } else if rim == 0.0 {
                    assert_eq!(value, 0.0);
                }
            }
        }
        assert!(touched > 1500 && seen[0] > 200 && seen[1] > 800, "{touched} {seen:?}");
        let mesh_marks = {
            let displaced = Displaced::new(traced.surface(), field).unwrap();
            let rates = uniform_rates(field.topology(), 16);
            let mut tessellation = displaced.tessellate(&context, &cage(), &rates).unwrap();
            tessellation.trace(traces, 10.0);
            tessellation
        };
        let list = |name: &str| match &mesh_marks.mesh.attribute(name).unwrap().values {
            relievo_core::Values::F32(values) => values.clone(),
            relievo_core::Values::U32(_) => panic!("{name} holds integers"),
        };
        let (contact, age) = (list("contact"), list("age"));
        for (contact, age) in contact.iter().zip(&age) {
            assert!(
                if *contact > 0.0 { (3.0 - 1e-4..=7.0 + 1e-4).contains(age) } else { *age == -1.0 },
                "{contact} {age}"
            );
        }
        assert!(list("depth").iter().any(|depth| (depth - 0.375).abs() < 0.02));
    }
}

#[test]
fn traces_of_another_size_and_too_small_a_budget_are_said() {
    let context = Context::serial();
    let stamp = stamp(&context, 0.1, 0.2, -0.25);
    let mut object = plate(&context, Some(2 * 8 * 34 * 34));
    let report = press(&context, &mut object, &stamp, 0.0, 0.0);
    assert!(!report.refused.is_empty());
    assert_eq!(object.traces().unwrap().allocated_count(), 2);
    assert!(object.displacement().allocated_count() > 2);

    let mut object = plate(&context, Some(1 << 30));
    let faces: Vec<(u32, u32)> = (0..36).map(|face| (face, 16)).collect();
    object.displacement_mut().resize(&context, &faces).unwrap();
    let before = object.displacement().bytes();
    let settings = ImprintSettings { voxels: 1 << 20, ..ImprintSettings::default() };
    let done = Imprinter::new().imprint(&context, &mut object, &stamp, &settings, Moment::default());
    assert!(done.unwrap_err().to_string().contains("another size"));
    assert_eq!((object.displacement().bytes(), object.traces().unwrap().bytes()), (before, 0));
    assert!(object.set_time(f64::NAN).is_err());
}
