// Whether two pipelines found the same contacts.
#pragma once

#include <span>
#include <vector>

#include <volccd/query/contact.hpp>

namespace volccd {

/// How `found` differs from `expected`, both in canonical order without duplicates (StepResult::contacts).
struct ContactDifference {
  std::vector<Contact> missing;  ///< expected, not found
  std::vector<Contact> extra;    ///< found, not expected
  std::vector<std::pair<Contact, Contact>> changed;  ///< expected, found: another time, normal, weight or point

  bool empty() const { return missing.empty() && extra.empty() && changed.empty(); }
};

/// Bit for bit. O(n).
ContactDifference compare_contacts(std::span<const Contact> expected, std::span<const Contact> found);

}  // namespace volccd
