// Stages written in Python as stages of the library.
#pragma once

#include <memory>

#include <volccd/pipelines/registry.hpp>

#include "bind.hpp"

namespace volccd::python {

/// Adds a class of volccd/_stages.py (ElementCulling, FeatureFilter or NarrowPhase) to the registry. Throws ConfigError
/// if its name is already used or its attributes are invalid. Must be called with the GIL held; the added stage takes
/// the GIL itself.
void add_stage(Registry& registry, const py::object& stage);

/// A Python object that may be copied and destroyed without the GIL.
class SharedObject {
 public:
  SharedObject() = default;
  /// The GIL must be held.
  explicit SharedObject(py::object object);
  /// For use with the GIL held.
  const py::object& get() const { return *object_; }
  explicit operator bool() const { return object_ != nullptr; }

 private:
  std::shared_ptr<py::object> object_;
};

/// The state of a stage in Python: the step as Python objects with copies of the arrays, so that a stage may keep them.
class PythonState final : public StageState {
 public:
  /// The GIL must be held.
  PythonState();

  /// Copies the step, and calls stage.prepare(step). Takes the GIL.
  void prepare(const Step& step, const SharedObject& stage);
  /// The GIL must be held.
  const py::object& step() const { return step_.get(); }
  std::size_t bytes() const override { return bytes_; }

 private:
  void set_elements(const Mesh& mesh);

  SharedObject step_;
  std::uint64_t version_ = 0;  ///< version of the topology whose elements the step has
  std::size_t bytes_ = 0;
};

/// The values that a stage returned for `n` pairs or tests, as uint8; they must be an array [n] of bool, or of integers
/// from 0 to 2. Throws ConfigError with the names of the stage and the method for anything else.
py::array verdicts_of(const py::object& returned, std::size_t n, const char* method, const py::object& stage);

}  // namespace volccd::python
