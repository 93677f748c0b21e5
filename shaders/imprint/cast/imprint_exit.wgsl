// import imprint_solid
// Where rays leave the surface that was voxelised, between the exact heights of the columns around, with the arithmetic of
// `geometry/exits.rs` in rust/detail.

// Squares of cosines between a ray and the surface's normal, in voxels: up to the first nothing is refined, from the second
// on all is.
const GRAZING: vec2<f32> = vec2(0.02, 0.1);

// Voxels to a column that has no end there.
const APART: f32 = 1e9;

// Voxels up to which a ray goes nowhere.
const RESTING: f32 = 0.03125;

struct Exit {
    // The distance at which a ray leaves the voxels.
    far: f32,
    // Voxels along the column from there to the rounded end of the column that is entered.
    gap: f32,
    // Whether it leaves at the upper end of a column.
    upper: bool,
    // Whether it was held at the border of the grid.
    held: bool,
}

// Where the height of the lower end of a column is, or that of the upper end, negated.
fn height_at(column: u32, upper: bool) -> u32 {
    return work.first_column + work.dims.x * work.dims.y + 2u * column + u32(upper);
}

// The exit at the end of a piece of a column. Its height is not known within a column of several, nor where the solid goes on
// beyond the grid.
fn end_exit(column: u32, end: i32, far: f32, upper: bool) -> Exit {
    let noted = i32(spans[height_at(column, upper)]);
    let rest = HEIGHT_UNITS * end - select(noted, -noted, upper);
    let known = rest >= -HEIGHT_UNITS / 2 && rest <= 3 * HEIGHT_UNITS / 2;
    let inner = !known && spans[work.first_column + column] == PIECES;
    let border = select(0, i32(work.dims.z), upper);
    return Exit(far, select(0.0, APART, inner), upper, end == border && !known);
}

// The exit at distance `far` into voxel z of a column, which is clear, at `place` along the column.
fn side_exit(column: u32, z: i32, far: f32, place: f32) -> Exit {
    let span = spans[work.first_column + column];
    if span == PIECES || span == 0u {
        return Exit(far, APART, false, false);
    }
    let upper = z >= i32(span >> 16u);
    return Exit(far, abs(f32(select(span & 0xffffu, span >> 16u, upper)) - place), upper, false);
}

// 1 up to a size, none from its double on, and linear between. `scale` is one by the size, negated.
fn fading(value: f32, scale: f32) -> f32 {
    return clamp(fma(abs(value), scale, 2.0), 0.0, 1.0);
}

// The distance at which a ray leaves the surface. Where that is too steep to be followed from column to column, or the ray
// grazes it, it passes into the distance at which the voxels are left, of which a voxel's length is rounding and goes nowhere.
fn refined(start: vec3<f32>, direction: vec3<f32>, exit: Exit) -> f32 {
    let most = vec2<f32>(work.dims.xy) - 1.0;
    let at = clamp(fma(vec2(exit.far), direction.xy, start.xy) - 0.5, vec2(0.0), most);
    let cell = min(vec2<u32>(at), max(work.dims.xy, vec2(2u)) - 2u);
    let part = at - vec2<f32>(cell);
    let rest = 1.0 - part;
    let sign = select(1.0, -1.0, exit.upper);
    let z = sign * (fma(exit.far, direction.z, start.z) - 0.5);
    let level = i32(z * f32(HEIGHT_UNITS));
    let right = select(0u, 1u, work.dims.x > 1u);
    let below = select(0u, work.dims.x, work.dims.y > 1u);
    let column = cell.y * work.dims.x + cell.x;
    let offsets = vec4(0u, right, below, below + right);
    let shares = vec4(rest.x * rest.y, part.x * rest.y, rest.x * part.y, part.x * part.y);
    var above: vec4<f32>;
    var count: vec4<f32>;
    var sum = 0.0;
    var all = 0.0;
    for (var k = 0u; k < 4u; k++) {
        let height = i32(spans[height_at(column + offsets[k], exit.upper)]);
        above[k] = f32(height - level) * (1.0 / f32(HEIGHT_UNITS));
        count[k] = fading(above[k], -1.0 / work.steep);
        let share = shares[k] * count[k];
        all += rounded(share);
        sum = fma(share, above[k], sum);
    }
    let mean = sum / max(all, 1e-6);
    let corner = fma(count, above - mean, vec4(mean));
    let slope = vec2(
        fma(corner.w - corner.z, part.y, rounded((corner.y - corner.x) * rest.y)),
        fma(corner.w - corner.y, part.x, rounded((corner.z - corner.x) * rest.x)),
    );
    let across = fma(slope.x, direction.x, rounded(slope.y * direction.y));
    let rate = sign * direction.z - across;
    let square = fma(direction.x, direction.x, fma(direction.y, direction.y, rounded(direction.z * direction.z)));
    // Of voxels alone, a voxel's length is rounding, which must not come and go at once.
    let voxels = rounded(exit.far * clamp(fma(rounded(exit.far * exit.far) * square, 1.0 / 3.0, -1.0 / 3.0), 0.0, 1.0));
    let leaves = rate < 0.0;
    let step = mean / select(-1.0, rate, leaves);
    let normal = fma(slope.x, slope.x, fma(slope.y, slope.y, 1.0));
    let facing = rounded(rate * rate) / rounded(square * normal);
    let width = GRAZING.y - GRAZING.x;
    let faced = clamp(fma(facing, 1.0 / width, -GRAZING.x / width), 0.0, 1.0);
    let near = fading(mean / (1.0 + (abs(slope.x) + abs(slope.y))), -1.0);
    let joined = fading(exit.gap, -1.0 / work.steep);
    let weight = select(0.0, faced * rounded(near * joined), leaves);
    let moved = max(fma(weight, (exit.far + step) - voxels, voxels), 0.0);
    return select(moved, 0.0, rounded(moved * moved) * square < RESTING * RESTING);
}
