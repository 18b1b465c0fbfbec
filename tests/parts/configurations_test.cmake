# Configures the project as its options allow, and looks at the commands of the build that follows: what is left out
# is neither compiled, nor is its package looked at.
cmake_minimum_required(VERSION 3.23)
file(REMOVE_RECURSE ${WORK})

# configure(NAME TARGET ARGUMENTS...): `commands` are those that build the target.
function(configure name target)
  execute_process(
    COMMAND ${CMAKE_COMMAND} -G Ninja -S ${SOURCE} -B ${WORK}/${name} -DCMAKE_CXX_COMPILER=${CXX} ${ARGN}
    RESULT_VARIABLE result OUTPUT_VARIABLE out ERROR_VARIABLE out)
  if(NOT result EQUAL 0)
    message(FATAL_ERROR "${name}: ${ARGN}: does not configure: ${out}")
  endif()
  execute_process(COMMAND ${NINJA} -C ${WORK}/${name} -t commands ${target}
                  OUTPUT_VARIABLE commands ERROR_VARIABLE commands COMMAND_ERROR_IS_FATAL ANY)
  set(commands "${commands}" PARENT_SCOPE)
endfunction()

function(need part)
  string(FIND "${commands}" "${part}" at)
  if(at EQUAL -1)
    message(FATAL_ERROR "the build of ${ARGN} has no ${part}")
  endif()
endfunction()

# forbid(NAME PARTS...): none of them is in the commands.
function(forbid name)
  foreach(part IN LISTS ARGN)
    string(FIND "${commands}" "${part}" at)
    if(NOT at EQUAL -1)
      string(SUBSTRING "${commands}" ${at} 120 some)
      message(FATAL_ERROR "${name}: found ${some} in what is built, allowed no ${part}")
    endif()
  endforeach()
endfunction()

# Each source by itself, so that its name stands in the command.
set(least -DSIMULI_UNITY=OFF -DBUILD_TESTING=OFF -DSIMULI_BENCH=OFF -DSIMULI_PYTHON=OFF)
configure(default all ${least})
need(view_server.cpp default)
need(libceres default)
need(camera_pose.cpp default)
forbid(default gtest benchmark pybind11 ${SOURCE}/tests/ ${SOURCE}/bench/)

configure(no_viewer all ${least} -DSIMULI_VIEWER=OFF)
need(view/absent.cpp no_viewer)
forbid(no_viewer httplib view_server view_session)

configure(no_serve all ${least} -DSIMULI_SERVE=OFF)
need(serve/absent.cpp no_serve)
forbid(no_serve grpc protoc render_session cli/serve/serve.cpp)

configure(no_mpi all ${least} -DSIMULI_MPI=OFF)
forbid(no_mpi openmpi mpi_module SIMULI_MPI_MODULE)

configure(no_calibration all ${least} -DSIMULI_CALIBRATION=OFF)
need(calibration/absent.cpp no_calibration)
forbid(no_calibration ceres glog ${SOURCE}/optim/calibration calibration/fit.cpp)

configure(core all ${least} -DSIMULI_CORE_ONLY=ON)
need(bin/simuli_bench core)
forbid(core grpc protoc ceres httplib nlohmann OpenImageIO nanoflann CLI11 ${SOURCE}/host/apps/cli ${SOURCE}/optim/ libz.)
