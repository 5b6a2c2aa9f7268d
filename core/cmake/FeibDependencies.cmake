# SPDX-License-Identifier: LGPL-2.1-or-later
# The packages Feib stands on, for the build tree and for the installed package alike.

find_package(deal.II 9.4.1 REQUIRED HINTS /usr)
if(DEAL_II_VERSION VERSION_GREATER_EQUAL 9.7)
  message(FATAL_ERROR "deal.II ${DEAL_II_VERSION} is not supported: 9.4.1 (Debian 12) and 9.6.2 (Debian 13) are")
endif()
find_package(MPI REQUIRED COMPONENTS C CXX)

# Feib::dealii: headers and the library of the right build type. deal_ii_setup_target() cannot be
# mixed with PUBLIC and PRIVATE, and the package's own link line names some two hundred libraries.
if(NOT TARGET Feib::dealii)
  add_library(Feib::dealii INTERFACE IMPORTED)
  string(REPLACE " " ";" feib_dealii_definitions "${DEAL_II_DEFINITIONS}")
  if(CMAKE_BUILD_TYPE STREQUAL "Debug")
    set(feib_dealii_library ${DEAL_II_TARGET_DEBUG})
  else()
    set(feib_dealii_library ${DEAL_II_TARGET_RELEASE})
  endif()
  include(${DEAL_II_TARGET_CONFIG})
  get_target_property(feib_dealii_file ${feib_dealii_library} LOCATION)
  find_library(FEIB_PETSC petsc REQUIRED)
  find_library(FEIB_TBB tbb REQUIRED)
  find_library(FEIB_P4EST p4est REQUIRED)
  find_library(FEIB_SC sc REQUIRED)
  find_library(FEIB_TEUCHOS trilinos_teuchoscore REQUIRED)
  find_library(FEIB_TEUCHOS_COMM trilinos_teuchoscomm REQUIRED)
  find_library(FEIB_BOOST_IOSTREAMS boost_iostreams REQUIRED)
  find_library(FEIB_BOOST_SERIALIZATION boost_serialization REQUIRED)
  set(feib_kokkos)
  if(DEAL_II_WITH_KOKKOS)
    find_library(FEIB_KOKKOS NAMES trilinos_kokkoscore kokkoscore REQUIRED)
    set(feib_kokkos ${FEIB_KOKKOS})
  endif()
  # From version 9.6 on the folders of what deal.II stands on are with targets of its own.
  set(feib_dealii_include ${DEAL_II_INCLUDE_DIRS})
  get_target_property(feib_dealii_parts ${feib_dealii_library} INTERFACE_LINK_LIBRARIES)
  foreach(part IN LISTS feib_dealii_parts)
    if(TARGET ${part})
      get_target_property(folders ${part} INTERFACE_INCLUDE_DIRECTORIES)
      if(folders)
        list(APPEND feib_dealii_include ${folders})
      endif()
    endif()
  endforeach()
  list(REMOVE_DUPLICATES feib_dealii_include)
  list(REMOVE_ITEM feib_dealii_include /usr/include) # the compiler's own
  target_include_directories(Feib::dealii SYSTEM INTERFACE ${feib_dealii_include})
  target_compile_definitions(Feib::dealii INTERFACE ${feib_dealii_definitions})
  target_link_libraries(Feib::dealii INTERFACE
    ${feib_dealii_file} ${FEIB_PETSC} ${FEIB_TBB} ${FEIB_P4EST} ${FEIB_SC} ${FEIB_TEUCHOS} ${FEIB_TEUCHOS_COMM}
    ${FEIB_BOOST_IOSTREAMS} ${FEIB_BOOST_SERIALIZATION} ${feib_kokkos} MPI::MPI_CXX)
endif()
