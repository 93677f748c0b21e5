//! Forces of elements by vectors: a lane for each element.
//!
//! Total Lagrangian (Miller et al. 2007): gradients are those of the shape at rest and never change. Elements that are
//! equal boxes have a gradient of two signs and constant hourglass patterns, so that both come from one Walsh–Hadamard
//! transform of the displacements of the corners, and forces from its inverse.

use relievo_core::lanes::Lanes;
use relievo_core::{Result, dispatch_simd};

use crate::block::{BLOCK, Blocks, GROUP, Row, place};
use crate::hexahedron::Hexahedron;
use crate::material::young;
use crate::model::Model;
use crate::stress::{Tensor, fibre, neo_hookean};

/// All that forces of elements follow from, in the order of the blocks.
#[derive(Clone, Debug)]
pub(crate) struct Elements {
    pub blocks: Blocks,
    /// Shear modulus, bulk modulus and hourglass stiffness of each element, times its volume: groups of three lists.
    pub moduli: Vec<f32>,
    pub shape: Form,
    /// Fibres: lists of `BLOCK` slots, of which block b has those from `layers[b]` to `layers[b + 1]`.
    pub fibres: Vec<FibreLayer>,
    /// Where the layers of each block begin, and at the end their number.
    pub layers: Vec<u32>,
}

#[derive(Clone, Debug)]
pub(crate) enum Form {
    /// One over four times the size along each axis.
    Box([f32; 3]),
    /// Gradients and then hourglass patterns over 8: groups of 24 and 32 lists.
    Any { gradients: Vec<f32>, patterns: Vec<f32> },
}

/// At most one fibre of each element of a block; an element without one has no stiffness there.
#[derive(Clone, Debug)]
pub(crate) struct FibreLayer {
    /// Directions: groups of three lists.
    pub directions: Vec<f32>,
    /// Passive stiffness and strength times volume: groups of two lists.
    pub stresses: Vec<f32>,
    pub muscles: Vec<u32>,
}

impl Elements {
    /// Prepares the elements of a model. `hourglass` scales the resistance to hourglass modes: 1 gives a beam of boxes
    /// its bending stiffness. Fails if an element is inside out.
    pub fn new(model: &Model, hourglass: f32) -> Result<Self> {
        let blocks = Blocks::new(model)?;
        let slots = blocks.len() * BLOCK;
        let mut moduli = vec![0.0; slots * 3];
        let is_box = model.cell.is_some();
        let list = |width: usize| vec![0.0; if is_box { 0 } else { slots * width }];
        let (mut gradients, mut patterns) = (list(24), list(32));
        let same = if is_box { Some(model.hexahedron(0)?) } else { None };
        for (slot, element) in blocks.order.iter().enumerate() {
            let element = *element as usize;
            let shape = match same {
                Some(shape) => shape,
                None => model.hexahedron(element)?,
            };
            let [shear, bulk, _] = model.moduli(element);
            let volume = shape.volume as f32;
            moduli[place(slot, 3, 0)] = shear * volume;
            moduli[place(slot, 3, 1)] = bulk * volume;
            moduli[place(slot, 3, 2)] = hourglass * stiffness(&shape, shear, bulk);
            if !is_box {
                for corner in 0..8 {
                    for axis in 0..3 {
                        gradients[place(slot, 24, 3 * corner + axis)] = shape.gradients[corner][axis] as f32;
                    }
                    for (mode, pattern) in shape.patterns.iter().enumerate() {
                        patterns[place(slot, 32, 4 * corner + mode)] = (0.125 * pattern[corner]) as f32;
                    }
                }
            }
        }
        let shape = match model.cell {
            Some(cell) => Form::Box(cell.map(|size| 0.25 / size)),
            None => Form::Any { gradients, patterns },
        };
        let (fibres, layers) = fibre_layers(model, &blocks, same.as_ref())?;
        Ok(Self { blocks, moduli, shape, fibres, layers })
    }

    /// Adds the forces of the elements of a block to its rows, which are 0, given the displacements of its rows and the
    /// activations of muscles. Returns whether an element is inside out or a number is not finite.
    pub fn forces(
        &self,
        level: relievo_core::simd::Level,
        block: usize,
        displacements: &[Row],
        activations: &[Row],
        rows: &mut [Row],
    ) -> bool {
        block_forces(level, self, block, displacements, activations, rows)
    }
}

/// Returns the stiffness that an hourglass mode of amplitude 1 works against: the energy of pure bending of a box, by
/// Young's modulus, for the mean size of the element.
fn stiffness(shape: &Hexahedron, shear: f32, bulk: f32) -> f32 {
    young(shear, bulk) * (shape.volume * shape.squares * 8.0 / 9.0) as f32
}

/// Puts the fibres of elements side by side, in as many layers as an element of the block has fibres at most.
fn fibre_layers(model: &Model, blocks: &Blocks, same: Option<&Hexahedron>) -> Result<(Vec<FibreLayer>, Vec<u32>)> {
    let (mut fibres, mut layers): (Vec<FibreLayer>, _) = (Vec::new(), vec![0u32]);
    for elements in blocks.order.chunks(BLOCK) {
        let first = fibres.len();
        for (slot, element) in elements.iter().enumerate() {
            let element = *element as usize;
            let list = model.fibres.get(element);
            if list.is_empty() {
                continue;
            }
            let volume = match same {
                Some(shape) => shape.volume,
                None => model.hexahedron(element)?.volume,
            };
            for (layer, fibre) in list.iter().enumerate() {
                if first + layer == fibres.len() {
                    let list = |width: usize| vec![0.0; BLOCK * width];
                    fibres.push(FibreLayer { directions: list(3), stresses: list(2), muscles: vec![0; BLOCK] });
                }
                let into = &mut fibres[first + layer];
                for axis in 0..3 {
                    into.directions[place(slot, 3, axis)] = fibre.direction[axis];
                }
                let muscle = &model.muscles[fibre.muscle as usize];
                let share = fibre.share * volume as f32;
                into.stresses[place(slot, 2, 0)] = share * muscle.stiffness;
                into.stresses[place(slot, 2, 1)] = share * muscle.strength;
                into.muscles[slot] = fibre.muscle;
            }
        }
        layers.push(fibres.len() as u32);
    }
    Ok((fibres, layers))
}

/// The corners in the order of binary numbers: x in bit 0, y in bit 1, z in bit 2.
const BINARY: [usize; 8] = [0, 1, 3, 2, 4, 5, 7, 6];
/// The numbers after the transform that are hourglass modes: xy, yz, zx, xyz.
const HOURGLASS: [usize; 4] = [3, 6, 5, 7];

/// The Walsh–Hadamard transform of eight numbers; twice gives them eightfold.
#[inline(always)]
fn transform<A: Lanes>(v: A, values: &mut [A::F; 8]) {
    let mut stride = 1;
    while stride < 8 {
        for low in 0..8 {
            if low & stride == 0 {
                let (a, b) = (values[low], values[low + stride]);
                values[low] = v.add(a, b);
                values[low + stride] = v.sub(b, a);
            }
        }
        stride *= 2;
    }
}

/// The inverse up to scale of [`transform`]: its signs are those of the patterns at the corners.
#[inline(always)]
fn transform_back<A: Lanes>(v: A, values: &mut [A::F; 8]) {
    let mut stride = 1;
    while stride < 8 {
        for low in 0..8 {
            if low & stride == 0 {
                let (a, b) = (values[low], values[low + stride]);
                values[low] = v.sub(a, b);
                values[low + stride] = v.add(a, b);
            }
        }
        stride *= 2;
    }
}

#[inline(always)]
fn block_forces_body<A: Lanes>(
    v: A,
    elements: &Elements,
    block: usize,
    displacements: &[Row],
    activations: &[Row],
    rows: &mut [Row],
) -> bool {
    let count = elements.blocks.elements(block);
    let zero = v.splat(0.0);
    let mut broken = zero;
    let corners = &elements.blocks.corners[block * BLOCK * 8..];
    let layers = &elements.fibres[elements.layers[block] as usize..elements.layers[block + 1] as usize];
    let mut out = [[0f32; GROUP]; 24];
    let mut rows_of = [0u32; 8 * GROUP];
    for group in 0..count.div_ceil(GROUP) {
        for (wide, row) in rows_of.iter_mut().zip(&corners[group * 8 * GROUP..]) {
            *wide = u32::from(*row);
        }
        let all = block * (BLOCK / GROUP) + group;
        for lane in (0..GROUP).step_by(A::WIDTH) {
            let at = |width: usize, which: usize| (all * width + which) * GROUP + lane;
            let local = |width: usize, which: usize| (group * width + which) * GROUP + lane;
            // Displacements by axis and corner.
            let mut u = [[zero; 8]; 3];
            for corner in 0..8 {
                let row = v.gather_rows(displacements, &rows_of[corner * GROUP + lane..]);
                for axis in 0..3 {
                    u[axis][corner] = row[axis];
                }
            }
            // Gradient of the displacement by axis, and hourglass modes by axis.
            let mut h: Tensor<A> = [[zero; 3]; 3];
            let mut q = [[zero; 4]; 3];
            match &elements.shape {
                Form::Box(scale) => {
                    for axis in 0..3 {
                        let mut modes = [zero; 8];
                        for number in 0..8 {
                            modes[number] = u[axis][BINARY[number]];
                        }
                        transform(v, &mut modes);
                        for by in 0..3 {
                            h[axis][by] = v.mul(modes[1 << by], v.splat(scale[by]));
                        }
                        for mode in 0..4 {
                            q[axis][mode] = v.mul(modes[HOURGLASS[mode]], v.splat(0.125));
                        }
                    }
                }
                Form::Any { gradients, patterns } => {
                    for corner in 0..8 {
                        for by in 0..3 {
                            let gradient = v.load(&gradients[at(24, 3 * corner + by)..]);
                            for axis in 0..3 {
                                h[axis][by] = v.fused(u[axis][corner], gradient, h[axis][by]);
                            }
                        }
                        for mode in 0..4 {
                            let pattern = v.load(&patterns[at(32, 4 * corner + mode)..]);
                            for axis in 0..3 {
                                q[axis][mode] = v.fused(u[axis][corner], pattern, q[axis][mode]);
                            }
                        }
                    }
                }
            }
            let shear = v.load(&elements.moduli[at(3, 0)..]);
            let bulk = v.load(&elements.moduli[at(3, 1)..]);
            let hourglass = v.load(&elements.moduli[at(3, 2)..]);
            let (mut p, volume) = neo_hookean(v, &h, shear, bulk);
            let is_whole = v.both(v.lt(zero, volume), v.lt(volume, v.splat(f32::MAX)));
            broken = v.select(is_whole, broken, v.splat(1.0));
            for layer in layers {
                let mut direction = [zero; 3];
                for axis in 0..3 {
                    direction[axis] = v.load(&layer.directions[local(3, axis)..]);
                }
                let stiffness = v.load(&layer.stresses[local(2, 0)..]);
                let strength = v.load(&layer.stresses[local(2, 1)..]);
                let muscles = &layer.muscles[group * GROUP + lane..];
                let active = v.mul(strength, v.gather_rows(activations, muscles)[0]);
                fibre(v, &h, &direction, stiffness, active, &mut p);
            }
            match &elements.shape {
                Form::Box(scale) => {
                    for axis in 0..3 {
                        let mut modes = [zero; 8];
                        for by in 0..3 {
                            modes[1 << by] = v.mul(p[axis][by], v.splat(scale[by]));
                        }
                        for mode in 0..4 {
                            modes[HOURGLASS[mode]] = v.mul(v.mul(hourglass, q[axis][mode]), v.splat(0.125));
                        }
                        transform_back(v, &mut modes);
                        for number in 0..8 {
                            v.store(modes[number], &mut out[3 * BINARY[number] + axis][lane..]);
                        }
                    }
                }
                Form::Any { gradients, patterns } => {
                    for axis in 0..3 {
                        for mode in 0..4 {
                            q[axis][mode] = v.mul(hourglass, q[axis][mode]);
                        }
                    }
                    for corner in 0..8 {
                        let mut force = [zero; 3];
                        for by in 0..3 {
                            let gradient = v.load(&gradients[at(24, 3 * corner + by)..]);
                            for axis in 0..3 {
                                force[axis] = v.fused(p[axis][by], gradient, force[axis]);
                            }
                        }
                        for mode in 0..4 {
                            let pattern = v.load(&patterns[at(32, 4 * corner + mode)..]);
                            for axis in 0..3 {
                                force[axis] = v.fused(q[axis][mode], pattern, force[axis]);
                            }
                        }
                        for axis in 0..3 {
                            v.store(force[axis], &mut out[3 * corner + axis][lane..]);
                        }
                    }
                }
            }
        }
        // Element after element, so that sums do not depend on the lanes.
        for lane in 0..GROUP.min(count - group * GROUP) {
            for corner in 0..8 {
                let row = &mut rows[rows_of[corner * GROUP + lane] as usize];
                row[0] += out[3 * corner][lane];
                row[1] += out[3 * corner + 1][lane];
                row[2] += out[3 * corner + 2][lane];
            }
        }
    }
    v.mask(v.lt(zero, broken)) != 0
}

dispatch_simd! {
    fn block_forces = block_forces_body(
        elements: &Elements,
        block: usize,
        displacements: &[Row],
        activations: &[Row],
        rows: &mut [Row],
    ) -> bool
}
