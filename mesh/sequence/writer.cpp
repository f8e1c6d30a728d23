#include <volccd/mesh/sequence/writer.hpp>

#include <algorithm>
#include <cmath>
#include <optional>
#include <utility>
#include <vector>

#include <volccd/core/error.hpp>
#include <volccd/core/output_file.hpp>
#include <volccd/mesh/sequence/detail/hdf5_output.hpp>
#include <volccd/mesh/sequence/detail/step_check.hpp>

namespace volccd {

namespace {

using detail::GrowingDataset;
using detail::StoredType;
using Integers = std::vector<std::int64_t>;

/// Number of rows per chunk: about 16384, and such that `rows` rows fill whole chunks except for a few entries.
std::int64_t chunk_rows(std::size_t rows) {
  constexpr std::size_t kRows = 16384;
  const std::size_t chunks = std::max<std::size_t>((rows + kRows - 1) / kRows, 1);
  return static_cast<std::int64_t>(std::max<std::size_t>((rows + chunks - 1) / chunks, 16));
}

template <class Range>
Integers wide(const Range& values) {
  return {values.begin(), values.end()};
}

}  // namespace

struct SequenceWriter::Impl {
  /// The face arrays of VTKHDF 2.5.
  struct Polyhedra {
    GrowingDataset face_connectivity, face_offsets, to_faces, offsets;
    Integers faces, face_connectivity_ids, to_face_ids;           ///< per topology
    Integers face_first, face_connectivity_first, to_face_first;  ///< per step
  };

  Impl(const std::string& file, std::span<const std::int64_t> ids, SequenceMetadata given, SequenceForm wanted)
      : target(file, kSequenceIsNoStream),
        output(target.temporary(), file),
        metadata(std::move(given)),
        form(wanted),
        point_ids(wide(ids)) {}

  void check(double time, std::span<const Vec3> points, const SequenceCells& cells, const StepFields& fields) const;
  void check_query(const StepFields& fields, const detail::StepPlace& place) const;
  void check_single(const SequenceCells& cells) const;
  void make_datasets(const SequenceCells& cells, const StepFields& fields);
  void append_topology(const SequenceCells& cells);
  void make_polyhedra();
  void append_polyhedra(const SequenceCells& cells);
  void append_vectors(GrowingDataset& dataset, std::span<const Vec3> vectors);
  void append_query(const StepFields& fields);
  void append_tables(double time, const StepFields& fields);
  void write_header();
  void write_counts();
  void write_tables();
  void close();

  /// Declared first and therefore destroyed last: the file is closed before it is removed.
  OutputFile target;
  detail::Hdf5Output output;
  SequenceMetadata metadata;
  SequenceForm form;
  Integers point_ids;
  bool usable = true;

  std::optional<GrowingDataset> positions, velocity, connectivity, offsets, types, parts, cell_ids, thickness,
      query_start, query_end, query_separation;
  std::optional<Polyhedra> polyhedra;
  SequenceCells last;
  std::vector<double> times, numbers;
  Integers cell_counts, connectivity_counts;  ///< per topology
  Integers topology, point_first, cell_first, connectivity_first, velocity_first, thickness_first,
      query_first;  ///< per step
};

SequenceWriter::SequenceWriter(const std::string& file, std::span<const std::int64_t> point_ids,
                               SequenceMetadata metadata, SequenceForm form) {
  detail::check_ids(file, "VTKHDF/PointData/GlobalPointIds", point_ids);
  if (point_ids.empty()) throw InputError(file, "VTKHDF/PointData/GlobalPointIds", "no points");
  impl_ = std::make_unique<Impl>(file, point_ids, std::move(metadata), form);
  impl_->write_header();
}

SequenceWriter::SequenceWriter(SequenceWriter&&) noexcept = default;
SequenceWriter::~SequenceWriter() = default;

void SequenceWriter::write_step(double time, std::span<const Vec3> points, const SequenceCells& cells,
                                const StepFields& fields) {
  Impl& o = *impl_;
  if (!std::exchange(o.usable, false))
    throw InputError(o.target.name(), "", "the writer has failed or finished before");
  o.check(time, points, cells, fields);
  if (o.times.empty()) o.make_datasets(cells, fields);
  if (o.times.empty() || !(cells == o.last)) o.append_topology(cells);
  o.append_tables(time, fields);
  o.append_vectors(*o.positions, points);
  if (o.velocity) o.append_vectors(*o.velocity, fields.velocity);
  if (o.thickness) o.thickness->append(fields.thickness);
  if (o.query_start) o.append_query(fields);
  o.usable = true;
}

void SequenceWriter::finish(const std::string& incomplete) {
  Impl& o = *impl_;
  if (!std::exchange(o.usable, false))
    throw InputError(o.target.name(), "", "the writer has failed or finished before");
  if (o.times.empty()) throw InputError(o.target.name(), "VTKHDF/Steps/Values", "no step has been written");
  if (!incomplete.empty()) o.output.string_attribute("/", "Incomplete", incomplete);
  o.write_counts();
  if (o.form == SequenceForm::temporal)
    o.write_tables();
  else
    o.output.reals("VTKHDF/FieldData/TimeValue", o.times);
  o.close();
  o.target.commit();
}

void SequenceWriter::Impl::check(double time, std::span<const Vec3> points, const SequenceCells& cells,
                                 const StepFields& fields) const {
  const std::string& file = target.name();
  const std::int64_t step = static_cast<std::int64_t>(times.size());
  if (!std::isfinite(time) || (!times.empty() && !(time > times.back())))
    throw InputError(file, "VTKHDF/Steps/Values", step, "the time is not finite or not after that of the step before");
  const detail::StepPlace place{step, point_ids};
  detail::check_vectors(file, "VTKHDF/Points", points, place);
  if (form == SequenceForm::single) check_single(cells);
  const bool first = times.empty();
  if (!first && velocity.has_value() == fields.velocity.empty())
    throw InputError(file, "VTKHDF/PointData/Velocity", step, "is given at some steps and not at others");
  if (!first && thickness.has_value() == fields.thickness.empty())
    throw InputError(file, "VTKHDF/CellData/Thickness", step, "is given at some steps and not at others");
  if (!fields.velocity.empty()) detail::check_vectors(file, "VTKHDF/PointData/Velocity", fields.velocity, place);
  check_query(fields, place);
  if (!fields.thickness.empty())
    detail::check_thickness(file, "VTKHDF/CellData/Thickness", fields.thickness, cells, place);
  if (first || !(cells == last)) detail::check_cells(file, cells, place);
}

void SequenceWriter::Impl::check_query(const StepFields& fields, const detail::StepPlace& place) const {
  const char *start = "VTKHDF/PointData/QueryStart", *end = "VTKHDF/PointData/QueryEnd";
  if (fields.query_start.empty() != fields.query_end.empty())
    throw InputError(target.name(), fields.query_start.empty() ? start : end, place.step,
                     "is missing beside the other");
  if (!times.empty() && query_start.has_value() == fields.query_start.empty())
    throw InputError(target.name(), start, place.step, "is given at some steps and not at others");
  if (fields.query_start.empty()) return;
  detail::check_vectors(target.name(), start, fields.query_start, place);
  detail::check_vectors(target.name(), end, fields.query_end, place);
  if (!(std::isfinite(fields.query_separation) && fields.query_separation >= 0))
    throw InputError(target.name(), "VTKHDF/PointData/QuerySeparation", place.step, "is negative or not finite");
}

void SequenceWriter::Impl::check_single(const SequenceCells& cells) const {
  if (!times.empty()) throw InputError(target.name(), "VTKHDF/Steps", 1, "is a second step: this form has one");
  if (!cells.face_offsets.empty())
    throw InputError(target.name(), "VTKHDF/Types",
                     "there are polyhedra, which VTKHDF 1.0 does not have: the temporal form keeps them");
}

void SequenceWriter::Impl::write_header() {
  const auto text = [&](const char* name, const std::string& value) {
    if (!value.empty()) output.string_attribute("/", name, value);
  };
  text("Title", metadata.title);
  text("Source", metadata.source);
  text("License", metadata.license);
  text("Units", metadata.units);
  text("TimeUnit", metadata.time_unit);
  text("Parts", format_part_names(metadata.part_names));
  for (const char* path : {"VTKHDF", "VTKHDF/PointData", "VTKHDF/CellData"}) output.group(path);
  if (form == SequenceForm::temporal)
    for (const char* path : {"VTKHDF/Steps", "VTKHDF/Steps/PointDataOffsets", "VTKHDF/Steps/CellDataOffsets"})
      output.group(path);
  else
    output.group("VTKHDF/FieldData");
  output.string_attribute("VTKHDF", "Type", "UnstructuredGrid");
  output.integers("VTKHDF/PointData/GlobalPointIds", point_ids);
}

void SequenceWriter::Impl::make_datasets(const SequenceCells& cells, const StepFields& fields) {
  const std::int64_t point_rows = chunk_rows(point_ids.size()), cell_rows = chunk_rows(cells.size());
  positions = output.growing("VTKHDF/Points", StoredType::float64, 3, point_rows);
  connectivity = output.growing("VTKHDF/Connectivity", StoredType::int64, 1, chunk_rows(cells.connectivity.size()));
  offsets = output.growing("VTKHDF/Offsets", StoredType::int64, 1, cell_rows);
  types = output.growing("VTKHDF/Types", StoredType::uint8, 1, cell_rows);
  parts = output.growing("VTKHDF/CellData/PartId", StoredType::int32, 1, cell_rows);
  cell_ids = output.growing("VTKHDF/CellData/GlobalCellIds", StoredType::int64, 1, cell_rows);
  if (!fields.velocity.empty())
    velocity = output.growing("VTKHDF/PointData/Velocity", StoredType::float64, 3, point_rows);
  if (!fields.query_start.empty()) {
    query_start = output.growing("VTKHDF/PointData/QueryStart", StoredType::float64, 3, point_rows);
    query_end = output.growing("VTKHDF/PointData/QueryEnd", StoredType::float64, 3, point_rows);
    query_separation = output.growing("VTKHDF/PointData/QuerySeparation", StoredType::float64, 1, point_rows);
  }
  if (!fields.thickness.empty())
    thickness = output.growing("VTKHDF/CellData/Thickness", StoredType::float64, 1, cell_rows);
}

void SequenceWriter::Impl::append_topology(const SequenceCells& cells) {
  if (!polyhedra && !cells.face_offsets.empty()) make_polyhedra();
  Integers numbers_of_types;
  for (const ElementType type : cells.types) numbers_of_types.push_back(static_cast<std::int64_t>(type));
  types->append(numbers_of_types);
  offsets->append(wide(cells.offsets));
  connectivity->append(wide(cells.connectivity));
  parts->append(wide(cells.parts));
  cell_ids->append(cells.ids);
  if (polyhedra) append_polyhedra(cells);
  cell_counts.push_back(static_cast<std::int64_t>(cells.size()));
  connectivity_counts.push_back(static_cast<std::int64_t>(cells.connectivity.size()));
  last = cells;
}

void SequenceWriter::Impl::make_polyhedra() {
  Polyhedra& p = polyhedra.emplace();
  p.face_connectivity = output.growing("VTKHDF/FaceConnectivity", StoredType::int64, 1, 16384);
  p.face_offsets = output.growing("VTKHDF/FaceOffsets", StoredType::int64, 1, 16384);
  p.to_faces = output.growing("VTKHDF/PolyhedronToFaces", StoredType::int64, 1, 16384);
  p.offsets = output.growing("VTKHDF/PolyhedronOffsets", StoredType::int64, 1, 16384);
  // The steps written before had no polytopes.
  for (const std::int64_t cells : cell_counts) {
    p.face_offsets.append(Integers{0});
    p.offsets.append(Integers(static_cast<std::size_t>(cells) + 1, 0));
  }
  p.faces = p.face_connectivity_ids = p.to_face_ids = Integers(cell_counts.size(), 0);
  p.face_first = p.face_connectivity_first = p.to_face_first = Integers(times.size(), 0);
}

void SequenceWriter::Impl::append_polyhedra(const SequenceCells& cells) {
  Integers points, face_ends{0}, to_faces, cell_ends{0};
  for (std::size_t i = 0; i < cells.size(); ++i) {
    visit_faces(cells.face_stream(i), [&](std::span<const Index> face) {
      points.insert(points.end(), face.begin(), face.end());
      to_faces.push_back(static_cast<std::int64_t>(to_faces.size()));
      face_ends.push_back(static_cast<std::int64_t>(points.size()));
    });
    cell_ends.push_back(static_cast<std::int64_t>(to_faces.size()));
  }
  polyhedra->face_connectivity.append(points);
  polyhedra->face_offsets.append(face_ends);
  polyhedra->to_faces.append(to_faces);
  polyhedra->offsets.append(cell_ends);
  polyhedra->faces.push_back(static_cast<std::int64_t>(to_faces.size()));
  polyhedra->face_connectivity_ids.push_back(static_cast<std::int64_t>(points.size()));
  polyhedra->to_face_ids.push_back(static_cast<std::int64_t>(to_faces.size()));
}

void SequenceWriter::Impl::append_vectors(GrowingDataset& dataset, std::span<const Vec3> vectors) {
  numbers.clear();
  for (const Vec3& v : vectors) numbers.insert(numbers.end(), v.data(), v.data() + 3);
  dataset.append(numbers);
}

void SequenceWriter::Impl::append_query(const StepFields& fields) {
  append_vectors(*query_start, fields.query_start);
  append_vectors(*query_end, fields.query_end);
  query_separation->append(std::vector<double>(fields.query_start.size(), fields.query_separation));
}

void SequenceWriter::Impl::append_tables(double time, const StepFields& fields) {
  const std::int64_t b = static_cast<std::int64_t>(cell_counts.size()) - 1;
  times.push_back(time);
  topology.push_back(b);
  point_first.push_back(positions->rows());
  // The topology has already been appended; it starts at the number of rows minus its own.
  cell_first.push_back(types->rows() - cell_counts.back());
  connectivity_first.push_back(connectivity->rows() - connectivity_counts.back());
  if (!fields.velocity.empty()) velocity_first.push_back(velocity->rows());
  if (!fields.query_start.empty()) query_first.push_back(query_start->rows());
  if (!fields.thickness.empty()) thickness_first.push_back(thickness->rows());
  if (!polyhedra) return;
  polyhedra->face_first.push_back(polyhedra->face_offsets.rows() - b - 1 - polyhedra->faces.back());
  polyhedra->face_connectivity_first.push_back(polyhedra->face_connectivity.rows() -
                                               polyhedra->face_connectivity_ids.back());
  polyhedra->to_face_first.push_back(polyhedra->to_faces.rows() - polyhedra->to_face_ids.back());
}

void SequenceWriter::Impl::write_counts() {
  const bool temporal = form == SequenceForm::temporal;
  output.integer_attribute("VTKHDF", "Version", temporal ? Integers{2, polyhedra ? 5 : 2} : Integers{1, 0});
  output.integers("VTKHDF/NumberOfPoints", Integers(cell_counts.size(), static_cast<std::int64_t>(point_ids.size())));
  output.integers("VTKHDF/NumberOfCells", cell_counts);
  output.integers("VTKHDF/NumberOfConnectivityIds", connectivity_counts);
}

void SequenceWriter::Impl::write_tables() {
  const Integers zeros(times.size(), 0);
  output.integer_attribute("VTKHDF/Steps", "NSteps", static_cast<std::int64_t>(times.size()));
  output.reals("VTKHDF/Steps/Values", times);
  output.integers("VTKHDF/Steps/PartOffsets", topology);
  output.integers("VTKHDF/Steps/NumberOfParts", Integers(times.size(), 1));
  output.integers("VTKHDF/Steps/PointOffsets", point_first);
  output.integers("VTKHDF/Steps/CellOffsets", cell_first, true);
  output.integers("VTKHDF/Steps/ConnectivityIdOffsets", connectivity_first, true);
  output.integers("VTKHDF/Steps/PointDataOffsets/GlobalPointIds", zeros);
  if (velocity) output.integers("VTKHDF/Steps/PointDataOffsets/Velocity", velocity_first);
  if (query_start)
    for (const std::string name : {"QueryStart", "QueryEnd", "QuerySeparation"})
      output.integers("VTKHDF/Steps/PointDataOffsets/" + name, query_first);
  output.integers("VTKHDF/Steps/CellDataOffsets/PartId", cell_first);
  output.integers("VTKHDF/Steps/CellDataOffsets/GlobalCellIds", cell_first);
  if (thickness) output.integers("VTKHDF/Steps/CellDataOffsets/Thickness", thickness_first);
  if (!polyhedra) return;
  output.integers("VTKHDF/NumberOfFaces", polyhedra->faces);
  output.integers("VTKHDF/NumberOfFaceConnectivityIds", polyhedra->face_connectivity_ids);
  output.integers("VTKHDF/NumberOfPolyhedronToFaceIds", polyhedra->to_face_ids);
  output.integers("VTKHDF/Steps/FaceOffsetsOffsets", polyhedra->face_first);
  output.integers("VTKHDF/Steps/FaceConnectivityOffsets", polyhedra->face_connectivity_first);
  output.integers("VTKHDF/Steps/PolyhedronToFaceIdOffsets", polyhedra->to_face_first);
}

void SequenceWriter::Impl::close() {
  for (auto* dataset : {&positions, &velocity, &connectivity, &offsets, &types, &parts, &cell_ids, &thickness,
                        &query_start, &query_end, &query_separation})
    dataset->reset();
  polyhedra.reset();
  output.close();
}

}  // namespace volccd
