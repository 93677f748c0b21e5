//! Particles of VTK's legacy files, as text or binary: the points of POLYDATA and UNSTRUCTURED_GRID and the arrays of
//! POINT_DATA (Schroeder, Martin, Lorensen 2006, "VTK File Formats"; versions 1 to 5). The array `id` has the particles'
//! numbers; of the arrays of the whole, `TIME` is the time and `spacing` the spacing.

use relievo_core::{Budget, Error, Result};

use crate::bytes::cut_off;
use crate::particles::{Channel, MAX, MAX_CHANNELS};
use crate::read::Read;
use crate::vtk_words::{Kind, Words};

pub(crate) const MAGIC: &[u8] = b"# vtk DataFile Version";
pub(crate) const NUMBER: &str = "id";
pub(crate) const TIME: &str = "TIME";
pub(crate) const SPACING: &str = "spacing";
/// The newest version whose cells are known.
const NEWEST: u32 = 5;

/// Reads a legacy VTK file. `memory_limit` bounds in bytes what is allocated for it. Arrays that no channel can hold are
/// left out with a note.
///
/// # Errors
/// Fails with `Invalid`, and the section, if the file ends too early, a number cannot be read or is not finite, or
/// there are no points; with `Unsupported` if it is of a newer version or a grid without points of its own; and with
/// `Memory` above the limit.
pub fn read_vtk(bytes: &[u8], memory_limit: u64) -> Result<Read> {
    let mut words = Words::new(bytes);
    let version = words.line()?.strip_prefix("# vtk DataFile Version").map(str::trim);
    let version = version.and_then(|version| version.split('.').next()?.parse::<u32>().ok());
    let Some(version) = version else {
        return Err(Error::invalid("the file does not begin with `# vtk DataFile Version`")
            .advise("check that it is a legacy VTK file"));
    };
    if version > NEWEST {
        return Err(Error::unsupported(format!("it is of version {version}"))
            .advise(format!("save it as version {NEWEST} or older")));
    }
    // The title may be of any bytes.
    let _ = words.line();
    let is_text = match words.line()? {
        "ASCII" => true,
        "BINARY" => false,
        other => {
            return Err(Error::invalid(format!("numbers are as {other:?}")).at("line 3").advise("use ASCII or BINARY"));
        }
    };
    words.is_text = is_text;
    let mut reader = Reader {
        words,
        version,
        budget: Budget::new(memory_limit),
        read: Read::default(),
        count: None,
        part: Part::Whole,
    };
    while let Some(line) = reader.words.next_line()? {
        let line: Vec<&str> = line.split_ascii_whitespace().collect();
        reader.section(&line).map_err(|error| error.at(format!("section {}", shown(line[0]))))?;
    }
    if reader.count.is_none() {
        return Err(Error::invalid("there are no POINTS").advise("save particles as polydata"));
    }
    reader.read.particles.check()?;
    Ok(reader.read)
}

/// What the arrays that follow belong to.
#[derive(Clone, Copy, PartialEq)]
enum Part {
    Whole,
    Points,
    Cells(u64),
}

struct Reader<'a> {
    words: Words<'a>,
    version: u32,
    budget: Budget,
    read: Read,
    /// How many points there are.
    count: Option<u64>,
    part: Part,
}

impl Reader<'_> {
    /// Reads a section that begins with a line of these words; there is one at least.
    fn section(&mut self, line: &[&str]) -> Result<()> {
        let word = |at: usize| line.get(at).copied().unwrap_or_default();
        let number = |at: usize| {
            let number: Option<u64> = word(at).parse().ok();
            number.ok_or_else(|| Error::invalid(format!("{:?} is not a count", shown(word(at)))))
        };
        match line[0] {
            "DATASET" if matches!(word(1), "POLYDATA" | "UNSTRUCTURED_GRID") => Ok(()),
            "DATASET" => Err(Error::unsupported(format!("a dataset {} has no particles", shown(word(1))))
                .advise("save particles as POLYDATA or UNSTRUCTURED_GRID")),
            "POINTS" => self.points(number(1)?, Kind::named(word(2))?),
            "VERTICES" | "LINES" | "POLYGONS" | "TRIANGLE_STRIPS" | "CELLS" => self.cells(number(1)?, number(2)?),
            "CELL_TYPES" => self.words.skip(number(1)?, Kind::I32),
            "POINT_DATA" => {
                self.part = Part::Points;
                let count = self.count.unwrap_or_default();
                match number(1)? {
                    given if given == count => Ok(()),
                    given => Err(Error::invalid(format!("there are values for {given} points, and {count} points"))),
                }
            }
            "CELL_DATA" => {
                self.part = Part::Cells(number(1)?);
                Ok(())
            }
            "FIELD" => (0..number(2)?).try_for_each(|_| self.field()),
            "SCALARS" => {
                let width = if line.len() > 3 { number(3)? } else { 1 };
                if self.words.continues("LOOKUP_TABLE") {
                    self.words.next_line()?;
                }
                self.array(word(1), width, self.rows(), Kind::named(word(2))?)
            }
            "VECTORS" | "NORMALS" => self.array(word(1), 3, self.rows(), Kind::named(word(2))?),
            "TEXTURE_COORDINATES" => self.array(word(1), number(2)?, self.rows(), Kind::named(word(3))?),
            "TENSORS" => self.array(word(1), 9, self.rows(), Kind::named(word(2))?),
            "TENSORS6" => self.array(word(1), 6, self.rows(), Kind::named(word(2))?),
            "GLOBAL_IDS" | "PEDIGREE_IDS" | "EDGE_FLAGS" => self.array(word(1), 1, self.rows(), Kind::named(word(2))?),
            "COLOR_SCALARS" => self.array(word(1), number(2)?, self.rows(), Kind::U8),
            "LOOKUP_TABLE" => self.words.skip(number(2)?.checked_mul(4).ok_or_else(cut_off)?, Kind::U8),
            "METADATA" => {
                while !self.words.line()?.is_empty() {}
                Ok(())
            }
            _ => Err(Error::unsupported("the section is not known").advise("leave it out of the export")),
        }
    }

    /// Values an array has.
    fn rows(&self) -> u64 {
        match self.part {
            Part::Whole => 0,
            Part::Points => self.count.unwrap_or_default(),
            Part::Cells(count) => count,
        }
    }

    fn points(&mut self, count: u64, kind: Kind) -> Result<()> {
        if self.count.is_some() || count > MAX {
            return Err(Error::unsupported("there are too many points, or a second list of them"));
        }
        let numbers = self.words.numbers(count.checked_mul(3).ok_or_else(cut_off)?, kind, &mut self.budget)?;
        let points = &mut self.read.particles.points;
        self.budget.reserve(points, count as usize)?;
        points.extend(numbers.as_chunks().0.iter().map(|[x, y, z]| [*x, *y, *z].map(|value| value as f32)));
        self.count = Some(count);
        Ok(())
    }

    /// Steps over cells: before version 5 their sizes and points in one list, then their beginnings and their points.
    fn cells(&mut self, first: u64, second: u64) -> Result<()> {
        if self.version < 5 {
            return self.words.skip(second, Kind::I32);
        }
        for (name, count) in [("OFFSETS", first), ("CONNECTIVITY", second)] {
            let line = self.words.next_line()?.unwrap_or_default();
            let kind = line.strip_prefix(name).ok_or_else(|| Error::invalid(format!("there is no list {name}")))?;
            self.words.skip(count, Kind::named(kind.trim())?)?;
        }
        Ok(())
    }

    /// An array of a FIELD.
    fn field(&mut self) -> Result<()> {
        let mut line = self.words.next_line()?.ok_or_else(cut_off)?;
        while line == "METADATA" {
            while !self.words.line()?.is_empty() {}
            line = self.words.next_line()?.ok_or_else(cut_off)?;
        }
        let line: Vec<&str> = line.split_ascii_whitespace().collect();
        let [name, width, rows, kind] = line[..] else {
            return Err(Error::invalid("an array has not name, width, count and type").at("FIELD"));
        };
        let count = |text: &str| {
            text.parse().map_err(|_| Error::invalid(format!("{:?} is not a count", shown(text))).at(shown(name)))
        };
        let (width, rows, kind) = (count(width)?, count(rows)?, Kind::named(kind)?);
        self.array(name, width, rows, kind).map_err(|error| error.at(shown(name)))
    }

    fn array(&mut self, name: &str, width: u64, rows: u64, kind: Kind) -> Result<()> {
        let name = decode(name);
        let total = width.checked_mul(rows).ok_or_else(cut_off)?;
        let particles = &mut self.read.particles;
        if self.part == Part::Whole && total == 1 && matches!(name.as_str(), TIME | SPACING) {
            let value = self.words.numbers(1, kind, &mut self.budget)?[0];
            match name == TIME {
                true => particles.time = Some(value),
                false => particles.spacing = Some(value as f32),
            }
            return Ok(());
        }
        let is_taken = particles.channel(&name).is_some() || (name == NUMBER && particles.numbers.is_some());
        let fits = (1..=4).contains(&width) && (1..=255).contains(&name.len()) && !is_taken;
        let is_there = self.part == Part::Points && Some(rows) == self.count;
        if !fits || !is_there || particles.channels.len() >= MAX_CHANNELS {
            if self.part == Part::Points && self.read.notes.len() < MAX_CHANNELS {
                self.read.notes.push(format!("the array {:?} is left out", shown(&name)));
            }
            return self.words.skip(total, kind);
        }
        let numbers = self.words.numbers(total, kind, &mut self.budget)?;
        let is_whole = |number: &f64| number.fract() == 0.0 && *number >= 0.0 && *number <= f64::from(u32::MAX);
        if name == NUMBER && width == 1 && numbers.iter().all(is_whole) {
            let mut list = Vec::new();
            self.budget.reserve(&mut list, numbers.len())?;
            list.extend(numbers.iter().map(|number| *number as u32));
            particles.numbers = Some(list);
            return Ok(());
        }
        let mut values = Vec::new();
        self.budget.reserve(&mut values, numbers.len())?;
        values.extend(numbers.iter().map(|number| *number as f32));
        particles.channels.push(Channel { name, width: width as u32, values });
        Ok(())
    }
}

/// A name whose bytes that are no letters are written as `%20`.
fn decode(name: &str) -> String {
    let mut bytes = Vec::with_capacity(name.len());
    let mut rest = name.as_bytes();
    while let Some((first, tail)) = rest.split_first() {
        let digits = tail.get(..2).filter(|_| *first == b'%').and_then(|digits| std::str::from_utf8(digits).ok());
        match digits.and_then(|digits| u8::from_str_radix(digits, 16).ok()) {
            Some(byte) => {
                bytes.push(byte);
                rest = &tail[2..];
            }
            None => {
                bytes.push(*first);
                rest = tail;
            }
        }
    }
    String::from_utf8_lossy(&bytes).into_owned()
}

/// A text of a file as an error shows it.
fn shown(text: &str) -> String {
    text.chars().take(40).collect()
}

/// Why a file that begins so is none of ours, where it is VTK's XML.
pub(crate) fn refusal(head: &[u8]) -> Option<Error> {
    let is_xml = head.windows(8).any(|window| window == b"<VTKFile");
    is_xml.then(|| Error::unsupported("it is VTK's XML form").advise("save it as a legacy .vtk file, or as PLY"))
}
