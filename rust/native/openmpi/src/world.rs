//! All ranks, and what they exchange.

use std::ffi::c_int;

use relievo_core::{Error, Result};

// SAFETY: the declarations are those of `cpp/openmpi/world.c`.
unsafe extern "C" {
    fn relievo_mpi_start(rank: *mut c_int, ranks: *mut c_int) -> c_int;
    fn relievo_mpi_finish();
    fn relievo_mpi_abort(code: c_int);
    fn relievo_mpi_exchange_counts(sent: *const c_int, received: *mut c_int);
    fn relievo_mpi_exchange(
        sent: *const u8,
        counts: *const c_int,
        firsts: *const c_int,
        received: *mut u8,
        expected: *const c_int,
        places: *const c_int,
    );
    fn relievo_mpi_gather_counts(own: c_int, received: *mut c_int);
    fn relievo_mpi_gather(
        own: *const u8,
        count: c_int,
        received: *mut u8,
        expected: *const c_int,
        places: *const c_int,
    );
}

/// All ranks of a run, from MPI's initialisation to its end. Calls are made by one thread at a time, and by all ranks in
/// the same order.
#[derive(Debug)]
pub struct World {
    rank: usize,
    ranks: usize,
}

impl World {
    /// Initialises MPI.
    ///
    /// # Errors
    /// MPI was initialised before, or cannot be used beside threads that do not call it.
    pub fn start() -> Result<Self> {
        let (mut rank, mut ranks) = (0, 0);
        // SAFETY: both numbers can be written.
        let is_started = unsafe { relievo_mpi_start(&mut rank, &mut ranks) } != 0;
        match (is_started, usize::try_from(rank), usize::try_from(ranks)) {
            (true, Ok(rank), Ok(ranks)) if rank < ranks => Ok(Self { rank, ranks }),
            _ => Err(Error::unsupported("MPI cannot be initialised")
                .advise("start the program by mpirun, once in a process")),
        }
    }

    /// Returns the number of this rank, from 0.
    pub fn rank(&self) -> usize {
        self.rank
    }

    /// Returns how many ranks there are.
    pub fn ranks(&self) -> usize {
        self.ranks
    }

    /// Ends all ranks with an exit code.
    pub fn abort(&self, code: i32) -> ! {
        // SAFETY: MPI is initialised as long as there is a world.
        unsafe { relievo_mpi_abort(code) };
        std::process::abort()
    }

    /// Sends messages, one for each rank in their order, and returns the messages that each rank sent here.
    ///
    /// # Errors
    /// There is not one message for each rank, or those of a rank are 2 GiB or more together.
    pub fn exchange(&mut self, sent: &[Vec<u8>]) -> Result<Vec<Vec<u8>>> {
        if sent.len() != self.ranks {
            let (given, ranks) = (sent.len(), self.ranks);
            return Err(Error::internal(format!("{given} messages are given for {ranks} ranks")));
        }
        let counts: Vec<c_int> = sent.iter().map(|message| count(message)).collect::<Result<_>>()?;
        let firsts = firsts(&counts)?;
        let mut expected: Vec<c_int> = vec![0; self.ranks];
        // SAFETY: both lists have a number for each rank, and MPI is initialised.
        unsafe { relievo_mpi_exchange_counts(counts.as_ptr(), expected.as_mut_ptr()) };
        let places = self::firsts(&expected)?;
        let (sent, mut received) = (sent.concat(), vec![0u8; total(&expected)?]);
        // SAFETY: the lists have a number for each rank, parts lie within the bytes that `firsts` and `total` were made of, and
        // the counts that are expected are the ones that the other ranks send.
        unsafe {
            relievo_mpi_exchange(
                start(&sent),
                counts.as_ptr(),
                firsts.as_ptr(),
                start_mut(&mut received),
                expected.as_ptr(),
                places.as_ptr(),
            );
        }
        Ok(split(&received, &expected))
    }

    /// Sends a message to all ranks and returns those of all in the order of ranks.
    ///
    /// # Errors
    /// The messages are 2 GiB or more together.
    pub fn gather(&mut self, own: &[u8]) -> Result<Vec<Vec<u8>>> {
        let count = count(own)?;
        let mut expected: Vec<c_int> = vec![0; self.ranks];
        // SAFETY: the list has a number for each rank, and MPI is initialised.
        unsafe { relievo_mpi_gather_counts(count, expected.as_mut_ptr()) };
        let places = firsts(&expected)?;
        let mut received = vec![0u8; total(&expected)?];
        // SAFETY: as in `exchange`.
        unsafe {
            relievo_mpi_gather(start(own), count, start_mut(&mut received), expected.as_ptr(), places.as_ptr());
        }
        Ok(split(&received, &expected))
    }
}

impl Drop for World {
    fn drop(&mut self) {
        // SAFETY: MPI is initialised as long as there is a world, and this is its end.
        unsafe { relievo_mpi_finish() };
    }
}

/// Returns where bytes begin. An empty list of Rust may begin at 1, which OpenMPI reads as `MPI_IN_PLACE`.
fn start(bytes: &[u8]) -> *const u8 {
    if bytes.is_empty() { std::ptr::null() } else { bytes.as_ptr() }
}

/// As [`start`], of bytes that are written.
fn start_mut(bytes: &mut [u8]) -> *mut u8 {
    if bytes.is_empty() { std::ptr::null_mut() } else { bytes.as_mut_ptr() }
}

fn too_large() -> Error {
    Error::memory("messages of a rank are 2 GiB or more").advise("take more ranks")
}

fn count(message: &[u8]) -> Result<c_int> {
    c_int::try_from(message.len()).map_err(|_| too_large())
}

/// Returns the sum of counts. Fails if it is more than MPI counts.
fn total(counts: &[c_int]) -> Result<usize> {
    let sum = counts.iter().try_fold(0, |sum: c_int, count| sum.checked_add(*count).filter(|_| *count >= 0));
    sum.and_then(|sum| usize::try_from(sum).ok()).ok_or_else(too_large)
}

/// Returns where each of the parts with these counts begins. Fails as [`total`].
fn firsts(counts: &[c_int]) -> Result<Vec<c_int>> {
    total(counts)?;
    Ok(counts.iter().scan(0, |sum, count| Some(std::mem::replace(sum, *sum + count))).collect())
}

fn split(received: &[u8], counts: &[c_int]) -> Vec<Vec<u8>> {
    let mut rest = received;
    let part = |count: &c_int| {
        let (part, after) = rest.split_at(*count as usize);
        rest = after;
        part.to_vec()
    };
    counts.iter().map(part).collect()
}
