//! Evaluation of Bézier patches at single places, in f64: position, first and second derivatives, and the normal with
//! its limits where the tangents vanish.
//!
//! Points on edges are evaluated from the control points of the edge alone, in its one direction, so that neighbours
//! agree to the bit when they are asked for the same place of it.

use glam::{DVec2, DVec3, DVec4};
use relievo_core::{Context, Error, Result};

use super::edge::{along, curve};
use super::{BezierSurface, EdgeSense};
use crate::{Place, Sample};

/// Tangents whose cross product is below this share of what they could be vanish, or are parallel.
const FLAT: f64 = 1e-9;

/// By how much of the way to the middle a place is moved where no limit is known.
const NUDGE: f64 = 1.0 / 1024.0;

impl BezierSurface {
    /// Position, derivatives and unit normal at `place`, whose tile is the patch.
    ///
    /// Derivatives are those of the patch itself, which has them everywhere since weights are above zero: along an edge
    /// that is collapsed to a point they are zero, and none of them needs a limit. Those of a rational patch S = P/w
    /// follow from P_uu = S_uu·w + 2·S_u·w_u + S·w_uu and its like (Farin 2002, *Curves and Surfaces for CAGD*, Section
    /// 13.6).
    ///
    /// Where an edge is collapsed to a point, or tangents vanish at a corner, the normal is the limit along the line of
    /// constant u or v that ends there. It is zero only where a patch has no area.
    ///
    /// # Errors
    /// The patch does not exist, or u or v are outside 0 to 1.
    pub fn evaluate(&self, place: Place) -> Result<(Sample, [f32; 3])> {
        self.check_place(place.tile, place.u, place.v)?;
        let patch = place.tile as usize;
        let controls = self.controls(patch);
        let forms = Forms::new(controls, f64::from(place.u), f64::from(place.v));
        let mut sample = forms.sample();
        let second = forms.second(controls, f64::from(place.u), f64::from(place.v));
        [sample.duu, sample.duv, sample.dvv] = second.map(|vector| vector.as_vec3().to_array());
        if let Some((edge, t)) = place.edge() {
            let edge = usize::from(edge);
            sample.p = edge_point(controls, edge, self.edges().senses(patch)[edge], t);
        }
        Ok((sample, self.limit_normal(patch, &forms, f64::from(place.u), f64::from(place.v))))
    }

    /// Whether there is such a place.
    ///
    /// # Errors
    /// The patch does not exist, or u or v are outside 0 to 1.
    pub fn check_place(&self, patch: u32, u: f32, v: f32) -> Result<()> {
        if patch as usize >= self.count() {
            return Err(Error::invalid(format!("patch {patch} does not exist"))
                .advise(format!("use 0 to {}", self.count() - 1)));
        }
        if !((0.0..=1.0).contains(&u) && (0.0..=1.0).contains(&v)) {
            return Err(Error::invalid(format!("u {u} or v {v} is outside the patch"))
                .at(format!("patch {patch}"))
                .advise("use 0 to 1"));
        }
        Ok(())
    }

    /// As [`Self::evaluate`], for many places. Results are in the order of the places.
    ///
    /// # Errors
    /// As there, for the first place that fails.
    pub fn evaluate_many(&self, context: &Context, places: &[Place]) -> Result<Vec<(Sample, [f32; 3])>> {
        const PIECE: usize = 256;
        let pieces = context.map(places.len().div_ceil(PIECE), |piece| {
            let first = piece * PIECE;
            let last = (first + PIECE).min(places.len());
            (first..last)
                .map(|at| self.evaluate(places[at]).map_err(|error| error.at(format!("place {at}"))))
                .collect::<Result<Vec<_>>>()
        });
        let mut results = Vec::with_capacity(places.len());
        for piece in pieces {
            results.extend(piece?);
        }
        Ok(results)
    }

    /// The normal, or its limit.
    pub(super) fn limit_normal(&self, patch: usize, forms: &Forms, u: f64, v: f64) -> [f32; 3] {
        if let Some(normal) = forms.normal() {
            return normal;
        }
        let controls = self.controls(patch);
        // The edges this place is on, and where along them.
        let edges = [(0, v == 0.0, u), (1, u == 1.0, v), (2, v == 1.0, 1.0 - u), (3, u == 0.0, 1.0 - v)];
        let on = edges.iter().filter(|(_, on, _)| *on);
        let near = on.filter_map(|(edge, _, t)| normal_at_edge(controls, *edge, *t)).next();
        let inside = |share: f64| {
            let (u, v) = (u + (0.5 - u) * share, v + (0.5 - v) * share);
            Forms::new(controls, u, v).normal()
        };
        near.or_else(|| inside(NUDGE)).or_else(|| inside(1.0)).unwrap_or_default()
    }
}

/// The point at parameter `t` along `edge`, whichever side asks.
pub(super) fn edge_point(controls: &[[f32; 4]; 16], edge: usize, sense: EdgeSense, t: f32) -> [f32; 3] {
    let mut curve = curve(controls, edge);
    if sense == EdgeSense::Against {
        curve.reverse();
    }
    let basis = bernstein(f64::from(sense.parameter(t)));
    // From the first point on, so that both ends are control points to the bit.
    if basis[3] == 1.0 {
        return [curve[3][0], curve[3][1], curve[3][2]];
    }
    let first = point(&curve[0]);
    let (mut sum, mut weight) = (DVec3::ZERO, 0.0);
    for (control, basis) in curve.iter().zip(basis) {
        let share = basis * f64::from(control[3]);
        sum += share * (point(control) - first);
        weight += share;
    }
    (first + sum / weight).as_vec3().to_array()
}

fn point(control: &[f32; 4]) -> DVec3 {
    DVec3::new(f64::from(control[0]), f64::from(control[1]), f64::from(control[2]))
}

fn bernstein(t: f64) -> [f64; 4] {
    let s = 1.0 - t;
    [s * s * s, 3.0 * t * s * s, 3.0 * t * t * s, t * t * t]
}

fn bernstein_first(t: f64) -> [f64; 4] {
    let s = 1.0 - t;
    [-3.0 * s * s, 3.0 * s * (s - 2.0 * t), 3.0 * t * (2.0 * s - t), 3.0 * t * t]
}

fn bernstein_second(t: f64) -> [f64; 4] {
    let s = 1.0 - t;
    [6.0 * s, 6.0 * (t - 2.0 * s), 6.0 * (s - 2.0 * t), 6.0 * t]
}

/// The homogeneous forms (w·x, w·y, w·z, w) of a place and their derivatives.
pub(super) struct Forms {
    p: DVec4,
    du: DVec4,
    dv: DVec4,
    /// What du and dv could be at most, as lengths.
    reach: DVec2,
}

impl Forms {
    pub(super) fn new(controls: &[[f32; 4]; 16], u: f64, v: f64) -> Self {
        let (bu, bv) = (bernstein(u), bernstein(v));
        let (du, dv) = (bernstein_first(u), bernstein_first(v));
        let mut forms = Self { p: DVec4::ZERO, du: DVec4::ZERO, dv: DVec4::ZERO, reach: DVec2::ZERO };
        for (number, control) in controls.iter().enumerate() {
            let weight = f64::from(control[3]);
            let form = (point(control) * weight).extend(weight);
            let (i, j) = (number % 4, number / 4);
            forms.p += bu[i] * bv[j] * form;
            forms.du += du[i] * bv[j] * form;
            forms.dv += bu[i] * dv[j] * form;
        }
        let longest = |pairs: [[usize; 2]; 12]| {
            let square = |[a, b]: [usize; 2]| point(&controls[a]).distance_squared(point(&controls[b]));
            3.0 * pairs.map(square).into_iter().fold(0.0, f64::max).sqrt()
        };
        forms.reach = DVec2::new(
            longest(std::array::from_fn(|k| [4 * (k / 3) + k % 3, 4 * (k / 3) + k % 3 + 1])),
            longest(std::array::from_fn(|k| [k, k + 4])),
        );
        forms
    }

    /// P, du, dv.
    fn project(&self) -> [DVec3; 3] {
        let p = self.p.truncate() / self.p.w;
        let tangent = |form: DVec4| (form.truncate() - p * form.w) / self.p.w;
        [p, tangent(self.du), tangent(self.dv)]
    }

    /// The second derivatives by uu, uv and vv at the place these forms are of.
    fn second(&self, controls: &[[f32; 4]; 16], u: f64, v: f64) -> [DVec3; 3] {
        let [in_u, in_v] = [u, v].map(|t| [bernstein(t), bernstein_first(t), bernstein_second(t)]);
        let [p, du, dv] = self.project();
        [[2, 0], [1, 1], [0, 2]].map(|[i, j]| {
            // About the place itself, so that how far it is from the origin does not count, and S·w_uu is nothing.
            let sum = controls.iter().enumerate().fold(DVec3::ZERO, |sum, (number, control)| {
                let share = in_u[i][number % 4] * in_v[j][number / 4] * f64::from(control[3]);
                sum + share * (point(control) - p)
            });
            let turned = match i {
                2 => 2.0 * du * self.du.w,
                1 => du * self.dv.w + dv * self.du.w,
                _ => 2.0 * dv * self.dv.w,
            };
            (sum - turned) / self.p.w
        })
    }

    fn sample(&self) -> Sample {
        let [p, du, dv] = self.project().map(|vector| vector.as_vec3().to_array());
        Sample { p, du, dv, ..Sample::default() }
    }

    /// `None` where the tangents vanish or are parallel.
    fn normal(&self) -> Option<[f32; 3]> {
        let [_, du, dv] = self.project();
        unit(du.cross(dv), self.reach.x * self.reach.y)
    }
}

/// `None` for what is but rounding beside `reach`.
fn unit(vector: DVec3, reach: f64) -> Option<[f32; 3]> {
    let length = vector.length();
    (length > FLAT * reach).then(|| (vector / length).as_vec3().to_array())
}

/// The limit of the normal at `t` along an edge where the patch's tangents vanish: the first row of control points that
/// moves along the edge gives the one direction, the first that is elsewhere than the edge the other.
fn normal_at_edge(controls: &[[f32; 4]; 16], edge: usize, t: f64) -> Option<[f32; 3]> {
    // Rows that run along the edge, from the edge inwards.
    let step = [4, -1, -4, 1][edge & 3];
    let row = |inwards: usize| -> [[f32; 4]; 4] {
        std::array::from_fn(|index| controls[(along(edge, index) as isize + step * inwards as isize) as usize & 15])
    };
    let size = {
        let far = |control: &[f32; 4]| point(control).distance(point(&controls[0]));
        controls.iter().map(far).fold(0.0, f64::max)
    };
    let (basis, first) = (bernstein(t), bernstein_first(t));
    let mut start = None;
    let (mut tangent, mut inwards) = (None, None);
    for number in 0..4 {
        let row = row(number);
        let form = |basis: &[f64; 4]| {
            row.iter().zip(basis).fold(DVec4::ZERO, |sum, (control, basis)| {
                let weight = basis * f64::from(control[3]);
                sum + (point(control) * weight).extend(weight)
            })
        };
        let (p, dp) = (form(&basis), form(&first));
        let place = p.truncate() / p.w;
        let along = (dp.truncate() - place * dp.w) / p.w;
        // At a corner where the first control points coincide, towards the first that does not.
        let along = match along.length() > FLAT * size {
            true => Some(along),
            false if t == 0.0 => {
                row.iter().map(|control| point(control) - point(&row[0])).find(|way| way.length() > FLAT * size)
            }
            false if t == 1.0 => {
                row.iter().rev().map(|control| point(&row[3]) - point(control)).find(|way| way.length() > FLAT * size)
            }
            false => None,
        };
        tangent = tangent.or(along);
        let start = *start.get_or_insert(place);
        inwards = inwards.or(Some(place - start).filter(|way| way.length() > FLAT * size));
    }
    let (tangent, inwards) = (tangent?, inwards?);
    unit(tangent.cross(inwards), tangent.length() * inwards.length())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::bezier::CONTROLS;

    /// De Casteljau's algorithm in homogeneous coordinates.
    fn de_casteljau(controls: &[[f32; 4]; CONTROLS], u: f64, v: f64) -> DVec3 {
        let curve = |mut points: [DVec4; 4], t: f64| {
            for round in 0..3 {
                for k in 0..3 - round {
                    points[k] = points[k].lerp(points[k + 1], t);
                }
            }
            points[0]
        };
        let form = |control: &[f32; 4]| (point(control) * f64::from(control[3])).extend(f64::from(control[3]));
        let rows = std::array::from_fn(|j| curve(std::array::from_fn(|i| form(&controls[4 * j + i])), u));
        let form = curve(rows, v);
        form.truncate() / form.w
    }

    fn random(seed: u64) -> impl FnMut() -> f32 {
        let mut state = seed;
        move || {
            state = state.wrapping_mul(6364136223846793005).wrapping_add(1442695040888963407);
            (state >> 40) as f32 / (1 << 24) as f32
        }
    }

    fn surface(seed: u64, rational: bool) -> BezierSurface {
        let mut random = random(seed);
        let points: Vec<[f32; 3]> =
            (0..16).map(|i| [(i % 4) as f32 + random(), (i / 4) as f32 + random(), 2.0 * random()]).collect();
        let weights: Vec<f32> = (0..16).map(|_| 0.25 + 3.0 * random()).collect();
        BezierSurface::new(&Context::serial(), &points, None, rational.then_some(&weights[..])).unwrap()
    }

    #[test]
    fn points_and_derivatives_are_those_of_de_casteljau() {
        for (seed, rational) in [(1, false), (2, true), (3, true)] {
            let surface = surface(seed, rational);
            for (u, v) in [(0.0, 0.0), (1.0, 0.0), (0.3, 0.0), (0.25, 0.6), (1.0, 0.7), (0.9, 1.0), (1.0, 1.0)] {
                let (sample, normal) = surface.evaluate(Place::new(0, u, v)).unwrap();
                let at = |du: f64, dv: f64| de_casteljau(surface.controls(0), f64::from(u) + du, f64::from(v) + dv);
                let step = 1e-5;
                let slope = |a: DVec3, b: DVec3| (a - b) / (2.0 * step);
                let wide = 1e-4;
                let bend = |a: DVec3, b: DVec3| (a - 2.0 * at(0.0, 0.0) + b) / (wide * wide);
                let (duu, dvv) = (bend(at(wide, 0.0), at(-wide, 0.0)), bend(at(0.0, wide), at(0.0, -wide)));
                let across = at(wide, wide) - at(wide, -wide) - at(-wide, wide) + at(-wide, -wide);
                let duv = across / (4.0 * wide * wide);
                let (du, dv) = (slope(at(step, 0.0), at(-step, 0.0)), slope(at(0.0, step), at(0.0, -step)));
                for (got, expected, tolerance) in [
                    (sample.p, at(0.0, 0.0), 1e-6),
                    (sample.du, du, 1e-5),
                    (sample.dv, dv, 1e-5),
                    (normal, du.cross(dv).normalize(), 1e-5),
                    (sample.duu, duu, 1e-4),
                    (sample.duv, duv, 1e-4),
                    (sample.dvv, dvv, 1e-4),
                ] {
                    let got = DVec3::from(got.map(f64::from));
                    assert!(
                        got.distance(expected) < tolerance * expected.length().max(1.0),
                        "{u} {v}: {got} {expected}"
                    );
                }
            }
        }
    }

    #[test]
    fn corners_are_control_points() {
        let surface = surface(7, true);
        for (corner, number) in [(0, 0), (1, 3), (2, 15), (3, 12)] {
            let (sample, _) = surface.evaluate(Place::corner(0, corner)).unwrap();
            assert_eq!(sample.p, surface.controls(0)[number][..3]);
        }
    }

    #[test]
    fn normals_have_limits_where_edges_are_collapsed() {
        // A piece of a paraboloid around its apex: the first row is one point.
        for turned in 0..4 {
            for rational in [false, true] {
                let angle = |i: usize| i as f32 * 0.5;
                let mut points = vec![[0.0; 3]; 16];
                for j in 0..4 {
                    for i in 0..4 {
                        let r = j as f32;
                        let number = along(turned, i) as isize + [4, -1, -4, 1][turned] * j as isize;
                        // Flat at the apex: the second row is as high as the first.
                        let height = -[0.0, 0.0, 1.0, 3.0][j];
                        points[number as usize] = [r * angle(i).cos(), r * angle(i).sin(), height];
                    }
                }
                let weights: Vec<f32> = (0..16).map(|i| 1.0 + i as f32 * 0.2).collect();
                let weights = rational.then_some(&weights[..]);
                let surface = BezierSurface::new(&Context::serial(), &points, None, weights).unwrap();
                assert_eq!(surface.edges().senses(0)[turned], EdgeSense::Collapsed);
                for step in 0..=8 {
                    let place = Place::on_edge(0, turned as u8, step as f32 / 8.0);
                    let (sample, normal) = surface.evaluate(place).unwrap();
                    assert_eq!(sample.p, [0.0; 3]);
                    // u × v runs against the circle seen from the edge inwards, on every side alike.
                    assert!((normal[2] + 1.0).abs() < 1e-6, "{turned} {step}: {normal:?}");
                    let mut near = Place::on_edge(0, turned as u8, step as f32 / 8.0);
                    let inwards = [(0.0, 1.0), (-1.0, 0.0), (0.0, -1.0), (1.0, 0.0)][turned];
                    (near.u, near.v) = (near.u + inwards.0 * 1e-4, near.v + inwards.1 * 1e-4);
                    let (_, beside) = surface.evaluate(near).unwrap();
                    let dot: f32 = (0..3).map(|axis| beside[axis] * normal[axis]).sum();
                    assert!(dot > 1.0 - 1e-5, "{turned} {step}: {normal:?} {beside:?}");
                }
            }
        }
    }

    #[test]
    fn normals_have_limits_at_degenerate_corners() {
        let mut points: Vec<[f32; 3]> = (0..16).map(|i| [(i % 4) as f32, (i / 4) as f32, 0.0]).collect();
        // Both neighbours of the corner coincide with it.
        points[1] = points[0];
        points[4] = points[0];
        let surface = BezierSurface::new(&Context::serial(), &points, None, None).unwrap();
        assert_eq!(surface.evaluate(Place::new(0, 0.0, 0.0)).unwrap().1, [0.0, 0.0, 1.0]);
        let nothing = BezierSurface::new(&Context::serial(), &[[1.0; 3]; 16], None, None).unwrap();
        let (sample, normal) = nothing.evaluate(Place::new(0, 0.3, 0.0)).unwrap();
        assert_eq!((sample.p, normal), ([1.0; 3], [0.0; 3]));
    }

    #[test]
    fn both_sides_of_an_edge_agree_to_the_bit() {
        let mut random = random(11);
        for rational in [false, true] {
            let mut points: Vec<[f32; 3]> = (0..16).map(|_| [random(), random(), random()]).collect();
            let mut weights: Vec<f32> = (0..16).map(|_| 0.5 + random()).collect();
            for edge in 0..4 {
                for other in 0..4 {
                    for reversed in [false, true] {
                        points.truncate(16);
                        weights.truncate(16);
                        points.extend((0..16).map(|_| [0.0; 3]).collect::<Vec<_>>());
                        weights.extend([1.0; 16]);
                        for number in 16..32 {
                            points[number] = [random(), random(), random()];
                        }
                        for index in 0..4 {
                            let from = along(edge, if reversed { 3 - index } else { index });
                            points[16 + along(other, index)] = points[from];
                            weights[16 + along(other, index)] = weights[from];
                        }
                        let weights = rational.then_some(&weights[..]);
                        let surface = BezierSurface::new(&Context::serial(), &points, None, weights).unwrap();
                        let curve = surface.edges().curves(0)[edge];
                        assert_eq!(curve, surface.edges().curves(1)[other]);
                        assert_eq!(surface.edges().sharing(curve as usize).count(), 2);
                        assert_eq!(surface.edges().curve_count(), 7);
                        for step in 0..=32 {
                            let t = step as f32 / 32.0 * 0.97;
                            let t = 1.0 - (1.0 - t);
                            let beside = if reversed { 1.0 - t } else { t };
                            let one = surface.evaluate(Place::on_edge(0, edge as u8, t)).unwrap().0.p;
                            let two = surface.evaluate(Place::on_edge(1, other as u8, beside)).unwrap().0.p;
                            assert_eq!(one, two, "edges {edge} {other}, reversed {reversed}, t {t}");
                        }
                    }
                }
            }
        }
    }

    #[test]
    fn places_outside_are_refused() {
        let surface = surface(5, false);
        assert!(surface.evaluate(Place::new(1, 0.5, 0.5)).is_err());
        assert!(surface.evaluate(Place::new(0, -0.1, 0.5)).is_err());
        assert!(surface.evaluate(Place::new(0, 0.5, f32::NAN)).is_err());
        let context = Context::serial();
        let error = surface.evaluate_many(&context, &[Place::default(), Place::new(0, 2.0, 0.0)]).unwrap_err();
        assert!(error.to_string().starts_with("place 1"));
    }
}
