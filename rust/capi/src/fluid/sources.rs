//! What acts on fluids, and where their particles come from: forces, emitters and solids of hosts.

use glam::Vec3;
use relievo_core::{Error, Mesh, Result};
use relievo_fluid::{Emitter, Force};

use super::{
    RLV_FLUID_ATTRACTOR, RLV_FLUID_DISC, RLV_FLUID_DRAG, RLV_FLUID_GRAVITY, RLV_FLUID_RECTANGLE, RLV_FLUID_SURFACE,
    RLV_FLUID_TURBULENCE, RLV_FLUID_VORTEX, RLV_FLUID_WIND, RlvFluidEmitterOptions, RlvFluidForce,
};
use crate::array::Plain;
use crate::detail::transform;
use crate::mesh::RlvMesh;
use crate::registry::{self, try_read};

impl Default for RlvFluidForce {
    fn default() -> Self {
        Self { kind: 0, seed: 0, vector: [0.0; 3], place: [0.0; 3], strength: 0.0, radius: 0.0, rate: 0.0 }
    }
}

// SAFETY: eleven numbers of four bytes, without padding.
unsafe impl Plain for RlvFluidForce {}

/// The force that is asked for.
pub fn force(given: &RlvFluidForce) -> Result<Force> {
    let RlvFluidForce { kind, seed, strength, radius, rate, .. } = *given;
    let (vector, place) = (Vec3::from(given.vector), Vec3::from(given.place));
    Ok(match kind {
        RLV_FLUID_GRAVITY => Force::Gravity(vector),
        RLV_FLUID_WIND => Force::Wind { velocity: vector, share: strength },
        RLV_FLUID_DRAG => Force::Drag { share: strength, square: rate },
        RLV_FLUID_VORTEX => Force::Vortex { place, axis: vector, strength, radius },
        RLV_FLUID_ATTRACTOR => Force::Attractor { place, strength, radius },
        RLV_FLUID_TURBULENCE => Force::Turbulence { strength, scale: radius, rate, seed },
        other => return Err(Error::invalid(format!("there is no force {other}")).advise("use 0 to 5")),
    })
}

/// The points of a mesh in the fluid, and its triangles.
///
/// # Safety
/// `matrix` is NULL or twelve doubles.
pub unsafe fn placed(mesh: &Mesh, matrix: *const f64) -> Result<(Vec<Vec3>, Vec<[u32; 3]>)> {
    // SAFETY: promised by the caller.
    let matrix = unsafe { transform(matrix) }?;
    let place = |point: &[f32; 3]| matrix.transform_point3(Vec3::from(*point).as_dvec3()).as_vec3();
    Ok((mesh.points.iter().map(place).collect(), mesh.triangles()))
}

/// The emitter that is asked for.
///
/// # Safety
/// `matrix` is NULL or twelve doubles.
pub unsafe fn emitter(
    given: &RlvFluidEmitterOptions,
    mesh: RlvMesh,
    matrix: *const f64,
    spacing: f32,
) -> Result<Emitter> {
    let [middle, u, v] = [given.middle, given.u, given.v].map(Vec3::from);
    let mut made = match given.shape {
        RLV_FLUID_DISC => Emitter::disc(middle, u, given.radius, given.speed, spacing)?,
        RLV_FLUID_RECTANGLE => Emitter::rectangle(middle, [u, v], given.speed, spacing)?,
        RLV_FLUID_SURFACE => {
            let object = registry::get(mesh)?;
            // SAFETY: promised by the caller.
            let (points, triangles) = unsafe { placed(&*try_read(&object.mesh, "mesh")?, matrix) }?;
            Emitter::mesh(&points, &triangles, given.speed, spacing)?
        }
        other => return Err(Error::invalid(format!("there is no shape {other}")).at("shape").advise("use 0 to 2")),
    };
    let lifetime = if given.lifetime == 0.0 { f32::INFINITY } else { given.lifetime };
    let end = if given.end == 0.0 { f64::INFINITY } else { given.end };
    if !(lifetime > 0.0 && given.begin.is_finite() && end > given.begin) {
        return Err(Error::invalid("its particles do not live, or it ends before it begins")
            .at("emitter")
            .advise("use positive seconds, or 0 for no end"));
    }
    (made.time, made.lifetime) = ([given.begin, end], lifetime);
    Ok(made)
}
