# tree_rules.cmake on small trees, one rule broken in each: it has to name the file, and to accept the good tree.
#   cmake -D RULES=tests/tree_rules.cmake -D WORK=<scratch folder> -P tree_rules_test.cmake
cmake_minimum_required(VERSION 3.23)

function(make_good_tree)
  file(REMOVE_RECURSE "${WORK}")
  file(WRITE "${WORK}/cl/files.cmake" "set(SIMULI_CL_FILES kernels/bin.cl math/sh.h)\n")
  file(WRITE "${WORK}/cl/kernels/bin.cl" "// bin.cl - keys. Launcher: host/device/render/frame/bin.cpp\n#include \"math/sh.h\"\n")
  file(WRITE "${WORK}/cl/math/sh.h" "// sh.h - harmonics.\n")
  file(WRITE "${WORK}/host/device/render/frame/bin.cpp" "#include \"host/device/runtime/kernel.hpp\"\n")
  file(WRITE "${WORK}/host/device/runtime/cl.hpp" "#include <CL/opencl.hpp>\n")
endfunction()

function(expect wanted_result wanted_text)
  execute_process(COMMAND ${CMAKE_COMMAND} -D ROOT=${WORK} -P ${RULES}
                  RESULT_VARIABLE result OUTPUT_VARIABLE out ERROR_VARIABLE out)
  string(REGEX REPLACE "[ \n]+" " " out "${out}")  # messages are wrapped
  string(FIND "${out}" "${wanted_text}" at)
  if((wanted_result STREQUAL "good" AND NOT result EQUAL 0) OR (wanted_result STREQUAL "bad" AND result EQUAL 0)
     OR at EQUAL -1)
    message(FATAL_ERROR "wanted ${wanted_result} and '${wanted_text}', got ${result}: ${out}")
  endif()
endfunction()

# breaks(FILE TEXT MESSAGE): the good tree with that file is refused with that message.
function(breaks file text wanted)
  make_good_tree()
  file(WRITE "${WORK}/${file}" "${text}")
  expect(bad "${wanted}")
endfunction()

make_good_tree()
expect(good "follow the rules")
string(REPEAT "// line\n" 500 just_fits)
file(WRITE "${WORK}/io/long.cpp" "${just_fits}")
expect(good "follow the rules")

breaks(io/long.cpp "${just_fits}// one more\n" "io/long.cpp: 501 lines")
breaks(cl/math/sh.h "#include \"host/core/base/error.hpp\"\n" "cl/math/sh.h: cl includes nothing above it")
foreach(pair IN ITEMS "host/core/base,io/base,the core" "host/core/scene,host/device/render/frame,the core"
        "host/device/runtime,host/device/render/frame,the runtime" "host/device/render/rays,io/base,render knows no io" "host/device/render/rays,host/device/render/frame,rays know no"
        "io/log,host/device/runtime,io knows no device" "optim/train,host/apps/cli/base,optim knows no program")
  string(REGEX MATCH "^([^,]+),([^,]+),(.+)$" unused "${pair}")
  breaks(${CMAKE_MATCH_1}/CMakeLists.txt "simuli_module(${CMAKE_MATCH_1}\n  SOURCES\n    a.cpp\n  MODULES cl ${CMAKE_MATCH_2})\n"
         "${CMAKE_MATCH_1} links ${CMAKE_MATCH_2}: ${CMAKE_MATCH_3}")
endforeach()
breaks(host/device/runtime/a.hpp "#include <CL/cl.h>\n" "host/device/runtime/a.hpp: headers of the runtime")
breaks(tests/a.cpp "#include <CL/cl.h>\n" "tests/a.cpp: only host/device/runtime")
breaks(host/device/runtime/buffer.hpp "#include <CL/cl.h>\n" "host/device/runtime/buffer.hpp: headers of the runtime")
breaks(cl/kernels/bin.cl "// something else\n" "cl/kernels/bin.cl: the first line")
breaks(cl/kernels/bin.cl "// bin.cl - keys. Launcher: host/device/render/frame/gone.cpp\n" "host/device/render/frame/gone.cpp does not exist")
breaks(cl/kernels/new.cl "// new.cl - new. Launcher: host/device/render/frame/bin.cpp\n" "cl/kernels/new.cl: is not in cl/files.cmake")
file(REMOVE_RECURSE "${WORK}")
