// Real sequences that are not part of the project.
#pragma once

#include <string>

namespace volccd {

/// Path of a file in the folder that the environment variable VOLCCD_DATA names, else in ../shared/data beside the
/// project's sources. The file need not exist.
std::string shared_data_path(const std::string& name);

}  // namespace volccd
