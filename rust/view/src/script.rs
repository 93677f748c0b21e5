//! Scripts: what a mouse and a keyboard do, one line for each act, so that a session is played without a person.
//!
//! ```text
//! click 120 80            left button on a pixel of the picture: a positive example
//! right_click 40 60       right button: a negative example
//! ask 120 80              middle button: why this pixel
//! press NAME              left button on a button, tab or box by what stands on it
//! drag A B 0.1 0.1 0.6 0.9   brushes the plot of features A and B, in shares of its width and height from the upper left
//! key s                   a key, with `ctrl+` before it where Control is down
//! type TEXT               text where the focus is
//! text FILE               the text of the shader, replaced by that of a file
//! wait_frames 3           nothing, for that many frames
//! screenshot FILE         the window as PNG
//! quit                    closes the window; so does the end of the script
//! ```
//!
//! Empty lines and lines that begin with `#` are skipped. A line is acted on when its widget has been drawn.

use std::path::{Path, PathBuf};

use relievo_core::{Error, Result};

/// Bytes that a script may have.
const MOST_BYTES: u64 = 1 << 20;

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
    Key {
        key: egui::Key,
        has_control: bool,
    },
    Type(String),
    Text(PathBuf),
    Wait(u32),
    Screenshot(PathBuf),
    Quit,
}

/// Acts in their order.
#[derive(Clone, Debug, PartialEq)]
pub struct Script {
    pub(crate) acts: Vec<Act>,
}

impl Script {
    /// Reads the text of a script. Fails with the line that is no act.
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
                    .advise("see the acts in `relievo shader view --help`")
            };
            acts.push(act(line).ok_or_else(refused)?);
        }
        Ok(Self { acts })
    }

    /// Reads a file.
    pub fn read(path: &Path) -> Result<Self> {
        let place = path.display().to_string();
        let bytes = relievo_core::file::load(path, MOST_BYTES)?;
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
            [a, b, x0, y0, x1, y1] => Some(Act::Drag {
                axes: [a.parse().ok()?, b.parse().ok()?],
                from: [share(x0)?, share(y0)?],
                to: [share(x1)?, share(y1)?],
            }),
            _ => None,
        },
        "key" => {
            let (has_control, name) = match rest.strip_prefix("ctrl+") {
                Some(name) => (true, name),
                None => (false, rest),
            };
            let name = if name.len() == 1 { name.to_ascii_uppercase() } else { name.to_owned() };
            Some(Act::Key { key: egui::Key::from_name(&name)?, has_control })
        }
        "type" => Some(Act::Type(named?)),
        "text" => Some(Act::Text(named?.into())),
        "wait_frames" => Some(Act::Wait(rest.parse().ok()?)),
        "screenshot" => Some(Act::Screenshot(named?.into())),
        "quit" if rest.is_empty() => Some(Act::Quit),
        _ => None,
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
        assert_eq!(script.acts[1], Act::Key { key: egui::Key::S, has_control: true });
        assert_eq!(script.acts[2], Act::Drag { axes: [0, 1], from: [0.1, 0.2], to: [0.5, 1.0] });
        assert_eq!(script.acts[3], Act::Press("Write vector".into()));
        for wrong in
            ["clock 3 4", "click 3", "click -1 4", "drag 0 1 0 0 2 1", "key nothing", "wait_frames", "quit now"]
        {
            let error = Script::parse(&format!("wait_frames 1\n{wrong}")).unwrap_err();
            assert!(error.to_string().contains("line 2"), "{error}");
        }
    }
}
