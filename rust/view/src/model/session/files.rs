//! The files of a session: the document that edits go to, and the one that they are kept in until they are saved.

use std::path::{Path, PathBuf};

use relievo_core::{Error, Result};
use relievo_detail::History;
use relievo_document::format::EXTENSION;

use super::{AUTOSAVE, HISTORY, Opening, Session, is_document};
use crate::model::stamp::BrushStamp;

impl Session {
    /// Whether there are edits that no file was saved with.
    pub fn is_unsaved(&self) -> bool {
        self.document.is_none() && !self.labels.is_empty()
    }

    /// The file that edits are saved to, or that they would be if nothing is said.
    pub fn document(&self) -> PathBuf {
        self.document.clone().unwrap_or_else(|| self.mesh_path.with_extension(EXTENSION))
    }

    /// The name of what is open.
    pub fn name(&self) -> String {
        let path = self.document.as_ref().unwrap_or(&self.mesh_path);
        path.file_name().map_or_else(String::new, |name| name.to_string_lossy().into_owned())
    }

    /// Saves all layers and edits; later edits go to the same file as they are made. Returns the file.
    ///
    /// # Errors
    /// The file cannot be written, or there is one that was not opened.
    pub fn save(&mut self) -> Result<PathBuf> {
        match self.document.clone() {
            Some(path) => self.history.sync().map(|()| path),
            None => {
                let path = self.document();
                if path.exists() {
                    return Err(Error::invalid("there is a document of that name already")
                        .at(path.display().to_string())
                        .advise("open it, or save under another name"));
                }
                self.save_as(&path)
            }
        }
    }

    /// Saves to a file, and has later edits go there. Returns it.
    ///
    /// # Errors
    /// The file cannot be written, its name does not end in `.relievo`, or another program works on it.
    pub fn save_as(&mut self, path: &Path) -> Result<PathBuf> {
        if !is_document(path) {
            return Err(Error::invalid("documents end in .relievo").at(path.display().to_string()));
        }
        self.write(path)?;
        self.document = Some(path.to_path_buf());
        self.drop_autosave();
        Ok(path.to_path_buf())
    }

    fn write(&mut self, path: &Path) -> Result<()> {
        let Self { context, object, mesh, history, costs, .. } = self;
        costs.other("save", || {
            object.settle(context)?;
            let document = object.document(context, mesh)?;
            history.save(path, &document)
        })
    }

    /// Keeps edits in a file until they are saved. Where that cannot be written the session goes on without.
    pub(super) fn keep(&mut self) {
        if self.document.is_some() || self.autosave.is_some() || self.is_autosave_refused {
            return;
        }
        let path = self.mesh_path.with_extension(AUTOSAVE);
        if self.recoverable.is_some() {
            // What an earlier session left stays until the user says.
            return;
        }
        match self.write(&path) {
            Ok(()) => self.autosave = Some(path),
            Err(error) => {
                self.is_autosave_refused = true;
                self.message = Some(format!("edits are not kept until they are saved: {error}"));
            }
        }
    }

    /// Removes the file that edits were kept in.
    fn drop_autosave(&mut self) {
        if let Some(path) = self.autosave.take() {
            // A file that stays is offered when the mesh is opened next.
            let _ = std::fs::remove_file(path);
        }
    }

    /// The file that an earlier session left without saving, if there is one.
    pub fn recoverable(&self) -> Option<&Path> {
        self.recoverable.as_deref()
    }

    /// Takes up what an earlier session left; it is not saved yet.
    ///
    /// # Errors
    /// The file cannot be read, or another program works on it.
    pub fn recover(&mut self) -> Result<()> {
        let Some(path) = self.recoverable.clone() else { return Ok(()) };
        let opening = Opening { file: path.clone(), mesh: Some(self.mesh_path.clone()), kind: None, cells: None };
        let made = Self::open(self.context.clone(), &opening)?;
        let (brush, serial) = (self.brush.clone(), self.triangles.serial);
        *self = Self { brush, document: None, autosave: Some(path), ..made };
        self.triangles.serial = serial + 1;
        self.picked_serial = serial + 1;
        Ok(())
    }

    /// Forgets what was not saved: of an earlier session where that is asked about, or else of this one.
    pub fn discard(&mut self) {
        match self.recoverable.take() {
            Some(path) => {
                if let Err(error) = std::fs::remove_file(&path) {
                    self.message = Some(Error::io(&path, &error).to_string());
                }
            }
            None => {
                self.history = History::new(HISTORY);
                self.labels.clear();
                self.drop_autosave();
            }
        }
    }

    /// Keeps what was not saved. Returns where it is, if there is anything.
    ///
    /// # Errors
    /// It cannot be written.
    pub fn rescue(&mut self) -> Result<Option<PathBuf>> {
        if !self.is_unsaved() {
            return self.history.sync().map(|()| None);
        }
        if self.autosave.is_none() {
            let path = self.mesh_path.with_extension(AUTOSAVE);
            self.write(&path)?;
            self.autosave = Some(path);
        }
        self.history.sync()?;
        Ok(self.autosave.clone())
    }

    /// Gives the brush the image of a PNG or EXR file.
    ///
    /// # Errors
    /// The file cannot be read, is damaged or too large. The brush stays as it was.
    pub fn open_stamp(&mut self, path: &Path) -> Result<()> {
        self.brush.stamp = Some(BrushStamp::read(&self.context, path)?);
        Ok(())
    }
}
