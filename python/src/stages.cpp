#include "stages.hpp"

#include <algorithm>
#include <array>
#include <optional>

#include <fmt/format.h>
#include <pybind11/stl.h>

#include <volccd/core/error.hpp>

#include "arrays.hpp"

namespace volccd::python {

namespace {

/// The common part of the three kinds of stages.
template <class Base>
class PythonStage : public Base {
 public:
  explicit PythonStage(SharedObject stage) : stage_(std::move(stage)) {}

  std::unique_ptr<StageState> make_state() const final {
    const py::gil_scoped_acquire gil;
    return std::make_unique<PythonState>();
  }
  void prepare(const Step& step, StageState& state, Executor&) const final {
    static_cast<PythonState&>(state).prepare(step, stage_);
  }

 protected:
  const py::object& stage() const { return stage_.get(); }
  static const py::object& step_of(const StageState& state) { return static_cast<const PythonState&>(state).step(); }

 private:
  SharedObject stage_;
};

class PythonElementCulling final : public PythonStage<ElementCulling> {
 public:
  using PythonStage::PythonStage;

  void run(const Step&, StageState& state, unsigned, PairBatch& batch) const override {
    const std::size_t n = batch.size();
    if (n == 0) return;
    const py::gil_scoped_acquire gil;
    static_assert(sizeof(ElementPair) == 2 * sizeof(Index));
    const py::array pairs = new_array({n, 2}, reinterpret_cast<const Index*>(batch.pairs.data()));
    const py::array kept = verdicts_of(stage().attr("cull")(step_of(state), pairs), n, "cull", stage());
    const std::uint8_t* verdict = static_cast<const std::uint8_t*>(kept.data());
    batch.cull([&](ElementPair, FeatureMask&) {
      const std::uint8_t value = *verdict++;
      return value == 0 ? PairVerdict::disjoint : value == 2 ? PairVerdict::contact_free : PairVerdict::keep;
    });
  }
};

/// Copies of the arrays of a block: kind, vertices [n, 4], points [control points, 4, 3, n].
struct BlockArrays {
  py::int_ kind;
  py::array vertices, points;

  explicit BlockArrays(const TestBlock& block)
      : kind(static_cast<int>(block.kind())),
        vertices(new_array({block.size(), 4}, block.vertices(0).data())),
        points(new_array(py::dtype::of<double>(),
                         {static_cast<std::size_t>(block.control_points()), 4, 3, block.size()}, nullptr, 0)) {
    double* to = static_cast<double*>(points.mutable_data());
    for (int c = 0; c < block.control_points(); ++c)
      for (int p = 0; p < 4; ++p)
        for (int axis = 0; axis < 3; ++axis, to += block.size()) std::copy_n(block.row(c, p, axis), block.size(), to);
  }
};

class PythonFeatureFilter final : public PythonStage<FeatureFilter> {
 public:
  using PythonStage::PythonStage;

  void run(const Step&, StageState& state, unsigned, const TestBlock& block,
           std::span<std::uint8_t> keep) const override {
    const py::gil_scoped_acquire gil;
    const BlockArrays arrays(block);
    const py::array kept =
        verdicts_of(stage().attr("filter")(step_of(state), arrays.kind, arrays.vertices, arrays.points), block.size(),
                    "filter", stage());
    const std::uint8_t* verdict = static_cast<const std::uint8_t*>(kept.data());
    for (std::size_t i = 0; i < block.size(); ++i)
      if (verdict[i] == 0) keep[i] = 0;
  }
};

/// Times of contacts and, if the stage gives them, the other fields.
struct Answer {
  std::optional<DoubleArray> toi, normal, point, weights, at_start;
};

class PythonNarrowPhase final : public PythonStage<NarrowPhase> {
 public:
  explicit PythonNarrowPhase(SharedObject made)
      : PythonStage(std::move(made)),
        max_control_points_(stage().attr("max_control_points").cast<int>()),
        handles_separation_(stage().attr("handles_separation").cast<bool>()),
        time_tolerance_(stage().attr("time_tolerance").cast<double>()) {}

  int max_control_points() const override { return max_control_points_; }
  bool handles_separation() const override { return handles_separation_; }
  double time_tolerance() const override { return time_tolerance_; }

  void run(const Step& step, StageState& state, unsigned, const TestBlock& block, std::vector<Contact>& contacts,
           NarrowCounters&) const override {
    const py::gil_scoped_acquire gil;
    const BlockArrays arrays(block);
    const Answer answer =
        answer_of(stage().attr("test")(step_of(state), arrays.kind, arrays.vertices, arrays.points), block.size());
    for (std::size_t i = 0; i < block.size(); ++i)
      if (const double toi = answer.toi->at(i); toi <= step.t_max) contacts.push_back(contact(block, answer, i));
  }

 private:
  std::optional<DoubleArray> take(const py::dict& fields, const char* name, std::size_t n, py::ssize_t columns) const {
    if (!fields.contains(name)) return std::nullopt;
    const auto array = DoubleArray::ensure(fields[name]);
    if (!array) throw py::error_already_set();
    const bool good = columns == 0 ? array.ndim() == 1 : array.ndim() == 2 && array.shape(1) == columns;
    if (!good || static_cast<std::size_t>(array.shape(0)) != n)
      throw ConfigError(fmt::format("stage '{}': test() returned '{}' of another shape than ({}{})",
                                    stage().attr("name").cast<std::string>(), name, n,
                                    columns == 0 ? "," : fmt::format(", {}", columns)));
    return array;
  }

  Answer answer_of(const py::object& returned, std::size_t n) const {
    py::dict fields;
    if (py::isinstance<py::dict>(returned))
      fields = returned;
    else
      fields["toi"] = returned;
    if (!fields.contains("toi"))
      throw ConfigError(fmt::format("stage '{}': test() returned no 'toi'", stage().attr("name").cast<std::string>()));
    Answer answer;
    answer.toi = take(fields, "toi", n, 0);
    answer.normal = take(fields, "normal", n, 3);
    answer.point = take(fields, "point", n, 3);
    answer.weights = take(fields, "weights", n, 4);
    answer.at_start = take(fields, "at_start", n, 0);
    return answer;
  }

  static Vec3 row(const std::optional<DoubleArray>& array, std::size_t i) {
    return array ? Vec3(array->at(i, 0), array->at(i, 1), array->at(i, 2)) : Vec3(Vec3::Zero());
  }

  static Contact contact(const TestBlock& block, const Answer& answer, std::size_t i) {
    Contact made{block.kind(),
                 block.vertices(i),
                 answer.toi->at(i),
                 row(answer.normal, i),
                 {},
                 row(answer.point, i),
                 answer.at_start && answer.at_start->at(i) != 0};
    if (answer.weights)
      for (std::size_t k = 0; k < 4; ++k) made.weights[k] = answer.weights->at(i, k);
    return made;
  }

  int max_control_points_;
  bool handles_separation_;
  double time_tolerance_;
};

Guarantee guarantee_of(const std::string& text, const std::string& stage) {
  for (const Guarantee guarantee : {Guarantee::exact, Guarantee::conservative, Guarantee::approximate})
    if (text == to_string(guarantee)) return guarantee;
  throw ConfigError(fmt::format("stage '{}': guarantee '{}' is not exact, conservative or approximate", stage, text));
}

std::vector<OptionInfo> options_of(const py::object& stage) {
  std::vector<OptionInfo> infos;
  for (const py::handle row : stage.attr("_describe_options")()) {
    const auto fields = row.cast<std::array<std::string, 4>>();
    infos.push_back({fields[0], fields[1], fields[2], fields[3]});
  }
  return infos;
}

/// Makes an instance with these options. A ConfigError of Python becomes one of the library, which the program reports.
SharedObject instance_of(const SharedObject& type, const OptionValues& values) {
  try {
    return SharedObject(type.get().attr("_make")(values));
  } catch (const py::error_already_set& error) {
    if (error.matches(py::module_::import("volccd._core").attr("ConfigError")))
      throw ConfigError(py::str(error.value()).cast<std::string>());
    throw;
  }
}

template <class Stage, class Made>
void add(Registry& registry, const py::object& stage) {
  StageDescriptor<Stage> descriptor;
  descriptor.name = stage.attr("name").cast<std::string>();
  descriptor.description = stage.attr("_description")().cast<std::string>();
  descriptor.guarantee = guarantee_of(stage.attr("guarantee").cast<std::string>(), descriptor.name);
  descriptor.options = options_of(stage);
  descriptor.make = [type = SharedObject(stage)](const OptionValues& values) -> std::unique_ptr<Stage> {
    const py::gil_scoped_acquire gil;
    return std::make_unique<Made>(instance_of(type, values));
  };
  descriptor.make({});  // errors are thrown now
  registry.add(std::move(descriptor));
}

}  // namespace

void add_stage(Registry& registry, const py::object& stage) {
  const std::string role = stage.attr("role").cast<std::string>();
  if (role == ElementCulling::kRole)
    add<ElementCulling, PythonElementCulling>(registry, stage);
  else if (role == FeatureFilter::kRole)
    add<FeatureFilter, PythonFeatureFilter>(registry, stage);
  else if (role == NarrowPhase::kRole)
    add<NarrowPhase, PythonNarrowPhase>(registry, stage);
  else
    throw ConfigError(
        fmt::format("a stage in Python is an ElementCulling, FeatureFilter or NarrowPhase, not '{}'", role));
}

}  // namespace volccd::python
