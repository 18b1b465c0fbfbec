# gRPC and protobuf, where they are: SIMULI_HAS_GRPC, simuli_grpc, PROTOC, GRPC_CPP_PLUGIN. By their files, as
# gRPC's own CMake package asks for the development files of all that it is made of.
find_path(GRPC_INCLUDE grpcpp/grpcpp.h)
find_library(GRPCPP_LIBRARY grpc++)
find_library(GRPC_LIBRARY grpc)
find_library(GPR_LIBRARY gpr)
find_library(ABSL_SYNCHRONIZATION_LIBRARY absl_synchronization)  # of gRPC's headers
find_path(PROTOBUF_INCLUDE google/protobuf/message.h)
find_library(PROTOBUF_LIBRARY protobuf)
find_program(PROTOC protoc)
find_program(GRPC_CPP_PLUGIN grpc_cpp_plugin)
mark_as_advanced(
  GRPC_INCLUDE GRPCPP_LIBRARY GRPC_LIBRARY GPR_LIBRARY ABSL_SYNCHRONIZATION_LIBRARY PROTOBUF_INCLUDE
  PROTOBUF_LIBRARY PROTOC GRPC_CPP_PLUGIN)

set(missing "")
foreach(need IN ITEMS
    GRPC_INCLUDE=libgrpc++-dev GRPCPP_LIBRARY=libgrpc++-dev GRPC_LIBRARY=libgrpc-dev GPR_LIBRARY=libgrpc-dev
    ABSL_SYNCHRONIZATION_LIBRARY=libabsl-dev PROTOBUF_INCLUDE=libprotobuf-dev PROTOBUF_LIBRARY=libprotobuf-dev
    PROTOC=protobuf-compiler
    GRPC_CPP_PLUGIN=protobuf-compiler-grpc)
  string(REGEX MATCH "^([A-Z_]+)=(.+)$" unused "${need}")
  if(NOT ${CMAKE_MATCH_1})
    list(APPEND missing ${CMAKE_MATCH_2})
  endif()
endforeach()
list(REMOVE_DUPLICATES missing)
if(missing)
  list(JOIN missing " " missing)
  message(STATUS "simuli serve: left out; missing, by their Debian names: ${missing}")
  set(SIMULI_HAS_GRPC OFF)
  return()
endif()
message(STATUS "simuli serve: with ${GRPCPP_LIBRARY} and ${PROTOBUF_LIBRARY}")
set(SIMULI_HAS_GRPC ON)
add_library(simuli_grpc INTERFACE)
target_include_directories(simuli_grpc SYSTEM INTERFACE ${GRPC_INCLUDE} ${PROTOBUF_INCLUDE})
target_link_libraries(simuli_grpc INTERFACE
  ${GRPCPP_LIBRARY} ${GRPC_LIBRARY} ${GPR_LIBRARY} ${ABSL_SYNCHRONIZATION_LIBRARY} ${PROTOBUF_LIBRARY}
  Threads::Threads)
