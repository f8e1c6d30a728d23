// The result of a step, from what the workers found.
#pragma once

#include <memory>
#include <span>
#include <vector>

#include <volccd/core/executor.hpp>
#include <volccd/pipelines/detail/contact_order.hpp>
#include <volccd/pipelines/detail/worker_scratch.hpp>

namespace volccd::detail {

/// Reused from step to step.
class ResultMerger {
 public:
  /// Sets contacts, in canonical order and each once, and initial overlaps; and the sums of the counts of all workers.
  void merge(std::span<const std::unique_ptr<WorkerScratch>> workers, Executor& executor, StepResult& result);

  /// Sets the tests that the chains of the workers collected, ascending and each once.
  static void merge_collected(std::span<const std::unique_ptr<WorkerScratch>> workers, TestBatch& tests);

  std::size_t bytes() const { return heap_bytes(order_, contacts_of_); }

 private:
  ContactOrder order_;
  std::vector<std::span<const Contact>> contacts_of_;  ///< by worker
};

/// Leaves the earliest contact alone, among those of one time the first in canonical order.
void keep_earliest(std::vector<Contact>& contacts);

/// Sets the order of Contact::features, Contact::elements, StepResult::ends if wanted, and the counts of contacts.
void complete(StepResult& result, const Step& step, bool ends, Executor& executor);

}  // namespace volccd::detail
