//! Lists of edits of progressive meshes.

use std::path::{Path, PathBuf};

use relievo_core::{Context, Error, Falloff, Result, file};
use relievo_detail::Stroke;
use relievo_lod::progressive::{Edit, Handle, HandleKey, KeyedEdit, KeyedHandle, Region};
use serde::de::Error as _;
use serde::{Deserialize, Deserializer};

use crate::progressive::Level;

/// Bytes of a list at most.
const LONGEST: u64 = 1 << 24;

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct List {
    #[serde(default)]
    edit: Vec<Entry>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct Entry {
    error: Option<f32>,
    faces: Option<usize>,
    ratio: Option<f64>,
    #[serde(default)]
    handle: Vec<Grabbed>,
    #[serde(default)]
    anchor: Vec<Held>,
    strokes: Option<PathBuf>,
}

/// What is done at a level.
pub enum Change {
    /// Regions are moved and turned.
    Edit(Edit),
    /// Strokes are made, one after the other.
    Strokes(Vec<Stroke>),
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct Grabbed {
    center: [f32; 3],
    radius: f32,
    #[serde(default, deserialize_with = "falloff")]
    falloff: Falloff,
    #[serde(default)]
    translation: [f32; 3],
    #[serde(default = "upwards")]
    axis: [f32; 3],
    #[serde(default)]
    angle: f32,
    #[serde(default)]
    key: Vec<Keyed>,
}

/// What a handle does at a time.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct Keyed {
    time: f64,
    #[serde(default)]
    translation: [f32; 3],
    #[serde(default = "upwards")]
    axis: [f32; 3],
    #[serde(default)]
    angle: f32,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct Held {
    center: [f32; 3],
    radius: f32,
    #[serde(default, deserialize_with = "falloff")]
    falloff: Falloff,
}

fn upwards() -> [f32; 3] {
    [0.0, 0.0, 1.0]
}

/// A falloff by its name.
fn falloff<'a, D: Deserializer<'a>>(source: D) -> std::result::Result<Falloff, D::Error> {
    let name = String::deserialize(source)?;
    let found = Falloff::NAMES.iter().find(|(_, other)| *other == name);
    found.map(|(falloff, _)| *falloff).ok_or_else(|| {
        let names = Falloff::NAMES.map(|(_, name)| name).join(", ");
        D::Error::custom(format!("there is no falloff `{name}`; use one of {names}"))
    })
}

/// An axis of length 1.
fn unit(axis: [f32; 3]) -> [f32; 3] {
    let length = axis.iter().map(|value| value * value).sum::<f32>().sqrt();
    axis.map(|value| value / length)
}

impl Grabbed {
    fn region(&self) -> Region {
        Region { center: self.center, radius: self.radius, falloff: self.falloff }
    }

    fn handle(&self) -> Handle {
        Handle {
            region: self.region(),
            translation: self.translation,
            axis: unit(self.axis),
            angle: self.angle.to_radians(),
        }
    }

    /// The handle over time: without keys it is the same at all times.
    fn keyed(&self) -> KeyedHandle {
        let of = |key: &Keyed| HandleKey {
            time: key.time,
            translation: key.translation,
            axis: unit(key.axis),
            angle: key.angle.to_radians(),
        };
        let Handle { region, translation, axis, angle } = self.handle();
        let keys = match self.key.as_slice() {
            [] => vec![HandleKey { time: 0.0, translation, axis, angle }],
            keys => keys.iter().map(of).collect(),
        };
        KeyedHandle { region, keys }
    }
}

impl Entry {
    /// What handles and anchors do; at a time in seconds, which has to be there if they have keys.
    fn edit(&self, time: Option<f64>) -> Result<Edit> {
        let anchor = |held: &Held| Region { center: held.center, radius: held.radius, falloff: held.falloff };
        let anchors: Vec<Region> = self.anchor.iter().map(anchor).collect();
        if self.handle.iter().all(|handle| handle.key.is_empty()) {
            return Ok(Edit { handles: self.handle.iter().map(Grabbed::handle).collect(), anchors });
        }
        let is_both = |handle: &Grabbed| {
            !handle.key.is_empty()
                && (handle.translation != [0.0; 3] || handle.axis != upwards() || handle.angle != 0.0)
        };
        if self.handle.iter().any(is_both) {
            return Err(
                Error::invalid("a handle has keys, or translation, axis and angle").advise("put these into its keys")
            );
        }
        let Some(time) = time else {
            return Err(Error::invalid("a handle has keys").advise("say by --time at which time it is taken"));
        };
        KeyedEdit { handles: self.handle.iter().map(Grabbed::keyed).collect(), anchors }.at(time)
    }
}

/// The edits of the list at `path`, as they are at a time in seconds if they have keys, and the levels they are made at.
pub fn read(context: &Context, path: &Path, time: Option<f64>) -> Result<Vec<(Level, Change)>> {
    let place = || path.display().to_string();
    let bytes = file::load(path, LONGEST)?;
    let text = String::from_utf8(bytes).map_err(|_| Error::invalid("it is no text").at(place()))?;
    let list: List = toml::from_str(&text).map_err(|error| Error::invalid(error.to_string()).at(place()))?;
    let edit = |(number, entry): (usize, Entry)| {
        let given = [entry.error.is_some(), entry.faces.is_some(), entry.ratio.is_some()];
        if given.into_iter().filter(|given| *given).count() > 1 {
            return Err(Error::invalid("an edit has one level")
                .at(place())
                .advise("leave all but one of error, faces and ratio out"));
        }
        let edit = entry.edit(time).map_err(|error| error.at(format!("{}: edit {}", path.display(), number + 1)))?;
        let change = match entry.strokes {
            None => Change::Edit(edit),
            Some(_) if edit != Edit::default() => {
                return Err(Error::invalid("an edit has strokes, or handles and anchors")
                    .at(place())
                    .advise("make two edits of them"));
            }
            Some(list) => {
                let list = path.parent().unwrap_or(Path::new("")).join(list);
                Change::Strokes(relievo_scene::replay::strokes(context, &list, &[])?)
            }
        };
        Ok((Level { error: entry.error, faces: entry.faces, ratio: entry.ratio }, change))
    };
    list.edit.into_iter().enumerate().map(edit).collect()
}
