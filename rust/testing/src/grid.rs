//! Grids of faces of all kinds from a list of choices, and numbers from a seed.

use relievo_core::Mesh;

/// A grid of `size`² quads, closed to a torus or open, of which some are split or merged in pairs. Bits of `choices`
/// decide, face by face; `reversed` allows faces wound against the others.
pub fn grid(size: u32, torus: bool, choices: &[u8], reversed: bool) -> Mesh {
    let stride = if torus { size } else { size + 1 };
    let point = |x: u32, y: u32| (y % stride) * stride + x % stride;
    let mut mesh = Mesh::default();
    for y in 0..stride {
        for x in 0..stride {
            let angle = |n: u32| n as f32 * std::f32::consts::TAU / stride as f32;
            let (a, b) = (angle(x), angle(y));
            mesh.points.push(if torus {
                [(3.0 + b.cos()) * a.cos(), (3.0 + b.cos()) * a.sin(), b.sin()]
            } else {
                [x as f32, y as f32, 0.3 * (a + 2.0 * b).sin()]
            });
        }
    }
    let mut taken = vec![false; (size * size) as usize];
    for (index, (y, x)) in (0..size).flat_map(|y| (0..size).map(move |x| (y, x))).enumerate() {
        if taken[index] {
            continue;
        }
        let [a, b, c, d] = [point(x, y), point(x + 1, y), point(x + 1, y + 1), point(x, y + 1)];
        let choice = choices[index % choices.len()];
        let mut faces = match choice & 3 {
            0 if x + 1 < size && !taken[index + 1] => {
                taken[index + 1] = true;
                vec![vec![a, b, point(x + 2, y), point(x + 2, y + 1), c, d]]
            }
            1 => vec![vec![a, b, c], vec![a, c, d]],
            _ => vec![vec![a, b, c, d]],
        };
        for face in &mut faces {
            let turn = usize::from(choice >> 2 & 3) % face.len();
            face.rotate_left(turn);
            if reversed && choice & 0x30 == 0x30 {
                face.reverse();
            }
            mesh.face_sizes.push(face.len() as u32);
            mesh.corners.extend_from_slice(face);
        }
    }
    mesh
}

/// Numbers from a seed.
pub struct Random(pub u64);

impl Random {
    /// A number below `count`.
    pub fn below(&mut self, count: usize) -> usize {
        self.0 = self.0.wrapping_mul(6364136223846793005).wrapping_add(1442695040888963407);
        (self.0 >> 33) as usize % count
    }

    /// A number from 0 to 1.
    pub fn unit(&mut self) -> f32 {
        self.below(1 << 20) as f32 / (1 << 20) as f32
    }
}
