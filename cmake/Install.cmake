# SPDX-License-Identifier: Apache-2.0
# What an installation holds (docs/install.md): tools, libndg with its CMake package, configs, documentation, licences,
# completion for bash; and the same as Debian packages (CPack).

include(GNUInstallDirs)
include(CMakePackageConfigHelpers)

set(NDG_DOC ${CMAKE_INSTALL_DATADIR}/doc)
get_property(tools GLOBAL PROPERTY NDG_TOOLS)

# A tool in a build folder finds configs where an installed one does (core/installed_files.h).
file(MAKE_DIRECTORY ${CMAKE_BINARY_DIR}/share)
file(CREATE_LINK ${CMAKE_SOURCE_DIR}/configs ${CMAKE_BINARY_DIR}/share/ndg SYMBOLIC)

# Tools, under their own names but for those that programs of others have. They link no library of this build, so their
# search paths hold nothing but where libraries from elsewhere lie (a libtorch with CUDA), and stay.
set(installed_name_animate ndg-animate)  # ImageMagick has an `animate`
foreach(tool IN LISTS tools)
  set(installed ${tool})
  if(DEFINED installed_name_${tool})
    set(installed ${installed_name_${tool}})
  endif()
  list(APPEND installed_tools ${installed})
  install(PROGRAMS $<TARGET_FILE:${tool}> DESTINATION ${CMAKE_INSTALL_BINDIR} RENAME ${installed} COMPONENT tools)
endforeach()
add_custom_target(installable DEPENDS ${tools} libndg)
# What is completed is asked of the tools themselves.
install(CODE "
  set(prefix \"\$ENV{DESTDIR}\${CMAKE_INSTALL_PREFIX}\")
  file(MAKE_DIRECTORY \"\${prefix}/${CMAKE_INSTALL_DATADIR}/bash-completion/completions\")
  foreach(tool ${installed_tools})
    execute_process(COMMAND \"\${prefix}/${CMAKE_INSTALL_BINDIR}/\${tool}\" --completion bash COMMAND_ERROR_IS_FATAL ANY
      OUTPUT_FILE \"\${prefix}/${CMAKE_INSTALL_DATADIR}/bash-completion/completions/\${tool}\")
  endforeach()" COMPONENT tools)

install(DIRECTORY configs/ DESTINATION ${CMAKE_INSTALL_DATADIR}/ndg COMPONENT tools)
install(FILES README.md LICENSE DESTINATION ${NDG_DOC}/ndg-tools COMPONENT tools)
install(DIRECTORY docs DESTINATION ${NDG_DOC}/ndg-tools COMPONENT tools)

# libndg and find_package(ndg).
set(package_folder ${CMAKE_INSTALL_LIBDIR}/cmake/ndg)
set_target_properties(libndg PROPERTIES EXPORT_NAME ndg)
install(TARGETS libndg EXPORT ndgTargets
  LIBRARY DESTINATION ${CMAKE_INSTALL_LIBDIR} COMPONENT runtime NAMELINK_COMPONENT development
  INCLUDES DESTINATION ${CMAKE_INSTALL_INCLUDEDIR})
install(FILES lib/ndg/runtime/ndg.h DESTINATION ${CMAKE_INSTALL_INCLUDEDIR}/ndg/runtime COMPONENT development)
install(EXPORT ndgTargets NAMESPACE ndg:: FILE ndgConfig.cmake DESTINATION ${package_folder} COMPONENT development)
write_basic_package_version_file(${CMAKE_BINARY_DIR}/ndgConfigVersion.cmake COMPATIBILITY SameMinorVersion)
install(FILES ${CMAKE_BINARY_DIR}/ndgConfigVersion.cmake DESTINATION ${package_folder} COMPONENT development)
install(DIRECTORY docs/examples DESTINATION ${NDG_DOC}/libndg-dev COMPONENT development)

# Whether what is built for `target` holds or links the third party `wanted` (external::tetgen), by whatever way.
function(ndg_links target wanted result)
  set(queue ${target})
  set(seen "")
  while(queue)
    list(POP_FRONT queue next)
    string(REGEX REPLACE "^\\$<LINK_ONLY:(.*)>$" "\\1" next "${next}")
    if(next STREQUAL wanted)
      set(${result} TRUE PARENT_SCOPE)
      return()
    endif()
    if(NOT TARGET "${next}" OR next IN_LIST seen)
      continue()
    endif()
    list(APPEND seen ${next})
    foreach(property LINK_LIBRARIES INTERFACE_LINK_LIBRARIES)
      get_target_property(links ${next} ${property})
      if(links)
        list(APPEND queue ${links})
      endif()
    endforeach()
  endwhile()
  set(${result} FALSE PARENT_SCOPE)
endfunction()

# The licence under which each executable may be passed on: the strongest of what it links.
foreach(tool installed IN ZIP_LISTS tools installed_tools)
  ndg_links(${tool} external::tetgen links_tetgen)
  ndg_links(${tool} external::cgal links_cgal)
  ndg_links(${tool} external::cholmod links_cholmod)
  if(links_tetgen)
    list(APPEND agpl_files usr/bin/${installed})
  elseif(links_cgal)
    list(APPEND cgal_files usr/bin/${installed})
  elseif(links_cholmod)
    list(APPEND cholmod_files usr/bin/${installed})
  endif()
endforeach()
foreach(files agpl_files cgal_files cholmod_files)
  list(JOIN ${files} "\n       " ${files})
endforeach()
configure_file(cmake/copyright.in ${CMAKE_BINARY_DIR}/copyright @ONLY)
# Texts of libraries that are compiled in or whose terms hold for what links them, as Debian has them.
set(third_parties libcgal-dev libcli11-dev libeigen3-dev libfmt-dev libspdlog-dev libsuitesparse-dev libtet1.5-dev
                  libtinygltf-dev nlohmann-json3-dev)
foreach(place tools/ndg-tools runtime/libndg0 development/libndg-dev)
  string(REPLACE "/" ";" place ${place})
  list(GET place 0 component)
  list(GET place 1 package)
  install(FILES ${CMAKE_BINARY_DIR}/copyright DESTINATION ${NDG_DOC}/${package} COMPONENT ${component})
  if(NOT component STREQUAL development)  # which holds no compiled code
    foreach(third_party IN LISTS third_parties)
      install(FILES /usr/share/doc/${third_party}/copyright DESTINATION ${NDG_DOC}/${package}/third-party
        RENAME ${third_party} COMPONENT ${component} OPTIONAL)
    endforeach()
  endif()
endforeach()

# Debian packages: the library apart from the tools, whose licences do not hold for it.
set(CPACK_GENERATOR DEB)
set(CPACK_PACKAGE_NAME ndg)
set(CPACK_PACKAGE_CONTACT "the project's maintainers <root@localhost>")
set(CPACK_PACKAGE_DIRECTORY ${CMAKE_BINARY_DIR}/packages)
set(CPACK_PACKAGING_INSTALL_PREFIX /usr)
set(CPACK_STRIP_FILES ON)
set(CPACK_COMPONENTS_ALL tools runtime development)
set(CPACK_DEB_COMPONENT_INSTALL ON)
set(CPACK_DEBIAN_FILE_NAME DEB-DEFAULT)
set(CPACK_DEBIAN_PACKAGE_SHLIBDEPS ON)
set(CPACK_DEBIAN_PACKAGE_GENERATE_SHLIBS ON)
set(CPACK_DEBIAN_PACKAGE_CONTROL_STRICT_PERMISSION ON)
set(CPACK_DEBIAN_TOOLS_PACKAGE_NAME ndg-tools)
set(CPACK_DEBIAN_TOOLS_PACKAGE_SECTION graphics)
set(CPACK_DEBIAN_RUNTIME_PACKAGE_NAME libndg0)
set(CPACK_DEBIAN_RUNTIME_PACKAGE_SECTION libs)
set(CPACK_DEBIAN_DEVELOPMENT_PACKAGE_NAME libndg-dev)
set(CPACK_DEBIAN_DEVELOPMENT_PACKAGE_SECTION libdevel)
set(CPACK_DEBIAN_DEVELOPMENT_PACKAGE_DEPENDS "libndg0 (= ${PROJECT_VERSION})")
set(CPACK_COMPONENT_TOOLS_DESCRIPTION "Neural deformation gradients: tools\n Bodies with bones, muscles and fat: built, simulated, learned and animated.")
set(CPACK_COMPONENT_RUNTIME_DESCRIPTION "Neural deformation gradients: runtime library\n Poses anatomical bodies by a trained network, frame by frame.")
set(CPACK_COMPONENT_DEVELOPMENT_DESCRIPTION "Neural deformation gradients: development files\n Header, CMake package and examples of libndg.")
include(CPack)
