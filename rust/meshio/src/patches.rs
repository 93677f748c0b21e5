//! Files of Bézier patches: `.bpt`, and lists of indices and points as of Newell's tea set.
//!
//! A `.bpt` file is text: the number of patches; for each the two degrees, then its control points, one a line, row by
//! row: the first degree counts rows, the second points in a row. A fourth number of a point is its weight. Degrees of 1
//! and 2 are raised to 3, which changes no point of the surface. The other kind has the number of patches, sixteen
//! indices from 1 a line, the number of points, and a point a line, with commas between numbers.

use std::fmt;
use std::io::Write;
use std::path::Path;

use relievo_core::{Context, Error, Result, file};

use crate::budget::Budget;
use crate::obj::writer::Shortest;
use crate::text::{Words, at_line, expect_finite, finite, integer, shown};

/// Control points of a patch, and of a patch's row.
const CONTROLS: usize = 16;
const ROW: usize = 4;

/// Bicubic Bézier patches of a file: sixteen control points each, row by row.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Patches {
    /// Control points.
    pub points: Vec<[f32; 3]>,
    /// The point of every control point, patch after patch.
    pub indices: Vec<u32>,
    /// The weight of every point, if the file has some.
    pub weights: Option<Vec<f32>>,
}

impl Patches {
    /// Number of patches.
    pub fn count(&self) -> usize {
        self.indices.len() / CONTROLS
    }
}

impl fmt::Display for Patches {
    fn fmt(&self, out: &mut fmt::Formatter<'_>) -> fmt::Result {
        let kind = if self.weights.is_some() { "rational bicubic" } else { "bicubic" };
        writeln!(out, "  {} {kind} Bézier patches", self.count())?;
        write!(out, "  {} control points", self.points.len())
    }
}

/// Whether a file begins as one of patches does.
pub(crate) fn is_patches(bytes: &[u8]) -> bool {
    let mut lines = Lines::new(bytes);
    let counted = lines.next_line().is_some_and(|line| integer(line).is_some());
    let Some(second) = lines.next_line().filter(|_| counted) else { return false };
    let fields = |separator: fn(&u8) -> bool| {
        let fields = second.split(separator).map(<[u8]>::trim_ascii).filter(|field| !field.is_empty());
        fields.map(integer).try_fold(0, |count, number| number.map(|_| count + 1))
    };
    fields(u8::is_ascii_whitespace) == Some(2) || fields(|byte| *byte == b',') == Some(CONTROLS)
}

/// Reads a file of patches of either kind, which its second line tells.
///
/// # Errors
/// The system refuses, the file is neither, or what [`parse_patches`] finds.
pub fn read_patches(context: &Context, path: &Path) -> Result<Patches> {
    let limit = context.memory_limit();
    let bytes = file::load(path, limit)?;
    let left = limit - bytes.len() as u64;
    parse_patches(&bytes, left).map_err(|error| error.at(path.display().to_string()))
}

/// Reads the bytes of a file of patches of either kind. `memory_limit` bounds in bytes what is allocated.
///
/// # Errors
/// With the line: the file ends too early or goes on too long, a number cannot be read, is not finite, or refers to
/// nothing, a degree is not 1, 2 or 3, a weight is not above zero, or weights are given for some points only.
pub fn parse_patches(bytes: &[u8], memory_limit: u64) -> Result<Patches> {
    if !is_patches(bytes) {
        return Err(Error::unsupported("the file holds no Bézier patches")
            .advise("use .bpt, or the number of patches and sixteen indices a line"));
    }
    let mut lines = Lines::new(bytes);
    lines.next_line();
    let indexed = lines.next_line().is_some_and(|line| line.contains(&b','));
    let budget = Budget::new(memory_limit);
    if indexed { parse_indexed(bytes, budget) } else { parse_bpt(bytes, budget) }
}

/// Lines that are not empty, without comments and blanks at their ends.
struct Lines<'a> {
    words: Words<'a>,
}

impl<'a> Lines<'a> {
    fn new(bytes: &'a [u8]) -> Self {
        Self { words: Words::new(bytes) }
    }

    fn next_line(&mut self) -> Option<&'a [u8]> {
        loop {
            let text = self.words.rest_of_line();
            let text = text.split(|byte| *byte == b'#').next().unwrap_or_default().trim_ascii();
            if !text.is_empty() {
                return Some(text);
            }
            if !self.words.next_line() {
                return None;
            }
        }
    }

    /// An error at the line that was read last.
    fn wrong(&self, what: String) -> Error {
        at_line(Error::invalid(what), self.words.line())
    }

    fn expect(&mut self, what: &str) -> Result<&'a [u8]> {
        let line = self.next_line();
        line.ok_or_else(|| self.wrong(format!("{what} is missing")).advise("the file is cut off"))
    }

    /// A count on a line of its own, of things that take at least `bytes` bytes of the file each.
    fn count(&mut self, what: &str, bytes: usize, length: usize) -> Result<usize> {
        let line = self.expect(&format!("the number of {what}"))?;
        let count = integer(line).and_then(|count| usize::try_from(count).ok());
        count.filter(|count| *count > 0 && *count <= length / bytes).ok_or_else(|| {
            self.wrong(format!("the number of {what}, {}, cannot be right", shown(line)))
                .advise("the file is cut off or no file of patches")
        })
    }

    fn finish(&mut self) -> Result<()> {
        match self.next_line() {
            Some(line) => Err(self
                .wrong(format!("there is more behind the last: {}", shown(line)))
                .advise("correct the counts of the file")),
            None => Ok(()),
        }
    }
}

/// Numbers between commas.
fn fields(line: &[u8]) -> impl Iterator<Item = &[u8]> {
    line.split(|byte| *byte == b',').map(<[u8]>::trim_ascii)
}

fn parse_indexed(bytes: &[u8], mut budget: Budget) -> Result<Patches> {
    let mut lines = Lines::new(bytes);
    let count = lines.count("patches", 2 * CONTROLS, bytes.len())?;
    let mut indices = budget.filled(count * CONTROLS, 0u32)?;
    for (patch, into) in indices.chunks_exact_mut(CONTROLS).enumerate() {
        let line = lines.expect(&format!("patch {patch}"))?;
        let mut found = 0;
        for field in fields(line) {
            let index = integer(field).and_then(|index| u32::try_from(index).ok()).filter(|index| *index > 0);
            let index = index.ok_or_else(|| {
                lines.wrong(format!("{} is no index", shown(field))).advise("indices of points count from 1")
            })?;
            if let Some(into) = into.get_mut(found) {
                *into = index - 1;
            }
            found += 1;
        }
        if found != CONTROLS {
            return Err(lines.wrong(format!("patch {patch} has {found} indices")).advise("use 16 for every patch"));
        }
    }
    let point_count = lines.count("points", 6, bytes.len())?;
    let mut points = budget.filled(point_count, [0.0; 3])?;
    for (index, point) in points.iter_mut().enumerate() {
        let line = lines.expect(&format!("point {index}"))?;
        let numbers = fields(line).count();
        if numbers != 3 {
            return Err(lines.wrong(format!("point {index} has {numbers} numbers")).advise("use x,y,z"));
        }
        for (value, field) in point.iter_mut().zip(fields(line)) {
            *value = expect_finite(Some(field), lines.words.line(), "a coordinate")?;
        }
    }
    lines.finish()?;
    if let Some(place) = indices.iter().position(|index| *index as usize >= point_count) {
        let index = u64::from(indices[place]) + 1;
        return Err(Error::invalid(format!("point {index} does not exist"))
            .at(format!("patch {}", place / CONTROLS))
            .advise(format!("use 1 to {point_count}")));
    }
    Ok(Patches { points, indices, weights: None })
}

fn parse_bpt(bytes: &[u8], mut budget: Budget) -> Result<Patches> {
    let mut lines = Lines::new(bytes);
    // The smallest patch is bilinear.
    let count = lines.count("patches", 4 + 4 * 6, bytes.len())?;
    let mut points = Vec::new();
    budget.reserve(&mut points, count * CONTROLS)?;
    let mut weights = Vec::new();
    budget.reserve(&mut weights, count * CONTROLS)?;
    let mut weighted = None;
    for patch in 0..count {
        let at = |error: Error| error.at(format!("patch {patch}"));
        let wrong = |lines: &Lines, what: String| at_line(at(Error::invalid(what)), lines.words.line());
        let line = lines.expect(&format!("patch {patch}"))?;
        let mut words = Words::new(line);
        let mut degree = || words.next_in_line().and_then(integer);
        let degrees = [degree(), degree()];
        let degrees = match (degrees, words.next_in_line()) {
            ([Some(rows @ 1..=3), Some(columns @ 1..=3)], None) => [rows as usize, columns as usize],
            ([Some(_), Some(_)], None) => {
                return Err(wrong(&lines, format!("its degrees are {}", shown(line)))
                    .advise("use degrees of 1, 2 or 3; raise or approximate others"));
            }
            _ => {
                return Err(wrong(&lines, format!("its degrees are expected and not {}", shown(line)))
                    .advise("use two whole numbers, then one control point a line"));
            }
        };
        // x·w, y·w, z·w, w of a grid of up to 4 × 4.
        let mut grid = [[[0.0f64; 4]; ROW]; ROW];
        for j in 0..=degrees[0] {
            for (i, control) in grid[j].iter_mut().take(degrees[1] + 1).enumerate() {
                let number = j * (degrees[1] + 1) + i;
                let line = lines.expect(&format!("control point {number} of patch {patch}"))?;
                let here = lines.words.line();
                let mut words = Words::new(line);
                let mut values = [0.0, 0.0, 0.0, 1.0];
                for value in values.iter_mut().take(3) {
                    *value = f64::from(expect_finite(words.next_in_line(), here, "a coordinate")?);
                }
                let weight = words.next_in_line();
                if let Some(word) = weight {
                    let weight = finite(word).filter(|weight| *weight > 0.0).ok_or_else(|| {
                        wrong(&lines, format!("the weight {} is not above zero", shown(word)))
                            .advise("use one control point a line, with x, y, z and perhaps a weight")
                    })?;
                    values[3] = f64::from(weight);
                }
                if words.next_in_line().is_some() {
                    return Err(wrong(&lines, "there are more than four numbers".into())
                        .advise("use one control point a line, with x, y, z and perhaps a weight"));
                }
                if *weighted.get_or_insert(weight.is_some()) != weight.is_some() {
                    return Err(wrong(&lines, "some points have weights and some have none".into())
                        .advise("give weights for all points or for none"));
                }
                let w = values[3];
                *control = [values[0] * w, values[1] * w, values[2] * w, w];
            }
        }
        raise(&mut grid, degrees);
        for control in grid.as_flattened() {
            let [x, y, z, w] = *control;
            // What is not weighted is not touched by a division.
            let point = if weighted == Some(true) { [x / w, y / w, z / w] } else { [x, y, z] };
            points.push(point.map(|value| value as f32));
            weights.push(w as f32);
        }
        if points.iter().rev().take(CONTROLS).flatten().any(|value| !value.is_finite())
            || weights.iter().rev().take(CONTROLS).any(|weight| !(weight.is_finite() && *weight > 0.0))
        {
            return Err(wrong(&lines, "its numbers are too large or too small".into()).advise("scale the model"));
        }
    }
    lines.finish()?;
    let mut indices = Vec::new();
    budget.reserve(&mut indices, points.len())?;
    indices.extend(0..points.len() as u32);
    Ok(Patches { points, indices, weights: weighted.filter(|weighted| *weighted).map(|_| weights) })
}

/// Raises the degrees of a patch to 3, first within rows, then from row to row.
fn raise(grid: &mut [[[f64; 4]; ROW]; ROW], [rows, columns]: [usize; 2]) {
    for degree in columns..3 {
        for row in grid.iter_mut().take(rows + 1) {
            *row = raised(row, degree);
        }
    }
    for degree in rows..3 {
        for column in 0..ROW {
            let curve = raised(&[0, 1, 2, 3].map(|row| grid[row][column]), degree);
            for (row, control) in grid.iter_mut().zip(curve) {
                row[column] = control;
            }
        }
    }
}

/// The control points, one more, of a curve of `degree` 1 or 2.
fn raised(curve: &[[f64; 4]; ROW], degree: usize) -> [[f64; 4]; ROW] {
    let share = |index: usize| index as f64 / (degree + 1) as f64;
    std::array::from_fn(|index| match index {
        0 => curve[0],
        _ if index <= degree => {
            std::array::from_fn(|k| share(index) * curve[index - 1][k] + (1.0 - share(index)) * curve[index][k])
        }
        _ if index == degree + 1 => curve[degree],
        _ => [0.0; 4],
    })
}

/// Writes patches as `.bpt`, with weights where there are some. Numbers are read back to the bit.
///
/// # Errors
/// Indices or weights do not fit, or the system refuses; then no file is left.
pub fn write_bpt(path: &Path, patches: &Patches) -> Result<()> {
    let wrong = |what: &str| Err(Error::invalid(what).at(path.display().to_string()));
    if patches.indices.is_empty() || !patches.indices.len().is_multiple_of(CONTROLS) {
        return wrong("the number of control points is not 16 for every patch");
    }
    if patches.indices.iter().any(|index| *index as usize >= patches.points.len())
        || patches.weights.as_ref().is_some_and(|weights| weights.len() != patches.points.len())
    {
        return wrong("an index or a weight belongs to no point");
    }
    file::store(path, |out| {
        writeln!(out, "{}", patches.count())?;
        for sixteen in patches.indices.chunks_exact(CONTROLS) {
            writeln!(out, "3 3")?;
            for index in sixteen {
                let [x, y, z] = patches.points[*index as usize].map(Shortest);
                write!(out, "{x} {y} {z}")?;
                if let Some(weights) = &patches.weights {
                    write!(out, " {}", Shortest(weights[*index as usize]))?;
                }
                writeln!(out)?;
            }
        }
        Ok(())
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    fn bpt(degrees: [usize; 2], weight: &str) -> String {
        let mut text = format!("1\n{} {}\n", degrees[0], degrees[1]);
        for j in 0..=degrees[0] {
            for i in 0..=degrees[1] {
                text += &format!("{} {} {}{weight}\n", i as f32 / degrees[1] as f32, j, (i * j) as f32 * 0.5);
            }
        }
        text
    }

    fn at(patches: &Patches, u: f64, v: f64) -> [f64; 4] {
        let basis = |t: f64| {
            let s = 1.0 - t;
            [s * s * s, 3.0 * t * s * s, 3.0 * t * t * s, t * t * t]
        };
        let mut sum = [0.0; 4];
        for (number, index) in patches.indices.iter().enumerate() {
            let weight = patches.weights.as_ref().map_or(1.0, |weights| f64::from(weights[*index as usize]));
            let share = basis(u)[number % 4] * basis(v)[number / 4] * weight;
            let [x, y, z] = patches.points[*index as usize].map(f64::from);
            sum = [sum[0] + share * x, sum[1] + share * y, sum[2] + share * z, sum[3] + share];
        }
        [sum[0] / sum[3], sum[1] / sum[3], sum[2] / sum[3], sum[3]]
    }

    #[test]
    fn lower_degrees_are_raised_exactly() {
        // z = i·j / 2 of a bilinear patch is u·v / 2; of quadratic rows its control points are those of 2·u·v.
        for (degrees, height) in
            [([1, 1], 0.5), ([1, 2], 1.0), ([2, 1], 1.0), ([2, 2], 2.0), ([3, 3], 4.5), ([3, 1], 1.5)]
        {
            let patches = parse_patches(bpt(degrees, "").as_bytes(), 1 << 20).unwrap();
            assert_eq!((patches.count(), patches.points.len(), &patches.weights), (1, 16, &None));
            for (u, v) in [(0.0, 0.0), (0.3, 0.9), (1.0, 0.5), (0.25, 0.75)] {
                let got = at(&patches, u, v);
                let expected = [u, v * degrees[0] as f64, height * u * v];
                assert!((0..3).all(|axis| (got[axis] - expected[axis]).abs() < 1e-6), "{degrees:?}: {got:?}");
            }
        }
    }

    #[test]
    fn a_quarter_of_a_circle_stays_one() {
        let weight = std::f64::consts::FRAC_1_SQRT_2;
        let mut text = "1 # a cylinder\n\n1 2\n".to_string();
        for z in 0..2 {
            text += &format!("1 0 {z} 1\n1 1 {z} {weight}\n0 1 {z} 1\n");
        }
        let patches = parse_patches(text.as_bytes(), 1 << 20).unwrap();
        assert!(patches.weights.is_some());
        for step in 0..=10 {
            let [x, y, z, _] = at(&patches, f64::from(step) / 10.0, 0.25);
            assert!((x.hypot(y) - 1.0).abs() < 1e-6 && (z - 0.25).abs() < 1e-6);
        }
    }

    #[test]
    fn what_is_written_is_read_back() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a.bpt");
        for weight in ["", " 0.7"] {
            let patches = parse_patches(bpt([2, 3], weight).as_bytes(), 1 << 20).unwrap();
            write_bpt(&path, &patches).unwrap();
            assert_eq!(read_patches(&Context::serial(), &path).unwrap().points, patches.points);
        }
        let indexed = "2\n1,2,3,4,5,6,7,8,9,10,11,12,13,14,15,16\n4,3,2,1,8,7,6,5,12,11,10,9,16,15,14,13\n16\n"
            .to_string()
            + &(0..16).map(|i| format!("{},{},0.1\n", i % 4, i / 4)).collect::<String>();
        let patches = parse_patches(indexed.as_bytes(), 1 << 20).unwrap();
        assert_eq!((patches.count(), patches.points.len(), patches.indices[16]), (2, 16, 3));
        write_bpt(&path, &patches).unwrap();
        let again = read_patches(&Context::serial(), &path).unwrap();
        assert_eq!(again.points.len(), 32);
        assert_eq!(again.points[16], patches.points[3]);
    }

    #[test]
    fn broken_files_are_refused_with_their_line() {
        let cases = [
            ("", "the file holds no"),
            ("v 1 2 3\nf 1 2 3\n", "the file holds no"),
            ("9\n3 3\n0 0 0\n", "line 1: the number of patches, \"9\""),
            ("-1\n3 3\n0 0 0\n", "line 1: the number of patches"),
            (&bpt([3, 3], "").replace("3 3", "4 3"), "line 2: patch 0: its degrees are \"4 3\""),
            (&bpt([3, 3], "").replace("3 3", "0 3"), "line 2: patch 0: its degrees are"),
            (&bpt([2, 2], "").replace("0 1 0\n", ""), "line 11: control point 8 of patch 0 is missing"),
            (&bpt([1, 1], "").replace("1 1 0.5", "1 1"), "line 6: a coordinate is missing"),
            (&bpt([1, 1], "").replace("1 1 0.5", "1 nan 1"), "line 6: a coordinate \"nan\" is not finite"),
            (&bpt([1, 1], " 0"), "line 3: patch 0: the weight \"0\" is not above zero"),
            (&bpt([1, 1], " 1 2"), "line 3: patch 0: there are more than four numbers"),
            (&bpt([1, 1], "").replace("1 1 0.5", "1 1 0.5 1"), "line 6: patch 0: some points have weights"),
            (&(bpt([1, 1], "") + "1 2 3\n"), "line 7: there is more behind the last"),
        ];
        for (text, expected) in cases {
            let message = parse_patches(text.as_bytes(), 1 << 20).unwrap_err().to_string();
            assert!(message.contains(expected), "{message:?} for {text:?}");
        }
        let row = "1,2,3,4,5,6,7,8,9,10,11,12,13,14,15,16";
        let points = "0,0,0\n".repeat(16);
        let refused = |text: String, expected: &str| {
            let message = parse_patches(text.as_bytes(), 1 << 20).unwrap_err().to_string();
            assert!(message.contains(expected), "{message:?} for {text:?}");
        };
        refused(format!("1\n{row}\n15\n{}", "0,0,0\n".repeat(15)), "patch 0: point 16 does not exist");
        refused(format!("1\n{row}\n99\n{points}"), "line 3: the number of points");
        refused(format!("1\n{row}\n16\n{}", points.replacen("0,0,0", "0,0", 1)), "line 4: point 0 has 2 numbers");
        refused(format!("1\n{}\n16\n{points}", row.replace("16", "0")), "line 2: \"0\" is no index");
        refused(format!("2\n{row}\n1,2\n16\n{points}"), "line 3: patch 1 has 2 indices");
        assert!(parse_patches(bpt([3, 3], "").as_bytes(), 100).is_err());
    }
}
