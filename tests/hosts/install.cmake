# Installs the shared and the static library of LIBRARY_DIR with the package files of SOURCE to PREFIX.
file(REMOVE_RECURSE ${PREFIX})
execute_process(COMMAND ${CMAKE_COMMAND} -S ${SOURCE} -B ${BUILD} -G ${GENERATOR} -DRELIEVO_OPENVDB=OFF -DRELIEVO_STATIC=ON
  -DRELIEVO_LIBRARY_DIR=${LIBRARY_DIR}
  -DCMAKE_INSTALL_LIBDIR=lib -DCMAKE_INSTALL_PREFIX=${PREFIX} COMMAND_ERROR_IS_FATAL ANY)
execute_process(COMMAND ${CMAKE_COMMAND} --build ${BUILD} COMMAND_ERROR_IS_FATAL ANY)
execute_process(COMMAND ${CMAKE_COMMAND} --install ${BUILD} --prefix ${PREFIX} COMMAND_ERROR_IS_FATAL ANY)
# Stripped, the library has the symbols that programs link and no others.
file(REMOVE_RECURSE ${PREFIX}-stripped)
execute_process(COMMAND ${CMAKE_COMMAND} --install ${BUILD} --strip --prefix ${PREFIX}-stripped COMMAND_ERROR_IS_FATAL ANY)
foreach(prefix ${PREFIX} ${PREFIX}-stripped)
  execute_process(COMMAND readelf --wide --section-headers ${prefix}/lib/librelievo.so OUTPUT_VARIABLE sections
    COMMAND_ERROR_IS_FATAL ANY)
  string(FIND "${sections}" " .symtab " symtab)
  string(FIND "${sections}" " .dynsym " dynsym)
  list(APPEND has_symbols ${symtab})
  if(dynsym EQUAL -1)
    message(FATAL_ERROR "the library in ${prefix} has no dynamic symbols")
  endif()
endforeach()
list(GET has_symbols 0 whole)
list(GET has_symbols 1 stripped)
if(whole EQUAL -1 OR NOT stripped EQUAL -1)
  message(FATAL_ERROR "--strip leaves the library as it is, or it is stripped without")
endif()
file(REMOVE_RECURSE ${PREFIX}-stripped)
