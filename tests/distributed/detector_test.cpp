// One rank's side of a detector: any distribution of elements and vertices, edits, what is given back, what is refused.
#include <volccd/distributed/detector.hpp>

#include <algorithm>
#include <limits>
#include <map>
#include <string>

#include <gtest/gtest.h>

#include <volccd/core/random.hpp>
#include <volccd/distributed/detail/imbalance.hpp>
#include <volccd/distributed/in_process_exchange.hpp>
#include <volccd/oracle/cases/colliding_scenes.hpp>
#include <volccd/pipelines/step_runner.hpp>

#include "distributed/registry.hpp"

namespace volccd::distributed {
namespace {

using cases::Scene;

PipelineSpec exact_spec(const std::string& name = "VolCCD+") {
  PipelineSpec spec = registry().pipeline(name);
  registry().apply_setting(spec, "inclusion.undecided=exact");
  return spec;
}

/// Vertex ids that need 64 bits, ascending with the slots.
std::int64_t wide(std::int64_t slot) { return (std::int64_t{1} << 40) + 7 * slot; }

/// What a rank gives: a random part of the elements and vertices, vertices in random order.
struct Part {
  Elements elements;
  std::vector<Index> slots;  ///< of its vertices
  std::vector<std::int64_t> ids;
  Motion motion;
};

/// `ranks_with_data`: the others have neither elements nor vertices.
std::vector<Part> divided(const Mesh& mesh, const Motion& motion, int ranks, int ranks_with_data, std::uint64_t seed) {
  Random random(seed);
  std::vector<Part> parts(static_cast<std::size_t>(ranks));
  const auto any = [&]() -> Part& { return parts[random.below(static_cast<std::uint64_t>(ranks_with_data))]; };
  for (Index o = 0; o < mesh.element_slots(); ++o) {
    if (!mesh.is_live(o)) continue;
    Elements one;
    one.add(mesh, o);
    for (std::int64_t& v : one.vertices) v = wide(v);
    for (std::size_t k = 0, rest = 0; k < one.faces.size(); ++k) {
      if (rest == 0)
        rest = static_cast<std::size_t>(one.faces[k]);
      else
        --rest, one.faces[k] = wide(one.faces[k]);
    }
    any().elements.add(one, 0);
  }
  std::vector<Index> slots(mesh.vertex_count());
  for (Index v = 0; v < mesh.vertex_count(); ++v) slots[v] = v;
  random.shuffle(slots);
  for (const Index v : slots) any().slots.push_back(v);
  for (Part& part : parts) {
    part.motion = Motion(static_cast<Index>(part.slots.size()), motion.control_points());
    for (Index i = 0; i < part.slots.size(); ++i) {
      part.ids.push_back(wide(part.slots[i]));
      for (int c = 0; c < motion.control_points(); ++c) part.motion.set(i, c, motion.point(part.slots[i], c));
    }
  }
  return parts;
}

void set_motion(Part& part, const Motion& motion) {
  for (Index i = 0; i < part.slots.size(); ++i)
    for (int c = 0; c < motion.control_points(); ++c) part.motion.set(i, c, motion.point(part.slots[i], c));
}

/// A contact of the whole mesh with ids.
RankContact with_ids(const Contact& contact, const Mesh& mesh) {
  RankContact result{.kind = contact.kind,
                     .toi = contact.toi,
                     .normal = contact.normal,
                     .weights = contact.weights,
                     .point = contact.point,
                     .at_start = contact.at_start,
                     .gap = contact.gap};
  for (std::size_t i = 0; i < 4; ++i) result.vertices[i] = wide(contact.vertices[i]);
  for (std::size_t i = 0; i < 2; ++i) {
    result.elements[i] = mesh.element_id(contact.elements[i]);
    result.objects[i] = mesh.object(contact.elements[i]);
  }
  return result;
}

std::vector<RankContact> with_ids(const std::vector<Contact>& contacts, const Mesh& mesh) {
  std::vector<RankContact> result;
  for (const Contact& contact : contacts) result.push_back(with_ids(contact, mesh));
  return result;
}

bool less(const RankContact& x, const RankContact& y) { return canonical_less(x, y); }

std::vector<RankContact> sorted(std::vector<RankContact> contacts) {
  std::ranges::sort(contacts, less);
  return contacts;
}

/// Runs body(exchange, part) on all ranks.
template <class Body>
void on_ranks(std::vector<Part>& parts, Body&& body) {
  InProcessRanks(static_cast<int>(parts.size())).run([&](Exchange& exchange) {
    body(exchange, parts[static_cast<std::size_t>(exchange.rank())]);
  });
}

TEST(RankDetector, AnyDistributionGivesTheContactsOfTheWhole) {
  for (const Scene& scene : cases::small_scenes(3, 0.15))
    for (const int ranks : {1, 3, 8})
      for (const int with_data : {1, ranks}) {
        SCOPED_TRACE(scene.name + ", ranks: " + std::to_string(ranks));
        StepRunner runner(Pipeline(registry(), exact_spec()));
        const Request request{.initial_overlaps = true};
        const StepResult& whole = runner.run(scene.topology, scene.motion, request);
        const Mesh& mesh = scene.topology.mesh();
        std::vector<RankContact> all;
        std::vector<std::array<std::int64_t, 2>> overlaps;
        auto parts = divided(mesh, scene.motion, ranks, with_data, 11);
        const std::vector<RankContact> expected = with_ids(whole.contacts, mesh);
        on_ranks(parts, [&](Exchange& exchange, Part& part) {
          Detector detector(exchange, registry(), exact_spec());
          detector.set_mesh(part.elements, part.ids);
          const RankResult& result = detector.step(part.motion, request);
          EXPECT_TRUE(std::ranges::is_sorted(result.contacts, less));
          all.insert(all.end(), result.contacts.begin(), result.contacts.end());
          overlaps.insert(overlaps.end(), result.initial_overlaps.begin(), result.initial_overlaps.end());
          std::vector<RankContact> mine;
          for (const RankContact& contact : expected)
            if (std::ranges::any_of(contact.vertices, [&](auto id) { return std::ranges::count(part.ids, id) > 0; }))
              mine.push_back(contact);
          EXPECT_EQ(detector.to_owners(), mine);
        });
        EXPECT_EQ(sorted(all), expected);
        EXPECT_EQ(overlaps.size(), whole.initial_overlaps.size());
      }
}

TEST(RankDetector, OneRankKeepsTheFirstContact) {
  const Scene scene = cases::colliding("block", block(ElementType::tetrahedron, 3, 2, 2), 4, 0.05);
  StepRunner runner(Pipeline(registry(), exact_spec()));
  const StepResult& whole = runner.run(scene.topology, scene.motion, {.query = Query::first});
  ASSERT_EQ(whole.contacts.size(), 1u);
  auto parts = divided(scene.topology.mesh(), scene.motion, 5, 5, 2);
  std::vector<RankContact> all;
  on_ranks(parts, [&](Exchange& exchange, Part& part) {
    Detector detector(exchange, registry(), exact_spec());
    detector.set_mesh(part.elements, part.ids);
    const auto& found = detector.step(part.motion, {.query = Query::first}).contacts;
    all.insert(all.end(), found.begin(), found.end());
  });
  EXPECT_EQ(all, with_ids(whole.contacts, scene.topology.mesh()));
}

/// Small motions, then greater ones: lists are kept while they serve. Contacts are those of the whole in each step,
/// with cuts by measured times in between, too.
TEST(RankDetector, ListsAndRegionsChangeWhenTheyMust) {
  const Scene scene = cases::colliding("block", block(ElementType::tetrahedron, 4, 3, 2), 6, 0.1);
  for (const double max_imbalance : {-1e9, std::numeric_limits<double>::infinity()}) {
    StepRunner runner(Pipeline(registry(), exact_spec()));
    auto parts = divided(scene.topology.mesh(), scene.motion, 6, 6, 3);
    std::vector<std::uint64_t> lists, cuts;
    on_ranks(parts, [&](Exchange& exchange, Part& part) {
      Detector detector(exchange, registry(), exact_spec(), {.skin = 0.3, .max_imbalance = max_imbalance});
      detector.set_mesh(part.elements, part.ids);
      Vec3 corner = Vec3::Zero();
      for (const double end : {0.1, 0.11, 0.12, 0.13, 0.8, 0.81, 0.1, 0.1, 1.0, 1.0, 1.0}) {
        Motion motion;
        motion.set_part(scene.motion, 0, end);
        set_motion(part, motion);
        detector.step(part.motion);
        const auto gathered = exchange.allgather(to_bytes(detector.result().contacts));
        if (exchange.rank() != 0) continue;
        std::vector<RankContact> all;
        for (const Bytes& bytes : gathered)
          for (const RankContact& contact : contacts_of(bytes)) all.push_back(contact);
        EXPECT_EQ(sorted(all), with_ids(runner.run(scene.topology, motion).contacts, scene.topology.mesh()));
        lists.push_back(detector.result().rank.lists);
        const Vec3 now = detector.regions().region(0).high.cwiseMin(1e9);
        cuts.push_back(now != corner ? 1 : 0);
        corner = now;
      }
    });
    if (max_imbalance > 0) {
      EXPECT_EQ(lists, (std::vector<std::uint64_t>{1, 0, 0, 0, 1, 0, 1, 0, 1, 0, 0}));
      EXPECT_EQ(std::ranges::count(cuts, 1u), 1);
    } else {
      for (const std::size_t k : {2, 4, 6, 8, 10}) EXPECT_EQ(lists[k], 1u) << "one step has lost more than any price";
    }
  }
}

/// Two ranks with given times: new cuts when the slower one has lost a 16th of what the first step took, then the whole
/// of it, then twice that.
TEST(Imbalance, WantsCutsWhenTheirPriceIsLost) {
  InProcessRanks(2).run([](Exchange& exchange) {
    detail::Imbalance imbalance(1.25);
    const auto steps = [&](double slow, double fast, bool after_cuts = false) {
      const double seconds = exchange.rank() == 1 ? slow : fast;
      imbalance.add_step(exchange, seconds, 2 * seconds, 100, after_cuts);
      return imbalance.needs_cuts();
    };
    EXPECT_FALSE(steps(2, 0.5, true)) << "its price is a 16th of 4";
    EXPECT_FALSE(steps(1.5, 0.5)) << "a quarter lost beyond 1.25 times the mean";
    EXPECT_TRUE(steps(1.5, 0.5));
    EXPECT_FALSE(steps(1.05, 0.5, true)) << "its price is 2.1";
    for (int k = 0; k < 3; ++k) EXPECT_FALSE(steps(1.5, 0.5)) << "each loses a quarter beyond 1.25 times the mean";
    for (int k = 0; k < 10; ++k) EXPECT_FALSE(steps(1.0, 0.8)) << "nothing lost";
    for (int k = 3; k < 8; ++k) EXPECT_FALSE(steps(1.5, 0.5)) << k;
    EXPECT_TRUE(steps(1.5, 0.5)) << "2.25 lost";
    const std::vector<double> density = imbalance.density(exchange);
    EXPECT_NEAR(density[1], (9 * 1.5 + 10 * 1.0) / 1900, 1e-9) << "the first step is no measure";
    EXPECT_FALSE(steps(1.05, 0.5, true)) << "its price is 4.2";
    for (int k = 0; k < 16; ++k) EXPECT_FALSE(steps(1.5, 0.5)) << k;
    EXPECT_TRUE(steps(1.5, 0.5));
  });
}

/// A block slides along another one in small steps, upwards on one axis: boxes leave theirs with skin on that side
/// alone, and cross into other regions before that.
TEST(RankDetector, ListsFollowASlidingBlock) {
  Shape both;
  both.append(block(ElementType::tetrahedron, 8, 1, 1), 1);
  const std::size_t fixed = both.positions.size();
  Shape slider = block(ElementType::tetrahedron, 2, 1, 1);
  both.append(slider.translate(Vec3(0.05, 0.1, 0.7)), 2);
  const Topology topology(both.mesh());
  const auto shifted = [&](double x) {
    std::vector<Vec3> positions = both.positions;
    for (std::size_t v = fixed; v < positions.size(); ++v) positions[v].x() += x;
    return positions;
  };
  StepRunner runner(Pipeline(registry(), exact_spec()));
  auto parts = divided(topology.mesh(), Motion::linear(both.positions, both.positions), 7, 7, 4);
  std::uint64_t lists = 0;
  std::size_t contacts = 0;
  on_ranks(parts, [&](Exchange& exchange, Part& part) {
    Detector detector(exchange, registry(), exact_spec(), {.skin = 1, .max_imbalance = 1e9});
    detector.set_mesh(part.elements, part.ids);
    for (int step = 0; step < 50; ++step) {
      const Motion motion = Motion::linear(shifted(0.1 * step), shifted(0.1 * (step + 1)));
      set_motion(part, motion);
      const auto gathered = exchange.allgather(to_bytes(detector.step(part.motion).contacts));
      if (exchange.rank() != 0) continue;
      std::vector<RankContact> all;
      for (const Bytes& bytes : gathered)
        for (const RankContact& contact : contacts_of(bytes)) all.push_back(contact);
      EXPECT_EQ(sorted(all), with_ids(runner.run(topology, motion).contacts, topology.mesh())) << step;
      lists += detector.result().rank.lists;
      contacts += all.size();
    }
  });
  EXPECT_GT(contacts, 200u);
  EXPECT_GT(lists, 2u);
  EXPECT_LT(lists, 15u);
}

TEST(RankDetector, Edits) {
  Scene scene = cases::colliding("block", block(ElementType::tetrahedron, 3, 2, 2), 6, 0.2);
  StepRunner runner(Pipeline(registry(), exact_spec()));
  auto parts = divided(scene.topology.mesh(), scene.motion, 4, 4, 5);
  std::vector<Elements> removed(parts.size());
  std::vector<RankContact> before, after, back;
  on_ranks(parts, [&](Exchange& exchange, Part& part) {
    Detector detector(exchange, registry(), exact_spec());
    // The last vertex of the rank comes by the edit, with the elements that it is a corner of.
    std::vector<std::int64_t> ids(part.ids.begin(), part.ids.end());
    detector.set_mesh(part.elements, ids);
    const auto collect = [&](std::vector<RankContact>& all) {
      const auto& found = detector.step(part.motion).contacts;
      all.insert(all.end(), found.begin(), found.end());
    };
    collect(before);
    Elements& gone = removed[static_cast<std::size_t>(exchange.rank())];
    for (std::size_t i = 0; i < part.elements.size(); i += 3) gone.add(part.elements, i);
    detector.edit(gone.ids, {}, {});
    collect(after);
    // A new vertex on rank 2, which no element uses, and the elements again, on the next rank.
    exchange.allgather({});
    const Elements& others = removed[static_cast<std::size_t>((exchange.rank() + 1) % exchange.size())];
    if (exchange.rank() == 2) {
      detector.edit({}, std::vector<std::int64_t>{3}, others);
      Motion longer(part.motion.vertex_count() + 1, 2);
      for (Index v = 0; v < part.motion.vertex_count(); ++v)
        for (int c = 0; c < 2; ++c) longer.set(v, c, part.motion.point(v, c));
      part.motion = longer;
    } else {
      detector.edit({}, {}, others);
    }
    collect(back);
    EXPECT_THROW(
        detector.edit(exchange.rank() == 1 ? std::vector<std::int64_t>{-5} : std::vector<std::int64_t>{}, {}, {}),
        RankError);
  });
  const std::vector<RankContact> whole =
      with_ids(runner.run(scene.topology, scene.motion).contacts, scene.topology.mesh());
  EXPECT_EQ(sorted(before), whole);
  EXPECT_EQ(sorted(back), whole);
  TopologyEdit edit;
  for (const Elements& gone : removed)
    for (const std::int64_t id : gone.ids) edit.removed.push_back(scene.topology.mesh().find_element(id));
  scene.topology.apply(edit);
  EXPECT_EQ(sorted(after), with_ids(runner.run(scene.topology, scene.motion).contacts, scene.topology.mesh()));
  EXPECT_NE(whole.size(), after.size());
}

/// The text that all of three ranks throw; they must go on afterwards.
template <class Act>
std::string refusal(Act&& act) {
  const Scene scene = cases::colliding("block", block(ElementType::tetrahedron, 2, 1, 1), 1, 0.1);
  auto parts = divided(scene.topology.mesh(), scene.motion, 3, 3, 5);
  std::vector<std::string> texts;
  on_ranks(parts, [&](Exchange& exchange, Part& part) {
    Detector detector(exchange, registry(), exact_spec());
    detector.set_mesh(part.elements, part.ids);
    Part changed = part;
    try {
      act(exchange, detector, changed, parts);
      ADD_FAILURE() << "nothing was refused";
    } catch (const RankError& error) {
      texts.push_back(error.what());
    }
    detector.set_separation(0);
    EXPECT_NO_THROW(detector.step(part.motion));
  });
  EXPECT_EQ(texts.size(), 3u);
  for (const std::string& text : texts) EXPECT_EQ(text, texts.front());
  return texts.empty() ? "" : texts.front();
}

#define EXPECT_TEXT(part, text) EXPECT_NE((text).find(part), std::string::npos) << (text)

TEST(RankDetector, RefusesMeshesThatDoNotFitTogether) {
  using Parts = std::vector<Part>;
  std::string text = refusal([](Exchange& exchange, Detector& detector, Part& part, const Parts& parts) {
    if (exchange.rank() == 2) part.ids.push_back(parts[1].ids.front());
    detector.set_mesh(part.elements, part.ids);
  });
  EXPECT_TEXT("is given by rank 1 and by rank 2", text);
  EXPECT_TEXT("vertex id 1099", text);
  text = refusal([](Exchange& exchange, Detector& detector, Part& part, const Parts&) {
    if (exchange.rank() == 1) part.ids.push_back(part.ids.front());
    detector.set_mesh(part.elements, part.ids);
  });
  EXPECT_TEXT("is given twice by rank 1", text);
  text = refusal([](Exchange& exchange, Detector& detector, Part& part, const Parts& parts) {
    if (exchange.rank() == 0) part.elements.add(parts[2].elements, 1);
    detector.set_mesh(part.elements, part.ids);
  });
  EXPECT_TEXT("element id", text);
  EXPECT_TEXT("is given by rank 0 and by rank 2", text);
  text = refusal([](Exchange& exchange, Detector& detector, Part& part, const Parts&) {
    if (exchange.rank() == 1) part.ids.pop_back();
    detector.set_mesh(part.elements, part.ids);
  });
  EXPECT_TEXT("no rank gives its vertex id", text);
  text = refusal([](Exchange& exchange, Detector& detector, Part& part, const Parts&) {
    if (exchange.rank() == 1) part.elements.vertices[1] = part.elements.vertices[0];
    detector.set_mesh(part.elements, part.ids);
  });
  EXPECT_TEXT("rank 1 of 3: mesh: mesh: elements[", text);
  EXPECT_TEXT("occurs twice in the element", text);
  text = refusal([](Exchange& exchange, Detector& detector, Part& part, const Parts&) {
    if (exchange.rank() == 1) part.elements.offsets.pop_back();
    detector.set_mesh(part.elements, part.ids);
  });
  EXPECT_TEXT("do not have the same length", text);
}

TEST(RankDetector, RefusesStepsAndOptionsThatDiffer) {
  using Parts = std::vector<Part>;
  std::string text = refusal([](Exchange& exchange, Detector& detector, Part& part, const Parts&) {
    detector.set_separation(exchange.rank() == 2 ? 0.25 : 0);
    detector.step(part.motion);
  });
  EXPECT_TEXT("request of a step must be the same on all ranks", text);
  EXPECT_TEXT("rank 2 has 2 control points, separation 0.25", text);
  text = refusal([](Exchange& exchange, Detector& detector, Part& part, const Parts&) {
    detector.step(part.motion, {.query = exchange.rank() == 1 ? Query::first : Query::all});
  });
  EXPECT_TEXT("rank 1 has 2 control points, separation 0, first contact", text);
  text = refusal([](Exchange& exchange, Detector& detector, Part& part, const Parts&) {
    detector.step(exchange.rank() == 1 ? Motion(1, 2) : part.motion);
  });
  EXPECT_TEXT("rank 1 of 3: step: step: motion: moves 1 vertices", text);
  text = refusal([](Exchange& exchange, Detector& detector, Part& part, const Parts&) {
    std::vector<Vec3> points(part.ids.size(), Vec3::Zero());
    if (exchange.rank() == 1) points.front().x() = std::numeric_limits<double>::quiet_NaN();
    detector.step(points, points);
  });
  EXPECT_TEXT("rank 1 of 3: step: motion: x0[0]: not a finite position", text);
  text = refusal([](Exchange& exchange, Detector&, Part&, const Parts&) {
    Detector(exchange, registry(), exact_spec(exchange.rank() == 1 ? "NavCCD" : "VolCCD+"));
  });
  EXPECT_TEXT("options must be the same on all ranks: rank 0 has pipeline VolCCD+", text);
  text = refusal([](Exchange& exchange, Detector&, Part&, const Parts&) {
    ObjectFilter filter;
    if (exchange.rank() == 2) filter.exclude(3, 1);
    Detector(exchange, registry(), exact_spec(), {.filter = filter});
  });
  EXPECT_TEXT("without 1-3", text);
  text = refusal([](Exchange& exchange, Detector&, Part& part, const Parts&) {
    Detector detector(exchange, registry(), exact_spec());
    detector.step(part.motion);
  });
  EXPECT_TEXT("a mesh must be set before the first step", text);
  text = refusal([](Exchange& exchange, Detector&, Part&, const Parts&) {
    Detector(exchange, registry(), exact_spec(), {.skin = exchange.rank() == 0 ? -1.0 : 0.0});
  });
  EXPECT_TEXT("rank 0 of 3: options: skin: -1 is not a finite number >= 0", text);
}

}  // namespace
}  // namespace volccd::distributed
