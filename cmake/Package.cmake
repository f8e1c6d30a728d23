# find_package(volccd) for other projects.
include(CMakePackageConfigHelpers)
