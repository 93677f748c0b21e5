//! Numbers of values: scalars, tuples and arrays of any precision as lists of one kind.

use openusd::sdf::Value;
use relievo_core::Result;

use crate::budget::Budget;

/// The floats of a value and how many belong together; `None` if it holds none. Integers are floats too.
pub(crate) fn floats(value: &Value, budget: &mut Budget) -> Result<Option<(Vec<f32>, u32)>> {
    macro_rules! from {
        ($list:expr, $number:ty, $width:expr) => {{
            let numbers: &[$number] = bytemuck::cast_slice($list);
            let mut list = Vec::new();
            budget.reserve(&mut list, numbers.len())?;
            list.extend(numbers.iter().map(|number| f64::from(*number) as f32));
            (list, $width)
        }};
    }
    use openusd::gf::f16;
    use std::slice::from_ref as one;
    Ok(Some(match value {
        Value::Half(value) => from!(one(value), f16, 1),
        Value::Float(value) => from!(one(value), f32, 1),
        Value::Double(value) => from!(one(value), f64, 1),
        Value::Vec2h(value) => from!(one(value), f16, 2),
        Value::Vec2f(value) => from!(one(value), f32, 2),
        Value::Vec2d(value) => from!(one(value), f64, 2),
        Value::Vec3h(value) => from!(one(value), f16, 3),
        Value::Vec3f(value) => from!(one(value), f32, 3),
        Value::Vec3d(value) => from!(one(value), f64, 3),
        Value::Vec4h(value) => from!(one(value), f16, 4),
        Value::Vec4f(value) => from!(one(value), f32, 4),
        Value::Vec4d(value) => from!(one(value), f64, 4),
        Value::HalfVec(list) => from!(list.as_slice(), f16, 1),
        Value::FloatVec(list) => from!(list.as_slice(), f32, 1),
        Value::DoubleVec(list) => from!(list.as_slice(), f64, 1),
        Value::Vec2hVec(list) => from!(list.as_slice(), f16, 2),
        Value::Vec2fVec(list) => from!(list.as_slice(), f32, 2),
        Value::Vec2dVec(list) => from!(list.as_slice(), f64, 2),
        Value::Vec3hVec(list) => from!(list.as_slice(), f16, 3),
        Value::Vec3fVec(list) => from!(list.as_slice(), f32, 3),
        Value::Vec3dVec(list) => from!(list.as_slice(), f64, 3),
        Value::Vec4hVec(list) => from!(list.as_slice(), f16, 4),
        Value::Vec4fVec(list) => from!(list.as_slice(), f32, 4),
        Value::Vec4dVec(list) => from!(list.as_slice(), f64, 4),
        _ => return Ok(None),
    }))
}

/// The integers of a value; `None` if it holds none, or one that is negative or of more than 32 bits.
pub(crate) fn integers(value: &Value, budget: &mut Budget) -> Result<Option<Vec<u32>>> {
    fn all<T: Copy>(list: &[T], budget: &mut Budget) -> Result<Option<Vec<u32>>>
    where
        u32: TryFrom<T>,
    {
        let mut out = Vec::new();
        budget.reserve(&mut out, list.len())?;
        for number in list {
            match u32::try_from(*number) {
                Ok(number) => out.push(number),
                Err(_) => return Ok(None),
            }
        }
        Ok(Some(out))
    }
    match value {
        Value::Int(value) => all(&[*value], budget),
        Value::Uint(value) => all(&[*value], budget),
        Value::Int64(value) => all(&[*value], budget),
        Value::Uint64(value) => all(&[*value], budget),
        Value::Uchar(value) => all(&[*value], budget),
        Value::IntVec(list) => all(list, budget),
        Value::UintVec(list) => all(list, budget),
        Value::Int64Vec(list) => all(list, budget),
        Value::Uint64Vec(list) => all(list, budget),
        Value::UcharVec(list) => all(list, budget),
        _ => Ok(None),
    }
}

/// The doubles of a scalar, tuple, quaternion (x, y, z, w) or matrix (row after row).
pub(crate) fn doubles(value: &Value) -> Option<Vec<f64>> {
    Some(match value {
        Value::Int(value) => vec![f64::from(*value)],
        Value::Int64(value) => vec![*value as f64],
        Value::Half(value) => vec![f64::from(*value)],
        Value::Float(value) => vec![f64::from(*value)],
        Value::Double(value) => vec![*value],
        Value::TimeCode(value) => vec![value.value()],
        Value::Vec3h(value) => [value.x, value.y, value.z].map(f64::from).to_vec(),
        Value::Vec3f(value) => [value.x, value.y, value.z].map(f64::from).to_vec(),
        Value::Vec3d(value) => vec![value.x, value.y, value.z],
        Value::Quath(value) => [value.x, value.y, value.z, value.w].map(f64::from).to_vec(),
        Value::Quatf(value) => [value.x, value.y, value.z, value.w].map(f64::from).to_vec(),
        Value::Quatd(value) => vec![value.x, value.y, value.z, value.w],
        Value::Matrix4d(value) => value.0.to_vec(),
        _ => return None,
    })
}

/// The one number that a value is.
pub(crate) fn number(value: &Value) -> Option<f64> {
    match doubles(value)?[..] {
        [number] => Some(number),
        _ => None,
    }
}
