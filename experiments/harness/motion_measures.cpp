#include <volccd/experiments/harness/motion_measures.hpp>

#include <algorithm>
#include <bit>
#include <fstream>
#include <vector>

#include <fmt/format.h>

#include <volccd/core/error.hpp>

namespace volccd {

namespace {

class Fnv1a {
 public:
  void add(const void* data, std::size_t bytes) {
    for (std::size_t i = 0; i < bytes; ++i) {
      hash_ ^= static_cast<const unsigned char*>(data)[i];
      hash_ *= 0x100000001b3u;
    }
  }
  std::string text() const { return fmt::format("{:016x}", hash_); }

 private:
  std::uint64_t hash_ = 0xcbf29ce484222325u;
};

/// The elements of both features of a contact.
std::pair<std::span<const Index>, std::span<const Index>> elements_of(const Features& features,
                                                                      const Contact& contact) {
  const auto& v = contact.vertices;
  if (contact.kind == FeatureKind::vf)
    return {features.vertex_elements(v[0]), features.triangle_elements(features.find_triangle(v[1], v[2], v[3]))};
  return {features.edge_elements(features.find_edge(v[0], v[1])),
          features.edge_elements(features.find_edge(v[2], v[3]))};
}

}  // namespace

std::uint64_t adjacent_pair_count(const Topology& topology) {
  const Mesh& mesh = topology.mesh();
  std::uint64_t count = 0;
  std::vector<Index> near;
  for (Index o = 0; o < mesh.element_slots(); ++o) {
    if (!mesh.is_live(o)) continue;
    near.clear();
    for (const Index v : mesh.vertices(o))
      for (const Index other : topology.features().vertex_elements(v))
        if (other >= o) near.push_back(other);
    std::sort(near.begin(), near.end());
    count += static_cast<std::uint64_t>(std::unique(near.begin(), near.end()) - near.begin());
  }
  return count;
}

std::uint64_t touching_pair_count(const Topology& topology, std::span<const Contact> contacts) {
  std::vector<ElementPair> pairs;
  for (const Contact& contact : contacts) {
    const auto [a, b] = elements_of(topology.features(), contact);
    for (const Index x : a)
      for (const Index y : b)
        if (!topology.adjacency().adjacent(x, y)) pairs.push_back({std::min(x, y), std::max(x, y)});
  }
  std::sort(pairs.begin(), pairs.end());
  return static_cast<std::uint64_t>(std::unique(pairs.begin(), pairs.end()) - pairs.begin());
}

double mean_edge_length(const Features& features, const Motion& motion) {
  double sum = 0;
  for (Index e = 0; e < features.edge_slots(); ++e)
    if (!features.edge_elements(e).empty())
      sum += (motion.point(features.edge(e)[0], 0) - motion.point(features.edge(e)[1], 0)).norm();
  return sum / std::max<double>(1, features.edge_count());
}

double mean_moved_edges(const Features& features, const Motion& motion) {
  double moved = 0;
  for (Index v = 0; v < features.vertex_slots(); ++v)
    if (!features.vertex_elements(v).empty()) moved += (motion.point(v, motion.degree()) - motion.point(v, 0)).norm();
  const double mean_edge = mean_edge_length(features, motion);
  return mean_edge > 0 ? moved / std::max<double>(1, features.vertex_count()) / mean_edge : 0;
}

std::string contacts_hash(std::span<const Contact> contacts) {
  Fnv1a hash;
  for (const Contact& contact : contacts) {
    const std::uint32_t kind = contact.kind == FeatureKind::vf ? 0 : 1;
    const std::uint64_t toi = std::bit_cast<std::uint64_t>(contact.toi);
    hash.add(&kind, sizeof kind);
    hash.add(contact.vertices.data(), sizeof contact.vertices);
    hash.add(&toi, sizeof toi);
  }
  return hash.text();
}

std::string file_hash(const std::string& file) {
  std::ifstream in(file, std::ios::binary);
  if (!in) throw InputError(file, "", "cannot be read");
  Fnv1a hash;
  std::vector<char> block(1 << 20);
  while (in.read(block.data(), static_cast<std::streamsize>(block.size())) || in.gcount() > 0)
    hash.add(block.data(), static_cast<std::size_t>(in.gcount()));
  if (in.bad()) throw InputError(file, "", "cannot be read to its end");
  return hash.text();
}

Motion scaled(const Motion& motion, double scale) {
  Motion result = motion;
  for (Index v = 0; v < motion.vertex_count(); ++v)
    for (int c = 1; c < motion.control_points(); ++c)
      result.set(v, c, motion.point(v, 0) + scale * (motion.point(v, c) - motion.point(v, 0)));
  return result;
}

}  // namespace volccd
