# Module libraries, and the include path <volccd/...> of a source tree whose folders are the modules.

# A link makes <volccd/mesh/mesh.hpp> available, because headers are in the same folders as their sources.
set(VOLCCD_INCLUDE_DIR "${CMAKE_BINARY_DIR}/include")
file(MAKE_DIRECTORY "${VOLCCD_INCLUDE_DIR}")
file(CREATE_LINK "${CMAKE_SOURCE_DIR}" "${VOLCCD_INCLUDE_DIR}/volccd" SYMBOLIC)

# Warnings and floating-point rules for all code of the project. Contraction into fused multiply-add would make
# rounding, and with it the error bounds, depend on the machine.
# GCC 12 gives false warnings for `"text" + std::string` (GCC bug 105651).
add_library(volccd_flags INTERFACE)
target_compile_options(volccd_flags INTERFACE
  -Wall -Wextra -Wpedantic -Wshadow -Wnon-virtual-dtor -Woverloaded-virtual
  $<$<AND:$<CXX_COMPILER_ID:GNU>,$<VERSION_LESS:$<CXX_COMPILER_VERSION>,13>>:-Wno-restrict>
  $<$<BOOL:${VOLCCD_WERROR}>:-Werror>)
set(VOLCCD_KERNEL_OPTIONS)
if(CMAKE_SYSTEM_PROCESSOR MATCHES "^(aarch64|arm64)$" AND CMAKE_CXX_COMPILER_ID STREQUAL "GNU")
  target_compile_options(volccd_flags INTERFACE -Wno-psabi)  # notes on an ABI before GCC 10.1
  # Highway's functions for NEON are compiled for processors with AES, which the kernels do not use. GCC cannot inline
  # them into implicit constructors, which are compiled for what the command line names.
  if(NOT CMAKE_CXX_FLAGS MATCHES "-m(arch|cpu)=")
    set(VOLCCD_KERNEL_OPTIONS -march=armv8-a+crypto)
  endif()
endif()

# By default GCC collects garbage from 128 MB on, a sixth of the time of a build with precompiled headers.
# With these it does so beyond 2 GB for each compiler process, where the machine has memory for a process for each core and
# two more, as Ninja starts. The compiled code is the same.
cmake_host_system_information(RESULT memory QUERY TOTAL_PHYSICAL_MEMORY)  # in MiB
cmake_host_system_information(RESULT cores QUERY NUMBER_OF_LOGICAL_CORES)
math(EXPR needed "2048 * (${cores} + 2)")
if(memory GREATER_EQUAL needed)
  target_compile_options(volccd_flags INTERFACE
    $<$<CXX_COMPILER_ID:GNU>:--param=ggc-min-heapsize=2000000>
    $<$<CXX_COMPILER_ID:GNU>:--param=ggc-min-expand=1000>)
endif()

# volccd_quick_to_compile(target): for code whose own speed does not matter (tests, command lines). Compiles in a third
# less time.
function(volccd_quick_to_compile target)
  target_compile_options(${target} PRIVATE $<$<CONFIG:Release>:-O1>)
endfunction()

# volccd_not_fuzzed(target [UNOPTIMISED]): for code that no fuzzer runs: libFuzzer's coverage, which checks nothing, is left
# out. UNOPTIMISED: for code that the address sanitizer's tests run little of, half the time to compile it there.
function(volccd_not_fuzzed target)
  cmake_parse_arguments(ARG "UNOPTIMISED" "" "" ${ARGN})
  if(CMAKE_BUILD_TYPE STREQUAL "None" AND CMAKE_CXX_COMPILER_ID STREQUAL "Clang")
    set(kind not_fuzzed)
    set(options -fno-sanitize=fuzzer-no-link)
    if(ARG_UNOPTIMISED)
      set(kind not_fuzzed_unoptimised)
      list(APPEND options -O0)
    endif()
    target_compile_options(${target} PRIVATE ${options})
    set_target_properties(${target} PROPERTIES VOLCCD_KIND ${kind} VOLCCD_KIND_OPTIONS "${options}")
  endif()
endfunction()

# volccd_precompile_module(target): called when the other functions have set the options of the module.
function(volccd_precompile_module target)
  set(kind modules)
  set(options)
  get_target_property(set_kind ${target} VOLCCD_KIND)
  if(set_kind)
    set(kind ${set_kind})
    get_target_property(options ${target} VOLCCD_KIND_OPTIONS)
  endif()
  volccd_precompile(${target} ${kind} OPTIONS ${options})
endfunction()

# volccd_module(mesh [PUBLIC lib...] [PRIVATE lib...] [SOURCES file...]): library volccd_mesh of all sources in this folder and
# below, exported as volccd::mesh with all headers outside of detail/ and what these include (InstallHeaders.cmake).
# volccd_module(program COMPONENT program [HEADERS file...] ...): a part of the package's component `program`, whose users
# alone need what it links. Of its headers, HEADERS and what these include are installed. `mpi` is another component.
# volccd_module(peers INTERNAL ...): not installed; only for private use by the program's executable and the tests.
function(volccd_module name)
  cmake_parse_arguments(ARG "INTERNAL" "COMPONENT" "PUBLIC;PRIVATE;SOURCES;HEADERS" ${ARGN})
  if(NOT ARG_SOURCES)
    file(GLOB_RECURSE ARG_SOURCES CONFIGURE_DEPENDS "${CMAKE_CURRENT_SOURCE_DIR}/*.cpp")
  endif()
  # The undefined-behaviour sanitizer finds little in vector kernels (no integers, no branches), and takes minutes to
  # compile them. With clang's address sanitizer, checks are function calls, because one source takes two minutes with
  # inline checks.
  foreach(source IN LISTS ARG_SOURCES)
    file(STRINGS "${source}" kernels REGEX "foreach_target" LIMIT_COUNT 1)
    if(kernels)
      # a source includes itself once for each instruction set
      set_property(SOURCE "${source}" PROPERTY SKIP_UNITY_BUILD_INCLUSION ON)
      if(VOLCCD_KERNEL_OPTIONS)
        set_property(SOURCE "${source}" PROPERTY SKIP_PRECOMPILE_HEADERS ON)  # which were compiled without these options
        set_property(SOURCE "${source}" APPEND PROPERTY COMPILE_OPTIONS ${VOLCCD_KERNEL_OPTIONS})
      endif()
      set_property(SOURCE "${source}" APPEND PROPERTY COMPILE_OPTIONS -fno-sanitize=undefined
                   $<$<CXX_COMPILER_ID:Clang>:-mllvm>
                   $<$<CXX_COMPILER_ID:Clang>:-asan-instrumentation-with-call-threshold=0>)
    endif()
  endforeach()
  set(target "volccd_${name}")
  if(ARG_INTERNAL OR ARG_COMPONENT)
    add_library(${target} STATIC ${ARG_SOURCES})
  else()
    add_library(${target} ${ARG_SOURCES})  # static, or shared with BUILD_SHARED_LIBS
    set_target_properties(${target} PROPERTIES VERSION ${PROJECT_VERSION}
      SOVERSION ${PROJECT_VERSION_MAJOR}.${PROJECT_VERSION_MINOR}  # before 1.0 a minor version may break the interface
      DEFINE_SYMBOL "")
  endif()
  add_library(volccd::${name} ALIAS ${target})
  set_target_properties(${target} PROPERTIES EXPORT_NAME ${name})
  target_compile_features(${target} PUBLIC cxx_std_20)
  target_compile_options(${target} PUBLIC -ffp-contract=off)
  target_include_directories(${target} PUBLIC
    $<BUILD_INTERFACE:${VOLCCD_INCLUDE_DIR}>
    $<INSTALL_INTERFACE:${CMAKE_INSTALL_INCLUDEDIR}>)
  target_link_libraries(${target} PUBLIC ${ARG_PUBLIC} PRIVATE ${ARG_PRIVATE} $<BUILD_INTERFACE:volccd_flags>)
  cmake_language(EVAL CODE "cmake_language(DEFER CALL volccd_precompile_module ${target})")
  if(ARG_INTERNAL)
    return()
  endif()
  file(RELATIVE_PATH folder "${CMAKE_SOURCE_DIR}" "${CMAKE_CURRENT_SOURCE_DIR}")
  if(ARG_COMPONENT STREQUAL "program")
    # Experiments and oracle use the address sanitizer only, which halves their time to compile under sanitizers.
    target_compile_options(${target} PRIVATE -fno-sanitize=undefined)
    if(VOLCCD_BUILD_PROGRAM)
      install(TARGETS ${target} EXPORT volccdProgramTargets ARCHIVE DESTINATION ${CMAKE_INSTALL_LIBDIR} COMPONENT dev)
    endif()
    list(TRANSFORM ARG_HEADERS PREPEND "${folder}/")
    set_property(GLOBAL APPEND PROPERTY VOLCCD_HEADERS ${ARG_HEADERS})
  elseif(ARG_COMPONENT STREQUAL "mpi")
    install(TARGETS ${target} EXPORT volccdMpiTargets ARCHIVE DESTINATION ${CMAKE_INSTALL_LIBDIR} COMPONENT dev)
    list(TRANSFORM ARG_HEADERS PREPEND "${folder}/")
    set_property(GLOBAL APPEND PROPERTY VOLCCD_HEADERS ${ARG_HEADERS})
  else()
    install(TARGETS ${target} EXPORT volccdTargets
      ARCHIVE DESTINATION ${CMAKE_INSTALL_LIBDIR} COMPONENT dev
      LIBRARY DESTINATION ${CMAKE_INSTALL_LIBDIR} COMPONENT program NAMELINK_COMPONENT dev)
    set_property(GLOBAL APPEND PROPERTY VOLCCD_HEADER_FOLDERS ${folder})
    file(GLOB rooms LIST_DIRECTORIES ON RELATIVE "${CMAKE_SOURCE_DIR}" "${CMAKE_CURRENT_SOURCE_DIR}/*")
    foreach(room IN LISTS rooms)
      if(IS_DIRECTORY "${CMAKE_SOURCE_DIR}/${room}" AND NOT room MATCHES "/(detail|tables|mpi)$"
         AND (VOLCCD_WITH_HDF5 OR NOT room MATCHES "^io/"))
        set_property(GLOBAL APPEND PROPERTY VOLCCD_HEADER_FOLDERS ${room})
      endif()
    endforeach()
  endif()
endfunction()
