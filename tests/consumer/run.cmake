# cmake -DPART=... -DBUILD_DIR=... -DPROJECT_DIR=... -DWORK_DIR=... -DGENERATOR=... -DCXX=... -DCXX_FLAGS=... -DCPACK=...
#       -DBUILD_TYPE=... -P run.cmake
# The tests of the installed package. PART is one of:
#   install    installs the build into WORK_DIR/prefix, which the other parts use, and checks its files
#   consumer   builds and runs tests/consumer/, without the packages that only the component `program` needs
#   example    builds examples/custom_culling/, which asks for the component `program`
#   solver     builds examples/solver/ and runs it, without the packages that only the component `program` needs
#   refusals   asks for components that are not available, and checks the reason in the error message
#   headers    checks that each installed header compiles by itself
#   debian     makes the Debian packages, unpacks them into an empty root, and uses them: the program, the importer, and
#              tests/consumer/ with CMake and with pkg-config (python/tests/installed.py uses the Python module)
#   shared     builds and installs shared libraries, without HDF5 and GMP because that is less to build, and uses them
#              by CMake and by pkg-config
#   fresh      configures the project where only the packages that the program needs are there
#   lean       builds and installs the library without program, HDF5 and GMP, and uses it
cmake_policy(VERSION 3.22)
set(PREFIX "${WORK_DIR}/prefix")

function(run what)
  message(STATUS "${what}")
  execute_process(COMMAND ${ARGN} RESULT_VARIABLE code)
  if(NOT code EQUAL 0)
    message(FATAL_ERROR "${what}: failed with ${code}")
  endif()
endfunction()

# configure_command(variable source name [options...]): with the build folder WORK_DIR/name.
function(configure_command variable source name)
  file(REMOVE_RECURSE "${WORK_DIR}/${name}")
  set(${variable} "${CMAKE_COMMAND}" -S "${source}" -B "${WORK_DIR}/${name}" -G "${GENERATOR}"
      "-DCMAKE_CXX_COMPILER=${CXX}" "-DCMAKE_CXX_FLAGS=${CXX_FLAGS}" "-DCMAKE_BUILD_TYPE=${BUILD_TYPE}"
      -DCMAKE_FIND_USE_PACKAGE_REGISTRY=OFF "-DCMAKE_PREFIX_PATH=${PREFIX}" ${ARGN} PARENT_SCOPE)
endfunction()

function(build source name)
  configure_command(command "${source}" "${name}" ${ARGN})
  run("configure" ${command})
  run("build" "${CMAKE_COMMAND}" --build "${WORK_DIR}/${name}")
endfunction()

# use_by_pkg_config(name [options...]): builds and runs tests/consumer/ with the flags that pkg-config gives for PREFIX.
function(use_by_pkg_config name)
  set(ENV{PKG_CONFIG_PATH} "${PREFIX}/lib/pkgconfig")
  execute_process(COMMAND pkg-config ${ARGN} --cflags --libs volccd OUTPUT_VARIABLE flags RESULT_VARIABLE code)
  if(NOT code EQUAL 0)
    message(FATAL_ERROR "pkg-config does not find volccd")
  endif()
  separate_arguments(flags UNIX_COMMAND "${flags}")
  run("compile by pkg-config" "${CXX}" "${PROJECT_DIR}/tests/consumer/main.cpp" -o "${WORK_DIR}/${name}" ${flags})
  set(ENV{LD_LIBRARY_PATH} "${PREFIX}/lib")
  run("run" "${WORK_DIR}/${name}")
endfunction()

# The library without its optional parts, whether or not HDF5 and GMP are installed.
set(without -DCMAKE_DISABLE_FIND_PACKAGE_HDF5=ON -DCMAKE_DISABLE_FIND_PACKAGE_GMP=ON)
set(lean -DVOLCCD_WITH_HDF5=OFF -DVOLCCD_WITH_GMP=OFF ${without})

# install_library(name [options...]): builds the library alone and installs it into WORK_DIR/name. Without optimisation,
# which halves the time.
function(install_library name)
  build("${PROJECT_DIR}" "${name}-build" -DVOLCCD_BUILD_PROGRAM=OFF -DVOLCCD_BUILD_TESTS=OFF
        -DVOLCCD_BUILD_BENCHMARKS=OFF -DVOLCCD_SIMD=baseline -DCMAKE_UNITY_BUILD=ON -DCMAKE_UNITY_BUILD_BATCH_SIZE=16
        -DCMAKE_BUILD_TYPE=Debug -DCMAKE_CXX_FLAGS_DEBUG=-O0 ${ARGN})
  file(REMOVE_RECURSE "${WORK_DIR}/${name}")
  run("install" "${CMAKE_COMMAND}" --install "${WORK_DIR}/${name}-build" --prefix "${WORK_DIR}/${name}")
endfunction()

# write_project(folder component text): a project that asks for the component (empty: for none).
function(write_project folder component text)
  if(component)
    set(component "COMPONENTS ${component}")
  endif()
  file(WRITE "${WORK_DIR}/${folder}/CMakeLists.txt" "cmake_minimum_required(VERSION 3.22)
project(${folder} LANGUAGES CXX)
find_package(volccd REQUIRED ${component})
${text}")
endfunction()

# refuse(component message [options...]): configuring a project that asks for the component fails with the message.
function(refuse component expected)
  write_project(refused "${component}" "")
  configure_command(command "${WORK_DIR}/refused" refused-build ${ARGN})
  execute_process(COMMAND ${command} RESULT_VARIABLE code OUTPUT_QUIET ERROR_VARIABLE message)
  string(REGEX REPLACE "[ \n]+" " " message "${message}")
  string(FIND "${message}" "${expected}" position)
  if(code EQUAL 0 OR position EQUAL -1)
    message(FATAL_ERROR "component ${component}: exit code ${code}, and not '${expected}', but: ${message}")
  endif()
endfunction()

# Users of the package must not see folders of the source tree.
function(check_no_file_names_this_machine)
  file(GLOB_RECURSE scripts "${PREFIX}/*.cmake")
  foreach(script IN LISTS scripts)
    file(READ "${script}" text)
    foreach(folder "${BUILD_DIR}" "${PROJECT_DIR}")
      string(REPLACE "${WORK_DIR}" "" text "${text}")
      string(FIND "${text}" "${folder}" position)
      if(NOT position EQUAL -1)
        message(FATAL_ERROR "${script} names ${folder}: the package works on this machine only")
      endif()
    endforeach()
  endforeach()
endfunction()

# The library without the program does not require these packages.
foreach(package PNG fcl ccd CLI11 nlohmann_json)
  list(APPEND without_program "-DCMAKE_DISABLE_FIND_PACKAGE_${package}=ON")
endforeach()

file(GLOB_RECURSE headers RELATIVE "${PREFIX}/include" "${PREFIX}/include/*.hpp")
file(GLOB_RECURSE program_targets "${PREFIX}/*/volccdProgramTargets.cmake")

if(PART STREQUAL "install")
  file(REMOVE_RECURSE "${PREFIX}")  # and no other folders, because other parts of the test may be running
  run("install" "${CMAKE_COMMAND}" --install "${BUILD_DIR}" --prefix "${PREFIX}")
  check_no_file_names_this_machine()
elseif(PART STREQUAL "consumer")
  build("${PROJECT_DIR}/tests/consumer" consumer ${without_program})
  run("run" "${WORK_DIR}/consumer/consumer")
elseif(PART STREQUAL "solver")
  build("${PROJECT_DIR}/examples/solver" solver ${without_program})
  run("run" "${WORK_DIR}/solver/solver")
elseif(PART STREQUAL "example")
  build("${PROJECT_DIR}/examples/custom_culling" custom_culling)
elseif(PART STREQUAL "refusals")
  refuse(nonsense "volccd has no component 'nonsense'; there is program")
  refuse(program "volccd's component program needs fcl (Debian: libfcl-dev), which was not found"
         -DCMAKE_DISABLE_FIND_PACKAGE_fcl=ON)
  # A copy of the prefix without the targets file of the program is a package without the component.
  file(REMOVE_RECURSE "${WORK_DIR}/prefix-without-program")
  file(COPY "${PREFIX}/" DESTINATION "${WORK_DIR}/prefix-without-program" PATTERN "volccdProgramTargets*" EXCLUDE)
  set(PREFIX "${WORK_DIR}/prefix-without-program")
  refuse(program "this package of volccd was built without its component program")
elseif(PART STREQUAL "headers")
  # Each header is included twice, which checks its include guard. It is compiled to an object file, because a compiler
  # cache stores these and not the results of syntax checks.
  file(REMOVE_RECURSE "${WORK_DIR}/headers")
  foreach(header IN LISTS headers)
    file(WRITE "${WORK_DIR}/headers/${header}.cpp" "#include <${header}>\n#include <${header}>\n")
  endforeach()
  set(component)
  if(program_targets)
    set(component program)
  endif()
  write_project(headers "${component}" "
file(GLOB_RECURSE stubs \"\${CMAKE_CURRENT_SOURCE_DIR}/volccd/*.cpp\")
add_library(headers OBJECT \${stubs})
target_compile_options(headers PRIVATE -O0)
target_link_libraries(headers PRIVATE volccd::volccd)
if(TARGET volccd::program)
  target_link_libraries(headers PRIVATE volccd::program)
endif()\n")
  build("${WORK_DIR}/headers" headers-build)
  list(LENGTH headers count)
  message(STATUS "${count} headers")
elseif(PART STREQUAL "debian")
  set(root "${WORK_DIR}/root")
  file(REMOVE_RECURSE "${root}" "${WORK_DIR}/packages")
  run("make packages" "${CPACK}" -G DEB --config "${BUILD_DIR}/CPackConfig.cmake" -B "${WORK_DIR}/packages")
  file(GLOB packages RELATIVE "${WORK_DIR}/packages" "${WORK_DIR}/packages/*.deb")
  list(TRANSFORM packages REPLACE "_.*" "" OUTPUT_VARIABLE names)
  list(REMOVE_ITEM names python3-volccd)  # this package exists only if the Python module is built
  if(NOT names STREQUAL "libvolccd-dev;volccd")
    message(FATAL_ERROR "packages beside those of docs/installing.md: ${names}")
  endif()
  foreach(package IN LISTS packages)
    run("unpack ${package}" dpkg-deb -x "${WORK_DIR}/packages/${package}" "${root}")
  endforeach()
  run("program" "${root}/usr/bin/volccd" stages)
  run("scene" "${root}/usr/bin/volccd" scene generate builtin --elements 200 --steps 2 -o "${WORK_DIR}/run.vtkhdf")
  run("contacts" "${root}/usr/bin/volccd" detect "${WORK_DIR}/run.vtkhdf")
  if(EXISTS "${BUILD_DIR}/page")
    # The page must be found in this root, not in the build folder.
    file(APPEND "${root}/usr/share/volccd/report/index.html" "<!-- of the package -->")
    file(REMOVE_RECURSE "${WORK_DIR}/view")
    run("page" "${root}/usr/bin/volccd" view "${WORK_DIR}/run.vtkhdf" -o "${WORK_DIR}/view")
    file(READ "${WORK_DIR}/view/index.html" page)
    if(NOT page MATCHES "of the package")
      message(FATAL_ERROR "the program takes the report's page from another folder than its own")
    endif()
  endif()
  run("importer" "${root}/usr/bin/volccd-import" --help)
  run("plots" "${root}/usr/bin/volccd-plot" --help)
  set(PREFIX "${root}/usr")
  build("${PROJECT_DIR}/tests/consumer" consumer-of-packages)
  run("run" "${WORK_DIR}/consumer-of-packages/consumer")
  use_by_pkg_config(by_pkg_config --static)
elseif(PART STREQUAL "shared")
  install_library(shared -DBUILD_SHARED_LIBS=ON ${lean})
  set(PREFIX "${WORK_DIR}/shared")
  file(GLOB archives "${PREFIX}/lib/*.a")
  if(archives)
    message(FATAL_ERROR "static libraries among the shared ones: ${archives}")
  endif()
  build("${PROJECT_DIR}/tests/consumer" consumer-of-shared ${without_program} ${without})
  run("run" "${WORK_DIR}/consumer-of-shared/consumer")
  use_by_pkg_config(by_pkg_config_shared)
elseif(PART STREQUAL "fresh")
  foreach(package GTest rapidcheck benchmark embree Bullet)
    list(APPEND without_tests "-DCMAKE_DISABLE_FIND_PACKAGE_${package}=ON")
  endforeach()
  configure_command(command "${PROJECT_DIR}" fresh ${without_tests})
  execute_process(COMMAND ${command} RESULT_VARIABLE code OUTPUT_VARIABLE message ERROR_VARIABLE message)
  foreach(expected "Tests: not built: not found: GTest (Debian: libgtest-dev), rapidcheck (Debian: librapidcheck-dev)"
                   "Benchmarks: not built: not found: benchmark (Debian: libbenchmark-dev)" "Python module: built for")
    string(FIND "${message}" "${expected}" position)
    if(NOT code EQUAL 0 OR position EQUAL -1)
      message(FATAL_ERROR "exit code ${code}, and not '${expected}', but: ${message}")
    endif()
  endforeach()
elseif(PART STREQUAL "lean")
  install_library(lean ${lean})
  set(PREFIX "${WORK_DIR}/lean")
  build("${PROJECT_DIR}/tests/consumer" consumer-of-lean ${without_program} ${without})
  run("run" "${WORK_DIR}/consumer-of-lean/consumer")
  execute_process(COMMAND ldd "${WORK_DIR}/consumer-of-lean/consumer" OUTPUT_VARIABLE libraries)
  if(NOT libraries MATCHES "libtbb" OR libraries MATCHES "hdf5|gmp")
    message(FATAL_ERROR "HDF5 or GMP is needed all the same: ${libraries}")
  endif()
  use_by_pkg_config(by_pkg_config_lean --static)
else()
  message(FATAL_ERROR "no part '${PART}'")
endif()
