//! The feature graph: a Delaunay triangulation of the pins within the outline (the paper's Section 4.1).
//!
//! Edges of the Delaunay triangulation that leave the outline are replaced by the shortest ones that stay within it. All
//! edges between triangles are kept, so that each face is convex and each pin a corner of the seed.

use relievo_core::{Error, Result};
use spade::{ConstrainedDelaunayTriangulation, Point2, Triangulation};

use crate::artwork::outline::Outline;
use crate::map::energy::Vec2;
use crate::pins::name;

/// The most pins of a decal.
const MAX: usize = 1024;

/// Edges and triangles between pins.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Graph {
    /// Pairs of pins, the smaller number first.
    pub edges: Vec<[u32; 2]>,
    /// Triples of pins, counter-clockwise in the image.
    pub triangles: Vec<[u32; 3]>,
}

impl Graph {
    /// Makes the graph of pins.
    ///
    /// # Errors
    /// A pin lies outside of the outline or on another one, or the graph is not connected. The error names the pins.
    pub fn new(pins: &[Vec2], outline: &Outline) -> Result<Self> {
        if pins.len() > MAX {
            return Err(
                Error::unsupported(format!("there are {} pins", pins.len())).advise(format!("use at most {MAX} pins"))
            );
        }
        for (pin, place) in pins.iter().enumerate() {
            if !outline.contains(*place) {
                return Err(Error::invalid(format!(
                    "its point ({}, {}) lies outside of the outline",
                    place[0], place[1]
                ))
                .at(name(pin))
                .advise("move the point into the outline"));
            }
            if let Some(other) = pins[..pin].iter().position(|other| other == place) {
                return Err(Error::invalid(format!("its point is that of pin {other}"))
                    .at(name(pin))
                    .advise("move or remove one of them"));
            }
        }
        let mut triangulation = ConstrainedDelaunayTriangulation::<Point2<f64>>::new();
        let mut handles = Vec::with_capacity(pins.len());
        let mut pin_of = vec![0; pins.len()];
        for (pin, place) in pins.iter().enumerate() {
            let handle = triangulation
                .insert(Point2::new(place[0], place[1]))
                .map_err(|error| Error::invalid(error.to_string()).at(name(pin)))?;
            pin_of[handle.index()] = pin as u32;
            handles.push(handle);
        }
        let can_see = |a: u32, b: u32| outline.encloses(pins[a as usize], pins[b as usize]);
        let kept: Vec<_> = triangulation
            .undirected_edges()
            .map(|edge| edge.vertices().map(|vertex| vertex.fix()))
            .filter(|[a, b]| can_see(pin_of[a.index()], pin_of[b.index()]))
            .collect();
        let is_whole = kept.len() == triangulation.num_undirected_edges();
        for [a, b] in kept {
            triangulation.add_constraint(a, b);
        }
        if !is_whole {
            // The other pairs that see each other, shortest first.
            let mut pairs = Vec::new();
            for b in 0..pins.len() as u32 {
                let seen = (0..b).filter(|a| can_see(*a, b));
                pairs.extend(seen.map(|a| {
                    let ([x, y], [z, w]) = (pins[a as usize], pins[b as usize]);
                    ((z - x).hypot(w - y), a, b)
                }));
            }
            pairs.sort_unstable_by(|a, b| a.0.total_cmp(&b.0));
            for (_, a, b) in pairs {
                let (a, b) = (handles[a as usize], handles[b as usize]);
                if triangulation.can_add_constraint(a, b) {
                    triangulation.add_constraint(a, b);
                }
            }
        }
        let mut graph = Self::default();
        for edge in triangulation.undirected_edges().filter(|edge| edge.is_constraint_edge()) {
            let [a, b] = edge.vertices().map(|vertex| pin_of[vertex.index()]);
            graph.edges.push([a.min(b), a.max(b)]);
        }
        graph.edges.sort_unstable();
        for face in triangulation.inner_faces() {
            if face.adjacent_edges().iter().all(|edge| edge.is_constraint_edge()) {
                graph.triangles.push(face.vertices().map(|vertex| pin_of[vertex.index()]));
            }
        }
        graph.triangles.sort_unstable();
        graph.check_connected(pins)?;
        Ok(graph)
    }

    fn check_connected(&self, pins: &[Vec2]) -> Result<()> {
        let mut is_reached = vec![false; pins.len()];
        let mut queue = vec![0_u32];
        is_reached[0] = true;
        while let Some(pin) = queue.pop() {
            for edge in self.edges.iter().filter(|edge| edge.contains(&pin)) {
                for end in edge {
                    if !std::mem::replace(&mut is_reached[*end as usize], true) {
                        queue.push(*end);
                    }
                }
            }
        }
        let Some(lonely) = is_reached.iter().position(|reached| !reached) else {
            return Ok(());
        };
        let distance = |pin: usize| (pins[pin][0] - pins[lonely][0]).hypot(pins[pin][1] - pins[lonely][1]);
        let reached = (0..pins.len()).filter(|pin| is_reached[*pin]);
        let nearest = reached.min_by(|a, b| distance(*a).total_cmp(&distance(*b))).unwrap_or_default();
        Err(Error::invalid("no line within the outline joins it to the other pins").at(name(lonely)).advise(format!(
            "add a pin inside the outline that sees both pin {nearest} and pin {lonely}, \
             and place it on the surface between them"
        )))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn edges_stay_within_a_concave_outline() {
        let outline = Outline::new(vec![
            [0.0, 0.0],
            [3.0, 0.0],
            [3.0, 3.0],
            [2.0, 3.0],
            [2.0, 1.0],
            [1.0, 1.0],
            [1.0, 3.0],
            [0.0, 3.0],
        ])
        .expect("simple");
        let pins = [[0.5, 2.5], [0.5, 0.5], [2.5, 0.5], [2.5, 2.5]];
        let graph = Graph::new(&pins, &outline).expect("connected");
        assert_eq!(graph.edges, [[0, 1], [1, 2], [2, 3]]);
        assert!(graph.triangles.is_empty());
        let error = Graph::new(&[pins[0], pins[3]], &outline).expect_err("apart").to_string();
        assert!(error.contains("pin 1") && error.contains("add a pin"), "{error}");
    }

    #[test]
    fn a_square_has_two_triangles() {
        let outline = Outline::rectangle([0.0, 0.0], [4.0, 4.0]).expect("simple");
        let graph = Graph::new(&[[1.0, 1.0], [3.0, 1.0], [3.0, 3.1], [1.0, 3.0]], &outline).expect("connected");
        assert_eq!((graph.edges.len(), graph.triangles.len()), (5, 2));
    }
}
