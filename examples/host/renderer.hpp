// A renderer with an Embree of the host's own, in which details are user geometry that is placed by instances.
#pragma once

#include "object.hpp"
#include "picture.hpp"
#include "pool.hpp"

#include <embree3/rtcore.h>

namespace studio {

class Renderer {
public:
    /// Takes what objects show now; later edits do not matter. Places are turned, moved and scaled evenly. Procedurals
    /// are made by jobs on the pool.
    Renderer(Pool &pool, const std::vector<Object> &objects);
    ~Renderer();
    Renderer(const Renderer &) = delete;
    Renderer &operator=(const Renderer &) = delete;

    /// Renders by a sun, which casts shadows if asked to, and a sky; rows side by side on the pool.
    Picture render(const Camera &camera, unsigned width, unsigned height, bool shadows) const;

private:
    /// A procedural with its place: what Embree's callbacks get, so that it stays where it is.
    struct Shown {
        relievo::Procedural procedural;
        RlvProceduralTable table;
        relievo::Matrix place;
        RTCScene scene;
    };

    void row(const Camera &camera, unsigned y, bool shadows, Picture &picture) const;

    Pool &pool_;
    RTCDevice device_;
    RTCScene scene_;
    std::vector<std::unique_ptr<Shown>> shown_;
};

} // namespace studio
