#include "picture.hpp"

#include <cstdio>
#include <numeric>
#include <stdexcept>

namespace studio {

Camera::Axes Camera::axes() const {
    const Vec ahead = normalized(target - eye), right = normalized(cross(ahead, {0, 0, 1}));
    return {ahead, right, cross(right, ahead)};
}

std::size_t Picture::covered_count() const { return std::accumulate(covered.begin(), covered.end(), std::size_t{0}); }

std::size_t Picture::apart(const Picture &other, float tolerance) const {
    if (width != other.width || height != other.height) {
        throw std::runtime_error("pictures of different sizes are compared");
    }
    std::size_t count = 0;
    for (std::size_t k = 0; k < pixels.size(); ++k) {
        bool differs = covered[k] != other.covered[k];
        for (std::size_t channel = 0; covered[k] && channel < 3; ++channel) {
            differs |= !(std::abs(pixels[k][channel] - other.pixels[k][channel]) <= tolerance);
        }
        count += differs;
    }
    return count;
}

void Picture::write(const std::string &path) const {
    std::FILE *file = std::fopen(path.c_str(), "wb");
    if (!file) {
        throw std::runtime_error("cannot write " + path);
    }
    std::fprintf(file, "P6\n%u %u\n255\n", width, height);
    for (const Vec &pixel : pixels) {
        for (const float value : pixel) {
            const float light = std::min(std::max(value, 0.0f), 1.0f);
            std::fputc(static_cast<int>(255.0f * std::pow(light, 1.0f / 2.2f) + 0.5f), file);
        }
    }
    if (std::fclose(file) != 0) {
        throw std::runtime_error("cannot write " + path);
    }
}

} // namespace studio
