#include "result.hpp"

#include <cstddef>
#include <cstring>
#include <memory>
#include <utility>

#include "arrays.hpp"

namespace volccd::python {

namespace {

/// The fields of a structured dtype, at their offsets in a C++ struct.
class Fields {
 public:
  template <class Struct, class Member>
  Fields& add(const char* name, const py::object& format, const Struct& sample, const Member& member) {
    names_.append(name);
    formats_.append(format);
    offsets_.append(reinterpret_cast<const char*>(&member) - reinterpret_cast<const char*>(&sample));
    return *this;
  }
  template <class Struct, class Member>
  Fields& add(const char* name, const char* format, const Struct& sample, const Member& member) {
    return add(name, py::str(format), sample, member);
  }
  py::dtype dtype(std::size_t size) { return py::dtype(names_, formats_, offsets_, static_cast<py::ssize_t>(size)); }

 private:
  py::list names_, formats_, offsets_;
};

py::object vector_of(const char* format, int n) { return py::make_tuple(format, py::make_tuple(n)); }

/// Adds the fields that contacts have whatever names their vertices.
template <class AnyContact>
Fields& add_geometry(Fields& fields, const AnyContact& c) {
  return fields.add("toi", "<f8", c, c.toi)
      .add("normal", vector_of("<f8", 3), c, c.normal)
      .add("point", vector_of("<f8", 3), c, c.point)
      .add("weights", vector_of("<f8", 4), c, c.weights)
      .add("at_start", "?", c, c.at_start)
      .add("gap", "<f8", c, c.gap);
}

py::dtype contact_dtype() {
  const Contact c{};
  static_assert(sizeof(c.kind) == 1 && sizeof(c.at_start) == 1);
  Fields fields;
  fields.add("kind", "u1", c, c.kind).add("vertices", vector_of("<u4", 4), c, c.vertices);
  return add_geometry(fields, c).dtype(sizeof(Contact));
}

const py::object& kept_dtype(py::object (*make)(), py::object*& kept) {
  if (!kept) kept = new py::object(make());  // for the lifetime of the process
  return *kept;
}

py::dtype contacts_dtype() {
  static py::object* kept = nullptr;
  return kept_dtype([]() -> py::object { return contact_dtype(); }, kept);
}

py::object rank_contact_dtype() {
  const distributed::RankContact c{};
  Fields fields;
  fields.add("kind", "u1", c, c.kind)
      .add("vertices", vector_of("<i8", 4), c, c.vertices)
      .add("elements", vector_of("<i8", 2), c, c.elements)
      .add("objects", vector_of("<i4", 2), c, c.objects);
  return add_geometry(fields, c).dtype(sizeof(distributed::RankContact));
}

py::dtype ends_dtype() {
  static py::object* kept = nullptr;
  return kept_dtype(
      []() -> py::object {
        const ContactEnd e{};
        return Fields()
            .add("gap", "<f8", e, e.gap)
            .add("weights", vector_of("<f8", 4), e, e.weights)
            .add("first", vector_of("<f8", 3), e, e.first)
            .add("second", vector_of("<f8", 3), e, e.second)
            .dtype(sizeof(ContactEnd));
      },
      kept);
}

py::array stage_table(const std::vector<StageStatistics>& stages) {
  py::list rows, fields;
  for (const StageStatistics& s : stages)
    rows.append(py::make_tuple(s.role, s.name, s.in, s.out, s.prepare_seconds, s.counter("bounds_seconds"), s.seconds));
  const char* const table[][2] = {
      {"role", "U24"},           {"name", "U32"},   {"in", "<u8"}, {"out", "<u8"}, {"prepare_seconds", "<f8"},
      {"bounds_seconds", "<f8"}, {"seconds", "<f8"}};
  for (const auto& field : table) fields.append(py::make_tuple(field[0], field[1]));
  return py::module_::import("numpy").attr("array")(rows, fields);
}

py::dict statistics_of(Result& result) {
  if (!result.statistics_dict) result.statistics_dict = statistics_dict(result.statistics);
  return result.statistics_dict;
}

std::string text_of(const Result& result) {
  return "<volccd.Result: " + std::to_string(result.contacts.size()) +
         (result.contacts.size() == 1 ? " contact" : " contacts") +
         (result.contacts.empty() ? "" : ", the earliest at " + std::to_string(result.statistics.earliest_toi)) + ">";
}

}  // namespace

py::array contacts_view(const std::vector<Contact>& contacts, const py::handle& owner) {
  return view(contacts_dtype(), contacts.size(), contacts.data(), owner);
}

py::array contacts_copy(const std::vector<Contact>& contacts) {
  return new_array(contacts_dtype(), {contacts.size()}, contacts.data(), contacts.size() * sizeof(Contact));
}

py::dtype rank_contacts_dtype() {
  static py::object* kept = nullptr;
  return kept_dtype(&rank_contact_dtype, kept);
}

py::array rank_contacts_copy(const std::vector<distributed::RankContact>& contacts) {
  return new_array(rank_contacts_dtype(), {contacts.size()}, contacts.data(),
                   contacts.size() * sizeof(distributed::RankContact));
}

py::array pairs_copy(const std::vector<ElementPair>& pairs) {
  return new_array(pair_dtype(), {pairs.size()}, pairs.data(), pairs.size() * sizeof(ElementPair));
}

py::dict statistics_dict(const Statistics& s) {
  py::dict d;
  visit_values(s, [&](const char* name, auto value) { d[name] = value; });
  d["stages"] = stage_table(s.stages);
  return d;
}

/// The rows of an array whose dtype has the size of T, as T.
template <class T>
std::vector<T> rows_of(const py::array& array, const char* name) {
  const bool fits = array.ndim() == 1 && array.itemsize() == static_cast<py::ssize_t>(sizeof(T)) &&
                    (array.flags() & py::array::c_style) != 0;
  if (!fits) wrong_shape(name, "rows of a result");
  std::vector<T> rows(static_cast<std::size_t>(array.size()));
  if (!rows.empty()) std::memcpy(static_cast<void*>(rows.data()), array.data(), rows.size() * sizeof(T));
  return rows;
}

/// A result with these arrays, as a pickle has them; `_results.py` has given them their dtypes.
std::shared_ptr<Result> result_of(const py::array& contacts, const py::array& ends, const py::array& overlaps,
                                  const py::dict& statistics) {
  StepResult result;
  result.contacts = rows_of<Contact>(contacts, "contacts");
  result.ends = rows_of<ContactEnd>(ends, "ends");
  result.initial_overlaps = rows_of<ElementPair>(overlaps, "initial_overlaps");
  for (Contact& contact : result.contacts) {  // slots of a topology that is not there
    contact.features = {kNone, kNone};
    contact.elements = {kNone, kNone};
  }
  result.statistics.earliest_toi = statistics["earliest_toi"].cast<double>();
  const auto made = std::make_shared<Result>(std::move(result));
  made->statistics_dict = statistics;
  return made;
}

void bind_results(py::module_& module) {
  module.attr("contact_dtype") = contacts_dtype();
  module.attr("end_dtype") = ends_dtype();
  module.def("result_of", &result_of);
  module.attr("pair_dtype") = pair_dtype();
  py::class_<Result, std::shared_ptr<Result>>(
      module, "Result", "What a step gave. Its arrays are views of the library's memory, which they keep alive.")
      .def_property_readonly(
          "contacts", [](const py::object& self) { return contacts_view(self.cast<const Result&>().contacts, self); },
          "Structured array (n,) of volccd.contact_dtype, in canonical order: by kind, then vertices.\n\n"
          "kind      uint8        volccd.VF: vertex and triangle; volccd.EE: two edges\n"
          "vertices  uint32 (4,)  {vertex, triangle} or {edge 1, edge 2}, rows of the points\n"
          "toi       float64      first time of contact, 0 .. 1 of the step; never late\n"
          "normal    float64 (3,) unit normal at toi, from the second feature towards the first; 0 where there is "
          "none\n"
          "point     float64 (3,) on the second feature at toi, in the unit of the points\n"
          "weights   float64 (4,) of the vertices; vertex-triangle {1, w0, w1, w2}, edge-edge {1-s, s, 1-u, u}\n"
          "at_start  bool         they touch, or are closer than the separation, at t = 0 already\n"
          "gap       float64      distance of the features at toi, in the unit of the points")
      .def_property_readonly(
          "ends",
          [](const py::object& self) {
            const auto& ends = self.cast<const Result&>().ends;
            return view(ends_dtype(), ends.size(), ends.data(), self);
          },
          "If asked for: structured array, one entry for each contact, of the features at t = 1.\n\n"
          "gap       float64      distance of the features, not signed\n"
          "weights   float64 (4,) of the vertices, for the closest points\n"
          "first     float64 (3,) closest point of the first feature\n"
          "second    float64 (3,) closest point of the second feature")
      .def_property_readonly(
          "initial_overlaps",
          [](const py::object& self) {
            const auto& pairs = self.cast<const Result&>().initial_overlaps;
            return view(pair_dtype(), pairs.size(), pairs.data(), self);
          },
          "Structured array (n,) of volccd.pair_dtype (a < b, uint32): slots of elements that overlap at t = 0, if "
          "they\n"
          "were asked for. Slots are the rows of the cells until the mesh is edited; `element_ids` has their ids.")
      .def_property_readonly(
          "statistics", &statistics_of,
          "dict: counts (element_pairs, surviving_pairs, vf_tests, ee_tests, contacts, ...), seconds,\n"
          "workspace_bytes, earliest_toi (inf without contacts), and stages: a structured array of role,\n"
          "name, in, out, prepare_seconds, bounds_seconds, seconds (summed over workers).")
      .def_property_readonly(
          "earliest", [](const Result& result) { return result.statistics.earliest_toi; },
          "The earliest time of contact, in 0 .. 1 of the step: the largest safe step. inf without contacts.")
      .def("__len__", [](const Result& result) { return result.contacts.size(); })
      .def("__repr__", &text_of);
}

}  // namespace volccd::python
