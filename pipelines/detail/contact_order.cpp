#include <volccd/pipelines/detail/contact_order.hpp>

#include <algorithm>

namespace volccd::detail {

namespace {

/// Lists of fewer sorted runs are merged, and not sorted.
constexpr std::size_t kFewRuns = 8;

/// Calls visit(begin) for each place where a key is less than the one before it, until it returns false. Returns
/// whether it never did.
template <class Keys, class Visit>
bool visit_runs(const Keys& keys, Visit&& visit) {
  for (std::size_t i = 1; i < keys.size(); ++i)
    if (keys[i] < keys[i - 1] && !visit(i)) return false;
  return true;
}

}  // namespace

/// Divides the keys into sorted ranges. A list of few sorted runs stays as it is: contacts of a candidate list come in
/// order but for the last tests of each kind. Others are sorted.
void ContactOrder::sort_lists(std::span<const std::span<const Contact>> lists, Executor& executor) {
  begins_.assign(1, 0);
  for (const std::span<const Contact> list : lists) begins_.push_back(begins_.back() + list.size());
  keys_.resize(begins_.back());
  executor.parallel_for(lists.size(), 1, [&](std::size_t begin, std::size_t end, unsigned) {
    for (std::size_t l = begin; l < end; ++l) {
      const std::span<Key> keys = std::span(keys_).subspan(begins_[l], lists[l].size());
      for (std::size_t i = 0; i < keys.size(); ++i) keys[i] = {lists[l][i], l, i};
      if (std::size_t runs = 0; !visit_runs(keys, [&](std::size_t) { return ++runs < kFewRuns; }))
        std::sort(keys.begin(), keys.end());
    }
  });
  begins_.assign(1, 0);
  visit_runs(keys_, [&](std::size_t run) { return begins_.push_back(run), true; });
  begins_.push_back(keys_.size());
  merged_.resize(begins_.size() > 2 ? keys_.size() : 0);
}

/// Merges two neighbouring ranges at a time until one is left.
void ContactOrder::merge_lists(Executor& executor) {
  while (begins_.size() > 2) {
    const std::size_t ranges = begins_.size() - 1, pairs = (ranges + 1) / 2;
    const auto at = [&](std::size_t range) {
      return keys_.begin() + static_cast<std::ptrdiff_t>(begins_[std::min(range, ranges)]);
    };
    executor.parallel_for(pairs, 1, [&](std::size_t begin, std::size_t end, unsigned) {
      for (std::size_t p = begin; p < end; ++p)
        std::merge(at(2 * p), at(2 * p + 1), at(2 * p + 1), at(2 * p + 2),
                   merged_.begin() + static_cast<std::ptrdiff_t>(begins_[2 * p]));
    });
    keys_.swap(merged_);
    for (std::size_t p = 1; p < pairs; ++p) begins_[p] = begins_[2 * p];
    begins_[pairs] = begins_[ranges];
    begins_.resize(pairs + 1);
  }
}

std::size_t ContactOrder::collect(std::span<const std::span<const Contact>> lists, Executor& executor,
                                  std::vector<Contact>& out) {
  sort_lists(lists, executor);
  merge_lists(executor);
  const std::size_t found = keys_.size();
  keys_.erase(std::unique(keys_.begin(), keys_.end()), keys_.end());
  out.resize(keys_.size());
  constexpr std::size_t grain = 2048;
  executor.parallel_for(keys_.size(), grain, [&](std::size_t begin, std::size_t end, unsigned) {
    for (std::size_t i = begin; i < end; ++i) out[i] = lists[keys_[i].list][keys_[i].place];
  });
  return found - keys_.size();
}

}  // namespace volccd::detail
