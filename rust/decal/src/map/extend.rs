//! Places new vertices around a map as rigidly as possible (Liu, Zhang, Xu, Gotsman and Gortler 2008).

use relievo_core::Result;

use crate::map::energy::{Rest, Vec2};
use crate::map::factor::{PINNED, System};

/// Rounds of rotations and positions.
const ROUNDS: usize = 4;
/// Rounds while triangles are flipped.
const MAX: usize = 60;
/// The residual of the moves of a round, as a share of that of none.
const TOLERANCE: f64 = 1e-4;

/// Moves the vertices that are not fixed so that their triangles come near to rotated rest triangles. The result may have
/// flipped triangles.
///
/// # Errors
/// A new vertex is not joined to a fixed one, or memory does not suffice.
pub fn extend(faces: &[[u32; 3]], rest: &[Rest], is_fixed: &[bool], positions: &mut [Vec2]) -> Result<()> {
    let mut system = System::new(positions.len(), faces, is_fixed)?;
    if system.free() == 0 {
        return Ok(());
    }
    system.clear();
    for (face, rest) in rest.iter().enumerate() {
        let stiffness = rest.stiffness();
        let coupling = |corner: usize| stiffness[corner][(corner + 1) % 3];
        system.add(faces[face], &[0, 1, 2].map(|corner| [coupling(corner), 0.0, 0.0, coupling(corner)]));
    }
    system.prepare()?;
    let mut side = vec![[0.0; 2]; system.free()];
    for round in 0..MAX {
        let is_flipped = |(face, rest): (usize, &Rest)| {
            rest.determinant(faces[face].map(|vertex| positions[vertex as usize])) <= 0.0
        };
        if round >= ROUNDS && !rest.iter().enumerate().any(is_flipped) {
            break;
        }
        // The forces that are left, which the moves of this round balance.
        side.fill([0.0; 2]);
        for (face, rest) in rest.iter().enumerate() {
            let vertices = faces[face];
            let places = vertices.map(|vertex| positions[vertex as usize]);
            let forces = rest.rotation_forces(places);
            let stiffness = rest.stiffness();
            for corner in 0..3 {
                let row = system.row(vertices[corner] as usize);
                if row == PINNED {
                    continue;
                }
                for axis in 0..2 {
                    let held: f64 = (0..3).map(|other| stiffness[corner][other] * places[other][axis]).sum();
                    side[row as usize][axis] += (forces[corner][axis] - held) as f32;
                }
            }
        }
        system.solve(&mut side, TOLERANCE);
        for (vertex, position) in positions.iter_mut().enumerate() {
            let row = system.row(vertex);
            if row != PINNED {
                *position = [0, 1].map(|axis| position[axis] + f64::from(side[row as usize][axis]));
            }
        }
    }
    Ok(())
}
