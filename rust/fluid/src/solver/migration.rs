//! Particles as messages between domains: a count, and then each list of numbers in the order of the rows.

use bytemuck::{Pod, bytes_of};
use glam::Vec4;
use relievo_core::Result;

use crate::solver::domain::{damaged, read};
use crate::solver::neighbours::NOWHERE;
use crate::solver::particles::{MAX, Particles, too_many};

impl Particles {
    /// Returns the message with some rows.
    pub fn pack(&self, rows: &[u32]) -> Vec<u8> {
        let mut message = (rows.len() as u64).to_le_bytes().to_vec();
        append(&mut message, rows, &self.places, 1);
        append(&mut message, rows, &self.velocities, 1);
        append(&mut message, rows, &self.pushes, 1);
        append(&mut message, rows, &self.pressures, 1);
        append(&mut message, rows, &self.numbers, 1);
        append(&mut message, rows, &self.births, 1);
        append(&mut message, rows, &self.lifetimes, 1);
        for channel in &self.channels {
            append(&mut message, rows, &channel.values, channel.width);
        }
        message
    }

    /// Takes the rows of messages in their order, instead of those before. Fails if one does not fit; the particles are then
    /// in no order to go on from.
    pub fn unpack(&mut self, messages: &[Vec<u8>]) -> Result<()> {
        let mut readers = Vec::new();
        for message in messages {
            let (count, rest) = message.split_first_chunk().ok_or_else(damaged)?;
            let count = u64::from_le_bytes(*count);
            let count = usize::try_from(count).ok().filter(|count| *count <= MAX).ok_or_else(too_many)?;
            readers.push(Reader { count, rest });
        }
        self.places.clear();
        self.velocities.clear();
        take(&mut readers, &mut self.places, 1)?;
        take(&mut readers, &mut self.velocities, 1)?;
        self.places.push(NOWHERE);
        self.velocities.push(Vec4::ZERO);
        replace(&mut readers, &mut self.pushes, 1)?;
        replace(&mut readers, &mut self.pressures, 1)?;
        replace(&mut readers, &mut self.numbers, 1)?;
        replace(&mut readers, &mut self.births, 1)?;
        replace(&mut readers, &mut self.lifetimes, 1)?;
        for channel in &mut self.channels {
            replace(&mut readers, &mut channel.values, channel.width)?;
        }
        match readers.iter().all(|reader| reader.rest.is_empty()) {
            true => Ok(()),
            false => Err(damaged()),
        }
    }
}

/// What is left of a message.
struct Reader<'a> {
    count: usize,
    rest: &'a [u8],
}

fn append<T: Pod>(message: &mut Vec<u8>, rows: &[u32], values: &[T], width: usize) {
    message.reserve(rows.len() * width * size_of::<T>());
    for row in rows {
        let first = *row as usize * width;
        values[first..first + width].iter().for_each(|value| message.extend_from_slice(bytes_of(value)));
    }
}

fn replace<T: Pod>(readers: &mut [Reader], values: &mut Vec<T>, width: usize) -> Result<()> {
    values.clear();
    take(readers, values, width)
}

fn take<T: Pod>(readers: &mut [Reader], values: &mut Vec<T>, width: usize) -> Result<()> {
    for reader in readers {
        let count = reader.count * width;
        let (taken, rest) = reader.rest.split_at_checked(count * size_of::<T>()).ok_or_else(damaged)?;
        reader.rest = rest;
        values.extend(read::<T>(taken, count)?);
    }
    Ok(())
}
