//! Traces of contact on triangle meshes: where colliders pushed, how far in all, and when last; at the vertices where
//! the displacement is. See [`crate::layers::trace`]. Units: object units, seconds.

use relievo_core::{Marks, Result};

use super::channel::{TriangleChannel, TriangleOptions};
use super::field::TriangleField;
use super::pattern::{Node, Pattern};
use super::tessellate::{TriangleTessellation, point_attribute};
use crate::layers::trace::{Mark, Trace};

impl TriangleChannel<Trace> {
    /// No traces, for a mesh with this displacement. They may occupy `budget` bytes.
    ///
    /// # Errors
    /// Fails as [`TriangleChannel::blank`] does.
    pub fn of(displacement: &TriangleField, budget: u64) -> Result<Self> {
        let options = TriangleOptions { segments: displacement.pattern().segments(), budget };
        Self::blank(displacement.topology().clone(), Trace::default(), &options)
    }
}

impl TriangleField<Trace> {
    /// The trace at a vertex of any pattern laid over `face`. Panics if there is no such face.
    pub fn mark(&self, face: u32, pattern: Pattern, node: Node) -> Mark {
        Mark::of(self.at(face, pattern, node))
    }
}

impl TriangleTessellation {
    /// Gives the mesh the point attributes `contact`, `depth` and `age` as [`Tessellation::trace`] does.
    ///
    /// [`Tessellation::trace`]: crate::Tessellation::trace
    pub fn trace(&mut self, traces: &TriangleField<Trace>, now: f64) {
        let marks: Vec<Mark> = self.places().iter().map(|place| mark(traces, *place)).collect();
        let lists = [
            ("contact", marks.iter().map(|mark| mark.contact).collect()),
            ("depth", marks.iter().map(|mark| mark.depth).collect()),
            ("age", marks.iter().map(|mark| mark.age(now)).collect()),
        ];
        for (name, values) in lists {
            self.mesh.attributes.retain(|attribute| attribute.name != name);
            self.mesh.attributes.push(point_attribute(name, 1, values));
        }
    }

    /// Gives `changed` points what `traces` says, as [`Self::trace`] gives it to all. `marks` get the points whose contact,
    /// depth or age differs from before.
    ///
    /// # Errors
    /// Fails, and changes nothing, if the mesh has no traces yet.
    pub fn retrace(&mut self, traces: &TriangleField<Trace>, now: f64, changed: &[u32], marks: &Marks) -> Result<()> {
        self.renew("contact", changed, marks, |place| [mark(traces, place).contact])?;
        self.renew("depth", changed, marks, |place| [mark(traces, place).depth])?;
        self.renew("age", changed, marks, |place| [mark(traces, place).age(now)])
    }
}

/// Returns the trace at a place, and none where there is no place.
fn mark(traces: &TriangleField<Trace>, place: Option<(u32, Pattern, Node)>) -> Mark {
    match place {
        Some((face, pattern, node)) if (face as usize) < traces.topology().face_count() => {
            traces.mark(face, pattern, node)
        }
        _ => Mark::default(),
    }
}
