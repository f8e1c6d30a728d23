# Install rules and find_package(volccd) for other projects. The package holds the libraries and their headers. Where the
# program is built, it is installed too, and so is the component `program`: the program as a library, with all that it links.
include(CMakePackageConfigHelpers)

set(VOLCCD_PACKAGE_DIR "${CMAKE_INSTALL_LIBDIR}/cmake/volccd")

install(EXPORT volccdTargets NAMESPACE volccd:: DESTINATION "${VOLCCD_PACKAGE_DIR}")
if(VOLCCD_BUILD_PROGRAM)
  # A package without this file refuses the component (volccdConfig.cmake).
  install(EXPORT volccdProgramTargets NAMESPACE volccd:: DESTINATION "${VOLCCD_PACKAGE_DIR}")
  install(TARGETS volccd_executable RUNTIME DESTINATION "${CMAKE_INSTALL_BINDIR}")
endif()

get_property(headers GLOBAL PROPERTY VOLCCD_HEADERS)
get_property(folders GLOBAL PROPERTY VOLCCD_HEADER_FOLDERS)
install(CODE "
  set(VOLCCD_HEADERS \"${headers}\")
  set(VOLCCD_HEADER_FOLDERS \"${folders}\")
  set(VOLCCD_SOURCE_DIR \"${PROJECT_SOURCE_DIR}\")
  set(VOLCCD_HEADER_DESTINATION \"${CMAKE_INSTALL_INCLUDEDIR}/volccd\")
  include(\"${CMAKE_CURRENT_LIST_DIR}/InstallHeaders.cmake\")")

configure_package_config_file(
  "${CMAKE_CURRENT_LIST_DIR}/volccdConfig.cmake.in" "${CMAKE_BINARY_DIR}/cmake/volccdConfig.cmake"
  INSTALL_DESTINATION "${VOLCCD_PACKAGE_DIR}"
  NO_SET_AND_CHECK_MACRO)
# Before 1.0 a minor version may break the interface.
write_basic_package_version_file("${CMAKE_BINARY_DIR}/cmake/volccdConfigVersion.cmake" COMPATIBILITY SameMinorVersion)

install(FILES "${CMAKE_BINARY_DIR}/cmake/volccdConfig.cmake" "${CMAKE_BINARY_DIR}/cmake/volccdConfigVersion.cmake"
              "${CMAKE_CURRENT_LIST_DIR}/FindGMP.cmake"
        DESTINATION "${VOLCCD_PACKAGE_DIR}")
install(FILES "${PROJECT_SOURCE_DIR}/LICENSE" DESTINATION "${CMAKE_INSTALL_DOCDIR}")
