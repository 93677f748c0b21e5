//! Builds of crowd models; see `include/relievo/crowd.h`.

use std::ffi::{c_char, c_void};
use std::path::PathBuf;
use std::sync::{Arc, OnceLock};

use relievo_core::{Error, Progress, Result};
use relievo_crowd::{BuildSettings, CrowdModel, Refit};
use relievo_meshio::Model;

use super::model::{CrowdModelObject, RlvCrowdModel, register};
use crate::border::array::{Input, Plain, present, put, text};
use crate::border::descriptor::{check_optional, write_optional};
use crate::border::registry;
use crate::runtime::context::{ContextObject, HostProgress, RlvContext, RlvProgress};
use crate::runtime::parameter::{RlvParameter, Table, settings, write_table};

settings!(RlvCrowdBuildSettings, BuildSettings);

descriptor! {
    pub struct RlvCrowdClipName {
        name: *const c_char,
    }
}

descriptor! {
    pub struct RlvCrowdRefitReport {
        struct_size: u32,
        grown_groups: u32,
        growth: f64,
        is_rebuild_due: u32,
        reserved: u32,
    }
}

impl Default for RlvCrowdClipName {
    fn default() -> Self {
        Self { name: std::ptr::null() }
    }
}

// SAFETY: a pointer without padding.
unsafe impl Plain for RlvCrowdClipName {}

/// A hierarchy to be built or refitted of a file, with all that this needs copied.
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
    /// Fails with `Invalid` if a text or the array of clips cannot be used or a setting is out of range, and with `Memory`
    /// if the names exceed the context's memory limit.
    ///
    /// # Safety
    /// `path` is NULL or a NUL-terminated text, `clips` has `count` names, `settings` is NULL or a descriptor that starts
    /// with its size.
    pub unsafe fn read(
        context: Arc<ContextObject>,
        path: *const c_char,
        clips: *const RlvCrowdClipName,
        count: usize,
        settings: *const RlvCrowdBuildSettings,
    ) -> Result<Self> {
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
        let (source, animations) = self.source(progress)?;
        let model = CrowdModel::build(&self.context.context, &source, &animations, &self.settings, progress)
            .map_err(|error| self.place(error))?;
        register(self.context.clone(), model)
    }

    /// Reads the file. Returns it with the indices of the animations that are wanted.
    fn source(&self, progress: &mut dyn Progress) -> Result<(Model, Vec<usize>)> {
        progress.step(0.0, "read poses")?;
        let source = relievo_meshio::read_model(&self.context.context, &self.path)?;
        source.notes.iter().for_each(|note| self.context.log(crate::runtime::context::RLV_LOG_WARNING, note));
        let animations = match self.clips.as_slice() {
            [] => (0..source.animations.len()).collect(),
            names => names.iter().map(|name| source.animation(name)).collect::<Result<Vec<_>>>()?,
        };
        Ok((source, animations))
    }

    fn place(&self, error: Error) -> Error {
        error.at(self.path.display().to_string())
    }
}

/// A model to be refitted, with all that this needs copied.
pub struct CrowdRefit {
    before: Arc<CrowdModelObject>,
    build: CrowdBuild,
}

impl CrowdRefit {
    /// Copies what a refit needs.
    ///
    /// # Errors
    /// Fails with `Invalid` if the handle is not alive; otherwise as [`CrowdBuild::read`].
    ///
    /// # Safety
    /// As for [`CrowdBuild::read`].
    pub unsafe fn read(
        model: RlvCrowdModel,
        path: *const c_char,
        clips: *const RlvCrowdClipName,
        count: usize,
        settings: *const RlvCrowdBuildSettings,
    ) -> Result<Self> {
        let before = registry::get(model)?;
        // SAFETY: promised by the caller.
        let build = unsafe { CrowdBuild::read(before.context.clone(), path, clips, count, settings) }?;
        Ok(Self { before, build })
    }

    pub fn context(&self) -> &Arc<ContextObject> {
        self.build.context()
    }

    /// Makes the refitted model.
    ///
    /// # Errors
    /// Fails as [`CrowdBuild::run`] and [`CrowdModel::refit`] do.
    pub fn run(&self, progress: &mut dyn Progress) -> Result<(RlvCrowdModel, RlvCrowdRefitReport)> {
        let Self { before, build } = self;
        let (source, animations) = build.source(progress)?;
        let (model, refit) = before
            .model
            .refit(&build.context.context, &source, &animations, &build.settings, progress)
            .map_err(|error| build.place(error))?;
        Ok((register(build.context.clone(), model)?, report_of(&refit)))
    }
}

fn report_of(refit: &Refit) -> RlvCrowdRefitReport {
    RlvCrowdRefitReport {
        struct_size: 0,
        grown_groups: refit.grown,
        growth: refit.growth,
        is_rebuild_due: refit.is_rebuild_due().into(),
        reserved: 0,
    }
}

entry! {
    fn rlv_crowd_params(params: *mut *const RlvParameter, count: *mut usize) {
        static TABLE: OnceLock<Table> = OnceLock::new();
        // SAFETY: the caller gives pointers to which a value may be written, or NULL.
        unsafe { write_table(&TABLE, BuildSettings::PARAMETERS, params, count) }
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
        let build = unsafe { CrowdBuild::read(registry::get(context)?, path, clips, clip_count, settings) }?;
        let made = build.run(&mut HostProgress { callback: progress, user })?;
        // SAFETY: checked above.
        unsafe { put(out, made) };
        Ok(())
    }

    fn rlv_crowd_model_refit(
        model: RlvCrowdModel,
        path: *const c_char,
        clips: *const RlvCrowdClipName,
        clip_count: usize,
        settings: *const RlvCrowdBuildSettings,
        progress: RlvProgress,
        user: *mut c_void,
        report: *mut RlvCrowdRefitReport,
        out: *mut RlvCrowdModel,
    ) {
        present("out", out)?;
        // SAFETY: the caller gives NUL-terminated texts, and NULL or descriptors that start with their size.
        let refit = unsafe {
            check_optional(report)?;
            CrowdRefit::read(model, path, clips, clip_count, settings)?
        };
        let (made, found) = refit.run(&mut HostProgress { callback: progress, user })?;
        // SAFETY: both were checked above.
        unsafe {
            write_optional(report, found)?;
            put(out, made);
        }
        Ok(())
    }
}
