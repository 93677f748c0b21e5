//! The meshes of colliders on a graphics device, one after the other in two buffers, so that what is done with their
//! points and triangles is one dispatch for all imprints of a submission.

use std::collections::BTreeMap;
use std::ops::Range;

use relievo_core::{Error, Result};
use relievo_gpu::{Buffer, Device};

use crate::imprint::collider::Collider;

/// Triangles up to which the kernels' sum of the work cannot wrap round.
const MAX_TRIANGLES: usize = 1 << 21;

/// Room is made for so many times what a submission needs at most, for colliders of others.
const KEPT: usize = 16;

/// Where a mesh is.
#[derive(Clone, Debug)]
pub(crate) struct Place {
    pub points: Range<u32>,
    pub triangles: Range<u32>,
    /// Whether it is solid inside, and not behind its front.
    pub closed: bool,
    /// Which points it has.
    pub identity: u64,
}

/// Meshes on a device, which imprints on all kinds of surfaces share.
#[derive(Debug)]
pub(crate) struct DeviceMeshes {
    points: Buffer<[f32; 3]>,
    triangles: Buffer<[u32; 3]>,
    places: BTreeMap<u64, Place>,
    /// Points and triangles that are taken.
    used: [usize; 2],
    /// How often there were other buffers.
    generation: u64,
}

impl DeviceMeshes {
    /// Room for no mesh so far.
    pub fn new(device: &Device) -> Result<Self> {
        let points = Buffer::new(device, "colliders' points", 0)?;
        let triangles = Buffer::new(device, "colliders' triangles", 0)?;
        Ok(Self { points, triangles, places: BTreeMap::new(), used: [0; 2], generation: 0 })
    }

    /// Which buffers it has: another number than before where they are others.
    pub fn generation(&self) -> u64 {
        self.generation
    }

    /// Points in object space.
    pub fn points(&self) -> &Buffer<[f32; 3]> {
        &self.points
    }

    /// The triangles' points, of each mesh from 0.
    pub fn triangles(&self) -> &Buffer<[u32; 3]> {
        &self.triangles
    }

    /// Where a mesh is that was brought to the device.
    pub(super) fn place(&self, mesh: u64) -> Result<&Place> {
        self.places.get(&mesh).ok_or_else(|| Error::internal("a collider that was not brought to the device"))
    }

    /// Brings colliders to the device as they are.
    ///
    /// Fails for a collider that is too large for kernels or has two poses of its points at once, and where the device has
    /// no room.
    pub fn bring(&mut self, device: &Device, colliders: &[&Collider]) -> Result<()> {
        let mut wanted: BTreeMap<u64, &Collider> = BTreeMap::new();
        for collider in colliders {
            let [mesh, points] = collider.identity;
            if wanted.entry(mesh).or_insert(collider).identity[1] != points {
                return Err(Error::unsupported("a collider in two poses at once"));
            }
            check(collider)?;
        }
        let sum = |there: &dyn Fn(&u64) -> bool| {
            let counted = wanted.iter().filter(|(mesh, _)| !there(mesh));
            let size = |it: &Collider| [it.boundary().0.len(), it.boundary().1.len()];
            counted.map(|(_, it)| size(it)).fold([0; 2], |[a, b], [c, d]| [a + c, b + d])
        };
        let missing = sum(&|mesh| self.places.contains_key(mesh));
        let capacity = [self.points.len(), self.triangles.len()];
        if (0..2).any(|k| self.used[k] + missing[k] > capacity[k]) {
            // What others need is brought again when it is needed.
            let all = sum(&|_| false);
            let grown = |k: usize| (capacity[k] + all[k]).min(KEPT * all[k]).max(all[k]);
            self.places.clear();
            self.used = [0; 2];
            self.points = Buffer::new(device, "colliders' points", grown(0))?;
            self.triangles = Buffer::new(device, "colliders' triangles", grown(1))?;
            self.generation += 1;
        }
        wanted.into_iter().try_for_each(|(mesh, collider)| self.write(device, mesh, collider))
    }

    /// Writes what the device lacks of a mesh, for which there is room.
    fn write(&mut self, device: &Device, mesh: u64, collider: &Collider) -> Result<()> {
        let identity = collider.identity[1];
        let (points, triangles) = collider.boundary();
        if let Some(place) = self.places.get_mut(&mesh) {
            if place.identity != identity {
                self.points.write(device, place.points.start as usize, points)?;
                place.identity = identity;
            }
            return Ok(());
        }
        let [first, second] = self.used;
        self.points.write(device, first, points)?;
        self.triangles.write(device, second, triangles)?;
        self.used = [first + points.len(), second + triangles.len()];
        let range = |from: usize, to: usize| from as u32..to as u32;
        let place = Place {
            points: range(first, self.used[0]),
            triangles: range(second, self.used[1]),
            closed: !collider.is_sheet(),
            identity,
        };
        self.places.insert(mesh, place);
        Ok(())
    }
}

/// Fails for a collider that is too large for kernels.
fn check(collider: &Collider) -> Result<()> {
    let (points, triangles) = collider.boundary();
    let (points, triangles) = (points.len(), triangles.len());
    if triangles > MAX_TRIANGLES || points > 3 * MAX_TRIANGLES {
        return Err(Error::unsupported(format!(
            "a collider of {triangles} triangles and {points} points is too large for a graphics device"
        ))
        .advise("use a coarser collider, or the device `cpu`"));
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::object::shapes;
    use glam::DAffine3;
    use relievo_core::Context;
    use relievo_testing::device;

    #[test]
    fn meshes_lie_one_after_the_other_and_are_written_once() {
        let Some(device) = device() else { return };
        let context = Context::serial();
        let (points, triangles) = shapes::sphere(0.8, 20, 10, 0.1);
        let make = || Collider::new(&context, points.clone(), triangles.clone(), DAffine3::IDENTITY).unwrap();
        let [mut ball, other, third] = [make(), make(), make()];
        let mut meshes = DeviceMeshes::new(&device).unwrap();
        meshes.bring(&device, &[&ball, &ball.clone()]).unwrap();
        meshes.bring(&device, &[&other]).unwrap();
        assert_eq!(meshes.generation(), 2);
        meshes.bring(&device, &[&ball, &other]).unwrap();
        assert!(meshes.place(other.identity[0]).is_ok());
        let there = |meshes: &DeviceMeshes, collider: &Collider| {
            let mut frame = device.frame().unwrap();
            let place = meshes.place(collider.identity[0]).unwrap();
            let range = place.points.start as usize..place.points.end as usize;
            let points = frame.read(meshes.points(), range).unwrap();
            let range = place.triangles.start as usize..place.triangles.end as usize;
            let triangles = frame.read(meshes.triangles(), range).unwrap();
            let _ = frame.submit().unwrap();
            points.get(&device).unwrap() == collider.points() && triangles.get(&device).unwrap() == collider.triangles()
        };
        let posed = ball.clone();
        let lifted: Vec<_> = points.iter().map(|p| [p[0], p[1], p[2] + 1.0]).collect();
        ball.set_points(&context, &lifted).unwrap();
        meshes.bring(&device, &[&ball, &third, &other]).unwrap();
        assert!([&ball, &third, &other].iter().all(|it| there(&meshes, it)) && !there(&meshes, &posed));
        let twice = meshes.bring(&device, &[&ball, &posed]).unwrap_err();
        assert!(twice.to_string().contains("two poses"), "{twice}");
        // One that others took the room of is brought again.
        for _ in 0..2 * KEPT {
            let next = make();
            meshes.bring(&device, &[&next]).unwrap();
            assert!(there(&meshes, &next) && meshes.points.len() <= 3 * KEPT * points.len());
        }
        meshes.bring(&device, &[&posed]).unwrap();
        assert!(there(&meshes, &posed));
    }
}
