// The canonical order of contacts that several workers have found.
#include <volccd/pipelines/detail/contact_order.hpp>

#include <algorithm>
#include <memory>
#include <vector>

#include <gtest/gtest.h>

#include <volccd/core/random.hpp>

namespace volccd {
namespace {

/// A contact whose data follow from its features, so that repeated contacts are equal. The last bits of the vertices
/// decide about the order, and the first ones.
Contact contact(Random& random) {
  const auto vertex = [&] {
    return static_cast<Index>(random.below(3)) | (random.below(2) == 0 ? Index{0} : Index{0xf000'0000});
  };
  const FeatureKind kind = random.below(2) == 0 ? FeatureKind::vf : FeatureKind::ee;
  Contact c{kind, {vertex(), vertex(), vertex(), vertex()}, 0, Vec3::Zero(), {}, Vec3::Zero(), false};
  for (const Index v : c.vertices) c.toi = c.toi * 7 + v;
  return c;
}

/// Sorts up to 10 pieces of the list, so that it has few or many sorted runs; or leaves it as it is.
void sort_pieces(std::vector<Contact>& list, Random& random) {
  const std::size_t pieces = random.below(11);
  for (std::size_t i = 0; i < pieces; ++i)
    std::sort(list.begin() + static_cast<std::ptrdiff_t>(i * list.size() / pieces),
              list.begin() + static_cast<std::ptrdiff_t>((i + 1) * list.size() / pieces), canonical_less);
}

TEST(ThreadsContactOrder, SortsAndKeepsEachFeaturePairOnce) {
  Random random(4);
  const std::unique_ptr<Executor> executor = make_thread_executor(3);
  detail::ContactOrder order;
  std::vector<Contact> found;
  for (int round = 0; round < 300; ++round) {
    std::vector<std::vector<Contact>> lists(random.below(10));
    std::vector<Contact> expected;
    for (std::vector<Contact>& list : lists)
      for (std::uint64_t i = random.below(200); i > 0; --i) {
        list.push_back(contact(random));
        expected.push_back(list.back());
      }
    for (std::vector<Contact>& list : lists) sort_pieces(list, random);
    std::sort(expected.begin(), expected.end(), canonical_less);
    const std::size_t all = expected.size();
    expected.erase(std::unique(expected.begin(), expected.end()), expected.end());
    const std::vector<std::span<const Contact>> spans(lists.begin(), lists.end());
    ASSERT_EQ(order.collect(spans, *executor, found), all - expected.size());
    ASSERT_TRUE(found == expected) << "round " << round;
  }
}

}  // namespace
}  // namespace volccd
