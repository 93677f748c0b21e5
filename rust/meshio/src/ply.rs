//! Polygon File Format (PLY): text, and binary of both byte orders; faces and triangle strips.
//!
//! Vertex columns become point attributes: `nx ny nz` `normal`, `red green blue (alpha)` `color` (whole numbers are
//! sRGB-encoded and made linear; floats are linear already), `s t`, `u v` or `texture_u texture_v` `uv`, others keep
//! their name. Face columns become face attributes, the list `texcoord` of a face the corner attribute `uv`.

mod header;
pub(crate) mod writer;

use relievo_core::{Attribute, Domain, Error, Mesh, Result, Values};

use crate::budget::Budget;
use crate::color::linear_from_srgb;
use crate::model::Model;
use crate::notes::Notes;
use crate::ply::header::{Element, Encoding, Header, Kind, Property};
use crate::text::{Words, at_line, shown};

/// Reads a PLY file. `memory_limit` bounds in bytes what is allocated for it.
///
/// # Errors
/// Fails with `Invalid`, the row of the element and in text files the line, if the file ends too early, a number cannot
/// be read, or an index refers to nothing, with `Unsupported` for a format that is not known or 2³² or more corners,
/// and with `Memory` above the limit.
pub fn read_ply(bytes: &[u8], memory_limit: u64) -> Result<Model> {
    let mut budget = Budget::new(memory_limit);
    let mut words = Words::new(bytes);
    let header = Header::read(&mut words, &mut budget)?;
    let body = match header.encoding {
        Encoding::Ascii => Body::Text(words),
        Encoding::Little => Body::Binary { rest: words.rest(), big: false },
        Encoding::Big => Body::Binary { rest: words.rest(), big: true },
    };
    let mut reader = Reader { budget, body, mesh: Mesh::default(), notes: Notes::default(), largest: None };
    for element in &header.elements {
        if element.properties.is_empty() {
            continue;
        }
        reader.check_room(element, header.encoding)?;
        match element.name.as_str() {
            "vertex" if reader.mesh.points.is_empty() => reader.vertices(element)?,
            "face" if element.list(FACE_LISTS).is_some() => reader.faces(element)?,
            "tristrips" if element.list(FACE_LISTS).is_some() => reader.strips(element)?,
            _ => reader.skip(element)?,
        }
    }
    reader.finish()
}

const FACE_LISTS: &[&str] = &["vertex_indices", "vertex_index"];

impl Element {
    /// The list called one of `names`.
    fn list(&self, names: &[&str]) -> Option<usize> {
        let wanted = |property: &Property| property.length.is_some() && names.contains(&property.name.as_str());
        self.properties.iter().position(wanted)
    }
}

/// The rows behind the header.
enum Body<'a> {
    Text(Words<'a>),
    Binary { rest: &'a [u8], big: bool },
}

impl Body<'_> {
    /// The next number.
    #[inline]
    fn number(&mut self, kind: Kind) -> Result<f64> {
        match self {
            Self::Text(words) => {
                let word = words.next_word().ok_or_else(cut_off)?;
                let number = std::str::from_utf8(word).ok().and_then(|word| word.parse::<f64>().ok());
                number.ok_or_else(|| Error::invalid(format!("{} is not a number", shown(word))))
            }
            Self::Binary { rest, big } => {
                let (bytes, tail) = rest.split_at_checked(kind.size()).ok_or_else(cut_off)?;
                *rest = tail;
                let mut word = [0; 8];
                if *big {
                    word.iter_mut().zip(bytes.iter().rev()).for_each(|(to, from)| *to = *from);
                } else {
                    word[..bytes.len()].copy_from_slice(bytes);
                }
                let word = u64::from_le_bytes(word);
                Ok(match kind {
                    Kind::I8 => f64::from(word as i8),
                    Kind::U8 => f64::from(word as u8),
                    Kind::I16 => f64::from(word as i16),
                    Kind::U16 => f64::from(word as u16),
                    Kind::I32 => f64::from(word as i32),
                    Kind::U32 => f64::from(word as u32),
                    Kind::F32 => f64::from(f32::from_bits(word as u32)),
                    Kind::F64 => f64::from_bits(word),
                })
            }
        }
    }

    /// The length of a list, checked against what is left of the file.
    fn length(&mut self, length: Kind, item: Kind) -> Result<usize> {
        let value = self.number(length)?;
        if value < 0.0 || value.fract() != 0.0 || value > f64::from(u32::MAX) {
            return Err(Error::invalid(format!("the list has the length {value}")).advise("use a whole number"));
        }
        let fits = match self {
            Self::Text(_) => value * 2.0 <= self.left() as f64 + 1.0,
            Self::Binary { .. } => value * item.size() as f64 <= self.left() as f64,
        };
        if fits { Ok(value as usize) } else { Err(cut_off()) }
    }

    /// Bytes left.
    fn left(&self) -> usize {
        match self {
            Self::Text(words) => words.left(),
            Self::Binary { rest, .. } => rest.len(),
        }
    }

    /// Ends a row, in text with its line. `true` if numbers were left on it.
    fn end_row(&mut self) -> bool {
        match self {
            Self::Text(words) => {
                let surplus = words.next_in_line().is_some();
                words.next_line();
                surplus
            }
            Self::Binary { .. } => false,
        }
    }

    /// Steps over `count` numbers.
    fn skip(&mut self, kind: Kind, count: usize) -> Result<()> {
        match self {
            Self::Text(words) => (0..count).try_for_each(|_| words.next_word().map(drop).ok_or_else(cut_off)),
            Self::Binary { rest, .. } => {
                let bytes = count.checked_mul(kind.size()).ok_or_else(cut_off)?;
                *rest = rest.get(bytes..).ok_or_else(cut_off)?;
                Ok(())
            }
        }
    }

    /// Steps over a number or list.
    fn skip_property(&mut self, property: &Property) -> Result<()> {
        let count = match property.length {
            Some(length) => self.length(length, property.kind)?,
            None => 1,
        };
        self.skip(property.kind, count)
    }

    /// The error with its row and, in text, its line.
    fn place(&self, error: Error, element: &Element, row: u64) -> Error {
        let error = error.at(format!("{} {row}", element.name));
        match self {
            Self::Text(words) => at_line(error, words.line()),
            Self::Binary { .. } => error,
        }
    }
}

fn cut_off() -> Error {
    Error::invalid("the file ends here").advise("it is cut off or its header is wrong; export it again")
}

/// How a number becomes the value of an attribute.
#[derive(Clone, Copy)]
enum Conversion {
    /// As it is.
    Plain,
    /// A share of the largest whole number.
    Share(f32),
    /// A share of the largest whole number, sRGB-encoded.
    Encoded(f32),
}

impl Conversion {
    fn apply(self, value: f64) -> f32 {
        match self {
            Self::Plain => value as f32,
            Self::Share(largest) => value as f32 / largest,
            Self::Encoded(largest) => linear_from_srgb(value as f32 / largest),
        }
    }
}

/// Columns of rows that become one attribute.
struct Column {
    attribute: Attribute,
    /// Property, component of the attribute and conversion.
    sources: Vec<(usize, usize, Conversion)>,
}

/// Groups of columns that mean one attribute together.
const GROUPS: &[(&str, &[&str])] = &[
    ("normal", &["nx", "ny", "nz"]),
    ("color", &["red", "green", "blue", "alpha"]),
    ("color", &["r", "g", "b", "a"]),
    ("color", &["red", "green", "blue"]),
    ("color", &["r", "g", "b"]),
    ("color", &["diffuse_red", "diffuse_green", "diffuse_blue"]),
    ("uv", &["s", "t"]),
    ("uv", &["u", "v"]),
    ("uv", &["texture_u", "texture_v"]),
    ("velocity", &["vx", "vy", "vz"]),
];

/// The attributes that the scalar columns of `element` make, except those in `taken`.
fn columns(element: &Element, domain: Domain, taken: &[usize]) -> Vec<Column> {
    let mut columns: Vec<Column> = Vec::new();
    let mut used = taken.to_vec();
    let mut add = |name: &str, integers: bool, sources: Vec<(usize, usize, Conversion)>| {
        if columns.iter().all(|column| column.attribute.name != name) {
            let values = if integers { Values::U32(Vec::new()) } else { Values::F32(Vec::new()) };
            let attribute = Attribute { name: name.into(), domain, width: sources.len() as u32, values, indices: None };
            columns.push(Column { attribute, sources });
        }
    };
    for (name, members) in GROUPS {
        let find = |member: &&str| {
            let wanted = |property: &Property| property.length.is_none() && property.name == *member;
            element.properties.iter().position(wanted).filter(|property| !used.contains(property))
        };
        let Some(found) = members.iter().map(find).collect::<Option<Vec<usize>>>() else { continue };
        let source = |(component, property): (usize, &usize)| {
            let largest = match element.properties[*property].kind {
                Kind::U8 => Some(255.0),
                Kind::U16 => Some(65535.0),
                _ => None,
            };
            let conversion = match largest.filter(|_| *name == "color") {
                Some(largest) if component < 3 => Conversion::Encoded(largest),
                Some(largest) => Conversion::Share(largest),
                None => Conversion::Plain,
            };
            (*property, component, conversion)
        };
        add(name, false, found.iter().enumerate().map(source).collect());
        used.extend(found);
    }
    for (index, property) in element.properties.iter().enumerate() {
        // A table of thousands of columns is no mesh, and the search above is not made for it.
        if property.length.is_none() && !used.contains(&index) && index < 256 {
            add(&property.name, property.kind.is_unsigned(), vec![(index, 0, Conversion::Plain)]);
        }
    }
    columns
}

struct Reader<'a> {
    budget: Budget,
    body: Body<'a>,
    mesh: Mesh,
    notes: Notes,
    /// The largest point index so far, and its element, row and line.
    largest: Option<(u32, &'static str, u64, u64)>,
}

impl Reader<'_> {
    /// Ends a row. Text files whose rows have more numbers than their header says exist; what the header describes is
    /// read from them.
    fn end_row(&mut self, element: &Element) {
        if self.body.end_row() {
            self.notes.add(&format!("numbers behind a row of `{}` are left out", element.name), 0);
        }
    }

    /// Fails if the file is too short for the rows of `element`.
    fn check_room(&self, element: &Element, encoding: Encoding) -> Result<()> {
        let needed = u128::from(element.rows) * u128::from(element.row_bytes(encoding));
        // The last separator of a text may be missing.
        if needed > self.body.left() as u128 + 1 || u32::try_from(element.rows).is_err() {
            let what = format!("the file is too short for {} rows", element.rows);
            let error = Error::invalid(what).at(format!("element `{}`", element.name));
            return Err(error.advise("it is cut off or its header is wrong; export it again"));
        }
        Ok(())
    }

    fn skip(&mut self, element: &Element) -> Result<()> {
        self.notes.add(&format!("the element `{}` is left out", element.name), 0);
        for row in 0..element.rows {
            for property in &element.properties {
                self.body.skip_property(property).map_err(|error| self.body.place(error, element, row))?;
            }
            self.end_row(element);
        }
        Ok(())
    }

    /// Makes room for the values of `columns`.
    fn open(&mut self, columns: &mut [Column], rows: usize) -> Result<()> {
        for column in columns {
            let count = rows * column.attribute.width as usize;
            match &mut column.attribute.values {
                Values::F32(values) => *values = self.budget.filled(count, 0.0)?,
                Values::U32(values) => *values = self.budget.filled(count, 0)?,
            }
        }
        Ok(())
    }

    /// Adds the finished columns to the mesh.
    fn close(&mut self, columns: Vec<Column>) {
        for Column { attribute, .. } in columns {
            let finite = match &attribute.values {
                Values::F32(values) => values.iter().all(|value| value.is_finite()),
                Values::U32(_) => true,
            };
            if !finite {
                self.notes.add(&format!("`{}` is left out because some of it is not finite", attribute.name), 0);
            } else if self.mesh.attribute(&attribute.name).is_some() {
                self.notes.add(&format!("a second `{}` is left out", attribute.name), 0);
            } else {
                self.mesh.attributes.push(attribute);
            }
        }
    }

    fn vertices(&mut self, element: &Element) -> Result<()> {
        let find = |name: &str| {
            let wanted = |property: &Property| property.name == name && property.length.is_none();
            element.properties.iter().position(wanted).ok_or_else(|| {
                Error::invalid(format!("there is no column `{name}`"))
                    .at("element `vertex`")
                    .advise("give points x, y and z")
            })
        };
        let axes = [find("x")?, find("y")?, find("z")?];
        let rows = element.rows as usize;
        let mut columns = columns(element, Domain::Point, &axes);
        self.mesh.points = self.budget.filled(rows, [0.0; 3])?;
        self.open(&mut columns, rows)?;
        let targets = Targets::new(element, &columns, &axes);
        for row in 0..rows {
            for (index, property) in element.properties.iter().enumerate() {
                let read = if property.length.is_some() {
                    self.body.skip_property(property).map(|()| 0.0)
                } else {
                    self.body.number(property.kind)
                };
                let value = read.map_err(|error| self.body.place(error, element, row as u64))?;
                match targets.of[index] {
                    Target::Axis(axis) => {
                        let value = value as f32;
                        if !value.is_finite() {
                            let what = format!("{} is {value}", ["x", "y", "z"][axis]);
                            let error = Error::invalid(what).advise("remove the point or repair its position");
                            return Err(self.body.place(error, element, row as u64));
                        }
                        self.mesh.points[row][axis] = value;
                    }
                    Target::Column { column, component, conversion } => {
                        put(&mut columns[column], row, component, value, conversion);
                    }
                    Target::None => {}
                }
            }
            self.end_row(element);
        }
        self.close(columns);
        Ok(())
    }

    /// Notes an index of a point, whose existence is checked when all points are read.
    #[inline]
    fn index(&mut self, value: f64, element: &Element, name: &'static str, row: u64) -> Result<u32> {
        let index = value as u32;
        if f64::from(index) != value {
            let error = Error::invalid(format!("point {value} does not exist")).advise("use whole numbers from 0");
            return Err(self.body.place(error, element, row));
        }
        if self.largest.is_none_or(|(largest, ..)| index > largest) {
            let line = if let Body::Text(words) = &self.body { words.line() } else { 0 };
            self.largest = Some((index, name, row, line));
        }
        Ok(index)
    }

    fn faces(&mut self, element: &Element) -> Result<()> {
        let rows = element.rows as usize;
        let corners = element.list(FACE_LISTS).unwrap_or_default();
        let coordinates = element.list(&["texcoord"]);
        let mut columns = columns(element, Domain::Face, &[]);
        // Other faces may have come before; attributes of these would have a gap.
        let columns_fit = self.mesh.face_sizes.is_empty();
        if !columns_fit {
            columns.clear();
        }
        self.open(&mut columns, rows)?;
        let targets = Targets::new(element, &columns, &[]);
        self.budget.reserve(&mut self.mesh.face_sizes, rows)?;
        let mut uvs = Vec::new();
        let mut uvs_fit = coordinates.is_some() && columns_fit;
        for row in 0..rows {
            let start = self.mesh.corners.len();
            let uv_start = uvs.len();
            for (index, property) in element.properties.iter().enumerate() {
                let fail = |body: &Body, error| body.place(error, element, row as u64);
                match property.length {
                    Some(length) if index == corners || Some(index) == coordinates => {
                        let count = self.body.length(length, property.kind).map_err(|error| fail(&self.body, error))?;
                        for _ in 0..count {
                            let value = self.body.number(property.kind).map_err(|error| fail(&self.body, error))?;
                            if index == corners {
                                let point = self.index(value, element, "face", row as u64)?;
                                self.budget.push(&mut self.mesh.corners, point)?;
                            } else if uvs_fit {
                                self.budget.push(&mut uvs, value as f32)?;
                            }
                        }
                    }
                    Some(_) => self.body.skip_property(property).map_err(|error| fail(&self.body, error))?,
                    None => {
                        let value = self.body.number(property.kind).map_err(|error| fail(&self.body, error))?;
                        if let Target::Column { column, component, conversion } = targets.of[index] {
                            put(&mut columns[column], row, component, value, conversion);
                        }
                    }
                }
            }
            let size = self.mesh.corners.len() - start;
            self.mesh.face_sizes.push(u32::try_from(size).map_err(|_| too_many_corners())?);
            uvs_fit &= uvs.len() - uv_start == 2 * size;
            self.end_row(element);
        }
        self.close(columns);
        if uvs_fit {
            let attribute = Attribute {
                name: "uv".into(),
                domain: Domain::Corner,
                width: 2,
                values: Values::F32(uvs),
                indices: None,
            };
            self.close(vec![Column { attribute, sources: Vec::new() }]);
        } else if coordinates.is_some() {
            self.notes.add("texture coordinates are left out: some faces have not two per corner", 0);
        }
        Ok(())
    }

    /// Triangle strips: every further point makes a triangle with the two before it, every second one turned; -1
    /// begins a new strip; triangles that repeat a point only join strips and are left out.
    fn strips(&mut self, element: &Element) -> Result<()> {
        let strip = element.list(FACE_LISTS).unwrap_or_default();
        for row in 0..element.rows {
            for (index, property) in element.properties.iter().enumerate() {
                let fail = |body: &Body, error| body.place(error, element, row);
                let Some(length) = property.length.filter(|_| index == strip) else {
                    self.body.skip_property(property).map_err(|error| fail(&self.body, error))?;
                    continue;
                };
                let count = self.body.length(length, property.kind).map_err(|error| fail(&self.body, error))?;
                let mut before = [0; 2];
                let mut place = 0;
                for _ in 0..count {
                    let value = self.body.number(property.kind).map_err(|error| fail(&self.body, error))?;
                    if value == -1.0 {
                        place = 0;
                        continue;
                    }
                    let point = self.index(value, element, "tristrips", row)?;
                    let [a, b] = before;
                    if place >= 2 && a != b && b != point && a != point {
                        let triangle = if place % 2 == 0 { [a, b, point] } else { [b, a, point] };
                        for corner in triangle {
                            self.budget.push(&mut self.mesh.corners, corner)?;
                        }
                        self.budget.push(&mut self.mesh.face_sizes, 3)?;
                    }
                    before = [b, point];
                    place += 1;
                }
            }
            self.end_row(element);
        }
        Ok(())
    }

    fn finish(mut self) -> Result<Model> {
        // Several elements may have made points or faces; attributes of one have no value for those of another.
        let Mesh { points, face_sizes, corners, attributes, .. } = &mut self.mesh;
        attributes.retain(|attribute| {
            let expected = match attribute.domain {
                Domain::Point => points.len(),
                Domain::Corner => corners.len(),
                Domain::Face => face_sizes.len(),
            };
            attribute.values.len() == expected * attribute.width as usize
        });
        let count = self.mesh.points.len();
        if let Some((index, name, row, line)) = self.largest.filter(|(index, ..)| *index as usize >= count) {
            let error = Error::invalid(format!("point {index} does not exist")).at(format!("{name} {row}"));
            let error = if line > 0 { at_line(error, line) } else { error };
            return Err(match count {
                0 => error.advise("the file has no points; add them"),
                _ => error.advise(format!("use 0 to {}", count - 1)),
            });
        }
        if u32::try_from(self.mesh.corners.len()).is_err() {
            return Err(too_many_corners());
        }
        Ok(Model { notes: self.notes.into_list(), ..Model::from_mesh(self.mesh) })
    }
}

fn too_many_corners() -> Error {
    Error::unsupported("the file has 2^32 or more corners").advise("split it")
}

/// Where a column goes.
#[derive(Clone, Copy)]
enum Target {
    None,
    Axis(usize),
    Column { column: usize, component: usize, conversion: Conversion },
}

/// Where every property of an element goes.
struct Targets {
    of: Vec<Target>,
}

impl Targets {
    fn new(element: &Element, columns: &[Column], axes: &[usize]) -> Self {
        let mut of = vec![Target::None; element.properties.len()];
        for (axis, property) in axes.iter().enumerate() {
            of[*property] = Target::Axis(axis);
        }
        for (column, Column { sources, .. }) in columns.iter().enumerate() {
            for (property, component, conversion) in sources {
                of[*property] = Target::Column { column, component: *component, conversion: *conversion };
            }
        }
        Self { of }
    }
}

fn put(column: &mut Column, row: usize, component: usize, value: f64, conversion: Conversion) {
    let at = row * column.attribute.width as usize + component;
    match &mut column.attribute.values {
        Values::F32(values) => values[at] = conversion.apply(value),
        Values::U32(values) => values[at] = value as u32,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn read(text: &str) -> Result<Model> {
        read_ply(text.as_bytes(), 1 << 20)
    }

    const POINTS: &str = "element vertex 4\nproperty float x\nproperty float y\nproperty float z\n";
    const FACES: &str = "property list uchar int vertex_indices\n";

    fn ascii(rest: &str) -> Mesh {
        read(&format!("ply\nformat ascii 1.0\n{rest}")).unwrap().meshes.remove(0).mesh
    }

    fn quad_points() -> Vec<[f32; 3]> {
        vec![[0.0; 3], [1.0, 0.0, 0.0], [1.0, 1.0, 0.0], [0.0, 1.0, 0.0]]
    }

    #[test]
    fn text_and_both_binaries_of_every_type_agree() {
        // In the text a row has a number too many and one runs over two lines.
        type Encode = fn(f64) -> Vec<u8>;
        let encode: [(&str, Encode); 8] = [
            ("char", |value| (value as i8).to_le_bytes().to_vec()),
            ("uint8", |value| (value as u8).to_le_bytes().to_vec()),
            ("short", |value| (value as i16).to_le_bytes().to_vec()),
            ("uint16", |value| (value as u16).to_le_bytes().to_vec()),
            ("int", |value| (value as i32).to_le_bytes().to_vec()),
            ("uint32", |value| (value as u32).to_le_bytes().to_vec()),
            ("float", |value| (value as f32).to_le_bytes().to_vec()),
            ("float64", |value| value.to_le_bytes().to_vec()),
        ];
        let expected = Mesh::new(quad_points(), vec![4], vec![0, 1, 2, 3]);
        for (kind, encode) in encode {
            let header = |format: &str| {
                format!(
                    "ply\nformat {format} 1.0\nelement vertex 4\nproperty {kind} x\nproperty {kind} y\n\
                     property {kind} z\nelement face 1\nproperty list uchar {kind} vertex_index\nend_header\n"
                )
            };
            let text = header("ascii") + "0 0 0\n1 0 0\n1 1 0 77\n0 1\n0\n4 0 1 2 3\n";
            assert_eq!(read(&text).unwrap().meshes[0].mesh, expected, "{kind} text");
            for (format, big) in [("binary_little_endian", false), ("binary_big_endian", true)] {
                let word = |value: f64| {
                    let mut word = encode(value);
                    if big {
                        word.reverse();
                    }
                    word
                };
                let mut bytes = header(format).into_bytes();
                bytes.extend(quad_points().as_flattened().iter().flat_map(|value| word(f64::from(*value))));
                bytes.push(4);
                bytes.extend([0.0, 1.0, 2.0, 3.0].into_iter().flat_map(word));
                assert_eq!(read_ply(&bytes, 1 << 20).unwrap().meshes[0].mesh, expected, "{kind} {format}");
                assert!(read_ply(&bytes[..bytes.len() - 1], 1 << 20).is_err());
            }
        }
    }

    #[test]
    fn strips_turn_every_second_triangle_and_restart() {
        let mesh = ascii(&format!(
            "{POINTS}element tristrips 1\nproperty list int int vertex_indices\nend_header\n\
             0 0 0\n1 0 0\n1 1 0\n0 1 0\n10 0 1 3 2 -1 2 3 3 0 1\n"
        ));
        assert_eq!(mesh.corners, [0, 1, 3, 3, 1, 2, 3, 0, 1]);
        assert_eq!(mesh.face_sizes, [3; 3]);
    }

    #[test]
    fn columns_become_attributes() {
        let model = read(&format!(
            "ply\nformat ascii 1.0\ncomment by hand\n{POINTS}property float ny\nproperty float nz\nproperty float nx\n\
             property uchar red\nproperty uchar green\nproperty uchar blue\nproperty uchar alpha\n\
             property double s\nproperty double t\nproperty float heat\nproperty ushort tag\n\
             property list uchar float junk\nelement edge 1\nproperty int a\n\
             element face 2\nproperty uchar red\n{FACES}property list uchar float texcoord\nend_header\n\
             0 0 0 2 3 1 255 0 0 51 .5 .25 7 9 0\n1 0 0 2 3 1 0 0 0 255 0 0 0 0 2 1 2\n\
             1 1 0 2 3 1 0 0 0 0 0 0 0 0 0\n0 1 0 2 3 1 0 0 0 0 0 0 0 0 0\n5\n\
             1 3 0 1 2 6 0 0 1 0 1 1\n2 3 0 2 3 6 0 0 1 1 0 1\n"
        ))
        .unwrap();
        let mesh = &model.meshes[0].mesh;
        let floats = |name: &str| match &mesh.attribute(name).unwrap().values {
            Values::F32(values) => values.clone(),
            Values::U32(_) => panic!("{name}"),
        };
        assert_eq!(floats("normal")[..3], [1.0, 2.0, 3.0]);
        assert_eq!(floats("color")[..4], [1.0, 0.0, 0.0, 0.2]);
        assert_eq!(floats("uv")[..2], [0.5, 0.25]);
        assert_eq!(floats("heat"), [7.0, 0.0, 0.0, 0.0]);
        assert_eq!(mesh.attribute("tag").unwrap().values, Values::U32(vec![9, 0, 0, 0]));
        let red = mesh.attribute("red").unwrap();
        assert_eq!((red.domain, &red.values), (Domain::Face, &Values::U32(vec![1, 2])));
        assert_eq!(model.notes, ["the element `edge` is left out", "a second `uv` is left out"]);
        assert_eq!(mesh.check(), Ok(()));
    }

    #[test]
    fn attributes_that_miss_some_faces_are_left_out() {
        let mesh = ascii(&format!(
            "{POINTS}element face 1\n{FACES}property list uchar float texcoord\nproperty int a\nelement face 1\n{FACES}end_header\n\
             0 0 0\n1 0 0\n1 1 0\n0 1 0\n3 0 1 2 6 0 0 1 0 1 1 5\n3 0 2 3\n"
        ));
        assert_eq!((mesh.face_sizes.len(), mesh.attributes.len()), (2, 0));
    }

    #[test]
    fn errors_name_line_and_row() {
        let header = format!("ply\nformat ascii 1.0\n{POINTS}element face 1\n{FACES}end_header\n");
        let cases = [
            ("obj".to_string(), "line 1: the file does not begin"),
            ("ply\nformat ascii 1.0\n".into(), "line 3: the header has no `end_header`"),
            ("ply\nformat morse 1.0\n".into(), "line 2: the format \"morse\" is not known"),
            ("ply\nproperty float x\n".into(), "line 2: a property stands before"),
            ("ply\nelement vertex many\n".into(), "line 2: the element \"vertex\" has no count"),
            ("ply\nelement vertex 1\nproperty list float int a\n".into(), "line 3: the property cannot"),
            ("ply\nend_header\n".into(), "line 2: the header has no `format`"),
            (
                "ply\nformat ascii 1.0\nelement vertex 1\nproperty float x\nend_header\n1\n".into(),
                "element `vertex`: there is no column `y`",
            ),
            (header.replace("vertex 4", "vertex 4000000000000"), "element `vertex`: the file is too short"),
            (header.clone() + "0 0 0\n1 0 0\n1 x 0\n0 0 0\n3 0 1 2", "line 12: vertex 2: \"x\" is not a number"),
            (header.clone() + "0 0 0\n1 0 0\n1 inf 0\n0 0 0\n3 0 1 2", "line 12: vertex 2: y is inf"),
            (header.clone() + "0 0 0\n1 0 0\n1 0 0\n0 0 0\n3 0 1 4", "line 14: face 0: point 4 does not exist"),
            (header.clone() + "0 0 0\n1 0 0\n1 0 0\n0 0 0\n3 0 1 -1", "line 14: face 0: point -1 does not exist"),
            (header.clone() + "0 0 0\n1 0 0\n1 0 0\n0 0 0\n90000 0 1 -1", "line 14: face 0: the file ends here"),
        ];
        for (text, expected) in cases {
            let message = read(&text).unwrap_err().to_string();
            assert!(message.starts_with(expected), "{message:?} for {text:?}");
        }
    }
}
