//! Progress of long calls: its fractions, and callers that ask to stop.

use std::collections::HashMap;

use relievo_core::{Context, ContextOptions, ErrorKind, Progress, Result};
use relievo_lod::progressive::BuildOptions;
use relievo_lod::{Progressive, SimplifyOptions, simplify};

use crate::shapes::torus;

type Call = fn(&Context, &mut dyn Progress) -> Result<()>;

fn simplifies(context: &Context, progress: &mut dyn Progress) -> Result<()> {
    let mesh = torus(60, 30);
    let options = SimplifyOptions { target_triangles: 400, ..Default::default() };
    simplify(context, &mesh.0, &mesh.1, &options, progress).map(|_| ())
}

fn builds(context: &Context, progress: &mut dyn Progress) -> Result<()> {
    let mesh = torus(60, 30);
    let options = BuildOptions { faces: 20, ..Default::default() };
    Progressive::build(context, &mesh.0, &mesh.1, &options, progress).map(|_| ())
}

const CALLS: [Call; 2] = [simplifies, builds];

#[test]
fn fractions_of_a_stage_rise_from_0_to_1() {
    for call in CALLS {
        let mut stages = HashMap::new();
        let mut rising = |fraction: f32, stage: &str| {
            let last = stages.entry(stage.to_owned()).or_insert(0.0);
            assert!((*last..=1.0).contains(&fraction), "{stage}: {fraction} after {last}");
            *last = fraction;
            true
        };
        call(&Context::serial(), &mut rising).unwrap();
        assert!(!stages.is_empty() && stages.values().all(|last| *last == 1.0), "{stages:?}");
    }
}

#[test]
fn a_wish_to_stop_at_the_last_report_cancels_a_call_on_threads() {
    let context = Context::new(&ContextOptions { threads: 2, ..Default::default() }).unwrap();
    for call in CALLS {
        let mut reports = 0;
        let mut count = |_: f32, _: &str| {
            reports += 1;
            true
        };
        call(&context, &mut count).unwrap();
        let mut stop = |_: f32, _: &str| {
            reports -= 1;
            reports > 0
        };
        assert_eq!(call(&context, &mut stop).unwrap_err().kind, ErrorKind::Cancelled);
    }
}
