# A small street, then python_test.py on it.
cmake_minimum_required(VERSION 3.23)
file(REMOVE_RECURSE ${WORK})
file(MAKE_DIRECTORY ${WORK})
execute_process(COMMAND ${PROGRAM} synth street -o ${WORK}/street.log --frames 6 --image-width 64 --image-height 36
  --lidar-columns 90 COMMAND_ERROR_IS_FATAL ANY OUTPUT_QUIET)
execute_process(COMMAND ${PYTHON} -c "import numpy" RESULT_VARIABLE no_numpy ERROR_QUIET)
if(no_numpy)
  message("SKIPPED: import simuli, ${PYTHON} has no NumPy")
  return()
endif()
set(ENV{PYTHONPATH} ${MODULE})
execute_process(COMMAND ${PYTHON} ${SOURCE}/python_test.py ${WORK}/street.log ${WORK} COMMAND_ERROR_IS_FATAL ANY)
