# Makes viewport_shader.hpp of viewport.wgsl by naga (`cargo install naga-cli`):
#   cmake -P examples/host/viewport_shader.cmake
# With -DCHECK=ON it makes nothing, and fails if the header is of other text than viewport.wgsl has.
set(folder ${CMAKE_CURRENT_LIST_DIR})
file(SHA256 ${folder}/viewport.wgsl digest)
if(CHECK)
  file(STRINGS ${folder}/viewport_shader.hpp made REGEX "^// SHA-256 of viewport.wgsl: ${digest}$")
  if(NOT made)
    message(FATAL_ERROR "viewport.wgsl has changed: run cmake -P examples/host/viewport_shader.cmake")
  endif()
  return()
endif()
find_program(NAGA naga REQUIRED)
set(binary ${folder}/viewport_shader.spv)
execute_process(COMMAND ${NAGA} --keep-coordinate-space ${folder}/viewport.wgsl ${binary} COMMAND_ERROR_IS_FATAL ANY)
file(READ ${binary} bytes HEX)
file(REMOVE ${binary})
# Words are little-endian in the file.
string(REGEX REPLACE "(..)(..)(..)(..)" "0x\\4\\3\\2\\1," words "${bytes}")
string(REPEAT "0x........," 10 line)
string(REGEX REPLACE "(${line})" "\\1\n    " words "${words}")
string(REPLACE ",0x" ", 0x" words "${words}")
string(STRIP "${words}" words)
file(WRITE ${folder}/viewport_shader.hpp "// Made by viewport_shader.cmake of viewport.wgsl: not to be edited.
// SHA-256 of viewport.wgsl: ${digest}
#pragma once

#include <cstdint>

namespace studio {

/// SPIR-V with the entry points `point` and `light`.
const std::uint32_t VIEWPORT_SHADER[] = {
    ${words}
};

} // namespace studio
")
