// Debian's OpenMesh, opened at run time on Linux.
#pragma once

#include "rust/cxx.h"

namespace relievo::openmesh {

// Opens the library of that file name, once for the process. Throws if it is not there or not the version that the headers
// are of, and if another OpenMesh and another operator new are both loaded for all names.
void open_library(rust::Str file);

} // namespace relievo::openmesh
