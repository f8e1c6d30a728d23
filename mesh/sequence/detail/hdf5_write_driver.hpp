// How HDF5 writes a file: so that a full disk is an error of ours, not a crash of HDF5's.
#pragma once

#include <volccd/mesh/sequence/detail/hdf5_id.hpp>

namespace volccd::detail {

/// File access property list of a driver that writes a file as H5FD_SEC2 does, but hides failures from HDF5: a write
/// that the system refuses counts as done, and `error`, which must outlive the file, receives the first errno.
/// HDF5 1.10 cannot close a file whose buffers cannot be written, and crashes when the process ends; here it closes,
/// and the caller, who looks at `error` after each call, throws the file away. Invalid if HDF5 refuses.
Hdf5Id write_driver_access(int* error);

}  // namespace volccd::detail
