
void pel_begin_vertex(uvec2 place) {
    pel_is_logged = pel_mode == 3u && place.x == pel_x && place.y == pel_y;
    pel_is_listed = pel_mode == 4u && place.x < pel_x && place.y < pel_y;
    pel_slot = place.y * pel_x + place.x;
}

void pel_end_vertex(vec4 position) {
    uint words = uint(pel_log_values.length());
    if (pel_is_listed && pel_slot < words / (FEATURESu + 6u)) {
        uint first = pel_slot * (FEATURESu + 6u);
        pel_log_values[first] = position.x;
        pel_log_values[first + 1u] = position.y;
        pel_log_values[first + 2u] = position.z;
        pel_log_values[first + 3u] = position.w;
        pel_log_values[first + 4u] = float(pel_added);
        pel_log_values[first + 5u] = pel_total;
        for (uint i = 0u; i < FEATURESu; i++) {
            pel_log_values[first + 6u + i] = pel_sums[i];
        }
    }
}
