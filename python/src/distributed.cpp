// One of several ranks, whose messages go through a Python object (volccd/distributed.py).
#include <cstring>
#include <memory>
#include <optional>
#include <utility>

#include <pybind11/stl.h>

#include <volccd/distributed/detector.hpp>

#include "arrays.hpp"
#include "cells.hpp"
#include "registry.hpp"
#include "runner.hpp"
#include "signals.hpp"

namespace volccd::python {

namespace {

using distributed::Bytes;

py::bytes python_bytes(const Bytes& bytes) { return {reinterpret_cast<const char*>(bytes.data()), bytes.size()}; }

Bytes bytes_of(const py::handle& object) {
  char* data = nullptr;
  py::ssize_t size = 0;
  if (PyBytes_AsStringAndSize(object.ptr(), &data, &size) != 0) throw py::error_already_set();
  return distributed::to_bytes(std::string_view(data, static_cast<std::size_t>(size)));
}

std::vector<Bytes> all_bytes_of(const py::object& list) {
  std::vector<Bytes> result;
  for (const py::handle& one : list) result.push_back(bytes_of(one));
  return result;
}

/// A Python object; kept, used and freed with the GIL, although the detector runs without it.
class Kept {
 public:
  explicit Kept(py::object object) : object_(new py::object(std::move(object))) {}
  Kept(const Kept&) = delete;
  ~Kept() {
    const py::gil_scoped_acquire gil;
    delete object_;
  }
  py::object& operator*() const { return *object_; }

 private:
  py::object* const object_;
};

/// `ranks` has exchange(destinations, sources, messages), which returns a message from each source.
class PythonGraph final : public distributed::Neighbourhood {
 public:
  PythonGraph(py::object ranks, std::vector<int> destinations, std::vector<int> sources)
      : Neighbourhood(std::move(destinations), std::move(sources)), ranks_(std::move(ranks)) {}

  std::vector<Bytes> exchange(std::vector<Bytes> messages) override {
    const py::gil_scoped_acquire gil;
    py::list sent;
    for (const Bytes& message : messages) sent.append(python_bytes(message));
    const auto numbers = [](std::span<const int> ranks) {
      return py::cast(std::vector<int>(ranks.begin(), ranks.end()));
    };
    return all_bytes_of((*ranks_).attr("exchange")(numbers(destinations()), numbers(sources()), sent));
  }

 private:
  Kept ranks_;
};

/// The operations of Exchange as methods of a Python object.
class PythonExchange final : public distributed::Exchange {
 public:
  explicit PythonExchange(const py::object& ranks)
      : ranks_(ranks), rank_(ranks.attr("rank").cast<int>()), size_(ranks.attr("size").cast<int>()) {}

  int rank() const override { return rank_; }
  int size() const override { return size_; }

  std::unique_ptr<distributed::Neighbourhood> connect(std::vector<int> destinations) override {
    const py::gil_scoped_acquire gil;
    auto sources = (*ranks_).attr("connect")(destinations).cast<std::vector<int>>();
    return std::make_unique<PythonGraph>(*ranks_, std::move(destinations), std::move(sources));
  }

  std::vector<Bytes> allgather(Bytes bytes) override {
    const py::gil_scoped_acquire gil;
    return all_bytes_of((*ranks_).attr("allgather")(python_bytes(bytes)));
  }

  void allreduce(std::span<std::uint64_t> values, distributed::Reduction reduction) override {
    const py::gil_scoped_acquire gil;
    const char* const name = reduction == distributed::Reduction::sum   ? "sum"
                             : reduction == distributed::Reduction::min ? "min"
                                                                        : "max";
    const py::array_t<std::uint64_t> array(static_cast<py::ssize_t>(values.size()), values.data());
    const auto reduced = (*ranks_).attr("allreduce")(array, name).cast<IntegerArray<std::uint64_t>>();
    std::ranges::copy(values_of(reduced, "allreduce"), values.begin());
  }

 private:
  Kept ranks_;
  int rank_, size_;
};

/// Cells whose vertices are rows of `vertices`, as elements that name vertices by their ids.
distributed::Elements elements_with_ids(const CellArrays& cells, std::span<const std::int64_t> vertices) {
  const auto id_of = [&](Index row) {
    if (row >= vertices.size())
      throw InputError("cells", "connectivity", static_cast<std::int64_t>(row),
                       "is no row of `vertices`, which has " + std::to_string(vertices.size()));
    return vertices[row];
  };
  distributed::Elements elements;
  for (const ElementSpec& spec : elements_of(cells)) {
    std::vector<std::int64_t> ids, faces;
    for (const Index v : spec.vertices) ids.push_back(id_of(v));
    for (std::size_t i = 0; i < spec.faces.size();) {  // {n, v0 .. v(n-1), n, ...}
      const std::size_t end = std::min(spec.faces.size(), i + 1 + spec.faces[i]);
      faces.push_back(spec.faces[i++]);
      while (i < end) faces.push_back(id_of(spec.faces[i++]));
    }
    elements.add(spec.type, ids, spec.object, spec.id, faces);
  }
  return elements;
}

/// A distributed::Detector whose executor looks for signals.
class RankDetector {
 public:
  RankDetector(const py::object& ranks, const py::dict& options, double skin, double max_imbalance) : exchange_(ranks) {
    const Registry stages = registry();  // which may change when the GIL is released
    PipelineSpec spec;
    distributed::Config config;
    distributed::run_on_all(exchange_, "options", [&] {
      const DetectorConfig given = detector_config(options);
      spec = stages.pipeline(given.pipeline);
      for (const std::string& setting : given.settings) stages.apply_setting(spec, setting);
      executor_ = make_signal_executor(given.threads);
      config = {.executor = executor_.get(),
                .separation = given.separation,
                .filter = given.filter,
                .skin = skin,
                .max_imbalance = max_imbalance,
                .lists = given.lists};
    });
    const py::gil_scoped_release without_gil;
    detector_.emplace(exchange_, stages, spec, config);
  }

  void set_mesh(const py::dict& cells, const IntegerArray<std::int64_t>& vertices, std::size_t owned,
                const std::string& edges) {
    const BusyGuard guard(busy_, "Detector");
    EdgeSet edge_set = EdgeSet::triangulated;
    distributed::Elements elements;
    std::vector<std::int64_t> own;
    distributed::run_on_all(exchange_, "cells", [&] {
      const std::span<const std::int64_t> ids = values_of(vertices, "vertices");
      edge_set = value_named<EdgeSet>(edges, "edges");
      elements = elements_with_ids(PythonCells(cells).views(), ids);
      own.assign(ids.begin(), ids.begin() + static_cast<std::ptrdiff_t>(owned));
    });
    const py::gil_scoped_release without_gil;
    detector_->set_mesh(std::move(elements), std::move(own), edge_set);
  }

  /// contacts, initial overlaps, statistics, and those of the rank.
  py::tuple step(const DoubleArray& points0, const DoubleArray& points1, const std::optional<DoubleArray>& middle,
                 bool first, bool initial_overlaps) {
    const BusyGuard guard(busy_, "Detector");
    const Request request = StepRequest{first, initial_overlaps, 1, false}.request();
    distributed::run_on_all(exchange_, "step", [&] {
      const std::span<const Vec3> x0 = points_of(points0, "points0"), x1 = points_of(points1, "points1");
      if (middle)
        motion_.set_quadratic(x0, points_of(*middle, "middle"), x1);
      else
        motion_.set_linear(x0, x1);
    });
    {
      const py::gil_scoped_release without_gil;
      detector_->step(motion_, request);
    }
    const distributed::RankResult& result = detector_->result();
    return py::make_tuple(rank_contacts_copy(result.contacts),
                          new_array({result.initial_overlaps.size(), 2},
                                    result.initial_overlaps.empty() ? nullptr : result.initial_overlaps.front().data()),
                          statistics_dict(result.statistics), rank_dict(result.rank));
  }

  py::array to_owners() {
    const BusyGuard guard(busy_, "Detector");
    std::vector<distributed::RankContact> contacts;
    {
      const py::gil_scoped_release without_gil;
      contacts = detector_->to_owners();
    }
    return rank_contacts_copy(contacts);
  }

  double separation() const { return detector_->separation(); }
  void set_separation(double separation) { detector_->set_separation(separation); }
  py::dict facts() const { return facts_of(detector_->pipeline(), *executor_); }

 private:
  static py::dict rank_dict(const distributed::RankStatistics& rank) {
    using namespace pybind11::literals;
    return py::dict("elements"_a = rank.elements, "copies"_a = rank.copies, "halo"_a = rank.halo,
                    "tests"_a = rank.tests, "contacts"_a = rank.contacts, "seconds"_a = rank.seconds,
                    "piece_seconds"_a = rank.piece_seconds, "lists"_a = rank.lists,
                    "bytes_received"_a = rank.bytes_received, "neighbours"_a = rank.neighbours);
  }

  PythonExchange exchange_;
  std::unique_ptr<Executor> executor_;
  std::optional<distributed::Detector> detector_;
  Motion motion_;
  bool busy_ = false;
};

}  // namespace

void bind_distributed(py::module_& module) {
  using namespace pybind11::literals;
  using Self = RankDetector;
  module.attr("rank_contact_dtype") = rank_contacts_dtype();
  py::class_<Self>(module, "RankDetector")
      .def(py::init<const py::object&, const py::dict&, double, double>())
      .def("set_mesh", &Self::set_mesh)
      .def("step", &Self::step, "points0"_a, "points1"_a, "middle"_a, "first"_a, "initial_overlaps"_a)
      .def("to_owners", &Self::to_owners)
      .def_property("separation", &Self::separation, &Self::set_separation)
      .def_property_readonly("facts", &Self::facts);
}

}  // namespace volccd::python
