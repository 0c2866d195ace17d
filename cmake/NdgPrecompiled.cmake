# SPDX-License-Identifier: Apache-2.0
# ndg_precompile(<target> <links>): the headers that nearly all sources include are parsed once for all targets. GCC
# takes a precompiled header only under the flags it was made with, so there is one for targets with OpenMP, one for
# those without, each position independent or not, one with libtorch's headers and one with Catch2's.

# A compiler cache keeps nothing that was compiled with them unless it is told how.
set(precompile ON)
if(CMAKE_CXX_COMPILER_LAUNCHER MATCHES "ccache" OR NOT CMAKE_CXX_COMPILER_ID STREQUAL "GNU")
  set(precompile OFF)
endif()
option(NDG_PRECOMPILED_HEADERS "Parse common headers once (a gigabyte in the build folder)" ${precompile})

set(NDG_COMMON_HEADERS
  <algorithm> <array> <cmath> <cstdint> <filesystem> <functional> <limits> <map> <memory> <numeric> <optional> <set>
  <string> <utility> <vector> <Eigen/Core> <Eigen/Geometry> <fmt/format.h>)

function(ndg_precompile target)
  if(NOT NDG_PRECOMPILED_HEADERS OR "external::cgal" IN_LIST ARGN)  # CGAL brings flags of its own
    return()
  endif()
  if("external::torch" IN_LIST ARGN AND NOT "OpenMP::OpenMP_CXX" IN_LIST ARGN)  # libtorch defines macros of its own
    return()
  endif()
  set(links ndg_flags Eigen3::Eigen fmt::fmt)
  set(headers ${NDG_COMMON_HEADERS})
  set(name ndg_precompiled)
  get_target_property(position_independent ${target} POSITION_INDEPENDENT_CODE)
  if(position_independent)
    string(APPEND name _pic)
  endif()
  if("OpenMP::OpenMP_CXX" IN_LIST ARGN)
    string(APPEND name _openmp)
    list(APPEND links OpenMP::OpenMP_CXX)
    if("external::torch" IN_LIST ARGN)
      string(APPEND name _torch)
      list(APPEND links external::torch)
      list(APPEND headers <torch/types.h>)
    endif()
  elseif("external::catch2" IN_LIST ARGN)
    string(APPEND name _catch2)
    list(APPEND links external::catch2)
    list(APPEND headers <catch2/catch.hpp>)
  endif()
  if(NOT TARGET ${name})
    file(CONFIGURE OUTPUT ${CMAKE_BINARY_DIR}/precompiled.cpp CONTENT "// Only its precompiled header is of use.\n")
    add_library(${name} OBJECT ${CMAKE_BINARY_DIR}/precompiled.cpp)
    target_link_libraries(${name} PRIVATE ${links})
    target_precompile_headers(${name} PRIVATE ${headers})
    if(position_independent)
      set_target_properties(${name} PROPERTIES POSITION_INDEPENDENT_CODE ON)
      target_compile_options(${name} PRIVATE -fno-semantic-interposition)
    endif()
  endif()
  target_precompile_headers(${target} REUSE_FROM ${name})
endfunction()
