//! The symmetric Dirichlet energy of a triangle, its gradient and its Hessian, projected to positive semidefinite.
//!
//! The energy is `|J|² (1 + 1/D²)` with the Jacobian `J` of the map from the flat rest triangle to the plane and its
//! determinant `D` (Smith and Schaefer 2015). It is infinite at flips. To turn flipped triangles back it is replaced by
//! `(|J|² + D² + 1) / χ` with `χ = (D + √(ε² + D²)) / 2`, which is finite everywhere and drives them to turn
//! back (Garanzha, Kaporin, Kudryavtseva, Protais, Ray and Sokolov 2021). The eigenvalues of the Hessian in the frame of
//! the singular values have a closed form (Smith, de Goes and Kim 2019).

/// A vector of the plane.
pub type Vec2 = [f64; 2];

/// Returns the distance of two points of the plane.
pub fn distance(a: Vec2, b: Vec2) -> f64 {
    (a[0] - b[0]).hypot(a[1] - b[1])
}

/// The largest slope of a hat function, and the inverse of the least one of its sizes: 32 bits hold its square.
const LARGEST: f64 = 1e18;
/// The smallest ratio of height to longest edge that a rest triangle keeps.
const THINNEST: f64 = 1e-5;

/// The rest shape of a triangle, its first edge along the first axis.
#[derive(Clone, Copy, Debug)]
pub struct Rest {
    /// The gradient of the hat function of the second vertex.
    second: [f32; 2],
    /// The gradient of that of the third vertex along the second axis; along the first it is 0.
    third: f32,
}

/// The second derivatives of an energy of a triangle between its first and second, second and third, third and first
/// corner: by x and x, x and y, y and x, y and y. Those of a corner alone follow, as moving all corners together costs
/// nothing.
pub type Couplings = [[f64; 4]; 3];

/// The energy of a triangle with its derivatives by the positions of its three vertices.
#[derive(Clone, Copy, Debug)]
pub struct Derivatives {
    /// The energy, weighted by the area.
    pub energy: f64,
    /// The derivatives by x and y of each vertex.
    pub gradient: [Vec2; 3],
    /// The projected second derivatives.
    pub couplings: Couplings,
}

impl Rest {
    /// Lays a triangle of space flat, scaled. A triangle that is almost a line gets the least height that keeps the
    /// derivatives finite, so that degenerate faces of a mesh do not spoil their neighbours.
    pub fn new(corners: [[f64; 3]; 3], scale: f64) -> Self {
        let edge = |from: usize, to: usize| -> [f64; 3] {
            std::array::from_fn(|axis| (corners[to][axis] - corners[from][axis]) * scale)
        };
        let dot = |a: [f64; 3], b: [f64; 3]| a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
        let (first, second, third) = (edge(0, 1), edge(0, 2), edge(1, 2));
        let longest = dot(first, first).max(dot(second, second)).max(dot(third, third)).sqrt();
        let longest = if longest > 0.0 { longest } else { f64::MIN_POSITIVE.sqrt() };
        let base = dot(first, first).sqrt().max(THINNEST * longest);
        let along = dot(first, second) / base;
        let height = (dot(second, second) - along * along).max(0.0).sqrt().max(THINNEST * longest);
        let narrow = |value: f64, least: f64| value.clamp(least, LARGEST) as f32;
        let (first, cross) = (narrow(1.0 / base, 1.0 / LARGEST), narrow(-along / (base * height), -LARGEST));
        Self { second: [first, cross], third: narrow(1.0 / height, 1.0 / LARGEST) }
    }

    /// The gradients of the hat functions of the second and of the third vertex, the latter along the second axis.
    fn slopes(&self) -> (Vec2, f64) {
        (self.second.map(f64::from), f64::from(self.third))
    }

    /// Returns the area in square units of the plane.
    pub fn area(&self) -> f64 {
        let ([x, _], third) = self.slopes();
        0.5 / (x * third)
    }

    /// Returns the Jacobian of the map that takes the rest triangle to these positions, row by row.
    pub fn jacobian(&self, positions: [Vec2; 3]) -> [Vec2; 2] {
        let ([x, y], third) = self.slopes();
        std::array::from_fn(|row| {
            let (a, b) = (positions[1][row] - positions[0][row], positions[2][row] - positions[0][row]);
            [a * x, a * y + b * third]
        })
    }

    /// Returns the determinant of the Jacobian: the signed ratio of the areas.
    pub fn determinant(&self, positions: [Vec2; 3]) -> f64 {
        let [[a, b], [c, d]] = self.jacobian(positions);
        a * d - b * c
    }

    /// Returns the energy weighted by the area; infinite for a flipped triangle if `epsilon` is 0.
    pub fn energy(&self, positions: [Vec2; 3], epsilon: f64) -> f64 {
        let [[a, b], [c, d]] = self.jacobian(positions);
        let (square, determinant) = (a * a + b * b + c * c + d * d, a * d - b * c);
        if epsilon == 0.0 && determinant <= 0.0 {
            return f64::INFINITY;
        }
        let Terms { h, k } = Terms::new(determinant, epsilon);
        self.area() * (square * h[0] + k[0])
    }

    /// Returns the matrix of the energy `|J - R|²`, weighted by the area, for one coordinate.
    pub fn stiffness(&self) -> [[f64; 3]; 3] {
        let (hats, weight) = (self.hats(), 2.0 * self.area());
        let product = |a: Vec2, b: Vec2| weight * (a[0] * b[0] + a[1] * b[1]);
        std::array::from_fn(|row| std::array::from_fn(|column| product(hats[row], hats[column])))
    }

    /// Returns the forces that turn a triangle towards the rotation nearest to its map, for its three vertices
    /// (Liu, Zhang, Xu, Gotsman and Gortler 2008).
    pub fn rotation_forces(&self, positions: [Vec2; 3]) -> [Vec2; 3] {
        let [[a, b], [c, d]] = self.jacobian(positions);
        let (cos, sin) = (a + d, c - b);
        let norm = cos.hypot(sin);
        let (cos, sin) = if norm > 0.0 { (cos / norm, sin / norm) } else { (1.0, 0.0) };
        let weight = 2.0 * self.area();
        self.hats().map(|hat| [weight * (cos * hat[0] - sin * hat[1]), weight * (sin * hat[0] + cos * hat[1])])
    }

    /// The gradients of the hat functions.
    fn hats(&self) -> [Vec2; 3] {
        let ([x, y], third) = self.slopes();
        [[-x, -y - third], [x, y], [0.0, third]]
    }

    /// Returns the energy with its derivatives.
    ///
    /// Vectors of the plane are complex numbers here: products of two hat gradients turn by twice the angle by which the
    /// gradients turn, so that no half angles are needed.
    pub fn derivatives(&self, positions: [Vec2; 3], epsilon: f64) -> Derivatives {
        let [[a, b], [c, d]] = self.jacobian(positions);
        // The rotation and the reflection that the Jacobian is the sum of; their norms give the singular values, of which
        // the smaller one has the sign of the determinant.
        let (e, f, g, h) = (0.5 * (a + d), 0.5 * (a - d), 0.5 * (c + b), 0.5 * (c - b));
        let (q, r) = ((e * e + h * h).sqrt(), (f * f + g * g).sqrt());
        let (larger, smaller) = (q + r, q - r);
        let (rotation, reflection) = (unit(e, h, q), unit(f, g, r));
        // Twice the angles that the singular vectors of the plane and of the rest triangle have.
        let left = times(rotation, reflection);
        let right = times(rotation, [reflection[0], -reflection[1]]);

        let (square, determinant) = (a * a + b * b + c * c + d * d, a * d - b * c);
        let Terms { h: [h0, h1, h2], k: [k0, k1, k2] } = Terms::new(determinant, epsilon);
        let (first, second) = (square * h1 + k1, square * h2 + k2);
        let p = 2.0 * h0 + 4.0 * determinant * h1 + second * smaller * smaller;
        let s = 2.0 * h0 + 4.0 * determinant * h1 + second * larger * larger;
        let o = 2.0 * square * h1 + first + second * determinant;
        // The block of the scalings without its negative eigenvalues: the mean and half the difference of the diagonal,
        // and the other entry.
        let (mean, half) = (0.5 * (p + s), 0.5 * (p - s));
        let radius = (half * half + o * o).sqrt();
        let (most, least) = ((mean + radius).max(0.0), (mean - radius).max(0.0));
        let [cos, sin] = unit(half, o, radius);
        let (mean, half, other) = (0.5 * (most + least), 0.5 * (most - least) * cos, 0.5 * (most - least) * sin);
        let (twist, flip) = (0.5 * (2.0 * h0 + first).max(0.0), 0.5 * (2.0 * h0 - first).max(0.0));
        let (shears, skew) = (flip + twist, flip - twist);

        let (hats, area) = (self.hats(), self.area());
        // The derivatives by the Jacobian.
        let (scaled, mirrored) = (2.0 * h0 * area, first * area);
        let stress = [
            [scaled * a + mirrored * d, scaled * b - mirrored * c],
            [scaled * c - mirrored * b, scaled * d + mirrored * a],
        ];
        let gradient = hats.map(|[x, y]| stress.map(|[along, across]| along * x + across * y));
        let couplings = [(0, 1), (1, 2), (2, 0)].map(|(from, to)| {
            let ([x, y], [u, v]) = (hats[from], hats[to]);
            let (inner, outer) = (area * (x * u + y * v), area * (x * v - y * u));
            let [real, imaginary] = times(right, [area * (x * u - y * v), area * (x * v + y * u)]);
            let trace = (mean + shears) * inner + half * real;
            let turned = times(left, [half * inner + (mean - shears) * real, (other + skew) * imaginary]);
            let anti = (other - skew) * outer;
            [trace + turned[0], turned[1] + anti, turned[1] - anti, trace - turned[0]].map(|entry| 0.5 * entry)
        });
        Derivatives { energy: area * (square * h0 + k0), gradient, couplings }
    }
}

/// A vector of length `norm` scaled to length 1; the first axis for one without length.
fn unit(x: f64, y: f64, norm: f64) -> Vec2 {
    if norm > 0.0 { [x / norm, y / norm] } else { [1.0, 0.0] }
}

/// The product of two complex numbers.
fn times(a: Vec2, b: Vec2) -> Vec2 {
    [a[0] * b[0] - a[1] * b[1], a[0] * b[1] + a[1] * b[0]]
}

/// The parts of the energy that depend on the determinant alone, with two derivatives: `|J|² h + k`.
struct Terms {
    h: [f64; 3],
    k: [f64; 3],
}

impl Terms {
    fn new(determinant: f64, epsilon: f64) -> Self {
        if epsilon == 0.0 {
            let inverse = 1.0 / determinant;
            let square = inverse * inverse;
            return Self { h: [1.0 + square, -2.0 * square * inverse, 6.0 * square * square], k: [0.0; 3] };
        }
        let root = determinant.hypot(epsilon);
        // For negative determinants the sum cancels; its conjugate does not.
        let value = if determinant >= 0.0 {
            0.5 * (determinant + root)
        } else {
            0.5 * epsilon * epsilon / (root - determinant)
        };
        let (first, second) = (value / root, 0.5 * epsilon * epsilon / root.powi(3));
        let inverse = 1.0 / value;
        let h1 = -first * inverse * inverse;
        let h2 = 2.0 * first * first * inverse.powi(3) - second * inverse * inverse;
        let size = determinant * determinant + 1.0;
        let k1 = 2.0 * determinant * inverse + size * h1;
        let k2 = 2.0 * inverse + 4.0 * determinant * h1 + size * h2;
        Self { h: [inverse, h1, h2], k: [size * inverse, k1, k2] }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const CORNERS: [[f64; 3]; 3] = [[0.0, 0.0, 1.0], [2.0, 0.5, 1.0], [0.3, 1.5, 0.2]];

    #[test]
    fn an_isometry_has_the_least_energy_and_no_gradient() {
        let rest = Rest::new(CORNERS, 1.0);
        let ([x, y], third) = rest.slopes();
        let flat = [[0.0, 0.0], [1.0 / x, 0.0], [-y / x / third, 1.0 / third]];
        let derivatives = rest.derivatives(flat, 0.0);
        assert!((derivatives.energy - 4.0 * rest.area()).abs() < 1e-12);
        assert!(derivatives.gradient.as_flattened().iter().all(|value| value.abs() < 1e-12), "{derivatives:?}");
    }

    #[test]
    fn derivatives_agree_with_differences() {
        let rest = Rest::new(CORNERS, 0.7);
        let places = [
            ([[0.1, 0.2], [1.3, 0.0], [0.4, 0.8]], 0.0),
            ([[0.1, 0.2], [1.3, 0.0], [0.4, -0.3]], 0.2),
            ([[0.1, 0.2], [0.3, 0.9], [-0.4, 0.3]], 0.0),
            ([[0.1, 0.2], [1.3, 0.1], [0.4, 0.8]], 0.4),
        ];
        for (positions, epsilon) in places {
            let derivatives = rest.derivatives(positions, epsilon);
            assert!((derivatives.energy - rest.energy(positions, epsilon)).abs() < 1e-9 * derivatives.energy);
            for unknown in 0..6 {
                let moved = |by: f64| {
                    let mut moved = positions;
                    moved[unknown / 2][unknown % 2] += by;
                    rest.energy(moved, epsilon)
                };
                let slope = (moved(1e-6) - moved(-1e-6)) / 2e-6;
                let expected = derivatives.gradient[unknown / 2][unknown % 2];
                assert!((slope - expected).abs() < 1e-5 * (1.0 + expected.abs()), "{unknown}: {slope} {expected}");
            }
        }
    }

    #[test]
    fn the_hessian_is_exact_where_it_is_convex() {
        // A stretched triangle, far from the directions that the projection removes.
        let rest = Rest::new([[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]], 1.0);
        let positions = [[0.0, 0.0], [1.3, 0.1], [-0.05, 1.25]];
        let derivatives = rest.derivatives(positions, 0.0);
        for unknown in 0..6 {
            let gradient = |by: f64| {
                let mut moved = positions;
                moved[unknown / 2][unknown % 2] += by;
                rest.derivatives(moved, 0.0).gradient
            };
            let (above, below) = (gradient(1e-5), gradient(-1e-5));
            for row in 0..6 {
                let (corner, axis, other) = (row / 2, row % 2, unknown / 2);
                let expected = (above[corner][axis] - below[corner][axis]) / 2e-5;
                let found: f64 = if corner == other {
                    let others = [(corner + 1) % 3, (corner + 2) % 3];
                    -others
                        .map(|other| entry(&derivatives.couplings, corner, other, axis, unknown % 2))
                        .iter()
                        .sum::<f64>()
                } else {
                    entry(&derivatives.couplings, corner, other, axis, unknown % 2)
                };
                assert!((found - expected).abs() < 1e-4, "{row} {unknown}: {found} {expected}");
            }
        }
    }

    /// The second derivative by coordinates of two corners.
    fn entry(couplings: &Couplings, from: usize, to: usize, row: usize, column: usize) -> f64 {
        if (from + 1) % 3 == to { couplings[from][2 * row + column] } else { couplings[to][2 * column + row] }
    }
}
