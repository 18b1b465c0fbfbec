# A small street's scene against bench/tensor_reference.py, and gradients against its autograd.
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
execute_process(COMMAND ${PROGRAM} train ${WORK}/street.log -o ${WORK}/street.scene --iterations 5 --set init.environment_width=0
  COMMAND_ERROR_IS_FATAL ANY OUTPUT_QUIET ERROR_QUIET)
execute_process(COMMAND ${DUMP} ${WORK}/gradients.json COMMAND_ERROR_IS_FATAL ANY)
execute_process(COMMAND ${PYTHON} ${SOURCE}/tensor_gradients.py ${BENCH} ${WORK}/gradients.json COMMAND_ERROR_IS_FATAL ANY)
execute_process(COMMAND ${PYTHON} ${BENCH}/tensor_reference.py ${PROGRAM} ${WORK}/street.scene 0.1 COMMAND_ERROR_IS_FATAL ANY)
