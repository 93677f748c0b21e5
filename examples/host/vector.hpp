// Vectors of three floats, as the renderer and the viewport compute with them.
#pragma once

#include <relievo/relievo.hpp>

#include <algorithm>
#include <cmath>

namespace studio {

using Vec = relievo::Float3;

inline Vec operator+(const Vec &a, const Vec &b) { return {a[0] + b[0], a[1] + b[1], a[2] + b[2]}; }
inline Vec operator-(const Vec &a, const Vec &b) { return {a[0] - b[0], a[1] - b[1], a[2] - b[2]}; }
inline Vec operator*(const Vec &a, float s) { return {a[0] * s, a[1] * s, a[2] * s}; }
inline float dot(const Vec &a, const Vec &b) { return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]; }
inline Vec cross(const Vec &a, const Vec &b) {
    return {a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]};
}
inline Vec normalized(const Vec &a) { return a * (1.0f / std::sqrt(std::max(dot(a, a), 1e-30f))); }

/// A direction of an object in the world: columns of the matrix are the images of the axes.
inline Vec turned(const relievo::Matrix &matrix, const Vec &v) {
    Vec made{};
    for (std::size_t axis = 0; axis < 3; ++axis) {
        for (std::size_t column = 0; column < 3; ++column) {
            made[axis] += static_cast<float>(matrix[3 * column + axis]) * v[column];
        }
    }
    return made;
}

} // namespace studio
