//! Pressures on faces of elements, which stay normal to the faces as they move.

use glam::Vec3;
use relievo_core::{Context, Error, Result};

use crate::block::Row;
use crate::curve::Curve;

/// A pressure on faces.
#[derive(Clone, Debug, PartialEq)]
pub struct Pressure {
    /// The nodes of each face, counter-clockwise seen from the side that is pressed.
    pub faces: Vec<[u32; 4]>,
    /// Pressure in Pa over seconds; negative ones pull.
    pub pressure: Curve<1>,
}

impl Pressure {
    /// Fails if a node does not exist.
    pub(crate) fn check(&self, nodes: usize) -> Result<()> {
        let missing = |face: &[u32; 4]| face.iter().any(|node| *node as usize >= nodes);
        match self.faces.iter().position(missing) {
            Some(face) => Err(Error::invalid("a node does not exist").at(format!("face {face} under pressure"))),
            None => Ok(()),
        }
    }

    /// Adds the forces at a time to those of the nodes, in N.
    pub(crate) fn add(
        &self,
        context: &Context,
        seconds: f64,
        (nodes, displacements): (&[[f32; 3]], &[Row]),
        forces: &mut [Row],
    ) {
        let [pressure] = self.pressure.at(seconds);
        if pressure == 0.0 {
            return;
        }
        let place = |node: u32| Vec3::from(nodes[node as usize]) + Vec3::from_slice(&displacements[node as usize]);
        let shares = context.map(self.faces.len(), |face| areas(self.faces[face].map(place)));
        for (face, shares) in self.faces.iter().zip(shares) {
            for (node, share) in face.iter().zip(shares) {
                (0..3).for_each(|axis| forces[*node as usize][axis] -= pressure * share[axis]);
            }
        }
    }
}

/// Returns the area of a bilinear quad as a vector, weighted by the shape function of each corner: the integrals, which two
/// Gauss points along each side give exactly.
pub(crate) fn areas([a, b, c, d]: [Vec3; 4]) -> [Vec3; 4] {
    let mut shares = [Vec3::ZERO; 4];
    for [u, v] in [[LOW, LOW], [HIGH, LOW], [HIGH, HIGH], [LOW, HIGH]] {
        let along_u = (b - a) * (1.0 - v) + (c - d) * v;
        let along_v = (d - a) * (1.0 - u) + (c - b) * u;
        let area = 0.25 * along_u.cross(along_v);
        let weights = [(1.0 - u) * (1.0 - v), u * (1.0 - v), u * v, (1.0 - u) * v];
        shares.iter_mut().zip(weights).for_each(|(share, weight)| *share += weight * area);
    }
    shares
}

/// The Gauss points of a side from 0 to 1.
const LOW: f32 = 0.211_324_87;
const HIGH: f32 = 1.0 - LOW;
