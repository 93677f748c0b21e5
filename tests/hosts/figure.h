// What programs that print figures for `cargo xtask bench hosts` share.
#pragma once

#include <algorithm>
#include <cstddef>
#include <vector>

/// The value that a share of them, 0 to 1, is not above.
inline double quantile(std::vector<double> values, double share) {
    std::sort(values.begin(), values.end());
    return values[static_cast<size_t>(share * double(values.size() - 1) + 0.5)];
}

inline double median(std::vector<double> values) { return quantile(std::move(values), 0.5); }
