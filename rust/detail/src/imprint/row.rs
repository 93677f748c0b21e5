//! Imprints in a row, each after those before it: the pairs of a frame, and the sub-steps of motions. On a graphics device
//! as many of them as can be are one submission.

use relievo_core::progress::Silent;
use relievo_core::{Context, Error, Progress, Result};

use crate::device::{Batch, DeviceRow, MAX_JOBS};
use crate::imprint::collider::Collider;
use crate::imprint::motion::Motion;
use crate::imprint::settings::{ImprintSettings, Moment, Report};
use crate::imprint::{Imprinted, Imprinter};
use crate::object::DisplacedObject;

/// One of several imprints that are made in a row.
#[derive(Clone, Copy, Debug)]
pub struct Press<'a> {
    /// Which of the objects is pressed into.
    pub into: usize,
    /// The collider, where it is.
    pub collider: &'a Collider,
    /// How.
    pub settings: &'a ImprintSettings,
    /// When.
    pub moment: Moment,
}

/// One of several motions that are made in a row.
#[derive(Clone, Copy, Debug)]
pub struct Sweep<'a> {
    /// Which of the objects is pressed into.
    pub into: usize,
    /// Which of the colliders moves.
    pub by: usize,
    /// How it moves.
    pub motion: &'a Motion,
    /// How it presses.
    pub settings: &'a ImprintSettings,
    /// When; the steps of the motion are counted from it.
    pub moment: Moment,
}

impl Sweep<'_> {
    /// Sub-steps that are made.
    fn count(&self) -> u32 {
        self.motion.sub_steps().min(self.settings.sub_steps)
    }

    fn is_limited(&self) -> bool {
        self.settings.depth_limit < Imprinter::NO_LIMIT
    }
}

/// Imprints whose colliders are put in place one by one.
trait Row: Send {
    fn len(&self) -> usize;

    /// The object, the settings and the moment of an imprint.
    fn press(&self, index: usize) -> (usize, &ImprintSettings, Moment);

    /// Whether the collider keeps its own points in it.
    fn is_rigid(&self, index: usize) -> bool;

    /// The collider of an imprint, where it presses.
    fn place(&mut self, context: &Context, index: usize) -> Result<&Collider>;

    /// All colliders, wherever they are.
    fn colliders(&self) -> Vec<&Collider>;
}

impl Row for &[Press<'_>] {
    fn len(&self) -> usize {
        <[_]>::len(self)
    }

    fn press(&self, index: usize) -> (usize, &ImprintSettings, Moment) {
        let press = &self[index];
        (press.into, press.settings, press.moment)
    }

    fn is_rigid(&self, _: usize) -> bool {
        true
    }

    fn place(&mut self, _: &Context, index: usize) -> Result<&Collider> {
        Ok(self[index].collider)
    }

    fn colliders(&self) -> Vec<&Collider> {
        self.iter().map(|press| press.collider).collect()
    }
}

/// The sub-steps of motions: which motion, and which of its steps, from 1.
struct Steps<'a, 'b> {
    sweeps: &'a [Sweep<'a>],
    colliders: &'a mut [&'b mut Collider],
    steps: Vec<(usize, u32)>,
}

impl Row for Steps<'_, '_> {
    fn len(&self) -> usize {
        self.steps.len()
    }

    fn press(&self, index: usize) -> (usize, &ImprintSettings, Moment) {
        let (sweep, step) = self.steps[index];
        let sweep = &self.sweeps[sweep];
        (sweep.into, sweep.settings, Moment { step: sweep.moment.step + step - 1, ..sweep.moment })
    }

    fn is_rigid(&self, index: usize) -> bool {
        self.sweeps[self.steps[index].0].motion.is_rigid()
    }

    fn place(&mut self, context: &Context, index: usize) -> Result<&Collider> {
        let (sweep, step) = self.steps[index];
        let sweep = &self.sweeps[sweep];
        let collider = &mut *self.colliders[sweep.by];
        collider.set_pose(context, &sweep.motion.at(f64::from(step) / f64::from(sweep.count())))?;
        Ok(collider)
    }

    fn colliders(&self) -> Vec<&Collider> {
        self.colliders.iter().map(|collider| &**collider).collect()
    }
}

impl Imprinter {
    /// Presses colliders into `objects` where they stand, each after those before it. On a graphics device they are one
    /// submission as long as objects are on one device.
    ///
    /// # Errors
    /// Fails with `Invalid`, before anything is made, if a setting is out of range or an object does not exist, and as
    /// [`Imprinter::imprint`]; imprints before stay made then.
    pub fn imprint_all(
        &mut self,
        context: &Context,
        objects: &mut [&mut DisplacedObject],
        presses: &[Press<'_>],
    ) -> Result<Vec<Report>> {
        for (index, press) in presses.iter().enumerate() {
            press.settings.check()?;
            if press.into >= objects.len() {
                return Err(Error::invalid("the object does not exist").at(format!("imprint {index}")));
            }
        }
        self.make_row(context, objects, None, &mut { presses }, &mut Silent)
    }

    /// Moves `colliders` along their motions and presses them into `objects`, each motion after those before it, as
    /// [`Imprinter::sweep`] does; on a graphics device in as few submissions as [`Imprinter::imprint_all`].
    ///
    /// # Errors
    /// Fails with `Invalid`, before anything is made, if a setting is out of range or an object or a collider does not
    /// exist, and as [`Imprinter::sweep`]; sub-steps before stay made then.
    #[allow(private_bounds)]
    pub fn sweep_all<O: Imprinted>(
        &mut self,
        context: &Context,
        objects: &mut [&mut O],
        colliders: &mut [&mut Collider],
        sweeps: &[Sweep<'_>],
    ) -> Result<Vec<Report>> {
        for (index, sweep) in sweeps.iter().enumerate() {
            sweep.settings.check()?;
            if sweep.into >= objects.len() || sweep.by >= colliders.len() {
                return Err(Error::invalid("the object or the collider does not exist").at(format!("motion {index}")));
            }
        }
        let mut reports = Vec::with_capacity(sweeps.len());
        // Where a depth limit counts from is known when the motions before are done.
        for sweeps in sweeps.chunk_by(|a, b| !a.is_limited() && !b.is_limited()) {
            reports.extend(O::sweep(context, self, objects, colliders, sweeps, &mut Silent)?);
        }
        Ok(reports)
    }

    /// Moves colliders along their motions, of which one alone may have a depth limit.
    pub(crate) fn sweep_steps<O: DeviceRow>(
        &mut self,
        context: &Context,
        objects: &mut [&mut O],
        colliders: &mut [&mut Collider],
        sweeps: &[Sweep<'_>],
        progress: &mut dyn Progress,
    ) -> Result<Vec<Report>> {
        let limited = sweeps.iter().find(|sweep| sweep.is_limited());
        let start = limited.map(|sweep| objects[sweep.into].field().clone());
        let steps = sweeps.iter().enumerate().flat_map(|(index, sweep)| (1..=sweep.count()).map(move |it| (index, it)));
        let steps: Vec<_> = steps.collect();
        let wanted = |sweep: &Sweep<'_>| u64::from(sweep.motion.sub_steps());
        let mut reports: Vec<Report> =
            sweeps.iter().map(|it| Report { sub_steps_wanted: wanted(it), ..Report::default() }).collect();
        let mut row = Steps { sweeps, colliders, steps };
        let made = self.make_row(context, objects, start.as_ref(), &mut row, progress)?;
        for ((sweep, _), made) in row.steps.into_iter().zip(made) {
            reports[sweep].merge(&made);
            made.give_back(context);
        }
        Ok(reports)
    }

    /// Makes the imprints of a row: on a device together the imprints that can be, else one by one. `progress` is asked
    /// before each.
    fn make_row<O: DeviceRow>(
        &mut self,
        context: &Context,
        objects: &mut [&mut O],
        start: Option<&O::Field>,
        row: &mut dyn Row,
        progress: &mut dyn Progress,
    ) -> Result<Vec<Report>> {
        for object in objects.iter_mut() {
            object.prepare(context)?;
        }
        let count = row.len();
        let mut reports = Vec::with_capacity(count);
        let (mut asked, mut most, mut worked) = (0, MAX_JOBS, false);
        while reports.len() < count {
            let done = reports.len();
            let fits = |index: &usize| {
                let (into, settings, _) = row.press(*index);
                row.is_rigid(*index) && objects[into].is_for_row(settings)
            };
            let wanted = (done..count.min(done + most)).take_while(fits).count();
            let mut stopped = Ok(());
            while asked < done + wanted.max(1) && stopped.is_ok() {
                stopped = progress.step(asked as f32 / count as f32, "imprint");
                asked += usize::from(stopped.is_ok());
            }
            let uneven = context.within(|| {
                let mut uneven = false;
                let until = asked.min(done + wanted);
                if until > done + 1 {
                    let mut batch = Batch::new(worked);
                    for index in done..until {
                        let (into, settings, moment) = row.press(index);
                        let settings = *settings;
                        let collider = row.place(context, index)?;
                        if !batch.add(context, into, objects[into], collider, &settings, moment)? {
                            break;
                        }
                    }
                    uneven = self.submit(context, objects, start, &row.colliders(), &batch, &mut reports)?;
                }
                if reports.len() == done && asked > done {
                    let (into, settings, moment) = row.press(done);
                    let settings = *settings;
                    let collider = row.place(context, done)?;
                    reports.push(objects[into].press(context, self, collider, (&settings, moment), start)?);
                }
                Ok::<_, Error>(uneven)
            })?;
            stopped?;
            let made = reports.len() - done;
            // What ends a submission early is soon met again: the next ones are shorter, or have the ring update between.
            worked |= uneven;
            if !uneven {
                most = if made < wanted { made } else { (2 * most).min(MAX_JOBS) };
            }
        }
        Ok(reports)
    }
}
