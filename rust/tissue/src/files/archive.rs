//! Model files, `.rtissue`, and states, `.rtstate`.
//!
//! Both begin with eight bytes of name, the version (u32), the number of bytes that follow (u64) and their CRC-32 (u32), all
//! little-endian. A model has its lists one after the other, each with its length (u64) first, and names as UTF-8. A state
//! has the CRC-32 of its model (u32), the instruction level, steps (u64), seconds (f64), and displacements and velocities.

use std::io::Write;
use std::path::Path;

use relievo_core::{Context, Error, Result, file};

use crate::build::binding::{Anchor, Binding};
use crate::material::{Material, Muscle};
use crate::model::{Fibre, Held, Lists, Model, NodeSet, Portion, Shape, Sliding};
use crate::simulation::State;

const MODEL: &[u8; 8] = b"RTISSUE\0";
const STATE: &[u8; 8] = b"RTSTATE\0";
const VERSION: u32 = 1;
/// Bytes of the header, which the checksum does not cover.
const HEADER: usize = 24;

/// A state with the model it is of and the instruction level that made it.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct SavedState {
    /// [`Model::checksum`], or a checksum of all that decides the frames.
    pub identity: u32,
    /// Name of the instruction level; others give other bits.
    pub level: String,
    /// The state.
    pub state: State,
}

impl Model {
    /// Returns the bytes of a model file.
    pub fn encode(&self) -> Vec<u8> {
        let mut out = Writer(Vec::new());
        out.list(&self.nodes, |out, node| out.floats(node));
        out.list(&self.elements, |out, corners| out.numbers(corners));
        out.list(self.cell.as_slice(), |out, cell| out.floats(cell));
        out.list(&self.materials, |out, material| {
            out.text(&material.name);
            out.floats(&[material.density, material.shear, material.bulk]);
        });
        out.list(&self.mixtures.starts, |out, start| out.numbers(&[*start]));
        out.list(&self.mixtures.items, |out, portion| {
            out.numbers(&[portion.material]);
            out.floats(&[portion.share]);
        });
        out.list(&self.muscles, |out, muscle| {
            out.text(&muscle.name);
            out.floats(&[muscle.stiffness, muscle.strength]);
        });
        out.list(&self.fibres.starts, |out, start| out.numbers(&[*start]));
        out.list(&self.fibres.items, |out, fibre| {
            out.numbers(&[fibre.muscle]);
            out.floats(&[fibre.share]);
            out.floats(&fibre.direction);
        });
        out.list(&self.held, |out, held| out.numbers(&[held.node, held.axes]));
        out.list(&self.surfaces, |out, shape| {
            out.text(&shape.name);
            out.list(&shape.points, |out, point| out.floats(point));
            out.list(&shape.triangles, |out, corners| out.numbers(corners));
        });
        out.list(&self.sliding, |out, sliding| {
            out.numbers(&[sliding.node, sliding.surface]);
            out.floats(&[sliding.distance]);
        });
        out.list(&self.sets, |out, set| {
            out.text(&set.name);
            out.list(&set.nodes, |out, node| out.numbers(&[*node]));
        });
        out.list(&self.bindings, |out, binding| {
            out.text(&binding.name);
            out.list(&binding.triangles, |out, corners| out.numbers(corners));
            out.list(&binding.anchors, |out, anchor| {
                out.numbers(&[anchor.element]);
                out.floats(&anchor.weights);
            });
        });
        sealed(MODEL, &out.0)
    }

    /// Returns the model in the bytes of a file.
    ///
    /// # Errors
    /// Fails if the bytes are no model, damaged or of another version, or the model cannot be used ([`Self::check`]).
    pub fn decode(bytes: &[u8]) -> Result<Self> {
        let mut input = opened(MODEL, bytes, "model")?;
        let model = Self {
            nodes: input.list(12, |input| input.floats())?,
            elements: input.list(32, |input| input.numbers())?,
            cell: input.list(12, |input| input.floats())?.first().copied(),
            materials: input.list(20, |input| {
                let name = input.text()?;
                let [density, shear, bulk] = input.floats()?;
                Ok(Material { name, density, shear, bulk })
            })?,
            mixtures: Lists {
                starts: input.list(4, Reader::number)?,
                items: input.list(8, |input| Ok(Portion { material: input.number()?, share: input.float()? }))?,
            },
            muscles: input.list(16, |input| {
                let name = input.text()?;
                let [stiffness, strength] = input.floats()?;
                Ok(Muscle { name, stiffness, strength })
            })?,
            fibres: Lists {
                starts: input.list(4, Reader::number)?,
                items: input.list(20, |input| {
                    Ok(Fibre { muscle: input.number()?, share: input.float()?, direction: input.floats()? })
                })?,
            },
            held: input.list(8, |input| Ok(Held { node: input.number()?, axes: input.number()? }))?,
            surfaces: input.list(24, |input| {
                let name = input.text()?;
                let points = input.list(12, Reader::floats)?;
                Ok(Shape { name, points, triangles: input.list(12, Reader::numbers)? })
            })?,
            sliding: input.list(12, |input| {
                Ok(Sliding { node: input.number()?, surface: input.number()?, distance: input.float()? })
            })?,
            sets: input.list(16, |input| Ok(NodeSet { name: input.text()?, nodes: input.list(4, Reader::number)? }))?,
            bindings: input.list(24, |input| {
                let name = input.text()?;
                let triangles = input.list(12, Reader::numbers)?;
                let anchors =
                    input.list(16, |input| Ok(Anchor { element: input.number()?, weights: input.floats()? }))?;
                Ok(Binding { name, triangles, anchors })
            })?,
        };
        input.end()?;
        model.check()?;
        Ok(model)
    }

    /// Writes a model file. It appears under its name when it is complete.
    ///
    /// # Errors
    /// Fails if the file cannot be written.
    pub fn write(&self, path: &Path) -> Result<()> {
        let bytes = self.encode();
        file::store(path, |out| out.write_all(&bytes))
    }

    /// Reads a model file.
    ///
    /// # Errors
    /// Fails if the file cannot be read or is larger than the memory limit, and as [`Self::decode`].
    pub fn read(context: &Context, path: &Path) -> Result<Self> {
        let bytes = file::load(path, context.memory_limit())?;
        Self::decode(&bytes).map_err(|error| error.at(path.display().to_string()))
    }

    /// Returns the CRC-32 of the model's file.
    pub fn checksum(&self) -> u32 {
        crc32fast::hash(&self.encode()[HEADER..])
    }
}

impl SavedState {
    /// Returns the bytes of a state file.
    pub fn encode(&self) -> Vec<u8> {
        let mut out = Writer(Vec::new());
        out.numbers(&[self.identity]);
        out.text(&self.level);
        out.0.extend(self.state.steps.to_le_bytes());
        out.0.extend(self.state.seconds.to_le_bytes());
        for rows in [&self.state.displacements, &self.state.velocities] {
            out.list(rows, |out, row| out.floats(&row[..3]));
        }
        sealed(STATE, &out.0)
    }

    /// Returns the state in the bytes of a file.
    ///
    /// # Errors
    /// Fails if the bytes are no state, damaged or of another version.
    pub fn decode(bytes: &[u8]) -> Result<Self> {
        let mut input = opened(STATE, bytes, "state")?;
        let identity = input.number()?;
        let level = input.text()?;
        let steps = input.long()?;
        let seconds = f64::from_bits(input.long()?);
        let mut rows = || {
            input.list(12, |input| {
                let [x, y, z] = input.floats()?;
                Ok([x, y, z, 0.0])
            })
        };
        let (displacements, velocities) = (rows()?, rows()?);
        input.end()?;
        Ok(Self { identity, level, state: State { steps, seconds, displacements, velocities } })
    }

    /// Writes a state file. It appears under its name when it is complete.
    ///
    /// # Errors
    /// Fails if the file cannot be written.
    pub fn write(&self, path: &Path) -> Result<()> {
        let bytes = self.encode();
        file::store(path, |out| out.write_all(&bytes))
    }

    /// Reads a state file.
    ///
    /// # Errors
    /// Fails if the file cannot be read or is larger than the memory limit, and as [`Self::decode`].
    pub fn read(context: &Context, path: &Path) -> Result<Self> {
        let bytes = file::load(path, context.memory_limit())?;
        Self::decode(&bytes).map_err(|error| error.at(path.display().to_string()))
    }
}

/// Puts a header before the bytes of a file.
fn sealed(name: &[u8; 8], bytes: &[u8]) -> Vec<u8> {
    let mut out = Vec::with_capacity(HEADER + bytes.len());
    out.extend(name);
    out.extend(VERSION.to_le_bytes());
    out.extend((bytes.len() as u64).to_le_bytes());
    out.extend(crc32fast::hash(bytes).to_le_bytes());
    out.extend(bytes);
    out
}

/// Checks the header of a file and the checksum of the rest.
fn opened<'a>(name: &[u8; 8], bytes: &'a [u8], what: &str) -> Result<Reader<'a>> {
    let mut header = Reader(bytes);
    if header.take(8).ok() != Some(name.as_slice()) {
        return Err(Error::invalid(format!("it is not a {what} of soft tissue"))
            .advise("name a file that `relievo tissue` wrote"));
    }
    let version = header.number()?;
    if version != VERSION {
        return Err(Error::unsupported(format!("its version is {version}")).advise("take the Relievo that wrote it"));
    }
    let (length, checksum) = (header.long()?, header.number()?);
    if length != header.0.len() as u64 || crc32fast::hash(header.0) != checksum {
        return Err(damaged());
    }
    Ok(header)
}

fn damaged() -> Error {
    Error::invalid("the file is damaged").advise("take a copy, or make it anew")
}

struct Writer(Vec<u8>);

impl Writer {
    fn numbers(&mut self, numbers: &[u32]) {
        self.0.extend(numbers.iter().flat_map(|number| number.to_le_bytes()));
    }

    fn floats(&mut self, numbers: &[f32]) {
        self.0.extend(numbers.iter().flat_map(|number| number.to_le_bytes()));
    }

    fn text(&mut self, text: &str) {
        self.0.extend((text.len() as u64).to_le_bytes());
        self.0.extend(text.as_bytes());
    }

    fn list<T>(&mut self, items: &[T], write: impl Fn(&mut Self, &T)) {
        self.0.extend((items.len() as u64).to_le_bytes());
        items.iter().for_each(|item| write(self, item));
    }
}

/// Takes from the front of bytes that may be anything.
struct Reader<'a>(&'a [u8]);

impl<'a> Reader<'a> {
    fn take(&mut self, count: usize) -> Result<&'a [u8]> {
        let (taken, rest) = self.0.split_at_checked(count).ok_or_else(damaged)?;
        self.0 = rest;
        Ok(taken)
    }

    fn array<const N: usize>(&mut self) -> Result<[u8; N]> {
        let (taken, rest) = self.0.split_first_chunk().ok_or_else(damaged)?;
        self.0 = rest;
        Ok(*taken)
    }

    fn number(&mut self) -> Result<u32> {
        self.array().map(u32::from_le_bytes)
    }

    fn long(&mut self) -> Result<u64> {
        self.array().map(u64::from_le_bytes)
    }

    fn float(&mut self) -> Result<f32> {
        self.array().map(f32::from_le_bytes)
    }

    fn numbers<const N: usize>(&mut self) -> Result<[u32; N]> {
        let mut numbers = [0; N];
        for number in &mut numbers {
            *number = self.number()?;
        }
        Ok(numbers)
    }

    fn floats<const N: usize>(&mut self) -> Result<[f32; N]> {
        let mut numbers = [0.0; N];
        for number in &mut numbers {
            *number = self.float()?;
        }
        Ok(numbers)
    }

    fn text(&mut self) -> Result<String> {
        let length = usize::try_from(self.long()?).map_err(|_| damaged())?;
        String::from_utf8(self.take(length)?.to_vec()).map_err(|_| damaged())
    }

    /// A list of items of at least `least` bytes each, which bounds how many there can be.
    fn list<T>(&mut self, least: usize, read: impl Fn(&mut Self) -> Result<T>) -> Result<Vec<T>> {
        let count = usize::try_from(self.long()?).map_err(|_| damaged())?;
        if count > self.0.len() / least {
            return Err(damaged());
        }
        (0..count).map(|_| read(self)).collect()
    }

    fn end(&self) -> Result<()> {
        if self.0.is_empty() { Ok(()) } else { Err(damaged()) }
    }
}
