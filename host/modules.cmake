# A module is a folder of sources with one target and one include directory of its own: a file can include
# only headers of the modules that its target links, so the compiler and the linker enforce the dependencies.
# The include directory (build/modules/TARGET) contains only a link to the folder; includes are written from the
# project's root ("io/log/log.hpp").

# Headers that nearly every file reads (the standard library, Eigen, fmt), parsed once.
option(SIMULI_PCH "Precompile the headers that nearly all sources share" ON)
set(SIMULI_PCH_HEADERS
  <algorithm> <array> <atomic> <chrono> <cmath> <cstdint> <cstring> <filesystem> <fstream> <functional>
  <iostream> <limits> <map> <memory> <mutex> <numeric> <optional> <random> <set> <span> <sstream> <string>
  <string_view> <thread> <tuple> <unordered_map> <utility> <variant> <vector>
  <Eigen/Core> <Eigen/Geometry> <fmt/format.h> <fmt/ranges.h>)

# Unity builds parse shared headers and instantiate shared templates once for several sources of a module.
option(SIMULI_UNITY "Compile the sources of a module together" ON)
function(simuli_unity target)
  if(SIMULI_UNITY)
    set_target_properties(${target} PROPERTIES UNITY_BUILD ON UNITY_BUILD_BATCH_SIZE 8)
    # In unity builds g++ treats included sources as headers.
    target_compile_options(${target} PRIVATE $<$<CXX_COMPILER_ID:GNU>:-Wno-subobject-linkage>)
  endif()
endfunction()

# simuli_includes(TARGET FOLDER...): makes the target's include directory, with a link to each folder.
function(simuli_includes target)
  set(place ${PROJECT_BINARY_DIR}/modules/${target})
  foreach(folder IN LISTS ARGN)
    cmake_path(GET folder PARENT_PATH parent)
    file(MAKE_DIRECTORY ${place}/${parent})
    file(CREATE_LINK ${PROJECT_SOURCE_DIR}/${folder} ${place}/${folder} SYMBOLIC)
  endforeach()
  get_target_property(type ${target} TYPE)
  if(type STREQUAL "INTERFACE_LIBRARY")
    target_include_directories(${target} INTERFACE ${place})
  else()
    target_include_directories(${target} PUBLIC $<BUILD_INTERFACE:${place}>)
  endif()
endfunction()

# simuli_module(FOLDER [OUTSIDE] [SUBFOLDERS folder...] [WITHOUT file...] [SOURCES file...] [MODULES folder...] [LIBS target...]):
# defines the static library simuli_FOLDER (slashes as underscores) from all *.cpp of FOLDER and of its SUBFOLDERS,
# except WITHOUT, plus generated SOURCES. MODULES and LIBS are linked. Modules are parts of libsimuli, unless OUTSIDE.
function(simuli_module folder)
  cmake_parse_arguments(ARG "OUTSIDE" "" "SUBFOLDERS;WITHOUT;SOURCES;MODULES;LIBS" ${ARGN})
  string(REPLACE "/" "_" target "simuli_${folder}")
  set(root ${PROJECT_SOURCE_DIR}/${folder})
  set(patterns ${root}/*.cpp)
  foreach(subfolder IN LISTS ARG_SUBFOLDERS)
    list(APPEND patterns ${root}/${subfolder}/*.cpp)
  endforeach()
  file(GLOB sources CONFIGURE_DEPENDS ${patterns})
  list(TRANSFORM ARG_WITHOUT PREPEND ${root}/)
  if(ARG_WITHOUT)
    list(REMOVE_ITEM sources ${ARG_WITHOUT})
  endif()
  add_library(${target} STATIC ${sources} ${ARG_SOURCES})
  simuli_includes(${target} ${folder})
  list(TRANSFORM ARG_MODULES REPLACE "/" "_")
  list(TRANSFORM ARG_MODULES PREPEND simuli_)
  target_link_libraries(${target} PUBLIC simuli_flags ${ARG_MODULES} PRIVATE ${ARG_LIBS})
  if(SIMULI_PCH)
    if(TARGET simuli_pch)
      target_precompile_headers(${target} REUSE_FROM simuli_pch)
    endif()
  endif()
  simuli_unity(${target})
  if(NOT ARG_OUTSIDE)
    set_property(GLOBAL APPEND PROPERTY SIMULI_LIBRARY_MODULES ${target})
  endif()
endfunction()
