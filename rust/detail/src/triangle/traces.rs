//! What an imprint notes down of itself on a triangle mesh: the traces of contact of the values that it pushed. Rims
//! and smoothing are no contact. See [`crate::imprint::traces`].

use relievo_core::{Context, Error, Result};
use relievo_tiles::triangle::{TriangleChannel, TriangleField};
use relievo_tiles::{Texel, Trace};

use super::dab::write;
use super::site::{Element, ElementEdit, values};

/// Fails if the traces have another pattern than the displacement.
pub(crate) fn check(displacement: &TriangleField, traces: &TriangleField<Trace>) -> Result<()> {
    match [displacement.pattern(), traces.pattern()] {
        [own, other] if own == other => Ok(()),
        [own, other] => {
            let [own, other] = [own.segments(), other.segments()];
            Err(Error::invalid(format!("its traces have {other} segments an edge and its displacement {own}"))
                .advise("make the traces anew after the displacement was given other segments"))
        }
    }
}

/// Notes in `traces` what an imprint pushed at `time` in and around `faces`, where `fields` are the displacement before
/// and after it. Returns the faces that the budget refused.
pub(super) fn record(
    context: &Context,
    fields: [&TriangleField; 2],
    traces: &mut TriangleChannel<Trace>,
    faces: &[u32],
    time: f64,
) -> Result<Vec<u32>> {
    let topology = fields[1].topology();
    let pattern = traces.field().pattern();
    let elements = Element::of_faces(topology, faces);
    let edits = context.map(elements.len(), |index| {
        let element = elements[index];
        let [before, after] = fields.map(|field| values(field, element, pattern));
        let (before, after) = (before?, after?);
        let mut new = values(traces.field(), element, pattern)?;
        let mut count = 0;
        for (trace, (old, now)) in new.iter_mut().zip(before.iter().zip(&after)) {
            let depth = (old.value() - now.value()) as f32;
            if depth > 0.0 {
                *trace = trace.pushed(depth, time as f32);
                count += 1;
            }
        }
        (count > 0).then_some(ElementEdit { element, pattern, values: new, count })
    });
    let edits = edits.into_iter().flatten().collect();
    Ok(write(context, traces, pattern, faces, edits, false)?.0.refused)
}
