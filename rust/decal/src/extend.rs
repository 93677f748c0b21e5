//! Places new vertices around a map as rigidly as possible (Liu, Zhang, Xu, Gotsman and Gortler 2008).

use relievo_core::Result;

use crate::energy::{Rest, Vec2};
use crate::factor::{PINNED, System};

/// Rounds of rotations and positions.
const ROUNDS: usize = 4;
/// Rounds while triangles are flipped.
const MOST: usize = 60;
/// The residual of the positions, as a share of that of the origin.
const TOLERANCE: f64 = 1e-6;

/// Moves the vertices that are not fixed so that their triangles come near to rotated rest triangles. The result may have
/// flipped triangles.
///
/// # Errors
/// A new vertex is not joined to a fixed one, or memory does not suffice.
pub fn extend(faces: &[[u32; 3]], rest: &[Rest], is_fixed: &[bool], positions: &mut [Vec2]) -> Result<()> {
    let mut system = System::new(positions.len(), faces, is_fixed)?;
    if system.unknowns() == 0 {
        return Ok(());
    }
    system.clear(1e-12);
    for (face, rest) in rest.iter().enumerate() {
        let stiffness = rest.stiffness();
        let part = |row: usize, column: usize| {
            if row % 2 == column % 2 { stiffness[row / 2][column / 2] } else { 0.0 }
        };
        system.add(faces[face], &std::array::from_fn(|row| std::array::from_fn(|column| part(row, column))));
    }
    system.factorise()?;
    let mut side = vec![0.0; system.unknowns()];
    for round in 0..MOST {
        let is_flipped = |(face, rest): (usize, &Rest)| {
            rest.determinant(faces[face].map(|vertex| positions[vertex as usize])) <= 0.0
        };
        if round >= ROUNDS && !rest.iter().enumerate().any(is_flipped) {
            break;
        }
        side.fill(0.0);
        for (face, rest) in rest.iter().enumerate() {
            let vertices = faces[face];
            let forces = rest.rotation_forces(vertices.map(|vertex| positions[vertex as usize]));
            let stiffness = rest.stiffness();
            for corner in 0..3 {
                let row = system.row(vertices[corner] as usize);
                if row == PINNED {
                    continue;
                }
                for axis in 0..2 {
                    let entry = &mut side[2 * row as usize + axis];
                    *entry += forces[corner][axis];
                    for other in (0..3).filter(|other| is_fixed[vertices[*other] as usize]) {
                        *entry -= stiffness[corner][other] * positions[vertices[other] as usize][axis];
                    }
                }
            }
        }
        system.solve(&mut side, TOLERANCE);
        for (vertex, position) in positions.iter_mut().enumerate() {
            let row = system.row(vertex);
            if row != PINNED {
                *position = [side[2 * row as usize], side[2 * row as usize + 1]];
            }
        }
    }
    Ok(())
}
