#include "library.h"

#include <cstddef>
#include <mutex>
#include <stdexcept>
#include <string>

#include <dlfcn.h>

#include "openmesh.h"

// Number, name in our namespace, and name in the library of every function that patch.cpp reaches and that is not inline.
#define RELIEVO_OPENMESH_FUNCTIONS(ENTRY)                                                                              \
    ENTRY(0, "_ZN16relievo_OpenMesh11ArrayKernelC2Ev", "_ZN8OpenMesh11ArrayKernelC2Ev")                                \
    ENTRY(1, "_ZN16relievo_OpenMesh11ArrayKernel5clearEv", "_ZN8OpenMesh11ArrayKernel5clearEv")                        \
    ENTRY(2, "_ZN16relievo_OpenMesh11ArrayKernel7reserveEmmm", "_ZN8OpenMesh11ArrayKernel7reserveEmmm")                \
    ENTRY(3, "_ZNK16relievo_OpenMesh11ArrayKernel6handleERKNS_10ArrayItems6VertexE",                                   \
          "_ZNK8OpenMesh11ArrayKernel6handleERKNS_10ArrayItems6VertexE")                                               \
    ENTRY(4, "_ZN16relievo_OpenMesh15TriConnectivity14is_collapse_okENS_14HalfedgeHandleE",                            \
          "_ZN8OpenMesh15TriConnectivity14is_collapse_okENS_14HalfedgeHandleE")                                        \
    ENTRY(5, "_ZN16relievo_OpenMesh15TriConnectivity4flipENS_10EdgeHandleE",                                           \
          "_ZN8OpenMesh15TriConnectivity4flipENS_10EdgeHandleE")                                                       \
    ENTRY(6, "_ZN16relievo_OpenMesh15TriConnectivity5splitENS_10EdgeHandleENS_12VertexHandleE",                        \
          "_ZN8OpenMesh15TriConnectivity5splitENS_10EdgeHandleENS_12VertexHandleE")                                    \
    ENTRY(7, "_ZN16relievo_OpenMesh15TriConnectivity8add_faceEPKNS_12VertexHandleEm",                                  \
          "_ZN8OpenMesh15TriConnectivity8add_faceEPKNS_12VertexHandleEm")                                              \
    ENTRY(8, "_ZNK16relievo_OpenMesh15TriConnectivity10is_flip_okENS_10EdgeHandleE",                                   \
          "_ZNK8OpenMesh15TriConnectivity10is_flip_okENS_10EdgeHandleE")                                               \
    ENTRY(9, "_ZN16relievo_OpenMesh16PolyConnectivity11delete_faceENS_10FaceHandleEb",                                 \
          "_ZN8OpenMesh16PolyConnectivity11delete_faceENS_10FaceHandleEb")                                             \
    ENTRY(10, "_ZN16relievo_OpenMesh16PolyConnectivity5splitENS_10FaceHandleENS_12VertexHandleE",                      \
          "_ZN8OpenMesh16PolyConnectivity5splitENS_10FaceHandleENS_12VertexHandleE")                                   \
    ENTRY(11, "_ZN16relievo_OpenMesh16PolyConnectivity8collapseENS_14HalfedgeHandleE",                                 \
          "_ZN8OpenMesh16PolyConnectivity8collapseENS_14HalfedgeHandleE")                                              \
    ENTRY(12, "_ZNK16relievo_OpenMesh16PolyConnectivity13find_halfedgeENS_12VertexHandleES1_",                         \
          "_ZNK8OpenMesh16PolyConnectivity13find_halfedgeENS_12VertexHandleES1_")                                      \
    ENTRY(13, "_Z13relievo_omerrv", "_Z5omerrv")

// Every name in our namespace is a jump through the table. The library's own calls among its functions are bound when it is
// opened, see below.
extern "C" __attribute__((visibility("hidden"))) void *relievo_openmesh_functions[14];
void *relievo_openmesh_functions[14];

#if defined(__x86_64__)
#define RELIEVO_JUMP(number) "endbr64\njmpq *relievo_openmesh_functions+8*" #number "(%rip)\n"
#elif defined(__aarch64__)
#define RELIEVO_JUMP(number)                                                                                           \
    "hint #34\nadrp x16, relievo_openmesh_functions+8*" #number                                                        \
    "\nldr x16, [x16, :lo12:relievo_openmesh_functions+8*" #number "]\nbr x16\n"
#else
#error "the jumps to OpenMesh are written for x86-64 and AArch64"
#endif
#define RELIEVO_DEFINE(number, ours, theirs)                                                                           \
    __asm__(".pushsection .text\n.globl " ours "\n.hidden " ours "\n.type " ours ", %function\n" ours                   \
            ":\n" RELIEVO_JUMP(number) ".popsection\n");
RELIEVO_OPENMESH_FUNCTIONS(RELIEVO_DEFINE)

namespace OpenMesh {

// The first virtual functions that are not inline, without which the compiler makes no tables of virtual functions.
ArrayKernel::~ArrayKernel() { clear(); }
void BaseProperty::stats(std::ostream &out) const { out << name(); }

} // namespace OpenMesh

namespace relievo::openmesh {

namespace {

constexpr const char *names[] = {
#define RELIEVO_NAME(number, ours, theirs) theirs,
    RELIEVO_OPENMESH_FUNCTIONS(RELIEVO_NAME)
#undef RELIEVO_NAME
};

[[noreturn]] void refuse(const std::string &what) { throw std::runtime_error(what); }

void open_once(const std::string &file) {
    // Where a host has an OpenMesh for all names, the library's calls among its functions would reach that one.
    bool is_crowded = false;
    for (const char *name : names) {
        is_crowded = is_crowded || dlsym(RTLD_DEFAULT, name) != nullptr;
    }
    int flags = RTLD_NOW | RTLD_LOCAL;
#ifdef RTLD_DEEPBIND
    flags |= is_crowded ? RTLD_DEEPBIND : 0;
#endif
    void *library = dlopen(file.c_str(), flags);
    if (library == nullptr) {
        const char *reason = dlerror();
        refuse(reason != nullptr ? reason : file + " cannot be opened");
    }
    // Bound to itself first, the library takes memory from the C++ library; we give it back by what the host has.
    constexpr const char *allocate = "_Znwm";
    if (is_crowded && dlsym(RTLD_DEFAULT, allocate) != dlsym(library, allocate)) {
        refuse("the host has loaded another OpenMesh and replaces operator new");
    }
    std::size_t number = 0;
    for (const char *name : names) {
        relievo_openmesh_functions[number] = dlsym(library, name);
        if (relievo_openmesh_functions[number++] == nullptr) {
            refuse(file + " is no OpenMesh 9: it lacks " + name);
        }
    }
}

} // namespace

void open_library(rust::Str file) {
    static std::mutex lock;
    static bool is_open = false;
    const std::lock_guard<std::mutex> guard(lock);
    if (!is_open) {
        open_once(std::string(file));
        is_open = true;
    }
}

} // namespace relievo::openmesh
