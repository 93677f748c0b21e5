// The host's scene file: for every object its name, its place, its cage as PLY, and its document.
#pragma once

#include "object.hpp"

namespace studio {

/// Writes a scene; the file is there as a whole or, after a failure, as it was.
void save_scene(const std::string &path, const std::vector<Object> &objects);

/// Reads a scene, which may come from anybody: sizes are checked against what the file has.
std::vector<Object> open_scene(const relievo::Context &context, const std::string &path);

} // namespace studio
