// Comparison of the contacts that two pipelines found.
#pragma once

#include <span>
#include <vector>

#include <volccd/query/contact.hpp>

namespace volccd {

/// The differences between `found` and `expected`. Both are in canonical order without duplicates, as
/// StepResult::contacts.
struct ContactDifference {
  std::vector<Contact> missing;                      ///< expected, but not found
  std::vector<Contact> extra;                        ///< found, but not expected
  std::vector<std::pair<Contact, Contact>> changed;  ///< expected and found contact with different time, normal,
                                                     ///< weights or point

  bool empty() const { return missing.empty() && extra.empty() && changed.empty(); }
};

/// Compares contacts bit for bit. O(n).
ContactDifference compare_contacts(std::span<const Contact> expected, std::span<const Contact> found);

}  // namespace volccd
