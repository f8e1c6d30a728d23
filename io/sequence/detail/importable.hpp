// Files of other programs in the place of a sequence.
#pragma once

#include <string>

namespace volccd::detail {

/// The command that makes a sequence of a mesh or result of another program, as its name says what it is: .vtu, .msh,
/// .inp, .pvd, .xdmf, .e, .exo, .k, d3plot and others. Empty for all other names. Reads nothing.
std::string import_command(const std::string& file);

/// Throws InputError with that command if the file exists, has such a name, and is no VTKHDF.
void refuse_importable(const std::string& file);

}  // namespace volccd::detail
