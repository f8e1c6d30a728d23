// Stages written in Python, as the library's stages.
#pragma once

#include <memory>

#include <volccd/pipelines/registry.hpp>

#include "bind.hpp"

namespace volccd::python {

/// Adds a class of volccd/_stages.py (ElementCulling, FeatureFilter or NarrowPhase there) to the registry. Throws
/// ConfigError if its name is taken or its attributes are not what they must be. With the GIL held; what it adds takes
/// the GIL itself.
void add_stage(Registry& registry, const py::object& stage);

/// A Python object that may be copied and destroyed without the GIL.
class SharedObject {
 public:
  SharedObject() = default;
  /// With the GIL held.
  explicit SharedObject(py::object object);
  /// For use with the GIL held.
  const py::object& get() const { return *object_; }
  explicit operator bool() const { return object_ != nullptr; }

 private:
  std::shared_ptr<py::object> object_;
};

/// What a state of a stage in Python keeps: the step as Python sees it, with copies of the arrays, so that a stage may
/// keep them.
class PythonState final : public StageState {
 public:
  /// With the GIL held.
  PythonState();

  /// Copies the step, and calls stage.prepare(step). Takes the GIL.
  void prepare(const Step& step, const SharedObject& stage);
  /// With the GIL held.
  const py::object& step() const { return step_.get(); }
  std::size_t bytes() const override { return bytes_; }

 private:
  void set_elements(const Mesh& mesh);

  SharedObject step_;
  std::uint64_t version_ = 0;  ///< of the topology whose elements the step has
  std::size_t bytes_ = 0;
};

/// What a stage returned for `n` pairs or tests, an array [n] of bool or of integers in 0 .. 2, as uint8. Throws
/// ConfigError that names the stage and the method for anything else.
py::array verdicts_of(const py::object& returned, std::size_t n, const char* method, const py::object& stage);

}  // namespace volccd::python
