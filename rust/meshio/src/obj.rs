//! Wavefront OBJ: polygons, with the tags (`t crease`, `t corner`, `t hole`) of OpenSubdiv's shape files.
//!
//! `vt` becomes the corner attribute `uv`, `vn` the attribute `normal` (on points where its indices are those of `v`,
//! on corners otherwise), colours behind `v` the point attribute `color` (taken as linear), `usemtl` the face
//! attribute `material`, `g` and `o` the face attribute `group`. No other file is opened.

pub(crate) mod writer;

use std::collections::HashMap;

use relievo_core::mesh::INFINITE_SHARPNESS;
use relievo_core::{Attribute, Crease, Domain, Error, Mesh, Result, Values};

use crate::budget::Budget;
use crate::model::Model;
use crate::notes::Notes;
use crate::text::{Words, at_line, expect_finite, integer, number, shown};

/// Stands for an index that a corner does not give, until the whole file is read.
const MISSING: u32 = u32::MAX;

/// Reads an OBJ file. `memory_limit` bounds in bytes what is allocated for it.
///
/// # Errors
/// Fails with `Invalid`, and the line, if a number cannot be read or is not finite, or an index refers to nothing, with
/// `Unsupported` for 2³² or more corners, and with `Memory` above the limit.
pub fn read_obj(bytes: &[u8], memory_limit: u64) -> Result<Model> {
    let mut reader = Reader::new(memory_limit);
    let mut words = Words::new(bytes).with_comments(b'#').with_continuation();
    loop {
        if let Some(keyword) = words.next_in_line() {
            reader.statement(keyword, &mut words)?;
        }
        if !words.next_line() {
            return reader.finish();
        }
    }
}

/// A list that corners index, and the largest index so far with its line.
#[derive(Default)]
struct Indexed {
    numbers: Vec<f32>,
    width: usize,
    indices: Vec<u32>,
    largest: Option<(u32, u64)>,
    missing: bool,
}

impl Indexed {
    fn of(width: usize) -> Self {
        Self { width, ..Self::default() }
    }

    fn count(&self) -> usize {
        self.numbers.len() / self.width
    }

    /// The index that the file writes as `written`, counted from 1 or back from the end.
    #[inline]
    fn index(&mut self, written: i64, line: u64, what: &str) -> Result<u32> {
        let count = self.count() as i64;
        let index = if written < 0 { count + written } else { written - 1 };
        match u32::try_from(index) {
            Ok(index) if written != 0 && index != MISSING => {
                if self.largest.is_none_or(|(largest, _)| index > largest) {
                    self.largest = Some((index, line));
                }
                Ok(index)
            }
            _ => Err(at_line(no_such(written, what, count as usize), line)),
        }
    }

    /// Adds the index of corner `corner`, with gaps before it marked.
    #[inline]
    fn put(&mut self, budget: &mut Budget, corner: usize, index: u32) -> Result<()> {
        while self.indices.len() < corner {
            budget.push(&mut self.indices, MISSING)?;
            self.missing = true;
        }
        budget.push(&mut self.indices, index)
    }

    /// Fails if an index refers behind the end.
    fn check(&self, what: &str) -> Result<()> {
        match self.largest {
            Some((index, line)) if index as usize >= self.count() => {
                Err(at_line(no_such(i64::from(index) + 1, what, self.count()), line))
            }
            _ => Ok(()),
        }
    }

    /// Gives `corners` corners an index each; those without one get a value of zeros.
    fn close(&mut self, budget: &mut Budget, corners: usize) -> Result<()> {
        if self.indices.len() < corners {
            self.missing = true;
            let gap = corners - self.indices.len();
            budget.reserve(&mut self.indices, gap)?;
            self.indices.resize(corners, MISSING);
        }
        if self.missing {
            let zero = self.count() as u32;
            for _ in 0..self.width {
                budget.push(&mut self.numbers, 0.0)?;
            }
            self.indices.iter_mut().filter(|index| **index == MISSING).for_each(|index| *index = zero);
        }
        Ok(())
    }
}

fn no_such(written: i64, what: &str, count: usize) -> Error {
    let error = Error::invalid(format!("{what} {written} does not exist"));
    match count {
        0 => error.advise(format!("the file has no {what}; add it or remove the reference")),
        _ => error.advise(format!("use 1 to {count}, or -{count} to -1 counted from the end")),
    }
}

/// Named slots that faces refer to: materials or groups.
#[derive(Default)]
struct Slots {
    names: Vec<String>,
    known: HashMap<Vec<u8>, u32>,
    current: u32,
    values: Vec<u32>,
}

impl Slots {
    /// Makes `name` the slot of the faces that follow `faces` faces.
    fn select(&mut self, budget: &mut Budget, name: &[u8], faces: usize) -> Result<()> {
        if self.names.is_empty() && faces > 0 && !name.is_empty() {
            self.select(budget, b"", faces)?;
        }
        if self.values.len() < faces {
            self.values = budget.filled(faces, 0)?;
        }
        if let Some(slot) = self.known.get(name) {
            self.current = *slot;
            return Ok(());
        }
        budget.charge(2 * name.len() as u64 + 128)?;
        self.current = self.names.len() as u32;
        self.names.push(String::from_utf8_lossy(name).into_owned());
        self.known.insert(name.to_vec(), self.current);
        Ok(())
    }

    fn face(&mut self, budget: &mut Budget) -> Result<()> {
        if self.names.is_empty() { Ok(()) } else { budget.push(&mut self.values, self.current) }
    }

    fn into_attribute(self, name: &str) -> Option<Attribute> {
        let indices = None;
        (!self.values.is_empty()).then(|| Attribute {
            name: name.into(),
            domain: Domain::Face,
            width: 1,
            values: Values::U32(self.values),
            indices,
        })
    }
}

struct Reader {
    budget: Budget,
    points: Indexed,
    uvs: Indexed,
    normals: Indexed,
    colors: Vec<f32>,
    face_sizes: Vec<u32>,
    materials: Slots,
    groups: Slots,
    creases: Vec<(Crease, u64)>,
    sharp_points: Vec<(u32, f32, u64)>,
    holes: Vec<(u32, u64)>,
    notes: Notes,
}

impl Reader {
    fn new(memory_limit: u64) -> Self {
        Self {
            budget: Budget::new(memory_limit),
            points: Indexed::of(3),
            uvs: Indexed::of(2),
            normals: Indexed::of(3),
            colors: Vec::new(),
            face_sizes: Vec::new(),
            materials: Slots::default(),
            groups: Slots::default(),
            creases: Vec::new(),
            sharp_points: Vec::new(),
            holes: Vec::new(),
            notes: Notes::default(),
        }
    }

    fn statement(&mut self, keyword: &[u8], words: &mut Words) -> Result<()> {
        match keyword {
            b"v" => self.point(words),
            b"vt" => numbers(&mut self.uvs, &mut self.budget, words, &["u", "v"]),
            b"vn" => numbers(&mut self.normals, &mut self.budget, words, &["nx", "ny", "nz"]),
            b"f" | b"fo" => self.face(words),
            b"t" => self.tag(words),
            b"usemtl" => self.materials.select(&mut self.budget, words.rest_of_line(), self.face_sizes.len()),
            b"g" | b"o" => self.groups.select(&mut self.budget, words.rest_of_line(), self.face_sizes.len()),
            b"mtllib" | b"s" => Ok(()),
            b"l" | b"p" => {
                self.notes.add("lines and points (`l`, `p`) are left out", words.line());
                Ok(())
            }
            _ => {
                self.notes.add(&format!("statements {} are not understood and left out", shown(keyword)), words.line());
                Ok(())
            }
        }
    }

    fn point(&mut self, words: &mut Words) -> Result<()> {
        numbers(&mut self.points, &mut self.budget, words, &["x", "y", "z"])?;
        // Behind the position: nothing, w, r g b, or r g b a.
        let mut extra = [0.0; 3];
        let mut count = 0;
        while let Some(word) = words.next_in_line() {
            let value = number(word)
                .ok_or_else(|| at_line(Error::invalid(format!("{} is not a number", shown(word))), words.line()))?;
            if let Some(slot) = extra.get_mut(count) {
                *slot = value;
            }
            count += 1;
        }
        if count >= 3 {
            let before = 3 * (self.points.count() - 1);
            if self.colors.len() < before {
                // White, the colour of a material that nothing tints.
                let gap = before - self.colors.len();
                self.budget.reserve(&mut self.colors, gap.max(before))?;
                self.colors.resize(before, 1.0);
            }
            for value in extra {
                self.budget.push(&mut self.colors, value)?;
            }
        }
        Ok(())
    }

    fn face(&mut self, words: &mut Words) -> Result<()> {
        let line = words.line();
        let start = self.points.indices.len();
        while let Some(word) = words.next_in_line() {
            let line = words.line();
            let [point, uv, normal] = corner(word).ok_or_else(|| {
                at_line(Error::invalid(format!("the corner {} cannot be read", shown(word))), line)
                    .advise("write v, v/vt, v//vn or v/vt/vn with whole numbers")
            })?;
            let at = self.points.indices.len();
            let point = point.unwrap_or_default();
            let index = self.points.index(point, line, "point")?;
            self.budget.push(&mut self.points.indices, index)?;
            if let Some(uv) = uv {
                let index = self.uvs.index(uv, line, "texture coordinate")?;
                self.uvs.put(&mut self.budget, at, index)?;
            }
            if let Some(normal) = normal {
                let index = self.normals.index(normal, line, "normal")?;
                self.normals.put(&mut self.budget, at, index)?;
            }
        }
        let corners = self.points.indices.len();
        if u32::try_from(corners).is_err() {
            return Err(at_line(Error::unsupported("the file has 2^32 or more corners"), line).advise("split it"));
        }
        if corners == start {
            return Err(at_line(Error::invalid("the face has no corners"), line).advise("remove it"));
        }
        self.materials.face(&mut self.budget)?;
        self.groups.face(&mut self.budget)?;
        self.budget.push(&mut self.face_sizes, (corners - start) as u32)
    }

    /// A tag: a name, how many whole numbers, numbers and words follow, and these.
    fn tag(&mut self, words: &mut Words) -> Result<()> {
        let line = words.line();
        let bad = |what: String| {
            at_line(Error::invalid(what), line).advise("write a tag as `t name integers/floats/strings values…`")
        };
        let name = words.next_in_line().ok_or_else(|| bad("the tag has no name".into()))?;
        let counts = words.next_in_line().ok_or_else(|| bad("the tag has no counts".into()))?;
        let mut parts = counts.split(|byte| *byte == b'/').map(integer);
        let (Some(Some(integers)), Some(Some(floats)), Some(Some(0..)), None) =
            (parts.next(), parts.next(), parts.next(), parts.next())
        else {
            return Err(bad(format!("{} are no counts", shown(counts))));
        };
        if integers < 0 || floats < 0 {
            return Err(bad(format!("{} are no counts", shown(counts))));
        }
        if !matches!(name, b"crease" | b"corner" | b"hole") {
            self.notes.add(&format!("tags {} are left out", shown(name)), line);
            return Ok(());
        }
        // Lists grow with the words that are there, never with the counts.
        let mut elements = Vec::new();
        for _ in 0..integers {
            let word = words.next_in_line().ok_or_else(|| bad("the tag has fewer integers than it says".into()))?;
            let element = integer(word).and_then(|value| u32::try_from(value).ok());
            let element = element.ok_or_else(|| bad(format!("{} is no index counted from 0", shown(word))))?;
            self.budget.push(&mut elements, element)?;
        }
        let mut numbers = Vec::new();
        for _ in 0..floats {
            let value = expect_finite(words.next_in_line(), line, "a number of the tag")?;
            if value < 0.0 {
                return Err(at_line(Error::invalid(format!("the sharpness is {value}")), line)
                    .advise("use 0 or more; 10 and more is infinitely sharp"));
            }
            self.budget.push(&mut numbers, value.min(INFINITE_SHARPNESS))?;
        }
        let sharp = match name {
            b"crease" => elements.len().saturating_sub(1),
            b"corner" => elements.len(),
            _ => 0,
        };
        if sharp > 0 && numbers.len() != 1 && numbers.len() != sharp {
            return Err(bad(format!("the tag has {} sharpnesses for {sharp} elements", numbers.len())));
        }
        let sharpness = |index: usize| if numbers.len() == 1 { numbers[0] } else { numbers[index] };
        match name {
            b"crease" => {
                for (index, pair) in elements.windows(2).enumerate() {
                    let crease = Crease { points: [pair[0], pair[1]], sharpness: sharpness(index) };
                    self.budget.push(&mut self.creases, (crease, line))?;
                }
            }
            b"corner" => {
                for (index, point) in elements.iter().enumerate() {
                    self.budget.push(&mut self.sharp_points, (*point, sharpness(index), line))?;
                }
            }
            _ => {
                for face in &elements {
                    self.budget.push(&mut self.holes, (*face, line))?;
                }
            }
        }
        Ok(())
    }

    fn check_tags(&self) -> Result<()> {
        let points = self.points.count();
        let exists = |index: u32, count: usize, what: &str, line: u64| {
            if (index as usize) < count {
                return Ok(());
            }
            Err(at_line(Error::invalid(format!("{what} {index} of the tag does not exist")), line)
                .advise(format!("tags count from 0; the file has {count} of them")))
        };
        for (crease, line) in &self.creases {
            exists(crease.points[0], points, "point", *line)?;
            exists(crease.points[1], points, "point", *line)?;
            if crease.points[0] == crease.points[1] {
                let what = format!("the crease runs from point {} to itself", crease.points[0]);
                return Err(at_line(Error::invalid(what), *line).advise("name the two ends of an edge"));
            }
        }
        for (point, _, line) in &self.sharp_points {
            exists(*point, points, "point", *line)?;
        }
        for (face, line) in &self.holes {
            exists(*face, self.face_sizes.len(), "face", *line)?;
        }
        Ok(())
    }

    /// Leaves out creases between points that no face joins by an edge, and notes them: they would change nothing.
    fn drop_creases_without_edges(&mut self) -> Result<()> {
        let key = |a: u32, b: u32| (a.min(b), a.max(b));
        let mut wanted = Vec::new();
        self.budget.reserve(&mut wanted, self.creases.len())?;
        wanted.extend(self.creases.iter().map(|(crease, _)| (key(crease.points[0], crease.points[1]), false)));
        wanted.sort_unstable();
        wanted.dedup();
        if wanted.is_empty() {
            return Ok(());
        }
        let mut rest = self.points.indices.as_slice();
        for size in &self.face_sizes {
            let (face, tail) = rest.split_at((*size as usize).min(rest.len()));
            rest = tail;
            for (a, b) in face.iter().zip(face.iter().cycle().skip(1)) {
                if let Ok(at) = wanted.binary_search_by_key(&key(*a, *b), |(edge, _)| *edge) {
                    wanted[at].1 = true;
                }
            }
        }
        let notes = &mut self.notes;
        self.creases.retain(|(crease, line)| {
            let edge = key(crease.points[0], crease.points[1]);
            let found = wanted.binary_search(&(edge, true)).is_ok();
            if !found {
                notes.add("creases between points that no edge joins are left out", *line);
            }
            found
        });
        Ok(())
    }

    fn finish(mut self) -> Result<Model> {
        self.points.check("point")?;
        self.uvs.check("texture coordinate")?;
        self.normals.check("normal")?;
        self.check_tags()?;
        self.drop_creases_without_edges()?;
        let corners = self.points.indices.len();
        let count = self.points.count();
        let mut points = Vec::new();
        self.budget.reserve(&mut points, count)?;
        points.extend_from_slice(self.points.numbers.as_chunks().0);
        let mut attributes = Vec::new();
        if !self.uvs.indices.is_empty() {
            self.uvs.close(&mut self.budget, corners)?;
            attributes.push(indexed("uv", self.uvs));
        }
        if self.normals.indices == self.points.indices && self.normals.count() == count && corners > 0 {
            attributes.push(Attribute {
                name: "normal".into(),
                domain: Domain::Point,
                width: 3,
                values: Values::F32(self.normals.numbers),
                indices: None,
            });
        } else if !self.normals.indices.is_empty() {
            self.normals.close(&mut self.budget, corners)?;
            attributes.push(indexed("normal", self.normals));
        }
        if !self.colors.is_empty() {
            if self.colors.iter().all(|value| value.is_finite()) {
                let gap = 3 * count - self.colors.len();
                self.budget.reserve(&mut self.colors, gap)?;
                self.colors.resize(3 * count, 1.0);
                attributes.push(Attribute {
                    name: "color".into(),
                    domain: Domain::Point,
                    width: 3,
                    values: Values::F32(self.colors),
                    indices: None,
                });
            } else {
                self.notes.add("colours are left out because some are not finite", 0);
            }
        }
        let materials = self.materials.names.clone();
        let groups = self.groups.names.clone();
        attributes.extend(self.materials.into_attribute("material"));
        attributes.extend(self.groups.into_attribute("group"));
        let mesh = Mesh {
            points,
            face_sizes: self.face_sizes,
            corners: self.points.indices,
            attributes,
            creases: self.creases.into_iter().map(|(crease, _)| crease).collect(),
            sharp_points: self.sharp_points.into_iter().map(|(point, sharpness, _)| (point, sharpness)).collect(),
            holes: self.holes.into_iter().map(|(face, _)| face).collect(),
        };
        Ok(Model { materials, groups, notes: self.notes.into_list(), ..Model::from_mesh(mesh) })
    }
}

/// Appends the numbers `names` of this line to a list.
#[inline]
fn numbers(list: &mut Indexed, budget: &mut Budget, words: &mut Words, names: &[&str]) -> Result<()> {
    for name in names {
        // One texture coordinate alone is a one-dimensional texture.
        let word = words.next_in_line();
        let value = match word {
            None if *name == "v" => 0.0,
            _ => expect_finite(word, words.line(), name)?,
        };
        budget.push(&mut list.numbers, value)?;
    }
    Ok(())
}

fn indexed(name: &str, list: Indexed) -> Attribute {
    Attribute {
        name: name.into(),
        domain: Domain::Corner,
        width: list.width as u32,
        values: Values::F32(list.numbers),
        indices: Some(list.indices),
    }
}

/// The point, texture coordinate and normal of a corner as written: `1`, `1/2`, `1//3`, `1/2/3`; parts may be empty
/// except the first.
#[inline]
fn corner(word: &[u8]) -> Option<[Option<i64>; 3]> {
    let mut parts = [None; 3];
    let mut part = 0;
    let mut at = 0;
    loop {
        let negative = word.get(at) == Some(&b'-');
        let start = at + usize::from(negative);
        at = start;
        let mut value = 0i64;
        while let Some(digit @ b'0'..=b'9') = word.get(at) {
            value = value * 10 + i64::from(digit - b'0');
            if value > i64::from(u32::MAX) {
                return None;
            }
            at += 1;
        }
        if at > start {
            parts[part] = Some(if negative { -value } else { value });
        } else if negative || part == 0 {
            return None;
        }
        match word.get(at) {
            None => return Some(parts),
            Some(b'/') if part < 2 => part += 1,
            Some(_) => return None,
        }
        at += 1;
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn read(text: &str) -> Result<Model> {
        read_obj(text.as_bytes(), 1 << 20)
    }

    fn mesh(text: &str) -> Mesh {
        read(text).unwrap().meshes.remove(0).mesh
    }

    const QUAD: &str = "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\n";

    #[test]
    fn corners_take_every_form() {
        assert_eq!(corner(b"1"), Some([Some(1), None, None]));
        assert_eq!(corner(b"1/2"), Some([Some(1), Some(2), None]));
        assert_eq!(corner(b"-1//3"), Some([Some(-1), None, Some(3)]));
        assert_eq!(corner(b"1/2/-3"), Some([Some(1), Some(2), Some(-3)]));
        assert_eq!(corner(b"1//"), Some([Some(1), None, None]));
        assert_eq!(corner(b"1/2/"), Some([Some(1), Some(2), None]));
        for bad in ["", "/1", "-", "1/2/3/4", "1.5", "a", "1/-", "99999999999999999999", "4294967296"] {
            assert_eq!(corner(bad.as_bytes()), None, "{bad}");
        }
    }

    #[test]
    fn a_quad_with_continuation_negative_indices_and_comments() {
        let expected =
            Mesh::new(vec![[0.0; 3], [1.0, 0.0, 0.0], [1.0, 1.0, 0.0], [0.0, 1.0, 0.0]], vec![4], vec![0, 1, 2, 3]);
        assert_eq!(mesh(&format!("{QUAD}f 1 2 3 4\n")), expected);
        assert_eq!(mesh(&format!("{QUAD}f -4 -3 \\\r\n -2 -1 # four")), expected);
        assert_eq!(mesh(&format!("f 1 2 3 4\n{QUAD}")), expected, "points may come behind faces");
        assert_eq!(mesh(&format!("\u{feff}{QUAD}f 1 2 3 4\n")), expected, "with a byte order mark");
    }

    #[test]
    fn texture_coordinates_and_normals_are_indexed_and_gaps_are_zero() {
        let mesh = mesh(&format!("{QUAD}vt .5 1\nvt 1 0 9\nvn 0 0 1\nf 1 2 3\nf 1/2/1 3/1/1 4/1\n"));
        let uv = mesh.attribute("uv").unwrap();
        assert_eq!(uv.values, Values::F32(vec![0.5, 1.0, 1.0, 0.0, 0.0, 0.0]));
        assert_eq!(uv.indices, Some(vec![2, 2, 2, 1, 0, 0]));
        let normal = mesh.attribute("normal").unwrap();
        assert_eq!(normal.domain, Domain::Corner);
        assert_eq!(normal.indices, Some(vec![1, 1, 1, 0, 0, 1]));
        assert_eq!(mesh.check(), Ok(()));
    }

    #[test]
    fn normals_with_the_indices_of_points_sit_on_points() {
        let normals = "vn 0 0 1\n".repeat(4);
        let mesh = mesh(&format!("{QUAD}{normals}f 1//1 2//2 3//3 4//4\n"));
        let normal = mesh.attribute("normal").unwrap();
        assert_eq!((normal.domain, normal.values.len()), (Domain::Point, 12));
    }

    #[test]
    fn colours_that_start_late_are_white_before_and_after() {
        let mesh = mesh("v 0 0 0\nv 1 0 0 .1 .2 .3\nv 0 1 0\nf 1 2 3\n");
        let expected = [1.0, 1.0, 1.0, 0.1, 0.2, 0.3, 1.0, 1.0, 1.0];
        assert_eq!(mesh.attribute("color").unwrap().values, Values::F32(expected.to_vec()));
        assert_eq!(self::mesh("v 0 0 0 1\nv 1 0 0 1\nv 0 1 0 1\nf 1 2 3\n").attribute("color"), None, "w is no colour");
    }

    #[test]
    fn materials_and_groups_keep_their_names() {
        let text =
            format!("{QUAD}f 1 2 3\nusemtl deep snow\ng a\nf 1 3 4\nusemtl ice\nf 1 2 4\nusemtl deep snow\nf 2 3 4");
        let model = read(&text).unwrap();
        assert_eq!(model.materials, ["", "deep snow", "ice"]);
        assert_eq!(model.groups, ["", "a"]);
        let mesh = &model.meshes[0].mesh;
        assert_eq!(mesh.attribute("material").unwrap().values, Values::U32(vec![0, 1, 2, 1]));
        assert_eq!(mesh.attribute("group").unwrap().values, Values::U32(vec![0, 1, 1, 1]));
        assert_eq!(mesh.check(), Ok(()));
    }

    #[test]
    fn creases_without_an_edge_are_left_out_with_a_note() {
        let model =
            read(&format!("{QUAD}f 1 2 3 4\nt crease 2/1/0 0 1 2\nt crease 3/1/0 2 0 1 2\nt crease 2/1/0 1 3 2\n"));
        let model = model.unwrap();
        let edges: Vec<_> = model.meshes[0].mesh.creases.iter().map(|crease| crease.points).collect();
        assert_eq!(edges, [[0, 1], [0, 1]]);
        assert_eq!(model.notes, ["line 7: creases between points that no edge joins are left out (2 times)"]);
    }

    #[test]
    fn tags_become_creases_sharp_points_and_holes() {
        let text = format!(
            "{QUAD}f 1 2 3\nf 1 3 4\nt crease 3/2/0 0 1 2 2.5 99\nt crease 2/1/0 0 3 1\nt corner 2/1/0 1 2 4\nt hole 1/0/0 1\nt interpolateboundary 1/0/0 2\n"
        );
        let model = read(&text).unwrap();
        let mesh = &model.meshes[0].mesh;
        let crease = |a, b, sharpness| Crease { points: [a, b], sharpness };
        assert_eq!(mesh.creases, [crease(0, 1, 2.5), crease(1, 2, 10.0), crease(0, 3, 1.0)]);
        assert_eq!(mesh.sharp_points, [(1, 4.0), (2, 4.0)]);
        assert_eq!(mesh.holes, [1]);
        assert_eq!(model.notes, ["line 11: tags \"interpolateboundary\" are left out"]);
    }

    #[test]
    fn errors_name_the_line_and_the_remedy() {
        let cases = [
            ("v 0 0\n", "line 1: z is missing"),
            ("v 0 0 0\n\nv 1 nan 0\n", "line 3: y \"nan\" is not finite"),
            ("f 1 2 3\n", "line 1: point 3 does not exist; the file has no point"),
            ("v 0 0 0\nf 1 1 2\nf 1 1 9\n", "line 3: point 9 does not exist; use 1 to 1"),
            ("v 0 0 0\nf 1 0 1\n", "line 2: point 0 does not exist"),
            ("v 0 0 0\nf -1 -2 -1\n", "line 2: point -2 does not exist"),
            ("v 0 0 0\nf 1/1 1/2 1/1\nvt 0 0\n", "line 2: texture coordinate 2 does not exist"),
            ("v 0 0 0\nf 1 1\\\n x\n", "line 3: the corner \"x\" cannot be read"),
            ("f\n", "line 1: the face has no corners"),
            ("v 0 0 0\nt crease 2/1/0 0 7 1\n", "line 2: point 7 of the tag does not exist"),
            ("t crease 9/1/0 0 7 1\n", "line 1: the tag has fewer integers"),
            ("t crease 3/3/0 0 1 2 1 1 1\n", "line 1: the tag has 3 sharpnesses for 2 elements"),
            ("t corner 1/1/0 0 -1\n", "line 1: the sharpness is -1"),
            ("t hole 99999999999/0/0\n", "line 1: the tag has fewer integers"),
        ];
        for (text, expected) in cases {
            let message = read(text).unwrap_err().to_string();
            assert!(message.starts_with(expected), "{message:?} for {text:?}");
        }
    }

    #[test]
    fn what_is_left_out_is_noted_once_per_kind() {
        let notes = read("v 0 0 0\nl 1 1\np 1\ncurv 1\nbevel on\ncurv 2\n").unwrap().notes;
        assert_eq!(
            notes,
            [
                "line 2: lines and points (`l`, `p`) are left out (2 times)",
                "line 4: statements \"curv\" are not understood and left out (2 times)",
                "line 5: statements \"bevel\" are not understood and left out",
            ]
        );
    }

    #[test]
    fn memory_is_bounded() {
        let text = QUAD.to_string() + &"f 1 2 3 4\n".repeat(10000);
        let error = read_obj(text.as_bytes(), 50_000).unwrap_err();
        assert_eq!(error.kind, relievo_core::ErrorKind::Memory);
    }
}
