//! A fluid in domains: each rank moves the particles of a part of the z-curve, and has copies of those around it, its halo.
//!
//! The curve goes through the cells of neighbour search, of one lattice for all ranks. At the beginning of a step it is
//! divided into parts with about as many particles each. Every particle goes to the rank of its cell, and as a copy to the
//! ranks of the cells around. Between the passes of a step the copies get the values of their owners.
//!
//! A rank receives particles in the order in which they are along the curve of the step before, so that sums go over
//! neighbours in the order of an undivided fluid. Ranks find the same lists of copies on both sides, because these follow
//! from cells alone: no indices are sent.

use std::time::Instant;

use glam::{DVec3, IVec3, Vec3, Vec4, Vec4Swizzles};
use relievo_core::{Error, Result};

use crate::solver::cells::Cells;
use crate::solver::particles::Particles;
use crate::solver::pcisph::Excess;
use crate::solver::transport::Transport;

/// Keys that each rank contributes to the division of the curve, at most.
const SAMPLES: usize = 512;

/// What a domain sent to others so far.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Traffic {
    /// Exchanges between all ranks.
    pub exchanges: u64,
    /// Bytes of particles that changed their rank, and of new copies.
    pub migrated: u64,
    /// Bytes of particles for states of the whole fluid.
    pub collected: u64,
    /// Bytes of values of copies.
    pub refreshed: u64,
    /// Bytes of sums, maxima and the division of the curve.
    pub reduced: u64,
    /// Seconds in exchanges, with the waiting for other ranks.
    pub seconds: f64,
    /// Particles that this rank owns, in the last step.
    pub owned: usize,
    /// Copies of particles of other ranks, in the last step.
    pub copies: usize,
}

/// The part of a fluid that this rank has; all of it where there is no transport.
#[derive(Default)]
pub struct Domain {
    transport: Option<Box<dyn Transport>>,
    /// The first key of each rank but the first.
    bounds: Vec<u64>,
    /// Whether each row is a copy; empty between steps.
    ghosts: Vec<bool>,
    /// Rows that each rank has copies of, and copies that each rank owns.
    sent: Vec<Vec<u32>>,
    received: Vec<Vec<u32>>,
    /// The speed of the fastest particle of all domains, in m/s.
    fastest: f32,
    traffic: Traffic,
}

/// The kind of what is exchanged.
#[derive(Clone, Copy)]
enum Kind {
    Migrated,
    Collected,
    Refreshed,
    Reduced,
}

impl Domain {
    /// Takes a part of a fluid whose fastest particle has a speed in m/s.
    pub fn new(transport: Box<dyn Transport>, fastest: f32) -> Self {
        Self { transport: Some(transport), fastest, ..Self::default() }
    }

    /// Whether this is all of the fluid.
    pub fn is_whole(&self) -> bool {
        self.transport.is_none()
    }

    /// Returns the speed of the fastest particle of all domains; `None` where this is all of the fluid.
    pub fn fastest(&self) -> Option<f32> {
        self.transport.as_ref().map(|_| self.fastest)
    }

    /// Notes the speed of the fastest particle of all domains.
    pub fn set_fastest(&mut self, speed: f32) {
        self.fastest = speed;
    }

    /// Returns what was sent.
    pub fn traffic(&self) -> Traffic {
        self.traffic
    }

    /// Returns for each row whether it is a copy; empty where none is.
    pub fn ghosts(&self) -> &[bool] {
        &self.ghosts
    }

    /// Returns which of so many particles of the whole fluid this rank begins with: a range of their list.
    pub fn share(&self, count: usize) -> std::ops::Range<usize> {
        match &self.transport {
            None => 0..count,
            Some(transport) => {
                let [rank, ranks] = [transport.rank(), transport.ranks()];
                rank * count / ranks..(rank + 1) * count / ranks
            }
        }
    }

    /// Fails unless this is all of the fluid.
    pub fn expect_whole(&self, what: &str) -> Result<()> {
        match self.is_whole() {
            true => Ok(()),
            false => Err(Error::unsupported(format!("{what} where a fluid is split into domains"))
                .advise("simulate it in one process")),
        }
    }

    /// Whether this rank has what is last in the order of all particles.
    pub fn is_last(&self) -> bool {
        self.transport.as_ref().is_none_or(|transport| transport.rank() + 1 == transport.ranks())
    }

    /// Returns the sum of a count over all domains.
    pub fn count(&mut self, own: usize) -> Result<usize> {
        let mut numbers = [own as f64];
        self.sum(&mut numbers)?;
        Ok(numbers[0] as usize)
    }

    /// Replaces numbers by their sums over all domains.
    pub fn sum(&mut self, numbers: &mut [f64]) -> Result<()> {
        if self.is_whole() {
            return Ok(());
        }
        let all = self.gather(bytemuck::cast_slice(numbers).to_vec())?;
        numbers.fill(0.0);
        for message in all {
            let theirs = read::<f64>(&message, numbers.len())?;
            numbers.iter_mut().zip(theirs).for_each(|(sum, number)| *sum += number);
        }
        Ok(())
    }

    /// Replaces flags by whether all domains have them.
    pub fn all(&mut self, flags: &mut [bool]) -> Result<()> {
        if self.is_whole() {
            return Ok(());
        }
        for message in self.gather(flags.iter().map(|flag| u8::from(*flag)).collect())? {
            let theirs = read::<u8>(&message, flags.len())?;
            flags.iter_mut().zip(theirs).for_each(|(all, flag)| *all &= flag != 0);
        }
        Ok(())
    }

    /// Replaces vectors by their sums over all domains.
    pub fn sum_vectors<'a>(&mut self, vectors: impl Iterator<Item = &'a mut DVec3>) -> Result<()> {
        if self.is_whole() {
            return Ok(());
        }
        let vectors: Vec<&mut DVec3> = vectors.collect();
        let mut numbers: Vec<f64> = vectors.iter().flat_map(|vector| vector.to_array()).collect();
        self.sum(&mut numbers)?;
        vectors.into_iter().zip(numbers.as_chunks::<3>().0).for_each(|(vector, sum)| *vector = DVec3::from(*sum));
        Ok(())
    }

    /// Replaces numbers by the greatest of all domains; what is not a number is greater than any.
    pub fn most<const N: usize>(&mut self, numbers: [f32; N]) -> Result<[f32; N]> {
        if self.is_whole() {
            return Ok(numbers);
        }
        let mut most = numbers;
        for message in self.gather(bytemuck::cast_slice(&numbers).to_vec())? {
            for (most, number) in most.iter_mut().zip(read::<f32>(&message, N)?) {
                *most = if number > *most || number.is_nan() { number } else { *most };
            }
        }
        Ok(most)
    }

    /// Turns the sums of excesses over so many rows into means over the particles of all domains, and has the greatest of
    /// all. Copies are less dense than at rest, so that they add nothing.
    pub fn mean<const N: usize>(&mut self, excess: [Excess; N], rows: usize) -> Result<[Excess; N]> {
        if self.is_whole() {
            let count = rows.max(1) as f32;
            return Ok(excess.map(|excess| Excess { mean: excess.mean / count, ..excess }));
        }
        let owned = rows - self.ghosts.iter().filter(|ghost| **ghost).count();
        let own: Vec<f64> =
            excess.iter().flat_map(|excess| [excess.most, excess.mean]).map(f64::from).chain([owned as f64]).collect();
        let (mut most, mut sums, mut count) = ([0.0f64; N], [0.0f64; N], 0.0);
        for message in self.gather(bytemuck::cast_slice(&own).to_vec())? {
            let theirs: Vec<f64> = read(&message, own.len())?.collect();
            for kind in 0..N {
                let (number, sum) = (theirs[2 * kind], theirs[2 * kind + 1]);
                most[kind] = if number > most[kind] || number.is_nan() { number } else { most[kind] };
                sums[kind] += sum;
            }
            count += theirs[2 * N];
        }
        let count = count.max(1.0) as f32;
        Ok(std::array::from_fn(|kind| Excess { most: most[kind] as f32, mean: sums[kind] as f32 / count }))
    }

    /// Returns the box around the particles of all domains, of the box around those of this one.
    pub fn bounds(&mut self, own: Option<(Vec3, Vec3)>) -> Result<Option<(Vec3, Vec3)>> {
        if self.is_whole() {
            return Ok(own);
        }
        let (low, high) = own.unwrap_or((Vec3::INFINITY, Vec3::NEG_INFINITY));
        let [x, y, z] = (-low).to_array();
        let [a, b, c] = high.to_array();
        let most = self.most([x, y, z, a, b, c])?;
        let (low, high) = (-Vec3::new(most[0], most[1], most[2]), Vec3::new(most[3], most[4], most[5]));
        Ok((low.x <= high.x).then_some((low, high)))
    }

    /// Divides the curve through cells, and has each rank own the particles of its part, with copies of those in the cells
    /// around it.
    pub fn divide(&mut self, cells: &Cells, particles: &mut Particles) -> Result<()> {
        let Some(transport) = &self.transport else { return Ok(()) };
        let ranks = transport.ranks();
        let places = &particles.places[..particles.len()];
        let keys: Vec<u64> = places.iter().map(|place| cells.key(cells.cell(place.xyz()))).collect();
        self.cut(&keys, ranks)?;
        let mut rows: Vec<Vec<u32>> = vec![Vec::new(); ranks];
        let (mut last, mut near) = (None, Vec::new());
        for (row, (place, key)) in (0u32..).zip(places.iter().zip(&keys)) {
            if last != Some(*key) {
                last = Some(*key);
                self.ranks_around(cells, cells.cell(place.xyz()), &mut near);
            }
            near.iter().for_each(|rank| rows[*rank].push(row));
        }
        let messages = rows.iter().map(|rows| particles.pack(rows)).collect();
        let received = self.exchange(messages, Kind::Migrated)?;
        particles.unpack(&received)
    }

    /// Finds the copies, and the rows that others have copies of, after the particles were sorted.
    pub fn list(&mut self, cells: &Cells, particles: &Particles) {
        let Some(transport) = &self.transport else { return };
        let [own, ranks] = [transport.rank(), transport.ranks()];
        [&mut self.sent, &mut self.received].into_iter().for_each(|lists| {
            lists.resize_with(ranks, Vec::new);
            lists.iter_mut().for_each(Vec::clear);
        });
        self.ghosts.clear();
        let places = &particles.places[..particles.len()];
        let (mut last, mut near, mut owner) = (None, Vec::new(), own);
        for (row, place) in (0u32..).zip(places) {
            let cell = cells.cell(place.xyz());
            let key = cells.key(cell);
            if last != Some(key) {
                last = Some(key);
                owner = self.owner(key);
                self.ranks_around(cells, cell, &mut near);
            }
            self.ghosts.push(owner != own);
            if owner == own {
                near.iter().filter(|rank| **rank != own).for_each(|rank| self.sent[*rank].push(row));
            } else {
                self.received[owner].push(row);
            }
        }
        let copies = self.ghosts.iter().filter(|ghost| **ghost).count();
        (self.traffic.owned, self.traffic.copies) = (places.len() - copies, copies);
    }

    /// Gives copies the rows of their owners.
    pub fn refresh(&mut self, rows: &mut [Vec4]) -> Result<()> {
        self.renew(rows, |row| *row, |row, value| *row = value)
    }

    /// Gives copies the fourth numbers of the rows of their owners.
    pub fn refresh_last(&mut self, rows: &mut [Vec4]) -> Result<()> {
        self.renew(rows, |row| row.w, |row, value| row.w = value)
    }

    /// Removes the copies.
    pub fn drop_copies(&mut self, particles: &mut Particles) {
        if !self.ghosts.is_empty() {
            let ghosts = std::mem::take(&mut self.ghosts);
            particles.remove(|row| ghosts[row]);
        }
    }

    /// Sends the particles of all domains to rank 0, where all of them are returned in the order of an undivided fluid.
    pub fn collect(&mut self, particles: &Particles) -> Result<Option<Particles>> {
        let Some(transport) = &self.transport else { return Ok(None) };
        let [rank, ranks] = [transport.rank(), transport.ranks()];
        let all: Vec<u32> = (0..particles.len() as u32).collect();
        let mut own = particles.pack(&all);
        let mut received = Vec::new();
        // One rank after the other, since MPI counts the bytes of an exchange in 31 bits.
        for sender in 0..ranks {
            let mut messages = vec![Vec::new(); ranks];
            if sender == rank {
                messages[0] = std::mem::take(&mut own);
            }
            received.push(std::mem::take(&mut self.exchange(messages, Kind::Collected)?[sender]));
        }
        if rank > 0 {
            return Ok(None);
        }
        let mut whole = particles.emptied();
        whole.unpack(&received)?;
        Ok(Some(whole))
    }

    fn renew<T: bytemuck::Pod>(
        &mut self,
        rows: &mut [Vec4],
        value: impl Fn(&Vec4) -> T,
        put: impl Fn(&mut Vec4, T),
    ) -> Result<()> {
        if self.is_whole() {
            return Ok(());
        }
        let message = |list: &Vec<u32>| {
            let values: Vec<T> = list.iter().map(|row| value(&rows[*row as usize])).collect();
            bytemuck::cast_slice(&values).to_vec()
        };
        let messages = self.sent.iter().map(message).collect();
        let received = self.exchange(messages, Kind::Refreshed)?;
        for (list, message) in self.received.iter().zip(&received) {
            for (row, value) in list.iter().zip(read::<T>(message, list.len())?) {
                put(&mut rows[*row as usize], value);
            }
        }
        Ok(())
    }

    /// Divides the curve where as many particles are before as behind, by keys that stand for those of each rank.
    fn cut(&mut self, keys: &[u64], ranks: usize) -> Result<()> {
        let mut sorted = keys.to_vec();
        sorted.sort_unstable();
        let samples = sorted.len().min(SAMPLES);
        let own =
            std::iter::once(sorted.len() as u64).chain((0..samples).map(|at| sorted[at * sorted.len() / samples]));
        let own: Vec<u64> = own.collect();
        let mut weighted: Vec<(u64, f64)> = Vec::new();
        for message in self.gather(bytemuck::cast_slice(&own).to_vec())? {
            let mut theirs = read::<u64>(&message, message.len() / 8)?;
            let count = theirs.next().ok_or_else(damaged)?;
            let keys: Vec<u64> = theirs.collect();
            let weight = count as f64 / keys.len().max(1) as f64;
            weighted.extend(keys.into_iter().map(|key| (key, weight)));
        }
        weighted.sort_unstable_by(|a, b| a.0.cmp(&b.0).then(a.1.total_cmp(&b.1)));
        let total: f64 = weighted.iter().map(|(_, weight)| weight).sum();
        self.bounds.clear();
        let mut sum = 0.0;
        for (key, weight) in weighted {
            while self.bounds.len() + 1 < ranks && sum >= total * (self.bounds.len() + 1) as f64 / ranks as f64 {
                self.bounds.push(key);
            }
            sum += weight;
        }
        self.bounds.resize(ranks - 1, u64::MAX);
        Ok(())
    }

    /// Returns the rank that owns the cell with a key.
    fn owner(&self, key: u64) -> usize {
        self.bounds.partition_point(|bound| *bound <= key)
    }

    /// Lists the ranks that own a cell or one of those around it.
    fn ranks_around(&self, cells: &Cells, cell: IVec3, ranks: &mut Vec<usize>) {
        ranks.clear();
        for step in 0..27 {
            let key = cells.key(cell + IVec3::new(step % 3, step / 3 % 3, step / 9) - 1);
            let owner = self.owner(key);
            if !ranks.contains(&owner) {
                ranks.push(owner);
            }
        }
    }

    fn gather(&mut self, own: Vec<u8>) -> Result<Vec<Vec<u8>>> {
        self.counted(Kind::Reduced, |transport| {
            let bytes = (own.len() * (transport.ranks() - 1)) as u64;
            Ok((transport.gather(own)?, bytes))
        })
    }

    fn exchange(&mut self, messages: Vec<Vec<u8>>, kind: Kind) -> Result<Vec<Vec<u8>>> {
        self.counted(kind, |transport| {
            let own = transport.rank();
            let sent = messages.iter().enumerate().filter(|(rank, _)| *rank != own).map(|(_, message)| message.len());
            let bytes = sent.sum::<usize>() as u64;
            Ok((transport.exchange(messages)?, bytes))
        })
    }

    /// Calls the transport and counts what is sent.
    fn counted(
        &mut self,
        kind: Kind,
        call: impl FnOnce(&mut dyn Transport) -> Result<(Vec<Vec<u8>>, u64)>,
    ) -> Result<Vec<Vec<u8>>> {
        let Some(transport) = &mut self.transport else { return Ok(Vec::new()) };
        let begin = Instant::now();
        let (received, bytes) = call(transport.as_mut())?;
        if received.len() != transport.ranks() {
            return Err(damaged());
        }
        self.traffic.seconds += begin.elapsed().as_secs_f64();
        self.traffic.exchanges += 1;
        let sum = match kind {
            Kind::Migrated => &mut self.traffic.migrated,
            Kind::Collected => &mut self.traffic.collected,
            Kind::Refreshed => &mut self.traffic.refreshed,
            Kind::Reduced => &mut self.traffic.reduced,
        };
        *sum += bytes;
        Ok(received)
    }
}

/// Returns the numbers of a message. Fails if there are not so many.
pub fn read<T: bytemuck::Pod>(message: &[u8], count: usize) -> Result<impl Iterator<Item = T>> {
    if message.len() != count.saturating_mul(size_of::<T>()) {
        return Err(damaged());
    }
    Ok(message.chunks_exact(size_of::<T>()).map(bytemuck::pod_read_unaligned))
}

/// Returns the error of a message that is not what it should be.
pub fn damaged() -> Error {
    Error::invalid("a message of another domain does not fit")
        .advise("run the same program with the same fluid on all ranks")
}
