//! What a check found and a repair changed.

use std::fmt;

use crate::topology::Topology;

/// An element of the mesh that was given.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Element {
    /// A point.
    Point(u32),
    /// A face.
    Face(u32),
    /// An edge by its two points.
    Edge([u32; 2]),
}

/// How many elements have something in common, and the first of them.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Finding {
    /// The number of elements.
    pub count: usize,
    /// The first ones, as many as [`crate::RepairSettings::listed`] allows.
    pub first: Vec<Element>,
}

impl Finding {
    /// Collects elements and keeps the first `listed`.
    pub(crate) fn of(elements: impl Iterator<Item = Element>, listed: u32) -> Self {
        let mut finding = Self::default();
        elements.for_each(|element| finding.add(element, listed));
        finding
    }

    pub(crate) fn add(&mut self, element: Element, listed: u32) {
        self.count += 1;
        if self.first.len() < listed as usize {
            self.first.push(element);
        }
    }
}

/// What a check found and a repair changed. All numbers of elements are those of the mesh that was given.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Report {
    /// Faces that use points that do not exist or are not finite. Always dropped.
    pub invalid_faces: Finding,
    /// Points that coincide with an earlier one.
    pub coincident_points: Finding,
    /// Points that no face uses.
    pub unused_points: Finding,
    /// Faces with fewer than three different points, or that touch themselves in a point.
    pub degenerate_faces: Finding,
    /// Faces of different points without area. They are reported and stay, because dropping them would open the mesh.
    pub flat_faces: Finding,
    /// Faces that have the same points as an earlier one.
    pub duplicate_faces: Finding,
    /// Edges of more than two faces.
    pub non_manifold_edges: Finding,
    /// Points at which faces meet that share no edge there.
    pub non_manifold_points: Finding,
    /// Edges at which two faces do not agree about their front.
    pub misoriented_edges: Finding,
    /// Edges at which a one-sided part of the mesh has to be cut to be oriented.
    pub one_sided_edges: Finding,
    /// Closed components that face inwards without lying within another one, by their first face.
    pub inverted_components: Finding,
    /// Boundary loops, by one of their edges.
    pub holes: Finding,
    /// The mesh after points were welded and faces dropped, before anything else.
    pub before: Topology,
    /// Faces that were turned over.
    pub turned_faces: usize,
    /// Points that were added where vertices were split.
    pub split_points: usize,
    /// Boundary loops that were filled.
    pub filled_holes: usize,
    /// Boundary loops that stay open, by one of their edges: too long, too large, or impossible to fill.
    pub open_holes: Finding,
    /// Points that fillings have added.
    pub filling_points: usize,
    /// Faces that fillings have added.
    pub filling_faces: usize,
    /// Attributes of points that became attributes of corners because welded points had different values.
    pub seam_attributes: Vec<String>,
    /// The repaired mesh. The same as `before` after a check.
    pub after: Topology,
}

impl Report {
    /// Returns the defects with their names, in the order of the steps.
    pub fn defects(&self) -> [(&'static str, &Finding); 12] {
        [
            ("invalid_faces", &self.invalid_faces),
            ("coincident_points", &self.coincident_points),
            ("unused_points", &self.unused_points),
            ("degenerate_faces", &self.degenerate_faces),
            ("flat_faces", &self.flat_faces),
            ("duplicate_faces", &self.duplicate_faces),
            ("non_manifold_edges", &self.non_manifold_edges),
            ("non_manifold_points", &self.non_manifold_points),
            ("misoriented_edges", &self.misoriented_edges),
            ("one_sided_edges", &self.one_sided_edges),
            ("inverted_components", &self.inverted_components),
            ("holes", &self.holes),
        ]
    }

    /// Returns whether the mesh is closed, manifold and oriented, without degenerate or doubled faces. Coincident,
    /// unused and flat elements are no obstacle.
    pub fn is_solid(&self) -> bool {
        let harmless = ["coincident_points", "unused_points", "flat_faces"];
        self.defects().iter().all(|(name, finding)| finding.count == 0 || harmless.contains(name))
    }
}

impl fmt::Display for Element {
    fn fmt(&self, out: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Point(number) | Self::Face(number) => write!(out, "{number}"),
            Self::Edge([a, b]) => write!(out, "{a}-{b}"),
        }
    }
}

impl fmt::Display for Finding {
    fn fmt(&self, out: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(out, "{}", self.count)?;
        if self.first.is_empty() {
            return Ok(());
        }
        let names: Vec<String> = self.first.iter().map(Element::to_string).collect();
        let more = if self.count > names.len() { ", ..." } else { "" };
        write!(out, " ({}{more})", names.join(", "))
    }
}
