// A flood that takes the whole mesh takes a piece of it, because a cut does not count as boundary.
#include <algorithm>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include <volccd/broadphase/kdop_bvh.hpp>
#include <volccd/culling/flood/boundary_flood.hpp>
#include <volccd/distributed/piece_mesh.hpp>
#include <volccd/oracle/cases/shapes.hpp>

namespace volccd::distributed {
namespace {

/// The elements of a block that meet the slab 2 <= x <= 4. Complete are the vertices in the slab.
struct Slab {
  Slab() {
    Shape whole = block(ElementType::tetrahedron, 6, 5, 5);
    whole.positions = jittered(whole.positions, 0.15, 3);  // the cut is ragged, and some vertices on it are suspect
    const Mesh mesh = whole.mesh();
    Elements elements;
    for (Index o = 0; o < mesh.element_slots(); ++o) {
      const auto x = [&](Index v) { return whole.positions[v].x(); };
      const auto vertices = mesh.vertices(o);
      const auto [low, high] = std::ranges::minmax(vertices, {}, x);
      if (x(low) <= 4 && x(high) >= 2) elements.add(mesh, o);
    }
    piece.build({.elements = elements, .owners = std::vector<int>(elements.vertices.size(), 0)}, {}, {},
                serial_executor());
    std::vector<Vec3> positions;
    for (const std::int64_t id : piece.vertex_ids()) {
      positions.push_back(whole.positions[static_cast<std::size_t>(id)]);
      complete.push_back(positions.back().x() >= 2 && positions.back().x() <= 4 ? 1 : 0);
    }
    motion = Motion::linear(positions, positions);
  }

  /// The share of elements with a face without another element, of all or of those with complete vertices alone.
  double boundary_share(bool of_complete) const {
    const Features& features = piece.topology().features();
    const Mesh& mesh = piece.topology().mesh();
    double all = 0, boundary = 0;
    for (Index o = 0; o < mesh.element_slots(); ++o) {
      if (of_complete && std::ranges::any_of(mesh.vertices(o), [&](Index v) { return complete[v] == 0; })) continue;
      ++all;
      const auto triangles = features.element_triangles(o);
      boundary += std::ranges::any_of(triangles, [&](Index f) { return features.triangle_elements(f).size() == 1; });
    }
    return boundary / all;
  }

  bool takes(const BoundaryFlood::Config& config, bool with_complete) const {
    const ObjectFilter everything;
    Step step{piece.topology(), motion, everything};
    if (with_complete) step.piece.complete = complete;
    const KdopBvh broad_phase{KdopBvh::Config()};
    const BoundaryFlood flood(config);
    const auto state = flood.make_state_with(broad_phase);
    flood.prepare(step, *state, serial_executor());
    return flood.takes(*state, false);
  }

  PieceMesh piece;
  Motion motion;
  std::vector<std::uint8_t> complete;
};

TEST(CompleteVertices, FacesOnACutAreNoBoundaryInShares) {
  const Slab slab;
  const double with = slab.boundary_share(true), without = slab.boundary_share(false);
  ASSERT_LT(with, without);
  const BoundaryFlood::Config config{.max_boundary_fraction = (with + without) / 2, .max_suspect_fraction = 1};
  EXPECT_TRUE(slab.takes(config, true));
  EXPECT_FALSE(slab.takes(config, false));
}

TEST(CompleteVertices, SuspectVerticesOnACutDoNotCount) {
  const Slab slab;
  const BoundaryFlood::Config config{.max_boundary_fraction = 1, .max_suspect_fraction = 0};
  EXPECT_TRUE(slab.takes(config, true));
  EXPECT_FALSE(slab.takes(config, false));
}

}  // namespace
}  // namespace volccd::distributed
