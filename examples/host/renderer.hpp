// A renderer with an Embree of the host's own, in which details are user geometry that is placed by instances.
#pragma once

#include "object.hpp"
#include "pool.hpp"

#include <embree3/rtcore.h>

namespace studio {

struct Camera {
    relievo::Float3 eye, target;
    /// Width of the picture at distance 1.
    float width = 0.9f;
};

/// Linear light, row by row from the top, and how many of the pixels show an object.
struct Picture {
    unsigned width, height;
    std::vector<relievo::Float3> pixels;
    std::size_t covered;

    /// Writes PPM, as sRGB encodes it.
    void write(const std::string &path) const;
};

class Renderer {
public:
    /// Takes what objects show now; later edits do not matter. Places are turned, moved and scaled evenly. Procedurals
    /// are made by jobs on the pool.
    Renderer(Pool &pool, const std::vector<Object> &objects);
    ~Renderer();
    Renderer(const Renderer &) = delete;
    Renderer &operator=(const Renderer &) = delete;

    /// Renders by a sun and a sky, rows side by side on the pool.
    Picture render(const Camera &camera, unsigned width, unsigned height) const;

private:
    /// A procedural with its place: what Embree's callbacks get, so that it stays where it is.
    struct Shown {
        relievo::Procedural procedural;
        RlvProceduralTable table;
        relievo::Matrix place;
        RTCScene scene;
    };

    void row(const Camera &camera, unsigned y, Picture &picture, std::size_t &covered) const;

    Pool &pool_;
    RTCDevice device_;
    RTCScene scene_;
    std::vector<std::unique_ptr<Shown>> shown_;
};

} // namespace studio
