//! Arrays of numbers in the buffers of a glTF file (glTF 2.0, Section 3.6.2), sparse ones included.

use gltf::json::accessor::{Accessor, ComponentType, GenericComponentType, IndexComponentType, Type};
use relievo_core::{Error, Result};

use super::container::{Container, understood};
use crate::budget::Budget;

/// What is wanted of an array.
pub(crate) struct Wanted<'a> {
    /// The shapes its elements may have.
    pub shapes: &'a [Type],
    /// How many elements it must have, if that is known. Only then may it be without bytes, which means zeros.
    pub count: Option<usize>,
}

/// The elements of an array as floats, normalised where the file says so.
pub(crate) fn floats(file: &Container, budget: &mut Budget, index: usize, wanted: &Wanted) -> Result<(Vec<f32>, Type)> {
    let place = |error: Error| error.at(format!("accessor {index}"));
    let accessor = find(file, index)?;
    let kind = understood(&accessor.component_type, "component type").map_err(place)?.0;
    let decode: fn([u8; 4]) -> f32 = match (kind, accessor.normalized) {
        (ComponentType::F32, _) => f32::from_le_bytes,
        (ComponentType::I8, false) => |bytes| f32::from(bytes[0] as i8),
        (ComponentType::I8, true) => |bytes| (f32::from(bytes[0] as i8) / 127.0).max(-1.0),
        (ComponentType::U8, false) => |bytes| f32::from(bytes[0]),
        (ComponentType::U8, true) => |bytes| f32::from(bytes[0]) / 255.0,
        (ComponentType::I16, false) => |bytes| f32::from(i16::from_le_bytes([bytes[0], bytes[1]])),
        (ComponentType::I16, true) => |bytes| (f32::from(i16::from_le_bytes([bytes[0], bytes[1]])) / 32767.0).max(-1.0),
        (ComponentType::U16, false) => |bytes| f32::from(u16::from_le_bytes([bytes[0], bytes[1]])),
        (ComponentType::U16, true) => |bytes| f32::from(u16::from_le_bytes([bytes[0], bytes[1]])) / 65535.0,
        (ComponentType::U32, _) => |bytes| u32::from_le_bytes(bytes) as f32,
    };
    let (values, shape) = read(file, budget, accessor, wanted, decode).map_err(place)?;
    if let Some(at) = values.iter().position(|value| !value.is_finite()) {
        let error = Error::invalid("a number is not finite").advise("repair it and export again");
        return Err(place(error.at(format!("element {}", at / shape.multiplicity()))));
    }
    Ok((values, shape))
}

/// The elements of an array as unsigned whole numbers.
pub(crate) fn integers(file: &Container, budget: &mut Budget, index: usize, wanted: &Wanted) -> Result<Vec<u32>> {
    let place = |error: Error| error.at(format!("accessor {index}"));
    let accessor = find(file, index)?;
    let decode: fn([u8; 4]) -> u32 = match understood(&accessor.component_type, "component type").map_err(place)?.0 {
        ComponentType::U8 | ComponentType::U16 | ComponentType::U32 => u32::from_le_bytes,
        _ => return Err(place(Error::invalid("its numbers are not unsigned").advise("use unsigned whole numbers"))),
    };
    Ok(read(file, budget, accessor, wanted, decode).map_err(place)?.0)
}

fn find<'a>(file: &'a Container, index: usize) -> Result<&'a Accessor> {
    file.json.accessors.get(index).ok_or_else(|| Error::invalid(format!("accessor {index} does not exist")))
}

fn read<T: Copy + Default>(
    file: &Container,
    budget: &mut Budget,
    accessor: &Accessor,
    wanted: &Wanted,
    decode: fn([u8; 4]) -> T,
) -> Result<(Vec<T>, Type)> {
    let shape = understood(&accessor.type_, "type")?;
    let GenericComponentType(kind) = understood(&accessor.component_type, "component type")?;
    if !wanted.shapes.contains(&shape) {
        return Err(Error::invalid(format!("its elements are {shape:?}")).advise(format!("use {:?}", wanted.shapes)));
    }
    let count = usize::try_from(accessor.count.0).map_err(|_| Error::invalid("its count is too large"))?;
    if wanted.count.is_some_and(|wanted| wanted != count) {
        let what = format!("it has {count} elements instead of {}", wanted.count.unwrap_or_default());
        return Err(Error::invalid(what).advise("attributes of a primitive have equally many"));
    }
    let width = shape.multiplicity();
    let mut values = Vec::new();
    match accessor.buffer_view {
        Some(view) => {
            let offset = accessor.byte_offset.unwrap_or_default().0;
            let source = Source::new(file, view.value(), offset, kind, width, count)?;
            budget.reserve(&mut values, count.saturating_mul(width))?;
            source.each(|_, bytes| values.push(decode(bytes)));
        }
        // Zeros take no bytes of the file, so that only a count known from elsewhere can be trusted.
        None if wanted.count.is_some() => values = budget.filled(count.saturating_mul(width), T::default())?,
        None => return Err(Error::invalid("it has no bytes").advise("give it a buffer view")),
    }
    if let Some(sparse) = &accessor.sparse {
        let changed = usize::try_from(sparse.count.0).ok().filter(|changed| *changed <= count);
        let changed = changed.ok_or_else(|| Error::invalid("its sparse count is larger than its count"))?;
        let IndexComponentType(index_kind) = understood(&sparse.indices.component_type, "sparse index type")?;
        let offset = sparse.indices.byte_offset.0;
        let source = Source::new(file, sparse.indices.buffer_view.value(), offset, index_kind, 1, changed)?;
        let mut places = Vec::new();
        budget.reserve(&mut places, changed)?;
        source.each(|_, bytes| places.push(u32::from_le_bytes(bytes)));
        if let Some(place) = places.iter().find(|place| **place as usize >= count) {
            return Err(Error::invalid(format!("its sparse element {place} does not exist")));
        }
        let offset = sparse.values.byte_offset.0;
        let source = Source::new(file, sparse.values.buffer_view.value(), offset, kind, width, changed)?;
        source.each(|at, bytes| values[places[at / width] as usize * width + at % width] = decode(bytes));
    }
    Ok((values, shape))
}

/// The bytes of an array, checked to be there.
struct Source<'a> {
    bytes: &'a [u8],
    stride: usize,
    size: usize,
    width: usize,
    count: usize,
}

impl<'a> Source<'a> {
    fn new(
        file: &'a Container,
        view: usize,
        offset: u64,
        kind: ComponentType,
        width: usize,
        count: usize,
    ) -> Result<Self> {
        let (bytes, stride) = file.view(view)?;
        let size = kind.size();
        let element = size * width;
        let stride = stride.unwrap_or(element);
        if stride < element {
            return Err(Error::invalid(format!("its stride {stride} is less than an element's {element} bytes"))
                .advise("export the file again"));
        }
        let bytes = usize::try_from(offset).ok().and_then(|offset| bytes.get(offset..));
        let needed = count.checked_sub(1).map_or(Some(0), |last| last.checked_mul(stride)?.checked_add(element));
        match (bytes, needed) {
            (Some(bytes), Some(needed)) if needed <= bytes.len() => Ok(Self { bytes, stride, size, width, count }),
            _ => Err(Error::invalid(format!("its {count} elements leave buffer view {view}"))
                .advise("the file is cut off; export it again")),
        }
    }

    /// Calls `work` for every number, with its bytes filled up to four.
    #[inline]
    fn each(&self, mut work: impl FnMut(usize, [u8; 4])) {
        for index in 0..self.count {
            let element = &self.bytes[index * self.stride..][..self.size * self.width];
            for (component, number) in element.chunks_exact(self.size).enumerate() {
                let mut bytes = [0; 4];
                bytes[..self.size].copy_from_slice(number);
                work(index * self.width + component, bytes);
            }
        }
    }
}
