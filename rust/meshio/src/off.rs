//! Object File Format (OFF) in text: polygons, with colours and normals of points.

pub(crate) mod writer;

use relievo_core::{Attribute, Domain, Error, Mesh, Result, Values};

use crate::budget::Budget;
use crate::color::linear_from_srgb;
use crate::model::Model;
use crate::text::{Words, at_line, expect_finite, integer, shown};

/// Reads an OFF, COFF, NOFF or CNOFF file. `memory_limit` bounds in bytes what is allocated for it.
///
/// Colours of faces are left out.
///
/// # Errors
/// Fails with `Invalid`, and the line, if the file ends too early, a number cannot be read, or an index refers to
/// nothing, with `Unsupported` if it begins with another keyword, and with `Memory` above the limit.
pub fn read_off(bytes: &[u8], memory_limit: u64) -> Result<Model> {
    let mut budget = Budget::new(memory_limit);
    let mut words = Words::new(bytes).with_comments(b'#');
    let first = words.next_word().unwrap_or_default();
    let head = first.iter().position(u8::is_ascii_digit).unwrap_or(first.len());
    let (colored, with_normals) = match &first[..head] {
        b"OFF" => (false, false),
        b"COFF" => (true, false),
        b"NOFF" => (false, true),
        b"CNOFF" => (true, true),
        other => {
            return Err(at_line(Error::unsupported(format!("the file begins with {}", shown(other))), words.line())
                .advise("use OFF, COFF, NOFF or CNOFF in text"));
        }
    };
    // Some files have no blank behind the keyword.
    let glued = Some(&first[head..]).filter(|word| !word.is_empty());
    let mut glued = glued.into_iter();
    let mut counts = [0usize; 3];
    for (count, what) in counts.iter_mut().zip(["points", "faces", "edges"]) {
        let word = glued.next().or_else(|| words.next_word());
        let number = word.and_then(integer).and_then(|number| usize::try_from(number).ok());
        // Every point and face takes at least two bytes of text.
        let number = number.filter(|number| what == "edges" || *number <= bytes.len() / 2);
        *count = number.ok_or_else(|| {
            at_line(Error::invalid(format!("the number of {what} cannot be right")), words.line())
                .advise("it is cut off or no OFF file")
        })?;
    }
    let [point_count, face_count, _] = counts;
    let mut points = budget.filled(point_count, [0.0; 3])?;
    let mut normals = Vec::new();
    let mut colors = Vec::new();
    for (index, point) in points.iter_mut().enumerate() {
        let place = |error: Error| error.at(format!("point {index}"));
        let numbers = |words: &mut Words, into: &mut [f32]| {
            into.iter_mut().try_for_each(|value| {
                let word = words.next_word();
                *value = expect_finite(word, words.line(), "a number")?;
                Ok(())
            })
        };
        numbers(&mut words, point)?;
        if with_normals {
            let mut normal = [0.0; 3];
            numbers(&mut words, &mut normal)?;
            normal.iter().try_for_each(|value| budget.push(&mut normals, *value))?;
        }
        if colored {
            let mut color = [0.0; 4];
            numbers(&mut words, &mut color)?;
            color.iter().try_for_each(|value| budget.push(&mut colors, *value))?;
        }
        if words.next_in_line().is_none() {
            words.next_line();
        } else {
            return Err(at_line(place(Error::invalid("there are numbers behind it")), words.line())
                .advise("name the columns by the keyword COFF, NOFF or CNOFF"));
        }
    }
    let mut face_sizes = Vec::new();
    let mut corners = Vec::new();
    for index in 0..face_count {
        let wrong = |words: &Words, what: String| {
            at_line(Error::invalid(what).at(format!("face {index}")), words.line())
                .advise(format!("use 0 to {} for points", point_count.saturating_sub(1)))
        };
        let size = words.next_word().and_then(integer).and_then(|size| u32::try_from(size).ok());
        let size = size.ok_or_else(|| wrong(&words, "its number of corners is missing".into()))?;
        for _ in 0..size {
            let word = words.next_in_line().ok_or_else(|| wrong(&words, format!("it has not {size} corners")))?;
            let point = integer(word).and_then(|point| u32::try_from(point).ok());
            let point = point.filter(|point| (*point as usize) < point_count);
            let point = point.ok_or_else(|| wrong(&words, format!("point {} does not exist", shown(word))))?;
            budget.push(&mut corners, point)?;
        }
        budget.push(&mut face_sizes, size)?;
        // A colour may follow.
        words.next_line();
    }
    let mut mesh = Mesh::new(points, face_sizes, corners);
    let mut add = |name: &str, width: u32, values: Vec<f32>| {
        let values = Values::F32(values);
        mesh.attributes.push(Attribute { name: name.into(), domain: Domain::Point, width, values, indices: None });
    };
    if with_normals {
        add("normal", 3, normals);
    }
    if colored {
        // Whole numbers up to 255, sRGB-encoded, and shares of one are both in use.
        if colors.iter().any(|value| *value > 1.0) {
            for color in colors.as_chunks_mut::<4>().0 {
                *color = color.map(|value| (value / 255.0).min(1.0));
                color[..3].iter_mut().for_each(|value| *value = linear_from_srgb(*value));
            }
        }
        add("color", 4, colors);
    }
    Ok(Model::from_mesh(mesh))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn points_faces_and_attributes_are_read() {
        let text = "# a quad\nCNOFF4 1 4 # counts\n0 0 0 0 0 1 255 0 0 255\n1 0 0 0 0 1 0 0 0 51\n\
                    1 1 0 0 0 1 0 0 0 0\n0 1 0 0 0 1 0 0 0 0\n4 0 1 2 3 0.5 0.5 0.5\n";
        let mesh = read_off(text.as_bytes(), 1 << 20).unwrap().meshes.remove(0).mesh;
        assert_eq!((mesh.points.len(), mesh.corners.as_slice()), (4, [0, 1, 2, 3].as_slice()));
        assert_eq!(mesh.check(), Ok(()));
        let Values::F32(colors) = &mesh.attribute("color").unwrap().values else { panic!() };
        assert_eq!(colors[..8], [1.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 0.2]);
    }

    #[test]
    fn broken_files_are_refused() {
        let cases = [
            ("", "line 1: the file begins with"),
            ("4OFF", "line 1: the file begins with"),
            ("OFF\n99999999 1 0\n", "line 2: the number of points"),
            ("OFF\n1 1 0\n0 0\n", "line 4: a number is missing"),
            ("OFF\n1 1 0\n0 0 0 9\n", "line 3: point 0: there are numbers behind it"),
            ("OFF\n1 1 0\n0 0 0\n3 0 0 1\n", "line 4: face 0: point \"1\" does not exist"),
            ("OFF\n1 1 0\n0 0 0\n4000000000 0\n", "line 4: face 0: it has not 4000000000 corners"),
            ("OFF\n1 1 0\n0 0 0\n", "line 4: face 0: its number of corners is missing"),
        ];
        for (text, expected) in cases {
            let message = read_off(text.as_bytes(), 1 << 20).unwrap_err().to_string();
            assert!(message.starts_with(expected), "{message:?} for {text:?}");
        }
    }
}
