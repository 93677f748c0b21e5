//! What happens to a fluid on its way through time, beside its own motion: colliders and bodies move, particles come and go.

use relievo_core::{Context, Error, Result};
use relievo_fluid::{Bodies, DeviceFluid, Fluid, Sources, StepStatistics};
use relievo_gpu::Device;

use crate::mover::Mover;

/// The moving parts of a description.
pub struct Play {
    /// Colliders of the fluid by their numbers; those of bodies come after them.
    pub movers: Vec<Mover>,
    /// What particles come from and where they go.
    pub sources: Sources,
    /// Rigid bodies.
    pub bodies: Bodies,
}

impl Play {
    /// Simulates so many seconds from a time on, and calls `watch` after each step. All but bodies follows from the time
    /// alone, so a fluid that was put back into a state, with its bodies, goes on as it did.
    ///
    /// # Errors
    /// Returns the error of `watch`, and fails with `Invalid` if pressures do not converge or something goes where it
    /// cannot be, with `Memory` for more than 2³⁰ particles, and with `Io` if another rank has ended.
    pub fn advance(
        &mut self,
        context: &Context,
        fluid: &mut Fluid,
        time: f64,
        seconds: f32,
        mut watch: impl FnMut(&mut Fluid, &StepStatistics) -> Result<()>,
    ) -> Result<()> {
        self.move_colliders(context, fluid, time, seconds)?;
        let mut since = fluid.seconds();
        let renewed = |fluid: &mut Fluid, done: &StepStatistics| {
            self.sources.renew(fluid, since)?;
            since = fluid.seconds();
            watch(fluid, done)
        };
        if self.bodies.is_empty() {
            return fluid.advance(context, seconds, renewed);
        }
        self.bodies.advance(context, fluid, seconds, renewed)
    }

    /// Has colliders go so many seconds from a time on.
    fn move_colliders(&mut self, context: &Context, fluid: &mut Fluid, time: f64, seconds: f32) -> Result<()> {
        for (number, mover) in self.movers.iter().enumerate().filter(|(_, mover)| mover.is_moving()) {
            let times = [time, time + f64::from(seconds)];
            let [from, to] = [mover.at(context, times[0])?, mover.at(context, times[1])?];
            fluid.move_collider(context, number, [&from, &to], seconds)?;
            if !self.bodies.is_empty() && mover.is_changing() {
                self.bodies.bend_obstacle(number, [&from, &to])?;
            } else if !self.bodies.is_empty() {
                self.bodies.move_obstacle(number, times.map(|time| mover.pose(time)))?;
            }
        }
        Ok(())
    }

    /// The same on a device, where nothing comes or goes and no bodies move.
    ///
    /// # Errors
    /// Fails with `Unsupported` if something does, as [`DeviceFluid::new`] does, with `Invalid` if pressures do not
    /// converge, with `Device` if the device was lost, and as `watch` does.
    pub fn advance_on(
        &mut self,
        (context, device): (&Context, &Device),
        fluid: &mut Fluid,
        time: f64,
        seconds: f32,
        mut watch: impl FnMut(&StepStatistics) -> Result<()>,
    ) -> Result<()> {
        if !(self.sources.emitters.is_empty() && self.sources.sinks.is_empty()) {
            return Err(Error::unsupported("fluids on devices have no emitters and sinks").advise("use `--device cpu`"));
        }
        if !self.bodies.is_empty() {
            return Err(Error::unsupported("fluids on devices have no rigid bodies").advise("use `--device cpu`"));
        }
        self.move_colliders(context, fluid, time, seconds)?;
        let mut sent = DeviceFluid::new(device, fluid)?;
        sent.advance(seconds, |_, done| watch(done))?;
        fluid.set_state(sent.state()?)
    }
}
