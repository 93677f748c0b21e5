// import progressive_follow
// Where the vertices of splits of one depth were that have something near that an edit has moved: where the quadrics of the
// triangles as they are now want them (`placement.rs`), as if the splits were taken back.

/// As `progressive_record.wgsl` has them.
@group(1) @binding(1) var<storage, read_write> touched: array<u32>;

const MIDDLE: f32 = 1e-5;
const REACH: f32 = 4.0;
const SIDE: f32 = 0.01;

/// A split with what is around.
struct Site {
    ring: vec4<u32>,
    ends: array<vec3<f32>, 2>,
}

/// The point of a vertex of the ring, or of the split, by its number.
fn point_of(site: Site, number: u32) -> vec3<f32> {
    let at = site.ring.x + number;
    if at >= site.ring.w {
        return site.ends[at - site.ring.w];
    }
    return now(star(at) & NODE).point;
}

/// The normal of a triangle by the root of its length.
fn root_normal(a: vec3<f32>, b: vec3<f32>) -> vec3<f32> {
    let normal = cross(a * work.scale, b * work.scale);
    return normal / max(sqrt(length(normal)), 1e-18);
}

/// What a border adds.
fn border(along: vec3<f32>) -> mat3x3<f32> {
    let square = dot(along, along);
    return mat3x3(vec3(square, 0.0, 0.0), vec3(0.0, square, 0.0), vec3(0.0, 0.0, square)) - outer(along, along);
}

@compute @workgroup_size(GROUP)
fn coarsen(id: Invocation) {
    let item = linear_item(id);
    if item >= work.count {
        return;
    }
    let split = order[work.first + item];
    let word = arrayLength(&touched) / 2u + split / 16u;
    if (touched[word] >> (2u * split % 32u) & 1u) == 0u {
        return;
    }
    let ring = ring_of(split);
    let start = starts[split];
    let second = ring.w + star(start + 3u);
    let here = array(now(2u * split), now(2u * split + 1u));
    // Where in `stars` the triangles at its first vertex begin, at its second one, and where they end.
    let spokes = vec3(ring.w, second, second + star(start + 4u));
    let site = Site(ring, array(here[0].point, here[1].point));
    var quadrics: array<mat3x3<f32>, 2>;
    var sums: array<vec3<f32>, 2>;
    var sides: array<vec3<f32>, 2>;
    var side_count = 0u;
    for (var side = 0u; side < 2u; side++) {
        let own = here[side].point;
        let other = ring.w - ring.x + 1u - side;
        var quadric = mat3x3<f32>();
        var sum = vec3(0.0);
        var edges = 0u;
        for (var k = spokes[side]; k < spokes[side + 1u]; k++) {
            let after = star(k) & 0xffffu;
            let last = star(k) >> 16u;
            let normal = root_normal(point_of(site, after) - own, point_of(site, last) - own);
            quadric += outer(normal, normal);
            sum += normal;
            if after == other || last == other {
                if side == 0u && side_count < 2u {
                    sides[side_count] = normal;
                    side_count += 1u;
                }
                edges += 1u;
            }
        }
        for (var k = ring.x; k < ring.w; k++) {
            if (star(k) & (BORDER << side)) != 0u {
                quadric += border((now(star(k) & NODE).point - own) * work.scale);
            }
        }
        if edges == 1u {
            quadric += border((here[1u - side].point - own) * work.scale);
        }
        quadrics[side] = quadric;
        sums[side] = sum;
    }
    // A vertex that stayed when the mesh was built still does.
    let parent = splits[split].parent;
    let one = built(parent);
    let stayed = vec2(all(built(2u * split).point == one.point), all(built(2u * split + 1u).point == one.point));
    let e = (here[1].point - here[0].point) * work.scale;
    let ee = dot(e, e);
    var a = quadrics[0] + quadrics[1] - outer(sides[0], sides[0]) - outer(sides[1], sides[1]);
    if side_count == 1u {
        a -= border(e);
    }
    let b = 0.5 * ((quadrics[1] - quadrics[0]) * e);
    let g = sums[0] + sums[1] - sides[0] - sides[1];
    let h = 0.5 * dot(sums[1] - sums[0], e);
    let trace = a[0].x + a[1].y + a[2].z;
    let scale = 1.0 / max(trace, 1e-30);
    // L D Lᵀ of the quadric with the middle on its diagonal.
    let low = 0.5 * MIDDLE;
    let m = a * scale;
    let d0 = max(m[0].x + MIDDLE, low);
    let l10 = m[0].y / d0;
    let l20 = m[0].z / d0;
    let d1 = max(m[1].y + MIDDLE - l10 * m[0].y, low);
    let t = m[1].z - l10 * m[0].z;
    let l21 = t / d1;
    let d2 = max(m[2].z + MIDDLE - l20 * m[0].z - l21 * t, low);
    var solved: array<vec3<f32>, 2>;
    for (var k = 0u; k < 2u; k++) {
        let q = select(b * scale, g, k == 1u);
        let y1 = q.y - l10 * q.x;
        let z = (q.z - l20 * q.x - l21 * y1) / d2;
        let y = y1 / d1 - l21 * z;
        solved[k] = vec3(q.x / d0 - l10 * y - l20 * z, y, z);
    }
    let keep = dot(g, g) > SIDE * trace;
    let lambda = select(0.0, (h - dot(g, solved[0])) / max(dot(g, solved[1]), 1e-30), keep);
    let x = lambda * solved[1] + solved[0];
    var point = 0.5 * (here[0].point + here[1].point);
    if dot(x, x) <= REACH * ee {
        point += x / work.scale;
    }
    point = select(point, here[1].point, stayed.y);
    point = select(point, here[0].point, stayed.x);
    var normal = vec3(0.0);
    for (var side = 0u; side < 2u; side++) {
        let other = ring.w - ring.x + 1u - side;
        for (var k = spokes[side]; k < spokes[side + 1u]; k++) {
            let after = star(k) & 0xffffu;
            let last = star(k) >> 16u;
            if after != other && last != other {
                normal += root_normal(point_of(site, after) - point, point_of(site, last) - point);
            }
        }
    }
    let merged = Place(point, 1u, unit_or(normal, one.normal));
    for (var side = 0u; side < 2u; side++) {
        set_note(2u * split + side, back(surroundings(beside(ring, side), array(one, merged)), here[side]));
    }
    set_place(parent, merged);
}
