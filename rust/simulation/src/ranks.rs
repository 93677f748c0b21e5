//! A fluid that several processes simulate together, each of them a domain (Morgenroth, Weiskopf, Eberhardt 2013,
//! Section 3).

use std::path::Path;
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::time::Instant;

use relievo_core::{Context, Error, Result};
use relievo_fluid::Transport;

use crate::description::Description;
use crate::files::in_folder;
use crate::rank_folder::Folder;
use crate::rank_report::report;
use crate::simulation::{Making, Simulation};

/// Simulates the description in a file on this rank, while all others of `transport` call this with the same description and
/// the same folder for the frames. Goes on from the last whole frame there. Rank 0 writes the frames, to the bit those of
/// `relievo fluid sim`, and returns a table of what each rank sent.
///
/// # Errors
/// The description or a file cannot be used, frames of another simulation are in the folder, another rank simulates something
/// else or at another instruction level, or another rank has ended.
pub fn simulate_on_rank(
    context: &Context,
    description: &Path,
    output: &Path,
    transport: Box<dyn Transport>,
) -> Result<Option<String>> {
    let mut ranks = Ranks(Arc::new(Mutex::new(transport)));
    let named = |error: Error| error.at(description.display().to_string());
    let files = in_folder(description.parent().unwrap_or(Path::new("")));
    let description = Description::read(description)?;
    let (frames, spacing) = (description.frames, description.spacing());
    let making = Making { format: Folder::FORMAT.extension().into(), parts: 1, device: None };
    let mut simulation = Simulation::begin(context, description, &files, making).map_err(named)?;
    let folder = Folder { path: output, spacing };
    let is_first = ranks.rank() == 0;
    // One rank looks, since frames may appear in the meantime.
    let next = match is_first {
        true => folder.last(context, simulation.identity())?.map_or(0, |step| step + 1),
        false => 0,
    };
    let next = agree(&mut ranks, context.level().name(), simulation.identity(), next)?;
    if next > 0 {
        simulation.restore(folder.read(context, next - 1)?)?;
    } else if is_first {
        folder.write(context, &simulation.checkpoint())?;
    }
    simulation.distribute(Box::new(ranks.clone()))?;
    let (begin, before) = (Instant::now(), simulation.totals().steps);
    while simulation.step() < simulation.last() {
        simulation.advance(context, |_| Ok(()))?;
        if let Some(checkpoint) = simulation.gather()? {
            folder.write(context, &checkpoint)?;
        }
    }
    let totals = simulation.totals();
    let (steps, elapsed) = (totals.steps - before, begin.elapsed().as_secs_f64());
    let table = report(&mut ranks, simulation.fluid().traffic(), steps, elapsed)?;
    let line = format!("{frames} frames in {} steps with {} corrections\n", totals.steps, totals.corrections);
    Ok(is_first.then_some(line + &table))
}

/// Returns the next frame that rank 0 names. Fails if ranks differ in what decides the bits of frames.
fn agree(ranks: &mut Ranks, level: &str, identity: &str, next: u64) -> Result<u64> {
    let own = [next.to_le_bytes().as_slice(), level.as_bytes(), b"\n", identity.as_bytes()].concat();
    let all = ranks.gather(own.clone())?;
    let number = size_of::<u64>();
    if let Some(rank) = all.iter().position(|theirs| theirs.get(number..) != Some(&own[number..])) {
        return Err(Error::invalid("the ranks do not simulate the same, or not at the same instruction level")
            .at(format!("rank {rank}"))
            .advise("give all ranks the same description and files, and set RELIEVO_SIMD to a level that all have"));
    }
    Ok(all[0].first_chunk().map_or(0, |bytes| u64::from_le_bytes(*bytes)))
}

/// A transport that the fluid and the run around it call in turn.
#[derive(Clone)]
struct Ranks(Arc<Mutex<Box<dyn Transport>>>);

impl Ranks {
    fn get(&self) -> MutexGuard<'_, Box<dyn Transport>> {
        // A panic between two exchanges leaves nothing half done.
        self.0.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

impl Transport for Ranks {
    fn rank(&self) -> usize {
        self.get().rank()
    }

    fn ranks(&self) -> usize {
        self.get().ranks()
    }

    fn exchange(&mut self, sent: Vec<Vec<u8>>) -> Result<Vec<Vec<u8>>> {
        self.get().exchange(sent)
    }

    fn gather(&mut self, own: Vec<u8>) -> Result<Vec<Vec<u8>>> {
        self.get().gather(own)
    }
}
