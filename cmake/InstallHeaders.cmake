# Run by `cmake --install`: installs the headers of VOLCCD_HEADERS, those in VOLCCD_HEADER_FOLDERS, and all headers of
# the project that these include. Headers that only sources include are left out, because they may need packages that
# users do not have.
cmake_policy(VERSION 3.22)
set(pending ${VOLCCD_HEADERS})
foreach(folder IN LISTS VOLCCD_HEADER_FOLDERS)
  file(GLOB found RELATIVE "${VOLCCD_SOURCE_DIR}" "${VOLCCD_SOURCE_DIR}/${folder}/*.hpp")
  list(APPEND pending ${found})
endforeach()
set(installed)
while(pending)
  list(POP_FRONT pending header)
  if(header IN_LIST installed)
    continue()
  endif()
  list(APPEND installed "${header}")
  get_filename_component(folder "${header}" DIRECTORY)
  file(INSTALL DESTINATION "${CMAKE_INSTALL_PREFIX}/${VOLCCD_HEADER_DESTINATION}/${folder}" TYPE FILE
       FILES "${VOLCCD_SOURCE_DIR}/${header}")
  file(STRINGS "${VOLCCD_SOURCE_DIR}/${header}" includes REGEX "^ *# *include *<volccd/")
  list(TRANSFORM includes REPLACE ".*<volccd/([^>]+)>.*" "\\1")
  list(APPEND pending ${includes})
endwhile()
