//! A stroke that is being drawn: its points come a few at a time, and its dabs are made as they come. The whole stroke
//! makes the same dabs when all its points are known: what has been made never depends on what comes.

use std::sync::Arc;

use relievo_core::{Context, Error, Result};

use crate::object::canvas::{Canvas, Start};
use crate::paint::dab::{Action, Dab, no_vectors};
use crate::paint::mode::PaintMode;
use crate::paint::path::{Station, StrokePoint};
use crate::paint::smudge::{Carried, Smudge};
use crate::paint::stroke::{Among, Images, Stroke, StrokeReport};

/// Dabs that smear and are made at once, at most: each has a picture of what was under it.
const CHAIN: usize = 32;

/// A stroke under way on some objects. They must always be given in the same order, and nothing else may edit them
/// meanwhile.
#[derive(Clone, Debug)]
pub struct OpenStroke {
    stroke: Stroke,
    starts: Vec<Start>,
    /// Stations whose dabs are made.
    made: usize,
    /// What the brush carries while it smears, and what its mirror images do.
    carried: Vec<Option<Arc<Carried>>>,
}

impl OpenStroke {
    /// Begins `stroke`, whose points are the first ones and may be none, on `objects`. No dab is made yet.
    ///
    /// # Errors
    /// Fails as [`Stroke::check_brush`], or as [`Stroke::check`] if there are points; with `Invalid` if an object has
    /// no colours and is to be painted, or no vectors and they are to be changed; and as [`Canvas::begin`].
    #[inline(never)]
    pub fn begin<C: Canvas + ?Sized>(context: &Context, mut stroke: Stroke, objects: &mut [&mut C]) -> Result<Self> {
        stroke.check_brush()?;
        if !stroke.points.is_empty() {
            stroke.pace().check(&stroke.points)?;
        }
        if matches!(stroke.action, Action::Paint { .. })
            && let Some(index) = objects.iter().position(|object| !object.is_paintable())
        {
            return Err(Error::invalid("the object has no colours to paint on")
                .at(format!("object {index} of the stroke"))
                .advise("give it some first"));
        }
        if matches!(stroke.action, Action::Sculpt { mode, .. } if mode.needs_vectors())
            && let Some(index) = objects.iter().position(|object| !object.is_bendable())
        {
            return Err(no_vectors().at(format!("object {index} of the stroke")));
        }
        let starts = objects.iter_mut().map(|object| object.begin(context)).collect::<Result<_>>()?;
        // Points come one by one; the list of another stroke has room for them.
        let mut points = context.scratch().take_list();
        points.append(&mut stroke.points);
        stroke.points = points;
        Ok(Self { stroke, starts, made: 0, carried: Vec::new() })
    }

    /// Gives the room of the list of points back to the context that the stroke was begun with.
    pub fn give_back(self, context: &Context) {
        context.scratch().keep_list(self.stroke.points);
    }

    /// The stroke with all points so far.
    pub fn stroke(&self) -> &Stroke {
        &self.stroke
    }

    /// Goes on to `points` and makes the dabs on the way. Returns what they did to each of the objects.
    ///
    /// # Errors
    /// Fails, and changes nothing, as [`Stroke::check`] of all points so far, and with `Invalid` if there are not as
    /// many objects as before. Fails as [`Canvas::nearest`], [`Canvas::dabs`] and [`Canvas::show`] too: dabs before
    /// stay made, and the ones left of these points are not made later.
    #[inline(never)]
    pub fn extend<C: Canvas + ?Sized>(
        &mut self,
        context: &Context,
        objects: &mut [&mut C],
        points: &[StrokePoint],
    ) -> Result<Vec<StrokeReport>> {
        let old = self.stroke.points.len();
        self.stroke.points.extend_from_slice(points);
        let checked = self.stroke.pace().check(&self.stroke.points);
        if let Err(error) = checked.and_then(|()| self.check_objects(objects)) {
            self.stroke.points.truncate(old);
            return Err(error);
        }
        if self.made == 0 && self.stroke.pace().waits(&self.stroke.points) {
            Ok(StrokeReport::list(context, objects.len()))
        } else {
            self.make(context, objects)
        }
    }

    /// Ends the stroke with its last `points`, if there are any, and makes the dabs that are left.
    ///
    /// # Errors
    /// Fails as [`Self::extend`], with `Invalid` if the stroke has no points at all, and as [`Canvas::end`]; dabs
    /// before stay made.
    #[inline(never)]
    pub fn end<C: Canvas + ?Sized>(
        mut self,
        context: &Context,
        objects: &mut [&mut C],
        points: &[StrokePoint],
    ) -> Result<Vec<StrokeReport>> {
        self.stroke.points.extend_from_slice(points);
        self.stroke.pace().check(&self.stroke.points)?;
        self.check_objects(objects)?;
        let mut done = self.make(context, objects)?;
        for (object, done) in objects.iter_mut().zip(&mut done) {
            done.report.refuse(object.end(context)?);
        }
        Ok(done)
    }

    fn check_objects<C: ?Sized>(&self, objects: &[&mut C]) -> Result<()> {
        if objects.len() == self.starts.len() {
            return Ok(());
        }
        Err(Error::invalid("the stroke began on other objects").advise("give it those it began on"))
    }

    /// Makes the dabs of the stations that have none.
    fn make<C: Canvas + ?Sized>(&mut self, context: &Context, objects: &mut [&mut C]) -> Result<Vec<StrokeReport>> {
        let (mut trail, mut stations) = (context.scratch().list(), context.scratch().list());
        self.stroke.pace().stations_into(&self.stroke.points, &mut trail, &mut stations);
        let left = stations.get(self.made..).unwrap_or_default();
        self.made += left.len();
        self.make_at(context, objects, left)
    }

    /// Makes dabs at `stations`.
    pub(crate) fn make_at<C: Canvas + ?Sized>(
        &mut self,
        context: &Context,
        objects: &mut [&mut C],
        stations: &[Station],
    ) -> Result<Vec<StrokeReport>> {
        // A dab has a dozen stages of less than a millisecond.
        context.within(|| self.make_within(context, objects, stations))
    }

    fn make_within<C: Canvas + ?Sized>(
        &mut self,
        context: &Context,
        objects: &mut [&mut C],
        stations: &[Station],
    ) -> Result<Vec<StrokeReport>> {
        let mut found = context.scratch().list();
        {
            let _stage = context.stats().begin("stroke.nearest");
            let objects = Among { objects: &*objects, starts: &self.starts };
            context.map_into(stations.len(), &mut found, |index| self.stroke.dabs(context, objects, &stations[index]));
        }
        let mut placed = context.scratch().list();
        for found in found.drain(..) {
            let Images { dabs, count } = found?;
            placed.extend(dabs.into_iter().take(count));
        }
        let missed = placed.iter().filter(|dab| dab.is_none()).count() as u64;
        let mut done = StrokeReport::list(context, objects.len());
        done.iter_mut().for_each(|done| done.missed = missed);
        let images = placed.len() / stations.len().max(1);
        self.carried.resize(images.max(self.carried.len()), None);
        if matches!(self.stroke.action, Action::Paint { mode: PaintMode::Smear, .. }) {
            self.smear(context, objects, placed.drain(..).enumerate(), (images, &mut done))?;
        } else {
            // What is done to one object does not depend on the others.
            let (mut on, mut dabs) = (context.scratch().list(), context.scratch().list());
            for (object, dab) in placed.drain(..).flatten() {
                on.push(object);
                dabs.push(dab);
            }
            for (index, object) in objects.iter_mut().enumerate() {
                let mut reports = object.dabs(context, &dabs, &self.starts[index], self.stroke.settings.level)?;
                for (on, report) in on.iter().zip(reports.drain(..)) {
                    done[index].dabs += u64::from(index == *on || report.changed_texels > 0);
                    done[index].report.merge(&report);
                    report.give_back(context);
                }
                context.scratch().keep_list(reports);
            }
        }
        for (object, done) in objects.iter_mut().zip(&mut done) {
            done.report.refuse(object.show(context)?);
        }
        Ok(done)
    }

    /// Makes dabs that smear, each with the object that it is put on: of every station as many as it has `images`.
    ///
    /// A dab leaves what the one before it picked up of all objects, and a mirror image what the one before that did.
    /// So dabs that follow each other and reach the same object alone are given to it at once, and what reaches several
    /// is made dab by dab.
    fn smear<C: Canvas + ?Sized>(
        &mut self,
        context: &Context,
        objects: &mut [&mut C],
        placed: impl Iterator<Item = (usize, Option<(usize, Dab)>)>,
        (images, done): (usize, &mut [StrokeReport]),
    ) -> Result<()> {
        for (object, done) in objects.iter_mut().zip(done.iter_mut()) {
            done.report.bytes = object.painted_bytes()?;
        }
        let (mut run, mut reached) = (context.scratch().list(), Reached::default());
        for (at, placed) in placed {
            let Some((on, dab)) = placed else { continue };
            let now = self.reached(context, objects, (on, &dab));
            if run.len() == CHAIN || now != reached {
                self.smear_on(context, objects, (&reached, run.drain(..)), done)?;
            }
            reached = now;
            run.push(Put { image: at % images, on, dab });
        }
        self.smear_on(context, objects, (&reached, run.drain(..)), done)
    }

    /// The objects that a dab on `on` reaches, this one among them.
    fn reached<C: Canvas + ?Sized>(
        &self,
        context: &Context,
        objects: &mut [&mut C],
        (on, dab): (usize, &Dab),
    ) -> Reached {
        if objects.len() == 1 {
            return Reached::from([0]);
        }
        let reaches = |index: &usize| *index == on || objects[*index].meets(context, dab, &self.starts[*index]);
        (0..self.starts.len()).filter(reaches).collect()
    }

    /// Makes dabs that smear on the only object that they reach, or one by one on those.
    fn smear_on<C: Canvas + ?Sized>(
        &mut self,
        context: &Context,
        objects: &mut [&mut C],
        (reached, run): (&Reached, impl Iterator<Item = Put>),
        done: &mut [StrokeReport],
    ) -> Result<()> {
        let level = self.stroke.settings.level;
        let &[own] = &reached[..] else {
            for Put { image, on, mut dab } in run {
                let smudge = Smudge::new(self.carried[image].take());
                dab.brush = dab.brush.with_smudge(smudge.clone());
                done[on].dabs += 1;
                for &index in reached {
                    let report = objects[index].dab(context, &dab, &self.starts[index], level)?;
                    done[index].dabs += u64::from(index != on && report.changed_texels > 0);
                    done[index].report.merge(&report);
                    report.give_back(context);
                }
                self.carried[image] = smudge.taken();
            }
            return Ok(());
        };
        let mut dabs = context.scratch().list();
        let mut last: [Option<Smudge>; 8] = Default::default();
        for Put { image, mut dab, .. } in run {
            let smudge = match &last[image] {
                Some(before) => Smudge::after(before),
                None => Smudge::new(self.carried[image].take()),
            };
            dab.brush = dab.brush.with_smudge(smudge.clone());
            last[image] = Some(smudge);
            dabs.push(dab);
        }
        let mut reports = objects[own].dabs(context, &dabs, &self.starts[own], level)?;
        for report in reports.drain(..) {
            done[own].dabs += 1;
            done[own].report.merge(&report);
            report.give_back(context);
        }
        context.scratch().keep_list(reports);
        for (carried, last) in self.carried.iter_mut().zip(&last) {
            if let Some(smudge) = last {
                *carried = smudge.taken();
            }
        }
        Ok(())
    }
}

/// Objects, ascending.
type Reached = Vec<usize>;

/// A dab that smears: which mirror image it is, and the object that it is put on.
struct Put {
    image: usize,
    on: usize,
    dab: Dab,
}
