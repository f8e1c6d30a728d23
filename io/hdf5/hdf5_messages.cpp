#include <volccd/io/hdf5/hdf5_messages.hpp>

#include <hdf5.h>

namespace volccd {

void turn_off_hdf5_messages() { H5Eset_auto2(H5E_DEFAULT, nullptr, nullptr); }

}  // namespace volccd
