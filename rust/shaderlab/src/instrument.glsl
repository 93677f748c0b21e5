
layout(std430, set = GROUP, binding = EXAMPLES_BINDING) readonly buffer pel_Examples {
    uint pel_mode; uint pel_x; uint pel_y; uint pel_count; float pel_exponent; float pel_example_values[];
};
layout(std430, set = GROUP, binding = LOG_BINDING) buffer pel_Log {
    uint pel_weighted; uint pel_all; float pel_weight; float pel_log_values[];
};
float pel_vector[FEATURES];
bool pel_is_taken = false;
bool pel_is_logged = false;
bool pel_is_masked = false;
bool pel_is_listed = false;
uint pel_slot = 0u;
uint pel_added = 0u;
float pel_total = 0.0;
float pel_sums[FEATURES];

void pel_begin(uvec2 place) {
    pel_is_logged = pel_mode == 1u && place.x == pel_x && place.y == pel_y;
    pel_is_masked = pel_mode == 2u && place.x < pel_x && place.y < pel_y;
    pel_slot = place.y * pel_x + place.x;
}

float pel_confidence() {
    float belongs = 0.0;
    float total = 0.0;
    float nearest = 0.0;
    uint words = uint(pel_example_values.length());
    uint count = 0u;
    if (pel_is_taken && words >= FEATURESu) {
        count = min(pel_count, (words - FEATURESu) / (FEATURESu + 1u));
    }
    for (uint i = 0u; i < FEATURESu; i++) {
        if ((floatBitsToUint(pel_vector[i]) & 0x7f800000u) == 0x7f800000u) {
            count = 0u;
        }
    }
    float halved = 0.5 * pel_exponent;
    for (uint example = 0u; example < count; example++) {
        uint first = FEATURESu + example * (FEATURESu + 1u);
        float apart = 0.0;
        for (uint i = 0u; i < FEATURESu; i++) {
            float far = (pel_vector[i] - pel_example_values[first + 1u + i]) * pel_example_values[i];
            float near = clamp(far, -MAX_DIFFERENCE, MAX_DIFFERENCE);
            apart += near * near;
        }
        float member = pel_example_values[first];
        if (example == 0u) {
            nearest = apart;
            belongs = member;
            total = 1.0;
        } else if (apart < nearest) {
            float ratio = 0.0;
            if (apart > 0.0) {
                ratio = pow(apart / nearest, halved);
            }
            belongs = belongs * ratio + member;
            total = total * ratio + 1.0;
            nearest = apart;
        } else {
            float ratio = 0.0;
            if (apart == nearest) {
                ratio = 1.0;
            } else if (nearest > 0.0) {
                ratio = pow(nearest / apart, halved);
            }
            belongs += ratio * member;
            total += ratio;
        }
    }
    return count > 0u ? belongs / total : 0.5;
}

void pel_take(float weight) {
    pel_is_taken = true;
    uint words = uint(pel_log_values.length());
    if (pel_is_logged && words >= FEATURESu) {
        uint taken = pel_weighted;
        uint records = (words - FEATURESu) / (FEATURESu + 1u);
        uint record = FEATURESu + pel_all * (FEATURESu + 1u);
        bool fits = pel_all < records;
        if (fits) {
            pel_log_values[record] = weight;
        }
        for (uint i = 0u; i < FEATURESu; i++) {
            if (fits) {
                pel_log_values[record + 1u + i] = pel_vector[i];
            }
            if (weight != 0.0) {
                LOG_VECTOR;
            }
        }
        if (weight != 0.0) {
            pel_weighted = taken + 1u;
            pel_weight = pel_weight + weight;
        }
        pel_all = pel_all + 1u;
    }
    if ((pel_is_masked || pel_is_listed) && weight != 0.0) {
        pel_total += weight;
        for (uint i = 0u; i < FEATURESu; i++) {
            ADD_VECTOR;
        }
        pel_added += 1u;
        if (pel_is_masked && pel_slot < words) {
            float last[FEATURES] = pel_vector;
            for (uint i = 0u; i < FEATURESu; i++) {
                pel_vector[i] = PIXEL_FEATURE;
            }
            pel_log_values[pel_slot] = pel_confidence();
            pel_vector = last;
        }
    }
}
