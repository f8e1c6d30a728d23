// What a stage learns of the elements that take part: nothing that has changed is left out, whatever happens in
// between.
#include <volccd/query/element_subset.hpp>

#include <algorithm>
#include <memory>
#include <numeric>
#include <vector>

#include <gtest/gtest.h>

#include <volccd/core/random.hpp>
#include <volccd/oracle/cases/shapes.hpp>
#include <volccd/query/step.hpp>

namespace volccd {
namespace {

/// The vertices with which each element takes part; none for those that do not.
using Parts = std::vector<std::vector<Index>>;

Parts parts_of(const Step& step) {
  Parts parts(step.mesh().element_slots());
  for (Index o = 0; o < step.mesh().element_slots(); ++o)
    if (step.takes_part(o)) parts[o].assign(step.part(o).begin(), step.part(o).end());
  return parts;
}

class Subsets {
 public:
  explicit Subsets(std::uint64_t seed)
      : random_(seed),
        topology_(block(ElementType::tetrahedron, 2, 2, 1).mesh()),
        motion_(topology_.mesh().vertex_count(), 2),
        subsets_{std::make_unique<ElementSubset>(), std::make_unique<ElementSubset>()} {
    for (auto& subset : subsets_)
      subset->assign(topology_.mesh(), all_slots(), [](Index) { return ElementSubset::kWhole; });
  }

  Random& random() { return random_; }
  Step step() const { return {topology_, motion_, filter_, 0, 1, chosen_ < 2 ? subsets_[chosen_].get() : nullptr}; }

  /// Changes a few parts of a subset, chooses another subset, or removes or adds an element.
  void change() {
    if (random_.below(6) == 0) chosen_ = random_.below(3);
    const Mesh& mesh = topology_.mesh();
    bool same_mesh = true;
    if (random_.below(6) == 0) {
      const auto o = static_cast<Index>(random_.below(mesh.element_slots()));
      TopologyEdit edit;
      if (mesh.is_live(o))
        edit.removed.push_back(o);
      else
        edit.added.push_back(
            {ElementType::tetrahedron, {0, 1, 2, static_cast<Index>(3 + random_.below(9))}, {}, 0, id_++});
      topology_.apply(edit);
      same_mesh = false;
    }
    const std::size_t which = same_mesh ? random_.below(2) : 2;
    for (std::size_t i = 0; i < 2; ++i) {
      if (which < 2 && i != which) continue;
      const std::uint64_t seed = random_.next(), rate = 1 + random_.below(10);
      const auto chosen = [&](Index o) { return mix(seed + o) % 16 < rate; };
      std::vector<Index> slots = all_slots();
      if (same_mesh) std::erase_if(slots, [&](Index o) { return !chosen(o); });
      subsets_[i]->assign(topology_.mesh(), slots, [&](Index o) {
        if (!topology_.mesh().is_live(o)) return ElementSubset::kNoPart;
        const std::uint8_t parts[] = {ElementSubset::kNoPart, ElementSubset::kWhole, 0x7, 0xb, 0xd, 0xe};
        if (chosen(o)) parts_[i][o] = parts[mix(seed + o) / 16 % 6];
        return parts_[i][o];
      });
    }
  }

 private:
  std::vector<Index> all_slots() const {
    std::vector<Index> slots(topology_.mesh().element_slots());
    std::iota(slots.begin(), slots.end(), Index{0});
    return slots;
  }

  Random random_;
  Topology topology_;
  Motion motion_;
  ObjectFilter filter_;
  std::unique_ptr<ElementSubset> subsets_[2];
  std::vector<std::uint8_t> parts_[2] = {std::vector<std::uint8_t>(1000, ElementSubset::kWhole),
                                         std::vector<std::uint8_t>(1000, ElementSubset::kWhole)};
  std::size_t chosen_ = 0;
  std::int64_t id_ = 1000;
};

/// A subset that is cleared for another mesh has a version from which no change is known.
TEST(ElementSubset, ForgetsWhatWasBeforeAnotherMesh) {
  const Mesh large = block(ElementType::tetrahedron, 2, 1, 1).mesh(),
             small = block(ElementType::tetrahedron, 1, 1, 1).mesh();
  ElementSubset subset;
  const auto assign = [&](const Mesh& mesh) {
    std::vector<Index> slots(mesh.element_slots());
    std::iota(slots.begin(), slots.end(), Index{0});
    subset.clear();
    subset.assign(mesh, slots, [](Index) { return ElementSubset::kWhole; });
  };
  assign(small);
  const std::uint64_t version = subset.version();
  std::span<const Index> slots;
  assign(large);
  EXPECT_FALSE(subset.changes_since(version, slots));
  assign(small);
  EXPECT_EQ(subset.size(), small.element_slots());
  EXPECT_NE(subset.version(), version);
  EXPECT_FALSE(subset.changes_since(version, slots));
  const Index first = 0;
  const std::uint64_t before = subset.version();
  subset.assign(small, {&first, 1}, [](Index) { return ElementSubset::kNoPart; });
  EXPECT_TRUE(subset.changes_since(before, slots));
  subset.clear();
  EXPECT_FALSE(subset.changes_since(before, slots));
}

TEST(ElementDelta, LeavesOutNoChange) {
  for (std::uint64_t seed = 0; seed < 20; ++seed) {
    Subsets subsets(seed);
    ElementDelta delta;
    Parts confirmed;
    bool known = false;  // whether the last sync() was confirmed
    std::size_t edits = 0;
    for (int round = 0; round < 300; ++round) {
      const Step step = subsets.step();
      const Parts now = parts_of(step);
      const ElementDelta::Extent extent = delta.sync(step);
      if (!known) {
        EXPECT_EQ(extent, ElementDelta::Extent::everything);
      }
      if (extent != ElementDelta::Extent::everything) {
        const std::vector<Index>& slots = delta.changed_slots();
        EXPECT_TRUE(std::is_sorted(slots.begin(), slots.end()));
        EXPECT_EQ(extent == ElementDelta::Extent::none, slots.empty());
        for (Index o = 0; o < now.size(); ++o)
          if (o >= confirmed.size() ? !now[o].empty() : now[o] != confirmed[o]) {
            ++edits;
            ASSERT_TRUE(std::binary_search(slots.begin(), slots.end(), o)) << "seed " << seed << ", round " << round;
          }
      }
      known = subsets.random().below(8) != 0;
      if (known) {
        delta.confirm();
        confirmed = now;
      }
      for (std::uint64_t n = subsets.random().below(3); n > 0; --n) subsets.change();
    }
    EXPECT_GT(edits, 50u);
  }
}

}  // namespace
}  // namespace volccd
