//! Total Lagrangian explicit dynamics (Miller, Joldes, Lance, Wittek 2007).
//!
//! Masses are lumped at the nodes, and time goes on by central differences in the form of Verlet's leapfrog: velocities
//! are those half a step before the present time.

mod device;

use glam::{DMat3, DVec3, Vec3};
use relievo_core::simd::prefetch;
use relievo_core::{Context, Error, ErrorKind, Progress, Result};

use self::device::OnDevice;
use crate::block::{Row, Sums};
use crate::collider::{Collider, place};
use crate::contact;
use crate::curve::Curve;
use crate::element::Elements;
use crate::model::Model;
use crate::options::{Drive, SimulationOptions};
use crate::pressure::Pressure;
use crate::self_contact::SelfContact;
use crate::slide::Slides;
use crate::stable::Steps;

/// Nodes that are moved at a time.
const CHUNK_LEN: usize = 4096;

/// Rows of forces that are fetched ahead of the one that is added.
const AHEAD: usize = 64;

/// The share of the stable step that relaxation takes at most: it begins where elements may be far from their rest.
const CAUTION: f32 = 0.6;

/// Steps between two states to which a simulation goes back where an element turns inside out.
const CHUNK: u64 = 64;

/// Steps of relaxation between two looks at the forces.
const WINDOW: u64 = 32;

/// A model in motion.
pub struct Simulation {
    model: Model,
    options: SimulationOptions,
    elements: Elements,
    steps: Steps,
    /// Inverse masses by axis, 0 where the node is held or driven, and the mass.
    masses: Vec<Row>,
    state: State,
    /// What elements exert on nodes, by rows of blocks.
    rows: Vec<Row>,
    /// Forces on nodes from outside in N; empty without such forces.
    loads: Vec<Row>,
    /// Forces of pressures on nodes at the time of the last forces of elements, in N; empty without pressures.
    pushes: Vec<Row>,
    pressures: Vec<Pressure>,
    activations: Vec<Curve<1>>,
    drives: Vec<Drive>,
    slides: Slides,
    colliders: Vec<Collider>,
    /// For each collider a node that was outside of it.
    witnesses: Vec<usize>,
    self_contact: Option<SelfContact>,
    /// Stretches of steps that were gone again by shorter ones.
    halved: u64,
    on_device: Option<OnDevice>,
    device_fault: Option<Error>,
}

impl std::fmt::Debug for Simulation {
    fn fmt(&self, out: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let (nodes, elements) = (self.model.nodes.len(), self.model.elements.len());
        out.debug_struct("Simulation").field("nodes", &nodes).field("elements", &elements).finish_non_exhaustive()
    }
}

/// Where a simulation is. The same state gives the same bits from there on.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct State {
    /// Steps so far.
    pub steps: u64,
    /// Seconds so far.
    pub seconds: f64,
    /// Displacements of the nodes in metres, and 0.
    pub displacements: Vec<[f32; 4]>,
    /// Velocities of the nodes half a step earlier, in m/s, and 0.
    pub velocities: Vec<[f32; 4]>,
}

/// Energies in J.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Energies {
    /// Of motion.
    pub kinetic: f64,
    /// Of deformation, hourglass modes included.
    pub elastic: f64,
    /// Of gravity, 0 at rest.
    pub potential: f64,
}

/// What an element is under.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct ElementState {
    /// Cauchy stress in Pa: xx, yy, zz, yz, zx, xy.
    pub stress: [f32; 6],
    /// Green–Lagrange strain, as components of the tensor: xx, yy, zz, yz, zx, xy.
    pub strain: [f32; 6],
    /// Von Mises stress in Pa.
    pub von_mises: f32,
    /// Principal stresses in Pa, the largest first.
    pub principal: [f32; 3],
    /// Principal Green–Lagrange strains, the largest first: (λ² − 1)/2 for a stretch λ.
    pub principal_strain: [f32; 3],
    /// Volume as a share of that at rest.
    pub volume: f32,
    /// Stretch of the first family of fibres; 1 where there is none.
    pub fibre_stretch: f32,
}

/// How dynamic relaxation ended.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Relaxation {
    /// Steps.
    pub steps: u64,
    /// Largest unbalanced force in N, and the largest force of elements on a node.
    pub unbalanced: [f32; 2],
    /// Whether the unbalanced force is as small as asked.
    pub is_at_rest: bool,
}

impl Simulation {
    /// Prepares a model at rest.
    ///
    /// # Errors
    /// The model or an option cannot be used, or `step` is longer than the stable step.
    pub fn new(model: Model, options: &SimulationOptions) -> Result<Self> {
        model.check()?;
        options.check()?;
        let elements = Elements::new(&model, options.hourglass)?;
        let steps = Steps::new(&model, options)?;
        let count = model.nodes.len();
        let mut sums = vec![0f64; count];
        for (element, corners) in model.elements.iter().enumerate() {
            corners.iter().for_each(|node| sums[*node as usize] += 0.125 * f64::from(steps.masses[element]));
        }
        // A node of no element has no mass and stays.
        let inverse = |mass: f64| if mass > 0.0 { (1.0 / mass) as f32 } else { 0.0 };
        let mut masses: Vec<Row> =
            sums.iter().map(|mass| [inverse(*mass), inverse(*mass), inverse(*mass), *mass as f32]).collect();
        for held in &model.held {
            (0..3).filter(|axis| held.axes >> axis & 1 != 0).for_each(|axis| masses[held.node as usize][axis] = 0.0);
        }
        let rows = vec![[0.0; 4]; elements.blocks.nodes.len()];
        let state =
            State { displacements: vec![[0.0; 4]; count], velocities: vec![[0.0; 4]; count], ..State::default() };
        let slides = Slides::new(&model)?;
        let activations = vec![Curve::constant([0.0]); model.muscles.len()];
        let self_contact = options.self_friction.map(|friction| SelfContact::new(&model, friction)).transpose()?;
        let mut simulation = Self {
            options: options.clone(),
            elements,
            steps,
            masses,
            state,
            rows,
            loads: Vec::new(),
            pushes: Vec::new(),
            pressures: Vec::new(),
            activations,
            drives: Vec::new(),
            slides,
            colliders: Vec::new(),
            witnesses: Vec::new(),
            self_contact,
            halved: 0,
            on_device: None,
            device_fault: None,
            model,
        };
        simulation.slides.keep_free(&simulation.masses);
        Ok(simulation)
    }

    /// Returns the model.
    pub fn model(&self) -> &Model {
        &self.model
    }

    /// Returns the seconds of a step, the stable step and the mass that was added for it.
    pub fn steps(&self) -> &Steps {
        &self.steps
    }

    /// Returns where the simulation is.
    pub fn state(&self) -> &State {
        &self.state
    }

    /// Goes on from a state.
    ///
    /// # Errors
    /// Fails if the state is not of this model, or a number is not finite.
    pub fn set_state(&mut self, state: State) -> Result<()> {
        let count = self.model.nodes.len();
        if state.displacements.len() != count || state.velocities.len() != count {
            return Err(Error::invalid(format!("{} nodes of a state do not fit {count}", state.displacements.len()))
                .advise("take a state of the same model"));
        }
        let is_finite = |rows: &[Row]| rows.iter().flatten().all(|number| number.is_finite());
        if !(is_finite(&state.displacements) && is_finite(&state.velocities) && state.seconds.is_finite()) {
            return Err(Error::invalid("a number of the state is not finite").advise("take an earlier state"));
        }
        self.state = state;
        Ok(())
    }

    /// Sets the activation over time of muscle `muscle`, 0 to 1.
    ///
    /// # Errors
    /// Fails if the muscle does not exist or a value is out of range.
    pub fn activate(&mut self, muscle: usize, activation: Curve<1>) -> Result<()> {
        if let Some((time, value)) = activation.keys().iter().find(|(_, value)| !(0.0..=1.0).contains(&value[0])) {
            return Err(
                Error::invalid(format!("an activation of {} at {time} s cannot be", value[0])).advise("use 0 to 1")
            );
        }
        match self.activations.get_mut(muscle) {
            Some(place) => *place = activation,
            None => return Err(Error::invalid(format!("muscle {muscle} does not exist"))),
        }
        Ok(())
    }

    /// Moves nodes along axes.
    ///
    /// # Errors
    /// Fails if a node does not exist.
    pub fn drive(&mut self, drive: Drive) -> Result<()> {
        if let Some(node) = drive.nodes.iter().find(|node| **node as usize >= self.masses.len()) {
            return Err(Error::invalid(format!("node {node} does not exist")).at("nodes that are moved"));
        }
        for node in &drive.nodes {
            let masses = &mut self.masses[*node as usize];
            (0..3).filter(|axis| drive.axes >> axis & 1 != 0).for_each(|axis| masses[axis] = 0.0);
        }
        self.drives.push(drive);
        self.forget_device();
        self.slides.keep_free(&self.masses);
        Ok(())
    }

    /// Sets the forces on all nodes from outside, in N; none if the list is empty.
    ///
    /// # Errors
    /// Fails if there are not as many forces as nodes, or one is not finite.
    pub fn load(&mut self, forces: &[[f32; 3]]) -> Result<()> {
        if !(forces.is_empty() || forces.len() == self.masses.len())
            || !forces.as_flattened().iter().all(|f| f.is_finite())
        {
            return Err(Error::invalid(format!(
                "{} forces for {} nodes, or one is not finite",
                forces.len(),
                self.masses.len()
            )));
        }
        self.forget_device();
        self.loads = forces.iter().map(|[x, y, z]| [*x, *y, *z, 0.0]).collect();
        Ok(())
    }

    /// Adds a body that nodes do not enter.
    pub fn add_collider(&mut self, collider: Collider) {
        self.forget_device();
        self.colliders.push(collider);
        self.witnesses.push(0);
    }

    /// Lets a device be sent again what changed.
    fn forget_device(&mut self) {
        if let Some(on) = &mut self.on_device {
            on.forget();
        }
    }

    /// Returns the bodies that nodes do not enter, in the order they were added.
    pub fn colliders_mut(&mut self) -> &mut [Collider] {
        &mut self.colliders
    }

    /// Presses on faces.
    ///
    /// # Errors
    /// Fails if a node of a face does not exist.
    pub fn press(&mut self, pressure: Pressure) -> Result<()> {
        pressure.check(self.masses.len())?;
        self.pressures.push(pressure);
        Ok(())
    }

    /// Returns how many stretches of up to 64 steps were gone by shorter steps, because an element turned inside out.
    pub fn halved(&self) -> u64 {
        self.halved
    }

    /// Takes `count` steps.
    ///
    /// A device that was given takes the steps if it can, and the processor takes over where it fails. The state is then that before where an element turns inside out.
    ///
    /// # Errors
    /// Fails when an element is inside out and the step cannot be halved again, when all nodes are inside of a
    /// collider, and if `progress` asks to stop; the state is then the one in which it is.
    pub fn advance(&mut self, context: &Context, count: u64, progress: &mut dyn Progress) -> Result<()> {
        if self.has_device() {
            match self.advance_on_device(count, progress) {
                Err(fault) if matches!(fault.kind, ErrorKind::Device | ErrorKind::Memory | ErrorKind::Internal) => {
                    // Nothing has moved.
                    self.use_device(None);
                    self.device_fault = Some(fault);
                }
                outcome => return outcome,
            }
        }
        let mut done = 0;
        while done < count {
            progress.step(done as f32 / count as f32, "steps")?;
            let chunk = (CHUNK - self.state.steps % CHUNK).min(count - done);
            if self.options.halvings > 0 {
                self.advance_halving(context, chunk)?;
            } else {
                (0..chunk).try_for_each(|_| self.step(context))?;
            }
            done += chunk;
        }
        Ok(())
    }

    /// Takes one step, whose length is never halved.
    ///
    /// # Errors
    /// Fails if an element is inside out, or all nodes are inside of a collider.
    pub fn step(&mut self, context: &Context) -> Result<()> {
        self.state.steps += 1;
        self.move_on(context, [self.steps.step; 2])
    }

    /// Takes `count` steps, or as long a time by steps of halves, quarters and so on if an element turns inside out.
    fn advance_halving(&mut self, context: &Context, count: u64) -> Result<()> {
        let begin = self.state.clone();
        for halvings in 0..=self.options.halvings {
            match self.advance_by(context, count, halvings) {
                Err(error) if error.kind == ErrorKind::Invalid && halvings < self.options.halvings => {
                    self.state = begin.clone();
                }
                outcome => {
                    self.halved += u64::from(halvings > 0);
                    return outcome;
                }
            }
        }
        Ok(())
    }

    /// Takes `count` steps, each cut into 2 to the power of `halvings`. Velocities are then again those half a whole step
    /// before the time that is reached.
    fn advance_by(&mut self, context: &Context, count: u64, halvings: u32) -> Result<()> {
        let (whole, seconds) = (self.steps.step, self.state.seconds);
        let short = whole / (1u32 << halvings) as f32;
        for part in 0..count << halvings {
            self.move_on(context, [short, if part == 0 { 0.5 * (whole + short) } else { short }])?;
        }
        self.state.steps += count;
        self.state.seconds = seconds + count as f64 * f64::from(whole);
        // An element that the last step turned inside out is found here, while there is a state to go back to.
        self.forces(context, self.state.seconds)?;
        if halvings > 0 {
            self.turn_back(0.5 * (whole - short));
        }
        Ok(())
    }

    /// Takes back what forces gave to the velocities of free nodes in so many seconds.
    fn turn_back(&mut self, seconds: f32) {
        for node in 0..self.masses.len() {
            let force = self.outer(node) - self.inner(node);
            let masses = &self.masses[node];
            for axis in (0..3).filter(|axis| masses[*axis] > 0.0) {
                let acceleration = force[axis] * masses[axis] + self.options.gravity[axis];
                self.state.velocities[node][axis] -= seconds * acceleration;
            }
        }
    }

    /// Goes on by a step of `dt` seconds, with velocities that change for `kick` seconds.
    fn move_on(&mut self, context: &Context, [dt, kick]: [f32; 2]) -> Result<()> {
        let begin = self.state.seconds;
        self.forces(context, begin)?;
        self.state.seconds = begin + f64::from(dt);
        self.integrate(context, [dt, kick], self.options.damping, self.options.gravity)?;
        self.bind(context, dt, true)
    }

    /// Computes what elements and pressures exert on nodes. Fails if an element is inside out.
    fn forces(&mut self, context: &Context, seconds: f64) -> Result<()> {
        let mut exerted = (std::mem::take(&mut self.rows), std::mem::take(&mut self.pushes));
        let outcome = self.exert(context, seconds, &mut exerted);
        (self.rows, self.pushes) = exerted;
        outcome
    }

    /// Writes what elements exert on nodes, by rows of blocks, and what pressures do. Fails if an element is inside out.
    fn exert(&self, context: &Context, seconds: f64, (rows, pushes): &mut (Vec<Row>, Vec<Row>)) -> Result<()> {
        if !self.pressures.is_empty() {
            pushes.clear();
            pushes.resize(self.masses.len(), [0.0; 4]);
            let bodies = (self.model.nodes.as_slice(), self.state.displacements.as_slice());
            self.pressures.iter().for_each(|pressure| pressure.add(context, seconds, bodies, pushes));
        }
        let mut activations: Vec<Row> =
            self.activations.iter().map(|curve| [curve.at(seconds)[0], 0.0, 0.0, 0.0]).collect();
        // Slots without fibres name muscle 0.
        activations.push([0.0; 4]);
        let elements = &self.elements;
        let blocks = &elements.blocks;
        let displacements = &self.state.displacements;
        let mut broken = vec![false; blocks.len()];
        let sums = Sums { starts: &blocks.rows, rows, broken: &mut broken };
        let scratch = context.scratch();
        context.for_each_part(sums, 1, |block, sums| {
            let mut local = scratch.list::<Row>();
            local.extend(blocks.nodes(block).iter().map(|node| displacements[*node as usize]));
            // Those of the next block come from memory meanwhile: a block's nodes lie in runs too short to be foreseen.
            if block + 1 < blocks.len() {
                blocks.nodes(block + 1).iter().for_each(|node| prefetch(displacements, *node as usize));
            }
            sums.rows.fill([0.0; 4]);
            sums.broken[0] = elements.forces(context.level(), block, &local, &activations, sums.rows);
            Ok(())
        })?;
        if broken.contains(&true) { Err(self.broken_element()) } else { Ok(()) }
    }

    /// Says which element turned inside out.
    fn broken_element(&self) -> Error {
        let volume = |element: usize| self.gradient(element).map(|f| f.determinant());
        let found = (0..self.model.elements.len()).find_map(|element| match volume(element) {
            Ok(volume) if volume > 0.0 && volume.is_finite() => None,
            Ok(volume) => Some((element, volume)),
            Err(_) => Some((element, f64::NAN)),
        });
        let (element, volume) = found.unwrap_or((0, f64::NAN));
        let place = |node: &u32| place(&self.model.nodes, &self.state, *node as usize);
        let corners = self.model.elements.get(element).map(|corners| corners.each_ref().map(place));
        let presses = |collider: &Collider| {
            let pose = collider.pose(self.state.seconds);
            let margin = |a: DVec3, b: DVec3| contact::MARGIN * a.distance(b) as f32;
            let touches = |corners: [DVec3; 8]| {
                corners.iter().any(|at| collider.touched(pose, *at, margin(corners[0], corners[6])).is_some())
            };
            corners.is_some_and(touches)
        };
        let advice = match self.colliders.iter().position(presses) {
            Some(index) => format!(
                "collider {index} presses on it: let the collider begin outside of the model, or move more slowly, or take a \
                 shorter step"
            ),
            None => "take a shorter step, slower motion, less activation or stiffer material".to_owned(),
        };
        Error::invalid(format!("the element has {volume:.3} times its volume after {:.6} s", self.state.seconds))
            .at(format!("element {element}"))
            .advise(advice)
    }

    /// Goes on by a step of `dt` seconds, with velocities that change for `kick` seconds.
    fn integrate(&mut self, context: &Context, [dt, kick]: [f32; 2], damping: f32, gravity: [f32; 3]) -> Result<()> {
        let half = 0.5 * damping * dt;
        let (kept, gained) = ((1.0 - half) / (1.0 + half), kick / (1.0 + half));
        let (blocks, rows, masses) = (&self.elements.blocks, &self.rows, &self.masses);
        let (loads, pushes) = (&self.loads, &self.pushes);
        let State { displacements, velocities, .. } = &mut self.state;
        let parts = (displacements.as_mut_slice(), velocities.as_mut_slice());
        context.for_each_part(parts, CHUNK_LEN, |first, (displacements, velocities)| {
            for (at, (u, v)) in displacements.iter_mut().zip(velocities).enumerate() {
                let node = first + at;
                let mass = &masses[node];
                let mut force = loads.get(node).copied().unwrap_or_default();
                if let Some(push) = pushes.get(node) {
                    (0..3).for_each(|axis| force[axis] += push[axis]);
                }
                for at in blocks.copies_range(node) {
                    if let Some(row) = blocks.copies.get(at + AHEAD) {
                        prefetch(rows, *row as usize);
                    }
                    let row = &rows[blocks.copies[at] as usize];
                    (0..3).for_each(|axis| force[axis] -= row[axis]);
                }
                for axis in 0..3 {
                    let is_free = if mass[axis] > 0.0 { 1.0 } else { 0.0 };
                    let acceleration = force[axis] * mass[axis] + gravity[axis] * is_free;
                    v[axis] = (v[axis] * kept + acceleration * gained) * is_free;
                    u[axis] += dt * v[axis];
                }
            }
            Ok(())
        })
    }

    /// Moves driven nodes to where they belong, and keeps others on their surfaces and out of colliders, which move or
    /// stand still.
    fn bind(&mut self, context: &Context, dt: f32, moves: bool) -> Result<()> {
        let time = self.state.seconds;
        for drive in &self.drives {
            let to = drive.displacement.at(time);
            for node in &drive.nodes {
                let node = *node as usize;
                for axis in (0..3).filter(|axis| drive.axes >> axis & 1 != 0) {
                    let from = self.state.displacements[node][axis];
                    self.state.velocities[node][axis] = (to[axis] - from) / dt;
                    self.state.displacements[node][axis] = to[axis];
                }
            }
        }
        if let Some(contact) = &mut self.self_contact {
            contact.keep(context, &self.model, &self.masses, &mut self.state);
        }
        for (index, (collider, witness)) in self.colliders.iter().zip(&mut self.witnesses).enumerate() {
            let (nodes, masses, moved) = (&self.model.nodes, &self.masses, moves.then_some(dt));
            let pushed = collider.push(context, nodes, masses, &mut self.state, moved, witness);
            pushed.map_err(|error| error.at(format!("collider {index}")))?;
        }
        self.slides.keep(context, &self.model.nodes, &mut self.state, dt);
        Ok(())
    }

    /// Goes to rest by steps whose damping follows the lowest frequency in the motion (Underwood 1983), with gravity, drives
    /// and activations as they are at the present time. All elements get the mass that allows the same step, which does
    /// not change where they rest.
    ///
    /// It ends when no node has an unbalanced force above `tolerance` times the largest force on a node, or after `most`
    /// steps. The time does not go on.
    ///
    /// # Errors
    /// Fails if an element is inside out, all nodes are inside of a collider, or `progress` asks to stop; the
    /// displacements are then those of the last step.
    pub fn relax(
        &mut self,
        context: &Context,
        tolerance: f32,
        most: u64,
        progress: &mut dyn Progress,
    ) -> Result<Relaxation> {
        let (time, steps) = (self.state.seconds, self.state.steps);
        let (own, dt) = (self.masses.clone(), 1.0);
        let scaled = self.steps.unit_masses(&self.model, self.options.safety.min(CAUTION));
        for (masses, scaled) in self.masses.iter_mut().zip(&scaled) {
            masses[..3].iter_mut().filter(|inverse| **inverse > 0.0).for_each(|inverse| *inverse = 1.0 / scaled);
        }
        // Weight stays that of the true masses.
        let loads = self.loads.clone();
        self.loads.resize(self.masses.len(), [0.0; 4]);
        for (load, own) in self.loads.iter_mut().zip(&own) {
            (0..3).for_each(|axis| load[axis] += own[3] * self.options.gravity[axis]);
        }
        let outcome = self.relax_scaled(context, (tolerance, most, dt), progress);
        self.masses = own;
        self.loads = loads;
        self.state.velocities.fill([0.0; 4]);
        (self.state.seconds, self.state.steps) = (time, steps);
        outcome
    }

    fn relax_scaled(
        &mut self,
        context: &Context,
        (tolerance, most, dt): (f32, u64, f32),
        progress: &mut dyn Progress,
    ) -> Result<Relaxation> {
        self.state.velocities.fill([0.0; 4]);
        self.bind(context, dt, false)?;
        self.state.velocities.fill([0.0; 4]);
        let mut before = None;
        let mut damping = 0.2;
        let mut relaxation = Relaxation { steps: 0, unbalanced: [f32::INFINITY, 0.0], is_at_rest: false };
        let margin =
            if self.colliders.is_empty() { 0.0 } else { contact::Surface::new(&self.model, &self.state).margin() };
        for step in 0..most {
            relaxation.steps = step;
            self.forces(context, self.state.seconds)?;
            if step % WINDOW == 0 {
                progress.step(step as f32 / most as f32, "relaxation")?;
                relaxation.unbalanced = self.unbalanced(context, margin);
                relaxation.is_at_rest = relaxation.unbalanced[0] <= tolerance * relaxation.unbalanced[1];
                if relaxation.is_at_rest && step > 0 {
                    break;
                }
                if let Some(frequency) = self.frequency(context, &mut before) {
                    damping = 2.0 * frequency;
                }
            }
            // From a stand, velocities half a step later follow from half a step.
            let kick = if step > 0 { dt } else { 0.5 * dt };
            self.integrate(context, [dt, kick], damping, [0.0; 3])?;
            self.bind(context, dt, false)?;
        }
        Ok(relaxation)
    }

    /// Returns the frequency of the motion since `before` by Rayleigh's quotient for steps of 1 s, and puts the present
    /// displacements and forces there; `None` the first time. Over many steps fast modes, which rounding excites for ever,
    /// cancel out. Sums have a fixed order.
    fn frequency(&self, context: &Context, before: &mut Option<[Vec<Row>; 2]>) -> Option<f32> {
        let count = self.masses.len();
        let forces = context.map(count, |node| self.inner(node).extend(0.0).to_array());
        let last = before.replace([self.state.displacements.clone(), forces])?;
        let now = before.as_ref()?;
        let parts = context.map(count.div_ceil(CHUNK_LEN), |part| {
            let (mut work, mut motion) = (0f64, 0f64);
            for node in part * CHUNK_LEN..((part + 1) * CHUNK_LEN).min(count) {
                for axis in (0..3).filter(|axis| self.masses[node][*axis] > 0.0) {
                    let [moved, force] = [0, 1].map(|list| f64::from(now[list][node][axis] - last[list][node][axis]));
                    work += moved * force;
                    motion += moved * moved / f64::from(self.masses[node][axis]);
                }
            }
            [work, motion]
        });
        let [work, motion] = parts.into_iter().fold([0.0; 2], |sum, part| [sum[0] + part[0], sum[1] + part[1]]);
        let square = if motion > 0.0 { work / motion } else { 0.0 };
        Some(square.clamp(1e-9, 0.25).sqrt() as f32)
    }

    /// Returns the largest unbalanced force on a node that may move, and the largest force of elements or loads on a node. What
    /// a collider within `margin` holds is balanced: a force into it, and along it what its friction allows.
    fn unbalanced(&self, context: &Context, margin: f32) -> [f32; 2] {
        let poses: Vec<_> = self.colliders.iter().map(|collider| collider.pose(self.state.seconds)).collect();
        let forces = context.map(self.masses.len(), |node| {
            let inner = self.inner(node);
            let sum = self.outer(node) - inner;
            let free = Vec3::from_slice(&self.masses[node]).map(|inverse| if inverse > 0.0 { 1.0 } else { 0.0 });
            let mut left = self.slides.free_part(node, &self.model.nodes, &self.state, sum * free);
            for (collider, pose) in self.colliders.iter().zip(&poses) {
                let Some(normal) = collider.touched(*pose, place(&self.model.nodes, &self.state, node), margin) else {
                    continue;
                };
                let pressing = -left.dot(normal);
                if pressing > 0.0 {
                    let along = left + pressing * normal;
                    let (_, friction) = collider.shape();
                    left = along * (1.0 - friction * pressing / along.length().max(f32::MIN_POSITIVE)).max(0.0);
                }
            }
            [left.length(), inner.length()]
        });
        forces.into_iter().fold([0.0; 2], |most, force| [most[0].max(force[0]), most[1].max(force[1])])
    }

    /// Returns the force of loads and pressures on a node, in N.
    fn outer(&self, node: usize) -> Vec3 {
        let of = |rows: &[Row]| rows.get(node).map_or(Vec3::ZERO, |row| Vec3::from_slice(row));
        of(&self.loads) + of(&self.pushes)
    }

    /// Returns the force with which elements resist the displacement of a node, in N.
    fn inner(&self, node: usize) -> Vec3 {
        let rows = self.elements.blocks.copies(node).iter().map(|row| Vec3::from_slice(&self.rows[*row as usize]));
        rows.sum()
    }

    /// Returns the forces with which nodes resist their displacements in the present state, added up, in N.
    ///
    /// # Errors
    /// Fails if an element is inside out.
    pub fn reaction(&mut self, context: &Context, nodes: &[u32]) -> Result<[f64; 3]> {
        self.forces(context, self.state.seconds)?;
        let known = nodes.iter().filter(|node| (**node as usize) < self.masses.len());
        let sum: DVec3 = known.map(|node| self.inner(*node as usize).as_dvec3()).sum();
        Ok(sum.to_array())
    }

    /// Returns the force of elements on every node in the present state, in N.
    ///
    /// # Errors
    /// Fails if an element is inside out.
    pub fn inner_forces(&mut self, context: &Context) -> Result<Vec<[f32; 3]>> {
        self.forces(context, self.state.seconds)?;
        Ok((0..self.masses.len()).map(|node| self.inner(node).to_array()).collect())
    }

    /// Returns the pressures in Pa with which colliders press on the nodes in the present state, 0 where none touches: the
    /// force of contact along the collider's normal, by the node's share of the outer faces that look at the collider. Where
    /// several touch a node, the largest counts.
    ///
    /// The force is the one that balances elements, loads, pressures, gravity and damping along the normal: that of a
    /// node which the collider holds at rest or in even motion. It depends on the state alone. Contact of the model
    /// with itself is left out.
    ///
    /// # Errors
    /// Fails if an element is inside out.
    pub fn contact_pressures(&self, context: &Context) -> Result<Vec<f32>> {
        if self.colliders.is_empty() {
            return Ok(vec![0.0; self.masses.len()]);
        }
        let mut exerted = (vec![[0.0; 4]; self.rows.len()], Vec::new());
        self.exert(context, self.state.seconds, &mut exerted)?;
        let (rows, pushes) = exerted;
        let gravity = Vec3::from(self.options.gravity);
        let balance = |node: usize| {
            let of = |rows: &[Row]| rows.get(node).map_or(Vec3::ZERO, |row| Vec3::from_slice(row));
            let copies = self.elements.blocks.copies(node).iter();
            let inner: Vec3 = copies.map(|row| Vec3::from_slice(&rows[*row as usize])).sum();
            let velocity = Vec3::from_slice(&self.state.velocities[node]);
            let mass = self.masses[node][3];
            of(&self.loads) + of(&pushes) - inner + mass * (gravity - self.options.damping * velocity)
        };
        let surface = contact::Surface::new(&self.model, &self.state);
        let mut pressures = vec![0f32; self.masses.len()];
        for collider in &self.colliders {
            let found = surface.pressures(context, collider, (&self.model.nodes, &self.state, &self.masses), &balance);
            pressures.iter_mut().zip(found).for_each(|(most, other)| *most = most.max(other));
        }
        Ok(pressures)
    }

    /// Returns where the nodes are, in metres.
    pub fn positions(&self) -> Vec<[f32; 3]> {
        let moved = |(node, u): (&[f32; 3], &Row)| std::array::from_fn(|axis| node[axis] + u[axis]);
        self.model.nodes.iter().zip(&self.state.displacements).map(moved).collect()
    }

    /// Returns the energies in the present state. Velocities are those at the time of the displacements.
    ///
    /// # Errors
    /// Fails if an element is inside out.
    pub fn energies(&mut self, context: &Context) -> Result<Energies> {
        self.forces(context, self.state.seconds)?;
        let mut energies = Energies::default();
        let gravity = Vec3::from(self.options.gravity);
        for (node, masses) in self.masses.iter().enumerate() {
            let (u, v) = (&self.state.displacements[node], &self.state.velocities[node]);
            let force = self.outer(node) - self.inner(node);
            let free = Vec3::from_slice(masses);
            let acceleration = force * free + gravity * free.map(|inverse| if inverse > 0.0 { 1.0 } else { 0.0 });
            let v = Vec3::from_slice(v) + 0.5 * self.steps.step * acceleration;
            energies.kinetic += 0.5 * f64::from(masses[3]) * f64::from(v.length_squared());
            energies.potential -= f64::from(masses[3]) * f64::from(gravity.dot(Vec3::from_slice(u)));
        }
        for element in 0..self.model.elements.len() {
            let shape = self.model.hexahedron(element)?;
            let [shear, bulk, _] = self.model.moduli(element).map(f64::from);
            let fibres: Vec<_> = self.families(element);
            let (_, density) = crate::stress::cauchy(self.gradient(element)?, shear, bulk, &fibres);
            energies.elastic += density * shape.volume;
            let young = 9.0 * bulk * shear / (3.0 * bulk + shear);
            let stiffness = f64::from(self.options.hourglass) * young * shape.volume * shape.squares * 8.0 / 9.0;
            let corners = self.model.elements[element].map(|node| self.state.displacements[node as usize]);
            for pattern in shape.patterns {
                let mode: DVec3 =
                    pattern.iter().zip(&corners).map(|(sign, u)| Vec3::from_slice(u).as_dvec3() * *sign).sum();
                energies.elastic += 0.5 * stiffness * mode.length_squared() / 64.0;
            }
        }
        Ok(energies)
    }

    /// Returns the stress and the stretch of every element in the present state.
    ///
    /// # Errors
    /// Fails if an element of the model at rest is inside out.
    pub fn element_states(&self, context: &Context) -> Result<Vec<ElementState>> {
        context.map(self.model.elements.len(), |element| self.element_state(element)).into_iter().collect()
    }

    fn element_state(&self, element: usize) -> Result<ElementState> {
        let [shear, bulk, _] = self.model.moduli(element).map(f64::from);
        let (f, fibres) = (self.gradient(element)?, self.families(element));
        let (stress, _) = crate::stress::cauchy(f, shear, bulk, &fibres);
        let mean = (stress.x_axis.x + stress.y_axis.y + stress.z_axis.z) / 3.0;
        let deviator = stress - DMat3::from_diagonal(DVec3::splat(mean));
        let strain = 0.5 * (f.transpose() * f - DMat3::IDENTITY);
        let six = |of: DMat3| {
            [of.x_axis.x, of.y_axis.y, of.z_axis.z, of.y_axis.z, of.z_axis.x, of.x_axis.y].map(|part| part as f32)
        };
        let squares: f64 = deviator.to_cols_array().iter().map(|part| part * part).sum();
        Ok(ElementState {
            stress: six(stress),
            strain: six(strain),
            von_mises: (1.5 * squares).sqrt() as f32,
            principal: crate::stress::principal(stress).map(|part| part as f32),
            principal_strain: crate::stress::principal(strain).map(|part| part as f32),
            volume: f.determinant() as f32,
            fibre_stretch: fibres.first().map_or(1.0, |fibre| (f * fibre.direction).length() as f32),
        })
    }

    fn families(&self, element: usize) -> Vec<crate::stress::Family> {
        let family = |fibre: &crate::model::Fibre| {
            let muscle = &self.model.muscles[fibre.muscle as usize];
            let activation = self.activations[fibre.muscle as usize].at(self.state.seconds)[0];
            crate::stress::Family {
                direction: Vec3::from(fibre.direction).as_dvec3(),
                stiffness: f64::from(fibre.share * muscle.stiffness),
                active: f64::from(fibre.share * muscle.strength * activation),
            }
        };
        self.model.fibres.get(element).iter().map(family).collect()
    }

    /// Returns the mean deformation gradient of an element.
    fn gradient(&self, element: usize) -> Result<DMat3> {
        let shape = self.model.hexahedron(element)?;
        let nodes = self.model.elements[element].iter().zip(shape.gradients);
        let parts = nodes.map(|(node, gradient)| {
            let u = Vec3::from_slice(&self.state.displacements[*node as usize]).as_dvec3();
            crate::stress::outer(u, gradient)
        });
        Ok(parts.fold(DMat3::IDENTITY, |sum, part| sum + part))
    }
}
