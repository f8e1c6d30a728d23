# Install rules and find_package(volccd) for other projects. The package holds the libraries and their headers; the program
# is installed beside them where it is built. The oracles and the experiments are not part of it.
include(CMakePackageConfigHelpers)

set(VOLCCD_PACKAGE_DIR "${CMAKE_INSTALL_LIBDIR}/cmake/volccd")

install(EXPORT volccdTargets NAMESPACE volccd:: DESTINATION "${VOLCCD_PACKAGE_DIR}")

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

if(TARGET volccd_program)
  install(TARGETS volccd_program RUNTIME DESTINATION "${CMAKE_INSTALL_BINDIR}")
endif()
