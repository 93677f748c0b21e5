// A cage under any of OpenSubdiv's schemes, with attributes of every interpolation, evaluated by Bfr and refined by Far.
#pragma once
#include <cstdint>
#include <memory>
#include <mutex>
#include <shared_mutex>
#include <vector>

#include <opensubdiv/bfr/refinerSurfaceFactory.h>
#include <opensubdiv/bfr/surfaceFactoryCache.h>
#include <opensubdiv/far/topologyRefiner.h>
#include <rust/cxx.h>

#include "../exceptions.h"

namespace relievo {
namespace opensubdiv {

// Defined by the bridge (rust/native/opensubdiv/src/bridge.rs).
struct Cage;
struct Primvar;
struct Rules;
struct Spot;

class Subdivision {
public:
    Subdivision(const Cage& cage, const Rules& rules);

    // Evaluates values at spots. out holds 6 * width numbers for each spot: value, du, dv, duu, duv and dvv per unit of the
    // tile, of which the first 1, 3 or 6 are computed, as derivatives says (0, 1, 2), and the others 0. A face without a
    // limit surface has zeros.
    void evaluate(const Primvar& primvar, rust::Slice<const Spot> spots, uint32_t derivatives, rust::Slice<float> out) const;

private:
    typedef OpenSubdiv::Bfr::SurfaceFactoryCacheThreaded<std::shared_mutex, std::shared_lock<std::shared_mutex>,
                                                         std::unique_lock<std::shared_mutex>>
        Cache;

    std::unique_ptr<OpenSubdiv::Far::TopologyRefiner> topology;
    std::unique_ptr<OpenSubdiv::Bfr::RefinerSurfaceFactory<Cache>> factory;
};

// The faces of a cage after uniform refinement.
class Refined {
public:
    Refined(const Cage& cage, const Rules& rules, uint32_t level);

    // Sizes, corners and faces of the cage of the faces that are no holes.
    rust::Slice<const uint32_t> face_sizes() const { return {sizes.data(), sizes.size()}; }
    rust::Slice<const uint32_t> corners() const { return {points.data(), points.size()}; }
    rust::Slice<const uint32_t> parents() const { return {cage_faces.data(), cage_faces.size()}; }
    // The value of every corner in a channel.
    rust::Vec<uint32_t> channel_corners(uint32_t channel) const;
    // Values of the refined points or of a channel, on the limit surface for vertex and face-varying interpolation.
    rust::Vec<float> values(const Primvar& primvar) const;

private:
    std::unique_ptr<OpenSubdiv::Far::TopologyRefiner> topology;
    std::vector<uint32_t> sizes, points, cage_faces;
    std::vector<int> visible;
};

// As Subdivision::evaluate, by Osd::CpuEvaluator on a patch table of adaptive refinement, for tests.
void osd_evaluate(const Cage& cage, const Rules& rules, const Primvar& primvar, rust::Slice<const Spot> spots,
                  rust::Slice<float> out);

std::unique_ptr<Subdivision> make_subdivision(const Cage& cage, const Rules& rules);
std::unique_ptr<Refined> refine_uniformly(const Cage& cage, const Rules& rules, uint32_t level);

} // namespace opensubdiv
} // namespace relievo
