//! Fluids on the graphics device, by its own clock: particle-steps a second, after the start of a dam.

use relievo_core::{ErrorKind, Result};
use relievo_fluid::{DeviceFluid, Fluid};
use relievo_gpu::{AdapterKind, Device, DeviceOptions, PassTime};

use crate::measure::Sample;
use crate::report::{Goal, Report};

/// Steps in which a dam gets going before the measured steps, and the measured steps.
const STEPS: [usize; 2] = [10, 20];
/// Millions of particle-steps a second that a graphics card makes with so many particles.
const CARD: (f64, usize) = (100.0, 1_250_000);

/// Measures the steps of a fluid.
pub fn case(report: &mut Report, fluid: &Fluid) -> Result<()> {
    let name = format!("PCISPH, {} particles, on a device", fluid.len());
    let device = match Device::open(&DeviceOptions { timing: true, ..DeviceOptions::default() }) {
        Ok(device) => device,
        Err(error) => {
            report.skip(&name, &error.to_string());
            return Ok(());
        }
    };
    match steps(report, &device, &name, fluid) {
        // Lists of neighbours are larger than some devices have buffers.
        Err(error) if error.kind == ErrorKind::Memory => {
            report.skip(&name, &error.to_string());
            Ok(())
        }
        made => made,
    }
}

fn steps(report: &mut Report, device: &Device, name: &str, fluid: &Fluid) -> Result<()> {
    let mut sent = DeviceFluid::new(device, fluid)?;
    let mut rates = Vec::new();
    for step in 0..STEPS[0] + STEPS[1] {
        sent.step(sent.time_step())?;
        let seconds: f64 = sent.times().iter().map(|PassTime { length, .. }| length.as_secs_f64()).sum();
        if step >= STEPS[0] {
            rates.push(fluid.len() as f64 / seconds / 1e6);
        }
    }
    let is_card = device.summary().kind != AdapterKind::Software && fluid.len() >= CARD.1;
    let goal = if is_card { Goal::AtLeast(CARD.0) } else { Goal::None };
    report.add(name, &Sample::new(rates), None, "M particle-steps/s", goal);
    Ok(())
}
