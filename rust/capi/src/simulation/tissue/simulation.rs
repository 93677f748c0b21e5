//! Simulations of soft tissue.

use std::ffi::{c_char, c_void};
use std::path::Path;
use std::sync::{Arc, RwLock};

use relievo_core::progress::Silent;
use relievo_core::{Attribute, Domain, Error, Mesh, Progress, Result, Values};
use relievo_tissue::{
    Binding, Body, Collider, Curve, DistanceField, Drive, Pressure, SavedState, Simulation, SimulationOptions,
};

use super::{RLV_TISSUE_BALL, RLV_TISSUE_FLOOR, RLV_TISSUE_MESH, RlvTissue, check_axes, item, nodes_of};
use crate::border::array::{Input, Output, Plain, present, put, text};
use crate::border::descriptor::{check_optional, read_descriptor, read_optional, write_descriptor, write_optional};
use crate::border::registry::{self, handle, try_read, try_write};
use crate::runtime::bytes::{self, RlvBytes};
use crate::runtime::context::{ContextObject, HostProgress, RlvProgress};
use crate::surfaces::mesh::{self, RlvMesh};

handle!(RlvTissueSimulation, 29, TissueSimulationObject);

descriptor! {
    pub struct RlvTissueOptions {
        struct_size: u32,
        halvings: u32,
        gravity: [f32; 3],
        damping: f32,
        step: f32,
        safety: f32,
        hourglass: f32,
        mass_scaling: f32,
        self_friction: f32,
    }
}

descriptor! {
    pub struct RlvTissueSimulationInfo {
        struct_size: u32,
        stiffest_element: u32,
        step: f32,
        stable_step: f32,
        added_mass: f32,
        reserved: u32,
        steps: u64,
        seconds: f64,
        halved: u64,
    }
}

descriptor! {
    pub struct RlvTissueEnergies {
        struct_size: u32,
        reserved: u32,
        kinetic: f64,
        elastic: f64,
        potential: f64,
    }
}

descriptor! {
    pub struct RlvTissueRelaxation {
        struct_size: u32,
        is_at_rest: u32,
        steps: u64,
        unbalanced: f32,
        largest: f32,
    }
}

descriptor! {
    pub struct RlvTissueCollider {
        struct_size: u32,
        body: u32,
        mesh: RlvMesh,
        radius: f32,
        friction: f32,
        times: *const f64,
        translations: *const f32,
        rotations: *const f32,
        key_count: usize,
    }
}

descriptor! {
    pub struct RlvTissueArrays {
        struct_size: u32,
        reserved: u32,
        node_count: usize,
        positions: *mut f32,
        velocities: *mut f32,
        element_count: usize,
        stresses: *mut f32,
        principal_stresses: *mut f32,
        von_mises: *mut f32,
        volumes: *mut f32,
        fibre_stretches: *mut f32,
        strains: *mut f32,
        principal_strains: *mut f32,
        contact_pressures: *mut f32,
    }
}

/// A simulation and the context it belongs to.
pub struct TissueSimulationObject {
    pub context: Arc<ContextObject>,
    simulation: RwLock<Simulation>,
    /// The checksum of the model's file, by which states are known.
    checksum: u32,
}

impl TissueSimulationObject {
    /// Goes on by whole steps that end at or just after so many seconds.
    ///
    /// # Errors
    /// Fails with `Invalid` if the seconds are negative or not finite, with `Busy` while another call is at work on the
    /// simulation, with `Cancelled` if `progress` asks to stop, and as the steps do.
    pub fn advance(&self, seconds: f64, progress: &mut dyn Progress) -> Result<()> {
        if !(seconds >= 0.0 && seconds.is_finite()) {
            return Err(Error::invalid(format!("{seconds} seconds cannot be simulated"))
                .at("seconds")
                .advise("use 0 or more"));
        }
        let mut simulation = try_write(&self.simulation, "tissue simulation")?;
        progress.step(0.0, "steps")?;
        let steps = (seconds / f64::from(simulation.steps().step) - 1e-6).ceil().max(0.0) as u64;
        self.take_steps(&mut simulation, steps, progress)
    }

    /// Takes steps, and logs where the processor took over from a device.
    fn take_steps(&self, simulation: &mut Simulation, steps: u64, progress: &mut dyn Progress) -> Result<()> {
        let outcome = simulation.advance(&self.context.context, steps, progress);
        if let Some(fault) = simulation.take_device_fault() {
            let text = format!("the processor took over the steps of soft tissue: {fault}");
            self.context.log(crate::runtime::context::RLV_LOG_WARNING, &text);
        }
        outcome
    }

    fn change<T>(&self, work: impl FnOnce(&mut Simulation) -> Result<T>) -> Result<T> {
        work(&mut *try_write(&self.simulation, "tissue simulation")?)
    }

    /// Goes on from a state that was read from `place`.
    fn restore(&self, saved: SavedState, place: &str) -> Result<()> {
        if saved.identity != self.checksum {
            let error = Error::invalid("it is the state of another model").at(place);
            return Err(error.advise("take a state of this model"));
        }
        self.change(|simulation| simulation.set_state(saved.state).map_err(|error| error.at(place)))
    }

    fn look<T>(&self, work: impl FnOnce(&Simulation) -> Result<T>) -> Result<T> {
        work(&*try_read(&self.simulation, "tissue simulation")?)
    }
}

/// Returns the curve of values at times; `default` everywhere if there are no keys.
///
/// # Safety
/// There are `count` times and `count` values.
unsafe fn curve<const N: usize>(
    name: &str,
    times: *const f64,
    values: *const [f32; N],
    count: usize,
    default: [f32; N],
) -> Result<Curve<N>>
where
    [f32; N]: Plain,
{
    if count == 0 {
        return Ok(Curve::constant(default));
    }
    // SAFETY: promised by the caller.
    let (times, values) = unsafe { (Input::new("times", times, count, 0)?, Input::new(name, values, count, 0)?) };
    Curve::new(times.iter().zip(values.iter()).collect()).map_err(|error| error.at(name))
}

/// Returns options.
///
/// # Safety
/// `options` is NULL or a descriptor that starts with its size.
unsafe fn options_of(options: *const RlvTissueOptions) -> Result<SimulationOptions> {
    let usual = SimulationOptions::default();
    let default = RlvTissueOptions {
        struct_size: 0,
        halvings: usual.halvings,
        gravity: usual.gravity,
        damping: usual.damping,
        step: 0.0,
        safety: usual.safety,
        hourglass: usual.hourglass,
        mass_scaling: 0.0,
        self_friction: -1.0,
    };
    // SAFETY: promised by the caller.
    let given = unsafe { read_optional(options, default) }?;
    let positive = |step: f32| (step != 0.0).then_some(step);
    Ok(SimulationOptions {
        gravity: given.gravity,
        damping: given.damping,
        step: positive(given.step),
        safety: given.safety,
        hourglass: given.hourglass,
        mass_scaling: positive(given.mass_scaling),
        halvings: given.halvings,
        self_friction: (given.self_friction != -1.0).then_some(given.self_friction),
    })
}

/// Returns a collider.
///
/// # Safety
/// `given` has as many keys as it states.
unsafe fn collider_of(given: &RlvTissueCollider) -> Result<Collider> {
    let body = match given.body {
        RLV_TISSUE_FLOOR => Body::Floor,
        RLV_TISSUE_BALL => Body::Ball(given.radius),
        RLV_TISSUE_MESH => {
            let object = registry::get(given.mesh)?;
            let mesh = try_read(&object.mesh, "mesh")?;
            Body::Mesh(DistanceField::new(&mesh.points, &mesh.triangles())?)
        }
        other => {
            return Err(Error::invalid(format!("there is no body {other}"))
                .at("body")
                .advise("use a value of RlvTissueBody"));
        }
    };
    let path = |name: &str, values: *const f32| {
        let count = if values.is_null() { 0 } else { given.key_count };
        // SAFETY: promised by the caller.
        unsafe { curve(name, given.times, values.cast::<[f32; 3]>(), count, [0.0; 3]) }
    };
    let motion = path("translations", given.translations)?;
    Collider::new(body, given.friction, motion, path("rotations", given.rotations)?)
}

/// Returns the points of a bound surface and their velocities.
fn bound(context: &ContextObject, simulation: &Simulation, binding: &Binding) -> [Vec<[f32; 3]>; 2] {
    let (model, state) = (simulation.model(), simulation.state());
    let still = vec![[0.0; 4]; model.nodes.len()];
    let [points, moved, rest] =
        [&state.displacements, &state.velocities, &still].map(|rows| binding.points(&context.context, model, rows));
    let apart = |(moved, rest): (&[f32; 3], &[f32; 3])| std::array::from_fn(|axis| moved[axis] - rest[axis]);
    [points, moved.iter().zip(&rest).map(apart).collect()]
}

entry! {
    fn rlv_tissue_simulate(tissue: RlvTissue, options: *const RlvTissueOptions, out: *mut RlvTissueSimulation) {
        present("out", out)?;
        let object = registry::get(tissue)?;
        // SAFETY: the caller gives NULL or a descriptor that starts with its size.
        let options = unsafe { options_of(options) }?;
        let model = try_read(&object.model, "tissue")?.clone();
        let checksum = model.checksum();
        let mut simulation = Simulation::new(model, &options)?;
        simulation.use_device(object.context.device());
        let simulation = RwLock::new(simulation);
        let made =
            registry::insert(TissueSimulationObject { context: object.context.clone(), simulation, checksum })?;
        // SAFETY: checked above.
        unsafe { put(out, made) };
        Ok(())
    }

    fn rlv_tissue_simulation_retain(simulation: RlvTissueSimulation) {
        registry::retain(simulation)
    }

    fn rlv_tissue_simulation_release(simulation: RlvTissueSimulation) {
        registry::release(simulation)
    }

    fn rlv_tissue_simulation_info(simulation: RlvTissueSimulation, out: *mut RlvTissueSimulationInfo) {
        let info = registry::get(simulation)?.look(|simulation| {
            let (steps, state) = (simulation.steps(), simulation.state());
            Ok(RlvTissueSimulationInfo {
                struct_size: 0,
                stiffest_element: steps.element,
                step: steps.step,
                stable_step: steps.stable,
                added_mass: steps.added_mass,
                reserved: 0,
                steps: state.steps,
                seconds: state.seconds,
                halved: simulation.halved(),
            })
        })?;
        // SAFETY: the caller gives NULL or a descriptor that starts with its size.
        unsafe { write_descriptor(out, info) }
    }

    fn rlv_tissue_simulation_energies(simulation: RlvTissueSimulation, out: *mut RlvTissueEnergies) {
        let object = registry::get(simulation)?;
        let energies = object.change(|simulation| simulation.energies(&object.context.context))?;
        let made = RlvTissueEnergies {
            struct_size: 0,
            reserved: 0,
            kinetic: energies.kinetic,
            elastic: energies.elastic,
            potential: energies.potential,
        };
        // SAFETY: the caller gives NULL or a descriptor that starts with its size.
        unsafe { write_descriptor(out, made) }
    }

    fn rlv_tissue_simulation_activate(
        simulation: RlvTissueSimulation,
        muscle: u32,
        times: *const f64,
        values: *const f32,
        count: usize,
    ) {
        let object = registry::get(simulation)?;
        // SAFETY: the caller promises `count` numbers in each array.
        let (times, values) = unsafe { (Input::new("times", times, count, 0)?, Input::new("values", values, count, 0)?) };
        let keys = times.iter().zip(values.iter()).map(|(time, value)| (time, [value])).collect();
        let activation = Curve::new(keys).map_err(|error| error.at("times"))?;
        object.change(|simulation| simulation.activate(muscle as usize, activation))
    }

    fn rlv_tissue_simulation_drive(
        simulation: RlvTissueSimulation,
        nodes: *const u32,
        count: usize,
        axes: u32,
        times: *const f64,
        displacements: *const f32,
        key_count: usize,
    ) {
        let object = registry::get(simulation)?;
        check_axes(axes)?;
        // SAFETY: the caller promises as many keys as it states.
        let displacement = unsafe { curve("displacements", times, displacements.cast(), key_count, [0.0; 3]) }?;
        object.change(|simulation| {
            // SAFETY: the caller promises `count` nodes.
            let nodes = unsafe { nodes_of(nodes, count, 0, simulation.model().nodes.len()) }?;
            simulation.drive(Drive { nodes, axes, displacement })
        })
    }

    fn rlv_tissue_simulation_load(
        simulation: RlvTissueSimulation,
        forces: *const f32,
        count: usize,
        stride: usize,
    ) {
        let object = registry::get(simulation)?;
        let limit = object.context.context.memory_limit();
        // SAFETY: the caller promises `count` forces.
        let forces = unsafe { Input::new("forces", forces.cast(), count, stride) }?.to_vec("forces", limit)?;
        object.change(|simulation| simulation.load(&forces).map_err(|error| error.at("forces")))
    }

    fn rlv_tissue_simulation_press(
        simulation: RlvTissueSimulation,
        nodes: *const u32,
        count: usize,
        times: *const f64,
        pressures: *const f32,
        key_count: usize,
    ) {
        let object = registry::get(simulation)?;
        // SAFETY: the caller promises as many keys as it states.
        let (times, pressures) = unsafe {
            (Input::new("times", times, key_count, 0)?, Input::new("pressures", pressures, key_count, 0)?)
        };
        let keys = times.iter().zip(pressures.iter()).map(|(time, pressure)| (time, [pressure])).collect();
        let pressure = Curve::new(keys).map_err(|error| error.at("times"))?;
        object.change(|simulation| {
            // SAFETY: the caller promises `count` nodes.
            let nodes = unsafe { nodes_of(nodes, count, 0, simulation.model().nodes.len()) }?;
            let faces = simulation.model().outer_faces_of(&nodes);
            if faces.is_empty() {
                return Err(Error::invalid("no outer face has all its nodes among them")
                    .at("nodes")
                    .advise("give all nodes of the faces that are pressed"));
            }
            simulation.press(Pressure { faces, pressure })
        })
    }

    fn rlv_tissue_simulation_add_collider(simulation: RlvTissueSimulation, collider: *const RlvTissueCollider) {
        let object = registry::get(simulation)?;
        // SAFETY: a descriptor of nothing but numbers, NULL pointers and a null handle.
        let default: RlvTissueCollider = unsafe { std::mem::zeroed() };
        // SAFETY: the caller gives NULL or a descriptor that starts with its size, with keys of their count.
        let made = unsafe { collider_of(&read_descriptor(collider, default)?) }.map_err(|error| error.at("collider"))?;
        object.change(|simulation| {
            simulation.add_collider(made);
            Ok(())
        })
    }

    fn rlv_tissue_simulation_step(simulation: RlvTissueSimulation, count: u64) {
        let object = registry::get(simulation)?;
        object.change(|simulation| object.take_steps(simulation, count, &mut Silent))
    }

    fn rlv_tissue_simulation_advance(
        simulation: RlvTissueSimulation,
        seconds: f64,
        progress: RlvProgress,
        user: *mut c_void,
    ) {
        registry::get(simulation)?.advance(seconds, &mut HostProgress { callback: progress, user })
    }

    fn rlv_tissue_simulation_relax(
        simulation: RlvTissueSimulation,
        tolerance: f32,
        steps: u64,
        progress: RlvProgress,
        user: *mut c_void,
        out: *mut RlvTissueRelaxation,
    ) {
        let object = registry::get(simulation)?;
        // SAFETY: the caller gives NULL or a descriptor that starts with its size.
        unsafe { check_optional(out) }?;
        if !(tolerance >= 0.0 && tolerance.is_finite()) {
            return Err(Error::invalid(format!("a tolerance of {tolerance} cannot be"))
                .at("tolerance")
                .advise("use 0 or more, such as 0.001"));
        }
        let mut progress = HostProgress { callback: progress, user };
        let done = object.change(|it| it.relax(&object.context.context, tolerance, steps, &mut progress))?;
        let made = RlvTissueRelaxation {
            struct_size: 0,
            is_at_rest: done.is_at_rest.into(),
            steps: done.steps,
            unbalanced: done.unbalanced[0],
            largest: done.unbalanced[1],
        };
        // SAFETY: as above.
        unsafe { write_optional(out, made) }
    }

    fn rlv_tissue_simulation_get(simulation: RlvTissueSimulation, arrays: *const RlvTissueArrays) {
        let object = registry::get(simulation)?;
        // SAFETY: a descriptor of nothing but numbers and NULL pointers.
        let default: RlvTissueArrays = unsafe { std::mem::zeroed() };
        // SAFETY: the caller gives NULL or a descriptor that starts with its size.
        let given = unsafe { read_descriptor(arrays, default) }?;
        object.look(|simulation| {
            let (nodes, elements) = (given.node_count, given.element_count);
            let (count, cells) = (simulation.model().nodes.len(), simulation.model().elements.len());
            let of_node = |name: &str, to: *mut f32| {
                // SAFETY: the caller promises room for so many nodes in each array that is not NULL.
                let out = unsafe { Output::<[f32; 3]>::optional(name, to.cast(), nodes, 0) }?;
                out.map(|out| out.holds("node_count", count)).transpose()
            };
            let of_element = |name: &str, to: *mut f32| {
                // SAFETY: the caller promises room for so many elements in each array that is not NULL.
                let out = unsafe { Output::<f32>::optional(name, to, elements, 0) }?;
                out.map(|out| out.holds("element_count", cells)).transpose()
            };
            let triples = |name: &str, to: *mut f32| {
                // SAFETY: as above, with three numbers each.
                let out = unsafe { Output::<[f32; 3]>::optional(name, to.cast(), elements, 0) }?;
                out.map(|out| out.holds("element_count", cells)).transpose()
            };
            let tensors = |name: &str, to: *mut f32| {
                // SAFETY: as above, with six numbers each.
                let out = unsafe { Output::<[f32; 6]>::optional(name, to.cast(), elements, 0) }?;
                out.map(|out| out.holds("element_count", cells)).transpose()
            };
            let positions = of_node("positions", given.positions)?;
            let velocities = of_node("velocities", given.velocities)?;
            // SAFETY: as above, with a number a node.
            let pressures = unsafe { Output::<f32>::optional("contact_pressures", given.contact_pressures, nodes, 0) }?;
            let pressures = pressures.map(|out| out.holds("node_count", count)).transpose()?;
            let stresses = tensors("stresses", given.stresses)?;
            let strains = tensors("strains", given.strains)?;
            let principal_stresses = triples("principal_stresses", given.principal_stresses)?;
            let principal_strains = triples("principal_strains", given.principal_strains)?;
            let von_mises = of_element("von_mises", given.von_mises)?;
            let volumes = of_element("volumes", given.volumes)?;
            let stretches = of_element("fibre_stretches", given.fibre_stretches)?;
            // What can fail comes before the first array is written to.
            let context = &object.context.context;
            let pressed = match pressures {
                Some(_) => simulation.contact_pressures(context)?,
                None => Vec::new(),
            };
            let is_wanted = [stresses.is_some(), strains.is_some(), von_mises.is_some(), volumes.is_some()].contains(&true)
                || [principal_stresses.is_some(), principal_strains.is_some(), stretches.is_some()].contains(&true);
            let states = if is_wanted { simulation.element_states(context)? } else { Vec::new() };
            if let Some(out) = positions {
                out.fill(simulation.positions());
            }
            if let Some(out) = velocities {
                out.fill(simulation.state().velocities.iter().map(|row| [row[0], row[1], row[2]]));
            }
            if let Some(out) = pressures {
                out.fill(pressed);
            }
            if let Some(out) = stresses {
                out.fill(states.iter().map(|state| state.stress));
            }
            if let Some(out) = strains {
                out.fill(states.iter().map(|state| state.strain));
            }
            if let Some(out) = principal_stresses {
                out.fill(states.iter().map(|state| state.principal));
            }
            if let Some(out) = principal_strains {
                out.fill(states.iter().map(|state| state.principal_strain));
            }
            if let Some(out) = von_mises {
                out.fill(states.iter().map(|state| state.von_mises));
            }
            if let Some(out) = volumes {
                out.fill(states.iter().map(|state| state.volume));
            }
            if let Some(out) = stretches {
                out.fill(states.iter().map(|state| state.fibre_stretch));
            }
            Ok(())
        })
    }

    fn rlv_tissue_simulation_get_bound(
        simulation: RlvTissueSimulation,
        index: u32,
        points: *mut f32,
        count: usize,
        stride: usize,
    ) {
        let object = registry::get(simulation)?;
        object.look(|simulation| {
            let binding = item(&simulation.model().bindings, "bound surface", index)?;
            // SAFETY: the caller promises room for `count` points.
            let out = unsafe { Output::<[f32; 3]>::new("points", points.cast(), count, stride) }?;
            let out = out.holds("points", binding.anchors.len())?;
            let [points, _] = bound(&object.context, simulation, binding);
            out.fill(points);
            Ok(())
        })
    }

    fn rlv_tissue_simulation_mesh(simulation: RlvTissueSimulation, index: u32, out: *mut RlvMesh) {
        present("out", out)?;
        let object = registry::get(simulation)?;
        let mesh = object.look(|simulation| {
            let binding = item(&simulation.model().bindings, "bound surface", index)?;
            let [points, velocities] = bound(&object.context, simulation, binding);
            let mut mesh = Mesh::from_triangles(points, &binding.triangles);
            mesh.attributes.push(Attribute {
                name: "velocity".into(),
                domain: Domain::Point,
                width: 3,
                values: Values::F32(velocities.into_flattened()),
                indices: None,
            });
            mesh.check()?;
            Ok(mesh)
        })?;
        let made = mesh::register(object.context.clone(), mesh)?;
        // SAFETY: checked above.
        unsafe { put(out, made) };
        Ok(())
    }

    fn rlv_tissue_simulation_save(simulation: RlvTissueSimulation, path: *const c_char) {
        let object = registry::get(simulation)?;
        // SAFETY: the caller gives a NUL-terminated text.
        let path = unsafe { text("path", path) }?;
        let level = object.context.context.level().name().to_owned();
        object.look(|simulation| {
            let state = simulation.state().clone();
            SavedState { identity: object.checksum, level, state }.write(Path::new(path))
        })
    }

    fn rlv_tissue_simulation_save_bytes(simulation: RlvTissueSimulation, out: *mut RlvBytes) {
        present("out", out)?;
        let object = registry::get(simulation)?;
        let level = object.context.context.level().name().to_owned();
        let made = object.look(|simulation| {
            let state = simulation.state().clone();
            Ok(SavedState { identity: object.checksum, level, state }.encode())
        })?;
        // SAFETY: checked above.
        unsafe { bytes::give(made, out) }
    }

    fn rlv_tissue_simulation_restore_bytes(simulation: RlvTissueSimulation, bytes: *const u8, size: usize) {
        let object = registry::get(simulation)?;
        // SAFETY: the caller promises `size` bytes.
        let bytes = unsafe { bytes::take(bytes, size, object.context.context.memory_limit()) }?;
        object.restore(SavedState::decode(&bytes).map_err(|error| error.at("bytes"))?, "bytes")
    }

    fn rlv_tissue_simulation_restore(simulation: RlvTissueSimulation, path: *const c_char) {
        let object = registry::get(simulation)?;
        // SAFETY: the caller gives a NUL-terminated text.
        let path = unsafe { text("path", path) }?;
        object.restore(SavedState::read(&object.context.context, Path::new(path))?, path)
    }

    fn rlv_tissue_simulation_write_vtu(simulation: RlvTissueSimulation, path: *const c_char) {
        let object = registry::get(simulation)?;
        // SAFETY: the caller gives a NUL-terminated text.
        let path = unsafe { text("path", path) }?;
        object.look(|simulation| {
            let context = &object.context.context;
            let (states, pressures) = (simulation.element_states(context)?, simulation.contact_pressures(context)?);
            simulation.write_vtu(Path::new(path), &states, &pressures)
        })
    }

    fn rlv_tissue_simulation_write_vdb(simulation: RlvTissueSimulation, path: *const c_char) {
        let object = registry::get(simulation)?;
        // SAFETY: the caller gives a NUL-terminated text.
        let path = unsafe { text("path", path) }?;
        let context = &object.context.context;
        object.look(|simulation| simulation.write_vdb(context, Path::new(path), &simulation.element_states(context)?))
    }
}
