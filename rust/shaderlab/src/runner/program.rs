//! What a device needs of a shader: its text in WGSL, its entry points and its resources.

use relievo_core::{Error, Result, error::nearest};

use super::bind::Inputs;
use crate::augment::Augmented;
use crate::fault::Faults;
use crate::front::{Parsed, entries, wgsl};
use crate::instrument::Instrument;
use crate::resource::{FieldKind, Resource, resources};
use crate::shader::Shader;
use crate::source::Stage;

/// An input or output of an entry point.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Located {
    pub location: u32,
    pub name: String,
    /// The kind of its numbers and how many they are; `None` for other types.
    pub numbers: Option<(FieldKind, u32)>,
    /// Whether it is interpolated as floats are when nothing else is said.
    pub is_smooth: bool,
}

/// An entry point with what it takes and gives.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Point {
    pub name: String,
    pub stage: Stage,
    pub workgroup: [u32; 3],
    pub inputs: Vec<Located>,
    pub outputs: Vec<Located>,
    /// Whether it takes vectors.
    pub is_marked: bool,
}

impl Point {
    /// Returns the floats of its output at location 0.
    pub fn output(&self) -> Option<u32> {
        let first = self.outputs.iter().find(|output| output.location == 0)?;
        first.numbers.filter(|(kind, _)| *kind == FieldKind::Float).map(|(_, count)| count)
    }
}

/// The entry points that a runner runs.
pub(super) struct Chosen {
    /// The one that computes pixels. A vertex shader can run without one.
    pub pixels: Option<Point>,
    /// The one that computes vertices. A fragment shader can run without one.
    pub vertices: Option<Point>,
}

/// A shader, plain or augmented, for a device.
#[derive(Clone, Debug)]
pub struct Program {
    pub(super) text: String,
    pub(super) points: Vec<Point>,
    pub(super) resources: Vec<Resource>,
    pub(super) instrument: Option<Instrument>,
    /// Whether it uses `confidence`.
    pub(super) judges: bool,
    /// The vertex shader of another text.
    pub(super) vertex: Option<Box<Program>>,
}

impl Program {
    /// Makes a program of a shader without changes.
    ///
    /// # Errors
    /// Fails if the shader uses what WGSL lacks.
    pub fn plain(shader: &Shader) -> std::result::Result<Self, Faults> {
        Ok(Self::of(&shader.parsed, shader.wgsl()?, None))
    }

    /// Makes a program of an augmented shader.
    ///
    /// # Errors
    /// Fails as [`Program::plain`] does.
    pub fn augmented(shader: &Shader, augmented: &Augmented) -> std::result::Result<Self, Faults> {
        Ok(Self::of(&augmented.parsed, augmented.wgsl(shader)?, Some(augmented)))
    }

    fn of(parsed: &Parsed, text: String, augmented: Option<&Augmented>) -> Self {
        let instrument = augmented.map(instrument);
        let points = points(parsed, instrument.as_ref());
        let judges = augmented.is_some_and(|it| it.uses_confidence);
        Self { text, points, resources: resources(&parsed.module), instrument, judges, vertex: None }
    }

    /// Adds a vertex shader of another text, plain or augmented, to the program of a fragment shader. Its bind groups follow
    /// those of the fragment shader, so that both may number them from 0; inputs of one name reach both.
    ///
    /// # Errors
    /// Fails if the vertex shader has no vertex entry point or several, if it uses what WGSL lacks, or if both take
    /// vectors that differ in length or accumulation.
    pub fn with_vertex(mut self, shader: &Shader, augmented: Option<&Augmented>) -> Result<Self> {
        let first = self.resources.iter().map(|resource| resource.group.saturating_add(1)).max().unwrap_or(0);
        let parsed = augmented.map_or(&shader.parsed, |it| &it.parsed);
        let text = match augmented {
            Some(augmented) => augmented.numbered(shader, first)?,
            None => wgsl(parsed, first).map_err(Faults::of(&shader.source))?,
        };
        let mut vertex = Self::of(parsed, text, augmented);
        let place = || shader.source.name.clone();
        match vertex.points.iter().filter(|point| point.stage == Stage::Vertex).count() {
            1 => {}
            0 => return Err(Error::unsupported("the shader has no vertex entry point").at(place())),
            _ => return Err(Error::unsupported("the shader has several vertex entry points").at(place())),
        }
        if let (Some(own), Some(other)) = (&self.instrument, &vertex.instrument)
            && (own.features, own.accumulation) != (other.features, other.accumulation)
        {
            return Err(Error::invalid("the vectors of the vertex shader have other features or another accumulation")
                .at(place())
                .advise("take the same features in both shaders, or vectors in one of them"));
        }
        vertex.resources.iter_mut().for_each(|resource| resource.group = resource.group.saturating_add(first));
        if let Some(instrument) = &mut vertex.instrument {
            instrument.group = instrument.group.saturating_add(first);
        }
        self.vertex = Some(Box::new(vertex));
        Ok(self)
    }

    /// Returns the program and the one of its vertex shader.
    pub(super) fn parts(&self) -> impl Iterator<Item = &Self> {
        std::iter::once(self).chain(self.vertex.as_deref())
    }

    /// Returns the resources of the user's shader, and of its vertex shader.
    pub fn resources(&self) -> impl Iterator<Item = &Resource> {
        self.parts().flat_map(|part| part.resources.iter().filter(|resource| !part.is_instrument(resource)))
    }

    pub(super) fn is_instrument(&self, resource: &Resource) -> bool {
        let places = |it: &Instrument| resource.group == it.group && resource.binding.wrapping_sub(it.binding) < 2;
        self.instrument.as_ref().is_some_and(places)
    }

    /// Returns the entry points to run: the one of a name, or the only one that computes pixels, or else vertices. With a
    /// fragment shader runs its vertex shader: that of another text; or that of the same text which needs no inputs, has
    /// some of its inputs among `inputs`, or alone takes vectors.
    pub(super) fn choose(&self, name: Option<&str>, inputs: &Inputs) -> Result<Chosen> {
        let point = self.entry(name)?;
        let is_vertex = |point: &&Point| point.stage == Stage::Vertex;
        if let (Some(_), Stage::Vertex | Stage::Compute) = (&self.vertex, point.stage) {
            return Err(Error::invalid(format!("a {} shader runs without a vertex shader", point.stage.name()))
                .at(point.name)
                .advise("leave the vertex shader out, or name a fragment shader"));
        }
        if point.stage == Stage::Vertex {
            return Ok(Chosen { pixels: None, vertices: Some(point) });
        }
        let is_given = |vertex: &&Point| {
            vertex.inputs.is_empty()
                || vertex.inputs.iter().any(|input| inputs.numbers.contains_key(&input.name))
                || (vertex.is_marked && !point.is_marked)
        };
        let vertices = match (&self.vertex, point.stage) {
            (Some(vertex), _) => vertex.points.iter().find(is_vertex),
            (None, Stage::Fragment) => self.points.iter().find(is_vertex).filter(is_given),
            (None, _) => None,
        };
        Ok(Chosen { vertices: vertices.cloned(), pixels: Some(point) })
    }

    /// Returns the entry point of a name, or the only one that computes pixels, or else vertices.
    fn entry(&self, name: Option<&str>) -> Result<Point> {
        let of = |is_wanted: fn(&Point) -> bool| self.points.iter().filter(|it| is_wanted(it)).collect::<Vec<_>>();
        let runs = match name {
            Some(_) => of(|_| true),
            None => of(|point| point.stage != Stage::Vertex),
        };
        let runs = if runs.is_empty() { of(|_| true) } else { runs };
        let names = || runs.iter().map(|point| point.name.as_str());
        let listed = names().collect::<Vec<_>>().join(", ");
        match (name, runs.as_slice()) {
            (_, []) => Err(Error::unsupported("the shader has no entry point of vertices, fragments or a grid")),
            (Some(name), _) => {
                runs.iter().find(|point| point.name == name).map(|point| (*point).clone()).ok_or_else(|| {
                    let advice = match nearest(name, names()) {
                        Some(near) => format!("did you mean `{near}`?"),
                        None => format!("there are {listed}"),
                    };
                    Error::new(relievo_core::ErrorKind::NotFound, format!("there is no entry point `{name}`"))
                        .advise(advice)
                })
            }
            (None, [point]) => Ok((*point).clone()),
            (None, _) => {
                Err(Error::invalid("the shader has several entry points").advise(format!("name one of {listed}")))
            }
        }
    }
}

fn instrument(augmented: &Augmented) -> Instrument {
    Instrument {
        features: augmented.features.len(),
        accumulation: augmented.accumulation,
        group: augmented.group,
        binding: augmented.binding,
    }
}

fn points(parsed: &Parsed, instrument: Option<&Instrument>) -> Vec<Point> {
    let module = &parsed.module;
    let numbers = |ty: naga::Handle<naga::Type>| {
        let (scalar, count) = match &module.types[ty].inner {
            naga::TypeInner::Scalar(scalar) => (scalar, 1),
            naga::TypeInner::Vector { size, scalar } => (scalar, *size as u32),
            _ => return None,
        };
        Some((FieldKind::of(scalar)?, count))
    };
    let located = |name: &Option<String>, ty: naga::Handle<naga::Type>, binding: &Option<naga::Binding>| {
        let of = |name: &Option<String>, ty: naga::Handle<naga::Type>, binding: &Option<naga::Binding>| match binding {
            Some(naga::Binding::Location { location, interpolation, sampling, .. }) => Some(Located {
                location: *location,
                name: name.clone().unwrap_or_default(),
                numbers: numbers(ty),
                is_smooth: matches!(interpolation, None | Some(naga::Interpolation::Perspective))
                    && matches!(sampling, None | Some(naga::Sampling::Center)),
            }),
            _ => None,
        };
        let mut found: Vec<_> = of(name, ty, binding).into_iter().collect();
        if let naga::TypeInner::Struct { members, .. } = &module.types[ty].inner {
            found.extend(members.iter().filter_map(|it| of(&it.name, it.ty, &it.binding)));
        }
        found
    };
    let is_log = |variable: &naga::GlobalVariable| {
        let place = variable.binding.as_ref().map(|it| (it.group, it.binding));
        instrument.is_some_and(|it| place == Some((it.group, it.binding + 1)))
    };
    let log = module.global_variables.iter().find(|(_, variable)| is_log(variable)).map(|(handle, _)| handle);
    let point = |(index, stage, entry): (usize, Stage, &naga::EntryPoint)| {
        let arguments = entry.function.arguments.iter();
        let results = entry.function.result.iter();
        Point {
            name: entry.name.clone(),
            stage,
            workgroup: entry.workgroup_size,
            inputs: arguments.flat_map(|it| located(&it.name, it.ty, &it.binding)).collect(),
            outputs: results.flat_map(|it| located(&None, it.ty, &it.binding)).collect(),
            is_marked: log.is_some_and(|log| !parsed.info.get_entry_point(index)[log].is_empty()),
        }
    };
    entries(module).map(point).collect()
}
