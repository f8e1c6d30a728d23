// Clauses of the theorem of `boundary-flood` (docs/boundary_flood.md), each with a scene in which contacts are lost
// without it; compared with the same pipeline without a flood.
#include <algorithm>
#include <array>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include <volccd/core/random.hpp>

#include "pipelines/flood_contest.hpp"
#include "support/trials.hpp"

namespace volccd {
namespace {

using test::Contest;
using test::kNoFilter;
using test::trials;

/// A block of 5 x 4 x 4 cells, and a smaller one inside it or across its boundary. Each step moves it by little, pulls
/// single vertices far, begins elsewhere, or follows an edit.
class BodyInABody {
 public:
  explicit BodyInABody(std::uint64_t seed) : random_(seed) {
    shape_ = block(ElementType::tetrahedron, 5, 4, 4);
    Shape inside = block(ElementType::tetrahedron, 3, 3, 3);
    const Vec3 at(random_.uniform(0.7, 1.3), random_.uniform(0.7, 1.3), random_.uniform(0.7, 1.3));
    const double across = random_.below(3) == 0 ? 2.5 : 0;
    for (Vec3& p : inside.positions) p = 0.5 * p + at + Vec3(across, 0, 0);
    shape_.append(inside, 1);
    if (random_.below(2) == 0) shape_ = permuted(shape_, random_.next());
    if (random_.below(3) == 0) {  // objects that share vertices, and a filter
      for (ElementSpec& e : shape_.elements) e.object = static_cast<std::int32_t>(random_.below(3));
      filter_ = random_.below(2) == 0 ? ObjectFilter(PairScope::inter) : ObjectFilter(PairScope::intra);
    }
    topology_.emplace(shape_.mesh());
    x_ = jittered(shape_.positions, 0.02, random_.next());
  }

  /// Returns the number of contacts.
  std::size_t compare(Contest& contest, std::size_t step, const std::string& what) {
    std::string done = step > 0 ? edit() : "";
    if (step > 0 && random_.below(5) == 0) {
      x_ = jittered(shape_.positions, 0.05, random_.next());
      done += ", jump";
    }
    std::vector<Vec3> end = jittered(x_, 0.03, random_.next());
    if (random_.below(2) == 0) {
      for (std::uint64_t i = 1 + random_.below(2); i > 0; --i)
        end[random_.below(end.size())] +=
            Vec3(random_.uniform(-1.5, 1.5), random_.uniform(-1.5, 1.5), random_.uniform(-1.5, 1.5));
      done += ", pulled";
    }
    const Motion motion = Motion::linear(x_, end);
    const double separation = random_.below(4) == 0 ? 0.05 : 0;
    const std::size_t contacts = contest.compare({*topology_, motion, filter_, separation}, what + done);
    x_ = random_.below(2) == 0 ? end : x_;
    return contacts;
  }

 private:
  std::string edit() {
    TopologyEdit edit;
    const Mesh& mesh = topology_->mesh();
    const std::uint64_t kind = random_.below(4);
    if (kind == 0)
      for (Index o = 0; o < mesh.element_slots(); ++o)
        if (mesh.is_live(o) && random_.below(30) == 0) {
          removed_.push_back(mesh.spec(o));
          edit.removed.push_back(o);
        }
    if (kind == 1) edit.added = std::exchange(removed_, {});
    if (edit.empty()) return "";
    topology_->apply(edit);
    return kind == 0 ? ", removed" : ", added again";
  }

  Random random_;
  Shape shape_;
  ObjectFilter filter_;
  std::optional<Topology> topology_;
  std::vector<Vec3> x_;
  std::vector<ElementSpec> removed_;
};

TEST(FloodClauses, BodiesInsideEachOtherOverManySteps) {
  std::size_t contacts = 0;
  for (std::uint64_t seed = 1; seed <= static_cast<std::uint64_t>(trials(40)) && !testing::Test::HasFailure(); ++seed) {
    BodyInABody bodies(seed);
    PipelineSpec spec = test::spec_of("boundary-flood");
    if (seed % 4 == 0) test::registry().apply_setting(spec, "csat.mode=features");  // pairs without contacts
    Contest contest(spec);
    for (std::size_t step = 0; step < 6; ++step)
      contacts += bodies.compare(contest, step, "seed " + std::to_string(seed) + ", step " + std::to_string(step));
  }
  EXPECT_GT(contacts, static_cast<std::size_t>(trials(10000)));
}

/// A closed surface around two vertices, each of which has eight tetrahedra below the same eight triangles.
Shape doubled_body(double size, const Vec3& at) {
  Shape shape;
  for (const Vec3& p : {Vec3(1, 0, 0), Vec3(0, 1, 0), Vec3(-1, 0, 0), Vec3(0, -1, 0), Vec3(0, 0, 1), Vec3(0, 0, -1),
                        Vec3(0.1, 0.05, 0.07), Vec3(-0.1, 0.03, -0.06)})
    shape.positions.push_back(size * p + at);
  for (const Index centre : {6u, 7u})
    for (Index i = 0; i < 4; ++i) {
      const Index a = i, b = (i + 1) % 4;
      for (const auto& [u, v, pole] : {std::array<Index, 3>{a, b, 4}, {b, a, 5}})
        shape.elements.push_back(
            {ElementType::tetrahedron, {centre, u, v, pole}, {}, 0, static_cast<std::int64_t>(shape.elements.size())});
    }
  return shape;
}

/// The inner body has no boundary face, because all faces of its surface have two tetrahedra on the same side.
TEST(FloodClauses, ABodyInsideWithoutBoundaryFaces) {
  Shape both = block(ElementType::tetrahedron, 5, 5, 5);
  const std::size_t outside = both.positions.size();
  both.append(doubled_body(0.9, Vec3(2.53, 2.47, 2.51)), 1);
  std::vector<Vec3> end = both.positions;
  for (std::size_t v = outside; v < end.size(); ++v) end[v] += Vec3(0.11, 0.23, 0.07);
  const Topology topology(both.mesh());
  EXPECT_GT(Contest().compare({topology, Motion::linear(both.positions, end), kNoFilter}, "doubled"), 20u);
}

/// A body deep inside another one, of which only a vertex in the middle moves, through the elements around it. These
/// have no vertex in common with the boundary of their body.
TEST(FloodClauses, AVertexPulledInABodyInsideAnother) {
  for (const bool calm_first : {false, true}) {
    Shape both = block(ElementType::tetrahedron, 3, 3, 3);
    for (Vec3& p : both.positions) p = 4 * p - Vec3(4, 4, 4);
    const std::size_t outside = both.positions.size();
    Shape inside = block(ElementType::tetrahedron, 6, 6, 6);
    for (Vec3& p : inside.positions) p = 0.5 * p + Vec3(0.53, 0.47, 0.51);
    std::size_t middle = 0;
    for (std::size_t v = 0; v < inside.positions.size(); ++v)
      if ((inside.positions[v] - Vec3(2.03, 1.97, 2.01)).norm() < 1e-9) middle = v;
    both.append(inside, 1);
    const Topology topology(both.mesh());
    std::vector<Vec3> end = both.positions;
    end[outside + middle] += Vec3(0.7, 0.2, 0.1);
    Contest contest;
    if (calm_first) contest.compare({topology, Motion::linear(both.positions, both.positions), kNoFilter}, "calm");
    EXPECT_GT(contest.compare({topology, Motion::linear(both.positions, end), kNoFilter}, "pulled"), 5u) << calm_first;
    contest.compare({topology, Motion::linear(both.positions, both.positions), kNoFilter}, "calm again");
  }
}

/// An element that an edit adds inside a body.
TEST(FloodClauses, AnElementAddedInsideABody) {
  Shape both = block(ElementType::tetrahedron, 3, 3, 3);
  ElementSpec added{ElementType::tetrahedron, {}, {}, 1, 1000};
  for (const Vec3& p : {Vec3(0, 0, 0), Vec3(0.9, 0, 0), Vec3(0, 0.9, 0), Vec3(0, 0, 0.9)}) {
    added.vertices.push_back(static_cast<Index>(both.positions.size()));
    both.positions.push_back(p + Vec3(0.93, 0.95, 0.97));
  }
  std::vector<Vec3> end = both.positions;
  for (const Index v : added.vertices) end[v] += Vec3(0.11, 0.13, 0.06);
  Topology topology(both.mesh());
  Contest contest;
  contest.compare({topology, Motion::linear(both.positions, end), kNoFilter}, "without");
  topology.apply({{}, {}, {added}});
  EXPECT_GT(contest.compare({topology, Motion::linear(both.positions, end), kNoFilter}, "added"), 5u);
}

/// An edit removes a layer in the middle of a block, so that the part above falls on the part below. All motions are
/// translations, so that no star is suspect.
TEST(FloodClauses, PartsThatAnEditSeparates) {
  const Shape shape = block(ElementType::tetrahedron, 3, 3, 7);
  Topology topology(shape.mesh());
  Contest contest;
  const Motion rest = Motion::linear(shape.positions, shape.positions);
  contest.compare({topology, rest, kNoFilter}, "whole");
  TopologyEdit edit;
  for (Index o = 0; o < topology.mesh().element_slots(); ++o) {
    double middle = 0;
    for (const Index v : topology.mesh().vertices(o)) middle += shape.positions[v].z() / 4;
    if (middle > 3 && middle < 4) edit.removed.push_back(o);
  }
  topology.apply(edit);
  std::vector<Vec3> end = shape.positions;
  for (Vec3& p : end)
    if (p.z() > 3.5) p += Vec3(0.21, 0.13, -1.37);
  EXPECT_GT(contest.compare({topology, Motion::linear(shape.positions, end), kNoFilter}, "falls"), 20u);
}

/// Of two tetrahedra inside a body, an edit replaces the second one by one with other vertices, in the same slot, which
/// has a vertex in common with the first. Both are outer as wholes, so that of the parts only the vertices change.
TEST(FloodClauses, AnElementReplacedInItsSlot) {
  Shape both = block(ElementType::tetrahedron, 6, 4, 4);
  const auto first = static_cast<Index>(both.positions.size());
  for (const Vec3& at : {Vec3(1.53, 1.47, 1.55), Vec3(3.53, 1.47, 1.55)})
    for (const Vec3& p : {Vec3(0, 0, 0), Vec3(0.9, 0, 0), Vec3(0, 0.9, 0), Vec3(0, 0, 0.9)})
      both.positions.push_back(p + at);
  both.elements.push_back({ElementType::tetrahedron, {first, first + 1, first + 2, first + 3}, {}, 1, 100000});
  both.elements.push_back({ElementType::tetrahedron, {first + 4, first + 5, first + 6, first + 7}, {}, 1, 100001});
  std::vector<Vec3> end = both.positions;
  for (Index v = first; v < end.size(); ++v) end[v] += Vec3(0.11, 0.13, 0.06);
  const Motion motion = Motion::linear(both.positions, end);
  Topology topology(both.mesh());
  Contest contest;
  EXPECT_GT(contest.compare({topology, motion, kNoFilter}, "apart"), 5u);
  const Index slot = topology.mesh().find_element(100001);
  topology.apply(
      {{slot}, {}, {{ElementType::tetrahedron, {first + 1, first + 5, first + 6, first + 7}, {}, 1, 100002}}});
  EXPECT_EQ(topology.mesh().find_element(100002), slot);
  EXPECT_GT(contest.compare({topology, motion, kNoFilter}, "joined"), 5u);
}

/// A body whose outside and inside are two objects that have vertices in common, and a bar that has been pushed through
/// the one into the other. Contacts of the bar and the outside are not asked for, so that with the filter no pair at
/// the boundary would be a seed.
TEST(FloodClauses, ObjectsThatAreTheOutsideAndTheInsideOfABody) {
  Shape both = block(ElementType::tetrahedron, 5, 5, 5);
  for (ElementSpec& e : both.elements) {
    Vec3 middle = Vec3::Zero();
    for (const Index v : e.vertices) middle += both.positions[v] / 4;
    e.object = (middle - Vec3(2.5, 2.5, 2.5)).lpNorm<Eigen::Infinity>() < 0.5 ? 1 : 0;
  }
  const std::size_t outside = both.positions.size();
  Shape bar = block(ElementType::tetrahedron, 1, 1, 8);
  for (Vec3& p : bar.positions) p = 0.4 * p + Vec3(2.23, 2.41, -0.57);
  both.append(bar, 2);
  std::vector<Vec3> end = both.positions;
  for (std::size_t v = outside; v < end.size(); ++v) end[v] += Vec3(0.21, 0.13, 0.17);
  const Topology topology(both.mesh());
  EXPECT_TRUE(topology.objects_share_vertices());
  ObjectFilter filter;
  filter.exclude(0, 2);
  EXPECT_GT(Contest().compare({topology, Motion::linear(both.positions, end), filter}, "bar"), 10u);
}

/// A needle through a body, in at one side and out at the other, without contacts of features at the boundary. In the
/// middle, a vertex moves, so that edges at it touch the needle. On the way there are only pairs of elements that
/// overlap while no feature of one touches a feature of the other (PairVerdict::contact_free).
TEST(FloodClauses, ANeedleThroughElementsWithoutContacts) {
  Shape both = block(ElementType::tetrahedron, 4, 4, 6);
  std::vector<Vec3> end = both.positions;
  for (Vec3& p : end)
    if ((p - Vec3(2, 2, 3)).norm() < 1e-9) p.x() += 0.6;
  ElementSpec needle{ElementType::tetrahedron, {}, {}, 1, static_cast<std::int64_t>(both.elements.size())};
  for (const Vec3& p : {Vec3(0.01, 0, -1), Vec3(-0.01, 0, -1), Vec3(0, 0.01, 7), Vec3(0, -0.01, 7)}) {
    needle.vertices.push_back(static_cast<Index>(both.positions.size()));
    both.positions.push_back(p + Vec3(2.67, 2.33, 0));
    end.push_back(both.positions.back());
  }
  both.elements.push_back(needle);
  const Topology topology(both.mesh());
  const Motion motion = Motion::linear(both.positions, end);
  const Step step{topology, motion, kNoFilter};
  PipelineSpec spec = test::spec_of("boundary-flood");
  test::registry().apply_setting(spec, "csat.mode=features");
  Contest contest(spec);
  EXPECT_GT(contest.compare(step, "needle"), 4u);
  contest.compare(step, "needle, with overlaps", {Query::all, true});
  EXPECT_EQ(contest.initial_overlaps(), 18u);
}

/// A bar in a body of tetrahedra, of which an edit replaces the outer cells by hexahedra, and a further edit brings the
/// tetrahedra back. The flood has processed steps before; after the first edit it has to copy and divide the mesh, or
/// does not take the steps. The way to the tetrahedra inside leads through the hexahedra.
TEST(FloodClauses, HexahedraAddedToABodyOfTetrahedra) {
  Shape both = block(ElementType::tetrahedron, 5, 5, 5);
  const Shape cells = block(ElementType::hexahedron, 5, 5, 5), tetrahedra = both;
  const std::size_t outside = both.positions.size();
  Shape bar = block(ElementType::tetrahedron, 1, 1, 8);
  for (Vec3& p : bar.positions) p = 0.4 * p + Vec3(2.23, 2.41, -0.57);
  both.append(bar, 1);
  std::vector<Vec3> end = both.positions;
  for (std::size_t v = outside; v < end.size(); ++v) end[v] += Vec3(0.21, 0.13, 0.17);
  const Motion motion = Motion::linear(both.positions, end);
  std::vector<ElementSpec> outer_tetrahedra, outer_cells;
  for (std::size_t i = 0; i < cells.elements.size(); ++i) {  // cell i is divided into the tetrahedra 6 i to 6 i + 5
    const ElementSpec& cell = cells.elements[i];
    const Vec3 middle = (both.positions[cell.vertices[0]] + both.positions[cell.vertices[6]]) / 2;
    if ((middle - Vec3(2.5, 2.5, 2.5)).lpNorm<Eigen::Infinity>() < 1.5) continue;
    outer_cells.push_back(cell);
    outer_cells.back().id += 10000;
    for (std::size_t k = 6 * i; k < 6 * i + 6; ++k) outer_tetrahedra.push_back(tetrahedra.elements[k]);
  }
  for (const char* max_divided_fraction : {"1", "0"}) {  // 0: the flood does not take the steps with hexahedra
    PipelineSpec spec = test::spec_of("boundary-flood");
    spec.flood->options["max_divided_fraction"] = max_divided_fraction;
    Contest contest(spec);
    Topology topology(both.mesh());
    const auto replace = [&](const std::vector<ElementSpec>& removed, const std::vector<ElementSpec>& added) {
      TopologyEdit edit{{}, {}, added};
      for (const ElementSpec& e : removed) edit.removed.push_back(topology.mesh().find_element(e.id));
      topology.apply(edit);
    };
    for (int round = 0; round < 2; ++round) {
      EXPECT_GT(contest.compare({topology, motion, kNoFilter}, "tetrahedra"), 20u);
      replace(outer_tetrahedra, outer_cells);
      EXPECT_GT(contest.compare({topology, motion, kNoFilter}, "hexahedra"), 10u);
      contest.compare({topology, motion, kNoFilter}, "hexahedra, with overlaps", {Query::all, true});
      EXPECT_GT(contest.initial_overlaps(), 20u);
      replace(outer_cells, outer_tetrahedra);
    }
  }
}

/// A vertex of the boundary touches a face of another body. The test is assigned to the first element at the vertex,
/// which has no other vertex on the boundary.
TEST(FloodClauses, AnElementThatHasOneVertexOnTheBoundary) {
  Shape both = block(ElementType::tetrahedron, 3, 3, 2);
  const auto lowest = [](const Vec3& p) { return (p - Vec3(1, 1, 0)).norm() < 1e-9; };
  const auto at = static_cast<Index>(std::ranges::find_if(both.positions, lowest) - both.positions.begin());
  const auto first = std::ranges::find_if(both.elements, [&](const ElementSpec& e) {
    return std::ranges::all_of(e.vertices, [&](Index v) { return v == at || both.positions[v].z() == 1; }) &&
           std::ranges::count(e.vertices, at) == 1;
  });
  ASSERT_NE(first, both.elements.end());
  std::swap(*first, both.elements.front());
  both.positions[at].z() = -0.3;
  std::vector<Vec3> end = both.positions;
  for (Vec3& p : end) p.z() -= 0.4;
  Shape below;
  below.positions = {Vec3(-4, -4, -0.5), Vec3(8, -3, -0.5), Vec3(1, 9, -0.5), Vec3(1, 1, -5)};
  below.elements = {{ElementType::tetrahedron, {0, 2, 1, 3}, {}, 0, 0}};
  both.append(below, 1);
  end.insert(end.end(), below.positions.begin(), below.positions.end());
  const Topology topology(both.mesh());
  EXPECT_EQ(Contest().compare({topology, Motion::linear(both.positions, end), kNoFilter}, "vertex"), 1u);
}

/// A body deep inside another one. Its last cell is missing, so that one of the vertices around the middle one is on
/// the boundary. The middle vertex has a shell as well, and thus no clear star: the elements at it are outer as wholes.
/// From the boundary they are reached over that one vertex.
TEST(FloodClauses, WholeElementsThatHaveOneVertexOnTheBoundary) {
  Shape both = block(ElementType::tetrahedron, 3, 3, 3);
  for (Vec3& p : both.positions) p = 4 * p - Vec3(4, 4, 4);
  const std::size_t outside = both.positions.size();
  Shape inside = block(ElementType::tetrahedron, 4, 4, 4);
  std::erase_if(inside.elements, [&](const ElementSpec& e) {
    return std::ranges::all_of(e.vertices, [&](Index v) { return inside.positions[v].minCoeff() >= 3; });
  });
  ElementSpec shell{ElementType::triangle, {}, {}, 0, 1000};
  for (Index v = 0; v < inside.positions.size(); ++v)
    if ((inside.positions[v] - Vec3(2, 2, 2)).norm() < 1e-9) shell.vertices.push_back(v);
  for (const Vec3& p : {Vec3(0.2, 0.1, 0.05), Vec3(0.05, 0.2, 0.1)}) {
    shell.vertices.push_back(static_cast<Index>(inside.positions.size()));
    inside.positions.push_back(p + Vec3(2, 2, 2));
  }
  inside.elements.push_back(shell);
  for (Vec3& p : inside.positions) p = 0.9 * p + Vec3(0.13, 0.21, 0.17);
  both.append(inside, 1);
  std::vector<Vec3> end = both.positions;
  for (std::size_t v = outside; v < end.size(); ++v) end[v] += Vec3(0.11, -0.08, 0.06);
  const Topology topology(both.mesh());
  EXPECT_GT(Contest().compare({topology, Motion::linear(both.positions, end), kNoFilter}, "shell"), 20u);
}

}  // namespace
}  // namespace volccd
