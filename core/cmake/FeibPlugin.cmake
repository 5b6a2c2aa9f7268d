# SPDX-License-Identifier: LGPL-2.1-or-later

# feib_embed(<target> <file>...): for x/y.schema.json, writes y_schema.h, which defines the text as
# y_schema (dots and dashes of the name become underscores), where the target's sources can include it.
function(feib_embed target)
  foreach(file IN LISTS ARGN)
    cmake_path(ABSOLUTE_PATH file)
    cmake_path(GET file FILENAME name)
    string(REGEX REPLACE "\\.json$" "" name ${name})
    string(REGEX REPLACE "[.-]" "_" name ${name})
    set(header ${CMAKE_CURRENT_BINARY_DIR}/embedded/${name}.h)
    file(READ ${file} text)
    file(CONFIGURE OUTPUT ${header} CONTENT
      "static const char ${name}[] = R\"feib-json(@text@)feib-json\";\n" @ONLY)
    set_property(DIRECTORY APPEND PROPERTY CMAKE_CONFIGURE_DEPENDS ${file})
  endforeach()
  target_include_directories(${target} PRIVATE ${CMAKE_CURRENT_BINARY_DIR}/embedded)
endfunction()

# feib_precompile(<target>) uses the precompiled header of Feib's own build. It was compiled with -fPIC,
# which all of its users must share, programs too.
function(feib_precompile target)
  if(TARGET feib_precompiled)
    set_target_properties(${target} PROPERTIES POSITION_INDEPENDENT_CODE OFF)
    target_compile_options(${target} PRIVATE -fPIC)
    target_precompile_headers(${target} REUSE_FROM feib_precompiled)
  endif()
endfunction()

# feib_add_base(<interface> SOURCES <file>... [TESTS <file>...] [LIBRARIES <library>...])
# builds Feib::<interface>_base: what components of one interface share, compiled once into a static
# library, from which a plugin takes what it uses. Its headers, include/feib/<interface>/*.h, are
# included as <feib/<interface>/...> and installed.
function(feib_add_base interface)
  cmake_parse_arguments(PARSE_ARGV 1 arg "" "" "SOURCES;TESTS;LIBRARIES")
  set(name feib_${interface}_base)
  add_library(${name} STATIC ${arg_SOURCES})
  add_library(Feib::${interface}_base ALIAS ${name})
  set_target_properties(${name} PROPERTIES
    EXPORT_NAME ${interface}_base POSITION_INDEPENDENT_CODE ON)
  target_include_directories(${name} PUBLIC
    $<BUILD_INTERFACE:${CMAKE_CURRENT_SOURCE_DIR}/include> $<INSTALL_INTERFACE:include>)
  target_link_libraries(${name} PUBLIC Feib::core ${arg_LIBRARIES})
  feib_precompile(${name})
  install(TARGETS ${name} EXPORT FeibTargets ARCHIVE DESTINATION lib)
  install(DIRECTORY include/ DESTINATION include)
  if(arg_TESTS AND FEIB_TESTS)
    feib_add_test(${interface}_base_test SOURCES ${arg_TESTS} LIBRARIES ${name})
  endif()
endfunction()

# feib_add_plugin(<name> SOURCES <file>... SCHEMAS <file>.schema.json... [TESTS <file>...]
#                 [BASE <interface>] [LIBRARIES <library>...])
# builds <name>.feib.so with the schemas embedded, and a GoogleTest that loads it. BASE: the plugin
# builds on what feib_add_base(<interface>) has built. FEIB_TEMPLATE: it is one of Feib's templates, built
# so that it is known to build, and neither installed nor found by a run.
function(feib_add_plugin name)
  cmake_parse_arguments(PARSE_ARGV 1 arg "" "BASE" "SOURCES;SCHEMAS;TESTS;LIBRARIES")
  if(arg_BASE)
    list(APPEND arg_LIBRARIES Feib::${arg_BASE}_base)
  endif()
  add_library(${name} MODULE ${arg_SOURCES})
  set_target_properties(${name} PROPERTIES
    PREFIX "" SUFFIX ".feib.so" LIBRARY_OUTPUT_DIRECTORY ${FEIB_PLUGIN_OUTPUT_DIRECTORY}
    BUILD_WITH_INSTALL_RPATH ON INSTALL_RPATH $ORIGIN/../..)
  target_link_libraries(${name} PRIVATE Feib::core ${arg_LIBRARIES})
  # Nothing but feib_plugin is seen from outside: two plugins may call two things by one name.
  set(exports ${CMAKE_CURRENT_FUNCTION_LIST_DIR}/plugin.map)
  target_link_options(${name} PRIVATE LINKER:--no-undefined LINKER:--version-script=${exports})
  set_target_properties(${name} PROPERTIES LINK_DEPENDS ${exports})
  feib_embed(${name} ${arg_SCHEMAS})
  feib_precompile(${name})
  if(NOT FEIB_TEMPLATE)
    install(TARGETS ${name} LIBRARY DESTINATION lib/feib/plugins)
    if(TARGET feib_run)
      add_dependencies(feib_run ${name})
    endif()
  endif()
  if(arg_TESTS AND FEIB_TESTS)
    feib_add_test(${name}_test SOURCES ${arg_TESTS} LIBRARIES ${arg_LIBRARIES})
    add_dependencies(${name}_test ${name})
  endif()
endfunction()

# feib_add_test(<name> SOURCES <file>... [LIBRARIES <library>...] [KIND unit|host|case] [RANKS <n>...]
#               [SLOW] [UNREGISTERED])
# builds a GoogleTest program and registers it with ctest once for each number of MPI ranks (by
# default one rank; not at all when UNREGISTERED). The tests find the plugins that are built with them,
# and Feib's own.
# Of Feib's own build, the target feib_unit_tests is all that `ctest -L unit` needs.
function(feib_add_test name)
  cmake_parse_arguments(PARSE_ARGV 1 arg "SLOW;UNREGISTERED" "KIND" "SOURCES;LIBRARIES;RANKS")
  add_executable(${name} ${arg_SOURCES})
  target_link_libraries(${name} PRIVATE Feib::testing ${arg_LIBRARIES})
  feib_precompile(${name})
  if(NOT arg_KIND)
    set(arg_KIND unit)
  endif()
  if(arg_KIND STREQUAL "unit" AND TARGET feib_unit_tests)
    add_dependencies(feib_unit_tests ${name})
  endif()
  if(NOT arg_RANKS AND NOT arg_UNREGISTERED)
    set(arg_RANKS 1)
  endif()
  set(slow)
  if(arg_SLOW)
    set(slow SLOW)
  endif()
  foreach(ranks IN LISTS arg_RANKS)
    feib_test_on_ranks(${name} ${ranks} KIND ${arg_KIND} ${slow})
  endforeach()
endfunction()

# feib_test_on_ranks(<program> <ranks> [NAME <test>] [ARGUMENTS <argument>...] [KIND unit|host|case]
#                    [SLOW])
# registers a program of feib_add_test() with ctest, run on that many MPI ranks. Its label is its
# kind: unit (the default), host (it runs feib-host) or case (one of cases/); `mpi` is added for more
# than one rank, `slow` for tests that take longer than 20 s in a release build.
function(feib_test_on_ranks program ranks)
  cmake_parse_arguments(PARSE_ARGV 2 arg "SLOW" "NAME;KIND" "ARGUMENTS")
  set(test ${program})
  if(arg_NAME)
    set(test ${arg_NAME})
  endif()
  set(command $<TARGET_FILE:${program}> ${arg_ARGUMENTS})
  set(labels unit)
  if(arg_KIND)
    set(labels ${arg_KIND})
  endif()
  if(NOT labels MATCHES "^(unit|host|case)$")
    message(FATAL_ERROR "the kind of the test ${test} is \"${labels}\"; it must be unit, host or case")
  endif()
  if(ranks GREATER 1)
    string(APPEND test _np${ranks})
    list(PREPEND command ${MPIEXEC_EXECUTABLE} -np ${ranks} --oversubscribe)
    list(APPEND labels mpi)
  endif()
  if(arg_SLOW)
    list(APPEND labels slow)
  endif()
  add_test(NAME ${test} COMMAND ${command})
  # A test has temporary files of its own, those of MPI too: programs of Open MPI 4 that share a
  # folder remove it when they end, under the hands of those that are starting.
  set(temporary ${CMAKE_CURRENT_BINARY_DIR}/${test}.tmp)
  file(MAKE_DIRECTORY ${temporary})
  # All ranks are on one machine, where Open MPI 5 complains of networks it does not need, and Open
  # MPI 4 looks for one for a second (ofi; the others are those that Debian leaves out with it).
  set(environment TMPDIR=${temporary} OMPI_ALLOW_RUN_AS_ROOT=1 OMPI_ALLOW_RUN_AS_ROOT_CONFIRM=1 OMPI_MCA_hwloc_base_binding_policy=none
    OMPI_MCA_btl=^tcp,uct,openib,ofi)
  if(FEIB_TEMPLATE OR NOT TARGET feib_core) # Feib finds its own
    list(APPEND environment FEIB_PLUGIN_PATH=${FEIB_PLUGIN_OUTPUT_DIRECTORY})
  endif()
  set_tests_properties(${test} PROPERTIES
    PROCESSORS ${ranks} TIMEOUT 600 LABELS "${labels}" ENVIRONMENT "${environment}")
endfunction()
