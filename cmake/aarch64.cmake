# Cross-compiler of Debian for AArch64 (preset `aarch64`, scripts/test_aarch64). Programs run in QEMU's emulation of the
# processor. The libraries for AArch64 are in VOLCCD_AARCH64_ROOT; what consists of headers alone is that of this machine.
set(CMAKE_SYSTEM_NAME Linux)
set(CMAKE_SYSTEM_PROCESSOR aarch64)
set(CMAKE_C_COMPILER aarch64-linux-gnu-gcc)
set(CMAKE_CXX_COMPILER aarch64-linux-gnu-g++)
set(CMAKE_Fortran_COMPILER NOTFOUND)  # instead of that of this machine
set(CMAKE_TRY_COMPILE_PLATFORM_VARIABLES VOLCCD_AARCH64_ROOT)

if(NOT IS_DIRECTORY "${VOLCCD_AARCH64_ROOT}/usr/lib/aarch64-linux-gnu")
  message(FATAL_ERROR "VOLCCD_AARCH64_ROOT is '${VOLCCD_AARCH64_ROOT}', where there are no libraries for AArch64: \
scripts/test_aarch64 puts them there")
endif()
set(CMAKE_FIND_ROOT_PATH "${VOLCCD_AARCH64_ROOT}")
set(CMAKE_FIND_ROOT_PATH_MODE_PROGRAM NEVER)
set(CMAKE_FIND_ROOT_PATH_MODE_LIBRARY ONLY)
set(CMAKE_FIND_ROOT_PATH_MODE_INCLUDE BOTH)
set(CMAKE_FIND_ROOT_PATH_MODE_PACKAGE BOTH)
set(CMAKE_CROSSCOMPILING_EMULATOR qemu-aarch64-static -L /usr/aarch64-linux-gnu)
