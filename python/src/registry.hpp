// The registry of the process: the library's stages, those of other libraries, and those registered from Python.
#pragma once

#include <string>
#include <vector>

#include <volccd/pipelines/registry.hpp>

#include "bind.hpp"

namespace volccd::python {

/// With the GIL held; changes at a registration. Copies of it may be used and destroyed without the GIL.
const Registry& registry();

/// A registered pipeline, changed by settings as of `--set`. Throws ConfigError.
PipelineSpec make_spec(const Registry& registry, const std::string& pipeline, const std::vector<std::string>& settings);

}  // namespace volccd::python
