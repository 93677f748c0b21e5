// OpenMesh on systems where it is linked: there is nothing to open.
#include "library.h"

namespace relievo::openmesh {

void open_library(rust::Str) {}

} // namespace relievo::openmesh
