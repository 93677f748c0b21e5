//! Draws of crowds as arrays of hosts; see `include/relievo/crowd.h`.

use relievo_core::{Context, Result};
use relievo_crowd::{Draw, DrawList, Instance, dual_rows};

use super::fill;
use crate::border::array::{Output, Plain};

#[repr(C)]
#[derive(Clone, Copy, Debug, Default)]
pub struct RlvCrowdDraw {
    pub index_count: u32,
    pub instance_count: u32,
    pub first_index: u32,
    pub base_vertex: i32,
    pub first_instance: u32,
}

descriptor! {
    pub struct RlvCrowdInstance {
        agent: u32,
        first_matrix: u32,
        transform: [f32; 12],
    }
}

descriptor! {
    pub struct RlvCrowdBuffers before dual_rows {
        struct_size: u32,
        reserved: u32,
        draws: *mut RlvCrowdDraw,
        draw_capacity: usize,
        draw_stride: usize,
        clusters: *mut u32,
        instances: *mut RlvCrowdInstance,
        instance_capacity: usize,
        instance_stride: usize,
        matrices: *mut f32,
        matrix_capacity: usize,
        matrix_stride: usize,
        weights: *mut f32,
        weight_capacity: usize,
        first_weights: *mut u32,
        blends: *mut f32,
        dual_rows: *mut f32,
    }
}

impl Default for RlvCrowdInstance {
    fn default() -> Self {
        Self { agent: 0, first_matrix: 0, transform: [0.0; 12] }
    }
}

// SAFETY: integers of four bytes without padding.
unsafe impl Plain for RlvCrowdDraw {}
// SAFETY: integers and floats of four bytes without padding.
unsafe impl Plain for RlvCrowdInstance {}

// SAFETY: floats without padding.
unsafe impl Plain for [[f32; 4]; 5] {}

/// Writes a list of draws to the arrays of C.
///
/// # Safety
/// There is room for the capacities in each array that is not NULL.
pub(crate) unsafe fn write_list(context: &Context, given: &RlvCrowdBuffers, list: &DrawList) -> Result<()> {
    // SAFETY: the caller promises room for the capacities in each array that is not NULL.
    let (draws, clusters, instances, matrices, weights, first_weights, blends, duals) = unsafe {
        (
            Output::optional("draws", given.draws, given.draw_capacity, given.draw_stride)?,
            Output::<[u32; 2]>::optional("clusters", given.clusters.cast(), given.draw_capacity, 0)?,
            Output::optional("instances", given.instances, given.instance_capacity, given.instance_stride)?,
            Output::<[f32; 12]>::optional(
                "matrices",
                given.matrices.cast(),
                given.matrix_capacity,
                given.matrix_stride,
            )?,
            Output::optional("weights", given.weights, given.weight_capacity, 0)?,
            Output::optional("first_weights", given.first_weights, given.instance_capacity, 0)?,
            Output::optional("blends", given.blends, given.draw_capacity, 0)?,
            Output::<[[f32; 4]; 5]>::optional("dual_rows", given.dual_rows.cast(), given.matrix_capacity, 0)?,
        )
    };
    // Nothing is written unless there is room for all.
    draws.map(|out| out.holds("draws", list.draws.len())).transpose()?;
    clusters.map(|out| out.holds("clusters", list.clusters.len())).transpose()?;
    instances.map(|out| out.holds("instances", list.instances.len())).transpose()?;
    matrices.map(|out| out.holds("matrices", list.matrices.len())).transpose()?;
    weights.map(|out| out.holds("weights", list.weights.len())).transpose()?;
    first_weights.map(|out| out.holds("first_weights", list.first_weights.len())).transpose()?;
    blends.map(|out| out.holds("blends", list.blends.len())).transpose()?;
    duals.map(|out| out.holds("dual_rows", list.matrices.len())).transpose()?;
    fill(draws, "draws", Some(list.draws.iter().map(draw_of)))?;
    fill(clusters, "clusters", Some(list.clusters.iter().copied()))?;
    fill(instances, "instances", Some(list.instances.iter().map(instance_of)))?;
    fill(matrices, "matrices", Some(list.matrices.iter().map(|rows| flat(*rows))))?;
    fill(weights, "weights", Some(list.weights.iter().copied()))?;
    fill(first_weights, "first_weights", Some(list.first_weights.iter().copied()))?;
    fill(blends, "blends", Some(list.blends.iter().copied()))?;
    if duals.is_some() {
        let rows = context.map(list.matrices.len(), |at| dual_rows(&list.matrices[at]));
        fill(duals, "dual_rows", Some(rows.into_iter()))?;
    }
    Ok(())
}

fn draw_of(draw: &Draw) -> RlvCrowdDraw {
    let Draw { index_count, instance_count, first_index, base_vertex, first_instance } = *draw;
    RlvCrowdDraw { index_count, instance_count, first_index, base_vertex, first_instance }
}

fn instance_of(instance: &Instance) -> RlvCrowdInstance {
    let Instance { agent, first_matrix, transform } = *instance;
    RlvCrowdInstance { agent, first_matrix, transform: flat(transform) }
}

/// Returns the numbers of a map, row after row.
pub(super) fn flat(rows: [[f32; 4]; 3]) -> [f32; 12] {
    std::array::from_fn(|at| rows[at / 4][at % 4])
}
