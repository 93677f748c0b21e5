// OpenSubdiv's description of a cage. Include the bridge before this header.
#pragma once
#include <opensubdiv/far/topologyDescriptor.h>

namespace relievo {
namespace opensubdiv {

// Borrows the arrays of the cage.
inline OpenSubdiv::Far::TopologyDescriptor describe(const Cage& cage) {
    OpenSubdiv::Far::TopologyDescriptor topology;
    topology.numVertices = (int)cage.point_count;
    topology.numFaces = (int)cage.face_sizes.size();
    topology.numVertsPerFace = cage.face_sizes.data();
    topology.vertIndicesPerFace = cage.corners.data();
    topology.numCreases = (int)cage.crease_sharpness.size();
    topology.creaseVertexIndexPairs = cage.crease_points.data();
    topology.creaseWeights = cage.crease_sharpness.data();
    topology.numCorners = (int)cage.sharp_points.size();
    topology.cornerVertexIndices = cage.sharp_points.data();
    topology.cornerWeights = cage.sharp_point_sharpness.data();
    topology.numHoles = (int)cage.holes.size();
    topology.holeIndices = cage.holes.data();
    return topology;
}

} // namespace opensubdiv
} // namespace relievo
