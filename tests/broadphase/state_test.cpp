// Data that a state keeps from step to step: topology changes, restructuring, memory.
#include <numeric>

#include <volccd/peers/peers.hpp>

#include "broadphase/scenes.hpp"
#include "support/allocations.hpp"

namespace volccd::test {
namespace {

/// The project's own.
std::vector<StageDescriptor<BroadPhase>> own_descriptors() {
  return {describe_kdop_bvh(), describe_spatial_hash(), describe_brute_force()};
}

std::vector<StageDescriptor<BroadPhase>> descriptors() {
  std::vector<StageDescriptor<BroadPhase>> all = own_descriptors();
  for (auto& peer : describe_peers()) all.push_back(std::move(peer));
  return all;
}

/// Removes `removals` random elements and adds `additions` elements near the others or far away.
TopologyEdit random_edit(const Topology& topology, std::size_t removals, std::size_t additions, std::mt19937_64& random,
                         std::int64_t& next_id) {
  const Mesh& mesh = topology.mesh();
  TopologyEdit edit;
  std::set<Index> removed;
  for (std::size_t tries = 0; removed.size() < removals && tries < 20 * removals; ++tries) {
    const Index o = static_cast<Index>(random() % mesh.element_slots());
    if (mesh.is_live(o)) removed.insert(o);
  }
  edit.removed.assign(removed.begin(), removed.end());
  for (std::size_t i = 0; i < additions; ++i) {
    std::set<Index> vertices;
    const std::size_t count = random() % 3 == 0 ? 3 : 4;
    const Index near = static_cast<Index>(random() % mesh.vertex_count());
    while (vertices.size() < count)
      vertices.insert(random() % 8 == 0
                          ? static_cast<Index>(random() % mesh.vertex_count())
                          : std::min<Index>(near + static_cast<Index>(random() % 6), mesh.vertex_count() - 1));
    edit.added.push_back({.type = count == 3 ? ElementType::triangle : ElementType::tetrahedron,
                          .vertices = {vertices.begin(), vertices.end()},
                          .object = static_cast<std::int32_t>(random() % 3),
                          .id = next_id++});
  }
  return edit;
}

void expect_follows_edits(std::size_t removals, std::size_t additions, bool whole_builds_expected) {
  const Shape shape = permuted(block(ElementType::tetrahedron, 6, 5, 5), 1);
  for (const auto& descriptor : own_descriptors())
    for (PairScope scope : {PairScope::all, PairScope::inter}) {
      SCOPED_TRACE(descriptor.name);
      Scene scene = make_scene("edits", shape, jittered(shape.positions, 0.3, 1));
      scene.filter = ObjectFilter(scope);
      const auto phase = descriptor.make({});
      const auto state = phase->make_state();
      SerialExecutor executor;
      std::mt19937_64 random(removals * 100 + additions);
      std::int64_t next_id = 1000000;
      for (int step = 0; step < 12; ++step) {
        scene.motion = Motion::linear(jittered(shape.positions, 0.1 * step, 2), jittered(shape.positions, 0.3, 3));
        for (PairRange range : {PairRange::nonadjacent, PairRange::every})
          ASSERT_EQ(run(*phase, scene.step(), *state, range, executor), run_fresh(*phase, scene.step(), range)) << step;
        // Sometimes there are several edits between two updates, and sometimes more than the history stores.
        const int edits = step % 4 == 2 ? 3 : step == 7 && whole_builds_expected ? 12 : 1;
        for (int e = 0; e < edits; ++e)
          scene.topology->apply(random_edit(*scene.topology, removals, additions, random, next_id));
      }
      if (descriptor.name == "kdop-bvh") {
        if (whole_builds_expected)
          EXPECT_GT(KdopBvh::counters(*state).builds, 1u);
        else
          EXPECT_EQ(KdopBvh::counters(*state).builds, 1u) << "small edits shall not rebuild the tree";
      }
    }
}

TEST(TopologyChanges, RemovedElements) { expect_follows_edits(7, 0, false); }
TEST(TopologyChanges, AddedElements) { expect_follows_edits(0, 4, false); }
TEST(TopologyChanges, RemovedAndAddedElements) { expect_follows_edits(5, 3, false); }
TEST(TopologyChanges, ManyAtOnce) { expect_follows_edits(60, 40, true); }

TEST(TopologyChanges, LargerElementsThanBefore) {
  Shape shape = block(ElementType::tetrahedron, 4, 4, 4);
  for (const auto& descriptor : descriptors()) {
    Scene scene = make_scene("growing", shape, jittered(shape.positions, 0.2, 1));
    const auto phase = descriptor.make({});
    const auto state = phase->make_state();
    SerialExecutor executor;
    run(*phase, scene.step(), *state, PairRange::every, executor);
    TopologyEdit edit;
    edit.removed = {3, 5};
    edit.added.push_back({.type = ElementType::hexahedron, .vertices = {0, 1, 6, 5, 25, 26, 31, 30}, .id = 100000});
    scene.topology->apply(edit);
    for (PairRange range : {PairRange::nonadjacent, PairRange::every})
      EXPECT_EQ(run(*phase, scene.step(), *state, range, executor), run_fresh(*phase, scene.step(), range));
  }
}

TEST(TopologyChanges, EverythingGoesAndComesBack) {
  Shape shape = block(ElementType::tetrahedron, 2, 2, 2);
  for (const auto& descriptor : descriptors()) {
    Scene scene = make_scene("all", shape, shape.positions);
    const auto phase = descriptor.make({});
    const auto state = phase->make_state();
    SerialExecutor executor;
    const Pairs before = run(*phase, scene.step(), *state, PairRange::every, executor);
    TopologyEdit away;
    for (Index o = 0; o < scene.topology->mesh().element_slots(); ++o) away.removed.push_back(o);
    scene.topology->apply(away);
    EXPECT_TRUE(run(*phase, scene.step(), *state, PairRange::every, executor).empty());
    TopologyEdit back;
    back.added = shape.elements;
    scene.topology->apply(back);
    EXPECT_EQ(run(*phase, scene.step(), *state, PairRange::every, executor).size(), before.size());
    EXPECT_EQ(query(*phase, scene.step(), *state, PairRange::every, executor), run_fresh(*phase, scene.step()));
  }
}

TEST(TopologyChanges, AStateIsNoticedToBelongToAnotherTopology) {
  const Shape small = block(ElementType::hexahedron, 3, 2, 2), large = block(ElementType::tetrahedron, 4, 3, 3);
  const Shape same_size = permuted(large, 1);
  const Scene a = make_scene("a", small, small.positions), b = make_scene("b", large, large.positions),
              c = make_scene("c", same_size, same_size.positions);
  for (const auto& descriptor : descriptors()) {
    SCOPED_TRACE(descriptor.name);
    const auto phase = descriptor.make({});
    const auto state = phase->make_state();
    SerialExecutor executor;
    for (const Scene* scene : {&a, &b, &c, &a})
      for (const PairRange range : {PairRange::every, PairRange::nonadjacent})
        EXPECT_EQ(run(*phase, scene->step(), *state, range, executor), run_fresh(*phase, scene->step(), range));
  }
}

/// Rounds to multiples of 2^-8, which floats, and therefore bounds of 6-DOPs, represent exactly.
std::vector<Vec3> on_grid(std::vector<Vec3> positions) {
  for (Vec3& p : positions)
    for (int c = 0; c < 3; ++c) p[c] = std::round(p[c] * 256) / 256;
  return positions;
}

/// The pairs that the tree must give, from their definition: live elements whose swept boxes overlap.
Pairs pairs_of_boxes(const Step& step) {
  struct Box {
    std::array<double, 6> bounds;  // lower ends, negated upper ends
    Index slot;
  };
  const Mesh& mesh = step.mesh();
  std::vector<Box> boxes;
  for (Index o = 0; o < mesh.element_slots(); ++o) {
    if (!mesh.is_live(o)) continue;
    Box box{{}, o};
    box.bounds.fill(INFINITY);
    for (const Index v : mesh.vertices(o))
      for (int c = 0; c < step.motion.control_points(); ++c)
        for (std::size_t k = 0; k < 3; ++k) {
          const double x = step.motion.point(v, c)[static_cast<Eigen::Index>(k)];
          box.bounds[k] = std::min(box.bounds[k], x);
          box.bounds[3 + k] = std::min(box.bounds[3 + k], -x);
        }
    boxes.push_back(box);
  }
  // Elements are in ascending order of the lower ends in x, so that not all pairs have to be compared.
  std::sort(boxes.begin(), boxes.end(), [](const Box& a, const Box& b) { return a.bounds[0] < b.bounds[0]; });
  Pairs pairs;
  for (std::size_t i = 0; i < boxes.size(); ++i)
    for (std::size_t j = i; j < boxes.size() && boxes[j].bounds[0] <= -boxes[i].bounds[3]; ++j) {
      const auto &a = boxes[i].bounds, &b = boxes[j].bounds;
      if (a[1] <= -b[4] && b[1] <= -a[4] && a[2] <= -b[5] && b[2] <= -a[5])
        pairs.push_back({std::min(boxes[i].slot, boxes[j].slot), std::max(boxes[i].slot, boxes[j].slot)});
    }
  std::sort(pairs.begin(), pairs.end());
  return pairs;
}

bool share_vertex(const Mesh& mesh, ElementPair pair) {
  const auto a = mesh.vertices(pair.a), b = mesh.vertices(pair.b);
  return std::find_first_of(a.begin(), a.end(), b.begin(), b.end()) != a.end();
}

/// Removes every `stride`-th element and those near `centre`, and adds similar elements near `centre` and elsewhere.
TopologyEdit edit_of_many(const Topology& topology, const std::vector<Vec3>& positions, const Vec3& centre,
                          double radius, Index stride, std::size_t additions, std::int64_t& next_id) {
  const Mesh& mesh = topology.mesh();
  TopologyEdit edit;
  std::vector<Index> near;  // vertices
  for (Index v = 0; v < mesh.vertex_count(); ++v)
    if ((positions[v] - centre).norm() < radius) near.push_back(v);
  for (Index o = 0; o < mesh.element_slots(); ++o) {
    if (!mesh.is_live(o)) continue;
    const auto v = mesh.vertices(o);
    const bool cluster =
        std::any_of(v.begin(), v.end(), [&](Index i) { return (positions[i] - centre).norm() < radius / 2; });
    if (cluster || o % stride == 0) edit.removed.push_back(o);
  }
  for (std::size_t i = 0; i < additions; ++i) {
    const bool scattered = i % 3 == 0;
    const std::size_t first = scattered ? i * 7919 : i;
    ElementSpec element{.type = ElementType::tetrahedron, .id = next_id++};
    for (std::size_t k = 0; k < 4; ++k)
      element.vertices.push_back(scattered ? static_cast<Index>((first + k) % mesh.vertex_count())
                                           : near[(first + k) % near.size()]);
    edit.added.push_back(element);
  }
  return edit;
}

/// Bricks of 48 tetrahedra, 27 vertices each, that fill a cube.
Shape bricks(int side) {
  Shape shape;
  const Shape brick = block(ElementType::tetrahedron, 2, 2, 2);
  for (int i = 0; i < side * side * side; ++i)
    shape.append(Shape(brick).translate({2.0 * (i % side), 2.0 * (i / side % side), 2.0 * (i / side / side)}), 0);
  return shape;
}

/// Exchanges the positions of the bricks `first` <= i < `end` at random.
void exchange(std::vector<Vec3>& positions, std::size_t first, std::size_t end, std::mt19937_64& random) {
  for (std::size_t i = first + 1; i < end; ++i) {
    const auto a = positions.begin() + static_cast<std::ptrdiff_t>(27 * i);
    std::swap_ranges(a, a + 27, positions.begin() + static_cast<std::ptrdiff_t>(27 * (first + random() % (i - first))));
  }
}

/// Edits a mesh with several refit blocks between steps that degrade parts of the tree, and in one step all of it.
void expect_tree_follows_edits_of_many(int side, int steps, std::size_t additions, Index stride,
                                       std::initializer_list<KdopBvh::Restructure> ways, int leaf_size = 4) {
  const Shape shape = bricks(side);
  const std::size_t number = shape.positions.size() / 27;
  for (const KdopBvh::Restructure restructure : ways) {
    KdopBvh::Config config;
    config.k = 6;
    config.leaf_size = leaf_size;
    config.restructure = restructure;
    config.degradation = 1.05;
    const KdopBvh phase(config);
    const auto state = phase.make_state();
    const auto executor = make_thread_executor(2);
    Scene scene = make_scene("many", shape, shape.positions);
    std::vector<Vec3> at = shape.positions;
    std::mt19937_64 random(7);
    std::int64_t next_id = 1000000;
    for (int step = 0; step <= steps; ++step) {
      for (const double part : {0.05, 0.1}) {  // one step after an edit, and one step without an edit
        scene.motion = Motion::linear(on_grid(at), on_grid(jittered(at, part, static_cast<std::uint64_t>(step))));
        const Pairs found = run(phase, scene.step(), *state, PairRange::every, *executor);
        Pairs expected = pairs_of_boxes(scene.step());
        ASSERT_TRUE(found == expected) << "step " << step;
        std::erase_if(expected, [&](ElementPair pair) { return share_vertex(scene.topology->mesh(), pair); });
        ASSERT_TRUE(query(phase, scene.step(), *state, PairRange::nonadjacent, *executor) == expected)
            << "step " << step;
      }
      if (step == steps) break;
      exchange(at, 0, step == 2 ? number : number / 8, random);
      const double c = 2 * side * (0.2 + 0.6 * step / steps);
      scene.topology->apply(
          edit_of_many(*scene.topology, at, Vec3(c, side, side * 0.7), 1.7, stride, additions, next_id));
    }
    const KdopBvh::Counters& counters = KdopBvh::counters(*state);
    const bool always = restructure == KdopBvh::Restructure::always;
    EXPECT_EQ(counters.builds, always ? 2 * static_cast<unsigned>(steps) + 2 : 1u)
        << "these edits shall not rebuild the tree";
    EXPECT_EQ(counters.restructured_elements > 0, restructure == KdopBvh::Restructure::subtrees);
  }
}

TEST(TopologyChanges, SeveralThousandElements) {
  using enum KdopBvh::Restructure;
  expect_tree_follows_edits_of_many(5, 5, 20, 97, {none, subtrees, always});
  expect_tree_follows_edits_of_many(5, 5, 20, 97, {subtrees}, 7);
}

// The tree of added elements has more than one refit block, too.
TEST(LongTopologyChanges, MoreThanAThousandAdditions) {
  expect_tree_follows_edits_of_many(9, 1, 1030, 997, {KdopBvh::Restructure::none});
}

// The table of adjacent pairs of leaves is kept when a small part of the tree is rebuilt.
TEST(AdjacentPairs, AreThoseOfTheMeshAfterPartsOfTheTreeAreRebuilt) {
  constexpr std::size_t moving = 12;
  const Shape shape = bricks(5);
  std::vector<Vec3> at = shape.positions;
  for (std::size_t v = 0; v < 27 * moving; ++v) at[v] += Vec3(100, 0, 0);
  const KdopBvh phase{{}}, slow{{.adjacent_pairs = KdopBvh::AdjacentPairs::vertices}};
  const auto state = phase.make_state();
  SerialExecutor executor;
  Scene scene = make_scene("a part", shape, shape.positions);
  std::mt19937_64 random(3);
  for (int step = 0; step < 20; ++step) {
    scene.motion = Motion::linear(at, jittered(at, 0.3, static_cast<std::uint64_t>(step)));
    EXPECT_EQ(run(phase, scene.step(), *state, PairRange::nonadjacent, executor),
              run_fresh(slow, scene.step(), PairRange::nonadjacent));
    exchange(at, 0, moving, random);
  }
  EXPECT_EQ(KdopBvh::counters(*state).builds, 1u);
  EXPECT_GT(KdopBvh::counters(*state).restructured_elements, 0u);
}

/// Elements are removed, parts of the tree are rebuilt, which moves others to the places of the removed ones in the
/// tree, and then an edit adds elements in the slots of the removed ones.
TEST(TopologyChanges, ElementsAddedInSlotsOfRemovedOnesAfterPartsOfTheTreeAreRebuilt) {
  constexpr std::size_t moving = 8;
  const Shape shape = bricks(3);
  std::vector<Vec3> at = shape.positions;
  for (std::size_t v = 0; v < 27 * moving; ++v) at[v] += Vec3(100, 0, 0);
  KdopBvh::Config config;
  config.degradation = 1.05;
  const KdopBvh phase(config);
  const auto state = phase.make_state();
  SerialExecutor executor;
  Scene scene = make_scene("a part", shape, shape.positions);
  std::mt19937_64 random(3);
  const auto expect_all = [&](const std::string& what) {
    scene.motion = Motion::linear(at, jittered(at, 0.1, random()));
    EXPECT_EQ(run(phase, scene.step(), *state, PairRange::every, executor),
              run_fresh(phase, scene.step(), PairRange::every))
        << what;
  };
  expect_all("at first");
  for (int round = 0; round < 3; ++round) {
    TopologyEdit removal, addition;
    for (Index o = static_cast<Index>(round); o < 48 * moving; o += 17) {
      removal.removed.push_back(o);
      addition.added.push_back(scene.topology->mesh().spec(o));
    }
    scene.topology->apply(removal);
    expect_all("removed");
    for (int step = 0; step < 3; ++step) {
      exchange(at, 0, moving, random);
      expect_all("exchanged");
    }
    scene.topology->apply(addition);
    expect_all("added");
    if (HasFailure()) break;
  }
  EXPECT_EQ(KdopBvh::counters(*state).builds, 1u);
  EXPECT_GT(KdopBvh::counters(*state).restructured_elements, 0u);
}

/// Elements are replaced in their slots by copies with vertices of their own, as along a crack: they keep their places
/// in the tree, but are no longer adjacent to their neighbours.
TEST(AdjacentPairs, FollowElementsThatAreReplacedInTheirPlaces) {
  Shape shape = bricks(3);
  const KdopBvh phase{{}}, slow{{.adjacent_pairs = KdopBvh::AdjacentPairs::vertices}};
  const auto state = phase.make_state();
  SerialExecutor executor;
  Scene scene = make_scene("crack", shape, shape.positions);
  const Mesh& mesh = scene.topology->mesh();
  std::size_t before = 0;
  for (Index round = 0; round < 4; ++round) {
    scene.motion = Motion::linear(shape.positions, jittered(shape.positions, 0.1, round));
    const Pairs pairs = run(phase, scene.step(), *state, PairRange::nonadjacent, executor);
    EXPECT_EQ(pairs, run_fresh(slow, scene.step(), PairRange::nonadjacent));
    EXPECT_GT(pairs.size(), before) << "elements that were adjacent overlap";
    before = pairs.size();
    TopologyEdit edit;
    for (Index o = round; o < mesh.element_slots(); o += 13) edit.removed.push_back(o);
    for (auto o = edit.removed.rbegin(); o != edit.removed.rend(); ++o) {  // slots are given in descending order
      ElementSpec copy = mesh.spec(*o);
      for (Index& v : copy.vertices) {
        edit.new_vertex_ids.push_back(1000000 + static_cast<std::int64_t>(shape.positions.size()));
        shape.positions.push_back(shape.positions[v]);
        v = static_cast<Index>(shape.positions.size() - 1);
      }
      edit.added.push_back(copy);
    }
    scene.topology->apply(edit);
  }
  EXPECT_EQ(KdopBvh::counters(*state).builds, 1u);
}

// A serial query writes the pairs in the order of the tree, so that they show every difference of two trees.
TEST(TreeThreads, AnyNumberMakesTheSameTree) {
  const Shape shape = bricks(7);  // enough elements for several tasks and chunks
  Scene scene = make_scene("bricks", shape, shape.positions);
  std::vector<Vec3> at = shape.positions;
  const KdopBvh phase{{}};
  SerialExecutor serial;
  std::vector<std::unique_ptr<Executor>> executors;
  std::vector<std::unique_ptr<StageState>> states;
  for (const unsigned threads : {1u, 5u}) {
    executors.push_back(make_thread_executor(threads));
    states.push_back(phase.make_state());
  }
  std::mt19937_64 random(4);
  std::int64_t next_id = 10000000;
  for (int step = 0; step < 4; ++step) {
    scene.motion = Motion::linear(at, jittered(at, 0.1, static_cast<std::uint64_t>(step)));
    std::vector<Pairs> pairs(states.size());
    for (std::size_t i = 0; i < states.size(); ++i) {
      phase.prepare(scene.step(), *states[i], *executors[i]);
      Step one = scene.step();
      one.range = PairRange::nonadjacent;
      visit_candidates(phase, one, *states[i], serial, [&](std::span<const ElementPair> block, unsigned) {
        pairs[i].insert(pairs[i].end(), block.begin(), block.end());
      });
      EXPECT_TRUE(pairs[i] == pairs[0]) << executors[i]->workers() << " threads, step " << step;
    }
    EXPECT_GT(pairs[0].size(), 10000u);
    if (step == 0)  // first several small subtrees degrade, and then a large one
      for (std::size_t first = 0; first < 340; first += 21) exchange(at, first, first + 3, random);
    else
      exchange(at, 0, 200, random);
    scene.topology->apply(edit_of_many(*scene.topology, at, Vec3(7, 7, 6), 3, step == 2 ? 3 : 997, 100, next_id));
  }
  EXPECT_EQ(KdopBvh::counters(*states[0]).builds, 2u);
  EXPECT_GT(KdopBvh::counters(*states[0]).restructured_elements, 4096u);
}

TEST(SteadyState, AllocatesNothing) {
  const Shape shape = permuted(block(ElementType::tetrahedron, 8, 8, 8), 2);
  Scene scene = make_scene("steady", shape, shape.positions);
  std::vector<Motion> motions;
  for (std::uint64_t seed = 0; seed < 4; ++seed)
    motions.push_back(Motion::linear(jittered(shape.positions, 0.05, seed), jittered(shape.positions, 0.2, seed + 10)));
  for (PairScope scope : {PairScope::all, PairScope::inter})
    for (const auto& descriptor : own_descriptors())
      for (unsigned workers : {1u, 3u}) {
        scene.filter = ObjectFilter(scope);
        const auto executor = make_thread_executor(workers);
        const auto phase = descriptor.make({});
        const auto state = phase->make_state();
        std::vector<Work> work(workers);
        for (Work& one : work) one.pairs.reserve(100000);
        std::size_t before = 0;
        for (int round = 0; round < 3; ++round) {
          if (round == 2) before = allocation_count();
          for (const Motion& motion : motions) {
            scene.motion = motion;  // the size is the same, so that the assignment does not allocate
            phase->prepare(scene.step(), *state, *executor);
            for (PairRange range : {PairRange::nonadjacent, PairRange::every}) {
              Step step = scene.step();
              step.range = range;
              executor->parallel_for(phase->blocks(step, *state, *executor), 1,
                                     [&](std::size_t begin, std::size_t, unsigned w) {
                                       phase->run(step, *state, w, begin, work[w]);
                                       work[w].pairs.clear();
                                     });
            }
          }
        }
        EXPECT_EQ(allocation_count() - before, 0u) << descriptor.name << " with " << workers << " workers";
        EXPECT_GT(state->bytes(), 0u);
      }
}

}  // namespace
}  // namespace volccd::test
