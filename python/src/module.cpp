#include "bind.hpp"

#include <volccd/io/build_facts.hpp>
#include <volccd/io/hdf5/hdf5_messages.hpp>

PYBIND11_MODULE(_core, module) {
  using namespace volccd::python;
  volccd::turn_off_hdf5_messages();
  module.doc() = "The compiled part of volccd. Use the package volccd: its interface is stable, this one is not.";
  module.attr("__version__") = volccd::build_facts().version;
  bind_errors(module);
  bind_cells(module);
  bind_results(module);
  bind_registry(module);
  bind_detector(module);
  bind_distributed(module);
  bind_sequence(module);
  bind_scenes(module);
  bind_verify(module);
  bind_program(module);
}
