# oiiotool and iinfo, which know nothing of Relievo, read what textures.cpp wrote to FOLDER, with the plugin in PLUGINS.
set(ENV{OIIO_LIBRARY_PATH} ${PLUGINS})

# Runs a command that must succeed and print what every pattern matches.
function(prints)
  cmake_parse_arguments(PARSE_ARGV 0 it "" "" "COMMAND;PATTERNS")
  execute_process(COMMAND ${it_COMMAND} OUTPUT_VARIABLE text ERROR_VARIABLE errors RESULT_VARIABLE result)
  if(NOT result EQUAL 0)
    message(FATAL_ERROR "${it_COMMAND} ended with ${result}:\n${text}${errors}")
  endif()
  foreach(pattern IN LISTS it_PATTERNS)
    if(NOT text MATCHES "${pattern}")
      message(FATAL_ERROR "${it_COMMAND} does not print ${pattern}:\n${text}${errors}")
    endif()
  endforeach()
endfunction()

# Runs a command that must fail with a message, and not by a signal.
function(refuses pattern)
  execute_process(COMMAND ${ARGN} OUTPUT_VARIABLE text ERROR_VARIABLE errors RESULT_VARIABLE result)
  if(NOT result MATCHES "^[0-9]+$" OR result EQUAL 0 OR NOT "${text}${errors}" MATCHES "${pattern}")
    message(FATAL_ERROR "${ARGN} ended with ${result} and not with ${pattern}:\n${text}${errors}")
  endif()
endfunction()

prints(COMMAND ${OIIOTOOL} --info -v -a ${FOLDER}/painted.relievo PATTERNS
  "120 x  120, 4 channel, half relievo" "120 x  120, 1 channel, float relievo" "MIP-map levels: 120x120 60x60 30x30"
  "channel list: displacement" "relievo:faces: 9" "relievo:side: 32" "relievo:gutter: 4" "relievo:kind: \"color\""
  "relievo:opacity: 1" "oiio:ColorSpace: \"Linear\"")
prints(COMMAND ${IINFO} ${FOLDER}/painted.relievo PATTERNS "2 subimages" "120 x  120")
prints(COMMAND ${OIIOTOOL} --info -v -a ${FOLDER}/triangles.relievo PATTERNS
  "200 x  160, 4 channel, half relievo" "200 x  160, 1 channel, float relievo" "MIP-map levels: 200x160 100x80 50x40"
  "relievo:surface: \"triangles\"" "relievo:faces: 18" "relievo:side: 32" "relievo:gutter: 4")
prints(COMMAND ${IINFO} ${FOLDER}/painted.ptx PATTERNS "9 subimages" "32 x   32, 4 channel, uint8 relievo")
# A copy in another format has the same numbers.
prints(COMMAND ${OIIOTOOL} ${FOLDER}/painted.relievo --subimage 1 -d float -o ${FOLDER}/copy.tif)
prints(COMMAND ${OIIOTOOL} ${FOLDER}/painted.relievo --subimage 1 ${FOLDER}/copy.tif --fail 0 --warn 0 --diff PATTERNS "PASS")
prints(COMMAND ${OIIOTOOL} ${FOLDER}/painted.relievo --colorconvert linear sRGB -o ${FOLDER}/copy.png)
refuses("damaged.relievo" ${OIIOTOOL} --info ${FOLDER}/damaged.relievo)
refuses("damaged.relievo" ${IINFO} ${FOLDER}/damaged.relievo)
