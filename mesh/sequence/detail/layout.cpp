#include <volccd/mesh/sequence/detail/layout.hpp>

#include <algorithm>
#include <cmath>
#include <limits>
#include <string>
#include <utility>

#include <volccd/core/error.hpp>
#include <volccd/mesh/types.hpp>

namespace volccd::detail {

namespace {

using std::to_string;

constexpr char kGrid[] = "VTKHDF";
/// Largest count for which one can be added without overflow.
constexpr std::int64_t kGreatestCount = std::int64_t{1} << 62;

std::string at(const std::string& name) { return std::string(kGrid) + "/" + name; }

/// Reads the tables one after another; `steps_` and `topologies_` are determined first.
class LayoutReader {
 public:
  explicit LayoutReader(const Hdf5File& file) : file_(file) {}

  SequenceLayout read() {
    check_header();
    read_counts();
    read_times();
    read_topologies();
    read_geometry();
    read_polyhedra();
    layout_.point_ids = point_array("GlobalPointIds", NumberKind::integer, 1);
    layout_.velocity = point_array("Velocity", NumberKind::real, 3);
    layout_.query_start = point_array("QueryStart", NumberKind::real, 3);
    layout_.query_end = point_array("QueryEnd", NumberKind::real, 3);
    layout_.query_separation = point_array("QuerySeparation", NumberKind::real, 1);
    layout_.cell_ids = cell_array("GlobalCellIds", NumberKind::integer);
    layout_.part_ids = cell_array("PartId", NumberKind::integer);
    layout_.thickness = cell_array("Thickness", NumberKind::real);
    return std::move(layout_);
  }

 private:
  void check_header();
  void read_counts();
  void read_times();
  void read_topologies();
  void read_geometry();
  void read_polyhedra();

  /// Counts of all topologies; not negative.
  std::vector<std::int64_t> counts(const std::string& name);
  /// A table of the group Steps; zeros for a file without steps.
  std::vector<std::int64_t> table(const std::string& name);
  StepArray array(const std::string& name, NumberKind kind, std::int64_t columns, const std::string& table_name);
  /// Adjusts the first rows of an array that has one entry more than `count` for every topology stored before.
  void add_topology_index(StepArray& array) const;
  std::optional<StepArray> point_array(const std::string& name, NumberKind kind, std::int64_t columns);
  std::optional<StepArray> cell_array(const std::string& name, NumberKind kind);
  StepArray data_array(const std::string& group, const std::string& name, NumberKind kind, std::int64_t columns);

  /// Checks for every step that its range [first, first + count(topology) + extra) is within the dataset.
  void check_slices(const StepArray& array, const std::vector<std::int64_t>& count, std::int64_t extra) const;
  void check_slices(const StepArray& array, std::int64_t count) const;

  const Hdf5File& file_;
  SequenceLayout layout_;
  bool temporal_ = false;
  std::int64_t steps_ = 1, topologies_ = 1;
};

void LayoutReader::check_header() {
  if (!file_.has(kGrid)) file_.fail(kGrid, "is missing: not a VTKHDF file");
  const std::string type = file_.string_attribute(kGrid, "Type");
  if (type != "UnstructuredGrid")
    file_.fail(std::string(kGrid) + "@Type", "is \"" + type + "\", but must be \"UnstructuredGrid\"");
  const std::vector<std::int64_t> version = file_.integer_attribute(kGrid, "Version", 2);
  if (version[0] < 1 || version[0] > 2)
    file_.fail(std::string(kGrid) + "@Version",
               "is " + to_string(version[0]) + "." + to_string(version[1]) + ", 1.x and 2.x are read");
}

std::vector<std::int64_t> LayoutReader::counts(const std::string& name) {
  std::vector<std::int64_t> values = file_.integers(at(name), topologies_);
  for (std::size_t b = 0; b < values.size(); ++b)
    if (values[b] < 0 || values[b] > kGreatestCount)
      throw InputError(file_.name(), at(name), static_cast<std::int64_t>(b), "is not a count: " + to_string(values[b]));
  return values;
}

void LayoutReader::read_counts() {
  topologies_ = file_.dataset(at("NumberOfPoints"), NumberKind::integer).rows();
  if (topologies_ == 0) file_.fail(at("NumberOfPoints"), "is empty: no topology");
  const std::vector<std::int64_t> points = counts("NumberOfPoints");
  for (std::size_t b = 1; b < points.size(); ++b)
    if (points[b] != points[0])
      throw InputError(file_.name(), at("NumberOfPoints"), static_cast<std::int64_t>(b),
                       "is " + to_string(points[b]) + ", but " + to_string(points[0]) +
                           " before: all topologies must have the same points");
  if (points[0] == 0 || points[0] >= std::int64_t{kNone})
    throw InputError(file_.name(), at("NumberOfPoints"), 0,
                     to_string(points[0]) + " points, but must have 1 .. " + to_string(kNone - 1));
  layout_.points = points[0];
  layout_.cells = counts("NumberOfCells");
  layout_.connectivity_ids = counts("NumberOfConnectivityIds");
  for (std::size_t b = 0; b < layout_.cells.size(); ++b)
    if (layout_.cells[b] == 0 || layout_.cells[b] >= std::int64_t{kNone})
      throw InputError(file_.name(), at("NumberOfCells"), static_cast<std::int64_t>(b),
                       to_string(layout_.cells[b]) + " cells, but must have 1 .. " + to_string(kNone - 1));
}

void LayoutReader::read_times() {
  temporal_ = file_.has(at("Steps"));
  if (!temporal_) {
    if (topologies_ != 1)
      file_.fail(at("NumberOfPoints"),
                 to_string(topologies_) + " pieces in a file without steps, but only one can be read");
    layout_.times = {0.0};
    return;
  }
  steps_ = file_.integer_attribute(at("Steps"), "NSteps", 1)[0];
  if (steps_ < 1) file_.fail(at("Steps@NSteps"), "is " + to_string(steps_) + ": no steps");
  if (steps_ > std::numeric_limits<int>::max())
    file_.fail(at("Steps@NSteps"), "is " + to_string(steps_) + ": too many");
  const Hdf5Dataset values = file_.dataset(at("Steps/Values"), NumberKind::real);
  if (values.rows() != steps_)
    values.fail("has " + to_string(values.rows()) + " entries, but must have " + to_string(steps_));
  values.read(0, steps_, layout_.times);
  for (std::size_t k = 0; k < layout_.times.size(); ++k) {
    if (!std::isfinite(layout_.times[k])) values.fail(static_cast<std::int64_t>(k), "the time is not finite");
    if (k > 0 && !(layout_.times[k] > layout_.times[k - 1]))
      values.fail(static_cast<std::int64_t>(k), "the time is not after that of the step before");
  }
}

std::vector<std::int64_t> LayoutReader::table(const std::string& name) {
  if (!temporal_) return {0};
  return file_.integers(at("Steps/" + name), steps_);
}

void LayoutReader::read_topologies() {
  layout_.topology = table("PartOffsets");
  for (std::size_t k = 0; k < layout_.topology.size(); ++k)
    if (layout_.topology[k] < 0 || layout_.topology[k] >= topologies_)
      throw InputError(
          file_.name(), at("Steps/PartOffsets"), static_cast<std::int64_t>(k),
          "is " + to_string(layout_.topology[k]) + ", there are " + to_string(topologies_) + " topologies");
  if (!temporal_ || !file_.has(at("Steps/NumberOfParts"))) return;
  const std::vector<std::int64_t> pieces = table("NumberOfParts");
  for (std::size_t k = 0; k < pieces.size(); ++k)
    if (pieces[k] != 1)
      throw InputError(file_.name(), at("Steps/NumberOfParts"), static_cast<std::int64_t>(k),
                       "is " + to_string(pieces[k]) + ", but only one piece for each step can be read");
}

StepArray LayoutReader::array(const std::string& name, NumberKind kind, std::int64_t columns,
                              const std::string& table_name) {
  StepArray result{file_.dataset(at(name), kind, columns), table(table_name), ""};
  if (temporal_) result.table = at("Steps/" + table_name);
  return result;
}

void LayoutReader::add_topology_index(StepArray& array) const {
  for (std::size_t k = 0; k < array.first.size(); ++k) {
    // A value out of range remains out of range, and the sum cannot overflow.
    if (array.first[k] >= 0 && array.first[k] <= array.data.rows()) array.first[k] += layout_.topology[k];
  }
}

void LayoutReader::check_slices(const StepArray& array, const std::vector<std::int64_t>& count,
                                std::int64_t extra) const {
  for (std::size_t k = 0; k < layout_.steps(); ++k) {
    const std::int64_t length = count[static_cast<std::size_t>(layout_.topology[k])] + extra;
    if (array.first[k] >= 0 && length <= array.data.rows() && array.first[k] <= array.data.rows() - length) continue;
    const std::string problem = "step " + to_string(k) + " wants " + to_string(length) + " rows of " +
                                array.data.path() + " from row " + to_string(array.first[k]) + " on, there are " +
                                to_string(array.data.rows());
    if (array.table.empty()) array.data.fail(problem);
    throw InputError(file_.name(), array.table, static_cast<std::int64_t>(k), problem);
  }
}

void LayoutReader::check_slices(const StepArray& array, std::int64_t count) const {
  check_slices(array, std::vector<std::int64_t>(static_cast<std::size_t>(topologies_), count), 0);
}

void LayoutReader::read_geometry() {
  layout_.positions = array("Points", NumberKind::real, 3, "PointOffsets");
  layout_.types = array("Types", NumberKind::integer, 1, "CellOffsets");
  layout_.connectivity = array("Connectivity", NumberKind::integer, 1, "ConnectivityIdOffsets");
  layout_.offsets = array("Offsets", NumberKind::integer, 1, "CellOffsets");
  add_topology_index(layout_.offsets);
  check_slices(layout_.positions, layout_.points);
  check_slices(layout_.types, layout_.cells, 0);
  check_slices(layout_.connectivity, layout_.connectivity_ids, 0);
  check_slices(layout_.offsets, layout_.cells, 1);
}

void LayoutReader::read_polyhedra() {
  if (!file_.has(at("FaceConnectivity"))) return;
  PolyhedronLayout polyhedra;
  polyhedra.faces = counts("NumberOfFaces");
  polyhedra.face_connectivity_ids = counts("NumberOfFaceConnectivityIds");
  polyhedra.to_face_ids = counts("NumberOfPolyhedronToFaceIds");
  polyhedra.face_connectivity = array("FaceConnectivity", NumberKind::integer, 1, "FaceConnectivityOffsets");
  polyhedra.to_faces = array("PolyhedronToFaces", NumberKind::integer, 1, "PolyhedronToFaceIdOffsets");
  polyhedra.face_offsets = array("FaceOffsets", NumberKind::integer, 1, "FaceOffsetsOffsets");
  polyhedra.offsets = array("PolyhedronOffsets", NumberKind::integer, 1, "CellOffsets");
  add_topology_index(polyhedra.face_offsets);
  add_topology_index(polyhedra.offsets);
  check_slices(polyhedra.face_connectivity, polyhedra.face_connectivity_ids, 0);
  check_slices(polyhedra.to_faces, polyhedra.to_face_ids, 0);
  check_slices(polyhedra.face_offsets, polyhedra.faces, 1);
  check_slices(polyhedra.offsets, layout_.cells, 1);
  layout_.polyhedra = std::move(polyhedra);
}

StepArray LayoutReader::data_array(const std::string& group, const std::string& name, NumberKind kind,
                                   std::int64_t columns) {
  const std::string table_name = group + "Offsets/" + name;
  // A file with one step needs no table.
  if (temporal_ && steps_ == 1 && !file_.has(at("Steps/" + table_name)))
    return {file_.dataset(at(group + "/" + name), kind, columns), {0}, ""};
  return array(group + "/" + name, kind, columns, table_name);
}

std::optional<StepArray> LayoutReader::point_array(const std::string& name, NumberKind kind, std::int64_t columns) {
  if (!file_.has(at("PointData/" + name))) return std::nullopt;
  StepArray result = data_array("PointData", name, kind, columns);
  check_slices(result, layout_.points);
  return result;
}

std::optional<StepArray> LayoutReader::cell_array(const std::string& name, NumberKind kind) {
  if (!file_.has(at("CellData/" + name))) return std::nullopt;
  StepArray result = data_array("CellData", name, kind, 1);
  check_slices(result, layout_.cells, 0);
  return result;
}

}  // namespace

SequenceLayout read_layout(const Hdf5File& file) { return LayoutReader(file).read(); }

}  // namespace volccd::detail
