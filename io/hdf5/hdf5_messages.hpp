// Control of the messages that HDF5 prints itself.
#pragma once

namespace volccd {

/// For programs, to be called before they open a file: HDF5 prints nothing on stderr from then on, neither errors of
/// the calling thread nor "infinite loop closing library" at the end of the process. HDF5 prints the latter after a
/// damaged file was opened, because HDF5 1.10 cannot release its internal blocks after it fails to load an object. The
/// functions of this library never print, and do not change the setting.
void turn_off_hdf5_messages();

}  // namespace volccd
