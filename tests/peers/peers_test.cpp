// Broad phases of other libraries, with each of their update methods, must give the pairs of `kdop-bvh` with k = 6, bit
// for bit.
#include <array>
#include <cfenv>
#include <sstream>

#include <volccd/peers/peers.hpp>

#include "broadphase/scenes.hpp"

namespace volccd::test {
namespace {

struct Variant {
  std::string name;
  std::unique_ptr<BroadPhase> phase;
};

/// Every value of each option with the others at their defaults; for an option with a range, the ends of the range.
std::vector<Variant> variants() {
  std::vector<Variant> all;
  for (const auto& peer : describe_peers()) {
    all.push_back({peer.name, make(peer)});
    for (const OptionInfo& option : peer.options) {
      std::vector<std::string> values;
      std::istringstream choices(option.allowed);
      for (std::string choice; std::getline(choices, choice, '|');) values.push_back(choice);
      // the option has a range
      if (values.size() < 2) values = {option.allowed.substr(0, option.allowed.find(' ')), "1000"};
      for (const std::string& value : values)
        all.push_back({peer.name + "." + option.name + "=" + value, make(peer, {{option.name, value}})});
    }
  }
  return all;
}

Pairs expected_pairs(const Step& step, PairRange range) {
  return run_fresh(*make(describe_kdop_bvh(), {{"k", "6"}}), step, range);
}

TEST(Peers, EmitThePairsOfBoxes) {
  const std::vector<Variant> all = variants();
  if (all.empty()) GTEST_SKIP() << "built without broad phases of other libraries";
  for (const Scene& scene : scenes()) {
    SCOPED_TRACE(scene.name);
    for (PairRange range : {PairRange::nonadjacent, PairRange::every}) {
      const Pairs expected = expected_pairs(scene.step(), range);
      for (const Variant& variant : all)
        EXPECT_TRUE(run_fresh(*variant.phase, scene.step(), range) == expected) << variant.name;
    }
  }
}

/// Pairs of tetrahedra. Each pair has its own order of magnitude of position and motion along each axis. Bounds are
/// clamped to finite floats: without this, `volccd check cgal-box-intersection` found missing pairs.
TEST(Peers, EmitPairsBeyondTheRangeOfFloats) {
  std::mt19937_64 random(1);
  std::uniform_real_distribution<double> exponent(-60, 60), sign(-1, 1);
  const std::vector<Variant> all = variants();
  for (int trial = 0; trial < 20; ++trial) {
    SCOPED_TRACE(trial);
    Shape shape;
    std::vector<Vec3> x1;
    for (std::size_t pair = 0; pair < 8; ++pair) {
      Vec3 start, end;
      for (int c = 0; c < 3; ++c) {
        start[c] = std::copysign(std::pow(10.0, exponent(random)), sign(random));
        end[c] = start[c] * sign(random);
      }
      for (Index element = 0; element < 2; ++element) {
        ElementSpec spec{.type = ElementType::tetrahedron, .id = static_cast<std::int64_t>(2 * pair + element)};
        for (int v = 0; v < 4; ++v) {
          spec.vertices.push_back(static_cast<Index>(shape.positions.size()));
          shape.positions.push_back(start * (1 + 1e-7 * sign(random)));
          x1.push_back(end * (1 + 1e-7 * sign(random)));
        }
        shape.elements.push_back(spec);
      }
    }
    const Scene scene = make_scene("far", shape, x1);
    const Pairs expected = expected_pairs(scene.step(), PairRange::nonadjacent);
    EXPECT_GE(expected.size(), 8u);
    for (const Variant& variant : all)
      EXPECT_TRUE(run_fresh(*variant.phase, scene.step(), PairRange::nonadjacent) == expected) << variant.name;
  }
}

/// Random meshes of several objects in random motions, with one state for all of them.
TEST(Peers, FollowMotionsEditsAndFilters) {
  const std::vector<Variant> all = variants();
  if (all.empty()) GTEST_SKIP() << "built without broad phases of other libraries";
  for (std::uint64_t seed = 0; seed < 6; ++seed) {
    std::mt19937_64 random(seed);
    Shape shape = permuted(block(ElementType::tetrahedron, 4, 3, 3), seed);
    Shape other = mixed_block(2, 1);
    shape.append(other.translate({1.5, 0.3 * static_cast<double>(seed), 0.2}), 1);
    Scene scene = make_scene("motions", shape, shape.positions);
    std::vector<std::unique_ptr<StageState>> states;
    for (const Variant& variant : all) states.push_back(variant.phase->make_state());
    for (int step = 0; step < 10; ++step) {
      SCOPED_TRACE("seed " + std::to_string(seed) + ", step " + std::to_string(step));
      const double far = step == 5 ? 1e19 : 1;  // beyond the range that some peers accept
      scene.motion = step % 3 == 2 ? Motion::quadratic(shape.positions, jittered(shape.positions, 0.4, random()),
                                                       scaled(jittered(shape.positions, 0.4, random()), far))
                                   : Motion::linear(scaled(jittered(shape.positions, 0.2, random()), far),
                                                    scaled(jittered(shape.positions, 0.4 * step, random()), far));
      scene.separation = step % 2 == 1 ? 0.1 * static_cast<double>(random() % 4) : 0;
      scene.filter = ObjectFilter(step % 4 == 1 ? PairScope::inter : step % 4 == 3 ? PairScope::intra : PairScope::all);
      const PairRange range = random() % 2 == 0 ? PairRange::every : PairRange::nonadjacent;
      const Pairs expected = expected_pairs(scene.step(), range);
      const auto executor = make_thread_executor(1 + static_cast<unsigned>(step % 3));
      for (std::size_t i = 0; i < all.size(); ++i)
        EXPECT_TRUE(run(*all[i].phase, scene.step(), *states[i], range, *executor) == expected) << all[i].name;
      if (step % 3 != 1) continue;
      TopologyEdit edit;  // some elements are removed, then all of them, and new ones are added
      const Mesh& mesh = scene.topology->mesh();
      for (Index o = 0; o < mesh.element_slots(); ++o)
        if (mesh.is_live(o) && random() % 4 == 0) edit.removed.push_back(o);
      for (std::size_t i = 0; i < 10; ++i) {
        const Index first = static_cast<Index>(random() % (mesh.vertex_count() - 4));
        edit.added.push_back({.type = ElementType::tetrahedron,
                              .vertices = {first, first + 1, first + 2, first + 3},
                              .object = 1,
                              .id = static_cast<std::int64_t>(10000 + 100 * step) + static_cast<std::int64_t>(i)});
      }
      scene.topology->apply(edit);
    }
  }
}

TEST(Peers, LeaveTheFloatingPointEnvironmentAsItWas) {
  const Shape shape = block(ElementType::tetrahedron, 6, 6, 6);
  const Scene scene = make_scene("block", shape, shape.positions);
  volatile double smallest = std::numeric_limits<double>::min();
  for (const Variant& variant : variants()) {
    run_fresh(*variant.phase, scene.step());
    EXPECT_EQ(std::fegetround(), FE_TONEAREST);
    const volatile double half = smallest / 2;
    EXPECT_GT(half, 0) << variant.name << " leaves subnormal numbers flushed to zero";
  }
}

TEST(Peers, TellTheirMemory) {
  const Shape shape = block(ElementType::tetrahedron, 6, 6, 6);
  const Scene scene = make_scene("block", shape, shape.positions);
  SerialExecutor executor;
  for (const Variant& variant : variants()) {
    const auto state = variant.phase->make_state();
    variant.phase->prepare(scene.step(), *state, executor);
    EXPECT_GT(state->bytes(), shape.elements.size() * 80)
        << variant.name << ": boxes and slots alone are about 50 bytes an element";
    EXPECT_LT(state->bytes(), shape.elements.size() * 4096 + 40000000) << variant.name;
  }
}

/// Only the executor determines the number of threads.
TEST(SpatialHashTest, SelfPairsComeFromAllWorkers) {
  Shape shape;
  for (int i = 0; i < 4000; ++i) {
    Shape one = block(ElementType::tetrahedron, 1, 1, 1);
    shape.append(one.translate({2.0 * i, 0, 0}), i);
  }
  Scene scene = make_scene("apart", shape, shape.positions);
  const auto phase = make(describe_spatial_hash());
  const auto state = phase->make_state();

  /// The workers process the chunks in turn.
  class Turns final : public Executor {
   public:
    unsigned workers() const override { return 2; }
    void parallel_for(std::size_t n, std::size_t grain, Body body) override {
      for (std::size_t begin = 0, turn = 0; begin < n; begin += std::max<std::size_t>(grain, 1), ++turn)
        body(begin, std::min(n, begin + std::max<std::size_t>(grain, 1)), static_cast<unsigned>(turn % 2));
    }
  } executor;
  std::array<std::size_t, 2> self{};
  phase->prepare(scene.step(), *state, executor);
  const auto count = [&](std::span<const ElementPair> pairs, unsigned worker) {
    for (const ElementPair pair : pairs) self[worker] += pair.a == pair.b;
  };
  visit_candidates(*phase, scene.step(), *state, executor, count);
  EXPECT_EQ(self[0] + self[1], shape.elements.size());
  EXPECT_GT(std::min(self[0], self[1]), shape.elements.size() / 4);
}

}  // namespace
}  // namespace volccd::test
