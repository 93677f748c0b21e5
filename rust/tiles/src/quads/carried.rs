//! Attributes of a cage on their way to a tessellation: bilinear over the tile for corners and points, copied for
//! faces.

use relievo_core::{Attribute, Context, Domain, Mesh, Values};

use crate::quads::numbering::{Local, Numbering};

/// Attributes of a cage on their way to a tessellation.
pub(crate) struct Carried<'a> {
    pub context: &'a Context,
    pub numbering: &'a Numbering,
    pub cage: &'a Mesh,
    pub offsets: Vec<u32>,
}

impl Carried<'_> {
    pub fn attribute(&self, attribute: &Attribute, tiles: &[u32], locals: &[u32]) -> Attribute {
        let topology = &self.numbering.topology;
        let width = attribute.width as usize;
        let (values, indices) = match attribute.domain {
            Domain::Face => {
                let face = |tile: &u32| topology.face(*tile) as usize * width;
                let values = match &attribute.values {
                    Values::F32(from) => {
                        Values::F32(tiles.iter().flat_map(|tile| &from[face(tile)..][..width]).copied().collect())
                    }
                    Values::U32(from) => {
                        Values::U32(tiles.iter().flat_map(|tile| &from[face(tile)..][..width]).copied().collect())
                    }
                };
                (values, None)
            }
            Domain::Corner => (self.local_values(attribute), Some(locals.to_vec())),
            Domain::Point => (self.point_values(attribute), None),
        };
        let Attribute { name, domain, width, .. } = attribute.clone();
        Attribute { name, domain, width, values, indices }
    }

    /// Values at every tile's own vertices.
    fn local_values(&self, attribute: &Attribute) -> Values {
        let tiles = self.numbering.rates.len();
        let lists = self.context.map(tiles, |tile| {
            let tile = tile as u32;
            if self.numbering.topology.is_hole(tile) {
                return (Vec::new(), Vec::new());
            }
            let parameters = Local::new(self.numbering, tile).parameters;
            self.interpolate(attribute, tile, &parameters)
        });
        match attribute.values {
            Values::F32(_) => Values::F32(lists.into_iter().flat_map(|list| list.0).collect()),
            Values::U32(_) => Values::U32(lists.into_iter().flat_map(|list| list.1).collect()),
        }
    }

    /// Values at every vertex of the mesh: a shared vertex has that of the first tile it belongs to.
    fn point_values(&self, attribute: &Attribute) -> Values {
        let width = attribute.width as usize;
        let count = self.numbering.vertices as usize;
        let mut values = (vec![0f32; count * width], vec![0u32; count * width]);
        let mut done = vec![false; count];
        for tile in (0..self.numbering.rates.len() as u32).filter(|tile| !self.numbering.topology.is_hole(*tile)) {
            let local = Local::new(self.numbering, tile);
            let (floats, integers) = self.interpolate(attribute, tile, &local.parameters);
            for (index, vertex) in local.vertices.iter().enumerate() {
                let (from, to) = (index * width, *vertex as usize * width);
                if std::mem::replace(&mut done[*vertex as usize], true) {
                    continue;
                }
                if floats.is_empty() {
                    values.1[to..to + width].copy_from_slice(&integers[from..from + width]);
                } else {
                    values.0[to..to + width].copy_from_slice(&floats[from..from + width]);
                }
            }
        }
        match attribute.values {
            Values::F32(_) => Values::F32(values.0),
            Values::U32(_) => Values::U32(values.1),
        }
    }

    /// Values at `parameters` of a tile, as floats or as integers. Integers, and the weights that belong to joints,
    /// are those of the nearest corner of the face.
    fn interpolate(&self, attribute: &Attribute, tile: u32, parameters: &[[f32; 2]]) -> (Vec<f32>, Vec<u32>) {
        let topology = &self.numbering.topology;
        let width = attribute.width as usize;
        let face = topology.face(tile) as usize;
        let (first, size) = (self.offsets[face] as usize, self.cage.face_sizes[face] as usize);
        let value = |corner: usize| {
            let corner = first + corner % size;
            width
                * match (attribute.domain, &attribute.indices) {
                    (Domain::Corner, Some(indices)) => indices[corner] as usize,
                    (Domain::Corner, None) => corner,
                    _ => self.cage.corners[corner] as usize,
                }
        };
        let (k, sub) = (topology.sub_corner(tile) as usize, topology.is_sub(tile));
        let nearest = |[u, v]: &[f32; 2]| match (sub, *u >= 0.5, *v >= 0.5) {
            (true, ..) => k,
            (false, false, false) => 0,
            (false, true, false) => 1,
            (false, true, true) => 2,
            (false, false, true) => 3,
        };
        match &attribute.values {
            Values::U32(from) => {
                let copied = parameters.iter().flat_map(|place| &from[value(nearest(place))..][..width]);
                (Vec::new(), copied.copied().collect())
            }
            Values::F32(from) if attribute.name == "weights" => {
                let copied = parameters.iter().flat_map(|place| &from[value(nearest(place))..][..width]);
                (copied.copied().collect(), Vec::new())
            }
            Values::F32(from) => {
                let mut out = Vec::with_capacity(parameters.len() * width);
                let corners: Vec<[f32; 4]> = (0..width)
                    .map(|axis| {
                        let at = |corner: usize| from[value(corner) + axis];
                        if sub {
                            let centre = (0..size).map(at).sum::<f32>() / size as f32;
                            [at(k), 0.5 * (at(k) + at(k + 1)), centre, 0.5 * (at(k) + at(k + size - 1))]
                        } else {
                            std::array::from_fn(at)
                        }
                    })
                    .collect();
                for [u, v] in parameters {
                    out.extend(corners.iter().map(|c| {
                        let (low, high) = (c[0] + (c[1] - c[0]) * u, c[3] + (c[2] - c[3]) * u);
                        low + (high - low) * v
                    }));
                }
                (out, Vec::new())
            }
        }
    }
}
