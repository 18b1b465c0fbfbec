# A small street's scene against bench/tensor_reference.py.
#   cmake -D PROGRAM=simuli -D PYTHON=python3 -D SCRIPT=tensor_reference.py -D WORK=<scratch folder> -P tensor_test.cmake
cmake_minimum_required(VERSION 3.23)
execute_process(COMMAND ${PYTHON} -c "import numpy, torch" RESULT_VARIABLE absent ERROR_QUIET)
if(absent)
  message("SKIPPED: pictures against tensors, ${PYTHON} has no NumPy or no PyTorch (python3-torch)")
  return()
endif()
file(REMOVE_RECURSE ${WORK})
file(MAKE_DIRECTORY ${WORK})
execute_process(COMMAND ${PROGRAM} synth street -o ${WORK}/street.log --frames 6 --image-width 64 --image-height 36
  --lidar-columns 90 COMMAND_ERROR_IS_FATAL ANY OUTPUT_QUIET)
execute_process(COMMAND ${PROGRAM} train ${WORK}/street.log -o ${WORK}/street.scene --iterations 5
  COMMAND_ERROR_IS_FATAL ANY OUTPUT_QUIET ERROR_QUIET)
execute_process(COMMAND ${PYTHON} ${SCRIPT} ${PROGRAM} ${WORK}/street.scene 0.1 COMMAND_ERROR_IS_FATAL ANY)
