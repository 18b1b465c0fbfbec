# Every kernel parses as strict OpenCL C 1.2 in every variant that the launchers ask for, without a warning:
# drivers differ in what they let pass. Run as: cmake -D CLANG=... -D ROOT=<cl folder> -P syntax_test.cmake
if(NOT CLANG)
  message("SKIPPED: strict OpenCL C 1.2 syntax of cl/kernels, clang is not installed")
  return()
endif()
file(GLOB_RECURSE kernels ${ROOT}/kernels/*.cl)
list(LENGTH kernels count)
if(count EQUAL 0)
  message(FATAL_ERROR "no kernels in ${ROOT}/kernels")
endif()

# Variants leave parameters unused on purpose. The builtin declarations come from the compiler's table:
# parsing the full header costs 0.4 s each time.
set(flags -fsyntax-only -x cl -cl-std=CL1.2 -Xclang -finclude-default-header -Xclang -fdeclare-opencl-builtins
    -Wall -Wextra -Wno-unused-parameter -Werror -I${ROOT})
# SENSOR MOVING ORIGINS SH_DEGREE MEDIAN | V NR LS | the double build or not
set(variants
    "-DSENSOR=0 -DMOVING=0 -DORIGINS=0 -DSH_DEGREE=3 -DMEDIAN=0 -DV=16 -DNR=16 -DLS=1"
    "-DSENSOR=0 -DMOVING=1 -DORIGINS=1 -DSH_DEGREE=0 -DMEDIAN=0 -DV=1 -DNR=4 -DLS=64"
    "-DSENSOR=1 -DMOVING=0 -DORIGINS=1 -DSH_DEGREE=1 -DMEDIAN=1 -DDROP=1 -DV=1 -DNR=4 -DLS=64 -DSIMULI_REAL_DOUBLE=1"
    "-DSENSOR=1 -DMOVING=1 -DORIGINS=1 -DSH_DEGREE=2 -DMEDIAN=1 -DDROP=1 -DV=16 -DNR=16 -DLS=1 -DSIMULI_REAL_DOUBLE=1"
    "-DSENSOR=0 -DMOVING=0 -DORIGINS=0 -DSH_DEGREE=2 -DMEDIAN=0 -DV=16 -DNR=16 -DLS=1 -DACTORS=1"
    "-DSENSOR=1 -DMOVING=1 -DORIGINS=1 -DSH_DEGREE=1 -DMEDIAN=1 -DV=1 -DNR=4 -DLS=64 -DACTORS=1 -DACTOR_MOTION=1")
# The projection alone: every lens, extent and projection, the sensor moving as that uses the most.
set(lane_shapes "-DV=16" "-DV=1" "-DV=8 -DSIMULI_REAL_DOUBLE=1")
set(project_variants
    "-DSENSOR=1 -DMOVING=1 -DSH_DEGREE=0 -DV=16 -DEXTENT=1 -DCULLING=1"
    "-DSENSOR=1 -DMOVING=1 -DSH_DEGREE=0 -DV=1 -DPROJECTION=1 -DSHUTTER_ITERATIONS=8"
    "-DSENSOR=1 -DMOVING=0 -DSH_DEGREE=0 -DV=16 -DPROJECTION=2")
# What pictures may ask for and trainings may not.
set(blend_variants
    "-DSENSOR=0 -DMOVING=0 -DORIGINS=0 -DSH_DEGREE=3 -DMEDIAN=0 -DV=16 -DNR=16 -DLS=1 -DRAY_SH=1"
    "-DSENSOR=1 -DMOVING=1 -DORIGINS=1 -DSH_DEGREE=1 -DMEDIAN=1 -DV=1 -DNR=4 -DLS=64 -DRAY_SH=1 -DACTORS=1 -DACTOR_MOTION=1 -DPER_RAY=1"
    "-DSENSOR=1 -DMOVING=1 -DORIGINS=1 -DSH_DEGREE=2 -DMEDIAN=1 -DV=8 -DNR=32 -DLS=1 -DRAY_SH=1 -DPER_RAY=1 -DSIMULI_REAL_DOUBLE=1"
    "-DSENSOR=0 -DMOVING=1 -DORIGINS=1 -DSH_DEGREE=3 -DMEDIAN=1 -DV=16 -DNR=16 -DLS=1 -DACTORS=1 -DACTOR_IDS=1 -DPER_RAY=1"
    "-DSENSOR=1 -DMOVING=1 -DORIGINS=1 -DSH_DEGREE=1 -DMEDIAN=1 -DDROP=1 -DV=1 -DNR=4 -DLS=64 -DRAY_SH=1 -DACTORS=1 -DACTOR_IDS=1")
# Back in rays' own orders.
set(replay_variants
    "-DSENSOR=0 -DMOVING=0 -DORIGINS=0 -DSH_DEGREE=3 -DMEDIAN=0 -DV=16 -DNR=16 -DLS=1"
    "-DSENSOR=1 -DMOVING=1 -DORIGINS=1 -DSH_DEGREE=1 -DMEDIAN=1 -DDROP=1 -DV=1 -DNR=4 -DLS=64 -DACTORS=1 -DACTOR_MOTION=1 -DPER_RAY=1"
    "-DSENSOR=1 -DMOVING=1 -DORIGINS=1 -DSH_DEGREE=2 -DMEDIAN=1 -DDROP=1 -DV=8 -DNR=32 -DLS=1 -DPER_RAY=1 -DSIMULI_REAL_DOUBLE=1")
list(TRANSFORM replay_variants APPEND " -DRAY_ORDER=1")
list(APPEND project_variants "-DSENSOR=1 -DMOVING=1 -DSH_DEGREE=0 -DV=16")
foreach(lens RANGE 8)  # SIM_LENS_.. of shared/layout.h
  math(EXPR shape "${lens} % 3")
  list(GET lane_shapes ${shape} lanes)
  foreach(option "EXTENT=1" "PROJECTION=0" "PROJECTION=1")
    list(APPEND project_variants "-DSENSOR=0 -DMOVING=1 -DSH_DEGREE=0 ${lanes} -DLENS=${lens} -D${option}")
  endforeach()
endforeach()
set(failed 0)
foreach(kernel IN LISTS kernels)
  set(all_variants "${variants}")
  if(kernel MATCHES "/project.cl$")
    list(APPEND all_variants ${project_variants})
  endif()
  if(kernel MATCHES "/render(_window|_per_ray)?.cl$")
    list(APPEND all_variants ${blend_variants})
  endif()
  if(kernel MATCHES "/(render_bwd_.*|replay_.*).cl$")
    list(APPEND all_variants ${replay_variants})
  endif()
  if(kernel MATCHES "_lanes.cl$")
    list(FILTER all_variants INCLUDE REGEX "LS=1( |$)")
  elseif(kernel MATCHES "_groups.cl$")
    list(FILTER all_variants EXCLUDE REGEX "LS=1( |$)")
  endif()
  foreach(variant IN LISTS all_variants)
    separate_arguments(defines UNIX_COMMAND "${variant} -DCLAMPED_CHANNELS=1 -DRADIX_BITS=4 -DNEIGHBOURS=50 -DGRID_X=16 -DGRID_Y=16 -DGRID_Z=8 -DCOMPENSATION=1 -DERRORS=1 -DWINDOW=16")
    execute_process(COMMAND ${CLANG} ${flags} ${defines} ${kernel} RESULT_VARIABLE code ERROR_VARIABLE log)
    if(NOT code EQUAL 0)
      message("${kernel} ${variant}:\n${log}")
      math(EXPR failed "${failed} + 1")
    endif()
  endforeach()
endforeach()
if(failed)
  message(FATAL_ERROR "${failed} of the variants of ${count} kernels are no strict OpenCL C 1.2")
endif()
message("${count} kernels parse in all variants")
