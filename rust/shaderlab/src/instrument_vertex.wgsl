
fn pel_begin_vertex(place: vec2<u32>) {
    pel_is_logged = pel_examples.mode == 3u && place.x == pel_examples.x && place.y == pel_examples.y;
    pel_is_listed = pel_examples.mode == 4u && place.x < pel_examples.x && place.y < pel_examples.y;
    pel_slot = place.y * pel_examples.x + place.x;
}

fn pel_end_vertex(position: vec4<f32>) {
    if (pel_is_listed && pel_slot < arrayLength(&pel_log.values) / (FEATURESu + 6u)) {
        let first = pel_slot * (FEATURESu + 6u);
        pel_log.values[first] = position.x;
        pel_log.values[first + 1u] = position.y;
        pel_log.values[first + 2u] = position.z;
        pel_log.values[first + 3u] = position.w;
        pel_log.values[first + 4u] = f32(pel_added);
        pel_log.values[first + 5u] = pel_total;
        for (var i = 0u; i < FEATURESu; i++) {
            pel_log.values[first + 6u + i] = pel_sums[i];
        }
    }
}
