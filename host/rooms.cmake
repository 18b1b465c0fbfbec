# A room is a folder of sources with one target and one include directory of its own: a file can include
# headers of the rooms that its target links and of no other, so that who may know whom is held by compiler
# and linker. The include directory (build/rooms/TARGET) holds nothing but a link to the folder, so that
# includes are spelt from the project's root ("io/log/log.hpp").

# Headers that nearly every file reads (the standard library, Eigen, fmt), parsed once.
option(SIMULI_PCH "Precompile the headers that nearly all sources share" ON)
set(SIMULI_PCH_HEADERS
  <algorithm> <array> <atomic> <chrono> <cmath> <cstdint> <cstring> <filesystem> <fstream> <functional>
  <iostream> <limits> <map> <memory> <mutex> <numeric> <optional> <random> <set> <span> <sstream> <string>
  <string_view> <thread> <tuple> <unordered_map> <utility> <variant> <vector>
  <Eigen/Core> <Eigen/Geometry> <fmt/format.h> <fmt/ranges.h>)

# Sources of a room compiled several at a time: what they share is parsed and instantiated once.
option(SIMULI_UNITY "Compile the sources of a room together" ON)
function(simuli_unity target)
  if(SIMULI_UNITY)
    set_target_properties(${target} PROPERTIES UNITY_BUILD ON UNITY_BUILD_BATCH_SIZE 8)
    # g++ takes sources that are included for headers.
    target_compile_options(${target} PRIVATE $<$<CXX_COMPILER_ID:GNU>:-Wno-subobject-linkage>)
  endif()
endfunction()

# simuli_includes(TARGET FOLDER...): makes the target's include directory, with a link to each folder.
function(simuli_includes target)
  set(place ${PROJECT_BINARY_DIR}/rooms/${target})
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

# simuli_room(FOLDER [OUTSIDE] [ALSO FOLDER...] SOURCES file... [ROOMS folder...] [LIBS target...]):
# the static library simuli_FOLDER (slashes as underscores) of the folder where this stands. ROOMS and LIBS
# are what it links; ALSO names folders that belong to it. Rooms are parts of libsimuli, unless OUTSIDE.
function(simuli_room folder)
  cmake_parse_arguments(ARG "OUTSIDE" "" "ALSO;SOURCES;ROOMS;LIBS" ${ARGN})
  string(REPLACE "/" "_" target "simuli_${folder}")
  list(TRANSFORM ARG_SOURCES PREPEND ${PROJECT_SOURCE_DIR}/${folder}/ REGEX "^[^/$]")
  add_library(${target} STATIC ${ARG_SOURCES})
  simuli_includes(${target} ${folder} ${ARG_ALSO})
  list(TRANSFORM ARG_ROOMS REPLACE "/" "_")
  list(TRANSFORM ARG_ROOMS PREPEND simuli_)
  target_link_libraries(${target} PUBLIC simuli_flags ${ARG_ROOMS} PRIVATE ${ARG_LIBS})
  if(SIMULI_PCH)
    if(TARGET simuli_pch)
      target_precompile_headers(${target} REUSE_FROM simuli_pch)
    endif()
  endif()
  simuli_unity(${target})
  if(NOT ARG_OUTSIDE)
    set_property(GLOBAL APPEND PROPERTY SIMULI_LIBRARY_ROOMS ${target})
  endif()
endfunction()
