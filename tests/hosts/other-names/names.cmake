# Writes OUTPUT, a C file whose functions have the names that LIBRARIES export, but for those of the C++ library. Whoever calls
# one of them ends the program with a message.
set(text "#include <unistd.h>
void other_function(void);
void other_function(void) {
    static const char text[] = \"a function of the host was called\\n\";
    _exit(write(2, text, sizeof(text) - 1) > 0 ? 1 : 2);
}
")
foreach(library ${LIBRARIES})
  execute_process(COMMAND ${NM} -D --defined-only ${library} OUTPUT_VARIABLE lines COMMAND_ERROR_IS_FATAL ANY)
  string(REGEX MATCHALL "[^ \n@]*(OpenSubdiv|3tbb6detail|GOMP_|omp_)[^ \n@]*" names "${lines}")
  list(APPEND all ${names})
endforeach()
list(REMOVE_DUPLICATES all)
list(LENGTH all count)
if(count LESS 1000)
  message(FATAL_ERROR "${LIBRARIES} export ${count} names alone")
endif()
foreach(name ${all})
  string(APPEND text "__asm__(\".globl ${name}\\n.set ${name}, other_function\");\n")
endforeach()
file(WRITE ${OUTPUT} "${text}")
