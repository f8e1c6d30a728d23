// The whole program, with the stages registered in Python.
#include <csignal>
#include <vector>

#include <pybind11/stl.h>

#include <volccd/program/program.hpp>

#include "bind.hpp"
#include "registry.hpp"

namespace volccd::python {

namespace {

/// The program sets its own signal handlers while it works; afterwards those of Python are restored.
class SignalsKept {
 public:
  SignalsKept() {
    for (Kept& one : kept_) sigaction(one.signal, nullptr, &one.action);
  }
  ~SignalsKept() {
    for (const Kept& one : kept_) sigaction(one.signal, &one.action, nullptr);
  }
  SignalsKept(const SignalsKept&) = delete;
  SignalsKept& operator=(const SignalsKept&) = delete;

 private:
  struct Kept {
    int signal;
    struct sigaction action;
  };
  Kept kept_[3] = {{SIGINT, {}}, {SIGTERM, {}}, {SIGXFSZ, {}}};
};

int run_program(const std::vector<std::string>& arguments) {
  std::vector<const char*> argv{"volccd"};
  for (const std::string& argument : arguments) argv.push_back(argument.c_str());
  argv.push_back(nullptr);
  const Registry stages = registry();  // a copy, so that a registration by another thread changes nothing here
  const SignalsKept signals;
  const py::gil_scoped_release without_gil;
  return program(static_cast<int>(argv.size()) - 1, argv.data(), stages);
}

}  // namespace

void bind_program(py::module_& module) { module.def("main", &run_program); }

}  // namespace volccd::python
