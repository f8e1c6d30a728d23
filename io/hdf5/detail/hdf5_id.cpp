#include <volccd/io/hdf5/detail/hdf5_id.hpp>

namespace volccd::detail {

bool Hdf5Id::reset() {
  if (id_ < 0) return true;
  const QuietHdf5 quiet;
  return close_(std::exchange(id_, -1)) >= 0;
}

QuietHdf5::QuietHdf5() {
  H5Eget_auto2(H5E_DEFAULT, &handler_, &data_);
  H5Eset_auto2(H5E_DEFAULT, nullptr, nullptr);
}

QuietHdf5::~QuietHdf5() { H5Eset_auto2(H5E_DEFAULT, handler_, data_); }

std::string hdf5_reason() {
  std::string text;
  const auto take_first = [](unsigned, const H5E_error2_t* entry, void* out) -> herr_t {
    std::string& first = *static_cast<std::string*>(out);
    if (first.empty() && entry->desc) first = entry->desc;
    return 0;
  };
  H5Ewalk2(H5E_DEFAULT, H5E_WALK_UPWARD, take_first, &text);
  return text.empty() ? text : " (HDF5: " + text + ")";
}

}  // namespace volccd::detail
