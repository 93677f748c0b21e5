//! Edits over time: what a handle does is given at keys. Between two of them its translation is linear, and its turn about
//! its middle goes on as turns do that have a fixed axis between them (Shoemake 1985, slerp).

use glam::{DQuat, DVec3, Vec3};
use relievo_core::{Context, Error, Result};

use super::handle::{Edit, Handle, Region};
use crate::progressive::build::cut::Front;
use crate::progressive::mesh::active::ActiveMesh;

/// What a handle does at a time.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct HandleKey {
    /// Seconds.
    pub time: f64,
    /// How far it moves.
    pub translation: [f32; 3],
    /// The axis it turns about, of length 1; of any where it does not turn.
    pub axis: [f32; 3],
    /// How far it turns, in radians. Less than a whole turn beside a key with another axis.
    pub angle: f32,
}

/// A handle over time. Before its first key it is as there, after its last one as there.
#[derive(Clone, Debug, PartialEq)]
pub struct KeyedHandle {
    /// What is grabbed.
    pub region: Region,
    /// One or more, later and later.
    pub keys: Vec<HandleKey>,
}

/// An edit over time.
#[derive(Clone, Debug, PartialEq)]
pub struct KeyedEdit {
    /// What moves.
    pub handles: Vec<KeyedHandle>,
    /// What stays.
    pub anchors: Vec<Region>,
}

impl KeyedEdit {
    /// Checks the keys, handles and anchors.
    ///
    /// # Errors
    /// Fails if a handle has no keys or a time that is not finite, keys do not come one after another or turn more than
    /// once between different axes, or a handle or anchor is not usable.
    pub fn check(&self) -> Result<()> {
        for (number, handle) in self.handles.iter().enumerate() {
            let refused = |what: &str| Err(Error::invalid(what).at(format!("keys of handle {number}")));
            let is_before = |pair: &[HandleKey]| pair[0].time < pair[1].time;
            if handle.keys.is_empty() || !handle.keys.iter().all(|key| key.time.is_finite()) {
                return refused("a handle needs one key or more, with finite times");
            }
            if !handle.keys.windows(2).all(is_before) {
                return refused("each key has to be later than the one before");
            }
            let too_far = |key: &HandleKey| key.angle.abs() >= std::f32::consts::TAU;
            if handle.keys.windows(2).any(|pair| !is_about_one_axis(pair) && pair.iter().any(too_far)) {
                return refused("between turns about different axes there is no more than a whole turn");
            }
        }
        let keys = self.handles.iter().map(|handle| handle.keys.len()).max().unwrap_or(0);
        let at_key = |key: usize| {
            let handle = |handle: &KeyedHandle| handle.of(&handle.keys[key.min(handle.keys.len() - 1)]);
            Edit { handles: self.handles.iter().map(handle).collect(), anchors: self.anchors.clone() }
        };
        (0..keys).try_for_each(|key| at_key(key).check())
    }

    /// What it is at a time in seconds.
    ///
    /// # Errors
    /// Fails as [`Self::check`], and if the time is not finite.
    pub fn at(&self, time: f64) -> Result<Edit> {
        check_time(time)?;
        self.check()?;
        let handles = self.handles.iter().map(|handle| handle.at(time)).collect();
        Ok(Edit { handles, anchors: self.anchors.clone() })
    }
}

/// Fails if a time is not finite.
pub(crate) fn check_time(time: f64) -> Result<()> {
    if time.is_finite() {
        return Ok(());
    }
    Err(Error::invalid(format!("{time} is no time")).at("time").advise("use a finite number"))
}

impl KeyedHandle {
    fn of(&self, key: &HandleKey) -> Handle {
        Handle { region: self.region, translation: key.translation, axis: key.axis, angle: key.angle }
    }

    fn at(&self, time: f64) -> Handle {
        let next = self.keys.partition_point(|key| key.time <= time);
        let (Some(before), Some(after)) = (next.checked_sub(1), self.keys.get(next)) else {
            return self.of(&self.keys[next.saturating_sub(1)]);
        };
        let before = &self.keys[before];
        let share = (time - before.time) / (after.time - before.time);
        let translation = Vec3::from(before.translation).lerp(after.translation.into(), share as f32).to_array();
        let (axis, angle) = turn_between([*before, *after], share);
        Handle { region: self.region, translation, axis, angle }
    }
}

/// Whether two keys turn about the same axis, or one of them does not turn.
fn is_about_one_axis(pair: &[HandleKey]) -> bool {
    let [before, after] = [pair[0], pair[1]].map(|key| Vec3::from(key.axis));
    pair.iter().any(|key| key.angle == 0.0) || before.cross(after).length_squared() < 1e-12
}

/// Axis and angle between two keys.
fn turn_between(pair: [HandleKey; 2], share: f64) -> ([f32; 3], f32) {
    let [before, after] = pair;
    if is_about_one_axis(&pair) {
        // Whole turns count, which quaternions know nothing of.
        let axis = if before.angle == 0.0 { after.axis } else { before.axis };
        let is_against = after.angle != 0.0 && Vec3::from(axis).dot(after.axis.into()) < 0.0;
        let [from, to] = [before.angle, if is_against { -after.angle } else { after.angle }].map(f64::from);
        return (axis, (from + share * (to - from)) as f32);
    }
    let [from, to] =
        pair.map(|key| DQuat::from_axis_angle(Vec3::from(key.axis).as_dvec3().normalize(), key.angle.into()));
    // Neither is replaced by the same turn the other way round: a part of a turn would leap.
    let between = from.dot(to).clamp(-1.0, 1.0).acos();
    let made = (from * ((1.0 - share) * between).sin() + to * (share * between).sin()).normalize();
    let along = DVec3::new(made.x, made.y, made.z);
    let angle = 2.0 * along.length().atan2(made.w);
    (along.try_normalize().unwrap_or(DVec3::Z).as_vec3().to_array(), angle as f32)
}

impl ActiveMesh {
    /// Makes edits as they are at a time, one after the other, each of the mesh that its front is, in place of what was
    /// made for another time. Then it is the mesh again that it was. They are no edits to be taken back: before one of
    /// those is made, taken back or made again, the mesh is at rest. Returns how many vertices were reached.
    ///
    /// # Errors
    /// Fails, and is at rest, if the time is not finite, an edit is not usable ([`KeyedEdit::check`]), its front is
    /// none of this mesh, or it moves and reaches no vertex or takes one where there is no number.
    pub fn pose(&mut self, context: &Context, edits: &[(Front, KeyedEdit)], time: f64) -> Result<usize> {
        self.rest(context);
        check_time(time)?;
        let at = |number: usize| move |error: Error| error.at(format!("edit {number}"));
        let made = edits.iter().enumerate().map(|(number, (_, edit))| edit.at(time).map_err(at(number)));
        let made = made.collect::<Result<Vec<_>>>()?;
        let (front, cut, mut reached, mut has_left) = (self.front(), self.cut(), 0, false);
        let mut work = || {
            for (number, ((at_front, _), edit)) in edits.iter().zip(&made).enumerate() {
                if !edit.handles.iter().any(Handle::is_moving) {
                    continue;
                }
                let (count, state) = match self.edit_beneath(context, at_front, edit).map_err(at(number))? {
                    Some(made) => made,
                    None => {
                        has_left = true;
                        self.adapt_front(context, at_front).map_err(at(number))?;
                        let vertices = self.reached(context, edit).map_err(at(number))?;
                        (vertices.len(), self.replace(context, &vertices).map_err(at(number))?)
                    }
                };
                reached += count;
                self.history.posed.push(state);
            }
            Ok(())
        };
        let done = work();
        if has_left {
            self.return_to(context, &front, cut);
        }
        if done.is_err() {
            self.rest(context);
        }
        done.map(|()| reached)
    }

    /// Takes back what [`Self::pose`] has made.
    pub fn rest(&mut self, context: &Context) {
        while let Some(state) = self.history.posed.pop() {
            self.restore(context, state);
        }
    }
}
