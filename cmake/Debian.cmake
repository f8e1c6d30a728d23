# Debian packages by CPack, one for each component: `cpack -G DEB --config build/release/CPackConfig.cmake -B
# build/packages`.
#   volccd           the program, importer and plots
#   libvolccd-dev    headers, libraries, CMake and pkg-config files, the component `program` included
#   libvolccd-c      the shared library for C
#   volccd-mpi       the program volccd-mpi, where MPI is there
#   python3-volccd   the Python module, where it is built
set(CPACK_PACKAGE_NAME volccd)
set(CPACK_PACKAGE_CONTACT "The VolCCD authors <volccd@localhost>")
set(CPACK_PACKAGE_DESCRIPTION_SUMMARY "${PROJECT_DESCRIPTION}")
set(CPACK_RESOURCE_FILE_LICENSE "${PROJECT_SOURCE_DIR}/LICENSE")
set(CPACK_PACKAGING_INSTALL_PREFIX /usr)
set(CPACK_STRIP_FILES ON)
set(CPACK_DEB_COMPONENT_INSTALL ON)
set(CPACK_DEBIAN_FILE_NAME DEB-DEFAULT)
set(CPACK_DEBIAN_PACKAGE_SECTION science)

set(CPACK_DEBIAN_PROGRAM_PACKAGE_NAME volccd)
set(CPACK_DEBIAN_PROGRAM_PACKAGE_SHLIBDEPS ON)
set(CPACK_DEBIAN_PROGRAM_PACKAGE_RECOMMENDS "fonts-dejavu-core, python3-meshio, python3-h5py, python3-matplotlib")
set(CPACK_DEBIAN_PROGRAM_PACKAGE_SUGGESTS "python3-netcdf4, python3-vtk9")
set(CPACK_COMPONENT_PROGRAM_DESCRIPTION "The program volccd, the importer of meshes and sequences, and figures of records.")

set(CPACK_DEBIAN_DEV_PACKAGE_NAME libvolccd-dev)
set(CPACK_DEBIAN_DEV_PACKAGE_SECTION libdevel)
set(depends libeigen3-dev libfmt-dev libtbb-dev libhwy-dev)
if(VOLCCD_WITH_HDF5)
  list(APPEND depends libhdf5-dev)
endif()
if(VOLCCD_WITH_GMP)
  list(APPEND depends libgmp-dev)
endif()
if(VOLCCD_BUILD_C)
  set(CPACK_DEBIAN_C_PACKAGE_NAME libvolccd-c)
  set(CPACK_DEBIAN_C_PACKAGE_SECTION libs)
  set(CPACK_DEBIAN_C_PACKAGE_SHLIBDEPS ON)
  set(CPACK_COMPONENT_C_DESCRIPTION "The shared library for C and Fortran.")
  list(APPEND depends "libvolccd-c (= ${PROJECT_VERSION})")
endif()
if(BUILD_SHARED_LIBS)
  set(CPACK_DEBIAN_MPI_PACKAGE_DEPENDS "volccd (= ${PROJECT_VERSION})")
  list(APPEND depends "volccd (= ${PROJECT_VERSION})")
endif()
list(JOIN depends ", " CPACK_DEBIAN_DEV_PACKAGE_DEPENDS)
set(CPACK_DEBIAN_DEV_PACKAGE_RECOMMENDS "libfcl-dev, libccd-dev, libpng-dev, zlib1g-dev, libcairo2-dev")
set(CPACK_COMPONENT_DEV_DESCRIPTION
  "Headers and libraries: for solvers, and for projects with stages of their own (CMake component program).")

set(CPACK_DEBIAN_MPI_PACKAGE_NAME volccd-mpi)
set(CPACK_DEBIAN_MPI_PACKAGE_SECTION science)
set(CPACK_DEBIAN_MPI_PACKAGE_SHLIBDEPS ON)
set(CPACK_DEBIAN_MPI_PACKAGE_RECOMMENDS "openmpi-bin")
set(CPACK_COMPONENT_MPI_DESCRIPTION "The program volccd-mpi: contacts by several processes.")

set(CPACK_DEBIAN_PYTHON_PACKAGE_NAME python3-volccd)
set(CPACK_DEBIAN_PYTHON_PACKAGE_SECTION python)
set(CPACK_DEBIAN_PYTHON_PACKAGE_SHLIBDEPS ON)
set(CPACK_DEBIAN_PYTHON_PACKAGE_DEPENDS "python3, python3-numpy")
if(TARGET volccd_python)
  # An extension module works with one minor version of Python.
  execute_process(COMMAND "${VOLCCD_PYTHON}" -c "import sys; print(*sys.version_info[:2], sys.version_info[1] + 1)"
                  OUTPUT_VARIABLE versions OUTPUT_STRIP_TRAILING_WHITESPACE COMMAND_ERROR_IS_FATAL ANY)
  string(REGEX REPLACE "(.*) (.*) (.*)" "python3 (>= \\1.\\2), python3 (<< \\1.\\3), python3-numpy"
         CPACK_DEBIAN_PYTHON_PACKAGE_DEPENDS "${versions}")
endif()
set(CPACK_COMPONENT_PYTHON_DESCRIPTION "The Python module volccd.")

include(CPack)
