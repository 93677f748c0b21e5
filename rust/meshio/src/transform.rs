//! Stacks of transform operations that may move over time (OpenUSD's `UsdGeomXformable`): the first is applied last.
//! Numbers are interpolated straight, orientations along the great arc, and then put together.

use glam::{DAffine3, DMat4, DQuat, DVec3};

/// What an operation does with its numbers.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Kind {
    /// Moves by three.
    Translate,
    /// Scales by three.
    Scale,
    /// Turns by an angle in degrees about an axis: 0 for x, 1 for y, 2 for z.
    Turn(u8),
    /// Turns by three angles in degrees about x, y and z, in this order of axes.
    Turns([u8; 3]),
    /// Turns by a quaternion (x, y, z, w).
    Orient,
    /// Maps by a matrix of sixteen, row after row for row vectors.
    Matrix,
}

/// An operation.
#[derive(Clone, Debug, PartialEq)]
pub struct Operation {
    /// What it does.
    pub kind: Kind,
    /// Whether it is undone instead.
    pub inverse: bool,
    /// Its numbers at no time in particular.
    pub rest: Vec<f64>,
    /// Times of its keys in seconds, increasing.
    pub times: Vec<f64>,
    /// Its numbers at every key.
    pub keys: Vec<Vec<f64>>,
}

impl Kind {
    /// How many numbers it needs.
    pub fn width(self) -> usize {
        match self {
            Self::Translate | Self::Scale | Self::Turns(_) => 3,
            Self::Turn(_) => 1,
            Self::Orient => 4,
            Self::Matrix => 16,
        }
    }
}

impl Operation {
    /// Its map at `time` seconds, or at rest.
    fn at(&self, time: Option<f64>) -> DAffine3 {
        let numbers = match time.filter(|_| !self.keys.is_empty()) {
            None => self.rest.clone(),
            Some(time) => {
                let after = self.times.partition_point(|key| *key <= time);
                let last = self.keys.len() - 1;
                let (a, b) = (after.saturating_sub(1).min(last), after.min(last));
                let length = self.times[b] - self.times[a];
                let share = if length > 0.0 { (time - self.times[a]) / length } else { 0.0 };
                let (from, to) = (&self.keys[a], &self.keys[b]);
                if self.kind == Kind::Orient && share > 0.0 {
                    return self.turned(quaternion(from).slerp(quaternion(to), share));
                }
                from.iter().zip(to).map(|(from, to)| from + (to - from) * share).collect()
            }
        };
        let vector = |numbers: &[f64]| match *numbers {
            [x, y, z, ..] => DVec3::new(x, y, z),
            _ => DVec3::ZERO,
        };
        let turn = |axis: u8, degrees: f64| {
            let axis = [DVec3::X, DVec3::Y, DVec3::Z][axis as usize % 3];
            DQuat::from_axis_angle(axis, degrees.to_radians())
        };
        let map = match self.kind {
            Kind::Translate => DAffine3::from_translation(vector(&numbers)),
            Kind::Scale => DAffine3::from_scale(vector(&numbers)),
            Kind::Turn(axis) => DAffine3::from_quat(turn(axis, numbers.first().copied().unwrap_or(0.0))),
            Kind::Turns(axes) => {
                let angles = vector(&numbers);
                let turn = |axis: u8| turn(axis, angles[axis as usize % 3]);
                DAffine3::from_quat(turn(axes[2]) * turn(axes[1]) * turn(axes[0]))
            }
            Kind::Orient => return self.turned(quaternion(&numbers)),
            Kind::Matrix => {
                let mut matrix = [0.0; 16];
                numbers.iter().zip(&mut matrix).for_each(|(number, part)| *part = *number);
                // Rows for row vectors are columns for column vectors.
                let columns = DMat4::from_cols_array(&matrix);
                DAffine3::from_mat4(columns)
            }
        };
        if self.inverse { map.inverse() } else { map }
    }

    fn turned(&self, rotation: DQuat) -> DAffine3 {
        DAffine3::from_quat(if self.inverse { rotation.conjugate() } else { rotation })
    }
}

fn quaternion(numbers: &[f64]) -> DQuat {
    let rotation = match *numbers {
        [x, y, z, w] => DQuat::from_xyzw(x, y, z, w),
        _ => DQuat::IDENTITY,
    };
    if rotation.length_squared() > 1e-24 { rotation.normalize() } else { DQuat::IDENTITY }
}

/// The map of a stack at `time` seconds, or at rest. One that is not finite is none.
pub fn map(operations: &[Operation], time: Option<f64>) -> DAffine3 {
    let map = operations.iter().fold(DAffine3::IDENTITY, |map, operation| map * operation.at(time));
    if map.is_finite() { map } else { DAffine3::IDENTITY }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn operation(kind: Kind, rest: &[f64]) -> Operation {
        Operation { kind, inverse: false, rest: rest.to_vec(), times: Vec::new(), keys: Vec::new() }
    }

    #[test]
    fn the_first_operation_is_applied_last() {
        let stack = [
            operation(Kind::Translate, &[1.0, 2.0, 3.0]),
            operation(Kind::Turns([0, 1, 2]), &[90.0, 0.0, 90.0]),
            operation(Kind::Scale, &[2.0, 1.0, 1.0]),
        ];
        // x is scaled, stays when turned about x, becomes y when turned about z.
        let moved = map(&stack, None).transform_point3(DVec3::X);
        assert!((moved - DVec3::new(1.0, 4.0, 3.0)).length() < 1e-12, "{moved}");
        // y becomes z about x, and stays there about z.
        let moved = map(&stack, None).transform_point3(DVec3::Y);
        assert!((moved - DVec3::new(1.0, 2.0, 4.0)).length() < 1e-12, "{moved}");
    }

    #[test]
    fn an_inverse_undoes_and_keys_are_interpolated() {
        let pivot = operation(Kind::Translate, &[1.0, 0.0, 0.0]);
        let mut turn = operation(Kind::Turn(2), &[0.0]);
        (turn.times, turn.keys) = (vec![1.0, 2.0], vec![vec![0.0], vec![360.0]]);
        let stack = [pivot.clone(), turn, Operation { inverse: true, ..pivot }];
        for (time, expected) in [(0.0, [2.0, 0.0]), (1.25, [1.0, 1.0]), (1.5, [0.0, 0.0]), (9.0, [2.0, 0.0])] {
            let moved = map(&stack, Some(time)).transform_point3(DVec3::new(2.0, 0.0, 0.0));
            assert!((moved - DVec3::new(expected[0], expected[1], 0.0)).length() < 1e-12, "{time}: {moved}");
        }
        let matrix = [1.0, 0.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 0.0, 1.0, 0.0, 5.0, 6.0, 7.0, 1.0];
        let moved = map(&[operation(Kind::Matrix, &matrix)], None).transform_point3(DVec3::ZERO);
        assert_eq!(moved, DVec3::new(5.0, 6.0, 7.0));
    }
}
