// The registry of the process: the library's stages, those of other libraries, and those registered in Python.
#pragma once

#include <volccd/pipelines/registry.hpp>

#include "bind.hpp"

namespace volccd::python {

/// Must be called with the GIL held. A registration changes the registry; copies may be used and destroyed without the
/// GIL.
const Registry& registry();

}  // namespace volccd::python
