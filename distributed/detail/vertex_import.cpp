#include <volccd/distributed/detail/vertex_import.hpp>

#include <cassert>
#include <utility>

#include <volccd/distributed/detail/bytes.hpp>

namespace volccd::distributed::detail {

VertexImport::VertexImport(Exchange& exchange, std::span<const std::int64_t> wanted, std::span<const int> owners,
                           const IdTable& own)
    : rank_(exchange.rank()), count_(static_cast<Index>(wanted.size())) {
  std::vector<std::vector<std::int64_t>> asked(static_cast<std::size_t>(exchange.size()));
  std::vector<std::vector<Index>> places(asked.size());
  for (Index i = 0; i < count_; ++i) {
    if (owners[i] == kNoRank) continue;
    if (owners[i] == exchange.rank()) {
      kept_own_.push_back(own.find(wanted[i]));
      kept_.push_back(i);
      continue;
    }
    asked[static_cast<std::size_t>(owners[i])].push_back(wanted[i]);
    places[static_cast<std::size_t>(owners[i])].push_back(i);
  }
  std::vector<int> askers;
  std::vector<Bytes> questions;
  for (std::size_t r = 0; r < asked.size(); ++r) {
    if (asked[r].empty()) continue;
    askers.push_back(static_cast<int>(r));
    put_values(questions.emplace_back(), asked[r]);
    received_.push_back(std::move(places[r]));
  }
  const auto graph = exchange.connect(std::move(askers));
  for (const Bytes& ids : graph->exchange(std::move(questions))) {
    auto& list = sent_.emplace_back();
    for (const std::int64_t id : values_of<std::int64_t>(ids)) list.push_back(own.find(id));
  }
  const auto sources = graph->sources();
  graph_ = exchange.connect({sources.begin(), sources.end()});
  assert(graph_->sources().size() == received_.size());
}

std::vector<std::pair<Index, int>> VertexImport::receivers() const {
  std::vector<std::pair<Index, int>> result;
  for (const Index i : kept_own_) result.emplace_back(i, rank_);
  for (std::size_t d = 0; d < sent_.size(); ++d)
    for (const Index i : sent_[d]) result.emplace_back(i, graph_->destinations()[d]);
  return result;
}

const Motion& VertexImport::update(const Motion& own) {
  const auto stride = 3 * static_cast<std::size_t>(own.control_points());
  std::vector<Bytes> messages;
  for (const std::vector<Index>& list : sent_) {
    Bytes& bytes = messages.emplace_back();
    bytes.reserve(list.size() * stride * sizeof(double));
    for (const Index i : list) put_values(bytes, std::span<const double>(own.at(i), stride));
  }
  const std::vector<Bytes> received = graph_->exchange(std::move(messages));
  if (motion_.vertex_count() != count_ || motion_.control_points() != own.control_points())
    motion_ = Motion(count_, own.control_points());
  const auto set = [&](Index i, const double* p) {
    for (int c = 0; c < own.control_points(); ++c) motion_.set(i, c, Eigen::Map<const Vec3>(p + 3 * c));
  };
  for (std::size_t k = 0; k < kept_.size(); ++k) set(kept_[k], own.at(kept_own_[k]));
  bytes_received_ = 0;
  std::vector<double> points;
  for (std::size_t s = 0; s < received.size(); ++s) {
    points = values_of<double>(received[s]);
    assert(points.size() == received_[s].size() * stride);
    for (std::size_t k = 0; k < received_[s].size(); ++k) set(received_[s][k], points.data() + k * stride);
    bytes_received_ += received[s].size();
  }
  return motion_;
}

}  // namespace volccd::distributed::detail
