//! Which particles lie within the support radius of each, in lists that all passes of a step go through.

use glam::{IVec3, Vec4, Vec4Swizzles};
use relievo_core::lanes::Lanes;
use relievo_core::{Context, Error, Result, dispatch_simd};

use crate::solver::cells::Cells;

/// Particles of a task.
pub const CHUNK_LEN: usize = 512;
/// Lists are filled up to multiples of this, the most lanes that a vector has, with the number after the last particle.
pub const LANES: usize = 16;
/// Neighbours of a particle at most.
pub const MAX: usize = 4096;
/// Where nothing is: no particle has it as a neighbour, and no kernel reaches it.
pub const NOWHERE: Vec4 = Vec4::new(1e15, 1e15, 1e15, 0.0);

/// The lists of all particles, by parts of [`CHUNK_LEN`] of them.
#[derive(Default)]
pub struct Neighbours {
    parts: Vec<Part>,
}

/// The lists of the particles of a part.
#[derive(Default)]
pub struct Part {
    /// Where each list begins, and at the end how many indices there are.
    pub starts: Vec<u32>,
    /// The neighbours, in the order of their cells.
    pub indices: Vec<u32>,
    /// The slope of the pressure's kernel towards each neighbour, as a factor of the vector from it.
    pub slopes: Vec<f32>,
    /// Who has too many of them.
    crowded: Option<u32>,
}

impl Neighbours {
    /// Finds what lies within a radius of points, sorted by cells, among `others`, which are followed by [`NOWHERE`] and in
    /// the order of `cells`, whose side is no less than the radius. A point is no neighbour of itself where both are the
    /// same (`is_same`). Points that are skipped get none; an empty list skips none. Fails if there are more than [`MAX`] within the radius of one.
    pub fn find(
        &mut self,
        context: &Context,
        points: &[Vec4],
        (others, cells): (&[Vec4], &Cells),
        radius: f32,
        is_same: bool,
        skipped: &[bool],
    ) -> Result<()> {
        self.parts.resize_with(points.len().div_ceil(CHUNK_LEN), Part::default);
        context.for_each_mut(&mut self.parts, |part, lists| {
            let range = part * CHUNK_LEN..points.len().min((part + 1) * CHUNK_LEN);
            let (points, skipped) = (&points[range.clone()], skipped.get(range).unwrap_or_default());
            lists.clear();
            let first = is_same.then_some((part * CHUNK_LEN) as u32);
            let search = Search { points, skipped, others, cells, square: radius * radius, first };
            find_part(context.level(), &search, lists);
        });
        match self.parts.iter().find_map(|part| part.crowded) {
            None => Ok(()),
            Some(particle) => Err(Error::invalid(format!(
                "more than {MAX} particles are within the support radius of another, number {particle} along the curve"
            ))
            .advise("let fewer particles begin at one place, or make their spacing less")),
        }
    }

    /// The lists of the particles from each multiple of [`CHUNK_LEN`] on.
    pub fn parts(&self) -> &[Part] {
        &self.parts
    }

    /// The same, for passes that find slopes.
    pub fn parts_mut(&mut self) -> &mut [Part] {
        &mut self.parts
    }
}

impl Part {
    fn clear(&mut self) {
        self.starts.clear();
        self.starts.push(0);
        self.indices.clear();
        self.crowded = None;
    }

    /// The places of a particle's neighbours in the part.
    #[inline(always)]
    pub fn range(&self, particle: usize) -> std::ops::Range<usize> {
        self.starts[particle] as usize..self.starts[particle + 1] as usize
    }
}

/// What is searched for.
struct Search<'a> {
    points: &'a [Vec4],
    skipped: &'a [bool],
    others: &'a [Vec4],
    cells: &'a Cells,
    /// The radius squared.
    square: f32,
    /// The number of the first point among the others, if it is one of them.
    first: Option<u32>,
}

/// What is in the cells around one.
#[derive(Default)]
struct Candidates {
    x: Vec<f32>,
    y: Vec<f32>,
    z: Vec<f32>,
    numbers: Vec<u32>,
}

impl Candidates {
    fn gather(&mut self, search: &Search, cell: IVec3) {
        let Self { x, y, z, numbers } = self;
        [&mut *x, y, z].into_iter().for_each(Vec::clear);
        numbers.clear();
        for range in search.cells.around(cell) {
            let others = &search.others[range.clone()];
            x.extend(others.iter().map(|other| other.x));
            y.extend(others.iter().map(|other| other.y));
            z.extend(others.iter().map(|other| other.z));
            numbers.extend(range.start as u32..range.end as u32);
        }
        let whole = numbers.len().next_multiple_of(LANES);
        [x, y, z].into_iter().for_each(|axis| axis.resize(whole, NOWHERE.x));
        numbers.resize(whole, 0);
    }
}

#[inline(always)]
fn find_body<A: Lanes>(v: A, search: &Search, part: &mut Part) {
    let mut candidates = Candidates::default();
    let mut last = IVec3::MAX;
    let square = v.splat(search.square);
    let none = search.others.len() as u32 - 1;
    let mut found = [0u32; MAX + LANES];
    for (particle, point) in (0u32..).zip(search.points) {
        if search.skipped.get(particle as usize).is_some_and(|skipped| *skipped) {
            part.starts.push(part.indices.len() as u32);
            continue;
        }
        // No other has the number of the place after the last one.
        let own = search.first.map_or(none, |first| first + particle);
        let cell = search.cells.cell(point.xyz());
        if cell != last {
            candidates.gather(search, cell);
            last = cell;
        }
        let [px, py, pz] = [point.x, point.y, point.z].map(|at| v.splat(at));
        let mut count = 0;
        for at in (0..candidates.numbers.len()).step_by(A::WIDTH) {
            let x = v.sub(v.load(&candidates.x[at..]), px);
            let y = v.sub(v.load(&candidates.y[at..]), py);
            let z = v.sub(v.load(&candidates.z[at..]), pz);
            let distance = v.fused(x, x, v.fused(y, y, v.mul(z, z)));
            let mut near = v.mask(v.lt(distance, square));
            if count > MAX {
                break;
            }
            while near != 0 {
                let number = candidates.numbers[at + near.trailing_zeros() as usize];
                near &= near - 1;
                found[count] = number;
                count += usize::from(number != own);
            }
        }
        if count > MAX {
            part.crowded = part.crowded.or(Some(own));
        }
        part.indices.extend_from_slice(&found[..count]);
        part.indices.resize(part.indices.len().next_multiple_of(LANES), none);
        part.starts.push(part.indices.len() as u32);
    }
}

dispatch_simd! { fn find_part = find_body(search: &Search, part: &mut Part) }

#[cfg(test)]
mod tests {
    use super::*;

    fn lists(level: &str, points: &[Vec4], radius: f32) -> Result<Vec<Vec<u32>>> {
        let context = Context::serial();
        let mut cells = Cells::default();
        cells.fill(&context, radius, points)?;
        let mut sorted: Vec<Vec4> = cells.order().map(|number| points[number as usize]).collect();
        let order: Vec<u32> = cells.order().collect();
        sorted.push(NOWHERE);
        let mut neighbours = Neighbours::default();
        neighbours.find(&context, &sorted[..points.len()], (&sorted, &cells), radius, true, &[])?;
        let mut lists = vec![Vec::new(); points.len()];
        for (place, number) in order.iter().enumerate() {
            let part = &neighbours.parts()[place / CHUNK_LEN];
            let list = &part.indices[part.range(place % CHUNK_LEN)];
            assert_eq!(list.len() % LANES, 0, "{level}");
            let own = list.iter().filter(|other| (**other as usize) < points.len());
            lists[*number as usize] = own.map(|other| order[*other as usize]).collect();
            lists[*number as usize].sort_unstable();
        }
        Ok(lists)
    }

    #[test]
    fn neighbours_are_those_within_the_radius() {
        let points: Vec<Vec4> = (0..2000u32)
            .map(|i| {
                let at = |k: u32| (i.wrapping_mul(k) >> 8) as f32 / (1 << 24) as f32;
                Vec4::new(at(0x9e37_79b1), at(0x85eb_ca77), at(0xc2b2_ae3d), 0.0)
            })
            .collect();
        for (number, list) in (0u32..).zip(lists("", &points, 0.2).unwrap()) {
            let near = (0..2000u32).filter(|other| {
                *other != number && points[*other as usize].distance_squared(points[number as usize]) < 0.04
            });
            assert!(list.into_iter().eq(near), "{number}");
        }
    }

    #[test]
    fn a_crowd_is_refused() {
        assert!(lists("", &[Vec4::ONE; MAX / 2], 0.1).is_ok());
        assert!(lists("", &[Vec4::ONE; MAX + 2], 0.1).is_err());
    }
}
