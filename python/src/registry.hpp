// The registry of the process: the library's stages, those of other libraries, and those registered in Python.
#pragma once

#include <string>
#include <vector>

#include <volccd/pipelines/registry.hpp>

#include "bind.hpp"

namespace volccd::python {

/// Must be called with the GIL held. A registration changes the registry; copies may be used and destroyed without the
/// GIL.
const Registry& registry();

/// A registered pipeline with changes in the form of `--set`. Throws ConfigError.
PipelineSpec make_spec(const Registry& registry, const std::string& pipeline, const std::vector<std::string>& settings);

}  // namespace volccd::python
