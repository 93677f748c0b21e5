//! Parametric maps of virtual vertices: the places at which a vertex shader evaluates a Bézier patch, after Concheiro,
//! Amor, Padrón, Gil, Martorell 2013 (*Rendering of Bézier Surfaces on Handheld Devices*, Section 3).
//!
//! The map P_l of level l has 2^(l+1) samples a side (Equation 8), so 2^(l+1) − 1 quads. Its vertices are a triangle
//! strip that goes through the rows of quads; the first and the last vertex of every row come twice, which joins rows,
//! and copies of the map for several patches, by triangles without area. So there are no indices: a strip of a patch
//! has 2·4^(l+1) − 2 vertices of 16 bytes.

use bytemuck::{Pod, Zeroable};
use relievo_core::{Error, Result};

use super::stitch::{Stitch, stitches};

/// The highest level.
pub const MAX_LEVEL: u32 = 8;

/// A vertex of a map, as vertex shaders read it.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Pod, Zeroable)]
pub struct VirtualVertex {
    /// First parameter.
    pub u: f32,
    /// Second parameter.
    pub v: f32,
    /// Which of the patches of a draw.
    pub patch: u32,
    /// Which of the samples along u, times 2¹² along v, times 2²⁴ the level of their map, and [`STITCH`].
    pub sample: u32,
}

/// Marks the virtual vertices of triangles that close gaps beside finer edges.
pub const STITCH: u32 = 1 << 28;

impl VirtualVertex {
    /// Sample (i, j) of `map`, for a patch of a draw.
    pub fn new(map: ParametricMap, patch: u32, [i, j]: [u32; 2]) -> Self {
        Self { u: map.parameter(i), v: map.parameter(j), patch, sample: i | j << 12 | map.level() << 24 }
    }

    /// Which of the samples along u and v.
    pub fn place(self) -> [u32; 2] {
        [self.sample & 0xfff, self.sample >> 12 & 0xfff]
    }
}

/// The map of a level.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct ParametricMap {
    level: u32,
}

impl ParametricMap {
    /// The map of `level`.
    ///
    /// # Errors
    /// The level is not from 1 to [`MAX_LEVEL`].
    pub fn new(level: u32) -> Result<Self> {
        if !(1..=MAX_LEVEL).contains(&level) {
            return Err(Error::invalid(format!("there is no level {level}"))
                .advise(format!("use levels from 1 to {MAX_LEVEL}")));
        }
        Ok(Self { level })
    }

    /// Its level.
    pub fn level(self) -> u32 {
        self.level
    }

    /// Samples a side.
    pub fn side(self) -> u32 {
        2 << self.level
    }

    /// Quads a side.
    pub fn segments(self) -> u32 {
        self.side() - 1
    }

    /// The parameter of a sample, counted from 0: (i − 1) / (2^(l+1) − 1) of Equation 8.
    pub fn parameter(self, sample: u32) -> f32 {
        sample as f32 / self.segments() as f32
    }

    /// Samples of a patch.
    pub fn samples(self) -> u64 {
        u64::from(self.side()).pow(2)
    }

    /// Triangles of a patch that have an area.
    pub fn triangles(self) -> u64 {
        2 * u64::from(self.segments()).pow(2)
    }

    /// Vertices of a patch's strip.
    pub fn strip_vertices(self) -> u64 {
        2 * self.samples() - 2
    }

    /// Bytes of the strips of `patches` patches.
    pub fn strip_bytes(self, patches: u64) -> u64 {
        size_of::<VirtualVertex>() as u64 * self.strip_vertices() * patches
    }

    /// The samples along u and v of a patch's strip.
    pub fn strip(self) -> impl Iterator<Item = [u32; 2]> {
        let side = self.side();
        (0..self.segments()).flat_map(move |row| {
            // Twice the first, a column of two at a time, twice the last.
            (0..2 * side + 2).map(move |place| {
                let place = place.clamp(1, 2 * side) - 1;
                [place / 2, row + place % 2]
            })
        })
    }

    /// The vertices of `patches` copies of the map.
    pub fn vertices(self, patches: u32) -> Vec<VirtualVertex> {
        (0..patches).flat_map(|patch| self.strip().map(move |at| VirtualVertex::new(self, patch, at))).collect()
    }

    /// Sample `k` along an edge, counted from corner `edge`.
    pub fn along(self, edge: usize, k: u32) -> [u32; 2] {
        let n = self.segments();
        [[k, 0], [n, k], [n - k, n], [0, n - k]][edge & 3]
    }

    /// The vertices of the triangles between `edge` of a patch of a draw and the division that `finer` has of it.
    pub fn stitched(self, patch: u32, edge: usize, finer: Self) -> impl Iterator<Item = VirtualVertex> {
        let corners = stitches(self.segments(), finer.segments()).flatten();
        corners.map(move |corner| {
            let vertex = match corner {
                Stitch::Own(k) => VirtualVertex::new(self, patch, self.along(edge, k)),
                Stitch::Finer(k) => VirtualVertex::new(finer, patch, finer.along(edge, k)),
            };
            VirtualVertex { sample: vertex.sample | STITCH, ..vertex }
        })
    }
}

/// Draws of `most` patches each that `patches` patches take: N_DP of Section 3.
///
/// # Panics
/// `most` is 0.
pub fn draw_calls(patches: u64, most: u64) -> u64 {
    patches.div_ceil(most)
}

#[cfg(test)]
mod tests {
    use super::*;

    const SCENES: [(&str, u64); 8] = [
        ("S5cups", 5 * 26),
        ("S5pots", 5 * 32),
        ("S10cups", 10 * 26),
        ("S10pots", 10 * 32),
        ("S15cups", 15 * 26),
        ("S15pots", 15 * 32),
        ("S20cups", 20 * 26),
        ("S20pots", 20 * 32),
    ];

    /// Table 1, thousands (of 1024) of triangles by scene and level. The paper prints two decimals, and some of its
    /// last ones are cut off rather than rounded.
    const TRIANGLES: [[f64; 5]; 8] = [
        [2.29, 12.44, 57.13, 244.00, 1007.75],
        [2.81, 15.31, 70.31, 300.31, 1240.31],
        [4.57, 24.88, 114.26, 488.01, 2015.51],
        [5.63, 30.63, 140.63, 600.63, 2480.63],
        [6.86, 37.32, 171.39, 732.01, 3023.26],
        [8.44, 45.94, 210.94, 900.94, 3720.94],
        [9.14, 49.77, 228.52, 976.02, 4031.02],
        [11.25, 61.25, 281.25, 1201.25, 4961.25],
    ];

    /// Table 2, kilobytes (of 1024) of strips by scene and level.
    const KILOBYTES: [[f64; 5]; 8] = [
        [60.94, 255.94, 1035.94, 4155.93, 16635.94],
        [75.00, 315.00, 1275.00, 5115.00, 20475.00],
        [121.88, 511.88, 2071.88, 8311.88, 33271.88],
        [150.00, 630.00, 2550.00, 10230.00, 40950.00],
        [182.81, 767.81, 3107.81, 12467.81, 49907.81],
        [225.00, 945.00, 3825.00, 15345.00, 61425.00],
        [243.75, 1023.75, 4143.75, 16623.75, 66543.75],
        [300.00, 1260.00, 5100.00, 20460.00, 81900.00],
    ];

    /// Table 3, draws by patches of a draw and scene of pots.
    const DRAWS: [(u64, [u64; 4]); 5] = [
        (1, [160, 320, 480, 640]),
        (2, [80, 160, 240, 320]),
        (4, [40, 80, 120, 160]),
        (8, [20, 40, 60, 80]),
        (16, [10, 20, 30, 40]),
    ];

    #[test]
    fn counts_are_those_of_the_tables() {
        for ((name, patches), (triangles, kilobytes)) in SCENES.into_iter().zip(TRIANGLES.into_iter().zip(KILOBYTES)) {
            for level in 1..=5 {
                let map = ParametricMap::new(level).unwrap();
                let row = level as usize - 1;
                let thousands = (map.triangles() * patches) as f64 / 1024.0;
                assert!((thousands - triangles[row]).abs() < 0.0101, "{name}, level {level}: {thousands}");
                let strips = map.strip_bytes(patches) as f64 / 1024.0;
                assert!((strips - kilobytes[row]).abs() < 0.0101, "{name}, level {level}: {strips}");
            }
        }
        for (most, draws) in DRAWS {
            let pots = SCENES.iter().filter(|(name, _)| name.ends_with("pots"));
            for ((name, patches), expected) in pots.zip(draws) {
                assert_eq!(draw_calls(*patches, most), expected, "{name}, {most} patches a draw");
            }
        }
        assert_eq!(draw_calls(130, 16), 9);
    }

    #[test]
    fn strips_are_the_quads_of_the_map_seen_from_the_front() {
        for level in 1..=4 {
            let map = ParametricMap::new(level).unwrap();
            let (side, copies) = (map.side(), 3);
            let strip = map.vertices(copies);
            assert_eq!(strip.len() as u64 * 16, map.strip_bytes(u64::from(copies)));
            let mut seen = vec![0; (copies * map.segments().pow(2)) as usize];
            let mut count = 0;
            for (place, three) in strip.windows(3).enumerate() {
                let corner = |vertex: &VirtualVertex| vertex.place();
                let [a, b, c] = [&three[0], &three[1], &three[2]];
                let [i, j, k] = [a, b, c].map(|v| (corner(v), v.patch));
                if i == j || j == k || i == k {
                    continue;
                }
                // Every other triangle of a strip is turned over.
                let (b, c) = if place % 2 == 0 { (b, c) } else { (c, b) };
                let area = (b.u - a.u) * (c.v - a.v) - (b.v - a.v) * (c.u - a.u);
                if a.patch != b.patch || a.patch != c.patch {
                    panic!("a triangle between patches at {place}");
                }
                assert!(area > 0.0, "{place}: {three:?}");
                count += 1;
                let low = |axis: usize| three.iter().map(|v| corner(v)[axis]).min().unwrap();
                seen[(a.patch * map.segments().pow(2) + low(1) * map.segments() + low(0)) as usize] += 1;
            }
            assert_eq!(count, map.triangles() * u64::from(copies));
            assert!(seen.iter().all(|count| *count == 2));
            assert_eq!(strip[strip.len() - 1].place(), [side - 1; 2]);
            assert_eq!((map.parameter(0), map.parameter(side - 1)), (0.0, 1.0));
        }
        assert!(ParametricMap::new(0).is_err() && ParametricMap::new(MAX_LEVEL + 1).is_err());
    }
}
