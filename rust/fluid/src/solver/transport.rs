//! Messages between the domains of a fluid.

use std::sync::mpsc::{Receiver, Sender, channel};
use std::sync::{Mutex, PoisonError};

use relievo_core::{Error, ErrorKind, Result};

/// Carries messages between the domains of a fluid, one of which each rank has. All ranks call the same functions in the
/// same order; each call waits for the messages of the others.
pub trait Transport: Send + Sync {
    /// Returns the number of this rank, from 0.
    fn rank(&self) -> usize;

    /// Returns how many ranks there are.
    fn ranks(&self) -> usize;

    /// Sends a message to each rank, in the order of ranks, and returns the messages that each sent to this one.
    /// Messages may be empty, also for most pairs of ranks.
    ///
    /// # Errors
    /// Fails if a rank has ended.
    fn exchange(&mut self, sent: Vec<Vec<u8>>) -> Result<Vec<Vec<u8>>>;

    /// Sends a message to all ranks and returns the messages of all, in the order of ranks.
    ///
    /// # Errors
    /// Fails if a rank has ended.
    fn gather(&mut self, own: Vec<u8>) -> Result<Vec<Vec<u8>>> {
        self.exchange(vec![own; self.ranks()])
    }
}

/// Carries messages between threads of a process.
pub struct InProcess {
    rank: usize,
    senders: Vec<Sender<Vec<u8>>>,
    /// A lock makes them shareable; nobody waits for it.
    receivers: Vec<Mutex<Receiver<Vec<u8>>>>,
}

impl InProcess {
    /// Returns the transports of so many ranks, in their order. A rank whose transport is dropped has ended.
    pub fn new(ranks: usize) -> Vec<Self> {
        let mut all: Vec<Self> =
            (0..ranks).map(|rank| Self { rank, senders: Vec::new(), receivers: Vec::new() }).collect();
        for from in 0..ranks {
            for to in 0..ranks {
                let (sender, receiver) = channel();
                all[from].senders.push(sender);
                all[to].receivers.push(Mutex::new(receiver));
            }
        }
        all
    }
}

impl Transport for InProcess {
    fn rank(&self) -> usize {
        self.rank
    }

    fn ranks(&self) -> usize {
        self.senders.len()
    }

    fn exchange(&mut self, sent: Vec<Vec<u8>>) -> Result<Vec<Vec<u8>>> {
        if sent.len() != self.senders.len() {
            let (given, ranks) = (sent.len(), self.senders.len());
            return Err(Error::internal(format!("{given} messages are given for {ranks} ranks")));
        }
        for (rank, (sender, message)) in self.senders.iter().zip(sent).enumerate() {
            sender.send(message).map_err(|_| ended(rank))?;
        }
        let receivers = self.receivers.iter_mut().enumerate();
        receivers
            .map(|(rank, receiver)| {
                receiver.get_mut().unwrap_or_else(PoisonError::into_inner).recv().map_err(|_| ended(rank))
            })
            .collect()
    }
}

fn ended(rank: usize) -> Error {
    Error::new(ErrorKind::Io, "a domain of the fluid has ended")
        .at(format!("rank {rank}"))
        .advise("read its own message; then go on from the last frame")
}
