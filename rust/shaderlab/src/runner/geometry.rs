//! The vertices that a vertex shader is given: their number and the buffers of its inputs.

use relievo_core::{Error, Result};
use relievo_gpu::wgpu::VertexFormat;
use relievo_gpu::{Buffer, Device};

use super::bind::Inputs;
use super::program::Point;
use crate::resource::FieldKind;

/// Vertices, counted anew in each instance, that a runner draws.
pub const MAX_VERTICES: u64 = 1 << 22;

/// What is drawn.
pub(super) struct Geometry {
    /// Vertices of an instance, and instances.
    pub count: [u32; 2],
    /// The inputs of the vertex shader: location, format, bytes of a vertex and buffer.
    pub attributes: Vec<(u32, VertexFormat, u64, Buffer<u8>)>,
}

impl Geometry {
    /// Makes the vertices of a vertex shader.
    ///
    /// Fails if an input has no numbers, if their numbers of vertices differ or are too few, or if there are more than
    /// [`MAX_VERTICES`].
    pub fn new(device: &Device, vertex: &Point, inputs: &Inputs) -> Result<Self> {
        let mut given: Option<(usize, &str)> = None;
        let mut attributes = Vec::new();
        for input in &vertex.inputs {
            let place = || format!("`{}`", input.name);
            let (kind, width) = input.numbers.ok_or_else(|| {
                Error::unsupported("the input of the vertex shader is no number and no vector of numbers").at(place())
            })?;
            let numbers = inputs.numbers.get(&input.name).ok_or_else(|| {
                Error::invalid("the input of the vertex shader has no numbers")
                    .at(place())
                    .advise(format!("give it {width} for each vertex, as for a uniform"))
            })?;
            let count = numbers.len() / width as usize;
            if count * width as usize != numbers.len() {
                let what = format!("there are {} numbers, no multiple of {width}", numbers.len());
                return Err(Error::invalid(what).at(place()).advise(format!("give {width} for each vertex")));
            }
            match given {
                Some((other, name)) if other != count => {
                    let what = format!("there are {count} vertices, and {other} of `{name}`");
                    return Err(Error::invalid(what).at(place()).advise("give all inputs as many vertices"));
                }
                _ => given = Some((count, &input.name)),
            }
            let bytes: Vec<u8> = numbers.iter().flat_map(|number| kind.bytes(*number)).collect();
            let buffer = Buffer::vertices(device, "vertices", bytes.len())?;
            buffer.write(device, 0, &bytes)?;
            attributes.push((input.location, format(kind, width), 4 * u64::from(width), buffer));
        }
        let given = given.map(|(count, _)| count);
        let stated = inputs.vertices.map(|count| count as usize);
        let count = stated.or(given).unwrap_or(3);
        if given.is_some_and(|given| given < count) {
            let what = format!("{count} vertices are to be drawn, and the inputs have {}", given.unwrap_or(0));
            return Err(Error::invalid(what).at("vertices").advise("give the inputs more numbers"));
        }
        let instances = inputs.instances.unwrap_or(1);
        let all = (count as u64).saturating_mul(u64::from(instances));
        if !(1..=MAX_VERTICES).contains(&all) {
            return Err(Error::invalid(format!("there are {count} vertices of {instances} instances"))
                .at("vertices")
                .advise(format!("draw 1 to {MAX_VERTICES}")));
        }
        Ok(Self { count: [count as u32, instances], attributes })
    }

    /// Returns all vertices of all instances.
    pub fn all(&self) -> usize {
        self.count[0] as usize * self.count[1] as usize
    }
}

fn format(kind: FieldKind, width: u32) -> VertexFormat {
    match (kind, width) {
        (FieldKind::Float, 1) => VertexFormat::Float32,
        (FieldKind::Float, 2) => VertexFormat::Float32x2,
        (FieldKind::Float, 3) => VertexFormat::Float32x3,
        (FieldKind::Float, _) => VertexFormat::Float32x4,
        (FieldKind::Signed, 1) => VertexFormat::Sint32,
        (FieldKind::Signed, 2) => VertexFormat::Sint32x2,
        (FieldKind::Signed, 3) => VertexFormat::Sint32x3,
        (FieldKind::Signed, _) => VertexFormat::Sint32x4,
        (FieldKind::Unsigned, 1) => VertexFormat::Uint32,
        (FieldKind::Unsigned, 2) => VertexFormat::Uint32x2,
        (FieldKind::Unsigned, 3) => VertexFormat::Uint32x3,
        (FieldKind::Unsigned, _) => VertexFormat::Uint32x4,
    }
}
