//! What a device needs of a shader: its text in WGSL, its entry points and its resources.

use relievo_core::{Error, Result, error::nearest};

use crate::augment::Augmented;
use crate::fault::Faults;
use crate::instrument::Instrument;
use crate::resource::{Resource, resources};
use crate::shader::Shader;
use crate::source::Stage;

/// An entry point with what it takes and gives.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Point {
    pub name: String,
    pub stage: Stage,
    pub workgroup: [u32; 3],
    /// Locations of its inputs with their floats; `None` for a type that no rectangle can give.
    pub inputs: Vec<(u32, Option<u32>)>,
    /// Floats of its output at location 0.
    pub output: Option<u32>,
}

/// A shader, plain or augmented, for a device.
#[derive(Clone, Debug)]
pub struct Program {
    pub(super) text: String,
    pub(super) points: Vec<Point>,
    pub(super) resources: Vec<Resource>,
    pub(super) instrument: Option<Instrument>,
}

impl Program {
    /// Makes a program of a shader as it is. Fails if the shader uses what WGSL lacks.
    pub fn plain(shader: &Shader) -> std::result::Result<Self, Faults> {
        let module = &shader.parsed.module;
        let (points, resources) = (points(module), resources(module));
        Ok(Self { text: shader.wgsl()?, points, resources, instrument: None })
    }

    /// Makes a program of an augmented shader. Fails as [`Program::plain`] does.
    pub fn augmented(shader: &Shader, augmented: &Augmented) -> std::result::Result<Self, Faults> {
        let module = &augmented.parsed.module;
        let instrument = Instrument {
            features: augmented.features.len(),
            accumulation: augmented.accumulation,
            group: augmented.group,
            binding: augmented.binding,
        };
        let (points, resources) = (points(module), resources(module));
        Ok(Self { text: augmented.wgsl(shader)?, points, resources, instrument: Some(instrument) })
    }

    /// Returns the resources of the user's shader.
    pub fn resources(&self) -> impl Iterator<Item = &Resource> {
        self.resources.iter().filter(|resource| !self.is_instrument(resource))
    }

    pub(super) fn is_instrument(&self, resource: &Resource) -> bool {
        let places = |it: &Instrument| resource.group == it.group && resource.binding.wrapping_sub(it.binding) < 2;
        self.instrument.as_ref().is_some_and(places)
    }

    /// Returns the fragment or compute entry point of a name, or the only one.
    pub(super) fn entry(&self, name: Option<&str>) -> Result<Point> {
        let runs: Vec<_> = self.points.iter().filter(|point| point.stage != Stage::Vertex).collect();
        let names = || runs.iter().map(|point| point.name.as_str());
        let listed = names().collect::<Vec<_>>().join(", ");
        match (name, runs.as_slice()) {
            (_, []) => Err(Error::unsupported("the shader has no fragment or compute entry point")
                .advise("run the fragment shader that belongs to it")),
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

fn points(module: &naga::Module) -> Vec<Point> {
    let floats = |ty: naga::Handle<naga::Type>| match &module.types[ty].inner {
        naga::TypeInner::Scalar(scalar) if *scalar == naga::Scalar::F32 => Some(1),
        naga::TypeInner::Vector { size, scalar } if *scalar == naga::Scalar::F32 => Some(*size as u32),
        _ => None,
    };
    let located = |ty: naga::Handle<naga::Type>, binding: &Option<naga::Binding>| {
        let mut found = Vec::new();
        let location = |binding: &Option<naga::Binding>| match binding {
            Some(naga::Binding::Location { location, .. }) => Some(*location),
            _ => None,
        };
        found.extend(location(binding).map(|location| (location, floats(ty))));
        if let naga::TypeInner::Struct { members, .. } = &module.types[ty].inner {
            found.extend(members.iter().filter_map(|it| Some((location(&it.binding)?, floats(it.ty)))));
        }
        found
    };
    let stages = [Stage::Vertex, Stage::Fragment, Stage::Compute];
    let point = |entry: &naga::EntryPoint| {
        let stage = stages.into_iter().find(|stage| stage.naga() == entry.stage)?;
        let arguments = entry.function.arguments.iter();
        let inputs = arguments.flat_map(|argument| located(argument.ty, &argument.binding)).collect();
        let outputs = entry.function.result.iter().flat_map(|result| located(result.ty, &result.binding));
        let output = outputs.into_iter().find(|(location, _)| *location == 0).and_then(|(_, floats)| floats);
        Some(Point { name: entry.name.clone(), stage, workgroup: entry.workgroup_size, inputs, output })
    };
    module.entry_points.iter().filter_map(point).collect()
}
