# SPDX-License-Identifier: LGPL-2.1-or-later
# What `cmake --install` and `cpack` make beside programs, libraries and headers: the CMake package with which
# plugins are built outside this tree. The build tree offers it too, in the same folders.
include(CMakePackageConfigHelpers)

set(package ${PROJECT_BINARY_DIR}/lib/cmake/Feib)
string(REGEX MATCH "^[0-9]+" feib_compiler_major ${CMAKE_CXX_COMPILER_VERSION})
configure_file(${CMAKE_CURRENT_LIST_DIR}/FeibConfig.cmake.in ${package}/FeibConfig.cmake @ONLY)
write_basic_package_version_file(${package}/FeibConfigVersion.cmake COMPATIBILITY SameMinorVersion)
foreach(file FeibDependencies.cmake FeibPlugin.cmake plugin.map)
  configure_file(${CMAKE_CURRENT_LIST_DIR}/${file} ${package}/${file} COPYONLY)
endforeach()
install(DIRECTORY ${package}/ DESTINATION lib/cmake/Feib PATTERN "Feib*Targets*.cmake" EXCLUDE)
export(EXPORT FeibTargets NAMESPACE Feib:: FILE ${package}/FeibTargets.cmake)
install(EXPORT FeibTargets NAMESPACE Feib:: DESTINATION lib/cmake/Feib)
if(TARGET feib_testing)
  export(EXPORT FeibTestingTargets NAMESPACE Feib:: FILE ${package}/FeibTestingTargets.cmake)
  install(EXPORT FeibTestingTargets NAMESPACE Feib:: DESTINATION lib/cmake/Feib)
endif()

# What --new-plugin copies, and what people read, found from the programs.
file(MAKE_DIRECTORY ${PROJECT_BINARY_DIR}/share/feib)
foreach(folder schemas cases plugins/template)
  cmake_path(GET folder FILENAME name)
  string(REPLACE template templates name ${name})
  file(CREATE_LINK ${PROJECT_SOURCE_DIR}/${folder} ${PROJECT_BINARY_DIR}/share/feib/${name} SYMBOLIC)
  install(DIRECTORY ${folder}/ DESTINATION share/feib/${name} PATTERN output EXCLUDE)
endforeach()
install(FILES LICENSE RENAME copyright DESTINATION share/doc/feib)

set(CPACK_GENERATOR DEB)
set(CPACK_PACKAGE_NAME feib)
set(CPACK_PACKAGE_CONTACT "The Feib authors")
set(CPACK_DEBIAN_FILE_NAME DEB-DEFAULT)
if(FEIB_NATIVE)
  set(CPACK_DEBIAN_PACKAGE_RELEASE native) # on another processor it may not start
endif()
set(CPACK_PACKAGING_INSTALL_PREFIX /usr)
set(CPACK_STRIP_FILES ON)
set(CPACK_VERBATIM_VARIABLES ON)
set(CPACK_DEBIAN_PACKAGE_SECTION science)
set(CPACK_DEBIAN_PACKAGE_SHLIBDEPS ON)
# In the folder of the package; libfeib is its own.
set(CPACK_DEBIAN_PACKAGE_SHLIBDEPS_PRIVATE_DIRS ${PROJECT_BINARY_DIR}/lib)
# What plugins are built with.
set(CPACK_DEBIAN_PACKAGE_RECOMMENDS "cmake (>= 3.25), g++, make, libdeal.ii-dev, libgtest-dev")
include(CPack)
