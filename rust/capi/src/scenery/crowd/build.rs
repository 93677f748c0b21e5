//! Builds of crowd models; see `include/relievo/crowd.h`.

use std::ffi::{c_char, c_void};
use std::path::PathBuf;
use std::sync::{Arc, OnceLock};

use relievo_core::{Error, Progress, Result};
use relievo_crowd::{BuildSettings, CrowdModel};

use super::model::{RlvCrowdModel, register};
use crate::border::array::{Input, Plain, present, put, text};
use crate::border::registry;
use crate::runtime::context::{ContextObject, HostProgress, RlvContext, RlvProgress};
use crate::runtime::parameter::{RlvParameter, Table, settings, table};

settings!(RlvCrowdBuildSettings, BuildSettings);

descriptor! {
    pub struct RlvCrowdClipName {
        name: *const c_char,
    }
}

impl Default for RlvCrowdClipName {
    fn default() -> Self {
        Self { name: std::ptr::null() }
    }
}

// SAFETY: a pointer without padding.
unsafe impl Plain for RlvCrowdClipName {}

/// A hierarchy to be built of a file, with all that this needs copied.
pub struct CrowdBuild {
    context: Arc<ContextObject>,
    path: PathBuf,
    clips: Vec<String>,
    settings: BuildSettings,
}

impl CrowdBuild {
    /// Copies what a build needs.
    ///
    /// # Errors
    /// Fails with `Invalid` if the handle is not alive, a text or the array of clips cannot be used or a setting is out
    /// of range, and with `Memory` if the names exceed the context's memory limit.
    ///
    /// # Safety
    /// `path` is NULL or a NUL-terminated text, `clips` has `count` names, `settings` is NULL or a descriptor that starts
    /// with its size.
    pub unsafe fn read(
        context: RlvContext,
        path: *const c_char,
        clips: *const RlvCrowdClipName,
        count: usize,
        settings: *const RlvCrowdBuildSettings,
    ) -> Result<Self> {
        let context = registry::get(context)?;
        // SAFETY: promised by the caller.
        let (path, settings) = unsafe { (text("path", path)?, RlvCrowdBuildSettings::read(settings)?) };
        // SAFETY: promised by the caller.
        let names = unsafe { Input::new("clips", clips, count, 0) }?.to_vec("clips", context.context.memory_limit())?;
        // SAFETY: as above.
        let clips = names.iter().map(|clip| unsafe { text("clips", clip.name) }.map(str::to_owned));
        let clips = clips.collect::<Result<Vec<_>>>()?;
        Ok(Self { context, path: path.into(), clips, settings })
    }

    pub fn context(&self) -> &Arc<ContextObject> {
        &self.context
    }

    /// Builds the hierarchy.
    ///
    /// # Errors
    /// Fails with `NotFound` if the file or a clip does not exist, as [`relievo_meshio::read_model`] and
    /// [`CrowdModel::build`] do, and with `Cancelled` if `progress` asks to stop.
    pub fn run(&self, progress: &mut dyn Progress) -> Result<RlvCrowdModel> {
        progress.step(0.0, "read poses")?;
        let context = &self.context.context;
        let source = relievo_meshio::read_model(context, &self.path)?;
        source.notes.iter().for_each(|note| self.context.log(crate::runtime::context::RLV_LOG_WARNING, note));
        let animations = match self.clips.as_slice() {
            [] => (0..source.animations.len()).collect(),
            names => names.iter().map(|name| source.animation(name)).collect::<Result<Vec<_>>>()?,
        };
        let place = |error: Error| error.at(self.path.display().to_string());
        let model = CrowdModel::build(context, &source, &animations, &self.settings, progress).map_err(place)?;
        register(self.context.clone(), model)
    }
}

entry! {
    fn rlv_crowd_params(params: *mut *const RlvParameter, count: *mut usize) {
        static TABLE: OnceLock<Table> = OnceLock::new();
        present("params", params)?;
        present("count", count)?;
        let rows = table(&TABLE, BuildSettings::PARAMETERS);
        // SAFETY: both were checked above.
        unsafe {
            put(params, rows.as_ptr());
            put(count, rows.len());
        }
        Ok(())
    }

    fn rlv_crowd_model_build(
        context: RlvContext,
        path: *const c_char,
        clips: *const RlvCrowdClipName,
        clip_count: usize,
        settings: *const RlvCrowdBuildSettings,
        progress: RlvProgress,
        user: *mut c_void,
        out: *mut RlvCrowdModel,
    ) {
        present("out", out)?;
        // SAFETY: the caller gives NUL-terminated texts, and NULL or a descriptor that starts with its size.
        let build = unsafe { CrowdBuild::read(context, path, clips, clip_count, settings) }?;
        let made = build.run(&mut HostProgress { callback: progress, user })?;
        // SAFETY: checked above.
        unsafe { put(out, made) };
        Ok(())
    }
}
