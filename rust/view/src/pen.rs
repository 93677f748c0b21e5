//! Pens under X11: how hard they press and how far they lean, which winit does not report.
//!
//! A connection of its own listens to the raw events of XInput 2.2. Any number of connections may, so that the window's
//! events stay as they are.

/// How a pen is held.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct PenState {
    /// How hard it presses, 0 to 1.
    pub pressure: f64,
    /// Degrees between the pen and a line upright on the tablet, 0 to 90.
    pub lean: f64,
}

impl PenState {
    /// What a mouse is like: a pen that is upright and presses fully.
    pub(crate) const MOUSE: Self = Self { pressure: 1.0, lean: 0.0 };
}

/// Returns the state at the `event`-th of `events` places that the pointer came to, of the `states` of the same time.
pub(crate) fn state_at(states: &[PenState], event: usize, events: usize) -> Option<PenState> {
    let place = (event + 1) * states.len() / events.max(1);
    states.get(place.saturating_sub(1)).or(states.last()).copied()
}

#[cfg(all(unix, not(target_vendor = "apple")))]
pub(crate) use x11::Pens;

#[cfg(not(all(unix, not(target_vendor = "apple"))))]
/// The pens of the display: none on this system.
pub(crate) struct Pens;

#[cfg(not(all(unix, not(target_vendor = "apple"))))]
impl Pens {
    /// Begins to listen to the pens of the display; `None` where that is not possible.
    pub(crate) fn open() -> Option<Self> {
        None
    }

    /// Returns the states of the pen that is moved since the last call.
    pub(crate) fn take(&mut self) -> Vec<PenState> {
        Vec::new()
    }
}

#[cfg(all(unix, not(target_vendor = "apple")))]
mod x11 {
    use std::collections::HashMap;
    use std::error::Error;

    use x11rb::connection::Connection;
    use x11rb::protocol::Event;
    use x11rb::protocol::xinput::{self, ConnectionExt as _, DeviceClassData, Fp3232, XIEventMask};
    use x11rb::protocol::xproto::ConnectionExt as _;
    use x11rb::rust_connection::RustConnection;

    use super::PenState;

    /// All devices, and all that move a pointer of the display, as XInput 2 numbers them.
    const ALL: u16 = 0;
    const POINTERS: u16 = 1;
    /// Degrees that the largest value of an axis of tilt stands for.
    const TILT: f64 = 64.0;

    /// An axis of a device.
    #[derive(Clone, Copy, Debug, PartialEq)]
    struct Axis {
        number: u16,
        range: [f64; 2],
        value: f64,
    }

    impl Axis {
        /// Where the value is in its range, 0 to 1.
        fn share(&self) -> f64 {
            let [from, to] = self.range;
            ((self.value - from) / (to - from)).clamp(0.0, 1.0)
        }

        /// The tangent of the angle that the value stands for.
        fn slope(&self) -> f64 {
            (TILT * (2.0 * self.share() - 1.0)).to_radians().tan()
        }
    }

    /// The axes that pens have and mice have not.
    #[derive(Clone, Copy, Debug, Default, PartialEq)]
    struct Axes {
        pressure: Option<Axis>,
        tilt: [Option<Axis>; 2],
    }

    impl Axes {
        /// Adds an axis if it is one of a pen, by the name that drivers give it.
        fn add(&mut self, name: &[u8], axis: Axis) {
            let place = match name {
                b"Abs Pressure" => &mut self.pressure,
                b"Abs Tilt X" => &mut self.tilt[0],
                b"Abs Tilt Y" => &mut self.tilt[1],
                _ => return,
            };
            // The range comes from the driver.
            *place = (axis.range[0] < axis.range[1]).then_some(axis);
        }

        /// Takes on the values of an event: those whose bits `mask` has, in their order.
        fn take(&mut self, mask: &[u32], values: &[Fp3232]) {
            let numbers = (0..32 * mask.len()).filter(|number| mask[number / 32] >> (number % 32) & 1 != 0);
            for (number, value) in numbers.zip(values) {
                let [x, y] = &mut self.tilt;
                for axis in [&mut self.pressure, x, y].into_iter().flatten() {
                    if usize::from(axis.number) == number {
                        axis.value = decimal(*value);
                    }
                }
            }
        }

        fn state(&self) -> PenState {
            let [x, y] = self.tilt.map(|axis| axis.map_or(0.0, |axis| axis.slope()));
            let pressure = self.pressure.map_or(1.0, |axis| axis.share());
            PenState { pressure, lean: x.hypot(y).atan().to_degrees() }
        }
    }

    fn decimal(value: Fp3232) -> f64 {
        f64::from(value.integral) + f64::from(value.frac) / (f64::from(u32::MAX) + 1.0)
    }

    /// The pens of the display.
    pub(crate) struct Pens {
        connection: RustConnection,
        /// By the numbers of devices, of pens alone.
        axes: HashMap<u16, Axes>,
    }

    impl Pens {
        /// Begins to listen to the pens of the display; `None` where that is not possible.
        pub(crate) fn open() -> Option<Self> {
            let (connection, screen) = RustConnection::connect(None).ok()?;
            let mut pens = Self { connection, axes: HashMap::new() };
            pens.listen(screen).ok()?;
            Some(pens)
        }

        fn listen(&mut self, screen: usize) -> Result<(), Box<dyn Error>> {
            self.connection.xinput_xi_query_version(2, 2)?.reply()?;
            let root = self.connection.setup().roots.get(screen).ok_or("no screen")?.root;
            let mask = |deviceid, mask| xinput::EventMask { deviceid, mask: vec![mask] };
            let masks = [mask(ALL, XIEventMask::HIERARCHY), mask(POINTERS, XIEventMask::RAW_MOTION)];
            self.connection.xinput_xi_select_events(root, &masks)?.check()?;
            self.axes = self.found()?;
            Ok(())
        }

        /// The devices that are there.
        fn found(&self) -> Result<HashMap<u16, Axes>, Box<dyn Error>> {
            let mut found = HashMap::new();
            for device in self.connection.xinput_xi_query_device(ALL)?.reply()?.infos {
                let mut axes = Axes::default();
                for class in device.classes {
                    let DeviceClassData::Valuator(it) = class.data else { continue };
                    if it.label == x11rb::NONE {
                        continue;
                    }
                    let name = self.connection.get_atom_name(it.label)?.reply()?.name;
                    let [low, high, value] = [it.min, it.max, it.value].map(decimal);
                    axes.add(&name, Axis { number: it.number, range: [low, high], value });
                }
                if axes != Axes::default() {
                    found.insert(device.deviceid, axes);
                }
            }
            Ok(found)
        }

        /// Returns the states of the pen that is moved since the last call, [`PenState::MOUSE`] where that is a mouse.
        pub(crate) fn take(&mut self) -> Vec<PenState> {
            let mut states = Vec::new();
            while let Ok(Some(event)) = self.connection.poll_for_event() {
                match event {
                    Event::XinputRawMotion(event) => {
                        let axes = self.axes.get_mut(&event.sourceid);
                        states.push(axes.map_or(PenState::MOUSE, |axes| {
                            axes.take(&event.valuator_mask, &event.axisvalues);
                            axes.state()
                        }));
                    }
                    // A pen was plugged in or out.
                    Event::XinputHierarchy(_) => self.axes = self.found().unwrap_or_default(),
                    _ => {}
                }
            }
            states
        }
    }

    #[cfg(test)]
    mod tests {
        use super::*;

        #[test]
        fn values_of_events_are_pressure_and_lean() {
            let number = |integral| Fp3232 { integral, frac: 0 };
            let axis = |number, range| Axis { number, range, value: 0.0 };
            let mut axes = Axes::default();
            axes.add(b"Abs X", axis(0, [0.0, 1e4]));
            axes.add(b"Abs Pressure", axis(2, [0.0, 2048.0]));
            axes.add(b"Abs Tilt X", axis(3, [-64.0, 64.0]));
            axes.add(b"Abs Tilt Y", axis(34, [-64.0, 64.0]));
            assert_eq!(axes.state(), PenState { pressure: 0.0, lean: 0.0 });
            // x, y, pressure and the second tilt.
            axes.take(&[0b111, 0b100], &[70, 80, 512, -45].map(number));
            let state = axes.state();
            assert!((state.pressure - 0.25).abs() < 1e-12 && (state.lean - 45.0).abs() < 1e-9, "{state:?}");
            // What an event does not have stays.
            axes.take(&[0b1000], &[number(45)]);
            let state = axes.state();
            assert!((state.pressure - 0.25).abs() < 1e-12 && (state.lean - 54.7356).abs() < 1e-3, "{state:?}");
            axes.take(&[0b100], &[number(1 << 20)]);
            assert_eq!(axes.state().pressure, 1.0);
            // Fewer values than bits, and a driver's range of nothing.
            axes.take(&[u32::MAX; 4], &[number(1), number(2)]);
            axes.add(b"Abs Pressure", axis(2, [5.0, 5.0]));
            assert_eq!(axes.state().pressure, 1.0);
        }

        #[test]
        fn fractions_are_added() {
            assert_eq!(decimal(Fp3232 { integral: -2, frac: 1 << 31 }), -1.5);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn states_are_spread_over_the_places_of_the_pointer() {
        let states = [0.1, 0.2, 0.3, 0.4].map(|pressure| PenState { pressure, lean: 0.0 });
        let at = |events: usize| -> Vec<f64> {
            (0..events).filter_map(|event| state_at(&states, event, events)).map(|state| state.pressure).collect()
        };
        assert_eq!(at(4), [0.1, 0.2, 0.3, 0.4]);
        assert_eq!(at(2), [0.2, 0.4]);
        assert_eq!(at(6), [0.1, 0.1, 0.2, 0.2, 0.3, 0.4]);
        assert_eq!(state_at(&states, 0, 0), Some(states[3]));
        assert_eq!(state_at(&[], 0, 3), None);
    }
}
