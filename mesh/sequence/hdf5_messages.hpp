// What HDF5 prints by itself.
#pragma once

namespace volccd {

/// For programs, before they open a file: from now on HDF5 prints nothing on stderr, neither errors of the calling
/// thread nor, at the end of the process, "infinite loop closing library". It prints the latter where a damaged file
/// has been opened: HDF5 1.10 loses blocks of its own when it fails to load an object, and cannot release them. The
/// functions of this library print nothing in any case, and leave the setting as it is.
void turn_off_hdf5_messages();

}  // namespace volccd
