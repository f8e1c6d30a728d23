#include <volccd/io/sequence/reader.hpp>

#include <cassert>
#include <cmath>
#include <utility>

#include <fmt/format.h>

#include <volccd/core/error.hpp>
#include <volccd/io/sequence/detail/cell_reader.hpp>
#include <volccd/io/sequence/detail/importable.hpp>
#include <volccd/io/sequence/detail/layout.hpp>
#include <volccd/io/sequence/detail/point_order.hpp>

namespace volccd {

namespace {

SequenceMetadata read_metadata(const detail::Hdf5File& file) {
  const auto text = [&](const char* name) {
    return file.has_attribute("/", name) ? file.string_attribute("/", name) : std::string();
  };
  return {text("Title"),     text("Source"),   text("License"),
          text("Units"),     text("TimeUnit"), parse_object_names(file.name(), text("Parts")),
          text("Incomplete")};
}

}  // namespace

struct SequenceReader::Impl {
  explicit Impl(const std::string& name)
      : file(name),
        metadata(read_metadata(file)),
        layout(detail::read_layout(file)),
        order(layout),
        cells(layout, order) {}

  std::size_t index(int frame) const {
    assert(frame >= 0 && static_cast<std::size_t>(frame) < layout.frames());
    return static_cast<std::size_t>(frame);
  }
  /// Calls visit(row, vector) for `count` rows after the first `first` ones.
  template <class Visit>
  void visit_vectors(const detail::FrameArray& array, int frame, const char* what, Index first, Index count,
                     Visit&& visit) {
    array.read_part(index(frame), first, count, numbers);
    for (std::size_t i = 0; i < count; ++i) {
      const Vec3 p(numbers.data() + 3 * i);
      if (!p.allFinite())
        array.fail(index(frame), first + i,
                   fmt::format("the {} is not finite: {}, {}, {} (point id {}, frame {})", what, p[0], p[1], p[2],
                               order.ids()[order.slots()[first + i]], frame));
      visit(first + i, p);
    }
  }
  void read_vectors(const detail::FrameArray& array, int frame, const char* what, std::vector<Vec3>& out) {
    out.resize(static_cast<std::size_t>(layout.points));
    visit_vectors(array, frame, what, 0, static_cast<Index>(layout.points),
                  [&](std::size_t row, const Vec3& p) { out[order.slots()[row]] = p; });
  }
  void read_part(const detail::FrameArray& array, int frame, const char* what, Index first, Index count,
                 std::vector<Vec3>& out) {
    out.resize(count);
    visit_vectors(array, frame, what, first, count, [&](std::size_t row, const Vec3& p) { out[row - first] = p; });
  }
  /// The separation of a query, from the same rows.
  double read_separation(int frame, Index first, Index count) {
    layout.query_separation->read_part(index(frame), first, count, numbers);
    for (std::size_t i = 0; i < numbers.size(); ++i)
      if (!(std::isfinite(numbers[i]) && numbers[i] >= 0 && numbers[i] == numbers[0]))
        layout.query_separation->fail(
            index(frame), first + i,
            fmt::format("the separation is negative, not finite, or not that of the other points: {} (frame {})",
                        numbers[i], frame));
    return numbers.empty() ? 0 : numbers[0];
  }

  detail::Hdf5File file;
  SequenceMetadata metadata;
  detail::SequenceLayout layout;
  detail::PointOrder order;
  detail::CellReader cells;
  std::vector<double> numbers;
};

SequenceReader::SequenceReader(const std::string& file) {
  detail::refuse_importable(file);
  impl_ = std::make_unique<Impl>(file);
}
SequenceReader::SequenceReader(SequenceReader&&) noexcept = default;
SequenceReader& SequenceReader::operator=(SequenceReader&&) noexcept = default;
SequenceReader::~SequenceReader() = default;

const std::string& SequenceReader::file() const { return impl_->file.name(); }
const SequenceMetadata& SequenceReader::metadata() const { return impl_->metadata; }
int SequenceReader::frame_count() const { return static_cast<int>(impl_->layout.frames()); }
double SequenceReader::time(int frame) const { return impl_->layout.times[impl_->index(frame)]; }

Index SequenceReader::point_count() const { return static_cast<Index>(impl_->layout.points); }
std::span<const std::int64_t> SequenceReader::point_ids() const { return impl_->order.ids(); }
std::span<const Index> SequenceReader::slot_of_point() const { return impl_->order.slots(); }

Index SequenceReader::cell_count(int frame) const {
  return static_cast<Index>(impl_->layout.cells_of(impl_->index(frame)));
}
int SequenceReader::topology_index(int frame) const {
  return static_cast<int>(impl_->layout.topology[impl_->index(frame)]);
}
bool SequenceReader::same_cells(int frame, int other) const {
  return impl_->cells.have_same_cells(impl_->index(frame), impl_->index(other));
}

bool SequenceReader::has_velocity() const { return impl_->layout.velocity.has_value(); }
bool SequenceReader::has_thickness() const { return impl_->layout.thickness.has_value(); }
bool SequenceReader::has_query() const {
  return impl_->layout.query_start && impl_->layout.query_end && impl_->layout.query_separation;
}

void SequenceReader::read_points(int frame, std::vector<Vec3>& points) {
  impl_->order.check(impl_->layout, impl_->index(frame));
  impl_->read_vectors(impl_->layout.positions, frame, "point", points);
}

void SequenceReader::read_velocity(int frame, std::vector<Vec3>& velocity) {
  if (!has_velocity()) impl_->file.fail("VTKHDF/PointData/Velocity", "is missing");
  impl_->read_vectors(*impl_->layout.velocity, frame, "velocity", velocity);
}

double SequenceReader::read_query(int frame, std::vector<Vec3>& start, std::vector<Vec3>& end) {
  if (!has_query()) impl_->file.fail("VTKHDF/PointData/QueryStart, QueryEnd or QuerySeparation", "is missing");
  impl_->read_vectors(*impl_->layout.query_start, frame, "start of the query", start);
  impl_->read_vectors(*impl_->layout.query_end, frame, "end of the query", end);
  return impl_->read_separation(frame, 0, point_count());
}

bool SequenceReader::can_read_parts() const { return !impl_->layout.polyhedra; }

void SequenceReader::read_points(int frame, Index first, Index count, std::vector<Vec3>& points) {
  impl_->order.check(impl_->layout, impl_->index(frame));
  impl_->read_part(impl_->layout.positions, frame, "point", first, count, points);
}

double SequenceReader::read_query(int frame, Index first, Index count, std::vector<Vec3>& start,
                                  std::vector<Vec3>& end) {
  if (!has_query()) impl_->file.fail("VTKHDF/PointData/QueryStart, QueryEnd or QuerySeparation", "is missing");
  impl_->read_part(*impl_->layout.query_start, frame, "start of the query", first, count, start);
  impl_->read_part(*impl_->layout.query_end, frame, "end of the query", first, count, end);
  return impl_->read_separation(frame, first, count);
}

void SequenceReader::read_cells(int frame, Index first, Index count, SequenceCells& cells) {
  impl_->cells.read_part(impl_->index(frame), first, count, cells);
}

void SequenceReader::read_thickness(int frame, std::vector<double>& thickness) {
  if (!has_thickness()) impl_->file.fail("VTKHDF/CellData/Thickness", "is missing");
  const std::size_t k = impl_->index(frame);
  impl_->layout.thickness->read(k, impl_->layout.cells_of(k), thickness);
  for (std::size_t i = 0; i < thickness.size(); ++i)
    if (!(std::isfinite(thickness[i]) && thickness[i] >= 0))
      impl_->layout.thickness->fail(
          k, i, fmt::format("the thickness is negative or not finite: {}{}", thickness[i], impl_->cells.place(k, i)));
}

void SequenceReader::read_cells(int frame, SequenceCells& cells) { impl_->cells.read(impl_->index(frame), cells); }

const std::map<std::pair<ElementType, ElementType>, std::uint64_t>& SequenceReader::collapsed_cells() const {
  return impl_->cells.collapsed();
}

void SequenceReader::check_contents() {
  std::vector<Vec3> vectors, others;
  std::vector<double> thickness;
  SequenceCells cells;
  for (int k = 0; k < frame_count(); ++k) {
    read_points(k, vectors);
    if (has_velocity()) read_velocity(k, vectors);
    if (has_thickness()) read_thickness(k, thickness);
    if (has_query()) read_query(k, vectors, others);
    if (k == 0 || !same_cells(k, k - 1)) read_cells(k, cells);
  }
}

}  // namespace volccd
