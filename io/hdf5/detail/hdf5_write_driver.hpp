// An HDF5 file driver that turns a full disk into an error of this library instead of a crash of HDF5.
#pragma once

#include <volccd/io/hdf5/detail/hdf5_id.hpp>

namespace volccd::detail {

/// File access property list for a driver that writes a file as H5FD_SEC2 does, but reports no write failures to HDF5:
/// a write that the system refuses appears successful, and `error`, which must outlive the file, receives the first
/// errno. HDF5 1.10 cannot close a file whose buffers cannot be written, and crashes at the end of the process. With
/// this driver the file can be closed; the caller checks `error` after each call and discards the file. Returns an
/// invalid identifier if HDF5 refuses.
Hdf5Id write_driver_access(int* error);

}  // namespace volccd::detail
