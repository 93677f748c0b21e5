//! Crowds of articulated models; see `include/relievo/crowd.h`.

mod build;
mod draws;
mod impostors;
mod model;
mod view;

use std::sync::{Arc, RwLock};

use glam::DAffine3;
use relievo_core::{Error, Result};
use relievo_crowd::{Agent, Crowd, Culled, DrawList, Frame, Occlusion};

pub use self::build::*;
pub use self::draws::*;
pub use self::impostors::*;
pub use self::model::*;
pub use self::view::*;

use crate::border::array::{Input, Output, Plain, present, put, put_optional};
use crate::border::descriptor::{check_optional, read_descriptor, write_optional};
use crate::border::registry::{self, handle, try_read, try_write};
use crate::runtime::context::{ContextObject, RlvContext};

handle!(RlvCrowd, 33, CrowdObject);

descriptor! {
    pub struct RlvCrowdAgent {
        model: u32,
        clip: u32,
        phase: f64,
        transform: [f64; 12],
    }
}

descriptor! {
    pub struct RlvCrowdFrame {
        struct_size: u32,
        agent_count: u32,
        draw_count: u32,
        matrix_count: u32,
        changed: u32,
        hidden: u32,
        clusters: u64,
        triangles: u64,
        hidden_triangles: u64,
        occluder_triangles: u64,
        weight_count: u32,
        impostor_count: u32,
        picture_count: u32,
        hidden_clusters: u32,
    }
}

impl Default for RlvCrowdAgent {
    fn default() -> Self {
        Self { model: 0, clip: 0, phase: 0.0, transform: [0.0; 12] }
    }
}

// SAFETY: two integers, then doubles, without padding.
unsafe impl Plain for RlvCrowdAgent {}

/// A crowd with what its last view draws.
pub struct CrowdObject {
    context: Arc<ContextObject>,
    state: RwLock<State>,
}

struct State {
    crowd: Crowd,
    frame: Frame,
    occlusion: Occlusion,
    list: DrawList,
    shown: ShownImpostors,
    is_cut: bool,
}

impl CrowdObject {
    /// Makes a crowd of which there was no cut.
    pub fn new(context: Arc<ContextObject>, crowd: Crowd) -> Self {
        let state = State {
            crowd,
            frame: Frame::default(),
            occlusion: Occlusion::default(),
            list: DrawList::default(),
            shown: ShownImpostors::default(),
            is_cut: false,
        };
        Self { context, state: RwLock::new(state) }
    }

    pub fn context(&self) -> &Arc<ContextObject> {
        &self.context
    }

    /// Works with the models and agents.
    ///
    /// # Errors
    /// Fails with `Busy` while they change, with `Internal` if an earlier panic left them broken, and as `work` does.
    pub fn with_crowd<T>(&self, work: impl FnOnce(&Crowd) -> Result<T>) -> Result<T> {
        work(&try_read(&self.state, "crowd")?.crowd)
    }
}

impl State {
    /// Fails where what the last cut found is not that of the agents.
    fn check_cut(&self) -> Result<()> {
        if self.is_cut {
            return Ok(());
        }
        Err(Error::invalid("the agents changed since the last cut, or it failed, or there was none")
            .advise("call rlv_crowd_cut first"))
    }

    fn shown(&self) -> Result<&ShownImpostors> {
        self.check_cut()?;
        Ok(&self.shown)
    }
}

/// Returns the agent that C describes.
fn agent_of(given: &RlvCrowdAgent) -> Agent {
    let RlvCrowdAgent { model, clip, phase, transform } = *given;
    Agent { model, clip, phase, transform: DAffine3::from_cols_array(&transform) }
}

/// Fills an array of elements with so many numbers each that is wanted, or fails if the model lacks them.
fn fill<T: Plain>(out: Option<Output<T>>, name: &str, values: Option<impl ExactSizeIterator<Item = T>>) -> Result<()> {
    let Some(out) = out else { return Ok(()) };
    let Some(values) = values else {
        return Err(Error::invalid("the model has none").at(name).advise("pass NULL"));
    };
    out.holds(name, values.len())?.fill(values);
    Ok(())
}

entry! {
    fn rlv_crowd_create(context: RlvContext, models: *const RlvCrowdModel, count: usize, out: *mut RlvCrowd) {
        present("out", out)?;
        let context = registry::get(context)?;
        // SAFETY: the caller promises `count` handles.
        let handles = unsafe { Input::new("models", models, count, 0) }?;
        if handles.is_empty() {
            return Err(Error::invalid("there is no model").at("models").advise("give one at least"));
        }
        let models = handles.iter().map(|handle| registry::get(handle).map(|object| Arc::clone(&object.model)));
        let models = models.collect::<Result<Vec<_>>>()?;
        for (at, model) in models.iter().enumerate() {
            model.check_triangles().map_err(|error| error.at(format!("model {at}")))?;
        }
        let crowd = Crowd::new(models);
        let handle = registry::insert(CrowdObject::new(context, crowd))?;
        // SAFETY: checked above.
        unsafe { put(out, handle) };
        Ok(())
    }

    fn rlv_crowd_retain(crowd: RlvCrowd) {
        registry::retain(crowd)
    }

    fn rlv_crowd_release(crowd: RlvCrowd) {
        registry::release(crowd)
    }

    fn rlv_crowd_add(crowd: RlvCrowd, agents: *const RlvCrowdAgent, count: usize, stride: usize, first: *mut u32) {
        let object = registry::get(crowd)?;
        // SAFETY: the caller promises `count` agents.
        let agents = unsafe { Input::new("agents", agents, count, stride) }?;
        let mut state = try_write(&object.state, "crowd")?;
        let start = state.crowd.agents().len();
        // All are checked before one is added.
        for (at, agent) in agents.iter().enumerate() {
            state.crowd.check(&agent_of(&agent)).map_err(|error| error.at(format!("agent {at}")))?;
        }
        if agents.len() > relievo_crowd::MAX_AGENTS - start {
            let most = relievo_crowd::MAX_AGENTS;
            return Err(Error::unsupported(format!("a crowd has at most {most} agents")).at("count"));
        }
        agents.iter().try_for_each(|agent| state.crowd.add(agent_of(&agent)).map(drop))?;
        state.is_cut = false;
        // SAFETY: the caller promises a place, or NULL.
        unsafe { put_optional(first, start as u32) };
        Ok(())
    }

    fn rlv_crowd_set(crowd: RlvCrowd, first: u32, agents: *const RlvCrowdAgent, count: usize, stride: usize) {
        let object = registry::get(crowd)?;
        // SAFETY: the caller promises `count` agents.
        let agents = unsafe { Input::new("agents", agents, count, stride) }?;
        let mut state = try_write(&object.state, "crowd")?;
        let known = state.crowd.agents().len();
        if (first as usize).checked_add(count).is_none_or(|end| end > known) {
            return Err(Error::invalid(format!("agents {first} and {count} more go beyond the {known} there are"))
                .at("first")
                .advise("add them by rlv_crowd_add"));
        }
        for (at, agent) in agents.iter().enumerate() {
            state.crowd.check(&agent_of(&agent)).map_err(|error| error.at(format!("agent {at}")))?;
        }
        for (agent, index) in agents.iter().zip(first..) {
            state.crowd.set(index, agent_of(&agent))?;
        }
        state.is_cut = false;
        Ok(())
    }

    fn rlv_crowd_set_weights(crowd: RlvCrowd, agent: u32, weights: *const f32, count: usize) {
        let object = registry::get(crowd)?;
        // SAFETY: the caller promises `count` weights.
        let given = unsafe { Input::new("weights", weights, count, 0) }?;
        let mut state = try_write(&object.state, "crowd")?;
        let given = given.to_vec("weights", object.context.context.memory_limit())?;
        let weights = (!weights.is_null()).then_some(given.as_slice());
        state.crowd.set_weights(agent, weights).map_err(|error| error.at("weights"))?;
        state.is_cut = false;
        Ok(())
    }

    fn rlv_crowd_cut(crowd: RlvCrowd, view: *const RlvCrowdView, out: *mut RlvCrowdFrame) {
        let object = registry::get(crowd)?;
        let mut state = try_write(&object.state, "crowd")?;
        let State { crowd, frame, occlusion, list, shown, is_cut } = &mut *state;
        // Before anything is refused, so that nobody draws the cut before.
        *is_cut = false;
        // SAFETY: the caller gives NULL or descriptors that start with their size.
        let Seen { view, eye, pixels, time } = unsafe {
            check_optional(out)?;
            view_of(view)?
        };
        let context = &object.context.context;
        crowd.cut(context, &view, frame)?;
        let culled = match pixels {
            Some(pixels) => occlusion.cull(context, crowd, (&pixels, time), frame)?,
            None => Culled::default(),
        };
        list.update(crowd, frame, time)?;
        let [impostor_count, picture_count] = shown.update(context, (crowd, &frame.impostors(), time), eye)?;
        *is_cut = true;
        let found = RlvCrowdFrame {
            struct_size: 0,
            agent_count: list.instances.len() as u32,
            draw_count: list.draws.len() as u32,
            matrix_count: list.matrices.len() as u32,
            changed: frame.changed,
            hidden: culled.hidden,
            clusters: frame.clusters,
            triangles: frame.triangles,
            hidden_triangles: culled.hidden_triangles,
            occluder_triangles: culled.occluder_triangles,
            weight_count: list.weights.len() as u32,
            impostor_count,
            picture_count,
            hidden_clusters: u32::try_from(culled.hidden_clusters).unwrap_or(u32::MAX),
        };
        // SAFETY: checked above.
        unsafe { write_optional(out, found) }
    }

    fn rlv_crowd_get(crowd: RlvCrowd, buffers: *const RlvCrowdBuffers) {
        let object = registry::get(crowd)?;
        // SAFETY: a descriptor of nothing but numbers and NULL pointers.
        let default: RlvCrowdBuffers = unsafe { std::mem::zeroed() };
        // SAFETY: the caller gives NULL or a descriptor that starts with its size.
        let given = unsafe { read_descriptor(buffers, default) }?;
        let state = try_read(&object.state, "crowd")?;
        state.check_cut()?;
        // SAFETY: the caller promises room for the capacities in each array that is not NULL.
        unsafe { write_list(&object.context.context, &given, &state.list) }
    }
}
