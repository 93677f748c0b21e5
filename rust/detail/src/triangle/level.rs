//! Edits of a level coarser than what is there: the change is made at the vertices of the coarser pattern and added to
//! the finer values between them, so that their detail stays.
//!
//! Schäfer, Keinert, Nießner and Stamminger 2015, Local Painting and Deformation of Meshes on the GPU, Section 7.1. The
//! paper copies values to all other levels, which would erase what a finer one has more. Since the coarser patterns are
//! subsets, the coarser value at a vertex is the finer one there.

use relievo_core::Context;
use relievo_tiles::Texel;
use relievo_tiles::triangle::{Node, Pattern, TriangleChange, TriangleField};

use super::site::{Element, ElementEdit, values};

/// How values of the coarser pattern change.
struct Differences<'a, T: Texel> {
    field: &'a TriangleField<T>,
    pattern: Pattern,
    /// By element, ascending.
    list: Vec<(Element, Vec<T::Value>)>,
}

impl<T: Texel> Differences<'_, T> {
    fn of(&self, element: Element) -> Option<&[T::Value]> {
        let at = self.list.binary_search_by_key(&element, |(element, _)| *element).ok()?;
        Some(&self.list[at].1)
    }

    /// At a vertex of the coarser pattern on `face`.
    fn at(&self, face: u32, node: Node) -> T::Value {
        let (element, index) = Element::of_knot(self.field.topology(), (face, self.pattern, node));
        self.of(element).map_or_else(T::Value::default, |values| values[index])
    }

    /// At a vertex of any pattern on `face`, linear in the triangles of the coarser one.
    fn between(&self, face: u32, pattern: Pattern, node: Node) -> T::Value {
        let unit = 1.0 / (3.0 * f64::from(pattern.segments()));
        let place = pattern.weights(node).map(|weight| (f64::from(weight) * unit) as f32);
        let (nodes, shares) = self.pattern.locate(place);
        nodes.into_iter().zip(shares).map(|(node, share)| self.at(face, node) * f64::from(share)).sum()
    }
}

/// Edits of what has a finer pattern than `pattern` made of edits in that pattern, which are ascending by element. What
/// has no finer one stays as it is.
pub(super) fn refined<T: Texel>(
    context: &Context,
    field: &TriangleField<T>,
    pattern: Pattern,
    edits: Vec<ElementEdit<T>>,
) -> Vec<ElementEdit<T>> {
    if pattern >= field.pattern() {
        return edits;
    }
    let is_finer = |element: Element| element.pattern(field).is_some_and(|own| own > pattern);
    let list = edits.iter().filter_map(|edit| {
        let old = values(field, edit.element, pattern)?;
        let values = edit.values.iter().zip(&old).map(|(new, old)| new.value() - old.value());
        Some((edit.element, values.collect::<Vec<_>>()))
    });
    let differences = Differences { field, pattern, list: list.collect() };
    let mut change = TriangleChange::default();
    for edit in &edits {
        match edit.element {
            Element::Face(face) => change.faces.push(face),
            Element::Edge(edge) => change.edges.push(edge),
            Element::Vertex(vertex) => change.vertices.push(vertex),
        }
    }
    let topology = field.topology();
    // A change at a vertex reaches into all that is divided between it and the next.
    let mut finer = Element::of_faces(topology, &change.faces_shown(topology));
    finer.retain(|element| is_finer(*element));
    let made = context.map(finer.len(), |index| {
        let element = finer[index];
        let own = element.pattern(field)?;
        let mut new = values(field, element, own)?;
        let mut count = 0;
        for (value, (face, own, node)) in new.iter_mut().zip(element.knots(topology, own)) {
            let changed = T::nearest(value.value() + differences.between(face, own, node));
            count += u64::from(!changed.same(*value));
            *value = changed;
        }
        (count > 0).then_some(ElementEdit { element, pattern: own, values: new, count })
    });
    let mut edits: Vec<ElementEdit<T>> = edits.into_iter().filter(|edit| !is_finer(edit.element)).collect();
    edits.extend(made.into_iter().flatten());
    edits.sort_by_key(|edit| edit.element);
    edits
}
