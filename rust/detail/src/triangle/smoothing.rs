//! Smoothing of dents on a triangle mesh after an imprint: values around changed ones move toward the mean of
//! their one-rings, across edges and at vertices over all faces there. See [`crate::imprint::smoothing`].

use std::collections::BTreeMap;

use half::f16;
use relievo_core::{Context, Result};
use relievo_tiles::Texel;
use relievo_tiles::triangle::{TriangleChange, TriangleChannel, TriangleField, TriangleValues};

use super::site::{Element, around, values};
use crate::imprint::settings::ImprintSettings;

/// Rings around a changed value that are smoothed as well.
const REACH: u32 = 2;

/// Smooths what an imprint changed in and around `faces`, where the displacement was `before`, as `settings` have it.
/// Returns the faces that look different.
pub(super) fn smooth(
    context: &Context,
    channel: &mut TriangleChannel,
    before: &TriangleField,
    faces: &[u32],
    settings: &ImprintSettings,
) -> Result<Vec<u32>> {
    let topology = before.topology().clone();
    let pattern = before.pattern();
    let field = channel.field();
    let fine: Vec<u32> = faces.iter().copied().filter(|face| field.face_pattern(*face) == Some(pattern)).collect();
    let mut elements = Element::of_faces(&topology, &fine);
    // Values that faces without a block would follow stay, as in dabs.
    let is_there = |(face, _): (u32, u32)| field.is_allocated(face);
    elements.retain(|element| match element {
        Element::Face(_) => true,
        Element::Edge(edge) => field.edge_pattern(*edge) == Some(pattern) && topology.faces_along(*edge).all(is_there),
        Element::Vertex(vertex) => topology.faces_around(*vertex).all(is_there),
    });
    let masks = context.map(elements.len(), |index| {
        let [old, new] = [before, field].map(|field| values(field, elements[index], pattern).unwrap_or_default());
        old.iter().zip(&new).map(|(old, new)| !old.same(*new)).collect::<Vec<bool>>()
    });
    let places: BTreeMap<Element, usize> = elements.iter().copied().zip(0..).collect();
    let mut masks = masks;
    for _ in 0..REACH {
        masks = context.map(elements.len(), |index| {
            let knots = elements[index].knots(&topology, pattern);
            let near = knots.into_iter().zip(&masks[index]).map(|(knot, own)| {
                let mut near = *own;
                around(&topology, knot, |face, node| {
                    let (element, at) = Element::of_knot(&topology, (face, pattern, node));
                    near |= places.get(&element).is_some_and(|place| masks[*place][at]);
                });
                near
            });
            near.collect()
        });
    }
    for _ in 0..settings.smoothing_passes {
        let field = channel.field();
        let new = context.map(elements.len(), |index| {
            let element = elements[index];
            if !masks[index].contains(&true) {
                return None;
            }
            let mut new = values(field, element, pattern)?;
            let knots = element.knots(&topology, pattern);
            for ((value, knot), _) in new.iter_mut().zip(knots).zip(&masks[index]).filter(|(_, smoothed)| **smoothed) {
                let (mut sum, mut count) = (0.0, 0.0);
                around(&topology, knot, |face, node| {
                    sum += field.at(face, pattern, node) as f32;
                    count += 1.0;
                });
                let here = value.to_f32();
                *value = f16::from_f32(here + settings.smoothing * (sum / f32::max(count, 1.0) - here));
            }
            Some((element, new))
        });
        let mut list = TriangleValues::default();
        for (element, new) in new.into_iter().flatten() {
            match element {
                Element::Face(face) => list.faces.push((face, new)),
                Element::Edge(edge) => list.edges.push((edge, new)),
                Element::Vertex(vertex) => list.vertices.extend(new.first().map(|value| (vertex, *value))),
            }
        }
        channel.write(list)?;
    }
    let mut change = TriangleChange::default();
    for (element, _) in elements.iter().zip(&masks).filter(|(_, mask)| mask.contains(&true)) {
        match element {
            Element::Face(face) => change.faces.push(*face),
            Element::Edge(edge) => change.edges.push(*edge),
            Element::Vertex(vertex) => change.vertices.push(*vertex),
        }
    }
    Ok(change.faces_shown(&topology))
}
