# cmake -DSOURCE=folder -DOUTPUT=header -P Commit.cmake: writes the commit of `folder` to a header, with "-dirty"
# appended if files differ from it. Runs at every build, so that records name the commit that was built. The header is
# changed only when the commit changes.
execute_process(COMMAND git describe --always --dirty --abbrev=12 --exclude=* WORKING_DIRECTORY "${SOURCE}"
                OUTPUT_VARIABLE commit OUTPUT_STRIP_TRAILING_WHITESPACE ERROR_QUIET)
if(NOT commit)
  set(commit "unknown")
endif()
file(CONFIGURE OUTPUT "${OUTPUT}" CONTENT "#define VOLCCD_COMMIT \"${commit}\"\n")
