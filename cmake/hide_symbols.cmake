# Makes OUTPUT, a static library with one object, of ARCHIVE: what the functions listed in SYMBOLS need is linked together,
# those functions become hidden, and all other symbols become local. A host may then have its own zstd, cxx or Rust
# library, and a module with the library inside exports none of it.
# The tools are COMPILER (a C compiler), LINKER, OBJCOPY and AR; intermediate files go to WORK.
file(MAKE_DIRECTORY ${WORK})
file(STRINGS ${SYMBOLS} names)
list(JOIN names "[];\nextern char " declared)
list(JOIN names ",\n    " listed)
# The linker gives a symbol the strictest visibility of all objects that mention it.
file(WRITE ${WORK}/hidden.c "#pragma GCC visibility push(hidden)
extern char ${declared}[];
const void *const relievo_hidden[] = {
    ${listed}};
")
list(TRANSFORM names PREPEND "-u " OUTPUT_VARIABLE roots)
list(JOIN roots "\n" roots)
file(WRITE ${WORK}/roots "${roots}\n")
execute_process(COMMAND ${COMPILER} -c ${WORK}/hidden.c -o ${WORK}/hidden.o COMMAND_ERROR_IS_FATAL ANY)
# A host's copy of a C++ template would replace ours if it stayed in a group, and then refer to symbols that are local.
execute_process(COMMAND ${LINKER} -r --strip-debug --gc-sections --force-group-allocation @${WORK}/roots
  -o ${WORK}/linked.o ${WORK}/hidden.o ${ARCHIVE} COMMAND_ERROR_IS_FATAL ANY)
# Rust's own libraries carry LLVM bitcode, which only makes the file larger.
execute_process(COMMAND ${OBJCOPY} -R .llvmbc -R .llvmcmd --keep-global-symbols=${SYMBOLS} ${WORK}/linked.o ${WORK}/relievo.o
  COMMAND_ERROR_IS_FATAL ANY)
file(REMOVE ${OUTPUT})
execute_process(COMMAND ${AR} rcs ${OUTPUT} ${WORK}/relievo.o COMMAND_ERROR_IS_FATAL ANY)
file(REMOVE ${WORK}/linked.o ${WORK}/relievo.o)
