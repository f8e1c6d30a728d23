# cmake -DSOURCE=folder -DOUTPUT=header -P Commit.cmake: writes the commit that `folder` is at, "-dirty" behind it where files
# differ from it. Run at every build, so that records name the commit that was built; the header changes only with it.
execute_process(COMMAND git describe --always --dirty --abbrev=12 --exclude=* WORKING_DIRECTORY "${SOURCE}"
                OUTPUT_VARIABLE commit OUTPUT_STRIP_TRAILING_WHITESPACE ERROR_QUIET)
if(NOT commit)
  set(commit "unknown")
endif()
file(CONFIGURE OUTPUT "${OUTPUT}" CONTENT "#define VOLCCD_COMMIT \"${commit}\"\n")
