# Runs PROGRAM, which writes OUT, and CHECK, which looks at it.
execute_process(COMMAND ${PROGRAM} ${OUT} COMMAND_ERROR_IS_FATAL ANY)
execute_process(COMMAND ${CHECK} ${OUT} COMMAND_ERROR_IS_FATAL ANY)
