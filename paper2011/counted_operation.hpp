// An operation on many samples: its floating-point operations, counted, and its time.
#pragma once

#include <algorithm>
#include <chrono>
#include <functional>
#include <utility>
#include <vector>

#include <nlohmann/json.hpp>

#include <volccd/core/median.hpp>
#include <volccd/paper2011/counted_double.hpp>
#include <volccd/paper2011/reference_vectors.hpp>

namespace volccd {

/// Trajectories in numbers that count.
inline reference::MovingPoint<CountedDouble> counted(const reference::MovingPoint<double>& p) {
  return {{p.x0[0], p.x0[1], p.x0[2]}, {p.x1[0], p.x1[1], p.x1[2]}};
}
inline std::vector<reference::MovingPoint<CountedDouble>> counted(
    const std::vector<reference::MovingPoint<double>>& points) {
  std::vector<reference::MovingPoint<CountedDouble>> result;
  for (const auto& p : points) result.push_back(counted(p));
  return result;
}

class CountedOperation {
 public:
  /// Counts the operations of `run`, a generic callable that takes a sample, or `counted(sample)`, and returns whether
  /// it found what it looks for. `samples` must not be empty, and must outlive the object. `row`: the first columns.
  template <class Sample, class Run>
  static CountedOperation of(nlohmann::json row, const std::vector<Sample>& samples, Run run) {
    CountedOperation operation;
    operation.row_ = std::move(row);
    operation.row_["tests"] = samples.size();
    operation.count(samples, run);
    operation.pass_ = [run, &samples] {
      std::size_t found = 0;
      for (const Sample& sample : samples) found += run(sample) ? 1 : 0;
      return found;
    };
    operation.tests_ = samples.size();
    return operation;
  }

  /// Measures some passes over the samples.
  void time() {
    using Clock = std::chrono::steady_clock;
    const auto start = Clock::now();
    for (int pass = 0; pass < kPasses; ++pass) found_ += pass_();
    const double seconds = std::chrono::duration<double>(Clock::now() - start).count();
    times_.push_back(seconds * 1e9 / static_cast<double>(kPasses * tests_));
  }

  /// `row`, "tests", means of the counts, "max": their maxima, "ns": the median of the times measured, "positive":
  /// share of the samples for which `run` returned true. Pre: time() was called.
  nlohmann::json row() const {
    nlohmann::json result = row_;
    result["ns"] = median(times_);
    result["positive"] = static_cast<double>(found_) / static_cast<double>(kPasses * times_.size() * tests_);
    return result;
  }

 private:
  static constexpr int kPasses = 8;

  struct NamedCount {
    const char* name;
    std::uint64_t OperationCounts::*count;
  };
  static constexpr NamedCount kCounts[] = {
      {"additions", &OperationCounts::additions},       {"multiplications", &OperationCounts::multiplications},
      {"divisions", &OperationCounts::divisions},       {"comparisons", &OperationCounts::comparisons},
      {"square_roots", &OperationCounts::square_roots}, {"absolute_values", &OperationCounts::absolute_values}};

  template <class Sample, class Run>
  void count(const std::vector<Sample>& samples, const Run& run) {
    OperationCounts sum, max;
    for (const Sample& plain : samples) {
      const auto sample = counted(plain);
      CountedDouble::counts() = {};
      run(sample);
      for (const NamedCount& one : kCounts) {
        const std::uint64_t value = CountedDouble::counts().*one.count;
        sum.*one.count += value;
        max.*one.count = std::max(max.*one.count, value);
      }
    }
    for (const NamedCount& one : kCounts) {
      row_[one.name] = static_cast<double>(sum.*one.count) / static_cast<double>(samples.size());
      row_["max"][one.name] = max.*one.count;
    }
  }

  nlohmann::json row_;
  std::function<std::size_t()> pass_;
  std::size_t tests_ = 0, found_ = 0;
  std::vector<double> times_;
};

}  // namespace volccd
