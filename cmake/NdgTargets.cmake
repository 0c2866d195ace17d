# SPDX-License-Identifier: Apache-2.0
# ndg_module, ndg_tool, ndg_test, ndg_bench: the four kinds of targets, with one set of flags.

add_library(ndg_flags INTERFACE)
target_compile_options(ndg_flags INTERFACE -Wall -Wextra -Wpedantic -Wshadow -Wnon-virtual-dtor -Woverloaded-virtual)
if(CMAKE_CXX_COMPILER_ID STREQUAL "GNU")
  # GCC 12's flow-based warnings are wrong inside vectorised Eigen code; the sanitizer build covers what they look for.
  target_compile_options(ndg_flags INTERFACE -Wno-array-bounds -Wno-maybe-uninitialized -Wno-stringop-overflow)
endif()
if(NDG_WARNINGS_AS_ERRORS)
  target_compile_options(ndg_flags INTERFACE -Werror)
endif()
if(NDG_SANITIZE)
  target_compile_options(ndg_flags INTERFACE -fsanitize=address,undefined -fno-sanitize-recover=all -fno-omit-frame-pointer)
  target_link_options(ndg_flags INTERFACE -fsanitize=address,undefined)
elseif(CMAKE_SYSTEM_PROCESSOR MATCHES "x86_64|AMD64")
  # Stated, not found out: what is built on one machine runs on others and gives the same numbers there.
  target_compile_options(ndg_flags INTERFACE -march=${NDG_ARCH})
  if(NDG_ARCH STREQUAL "native")
    # GCC 12 warns wrongly inside its AVX-512 headers (PR 105593), and results then agree with those of x86-64-v3.
    target_compile_options(ndg_flags INTERFACE -mno-avx512f)
  endif()
endif()

include(NdgPrecompiled)

# Modules that the shared library libndg holds.
set(NDG_SHARED_MODULES core io solver geometry body bones dataset deform runtime)

# ndg_module(<name> SOURCES <files> LINKS <public> PRIVATE_LINKS <private>)
# Links to modules of ours are written ndg::<module> and must be declared before: the graph cannot have a cycle.
function(ndg_module name)
  cmake_parse_arguments(ARG "" "" "SOURCES;LINKS;PRIVATE_LINKS" ${ARGN})
  foreach(link IN LISTS ARG_LINKS ARG_PRIVATE_LINKS)
    if(link MATCHES "^ndg::" AND NOT TARGET ${link})
      message(FATAL_ERROR "Module ${name} links ${link}, which is not a lower module")
    endif()
  endforeach()
  add_library(ndg_${name} STATIC ${ARG_SOURCES})
  add_library(ndg::${name} ALIAS ndg_${name})
  target_include_directories(ndg_${name} PUBLIC ${CMAKE_SOURCE_DIR}/lib)
  target_link_libraries(ndg_${name} PUBLIC ${ARG_LINKS} PRIVATE ndg_flags ${ARG_PRIVATE_LINKS})
  if(name IN_LIST NDG_SHARED_MODULES)
    set_target_properties(ndg_${name} PROPERTIES POSITION_INDEPENDENT_CODE ON)
    target_compile_options(ndg_${name} PRIVATE -fno-semantic-interposition)
  endif()
  ndg_precompile(ndg_${name} ${ARG_PRIVATE_LINKS})
endfunction()

# ndg_tool(<name> <links>): tools/<name>.cpp becomes an executable of that name.
function(ndg_tool name)
  if(NOT EXISTS ${CMAKE_SOURCE_DIR}/tools/${name}.cpp)
    return()
  endif()
  add_executable(${name} ${name}.cpp)
  target_link_libraries(${name} PRIVATE ndg_flags ${ARGN})
  set_property(GLOBAL APPEND PROPERTY NDG_TOOLS ${name})
  ndg_precompile(${name} ${ARGN})
endfunction()

# ndg_test(<module> <links>): every tests/<module>/*.cpp goes into one Catch2 executable and one ctest entry.
function(ndg_test name)
  file(GLOB sources CONFIGURE_DEPENDS ${CMAKE_SOURCE_DIR}/tests/${name}/*.cpp)
  if(NOT sources)
    return()
  endif()
  add_executable(test_${name} ${sources})
  target_link_libraries(test_${name} PRIVATE ndg_flags ndg_test_support ${ARGN})
  ndg_precompile(test_${name} ${ARGN} external::catch2)
  add_test(NAME ${name} COMMAND test_${name})
  if(NDG_DATA)  # at run time, so that another data folder compiles nothing anew
    set_tests_properties(${name} PROPERTIES ENVIRONMENT "NDG_DATA=${NDG_DATA}")
  endif()
endfunction()

# ndg_bench(<name> <links>): bench/<name>.cpp, target bench_<name>.
function(ndg_bench name)
  if(NOT EXISTS ${CMAKE_SOURCE_DIR}/bench/${name}.cpp)
    return()
  endif()
  add_executable(bench_${name} ${name}.cpp)
  target_link_libraries(bench_${name} PRIVATE ndg_flags ${ARGN})
  ndg_precompile(bench_${name} ${ARGN})
endfunction()
