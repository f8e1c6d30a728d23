// A contact names its features and one element of each by slot: compared with a search by vertices.
#include <algorithm>
#include <span>

#include <gtest/gtest.h>

#include <volccd/pipelines/step_runner.hpp>

#include "scenes.hpp"

namespace volccd::test {
namespace {

Index element_of_smallest_id(const Mesh& mesh, std::span<const Index> elements) {
  return *std::ranges::min_element(elements, {}, [&](Index o) { return mesh.element_id(o); });
}

void expect_slots(const Topology& topology, const Contact& contact) {
  const Features& features = topology.features();
  const auto& v = contact.vertices;
  const bool vf = contact.kind == FeatureKind::vf;
  const Index a = vf ? v[0] : features.find_edge(v[0], v[1]);
  const Index b = vf ? features.find_triangle(v[1], v[2], v[3]) : features.find_edge(v[2], v[3]);
  EXPECT_EQ(contact.features.a, a);
  EXPECT_EQ(contact.features.b, b);
  EXPECT_EQ(contact.elements[0],
            element_of_smallest_id(topology.mesh(), vf ? features.vertex_elements(a) : features.edge_elements(a)));
  EXPECT_EQ(contact.elements[1],
            element_of_smallest_id(topology.mesh(), vf ? features.triangle_elements(b) : features.edge_elements(b)));
}

/// Removes a part of the elements, and adds them again in opposite order: features move to other slots, and an edge of
/// smaller slot may have greater vertices.
void exchange_slots(Topology& topology, Index stride) {
  TopologyEdit removal, addition;
  for (Index o = 0; o < topology.mesh().element_slots(); ++o)
    if (topology.mesh().is_live(o) && o % stride != 0) {
      removal.removed.push_back(o);
      addition.added.push_back(topology.mesh().spec(o));
    }
  std::ranges::reverse(addition.added);
  topology.apply(removal);
  topology.apply(addition);
}

TEST(ContactSlots, EqualASearchByVertices) {
  for (const char* preset : {"VolCCD+", "VolCCD", "NavCCD"})
    for (const Scene& scene : small_scenes(4, 0.1)) {
      StepRunner runner(Pipeline(registry(), registry().pipeline(preset)));
      const StepResult& all = runner.run(scene.topology, scene.motion);
      EXPECT_GT(all.contacts.size(), 0u) << scene.name;
      for (const Contact& contact : all.contacts) expect_slots(scene.topology, contact);
      const StepResult& first = runner.run(scene.topology, scene.motion, {.query = Query::first});
      for (const Contact& contact : first.contacts) expect_slots(scene.topology, contact);
    }
}

TEST(ContactSlots, EqualASearchByVerticesAfterEdits) {
  std::size_t reversed = 0;
  for (Scene& scene : small_scenes(5, 0.1)) {
    StepRunner runner(Pipeline(registry(), registry().pipeline("VolCCD+")));
    for (const Index stride : {2, 3}) {
      exchange_slots(scene.topology, stride);
      for (const Contact& contact : runner.run(scene.topology, scene.motion).contacts) {
        expect_slots(scene.topology, contact);
        reversed += contact.kind == FeatureKind::ee && contact.features.a > contact.features.b ? 1 : 0;
      }
    }
  }
  EXPECT_GT(reversed, 20u);
}

}  // namespace
}  // namespace volccd::test
