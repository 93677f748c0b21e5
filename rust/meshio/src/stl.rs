//! Stereolithography (STL), text and binary: loose triangles, whose corners with equal coordinates become one point.

pub(crate) mod writer;

use std::collections::HashMap;

use relievo_core::{Error, Mesh, Result};

use crate::budget::Budget;
use crate::model::Model;
use crate::notes::Notes;
use crate::text::{Words, at_line, expect_finite, shown};

/// Reads an STL file. `memory_limit` bounds in bytes what is allocated for it.
///
/// Triangles that repeat a point are left out.
///
/// # Errors
/// Fails with `Invalid`, and the line or triangle, if the file ends too early or a number cannot be read or is not
/// finite, and with `Memory` above the limit.
pub fn read_stl(bytes: &[u8], memory_limit: u64) -> Result<Model> {
    let mut builder = Builder::new(memory_limit);
    // Binary files may begin with `solid` too; their length tells.
    let claimed = bytes.get(80..84).and_then(|word| <[u8; 4]>::try_from(word).ok()).map(u32::from_le_bytes);
    let binary = claimed.is_some_and(|count| bytes.len() as u64 == 84 + 50 * u64::from(count));
    if binary || !bytes.trim_ascii_start().get(..5).is_some_and(|word| word.eq_ignore_ascii_case(b"solid")) {
        let count = claimed.unwrap_or_default();
        let triangles = bytes.get(84..).unwrap_or_default().chunks_exact(50);
        if claimed.is_none() || (triangles.len() as u64) < u64::from(count) {
            return Err(Error::invalid(format!("the file ends after {} of {count} triangles", triangles.len()))
                .advise("it is cut off or no STL; export it again"));
        }
        for (index, triangle) in triangles.take(count as usize).enumerate() {
            let mut numbers = [0.0f32; 12];
            for (number, bytes) in numbers.iter_mut().zip(triangle.as_chunks::<4>().0) {
                *number = f32::from_le_bytes(*bytes);
            }
            // The normal comes first; the corners' order says the same.
            let corners = &numbers.as_chunks::<3>().0[1..];
            if corners.as_flattened().iter().any(|value| !value.is_finite()) {
                return Err(Error::invalid("a coordinate is not finite")
                    .at(format!("triangle {index}"))
                    .advise("remove the triangle or repair its corners"));
            }
            builder.triangle(corners)?;
        }
    } else {
        text(bytes, &mut builder)?;
    }
    let mesh = Mesh::from_triangles(builder.points, &builder.triangles);
    Ok(Model { notes: builder.notes.into_list(), ..Model::from_mesh(mesh) })
}

fn text(bytes: &[u8], builder: &mut Builder) -> Result<()> {
    let mut words = Words::new(bytes);
    let mut corners = [[0.0; 3]; 3];
    let mut count = 0;
    loop {
        let keyword = words.next_in_line().unwrap_or_default();
        let line = words.line();
        let is = |name: &str| keyword.eq_ignore_ascii_case(name.as_bytes());
        if is("vertex") {
            let Some(corner) = corners.get_mut(count) else {
                return Err(at_line(Error::invalid("the facet has more than three corners"), line)
                    .advise("STL holds triangles; write polygons as OBJ or PLY"));
            };
            for (value, name) in corner.iter_mut().zip(["x", "y", "z"]) {
                *value = expect_finite(words.next_in_line(), line, name)?;
            }
            count += 1;
        } else if is("endfacet") || is("endloop") {
            match count {
                3 => builder.triangle(&corners)?,
                0 => {}
                _ => {
                    let what = format!("the facet has {count} corners");
                    return Err(at_line(Error::invalid(what), line).advise("give it three"));
                }
            }
            count = 0;
        } else if !["", "solid", "facet", "outer", "endsolid"].iter().any(|name| is(name)) {
            let what = format!("{} is not known", shown(keyword));
            return Err(at_line(Error::invalid(what), line).advise("check that it is an STL file"));
        }
        if !words.next_line() {
            break;
        }
    }
    if count > 0 {
        return Err(at_line(Error::invalid("the file ends within a facet"), words.line())
            .advise("it is cut off; export it again"));
    }
    Ok(())
}

struct Builder {
    budget: Budget,
    points: Vec<[f32; 3]>,
    triangles: Vec<[u32; 3]>,
    known: HashMap<[u32; 3], u32>,
    notes: Notes,
}

impl Builder {
    fn new(memory_limit: u64) -> Self {
        Self {
            budget: Budget::new(memory_limit),
            points: Vec::new(),
            triangles: Vec::new(),
            known: HashMap::new(),
            notes: Notes::default(),
        }
    }

    fn triangle(&mut self, corners: &[[f32; 3]]) -> Result<()> {
        let mut triangle = [0; 3];
        for (index, corner) in triangle.iter_mut().zip(corners) {
            // Adding zero makes the two zeros one.
            let key = corner.map(|value| (value + 0.0).to_bits());
            *index = match self.known.get(&key) {
                Some(index) => *index,
                None => {
                    let index = self.points.len() as u32;
                    if self.known.len() == self.known.capacity() {
                        // The table doubles; an entry takes its 16 bytes, a control byte and an eighth of slack.
                        self.budget.charge(2 * 20 * self.known.capacity().max(64) as u64)?;
                    }
                    self.known.insert(key, index);
                    self.budget.push(&mut self.points, *corner)?;
                    index
                }
            };
        }
        let [a, b, c] = triangle;
        if a == b || b == c || c == a {
            self.notes.add("triangles that repeat a point are left out", 0);
            return Ok(());
        }
        self.budget.push(&mut self.triangles, triangle)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const TEXT: &str = "solid a b\n facet normal 0 0 1\n  outer loop\n   vertex 0 0 0\n   vertex 1 0 0\n   \
                        VERTEX 1 1 0\n  endloop\n endfacet\n facet normal 0 0 1\n outer loop\n vertex -0 0 0\n vertex 1 1 0\n \
                        vertex 0 1e0 0\n endloop\nendfacet\nendsolid a b\n";

    fn binary(triangles: &[[[f32; 3]; 3]]) -> Vec<u8> {
        let mut bytes = b"solid but binary".to_vec();
        bytes.resize(80, 0);
        bytes.extend((triangles.len() as u32).to_le_bytes());
        for triangle in triangles {
            bytes.extend([0; 12]);
            bytes.extend(triangle.as_flattened().iter().flat_map(|value| value.to_le_bytes()));
            bytes.extend([0; 2]);
        }
        bytes
    }

    #[test]
    fn equal_corners_become_one_point() {
        let expected = Mesh::from_triangles(
            vec![[0.0; 3], [1.0, 0.0, 0.0], [1.0, 1.0, 0.0], [0.0, 1.0, 0.0]],
            &[[0, 1, 2], [0, 2, 3]],
        );
        assert_eq!(read_stl(TEXT.as_bytes(), 1 << 20).unwrap().meshes[0].mesh, expected);
        let [a, b, c, d] = [0, 1, 2, 3].map(|point| expected.points[point]);
        let bytes = binary(&[[a, b, c], [a, c, d], [a, a, d]]);
        let model = read_stl(&bytes, 1 << 20).unwrap();
        assert_eq!(model.meshes[0].mesh, expected);
        assert_eq!(model.notes.len(), 1);
    }

    #[test]
    fn broken_files_are_refused() {
        let bytes = binary(&[[[0.0; 3], [1.0, 0.0, 0.0], [0.0, f32::NAN, 0.0]]]);
        assert!(read_stl(&bytes, 1 << 20).unwrap_err().to_string().starts_with("triangle 0: a coordinate"));
        let mut long = binary(&[]);
        long[0] = b'x';
        long[80..84].copy_from_slice(&u32::MAX.to_le_bytes());
        assert!(read_stl(&long, 1 << 20).unwrap_err().to_string().contains("0 of 4294967295"));
        let cases = [
            ("solid\nvertex 0 0 0\nendfacet", "line 3: the facet has 1 corners"),
            ("solid\nvertex 0 0 x\n", "line 2: z \"x\" is not a number"),
            ("solid\nvertex 0 0 0\n", "line 3: the file ends within a facet"),
            ("solid\nfacets\n", "line 2: \"facets\" is not known"),
            ("solid\nvertex 0 0 0\nvertex 0 0 0\nvertex 0 0 0\nvertex 0 0 0\n", "line 5: the facet has more"),
            ("", "the file ends after 0 of 0"),
        ];
        for (text, expected) in cases {
            let message = read_stl(text.as_bytes(), 1 << 20).unwrap_err().to_string();
            assert!(message.starts_with(expected), "{message}");
        }
        assert!(read_stl(TEXT.as_bytes(), 100).is_err());
    }
}
