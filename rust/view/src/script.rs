//! Scripts: what a mouse and a keyboard do, one line for each act, so that a session is played without a person.
//!
//! ```text
//! click 120 80            left button on a pixel of the picture: a positive example
//! right_click 40 60       right button: a negative example
//! ask 120 80              middle button: why this pixel
//! press NAME              left button on a button, tab or box by what stands on it
//! drag A B 0.1 0.1 0.6 0.9   brushes the plot of features A and B, in shares of its width and height from the upper left
//! drag left 0.3 0.5 0.6 0.5  drags over the view of a model, in shares of it; also `middle`, `right`, `ctrl+left`, `shift+left`
//! point 0.3 0.5           the pointer over the view
//! pen 0.4 50              a pen from now on, how hard it presses and the degrees that it leans; `pen 1 0` is as a mouse
//! wheel -2                notches of the wheel, where the pointer is
//! resize 960 600          other width and height of the window
//! key s                   a key, with `ctrl+` and `shift+` before it where these are down
//! type TEXT               text where the focus is
//! text FILE               the text of the shader, replaced by that of a file
//! drop FILE               a file that is dropped on the window
//! wait_frames 3           nothing, for that many frames
//! rest                    nothing, until the ray caster's picture and what is recorded are there
//! screenshot FILE         the window as PNG
//! quit                    closes the window; so does the end of the script
//! ```
//!
//! Empty lines and lines that begin with `#` are skipped. A line is acted on when its widget has been drawn.

use std::path::{Path, PathBuf};

use egui::Modifiers;
use relievo_core::{Error, Result};

/// Bytes that a script may have.
const MAX_BYTES: u64 = 1 << 20;

/// An act.
#[derive(Clone, Debug, PartialEq)]
pub(crate) enum Act {
    /// A button of the mouse on a pixel of the picture.
    Click {
        pixel: [u32; 2],
        button: egui::PointerButton,
    },
    /// The left button on the widget of a name.
    Press(String),
    /// A brush over the plot of two features, between two places in shares of the plot.
    Drag {
        axes: [usize; 2],
        from: [f32; 2],
        to: [f32; 2],
    },
    /// A button dragged over the view, between two places in shares of it.
    Sweep {
        button: egui::PointerButton,
        modifiers: Modifiers,
        from: [f32; 2],
        to: [f32; 2],
    },
    /// The pointer at a place of the view, in shares of it.
    Point([f32; 2]),
    /// How hard a pen presses, 0 to 1, and by how many degrees it leans, from now on.
    Pen([f32; 2]),
    /// Notches of the wheel, positive away from the user.
    Wheel(f32),
    /// Points of the window's width and height.
    Resize([u32; 2]),
    Key {
        key: egui::Key,
        modifiers: Modifiers,
    },
    Type(String),
    Text(PathBuf),
    Drop(PathBuf),
    Wait(u32),
    Rest,
    Screenshot(PathBuf),
    Quit,
}

/// Acts in their order.
#[derive(Clone, Debug, PartialEq)]
pub struct Script {
    pub(crate) acts: Vec<Act>,
}

impl Script {
    /// Reads the text of a script.
    ///
    /// # Errors
    /// Fails, with the line, if a line is no act.
    pub fn parse(text: &str) -> Result<Self> {
        let mut acts = Vec::new();
        for (index, line) in text.lines().enumerate() {
            let line = line.trim();
            if line.is_empty() || line.starts_with('#') {
                continue;
            }
            let refused = || {
                Error::invalid(format!("{line:?} is no act"))
                    .at(format!("line {}", index + 1))
                    .advise("see the acts in `relievo view --help` and `relievo shader view --help`")
            };
            acts.push(act(line).ok_or_else(refused)?);
        }
        Ok(Self { acts })
    }

    /// Reads a file.
    ///
    /// # Errors
    /// Fails if the file cannot be read, is larger than 1 MiB or no UTF-8, and as [`Self::parse`].
    pub fn read(path: &Path) -> Result<Self> {
        let place = path.display().to_string();
        let bytes = relievo_core::file::load(path, MAX_BYTES)?;
        let text = String::from_utf8(bytes).map_err(|_| Error::invalid("the file is no UTF-8").at(&*place))?;
        Self::parse(&text).map_err(|error| error.at(place))
    }
}

fn act(line: &str) -> Option<Act> {
    let (word, rest) = line.split_once(char::is_whitespace).unwrap_or((line, ""));
    let rest = rest.trim();
    let parts: Vec<&str> = rest.split_whitespace().collect();
    let click = |button| match parts.as_slice() {
        [x, y] => Some(Act::Click { pixel: [x.parse().ok()?, y.parse().ok()?], button }),
        _ => None,
    };
    let named = (!rest.is_empty()).then(|| rest.to_owned());
    match word {
        "click" => click(egui::PointerButton::Primary),
        "right_click" => click(egui::PointerButton::Secondary),
        "ask" => click(egui::PointerButton::Middle),
        "press" => Some(Act::Press(named?)),
        "drag" => match parts.as_slice() {
            [which, x0, y0, x1, y1] => {
                let (modifiers, button) = held(which);
                let button = match button {
                    "left" => egui::PointerButton::Primary,
                    "middle" => egui::PointerButton::Middle,
                    "right" => egui::PointerButton::Secondary,
                    _ => return None,
                };
                Some(Act::Sweep { button, modifiers, from: [share(x0)?, share(y0)?], to: [share(x1)?, share(y1)?] })
            }
            [a, b, x0, y0, x1, y1] => Some(Act::Drag {
                axes: [a.parse().ok()?, b.parse().ok()?],
                from: [share(x0)?, share(y0)?],
                to: [share(x1)?, share(y1)?],
            }),
            _ => None,
        },
        "point" => match parts.as_slice() {
            [x, y] => Some(Act::Point([share(x)?, share(y)?])),
            _ => None,
        },
        "pen" => match parts.as_slice() {
            [pressure, lean] => {
                let lean = lean.parse().ok().filter(|lean| (0.0..=90.0).contains(lean))?;
                Some(Act::Pen([share(pressure)?, lean]))
            }
            _ => None,
        },
        "wheel" => rest.parse().ok().filter(|notches: &f32| notches.abs() <= 100.0).map(Act::Wheel),
        "resize" => match parts.as_slice() {
            [width, height] => {
                let edge = |text: &str| text.parse().ok().filter(|edge| (100..=8192).contains(edge));
                Some(Act::Resize([edge(width)?, edge(height)?]))
            }
            _ => None,
        },
        "key" => {
            let (modifiers, name) = held(rest);
            let name = if name.len() == 1 { name.to_ascii_uppercase() } else { name.to_owned() };
            Some(Act::Key { key: egui::Key::from_name(&name)?, modifiers })
        }
        "type" => Some(Act::Type(named?)),
        "text" => Some(Act::Text(named?.into())),
        "drop" => Some(Act::Drop(named?.into())),
        "wait_frames" => Some(Act::Wait(rest.parse().ok()?)),
        "rest" if rest.is_empty() => Some(Act::Rest),
        "screenshot" => Some(Act::Screenshot(named?.into())),
        "quit" if rest.is_empty() => Some(Act::Quit),
        _ => None,
    }
}

/// Splits the modifiers off the name of a key or button.
fn held(text: &str) -> (Modifiers, &str) {
    let (mut modifiers, mut name) = (Modifiers::NONE, text);
    loop {
        if let Some(rest) = name.strip_prefix("ctrl+") {
            (modifiers, name) = (modifiers | Modifiers::CTRL | Modifiers::COMMAND, rest);
        } else if let Some(rest) = name.strip_prefix("shift+") {
            (modifiers, name) = (modifiers | Modifiers::SHIFT, rest);
        } else {
            return (modifiers, name);
        }
    }
}

fn share(text: &str) -> Option<f32> {
    text.parse().ok().filter(|share| (0.0..=1.0).contains(share))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn acts_are_read_and_others_refused_with_their_line() {
        let script =
            Script::parse("# start\nclick 3 4\n\nkey ctrl+s\ndrag 0 1 0.1 0.2 0.5 1\npress Write vector\n").unwrap();
        assert_eq!(script.acts[0], Act::Click { pixel: [3, 4], button: egui::PointerButton::Primary });
        let control = Modifiers::CTRL | Modifiers::COMMAND;
        assert_eq!(script.acts[1], Act::Key { key: egui::Key::S, modifiers: control });
        assert_eq!(script.acts[2], Act::Drag { axes: [0, 1], from: [0.1, 0.2], to: [0.5, 1.0] });
        assert_eq!(script.acts[3], Act::Press("Write vector".into()));
        let script =
            Script::parse("drag shift+middle 0 0.5 1 0.5\nwheel -2\nresize 960 600\nkey ctrl+shift+z\npen 0.5 60")
                .unwrap();
        let (button, [from, to]) = (egui::PointerButton::Middle, [[0.0, 0.5], [1.0, 0.5]]);
        assert_eq!(script.acts[0], Act::Sweep { button, modifiers: Modifiers::SHIFT, from, to });
        assert_eq!(script.acts[1..3], [Act::Wheel(-2.0), Act::Resize([960, 600])]);
        assert_eq!(script.acts[3], Act::Key { key: egui::Key::Z, modifiers: control | Modifiers::SHIFT });
        assert_eq!(script.acts[4], Act::Pen([0.5, 60.0]));
        for wrong in [
            "clock 3 4",
            "click 3",
            "click -1 4",
            "drag 0 1 0 0 2 1",
            "drag left 0 0 2 1",
            "drag up 0 0 1 1",
            "point 0.5",
            "pen 0.5",
            "pen 0.5 91",
            "wheel nan",
            "resize 9 9",
            "key nothing",
            "wait_frames",
            "drop",
            "quit now",
            "rest 3",
        ] {
            let error = Script::parse(&format!("wait_frames 1\n{wrong}")).unwrap_err();
            assert!(error.to_string().contains("line 2"), "{error}");
        }
    }
}
