# Checks that MODULE exports FUNCTION and nothing else.
cmake_policy(VERSION 3.25)
execute_process(COMMAND ${NM} -D --defined-only --format=just-symbols ${MODULE}
  OUTPUT_VARIABLE exported COMMAND_ERROR_IS_FATAL ANY)
string(REGEX REPLACE "\n" ";" exported "${exported}")
# The tables of digits in the headers of GCC's C++ library, of which a process has one copy.
list(FILTER exported EXCLUDE REGEX "^_ZZNSt8__detail18__to_chars_10_impl")
list(REMOVE_ITEM exported "")
list(LENGTH exported count)
if(NOT exported STREQUAL FUNCTION)
  list(SUBLIST exported 0 20 exported)
  message(FATAL_ERROR "${count} symbols are exported, not ${FUNCTION} alone: ${exported}")
endif()
