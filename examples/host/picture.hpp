// Pictures of the renderer and of the viewport, and the camera that they are taken with.
#pragma once

#include "vector.hpp"

#include <string>
#include <vector>

namespace studio {

struct Camera {
    Vec eye, target;
    /// Width of the picture at distance 1.
    float width = 0.9f;

    /// Unit vectors to where it looks, to its right, and up.
    struct Axes {
        Vec ahead, right, up;
    };
    Axes axes() const;
};

/// Linear light, row by row from the top.
struct Picture {
    unsigned width, height;
    std::vector<Vec> pixels;
    /// 1 where a pixel shows an object, else 0.
    std::vector<std::uint8_t> covered;

    std::size_t covered_count() const;

    /// Counts the pixels that show an object in one picture only, or of which a channel differs by more than `tolerance`.
    std::size_t apart(const Picture &other, float tolerance) const;

    /// Writes PPM, as sRGB encodes it.
    void write(const std::string &path) const;
};

} // namespace studio
