#include <volccd/io/sequence/writer.hpp>

#include <algorithm>
#include <cmath>
#include <map>
#include <numeric>
#include <utility>
#include <vector>

#include <volccd/core/error.hpp>
#include <volccd/io/hdf5/detail/hdf5_output.hpp>
#include <volccd/io/output_file.hpp>
#include <volccd/io/sequence/detail/frame_check.hpp>

namespace volccd {

namespace {

using detail::GrowingDataset;
using Integers = std::vector<std::int64_t>;

constexpr std::size_t kChunkRows = 16384;

/// Number of rows per chunk: about kChunkRows, and such that `rows` rows fill whole chunks except for a few entries.
std::int64_t chunk_rows(std::size_t rows) {
  const std::size_t chunks = std::max<std::size_t>((rows + kChunkRows - 1) / kChunkRows, 1);
  return static_cast<std::int64_t>(std::max<std::size_t>((rows + chunks - 1) / chunks, 16));
}

template <class Range>
Integers wide(const Range& values) {
  return {values.begin(), values.end()};
}

/// For each value, the sum of those before it.
Integers sums_before(const Integers& values) {
  Integers sums(values.size());
  std::exclusive_scan(values.begin(), values.end(), sums.begin(), std::int64_t{0});
  return sums;
}

}  // namespace

struct SequenceWriter::Impl {
  Impl(const std::string& file, std::span<const std::int64_t> ids, SequenceForm wanted)
      : target(file, kSequenceIsNoStream), output(target.temporary(), file), form(wanted), point_ids(wide(ids)) {}

  [[noreturn]] void fail(const std::string& path, const std::string& problem) const {
    throw InputError(target.name(), path, static_cast<std::int64_t>(times.size()), problem);
  }

  bool has(const std::string& path) const { return data.contains(path); }
  template <class Values>
  void append(const std::string& path, const Values& values) {
    data.at(path).append(values);
  }

  void check(double time, std::span<const Vec3> points, const SequenceCells& cells, const FrameFields& fields) const {
    if (!std::isfinite(time) || (!times.empty() && !(time > times.back())))
      fail("VTKHDF/Steps/Values", "the time is not finite or not after that of the frame before");
    const detail::FramePlace place{target.name(), static_cast<std::int64_t>(times.size()), point_ids};
    detail::check_vectors("VTKHDF/Points", points, place);
    const bool single = form == SequenceForm::single;
    if (single && !times.empty()) fail("VTKHDF/Steps", "is a second frame: this form has one");
    if (single && !cells.face_offsets.empty())
      throw InputError(target.name(), "VTKHDF/Types",
                       "there are polyhedra, which VTKHDF 1.0 does not have: the temporal form keeps them");
    check_given("PointData/Velocity", !fields.velocity.empty());
    check_given("CellData/Thickness", !fields.thickness.empty());
    if (!fields.velocity.empty()) detail::check_vectors("VTKHDF/PointData/Velocity", fields.velocity, place);
    check_query(fields, place);
    if (!fields.thickness.empty()) detail::check_thickness("VTKHDF/CellData/Thickness", fields.thickness, cells, place);
    if (times.empty() || !(cells == last)) detail::check_cells(cells, place);
  }

  void check_given(const std::string& path, bool given) const {
    if (!times.empty() && has(path) != given) fail("VTKHDF/" + path, "is given at some frames and not at others");
  }

  void check_query(const FrameFields& fields, const detail::FramePlace& place) const {
    const char *start = "VTKHDF/PointData/QueryStart", *end = "VTKHDF/PointData/QueryEnd";
    if (fields.query_start.empty() != fields.query_end.empty())
      fail(fields.query_start.empty() ? start : end, "is missing beside the other");
    check_given("PointData/QueryStart", !fields.query_start.empty());
    if (fields.query_start.empty()) return;
    detail::check_vectors(start, fields.query_start, place);
    detail::check_vectors(end, fields.query_end, place);
    if (!(std::isfinite(fields.query_separation) && fields.query_separation >= 0))
      fail("VTKHDF/PointData/QuerySeparation", "is negative or not finite");
  }

  void make(const std::string& path, hid_t type, std::int64_t columns, std::size_t rows) {
    data.emplace(path, output.growing("VTKHDF/" + path, type, columns, chunk_rows(rows)));
  }

  void make_datasets(const SequenceCells& cells, const FrameFields& fields) {
    make("Points", H5T_IEEE_F64LE, 3, point_ids.size());
    make("Connectivity", H5T_STD_I64LE, 1, cells.connectivity.size());
    make("Offsets", H5T_STD_I64LE, 1, cells.size());
    make("Types", H5T_STD_U8LE, 1, cells.size());
    make("CellData/PartId", H5T_STD_I32LE, 1, cells.size());
    make("CellData/GlobalCellIds", H5T_STD_I64LE, 1, cells.size());
    if (!fields.velocity.empty()) make("PointData/Velocity", H5T_IEEE_F64LE, 3, point_ids.size());
    if (!fields.query_start.empty()) {
      make("PointData/QueryStart", H5T_IEEE_F64LE, 3, point_ids.size());
      make("PointData/QueryEnd", H5T_IEEE_F64LE, 3, point_ids.size());
      make("PointData/QuerySeparation", H5T_IEEE_F64LE, 1, point_ids.size());
    }
    if (!fields.thickness.empty()) make("CellData/Thickness", H5T_IEEE_F64LE, 1, cells.size());
  }

  void append_topology(const SequenceCells& cells) {
    if (!has("FaceOffsets") && !cells.face_offsets.empty()) make_polyhedra();
    Integers types;
    for (const ElementType type : cells.types) types.push_back(static_cast<std::int64_t>(type));
    append("Types", types);
    append("Offsets", wide(cells.offsets));
    append("Connectivity", wide(cells.connectivity));
    append("CellData/PartId", wide(cells.objects));
    append("CellData/GlobalCellIds", cells.ids);
    if (has("FaceOffsets")) append_polyhedra(cells);
    cell_counts.push_back(static_cast<std::int64_t>(cells.size()));
    connectivity_counts.push_back(static_cast<std::int64_t>(cells.connectivity.size()));
    last = cells;
  }

  /// Makes the face arrays of VTKHDF 2.5.
  void make_polyhedra() {
    for (const char* path : {"FaceConnectivity", "FaceOffsets", "PolyhedronToFaces", "PolyhedronOffsets"})
      make(path, H5T_STD_I64LE, 1, kChunkRows);
    // The frames written before had no polytopes.
    for (const std::int64_t cells : cell_counts) {
      append("FaceOffsets", Integers{0});
      append("PolyhedronOffsets", Integers(static_cast<std::size_t>(cells) + 1, 0));
    }
    face_counts = face_connectivity_counts = Integers(cell_counts.size(), 0);
  }

  void append_polyhedra(const SequenceCells& cells) {
    Integers points, face_ends{0}, to_faces, cell_ends{0};
    for (std::size_t i = 0; i < cells.size(); ++i) {
      visit_faces(cells.face_stream(i), [&](std::span<const Index> face) {
        points.insert(points.end(), face.begin(), face.end());
        to_faces.push_back(static_cast<std::int64_t>(to_faces.size()));
        face_ends.push_back(static_cast<std::int64_t>(points.size()));
      });
      cell_ends.push_back(static_cast<std::int64_t>(to_faces.size()));
    }
    append("FaceConnectivity", points);
    append("FaceOffsets", face_ends);
    append("PolyhedronToFaces", to_faces);
    append("PolyhedronOffsets", cell_ends);
    face_counts.push_back(static_cast<std::int64_t>(to_faces.size()));
    face_connectivity_counts.push_back(static_cast<std::int64_t>(points.size()));
  }

  void append_vectors(const std::string& path, std::span<const Vec3> vectors) {
    numbers.clear();
    for (const Vec3& v : vectors) numbers.insert(numbers.end(), v.data(), v.data() + 3);
    append(path, numbers);
  }

  void write_header(const SequenceMetadata& metadata) {
    const auto text = [&](const char* name, const std::string& value) {
      if (!value.empty()) output.string_attribute("/", name, value);
    };
    text("Title", metadata.title);
    text("Source", metadata.source);
    text("License", metadata.license);
    text("Units", metadata.units);
    text("TimeUnit", metadata.time_unit);
    text("Parts", format_object_names(metadata.object_names));
    for (const char* path : {"VTKHDF", "VTKHDF/PointData", "VTKHDF/CellData"}) output.group(path);
    if (form == SequenceForm::temporal)
      for (const char* path : {"VTKHDF/Steps", "VTKHDF/Steps/PointDataOffsets", "VTKHDF/Steps/CellDataOffsets"})
        output.group(path);
    else
      output.group("VTKHDF/FieldData");
    output.string_attribute("VTKHDF", "Type", "UnstructuredGrid");
    output.integers("VTKHDF/PointData/GlobalPointIds", point_ids);
  }

  /// The values of the topologies that the frames use.
  Integers of_frames(const Integers& of_topologies) const {
    Integers values;
    for (const std::int64_t b : topology) values.push_back(of_topologies[static_cast<std::size_t>(b)]);
    return values;
  }

  void write_tables() {
    const Integers version = form == SequenceForm::single ? Integers{1, 0} : Integers{2, has("FaceOffsets") ? 5 : 2};
    output.integer_attribute("VTKHDF", "Version", version);
    output.integers("VTKHDF/NumberOfPoints", Integers(cell_counts.size(), static_cast<std::int64_t>(point_ids.size())));
    output.integers("VTKHDF/NumberOfCells", cell_counts);
    output.integers("VTKHDF/NumberOfConnectivityIds", connectivity_counts);
    if (form == SequenceForm::single) return output.reals("VTKHDF/FieldData/TimeValue", times);
    const Integers zeros(times.size(), 0);
    const Integers point_first = sums_before(Integers(times.size(), static_cast<std::int64_t>(point_ids.size())));
    const Integers cell_first = of_frames(sums_before(cell_counts));
    output.integer_attribute("VTKHDF/Steps", "NSteps", Integers{static_cast<std::int64_t>(times.size())});
    output.reals("VTKHDF/Steps/Values", times);
    output.integers("VTKHDF/Steps/PartOffsets", topology);
    output.integers("VTKHDF/Steps/NumberOfParts", Integers(times.size(), 1));
    output.integers("VTKHDF/Steps/PointOffsets", point_first);
    output.integers("VTKHDF/Steps/CellOffsets", cell_first, true);
    output.integers("VTKHDF/Steps/ConnectivityIdOffsets", of_frames(sums_before(connectivity_counts)), true);
    output.integers("VTKHDF/Steps/PointDataOffsets/GlobalPointIds", zeros);
    for (const std::string name : {"Velocity", "QueryStart", "QueryEnd", "QuerySeparation"})
      if (has("PointData/" + name)) output.integers("VTKHDF/Steps/PointDataOffsets/" + name, point_first);
    output.integers("VTKHDF/Steps/CellDataOffsets/PartId", cell_first);
    output.integers("VTKHDF/Steps/CellDataOffsets/GlobalCellIds", cell_first);
    // Each frame has its own thickness, even if its cells are those of the frame before.
    if (has("CellData/Thickness"))
      output.integers("VTKHDF/Steps/CellDataOffsets/Thickness", sums_before(of_frames(cell_counts)));
    if (!has("FaceOffsets")) return;
    output.integers("VTKHDF/NumberOfFaces", face_counts);
    output.integers("VTKHDF/NumberOfFaceConnectivityIds", face_connectivity_counts);
    output.integers("VTKHDF/NumberOfPolyhedronToFaceIds", face_counts);
    output.integers("VTKHDF/Steps/FaceOffsetsOffsets", of_frames(sums_before(face_counts)));
    output.integers("VTKHDF/Steps/FaceConnectivityOffsets", of_frames(sums_before(face_connectivity_counts)));
    output.integers("VTKHDF/Steps/PolyhedronToFaceIdOffsets", of_frames(sums_before(face_counts)));
  }

  /// The order in which datasets are closed determines where their last chunks are in the file.
  void close() {
    for (const char* path :
         {"Points", "PointData/Velocity", "Connectivity", "Offsets", "Types", "CellData/PartId",
          "CellData/GlobalCellIds", "CellData/Thickness", "PointData/QueryStart", "PointData/QueryEnd",
          "PointData/QuerySeparation", "PolyhedronOffsets", "PolyhedronToFaces", "FaceOffsets", "FaceConnectivity"})
      data.erase(path);
    output.close();
  }

  /// Declared first and therefore destroyed last: the file is closed before it is removed.
  OutputFile target;
  detail::Hdf5Output output;
  SequenceForm form;
  Integers point_ids;
  bool usable = true;

  std::map<std::string, GrowingDataset> data;  ///< by their paths in the group VTKHDF
  SequenceCells last;
  std::vector<double> times, numbers;
  Integers topology;                               ///< per frame
  Integers cell_counts, connectivity_counts;       ///< per topology
  Integers face_counts, face_connectivity_counts;  ///< per topology, if there are polytopes; each face is in one list
};

SequenceWriter::SequenceWriter(const std::string& file, std::span<const std::int64_t> point_ids,
                               const SequenceMetadata& metadata, SequenceForm form) {
  detail::check_ids(file, "VTKHDF/PointData/GlobalPointIds", point_ids);
  if (point_ids.empty()) throw InputError(file, "VTKHDF/PointData/GlobalPointIds", "no points");
  impl_ = std::make_unique<Impl>(file, point_ids, form);
  impl_->write_header(metadata);
}

SequenceWriter::SequenceWriter(SequenceWriter&&) noexcept = default;
SequenceWriter::~SequenceWriter() = default;

void SequenceWriter::write_frame(double time, std::span<const Vec3> points, const SequenceCells& cells,
                                 const FrameFields& fields) {
  Impl& o = *impl_;
  if (!std::exchange(o.usable, false))
    throw InputError(o.target.name(), "", "the writer has failed or finished before");
  o.check(time, points, cells, fields);
  if (o.times.empty()) o.make_datasets(cells, fields);
  if (o.times.empty() || !(cells == o.last)) o.append_topology(cells);
  o.times.push_back(time);
  o.topology.push_back(static_cast<std::int64_t>(o.cell_counts.size()) - 1);
  o.append_vectors("Points", points);
  if (o.has("PointData/Velocity")) o.append_vectors("PointData/Velocity", fields.velocity);
  if (o.has("CellData/Thickness")) o.append("CellData/Thickness", fields.thickness);
  if (o.has("PointData/QueryStart")) {
    o.append_vectors("PointData/QueryStart", fields.query_start);
    o.append_vectors("PointData/QueryEnd", fields.query_end);
    o.append("PointData/QuerySeparation", std::vector<double>(points.size(), fields.query_separation));
  }
  o.usable = true;
}

void SequenceWriter::finish(const std::string& incomplete) {
  Impl& o = *impl_;
  if (!std::exchange(o.usable, false))
    throw InputError(o.target.name(), "", "the writer has failed or finished before");
  if (o.times.empty()) throw InputError(o.target.name(), "VTKHDF/Steps/Values", "no frame has been written");
  if (!incomplete.empty()) o.output.string_attribute("/", "Incomplete", incomplete);
  o.write_tables();
  o.close();
  o.target.commit();
}

}  // namespace volccd
