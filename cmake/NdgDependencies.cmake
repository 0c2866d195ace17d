# SPDX-License-Identifier: Apache-2.0
# Debian packages only; nothing is downloaded. Every third party is one imported target, with system includes.

find_package(Threads REQUIRED)
find_package(OpenMP REQUIRED)
find_package(Eigen3 3.4 REQUIRED)
find_package(fmt REQUIRED)
find_package(spdlog REQUIRED)
find_package(nlohmann_json REQUIRED)
find_package(OpenSSL REQUIRED)
find_package(PNG REQUIRED)
find_package(ZLIB REQUIRED)
find_package(HDF5 REQUIRED COMPONENTS C)
find_package(embree 3 REQUIRED)
find_package(CGAL 5.5 REQUIRED)
find_path(CHOLMOD_INCLUDE_DIR suitesparse/cholmod.h REQUIRED)
find_library(CHOLMOD_LIBRARY cholmod REQUIRED)
find_path(CLI11_INCLUDE_DIR CLI/CLI.hpp REQUIRED)
find_path(TETGEN_INCLUDE_DIR tetgen.h REQUIRED)
find_library(TETGEN_LIBRARY tet REQUIRED)
find_path(TINYGLTF_INCLUDE_DIR tiny_gltf.h REQUIRED)
find_library(TINYGLTF_LIBRARY tinygltf REQUIRED)
find_path(WEBP_INCLUDE_DIR webp/mux.h REQUIRED)
find_library(WEBP_LIBRARY webp REQUIRED)
find_library(WEBPMUX_LIBRARY webpmux REQUIRED)
find_library(OPENBLAS_LIBRARY openblas REQUIRED)
find_path(CATCH2_INCLUDE_DIR catch2/catch.hpp REQUIRED)

# The libraries above, as targets with one naming scheme.
function(ndg_external name)
  cmake_parse_arguments(ARG "" "" "INCLUDES;LIBRARIES;DEFINITIONS" ${ARGN})
  add_library(ndg_external_${name} INTERFACE)
  target_include_directories(ndg_external_${name} SYSTEM INTERFACE ${ARG_INCLUDES})
  target_link_libraries(ndg_external_${name} INTERFACE ${ARG_LIBRARIES})
  target_compile_definitions(ndg_external_${name} INTERFACE ${ARG_DEFINITIONS})
  add_library(external::${name} ALIAS ndg_external_${name})
endfunction()

ndg_external(hdf5 INCLUDES ${HDF5_C_INCLUDE_DIRS} LIBRARIES ${HDF5_C_LIBRARIES})
ndg_external(cholmod INCLUDES ${CHOLMOD_INCLUDE_DIR} LIBRARIES ${CHOLMOD_LIBRARY} ${OPENBLAS_LIBRARY})
ndg_external(openblas LIBRARIES ${OPENBLAS_LIBRARY})
ndg_external(cli11 INCLUDES ${CLI11_INCLUDE_DIR})
ndg_external(tetgen INCLUDES ${TETGEN_INCLUDE_DIR} LIBRARIES ${TETGEN_LIBRARY} DEFINITIONS TETLIBRARY)
ndg_external(tinygltf INCLUDES ${TINYGLTF_INCLUDE_DIR} LIBRARIES ${TINYGLTF_LIBRARY}
             DEFINITIONS TINYGLTF_NO_STB_IMAGE TINYGLTF_NO_STB_IMAGE_WRITE TINYGLTF_NO_EXTERNAL_IMAGE)
ndg_external(embree INCLUDES ${EMBREE_INCLUDE_DIRS} LIBRARIES embree)
ndg_external(webp INCLUDES ${WEBP_INCLUDE_DIR} LIBRARIES ${WEBPMUX_LIBRARY} ${WEBP_LIBRARY})
ndg_external(cgal LIBRARIES CGAL::CGAL)
ndg_external(catch2 INCLUDES ${CATCH2_INCLUDE_DIR})

if(NDG_WITH_TORCH)
  find_package(Torch REQUIRED)
  ndg_external(torch INCLUDES ${TORCH_INCLUDE_DIRS} LIBRARIES ${TORCH_LIBRARIES})
  # PyTorch's own builds of libtorch export std::filesystem out of a static libstdc++, which does not work from outside
  # (remove_all jumps to address 0). The system's libstdc++ must be loaded, and its symbols be found, before them.
  target_link_options(ndg_external_torch INTERFACE "LINKER:--push-state,--no-as-needed" -lstdc++ "LINKER:--pop-state")
  # The library that Debian's libtorch links: oneDNN, for products in float32 and bfloat16. A libtorch with CUDA brings
  # one of its own, beside which it must not be linked.
  if(NOT TORCH_CUDA_LIBRARIES)
    find_path(DNNL_INCLUDE_DIR oneapi/dnnl/dnnl.hpp REQUIRED)
    find_library(DNNL_LIBRARY dnnl REQUIRED)
    ndg_external(dnnl INCLUDES ${DNNL_INCLUDE_DIR} LIBRARIES ${DNNL_LIBRARY} DEFINITIONS NDG_WITH_DNNL)
  endif()
endif()
