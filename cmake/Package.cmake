# Install rules and find_package(volccd) for other projects. The package contains the libraries and their headers. If
# the program is built, it is installed as well, and so is the component `program`: the program as a library with its
# dependencies. The components `c` and `fortran` are the library for C, which needs no dependency.
include(CMakePackageConfigHelpers)

set(VOLCCD_PACKAGE_DIR "${CMAKE_INSTALL_LIBDIR}/cmake/volccd")
file(RELATIVE_PATH VOLCCD_PREFIX_FROM_PC "/${CMAKE_INSTALL_LIBDIR}/pkgconfig" "/")
string(REGEX REPLACE "/$" "" VOLCCD_PREFIX_FROM_PC "${VOLCCD_PREFIX_FROM_PC}")

# volccd_tool_manual(name script): the manual page of a tool in Python, from its --help. Needs help2man, and what the tool
# imports; otherwise there is none.
find_program(VOLCCD_HELP2MAN help2man)
function(volccd_tool_manual name script)
  set(tool "${CMAKE_BINARY_DIR}/manual/volccd-${name}")
  file(CONFIGURE OUTPUT "${tool}" @ONLY
       CONTENT "#!/bin/sh\nexec /usr/bin/python3 -B \"${PROJECT_SOURCE_DIR}/tools/${script}.py\" \"$@\"\n")
  file(CHMOD "${tool}" PERMISSIONS OWNER_READ OWNER_WRITE OWNER_EXECUTE)
  execute_process(COMMAND "${tool}" --version RESULT_VARIABLE code OUTPUT_QUIET ERROR_QUIET)
  if(NOT VOLCCD_HELP2MAN OR NOT code EQUAL 0)
    message(STATUS "volccd-${name}: no manual page (help2man, and what the tool imports)")
    return()
  endif()
  file(READ "${PROJECT_SOURCE_DIR}/tools/${script}.py" text)
  string(REGEX MATCH "\"\"\"([^\n]*)\\.\n" first "${text}")
  string(SUBSTRING "${CMAKE_MATCH_1}" 0 1 letter)
  string(SUBSTRING "${CMAKE_MATCH_1}" 1 -1 rest)
  string(TOLOWER "${letter}" letter)
  add_custom_command(OUTPUT "${tool}.1" DEPENDS "${PROJECT_SOURCE_DIR}/tools/${script}.py"
    COMMAND "${VOLCCD_HELP2MAN}" --no-info "--name=${letter}${rest}" -o "${tool}.1" "${tool}" VERBATIM)
  add_custom_target(volccd_manual_${name} ALL DEPENDS "${tool}.1")
  install(FILES "${tool}.1" DESTINATION "${CMAKE_INSTALL_MANDIR}/man1" COMPONENT program)
endfunction()

install(EXPORT volccdTargets NAMESPACE volccd:: DESTINATION "${VOLCCD_PACKAGE_DIR}" COMPONENT dev)
if(VOLCCD_BUILD_PROGRAM)
  # A package without this file has no such component (volccdConfig.cmake).
  install(EXPORT volccdProgramTargets NAMESPACE volccd:: DESTINATION "${VOLCCD_PACKAGE_DIR}" COMPONENT dev)
  install(TARGETS volccd_executable RUNTIME DESTINATION "${CMAKE_INSTALL_BINDIR}" COMPONENT program)
  # Python tools that are installed with the program: importer and figures.
  install(DIRECTORY "${PROJECT_SOURCE_DIR}/tools/" DESTINATION "${CMAKE_INSTALL_DATADIR}/volccd/tools" COMPONENT program
          USE_SOURCE_PERMISSIONS FILES_MATCHING PATTERN "*.py" PATTERN "__pycache__" EXCLUDE)
  file(CONFIGURE OUTPUT "${CMAKE_BINARY_DIR}/tools/VERSION" CONTENT "@PROJECT_VERSION@\n" @ONLY)
  install(FILES "${CMAKE_BINARY_DIR}/tools/VERSION" DESTINATION "${CMAKE_INSTALL_DATADIR}/volccd/tools" COMPONENT program)
  foreach(tool IN ITEMS import:import_sequence plot:plot_results)
    string(REPLACE ":" ";" tool "${tool}")
    list(GET tool 0 name)
    list(GET tool 1 script)
    file(CONFIGURE OUTPUT "${CMAKE_BINARY_DIR}/tools/volccd-${name}" @ONLY CONTENT "#!/bin/sh
exec /usr/bin/python3 \"\$(dirname \"\$(readlink -f \"\$0\")\")/../${CMAKE_INSTALL_DATADIR}/volccd/tools/${script}.py\" \"\$@\"
")
    install(PROGRAMS "${CMAKE_BINARY_DIR}/tools/volccd-${name}" DESTINATION "${CMAKE_INSTALL_BINDIR}" COMPONENT program)
    volccd_tool_manual("${name}" "${script}")
  endforeach()
endif()

if(VOLCCD_BUILD_C)
  # Packages without these files have no components `c` and `fortran`.
  install(EXPORT volccdCTargets NAMESPACE volccd:: DESTINATION "${VOLCCD_PACKAGE_DIR}" COMPONENT dev)
  if(TARGET volccd_fortran)
    install(EXPORT volccdFortranTargets NAMESPACE volccd:: DESTINATION "${VOLCCD_PACKAGE_DIR}" COMPONENT dev)
  endif()
  configure_file("${CMAKE_CURRENT_LIST_DIR}/volccd_c.pc.in" "${CMAKE_BINARY_DIR}/cmake/volccd_c.pc" @ONLY)
  install(FILES "${CMAKE_BINARY_DIR}/cmake/volccd_c.pc" DESTINATION "${CMAKE_INSTALL_LIBDIR}/pkgconfig" COMPONENT dev)
endif()

if(VOLCCD_MPI)
  install(EXPORT volccdMpiTargets NAMESPACE volccd:: DESTINATION "${VOLCCD_PACKAGE_DIR}" COMPONENT dev)
  if(VOLCCD_BUILD_PROGRAM)
    install(TARGETS volccd_mpi_executable RUNTIME DESTINATION "${CMAKE_INSTALL_BINDIR}" COMPONENT mpi)
  endif()
endif()

get_property(headers GLOBAL PROPERTY VOLCCD_HEADERS)
get_property(folders GLOBAL PROPERTY VOLCCD_HEADER_FOLDERS)
install(CODE "
  set(VOLCCD_HEADERS \"${headers}\")
  set(VOLCCD_HEADER_FOLDERS \"${folders}\")
  set(VOLCCD_SOURCE_DIR \"${PROJECT_SOURCE_DIR}\")
  set(VOLCCD_HEADER_DESTINATION \"${CMAKE_INSTALL_INCLUDEDIR}/volccd\")
  include(\"${CMAKE_CURRENT_LIST_DIR}/InstallHeaders.cmake\")" COMPONENT dev)

configure_package_config_file(
  "${CMAKE_CURRENT_LIST_DIR}/volccdConfig.cmake.in" "${CMAKE_BINARY_DIR}/cmake/volccdConfig.cmake"
  INSTALL_DESTINATION "${VOLCCD_PACKAGE_DIR}"
  NO_SET_AND_CHECK_MACRO)
# Before 1.0 a minor version may break the interface.
write_basic_package_version_file("${CMAKE_BINARY_DIR}/cmake/volccdConfigVersion.cmake" COMPATIBILITY SameMinorVersion)

install(FILES "${CMAKE_BINARY_DIR}/cmake/volccdConfig.cmake" "${CMAKE_BINARY_DIR}/cmake/volccdConfigVersion.cmake"
              "${CMAKE_CURRENT_LIST_DIR}/FindGMP.cmake"
        DESTINATION "${VOLCCD_PACKAGE_DIR}" COMPONENT dev)
install(FILES "${PROJECT_SOURCE_DIR}/LICENSE" "${PROJECT_SOURCE_DIR}/THIRD_PARTY" DESTINATION "${CMAKE_INSTALL_DOCDIR}"
        COMPONENT program)
# Each Debian package has its own copy, where Debian looks for it.
file(READ "${PROJECT_SOURCE_DIR}/THIRD_PARTY" third_party)
file(READ "${PROJECT_SOURCE_DIR}/LICENSE" license)
file(CONFIGURE OUTPUT "${CMAKE_BINARY_DIR}/copyright" @ONLY CONTENT "volccd, by the VolCCD authors, is under the Apache License 2.0, which stands \
below. (On Debian: /usr/share/common-licenses/Apache-2.0.)

@third_party@
@license@")
set(packages program:volccd dev:libvolccd-dev)
if(VOLCCD_BUILD_C)
  list(APPEND packages c:libvolccd-c)
endif()
if(VOLCCD_MPI AND VOLCCD_BUILD_PROGRAM)
  list(APPEND packages mpi:volccd-mpi)
endif()
if(TARGET volccd_python)
  list(APPEND packages python:python3-volccd)
endif()
foreach(package IN LISTS packages)
  string(REPLACE ":" ";" package "${package}")
  list(GET package 0 component)
  list(GET package 1 name)
  set(place "${CMAKE_INSTALL_DATADIR}/doc/${name}")
  if(component STREQUAL "python" AND "${VOLCCD_PYTHON_DIR}" STREQUAL ".")
    set(place volccd)  # a wheel has no doc/
  endif()
  install(FILES "${CMAKE_BINARY_DIR}/copyright" DESTINATION "${place}" COMPONENT ${component})
endforeach()
# Documents with the program, examples with what they use.
set(doc "${CMAKE_INSTALL_DATADIR}/doc")
install(DIRECTORY "${PROJECT_SOURCE_DIR}/docs" DESTINATION "${doc}/volccd" COMPONENT program FILES_MATCHING PATTERN "*.md"
        PATTERN "*.json")
foreach(example IN ITEMS c fortran solver custom_culling)
  install(DIRECTORY "${PROJECT_SOURCE_DIR}/examples/${example}" DESTINATION "${doc}/libvolccd-dev/examples" COMPONENT dev)
endforeach()
if(TARGET volccd_python AND NOT "${VOLCCD_PYTHON_DIR}" STREQUAL ".")
  install(DIRECTORY "${PROJECT_SOURCE_DIR}/examples/python" "${PROJECT_SOURCE_DIR}/examples/dolfinx"
          DESTINATION "${doc}/python3-volccd/examples" COMPONENT python)
endif()

# pkg-config: volccd.pc, for builds without CMake. Users of a static library also link the libraries that it needs
# (--static).
set(modules volccd_io volccd_distributed volccd_pipelines volccd_narrowphase volccd_culling volccd_broadphase volccd_query volccd_mesh volccd_numerics
    volccd_core)
set(VOLCCD_PC_PRIVATE_LIBS "")
if(VOLCCD_WITH_HDF5)
  list(GET HDF5_C_LIBRARIES 0 hdf5)  # a shared library is linked with the libraries that it needs
  string(APPEND VOLCCD_PC_PRIVATE_LIBS " ${hdf5}")
endif()
if(VOLCCD_WITH_GMP)
  string(APPEND VOLCCD_PC_PRIVATE_LIBS " -lgmp")
endif()
list(TRANSFORM modules PREPEND "-l")
list(JOIN modules " " VOLCCD_PC_LIBS)
configure_file("${CMAKE_CURRENT_LIST_DIR}/volccd.pc.in" "${CMAKE_BINARY_DIR}/cmake/volccd.pc" @ONLY)
install(FILES "${CMAKE_BINARY_DIR}/cmake/volccd.pc" DESTINATION "${CMAKE_INSTALL_LIBDIR}/pkgconfig" COMPONENT dev)
