
struct pel_Examples { mode: u32, x: u32, y: u32, count: u32, exponent: f32, values: array<f32> }
struct pel_Log { weighted: u32, taken: u32, weight: f32, values: array<f32> }
@group(GROUP) @binding(EXAMPLES_BINDING) var<storage, read> pel_examples: pel_Examples;
@group(GROUP) @binding(LOG_BINDING) var<storage, read_write> pel_log: pel_Log;
var<private> pel_vector: array<f32, FEATURES>;
var<private> pel_is_taken: bool;
var<private> pel_is_logged: bool;
var<private> pel_is_masked: bool;
var<private> pel_is_listed: bool;
var<private> pel_slot: u32;
var<private> pel_added: u32;
var<private> pel_total: f32;
var<private> pel_sums: array<f32, FEATURES>;

fn pel_begin(place: vec2<u32>) {
    pel_is_logged = pel_examples.mode == 1u && place.x == pel_examples.x && place.y == pel_examples.y;
    pel_is_masked = pel_examples.mode == 2u && place.x < pel_examples.x && place.y < pel_examples.y;
    pel_slot = place.y * pel_examples.x + place.x;
}

fn pel_take(weight: f32) {
    pel_is_taken = true;
    if (pel_is_logged && arrayLength(&pel_log.values) >= FEATURESu) {
        let taken = pel_log.weighted;
        let records = (arrayLength(&pel_log.values) - FEATURESu) / (FEATURESu + 1u);
        let record = FEATURESu + pel_log.taken * (FEATURESu + 1u);
        let fits = pel_log.taken < records;
        if (fits) {
            pel_log.values[record] = weight;
        }
        for (var i = 0u; i < FEATURESu; i++) {
            if (fits) {
                pel_log.values[record + 1u + i] = pel_vector[i];
            }
            if (weight != 0.0) {
                LOG_VECTOR;
            }
        }
        if (weight != 0.0) {
            pel_log.weighted = taken + 1u;
            pel_log.weight = pel_log.weight + weight;
        }
        pel_log.taken = pel_log.taken + 1u;
    }
    if ((pel_is_masked || pel_is_listed) && weight != 0.0) {
        pel_total += weight;
        for (var i = 0u; i < FEATURESu; i++) {
            ADD_VECTOR;
        }
        pel_added += 1u;
        if (pel_is_masked && pel_slot < arrayLength(&pel_log.values)) {
            let last = pel_vector;
            for (var i = 0u; i < FEATURESu; i++) {
                pel_vector[i] = PIXEL_FEATURE;
            }
            pel_log.values[pel_slot] = pel_confidence();
            pel_vector = last;
        }
    }
}

fn pel_confidence() -> f32 {
    var belongs = 0.0;
    var total = 0.0;
    var nearest = 0.0;
    let length = arrayLength(&pel_examples.values);
    var count = 0u;
    if (pel_is_taken && length >= FEATURESu) {
        count = min(pel_examples.count, (length - FEATURESu) / (FEATURESu + 1u));
    }
    for (var i = 0u; i < FEATURESu; i++) {
        if ((bitcast<u32>(pel_vector[i]) & 0x7f800000u) == 0x7f800000u) {
            count = 0u;
        }
    }
    let halved = 0.5 * pel_examples.exponent;
    for (var example = 0u; example < count; example++) {
        let first = FEATURESu + example * (FEATURESu + 1u);
        var distance = 0.0;
        for (var i = 0u; i < FEATURESu; i++) {
            let far = (pel_vector[i] - pel_examples.values[first + 1u + i]) * pel_examples.values[i];
            let near = clamp(far, -MAX_DIFFERENCE, MAX_DIFFERENCE);
            distance += near * near;
        }
        let member = pel_examples.values[first];
        if (example == 0u) {
            nearest = distance;
            belongs = member;
            total = 1.0;
        } else if (distance < nearest) {
            var ratio = 0.0;
            if (distance > 0.0) {
                ratio = pow(distance / nearest, halved);
            }
            belongs = belongs * ratio + member;
            total = total * ratio + 1.0;
            nearest = distance;
        } else {
            var ratio = 0.0;
            if (distance == nearest) {
                ratio = 1.0;
            } else if (nearest > 0.0) {
                ratio = pow(nearest / distance, halved);
            }
            belongs += ratio * member;
            total += ratio;
        }
    }
    var confidence = 0.5;
    if (count > 0u) {
        confidence = belongs / total;
    }
    return confidence;
}
