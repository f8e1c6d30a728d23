#include <volccd/io/sequence/ground_truth.hpp>

#include <algorithm>
#include <cmath>
#include <span>
#include <utility>

#include <fmt/format.h>

#include <volccd/io/hdf5/detail/hdf5_file.hpp>

namespace volccd {

namespace {

using detail::Hdf5File;

using IndexPair = std::array<std::int64_t, 2>;
using FourIds = std::array<std::int64_t, 4>;

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
  std::vector<IndexPair> index_pairs(const std::string& path) const {
    const detail::Hdf5Dataset data = file_.dataset(path, detail::NumberKind::integer, 2);
    std::vector<std::int64_t> numbers;
    data.read(0, data.rows(), numbers);
    std::vector<IndexPair> pairs(numbers.size() / 2);
    for (std::size_t i = 0; i < pairs.size(); ++i) pairs[i] = {numbers[2 * i], numbers[2 * i + 1]};
    return pairs;
  }

  void check_range(const std::string& path, std::size_t row, const char* what, std::int64_t index,
                   std::size_t count) const {
    if (index < 0 || static_cast<std::size_t>(index) >= count)
      file_.fail(path, row, fmt::format("the {} {} is out of range, there are {}", what, index, count));
  }

  /// Id of a point of the file.
  std::int64_t id(const std::string& path, std::size_t row, std::int64_t point) const {
    check_range(path, row, "point", point, sequence_.point_count());
    return sequence_.point_ids()[sequence_.slot_of_point()[static_cast<std::size_t>(point)]];
  }

  void read_edges() {
    const std::string path = "GroundTruth/Edges";
    for (const IndexPair& points : index_pairs(path)) {
      const std::int64_t a = id(path, edges_.size(), points[0]), b = id(path, edges_.size(), points[1]);
      if (a == b) file_.fail(path, edges_.size(), "both ends of the edge are the same point");
      edges_.push_back({std::min(a, b), std::max(a, b)});
    }
  }

  FourIds vertex_face(const std::string& path, std::size_t row, IndexPair pair) const {
    check_range(path, row, "cell", pair[1], cells_.size());
    const std::size_t cell = static_cast<std::size_t>(pair[1]);
    if (cells_.types[cell] != ElementType::triangle)
      file_.fail(path, row, fmt::format("the cell {} is not a triangle", cell));
    FourIds ids{id(path, row, pair[0]), 0, 0, 0};
    for (std::size_t i = 0; i < 3; ++i) ids[i + 1] = sequence_.point_ids()[cells_.vertices(cell)[i]];
    std::sort(ids.begin() + 1, ids.end());
    return ids;
  }

  FourIds edge_edge(const std::string& path, std::size_t row, IndexPair pair) const {
    for (const std::int64_t e : pair) check_range(path, row, "edge", e, edges_.size());
    const auto [first, second] =
        std::minmax(edges_[static_cast<std::size_t>(pair[0])], edges_[static_cast<std::size_t>(pair[1])]);
    return {first[0], first[1], second[0], second[1]};
  }

  void read_kind(const std::string& group, FeatureKind kind) {
    const std::string path = group + "/Pairs";
    const std::size_t first = answers_.size();
    for (const IndexPair& pair : index_pairs(path)) {
      const std::size_t row = answers_.size() - first;
      const FourIds ids = kind == FeatureKind::vf ? vertex_face(path, row, pair) : edge_edge(path, row, pair);
      FourIds sorted = ids;
      std::sort(sorted.begin(), sorted.end());
      if (std::adjacent_find(sorted.begin(), sorted.end()) != sorted.end())
        file_.fail(path, row, "the two features have a common vertex");
      answers_.push_back({kind, ids, false});
    }
    read_answers(group, std::span(answers_).subspan(first));
  }

  void read_answers(const std::string& group, std::span<KnownAnswer> answers) const {
    const std::string collides_path = group + "/Collides", toi_path = group + "/TimeOfImpact";
    const std::int64_t count = static_cast<std::int64_t>(answers.size());
    const std::vector<std::int64_t> collides = file_.values<std::int64_t>(collides_path, count, " pairs");
    for (std::size_t i = 0; i < answers.size(); ++i) {
      if (collides[i] != 0 && collides[i] != 1)
        file_.fail(collides_path, i, fmt::format("is {}, but must be 0 or 1", collides[i]));
      answers[i].collides = collides[i] == 1;
    }
    if (!file_.has(toi_path)) return;
    const std::vector<double> toi = file_.values<double>(toi_path, count, " pairs");
    for (std::size_t i = 0; i < answers.size(); ++i) {
      if (answers[i].collides && !(toi[i] >= 0 && toi[i] <= 1))
        file_.fail(toi_path, i, "the pair collides, but the time is not in [0, 1]");
      if (!answers[i].collides && !std::isnan(toi[i]))
        file_.fail(toi_path, i, "the pair does not collide, but there is a time");
      answers[i].toi = toi[i];
    }
  }

  const Hdf5File& file_;
  SequenceReader& sequence_;
  SequenceCells cells_;
  std::vector<IndexPair> edges_;  ///< ids, ascending
  std::vector<KnownAnswer> answers_;
};

}  // namespace

std::optional<std::vector<KnownAnswer>> read_ground_truth(SequenceReader& reader) {
  const Hdf5File file(reader.file());
  if (!file.has("GroundTruth")) return std::nullopt;
  if (reader.frame_count() < 2) file.fail("GroundTruth", "is there, but the file has one frame only");
  return GroundTruthReader(file, reader).read();
}

}  // namespace volccd
