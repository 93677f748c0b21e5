# Runs the example PROGRAM with LIBRARY; its picture OUT has light and shadow in it.
execute_process(COMMAND ${PROGRAM} ${OUT} ${LIBRARY} 160 4 RESULT_VARIABLE result OUTPUT_VARIABLE printed
  ERROR_VARIABLE errors)
if(NOT result EQUAL 0 OR NOT printed MATCHES "[0-9]+ primitives")
  message(FATAL_ERROR "the example ended with ${result}: ${printed}${errors}")
endif()
file(READ ${OUT} pixels OFFSET 14 HEX)
string(LENGTH "${pixels}" length)
if(NOT length EQUAL 86400) # 160 x 90 pixels of three bytes
  message(FATAL_ERROR "the picture has ${length} digits")
endif()
string(REGEX MATCHALL "[0-9a-f][0-9a-f]" bytes "${pixels}")
list(REMOVE_DUPLICATES bytes)
list(LENGTH bytes values)
if(values LESS 100)
  message(FATAL_ERROR "the picture has ${values} values")
endif()
