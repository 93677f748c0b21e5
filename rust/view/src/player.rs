//! The player of scripts: it turns acts into events of a mouse and a keyboard, frame by frame.

use std::collections::VecDeque;
use std::path::PathBuf;

use egui::{Event, Key, Modifiers, MouseWheelUnit, PointerButton, Pos2, Rect, TouchPhase, Vec2, pos2};
use relievo_core::{Error, Result};

use crate::pen::PenState;
use crate::script::{Act, Script};
use crate::window::Content;

/// Frames that a script waits for a widget that is not there yet.
const PATIENCE: u32 = 120;

/// Places at which the pointer stops on its way over the view.
const STOPS: u32 = 8;

/// A script that is played.
pub(crate) struct Player {
    acts: VecDeque<Act>,
    /// Events of the next frames.
    frames: VecDeque<Vec<Event>>,
    waited: u32,
    /// Where the pointer is, in points.
    pointer: Pos2,
    /// How the pen is held that the script has.
    pub(crate) pen: PenState,
}

/// What a frame of a script asks for besides events.
pub(crate) enum Wish {
    Nothing,
    Screenshot(PathBuf),
    Resize([u32; 2]),
    Drop(PathBuf),
    End,
}

impl Player {
    pub(crate) fn new(script: Script) -> Self {
        Self { acts: script.acts.into(), frames: VecDeque::new(), waited: 0, pointer: Pos2::ZERO, pen: PenState::MOUSE }
    }

    /// Returns the events of the next frame.
    ///
    /// # Errors
    /// The content has not drawn what the act is for within some frames, or a file of the act cannot be read.
    pub(crate) fn step(&mut self, content: &mut impl Content) -> Result<(Vec<Event>, Wish)> {
        if let Some(events) = self.frames.pop_front() {
            return Ok((events, Wish::Nothing));
        }
        let Some(act) = self.acts.front().cloned() else { return Ok((Vec::new(), Wish::End)) };
        let frames = match &act {
            Act::Click { pixel, button } => content.pixel(*pixel).map(|at| self.click(at, *button)),
            Act::Press(name) => content.widget(name).map(|area| self.click(area.center(), PointerButton::Primary)),
            Act::Drag { axes, from, to } => {
                let (button, modifiers) = (PointerButton::Primary, Modifiers::NONE);
                content.plot(*axes).map(|area| self.drag(area, (button, modifiers), [*from, *to], 2))
            }
            Act::Sweep { button, modifiers, from, to } => {
                content.view().map(|area| self.drag(area, (*button, *modifiers), [*from, *to], STOPS))
            }
            Act::Point(share) => content.view().map(|area| {
                self.pointer = within(area, *share);
                vec![vec![Event::PointerMoved(self.pointer)], Vec::new()]
            }),
            Act::Pen(held) => {
                let [pressure, lean] = held.map(f64::from);
                self.pen = PenState { pressure, lean };
                Some(vec![Vec::new()])
            }
            Act::Wheel(notches) => Some(vec![vec![wheel(*notches)], Vec::new()]),
            Act::Key { key, modifiers } => Some(press(*key, *modifiers)),
            Act::Type(text) => Some(vec![vec![Event::Text(text.clone())]]),
            Act::Text(file) => {
                content.replace_text(file)?;
                Some(vec![Vec::new(); 2])
            }
            // The frame of the act before has to be there, which asks for what it waits for.
            Act::Rest if self.waited < 2 || !content.is_resting() => {
                self.waited += 1;
                // Frames that nobody asks for take time from what is waited for.
                std::thread::sleep(std::time::Duration::from_millis(20));
                return Ok((Vec::new(), Wish::Nothing));
            }
            Act::Rest => Some(vec![Vec::new()]),
            Act::Wait(count) => Some(vec![Vec::new(); *count as usize]),
            Act::Screenshot(file) => {
                self.acts.pop_front();
                return Ok((Vec::new(), Wish::Screenshot(file.clone())));
            }
            Act::Resize(size) => {
                self.acts.pop_front();
                self.frames = vec![Vec::new(); 4].into();
                return Ok((Vec::new(), Wish::Resize(*size)));
            }
            Act::Drop(file) => {
                self.acts.pop_front();
                self.frames = vec![Vec::new(); 2].into();
                return Ok((Vec::new(), Wish::Drop(file.clone())));
            }
            Act::Quit => return Ok((Vec::new(), Wish::End)),
        };
        match frames {
            Some(frames) => {
                self.acts.pop_front();
                self.waited = 0;
                self.frames = frames.into();
                Ok((self.frames.pop_front().unwrap_or_default(), Wish::Nothing))
            }
            None if self.waited < PATIENCE => {
                self.waited += 1;
                Ok((Vec::new(), Wish::Nothing))
            }
            None => Err(Error::invalid(format!("the window shows nothing for {act:?}")).at("the script")),
        }
    }

    /// Returns frames in which the pointer moves to a place, presses a button and releases it.
    fn click(&mut self, at: Pos2, which: PointerButton) -> Vec<Vec<Event>> {
        self.pointer = at;
        let button = |pressed| vec![button(at, (which, Modifiers::NONE), pressed)];
        vec![vec![Event::PointerMoved(at)], button(true), button(false), Vec::new()]
    }

    /// Returns frames in which the pointer drags between two places of an area, over `stops` places.
    fn drag(
        &mut self,
        area: Rect,
        which: (PointerButton, Modifiers),
        [from, to]: [[f32; 2]; 2],
        stops: u32,
    ) -> Vec<Vec<Event>> {
        let (first, last) = (within(area, from), within(area, to));
        self.pointer = last;
        let mut frames =
            vec![vec![Event::ModifiersChanged(which.1), Event::PointerMoved(first)], vec![button(first, which, true)]];
        frames.extend((1..=stops).map(|at| vec![Event::PointerMoved(first.lerp(last, at as f32 / stops as f32))]));
        frames.push(vec![button(last, which, false)]);
        frames.push(vec![Event::ModifiersChanged(Modifiers::NONE)]);
        frames
    }
}

/// Returns the place of shares of an area from its upper left.
fn within(area: Rect, [x, y]: [f32; 2]) -> Pos2 {
    pos2(area.left() + x * area.width(), area.top() + y * area.height())
}

fn button(at: Pos2, (button, modifiers): (PointerButton, Modifiers), pressed: bool) -> Event {
    Event::PointerButton { pos: at, button, pressed, modifiers }
}

fn press(key: Key, modifiers: Modifiers) -> Vec<Vec<Event>> {
    let event = |pressed| Event::Key { key, physical_key: None, pressed, repeat: false, modifiers };
    vec![
        vec![Event::ModifiersChanged(modifiers), event(true)],
        vec![event(false), Event::ModifiersChanged(Modifiers::NONE)],
    ]
}

fn wheel(notches: f32) -> Event {
    Event::MouseWheel {
        unit: MouseWheelUnit::Line,
        delta: Vec2::new(0.0, notches),
        phase: TouchPhase::Move,
        source: egui::MouseWheelSource::Wheel,
        modifiers: Modifiers::NONE,
    }
}
