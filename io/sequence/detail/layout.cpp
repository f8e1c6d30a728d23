#include <volccd/io/sequence/detail/layout.hpp>

#include <cmath>
#include <limits>
#include <string>
#include <utility>

#include <volccd/numerics/types.hpp>

namespace volccd::detail {

namespace {

using std::to_string;
using Integers = std::vector<std::int64_t>;

constexpr char kGrid[] = "VTKHDF";
/// Largest count for which one can be added without overflow.
constexpr std::int64_t kGreatestCount = std::int64_t{1} << 62;

std::string at(const std::string& name) { return std::string(kGrid) + "/" + name; }

/// Reads the tables one after another; `frames_` and `topologies_` are determined first.
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
    layout_.point_ids = data_array("PointData", "GlobalPointIds", NumberKind::integer, 1, points_);
    layout_.velocity = data_array("PointData", "Velocity", NumberKind::real, 3, points_);
    layout_.query_start = data_array("PointData", "QueryStart", NumberKind::real, 3, points_);
    layout_.query_end = data_array("PointData", "QueryEnd", NumberKind::real, 3, points_);
    layout_.query_separation = data_array("PointData", "QuerySeparation", NumberKind::real, 1, points_);
    layout_.cell_ids = data_array("CellData", "GlobalCellIds", NumberKind::integer, 1, layout_.cells);
    layout_.part_ids = data_array("CellData", "PartId", NumberKind::integer, 1, layout_.cells);
    layout_.thickness = data_array("CellData", "Thickness", NumberKind::real, 1, layout_.cells);
    return std::move(layout_);
  }

 private:
  [[noreturn]] void fail(const std::string& name, std::size_t row, const std::string& problem) const {
    file_.fail(at(name), row, problem);
  }

  void check_header() {
    if (!file_.has(kGrid)) file_.fail(kGrid, "is missing: not a VTKHDF file");
    const std::string type = file_.string_attribute(kGrid, "Type");
    if (type != "UnstructuredGrid")
      file_.fail(std::string(kGrid) + "@Type", "is \"" + type + "\", but must be \"UnstructuredGrid\"");
    const std::vector<std::int64_t> version = file_.integer_attribute(kGrid, "Version", 2);
    if (version[0] < 1 || version[0] > 2)
      file_.fail(std::string(kGrid) + "@Version",
                 "is " + to_string(version[0]) + "." + to_string(version[1]) + ", 1.x and 2.x are read");
  }

  /// Counts of all topologies; not negative.
  Integers counts(const std::string& name) {
    Integers values = file_.values<std::int64_t>(at(name), topologies_);
    for (std::size_t b = 0; b < values.size(); ++b)
      if (values[b] < 0 || values[b] > kGreatestCount) fail(name, b, "is not a count: " + to_string(values[b]));
    return values;
  }

  void read_counts() {
    topologies_ = file_.dataset(at("NumberOfPoints"), NumberKind::integer).rows();
    if (topologies_ == 0) file_.fail(at("NumberOfPoints"), "is empty: no topology");
    points_ = counts("NumberOfPoints");
    for (std::size_t b = 1; b < points_.size(); ++b)
      if (points_[b] != points_[0])
        fail("NumberOfPoints", b,
             "is " + to_string(points_[b]) + ", but " + to_string(points_[0]) +
                 " before: all topologies must have the same points");
    check_number("NumberOfPoints", 0, points_[0], " points");
    layout_.points = points_[0];
    layout_.cells = counts("NumberOfCells");
    layout_.connectivity_ids = counts("NumberOfConnectivityIds");
    for (std::size_t b = 0; b < layout_.cells.size(); ++b) check_number("NumberOfCells", b, layout_.cells[b], " cells");
  }

  void check_number(const std::string& name, std::size_t row, std::int64_t number, const std::string& what) const {
    if (number == 0 || number >= std::int64_t{kNone})
      fail(name, row, to_string(number) + what + ", but must have 1 .. " + to_string(kNone - 1));
  }

  void read_times() {
    temporal_ = file_.has(at("Steps"));
    if (!temporal_) {
      if (topologies_ != 1)
        file_.fail(at("NumberOfPoints"),
                   to_string(topologies_) + " pieces in a file without frames, but only one can be read");
      layout_.times = {0.0};
      return;
    }
    frames_ = file_.integer_attribute(at("Steps"), "NSteps", 1)[0];
    if (frames_ < 1) file_.fail(at("Steps@NSteps"), "is " + to_string(frames_) + ": no frames");
    if (frames_ > std::numeric_limits<int>::max())
      file_.fail(at("Steps@NSteps"), "is " + to_string(frames_) + ": too many");
    layout_.times = file_.values<double>(at("Steps/Values"), frames_);
    for (std::size_t k = 0; k < layout_.times.size(); ++k) {
      if (!std::isfinite(layout_.times[k])) fail("Steps/Values", k, "the time is not finite");
      if (k > 0 && !(layout_.times[k] > layout_.times[k - 1]))
        fail("Steps/Values", k, "the time is not after that of the frame before");
    }
  }

  void read_topologies() {
    layout_.topology = {0};
    if (!temporal_) return;
    layout_.topology = file_.values<std::int64_t>(at("Steps/PartOffsets"), frames_);
    for (std::size_t k = 0; k < layout_.topology.size(); ++k)
      if (layout_.topology[k] < 0 || layout_.topology[k] >= topologies_)
        fail("Steps/PartOffsets", k,
             "is " + to_string(layout_.topology[k]) + ", there are " + to_string(topologies_) + " topologies");
    if (!file_.has(at("Steps/NumberOfParts"))) return;
    const Integers pieces = file_.values<std::int64_t>(at("Steps/NumberOfParts"), frames_);
    for (std::size_t k = 0; k < pieces.size(); ++k)
      if (pieces[k] != 1)
        fail("Steps/NumberOfParts", k,
             "is " + to_string(pieces[k]) + ", but only one piece for each frame can be read");
  }

  /// An array and its table of the group Steps. A file without frames has no table, and a file with one frame needs
  /// none if it is `optional`.
  FrameArray array(const std::string& name, NumberKind kind, std::int64_t columns, const std::string& table_name,
                   bool optional = false) const {
    const std::string table = at("Steps/" + table_name);
    const bool has_table = temporal_ && (!optional || frames_ > 1 || file_.has(table));
    Hdf5Dataset data = file_.dataset(at(name), kind, columns);
    if (!has_table) return {std::move(data), {0}, ""};
    return {std::move(data), file_.values<std::int64_t>(table, frames_), table};
  }

  /// Adjusts the first rows of an array that has one entry more than `count` for every topology stored before.
  void add_topology_index(FrameArray& array) const {
    for (std::size_t k = 0; k < array.first.size(); ++k) {
      // A value out of range remains out of range, and the sum cannot overflow.
      if (array.first[k] >= 0 && array.first[k] <= array.data.rows()) array.first[k] += layout_.topology[k];
    }
  }

  /// Checks for every frame that its range [first, first + count(topology) + extra) is within the dataset.
  void check_slices(const FrameArray& array, const Integers& count, std::int64_t extra = 0) const {
    for (std::size_t k = 0; k < layout_.frames(); ++k) {
      const std::int64_t length = count[layout_.topology_of(k)] + extra, rows = array.data.rows();
      if (array.first[k] >= 0 && length <= rows && array.first[k] <= rows - length) continue;
      const std::string problem = "frame " + to_string(k) + " needs " + to_string(length) + " rows of " +
                                  array.data.path() + " from row " + to_string(array.first[k]) + " on, there are " +
                                  to_string(rows);
      if (array.table.empty()) array.data.fail(problem);
      file_.fail(array.table, k, problem);
    }
  }

  void read_geometry() {
    layout_.positions = array("Points", NumberKind::real, 3, "PointOffsets");
    layout_.types = array("Types", NumberKind::integer, 1, "CellOffsets");
    layout_.connectivity = array("Connectivity", NumberKind::integer, 1, "ConnectivityIdOffsets");
    layout_.offsets = array("Offsets", NumberKind::integer, 1, "CellOffsets");
    add_topology_index(layout_.offsets);
    check_slices(layout_.positions, points_);
    check_slices(layout_.types, layout_.cells);
    check_slices(layout_.connectivity, layout_.connectivity_ids);
    check_slices(layout_.offsets, layout_.cells, 1);
  }

  void read_polyhedra() {
    if (!file_.has(at("FaceConnectivity"))) return;
    PolyhedronLayout& polyhedra = layout_.polyhedra.emplace();
    polyhedra.faces = counts("NumberOfFaces");
    polyhedra.face_connectivity_ids = counts("NumberOfFaceConnectivityIds");
    polyhedra.to_face_ids = counts("NumberOfPolyhedronToFaceIds");
    polyhedra.face_connectivity = array("FaceConnectivity", NumberKind::integer, 1, "FaceConnectivityOffsets");
    polyhedra.to_faces = array("PolyhedronToFaces", NumberKind::integer, 1, "PolyhedronToFaceIdOffsets");
    polyhedra.face_offsets = array("FaceOffsets", NumberKind::integer, 1, "FaceOffsetsOffsets");
    polyhedra.offsets = array("PolyhedronOffsets", NumberKind::integer, 1, "CellOffsets");
    add_topology_index(polyhedra.face_offsets);
    add_topology_index(polyhedra.offsets);
    check_slices(polyhedra.face_connectivity, polyhedra.face_connectivity_ids);
    check_slices(polyhedra.to_faces, polyhedra.to_face_ids);
    check_slices(polyhedra.face_offsets, polyhedra.faces, 1);
    check_slices(polyhedra.offsets, layout_.cells, 1);
  }

  /// An array of the group PointData or CellData, if there is one, with count[b] rows for topology b.
  std::optional<FrameArray> data_array(const std::string& group, const std::string& field, NumberKind kind,
                                       std::int64_t columns, const Integers& count) const {
    const std::string name = group + "/" + field;
    if (!file_.has(at(name))) return std::nullopt;
    FrameArray result = array(name, kind, columns, group + "Offsets/" + field, true);
    check_slices(result, count);
    return result;
  }

  const Hdf5File& file_;
  SequenceLayout layout_;
  Integers points_;  ///< number of points of each topology
  bool temporal_ = false;
  std::int64_t frames_ = 1, topologies_ = 1;
};

}  // namespace

SequenceLayout read_layout(const Hdf5File& file) { return LayoutReader(file).read(); }

}  // namespace volccd::detail
