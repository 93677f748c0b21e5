# Compares the binary interface that the headers declare (functions, structs, values) with the one that was agreed on,
# BASELINE, by libabigail. That the library has it is what symbols.cmake and rust/capi/tests/header say. After a change
# that is meant: cmake -DRENEW=ON -DHEADERS=include -DBASELINE=tests/c/abi.xml.gz -DWORK=target/abi -P tests/c/abi.cmake
if(NOT COMPILER)
  set(COMPILER cc)
endif()
get_filename_component(HEADERS ${HEADERS} ABSOLUTE)
get_filename_component(BASELINE ${BASELINE} ABSOLUTE)
get_filename_component(WORK ${WORK} ABSOLUTE)
file(MAKE_DIRECTORY ${WORK})

# Every declared function with a body, so that there is debug information about all of them.
set(source "#include <relievo/relievo.h>\n")
file(GLOB headers ${HEADERS}/relievo/*.h)
list(SORT headers)
foreach(header IN LISTS headers)
  file(READ ${header} text)
  # Lists of CMake end at brackets and semicolons.
  string(REPLACE "[" "<" text "${text}")
  string(REPLACE "]" ">" text "${text}")
  string(REPLACE ";" "@" text "${text}")
  string(REGEX MATCHALL "\nRLV_API [^@]*@" declarations "${text}")
  foreach(declaration IN LISTS declarations)
    string(REGEX REPLACE "\nRLV_API ([^@]*)@" "\\1 { return 0@ }\n" body "${declaration}")
    string(REPLACE "@" "\;" body "${body}")
    string(REPLACE "<" "[" body "${body}")
    string(REPLACE ">" "]" body "${body}")
    string(APPEND source "${body}")
  endforeach()
endforeach()
string(REPLACE "\\;" ";" source "${source}")
file(WRITE ${WORK}/abi.c "${source}")
execute_process(COMMAND ${COMPILER} -std=c99 -g -O0 -fPIC -shared -Wl,-soname,librelievo.so -I${HEADERS} ${WORK}/abi.c
  -o ${WORK}/abi.so COMMAND_ERROR_IS_FATAL ANY)

set(abidw abidw --no-corpus-path --no-comp-dir-path --no-show-locs --no-parameter-names)
if(RENEW)
  execute_process(COMMAND ${abidw} ${WORK}/abi.so COMMAND gzip -9 -n OUTPUT_FILE ${BASELINE} COMMAND_ERROR_IS_FATAL ANY)
  return()
endif()
execute_process(COMMAND gzip -dc ${BASELINE} OUTPUT_FILE ${WORK}/agreed.xml COMMAND_ERROR_IS_FATAL ANY)
execute_process(COMMAND abidiff --no-show-locs ${WORK}/agreed.xml ${WORK}/abi.so OUTPUT_VARIABLE changes
  ERROR_VARIABLE errors RESULT_VARIABLE result)
if(NOT result EQUAL 0)
  message(FATAL_ERROR "the binary interface is not what was agreed on (${result}):\n${changes}${errors}\n"
    "Within the versions of one SONAME functions may be added and descriptors may grow; if that is so, or the minor "
    "version is a new one, renew tests/c/abi.xml.gz as tests/c/abi.cmake says.")
endif()
