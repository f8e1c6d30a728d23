// How late contacts may be that a query still asks for.
#pragma once

#include <algorithm>
#include <atomic>
#include <span>

#include <volccd/pipelines/pipeline.hpp>

namespace volccd::detail {

/// With Query::first, what touches only after the best contact so far is irrelevant. Shared by all workers.
class EarliestTime {
 public:
  /// `tolerance`: by how much the narrow phase may report a time early.
  EarliestTime(Query query, double t_max, double tolerance)
      : first_(query == Query::first), t_max_(t_max), slack_(1e-12 + tolerance), best_(std::min(t_max, 1.0)) {}

  /// Until when stages have to find contacts. Since the narrow phase rounds its times, a slack is added, so that the
  /// answer does not depend on the order in which workers find contacts. The narrow phase itself always receives the
  /// original step.
  double limit() const {
    return first_ ? std::min(1.0, best_.load(std::memory_order_relaxed) * (1 + 1e-9) + slack_) : t_max_;
  }

  /// Records contacts from `old_contacts` on, and removes those that are later than the best one. Without Query::first,
  /// nothing changes.
  void record(std::vector<Contact>& contacts, std::size_t old_contacts) {
    if (!first_) return;
    double best = best_.load(std::memory_order_relaxed);
    for (std::size_t i = old_contacts; i < contacts.size(); ++i)
      while (contacts[i].toi < best && !best_.compare_exchange_weak(best, contacts[i].toi, std::memory_order_relaxed)) {
      }
    best = best_.load(std::memory_order_relaxed);
    std::erase_if(contacts, [best](const Contact& contact) { return contact.toi > best; });
  }

 private:
  const bool first_;
  const double t_max_, slack_;
  std::atomic<double> best_;
};

}  // namespace volccd::detail
