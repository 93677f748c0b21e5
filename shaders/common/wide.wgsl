// Signed integers of 64 and 96 bits in words of 32, the low one first: predicates that must be the same on every device.

// The product of two words.
fn wide_mul(a: u32, b: u32) -> vec2<u32> {
    let low = vec2(a, b) & vec2(0xffffu);
    let high = vec2(a, b) >> vec2(16u);
    let middle = low.x * high.y + ((low.x * low.y) >> 16u);
    let other = high.x * low.y + (middle & 0xffffu);
    return vec2(a * b, high.x * high.y + (middle >> 16u) + (other >> 16u));
}

fn wide_add(a: vec2<u32>, b: vec2<u32>) -> vec2<u32> {
    let low = a.x + b.x;
    return vec2(low, a.y + b.y + u32(low < a.x));
}

fn wide_neg(a: vec2<u32>) -> vec2<u32> {
    return wide_add(~a, vec2(1u, 0u));
}

fn wide_sub(a: vec2<u32>, b: vec2<u32>) -> vec2<u32> {
    return vec2(a.x - b.x, a.y - b.y - u32(a.x < b.x));
}

fn wide_negative(a: vec2<u32>) -> bool {
    return (a.y >> 31u) == 1u;
}

// The product of two signed words.
fn wide_product(a: i32, b: i32) -> vec2<u32> {
    let product = wide_mul(u32(a), u32(b));
    let excess = select(0u, u32(b), a < 0) + select(0u, u32(a), b < 0);
    return vec2(product.x, product.y - excess);
}

// a·b − c·d.
fn wide_cross(a: i32, b: i32, c: i32, d: i32) -> vec2<u32> {
    return wide_sub(wide_product(a, b), wide_product(c, d));
}

// The number as a float, to a few units in its last place.
fn wide_float(a: vec2<u32>) -> f32 {
    let negative = wide_negative(a);
    let size = select(a, wide_neg(a), negative);
    let value = f32(size.y) * 4294967296.0 + f32(size.x);
    return select(value, -value, negative);
}

fn wider_add(a: vec3<u32>, b: vec3<u32>) -> vec3<u32> {
    let low = a.x + b.x;
    let carry = u32(low < a.x);
    let middle = a.y + b.y;
    let sum = middle + carry;
    return vec3(low, sum, a.z + b.z + u32(middle < a.y) + u32(sum < middle));
}

fn wider_neg(a: vec3<u32>) -> vec3<u32> {
    return wider_add(~a, vec3(1u, 0u, 0u));
}

fn wider_negative(a: vec3<u32>) -> bool {
    return (a.z >> 31u) == 1u;
}

// The number as a float, to a few units in its last place.
fn wider_float(a: vec3<u32>) -> f32 {
    let negative = wider_negative(a);
    let size = select(a, wider_neg(a), negative);
    let value = (f32(size.z) * 4294967296.0 + f32(size.y)) * 4294967296.0 + f32(size.x);
    return select(value, -value, negative);
}

// The product of a number of 64 bits and a signed word.
fn wider_product(a: vec2<u32>, b: i32) -> vec3<u32> {
    let size = select(a, wide_neg(a), wide_negative(a));
    let word = u32(abs(b));
    let low = wide_mul(size.x, word);
    let high = wide_mul(size.y, word);
    let middle = low.y + high.x;
    let product = vec3(low.x, middle, high.y + u32(middle < low.y));
    return select(product, wider_neg(product), wide_negative(a) != (b < 0));
}
