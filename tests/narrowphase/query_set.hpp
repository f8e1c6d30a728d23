// Runs a narrow phase on a query set.
#pragma once

#include <array>
#include <vector>

#include <volccd/oracle/cases/query_set.hpp>
#include <volccd/query/contact.hpp>
#include <volccd/query/roles/narrow_phase.hpp>

#include "support/stages.hpp"

namespace volccd::test {

/// Points 0..3 at t = 0, then at t = 1. VF: vertex, triangle; EE: edge 1, edge 2.
using Query = std::array<Vec3, 8>;

class QuerySet : public volccd::QuerySet {
 public:
  using volccd::QuerySet::QuerySet;
  QuerySet(FeatureKind kind, const std::vector<Query>& queries) : volccd::QuerySet(kind, queries) {}

  std::vector<Contact> test(const NarrowPhase& narrow, double t_max = 1, NarrowCounters* counters = nullptr) const {
    std::vector<Contact> contacts;
    NarrowCounters own;
    run_stage(narrow, step(t_max), kind(), pairs(), contacts, counters ? *counters : own);
    return contacts;
  }
};

}  // namespace volccd::test
