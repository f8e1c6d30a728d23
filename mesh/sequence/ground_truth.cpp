#include <volccd/mesh/sequence/ground_truth.hpp>

#include <algorithm>
#include <cmath>
#include <utility>

#include <volccd/mesh/sequence/detail/hdf5_file.hpp>

namespace volccd {

namespace {

using detail::Hdf5Dataset;
using detail::Hdf5File;
using detail::NumberKind;

using IndexPair = std::array<std::int64_t, 2>;

class GroundTruthReader {
 public:
  GroundTruthReader(const Hdf5File& file, SequenceReader& sequence) : file_(file), sequence_(sequence) {}

  std::vector<KnownAnswer> read() {
    sequence_.read_cells(0, cells_);
    if (file_.has("GroundTruth/VertexFace")) read_kind("GroundTruth/VertexFace", FeatureKind::vf);
    if (file_.has("GroundTruth/EdgeEdge")) {
      read_edges();
      read_kind("GroundTruth/EdgeEdge", FeatureKind::ee);
    }
    return std::move(answers_);
  }

 private:
  void read_edges();
  void read_kind(const std::string& group, FeatureKind kind);
  std::array<std::int64_t, 4> vertex_face(const Hdf5Dataset& pairs, std::int64_t row, IndexPair pair) const;
  std::array<std::int64_t, 4> edge_edge(const Hdf5Dataset& pairs, std::int64_t row, IndexPair pair) const;
  void read_answers(const std::string& group, std::size_t first);

  /// Id of a point of the file.
  std::int64_t id(const Hdf5Dataset& data, std::int64_t row, std::int64_t point) const {
    check_range(data, row, "point", point, sequence_.point_count());
    return sequence_.point_ids()[sequence_.slot_of_point()[static_cast<std::size_t>(point)]];
  }
  static void check_range(const Hdf5Dataset& data, std::int64_t row, const char* what, std::int64_t index,
                          std::size_t count) {
    if (index < 0 || static_cast<std::size_t>(index) >= count)
      data.fail(row, std::string("the ") + what + " " + std::to_string(index) + " is out of range, there are " +
                         std::to_string(count));
  }

  const Hdf5File& file_;
  SequenceReader& sequence_;
  SequenceCells cells_;
  std::vector<IndexPair> edges_;  ///< ids, ascending
  std::vector<KnownAnswer> answers_;
};

void GroundTruthReader::read_edges() {
  const Hdf5Dataset data = file_.dataset("GroundTruth/Edges", NumberKind::integer, 2);
  std::vector<std::int64_t> points;
  data.read(0, data.rows(), points);
  edges_.resize(points.size() / 2);
  for (std::size_t e = 0; e < edges_.size(); ++e) {
    const std::int64_t row = static_cast<std::int64_t>(e);
    const std::int64_t a = id(data, row, points[2 * e]), b = id(data, row, points[2 * e + 1]);
    if (a == b) data.fail(row, "both ends of the edge are the same point");
    edges_[e] = {std::min(a, b), std::max(a, b)};
  }
}

std::array<std::int64_t, 4> GroundTruthReader::vertex_face(const Hdf5Dataset& pairs, std::int64_t row,
                                                           IndexPair pair) const {
  check_range(pairs, row, "cell", pair[1], cells_.size());
  const std::size_t cell = static_cast<std::size_t>(pair[1]);
  if (cells_.types[cell] != ElementType::triangle)
    pairs.fail(row, "the cell " + std::to_string(cell) + " is not a triangle");
  std::array<std::int64_t, 4> ids{id(pairs, row, pair[0]), 0, 0, 0};
  const std::span<const Index> corners = cells_.vertices(cell);
  for (std::size_t i = 0; i < 3; ++i) ids[i + 1] = sequence_.point_ids()[corners[i]];
  std::sort(ids.begin() + 1, ids.end());
  return ids;
}

std::array<std::int64_t, 4> GroundTruthReader::edge_edge(const Hdf5Dataset& pairs, std::int64_t row,
                                                         IndexPair pair) const {
  for (const std::int64_t e : pair) check_range(pairs, row, "edge", e, edges_.size());
  const auto [first, second] =
      std::minmax(edges_[static_cast<std::size_t>(pair[0])], edges_[static_cast<std::size_t>(pair[1])]);
  return {first[0], first[1], second[0], second[1]};
}

void GroundTruthReader::read_kind(const std::string& group, FeatureKind kind) {
  const Hdf5Dataset pairs = file_.dataset(group + "/Pairs", NumberKind::integer, 2);
  std::vector<std::int64_t> numbers;
  pairs.read(0, pairs.rows(), numbers);
  const std::size_t first = answers_.size();
  for (std::size_t i = 0; i < numbers.size() / 2; ++i) {
    const std::int64_t row = static_cast<std::int64_t>(i);
    const IndexPair pair{numbers[2 * i], numbers[2 * i + 1]};
    const std::array<std::int64_t, 4> ids =
        kind == FeatureKind::vf ? vertex_face(pairs, row, pair) : edge_edge(pairs, row, pair);
    std::array<std::int64_t, 4> sorted = ids;
    std::sort(sorted.begin(), sorted.end());
    if (std::adjacent_find(sorted.begin(), sorted.end()) != sorted.end())
      pairs.fail(row, "the two features have a common vertex");
    answers_.push_back({kind, ids, false});
  }
  read_answers(group, first);
}

void GroundTruthReader::read_answers(const std::string& group, std::size_t first) {
  const std::int64_t count = static_cast<std::int64_t>(answers_.size() - first);
  const Hdf5Dataset collides = file_.dataset(group + "/Collides", NumberKind::integer);
  if (collides.rows() != count)
    collides.fail("has " + std::to_string(collides.rows()) + " entries for " + std::to_string(count) + " pairs");
  std::vector<std::int64_t> flags;
  collides.read(0, count, flags);
  for (std::int64_t i = 0; i < count; ++i) {
    const std::int64_t flag = flags[static_cast<std::size_t>(i)];
    if (flag != 0 && flag != 1) collides.fail(i, "is " + std::to_string(flag) + ", but must be 0 or 1");
    answers_[first + static_cast<std::size_t>(i)].collides = flag == 1;
  }
  if (!file_.has(group + "/TimeOfImpact")) return;
  const Hdf5Dataset times = file_.dataset(group + "/TimeOfImpact", NumberKind::real);
  if (times.rows() != count)
    times.fail("has " + std::to_string(times.rows()) + " entries for " + std::to_string(count) + " pairs");
  std::vector<double> toi;
  times.read(0, count, toi);
  for (std::int64_t i = 0; i < count; ++i) {
    KnownAnswer& answer = answers_[first + static_cast<std::size_t>(i)];
    answer.toi = toi[static_cast<std::size_t>(i)];
    if (answer.collides ? !(answer.toi >= 0 && answer.toi <= 1) : !std::isnan(answer.toi))
      times.fail(i, answer.collides ? "the pair collides, but the time is not in [0, 1]"
                                    : "the pair does not collide, but there is a time");
  }
}

}  // namespace

std::optional<std::vector<KnownAnswer>> read_ground_truth(SequenceReader& reader) {
  const Hdf5File file(reader.file());
  if (!file.has("GroundTruth")) return std::nullopt;
  if (reader.step_count() < 2) file.fail("GroundTruth", "is there, but the file has one step only");
  return GroundTruthReader(file, reader).read();
}

}  // namespace volccd
