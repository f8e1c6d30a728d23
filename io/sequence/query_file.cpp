#include <volccd/io/sequence/query_file.hpp>

#include <iterator>
#include <sstream>

#include <fmt/format.h>

#include <volccd/io/hdf5/detail/hdf5_file.hpp>
#include <volccd/io/sequence/detail/importable.hpp>

namespace volccd {

namespace {

using detail::Hdf5Dataset;
using detail::Hdf5File;
using detail::NumberKind;

constexpr std::int64_t kPoints = 8;

std::vector<std::string> words(const std::string& text) {
  std::istringstream in(text);
  return {std::istream_iterator<std::string>(in), {}};
}

void read_points(const Hdf5Dataset& data, std::vector<Vec3>& points) {
  std::vector<double> numbers;
  data.read(0, data.rows(), numbers);
  points.resize(numbers.size() / 3);
  for (std::size_t i = 0; i < points.size(); ++i) {
    points[i] = Vec3(numbers.data() + 3 * i);
    if (!points[i].allFinite()) data.fail(static_cast<std::int64_t>(i) / kPoints, "a point is not finite");
  }
}

/// Reads one integer per query, each in [0, end).
template <class T>
void read_numbers(const Hdf5File& file, const std::string& path, std::int64_t queries, std::int64_t end,
                  std::vector<T>& out) {
  const auto numbers = file.values<std::int64_t>(path, queries, " queries");
  for (std::size_t i = 0; i < numbers.size(); ++i)
    if (numbers[i] < 0 || numbers[i] >= end)
      file.fail(path, i, fmt::format("is {}, but must be 0 .. {}", numbers[i], end - 1));
  out.assign(numbers.begin(), numbers.end());
}

QueryGroup read_group(const Hdf5File& file, const std::string& scene, FeatureKind kind, const std::string& path) {
  QueryGroup group;
  group.scene = scene;
  group.kind = kind;
  const Hdf5Dataset points = file.dataset(path + "/Points", NumberKind::real, kPoints, 3);
  read_points(points, group.points);
  read_numbers(file, path + "/Collides", points.rows(), 2, group.collides);
  group.file_names = words(file.string_attribute(path, "Files"));
  read_numbers(file, path + "/File", points.rows(), static_cast<std::int64_t>(group.file_names.size()), group.file);
  return group;
}

}  // namespace

std::vector<QueryGroup> read_query_file(const std::string& name) {
  const Hdf5File file(name);
  std::vector<QueryGroup> groups;
  const std::vector<std::string> scenes = file.root_names();
  if (scenes.empty()) file.fail("/", "is empty: no scenes of queries");
  for (const std::string& scene : scenes) {
    const std::string vf = scene + "/VertexFace", ee = scene + "/EdgeEdge";
    const bool has_vf = file.has(vf), has_ee = file.has(ee);
    if (!has_vf && !has_ee) file.fail(scene, "is no scene of queries: has neither VertexFace nor EdgeEdge");
    if (has_vf) groups.push_back(read_group(file, scene, FeatureKind::vf, vf));
    if (has_ee) groups.push_back(read_group(file, scene, FeatureKind::ee, ee));
  }
  std::erase_if(groups, [](const QueryGroup& group) { return group.size() == 0; });
  return groups;
}

bool is_sequence_file(const std::string& file) {
  detail::refuse_importable(file);
  return Hdf5File(file).has("VTKHDF");
}

}  // namespace volccd
