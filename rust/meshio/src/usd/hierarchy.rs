//! Prims as nodes: where they are, over time too.

use openusd::sdf::Value;
use relievo_core::Result;

use super::stage::{Prim, Property, Stage, words};
use super::value::doubles;
use crate::transform::{Kind, Operation};

/// The time codes of a stage as seconds.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Clock {
    /// The time code that is second 0.
    pub start: f64,
    /// Time codes of a second.
    pub rate: f64,
}

impl Clock {
    /// The second of a time code.
    pub fn seconds(&self, code: f64) -> f64 {
        (code - self.start) / self.rate
    }
}

/// The operations that place a prim, and whether they start from the stage instead of the prim above.
pub(crate) fn placement(stage: &Stage, prim: &Prim, clock: Clock) -> Result<(Vec<Operation>, bool)> {
    let mut operations = Vec::new();
    let mut reset = false;
    let order: Vec<String> = match stage.property(prim, "xformOpOrder")?.rest() {
        Some(order) => words(order).into_iter().map(str::to_owned).collect(),
        None => return Ok((operations, reset)),
    };
    for name in &order {
        if name == "!resetXformStack!" {
            operations.clear();
            reset = true;
            continue;
        }
        let (inverse, name) = match name.strip_prefix("!invert!") {
            Some(name) => (true, name),
            None => (false, name.as_str()),
        };
        let kind = name.strip_prefix("xformOp:").map(|rest| rest.split(':').next().unwrap_or_default());
        let kind = match kind {
            Some("translate") => Kind::Translate,
            Some("scale") => Kind::Scale,
            Some("rotateX") => Kind::Turn(0),
            Some("rotateY") => Kind::Turn(1),
            Some("rotateZ") => Kind::Turn(2),
            Some("rotateXYZ") => Kind::Turns([0, 1, 2]),
            Some("rotateXZY") => Kind::Turns([0, 2, 1]),
            Some("rotateYXZ") => Kind::Turns([1, 0, 2]),
            Some("rotateYZX") => Kind::Turns([1, 2, 0]),
            Some("rotateZXY") => Kind::Turns([2, 0, 1]),
            Some("rotateZYX") => Kind::Turns([2, 1, 0]),
            Some("orient") => Kind::Orient,
            Some("transform") => Kind::Matrix,
            _ => {
                stage.note(&format!("the transform operation `{name}` is not known and left out"));
                continue;
            }
        };
        let value = stage.property(prim, name)?;
        let numbers = |value: &Value| {
            doubles(value).filter(|list| list.len() == kind.width() && list.iter().all(|number| number.is_finite()))
        };
        let Some(rest) = value.rest().and_then(numbers) else {
            stage.note(&format!("the transform operation `{name}` has no numbers and is left out"));
            continue;
        };
        let Property { samples, .. } = value;
        let keys = samples.iter().filter_map(|(code, value)| Some((clock.seconds(*code), numbers(value)?)));
        let (times, keys): (Vec<f64>, Vec<Vec<f64>>) = keys.unzip();
        operations.push(Operation { kind, inverse, rest, times, keys });
    }
    let numbers = operations.iter().map(|operation| operation.keys.len() * (operation.kind.width() + 4)).sum::<usize>();
    stage.charge(8 * numbers as u64)?;
    Ok((operations, reset))
}
