# Headers of other projects that nearly all sources include, read once for each kind of target instead of once for each
# source. Nothing of this project is among them.
option(VOLCCD_PRECOMPILE "Precompile the headers of the standard library, Eigen, fmt and GoogleTest: less processor time for a build from nothing" OFF)

set(VOLCCD_PRECOMPILED algorithm array atomic cmath cstdint functional limits map memory numeric optional ranges set span
  string string_view tuple utility vector Eigen/Geometry fmt/format.h)

# volccd_precompile(target kind [OPTIONS option...] [LIBRARIES lib...] [HEADERS header...]): targets of one kind share one
# precompiled header, so that all of them must be compiled with the same OPTIONS, and be all libraries or all programs.
# The names of the kinds of programs begin with "test". Other options of the targets may differ where the compiler accepts it;
# otherwise it gives a warning (-Winvalid-pch).
function(volccd_precompile target kind)
  if(NOT VOLCCD_PRECOMPILE)
    return()
  endif()
  cmake_parse_arguments(ARG "" "" "OPTIONS;LIBRARIES;HEADERS" ${ARGN})
  set(owner "volccd_headers_of_${kind}")
  if(NOT TARGET ${owner})
    set(source "${CMAKE_BINARY_DIR}/precompiled/main.cpp")
    file(CONFIGURE OUTPUT "${source}" CONTENT "int main() { return 0; }\n")
    if(kind MATCHES "^test")
      add_executable(${owner} "${source}")
    else()
      add_library(${owner} STATIC "${source}")
    endif()
    target_compile_features(${owner} PRIVATE cxx_std_20)
    # without times, so that compiler caches find what is compiled with it
    target_compile_options(${owner} PRIVATE -ffp-contract=off ${ARG_OPTIONS}
      $<$<CXX_COMPILER_ID:Clang>:SHELL:-Xclang -fno-pch-timestamp>)
    target_link_libraries(${owner} PRIVATE volccd_flags Eigen3::Eigen fmt::fmt ${ARG_LIBRARIES})
    list(TRANSFORM VOLCCD_PRECOMPILED REPLACE ".+" "<\\0>" OUTPUT_VARIABLE headers)
    target_precompile_headers(${owner} PRIVATE ${headers} ${ARG_HEADERS})
  endif()
  target_precompile_headers(${target} REUSE_FROM ${owner})
endfunction()
