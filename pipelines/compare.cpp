#include <volccd/pipelines/compare.hpp>

namespace volccd {

ContactDifference compare_contacts(std::span<const Contact> expected, std::span<const Contact> found) {
  ContactDifference difference;
  std::size_t i = 0, j = 0;
  while (i < expected.size() || j < found.size()) {
    if (j == found.size() || (i < expected.size() && canonical_less(expected[i], found[j]))) {
      difference.missing.push_back(expected[i++]);
    } else if (i == expected.size() || canonical_less(found[j], expected[i])) {
      difference.extra.push_back(found[j++]);
    } else {
      if (!(expected[i] == found[j])) difference.changed.emplace_back(expected[i], found[j]);
      ++i, ++j;
    }
  }
  return difference;
}

}  // namespace volccd
