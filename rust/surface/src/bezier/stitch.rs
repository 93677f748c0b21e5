//! Triangles that close the gap between an edge of a patch and a finer division of it.
//!
//! Both polygons have their corners on the same curve and share its ends. The triangles between them go forward on the
//! side whose next corner comes first, so that no triangle spans more of the curve than a segment of the coarser side.

/// A corner: of the patch's own division of its edge, or of the finer one.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Stitch {
    /// This many segments from where the edge begins in the patch.
    Own(u32),
    /// As many of the finer segments, neither the first nor the last of their ends.
    Finer(u32),
}

/// The triangles between `own` segments of an edge and `finer` ones, as numbers of segments from where the edge begins
/// in a patch that is to its left, counter-clockwise from the front. There are `own` + `finer` − 2.
pub fn stitches(own: u32, finer: u32) -> impl Iterator<Item = [Stitch; 3]> {
    let beyond = move |j: u32| match j {
        0 => Stitch::Own(0),
        j if j == finer => Stitch::Own(own),
        j => Stitch::Finer(j),
    };
    let (mut k, mut j) = (0, 0);
    std::iter::from_fn(move || {
        while k < own || j < finer {
            let [a, b] = [Stitch::Own(k), beyond(j)];
            let forward =
                j < finer && (k == own || u64::from(j + 1) * u64::from(own) <= u64::from(k + 1) * u64::from(finer));
            let next = if forward {
                j += 1;
                beyond(j)
            } else {
                k += 1;
                Stitch::Own(k)
            };
            if a != b && a != next && b != next {
                return Some(if forward { [b, next, a] } else { [a, b, next] });
            }
        }
        None
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn triangles_hang_together_and_are_no_longer_than_a_segment() {
        for (own, finer) in [(3, 7), (3, 511), (7, 15), (15, 31), (3, 15), (127, 255)] {
            let triangles: Vec<[Stitch; 3]> = stitches(own, finer).collect();
            assert_eq!(triangles.len() as u32, own + finer - 2);
            let mut edges = std::collections::BTreeMap::new();
            for triangle in &triangles {
                let at = triangle.map(|corner| match corner {
                    Stitch::Own(k) => (k * finer, 0),
                    Stitch::Finer(j) => (j * own, 1),
                });
                let (low, high) = (at.iter().min().unwrap().0, at.iter().max().unwrap().0);
                assert!(high - low <= finer, "{triangle:?}");
                for k in 0..3 {
                    let (a, b) = (at[k], at[(k + 1) % 3]);
                    *edges.entry((a.min(b), a.max(b))).or_insert(0) += if a < b { 1 } else { -1 };
                }
            }
            // What is left is both sides: forwards along the finer one, backwards along the patch.
            let open: Vec<_> = edges.into_iter().filter(|(_, count)| *count != 0).collect();
            assert_eq!(open.len() as u32, own + finer);
            let along = |(a, b): ((u32, u32), (u32, u32))| a.1 == 0 && b.1 == 0 && b.0 - a.0 == finer;
            let backwards = open.iter().filter(|(edge, count)| along(*edge) && *count == -1).count();
            let forwards = open.iter().filter(|(edge, count)| !along(*edge) && *count == 1).count();
            assert_eq!([backwards as u32, forwards as u32], [own, finer]);
        }
        assert_eq!(stitches(7, 7).count(), 12);
    }
}
