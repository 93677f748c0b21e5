//! Numbered meshes, one file per frame: `wheel.####.obj` or `wheel.%04d.obj`.

use std::path::{Path, PathBuf};

use relievo_core::{Context, Error, ErrorKind, Mesh, Result};

/// A sequence of files whose names differ in a number, the frame.
#[derive(Clone, Debug)]
pub struct Sequence {
    pattern: Pattern,
    frames: Vec<u64>,
    first: Option<Topology>,
}

/// What must be the same in all frames.
#[derive(Clone, Debug, PartialEq)]
struct Topology {
    points: usize,
    face_sizes: Vec<u32>,
    corners: Vec<u32>,
}

/// The name of a frame's file: a prefix, a number of at least `digits` digits, a suffix.
#[derive(Clone, Debug)]
struct Pattern {
    folder: PathBuf,
    prefix: String,
    digits: usize,
    suffix: String,
}

/// More digits than a frame number has.
const MAX_DIGITS: usize = 18;

impl Pattern {
    /// The pattern that `path` is, `None` if its name has no number in it.
    fn parse(path: &Path) -> Option<Self> {
        let name = path.file_name()?.to_str()?;
        let folder = path.parent().unwrap_or(Path::new("")).to_path_buf();
        let (prefix, digits, suffix) = if let Some(start) = name.find('#') {
            let rest = name[start..].trim_start_matches('#');
            (&name[..start], name.len() - start - rest.len(), rest)
        } else {
            let (prefix, rest) = name.split_once('%')?;
            let (digits, suffix) = rest.split_once('d')?;
            let digits = match digits {
                "" => 1,
                // Only zeros fill the field.
                _ => digits.strip_prefix('0')?.parse().ok()?,
            };
            (prefix, digits, suffix)
        };
        let digits = (1..=MAX_DIGITS).contains(&digits).then_some(digits)?;
        Some(Self { folder, prefix: prefix.into(), digits, suffix: suffix.into() })
    }

    fn path(&self, frame: u64) -> PathBuf {
        let Self { folder, prefix, digits, suffix } = self;
        folder.join(format!("{prefix}{frame:0digits$}{suffix}"))
    }

    /// The frame whose file is called `name`.
    fn frame(&self, name: &str) -> Option<u64> {
        let digits = name.strip_prefix(self.prefix.as_str())?.strip_suffix(self.suffix.as_str())?;
        let longer = digits.len() > self.digits && !digits.starts_with('0');
        let plain = digits.bytes().all(|byte| byte.is_ascii_digit()) && digits.len() <= MAX_DIGITS;
        if plain && (digits.len() == self.digits || longer) { digits.parse().ok() } else { None }
    }
}

impl Sequence {
    /// Whether the name of `path` has a place for a number.
    pub fn is_pattern(path: &Path) -> bool {
        Pattern::parse(path).is_some()
    }

    /// Finds the files of a sequence, without reading them. Fails if there are none.
    pub fn open(pattern: &Path) -> Result<Self> {
        let place = pattern.display().to_string();
        let pattern = Pattern::parse(pattern).ok_or_else(|| {
            Error::invalid("the name has no place for the number of the frame")
                .at(place.clone())
                .advise("write `####` or `%04d` in it")
        })?;
        let folder = if pattern.folder.as_os_str().is_empty() { Path::new(".") } else { &pattern.folder };
        let failed = |error: std::io::Error| Error::io(folder, &error);
        let mut frames = Vec::new();
        for entry in std::fs::read_dir(folder).map_err(failed)? {
            let name = entry.map_err(failed)?.file_name();
            frames.extend(name.to_str().and_then(|name| pattern.frame(name)));
        }
        frames.sort_unstable();
        if frames.is_empty() {
            return Err(Error::new(ErrorKind::NotFound, "no file has a name of this form")
                .at(place)
                .advise("check the folder and the number of digits"));
        }
        Ok(Self { pattern, frames, first: None })
    }

    /// The frames that exist, in order.
    pub fn frames(&self) -> &[u64] {
        &self.frames
    }

    /// The file of a frame, whether it exists or not.
    pub fn path(&self, frame: u64) -> PathBuf {
        self.pattern.path(frame)
    }

    /// The existing frame that stands for `frame`: itself, or the nearest one before, or the first.
    pub fn nearest(&self, frame: u64) -> u64 {
        let behind = self.frames.partition_point(|known| *known <= frame);
        self.frames.get(behind.saturating_sub(1)).copied().unwrap_or(frame)
    }

    /// Reads the mesh of an existing frame. Fails if its faces are not those of the first one that was read.
    pub fn read(&mut self, context: &Context, frame: u64) -> Result<Mesh> {
        let path = self.path(frame);
        if self.frames.binary_search(&frame).is_err() {
            let (first, last) = (self.frames.first().copied(), self.frames.last().copied());
            return Err(Error::new(ErrorKind::NotFound, format!("there is no frame {frame}"))
                .at(path.display().to_string())
                .advise(format!("use {} to {}", first.unwrap_or_default(), last.unwrap_or_default())));
        }
        let mesh = crate::read(context, &path)?;
        let topology =
            Topology { points: mesh.points.len(), face_sizes: mesh.face_sizes.clone(), corners: mesh.corners.clone() };
        match &self.first {
            None => self.first = Some(topology),
            Some(first) if *first == topology => {}
            Some(first) => {
                let what = format!(
                    "its {} points and {} faces are not connected as the {} points and {} faces read before",
                    topology.points,
                    topology.face_sizes.len(),
                    first.points,
                    first.face_sizes.len()
                );
                return Err(Error::invalid(what)
                    .at(path.display().to_string())
                    .advise("the meshes of a sequence may only differ in the places of their points"));
            }
        }
        Ok(mesh)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_and_frames_belong_together() {
        for (pattern, frame, name) in [
            ("a/w.####.obj", 7, "a/w.0007.obj"),
            ("a/w.####.obj", 12345, "a/w.12345.obj"),
            ("w%04d.ply", 7, "w0007.ply"),
            ("w%d.ply", 70, "w70.ply"),
            ("##", 3, "03"),
        ] {
            let pattern = Pattern::parse(Path::new(pattern)).unwrap();
            assert_eq!(pattern.path(frame), Path::new(name));
            let name = Path::new(name).file_name().unwrap().to_str().unwrap();
            assert_eq!(pattern.frame(name), Some(frame));
        }
        let pattern = Pattern::parse(Path::new("w.####.obj")).unwrap();
        for bad in ["w.007.obj", "w.00012.obj", "w.-001.obj", "w.0001.obj.bak", "x.0001.obj", "w.00+1.obj", "w..obj"] {
            assert_eq!(pattern.frame(bad), None, "{bad}");
        }
        for bad in ["a.obj", "a%.obj", "a%4d.obj", "a%0999d.obj", "a%s.obj", ""] {
            assert!(!Sequence::is_pattern(Path::new(bad)), "{bad}");
        }
    }

    #[test]
    fn frames_are_found_read_and_compared() {
        let folder = tempfile::tempdir().unwrap();
        let put =
            |frame: u32, text: &str| std::fs::write(folder.path().join(format!("w.{frame:04}.obj")), text).unwrap();
        put(3, "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n");
        put(5, "v 0 0 9\nv 1 0 0\nv 0 1 0\nf 1 2 3\n");
        put(6, "v 0 0 9\nv 1 0 0\nv 0 1 0\nf 2 1 3\n");
        std::fs::write(folder.path().join("w.txt"), "").unwrap();
        let context = Context::serial();
        let mut sequence = Sequence::open(&folder.path().join("w.####.obj")).unwrap();
        assert_eq!(sequence.frames(), [3, 5, 6]);
        assert_eq!([0, 3, 4, 5, 99].map(|frame| sequence.nearest(frame)), [3, 3, 3, 5, 6]);
        assert_eq!(sequence.read(&context, 3).unwrap().points[0], [0.0; 3]);
        assert_eq!(sequence.read(&context, 5).unwrap().points[0], [0.0, 0.0, 9.0]);
        assert!(sequence.read(&context, 6).unwrap_err().to_string().contains("not connected"));
        assert!(sequence.read(&context, 4).unwrap_err().to_string().contains("use 3 to 6"));
        assert!(Sequence::open(&folder.path().join("x.####.obj")).is_err());
        assert!(Sequence::open(&folder.path().join("w.obj")).is_err());
    }
}
