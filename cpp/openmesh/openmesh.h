// OpenMesh's headers, on Linux in a namespace of our own. Functions that are not inline are looked up in Debian's library by
// library.cpp: an OpenMesh that a host has loaded for all names cannot answer for it, and we answer for none of the host's.
// Elsewhere names belong to libraries, and OpenMesh is linked.
#pragma once

#ifdef __linux__
#define OpenMesh relievo_OpenMesh
#define omerr relievo_omerr
#define omlog relievo_omlog
#define omout relievo_omout
#endif
#include <OpenMesh/Core/Mesh/Status.hh>
#include <OpenMesh/Core/Utils/typename.hh>

#ifdef __linux__
namespace OpenMesh {

// Debian's library has assertions on, and compares the names of types that properties hold with its own.
template <>
inline std::string get_type_name<Attributes::StatusInfo>() {
    return "N8OpenMesh10Attributes10StatusInfoE";
}

} // namespace OpenMesh
#endif

#include <OpenMesh/Core/Mesh/TriMesh_ArrayKernelT.hh>
