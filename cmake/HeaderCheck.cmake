# Target header_check: each public header of the library, alone in a source file, through the compiler's front end. Not part
# of `all`; `scripts/test` without --quick builds it.
set(stubs)
foreach(module core mesh query mesh/sequence broadphase culling narrowphase pipelines)
  file(GLOB headers CONFIGURE_DEPENDS "${PROJECT_SOURCE_DIR}/${module}/*.hpp")
  list(FILTER headers EXCLUDE REGEX "-inl\\.hpp$")  # for sources that set the instruction set
  foreach(header IN LISTS headers)
    file(RELATIVE_PATH path "${PROJECT_SOURCE_DIR}" "${header}")
    set(stub "${CMAKE_BINARY_DIR}/header_check/${path}.cpp")
    # Twice: the second time checks the include guard.
    file(CONFIGURE OUTPUT "${stub}" CONTENT "#include <volccd/${path}>\n#include <volccd/${path}>\n")
    list(APPEND stubs "${stub}")
  endforeach()
endforeach()

add_library(header_check OBJECT EXCLUDE_FROM_ALL ${stubs})
target_compile_options(header_check PRIVATE -O0 -fsyntax-only)
target_link_libraries(header_check PRIVATE volccd volccd_flags)
set_target_properties(header_check PROPERTIES UNITY_BUILD OFF)  # alone is the point
